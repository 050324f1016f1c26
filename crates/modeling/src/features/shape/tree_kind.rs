//! Trees of woods: of each kind one is made of voxels, and stands in many places.

use glam::{DVec2, dvec2};

use super::super::kinds::{Leaf, Tree};
use super::super::meaning::crown;
use super::round::BoundTree;
use super::solid::{PlacedSolid, Square};

/// Heights of trees that are told apart differ by this many to a factor of two, diameters of crowns likewise.
const HEIGHTS: f64 = 16.0;
const CROWNS: f64 = 8.0;

/// Factors by which a kind's height and crown may differ from the tree's.
pub(super) const TALLER: f64 = 1.03;
pub(super) const WIDER: f64 = 1.08;

/// Kinds that differ by their leaves' shades alone.
const VARIANTS: u8 = 4;

/// A kind of tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TreeKind {
    is_needle: bool,
    height: i16,
    crown: i16,
    variant: u8,
}

/// A tree of a wood that stands on a voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedTree {
    /// Kind of the tree.
    pub kind: TreeKind,
    /// Place of its axis.
    pub place: DVec2,
    /// Height of the ground there, metres.
    pub base_m: f64,
    /// Hash that tells it from others.
    pub hash: u64,
}

impl TreeKind {
    /// The kind that comes nearest to a tree; `hash` tells it from others.
    pub(super) fn of(tree: &Tree, hash: u64) -> Self {
        let step = |metres: f64, steps: f64| (metres.max(0.1).log2() * steps).round() as i16;
        Self {
            is_needle: tree.leaf == Leaf::Needle,
            height: step(tree.height_m, HEIGHTS),
            crown: step(tree.crown_m, CROWNS),
            variant: (hash % u64::from(VARIANTS)) as u8,
        }
    }

    /// The kind that comes nearest to a height and a diameter of the crown, metres > 0.
    pub fn nearest(height_m: f64, crown_m: f64, leaf: Leaf) -> Self {
        Self::of(&Tree { height_m, crown_m, leaf, paint: crown(leaf) }, 0)
    }

    /// The height that trees of about this one have, metres.
    pub(super) fn height_like(height_m: f64) -> f64 {
        ((height_m.max(0.1).log2() * HEIGHTS).round() / HEIGHTS).exp2()
    }

    /// All kinds of trees of two heights (metres) and between, `tree` being one of a height that kinds have.
    pub(super) fn all_between(low_m: f64, high_m: f64, tree: impl Fn(f64) -> Tree) -> Vec<Self> {
        let [first, last] = [low_m, high_m].map(|height| (height.max(0.1).log2() * HEIGHTS).round() as i16);
        let heights = (first..=last).map(|step| f64::from(step) / HEIGHTS);
        heights
            .flat_map(|height| {
                let tree = tree(height.exp2());
                (0..VARIANTS).map(move |variant| Self::of(&tree, variant.into()))
            })
            .collect()
    }

    /// A tree of it.
    pub(super) fn tree(self) -> Tree {
        let leaf = if self.is_needle { Leaf::Needle } else { Leaf::Broad };
        let height_m = (f64::from(self.height) / HEIGHTS).exp2();
        let crown_m = (f64::from(self.crown) / CROWNS).exp2();
        Tree { height_m, crown_m, leaf, paint: crown(leaf) }
    }

    /// Voxels of this side (metres) along a side of it.
    pub fn side(self, spacing: f64) -> usize {
        2 * (0.5 * self.tree().crown_m / spacing).floor() as usize + 1
    }

    /// Raises it over voxels of this side (metres): how many of them eastward and northward, and its solids with their row-major index,
    /// metres above its foot. Its axis is that of the voxel in the middle.
    pub fn voxels(self, spacing: f64) -> (usize, Vec<PlacedSolid>) {
        let (tree, side) = (self.tree(), self.side(spacing));
        let square = Square { origin: DVec2::ZERO, first: [0, 0], spacing, columns: side, rows: side };
        let place = dvec2(0.5, 0.5) * side as f64 * spacing;
        let mut solids = Vec::new();
        BoundTree { place, base_m: 0.0, tree, hash: self.variant.into() }.raise(&square, &mut solids);
        (side, solids)
    }
}
