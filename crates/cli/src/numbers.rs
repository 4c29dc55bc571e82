//! Numbers as values of options: negative ones are values, and what cannot be is refused in words.

use std::any::TypeId;
use std::str::FromStr;

use clap::Arg;

/// The option with the parser of its number, if it takes one.
pub(crate) fn read_in_words(option: Arg) -> Arg {
    if !option.get_action().takes_values() {
        return option;
    }
    let of = option.get_value_parser().type_id();
    let option = option.allow_negative_numbers(true);
    if of == TypeId::of::<usize>() {
        option.value_parser(whole::<usize>)
    } else if of == TypeId::of::<u64>() {
        option.value_parser(whole::<u64>)
    } else if of == TypeId::of::<f64>() {
        option.value_parser(number)
    } else {
        option
    }
}

fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| {
        let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        match digits {
            true => format!("a whole number of at most {} is needed", u64::MAX),
            false => "a whole number of 0 or more is needed".to_owned(),
        }
    })
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "a number is needed, with a point before its decimals".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_refused_in_words() {
        assert_eq!(whole::<usize>("12"), Ok(12));
        assert_eq!(whole::<u64>("18446744073709551615"), Ok(u64::MAX));
        for text in ["-5", "", "0.5", "lucky", "0x1"] {
            let error = whole::<usize>(text).expect_err("no whole number");
            assert_eq!(error, "a whole number of 0 or more is needed", "{text}");
        }
        let error = whole::<u64>("99999999999999999999").expect_err("too large");
        assert!(error.contains("at most 18446744073709551615"), "{error}");
        assert_eq!(number("-0.5"), Ok(-0.5));
        assert!(number("0,5").is_err());
    }
}
