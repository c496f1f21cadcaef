use super::*;
use crate::capture::dome::lights;
use crate::direction::Direction;
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};

fn named_lights(count: usize) -> Vec<(String, Direction)> {
    lights(count).into_iter().enumerate().map(|(i, light)| (format!("{i}.png"), light)).collect()
}

/// Photographs of matt texels with random normals, 16 bits in the given space, each with an exposure.
fn matt(
    size: Size,
    lights: &[(String, Direction)],
    space: Space,
    exposure: &dyn Fn(usize) -> f64,
) -> Vec<Raster> {
    glossy(size, lights, space, 0.0, exposure)
}

/// As [`matt`], under a coat that reflects the lights with a strength.
fn glossy(
    size: Size,
    lights: &[(String, Direction)],
    space: Space,
    strength: f64,
    exposure: &dyn Fn(usize) -> f64,
) -> Vec<Raster> {
    let mut stream = Stream::new(11, Purpose::Sample, [4]);
    let texels: Vec<(Direction, f64)> = (0..size.texels())
        .map(|_| {
            let normal = Direction::from_angles(0.7 * stream.unit(), 6.2 * stream.unit());
            (normal, 0.2 + 0.5 * stream.unit())
        })
        .collect();
    let photograph = |(k, (_, light)): (usize, &(String, Direction))| {
        let code = |(normal, albedo): &(Direction, f64)| {
            let [x, y, z] = light.to_array();
            let half = Direction::new(x, y, z + 1.0).unwrap();
            let highlight = strength * normal.dot(half).max(0.0).powi(30);
            let value = ((albedo * normal.dot(*light).max(0.0) + highlight) * exposure(k)) as f32;
            (space.from_linear(value).clamp(0.0, 1.0) * 65535.0).round() as u16
        };
        Raster::new(size, 1, Samples::U16(texels.iter().map(code).collect())).unwrap()
    };
    lights.iter().enumerate().map(photograph).collect()
}

#[test]
fn a_development_without_steps_leaves_photographs_as_they_are() {
    let size = Size::new(5, 4);
    let photograph = Raster::new(size, 1, Samples::U8((0..20).collect())).unwrap();
    let idle = Development::default();
    assert_eq!(idle.apply(3, photograph.clone()).unwrap(), photograph);
    let part = Development { crop: Some(Rect::new(1, 2, Size::new(3, 2))), ..idle };
    assert_eq!(part.apply(0, photograph.clone()).unwrap(), photograph.crop(1, 2, Size::new(3, 2)).unwrap());
    assert_eq!(part.size_of(size).unwrap(), Size::new(3, 2));
    let too_small = Development { reduction: 3, ..part };
    assert!(too_small.size_of(size).unwrap_err().to_string().contains("nothing would be left"));
}

#[test]
fn both_readings_are_compared_and_the_right_one_is_clearly_better() {
    let lights = named_lights(16);
    for space in [Space::Linear, Space::Srgb] {
        let photographs = matt(Size::new(20, 20), &lights, space, &|_| 1.0);
        let sample = sample_texels(&lights, &|i| Ok(photographs[i].clone()), None, &Job::default()).unwrap();
        let check = check_reading(&sample).unwrap();
        assert_eq!((check.better(), check.is_clear()), (space, true), "{check:?}");
        let other = if space == Space::Linear { Space::Srgb } else { Space::Linear };
        assert!(check.warning(other).unwrap().contains("--input-space"));
        assert!(check.warning(space).is_none());
    }
    let few = named_lights(4);
    let photographs = matt(Size::new(20, 20), &few, Space::Srgb, &|_| 1.0);
    let sample = sample_texels(&few, &|i| Ok(photographs[i].clone()), None, &Job::default()).unwrap();
    assert!(check_reading(&sample).is_none());
}

#[test]
fn planted_exposures_are_found_and_undone() {
    let lights = named_lights(18);
    let exposure = |k: usize| if k % 5 == 2 { 0.5 } else { 1.0 + 0.02 * k as f64 };
    let photographs = matt(Size::new(24, 24), &lights, Space::Linear, &exposure);
    let sample = sample_texels(&lights, &|i| Ok(photographs[i].clone()), None, &Job::default()).unwrap();
    let found = exposures(&sample).unwrap().gains;
    let products: Vec<f64> = found.iter().enumerate().map(|(k, g)| g * exposure(k)).collect();
    let mean = products.iter().sum::<f64>() / products.len() as f64;
    assert!(products.iter().all(|p| (p / mean - 1.0).abs() < 0.03), "{products:?}");
    let undone = Development { space: Some(Space::Linear), gains: found.clone(), ..Development::default() };
    let first = undone.apply(2, photographs[2].clone()).unwrap();
    let expected = f64::from(photographs[2].samples().value(7)) * found[2];
    assert!((f64::from(first.samples().value(7)) - expected).abs() < 1e-6);
}

/// A fault: highlights passed for exposures, and photographs of one exposure were multiplied by factors up to 8.
#[test]
fn highlights_are_no_exposures() {
    let lights = named_lights(40);
    for changed in [1.0, 0.6] {
        let exposure = |k: usize| if k % 4 == 1 { changed } else { 1.0 };
        let photographs = glossy(Size::new(24, 24), &lights, Space::Linear, 0.25, &exposure);
        let sample = sample_texels(&lights, &|i| Ok(photographs[i].clone()), None, &Job::default()).unwrap();
        let found = exposures(&sample).unwrap().gains;
        let errors: Vec<f64> = found.iter().enumerate().map(|(k, g)| (g * exposure(k)).ln()).collect();
        let mean = errors.iter().sum::<f64>() / 40.0;
        let rms = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 40.0).sqrt();
        assert!(rms < 0.05, "{rms}: {found:?}");
        let share = share_by_direction(&lights, &found).unwrap();
        assert!(changed == 1.0 || share < 0.5, "{share}");
    }
}

/// A fault: a photograph of which shadows cover the greater part was made four times as bright.
#[test]
fn shadows_are_no_exposures() {
    let (size, lights) = (Size::new(24, 24), named_lights(24));
    let mut photographs = matt(size, &lights, Space::Linear, &|k| if k == 3 { 0.6 } else { 1.0 });
    let Samples::U16(codes) = photographs[5].samples() else { panic!("16 bits") };
    // At five of six texels from a twentieth to half of the light, from other parts of the surface.
    let share = |i: usize| if i.is_multiple_of(6) { 1.0 } else { 0.05 * 1.26f64.powi(i as i32 % 11) };
    let shadowed = codes.iter().enumerate().map(|(i, code)| (f64::from(*code) * share(i)) as u16).collect();
    photographs[5] = Raster::new(size, 1, Samples::U16(shadowed)).unwrap();
    let sample = sample_texels(&lights, &|i| Ok(photographs[i].clone()), None, &Job::default()).unwrap();
    let found = exposures(&sample).unwrap();
    assert_eq!(found.untold, [5]);
    assert!(found.gains[5] < 1.1, "{:?}", found.gains);
    assert!((found.gains[3] * 0.6 - 1.0).abs() < 0.05, "{:?}", found.gains);
}

/// A mask leaves what is beside the surface, under a lamp of its own, out of the comparison.
#[test]
fn exposures_are_those_of_the_texels_that_a_mask_leaves() {
    let (size, lights) = (Size::new(24, 24), named_lights(18));
    let of_surface = matt(size, &lights, Space::Linear, &|_| 1.0);
    let beside = matt(size, &lights, Space::Linear, &|k| if k % 2 == 0 { 0.4 } else { 1.0 });
    let mask: Vec<bool> = (0..size.texels()).map(|i| i % 24 < 6).collect();
    let photograph = |k: usize| {
        let both = (of_surface[k].samples(), beside[k].samples());
        let (Samples::U16(inside), Samples::U16(outside)) = both else { panic!("16 bits") };
        let codes = (0..size.texels()).map(|i| if mask[i] { inside[i] } else { outside[i] }).collect();
        Raster::new(size, 1, Samples::U16(codes))
    };
    let found = |mask: Option<&[bool]>| {
        exposures(&sample_texels(&lights, &photograph, mask, &Job::default()).unwrap()).unwrap().gains
    };
    let off = |gains: &[f64]| gains.iter().map(|g| g.ln().abs()).fold(0.0, f64::max);
    assert!(off(&found(Some(&mask))) < 0.02 && off(&found(None)) > 0.3);
}

#[test]
fn exposures_that_follow_the_light_are_told_from_others() {
    let lights = named_lights(30);
    let by_light: Vec<f64> = lights.iter().map(|(_, light)| 1.0 / (0.3 + light.z())).collect();
    assert!(share_by_direction(&lights, &by_light).unwrap() > 0.85);
    let by_turn: Vec<f64> = (0..30).map(|k| if k % 3 == 0 { 0.7 } else { 1.1 }).collect();
    assert!(share_by_direction(&lights, &by_turn).unwrap() < 0.3);
    // On a ring x and y alone tell the lights apart; few lights, and equal gains, tell nothing.
    let ring: Vec<(String, Direction)> =
        (0..20).map(|i| (i.to_string(), Direction::from_angles(0.8, 0.31 * f64::from(i)))).collect();
    let gains: Vec<f64> = ring.iter().map(|(_, light)| 1.0 + 0.5 * light.x()).collect();
    assert!(share_by_direction(&ring, &gains).unwrap() > 0.9);
    assert_eq!(share_by_direction(&ring[..17], &gains[..17]), None);
    assert_eq!(share_by_direction(&ring, &[1.0; 20]), None);
}

#[test]
fn black_photographs_have_no_exposure() {
    let lights = named_lights(9);
    let black = Raster::new(Size::new(9, 9), 1, Samples::U8(vec![0; 81])).unwrap();
    let sample = sample_texels(&lights, &|_| Ok(black.clone()), None, &Job::default()).unwrap();
    assert!(exposures(&sample).unwrap_err().to_string().contains("too dark"));
    assert!(check_reading(&sample).is_none());
}

/// Value noise without a period: grains of paint, which do not move with the light.
fn grain(x: f64, y: f64) -> f64 {
    let (x, y) = (x / 4.3 + 50.0, y / 4.3 + 50.0);
    let (column, row) = (x.floor(), y.floor());
    let at =
        |dx: f64, dy: f64| Stream::new(1, Purpose::Sample, [(column + dx) as u64, (row + dy) as u64]).unit();
    let (s, t) = (x - column, y - row);
    (1.0 - t) * ((1.0 - s) * at(0.0, 0.0) + s * at(1.0, 0.0))
        + t * ((1.0 - s) * at(0.0, 1.0) + s * at(1.0, 1.0))
}

/// A pattern of smooth bumps at a place between pixels, under a light.
fn bumps(size: Size, [right, down]: [f64; 2], light: Direction) -> Raster {
    let value = |texel: usize| {
        let (x, y) = ((texel % size.width) as f64 - right, (texel / size.width) as f64 - down);
        let slope_x = 0.25 * (0.31 * x + 0.07 * y).cos() + 0.2 * (0.13 * x - 0.22 * y).sin();
        let slope_y = 0.25 * (0.05 * x + 0.27 * y).sin() + 0.2 * (0.19 * x + 0.11 * y).cos();
        let normal = Direction::new(slope_x, slope_y, 1.0).unwrap();
        let albedo = if grain(x, y) > 0.5 { 0.8 } else { 0.35 };
        (255.0 * albedo * normal.dot(light).max(0.0)).round() as u8
    };
    Raster::new(size, 1, Samples::U8((0..size.texels()).map(value).collect())).unwrap()
}

/// A fault: the noise of photographs without edges was moved by up to a tenth of their sides.
#[test]
fn noise_is_not_moved() {
    for size in [Size::new(48, 40), Size::new(160, 160)] {
        let noise = |k: usize| {
            let mut stream = Stream::new(k as u64, Purpose::Sample, [7]);
            let codes = (0..size.texels()).map(|_| 120 + (8.0 * stream.unit()) as u8).collect();
            Raster::new(size, 1, Samples::U8(codes))
        };
        let found = shifts(&named_lights(12), &noise, &Job::default()).unwrap();
        assert_eq!(found.untold, (0..12).collect::<Vec<usize>>());
        assert_eq!(found.shifts, [[0.0; 2]; 12]);
    }
}

#[test]
fn frames_that_moved_are_moved_back_under_changing_light() {
    let size = Size::new(96, 80);
    let lights = lights(8);
    let planted = |k: usize| [0.0, 1.3, -2.25, 0.5, 3.0, -0.75, 1.0, -1.5][k];
    let moves: Vec<[f64; 2]> = (0..8).map(|k| [planted(k), -0.5 * planted(k)]).collect();
    let frames: Vec<Raster> = (0..8).map(|k| bumps(size, moves[k], lights[k])).collect();
    let found = shifts(&named_lights(8), &|i| Ok(frames[i].clone()), &Job::default()).unwrap();
    assert!(found.untold.is_empty(), "{:?}", found.untold);
    for (found, truth) in found.shifts.iter().zip(&moves) {
        assert!((found[0] - truth[0]).hypot(found[1] - truth[1]) < 0.35, "{found:?} {truth:?}");
    }
    let still = bumps(size, [0.0; 2], lights[4]);
    let aligned = Development { shifts: moves.clone(), ..Development::default() };
    let back = aligned.apply(4, frames[4].clone()).unwrap();
    let truth = linear(&still, None);
    // Grains have hard edges, which no interpolation brings back: most texels agree.
    let inner = (10..70).flat_map(|y| (10..86).map(move |x| size.index(x, y)));
    let off: Vec<f32> = inner.map(|i| (back.samples().value(i) - truth.plane(0)[i]).abs()).collect();
    let apart = linear(&frames[4], None);
    let inner = (10..70).flat_map(|y| (10..86).map(move |x| size.index(x, y)));
    let before: Vec<f32> = inner.map(|i| (apart.plane(0)[i] - truth.plane(0)[i]).abs()).collect();
    let mean = |all: &[f32]| all.iter().sum::<f32>() / all.len() as f32;
    assert!(mean(&off) < 0.25 * mean(&before), "{} {}", mean(&off), mean(&before));
}

#[test]
fn the_white_card_the_room_and_the_lamps_are_taken_out() {
    let size = Size::new(6, 4);
    let shade = |texel: usize| 0.5 + 0.5 * (texel % 6) as f32 / 5.0;
    let values: Vec<f32> = (0..24).flat_map(|t| [0.3 * shade(t) * 2.0 + 0.1; 3]).collect();
    let photograph = Raster::new(size, 3, Samples::F32(values)).unwrap();
    let card = Planes::from_vec(size, 1, (0..24).map(|t| 0.8 * shade(t)).collect()).unwrap();
    let development = Development {
        ambient: Some(Planes::from_vec(size, 3, vec![0.1; 72]).unwrap()),
        flat: vec![std::sync::Arc::new(even_field(card).unwrap())],
        intensities: vec![[2.0; 3]],
        ..Development::default()
    };
    let developed = development.apply(0, photograph.clone()).unwrap();
    let middle = developed.samples().value(0);
    assert!((0..72).all(|i| (developed.samples().value(i) - middle).abs() < 1e-6));
    assert!((middle - 0.3 * 0.7).abs() < 1e-4, "{middle}");
    let zero = Development { intensities: vec![[1.0, 0.0, 1.0]], ..Development::default() };
    let text = zero.apply(0, photograph.clone()).unwrap_err().to_string();
    assert!(text.contains("intensity of light 1 is 0"), "{text}");
    let other = Development { ambient: Some(Planes::zeros(Size::new(2, 2), 1)), ..Development::default() };
    assert!(other.apply(0, photograph.clone()).unwrap_err().to_string().contains("both must be alike"));
    let mask = Development { mask: Some(vec![true; 5]), ..Development::default() };
    assert!(mask.apply(0, photograph).unwrap_err().to_string().contains("the mask has 5 texels"));
    assert!(even_field(Planes::zeros(size, 1)).unwrap_err().to_string().contains("black at (0, 0)"));
}

#[test]
fn a_mask_of_the_photographs_is_cropped_and_reduced_with_them() {
    let (whole, part) = (Size::new(8, 6), Size::new(4, 4));
    let development = Development {
        crop: Some(crate::rect::Rect::new(2, 1, part)),
        reduction: 2,
        ..Development::default()
    };
    // The left half of the part, and one pixel more that does not make a texel.
    let painted: Vec<bool> = (0..48).map(|i| i % 8 < 4 || i == 12).collect();
    let of_whole = development.mask_of_texels(&painted, whole, whole).unwrap();
    assert_eq!(of_whole, [true, false, true, false]);
    let cropped = development.mask_of_texels(&[false, true, true, true], Size::new(2, 2), whole).unwrap();
    assert_eq!(cropped, [false, true, true, true]);
    let text = development.mask_of_texels(&[true; 16], part, whole).unwrap_err().to_string();
    assert!(text.contains("8 x 6 of the photographs, or the 2 x 2"), "{text}");
    let nothing = development.mask_of_texels(&[false; 48], whole, whole).unwrap_err();
    assert!(nothing.kind() == crate::error::ErrorKind::Invalid, "{nothing}");
    let masked = Development { mask: Some(of_whole), ..development };
    let white = Raster::new(whole, 1, Samples::U8(vec![255; 48])).unwrap();
    let texels = masked.apply(0, white).unwrap();
    assert_eq!([0, 1, 2, 3].map(|i| texels.samples().value(i)), [1.0, 0.0, 1.0, 0.0]);
}

#[test]
fn near_lamps_are_evened_out() {
    let size = Size::new(40, 30);
    let lamps = LampPositions::new(vec![[40.0, 30.0, 80.0]], (40, 30), 100.0).unwrap();
    let value = |texel: usize| (0.2 * lamps.at(0, texel % 40, texel / 40).1) as f32;
    let photograph = Raster::new(size, 1, Samples::F32((0..1200).map(value).collect())).unwrap();
    let near = Development { lamps: Some(lamps), reduction: 2, ..Development::default() };
    let developed = near.apply(0, photograph).unwrap();
    assert_eq!(developed.size(), Size::new(20, 15));
    assert!((0..300).all(|i| (developed.samples().value(i) - 0.2).abs() < 1e-5));
    assert_eq!(near.lamps_over_texels().unwrap().mm_per_texel(), 5.0);
}

#[test]
fn a_grey_patch_becomes_grey() {
    let factors = grey_factors([2.0, 1.0, 0.5]).unwrap();
    assert_eq!(factors, [0.5, 1.0, 2.0]);
    assert!(grey_factors([0.0, 1.0, 1.0]).is_err());
}
