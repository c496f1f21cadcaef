use super::*;
use crate::limits::Limits;
use crate::numeric::random::{Purpose, Stream};
use crate::raster::Samples;

/// Lights on three rings.
fn lights(count: usize) -> Vec<(String, Direction)> {
    let light = |i: usize| Direction::from_angles(0.3 + 0.25 * (i % 3) as f64, 2.4 * i as f64);
    (0..count).map(|i| (format!("{i}.exr"), light(i))).collect()
}

/// Texels with known normals and albedo, and their photographs; on request every fifth value of each is
/// corrupted by a shadow or a highlight.
struct Planted {
    size: Size,
    normals: Vec<Direction>,
    albedo: Vec<[f32; 3]>,
    photographs: Vec<Raster>,
}

fn planted(size: Size, lights: &[(String, Direction)], ambient: f64, spoilt: bool) -> Planted {
    let mut stream = Stream::new(3, Purpose::Sample, [1]);
    let normals: Vec<Direction> = (0..size.texels())
        .map(|_| Direction::from_angles(0.6 * stream.unit(), 6.25 * stream.unit()))
        .collect();
    let albedo: Vec<[f32; 3]> =
        (0..size.texels()).map(|_| [0; 3].map(|_| 0.2 + 0.7 * stream.unit() as f32)).collect();
    let photograph = |(k, (_, light)): (usize, &(String, Direction))| {
        let value = |i: usize| {
            let (texel, c) = (i / 3, i % 3);
            let shading = light.dot(normals[texel]).max(0.0) + ambient;
            let matt = f64::from(albedo[texel][c]) * shading;
            match (texel + k) % 10 {
                0 if spoilt => 0.0,
                5 if spoilt => matt + 0.8,
                _ => matt,
            }
        };
        let samples = (0..3 * size.texels()).map(|i| value(i) as f32).collect();
        Raster::new(size, 3, Samples::F32(samples)).unwrap()
    };
    let photographs = lights.iter().enumerate().map(photograph).collect();
    Planted { size, normals, albedo, photographs }
}

fn run(
    planted: &Planted,
    lights: &[(String, Direction)],
    options: StereoOptions,
    job: Job,
) -> Result<Stereo> {
    let load = |i: usize| Ok(planted.photographs[i].clone());
    photometric_stereo(StereoInput { lights, lamps: None, load: &load }, &options, &job)
}

/// The largest angle in degrees and the largest error of albedo.
fn errors(planted: &Planted, found: &Stereo) -> (f64, f32) {
    let texels = 0..planted.size.texels();
    let angle = |t: usize| {
        let n = [0, 1, 2].map(|k| f64::from(found.normals.plane(k)[t]));
        let n = Direction::new(n[0], n[1], n[2]).unwrap();
        n.dot(planted.normals[t]).clamp(-1.0, 1.0).acos().to_degrees()
    };
    let off = |t: usize| {
        let each = (0..3).map(|c| (found.albedo.planes.plane(c)[t] - planted.albedo[t][c]).abs());
        each.fold(0.0, f32::max)
    };
    (texels.clone().map(angle).fold(0.0, f64::max), texels.map(off).fold(0.0, f32::max))
}

#[test]
fn planted_normals_and_colours_are_found_by_every_estimator() {
    let lights = lights(12);
    let planted = planted(Size::new(7, 5), &lights, 0.0, false);
    use Estimator::{Cauchy, LeastSquares, Robust, Shared, Trimmed};
    for estimator in [LeastSquares, Trimmed, Robust, Cauchy, Shared] {
        let options = StereoOptions { estimator, ..StereoOptions::default() };
        let found = run(&planted, &lights, options, Job::default()).unwrap();
        let (angle, albedo) = errors(&planted, &found);
        assert!(angle < 0.1 && albedo < 1e-4, "{estimator:?} {angle} {albedo}");
        assert!(found.determined.iter().all(|determined| *determined));
    }
}

#[test]
fn shadows_and_highlights_are_seen_through_and_mislead_least_squares() {
    let lights = lights(30);
    let planted = planted(Size::new(9, 6), &lights, 0.0, true);
    let with = |estimator| {
        let options = StereoOptions { estimator, ..StereoOptions::default() };
        errors(&planted, &run(&planted, &lights, options, Job::default()).unwrap()).0
    };
    assert!(with(Estimator::Robust) < 0.5, "{}", with(Estimator::Robust));
    assert!(with(Estimator::Cauchy) < 2.0, "{}", with(Estimator::Cauchy));
    assert!(with(Estimator::LeastSquares) > 5.0);
}

#[test]
fn a_constant_light_is_estimated_where_asked() {
    let lights = lights(15);
    let planted = planted(Size::new(5, 4), &lights, 0.15, false);
    let with = |ambient| {
        let options = StereoOptions { ambient, ..StereoOptions::default() };
        errors(&planted, &run(&planted, &lights, options, Job::default()).unwrap())
    };
    let (angle, albedo) = with(Ambient::Constant);
    assert!(angle < 0.1 && albedo < 1e-3, "{angle} {albedo}");
    assert!(with(Ambient::None).0 > 1.0);
}

#[test]
fn near_lamps_light_every_texel_from_its_own_direction() {
    let size = Size::new(40, 30);
    let place = |i: usize| {
        let (sin, cos) = (0.7 * i as f64).sin_cos();
        [40.0 * cos, 40.0 * sin, 60.0 + 4.0 * (i % 3) as f64]
    };
    let lamps = LampPositions::new((0..9).map(place).collect(), (40, 30), 80.0).unwrap();
    let normal = Direction::from_angles(0.2, 1.0).to_array();
    let photograph = |k: usize| {
        let value = |i: usize| {
            let (light, share) = lamps.at(k, i % 40, i / 40);
            (0.5 * share * light.iter().zip(normal).map(|(l, n)| l * n).sum::<f64>()) as f32
        };
        Raster::new(size, 1, Samples::F32((0..size.texels()).map(value).collect())).unwrap()
    };
    let load = |k: usize| Ok(photograph(k));
    let lights: Vec<_> = (0..9).map(|k| (k.to_string(), lamps.direction(k))).collect();
    let with = |lamps| {
        let input = StereoInput { lights: &lights, lamps, load: &load };
        let options = StereoOptions { estimator: Estimator::LeastSquares, ..StereoOptions::default() };
        let found = photometric_stereo(input, &options, &Job::default()).unwrap();
        let off = |i: usize| {
            let cosine: f64 = (0..3).map(|k| f64::from(found.normals.plane(k)[i]) * normal[k]).sum();
            cosine.clamp(-1.0, 1.0).acos().to_degrees()
        };
        ((0..size.texels()).map(off).fold(0.0, f64::max), found.albedo.planes.plane(0)[0])
    };
    let (near, albedo) = with(Some(&lamps));
    assert!(near < 0.05 && (albedo - 0.5).abs() < 1e-3, "{near} {albedo}");
    assert!(with(None).0 > 5.0);
}

#[test]
fn bands_and_threads_change_nothing() {
    let lights = lights(8);
    let planted = planted(Size::new(6, 11), &lights, 0.0, true);
    let whole = run(&planted, &lights, StereoOptions::default(), Job::default()).unwrap();
    // The result, and twice the bytes of two rows of eight photographs in three channels.
    let solved = (2 * size_of::<Solved>() + 4 * 6) * 6 * 11;
    let max_bytes = (solved + 2 * 2 * 6 * 8 * 3 * 4) as u64;
    let tight = Job::new(Limits { max_bytes, ..Limits::default() });
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(whole, pool.install(|| run(&planted, &lights, StereoOptions::default(), tight)).unwrap());
}

#[test]
fn what_is_no_stereo_is_refused() {
    let all = lights(9);
    let planted = planted(Size::new(3, 3), &all, 0.0, false);
    let refused = |lights: &[(String, Direction)], ambient| {
        let options = StereoOptions { ambient, ..StereoOptions::default() };
        run(&planted, lights, options, Job::default()).unwrap_err().to_string()
    };
    assert!(refused(&all[..2], Ambient::None).contains("at least 3 lights"));
    assert!(refused(&all[..3], Ambient::Constant).contains("at least 4 lights"));
    let arc: Vec<_> =
        (0..9).map(|i| (String::new(), Direction::from_angles(0.1 * f64::from(i) - 0.4, 0.0))).collect();
    assert!(refused(&arc, Ambient::None).contains("in one plane"));
    let small = Raster::new(Size::new(1, 1), 3, Samples::F32(vec![0.0; 3])).unwrap();
    let load = |i: usize| Ok(if i == 4 { small.clone() } else { planted.photographs[i].clone() });
    let with = |load| StereoInput { lights: &all, lamps: None, load };
    let odd = photometric_stereo(with(&load), &StereoOptions::default(), &Job::default());
    assert!(odd.unwrap_err().to_string().contains("4.exr"));
    let black = |_: usize| Ok(small.clone());
    let found = photometric_stereo(with(&black), &StereoOptions::default(), &Job::default());
    assert_eq!(found.unwrap().determined.iter().filter(|determined| !**determined).count(), 1);
}
