//! Slopes of a height field z: p = dz/dx and q = dz/dy, x right and y up, in texels per texel.

use crate::error::{Error, Result};
use crate::planes::Planes;
use crate::size::Size;

/// A bound for measured slopes: normals less than about three degrees above the horizon say little about the
/// steepness of the surface.
pub const STEEPEST: f64 = 20.0;

/// The slopes of every texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Slopes {
    size: Size,
    /// dz/dx, row after row from the top.
    pub p: Vec<f64>,
    /// dz/dy, y up.
    pub q: Vec<f64>,
}

impl Slopes {
    /// A level surface.
    pub fn level(size: Size) -> Self {
        Self { size, p: vec![0.0; size.texels()], q: vec![0.0; size.texels()] }
    }

    /// The slopes of three planes of normals (x right, y up, z out) of any length; slopes beyond `steepest`
    /// are reduced to it, with their azimuth unchanged.
    ///
    /// # Errors
    /// When `steepest` is not above 0, there are not three planes, or a normal is not finite.
    pub fn from_normals(normals: &Planes, steepest: f64) -> Result<Self> {
        if !(steepest > 0.0 && steepest.is_finite()) {
            return Err(Error::usage(format!("the steepest slope is {steepest}: expected a number above 0")));
        }
        if normals.count() != 3 {
            return Err(Error::invalid(format!("normals have three planes, found {}", normals.count())));
        }
        let mut slopes = Self::level(normals.size());
        for texel in 0..normals.size().texels() {
            let [x, y, z] = [0, 1, 2].map(|k| f64::from(normals.plane(k)[texel]));
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                let (column, row) = (texel % slopes.size.width, texel / slopes.size.width);
                return Err(Error::invalid(format!(
                    "the normal at column {column}, row {row} is ({x}, {y}, {z}): expected finite numbers"
                )));
            }
            let down = z.max(x.hypot(y) / steepest).max(1e-12);
            (slopes.p[texel], slopes.q[texel]) = (-x / down, -y / down);
        }
        Ok(slopes)
    }

    /// Three planes of unit normals.
    pub fn normals(&self) -> Planes {
        let mut normals = Planes::zeros(self.size, 3);
        for (texel, (p, q)) in self.p.iter().zip(&self.q).enumerate() {
            let length = (1.0 + p * p + q * q).sqrt();
            let normal = [-p / length, -q / length, 1.0 / length];
            (0..3).for_each(|k| normals.plane_mut(k)[texel] = normal[k] as f32);
        }
        normals
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The slopes of the surface mirrored at its right and lower border, twice as wide and high: any surface
    /// is then periodic. Slopes across a mirror change their sign.
    pub fn mirrored(&self) -> Self {
        let Size { width, height } = self.size;
        let mut mirrored = Self::level(Size::new(2 * width, 2 * height));
        for y in 0..2 * height {
            let (row, sign_q) = if y < height { (y, 1.0) } else { (2 * height - 1 - y, -1.0) };
            for x in 0..2 * width {
                let (column, sign_p) = if x < width { (x, 1.0) } else { (2 * width - 1 - x, -1.0) };
                let (from, to) = (self.size.index(column, row), mirrored.size.index(x, y));
                mirrored.p[to] = sign_p * self.p[from];
                mirrored.q[to] = sign_q * self.q[from];
            }
        }
        mirrored
    }

    /// The upper left part of the given size.
    ///
    /// # Panics
    /// When it is larger than the whole.
    pub(super) fn cropped(&self, size: Size) -> Self {
        let part = |all: &[f64]| -> Vec<f64> {
            let rows = all.chunks_exact(self.size.width).take(size.height);
            rows.flat_map(|row| row[..size.width].iter().copied()).collect()
        };
        Self { size, p: part(&self.p), q: part(&self.q) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_and_slopes_lead_to_each_other() {
        let mut slopes = Slopes::level(Size::new(3, 2));
        slopes.p = vec![0.0, 0.5, -2.0, 3.0, -0.1, 0.0];
        slopes.q = vec![0.0, -0.25, 1.0, -4.0, 7.0, 0.3];
        let back = Slopes::from_normals(&slopes.normals(), STEEPEST).unwrap();
        for (a, b) in slopes.p.iter().chain(&slopes.q).zip(back.p.iter().chain(&back.q)) {
            assert!((a - b).abs() < 1e-5 * (1.0 + a.abs()));
        }
        let flat = Planes::from_vec(Size::new(1, 1), 3, vec![0.6, -0.8, -0.1]).unwrap();
        let steep = Slopes::from_normals(&flat, STEEPEST).unwrap();
        assert!((steep.p[0] + 12.0).abs() < 1e-5 && (steep.q[0] - 16.0).abs() < 1e-5);
        let nan = Planes::from_vec(Size::new(1, 1), 3, vec![f32::NAN, 0.0, 1.0]).unwrap();
        assert!(Slopes::from_normals(&flat, 0.0).is_err());
        assert!(Slopes::from_normals(&nan, STEEPEST).is_err());
        assert!(Slopes::from_normals(&Planes::zeros(Size::new(1, 1), 2), STEEPEST).is_err());
    }
}
