//! Lamps at places instead of in directions: the direction and the strength of their light differ from texel to texel.
//!
//! A small lamp at P lights the point X of the surface from the direction (P - X) / |P - X| with a strength that falls
//! off as 1 / |P - X|^2. Strengths are relative to those in the middle of the surface, which is flat and at z = 0 here.

use crate::direction::Direction;
use crate::error::{Error, Result};

/// The places of lamps above a surface, and the scale of its texels.
#[derive(Debug, Clone, PartialEq)]
pub struct LampPositions {
    /// In millimetres from the middle of the whole photograph; x right, y up, z from the surface.
    positions: Vec<[f64; 3]>,
    mm_per_texel: f64,
    /// The upper left corner of the texels in millimetres.
    corner: [f64; 2],
}

/// The least distance of a lamp from the surface, as a part of the surface's width.
const LEAST_HEIGHT: f64 = 0.02;

impl LampPositions {
    /// Lamps above photographs of `width` x `height` pixels that show a surface `surface_mm` wide.
    ///
    /// # Errors
    /// A surface without a size, and lamps in it, below it, or without a place.
    pub fn new(positions: Vec<[f64; 3]>, (width, height): (usize, usize), surface_mm: f64) -> Result<Self> {
        if !(surface_mm > 0.0 && surface_mm.is_finite()) {
            return Err(Error::usage(format!(
                "the surface is {surface_mm} mm wide: expected a number above 0"
            )));
        }
        let least = LEAST_HEIGHT * surface_mm;
        let is_above = |p: &[f64; 3]| p.iter().all(|v| v.is_finite()) && p[2] > least;
        if let Some(i) = positions.iter().position(|p| !is_above(p)) {
            let [x, y, z] = positions[i];
            return Err(Error::usage(format!(
                "lamp {} is at ({x}, {y}, {z}) mm: expected a place more than {least:.1} mm above the surface of \
                 {surface_mm} mm; are these directions instead of positions?",
                i + 1
            )));
        }
        let mm_per_texel = surface_mm / width as f64;
        let corner = [-0.5 * surface_mm, 0.5 * height as f64 * mm_per_texel];
        Ok(Self { positions, mm_per_texel, corner })
    }

    /// The same lamps over a part of the photographs that begins at (x, y), with squares of `reduction` pixels as texels.
    #[must_use]
    pub fn over_part(&self, (x, y): (usize, usize), reduction: usize) -> Self {
        let [left, top] = self.corner;
        Self {
            positions: self.positions.clone(),
            mm_per_texel: self.mm_per_texel * reduction as f64,
            corner: [left + x as f64 * self.mm_per_texel, top - y as f64 * self.mm_per_texel],
        }
    }

    /// The number of lamps.
    pub fn count(&self) -> usize {
        self.positions.len()
    }

    /// The size of a texel in millimetres.
    pub fn mm_per_texel(&self) -> f64 {
        self.mm_per_texel
    }

    /// The direction of lamp `lamp` from the middle of the whole photograph.
    pub fn direction(&self, lamp: usize) -> Direction {
        let [x, y, z] = self.positions[lamp];
        Direction::new(x, y, z).expect("lamps are above the surface")
    }

    /// The direction of a lamp from texel (x, y).
    pub fn direction_at(&self, lamp: usize, x: usize, y: usize) -> Direction {
        let [x, y, z] = self.at(lamp, x, y).0;
        Direction::new(x, y, z).expect("lamps are above the surface")
    }

    /// The unit vector from texel (x, y) to a lamp, and how much of its strength in the middle of the surface arrives
    /// there.
    pub fn at(&self, lamp: usize, x: usize, y: usize) -> ([f64; 3], f64) {
        let position = self.positions[lamp];
        let place =
            |corner: f64, sign: f64, texel: usize| corner + sign * (texel as f64 + 0.5) * self.mm_per_texel;
        let to = [
            position[0] - place(self.corner[0], 1.0, x),
            position[1] - place(self.corner[1], -1.0, y),
            position[2],
        ];
        let squared = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>();
        let length = squared(to).sqrt();
        (to.map(|c| c / length), squared(position) / squared(to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_comes_from_the_lamp_and_falls_off_with_the_square_of_its_distance() {
        let lamps = LampPositions::new(vec![[30.0, 40.0, 120.0]], (200, 100), 400.0).unwrap();
        assert_eq!((lamps.mm_per_texel(), lamps.count()), (2.0, 1));
        // The texel whose middle is at (31, 41) mm.
        let (direction, share) = lamps.at(0, 115, 29);
        assert!((direction[0] + 1.0 / 120.0).abs() < 1e-4 && direction[2] > 0.999, "{direction:?}");
        assert!((share - 130.0f64.powi(2) / (120.0f64.powi(2) + 2.0)).abs() < 1e-12);
        let part = lamps.over_part((110, 20), 5);
        let (of_part, _) = part.at(0, 1, 1);
        let (whole, _) = lamps.at(0, 117, 27);
        assert!(of_part.iter().zip(whole).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn lamps_in_the_surface_and_surfaces_without_size_are_refused() {
        let text = LampPositions::new(vec![[0.1, 0.2, 0.97]], (10, 10), 100.0).unwrap_err().to_string();
        assert!(text.contains("lamp 1") && text.contains("directions instead"), "{text}");
        assert!(LampPositions::new(vec![], (10, 10), 0.0).is_err());
    }
}
