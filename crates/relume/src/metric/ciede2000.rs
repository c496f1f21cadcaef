//! Colour difference as seen: CIEDE2000 (ISO/CIE 11664-6:2014), in the form of Sharma, Wu, Dalal, "The CIEDE2000
//! Color-Difference Formula: Implementation Notes, Supplementary Test Data, and Mathematical Observations", Color
//! Research and Application 30, 2005. All weights are 1.

use std::f64::consts::TAU;

/// The difference of two colours in CIE L*, a*, b*; about 1 is just visible.
pub fn ciede2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    let mean_chroma = 0.5 * (a[1].hypot(a[2]) + b[1].hypot(b[2]));
    let g = 0.5 * (1.0 - chroma_weight(mean_chroma));
    let [(chroma_a, hue_a), (chroma_b, hue_b)] = [a, b].map(|[_, a, b]| {
        let a = a * (1.0 + g);
        (a.hypot(b), if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).rem_euclid(TAU) })
    });
    let is_grey = chroma_a * chroma_b == 0.0;
    let turn = match hue_b - hue_a {
        _ if is_grey => 0.0,
        d if d > 0.5 * TAU => d - TAU,
        d if d < -0.5 * TAU => d + TAU,
        d => d,
    };
    let mean_hue = match hue_a + hue_b {
        sum if is_grey => sum,
        sum if (hue_a - hue_b).abs() <= 0.5 * TAU => 0.5 * sum,
        sum if sum < TAU => 0.5 * (sum + TAU),
        sum => 0.5 * (sum - TAU),
    };
    let (lightness, chroma) = (0.5 * (a[0] + b[0]), 0.5 * (chroma_a + chroma_b));
    let hue_difference = 2.0 * (chroma_a * chroma_b).sqrt() * (0.5 * turn).sin();
    let offset = (lightness - 50.0).powi(2);
    let dl = (b[0] - a[0]) / (1.0 + 0.015 * offset / (20.0 + offset).sqrt());
    let dc = (chroma_b - chroma_a) / (1.0 + 0.045 * chroma);
    let dh = hue_difference / (1.0 + 0.015 * chroma * hue_weight(mean_hue));
    (dl * dl + dc * dc + dh * dh + rotation(mean_hue, chroma) * dc * dh).max(0.0).sqrt()
}

/// sqrt(C^7 / (C^7 + 25^7)).
fn chroma_weight(chroma: f64) -> f64 {
    let seventh = chroma.powi(7);
    (seventh / (seventh + 25f64.powi(7))).sqrt()
}

fn hue_weight(hue: f64) -> f64 {
    let degrees = |d: f64| d.to_radians();
    1.0 - 0.17 * (hue - degrees(30.0)).cos()
        + 0.24 * (2.0 * hue).cos()
        + 0.32 * (3.0 * hue + degrees(6.0)).cos()
        - 0.20 * (4.0 * hue - degrees(63.0)).cos()
}

/// The interaction of chroma and hue of blue colours.
fn rotation(hue: f64, chroma: f64) -> f64 {
    let around_blue = ((hue.to_degrees() - 275.0) / 25.0).powi(2);
    -2.0 * chroma_weight(chroma) * (60.0 * (-around_blue).exp()).to_radians().sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of the supplementary data of Sharma, Wu, Dalal (2005), table 1, with their differences.
    #[test]
    fn published_pairs_have_their_published_differences() {
        let pairs = [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
            ([50.0, -0.001, 2.49], [50.0, 0.0011, -2.49], 4.7461),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
            ([90.8027, -2.0831, 1.4410], [91.1528, -1.6435, 0.0447], 1.4441),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ];
        for (a, b, expected) in pairs {
            assert!((ciede2000(a, b) - expected).abs() < 1e-4, "{a:?} {b:?}: {}", ciede2000(a, b));
            assert!((ciede2000(b, a) - ciede2000(a, b)).abs() < 1e-9);
        }
    }
}
