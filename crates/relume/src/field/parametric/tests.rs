use super::examples::all;
use super::*;
use crate::direction::Direction;

#[test]
fn pictures_are_the_values_of_their_texels_and_planes_have_distinct_names() {
    let directions =
        Directions { light: Direction::from_angles(0.6, 1.0), view: Direction::from_angles(0.5, -2.0) };
    for field in all() {
        let picture = field.picture(directions, &Job::default()).unwrap();
        assert_eq!((picture.size(), picture.space), (field.size(), field.model().space()));
        for (x, y) in [(0, 0), (4, 2), (1, 1)] {
            let values = field.evaluate(x, y, directions);
            assert_eq!(values.len(), field.channels());
            let shown: Vec<f32> = (0..field.channels()).map(|c| picture.planes.at(c, x, y)).collect();
            assert_eq!(shown, values);
        }
        let mut names = field.plane_names();
        assert_eq!(names.len(), field.planes().count());
        names.sort();
        names.dedup();
        assert_eq!(names.len(), field.planes().count(), "{names:?}");
    }
}

#[test]
fn a_measured_view_is_its_own_function_and_others_are_means() {
    for field in all() {
        let TexelModel::PerView(model) = field.model() else { continue };
        let light = Direction::from_angles(0.4, 0.3);
        let value = |view| f64::from(field.evaluate(2, 1, Directions { light, view })[0]);
        let own = value(model.views()[2]);
        let other = value(model.views()[0]);
        // Halfway along an edge of the triangles in the stereographic projection, near halfway on the sphere.
        let [a, b] = [0, 2].map(|i| model.views()[i].to_array());
        let view = Direction::new(a[0] + b[0], a[1] + b[1], a[2] + b[2]).unwrap();
        let between = value(view);
        assert!(between > own.min(other) && between < own.max(other), "{own} {between} {other}");
    }
}

#[test]
fn functions_seen_from_above_are_those_of_the_models() {
    let job = Job::default();
    for field in all() {
        let Some(above) = field.from_above(&job).unwrap() else {
            let name = field.model().name();
            assert!(name == "ggx" || name.contains("lafortune"), "{name}");
            continue;
        };
        let light = Direction::from_angles(0.7, 2.0);
        for (x, y) in [(0, 0), (4, 2), (2, 1)] {
            let (a, b) = (field.evaluate(x, y, light), above.value(x, y, light));
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} {b:?}");
        }
    }
}

#[test]
fn fields_that_do_not_fit_are_refused_in_a_sentence() {
    let lobes = |lobes, channels, planes: usize| {
        let planes = Planes::zeros(Size::new(2, 2), planes);
        ParametricField::new(TexelModel::Lafortune { lobes }, channels, planes).unwrap_err().to_string()
    };
    assert!(lobes(0, 3, 3).contains("1 to 3 lobes"), "{}", lobes(0, 3, 3));
    assert!(lobes(9, 3, 66).contains("1 to 3 lobes"));
    assert!(lobes(1, 2, 7).contains("not 2"));
    assert!(lobes(1, 3, 9).contains("has 10 planes, found 9"));
    let mut planes = Planes::zeros(Size::new(2, 2), 7);
    planes.plane_mut(5)[3] = f32::NAN;
    let error = ParametricField::new(TexelModel::Ggx, 3, planes).unwrap_err().to_string();
    assert!(error.contains("roughness of texel (1, 1) is NaN"), "{error}");
    let views = |views: &[Direction], function| PerViewModel::new(views, function).unwrap_err().to_string();
    let up = Direction::ZENITH;
    assert!(views(&[], ViewFunction::Lobes(1)).contains("of 0"));
    assert!(views(&[up, up], ViewFunction::Lobes(1)).contains("given twice"));
    assert!(views(&[up], ViewFunction::Lobes(0)).contains("at least one lobe"));
    assert!(views(&[up], ViewFunction::Lobes(7)).contains("at most 3"));
    let products = |lights: &[Direction], products| {
        SeparableModel::new(&[up], lights, products, Space::Srgb).unwrap_err().to_string()
    };
    assert!(products(&[up], 0).contains("1 to 16 products, not of 0"));
    assert!(products(&[up], 17).contains("not of 17"));
    assert!(products(&[], 1).contains("lights, not of 0"));
    assert!(products(&[up, up], 1).contains("the light (0, 0, 1) is given twice"));
    let many: Vec<Direction> = (0..3000).map(|i| Direction::from_angles(1.0, 1e-3 * f64::from(i))).collect();
    assert!(products(&many, 8).contains("more than 65536"));
}

#[test]
fn a_separable_texel_is_the_sum_of_its_products() {
    let angles = |polar, azimuth| Direction::from_angles(polar, azimuth);
    let (views, lights) =
        ([angles(0.0, 0.0), angles(0.6, 2.0)], [angles(0.3, 0.0), angles(0.5, 3.0), angles(0.7, 5.0)]);
    let model = TexelModel::Separable(SeparableModel::new(&views, &lights, 2, Space::Srgb).unwrap());
    // Of each product two views, then three lights of each channel.
    let numbers: Vec<f32> = (0..22).map(|k| k as f32).collect();
    let field =
        ParametricField::new(model, 3, Planes::from_vec(Size::new(1, 1), 22, numbers).unwrap()).unwrap();
    for (v, view) in views.into_iter().enumerate() {
        for (l, light) in lights.into_iter().enumerate() {
            let of = |c: usize| v * (2 + 3 * c + l) + (11 + v) * (13 + 3 * c + l);
            let truth: Vec<f32> = (0..3).map(|c| of(c) as f32).collect();
            assert_eq!(field.evaluate(0, 0, Directions { light, view }), truth);
        }
    }
    let halfway = Directions { light: lights[0], view: angles(2.0 * (0.5 * (0.3f64).tan()).atan(), 2.0) };
    let ends = [0, 1].map(|v| field.evaluate(0, 0, Directions { light: lights[0], view: views[v] })[1]);
    let between = field.evaluate(0, 0, halfway)[1];
    assert!((between - 0.5 * (ends[0] + ends[1])).abs() < 1.0 && between != ends[0], "{between} {ends:?}");
}
