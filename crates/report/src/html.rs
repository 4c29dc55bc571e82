//! Building HTML so that nothing from data reaches the page unescaped.
//!
//! [`Html`] can be made only from literals of this crate ([`Html::literal`]), from escaped text,
//! and from other [`Html`]. A string from a JSON file has no other way in.

mod crossed;
mod csv;
mod heat;
mod ranges;

pub(crate) use crossed::{Crossed, CrossedCell, CrossedRow};
pub(crate) use heat::{Heat, HeatCell, HeatWidth};

use crate::figure::{Drawn, Key, Stroke};
use crate::number::percent;

/// A piece of a page.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Html(String);

/// A cell with longer text is long, bytes.
const LONG: usize = 24;
/// A table with so many columns has smaller letters.
const DENSE: usize = 8;
/// A cell with text up to this length is not broken, bytes.
const SHORT: usize = 12;

/// Alignment of a table column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    /// Words, left-aligned.
    Text,
    /// Numbers, right-aligned.
    Number,
}

/// A column of a list of items: its name, its alignment, and what its cell says of an item.
pub(crate) type ColumnOf<'a, T> = (&'a str, Column, &'a dyn Fn(&T) -> String);

impl Html {
    /// Markup that is written in this crate.
    pub(crate) fn literal(&mut self, markup: &'static str) -> &mut Self {
        self.0.push_str(markup);
        self
    }

    /// Text from anywhere, escaped.
    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        escape_into(&mut self.0, text);
        self
    }

    /// An element that holds text.
    pub(crate) fn element(&mut self, tag: &'static str, text: &str) -> &mut Self {
        self.literal("<").literal(tag).literal(">").text(text);
        self.literal("</").literal(tag).literal(">\n")
    }

    /// A paragraph.
    pub(crate) fn paragraph(&mut self, text: &str) -> &mut Self {
        self.element("p", text)
    }

    /// A paragraph of a class of the style sheet.
    pub(crate) fn paragraph_of(&mut self, class: &'static str, text: &str) -> &mut Self {
        self.literal("<p class=\"").literal(class).literal("\">").text(text).literal("</p>\n")
    }

    /// A paragraph that says that something is missing.
    pub(crate) fn absent(&mut self, text: &str) -> &mut Self {
        self.paragraph_of("absent", text)
    }

    /// A list, which begins with the tag `open`; nothing without an item.
    pub(crate) fn list(&mut self, open: &'static str, items: &[String]) {
        if items.is_empty() {
            return;
        }
        self.literal(open).literal("\n");
        for item in items {
            self.element("li", item);
        }
        self.literal("</ul>\n");
    }

    /// Another piece.
    pub(crate) fn push(&mut self, other: &Self) -> &mut Self {
        self.0.push_str(&other.0);
        self
    }

    /// A section with its heading; `id` is also the target of the contents list.
    pub(crate) fn section(id: &'static str, heading: &'static str, body: &Self) -> Self {
        let mut html = Self::default();
        html.literal("<section id=\"").literal(id).literal("\">\n");
        html.element("h2", heading).push(body).literal("</section>\n");
        html
    }

    /// A figure with the key to its lines and a caption that says what it shows; returns whether
    /// there is one.
    pub(crate) fn figure(&mut self, drawn: Option<Drawn>, caption: &str) -> bool {
        let Some((svg, keys)) = drawn else {
            return false;
        };
        self.literal("<figure>\n");
        self.0.push_str(svg.markup());
        if !keys.is_empty() {
            self.literal("<ul class=\"key\">");
            for key in &keys {
                self.literal("<li>").0.push_str(&swatch(key));
                self.text(&key.label).literal("</li>");
            }
            self.literal("</ul>\n");
        }
        self.literal("<figcaption>").text(caption).literal("</figcaption>\n</figure>\n");
        true
    }

    /// A table with one row an item, as [`Html::table`]; nothing without an item.
    pub(crate) fn rows<T>(
        &mut self,
        caption: &str,
        items: &[T],
        bold: impl Fn(&T) -> bool,
        columns: &[ColumnOf<'_, T>],
    ) {
        if items.is_empty() {
            return;
        }
        let cells = |item: &T| columns.iter().map(|(_, _, cell)| cell(item)).collect();
        let rows: Vec<(bool, Vec<String>)> =
            items.iter().map(|item| (bold(item), cells(item))).collect();
        let columns: Vec<(&str, Column)> =
            columns.iter().map(|(name, column, _)| (*name, *column)).collect();
        self.table(caption, &columns, &rows);
    }

    /// A table that scrolls sideways where it is wider than the page. Rows marked `true` are bold.
    pub(crate) fn table(
        &mut self,
        caption: &str,
        columns: &[(&str, Column)],
        rows: &[(bool, Vec<String>)],
    ) -> &mut Self {
        let cells = |row: &Vec<String>| row.iter().map(|cell| Self::of_text(cell)).collect();
        let rows: Vec<(bool, Vec<Self>)> =
            rows.iter().map(|(bold, row)| (*bold, cells(row))).collect();
        self.table_of(caption, columns, &rows)
    }

    /// As [`Html::table`], with cells that may hold more than text.
    pub(crate) fn table_of(
        &mut self,
        caption: &str,
        columns: &[(&str, Column)],
        rows: &[(bool, Vec<Self>)],
    ) -> &mut Self {
        let dense = columns.len() >= DENSE;
        let table = if dense { "<table class=\"dense\">\n" } else { "<table>\n" };
        self.scroll("scroll", caption).literal(table);
        // The span stays in view while the table scrolls sideways under it.
        self.literal("<caption><span>").text(caption).literal("</span></caption>\n<thead><tr>");
        for (name, column) in columns {
            self.literal(match column {
                Column::Text => "<th scope=\"col\">",
                Column::Number => "<th scope=\"col\" class=\"number\">",
            });
            self.text(name).literal("</th>");
        }
        self.literal("</tr></thead>\n<tbody>\n");
        for (bold, cells) in rows {
            self.literal(if *bold { "<tr class=\"bold\">" } else { "<tr>" });
            for (cell, (_, column)) in cells.iter().zip(columns) {
                self.literal(match column {
                    Column::Text if cell.is_long_text() => "<td class=\"wide\">",
                    Column::Text if cell.0.len() <= SHORT => "<td class=\"short\">",
                    Column::Text => "<td>",
                    Column::Number => "<td class=\"number\">",
                });
                self.push(cell).literal("</td>");
            }
            self.literal("</tr>\n");
        }
        self.literal("</tbody>\n</table>\n</div>\n");
        let head = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
        let body = rows.iter().map(|(_, cells)| cells.iter().map(Self::plain_text).collect());
        self.download(caption, &std::iter::once(head).chain(body).collect::<Vec<_>>())
    }

    /// A box around a table that scrolls sideways, which a keyboard can reach.
    fn scroll(&mut self, class: &'static str, caption: &str) -> &mut Self {
        self.literal("<div class=\"")
            .literal(class)
            .literal("\" tabindex=\"0\" role=\"group\" aria-label=\"");
        self.text(caption).literal("\">\n")
    }

    /// Whether it is text that needs a wider column on a phone.
    fn is_long_text(&self) -> bool {
        self.0.len() > LONG && !self.0.contains('<')
    }

    /// Text alone.
    pub(crate) fn of_text(text: &str) -> Self {
        let mut html = Self::default();
        html.text(text);
        html
    }

    /// A probability or share as a bar with its number.
    pub(crate) fn bar(share: f64) -> Self {
        let mut html = Self::default();
        let length = (100.0 * share.clamp(0.0, 1.0)).round() as u32;
        html.literal(
            "<span class=\"bar\"><svg viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" ",
        );
        html.literal("aria-hidden=\"true\"><rect class=\"trough\" width=\"100\" height=\"10\"/>");
        html.literal("<rect width=\"")
            .text(&length.to_string())
            .literal("\" height=\"10\"/></svg>");
        html.text(&percent(share)).literal("</span>");
        html
    }

    /// Something that opens when its summary is clicked.
    pub(crate) fn folded(&mut self, summary: &str, body: &Self) -> &mut Self {
        self.literal("<details>\n").element("summary", summary);
        self.push(body).literal("</details>\n")
    }

    /// The finished text.
    pub(crate) fn into_string(self) -> String {
        self.0
    }
}

/// Appends `text` with the five special characters of HTML escaped.
pub(crate) fn escape_into(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            other => out.push(other),
        }
    }
}

/// A short piece of a line, a patch or a marker, as the figure draws it. It holds numbers and
/// colours only.
fn swatch(key: &Key) -> String {
    let Stroke { colour, dash, .. } = key.stroke;
    let colour = format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2);
    let shape = if key.filled {
        let opacity = key.opacity;
        format!(
            "<rect x=\"2\" y=\"1\" width=\"40\" height=\"12\" fill=\"{colour}\" opacity=\"{opacity}\"/>"
        )
    } else {
        let pattern = match dash {
            None => String::new(),
            Some((on, off)) => format!(" stroke-dasharray=\"{} {}\"", on / 2, off / 2),
        };
        format!("<path d=\"M2 7H42\" stroke=\"{colour}\" stroke-width=\"3\"{pattern}/>")
    };
    let marker = key.marker.map_or("", |marker| marker.swatch());
    let marker = marker.replace("COLOUR", &colour);
    format!(
        "<svg width=\"44\" height=\"14\" viewBox=\"0 0 44 14\" aria-hidden=\"true\">{shape}{marker}</svg>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let mut html = Html::default();
        html.element("p", "<script>alert('x')</script> & \"y\"");
        assert_eq!(
            html.into_string(),
            "<p>&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &quot;y&quot;</p>\n"
        );
    }

    #[test]
    fn a_table_has_a_caption_and_headers() {
        let mut html = Html::default();
        let rows = [(true, vec!["a<b".to_owned(), "1".to_owned()])];
        html.table("What", &[("Name", Column::Text), ("n", Column::Number)], &rows);
        let text = html.into_string();
        for part in [
            "<caption><span>What</span></caption>",
            "<th scope=\"col\">Name</th>",
            "<td class=\"number\">1</td>",
            "<tr class=\"bold\"><td class=\"short\">a&lt;b</td>",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
