use super::*;
use crate::field::Interpolated;
use crate::space::Space;

const SIZE: Size = Size { width: 24, height: 9 };

fn lights() -> Vec<Direction> {
    (0..14).map(Direction::fibonacci(14)).collect()
}

fn field_of(
    layout: PlaneLayout,
    interpolation: Interpolation,
    value: impl Fn(Direction, usize, usize) -> f32,
) -> ReflectanceField {
    let lights = lights();
    let planes = (0..layout.channels()).flat_map(|c| lights.iter().map(move |light| (c, *light)));
    let texels = |(_, light)| (0..SIZE.texels()).map(move |t| (light, t % SIZE.width, t / SIZE.width));
    let data = planes.flat_map(texels).map(|(light, x, y)| value(light, x, y)).collect();
    let basis = Basis::Interpolated(Interpolated::new(&lights, interpolation).unwrap());
    let planes = Planes::from_vec(SIZE, lights.len() * layout.channels(), data).unwrap();
    ReflectanceField::new(basis, layout, Space::Srgb, planes).unwrap()
}

/// A field whose shadow moves between the lights.
pub(crate) fn shapes_example(layout: PlaneLayout) -> ReflectanceField {
    field_of(layout, Interpolation::Shapes, behind_a_wall)
}

/// A wall left of the texels that is higher than the picture is wide: its shadow ends where the light passes over it.
fn behind_a_wall(light: Direction, x: usize, _: usize) -> f32 {
    let is_dark = light.x() < 0.0 && (x as f64) < 6.0 * -light.x() / light.z();
    if is_dark { 0.05 } else { Space::Srgb.from_linear(0.7 * light.z() as f32) }
}

#[test]
fn pictures_are_those_of_the_values_of_texels() {
    for layout in [PlaneLayout::LUMINANCE, PlaneLayout::RGB] {
        let field = shapes_example(layout);
        let shapes = Shapes::of(&field, &Job::default()).unwrap().unwrap();
        let light = Direction::from_angles(0.6, 2.9);
        let mut picture = Planes::zeros(SIZE, field.layout().channels());
        shapes.correct(light, &mut picture);
        assert!(picture.as_slice().iter().any(|v| v.abs() > 0.01), "nothing moved");
        for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
            let (truth, linear) = (shapes.value(x, y, light), field.values(x, y, light));
            for c in 0..picture.count() {
                assert!((picture.at(c, x, y) - (truth[c] - linear[c])).abs() < 1e-6, "({x}, {y})");
            }
        }
    }
}

#[test]
fn corrections_of_looked_up_texels_are_those_of_pictures() {
    for layout in [PlaneLayout::LUMINANCE, PlaneLayout::RGB] {
        let field = shapes_example(layout);
        let shapes = Shapes::of(&field, &Job::default()).unwrap().unwrap();
        let (light, lookup) = (Direction::from_angles(0.6, 2.9), shapes.lookup());
        let (weights, mut numbers) = (field.basis().weights(light), vec![0.0; lookup.len()]);
        let mut picture = Planes::zeros(SIZE, field.layout().channels());
        shapes.correct(light, &mut picture);
        for texel in 0..SIZE.texels() {
            shapes.numbers_into(texel, &mut numbers);
            let found = lookup.corrections(&numbers, &weights, light, 1.0);
            for (c, plane) in picture.iter().enumerate() {
                assert!(
                    (plane[texel] - found[c]).abs() < 1e-5,
                    "texel {texel}: {} and {}",
                    plane[texel],
                    found[c]
                );
            }
        }
    }
}

/// From afar a patch holds shadow and light, and fades from one to the other.
#[test]
fn corrections_vanish_where_patches_are_wider_than_the_reach_of_distances() {
    let field = shapes_example(PlaneLayout::LUMINANCE);
    let shapes = Shapes::of(&field, &Job::default()).unwrap().unwrap();
    let (light, lookup) = (Direction::from_angles(0.6, 2.9), shapes.lookup());
    let (weights, mut numbers) = (field.basis().weights(light), vec![0.0; lookup.len()]);
    let mut most = |footprint: f64| {
        let of_texel = |texel| {
            shapes.numbers_into(texel, &mut numbers);
            lookup.corrections(&numbers, &weights, light, footprint)[0].abs()
        };
        (0..SIZE.texels()).map(of_texel).fold(0.0, f32::max)
    };
    let (near, far) = (most(1.0), most(200.0));
    assert!(near > 0.05 && far < 0.02 * near, "{near} near and {far} from afar");
    assert!(most(f64::INFINITY).is_finite());
}

#[test]
fn photographs_are_kept_under_their_own_lights() {
    let field = shapes_example(PlaneLayout::LUMINANCE);
    let shapes = Shapes::of(&field, &Job::default()).unwrap().unwrap();
    for light in lights() {
        let mut picture = Planes::zeros(SIZE, 1);
        shapes.correct(light, &mut picture);
        assert!(picture.as_slice().iter().all(|v| v.abs() < 1e-4), "{light:?}");
    }
}

/// The promise of the model: a shadow between those of two lights is nearer to the truth than two half shadows.
#[test]
fn a_shadow_moves_between_the_lights() {
    let field = shapes_example(PlaneLayout::LUMINANCE);
    let shapes = Shapes::of(&field, &Job::default()).unwrap().unwrap();
    let (mut linear, mut moved) = (0.0, 0.0);
    for i in 0..20 {
        let light = Direction::from_angles(0.5 + 0.03 * f64::from(i), 2.6 + 0.05 * f64::from(i));
        for x in 0..SIZE.width {
            let truth = behind_a_wall(light, x, 4);
            linear += (field.value(x, 4, light)[0] - truth).powi(2);
            moved += (shapes.value(x, 4, light)[0] - truth).powi(2);
        }
    }
    assert!(moved < 0.85 * linear, "squared error {moved} with moved boundaries and {linear} without");
}

#[test]
fn a_matt_surface_has_no_boundaries() {
    let field = field_of(PlaneLayout::RGB, Interpolation::Shapes, |light, _, _| {
        Space::Srgb.from_linear(0.7 * light.z() as f32)
    });
    let shapes = Shapes::of(&field, &Job::default()).unwrap().unwrap();
    let mut picture = Planes::zeros(SIZE, 3);
    shapes.correct(Direction::from_angles(0.9, 0.3), &mut picture);
    assert!(picture.as_slice().iter().all(|v| *v == 0.0));
}

#[test]
fn other_bases_have_no_shapes() {
    let field = field_of(PlaneLayout::LUMINANCE, Interpolation::RadialBasis, behind_a_wall);
    assert!(Shapes::of(&field, &Job::default()).unwrap().is_none());
}
