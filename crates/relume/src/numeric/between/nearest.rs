//! Search for the nearest measured pairs of directions: a k-d tree (Bentley, "Multidimensional Binary Search
//! Trees Used for Associative Searching", Communications of the ACM 18, 1975) over the six components of
//! light and view, stored as one permuted list. A search allocates nothing.

/// The most neighbours returned by a search: the corners of a cell of the four-dimensional domain, and one
/// more, which bounds them.
pub(super) const MOST: usize = 17;

/// A neighbour: its squared distance, and its index among the measured pairs.
pub(super) type Neighbour = (f64, u32);

/// The measured pairs as a tree: the middle of a range is its root and divides the rest along a stored axis.
#[derive(Debug, Clone)]
pub(super) struct PairTree {
    points: Vec<[f64; 6]>,
    /// The index of the pair of each point.
    pairs: Vec<u32>,
    axes: Vec<u8>,
}

/// The neighbours found so far, nearest first; ties by the index of the pair.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestPairs {
    neighbours: [Neighbour; MOST],
    count: usize,
}

impl NearestPairs {
    /// The neighbours, nearest first.
    pub fn neighbours(&self) -> &[Neighbour] {
        &self.neighbours[..self.count]
    }

    fn insert(&mut self, neighbour: Neighbour) {
        if self.count == MOST && neighbour >= self.neighbours[MOST - 1] {
            return;
        }
        let place = self.neighbours().partition_point(|other| *other < neighbour);
        self.count = (self.count + 1).min(MOST);
        self.neighbours.copy_within(place..self.count - 1, place + 1);
        self.neighbours[place] = neighbour;
    }

    /// The squared distance beyond which points are irrelevant.
    fn reach(&self) -> f64 {
        if self.count < MOST { f64::INFINITY } else { self.neighbours[MOST - 1].0 }
    }
}

impl PairTree {
    /// A tree of points.
    pub fn new(points: &[[f64; 6]]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        divide(points, &mut order, &mut axes);
        let sorted = order.iter().map(|&pair| points[pair as usize]).collect();
        Self { points: sorted, pairs: order, axes }
    }

    /// The nearest [`MOST`] points, or all if there are fewer.
    pub fn nearest(&self, place: &[f64; 6]) -> NearestPairs {
        let mut found = NearestPairs { neighbours: [(f64::INFINITY, u32::MAX); MOST], count: 0 };
        self.search(0, self.points.len(), place, &mut found);
        found
    }

    fn search(&self, start: usize, end: usize, place: &[f64; 6], found: &mut NearestPairs) {
        if start == end {
            return;
        }
        let middle = start + (end - start) / 2;
        found.insert((square_distance(&self.points[middle], place), self.pairs[middle]));
        let axis = usize::from(self.axes[middle]);
        let beyond = place[axis] - self.points[middle][axis];
        let (near, far) = ((start, middle), (middle + 1, end));
        let (near, far) = if beyond < 0.0 { (near, far) } else { (far, near) };
        self.search(near.0, near.1, place, found);
        if beyond * beyond <= found.reach() {
            self.search(far.0, far.1, place, found);
        }
    }
}

/// Moves the median along the widest axis to the middle, with smaller ones before it, and divides both sides.
fn divide(points: &[[f64; 6]], order: &mut [u32], axes: &mut [u8]) {
    if order.is_empty() {
        return;
    }
    let at = |pair: u32, axis: usize| points[pair as usize][axis];
    let width = |axis: usize| {
        let values = order.iter().map(|&pair| at(pair, axis));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let widths: [f64; 6] = std::array::from_fn(width);
    let axis = (0..6).fold(0, |best, axis| if widths[axis] > widths[best] { axis } else { best });
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| at(a, axis).total_cmp(&at(b, axis)).then(a.cmp(&b)));
    axes[middle] = axis as u8;
    let (before, after) = order.split_at_mut(middle);
    let (axes_before, axes_after) = axes.split_at_mut(middle);
    divide(points, before, axes_before);
    divide(points, &mut after[1..], &mut axes_after[1..]);
}

pub(super) fn square_distance(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn a_search_finds_what_sorting_all_points_does() {
        let mut stream = Stream::new(4, Purpose::Sample, [0]);
        for count in [1, 2, 16, 17, 18, 300] {
            // Coarse coordinates, so that distances repeat.
            let mut coordinate = || (stream.unit() * 8.0).floor() / 4.0 - 1.0;
            let points: Vec<[f64; 6]> = (0..count).map(|_| std::array::from_fn(|_| coordinate())).collect();
            let tree = PairTree::new(&points);
            for _ in 0..50 {
                let place: [f64; 6] = std::array::from_fn(|_| coordinate());
                let mut truth: Vec<Neighbour> =
                    (0..count).map(|i| (square_distance(&points[i], &place), i as u32)).collect();
                truth.sort_by(|a, b| a.partial_cmp(b).unwrap());
                truth.truncate(MOST);
                assert_eq!(tree.nearest(&place).neighbours(), truth, "{count} points");
            }
        }
    }
}
