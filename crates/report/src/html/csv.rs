//! A table as a file to download: CSV inside a `data:` address, so that the page needs no network.

use super::Html;

/// Rows below which a table has no download.
const LEAST: usize = 3;
/// Longest name of a file, characters.
const NAME: usize = 48;

impl Html {
    /// A link that saves a table as CSV; `rows` begin with the names of the columns.
    pub(super) fn download(&mut self, caption: &str, rows: &[Vec<String>]) -> &mut Self {
        if rows.len() <= LEAST {
            return self;
        }
        self.literal("<p class=\"download\"><a download=\"").text(&file_name(caption));
        self.literal(".csv\" href=\"data:text/csv;charset=utf-8,");
        self.text(&encoded(&csv(rows)));
        self.literal("\">Download as CSV<span class=\"unseen\">: ").text(caption);
        self.literal("</span></a></p>\n")
    }

    /// The text of a piece without its markup; titles that follow each other are parted.
    pub(super) fn plain_text(&self) -> String {
        let mut text = String::new();
        let mut titled = false;
        for (index, part) in self.0.split('<').enumerate() {
            if part.starts_with("title>") {
                text.push_str(if titled { "; " } else { "" });
                titled = true;
            }
            let after = match index {
                0 => part,
                _ => part.split_once('>').map_or("", |(_, after)| after),
            };
            text.push_str(after);
        }
        // The ampersand last, so that no entity is made.
        for (entity, letter) in
            [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")]
        {
            text = text.replace(entity, letter);
        }
        text
    }
}

/// Letters and digits of the caption's beginning, with dashes between words.
fn file_name(caption: &str) -> String {
    let start = caption.split([':', ';', ',']).next().unwrap_or_default();
    let words: Vec<String> = start
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    let name: String = words.join("-").chars().take(NAME).collect();
    if name.is_empty() { "table".to_owned() } else { name }
}

/// Rows as RFC 4180 has them, with line feeds.
fn csv(rows: &[Vec<String>]) -> String {
    let cell = |cell: &String| {
        // Programs read a hyphen as the sign of a number, and no other.
        let cell = cell.replace('\u{2212}', "-").replace('\u{a0}', " ").replace('\u{200b}', "");
        if cell.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell
        }
    };
    rows.iter().map(|row| row.iter().map(cell).collect::<Vec<_>>().join(",") + "\n").collect()
}

/// Percent-encoded UTF-8.
fn encoded(text: &str) -> String {
    let mut out = String::with_capacity(text.len() * 3 / 2);
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b',' | b':' => {
                out.push(byte as char);
            }
            other => out.push_str(&format!("%{other:02X}")),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_can_be_saved_with_commas_quotes_and_letters_of_any_language() {
        let row = |cells: [&str; 2]| cells.map(str::to_owned).to_vec();
        let rows = [
            row(["Name", "n, %"]),
            row(["a \"b\"", "1"]),
            row(["é", "<2"]),
            row(["x", "\u{2212}3"]),
        ];
        let mut html = Html::default();
        html.download("Errors by person: mg/dL", &rows);
        let text = html.into_string();
        assert!(text.contains("download=\"errors-by-person.csv\""), "{text}");
        assert!(
            text.contains("utf-8,Name,%22n%2C%20%25%22%0A".replace("%2C", ",").as_str()),
            "{text}"
        );
        assert!(text.contains("%22a%20%22%22b%22%22%22,1%0A%C3%A9,%3C2%0Ax,-3%0A"), "{text}");
        let mut html = Html::default();
        html.download("Two rows", &rows[..3]);
        assert_eq!(html.into_string(), "");
    }

    #[test]
    fn markup_and_entities_leave_text() {
        let mut html = Html::bar(0.5);
        html.text(" a<b & &lt;");
        assert_eq!(html.plain_text(), "50\u{a0}% a<b & &lt;");
    }

    #[test]
    fn titles_that_follow_each_other_are_parted() {
        let mut html = Html::default();
        html.literal("<svg><rect><title>").text("low: 1 %").literal("</title></rect>");
        html.literal("<rect><title>").text("high: 2 %").literal("</title></rect></svg>");
        assert_eq!(html.plain_text(), "low: 1 %; high: 2 %");
    }
}
