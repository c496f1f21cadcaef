//! What one viewer sees, whatever the light: for each texel of the reference plane a point of the surface.
//!
//! The reference plane lies at the mean height. An image is rectified to it, as the images of measured bidirectional
//! texture functions are: pixel (x, y) shows what lies on the line of sight through texel (x, y) of that plane, so
//! heights appear as parallax, and parts of the surface hide others. The properties of a point between texels are
//! interpolated.

use super::Dome;
use super::illumination::{Illumination, LEAST_DIRECTION_Z};
use super::parallax::SightLines;
use super::reflect::ReflectingPoint;
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory::Footprint;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;
/// What one viewer sees of the surface under a dome.
#[derive(Debug, Clone)]
pub struct Sight {
    view: Direction,
    seen: Vec<SeenPoint>,
}

/// A point of the surface between four texels.
#[derive(Debug, Clone, Copy)]
struct SeenPoint {
    place: BetweenTexels,
    surface: ReflectingPoint,
}

/// A place between texels.
#[derive(Debug, Clone, Copy)]
struct BetweenTexels {
    /// The texels around it: upper left, upper right, lower left, lower right.
    texels: [u32; 4],
    /// The weights of the right and of the lower ones.
    right: f32,
    lower: f32,
}

impl BetweenTexels {
    /// A value between those of the four texels.
    fn between<const N: usize>(&self, values: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        let [a, b, c, d] = self.texels.map(|texel| values(texel as usize));
        std::array::from_fn(|k| {
            let upper = a[k] + (b[k] - a[k]) * self.right;
            upper + (c[k] + (d[k] - c[k]) * self.right - upper) * self.lower
        })
    }
}

impl Sight {
    /// The direction of the viewer.
    pub fn view(&self) -> Direction {
        self.view
    }

    /// The memory of what a viewer sees of maps of `size`.
    pub fn footprint(size: Size) -> Footprint {
        let bytes = size_of::<SeenPoint>() as u64;
        Footprint::of_texels(size, bytes, bytes)
    }
}

impl Dome {
    /// What a distant viewer sees. Its memory is [`Sight::footprint`].
    ///
    /// # Errors
    /// A viewer less than about half a degree above the surface, or below it; a cancelled job.
    pub fn sight(&self, view: Direction, job: &Job) -> Result<Sight> {
        if view.z() < LEAST_DIRECTION_Z {
            return Err(Error::usage(format!(
                "a viewer at ({}, {}, {}) does not see the surface: expected z of at least {LEAST_DIRECTION_Z}",
                view.x(),
                view.y(),
                view.z()
            )));
        }
        let lines = SightLines::new(&self.relief, view, self.level);
        let width = self.size().width;
        let nothing = self.seen_at(0.0, 0.0);
        let mut seen = vec![nothing; self.size().texels()];
        parallel::try_for_each(seen.chunks_mut(width).enumerate(), |(y, row)| -> Result<()> {
            job.proceed()?;
            let mut distances = vec![0.0; width];
            lines.seen(&self.relief, y, &mut distances);
            let heading = lines.heading();
            for (x, (point, distance)) in row.iter_mut().zip(distances).enumerate() {
                let distance = f64::from(distance);
                *point =
                    self.seen_at(x as f64 + distance * heading.column, y as f64 + distance * heading.row);
            }
            Ok(())
        })?;
        Ok(Sight { view, seen })
    }

    /// The image that a viewer has under a lamp: linear RGB, 1 for a white Lambertian facing the lamp, rectified to
    /// the reference plane. From the zenith it is [`Dome::photograph`]. The picture takes 12 bytes per texel.
    ///
    /// # Errors
    /// A cancelled job.
    ///
    /// # Panics
    /// When sight and light are of maps of another size.
    pub fn image(&self, sight: &Sight, lit: &Illumination, job: &Job) -> Result<Picture> {
        let (size, texels) = (self.size(), self.size().texels());
        assert!(sight.seen.len() == texels && lit.texels.len() == texels, "sight and light of other maps");
        let directions = Directions { light: lit.light, view: sight.view };
        let mut planes = Planes::zeros(size, 3);
        let values = planes.as_mut_slice();
        for (y, row) in sight.seen.chunks_exact(size.width).enumerate() {
            job.proceed()?;
            for (x, SeenPoint { place, surface }) in row.iter().enumerate() {
                let [share, indirect @ ..] = place.between(|texel| lit.texels[texel]);
                let lamp = share * surface.cosine(lit.light);
                let color = surface.reflected(self.options.surface, directions, lamp, indirect);
                let texel = size.index(x, y);
                (0..3).for_each(|k| values[k * texels + texel] = color[k]);
            }
        }
        Ok(Picture { planes, space: Space::Linear })
    }

    /// The surface at (x, y), in texels to the right and down.
    fn seen_at(&self, x: f64, y: f64) -> SeenPoint {
        let (column, row) = (x.floor(), y.floor());
        let corner = |i: isize, j: isize| self.relief.texel(column as isize + i, row as isize + j) as u32;
        let place = BetweenTexels {
            texels: [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)],
            right: (x - column) as f32,
            lower: (y - row) as f32,
        };
        let surface = place.between(|texel| {
            let ReflectingPoint { normal: [x, y, z], albedo: [r, g, b], roughness, metallic } =
                self.point(texel);
            [x, y, z, r, g, b, roughness, metallic]
        });
        let [x, y, z, r, g, b, roughness, metallic] = surface;
        let surface = ReflectingPoint { normal: unit([x, y, z]), albedo: [r, g, b], roughness, metallic };
        SeenPoint { place, surface }
    }
}

/// The vector of length 1 between unit vectors, which never cancel in the upper half space. One of them is kept bit for
/// bit.
fn unit(vector: [f32; 3]) -> [f32; 3] {
    let squared = vector.iter().map(|c| c * c).sum::<f32>();
    if (squared - 1.0).abs() < 1e-6 { vector } else { vector.map(|c| c / squared.sqrt()) }
}

#[cfg(test)]
mod tests {
    use super::super::parallax::seen_by_brute_force;
    use super::super::{Bounce, DomeOptions, ReliefBorder, Surface, lights};
    use super::*;
    use crate::maps::SurfaceMaps;
    use crate::microfacet;
    use std::f64::consts::{PI, TAU};

    const SIZE: Size = Size { width: 40, height: 36 };

    /// Bumps of colours, roughnesses and metal that vary.
    fn bumps(rise: f64) -> SurfaceMaps {
        let of = |count: usize, value: &dyn Fn(usize, f64, f64) -> f64| {
            let values = (0..count * SIZE.texels()).map(|i| {
                let (k, texel) = (i / SIZE.texels(), i % SIZE.texels());
                let [x, y] = [texel % SIZE.width, texel / SIZE.width].map(|c| c as f64);
                value(k, x * TAU / SIZE.width as f64, y * TAU / SIZE.height as f64) as f32
            });
            Planes::from_vec(SIZE, count, values.collect()).unwrap()
        };
        SurfaceMaps {
            height: of(1, &|_, x, y| rise * ((2.0 * x).sin() * y.cos() + 0.5 * (3.0 * y + x).sin())),
            albedo: of(3, &|k, x, y| 0.5 + 0.3 * (x + 2.0 * y + k as f64).sin()),
            normal: None,
            roughness: Some(of(1, &|_, x, y| 0.6 + 0.2 * (x - y).cos())),
            metallic: Some(of(1, &|_, x, y| 0.5 + 0.5 * (2.0 * x + y).sin())),
        }
    }

    fn dome(maps: SurfaceMaps, options: DomeOptions) -> Dome {
        Dome::new(maps, &options, &Job::default()).unwrap()
    }

    fn image(dome: &Dome, view: Direction, light: Direction) -> Planes {
        let job = Job::default();
        let (sight, lit) = (dome.sight(view, &job).unwrap(), dome.illumination(light, &job).unwrap());
        dome.image(&sight, &lit, &job).unwrap().planes
    }

    #[test]
    fn from_the_zenith_an_image_is_the_photograph() {
        for surface in [Surface::Matte, DomeOptions::default().surface] {
            let dome = dome(bumps(3.0), DomeOptions { surface, ..Default::default() });
            for light in lights(7) {
                let photographed = dome.photograph(light).unwrap().planes;
                assert_eq!(image(&dome, Direction::ZENITH, light), photographed);
            }
        }
    }

    #[test]
    fn a_plane_is_the_closed_form_under_every_pair() {
        let flat = SurfaceMaps { height: Planes::zeros(SIZE, 1), ..bumps(0.0) };
        let dome = dome(flat.clone(), DomeOptions { ambient: 0.0, ..Default::default() });
        let of = |planes: &Planes, k: usize| f64::from(planes.at(k, 11, 23));
        let job = Job::default();
        let lit: Vec<Illumination> =
            lights(9).into_iter().map(|l| dome.illumination(l, &job).unwrap()).collect();
        for view in lights(8) {
            let sight = dome.sight(view, &job).unwrap();
            for lit in &lit {
                let seen = dome.image(&sight, lit, &job).unwrap().planes;
                let (light, f0) = (lit.light(), microfacet::DIELECTRIC_F0);
                let half = Direction::new(light.x() + view.x(), light.y() + view.y(), light.z() + view.z());
                let half = half.unwrap();
                let alpha = microfacet::alpha(of(flat.roughness.as_ref().unwrap(), 0));
                let gloss =
                    |f0| microfacet::specular(light.z(), view.z(), half.z(), light.dot(half), alpha, f0);
                let metal = of(flat.metallic.as_ref().unwrap(), 0);
                for k in 0..3 {
                    let albedo = of(&flat.albedo, k);
                    let plain = albedo * microfacet::body_share(light.z(), view.z(), f0) + gloss(f0);
                    let truth = light.z() * (plain * (1.0 - metal) + gloss(albedo) * metal);
                    let value = of(&seen, k);
                    assert!(
                        (value - truth).abs() < 1e-5 * (1.0 + truth),
                        "{light:?} {view:?}: {value} {truth}"
                    );
                }
            }
        }
    }

    /// Each texel of the reference plane subtends the same area towards the viewer, so the mean of an image times the
    /// cosine of the viewer is the light from one side to the other, which is the same both ways.
    #[test]
    fn light_and_viewer_may_be_exchanged_over_the_whole_relief() {
        let options = DomeOptions { ambient: 0.0, bounce: Bounce::None, ..Default::default() };
        let matte = DomeOptions { surface: Surface::Matte, lamp_radius_rad: 0.0, ..options };
        let dome = dome(bumps(2.5), matte);
        let sum = |view: Direction, light: Direction| {
            let seen = image(&dome, view, light);
            view.z() * seen.as_slice().iter().copied().map(f64::from).sum::<f64>()
        };
        for (a, b) in [((0.0, 0.0), (0.9, 1.0)), ((0.8, 2.0), (1.1, 2.6)), ((1.0, 3.0), (1.0, 0.2))] {
            let [a, b] = [a, b].map(|(polar, azimuth)| Direction::from_angles(polar, azimuth));
            let (one, other) = (sum(a, b), sum(b, a));
            assert!((one - other).abs() < 0.015 * one, "{a:?} {b:?}: {one} {other}");
        }
    }

    /// The slow truth: lines of sight and of light in small steps, from the point that is seen.
    #[test]
    fn images_agree_with_brute_force() {
        let options = DomeOptions {
            ambient: 0.0,
            bounce: Bounce::None,
            lamp_radius_rad: 0.0,
            border: ReliefBorder::Wrap,
            ..Default::default()
        };
        let dome = dome(bumps(3.0), options);
        for (view, light) in [((0.5, 1.0), (0.9, 4.0)), ((1.1, 3.0), (1.0, 3.5)), ((1.25, 5.5), (0.4, 2.0))] {
            let [view, light] = [view, light].map(|(polar, azimuth)| Direction::from_angles(polar, azimuth));
            let seen = image(&dome, view, light);
            let mut off: Vec<f32> = (0..SIZE.texels())
                .map(|i| {
                    let truth = brute_force(&dome, [i % SIZE.width, i / SIZE.width], view, light);
                    (0..3).map(|k| (seen.plane(k)[i] - truth[k]).abs()).fold(0.0, f32::max)
                })
                .collect();
            off.sort_by(f32::total_cmp);
            // Outlines of shadows and silhouettes differ.
            let [middle, most] = [off.len() / 2, off.len() * 9 / 10].map(|rank| off[rank]);
            let mean = seen.as_slice().iter().sum::<f32>() / seen.as_slice().len() as f32;
            assert!(middle < 0.01 && most < 0.15 * mean, "{view:?} {light:?}: {middle} {most}, mean {mean}");
        }
    }

    fn brute_force(dome: &Dome, [x, y]: [usize; 2], view: Direction, light: Direction) -> [f32; 3] {
        let distance = seen_by_brute_force(&dome.relief, [x, y], view, f64::from(dome.level), 1.0 / 64.0);
        let level = view.x().hypot(view.y());
        let place = [x as f64 + distance * view.x() / level, y as f64 - distance * view.y() / level];
        let height = dome.relief.between(place[0], place[1]);
        let rise = light.z() / light.x().hypot(light.y());
        let is_hidden = (64..64 * 60).any(|k| {
            let d = f64::from(k) / 64.0;
            let at = [
                place[0] + d * light.x() / light.x().hypot(light.y()),
                place[1] - d * light.y() / light.x().hypot(light.y()),
            ];
            dome.relief.between(at[0], at[1]) > height + d * rise
        });
        let point = dome.seen_at(place[0], place[1]).surface;
        let lamp = if is_hidden { 0.0 } else { point.cosine(light) };
        point.reflected(dome.options.surface, Directions { light, view }, lamp, [0.0; 3])
    }

    #[test]
    fn images_are_the_same_at_any_thread_count() {
        let view = Direction::from_angles(1.0, 2.0);
        let light = Direction::from_angles(0.8, 5.0);
        let many = image(&dome(bumps(3.0), DomeOptions::default()), view, light);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(|| image(&dome(bumps(3.0), DomeOptions::default()), view, light)), many);
    }

    #[test]
    fn viewers_below_the_surface_are_refused() {
        let dome = dome(bumps(1.0), DomeOptions::default());
        for polar in [PI / 2.0, 2.0] {
            let refused = dome.sight(Direction::from_angles(polar, 0.0), &Job::default()).unwrap_err();
            assert!(refused.to_string().contains("viewer"), "{refused}");
        }
    }
}
