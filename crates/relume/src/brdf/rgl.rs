//! BRDFs of the database of the Realistic Graphics Lab at EPFL (J. Dupuy, W. Jakob, "An Adaptive Parameterization for
//! Efficient Material Acquisition and Rendering", ACM Transactions on Graphics 37(6), 2018): tables over the half
//! vector in a parameterisation by the distribution of visible normals.
//!
//! The rule of the authors' implementation: for the incident direction i and the half vector m,
//! value = table(inverse warp of m) D(m) / (4 sigma(i)), where D is the table of the distribution of normals and sigma
//! that of projected areas, m in the coordinates u = sqrt(2 polar / pi) and v = (azimuth + pi) / (2 pi). Between
//! tabulated incident directions, tables and warps are interpolated linearly; outside, those at the edge hold. The
//! azimuth of m counts from that of i if the material is isotropic. That value contains the cosine of the outgoing
//! direction.
//!
//! As in the renderers of the authors, the *view* is the incident direction of the tables; the value is divided by
//! the cosine of the light. A real material is reciprocal, a measurement only nearly so.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::angles;
use super::tables::{ONE_SLICE, SliceWeights, TableShape, WarpTables, bilinear};
use crate::direction::Directions;
use crate::error::{Error, Result};

/// The tables of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct RglTables {
    /// Azimuths of the tabulated incident directions in radians, ascending.
    pub azimuths: Vec<f32>,
    /// Their polar angles in radians, ascending.
    pub polars: Vec<f32>,
    /// The distribution of normals, and its shape of one slice.
    pub distribution: (TableShape, Vec<f32>),
    /// The projected areas of the surface for incident directions, and their shape of one slice.
    pub areas: (TableShape, Vec<f32>),
    /// Warps to visible normals, a slice for each azimuth and polar angle, the latter faster.
    pub visible: WarpTables,
    /// Linear red, green and blue, with slices as the warps.
    pub colors: (TableShape, [Vec<f32>; 3]),
    /// Whether the tables of colours are to be multiplied by the distribution over the projected area.
    pub scaled: bool,
}

/// A BRDF over adaptive coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct RglBrdf {
    tables: RglTables,
    /// Parts of the circle that are alike: 1, 2 or 4.
    symmetry: usize,
}

impl RglBrdf {
    /// A BRDF of checked tables.
    ///
    /// # Errors
    /// Angles that do not ascend, tables that do not fit together, azimuths over a part of the circle other than a
    /// half or a quarter.
    pub fn new(tables: RglTables) -> Result<Self> {
        for (name, values) in [("phi_i", &tables.azimuths), ("theta_i", &tables.polars)] {
            let ascend = values.windows(2).all(|pair| pair[0] < pair[1]);
            if values.is_empty() || !ascend || values.iter().any(|angle| !angle.is_finite()) {
                return Err(Error::invalid(format!(
                    "the angles '{name}' of the BRDF do not ascend: the file is damaged"
                )));
            }
        }
        tables.distribution.0.check("ndf", &tables.distribution.1)?;
        tables.areas.0.check("sigma", &tables.areas.1)?;
        let slices = tables.azimuths.len() * tables.polars.len();
        let shape = tables.colors.0;
        tables.colors.1.iter().try_for_each(|table| shape.check("colours", table))?;
        let found =
            [shape.slices, tables.visible.slices(), tables.distribution.0.slices, tables.areas.0.slices];
        if found != [slices, slices, 1, 1] {
            return Err(Error::invalid(format!(
                "the tables of the BRDF have {found:?} slices: expected {slices}, {slices}, 1 and 1"
            )));
        }
        let symmetry = symmetry(&tables.azimuths)?;
        Ok(Self { tables, symmetry })
    }

    /// Whether the BRDF does not change when light and view turn about the normal.
    pub fn is_isotropic(&self) -> bool {
        self.tables.azimuths.len() <= 2
    }

    /// The value for directions above the surface.
    pub(super) fn evaluate(&self, Directions { light, view }: Directions) -> [f64; 3] {
        let (incident, outgoing) = (view.to_array(), light.to_array());
        let [incident, outgoing] = [incident, outgoing].map(|d| self.folded(d, incident));
        let half = std::array::from_fn(|k| incident[k] + outgoing[k]);
        let ((polar, azimuth), (half_polar, half_azimuth)) = (angles(incident), angles(half));
        let turned = if self.is_isotropic() { half_azimuth - azimuth } else { half_azimuth };
        let at_half = [square_polar(half_polar), square_azimuth(turned).rem_euclid(1.0)];
        let slices = self.slices(azimuth, polar);
        let sample = self.tables.visible.invert(&slices, at_half);
        let (shape, colors) = &self.tables.colors;
        let scale = if self.tables.scaled { self.scale(at_half, polar, azimuth) } else { 1.0 };
        std::array::from_fn(|c| scale / outgoing[2] * bilinear(&colors[c], *shape, &slices, sample))
    }

    /// The distribution over four times the projected area.
    fn scale(&self, at_half: [f64; 2], polar: f64, azimuth: f64) -> f64 {
        let at = |(shape, table): &(TableShape, Vec<f32>), point| bilinear(table, *shape, &ONE_SLICE, point);
        let area = at(&self.tables.areas, [square_polar(polar), square_azimuth(azimuth)]);
        if area > 0.0 { at(&self.tables.distribution, at_half) / (4.0 * area) } else { 0.0 }
    }

    /// A direction turned or mirrored with the incident direction into the tabulated part of the circle, which ends
    /// below the x axis: half turns for two parts, mirrors for four.
    fn folded(&self, [x, y, z]: [f64; 3], [by_x, by_y, _]: [f64; 3]) -> [f64; 3] {
        let away = |value: f64, by: f64| if by.is_sign_negative() { value } else { -value };
        match self.symmetry {
            1 => [x, y, z],
            2 => [away(x, by_y), away(y, by_y), z],
            _ => [away(x, by_x), away(y, by_y), z],
        }
    }

    /// The four tabulated incident directions around one, with their weights.
    fn slices(&self, azimuth: f64, polar: f64) -> SliceWeights {
        let [(a, ahead), (p, outward)] =
            [bracket(&self.tables.azimuths, azimuth), bracket(&self.tables.polars, polar)];
        let (polars, next) =
            (self.tables.polars.len(), |values: &[f32], i: usize| (i + 1).min(values.len() - 1));
        let (b, q) = (next(&self.tables.azimuths, a), next(&self.tables.polars, p));
        [
            (a * polars + p, (1.0 - ahead) * (1.0 - outward)),
            (a * polars + q, (1.0 - ahead) * outward),
            (b * polars + p, ahead * (1.0 - outward)),
            (b * polars + q, ahead * outward),
        ]
    }
}

/// The number of parts of the circle of which one is tabulated.
fn symmetry(azimuths: &[f32]) -> Result<usize> {
    if azimuths.len() <= 2 {
        return Ok(1);
    }
    let span = f64::from(azimuths[azimuths.len() - 1] - azimuths[0]);
    match (TAU / span).round() {
        1.0 => Ok(1),
        2.0 => Ok(2),
        4.0 => Ok(4),
        _ => Err(Error::unsupported(format!(
            "the azimuths of the BRDF span {:.1} degrees: expected the circle, a half or a quarter of it",
            span.to_degrees()
        ))),
    }
}

/// The number of the value at or before `at`, and the share of the next; the ends hold.
fn bracket(values: &[f32], at: f64) -> (usize, f64) {
    if values.len() < 2 {
        return (0, 0.0);
    }
    let i = values.partition_point(|&value| f64::from(value) <= at).saturating_sub(1).min(values.len() - 2);
    let (a, b) = (f64::from(values[i]), f64::from(values[i + 1]));
    (i, ((at - a) / (b - a)).clamp(0.0, 1.0))
}

/// The coordinate of a polar angle in the unit square.
fn square_polar(polar: f64) -> f64 {
    (polar / FRAC_PI_2).sqrt()
}

/// The coordinate of an azimuth, from 0 at -pi to 1 at pi.
fn square_azimuth(azimuth: f64) -> f64 {
    (azimuth + PI) / TAU
}
