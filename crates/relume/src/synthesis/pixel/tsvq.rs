//! Tree-structured vector quantisation: Gersho, Gray, "Vector Quantization and Signal Compression",
//! 1992, chapter 12, as Wei, Levoy, "Fast Texture Synthesis using Tree-structured Vector
//! Quantization", SIGGRAPH 2000, use it to find a near vector in logarithmic time.
//!
//! The root holds all training vectors. Generation after generation the leaves of the largest distortion are
//! split in two by Lloyd's iteration, started from the mean of the coordinate with the largest variance, on
//! an even sample where the leaf is large, until there are as many leaves as requested codewords. A search
//! descends to the nearer of two centroids each time.
//!
//! Where we differ from the paper, which returns the codeword itself: the nearest training vector of the leaf
//! is returned, so that the result is always one of them, and fewer codewords make a slower and better
//! search. It is often not the nearest of all; the caller has to weigh that cost. All deciding numbers are
//! integers: centroids are rounded means, ties go to the first child and the first vector.

use super::vectors::{self, Vectors, moments};
use crate::error::Result;
use crate::job::Job;
use crate::parallel;

/// Iterations of Lloyd's algorithm for a split.
const ITERATIONS: usize = 2;

/// The size of the even sample of a cluster from which the centroids of its parts are computed.
const SAMPLE: usize = 512;

/// Training vectors in a tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tsvq {
    nodes: Vec<Node>,
    /// A centroid for each node.
    centroids: Vectors,
    /// The training vectors, those of a leaf adjacent.
    vectors: Vectors,
    /// The original number of each of them.
    numbers: Vec<u32>,
    codewords: usize,
}

/// A node: inner ones have two children, leaves hold vectors.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Node {
    /// The number of the first child; the second follows it.
    Inner(usize),
    /// The first vector and the one past the last, in the order of the tree; a single one if all are equal.
    Leaf(usize, usize),
}

impl Tsvq {
    /// A tree of up to `codewords` leaves over training vectors.
    ///
    /// # Errors
    /// When the job is cancelled.
    ///
    /// # Panics
    /// When there is no vector.
    pub fn new(training: &Vectors, codewords: usize, job: &Job) -> Result<Self> {
        assert!(training.count() > 0, "a tree needs a vector");
        let mut growing = Growing::new(training);
        growing.split_until(codewords, job)?;
        Ok(growing.finish())
    }

    /// Memory that making a tree of training vectors takes: their copy, and of each its number in two
    /// generations of leaves; and the nodes with their centroids, as they grow and as they are kept.
    pub fn bytes(training: &Vectors, codewords: usize) -> u64 {
        let nodes = 2 * codewords.min(training.count());
        let node = size_of::<GrowingNode>() + size_of::<Node>() + 4 * training.length();
        training.bytes() + (12 * training.count() + nodes * node) as u64
    }

    /// The memory of this tree.
    pub fn held_bytes(&self) -> u64 {
        let tree = size_of_val(&*self.nodes) + size_of_val(&*self.numbers);
        tree as u64 + self.centroids.bytes() + self.vectors.bytes()
    }

    /// The number of leaves.
    pub fn codewords(&self) -> usize {
        self.codewords
    }

    /// The number of a training vector near `query`, and its squared distance.
    pub fn near(&self, query: &[i16]) -> (usize, u64) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || self.near_with(query, |a, b| vectors::avx2(simd, a, b)),
            );
        }
        self.near_with(query, vectors::portable)
    }

    #[inline(always)]
    fn near_with(&self, query: &[i16], squared_distance: impl Fn(&[i16], &[i16]) -> u64) -> (usize, u64) {
        let mut at = 0;
        loop {
            match self.nodes[at] {
                Node::Inner(first) => {
                    let a = squared_distance(query, self.centroids.row(first));
                    let b = squared_distance(query, self.centroids.row(first + 1));
                    at = if b < a { first + 1 } else { first };
                }
                Node::Leaf(start, end) => {
                    let mut near = (u64::MAX, start);
                    for i in start..end {
                        near = near.min((squared_distance(query, self.vectors.row(i)), i));
                    }
                    return (self.numbers[near.1] as usize, near.0);
                }
            }
        }
    }

    /// The training vectors of each leaf, by number; for a leaf of equal ones only the first.
    pub fn leaves(&self) -> Vec<Vec<usize>> {
        let leaf = |node: &Node| match node {
            Node::Leaf(start, end) => {
                Some(self.numbers[*start..*end].iter().map(|&number| number as usize).collect())
            }
            Node::Inner(_) => None,
        };
        self.nodes.iter().filter_map(leaf).collect()
    }
}

/// A leaf of a growing tree.
struct Cluster {
    members: Vec<u32>,
    centroid: Vec<i16>,
    /// The sum of the squared distances to the mean.
    distortion: f64,
    /// The coordinate with the largest variance, and its sum over the members.
    widest: (usize, i64),
}

impl Cluster {
    fn new(training: &Vectors, members: Vec<u32>) -> Self {
        let count = members.len() as i64;
        let (sums, squares) = moments(training, &members);
        let spread = |d: usize| count as i128 * i128::from(squares[d]) - i128::from(sums[d]).pow(2);
        let first_widest = |a: usize, b: usize| if spread(b) > spread(a) { b } else { a };
        let widest = (0..sums.len()).reduce(first_widest).expect("vectors have coordinates");
        let total: i128 = (0..sums.len()).map(spread).sum();
        Self {
            centroid: sums.iter().map(|&sum| rounded_mean(sum, count)).collect(),
            distortion: total as f64 / count as f64,
            widest: (widest, sums[widest]),
            members,
        }
    }

    /// Two parts of the cluster, each of the vectors nearer to its centroid than to the other; `None` if no
    /// such parts are found.
    fn split(&self, training: &Vectors) -> Option<[Self; 2]> {
        if self.distortion == 0.0 {
            return None;
        }
        let (d, sum) = self.widest;
        let count = self.members.len() as i64;
        let above = |&n: &u32| i64::from(training.row(n as usize)[d]) * count >= sum;
        let stride = self.members.len().div_ceil(SAMPLE);
        let sample: Vec<u32> = self.members.iter().copied().step_by(stride).collect();
        let (b, a): (Vec<u32>, Vec<u32>) = sample.iter().partition(|n| above(n));
        let mut parts = [a, b];
        let mut found = None;
        for _ in 0..ITERATIONS {
            if parts.iter().any(Vec::is_empty) {
                break;
            }
            let means = parts.map(|part| mean(training, &part));
            parts = parted(training, &sample, &means);
            found = Some(means);
        }
        let [a, b] = found?;
        if stride > 1 {
            parts = parted(training, &self.members, &[a.clone(), b.clone()]);
        }
        if parts.iter().any(Vec::is_empty) {
            return None;
        }
        let [first, second] = parts.map(|members| Self::new(training, members));
        Some([Self { centroid: a, ..first }, Self { centroid: b, ..second }])
    }
}

/// The members that are not nearer to the second of two centroids, and those that are.
fn parted(training: &Vectors, members: &[u32], centroids: &[Vec<i16>; 2]) -> [Vec<u32>; 2] {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(
            #[inline(always)]
            || parted_with(training, members, centroids, |a, b| vectors::avx2(simd, a, b)),
        );
    }
    parted_with(training, members, centroids, vectors::portable)
}

#[inline(always)]
fn parted_with(
    training: &Vectors,
    members: &[u32],
    centroids: &[Vec<i16>; 2],
    squared_distance: impl Fn(&[i16], &[i16]) -> u64,
) -> [Vec<u32>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for &n in members {
        let vector = training.row(n as usize);
        let first = squared_distance(vector, &centroids[0]);
        let second = squared_distance(vector, &centroids[1]);
        parts[usize::from(second < first)].push(n);
    }
    parts
}

/// The rounded mean of given vectors.
fn mean(training: &Vectors, members: &[u32]) -> Vec<i16> {
    let (sums, _) = moments(training, members);
    sums.into_iter().map(|sum| rounded_mean(sum, members.len() as i64)).collect()
}

fn rounded_mean(sum: i64, count: i64) -> i16 {
    ((2 * sum + count) / (2 * count)) as i16
}

/// A growing tree, whose leaves are clusters.
struct Growing<'a> {
    training: &'a Vectors,
    nodes: Vec<GrowingNode>,
    leaves: usize,
}

enum GrowingNode {
    Inner { centroid: Vec<i16>, first: usize },
    Leaf(Cluster),
}

impl<'a> Growing<'a> {
    fn new(training: &'a Vectors) -> Self {
        let all = Cluster::new(training, (0..training.count() as u32).collect());
        Self { training, nodes: vec![GrowingNode::Leaf(all)], leaves: 1 }
    }

    /// Splits generation after generation, the largest distortions first.
    fn split_until(&mut self, codewords: usize, job: &Job) -> Result<()> {
        let mut generation = vec![0];
        while self.leaves < codewords && !generation.is_empty() {
            generation.sort_by(|&a, &b| self.distortion(b).total_cmp(&self.distortion(a)).then(a.cmp(&b)));
            let waiting = generation.split_off(generation.len().min(codewords - self.leaves));
            let split = |&node: &usize| {
                job.proceed()?;
                Ok(match &self.nodes[node] {
                    GrowingNode::Leaf(cluster) => cluster.split(self.training),
                    GrowingNode::Inner { .. } => None,
                })
            };
            let parts = parallel::try_map(generation.iter(), split)?;
            let mut next = waiting;
            for (node, parts) in generation.into_iter().zip(parts) {
                next.extend(parts.into_iter().flat_map(|parts| self.replace(node, parts)));
            }
            generation = next;
        }
        Ok(())
    }

    fn distortion(&self, node: usize) -> f64 {
        match &self.nodes[node] {
            GrowingNode::Leaf(cluster) => cluster.distortion,
            GrowingNode::Inner { .. } => 0.0,
        }
    }

    /// Turns a leaf into an inner node over two new ones, whose numbers it returns.
    fn replace(&mut self, node: usize, parts: [Cluster; 2]) -> [usize; 2] {
        let first = self.nodes.len();
        if let GrowingNode::Leaf(cluster) = &mut self.nodes[node] {
            let centroid = std::mem::take(&mut cluster.centroid);
            self.nodes[node] = GrowingNode::Inner { centroid, first };
        }
        self.nodes.extend(parts.map(GrowingNode::Leaf));
        self.leaves += 1;
        [first, first + 1]
    }

    fn finish(self) -> Tsvq {
        let (length, count) = (self.training.length(), self.training.count());
        let mut centroids = Vectors::with_capacity(length, self.nodes.len());
        let mut vectors = Vectors::with_capacity(length, count);
        let mut numbers = Vec::with_capacity(count);
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for node in self.nodes {
            let (centroid, node) = match node {
                GrowingNode::Inner { centroid, first } => (centroid, Node::Inner(first)),
                GrowingNode::Leaf(cluster) => {
                    let start = numbers.len();
                    let kept = if cluster.distortion == 0.0 { 1 } else { cluster.members.len() };
                    numbers.extend_from_slice(&cluster.members[..kept]);
                    (cluster.centroid, Node::Leaf(start, numbers.len()))
                }
            };
            centroids.push(&centroid);
            nodes.push(node);
        }
        numbers.iter().for_each(|&n| vectors.push(self.training.row(n as usize)));
        Tsvq { nodes, centroids, vectors, numbers, codewords: self.leaves }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::squared_distance;
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    /// Vectors around a few centres, with repetitions.
    fn clustered(count: usize, length: usize, seed: u64) -> Vectors {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let mut vectors = Vectors::with_capacity(length, count);
        let centres: Vec<usize> = (0..5 * length).map(|_| stream.below(3000)).collect();
        for _ in 0..count {
            let (centre, spread) = (stream.below(5), 1 + stream.below(300));
            let row: Vec<i16> =
                (0..length).map(|d| (centres[centre * length + d] + stream.below(spread)) as i16).collect();
            vectors.push(&row);
        }
        vectors
    }

    fn full_search(vectors: &Vectors, query: &[i16]) -> (usize, u64) {
        let all = (0..vectors.count()).map(|n| (squared_distance(vectors.row(n), query), n));
        let (distance, number) = all.min().unwrap();
        (number, distance)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn leaves_share_the_training_vectors_and_searches_end_at_the_nearest_of_one(
            (count, length, codewords, seed) in (1usize..300, 1usize..40, 1usize..80, any::<u64>()),
        ) {
            let vectors = clustered(count, length, seed);
            let tree = Tsvq::new(&vectors, codewords, &Job::default()).unwrap();
            prop_assert!(tree.codewords() <= codewords);
            let leaves = tree.leaves();
            prop_assert_eq!(leaves.len(), tree.codewords());
            let all: std::collections::BTreeSet<usize> = leaves.iter().flatten().copied().collect();
            prop_assert_eq!(all.len(), leaves.iter().map(Vec::len).sum::<usize>());
            prop_assert!((0..count).all(|n| tree.near(vectors.row(n)).1 == 0), "all are found again");
            let queries = clustered(20, length, seed ^ 1);
            for query in (0..20).map(|n| queries.row(n)) {
                let (number, distance) = tree.near(query);
                prop_assert_eq!(distance, squared_distance(vectors.row(number), query));
                prop_assert!(distance >= full_search(&vectors, query).1);
                let leaf = leaves.iter().find(|leaf| leaf.contains(&number)).unwrap();
                prop_assert!(leaf.iter().all(|&n| squared_distance(vectors.row(n), query) >= distance));
            }
        }
    }

    #[test]
    fn what_is_lost_grows_slowly_with_the_codewords() {
        let vectors = clustered(3000, 24, 5);
        let queries = clustered(300, 24, 6);
        let excess = |codewords| -> f64 {
            let tree = Tsvq::new(&vectors, codewords, &Job::default()).unwrap();
            let ratio = |query| tree.near(query).1 as f64 / full_search(&vectors, query).1.max(1) as f64;
            (0..300).map(|n| ratio(queries.row(n))).sum::<f64>() / 300.0
        };
        let (one, few, many) = (excess(1), excess(30), excess(300));
        assert_eq!(one, 1.0, "a tree of one leaf is a full search");
        assert!(few < many && many < 2.0, "{few} {many}");
    }
}
