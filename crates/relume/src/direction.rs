//! Unit directions in the frame of the texture: x right, y up, z towards the viewer.

use crate::error::{Error, Result};

/// A unit vector in the tangent frame of a texture. Light directions point *towards* the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    x: f64,
    y: f64,
    z: f64,
}

impl Direction {
    /// Straight above the texture.
    pub const ZENITH: Self = Self { x: 0.0, y: 0.0, z: 1.0 };

    /// The direction of a vector of any length.
    ///
    /// # Errors
    /// A vector that is not finite or is shorter than 1e-9 or longer than 1e150 has no direction.
    pub fn new(x: f64, y: f64, z: f64) -> Result<Self> {
        let length = (x * x + y * y + z * z).sqrt();
        if !length.is_finite() || length < 1e-9 {
            return Err(Error::invalid(format!(
                "({}, {}, {}) has no direction: expected three finite numbers, the largest from 1e-9 to 1e150",
                Short(x),
                Short(y),
                Short(z)
            )));
        }
        Ok(Self { x: x / length, y: y / length, z: z / length })
    }

    /// The direction of a vector of length 1, whose components are kept bit for bit.
    ///
    /// # Errors
    /// When the length differs from 1 by more than 1e-9.
    pub fn from_unit_vector(x: f64, y: f64, z: f64) -> Result<Self> {
        let length = (x * x + y * y + z * z).sqrt();
        if length.is_nan() || (length - 1.0).abs() > 1e-9 {
            return Err(Error::invalid(format!(
                "({x}, {y}, {z}) is not a direction: expected a vector of length 1"
            )));
        }
        Ok(Self { x, y, z })
    }

    /// The direction at a polar angle from the zenith and an azimuth counted from x towards y.
    pub fn from_angles(polar_rad: f64, azimuth_rad: f64) -> Self {
        let (sin_polar, z) = polar_rad.sin_cos();
        let (sin_azimuth, cos_azimuth) = azimuth_rad.sin_cos();
        Self { x: sin_polar * cos_azimuth, y: sin_polar * sin_azimuth, z }
    }

    /// The direction of the upper hemisphere over the point (u, v) of the unit disk; points outside are
    /// projected to the rim.
    pub fn from_disk(u: f64, v: f64) -> Self {
        let radius = u.hypot(v).max(1.0);
        let (x, y) = (u / radius, v / radius);
        Self { x, y, z: (1.0 - x * x - y * y).max(0.0).sqrt() }
    }

    /// The component to the right; `u` of a polynomial texture map.
    pub fn x(self) -> f64 {
        self.x
    }

    /// The component up; `v` of a polynomial texture map.
    pub fn y(self) -> f64 {
        self.y
    }

    /// The component towards the viewer: the cosine of the angle to the normal of the texture.
    pub fn z(self) -> f64 {
        self.z
    }

    /// The angle from the zenith.
    pub fn polar_rad(self) -> f64 {
        self.z.clamp(-1.0, 1.0).acos()
    }

    /// The azimuth counted from x towards y, from 0 to a turn.
    pub fn azimuth_rad(self) -> f64 {
        self.y.atan2(self.x).rem_euclid(std::f64::consts::TAU)
    }

    /// Directions spread evenly over the upper hemisphere: a Fibonacci lattice, a golden angle from each to the next.
    pub(crate) fn fibonacci(count: usize) -> impl Fn(usize) -> Self {
        let golden_rad = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        move |i| Self::from_angles((1.0 - (i as f64 + 0.5) / count as f64).acos(), golden_rad * i as f64)
    }

    /// The components in order.
    pub fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }

    /// The cosine between two directions.
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
}

/// A number in a message: without hundreds of zeros.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0.abs() {
            usual if usual == 0.0 || (1e-4..1e7).contains(&usual) => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// The directions towards the light and towards the viewer, on which the functions of a texture depend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directions {
    /// Towards the light.
    pub light: Direction,
    /// Towards the viewer.
    pub view: Direction,
}

impl Directions {
    /// Lit from a direction and seen from straight above, as in the photographs for textures without view
    /// dependence.
    pub const fn lit_from(light: Direction) -> Self {
        Self { light, view: Direction::ZENITH }
    }

    /// The components of the light, then those of the view.
    pub fn to_array(self) -> [f64; 6] {
        let ([a, b, c], [d, e, f]) = (self.light.to_array(), self.view.to_array());
        [a, b, c, d, e, f]
    }
}

/// A light alone implies the view from straight above.
impl From<Direction> for Directions {
    fn from(light: Direction) -> Self {
        Self::lit_from(light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_constructor_gives_a_unit_vector() {
        let directions = [
            Direction::new(3.0, -4.0, 12.0).unwrap(),
            Direction::from_angles(0.7, 2.0),
            Direction::from_disk(0.3, -0.2),
            Direction::from_disk(3.0, 4.0),
        ];
        for d in directions {
            assert!((d.dot(d) - 1.0).abs() < 1e-12, "{d:?}");
        }
    }

    #[test]
    fn vectors_without_direction_are_refused() {
        assert!(Direction::new(0.0, 0.0, 0.0).is_err());
        assert!(Direction::new(f64::NAN, 0.0, 1.0).is_err());
        assert!(Direction::new(f64::INFINITY, 0.0, 1.0).is_err());
    }
}
