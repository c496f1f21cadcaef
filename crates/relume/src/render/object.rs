//! Pictures of a texture on an object.

use super::environment::{EnvironmentMethod, ImportanceTable, Prefiltered};
use super::material::{LitTexture, Lookup};
use super::mesh::{Mesh, Tangents};
use super::raster::{self, Hit, Setup};
use super::relief::{MeshRelief, TRIANGLE_BYTES, displaced};
use super::relighter::Relighter;
use super::scene::{CastShadows, RenderOptions, TexelShading};
use super::shade::{AmbientLight, Shader};
use super::shadow::ShadowMap;
use super::vector::Vec3;
use super::view::View;
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// Rows of pixels rendered by one task.
const BAND: usize = 8;
/// Memory of a pixel: its colour in a band and in the picture.
const PIXEL_BYTES: u64 = 24;

/// A linear RGB picture of `field` on `mesh`, without relief.
///
/// # Errors
/// As [`render_relief`].
pub fn render(
    field: &ReflectanceField,
    normals: Option<&Planes>,
    mesh: &Mesh,
    options: &RenderOptions,
    job: &Job,
) -> Result<Picture> {
    render_relief(field, normals, None, mesh, options, job)
}

/// A linear RGB picture of `field` on `mesh`, bumped and displaced by a relief if one is given. `normals` are
/// those of the texels of the field and add highlights; without them there are none.
///
/// # Errors
/// When an option is out of its range, the normals do not match the field, or the limits are exceeded.
pub fn render_relief(
    field: &ReflectanceField,
    normals: Option<&Planes>,
    relief: Option<&MeshRelief>,
    mesh: &Mesh,
    options: &RenderOptions,
    job: &Job,
) -> Result<Picture> {
    options.validate()?;
    relief.map_or(Ok(()), MeshRelief::validate)?;
    job.check("the picture", options.size, PIXEL_BYTES)?;
    let _picture = job.hold("the picture", PIXEL_BYTES * options.size.texels() as u64)?;
    let shadow_bytes = ShadowMap::BYTES.saturating_mul(options.lights.len() as u64);
    let _shadows = job.hold("the shadow maps", shadow_bytes)?;
    let _mesh = job.hold("the mesh", TRIANGLE_BYTES * mesh.triangles().len() as u64)?;
    let material = match options.shading {
        TexelShading::Reflectance => LitTexture::of_field(field, normals, job)?,
        TexelShading::Plain { light } => {
            let photograph = Relighter::new(field, job)?.relight(light).to_space(Space::Linear);
            LitTexture::of_colors(&photograph.planes, job)?
        }
    };
    let lookups = relief.map(|relief| relief.lookups(job)).transpose()?;
    let moved = match (relief, &lookups) {
        (Some(relief), Some(lookups)) if relief.displacement != 0.0 => {
            Some(displaced(mesh, relief, lookups, options.tiling, job)?)
        }
        _ => None,
    };
    let geometry = moved.as_ref().map_or(mesh, |moved| &moved.mesh);
    let samples = Size::new(options.size.width * options.samples, options.size.height * options.samples);
    let view = View::of_camera(&options.camera, geometry.bounding_sphere(), samples);
    let shadows = match options.shadows {
        CastShadows::Off => Vec::new(),
        CastShadows::On => {
            let towards = options.lights.iter().map(|light| Vec3::from(light.direction));
            towards.map(|towards_light| ShadowMap::new(geometry, towards_light)).collect()
        }
    };
    let tangents = Tangents::new(mesh);
    let tilt = relief.map_or(0.0, |relief| tilt(relief, options.shading));
    let shader = Shader {
        mesh,
        moved: moved.as_ref(),
        slopes: lookups.as_ref().filter(|_| tilt != 0.0).map(|slopes| (slopes, tilt)),
        tangents,
        material: &material,
        attached: material.attached_shadow(),
        view,
        options,
        shadows,
        ambient: ambient(&material, normals, options, job)?,
    };
    Ok(Picture { planes: all_bands(&shader, job)?, space: Space::Linear })
}

/// The environment of the scene, prepared for a texture.
fn ambient(
    material: &LitTexture,
    normals: Option<&Planes>,
    options: &RenderOptions,
    job: &Job,
) -> Result<Option<AmbientLight>> {
    let Some(light) = &options.environment else { return Ok(None) };
    let shines = normals.is_some() && options.specular.strength > 0.0;
    let highlights = (shines && options.shading == TexelShading::Reflectance).then_some(&options.specular);
    Ok(Some(match light.method {
        EnvironmentMethod::Prefiltered => {
            if material.has_moved_boundaries() {
                job.remark(
                    "the prefiltered light of the environment is smooth, and fades shadows and highlights between the lights \
                     of the photographs instead of moving them: sample it at each point (--env-samples) for those of the \
                     texture"
                        .to_owned(),
                );
            }
            AmbientLight::Prefiltered(Box::new(Prefiltered::new(
                &light.environment,
                material,
                highlights,
                job,
            )?))
        }
        EnvironmentMethod::Sampled { samples, seed } => {
            AmbientLight::Sampled(ImportanceTable::new(&light.environment, job)?, samples, seed)
        }
    }))
}

/// The factor of the slopes by which frames are tilted: a conventional texture is shaded by its displacement.
fn tilt(relief: &MeshRelief, shading: TexelShading) -> f64 {
    match shading {
        TexelShading::Plain { .. } => relief.bump + relief.displacement,
        TexelShading::Reflectance => relief.bump,
    }
}

fn all_bands(shader: &Shader, job: &Job) -> Result<Planes> {
    let size = shader.options.size;
    let setups = Setup::all(shader.geometry(), &shader.view);
    let bands = raster::by_band(&setups, &shader.view, BAND * shader.options.samples);
    job.start("rendering", bands.len() as u64);
    let colors = parallel::try_map(bands.iter().enumerate(), |(band, chosen)| {
        let rows = (band * BAND, ((band + 1) * BAND).min(size.height));
        job.advance(1).map(|()| one_band(shader, &setups, chosen, rows))
    })?;
    let mut planes = Planes::zeros(size, 3);
    for (c, plane) in planes.iter_mut().enumerate() {
        plane.iter_mut().zip(colors.iter().flatten()).for_each(|(out, color)| *out = color[c]);
    }
    Ok(planes)
}

/// The pixels of rows `rows.0..rows.1`: the mean of their samples.
fn one_band(shader: &Shader, setups: &[Setup], chosen: &[u32], rows: (usize, usize)) -> Vec<[f32; 3]> {
    let (n, width) = (shader.options.samples, shader.options.size.width);
    let hits = raster::scan(setups, chosen, &shader.view, (rows.0 * n, rows.1 * n));
    let background = shader.options.background.map(f64::from);
    let mut sums = vec![[0.0f64; 3]; width * (rows.1 - rows.0)];
    let mut lookup = Lookup::default();
    for (line, hits) in hits.chunks_exact(width * n).enumerate() {
        for (column, hit) in hits.iter().enumerate() {
            let color = if *hit == Hit::NOTHING {
                background
            } else {
                let (x, y) = (column as f64 + 0.5, (rows.0 * n + line) as f64 + 0.5);
                shader.color(&setups[hit.setup as usize], x, y, &mut lookup)
            };
            let sum = &mut sums[line / n * width + column / n];
            sum.iter_mut().zip(color).for_each(|(s, c)| *s += c);
        }
    }
    let count = (n * n) as f64;
    sums.into_iter().map(|sum| sum.map(|s| (s / count) as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::{Basis, PlaneLayout, shapes_example};
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use crate::render::highlight::Specular;
    use crate::render::mesh::Primitive;
    use crate::render::relight::relight;
    use crate::render::scene::{Camera, Light};

    /// Positive under any light: the constant outweighs the other coefficients.
    fn random_field(color: PlaneLayout, space: Space, side: usize) -> ReflectanceField {
        let mut stream = Stream::new(11, Purpose::Sample, [0]);
        let size = Size::new(side, side);
        let count = color.planes(6);
        let mut planes = Planes::zeros(size, count);
        for (k, plane) in planes.iter_mut().enumerate() {
            let is_color = color == PlaneLayout::LRGB && k >= 6;
            let (least, range) = if is_color || k % 6 == 5 { (0.4, 0.4) } else { (-0.05, 0.1) };
            plane.iter_mut().for_each(|v| *v = least + range * stream.unit() as f32);
        }
        ReflectanceField::new(Basis::Ptm, color, space, planes).unwrap()
    }

    /// Every texel has the same six coefficients.
    fn uniform_field(coefficients: [f32; 6]) -> ReflectanceField {
        let data = coefficients.iter().flat_map(|&c| [c; 4]).collect();
        let planes = Planes::from_vec(Size::new(2, 2), 6, data).unwrap();
        ReflectanceField::new(Basis::Ptm, PlaneLayout::LUMINANCE, Space::Linear, planes).unwrap()
    }

    /// Options with which the plane fills the picture.
    fn facing(size: Size, light: [f64; 3]) -> RenderOptions {
        let mut options = RenderOptions { size, samples: 1, ..RenderOptions::default() };
        options.camera.distance_radii = 1.0 / ((0.5 * options.camera.field_of_view_rad).tan() * 2f64.sqrt());
        options.lights = vec![light_from(light)];
        options
    }

    fn light_from([x, y, z]: [f64; 3]) -> Light {
        Light { direction: Direction::new(x, y, z).unwrap(), color: [1.0; 3] }
    }

    fn rendered(field: &ReflectanceField, mesh: &Mesh, options: &RenderOptions) -> Picture {
        render(field, None, mesh, options, &Job::default()).unwrap()
    }

    #[test]
    fn a_plane_that_faces_the_camera_shows_the_relit_picture() {
        for color in [PlaneLayout::LUMINANCE, PlaneLayout::RGB, PlaneLayout::LRGB] {
            for space in [Space::Linear, Space::Srgb] {
                let field = random_field(color.clone(), space, 33);
                let options = facing(field.size(), [0.5, -0.3, 0.6]);
                let picture = rendered(&field, &Primitive::Plane.mesh(), &options);
                let truth = relight(&field, options.lights[0].direction).to_space(Space::Linear);
                for c in 0..3 {
                    let truth = truth.planes.plane(if color == PlaneLayout::LUMINANCE { 0 } else { c });
                    for (i, (a, b)) in picture.planes.plane(c).iter().zip(truth).enumerate() {
                        assert!((a - b).abs() < 1e-5, "{color:?} {space:?} texel {i}: {a} instead of {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn objects_show_the_boundaries_that_move_between_the_lights() {
        for layout in [PlaneLayout::LUMINANCE, PlaneLayout::RGB] {
            let field = shapes_example(layout);
            let light = Direction::from_angles(0.6, 2.9);
            let size = field.size();
            let wide = Primitive::Plane.mesh_with_aspect(size.width as f64 / size.height as f64);
            let mut options = facing(size, light.to_array());
            options.camera.distance_radii = distance_that_fills(size, &options);
            let picture = rendered(&field, &wide, &options);
            let relighter = Relighter::new(&field, &Job::default()).unwrap();
            let truth = relighter.relight(light).to_space(Space::Linear).planes;
            let linear = relight(&field, light).to_space(Space::Linear).planes;
            assert!(truth.plane(0).iter().zip(linear.plane(0)).any(|(a, b)| (a - b).abs() > 0.05));
            for (i, (a, b)) in picture.planes.plane(0).iter().zip(truth.plane(0)).enumerate() {
                assert!((a - b.max(0.0)).abs() < 1e-4, "texel {i}: {a} instead of {b}");
            }
        }
    }

    /// The distance from which a plane of the proportions of the picture fills it.
    fn distance_that_fills(size: Size, options: &RenderOptions) -> f64 {
        let half_height = 1.0 / (1.0 + (size.width as f64 / size.height as f64).powi(2)).sqrt();
        half_height / (0.5 * options.camera.field_of_view_rad).tan()
    }

    #[test]
    fn the_middle_of_a_plane_is_seen_from_straight_above_with_any_basis() {
        for basis in Basis::examples() {
            let light = Direction::new(0.5, -0.3, 0.6).unwrap();
            // The values of the functions as coefficients: a sum of squares is positive.
            let weights = basis.weights(light);
            let data = weights[..basis.len()].iter().flat_map(|&w| [w as f32; 9]).collect();
            let planes = Planes::from_vec(Size::new(3, 3), basis.len(), data).unwrap();
            let layout = match basis.channels() {
                1 => PlaneLayout::LUMINANCE,
                _ => PlaneLayout::shared(["R", "G", "B"]).unwrap(),
            };
            let field = ReflectanceField::new(basis.clone(), layout, Space::Linear, planes).unwrap();
            let picture = rendered(&field, &Primitive::Plane.mesh(), &facing(field.size(), [0.5, -0.3, 0.6]));
            let truth = Relighter::new(&field, &Job::default()).unwrap().relight(light);
            let truth = truth.planes.at(0, 1, 1);
            assert!((picture.planes.at(0, 1, 1) / truth - 1.0).abs() < 1e-5, "{}", basis.name());
        }
    }

    #[test]
    fn channels_that_make_no_colour_are_refused() {
        let layout = PlaneLayout::of_channels(["metallic", "roughness"]).unwrap();
        let planes = Planes::zeros(Size::new(2, 2), 2);
        let field = ReflectanceField::new(Basis::Constant, layout, Space::Linear, planes).unwrap();
        let options = facing(field.size(), [0.0, 0.0, 1.0]);
        let error = render(&field, None, &Primitive::Plane.mesh(), &options, &Job::default()).unwrap_err();
        assert!(error.to_string().contains("metallic, roughness"), "{error}");
    }

    #[test]
    fn lights_add_up_in_their_colours() {
        let (field, mesh) = (random_field(PlaneLayout::RGB, Space::Linear, 16), Primitive::Plane.mesh());
        let mut options = facing(field.size(), [0.5, 0.0, 0.8]);
        let first = rendered(&field, &mesh, &options);
        options.lights = vec![light_from([0.0, -0.4, 0.9])];
        let second = rendered(&field, &mesh, &options);
        options.lights.push(Light { color: [0.5, 2.0, 0.0], ..light_from([0.5, 0.0, 0.8]) });
        let both = rendered(&field, &mesh, &options);
        for (c, share) in [0.5, 2.0, 0.0].into_iter().enumerate() {
            for (i, sum) in both.planes.plane(c).iter().enumerate() {
                let expected = second.planes.plane(c)[i] + share * first.planes.plane(c)[i];
                assert!((sum - expected).abs() < 1e-5);
            }
        }
    }

    /// The value in the middle of the picture of a square whose texture coordinates are `s`, `t` of the (x,
    /// y) of its corners.
    fn middle(field: &ReflectanceField, light: [f64; 3], texcoord: impl Fn([f32; 2]) -> [f32; 2]) -> f32 {
        let plane = Primitive::Plane.mesh();
        let texcoords = plane.texcoords().iter().map(|&c| texcoord(c)).collect();
        let mesh =
            Mesh::new(plane.positions().to_vec(), None, texcoords, plane.triangles().to_vec()).unwrap();
        rendered(field, &mesh, &facing(Size::new(3, 3), light)).planes.at(0, 1, 1)
    }

    #[test]
    fn the_tangent_frame_follows_the_texture() {
        // Bright for light from the right of the texture, and less so from above.
        let field = uniform_field([0.0, 0.0, 0.0, 0.4, 0.1, 0.5]);
        let light = [0.6, 0.0, 0.8];
        let near = |found: f32, u: f64, v: f64| {
            let expected = 0.5 + 0.4 * u + 0.1 * v;
            assert!((f64::from(found) - expected).abs() < 1e-5, "{found} instead of {expected}");
        };
        near(middle(&field, light, |c| c), 0.6, 0.0);
        near(middle(&field, [-0.6, 0.0, 0.8], |c| c), -0.6, 0.0);
        near(middle(&field, [0.0, 0.6, 0.8], |c| c), 0.0, 0.6);
        // Mirrored, the right of the texture is the left of the world; its up stays up.
        near(middle(&field, light, |[s, t]| [1.0 - s, t]), -0.6, 0.0);
        near(middle(&field, [0.0, 0.6, 0.8], |[s, t]| [1.0 - s, t]), 0.0, 0.6);
        // Turned by a quarter, the right of the texture is up in the world.
        near(middle(&field, light, |[s, t]| [t, 1.0 - s]), 0.0, -0.6);
        near(middle(&field, [0.0, 0.6, 0.8], |[s, t]| [t, 1.0 - s]), 0.6, 0.0);
    }

    #[test]
    fn the_nearer_of_two_squares_is_seen_in_any_order() {
        let picture = Picture {
            planes: Planes::from_vec(Size::new(2, 1), 1, vec![0.2, 0.8]).unwrap(),
            space: Space::Linear,
        };
        let field = ReflectanceField::from_picture(picture);
        let square = |z: f32| [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
        for (heights, expected) in [([0.0, 0.5], 0.8), ([0.5, 0.0], 0.2)] {
            let positions = heights.iter().flat_map(|&z| square(z)).collect();
            let texcoords = [[0.25, 0.5]; 4].into_iter().chain([[0.75, 0.5]; 4]).collect();
            let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
            let mesh = Mesh::new(positions, None, texcoords, triangles).unwrap();
            let picture = rendered(&field, &mesh, &facing(Size::new(9, 9), [0.0, 0.0, 1.0]));
            assert!((picture.planes.at(0, 4, 4) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn a_pixel_is_the_mean_of_its_samples() {
        let field = random_field(PlaneLayout::RGB, Space::Linear, 16);
        let mesh = Primitive::Sphere.mesh();
        let coarse = RenderOptions { size: Size::new(24, 20), samples: 3, ..RenderOptions::default() };
        let fine = RenderOptions { size: Size::new(72, 60), samples: 1, ..RenderOptions::default() };
        let (coarse, fine) = (rendered(&field, &mesh, &coarse), rendered(&field, &mesh, &fine));
        for (c, y, x) in (0..3).flat_map(|c| (0..20).flat_map(move |y| (0..24).map(move |x| (c, y, x)))) {
            let samples = (0..9).map(|i| fine.planes.at(c, 3 * x + i % 3, 3 * y + i / 3));
            assert!((coarse.planes.at(c, x, y) - samples.sum::<f32>() / 9.0).abs() < 1e-6);
        }
    }

    #[test]
    fn thread_counts_do_not_change_a_bit() {
        let field = random_field(PlaneLayout::LRGB, Space::Srgb, 16);
        let normals =
            Planes::from_vec(field.size(), 3, [[0.0; 256], [0.0; 256], [1.0; 256]].concat()).unwrap();
        let mesh = Primitive::Torus.mesh();
        let options = RenderOptions { size: Size::new(61, 47), samples: 2, ..RenderOptions::default() };
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&field, Some(&normals), &mesh, &options, &Job::default()).unwrap())
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn a_plain_texture_is_a_matt_surface_with_the_photograph_s_colours() {
        let field = random_field(PlaneLayout::LRGB, Space::Srgb, 9);
        let photographed = Direction::from_disk(0.2, 0.1);
        let mut options = facing(field.size(), [0.3, 0.4, 0.8]);
        options.shading = TexelShading::Plain { light: photographed };
        let picture = rendered(&field, &Primitive::Plane.mesh(), &options);
        let photograph = relight(&field, photographed).to_space(Space::Linear);
        let cosine = options.lights[0].direction.z() as f32;
        for (a, b) in picture.planes.as_slice().iter().zip(photograph.planes.as_slice()) {
            assert!((a - b * cosine).abs() < 1e-5);
        }
    }

    #[test]
    fn highlights_need_normals_and_strength() {
        let field = uniform_field([0.0, 0.0, 0.0, 0.0, 0.0, 0.3]);
        let up = Planes::from_vec(field.size(), 3, [[0.0; 4], [0.0; 4], [1.0; 4]].concat()).unwrap();
        let mesh = Primitive::Sphere.mesh();
        let brightest = |normals: Option<&Planes>, strength: f64| {
            let specular = Specular { strength, roughness: 0.4 };
            let options = RenderOptions { size: Size::new(60, 60), specular, ..RenderOptions::default() };
            let picture = render(&field, normals, &mesh, &options, &Job::default()).unwrap();
            picture.planes.range(0).1
        };
        assert!((brightest(None, 0.5) - 0.3).abs() < 1e-5);
        assert!((brightest(Some(&up), 0.0) - 0.3).abs() < 1e-5);
        assert!(brightest(Some(&up), 0.04) > 0.5);
    }

    #[test]
    fn the_far_side_of_the_light_is_dark_and_the_background_is_kept() {
        let field = uniform_field([0.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
        let mut options = facing(Size::new(41, 41), [1.0, 0.0, 0.0]);
        options.camera = Camera::default();
        options.background = [0.1, 0.2, 0.3];
        let picture = rendered(&field, &Primitive::Sphere.mesh(), &options);
        assert_eq!([0, 1, 2].map(|c| picture.planes.at(c, 0, 0)), [0.1, 0.2, 0.3]);
        assert_eq!(picture.planes.at(0, 12, 20), 0.0);
        assert!((picture.planes.at(0, 28, 20) - 0.5).abs() < 1e-5);
    }

    /// The value left of a ridge six texels high, under light from the right.
    fn beside_a_ridge(displacement: f64, bump: f64, shadows: CastShadows) -> f32 {
        let size = Size::new(32, 32);
        let heights = (0..size.texels()).map(|i| if (14..18).contains(&(i % 32)) { 6.0 } else { 0.0 });
        let height = Planes::from_vec(size, 1, heights.collect()).unwrap();
        let relief = MeshRelief { height, displacement, bump };
        let field = uniform_field([0.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
        let options = RenderOptions { shadows, ..facing(Size::new(64, 64), [0.8, 0.0, 0.6]) };
        let (mesh, job) = (Primitive::Plane.mesh(), Job::default());
        let picture = render_relief(&field, None, Some(&relief), &mesh, &options, &job).unwrap();
        picture.planes.at(0, 21, 32)
    }

    #[test]
    fn a_displaced_ridge_casts_a_shadow_and_a_bumped_one_does_not() {
        assert_eq!(beside_a_ridge(1.0, 0.0, CastShadows::On), 0.0);
        for (displacement, bump, shadows) in [
            (1.0, 0.0, CastShadows::Off),
            (0.0, 1.0, CastShadows::On),
            (0.0, 0.0, CastShadows::On),
            (0.2, 0.0, CastShadows::On),
        ] {
            let lit = beside_a_ridge(displacement, bump, shadows);
            assert!((lit - 0.5).abs() < 1e-5, "{displacement} {bump} {shadows:?}: {lit}");
        }
    }

    #[test]
    fn what_cannot_be_rendered_is_refused() {
        let (field, mesh) = (uniform_field([0.0; 6]), Primitive::Plane.mesh());
        let refused = |change: &dyn Fn(&mut RenderOptions)| {
            let mut options = RenderOptions::default();
            change(&mut options);
            render(&field, None, &mesh, &options, &Job::default()).unwrap_err().to_string()
        };
        assert!(refused(&|o| o.samples = 0).contains("samples"));
        assert!(refused(&|o| o.lights.clear()).contains("lights"));
        assert!(refused(&|o| o.tiling = [f64::NAN, 1.0]).contains("tiling"));
        assert!(refused(&|o| o.size = Size::new(0, 5)).contains("width"));
        assert!(refused(&|o| o.camera.distance_radii = -1.0).contains("distance"));
        assert!(refused(&|o| o.specular.roughness = f64::NAN).contains("roughness"));
        let normals = Planes::zeros(Size::new(3, 2), 3);
        assert!(render(&field, Some(&normals), &mesh, &RenderOptions::default(), &Job::default()).is_err());
        let small = Job::new(Limits { max_bytes: 1000, ..Limits::default() });
        assert!(render(&field, None, &mesh, &RenderOptions::default(), &small).is_err());
    }
}
