//! Building HTML so that nothing from data reaches the page unescaped.
//!
//! [`Html`] can be made only from literals of this crate ([`Html::literal`]), from escaped text,
//! and from other [`Html`]. A string from a JSON file has no other way in.

mod crossed;
mod csv;
mod heat;
mod ranges;

pub(crate) use crossed::{Crossed, CrossedCell, CrossedRow};
pub(crate) use heat::{Heat, HeatCell};

use crate::figure::{Drawn, Key};
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
pub(crate) type ColumnOf<'a, T, C = String> = (&'a str, Column, &'a dyn Fn(&T) -> C);

impl From<String> for Html {
    /// Text alone.
    fn from(text: String) -> Self {
        let mut html = Self::default();
        html.text(&text);
        html
    }
}

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
    pub(crate) fn paragraph(&mut self, text: &str) {
        self.element("p", text);
    }

    /// A paragraph of a class of the style sheet.
    pub(crate) fn paragraph_of(&mut self, class: &'static str, text: &str) -> &mut Self {
        self.literal("<p class=\"").literal(class).literal("\">").text(text).literal("</p>\n")
    }

    /// A paragraph that says that something is missing.
    pub(crate) fn absent(&mut self, text: &str) {
        self.paragraph_of("absent", text);
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

    /// A figure with the key to its lines and a caption that says what it shows; returns whether
    /// there is one.
    pub(crate) fn figure(&mut self, drawn: Option<Drawn>, caption: &str) -> bool {
        let Some(drawn) = drawn else { return false };
        self.literal("<figure>\n").0.push_str(drawn.markup());
        self.literal("<ul class=\"key\">");
        for key in &drawn.keys {
            self.literal("<li>").0.push_str(&swatch(key));
            self.text(&key.label).literal("</li>");
        }
        self.literal("</ul>\n");
        self.literal("<figcaption>").text(caption).literal("</figcaption>\n</figure>\n");
        true
    }

    /// A table with one row an item, as [`Html::table`]; nothing without an item.
    pub(crate) fn rows<T, C: Into<Self>>(
        &mut self,
        caption: &str,
        items: &[T],
        columns: &[ColumnOf<'_, T, C>],
    ) {
        self.marked_rows(caption, items, |_| false, columns);
    }

    /// As [`Html::rows`], with the rows of some items in bold.
    pub(crate) fn marked_rows<T, C: Into<Self>>(
        &mut self,
        caption: &str,
        items: &[T],
        bold: impl Fn(&T) -> bool,
        columns: &[ColumnOf<'_, T, C>],
    ) {
        if items.is_empty() {
            return;
        }
        let cells = |item: &T| columns.iter().map(|(_, _, cell)| cell(item)).collect();
        let rows: Vec<(bool, Vec<C>)> =
            items.iter().map(|item| (bold(item), cells(item))).collect();
        let columns: Vec<(&str, Column)> =
            columns.iter().map(|(name, column, _)| (*name, *column)).collect();
        self.table(caption, &columns, rows);
    }

    /// A table that scrolls sideways where it is wider than the page. Rows marked `true` are bold.
    pub(crate) fn table<C: Into<Self>>(
        &mut self,
        caption: &str,
        columns: &[(&str, Column)],
        rows: Vec<(bool, Vec<C>)>,
    ) {
        let dense = columns.len() >= DENSE;
        let tag = if dense { "<table class=\"dense\">\n" } else { "<table>\n" };
        self.begin_table("scroll", tag, caption);
        let names = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
        let mut texts: Vec<Vec<String>> = vec![names];
        for (name, column) in columns {
            self.literal(match column {
                Column::Text => "<th scope=\"col\">",
                Column::Number => "<th scope=\"col\" class=\"number\">",
            });
            self.text(name).literal("</th>");
        }
        self.literal("</tr></thead>\n<tbody>\n");
        for (bold, cells) in rows {
            self.literal(if bold { "<tr class=\"bold\">" } else { "<tr>" });
            let cells: Vec<Self> = cells.into_iter().map(Into::into).collect();
            texts.push(cells.iter().map(Self::plain_text).collect());
            for (cell, (_, column)) in cells.iter().zip(columns) {
                self.literal(match column {
                    // Text that needs a wider column on a phone.
                    Column::Text if cell.0.len() > LONG && !cell.0.contains('<') => {
                        "<td class=\"wide\">"
                    }
                    Column::Text if cell.0.len() <= SHORT => "<td class=\"short\">",
                    Column::Text => "<td>",
                    Column::Number => "<td class=\"number\">",
                });
                self.push(cell).literal("</td>");
            }
            self.literal("</tr>\n");
        }
        self.end_table(caption, &texts);
    }

    /// A table up to the names of its columns, in a box of a class that scrolls sideways and that a
    /// keyboard can reach.
    fn begin_table(&mut self, class: &'static str, tag: &'static str, caption: &str) {
        self.literal("<div class=\"").literal(class);
        self.literal("\" tabindex=\"0\" role=\"group\" aria-label=\"").text(caption);
        // The span stays in view while the table scrolls sideways under it.
        self.literal("\">\n").literal(tag).literal("<caption><span>").text(caption);
        self.literal("</span></caption>\n<thead><tr>");
    }

    /// The rest of a table behind its last row; `texts` are its rows without markup, the names of the
    /// columns first.
    fn end_table(&mut self, caption: &str, texts: &[Vec<String>]) {
        self.literal("</tbody>\n</table>\n</div>\n").download(caption, texts);
    }

    /// A probability or share as a bar with its number.
    pub(crate) fn bar(share: f64) -> Self {
        let mut html = Self::default();
        let length = (100.0 * share.clamp(0.0, 1.0)).round() as u32;
        html.literal(
            "<span class=\"bar\"><svg viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" \
             aria-hidden=\"true\"><rect class=\"trough\" width=\"100\" height=\"10\"/><rect width=\"",
        );
        html.text(&length.to_string()).literal("\" height=\"10\"/></svg>");
        html.text(&percent(share)).literal("</span>");
        html
    }

    /// Something that opens when its summary is clicked.
    pub(crate) fn folded(&mut self, summary: &str, body: impl FnOnce(&mut Self)) {
        self.literal("<details>\n").element("summary", summary);
        body(self);
        self.literal("</details>\n");
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
    let colour = key.stroke.colour;
    let colour = format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2);
    let dashes = |(on, off): (i32, i32)| format!(" stroke-dasharray=\"{} {}\"", on / 2, off / 2);
    let pattern = key.stroke.dash.map(dashes).unwrap_or_default();
    let shape = match key.area {
        Some(opacity) => format!(
            "<rect x=\"2\" y=\"1\" width=\"40\" height=\"12\" fill=\"{colour}\" opacity=\"{opacity}\"/>"
        ),
        None => format!("<path d=\"M2 7H42\" stroke=\"{colour}\" stroke-width=\"3\"{pattern}/>"),
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
        let rows = vec![(true, vec!["a<b".to_owned(), "1".to_owned()])];
        html.table("What", &[("Name", Column::Text), ("n", Column::Number)], rows);
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
