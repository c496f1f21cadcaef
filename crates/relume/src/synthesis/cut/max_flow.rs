//! The maximum flow from a source to a sink through a grid, and with it the minimum cut.
//!
//! Boykov, Kolmogorov, "An Experimental Comparison of Min-Cut/Max-Flow Algorithms for Energy Minimization in
//! Vision", PAMI 26(9), 2004, section 3: a tree of nodes grows from each terminal; where they touch, flow is
//! pushed along the path, and nodes cut off by its saturated arcs look for another parent in their tree.
//! Capacities are integers, so the flow is exact. On grids the size of blocks the path to the root is short,
//! so the time stamps of the paper are omitted.
//!
//! Of all minimum cuts, the result is the one with the fewest nodes on the side of the source: those still
//! reachable by flow from the source. It is unique, whatever the order in which paths are found.

use std::collections::VecDeque;

use crate::size::Size;

/// The neighbours of a node: right, down, left, up.
const SIDES: usize = 4;

/// The side from which a neighbour sees a node.
fn opposite(side: usize) -> usize {
    side ^ 2
}

/// A grid of nodes connected to their four neighbours, to a source and to a sink.
///
/// The grid is surrounded by a ring of unused nodes, so that each node has four neighbours.
#[derive(Debug, Clone)]
pub struct GridNetwork {
    size: Size,
    steps: [isize; SIDES],
    /// The residual capacity from each node to each neighbour.
    residual: Vec<[u64; SIDES]>,
    /// The residual capacity from the source to a node; if negative, that from the node to the sink.
    terminal: Vec<i64>,
    flow: u64,
}

/// A minimum cut.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MinimumCut {
    /// The capacity of the arcs it cuts: the maximum flow.
    pub value: u64,
    /// Whether each node, row by row, is on the side of the source.
    pub source_side: Vec<bool>,
}

impl GridNetwork {
    /// Nodes without arcs.
    pub fn new(size: Size) -> Self {
        let stride = size.width.cast_signed() + 2;
        let nodes = (size.width + 2) * (size.height + 2);
        Self {
            size,
            steps: [1, stride, -1, -stride],
            residual: vec![[0; SIDES]; nodes],
            terminal: vec![0; nodes],
            flow: 0,
        }
    }

    fn node(&self, x: usize, y: usize) -> usize {
        (y + 1) * (self.size.width + 2) + x + 1
    }

    /// Connects (x, y) and (x + 1, y) with a capacity in both directions.
    pub fn join_right(&mut self, x: usize, y: usize, capacity: u64) {
        self.join(self.node(x, y), 0, capacity);
    }

    /// Connects (x, y) and (x, y + 1) with a capacity in both directions.
    pub fn join_down(&mut self, x: usize, y: usize, capacity: u64) {
        self.join(self.node(x, y), 1, capacity);
    }

    fn join(&mut self, node: usize, side: usize, capacity: u64) {
        self.residual[node][side] += capacity;
        let next = node.wrapping_add_signed(self.steps[side]);
        self.residual[next][opposite(side)] += capacity;
    }

    /// Connects a node to both terminals, once; flow straight through it is sent immediately.
    pub fn join_terminals(&mut self, x: usize, y: usize, from_source: u64, to_sink: u64) {
        let node = self.node(x, y);
        self.flow += from_source.min(to_sink);
        self.terminal[node] = from_source.cast_signed() - to_sink.cast_signed();
    }

    /// The minimum cut with the fewest nodes on the side of the source.
    pub fn minimum_cut(self) -> MinimumCut {
        let size = self.size;
        let mut forest = Forest::new(self);
        while let Some((node, side)) = forest.grow() {
            forest.augment(node, side);
            forest.adopt();
        }
        let nodes = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        let from_source = |(x, y)| forest.tree[forest.network.node(x, y)] == Tree::Source;
        MinimumCut { value: forest.network.flow, source_side: nodes.map(from_source).collect() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tree {
    None,
    Source,
    Sink,
}

/// The parent of a node in a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Parent {
    Missing,
    Terminal,
    Neighbour(usize),
}

/// The two trees.
struct Forest {
    network: GridNetwork,
    tree: Vec<Tree>,
    parent: Vec<Parent>,
    /// Nodes whose neighbours may be free or in the other tree.
    active: VecDeque<usize>,
    is_active: Vec<bool>,
    /// Nodes that have lost their parent.
    orphans: VecDeque<usize>,
}

impl Forest {
    fn new(network: GridNetwork) -> Self {
        let nodes = network.terminal.len();
        let (tree, parent, is_active) =
            (vec![Tree::None; nodes], vec![Parent::Missing; nodes], vec![false; nodes]);
        let (active, orphans) = (VecDeque::new(), VecDeque::new());
        let mut forest = Self { network, tree, parent, active, is_active, orphans };
        for node in 0..nodes {
            match forest.network.terminal[node] {
                0 => {}
                amount => {
                    forest.plant(node, if amount > 0 { Tree::Source } else { Tree::Sink }, Parent::Terminal);
                }
            }
        }
        forest
    }

    fn plant(&mut self, node: usize, tree: Tree, parent: Parent) {
        (self.tree[node], self.parent[node]) = (tree, parent);
        self.activate(node);
    }

    fn activate(&mut self, node: usize) {
        if !self.is_active[node] {
            self.is_active[node] = true;
            self.active.push_back(node);
        }
    }

    fn neighbour(&self, node: usize, side: usize) -> usize {
        node.wrapping_add_signed(self.network.steps[side])
    }

    /// The arc over which flow passes between a node in `tree` and its child at `side`: away from the source,
    /// towards the sink.
    fn arc(&self, tree: Tree, node: usize, side: usize) -> (usize, usize) {
        match tree {
            Tree::Sink => (self.neighbour(node, side), opposite(side)),
            _ => (node, side),
        }
    }

    fn room(&self, (node, side): (usize, usize)) -> u64 {
        self.network.residual[node][side]
    }

    /// The arc between a node and its parent at `side`.
    fn arc_from_parent(&self, node: usize, side: usize) -> (usize, usize) {
        self.arc(self.tree[node], self.neighbour(node, side), opposite(side))
    }

    /// Grows both trees until they touch; returns the arc from the source tree to the sink tree.
    fn grow(&mut self) -> Option<(usize, usize)> {
        while let Some(&node) = self.active.front() {
            let tree = self.tree[node];
            for side in 0..SIDES {
                let arc = self.arc(tree, node, side);
                if tree == Tree::None || self.room(arc) == 0 {
                    continue;
                }
                let next = self.neighbour(node, side);
                match self.tree[next] {
                    Tree::None => self.plant(next, tree, Parent::Neighbour(opposite(side))),
                    other if other != tree => return Some(arc),
                    _ => {}
                }
            }
            self.active.pop_front();
            self.is_active[node] = false;
        }
        None
    }

    /// Sends the most flow possible through an arc that connects the trees.
    fn augment(&mut self, node: usize, side: usize) {
        let next = self.neighbour(node, side);
        let amount = self.room((node, side)).min(self.slack(node)).min(self.slack(next));
        self.send((node, side), amount);
        self.drain(node, amount);
        self.drain(next, amount);
        self.network.flow += amount;
    }

    /// The residual capacity between a node and its terminal.
    fn slack(&self, mut node: usize) -> u64 {
        let mut least = u64::MAX;
        while let Parent::Neighbour(side) = self.parent[node] {
            least = least.min(self.room(self.arc_from_parent(node, side)));
            node = self.neighbour(node, side);
        }
        least.min(self.network.terminal[node].unsigned_abs())
    }

    fn send(&mut self, (node, side): (usize, usize), amount: u64) {
        self.network.residual[node][side] -= amount;
        let next = self.neighbour(node, side);
        self.network.residual[next][opposite(side)] += amount;
    }

    /// Sends an amount between a node and its terminal; nodes below saturated arcs lose their parent.
    fn drain(&mut self, mut node: usize, amount: u64) {
        while let Parent::Neighbour(side) = self.parent[node] {
            let arc = self.arc_from_parent(node, side);
            self.send(arc, amount);
            if self.room(arc) == 0 {
                self.orphan(node);
            }
            node = self.neighbour(node, side);
        }
        let left = &mut self.network.terminal[node];
        *left -= left.signum() * amount.cast_signed();
        if *left == 0 {
            self.orphan(node);
        }
    }

    fn orphan(&mut self, node: usize) {
        self.parent[node] = Parent::Missing;
        self.orphans.push_back(node);
    }

    /// Finds new parents for orphans; a node without one leaves its tree.
    fn adopt(&mut self) {
        while let Some(node) = self.orphans.pop_front() {
            let tree = self.tree[node];
            let relative = |side: &usize| {
                let next = self.neighbour(node, *side);
                self.tree[next] == tree && self.room(self.arc(tree, next, opposite(*side))) > 0
            };
            let rooted = |side: &usize| relative(side) && self.is_rooted(self.neighbour(node, *side));
            if let Some(side) = (0..SIDES).find(rooted) {
                self.parent[node] = Parent::Neighbour(side);
                continue;
            }
            let relatives: Vec<usize> = (0..SIDES).filter(relative).collect();
            for side in relatives {
                self.activate(self.neighbour(node, side));
            }
            self.leave(node);
        }
    }

    /// Frees a node and orphans its children.
    fn leave(&mut self, node: usize) {
        self.tree[node] = Tree::None;
        for side in 0..SIDES {
            let next = self.neighbour(node, side);
            if self.parent[next] == Parent::Neighbour(opposite(side)) {
                self.orphan(next);
            }
        }
    }

    fn is_rooted(&self, mut node: usize) -> bool {
        while let Parent::Neighbour(side) = self.parent[node] {
            node = self.neighbour(node, side);
        }
        self.parent[node] == Parent::Terminal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// Capacities from 0 to `most` on all arcs of a grid, drawn from a stream.
    struct Arcs {
        size: Size,
        right: Vec<u64>,
        down: Vec<u64>,
        source: Vec<u64>,
        sink: Vec<u64>,
    }

    impl Arcs {
        fn random(size: Size, most: usize, seed: u64) -> Self {
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
            let mut draw = || (0..size.texels()).map(|_| stream.below(most + 1) as u64).collect();
            Self { size, right: draw(), down: draw(), source: draw(), sink: draw() }
        }

        fn network(&self) -> GridNetwork {
            let mut network = GridNetwork::new(self.size);
            for node in 0..self.size.texels() {
                let (x, y) = (node % self.size.width, node / self.size.width);
                if x + 1 < self.size.width {
                    network.join_right(x, y, self.right[node]);
                }
                if y + 1 < self.size.height {
                    network.join_down(x, y, self.down[node]);
                }
                network.join_terminals(x, y, self.source[node], self.sink[node]);
            }
            network
        }

        /// The capacity of the arcs from nodes on the side of the source to others.
        fn capacity(&self, source_side: impl Fn(usize) -> bool) -> u64 {
            let between = |a: usize, b: usize, capacity: u64| {
                if source_side(a) == source_side(b) { 0 } else { capacity }
            };
            let node = |node: usize| {
                let right = if (node + 1).is_multiple_of(self.size.width) { node } else { node + 1 };
                let down = Some(node + self.size.width).filter(|d| *d < self.size.texels()).unwrap_or(node);
                let terminal = if source_side(node) { self.sink[node] } else { self.source[node] };
                between(node, right, self.right[node]) + between(node, down, self.down[node]) + terminal
            };
            (0..self.size.texels()).map(node).sum()
        }
    }

    #[test]
    fn flow_equals_the_least_cut_of_all_and_its_source_side_is_in_every_least_cut() {
        let sizes = [(1, 1), (1, 7), (5, 1), (2, 2), (3, 2), (2, 5), (3, 3), (4, 3)];
        for seed in 0..120 {
            let (width, height) = sizes[seed % sizes.len()];
            // Small capacities make many ties.
            let arcs = Arcs::random(Size::new(width, height), [1, 3, 50][seed % 3], seed as u64);
            let nodes = width * height;
            let capacity = |cut: u32| arcs.capacity(|node| cut >> node & 1 == 1);
            let least = (0..1 << nodes).map(capacity).min().unwrap();
            let common = (0..1 << nodes).filter(|cut| capacity(*cut) == least).fold(u32::MAX, |a, b| a & b);
            let found = arcs.network().minimum_cut();
            assert_eq!(found.value, least, "seed {seed}");
            let expected: Vec<bool> = (0..nodes).map(|node| common >> node & 1 == 1).collect();
            assert_eq!(found.source_side, expected, "seed {seed}");
        }
    }

    #[test]
    fn flow_fills_the_cut_it_gives_on_large_grids() {
        for (seed, most) in [1, 2, 10, 1 << 40].into_iter().cycle().take(40).enumerate() {
            let size = Size::new(1 + seed * 7 % 41, 1 + seed * 5 % 37);
            let arcs = Arcs::random(size, most, seed as u64);
            let found = arcs.network().minimum_cut();
            assert_eq!(arcs.capacity(|node| found.source_side[node]), found.value);
        }
    }
}
