//! `info.xml`.

use std::fmt::Write;

use super::quadtree::{Leaves, Quadtree, TreeNode, implied, listed};
use crate::error::{Error, Result};
use crate::format::xml::{attribute, element};
use crate::job::Job;
use crate::size::Size;

/// The contents of a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MultiresKind {
    LrgbPtm,
    RgbPtm,
    Hsh,
    Image,
}

/// The kinds, with the words of the file.
const KINDS: [(&str, MultiresKind); 4] = [
    ("LRGB_PTM", MultiresKind::LrgbPtm),
    ("RGB_PTM", MultiresKind::RgbPtm),
    ("HSH_RTI", MultiresKind::Hsh),
    ("IMAGE", MultiresKind::Image),
];

/// What `info.xml` says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MultiresInfo {
    pub kind: MultiresKind,
    /// Functions of a channel.
    pub terms: usize,
    /// The two lists of the file, one number for each function.
    pub scale: Vec<f32>,
    pub bias: Vec<f32>,
    pub tree: Quadtree,
    /// The extension of the tiles.
    pub extension: &'static str,
}

/// More functions are not believed.
const MOST_TERMS: usize = 25;

impl MultiresInfo {
    /// The contents of a file, and the tiles of the finest level.
    pub(super) fn parse(bytes: &[u8], job: &Job) -> Result<(Self, Leaves)> {
        let text = String::from_utf8_lossy(bytes);
        let (root, content) = part(&text, "MultiRes")?;
        let extension = match attribute(root, "format") {
            None | Some("0") => "jpg",
            Some("1") => "png",
            Some(other) => {
                return Err(Error::unsupported(format!(
                    "the tiles of the folder have the format {}: expected 0, jpg, or 1, png",
                    shortened(other)
                )));
            }
        };
        let (attributes, inside) = part(content, "Content")?;
        let kind = kind(attribute(attributes, "type").unwrap_or_default())?;
        let (sizes, _) = part(inside, "Size")?;
        let size = Size::new(whole(sizes, "width", 1 << 24)?, whole(sizes, "height", 1 << 24)?);
        // Before the tiles are counted.
        job.check("the folder of tiles", size, 9)?;
        let terms = match kind {
            MultiresKind::Image => 1,
            MultiresKind::Hsh => whole(sizes, "coefficients", MOST_TERMS)?,
            MultiresKind::LrgbPtm | MultiresKind::RgbPtm => match whole(sizes, "coefficients", MOST_TERMS)? {
                6 => 6,
                n => {
                    return Err(Error::unsupported(format!(
                        "polynomials of {n} coefficients are not read: expected 6"
                    )));
                }
            },
        };
        let [scale, bias] = match kind {
            MultiresKind::Image => [Vec::new(), Vec::new()],
            _ => [numbers(inside, "Scale", terms)?, numbers(inside, "Bias", terms)?],
        };
        let (tree, leaves) = tree(part(content, "Tree")?.1, size)?;
        Ok((Self { kind, terms, scale, bias, tree, extension }, leaves))
    }

    /// The pictures of the folder.
    pub(super) fn pictures(&self) -> usize {
        match self.kind {
            MultiresKind::LrgbPtm => 3,
            MultiresKind::Image => 1,
            MultiresKind::RgbPtm | MultiresKind::Hsh => self.terms,
        }
    }

    /// The text of the file, with all nodes.
    pub(super) fn to_text(&self) -> String {
        let kind = KINDS.iter().find(|(_, kind)| *kind == self.kind).map_or("", |(word, _)| word);
        let Size { width, height } = self.tree.size;
        let list = |numbers: &[f32]| numbers.iter().map(|n| format!("{n} ")).collect::<String>();
        let Quadtree { tile, square, .. } = self.tree;
        let levels = self.tree.levels();
        let mut text = format!(
            "<!DOCTYPE WebMultiRes>\n<MultiRes format=\"0\">\n<Content type=\"{kind}\">\n<Size width=\"{width}\" \
             height=\"{height}\" coefficients=\"{}\"/>\n<Scale>{}</Scale>\n<Bias>{}</Bias>\n</Content>\n\
             <Tree>{} 0\n{tile}\n{square} {square} 255\n0 0 0\n",
            self.terms,
            list(&self.scale),
            list(&self.bias),
            (0..levels).map(|level| 1usize << (2 * level)).sum::<usize>(),
        );
        for node in (0..levels).flat_map(Quadtree::nodes) {
            self.line(node, levels, &mut text);
        }
        text + "</Tree>\n</MultiRes>\n"
    }

    /// The line of a node; see [`listed`].
    fn line(&self, node: TreeNode, levels: u32, text: &mut String) {
        let index = node.index();
        let parent = index.checked_sub(1).map_or(-1, |before| (before / 4) as i64);
        // Lower left, lower right, upper left, upper right.
        let child = |k: u64| if node.level + 1 < levels { (4 * index + k) as i64 } else { -1 };
        let side = 1.0 / (1u64 << node.level) as f64;
        let (left, top) = (node.column as f64 * side, 1.0 - node.row as f64 * side);
        let is_there = u8::from(self.tree.touches(node));
        let line = format_args!(
            "{} {parent} {} {} {} {} {} {is_there} {left} {} 0 {} {top} 1\n",
            index + 1,
            child(3),
            child(4),
            child(1),
            child(2),
            self.tree.tile,
            top - side,
            left + side,
        );
        text.write_fmt(line).expect("text grows");
    }
}

/// An element that has to be there.
fn part<'a>(text: &'a str, name: &str) -> Result<(&'a str, &'a str)> {
    element(text, name).ok_or_else(|| Error::invalid(format!("info.xml has no complete element {name}")))
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect::<String>().escape_debug().to_string()
}

fn kind(word: &str) -> Result<MultiresKind> {
    KINDS.iter().find(|(name, _)| *name == word).map(|(_, kind)| *kind).ok_or_else(|| {
        Error::unsupported(format!(
            "the folder holds the type '{}': expected LRGB_PTM, RGB_PTM, HSH_RTI or IMAGE",
            shortened(word)
        ))
    })
}

fn whole(attributes: &str, name: &str, most: usize) -> Result<usize> {
    let number = attribute(attributes, name).and_then(|n| n.parse().ok()).filter(|n| (1..=most).contains(n));
    number.ok_or_else(|| {
        Error::invalid(format!("the {name} in info.xml is not a whole number from 1 to {most}"))
    })
}

/// One number for each function; what follows is left.
fn numbers(text: &str, name: &str, count: usize) -> Result<Vec<f32>> {
    let words = part(text, name)?.1.split_whitespace().take(count);
    let numbers: Option<Vec<f32>> =
        words.map(|word| word.parse().ok().filter(|n: &f32| n.is_finite() && n.abs() <= 1e6)).collect();
    numbers.filter(|numbers| numbers.len() == count).ok_or_else(|| {
        Error::invalid(format!(
            "the element {name} of info.xml is not a list of {count} numbers of at most 1e6"
        ))
    })
}

/// The tree, and its tiles of the finest level.
fn tree(text: &str, size: Size) -> Result<(Quadtree, Leaves)> {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let number = |line: usize, word: usize, what: &str, least: usize| {
        let word = lines.get(line).and_then(|line| line.split_whitespace().nth(word));
        let number: Option<f64> = word.and_then(|word| word.parse().ok());
        number
            .filter(|n| n.fract() == 0.0 && (least as f64..=(1 << 24) as f64).contains(n))
            .map(|n| n as usize)
            .ok_or_else(|| {
                Error::invalid(format!("the tree in info.xml has no {what} of {least} to {}", 1 << 24))
            })
    };
    let (nodes, tile) = (number(0, 0, "number of nodes", 1)?, number(1, 0, "side of tiles", 16)?);
    let (square, other) = (number(2, 0, "side", 16)?, number(2, 1, "side", 16)?);
    let ratio = square / tile;
    if square != other || ratio * tile != square || !ratio.is_power_of_two() {
        return Err(Error::unsupported(format!(
            "the tree in info.xml covers {square} x {other} texels: expected a square of tiles of {tile} texels, times a \
             power of two"
        )));
    }
    if square < size.width.max(size.height) {
        return Err(Error::invalid(format!(
            "the tree in info.xml covers {square} x {square} texels, and the picture has {size}"
        )));
    }
    let tree = Quadtree { size, tile, square };
    match &lines[lines.len().min(4)..] {
        [] => Ok((tree, implied(&tree))),
        listing if listing.len() == nodes => Ok((tree, listed(listing, &tree)?)),
        listing => Err(Error::invalid(format!(
            "the tree in info.xml announces {nodes} nodes and lists {}: the file is incomplete",
            listing.len()
        ))),
    }
}
