//! Times in the five ranges of glucose, as a bar.

use super::Html;
use crate::number::fixed;
use contract::glucose_by_person::GlucoseRanges;

/// Width of the bar in its own units.
const WIDTH: f64 = 400.0;

/// Class, name and share of each range, from low to high.
fn parts(ranges: &GlucoseRanges) -> [(&'static str, &'static str, f64); 5] {
    [
        ("r1", "below 54", ranges.below_54),
        ("r2", "54 to 70", ranges.from_54_to_70),
        ("r3", "70 to 180", ranges.from_70_to_180),
        ("r4", "180 to 250", ranges.from_180_to_250),
        ("r5", "above 250", ranges.above_250),
    ]
}

impl Html {
    /// A bar with its numbers beneath.
    pub(crate) fn ranges(ranges: &GlucoseRanges) -> Self {
        let mut html = Self::ranges_bar(ranges);
        html.literal("<ul class=\"key\">");
        for (class, name, share) in parts(ranges) {
            html.literal("<li><span class=\"patch ").literal(class).literal("\"></span>");
            html.text(&format!("{name} mg/dL: {}\u{a0}%", fixed(share, 1))).literal("</li>");
        }
        html.literal("</ul>\n");
        html
    }

    /// The bar alone; its numbers show under a pointer.
    pub(crate) fn ranges_bar(ranges: &GlucoseRanges) -> Self {
        let mut html = Self::default();
        html.literal("<svg class=\"ranges\" viewBox=\"0 0 400 16\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"");
        let words: Vec<String> = parts(ranges)
            .iter()
            .map(|(_, name, share)| format!("{name} mg/dL {} %", fixed(*share, 1)))
            .collect();
        html.text(&words.join(", ")).literal("\">");
        let mut from = 0.0;
        for (class, name, share) in parts(ranges) {
            let width = WIDTH * share.clamp(0.0, 100.0) / 100.0;
            if width > 0.0 {
                html.literal("<rect class=\"").literal(class).literal("\" x=\"");
                html.text(&format!("{from:.0}")).literal("\" width=\"");
                html.text(&format!("{width:.0}")).literal("\" height=\"16\"><title>");
                html.text(&format!("{name} mg/dL: {} %", fixed(share, 1)))
                    .literal("</title></rect>");
            }
            from += width;
        }
        html.literal("</svg>");
        html
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_side_by_side() {
        let ranges = GlucoseRanges {
            below_54: 1.0,
            from_54_to_70: 4.0,
            from_70_to_180: 70.0,
            from_180_to_250: 25.0,
            above_250: 0.0,
        };
        let bar = Html::ranges_bar(&ranges).into_string();
        assert_eq!(bar.matches("<rect").count(), 4, "an empty range has no part");
        assert!(bar.contains("class=\"r3\" x=\"20\" width=\"280\""), "{bar}");
        assert!(bar.contains("<title>70 to 180 mg/dL: 70.0 %</title>"));
        assert!(Html::ranges(&ranges).into_string().contains("above 250 mg/dL: 0.0\u{a0}%"));
    }
}
