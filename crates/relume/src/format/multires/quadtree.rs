//! The square of a picture, and its tiles.

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::size::Size;

/// The places of the tiles of a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Quadtree {
    /// Of the picture.
    pub size: Size,
    /// The side of a tile, without its border.
    pub tile: usize,
    /// The side of the square: the tile's times a power of two.
    pub square: usize,
}

/// The texels of a tile around its side.
pub(super) const BORDER: usize = 1;

/// A node: its level, 0 for the root, and its column and row among the nodes of the level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TreeNode {
    pub level: u32,
    pub column: usize,
    pub row: usize,
}

impl Quadtree {
    /// The least tree of a picture.
    pub(super) fn of(size: Size, tile: usize) -> Self {
        let mut square = tile;
        while square < size.width.max(size.height) {
            square *= 2;
        }
        Self { size, tile, square }
    }

    pub(super) fn levels(&self) -> u32 {
        (self.square / self.tile).trailing_zeros() + 1
    }

    /// The left and the upper side of the picture in the square.
    pub(super) fn offset(&self) -> (usize, usize) {
        ((self.square - self.size.width) / 2, (self.square - self.size.height) / 2)
    }

    /// The texels of the square that a tile of a level covers along a side.
    pub(super) fn span(&self, level: u32) -> usize {
        self.square >> level
    }

    /// Whether a node and the picture have a point in common, if only of their sides.
    pub(super) fn touches(&self, node: TreeNode) -> bool {
        let span = self.span(node.level);
        let (left, top) = self.offset();
        let meets = |place: usize, first: usize, length: usize| {
            place * span <= first + length && first <= (place + 1) * span
        };
        meets(node.column, left, self.size.width) && meets(node.row, top, self.size.height)
    }

    /// The columns and the rows of the finest level that hold texels of the picture.
    pub(super) fn covered(&self) -> [std::ops::RangeInclusive<usize>; 2] {
        let (left, top) = self.offset();
        [(left, self.size.width), (top, self.size.height)]
            .map(|(first, length)| first / self.tile..=(first + length - 1) / self.tile)
    }

    /// The nodes of a level, in the order of their numbers.
    pub(super) fn nodes(level: u32) -> impl Iterator<Item = TreeNode> {
        (0..1usize << (2 * level)).map(move |at| {
            let bits = |odd: u32| (0..level).map(|b| (at >> (2 * b + odd) & 1) << b).sum();
            TreeNode { level, column: bits(0), row: bits(1) }
        })
    }
}

impl TreeNode {
    /// The number of a node in the tree, from 0.
    pub(super) fn index(self) -> u64 {
        (0..self.level).rev().fold(0, |index, bit| {
            let child = (self.column >> bit & 1) + 2 * (self.row >> bit & 1);
            4 * index + 1 + child as u64
        })
    }
}

/// The numbers N of the files of the tiles of the finest level, by column and row.
pub(super) type Leaves = BTreeMap<(usize, usize), u64>;

/// The leaves of a tree whose nodes are not listed.
pub(super) fn implied(tree: &Quadtree) -> Leaves {
    let [columns, rows] = tree.covered();
    let level = tree.levels() - 1;
    let places = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
    places.map(|(column, row)| ((column, row), TreeNode { level, column, row }.index() + 1)).collect()
}

/// The leaves of a list of nodes, each on a line: number, parent, four children, side of the tile, whether it is there,
/// and the box in the square with y up: least x, y, z, largest x, y, z.
pub(super) fn listed(lines: &[&str], tree: &Quadtree) -> Result<Leaves> {
    let wrong =
        |k: usize, what: &str| Error::invalid(format!("node {} of the tree in info.xml {what}", k + 1));
    let mut leaves = Leaves::new();
    for (k, line) in lines.iter().enumerate() {
        let numbers: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        if numbers.len() < 14 || numbers.iter().any(|n| !n.is_finite()) {
            return Err(wrong(k, "is not a line of 14 numbers"));
        }
        let is_leaf = numbers[2..6].iter().all(|child| *child < 0.0);
        if !is_leaf || numbers[7] == 0.0 {
            continue;
        }
        let place = |n: f64| n * tree.square as f64 / tree.tile as f64;
        let [column, row, right, bottom] =
            [place(numbers[8]), place(1.0 - numbers[12]), place(numbers[11]), place(1.0 - numbers[9])];
        let is_near = |a: f64, b: f64| (a - b).abs() < 1e-3;
        if !is_near(column, column.round())
            || !is_near(row, row.round())
            || !is_near(right - column, 1.0)
            || !is_near(bottom - row, 1.0)
        {
            return Err(wrong(k, "is not a square of one tile at the finest level"));
        }
        if !(1.0..1e15).contains(&numbers[0]) || column < -0.5 || row < -0.5 {
            return Err(wrong(k, "has a number or a place below 0"));
        }
        leaves.insert((column.round() as usize, row.round() as usize), numbers[0] as u64);
    }
    let [columns, rows] = tree.covered();
    for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
        if !leaves.contains_key(&(column, row)) {
            return Err(Error::invalid(format!(
                "the tree in info.xml has no tile in column {column} and row {row}: expected one, since the picture is there"
            )));
        }
    }
    Ok(leaves)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_have_the_numbers_of_their_parents_children() {
        assert_eq!(TreeNode { level: 0, column: 0, row: 0 }.index(), 0);
        let first: Vec<u64> = Quadtree::nodes(1).map(TreeNode::index).collect();
        assert_eq!(first, [1, 2, 3, 4]);
        // The lower left child of the upper right one.
        assert_eq!(TreeNode { level: 2, column: 2, row: 1 }.index(), 4 * 2 + 3);
        let third: Vec<u64> = Quadtree::nodes(3).map(TreeNode::index).collect();
        assert_eq!(third, (21..85).collect::<Vec<u64>>());
    }

    #[test]
    fn a_picture_lies_in_the_middle_of_its_square() {
        let tree = Quadtree::of(Size::new(601, 300), 256);
        assert_eq!((tree.square, tree.levels(), tree.offset()), (1024, 3, (211, 362)));
        assert_eq!(tree.covered(), [0..=3, 1..=2]);
        assert_eq!(Quadtree::of(Size::new(20, 30), 256).levels(), 1);
        // A side of the picture on a side of tiles.
        let even = Quadtree::of(Size::new(512, 1024), 256);
        assert_eq!(even.covered(), [1..=2, 0..=3]);
        assert!(even.touches(TreeNode { level: 2, column: 0, row: 0 }));
    }
}
