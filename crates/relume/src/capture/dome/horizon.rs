//! What each texel sees apart from the lamp: the open sky, and the surface that hides the rest of it.
//!
//! The sky is divided into equal sectors of azimuth. In each, the horizon of the texel is marched, and the
//! cosine-weighted share of the hemisphere about its normal is integrated in closed form over the polar angle
//! (N. Max, Horizon mapping, 1988; L. Bavoil, M. Sainz, R. Dimitrov, Image-space horizon-based ambient
//! occlusion, SIGGRAPH 2008). Above the horizon lies open sky; between the horizon and the tangent plane of
//! the texel lies surface. That part is represented by one [`Link`] to the texel hit by the ray of its middle
//! slope: a one-point quadrature of the light reflected from there, shared by all lights. The shares of sky
//! and links of a texel sum to at most 1 (to the accuracy of the sectors), so a bounce cannot create light.
//!
//! Limits: one horizon per sector; horizons flatter than 1/32 (a thousandth of the sky) may be missed.

use super::march::{Heading, UNSEEN, crossings, first_at_least, steepest_slopes};
use super::relief::Relief;
use crate::error::Result;
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use std::f64::consts::{PI, TAU};

/// Slopes below this hide less than a thousandth of a sector.
pub(super) const NEGLIGIBLE_SLOPE: f32 = 1.0 / 32.0;

/// A part of the hemisphere that is covered by another texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Cosine-weighted share of the hemisphere, 0 to 1.
    pub share: f32,
    /// The texel seen there.
    pub texel: u32,
}

/// What all texels see in one sector of azimuth.
struct Sector {
    /// Cosine-weighted share of the hemisphere that is open sky, for each texel.
    sky: Vec<f32>,
    links: Vec<Link>,
}

/// What all texels see.
#[derive(Debug, Clone)]
pub struct Surroundings {
    /// Cosine-weighted share of the hemisphere that is open sky, for each texel: 1 on a plane.
    pub sky: Vec<f32>,
    /// For each sector, for each texel, the surface seen there.
    pub links: Vec<Vec<Link>>,
}

/// Bytes per texel of [`Surroundings`] with the given number of sectors, during construction.
pub fn bytes_per_texel(sectors: usize) -> u64 {
    8 * sectors as u64 + 8
}

impl Surroundings {
    /// Marches all horizons of a relief with the given `normals`.
    ///
    /// # Errors
    /// When the job is cancelled.
    pub fn new(relief: &Relief, normals: &Planes, sectors: usize, job: &Job) -> Result<Self> {
        let mut all = Self { sky: vec![0.0; relief.size().texels()], links: Vec::with_capacity(sectors) };
        for k in 0..sectors {
            // Half a step away from the axes of the grid, where errors are largest.
            let azimuth = (k as f64 + 0.5) * TAU / sectors as f64;
            let sector = sector(relief, normals, azimuth, TAU / sectors as f64, job)?;
            all.sky.iter_mut().zip(sector.sky).for_each(|(sum, share)| *sum += share);
            all.links.push(sector.links);
        }
        Ok(all)
    }
}

fn sector(relief: &Relief, normals: &Planes, azimuth_rad: f64, width_rad: f64, job: &Job) -> Result<Sector> {
    let size = relief.size();
    let heading = Heading::from_azimuth(azimuth_rad);
    let reach = relief.reach().min(f64::from(relief.range()) / f64::from(NEGLIGIBLE_SLOPE));
    let path = crossings(heading, reach);
    let mut sky = vec![0.0f32; size.texels()];
    let mut links = vec![Link { share: 0.0, texel: 0 }; size.texels()];
    let rows = sky.chunks_mut(size.width).zip(links.chunks_mut(size.width)).enumerate();
    parallel::try_for_each(rows, |(y, (sky, links))| {
        job.proceed()?;
        let mut horizon = vec![0.0f32; size.width];
        steepest_slopes(relief, &path, y, NEGLIGIBLE_SLOPE, &mut horizon);
        let mut middle = vec![0.0f32; size.width];
        let mut first = vec![UNSEEN; size.width];
        for x in 0..size.width {
            let facet = Facet::new(normals, size.index(x, y), azimuth_rad);
            let shares = facet.shares(f64::from(horizon[x])).map(|s| (s * width_rad / PI) as f32);
            sky[x] = shares[0];
            links[x].share = shares[1];
            middle[x] = 0.5 * (facet.slope() as f32 + horizon[x]);
            if shares[1] <= 0.0 {
                first[x] = 0;
            }
        }
        first_at_least(relief, &path, y, &middle, &mut first);
        for (x, (link, &number)) in links.iter_mut().zip(&first).enumerate() {
            match path.get(number as usize) {
                Some(crossing) => {
                    let [column, row] = crossing.nearest();
                    link.texel = relief.texel(x as isize + column, y as isize + row) as u32;
                }
                None => link.share = 0.0,
            }
        }
        Ok(())
    })?;
    Ok(Sector { sky, links })
}

/// The normal of a texel in the vertical plane of one azimuth: its component along the heading, and up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    along: f64,
    up: f64,
}

impl Facet {
    pub fn new(normals: &Planes, texel: usize, azimuth_rad: f64) -> Self {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(normals.plane(k)[texel]));
        Self { along: x * azimuth_rad.cos() + y * azimuth_rad.sin(), up: z }
    }

    /// The slope of the tangent plane along the heading.
    fn slope(self) -> f64 {
        -self.along / self.up
    }

    /// The cosine integrated over polar angles above the horizon, per radian of azimuth.
    pub fn sky(self, horizon_slope: f64) -> f64 {
        self.integral(horizon_slope.max(self.slope()))
    }

    /// The cosine integrated over polar angles above and below the horizon, per radian of azimuth.
    fn shares(self, horizon_slope: f64) -> [f64; 2] {
        let sky = self.sky(horizon_slope);
        [sky, (self.integral(self.slope()) - sky).max(0.0)]
    }

    /// The integral of (along sin t + up cos t) sin t over polar angles t from the zenith to the
    /// direction of a slope.
    fn integral(self, slope: f64) -> f64 {
        let sine_squared = 1.0 / (1.0 + slope * slope);
        let polar = 1f64.atan2(slope);
        0.5 * (self.along * (polar - slope * sine_squared) + self.up * sine_squared)
    }
}

#[cfg(test)]
mod tests {
    use super::super::relief::ReliefBorder;
    use super::*;
    use crate::size::Size;

    fn surroundings(
        size: Size,
        border: ReliefBorder,
        sectors: usize,
        height: impl Fn(usize, usize) -> f32,
    ) -> Surroundings {
        let values = (0..size.texels()).map(|i| height(i % size.width, i / size.width)).collect();
        let relief = Relief::new(&Planes::from_vec(size, 1, values).unwrap(), border);
        Surroundings::new(&relief, &relief.normals(), sectors, &Job::default()).unwrap()
    }

    #[test]
    fn a_facet_integrates_its_cosine() {
        for (along, up) in [(0.0, 1.0), (0.5, 0.8), (-0.6, 0.75)] {
            let facet = Facet { along, up };
            for slope in [-0.4, 0.0, 0.7, 3.0f64] {
                let polar = 1f64.atan2(slope);
                let cosine = |t: f64| (along * t.sin() + up * t.cos()) * t.sin();
                let steps = 20_000;
                let sum: f64 =
                    (0..steps).map(|k| cosine((f64::from(k) + 0.5) * polar / f64::from(steps))).sum();
                assert!((facet.integral(slope) - sum * polar / f64::from(steps)).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn a_plane_sees_nothing_but_sky_and_a_tilted_facet_its_share_of_it() {
        let flat = surroundings(Size::new(9, 7), ReliefBorder::Wrap, 16, |_, _| 3.0);
        assert!(flat.sky.iter().all(|s| (s - 1.0).abs() < 1e-6));
        assert!(flat.links.iter().flatten().all(|link| link.share == 0.0));
        // A plane tilted by an angle b sees (1 + cos b) / 2 of the sky above level ground; the rest of the
        // tilted relief rises behind it without hiding more.
        let relief = Relief::new(&Planes::zeros(Size::new(1, 1), 1), ReliefBorder::Wrap);
        let mut normals = Planes::zeros(Size::new(1, 1), 3);
        normals.as_mut_slice().copy_from_slice(&[0.6, 0.0, 0.8]);
        let sky = Surroundings::new(&relief, &normals, 64, &Job::default()).unwrap().sky[0];
        assert!((sky - 0.9).abs() < 1e-3, "{sky}");
    }

    /// A point at distance d of an endless wall of height H sees it in (1 - d / sqrt(d^2 + H^2)) / 2.
    #[test]
    fn the_sky_beside_a_wall_is_the_closed_form() {
        let size = Size::new(200, 200);
        for (sectors, tolerance) in [(16, 0.02), (128, 0.003)] {
            let wall =
                surroundings(size, ReliefBorder::Clamp, sectors, |x, _| if x >= 60 { 20.0 } else { 0.0 });
            for distance in [2, 5, 10, 20, 40] {
                let texel = size.index(60 - distance, 100);
                let d = distance as f32;
                let hidden = 0.5 * (1.0 - d / (d * d + 400.0).sqrt());
                let sky = wall.sky[texel];
                assert!(
                    (sky - (1.0 - hidden)).abs() < tolerance,
                    "{sectors} sectors, {distance}: {sky} {hidden}"
                );
                let linked: f32 = wall.links.iter().map(|sector| sector[texel].share).sum();
                assert!(
                    (linked - hidden).abs() < tolerance,
                    "{sectors} sectors, {distance}: {linked} {hidden}"
                );
            }
        }
    }

    /// The bottom of an endless V-groove with walls of slope tan b sees cos b of the sky.
    #[test]
    fn the_sky_in_a_groove_is_the_closed_form() {
        let size = Size::new(81, 300);
        for slope in [0.5f32, 1.0, 2.0] {
            let groove =
                surroundings(size, ReliefBorder::Clamp, 16, |x, _| slope * (x as f32 - 40.0).abs().min(30.0));
            let sky = groove.sky[size.index(40, 150)];
            let truth = 1.0 / (1.0 + slope * slope).sqrt();
            assert!((sky - truth).abs() < 0.01, "slope {slope}: {sky} {truth}");
        }
    }

    #[test]
    fn no_texel_sees_more_than_its_hemisphere() {
        let size = Size::new(40, 33);
        let bumps = |x: usize, y: usize| 4.0 * (x as f32 * 0.47).sin() * (y as f32 * 0.57).cos();
        let all = surroundings(size, ReliefBorder::Wrap, 16, bumps);
        for texel in 0..size.texels() {
            let linked: f32 = all.links.iter().map(|sector| sector[texel].share).sum();
            let sum = all.sky[texel] + linked;
            assert!(sum < 1.002 && sum > 0.85, "texel {texel}: {} + {linked}", all.sky[texel]);
        }
    }
}
