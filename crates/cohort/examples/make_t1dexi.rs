//! `cargo run -p cohort --example make_t1dexi -- PEOPLE DAYS FOLDER`: a made-up study of any
//! size in the layout of T1DEXI, with steps every ten seconds, to measure what an import takes.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use Cell::{Number, Text};

/// 2020-01-01, seconds from 1960.
const START: i64 = 1_893_456_000;
const DAY: i64 = 86_400;

/// A column: a text of so many bytes, or a number.
#[derive(Clone, Copy)]
enum Kind {
    Text(usize),
    Number,
}

impl Kind {
    const fn length(self) -> usize {
        match self {
            Self::Text(length) => length,
            Self::Number => 8,
        }
    }
}

/// A cell.
#[derive(Clone, Copy)]
enum Cell<'a> {
    Text(&'a str),
    Number(f64),
}

/// A SAS transport file of version 5 that is being written.
struct Xpt {
    file: BufWriter<File>,
    kinds: Vec<Kind>,
    bytes: usize,
}

fn padded(text: &str, length: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(length, b' ');
    bytes
}

/// A double as IBM hexadecimal floating point: sign, exponent of 16 over 64, fraction of 56 bits.
fn ibm(value: f64) -> [u8; 8] {
    if value == 0.0 {
        return [0; 8];
    }
    let (mut fraction, mut exponent) = (value.abs(), 64_i32);
    while fraction >= 1.0 {
        fraction /= 16.0;
        exponent += 1;
    }
    while fraction < 1.0 / 16.0 {
        fraction *= 16.0;
        exponent -= 1;
    }
    let mut bytes = ((fraction * 2_f64.powi(56)) as u64).to_be_bytes();
    bytes[0] = exponent as u8 | if value < 0.0 { 0x80 } else { 0 };
    bytes
}

impl Xpt {
    fn begin(folder: &Path, domain: &str, columns: &[(&str, Kind)]) -> io::Result<Self> {
        let path = folder.join(format!("{domain}.xpt"));
        let mut file = BufWriter::with_capacity(1 << 20, File::create(path)?);
        let date = "01JAN20:00:00:00";
        let header = |kind: &str, digits: &str| {
            padded(&format!("HEADER RECORD*******{kind:<8}HEADER RECORD!!!!!!!{digits:<30}"), 80)
        };
        let zeros = "0".repeat(30);
        let system = format!("{:<8}{:<8}{:<24}{date}", "9.4", "Linux", "");
        file.write_all(&header("LIBRARY", &zeros))?;
        file.write_all(&padded(&format!("{:<8}{:<8}{:<8}{system}", "SAS", "SAS", "SASLIB"), 80))?;
        file.write_all(&padded(date, 80))?;
        file.write_all(&header("MEMBER", "000000000000000001600000000140"))?;
        file.write_all(&header("DSCRPTR", &zeros))?;
        file.write_all(&padded(&format!("{:<8}{domain:<8}{:<8}{system}", "SAS", "SASDATA"), 80))?;
        file.write_all(&padded(date, 80))?;
        file.write_all(&header("NAMESTR", &format!("{:06}{:04}{:020}", 0, columns.len(), 0)))?;
        let (mut described, mut place) = (Vec::new(), 0);
        for (number, (name, kind)) in columns.iter().enumerate() {
            let of_type = match kind {
                Kind::Number => 1_i16,
                Kind::Text(_) => 2,
            };
            let numbers = [of_type, 0, kind.length() as i16, number as i16 + 1];
            described.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
            described.extend(padded(name, 8));
            described.extend(padded(name, 40));
            described.extend(padded("", 8));
            described.extend([0; 8]);
            described.extend(padded("", 8));
            described.extend([0; 4]);
            described.extend((place as i32).to_be_bytes());
            described.extend([0; 52]);
            place += kind.length();
        }
        described.resize(described.len().next_multiple_of(80), b' ');
        file.write_all(&described)?;
        file.write_all(&header("OBS", &zeros))?;
        Ok(Self { file, kinds: columns.iter().map(|column| column.1).collect(), bytes: 0 })
    }

    fn row(&mut self, cells: &[Cell<'_>]) -> io::Result<()> {
        for (kind, cell) in self.kinds.iter().zip(cells) {
            match (kind, cell) {
                (Kind::Text(length), Text(text)) => {
                    self.file.write_all(text.as_bytes())?;
                    for _ in text.len()..*length {
                        self.file.write_all(b" ")?;
                    }
                }
                (Kind::Number, Number(value)) => self.file.write_all(&ibm(*value))?,
                _ => return Err(io::Error::other("a cell of another kind than its column")),
            }
            self.bytes += kind.length();
        }
        Ok(())
    }

    fn end(mut self) -> io::Result<()> {
        let rest = self.bytes.next_multiple_of(80) - self.bytes;
        self.file.write_all(&vec![b' '; rest])?;
        self.file.flush()
    }
}

fn main() -> io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [people, days, folder] = arguments.as_slice() else {
        return Err(io::Error::other("usage: make_t1dexi PEOPLE DAYS FOLDER"));
    };
    let number = |text: &str| text.parse().map_err(io::Error::other);
    let (people, days): (i64, i64) = (number(people)?, number(days)?);
    let folder = PathBuf::from(folder);
    std::fs::create_dir_all(&folder)?;
    let names: Vec<String> = (1..=people).map(|number| format!("{number:04}")).collect();
    glucose(&folder, &names, days)?;
    insulin(&folder, &names, days)?;
    meals(&folder, &names, days)?;
    heart_rate(&folder, &names, days)?;
    steps(&folder, &names, days)
}

/// The cell of a time in seconds from the start.
fn time(at: i64) -> Cell<'static> {
    Number((START + at) as f64)
}

fn glucose(folder: &Path, names: &[String], days: i64) -> io::Result<()> {
    let columns = [
        ("USUBJID", Kind::Text(8)),
        ("LBTESTCD", Kind::Text(8)),
        ("LBCAT", Kind::Text(4)),
        ("LBDTC", Kind::Number),
        ("LBSTRESN", Kind::Number),
        ("LBSTRESU", Kind::Text(8)),
    ];
    let mut file = Xpt::begin(folder, "LB", &columns)?;
    for (offset, name) in names.iter().enumerate() {
        for at in (0..days * DAY).step_by(300) {
            let hour = at as f64 / 3600.0 + offset as f64;
            let glucose = (150.0 + 60.0 * (hour / 4.0).sin() + 20.0 * (hour * 1.7).cos()).round();
            file.row(&[
                Text(name),
                Text("GLUC"),
                Text("CGM"),
                time(at),
                Number(glucose),
                Text("mg/dL"),
            ])?;
        }
    }
    file.end()
}

fn insulin(folder: &Path, names: &[String], days: i64) -> io::Result<()> {
    let columns = [
        ("USUBJID", Kind::Text(8)),
        ("FATEST", Kind::Text(16)),
        ("FADTC", Kind::Number),
        ("FAORRES", Kind::Number),
        ("FADUR", Kind::Text(8)),
    ];
    let mut file = Xpt::begin(folder, "FACM", &columns)?;
    for name in names {
        for at in (0..days * DAY).step_by(300) {
            let mut row = |test, amount, lasts| {
                file.row(&[Text(name), Text(test), time(at), Number(amount), Text(lasts)])
            };
            row("BASAL FLOW RATE", 0.9, "PT5M")?;
            row("BASAL INSULIN", 0.075, "PT5M")?;
            if at % (6 * 3600) == 3600 * 2 {
                row("BOLUS INSULIN", 4.5, "")?;
            }
        }
    }
    file.end()
}

fn meals(folder: &Path, names: &[String], days: i64) -> io::Result<()> {
    let columns = [
        ("USUBJID", Kind::Text(8)),
        ("FATESTCD", Kind::Text(8)),
        ("FACAT", Kind::Text(8)),
        ("FADTC", Kind::Number),
        ("FASTRESN", Kind::Number),
    ];
    let mut file = Xpt::begin(folder, "FAMLPM", &columns)?;
    for name in names {
        for at in (2 * 3600..days * DAY).step_by(6 * 3600) {
            file.row(&[Text(name), Text("DCARBT"), Text("CONSUMED"), time(at), Number(45.0)])?;
        }
    }
    file.end()
}

fn heart_rate(folder: &Path, names: &[String], days: i64) -> io::Result<()> {
    let columns = [
        ("USUBJID", Kind::Text(8)),
        ("VSTEST", Kind::Text(10)),
        ("VSDTC", Kind::Number),
        ("VSSTRESN", Kind::Number),
        ("VSSTRESU", Kind::Text(10)),
    ];
    let mut file = Xpt::begin(folder, "VS", &columns)?;
    for name in names {
        for at in (0..days * DAY).step_by(60) {
            let rate = 70.0 + (at / 600 % 9) as f64;
            file.row(&[Text(name), Text("Heart Rate"), time(at), Number(rate), Text("beats/min")])?;
        }
    }
    file.end()
}

fn steps(folder: &Path, names: &[String], days: i64) -> io::Result<()> {
    let columns = [
        ("USUBJID", Kind::Text(8)),
        ("FAOBJ", Kind::Text(30)),
        ("FADTC", Kind::Number),
        ("FASTRESN", Kind::Number),
    ];
    let mut file = Xpt::begin(folder, "FA", &columns)?;
    for name in names {
        for at in (0..days * DAY).step_by(10) {
            let count = if at / 900 % 5 == 2 { 12.0 } else { 0.0 };
            let object = Text("10-SECOND INTERVAL STEP COUNT");
            file.row(&[Text(name), object, time(at), Number(count)])?;
        }
    }
    file.end()
}
