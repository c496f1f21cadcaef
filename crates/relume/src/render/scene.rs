//! The scene of a rendered picture apart from the mesh and its texture: camera, lights, options.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;

use super::environment::EnvironmentLight;
use super::highlight::Specular;
use super::vector::Vec3;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::microfacet::LEAST_ROUGHNESS;
use crate::size::Size;

/// A camera on an orbit around the object, looking at the centre of its bounding sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Around the y axis, from the front (+z) towards the right (+x).
    pub azimuth_rad: f64,
    /// Above the horizon, -90 to 90 degrees.
    pub elevation_rad: f64,
    /// From the centre, in radii of the object's bounding sphere.
    pub distance_radii: f64,
    /// The vertical field of view.
    pub field_of_view_rad: f64,
}

impl Default for Camera {
    /// From the front, at a distance that just shows the whole bounding sphere.
    fn default() -> Self {
        let field_of_view_rad = 30.0 * PI / 180.0;
        let distance_radii = Self::distance_to_fit(field_of_view_rad, Size::new(1, 1));
        Self { azimuth_rad: 0.0, elevation_rad: 0.0, distance_radii, field_of_view_rad }
    }
}

impl Camera {
    /// The distance, in radii, from which a sphere fills 94 % of the smaller side of a picture of that size.
    pub fn distance_to_fit(field_of_view_rad: f64, size: Size) -> f64 {
        let smaller = (size.width as f64 / size.height as f64).min(1.0);
        1.0 / (0.94 * smaller * (0.5 * field_of_view_rad).tan()).atan().sin()
    }

    /// A direction given in the frame of the picture (x right, y up, z to the viewer), in world space.
    pub fn to_world(&self, in_picture: Direction) -> Direction {
        let [right, up, back] = self.frame();
        let [x, y, z] = in_picture.to_array();
        let turned = right * x + up * y + back * z;
        Direction::new(turned.x, turned.y, turned.z).expect("a rotated unit vector has a length")
    }

    /// Unit vectors in world space: right and up in the picture, and towards the camera.
    pub(super) fn frame(&self) -> [Vec3; 3] {
        let ((sin_azimuth, cos_azimuth), (sin_elevation, cos_elevation)) =
            (self.azimuth_rad.sin_cos(), self.elevation_rad.sin_cos());
        let back = Vec3::new(sin_azimuth * cos_elevation, sin_elevation, cos_azimuth * cos_elevation);
        let right = Vec3::new(cos_azimuth, 0.0, -sin_azimuth);
        [right, back.cross(right), back]
    }

    fn validate(&self) -> Result<()> {
        let open = 0.1 * PI / 180.0..=170.0 * PI / 180.0;
        if !self.azimuth_rad.is_finite() || !(-FRAC_PI_2..=FRAC_PI_2).contains(&self.elevation_rad) {
            return Err(Error::usage("the camera's elevation must lie between -90 and 90 degrees"));
        }
        if !(1e-3..=1e6).contains(&self.distance_radii) {
            return Err(Error::usage(format!(
                "the camera's distance is {} radii of the object: expected 0.001 to 1,000,000",
                self.distance_radii
            )));
        }
        if !open.contains(&self.field_of_view_rad) {
            return Err(Error::usage("the camera's field of view must lie between 0.1 and 170 degrees"));
        }
        Ok(())
    }
}

/// A light at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Towards the light, in world space (x right, y up, z to the viewer).
    pub direction: Direction,
    /// Linear red, green and blue; 1 is the light of the photographs.
    pub color: [f32; 3],
}

impl Light {
    /// The red, green and blue that a light can have.
    pub const COMPONENTS: RangeInclusive<f64> = 0.0..=1e6;
}

/// How texels respond to light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TexelShading {
    /// By their functions of the direction of the light in the tangent frame.
    Reflectance,
    /// As a conventional texture: the picture of the field under one light of its own frame, used as the
    /// colour of a matt surface. For comparison with the functions.
    Plain {
        /// The light of that picture.
        light: Direction,
    },
}

/// Whether the object casts shadows on itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CastShadows {
    /// Only attached shadows: points that face away from the light are dark.
    Off,
    /// By a shadow map for each light.
    On,
}

/// Options of rendering.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderOptions {
    /// Pixels of the picture.
    pub size: Size,
    /// Each pixel is the mean of `samples` x `samples` points.
    pub samples: usize,
    /// The camera.
    pub camera: Camera,
    /// The lights; at least one where there is no environment.
    pub lights: Vec<Light>,
    /// Light from all around, beside the lights.
    pub environment: Option<EnvironmentLight>,
    /// How often the texture repeats over texture coordinates 0..1, along s and t.
    pub tiling: [f64; 2],
    /// Linear colour where there is no object.
    pub background: [f32; 3],
    /// How texels respond to light.
    pub shading: TexelShading,
    /// Highlights; only where normals are given, and not for [`TexelShading::Plain`].
    pub specular: Specular,
    /// Shadows of the object on itself.
    pub shadows: CastShadows,
}

impl Default for RenderOptions {
    fn default() -> Self {
        let direction = Direction::from_angles(FRAC_PI_2 / 2.0, 3.0 * FRAC_PI_2 / 2.0);
        Self {
            size: Size::new(800, 800),
            samples: 3,
            camera: Camera::default(),
            lights: vec![Light { direction, color: [1.0; 3] }],
            environment: None,
            tiling: [1.0, 1.0],
            background: [0.0; 3],
            shading: TexelShading::Reflectance,
            specular: Specular::default(),
            shadows: CastShadows::On,
        }
    }
}

impl RenderOptions {
    /// Checks every value.
    ///
    /// # Errors
    /// The error names the option that cannot be used, and its range.
    pub fn validate(&self) -> Result<()> {
        let within = |what: &str, value: f64, least: f64, most: f64| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            Err(Error::usage(format!("the {what} is {value}: expected {least} to {most}")))
        };
        self.camera.validate()?;
        within("width of the picture", self.size.width as f64, 1.0, 65_536.0)?;
        within("height of the picture", self.size.height as f64, 1.0, 65_536.0)?;
        within("number of samples along a pixel's side", self.samples as f64, 1.0, 16.0)?;
        let least = if self.environment.is_some() { 0.0 } else { 1.0 };
        within("number of lights", self.lights.len() as f64, least, 64.0)?;
        self.environment.as_ref().map_or(Ok(()), EnvironmentLight::validate)?;
        within("specular strength", self.specular.strength, 0.0, 1.0)?;
        within("roughness", self.specular.roughness, LEAST_ROUGHNESS, 1.0)?;
        for tiling in self.tiling {
            within("tiling factor", tiling, 1e-3, 1e4)?;
        }
        let allowed = Light::COMPONENTS;
        for value in self.lights.iter().flat_map(|light| light.color).chain(self.background) {
            within(
                "colour component of a light or the background",
                f64::from(value),
                *allowed.start(),
                *allowed.end(),
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::view::View;
    use super::*;

    #[test]
    fn a_direction_of_the_picture_points_the_same_way_in_it_for_any_camera() {
        for (azimuth_rad, elevation_rad) in [(0.0, 0.0), (0.7, 0.4), (-2.5, -1.1), (3.0, 1.5)] {
            let camera = Camera { azimuth_rad, elevation_rad, ..Camera::default() };
            let view = View::of_camera(&camera, (Vec3::new(0.0, 0.0, 0.0), 1.0), Size::new(100, 100));
            // Right, up and towards the viewer, in samples and radii.
            let seen = |x: f64, y: f64, z: f64| {
                let at = view.project(Vec3::from(camera.to_world(Direction::new(x, y, z).unwrap())) * 0.1);
                [at.x / at.z - 50.0, 50.0 - at.y / at.z, camera.distance_radii - at.z]
            };
            let (right, up, near) = (seen(1.0, 0.0, 0.0), seen(0.0, 1.0, 0.0), seen(0.0, 0.0, 1.0));
            assert!(right[0] > 1.0 && right[1].abs() < 1e-9 && right[2].abs() < 1e-9, "{right:?}");
            assert!(up[1] > 1.0 && up[0].abs() < 1e-9 && up[2].abs() < 1e-9, "{up:?}");
            assert!((near[2] - 0.1).abs() < 1e-9 && near[0].abs() < 1e-9, "{near:?}");
        }
    }

    #[test]
    fn a_sphere_fits_the_smaller_side_of_the_picture() {
        for size in [Size::new(100, 100), Size::new(40, 100), Size::new(100, 40)] {
            let field_of_view_rad = 0.5;
            let distance_radii = Camera::distance_to_fit(field_of_view_rad, size);
            let camera = Camera { distance_radii, field_of_view_rad, ..Camera::default() };
            let view = View::of_camera(&camera, (Vec3::new(0.0, 0.0, 0.0), 1.0), size);
            // The outline of a sphere lies where rays touch it.
            let touch = (1.0 - distance_radii.powi(-2)).sqrt();
            let edge = view.project(Vec3::new(touch, 0.0, 1.0 / distance_radii));
            let across = edge.x / edge.z - 0.5 * size.width as f64;
            let smaller = 0.5 * size.width.min(size.height) as f64;
            assert!((across / smaller - 0.94).abs() < 1e-6, "{size}: {across}");
        }
    }
}
