//! One photograph from straight above: a texel is a pixel.

use super::Dome;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::job::Job;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::space::Space;
impl Dome {
    /// The photograph under a distant lamp: linear RGB, 1 for a white Lambertian facing the lamp.
    ///
    /// # Errors
    /// A lamp less than about half a degree above the surface, or below it.
    pub fn photograph(&self, light: Direction) -> Result<Picture> {
        self.photograph_within(light, &Job::default())
    }

    /// [`Dome::photograph`] as a part of a job; its memory is [`Dome::photograph_footprint`].
    ///
    /// # Errors
    /// As [`Dome::photograph`], and a cancelled job.
    pub fn photograph_within(&self, light: Direction, job: &Job) -> Result<Picture> {
        let lit = self.illumination(light, job)?;
        let directions = Directions::lit_from(light);
        let mut colors = vec![[0.0; 3]; self.size().texels()];
        let width = self.size().width;
        parallel::try_for_each(colors.chunks_mut(width).enumerate(), |(y, row)| {
            job.proceed()?;
            for (texel, color) in (y * width..).zip(row) {
                let [share, indirect @ ..] = lit.texels[texel];
                let point = self.point(texel);
                let lamp = share * point.cosine(light);
                *color = point.reflected(self.options.surface, directions, lamp, indirect);
            }
            Ok(())
        })?;
        let mut planes = Planes::zeros(self.size(), 3);
        for (k, plane) in planes.iter_mut().enumerate() {
            plane.iter_mut().zip(&colors).for_each(|(out, color)| *out = color[k]);
        }
        Ok(Picture { planes, space: Space::Linear })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Bounce, DomeOptions, ReliefBorder, Surface, lights};
    use super::*;
    use crate::limits::Limits;
    use crate::maps::SurfaceMaps;
    use crate::size::Size;

    fn maps(size: Size, height: impl Fn(usize, usize) -> f32, albedo: f32) -> SurfaceMaps {
        let heights = (0..size.texels()).map(|i| height(i % size.width, i / size.width)).collect();
        SurfaceMaps {
            height: Planes::from_vec(size, 1, heights).unwrap(),
            albedo: Planes::from_vec(size, 3, vec![albedo; 3 * size.texels()]).unwrap(),
            normal: None,
            roughness: None,
            metallic: None,
        }
    }

    fn dome(maps: SurfaceMaps, options: DomeOptions) -> Dome {
        Dome::new(maps, &options, &Job::default()).unwrap()
    }

    fn matte() -> DomeOptions {
        DomeOptions { surface: Surface::Matte, ..Default::default() }
    }

    fn bumps(size: Size) -> SurfaceMaps {
        maps(size, |x, y| 3.0 * (x as f32 * 0.8).sin() + 2.0 * (y as f32 * 0.6).cos(), 0.7)
    }

    #[test]
    fn a_plane_is_its_albedo_times_the_cosine_and_the_sky() {
        let options = DomeOptions { ambient: 0.1, ..matte() };
        let flat = dome(maps(Size::new(8, 6), |_, _| 2.0, 0.6), options);
        for light in lights(9) {
            let truth = 0.6 * (light.z() as f32 + 0.1);
            let picture = flat.photograph(light).unwrap();
            assert!(picture.planes.as_slice().iter().all(|v| (v - truth).abs() < 1e-6));
        }
    }

    #[test]
    fn slopes_that_face_the_light_are_the_bright_ones() {
        let size = Size::new(40, 40);
        let hill = |x: usize, y: usize| {
            let squared = (x as f32 - 20.0).powi(2) + (y as f32 - 20.0).powi(2);
            6.0 * (-squared / 60.0).exp()
        };
        let dome = dome(maps(size, hill, 0.5), DomeOptions::default());
        // A light from the right brightens the right side; one from +y brightens the side towards the top
        // row.
        for (azimuth, bright, dark) in
            [(0.0, (26, 20), (14, 20)), (std::f64::consts::FRAC_PI_2, (20, 14), (20, 26))]
        {
            let picture = dome.photograph(Direction::from_angles(0.7, azimuth)).unwrap();
            let [bright, dark] = [bright, dark].map(|(x, y)| picture.planes.at(0, x, y));
            assert!(bright > 1.5 * dark, "azimuth {azimuth}: {bright} {dark}");
        }
    }

    #[test]
    fn a_bounce_adds_light_and_never_more_than_the_hidden_sky_could_send() {
        let size = Size::new(48, 40);
        let with = dome(bumps(size), matte());
        let without = dome(bumps(size), DomeOptions { bounce: Bounce::None, ..matte() });
        let mut brighter = 0;
        for light in lights(12) {
            let direct = without.photograph(light).unwrap().planes;
            let all = with.photograph(light).unwrap().planes;
            let most = direct.range(0).1;
            for texel in 0..size.texels() {
                let added = all.plane(0)[texel] - direct.plane(0)[texel];
                let hidden = 1.0 - with.surroundings.sky[texel];
                assert!(added >= -1e-6 && added <= 0.7 * most * hidden + 2e-3, "{added} {hidden}");
                brighter += usize::from(added > 0.01);
            }
        }
        assert!(brighter > size.texels(), "{brighter} texels");
    }

    /// Light out is at most light in: the mean of a white relief under a lamp at the zenith.
    #[test]
    fn a_white_relief_reflects_no_more_than_arrives() {
        let size = Size::new(48, 48);
        let white = maps(
            size,
            |x, y| {
                5.0 * (x as f32 * std::f32::consts::TAU / 12.0).sin()
                    * (y as f32 * std::f32::consts::TAU / 16.0).cos()
            },
            1.0,
        );
        let dome = dome(white, DomeOptions { ambient: 0.0, ..matte() });
        let lamp = dome.lamp_irradiance(&vec![1.0; size.texels()], Direction::ZENITH);
        let bounced = dome.bounced_irradiance(&lamp, |_, light| light, &Job::default()).unwrap();
        // Integrate over the true area of the facets: texel area divided by the z of the normal.
        let area = |texel: usize| 1.0 / dome.point(texel).normal[2];
        let arrived: f32 = (0..lamp.len()).map(|t| lamp[t] * area(t)).sum();
        let again: f32 = (0..lamp.len()).map(|t| bounced[t][0] * area(t)).sum();
        assert!((arrived / size.texels() as f32 - 1.0).abs() < 1e-5);
        assert!(again > 0.05 * arrived && again < arrived, "{again} of {arrived}");
    }

    #[test]
    fn a_normal_map_shades_and_the_height_still_shadows() {
        let size = Size::new(30, 6);
        let mut wall = maps(size, |x, _| if x >= 20 { 8.0 } else { 0.0 }, 1.0);
        let mut normal = Planes::zeros(size, 3);
        normal.plane_mut(0).fill(1.2);
        normal.plane_mut(2).fill(1.6);
        wall.normal = Some(normal);
        let options =
            DomeOptions { bounce: Bounce::None, ambient: 0.0, border: ReliefBorder::Clamp, ..matte() };
        let light = Direction::from_angles(std::f64::consts::FRAC_PI_4, 0.0);
        let picture = dome(wall, options).photograph(light).unwrap();
        let lit = std::f32::consts::FRAC_1_SQRT_2 * 1.4;
        assert!((picture.planes.at(1, 5, 3) - lit).abs() < 1e-6);
        assert_eq!(picture.planes.at(1, 15, 3), 0.0);
    }

    #[test]
    fn gloss_adds_a_highlight_where_the_mirror_direction_is_the_camera() {
        let size = Size::new(4, 4);
        let mut flat = maps(size, |_, _| 0.0, 0.2);
        flat.roughness = Some(Planes::from_vec(size, 1, vec![0.3; 16]).unwrap());
        let dome = dome(flat, DomeOptions { ambient: 0.0, ..Default::default() });
        let value =
            |polar: f64| dome.photograph(Direction::from_angles(polar, 1.0)).unwrap().planes.at(0, 1, 1);
        // pi D V F with n.l = n.v = n.h = 1: F0 / (4 alpha^2), alpha = 0.09, plus the share of the body.
        let truth = 0.04 / (4.0 * 0.09f32.powi(2)) + 0.2 * 0.96 * 0.96;
        assert!((value(0.0) - truth).abs() < 1e-4, "{} {truth}", value(0.0));
        assert!(value(1.0) < 0.2);
    }

    #[test]
    fn photographs_are_the_same_at_any_thread_count() {
        let many = dome(bumps(Size::new(33, 21)), DomeOptions::default());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        for light in lights(3) {
            let one = pool.install(|| {
                dome(bumps(Size::new(33, 21)), DomeOptions::default()).photograph(light).unwrap()
            });
            assert_eq!(one, many.photograph(light).unwrap());
        }
    }

    #[test]
    fn maps_options_and_lights_that_mean_nothing_are_refused() {
        let size = Size::new(5, 4);
        let flat = || maps(size, |_, _| 1.0, 0.5);
        let refused = |maps: SurfaceMaps, options: DomeOptions| {
            Dome::new(maps, &options, &Job::default()).expect_err("refused").to_string()
        };
        let spoil = |f: fn(&mut SurfaceMaps)| {
            let mut maps = flat();
            f(&mut maps);
            refused(maps, DomeOptions::default())
        };
        assert!(spoil(|m| m.height.as_mut_slice()[7] = f32::NAN).contains("column 2, row 1"));
        assert!(spoil(|m| m.height.as_mut_slice()[7] = 1e30).contains("height scale"));
        assert!(spoil(|m| m.albedo.as_mut_slice()[20] = 1.5).contains("column 0, row 0"));
        assert!(spoil(|m| m.normal = Some(Planes::zeros(m.size(), 3))).contains("(0, 0, 0)"));
        assert!(spoil(|m| m.roughness = Some(Planes::zeros(Size::new(1, 1), 1))).contains("the same size"));
        let options = [
            DomeOptions { ambient: f64::NAN, ..Default::default() },
            DomeOptions { lamp_radius_rad: -0.1, ..Default::default() },
            DomeOptions { sectors: 0, ..Default::default() },
            DomeOptions { surface: Surface::Ggx { f0: 2.0 }, ..Default::default() },
        ];
        options.into_iter().for_each(|o| assert!(refused(flat(), o).contains("expected a number")));
        let below = Direction::from_angles(2.0, 0.0);
        assert!(dome(flat(), DomeOptions::default()).photograph(below).is_err());
        let small = Job::new(Limits { max_bytes: 1000, ..Default::default() });
        assert!(Dome::new(flat(), &DomeOptions::default(), &small).is_err());
    }
}
