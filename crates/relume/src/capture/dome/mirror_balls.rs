//! Mirror balls beside a photograph of the dome, as people lay them beside a surface to find the lamps.
//!
//! The strip with the balls is a matte grey ground. A ball mirrors the lamp, with a faint halo as of a surface that is
//! not quite clean, the dark room above and the ground around it; it casts no shadow.

use crate::capture::balls::MirrorBall;
use crate::direction::Direction;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;

/// The reflectance of the ground, and of the room around the dome.
const GROUND: f64 = 0.25;
const ROOM: f64 = 0.01;
/// The radiance of the lamp, far beyond white, and that of its halo.
const LAMP: f64 = 30.0;
const HALO: f64 = 0.8;
/// The angular radius of the halo in radians.
const HALO_RAD: f64 = 0.06;
/// The least angular radius of the lamp: smaller ones would fall between the samples.
const LEAST_LAMP_RAD: f64 = 0.015;
/// Samples of a pixel along each axis.
const SAMPLES: usize = 4;
/// The side of the square around a ball, in radii.
const PLACE: f64 = 2.4;

/// A strip with mirror balls at the right of a photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct BallStrip {
    size: Size,
    balls: Vec<MirrorBall>,
}

impl BallStrip {
    /// A strip beside photographs of a size, with some balls one below the other; `None` for none, or where the
    /// photographs are too small.
    pub fn new(size: Size, count: usize) -> Option<Self> {
        let radius = (size.height as f64 / (PLACE * count as f64)).min(size.width as f64 / 4.0).floor();
        if count == 0 || radius < 8.0 {
            return None;
        }
        let width = (PLACE * radius).ceil();
        let ball = |k: usize| MirrorBall {
            x: size.width as f64 + 0.5 * width,
            y: size.height as f64 * (k as f64 + 0.5) / count as f64,
            radius,
        };
        let balls = (0..count).map(ball).collect();
        Some(Self { size: Size::new(size.width + width as usize, size.height), balls })
    }

    /// The size of the photographs with the strip.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The outlines of the balls.
    pub fn balls(&self) -> &[MirrorBall] {
        &self.balls
    }

    /// A linear photograph with the strip, under a distant lamp.
    ///
    /// # Panics
    /// When the photograph does not have the size of the strip.
    #[must_use]
    pub fn beside(&self, photograph: &Picture, light: Direction, lamp_rad: f64) -> Picture {
        let part = photograph.size();
        assert!(part.height == self.size.height && part.width < self.size.width, "made for another size");
        let mut planes = Planes::zeros(self.size, photograph.planes.count());
        for y in 0..self.size.height {
            for x in part.width..self.size.width {
                let value = self.pixel(x, y, light, lamp_rad.max(LEAST_LAMP_RAD)) as f32;
                (0..planes.count()).for_each(|c| planes.plane_mut(c)[self.size.index(x, y)] = value);
            }
            for c in 0..planes.count() {
                let row = &photograph.planes.plane(c)[part.index(0, y)..][..part.width];
                planes.plane_mut(c)[self.size.index(0, y)..][..part.width].copy_from_slice(row);
            }
        }
        Picture { planes, space: photograph.space }
    }

    fn pixel(&self, x: usize, y: usize, light: Direction, lamp_rad: f64) -> f64 {
        let offset = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
        let samples = (0..SAMPLES * SAMPLES).map(|k| {
            self.seen(x as f64 + offset(k % SAMPLES), y as f64 + offset(k / SAMPLES), light, lamp_rad)
        });
        samples.sum::<f64>() / (SAMPLES * SAMPLES) as f64
    }

    /// The radiance at a place of the photograph.
    fn seen(&self, x: f64, y: f64, light: Direction, lamp_rad: f64) -> f64 {
        let inside = |ball: &&MirrorBall| (x - ball.x).hypot(y - ball.y) < ball.radius;
        let Some(ball) = self.balls.iter().find(inside) else { return GROUND * light.z() };
        let (nx, ny) = ((x - ball.x) / ball.radius, (ball.y - y) / ball.radius);
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let (dx, dy, dz) = (2.0 * nz * nx, 2.0 * nz * ny, 2.0 * nz * nz - 1.0);
        let off = (dx * light.x() + dy * light.y() + dz * light.z()).clamp(-1.0, 1.0).acos();
        let lamp = if off < lamp_rad { LAMP } else { 0.0 };
        let around = if dz < 0.0 { 0.5 * GROUND * light.z() } else { ROOM };
        lamp + HALO * (-(off / HALO_RAD).powi(2)).exp() + around
    }
}
