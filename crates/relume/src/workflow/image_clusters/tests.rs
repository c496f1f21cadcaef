use super::*;
use crate::direction::Direction;
use crate::random_field::{Fields, RealisationOptions};
use crate::raster::{Raster, Samples};
use crate::size::Size;

const SIZE: Size = Size { width: 48, height: 40 };

fn directions(count: usize) -> Vec<Direction> {
    (0..count).map(|i| Direction::from_angles(0.16 * i as f64, 2.4 * i as f64)).collect()
}

fn pairs() -> Vec<(String, Directions)> {
    let (lights, views) = (directions(8), directions(4));
    let pair = |i: usize| Directions { light: lights[i % 8], view: views[i / 8] };
    (0..32).map(|i| (format!("p{i}"), pair(i))).collect()
}

/// A grain that is red or blue by the view, as bright as the cosine of the light.
fn photograph((_, pair): &(String, Directions)) -> Raster {
    let mut stream = Stream::new(7, Purpose::Sample, [0]);
    let red = pair.view.z() > 0.95;
    let cosine = pair.light.z() as f32;
    let samples = (0..SIZE.texels()).flat_map(|_| {
        let grain = 0.35 + 0.3 * stream.unit() as f32;
        let dim = 0.3 * grain;
        [if red { grain } else { dim }, dim, if red { dim } else { grain }]
            .map(|v| (255.0 * v * cosine) as u8)
    });
    Raster::new(SIZE, 3, Samples::U8(samples.collect())).unwrap()
}

fn modelled(request: &ImageClusterRequest) -> Result<ImageClusterModel> {
    let pairs = pairs();
    let images: Vec<Raster> = pairs.iter().map(photograph).collect();
    model_image_clusters(&pairs, &|i| Ok(images[i].clone()), request, &Job::default())
}

fn request(clusters: usize) -> ImageClusterRequest {
    let options = ModelOptions { levels: 1, candidates: 4, coarse: 0, ..ModelOptions::default() };
    ImageClusterRequest { clusters, options, range: None, seed: 0 }
}

fn mean(planes: &crate::Planes, k: usize) -> f32 {
    planes.plane(k).iter().sum::<f32>() / planes.plane(k).len() as f32
}

#[test]
fn every_pair_has_the_colour_and_brightness_of_its_photograph() {
    let made = modelled(&request(6)).unwrap();
    assert_eq!(made.report.photographs.iter().sum::<usize>(), 32);
    assert!(made.report.table_rmse < 0.05, "{:?}", made.report);
    let options = RealisationOptions { origin: [0, 0], size: Size::new(64, 64), seed: 1, period: None };
    let field = made.model.synthesize(&options, &Job::default()).unwrap();
    for pair in &pairs() {
        let (truth, shown) =
            (photograph(pair).to_picture(Space::Srgb).planes, crate::render::relight(&field, pair.1).planes);
        for k in 0..3 {
            assert!((mean(&truth, k) - mean(&shown, k)).abs() < 0.04, "{} {k}", pair.0);
        }
    }
}

#[test]
fn the_picture_of_a_pair_is_that_of_the_whole_texture() {
    let made = modelled(&request(5)).unwrap();
    let job = Job::default();
    let options = RealisationOptions { origin: [-9, 30], size: Size::new(20, 10), seed: 3, period: None };
    let field = made.model.synthesize(&options, &job).unwrap();
    for (light, view) in [(0.3, 0.1), (0.5, 0.45), (1.4, 0.2)] {
        let pair =
            Directions { light: Direction::from_angles(light, 1.0), view: Direction::from_angles(view, 2.0) };
        let whole = crate::render::relight(&field, pair);
        let alone = made.model.cluster_picture(pair, &options, &job).unwrap().unwrap();
        assert_eq!(alone.space, whole.space);
        let pairs = alone.planes.as_slice().iter().zip(whole.planes.as_slice());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-4));
    }
}

#[test]
fn the_range_map_is_under_the_same_noise_and_closes_with_the_pictures() {
    let request = ImageClusterRequest { range: Some(ModelRequest::default()), ..request(3) };
    let made = modelled(&request).unwrap();
    let range = made.report.range.unwrap();
    assert_eq!(range.photographs, 8);
    let Fields::Clusters(clusters) = &made.model.fields else { panic!("clusters") };
    assert_eq!(clusters.range.as_ref().unwrap().planes(), 1);
    let size = made.model.tile_size();
    let options = RealisationOptions { origin: [0, 0], size, seed: 0, period: Some(size) };
    let heights = made.model.range_map(&options, &Job::default()).unwrap().unwrap();
    assert_eq!((heights.count(), heights.size()), (1, size));
}

#[test]
fn requests_without_meaning_and_sets_without_a_grid_are_refused() {
    let message = |request: &ImageClusterRequest| modelled(request).unwrap_err().to_string();
    assert!(message(&request(0)).contains("1 to 255 clusters"));
    assert!(message(&request(256)).contains("not 256"));
    let pairs = pairs();
    let load = |i: usize| Ok(photograph(&pairs[i]));
    let some = |pairs: &[(String, Directions)]| {
        model_image_clusters(pairs, &load, &request(3), &Job::default()).unwrap_err().to_string()
    };
    assert!(some(&[]).contains("found none"));
    assert!(some(&pairs[1..]).contains("all of some lights"), "{}", some(&pairs[1..]));
    let other = |i: usize| match i {
        7 => Raster::new(Size::new(4, 4), 3, Samples::U8(vec![1; 48])),
        _ => Ok(photograph(&pairs[i])),
    };
    let error = model_image_clusters(&pairs, &other, &request(3), &Job::default()).unwrap_err().to_string();
    assert!(error.contains("photograph p7 is 4 x 4"), "{error}");
}

/// A fault: a photograph that is black everywhere was the picture of its cluster, which no random field can be.
#[test]
fn photographs_that_are_the_same_everywhere_take_the_picture_of_others() {
    let pairs = pairs();
    let load = |i: usize| match i % 8 {
        7 => Raster::new(SIZE, 3, Samples::U8(vec![0; 3 * SIZE.texels()])),
        _ => Ok(photograph(&pairs[i])),
    };
    let made = model_image_clusters(&pairs, &load, &request(6), &Job::default()).unwrap();
    assert_eq!(made.report.photographs.iter().sum::<usize>(), 32);
    assert!(made.report.pictures.iter().all(|name| !["p7", "p15", "p23", "p31"].contains(&&**name)));
    let black = |_| Raster::new(SIZE, 3, Samples::U8(vec![0; 3 * SIZE.texels()]));
    let error = model_image_clusters(&pairs, &black, &request(6), &Job::default()).unwrap_err().to_string();
    assert!(error.contains("same everywhere"), "{error}");
}
