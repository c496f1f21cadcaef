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

/// A wall left of the texels that is higher than the picture is wide: its shadow ends where the light passes over it.
fn behind_a_wall(light: Direction, x: usize, _: usize) -> f32 {
    let is_dark = light.x() < 0.0 && (x as f64) < 6.0 * -light.x() / light.z();
    if is_dark { 0.05 } else { Space::Srgb.from_linear(0.7 * light.z() as f32) }
}

#[test]
fn pictures_are_those_of_the_values_of_texels() {
    for layout in [PlaneLayout::LUMINANCE, PlaneLayout::RGB] {
        let field = field_of(layout, Interpolation::Shapes, behind_a_wall);
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
fn photographs_are_kept_under_their_own_lights() {
    let field = field_of(PlaneLayout::LUMINANCE, Interpolation::Shapes, behind_a_wall);
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
    let field = field_of(PlaneLayout::LUMINANCE, Interpolation::Shapes, behind_a_wall);
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
