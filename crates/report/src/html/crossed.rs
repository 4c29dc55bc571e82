//! Tables with one row per quantity and one column per method; each cell is a value with a line
//! beneath.

use super::Html;

/// A table of values with notes beneath each.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Crossed {
    /// What the rows are.
    pub(crate) corner: String,
    /// Names of the columns.
    pub(crate) columns: Vec<String>,
    /// One entry a row.
    pub(crate) rows: Vec<CrossedRow>,
}

/// One row, with as many cells as there are columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct CrossedRow {
    /// Its name.
    pub(crate) name: String,
    /// Its note beneath, or nothing.
    pub(crate) note: String,
    /// Its cells.
    pub(crate) cells: Vec<CrossedCell>,
}

/// One cell.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct CrossedCell {
    /// Its value.
    pub(crate) value: String,
    /// Lines beneath.
    pub(crate) notes: Vec<String>,
    /// Whether it stands out: bold, with a background colour.
    pub(crate) marked: bool,
}

impl Crossed {
    /// The same with rows for columns; a row's note stands beside its name.
    pub(crate) fn transposed(self, corner: &str) -> Self {
        let name = |row: &CrossedRow| [&*row.name, &*row.note].join(" ").trim_end().to_owned();
        let columns = self.rows.iter().map(name).collect();
        let rows = self.columns.iter().enumerate().map(|(place, column)| CrossedRow {
            name: column.clone(),
            note: String::new(),
            cells: self
                .rows
                .iter()
                .map(|row| row.cells.get(place).cloned().unwrap_or_default())
                .collect(),
        });
        Self { corner: corner.to_owned(), columns, rows: rows.collect() }
    }
}

impl Html {
    /// A crossed table. It scrolls sideways where it is wider than the page, and the names of its
    /// rows stay in view.
    pub(crate) fn crossed(&mut self, caption: &str, table: &Crossed) {
        self.begin_table("scroll across", "<table class=\"crossed\">\n", caption);
        self.literal("<th scope=\"col\">").text(&table.corner).literal("</th>");
        for column in &table.columns {
            self.literal("<th scope=\"col\" class=\"number\">").text(column).literal("</th>");
        }
        self.literal("</tr></thead>\n<tbody>\n");
        let mut texts = vec![[std::slice::from_ref(&table.corner), &table.columns].concat()];
        for row in &table.rows {
            let mut text = vec![[&*row.name, &*row.note].join(" ").trim_end().to_owned()];
            self.literal("<tr><th scope=\"row\">").text(&row.name);
            self.beneath(&row.note).literal("</th>");
            for cell in row.cells.iter().take(table.columns.len()) {
                let class = if cell.marked { "number marked" } else { "number" };
                self.literal("<td class=\"").literal(class).literal("\">").text(&cell.value);
                for note in &cell.notes {
                    self.beneath(note);
                }
                self.literal("</td>");
                text.push([std::slice::from_ref(&cell.value), &cell.notes].concat().join(" "));
            }
            self.literal("</tr>\n");
            texts.push(text);
        }
        self.end_table(caption, &texts);
    }

    /// A small line beneath a value. The space before it separates the two where styles are lost.
    fn beneath(&mut self, note: &str) -> &mut Self {
        if !note.is_empty() {
            self.literal(" <span class=\"beneath\">").text(note).literal("</span>");
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_text_and_marks() {
        let cell = |value: &str, marked| CrossedCell {
            value: value.to_owned(),
            notes: vec!["p < 1".to_owned()],
            marked,
        };
        let mut html = Html::default();
        html.crossed(
            "what",
            &Crossed {
                corner: "Outcome".to_owned(),
                columns: vec!["<b>".to_owned(), "plain".to_owned()],
                rows: vec![CrossedRow {
                    name: "TIR".to_owned(),
                    note: String::new(),
                    cells: vec![cell("1", true), cell("2", false), cell("one too many", false)],
                }],
            },
        );
        let text = html.into_string();
        for part in [
            "<th scope=\"col\" class=\"number\">&lt;b&gt;</th>",
            "<th scope=\"row\">TIR</th>",
            "<td class=\"number marked\">1 <span class=\"beneath\">p &lt; 1</span></td>",
            "<td class=\"number\">2 <span",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert!(!text.contains("too many"));
    }

    #[test]
    fn rows_become_columns() {
        let cell = |value: &str| CrossedCell { value: value.to_owned(), ..CrossedCell::default() };
        let row = |name: &str, note: &str, cells: [&str; 2]| CrossedRow {
            name: name.to_owned(),
            note: note.to_owned(),
            cells: cells.map(cell).to_vec(),
        };
        let table = Crossed {
            corner: "Outcome".to_owned(),
            columns: vec!["Records".to_owned(), "Twin".to_owned()],
            rows: vec![row("TIR", "\u{b1}5 %", ["70", "68"]), row("RMSE", "", ["", "31"])],
        };
        let turned = table.transposed("Method");
        assert_eq!((turned.corner.as_str(), turned.columns.len()), ("Method", 2));
        assert_eq!(turned.columns, ["TIR \u{b1}5 %", "RMSE"]);
        assert_eq!(turned.rows[1], row("Twin", "", ["68", "31"]));
    }
}
