//! Clusters of points by Lloyd's algorithm (S. P. Lloyd, "Least Squares Quantization in PCM", IEEE Transactions on Information
//! Theory 28, 1982), from points drawn with probabilities that grow with the distance from those before (D. Arthur, S.
//! Vassilvitskii, "k-means++", SODA 2007).

use super::random::Stream;

/// Rounds; those of thousands of points settle in fewer.
const ROUNDS: usize = 100;

/// The cluster of each point; points have `dimensions` adjacent numbers. Every cluster has a point; there are fewer clusters
/// than asked for where fewer points differ.
pub fn k_means(points: &[f64], dimensions: usize, clusters: usize, stream: &mut Stream) -> Vec<usize> {
    let point = |i: usize| &points[i * dimensions..][..dimensions];
    let count = points.len() / dimensions;
    let mut means = first_means(points, dimensions, clusters, stream);
    let mut labels = vec![0; count];
    for _ in 0..ROUNDS {
        let nearest: Vec<usize> = (0..count).map(|i| nearest(&means, point(i))).collect();
        let is_settled = nearest == labels;
        labels = nearest;
        if is_settled {
            break;
        }
        for (k, mean) in means.iter_mut().enumerate() {
            let own = (0..count).filter(|i| labels[*i] == k);
            let (mut sum, mut members) = (vec![0.0; dimensions], 0.0);
            for i in own {
                sum.iter_mut().zip(point(i)).for_each(|(s, v)| *s += v);
                members += 1.0;
            }
            if members > 0.0 {
                *mean = sum.into_iter().map(|s| s / members).collect();
            }
        }
    }
    numbered_without_gaps(&labels)
}

fn first_means(points: &[f64], dimensions: usize, clusters: usize, stream: &mut Stream) -> Vec<Vec<f64>> {
    let count = points.len() / dimensions;
    let mut chosen = stream.below(count);
    let mut squares = vec![f64::INFINITY; count];
    let mut means = Vec::new();
    loop {
        let mean = points[chosen * dimensions..][..dimensions].to_vec();
        for (i, square) in squares.iter_mut().enumerate() {
            *square = square.min(square_distance(&points[i * dimensions..][..dimensions], &mean));
        }
        means.push(mean);
        let sum: f64 = squares.iter().sum();
        if means.len() >= clusters || sum <= 0.0 {
            return means;
        }
        let mut left = stream.unit() * sum;
        let reached = squares.iter().position(|square| {
            left -= square;
            left < 0.0
        });
        chosen = reached.unwrap_or(count - 1);
    }
}

fn nearest(means: &[Vec<f64>], point: &[f64]) -> usize {
    let mut best = (f64::INFINITY, 0);
    for (k, mean) in means.iter().enumerate() {
        let square = square_distance(point, mean);
        if square < best.0 {
            best = (square, k);
        }
    }
    best.1
}

fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The same clusters, numbered in the order of their first points.
fn numbered_without_gaps(labels: &[usize]) -> Vec<usize> {
    let mut seen: Vec<usize> = Vec::new();
    let number = |label: &usize| match seen.iter().position(|known| known == label) {
        Some(number) => number,
        None => {
            seen.push(*label);
            seen.len() - 1
        }
    };
    labels.iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Purpose;

    #[test]
    fn groups_apart_are_found_and_numbered_by_their_first_points() {
        let mut stream = Stream::new(5, Purpose::Sample, [0]);
        let centre = |i: usize| [[0.0, 9.0], [9.0, 0.0], [-9.0, -9.0]][i % 3];
        let points: Vec<f64> = (0..60).flat_map(|i| centre(i).map(|v| v + stream.unit())).collect();
        for seed in 0..5 {
            let labels = k_means(&points, 2, 3, &mut Stream::new(seed, Purpose::Sample, [1]));
            assert_eq!(labels, (0..60).map(|i| i % 3).collect::<Vec<_>>());
        }
    }

    #[test]
    fn equal_points_are_one_cluster() {
        let labels = k_means(&[2.0; 12], 3, 7, &mut Stream::new(0, Purpose::Sample, [2]));
        assert_eq!(labels, [0; 4]);
    }
}
