//! The fast form against the truth by samples, and both against closed forms and single lights.

use std::f64::consts::PI;

use super::cells::cells;
use super::*;
use crate::direction::{Direction, Directions};
use crate::error::ErrorKind;
use crate::field::basis::learned_example;
use crate::field::{Basis, Domain, PlaneLayout, ReflectanceField, shapes_example};
use crate::limits::Limits;
use crate::numeric::quadrature::integrate_hemisphere;
use crate::render::{CastShadows, Light, Primitive, Relighter, RenderOptions, TexelShading, relight, render};

fn job() -> Job {
    Job::default()
}

fn map(size: Size, value: impl Fn(usize, usize) -> [f32; 3]) -> Environment {
    let texels = |c| (0..size.texels()).map(move |i| (i % size.width, i / size.width, c));
    let data = (0..3).flat_map(texels).map(|(x, y, c): (usize, usize, usize)| value(x, y)[c]).collect();
    let planes = Planes::from_vec(size, 3, data).unwrap();
    Environment::new(&Picture { planes, space: Space::Linear }, &job()).unwrap()
}

fn constant(value: [f32; 3]) -> Environment {
    map(Size::new(32, 16), |_, _| value)
}

/// One bright texel whose radiance integrates to pi, and the direction of its middle.
fn spot(size: Size, (x, y): (usize, usize)) -> (Environment, Direction) {
    let (top, bottom) = (row_cosine(y, size.height), row_cosine(y + 1, size.height));
    let solid_angle = 2.0 * PI * (top - bottom) / size.width as f64;
    let radiance = (PI / solid_angle) as f32;
    let environment = map(size, |i, k| if (i, k) == (x, y) { [radiance; 3] } else { [0.0; 3] });
    let at = environment.direction((x as f64 + 0.5) / size.width as f64, 0.5 * (top + bottom));
    (environment, Direction::new(at.x, at.y, at.z).unwrap())
}

/// The normal of a texel.
fn tilted(texel: usize) -> Direction {
    Direction::from_angles(0.08 * (texel % 5) as f64, 1.9 * texel as f64)
}

/// The normals of texels tilted like those of [`field`].
fn normals(size: Size) -> Planes {
    let data = (0..3).flat_map(|k| (0..size.texels()).map(move |texel| tilted(texel).to_array()[k] as f32));
    Planes::from_vec(size, 3, data.collect()).unwrap()
}

/// Texels tilted in different directions, their light projected on a basis; for a learned one, the functions themselves.
fn field(basis: &Basis, space: Space) -> ReflectanceField {
    let size = Size::new(4, 4);
    let n = basis.len();
    let gram = basis.gram(Domain::Hemisphere).unwrap();
    let mut planes = Planes::zeros(size, 3 * n);
    for texel in 0..size.texels() {
        let normal = tilted(texel);
        for k in 0..n {
            let coefficient = match basis {
                Basis::Ptm => {
                    let [x, y, _] = normal.to_array();
                    [-0.3, -0.3, 0.0, 0.5 * x, 0.5 * y, 0.75][k]
                }
                Basis::Learned(learned) => {
                    // A matt surface that is somewhat brighter seen from the side of the light.
                    let value = |pair: &Directions| {
                        pair.light.dot(normal).max(0.0) * (0.7 + 0.3 * pair.light.dot(pair.view))
                    };
                    let rows =
                        learned.values().chunks_exact(n).zip(learned.pairs().iter().zip(learned.weights()));
                    rows.map(|(row, (pair, weight))| weight * f64::from(row[k]) * value(pair)).sum()
                }
                Basis::Interpolated(interpolated) => interpolated.lights()[k].dot(normal).max(0.0),
                Basis::Constant => 1.0,
                _ => {
                    let lit = |w: Direction| basis.weights(w)[k] * w.dot(normal).max(0.0);
                    integrate_hemisphere(24, lit) / gram.at(k, k)
                }
            };
            (0..3).for_each(|c| {
                planes.plane_mut(c * n + k)[texel] = (coefficient * [0.9, 0.7, 0.5][c]) as f32;
            });
        }
    }
    ReflectanceField::new(basis.clone(), PlaneLayout::RGB, space, planes).unwrap()
}

fn lit_by(environment: Environment, method: EnvironmentMethod, side: usize) -> RenderOptions {
    RenderOptions {
        size: Size::new(side, side),
        samples: 1,
        lights: Vec::new(),
        environment: Some(EnvironmentLight { environment, method }),
        tiling: [3.0, 2.0],
        ..RenderOptions::default()
    }
}

fn rendered(field: &ReflectanceField, primitive: Primitive, options: &RenderOptions) -> Picture {
    let normals = normals(field.size());
    render(field, Some(&normals), &primitive.mesh(), options, &job()).unwrap()
}

/// The root mean square of the differences, as a fraction of that of the truth.
fn relative(found: &Picture, truth: &Picture) -> f64 {
    let pairs = || found.planes.as_slice().iter().zip(truth.planes.as_slice());
    let square = |v: f32| f64::from(v) * f64::from(v);
    let errors: f64 = pairs().map(|(a, b)| square(a - b)).sum();
    (errors / pairs().map(|(_, b)| square(*b)).sum::<f64>()).sqrt()
}

#[test]
fn the_centre_of_a_map_is_straight_ahead_and_turning_moves_it_to_the_right() {
    let size = Size::new(64, 32);
    let environment = map(size, |x, y| [x as f32, y as f32, 1.0]);
    let seen = |x: f64, y: f64, z: f64| environment.radiance(Vec3::new(x, y, z));
    assert_eq!(seen(0.01, 0.01, -1.0)[..2], [32.0, 15.0]);
    assert_eq!(seen(1.0, -0.01, -0.01)[..2], [47.0, 16.0]);
    assert_eq!(seen(-1.0, 0.01, -0.01)[0], 16.0);
    assert_eq!((seen(0.01, 0.0, 1.0)[0], seen(-0.01, 0.0, 1.0)[0]), (63.0, 0.0));
    assert_eq!((seen(0.0, 1.0, 0.0)[1], seen(0.0, -1.0, 0.0)[1]), (0.0, 31.0));
    for (x, y) in [(0, 0), (17, 5), (63, 31)] {
        let middle = 0.5 * (row_cosine(y, 32) + row_cosine(y + 1, 32));
        let direction = environment.direction((x as f64 + 0.5) / 64.0, middle);
        assert_eq!(environment.radiance(direction)[..2], [x as f64, y as f64]);
    }
    let turned = environment.adjusted(0.5 * PI, 2.0).unwrap();
    assert_eq!(turned.radiance(Vec3::new(1.0, 0.01, 0.01)), [64.0, 30.0, 2.0]);
}

#[test]
fn samples_and_cells_hold_the_light_of_the_map() {
    let sky = Environment::sky(&job()).unwrap().adjusted(0.3, 1.5).unwrap();
    let Size { width, height } = sky.size();
    let mut whole = [0.0; 3];
    for y in 0..height {
        let solid_angle = 2.0 * PI * (row_cosine(y, height) - row_cosine(y + 1, height)) / width as f64;
        (0..width).for_each(|x| (0..3).for_each(|c| whole[c] += solid_angle * sky.texel(x, y)[c]));
    }
    let lights = cells(&sky, 2048);
    assert!(lights.len() > 2000 && lights.len() <= 2048, "{}", lights.len());
    let table = ImportanceTable::new(&sky, &job()).unwrap();
    let mut drawn = [0.0; 3];
    table.for_each(PlacedSamples { samples: 4096, seed: 1, place: [3, 4] }, |direction, color| {
        assert!((direction.dot(direction) - 1.0).abs() < 1e-9);
        (0..3).for_each(|c| drawn[c] += PI * color[c]);
    });
    for c in 0..3 {
        let sum: f64 = lights.iter().map(|light| light.power[c]).sum();
        assert!((sum / whole[c] - 1.0).abs() < 1e-5, "{sum} {}", whole[c]);
        assert!((drawn[c] / whole[c] - 1.0).abs() < 0.01, "{} {}", drawn[c], whole[c]);
    }
}

/// Drawn directions are as frequent as their light: the mean of any function is its integral.
#[test]
fn the_mean_over_drawn_directions_is_the_integral() {
    let sky = Environment::sky(&job()).unwrap();
    let table = ImportanceTable::new(&sky, &job()).unwrap();
    let function = |v: Vec3| (1.0 + v.x) * (1.2 - v.y * v.z);
    let truth: f64 = cells(&sky, 1 << 16).iter().map(|l| function(l.direction) * l.power[1]).sum();
    let mut sum = 0.0;
    table.for_each(PlacedSamples { samples: 1 << 14, seed: 0, place: [0, 0] }, |v, color| {
        sum += PI * function(v) * color[1];
    });
    assert!((sum / truth - 1.0).abs() < 0.003, "{sum} {truth}");
}

#[test]
fn under_a_constant_environment_a_texture_has_the_integrals_of_its_functions() {
    let radiance = [1.0, 2.0, 0.5];
    for basis in Basis::NAMED {
        for k in 0..basis.len() {
            let planes: Vec<f32> = (0..basis.len()).map(|j| f32::from(u8::from(j == k))).collect();
            let planes = Planes::from_vec(Size::new(1, 1), basis.len(), planes).unwrap();
            let field =
                ReflectanceField::new(basis.clone(), PlaneLayout::LUMINANCE, Space::Linear, planes).unwrap();
            let integral = basis.integrate(Domain::Hemisphere, 40, |w| w[k]).unwrap() / PI;
            let picture = relight_under(&field, &constant(radiance), &job()).unwrap();
            for (c, radiance) in radiance.into_iter().enumerate() {
                let expected = integral.max(0.0) * f64::from(radiance);
                let found = f64::from(picture.planes.plane(c)[0]);
                assert!((found - expected).abs() < 0.004, "{} {k}: {found} {expected}", basis.name());
            }
        }
    }
}

#[test]
fn a_white_matt_sphere_is_white_in_a_white_world() {
    let picture =
        Picture { planes: Planes::from_vec(Size::new(1, 1), 1, vec![1.0]).unwrap(), space: Space::Linear };
    let field = ReflectanceField::from_picture(picture);
    // The fade at the horizon takes a little: 1 - 2 ∫ c fade dc.
    let steps = 10_000;
    let cosine = |i: usize| (i as f64 + 0.5) / steps as f64;
    let share =
        (0..steps).map(|i| 2.0 * cosine(i) * super::super::horizon::AttachedShadow::Smooth.share(cosine(i)));
    let expected = share.sum::<f64>() / steps as f64;
    assert!((0.99..1.0).contains(&expected), "{expected}");
    let sampled = EnvironmentMethod::Sampled { samples: 4096, seed: 0 };
    for (method, tolerance) in [(EnvironmentMethod::Prefiltered, 0.002), (sampled, 0.02)] {
        let mut options = lit_by(constant([1.0; 3]), method, 9);
        options.shading = TexelShading::Plain { light: Direction::ZENITH };
        let found = f64::from(rendered(&field, Primitive::Sphere, &options).planes.at(0, 4, 4));
        assert!((found - expected).abs() < tolerance, "{method:?}: {found} {expected}");
    }
}

#[test]
fn a_narrow_spot_is_a_light() {
    let size = Size::new(512, 256);
    // To the upper right, in front of the object.
    let (environment, direction) = spot(size, (440, 80));
    assert!(direction.x() > 0.3 && direction.y() > 0.3 && direction.z() > 0.3, "{direction:?}");
    for (basis, space) in
        [(Basis::Ptm, Space::Linear), (Basis::Ptm, Space::Srgb), (Basis::HSH9, Space::Linear)]
    {
        let field = field(&basis, space);
        let flat = relight_under(&field, &environment, &job()).unwrap();
        let truth = relight(&field, direction).to_space(Space::Linear);
        let error = relative(&flat, &truth);
        assert!(error < if space == Space::Srgb { 0.03 } else { 1e-3 }, "{basis:?} {space:?}: {error}");
        let sampled = EnvironmentMethod::Sampled { samples: 64, seed: 0 };
        let mut options = lit_by(environment.clone(), sampled, 40);
        let drawn = rendered(&field, Primitive::Sphere, &options);
        options.environment.as_mut().unwrap().method = EnvironmentMethod::Prefiltered;
        let fast = rendered(&field, Primitive::Sphere, &options);
        options.environment = None;
        options.lights = vec![Light { direction, color: [1.0; 3] }];
        options.shadows = CastShadows::Off;
        let truth = rendered(&field, Primitive::Sphere, &options);
        assert!(relative(&drawn, &truth) < 0.01, "{basis:?} {space:?}: {}", relative(&drawn, &truth));
        let error = relative(&fast, &truth);
        eprintln!("a spot, {} {space}: {:.2} %", basis.name(), 100.0 * error);
        assert!(error < if space == Space::Srgb { 0.06 } else { 0.03 }, "{basis:?} {space:?}: {error}");
    }
}

#[test]
fn a_turned_map_is_a_turned_object() {
    let one = field(&Basis::Ptm, Space::Linear);
    let one = one.with_coefficients(one.coefficients().crop(1, 1, Size::new(1, 1)).unwrap()).unwrap();
    let sky = Environment::sky(&job()).unwrap();
    for method in [EnvironmentMethod::Prefiltered, EnvironmentMethod::Sampled { samples: 4096, seed: 0 }] {
        let here = rendered(&one, Primitive::Sphere, &lit_by(sky.clone(), method, 24));
        let turned = sky.clone().adjusted(0.5 * PI, 1.0).unwrap();
        let mut options = lit_by(turned, method, 24);
        let unlike = relative(&rendered(&one, Primitive::Sphere, &options), &here);
        assert!(unlike > 0.2, "{method:?}: {unlike}");
        // What was ahead is now to the right, and the camera that was in front is now to the left.
        options.camera.azimuth_rad = -0.5 * PI;
        let error = relative(&rendered(&one, Primitive::Sphere, &options), &here);
        assert!(error < 0.01, "{method:?}: {error}");
    }
}

/// The promises of the documentation.
#[test]
fn the_prefiltered_form_is_within_two_per_cent_of_the_truth() {
    let both = &[Primitive::Sphere, Primitive::Cloth][..];
    let learned = Basis::Learned(learned_example(40, 20, 6));
    let kinds = [
        (Basis::Ptm, Space::Linear, both, 28, 1 << 13, 0.02),
        (Basis::Ptm, Space::Srgb, both, 28, 1 << 13, 0.02),
        (Basis::HSH9, Space::Linear, both, 28, 1 << 13, 0.02),
        (learned, Space::Linear, &both[..1], 14, 1 << 11, 0.02),
    ];
    let sky = Environment::sky(&job()).unwrap();
    for (basis, space, primitives, side, samples, most) in kinds {
        let field = field(&basis, space);
        for &primitive in primitives {
            let fast =
                rendered(&field, primitive, &lit_by(sky.clone(), EnvironmentMethod::Prefiltered, side));
            let sampled = EnvironmentMethod::Sampled { samples, seed: 5 };
            let truth = rendered(&field, primitive, &lit_by(sky.clone(), sampled, side));
            let error = relative(&fast, &truth);
            eprintln!("{} {space} on {}: {:.2} %", basis.name(), primitive.name(), 100.0 * error);
            assert!(error < most, "{} {space} on {}: {error}", basis.name(), primitive.name());
        }
    }
}

#[test]
fn highlights_are_those_of_the_samples() {
    let field = field(&Basis::Ptm, Space::Linear);
    let black = field.with_coefficients(Planes::zeros(field.size(), 18)).unwrap();
    let normals = normals(field.size());
    let shown = |method| {
        let mut options = lit_by(Environment::sky(&job()).unwrap(), method, 24);
        options.specular.strength = 0.5;
        render(&black, Some(&normals), &Primitive::Sphere.mesh(), &options, &job()).unwrap()
    };
    let truth = shown(EnvironmentMethod::Sampled { samples: 1 << 12, seed: 0 });
    let error = relative(&shown(EnvironmentMethod::Prefiltered), &truth);
    eprintln!("highlights: {:.2} %", 100.0 * error);
    assert!(error < 0.2, "{error}");
}

#[test]
fn lights_add_to_an_environment() {
    let field = field(&Basis::Ptm, Space::Linear);
    let sky = Environment::sky(&job()).unwrap();
    let mut options = lit_by(sky, EnvironmentMethod::Prefiltered, 16);
    let ambient = rendered(&field, Primitive::Torus, &options);
    options.lights = RenderOptions::default().lights;
    let both = rendered(&field, Primitive::Torus, &options);
    options.environment = None;
    let lamp = rendered(&field, Primitive::Torus, &options);
    for ((a, b), sum) in
        ambient.planes.as_slice().iter().zip(lamp.planes.as_slice()).zip(both.planes.as_slice())
    {
        assert!((a + b - sum).abs() < 1e-5, "{a} {b} {sum}");
    }
}

#[test]
fn samples_depend_on_the_seed_alone() {
    let field = field(&Basis::Ptm, Space::Linear);
    let sky = Environment::sky(&job()).unwrap();
    let run = |seed, threads| {
        let options = lit_by(sky.clone(), EnvironmentMethod::Sampled { samples: 16, seed }, 24);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| rendered(&field, Primitive::Sphere, &options))
    };
    let first = run(0, 1);
    assert_eq!(first, run(0, 3));
    assert_ne!(first, run(1, 1));
    let fast = |threads| {
        let options = lit_by(sky.clone(), EnvironmentMethod::Prefiltered, 24);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| rendered(&field, Primitive::Sphere, &options))
    };
    assert_eq!(fast(1), fast(3));
}

#[test]
fn maps_that_are_no_environment_are_refused_or_mended_in_a_sentence() {
    let picture = |size: Size, channels: usize, value: f32| Picture {
        planes: Planes::from_vec(size, channels, vec![value; channels * size.texels()]).unwrap(),
        space: Space::Linear,
    };
    let new = |picture: &Picture| Environment::new(picture, &job()).unwrap_err().to_string();
    assert!(new(&picture(Size::new(4, 2), 3, 0.0)).contains("black"));
    assert!(new(&picture(Size::new(4, 2), 2, 1.0)).contains("2 channels"));
    let listening = job();
    let mut odd = picture(Size::new(4, 3), 1, 1.0);
    odd.planes.as_mut_slice()[0] = -1.0;
    let environment = Environment::new(&odd, &listening).unwrap();
    assert_eq!(environment.texel(0, 0), [0.0; 3]);
    let remarks = listening.remarks().join("\n");
    assert!(remarks.contains("3 values") && remarks.contains("twice as wide"), "{remarks}");
    let sky = || Environment::sky(&job()).unwrap();
    assert!(sky().adjusted(f64::NAN, 1.0).is_err() && sky().adjusted(0.0, -1.0).is_err());
    for samples in [0, MOST_SAMPLES + 1] {
        let options = lit_by(sky(), EnvironmentMethod::Sampled { samples, seed: 0 }, 4);
        assert!(options.validate().unwrap_err().message().contains("samples"));
    }
    // The table of all frames, and the map, are foreseen.
    let field = field(&Basis::Ptm, Space::Linear);
    let small = Job::new(Limits { max_bytes: 2 << 20, ..Limits::default() });
    let mut options = lit_by(constant([1.0; 3]), EnvironmentMethod::Prefiltered, 8);
    options.shadows = CastShadows::Off;
    let error = render(&field, None, &Primitive::Plane.mesh(), &options, &small).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Limit);
    assert!(error.message().contains("environment"), "{error}");
    assert_eq!(
        Environment::sky(&Job::new(Limits { max_bytes: 1 << 20, ..Limits::default() })).unwrap_err().kind(),
        ErrorKind::Limit
    );
}

#[test]
fn boundaries_that_move_between_the_lights_move_under_a_spot_as_under_a_lamp() {
    for layout in [PlaneLayout::LUMINANCE, PlaneLayout::RGB] {
        let field = shapes_example(layout);
        // In front of the texture, up and to the left.
        let (environment, light) = spot(Size::new(512, 256), (56, 96));
        assert!(light.z() > 0.5, "{light:?}");
        let found = relight_under(&field, &environment, &job()).unwrap().planes;
        let lamp = Relighter::new(&field, &job()).unwrap().relight(light).to_space(Space::Linear).planes;
        let linear = relight(&field, light).to_space(Space::Linear).planes;
        let error = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
        let (moved, faded) = (error(found.plane(0), lamp.plane(0)), error(found.plane(0), linear.plane(0)));
        assert!(moved < 0.2 * faded, "squared error {moved} to the moved picture, {faded} to the faded one");
    }
}
