//! Tables whose cells are shaded by their value: a heat map that can be read aloud and copied.

use super::Html;
use crate::number::fixed;

/// A table of shaded cells.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Heat {
    /// What the rows are.
    pub(crate) corner: String,
    /// Names of the columns.
    pub(crate) columns: Vec<String>,
    /// Name and cells of each row.
    pub(crate) rows: Vec<(String, Vec<HeatCell>)>,
    /// Whether the columns are so narrow that eight of short numbers fit a phone.
    pub(crate) narrow: bool,
}

/// One shaded cell.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct HeatCell {
    /// What it says.
    pub(crate) text: String,
    /// From −1 to 1: the farther from 0 the darker, in a different colour on each side.
    pub(crate) shade: f64,
    /// Whether it has a frame.
    pub(crate) framed: bool,
    /// What shows under a pointer, or nothing.
    pub(crate) hover: String,
}

/// Longest name of a column that is written horizontally, characters.
const LEVEL: usize = 10;
/// Classes of the shades on the positive side, from none.
const POSITIVE: [&str; 6] = ["", " p1", " p2", " p3", " p4", " p5"];
/// Classes of the shades on the negative side, from none.
const NEGATIVE: [&str; 6] = ["", " m1", " m2", " m3", " m4", " m5"];

impl Html {
    /// A heat map, with vertical column names where one is long. It scrolls sideways where it is
    /// wider than the page.
    pub(crate) fn heat(&mut self, caption: &str, heat: &Heat) {
        let tag = if heat.narrow {
            "<table class=\"heat narrow\">\n"
        } else {
            "<table class=\"heat\">\n"
        };
        self.begin_table("scroll", tag, caption);
        self.literal("<th scope=\"col\">").text(&heat.corner).literal("</th>");
        let upright = heat.columns.iter().any(|column| column.chars().count() > LEVEL);
        let class = if upright { "upright" } else { "level" };
        for column in &heat.columns {
            self.literal("<th scope=\"col\" class=\"").literal(class).literal("\"><span>");
            self.text(column).literal("</span></th>");
        }
        self.literal("</tr></thead>\n<tbody>\n");
        let mut texts = vec![[std::slice::from_ref(&heat.corner), &heat.columns].concat()];
        for (name, cells) in &heat.rows {
            let mut row = vec![name.clone()];
            self.literal("<tr><th scope=\"row\">").text(name).literal("</th>");
            for cell in cells.iter().take(heat.columns.len()) {
                let frame = if cell.framed { "framed" } else { "" };
                self.literal("<td class=\"").literal(frame).literal(shade(cell.shade));
                if !cell.hover.is_empty() {
                    self.literal("\" title=\"").text(&cell.hover);
                }
                self.literal("\">").text(&cell.text).literal("</td>");
                row.push(cell.text.clone());
            }
            self.literal("</tr>\n");
            texts.push(row);
        }
        self.end_table(caption, &texts);
    }

    /// The scale of a heat map from `-end` to `end`: each shade with the value at its far edge.
    pub(crate) fn shades(&mut self, end: f64) {
        self.literal("<p class=\"shades\"><span class=\"unseen\">Scale, mg/dL: </span>");
        for step in -5..=5_i32 {
            let share = f64::from(step) / 5.0;
            let sign = if step > 0 { "+" } else { "" };
            self.literal("<span class=\"").literal(shade(share).trim_start()).literal("\">");
            self.text(&format!("{sign}{}", fixed(share * end, 0))).literal("</span> ");
        }
        self.literal("</p>\n");
    }
}

fn shade(value: f64) -> &'static str {
    if !value.is_finite() {
        return "";
    }
    // Every value but 0 has a shade.
    let step = (5.0 * value.abs().min(1.0)).ceil() as usize;
    if value < 0.0 { NEGATIVE[step] } else { POSITIVE[step] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_follow_size_and_side() {
        for (value, class) in [
            (0.0, ""),
            (f64::NAN, ""),
            (0.01, " p1"),
            (0.2, " p1"),
            (0.5, " p3"),
            (7.0, " p5"),
            (-0.9, " m5"),
        ] {
            assert_eq!(shade(value), class, "{value}");
        }
    }

    #[test]
    fn the_scale_says_the_far_edge_of_every_shade() {
        let mut html = Html::default();
        html.shades(20.0);
        let text = html.into_string();
        assert!(text.contains("<span class=\"m5\">\u{2212}20</span>"), "{text}");
        assert!(
            text.contains("<span class=\"\">0</span>")
                && text.contains("<span class=\"p1\">+4</span>")
        );
    }

    #[test]
    fn names_are_escaped_and_rows_fit_the_columns() {
        let cell = |text: &str| HeatCell {
            text: text.to_owned(),
            shade: 1.0,
            framed: true,
            hover: "one \"&\" all".to_owned(),
        };
        let mut html = Html::default();
        html.heat(
            "what",
            &Heat {
                corner: "truth".to_owned(),
                columns: vec!["<b>".to_owned()],
                rows: vec![("&".to_owned(), vec![cell("1"), cell("one too many")])],
                ..Heat::default()
            },
        );
        let text = html.into_string();
        assert!(text.contains("<span>&lt;b&gt;</span>") && text.contains(">&amp;</th>"), "{text}");
        assert!(
            text.contains("<td class=\"framed p5\" title=\"one &quot;&amp;&quot; all\">1</td>")
                && !text.contains("too many")
        );
    }
}
