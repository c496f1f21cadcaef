//! Evidence curves as a picture: for each level the log evidence of the sets examined, by their size.
//!
//! Scalable vector graphics, with numbers on the axes.

use std::fmt::Write;

use super::estimate::LevelReport;

/// The size of the panel of a level in pixels.
const PANEL: [f64; 2] = [300.0, 230.0];

/// The margins around the curve of a panel: left, right, top and bottom.
const MARGINS: [f64; 4] = [66.0, 14.0, 34.0, 40.0];

/// One panel per level, the finest on the left. The line joins the most probable set of each size; circles
/// mark sets more probable than the chosen one but unstable; the disk marks the chosen one.
pub fn svg(reports: &[LevelReport]) -> String {
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" font-family=\"sans-serif\" \
         font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        PANEL[0] * reports.len() as f64,
        PANEL[1]
    );
    for (number, report) in reports.iter().enumerate() {
        panel(&mut text, number, report);
    }
    text + "</svg>\n"
}

fn panel(text: &mut String, number: usize, report: &LevelReport) {
    let curve = best_by_size(&report.path);
    let axes = CurveAxes::of(&curve);
    let _ = writeln!(
        text,
        "<g transform=\"translate({} 0)\">\n<text x=\"{}\" y=\"20\">level {number}: {} x {} texels</text>",
        PANEL[0] * number as f64,
        MARGINS[0],
        report.width,
        report.height
    );
    axes.draw(text);
    let points: Vec<String> =
        curve.iter().map(|&point| axes.place(point)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(text, "<polyline points=\"{}\" fill=\"none\" stroke=\"#26547c\"/>", points.join(" "));
    for (rank, &point) in report.path.iter().take(report.unstable + 1).enumerate() {
        let [x, y] = axes.place(point);
        let fill = if rank == report.unstable { "#c1121f" } else { "none" };
        let _ = writeln!(
            text,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{fill}\" stroke=\"#c1121f\"/>"
        );
    }
    text.push_str("</g>\n");
}

/// The best log evidence of each size, by size.
fn best_by_size(path: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let mut best = path.to_vec();
    best.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    best.dedup_by_key(|point| point.0);
    best
}

/// The ranges of the axes of a panel.
struct CurveAxes {
    most: f64,
    range: [f64; 2],
}

impl CurveAxes {
    /// From no neighbour to the most, and from the evidence of few neighbours to the highest; that of none
    /// lies far below.
    fn of(curve: &[(usize, f64)]) -> Self {
        let most = curve.last().map_or(1, |last| last.0.max(1)) as f64;
        let values = || curve.iter().skip(usize::from(curve.len() > 2)).map(|point| point.1);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        Self { most, range: if high > low { [low, high] } else { [low - 1.0, low + 1.0] } }
    }

    fn place(&self, (size, value): (usize, f64)) -> [f64; 2] {
        let [left, right, top, bottom] = MARGINS;
        let [low, high] = self.range;
        let up = ((value - low) / (high - low)).clamp(0.0, 1.0);
        [
            left + (PANEL[0] - left - right) * size as f64 / self.most,
            PANEL[1] - bottom - (PANEL[1] - top - bottom) * up,
        ]
    }

    fn draw(&self, text: &mut String) {
        let [low, high] = self.range;
        let ([x0, y0], [x1, y1]) = (self.place((0, low)), self.place((self.most as usize, high)));
        let _ = writeln!(text, "<path d=\"M{x0} {y1}V{y0}H{x1}\" fill=\"none\" stroke=\"black\"/>");
        for (value, y) in [(low, y0), (high, y1)] {
            let x = x0 - 5.0;
            let _ = writeln!(text, "<text x=\"{x}\" y=\"{}\" text-anchor=\"end\">{value:.0}</text>", y + 4.0);
        }
        let label = |text: &mut String, x: f64, words: &str| {
            let y = y0 + 16.0;
            let _ = writeln!(text, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{words}</text>");
        };
        label(text, x0, "0");
        label(text, 0.5 * (x0 + x1), "neighbours; up: ln evidence");
        label(text, x1 - 4.0, &format!("{:.0}", self.most));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_a_panel_a_level_and_marks_what_was_taken() {
        let report = |path: Vec<(usize, f64)>, unstable| LevelReport {
            width: 9,
            height: 8,
            path,
            unstable,
            prior: 1.0,
            predicted: 0.5,
            radius: 0.9,
        };
        let text = svg(&[
            report(vec![(3, -10.0), (2, -12.0), (1, -40.0), (0, -900.0)], 1),
            report(vec![(0, -3.0)], 0),
        ]);
        assert_eq!((text.matches("<g ").count(), text.matches("<circle").count()), (2, 3));
        assert_eq!(text.matches("fill=\"#c1121f\"").count(), 2);
        assert!(text.contains(">-40<") && text.contains(">-10<") && !text.contains("NaN"), "{text}");
    }

    #[test]
    fn the_best_of_each_size_counts() {
        assert_eq!(
            best_by_size(&[(2, -1.0), (1, -5.0), (2, -3.0), (0, -9.0)]),
            [(0, -9.0), (1, -5.0), (2, -1.0)]
        );
    }
}
