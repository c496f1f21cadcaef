//! What a report says of a texture that was made to tile: the steps across its borders, measured.

use relume::metric::texture::wrap::Wrap;
use relume::workflow::tiling::MeasuredTiling;

use crate::report::Report;

/// The report with the measured tiling, and a warning where a border shows; `remedy` says what to do then.
pub fn with_tiling(mut report: Report, tiling: Option<&MeasuredTiling>, remedy: &str) -> Report {
    let Some(tiling) = tiling else { return report };
    let [across, down] = tiling.wrap;
    let text = format!(
        "; tiles: steps across the borders are {:.2} (right to left) and {:.2} (bottom to top) times those \
         inside",
        across.ratio, down.ratio
    );
    report.text.push_str(&text);
    report.json["wrap"] = serde_json::json!(tiling);
    let shows = tiling.shows.then(|| format!("{}: {remedy}", in_words(across, down)));
    report.with_warnings(shows)
}

/// The border that shows more.
fn in_words(across: Wrap, down: Wrap) -> String {
    let (which, worse) =
        if across.ratio >= down.ratio { ("left and right", across) } else { ("upper and lower", down) };
    format!(
        "the {which} borders do not meet well: the step across them is {:.1} times those inside and larger than \
         {:.0} % of them",
        worse.ratio,
        100.0 * worse.rank
    )
}
