use super::*;
use crate::direction::Direction;
use crate::numeric::Matrix;
use crate::numeric::random::{Purpose, Stream};
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// Photographs of texels that are products of some numbers and smooth functions of light and view, with noise.
pub(super) struct Photographed {
    pub pairs: Vec<(String, Directions)>,
    pub images: Vec<Raster>,
}

const SIZE: Size = Size { width: 9, height: 7 };

pub(super) fn material(lights: usize, views: usize, channels: usize, noise: f64) -> Photographed {
    let direction = |i: usize, n: usize| Direction::from_angles(1.3 * i as f64 / n as f64, 2.4 * i as f64);
    let pair = move |i: usize| Directions {
        light: direction(i % lights, lights),
        view: direction(i / lights, views),
    };
    let pairs: Vec<_> = (0..lights * views).map(|i| (format!("p{i}"), pair(i))).collect();
    let value = |pair: &Directions, channel: usize, texel: usize| {
        let (x, c) = (texel as f64, channel as f64);
        let half = pair.light.dot(pair.view);
        let terms = (0..6).map(|k| {
            let k = f64::from(k);
            let texture = (x * (0.31 + 0.17 * k) + k).sin() / (1.0 + k * k);
            texture * (k * (pair.light.x() + 0.3 * c) + 0.5 * k * pair.view.y() + half).cos()
        });
        0.45 + 0.2 * terms.sum::<f64>()
    };
    let image = |(i, (_, pair)): (usize, &(String, Directions))| {
        let mut stream = Stream::new(1, Purpose::Sample, [i as u64]);
        let samples = (0..SIZE.texels() * channels).map(|s| {
            let clean = value(pair, s % channels, s / channels);
            ((clean + noise * (stream.unit() - 0.5)).clamp(0.0, 1.0) * 65535.0).round() as u16
        });
        Raster::new(SIZE, channels, Samples::U16(samples.collect())).unwrap()
    };
    let images = pairs.iter().enumerate().map(image).collect();
    Photographed { pairs, images }
}

impl Photographed {
    pub fn fit(&self, options: &LearnedOptions) -> Result<LearnedFit> {
        fit(&self.pairs, &|i| Ok(self.images[i].clone()), options, &Job::default())
    }

    fn matrix(&self) -> Matrix {
        let channels = self.images[0].channels();
        Matrix::from_fn(SIZE.texels(), self.images.len() * channels, |texel, column| {
            f64::from(self.images[column / channels].samples().value(texel * channels + column % channels))
        })
    }
}

#[test]
fn errors_are_those_of_the_exact_decomposition_at_every_rank() {
    for channels in [1, 3] {
        let material = material(7, 5, channels, 0.1);
        let truth = exact(&material.matrix());
        for functions in [1, 2, 5, 8, 20] {
            let options = LearnedOptions { rank: Rank::Functions(functions), ..LearnedOptions::default() };
            let fit = material.fit(&options).unwrap();
            let found = fit.report.error.rmse;
            let truth = truth[functions - 1];
            // Beyond the six functions of the material there is noise alone, whose singular values are all alike.
            let tolerance = if functions <= 5 { 0.01 } else { 0.02 };
            assert!((found / truth - 1.0).abs() < tolerance, "{functions} functions: {found} and {truth}");
            // All texels are measured; values clamped to what photographs hold are no farther.
            assert!((fit.report.fitted.error.rmse / found - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn relit_pictures_are_the_photographs_where_the_functions_suffice() {
    let material = material(6, 4, 3, 0.0);
    let options = LearnedOptions { rank: Rank::Functions(40), ..LearnedOptions::default() };
    let fit = material.fit(&options).unwrap();
    assert_eq!(fit.field.layout().channel_names(), ["R", "G", "B"]);
    for ((_, pair), image) in material.pairs.iter().zip(&material.images) {
        for texel in 0..SIZE.texels() {
            let values = fit.field.value(texel % SIZE.width, texel / SIZE.width, *pair);
            for (channel, value) in values.into_iter().enumerate() {
                let truth = image.samples().value(3 * texel + channel);
                assert!((value - truth).abs() < 2e-4, "{value} and {truth}");
            }
        }
    }
}

#[test]
fn coefficients_are_index_planes_largest_first() {
    let fit = material(6, 6, 3, 0.05)
        .fit(&LearnedOptions { rank: Rank::Functions(6), ..Default::default() })
        .unwrap();
    let planes = fit.field.coefficients();
    let dot = |j: usize, k: usize| -> f64 {
        planes.plane(j).iter().zip(planes.plane(k)).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    };
    for j in 0..6 {
        assert!(j == 0 || dot(j, j) <= dot(j - 1, j - 1));
        (0..j).for_each(|k| assert!(dot(j, k).abs() < 1e-4 * dot(0, 0), "{j} {k}"));
    }
}

#[test]
fn an_error_asks_for_as_few_functions_as_reach_it() {
    let material = material(7, 6, 1, 0.05);
    let truth = exact(&material.matrix());
    let asked = 0.5 * (truth[3] + truth[4]);
    let fit = material.fit(&LearnedOptions { rank: Rank::Error(asked), ..Default::default() }).unwrap();
    assert_eq!(fit.field.basis().len(), 5);
    assert!(fit.report.error.rmse <= asked);
    let error = material.fit(&LearnedOptions { rank: Rank::Error(1e-9), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("42 functions"), "{error}");
}

#[test]
fn pairs_left_out_are_predicted_and_reported() {
    let material = material(12, 10, 3, 0.0);
    let options = LearnedOptions { rank: Rank::Functions(8), hold_out: Some(5), ..Default::default() };
    let fit = material.fit(&options).unwrap();
    let left_out = fit.report.held_out.unwrap();
    // Of 12 lights 4 and 9, of 10 views 4 and 9.
    assert_eq!((left_out.pairs, fit.report.fitted.pairs), (120 - 80, 80));
    assert!(left_out.error.rmse > fit.report.fitted.error.rmse && left_out.error.rmse < 0.1);
    assert!(left_out.mae_lab.unwrap() > fit.report.fitted.mae_lab.unwrap());
}

#[test]
fn thread_counts_do_not_change_a_bit() {
    let material = material(5, 4, 3, 0.1);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            material.fit(&LearnedOptions { rank: Rank::Functions(7), ..Default::default() }).unwrap().field
        })
    };
    assert!(run(1) == run(3));
}

#[test]
fn what_cannot_be_learned_is_refused() {
    let material = material(3, 2, 1, 0.1);
    let message = |options: LearnedOptions| material.fit(&options).unwrap_err().to_string();
    let rank = |rank| LearnedOptions { rank, ..LearnedOptions::default() };
    assert!(message(rank(Rank::Functions(0))).contains("1 to 256"));
    assert!(message(rank(Rank::Functions(7))).contains("at most 6"));
    assert!(message(rank(Rank::Error(f64::NAN))).contains("between 0 and 1"));
    assert!(message(LearnedOptions { hold_out: Some(1), ..rank(Rank::Functions(1)) }).contains("2 or more"));
    assert!(message(LearnedOptions { report_texels: 0, ..rank(Rank::Functions(1)) }).contains("at least 1"));
}

#[test]
fn black_photographs_are_refused() {
    let mut material = material(3, 3, 3, 0.0);
    for image in &mut material.images {
        *image = Raster::new(SIZE, 3, Samples::U8(vec![0; 3 * SIZE.texels()])).unwrap();
    }
    let error = material.fit(&LearnedOptions { rank: Rank::Functions(2), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("black"), "{error}");
}

#[test]
fn fewer_functions_than_asked_suffice_for_a_flat_texture() {
    let mut material = material(3, 3, 3, 0.0);
    for (i, image) in material.images.iter_mut().enumerate() {
        let samples = vec![20 * (i as u8 + 1); 3 * SIZE.texels()];
        *image = Raster::new(SIZE, 3, Samples::U8(samples)).unwrap();
    }
    let fit = material.fit(&LearnedOptions { rank: Rank::Functions(4), ..Default::default() }).unwrap();
    assert_eq!(fit.field.basis().len(), 1);
    // The figure is the root of a difference of large sums of floats.
    assert!(fit.report.error.rmse < 3e-4, "{}", fit.report.error.rmse);
    assert!(fit.report.fitted.error.rmse < 1e-5, "{}", fit.report.fitted.error.rmse);
}

fn in_clusters(clusters: usize, axes: usize, functions: usize) -> LearnedOptions {
    LearnedOptions {
        rank: Rank::Functions(functions),
        clusters: Some(ClusterOptions { clusters, axes }),
        ..LearnedOptions::default()
    }
}

/// Two materials side by side: texels left and right of a border are products of numbers with functions of their own.
fn two_materials() -> Photographed {
    let mut photographed = material(7, 5, 3, 0.0);
    for (i, image) in photographed.images.iter_mut().enumerate() {
        let pair = photographed.pairs[i].1;
        let value = |s: usize| {
            let (texel, channel) = (s / 3, (s % 3) as f64);
            let (x, y) = ((texel % SIZE.width) as f64, (texel / SIZE.width) as f64);
            let own = (1.3 * x + 0.7 * y).sin();
            match x < 4.5 {
                true => 0.3 + 0.1 * own * (pair.light.x() + 0.2 * channel),
                false => 0.7 + 0.1 * own * (3.0 * pair.view.y() * pair.light.y() - 0.3 * channel),
            }
        };
        let samples = (0..SIZE.texels() * 3).map(|s| (value(s) * 65535.0).round() as u16).collect();
        *image = Raster::new(SIZE, 3, Samples::U16(samples)).unwrap();
    }
    photographed
}

#[test]
fn a_number_for_each_texel_suffices_where_each_cluster_has_one_axis() {
    let material = two_materials();
    let fit = material.fit(&in_clusters(2, 1, 6)).unwrap();
    let clustered = fit.clustered.unwrap();
    let labels = clustered.planes().plane(0);
    let is_right = |texel: usize| texel % SIZE.width > 4;
    for texel in 0..SIZE.texels() {
        assert_eq!(labels[texel] == labels[0], !is_right(texel), "texel {texel}");
    }
    assert!(fit.report.error.rmse < 1e-3, "{}", fit.report.error.rmse);
    // One function more than the mean is not enough for both.
    let options = LearnedOptions { rank: Rank::Functions(2), ..LearnedOptions::default() };
    assert!(material.fit(&options).unwrap().report.error.rmse > 0.02);
}

#[test]
fn the_error_of_clusters_is_that_of_the_relit_photographs() {
    let fit = material(7, 5, 3, 0.05).fit(&in_clusters(4, 2, 8)).unwrap();
    // All texels are measured, on the expanded texture.
    assert!((fit.report.fitted.error.rmse / fit.report.error.rmse - 1.0).abs() < 1e-3, "{:?}", fit.report);
    let clustered = fit.clustered.unwrap();
    assert_eq!(clustered.expanded(&Job::default()).unwrap(), fit.field);
    assert_eq!((clustered.planes().count(), fit.field.coefficients().count()), (3, 8));
}

#[test]
fn more_clusters_and_more_axes_lower_the_error() {
    let material = material(7, 5, 3, 0.05);
    let error = |clusters, axes| material.fit(&in_clusters(clusters, axes, 8)).unwrap().report.error.rmse;
    let errors = [error(1, 2), error(4, 2), error(4, 4), error(12, 4)];
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
}

#[test]
fn clusters_do_not_depend_on_the_number_of_threads() {
    let material = material(6, 4, 3, 0.1);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| material.fit(&in_clusters(5, 2, 7)).unwrap().clustered.unwrap())
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn clusters_without_meaning_are_refused_in_a_sentence() {
    let material = material(4, 3, 3, 0.1);
    let message = |clusters, axes| material.fit(&in_clusters(clusters, axes, 4)).unwrap_err().to_string();
    assert!(message(0, 2).contains("1 to 63 clusters are made of 63 texels"));
    assert!(message(64, 2).contains("not 64"));
    assert!(message(2, 0).contains("at least 1, not 0"));
    assert!(message(2, 4).contains("fewer numbers than the 4 common functions"));
}

/// What a fit of 151 x 151 photographs of 512 x 512 asks for before it reads the second one: all but the coefficients, which
/// the first sums are larger than.
#[test]
fn a_dome_sized_set_is_factored_within_a_gigabyte_and_a_half() {
    use crate::capture::dome::sampling::{DirectionSampling, all_pairs};
    let directions = DirectionSampling::Dome.directions();
    let pairs: Vec<(String, Directions)> =
        all_pairs(&directions, &directions).into_iter().map(|pair| (String::new(), pair)).collect();
    assert_eq!(pairs.len(), 22_801);
    let size = Size::new(512, 512);
    let load = |i: usize| match i {
        0 => Raster::new(size, 3, Samples::U8(vec![9; 3 * size.texels()])),
        _ => Err(Error::invalid("the second photograph")),
    };
    let job = Job::new(crate::Limits { max_bytes: 1_500_000_000, ..crate::Limits::default() });
    let error = fit(&pairs, &load, &LearnedOptions::default(), &job).unwrap_err().to_string();
    assert!(error.contains("the second photograph"), "{error}");
    let asked = job.peak_bytes();
    assert!((200_000_000..700_000_000).contains(&asked), "{asked} bytes");
}
