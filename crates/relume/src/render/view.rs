//! Projections from world space to the samples of a picture or a shadow map.

use super::scene::Camera;
use super::vector::Vec3;
use crate::size::Size;

/// A viewpoint: an orthonormal frame and its projection. Sample (i, j) has its centre at (i + 1/2, j + 1/2);
/// j counts downwards.
#[derive(Debug, Clone, Copy)]
pub struct View {
    size: Size,
    origin: Vec3,
    right: Vec3,
    up: Vec3,
    /// From the scene towards the viewer.
    back: Vec3,
    /// Samples per unit length: at unit depth (perspective) or at any depth (parallel).
    scale: f64,
    projection: ViewProjection,
}

/// How depth enters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ViewProjection {
    /// Rays through one eye; nothing nearer than `near` is visible.
    Perspective {
        /// In world units.
        near: f64,
    },
    /// Parallel rays.
    Parallel,
}

impl View {
    /// The view of a camera on an object with a bounding sphere.
    pub fn of_camera(camera: &Camera, (center, radius): (Vec3, f64), size: Size) -> Self {
        let [right, up, back] = camera.frame();
        let distance = camera.distance_radii * radius;
        Self {
            size,
            origin: center + back * distance,
            right,
            up,
            back,
            scale: 0.5 * size.height as f64 / (0.5 * camera.field_of_view_rad).tan(),
            projection: ViewProjection::Perspective { near: 1e-3 * distance.min(radius) },
        }
    }

    /// The view from a light at infinity on a square map that just contains the bounding sphere.
    pub fn of_light(towards: Vec3, (center, radius): (Vec3, f64), side: usize) -> Self {
        let right = towards.any_perpendicular();
        Self {
            size: Size::new(side, side),
            origin: center,
            right,
            up: towards.cross(right),
            back: towards,
            // Two samples remain free around it for filtering.
            scale: (0.5 * side as f64 - 2.0).max(0.5) / radius,
            projection: ViewProjection::Parallel,
        }
    }

    /// Samples along both sides.
    pub fn size(&self) -> Size {
        self.size
    }

    /// How depth enters.
    pub fn projection(&self) -> ViewProjection {
        self.projection
    }

    /// World units between two samples (at unit depth for a camera).
    pub fn sample_step(&self) -> f64 {
        1.0 / self.scale
    }

    /// The unit vector from a point towards the viewer.
    pub fn towards_viewer(&self, point: Vec3) -> Vec3 {
        match self.projection {
            ViewProjection::Perspective { .. } => (self.origin - point).unit().unwrap_or(self.back),
            ViewProjection::Parallel => self.back,
        }
    }

    /// Homogeneous sample coordinates (x w, y w, w); w is the depth along the view direction for
    /// a camera, 1 for a light.
    pub fn project(&self, point: Vec3) -> Vec3 {
        let p = point - self.origin;
        let w = match self.projection {
            ViewProjection::Perspective { .. } => -p.dot(self.back),
            ViewProjection::Parallel => 1.0,
        };
        let (half_width, half_height) = (0.5 * self.size.width as f64, 0.5 * self.size.height as f64);
        Vec3::new(
            self.scale * p.dot(self.right) + half_width * w,
            half_height * w - self.scale * p.dot(self.up),
            w,
        )
    }

    /// The coordinate of a point along the direction to the viewer.
    pub fn height(&self, point: Vec3) -> f64 {
        (point - self.origin).dot(self.back)
    }
}
