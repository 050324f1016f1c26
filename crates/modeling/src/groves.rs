//! Trees of woods as objects that are placed.

use std::collections::{BTreeSet, HashMap};

use super::features::{Feature, Meaning, PlacedTree, TreeKind};
use super::object::Shape;
use super::placing::{Collection, Placed};
use hedgehop::voxel::{Grid, HeightCode, Placement, Symmetry};

/// Kinds of trees: the number, and voxels to a side, of each that is an object.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Groves(HashMap<TreeKind, (u16, usize)>);

impl Groves {
    /// All kinds that woods among `features` have on voxels of this side (metres), as far as there is room for them.
    pub fn of(features: &[Feature], spacing: f64, objects: &mut Collection<'_>) -> Self {
        let woods = features.iter().filter_map(|feature| match &feature.meaning {
            Meaning::Wood(wood) => Some(wood.kinds(spacing)),
            _ => None,
        });
        let kinds: BTreeSet<TreeKind> = woods.flatten().collect();
        let numbered = kinds.into_iter().filter_map(|kind| {
            let shape = Shape::planted(kind, spacing);
            Some((kind, (objects.take(&shape)?, shape.columns)))
        });
        Self(numbered.collect())
    }

    /// Places a tree as an object; `None` if its kind is none.
    pub fn placed(&self, tree: &PlacedTree, grid: &Grid, code: &HeightCode) -> Option<Placed> {
        let &(number, side) = self.0.get(&tree.kind)?;
        let voxel = ((tree.place - grid.origin) / grid.spacing).floor();
        let first = [voxel.x, voxel.y].map(|at| at as i64 - (side / 2) as i64);
        // Other bits than those that chose the kind.
        let symmetry = Symmetry::new(tree.hash >> 32);
        Some((first, Placement::new(number, symmetry, [0, 0], code.encode(tree.base_m))))
    }
}
