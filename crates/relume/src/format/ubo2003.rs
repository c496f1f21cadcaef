//! Images of bidirectional texture functions as the University of Bonn published them in 2003: one file for each pair of
//! directions, named by its angles, in a folder for each view.
//!
//! `tv030_pv060/00081 tl015 pl120 tv030 pv060.jpg`: a running number, then the polar (t) and azimuth (p) angles of light
//! (l) and view (v) in degrees, at least three digits before the point. Angles that are not whole have up to four
//! decimals (`tl012.5`), as in later sets of the same names. Numbers run over all lights of the first view, then over
//! those of the next.

use crate::direction::{Direction, Directions};

/// The path of the image of a pair below the folder of its material, with forward slashes.
pub fn image_name(number: usize, directions: Directions, extension: &str) -> String {
    let [tl, pl] = angles(directions.light);
    let [tv, pv] = angles(directions.view);
    format!("tv{tv}_pv{pv}/{number:05} tl{tl} pl{pl} tv{tv} pv{pv}.{extension}")
}

/// The polar angle and the azimuth of a direction as in names.
fn angles(direction: Direction) -> [String; 2] {
    let polar = direction.x().hypot(direction.y()).atan2(direction.z()).to_degrees();
    let azimuth = if polar < 0.5e-4 { 0.0 } else { direction.y().atan2(direction.x()).to_degrees() };
    let azimuth = decimals(azimuth.rem_euclid(360.0));
    // A hair below a full turn is rounded to it.
    [decimals(polar), if azimuth == "360" { "000".to_owned() } else { azimuth }]
}

/// At least three digits, and up to four decimals without trailing zeros.
fn decimals(angle_deg: f64) -> String {
    let text = format!("{angle_deg:08.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(polar: f64, azimuth: f64) -> Direction {
        Direction::from_angles(polar.to_radians(), azimuth.to_radians())
    }

    #[test]
    fn names_are_those_of_the_published_sets() {
        let pair = Directions { light: Direction::ZENITH, view: direction(30.0, 30.0) };
        assert_eq!(image_name(8, pair, "jpg"), "tv030_pv030/00008 tl000 pl000 tv030 pv030.jpg");
        let last = Directions { light: direction(75.0, 330.0), view: direction(75.0, 345.0) };
        assert_eq!(image_name(6559, last, "jpg"), "tv075_pv345/06559 tl075 pl330 tv075 pv345.jpg");
    }

    #[test]
    fn angles_that_are_not_whole_have_decimals() {
        let pair = Directions { light: direction(12.5, 337.5), view: direction(4.07, 0.25) };
        assert_eq!(
            image_name(123_456, pair, "exr"),
            "tv004.07_pv000.25/123456 tl012.5 pl337.5 tv004.07 pv000.25.exr"
        );
    }

    #[test]
    fn every_direction_has_one_name_from_0_up_to_a_full_turn() {
        assert_eq!(angles(direction(10.0, 359.999_99)), ["010", "000"]);
        assert_eq!(angles(direction(10.0, -90.0)), ["010", "270"]);
        assert_eq!(angles(direction(0.0, 200.0)), ["000", "000"]);
        assert_eq!(angles(direction(100.0, 100.0)), ["100", "100"]);
    }
}
