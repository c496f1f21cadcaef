//! The path of least error through a strip, by dynamic programming:
//! E(a, c) = e(a, c) + min(E(a-1, c-1), E(a-1, c), E(a-1, c+1)).
//! Efros, Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001, section 2.1.

/// For each position along a strip of `length` x `width` texels, the position of the path across it.
/// Neighbouring positions differ by at most one. Among equal paths it is the one that ends nearest to
/// `across` = 0 and, going back from there, stays nearest to it.
pub fn least_path(length: usize, width: usize, error: impl Fn(usize, usize) -> u64) -> Vec<usize> {
    let mut sums: Vec<u64> = Vec::with_capacity(length * width);
    for along in 0..length {
        for across in 0..width {
            let before = match along {
                0 => 0,
                _ => sums[least_near(&sums, along - 1, width, across)],
            };
            sums.push(before + error(along, across));
        }
    }
    let mut path = vec![0; length];
    for along in (0..length).rev() {
        path[along] = match path.get(along + 1) {
            Some(&after) => least_near(&sums, along, width, after) - along * width,
            None => (0..width).min_by_key(|c| sums[along * width + c]).unwrap_or(0),
        };
    }
    path
}

/// The index of the least sum at `along` within one texel of `across`, the first among equals.
fn least_near(sums: &[u64], along: usize, width: usize, across: usize) -> usize {
    let near = across.saturating_sub(1)..=(across + 1).min(width - 1);
    near.map(|c| along * width + c).min_by_key(|&i| sums[i]).expect("the range is not empty")
}

/// The least error of any path, found by trying all of them: the slow truth of [`least_path`], for strips of
/// a few texels.
pub fn least_error_of_all_paths(length: usize, width: usize, error: &impl Fn(usize, usize) -> u64) -> u64 {
    fn from(along: usize, across: usize, shape: (usize, usize), error: &impl Fn(usize, usize) -> u64) -> u64 {
        let own = error(along, across);
        if along + 1 == shape.0 {
            return own;
        }
        let near = across.saturating_sub(1)..=(across + 1).min(shape.1 - 1);
        own + near.map(|next| from(along + 1, next, shape, error)).min().unwrap_or(0)
    }
    (0..width).map(|across| from(0, across, (length, width), error)).min().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn no_path_has_less_error() {
        for seed in 0..200 {
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
            let (length, width) = (1 + stream.below(7), 1 + stream.below(5));
            let errors: Vec<u64> = (0..length * width).map(|_| stream.below(20) as u64).collect();
            let error = |along: usize, across: usize| errors[along * width + across];
            let path = least_path(length, width, error);
            assert!(path.windows(2).all(|w| w[0].abs_diff(w[1]) <= 1));
            let sum: u64 = path.iter().enumerate().map(|(along, &across)| error(along, across)).sum();
            assert_eq!(sum, least_error_of_all_paths(length, width, &error), "seed {seed}");
        }
    }

    #[test]
    fn ties_are_settled_by_position() {
        assert_eq!(least_path(4, 3, |_, _| 5), [0; 4]);
        assert_eq!(least_path(3, 3, |along, across| u64::from(across != 2 - along)), [2, 1, 0]);
    }
}
