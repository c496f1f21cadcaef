//! A picture of what was found: balls outlined, highlights marked, over the brightest values of all photographs.

use super::BallLights;
use crate::error::Result;
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::LoadRaster;
use crate::size::Size;
use crate::space::Space;

/// Colours of outlines, and of highlights.
const OUTLINE: [f32; 3] = [0.1, 0.9, 0.2];
const MARK: [f32; 3] = [1.0, 0.1, 0.1];

/// The brightest value of each pixel over all photographs, with the balls and the highlights drawn over it.
///
/// # Errors
/// Those of `load`, photographs that differ in size, and the limits of the job.
pub fn drawn(found: &BallLights, load: &LoadRaster, job: &Job) -> Result<Picture> {
    job.check("a picture of the balls", found.size, 12)?;
    let mut planes = Planes::zeros(found.size, 3);
    job.start("drawing the balls", found.frames.len() as u64);
    for i in 0..found.frames.len() {
        let photograph = load(i)?;
        if photograph.size() != found.size {
            continue;
        }
        let values = photograph.to_picture(Space::Srgb).planes;
        for (c, plane) in planes.iter_mut().enumerate() {
            let brighter = values.plane(c.min(values.count() - 1));
            plane.iter_mut().zip(brighter).for_each(|(out, v)| *out = out.max(*v));
        }
        job.advance(1)?;
    }
    let mut pen = Pen { planes, size: found.size };
    for ball in &found.balls {
        pen.circle((ball.x, ball.y), ball.radius);
    }
    for highlight in found.frames.iter().flat_map(|frame| frame.highlights.iter().flatten()) {
        pen.cross((highlight.x, highlight.y));
    }
    Ok(Picture { planes: pen.planes, space: Space::Srgb })
}

/// Draws into planes.
struct Pen {
    planes: Planes,
    size: Size,
}

impl Pen {
    fn dot(&mut self, x: f64, y: f64, color: [f32; 3]) {
        let (x, y) = (x.floor(), y.floor());
        if x >= 0.0 && y >= 0.0 && x < self.size.width as f64 && y < self.size.height as f64 {
            let texel = self.size.index(x as usize, y as usize);
            (0..3).for_each(|c| self.planes.plane_mut(c)[texel] = color[c]);
        }
    }

    /// A line about a three-hundredth of the radius wide, at least one pixel.
    fn circle(&mut self, (x, y): (f64, f64), radius: f64) {
        let steps = (std::f64::consts::TAU * (radius + 2.0) * 2.0).ceil() as usize;
        let width = (radius / 150.0).ceil().max(1.0) as usize;
        for step in 0..steps {
            let (sin, cos) = (std::f64::consts::TAU * step as f64 / steps as f64).sin_cos();
            for line in 0..width {
                let r = radius + line as f64;
                self.dot(x + r * cos, y + r * sin, OUTLINE);
            }
        }
    }

    fn cross(&mut self, (x, y): (f64, f64)) {
        for step in -4..=4 {
            self.dot(x + f64::from(step), y, MARK);
            self.dot(x, y + f64::from(step), MARK);
        }
    }
}
