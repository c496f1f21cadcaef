use super::*;
use crate::capture::dome::lights;
use crate::capture::dome::mirror_balls::BallStrip;
use crate::limits::Limits;
use crate::picture::Picture;
use crate::raster::{Raster, Samples};

/// Photographs of a plain with a grain, with balls beside it, as 8-bit files would hold them.
fn photographs(size: Size, balls: usize, lamps: &[Direction]) -> (BallStrip, Vec<Raster>) {
    let strip = BallStrip::new(size, balls).unwrap();
    let grain = |i: usize| 0.2 + 0.1 * ((i * 7919 % 101) as f32 / 101.0);
    let photograph = |lamp: &Direction| {
        let values = (0..size.texels()).map(|i| grain(i) * lamp.z() as f32).collect();
        let plain = Picture { planes: Planes::from_vec(size, 1, values).unwrap(), space: Space::Linear };
        stored(&strip.beside(&plain, *lamp, 0.02))
    };
    let taken = lamps.iter().map(photograph).collect();
    (strip, taken)
}

fn stored(picture: &Picture) -> Raster {
    let code = |v: &f32| (255.0 * Space::Linear.to_srgb(*v).clamp(0.0, 1.0)).round() as u8;
    let codes = picture.planes.plane(0).iter().map(code).collect();
    Raster::new(picture.size(), 1, Samples::U8(codes)).unwrap()
}

fn names(count: usize) -> Vec<String> {
    (0..count).map(|i| format!("{i}.png")).collect()
}

/// The mean and largest angle to the true directions in degrees.
fn errors(found: &BallLights, lamps: &[Direction]) -> (f64, f64) {
    let off = |(frame, lamp): (&BallFrame, &Direction)| {
        let [x, y, z] = frame.direction.unwrap();
        Direction::new(x, y, z).unwrap().dot(*lamp).clamp(-1.0, 1.0).acos().to_degrees()
    };
    let all: Vec<f64> = found.frames.iter().zip(lamps).map(off).collect();
    (all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max))
}

#[test]
fn a_given_ball_shows_every_lamp_to_a_fraction_of_a_degree() {
    let lamps = lights(15);
    let (strip, taken) = photographs(Size::new(240, 150), 1, &lamps);
    let load = |i: usize| Ok(taken[i].clone());
    let found = lights_of(&names(15), &load, strip.balls(), &Job::default()).unwrap();
    let (mean, most) = errors(&found, &lamps);
    assert!(mean < 0.25 && most < 0.6, "{mean} {most}");
    assert!(found.refuse_problems().is_ok());
    assert!(found.frames.iter().all(|frame| frame.position.is_none()));
    assert_eq!(found.lights().len(), 15);
}

#[test]
fn balls_are_found_by_themselves() {
    let lamps = lights(12);
    for count in [1, 2] {
        let (strip, taken) = photographs(Size::new(260, 200), count, &lamps);
        let load = |i: usize| Ok(taken[i].clone());
        let found = find_lights(&names(12), &load, &Job::default()).unwrap();
        assert_eq!(found.balls.len(), count, "{:?}", found.balls);
        for ball in strip.balls() {
            let off = |b: &MirrorBall| {
                (b.x - ball.x).abs().max((b.y - ball.y).abs()).max((b.radius - ball.radius).abs())
            };
            let nearest = found.balls.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.02 * ball.radius, "{ball:?} {:?}", found.balls);
        }
        let (mean, most) = errors(&found, &lamps);
        assert!(mean < 1.0 && most < 2.5, "{count} balls: {mean} {most}");
    }
}

#[test]
fn a_glossy_surface_beside_the_ball_is_not_taken_for_one() {
    // A round spot whose gloss moves against the lamp, beside a real ball.
    let lamps = lights(10);
    let (strip, taken) = photographs(Size::new(200, 150), 1, &lamps);
    let size = taken[0].size();
    let with_spot = |(raster, lamp): (&Raster, &Direction)| {
        let Samples::U8(codes) = raster.samples() else { panic!("8 bits were made") };
        let mut codes = codes.clone();
        for (i, code) in codes.iter_mut().enumerate() {
            let (x, y) = ((i % size.width) as f64 - 80.0, (i / size.width) as f64 - 70.0);
            let gloss = (x + 15.0 * lamp.x()).hypot(y - 15.0 * lamp.y());
            if x.hypot(y) < 25.0 {
                *code = if gloss < 2.0 { 255 } else { 5 };
            }
        }
        Raster::new(size, 1, Samples::U8(codes)).unwrap()
    };
    let spotted: Vec<Raster> = taken.iter().zip(&lamps).map(with_spot).collect();
    let found = find_lights(&names(10), &|i| Ok(spotted[i].clone()), &Job::default()).unwrap();
    assert_eq!(found.balls.len(), 1, "{:?}", found.balls);
    assert!((found.balls[0].x - strip.balls()[0].x).abs() < 1.0, "{:?}", found.balls);
}

#[test]
fn the_reflected_direction_is_that_of_the_formula_and_its_mirror_image() {
    for light in lights(20) {
        let half = Direction::new(light.x(), light.y(), light.z() + 1.0).unwrap();
        assert!(reflected(half.to_array()).dot(light) > 1.0 - 1e-12);
    }
}

#[test]
fn rays_of_two_balls_meet_at_the_lamp() {
    let size = Size::new(400, 300);
    let balls =
        [MirrorBall { x: 40.0, y: 150.0, radius: 30.0 }, MirrorBall { x: 360.0, y: 200.0, radius: 30.0 }];
    let lamp = [150.0, -80.0, 700.0];
    let ray = |ball: &MirrorBall| {
        // The normal that mirrors the lamp, by fixed-point iteration.
        let mut normal = [0.0, 0.0, 1.0];
        for _ in 0..50 {
            let at = [
                ball.x + normal[0] * 30.0 - 200.0,
                150.0 - ball.y + normal[1] * 30.0,
                30.0 + normal[2] * 30.0,
            ];
            let to = Direction::new(lamp[0] - at[0], lamp[1] - at[1], lamp[2] - at[2]).unwrap();
            normal = Direction::new(to.x(), to.y(), to.z() + 1.0).unwrap().to_array();
        }
        (rays::Reflection::new(ball, normal), reflected(normal))
    };
    let found = rays::meet(&balls.iter().map(ray).collect::<Vec<_>>(), size).unwrap();
    assert!(found.iter().zip(lamp).all(|(a, b)| (a - b).abs() < 0.1), "{found:?}");
    let parallel = [ray(&balls[0]), (rays::Reflection::new(&balls[1], [0.0, 0.0, 1.0]), ray(&balls[0]).1)];
    assert!(rays::meet(&parallel, size).is_none());
}

#[test]
fn a_frame_without_a_highlight_is_named() {
    let lamps = lights(8);
    let (strip, mut taken) = photographs(Size::new(200, 120), 1, &lamps);
    let size = taken[0].size();
    taken[5] = Raster::new(size, 1, Samples::U8(vec![0; size.texels()])).unwrap();
    taken[6] = Raster::new(size, 1, Samples::U8(vec![255; size.texels()])).unwrap();
    let load = |i: usize| Ok(taken[i].clone());
    let found = lights_of(&names(8), &load, strip.balls(), &Job::default()).unwrap();
    let text = found.refuse_problems().unwrap_err().to_string();
    assert!(text.contains("2 of 8 photographs") && text.contains("5.png has no highlight"), "{text}");
    assert!(text.contains("6.png"), "{text}");
    assert_eq!(found.lights().len(), 6);
}

#[test]
fn a_lamp_below_the_surface_is_said() {
    let size = Size::new(100, 100);
    let ball = MirrorBall { x: 50.0, y: 50.0, radius: 40.0 };
    let mut codes = vec![2u8; size.texels()];
    for (x, y) in [(84, 50), (85, 50), (84, 51), (85, 51)] {
        codes[size.index(x, y)] = 255;
    }
    let raster = Raster::new(size, 1, Samples::U8(codes)).unwrap();
    let load = |_: usize| Ok(raster.clone());
    let found = lights_of(&names(1), &load, &[ball], &Job::default()).unwrap();
    assert_eq!(found.frames[0].problem.as_deref(), Some("shows its lamp below the surface"));
}

#[test]
fn balls_outside_other_sizes_and_pictures_without_balls_are_refused() {
    let size = Size::new(120, 90);
    let plain = Raster::new(size, 1, Samples::U8(vec![80; size.texels()])).unwrap();
    let load = |_: usize| Ok(plain.clone());
    let refused =
        |ball: MirrorBall| lights_of(&names(2), &load, &[ball], &Job::default()).unwrap_err().to_string();
    assert!(refused(MirrorBall { x: 300.0, y: 40.0, radius: 20.0 }).contains("not inside"));
    assert!(refused(MirrorBall { x: 40.0, y: 40.0, radius: 1.0 }).contains("at least 4"));
    let none = find_lights(&names(2), &load, &Job::default()).unwrap_err().to_string();
    assert!(none.contains("no mirror ball was found"), "{none}");
    assert!(find_lights(&[], &load, &Job::default()).is_err());
    let small = Raster::new(Size::new(9, 9), 1, Samples::U8(vec![0; 81])).unwrap();
    let mixed = |i: usize| Ok(if i == 1 { small.clone() } else { plain.clone() });
    let text = find_lights(&names(2), &mixed, &Job::default()).unwrap_err().to_string();
    assert!(text.contains("1.png") && text.contains("same size"), "{text}");
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let lamps = lights(6);
    let (_, taken) = photographs(Size::new(160, 110), 1, &lamps);
    let load = |i: usize| Ok(taken[i].clone());
    let many = find_lights(&names(6), &load, &Job::default()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| find_lights(&names(6), &load, &Job::default())).unwrap(), many);
    let tight = Job::new(Limits { max_bytes: 1000, ..Limits::default() });
    assert!(find_lights(&names(6), &load, &tight).is_err());
}

#[test]
fn the_picture_marks_balls_and_highlights() {
    let lamps = lights(5);
    let (strip, taken) = photographs(Size::new(160, 110), 1, &lamps);
    let load = |i: usize| Ok(taken[i].clone());
    let found = lights_of(&names(5), &load, strip.balls(), &Job::default()).unwrap();
    let picture = drawn(&found, &load, &Job::default()).unwrap();
    let is_red = |i: usize| picture.planes.plane(0)[i] == 1.0 && picture.planes.plane(1)[i] < 0.2;
    assert_eq!(picture.size(), strip.size());
    assert!((0..picture.size().texels()).filter(|i| is_red(*i)).count() >= 5 * 9);
}
