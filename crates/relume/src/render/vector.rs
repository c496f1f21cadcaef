//! Vectors of three in `f64`, for geometry.

use crate::direction::Direction;
use std::ops::{Add, Mul, Neg, Sub};

/// Three components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vec3 {
    /// Right.
    pub x: f64,
    /// Up.
    pub y: f64,
    /// To the viewer.
    pub z: f64,
}

impl Vec3 {
    /// A vector from its components.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// All components equal.
    pub const fn splat(v: f64) -> Self {
        Self::new(v, v, v)
    }

    /// The inner product.
    pub fn dot(self, o: Self) -> f64 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// The cross product.
    pub fn cross(self, o: Self) -> Self {
        Self::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }

    /// The smaller of each component.
    pub fn min(self, o: Self) -> Self {
        Self::new(self.x.min(o.x), self.y.min(o.y), self.z.min(o.z))
    }

    /// The larger of each component.
    pub fn max(self, o: Self) -> Self {
        Self::new(self.x.max(o.x), self.y.max(o.y), self.z.max(o.z))
    }

    /// The unit vector, or `None` where there is no direction.
    pub fn unit(self) -> Option<Self> {
        let size = length(self);
        (size.is_finite() && size > 1e-30).then(|| self * (1.0 / size))
    }

    /// Some unit vector at right angles to this unit vector.
    pub fn any_perpendicular(self) -> Self {
        let axis = if self.x.abs() < 0.7 { Self::new(1.0, 0.0, 0.0) } else { Self::new(0.0, 1.0, 0.0) };
        let rest = axis - self * self.dot(axis);
        rest * (1.0 / length(rest))
    }
}

/// The Euclidean length.
pub fn length(v: Vec3) -> f64 {
    v.dot(v).sqrt()
}

impl From<Direction> for Vec3 {
    fn from(direction: Direction) -> Self {
        let [x, y, z] = direction.to_array();
        Self::new(x, y, z)
    }
}

impl From<[f32; 3]> for Vec3 {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self::new(f64::from(x), f64::from(y), f64::from(z))
    }
}

impl From<Vec3> for [f32; 3] {
    fn from(v: Vec3) -> Self {
        [v.x as f32, v.y as f32, v.z as f32]
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}
