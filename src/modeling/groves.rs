//! Objects that are stored once and placed many times; trees of woods among them.

use std::collections::{BTreeSet, HashMap};

use super::features::{Feature, Meaning, PlacedTree, Solid, TreeKind};
use super::materials::Materials;
use super::warp::Rect;
use crate::voxel::{Grid, HeightCode, Placement, SharedObject, SharedObjects, Span, SpanTable, Symmetry};

/// Voxels that all objects may have together, which are held in memory by all who open the database. Kinds of trees beyond that have spans of their
/// own wherever they stand.
pub(super) const MOST_VOXELS: usize = 1 << 22;

/// Kinds of trees, in the order of their numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Groves {
    kinds: Vec<TreeKind>,
    /// Number, and voxels to a side, of each.
    numbers: HashMap<TreeKind, (u16, usize)>,
}

/// An object on the voxels of the area: its south-west one, and the placement without it.
pub(super) type Placed = ([i64; 2], Placement);

/// What stands on a block: solids with the index of their voxel, and objects.
pub(super) type Raised = (Vec<(usize, Solid)>, Vec<Placed>);

impl Groves {
    /// All kinds that woods among `features` have.
    pub fn of(features: &[Feature], spacing: f64) -> Self {
        let woods = features.iter().filter_map(|feature| match &feature.meaning {
            Meaning::Wood(wood) => Some(wood.kinds(spacing)),
            _ => None,
        });
        let mut groves = Self::default();
        let mut voxels = 0;
        for kind in woods.flatten().collect::<BTreeSet<_>>() {
            let side = kind.side(spacing);
            voxels += side * side;
            let fits = side <= usize::from(SharedObject::MOST_VOXELS)
                && groves.kinds.len() < SharedObjects::MOST
                && voxels <= MOST_VOXELS;
            if fits {
                groves.numbers.insert(kind, (groves.kinds.len() as u16, side));
                groves.kinds.push(kind);
            }
        }
        groves
    }

    /// What they are made of on the finest voxels of a grid, by heights of this code.
    pub fn share(&self, grid: &Grid, code: HeightCode, materials: &Materials) -> Vec<SharedObject> {
        let object = |kind: &TreeKind| {
            let (side, mut solids) = kind.voxels(grid.spacing);
            materials.dress(&mut solids);
            let mut columns = vec![Vec::new(); side * side];
            solids.into_iter().for_each(|(index, solid)| columns[index].push(solid));
            shared([side as u16; 2], grid, code, |x, y| &columns[usize::from(y) * side + usize::from(x)])
        };
        self.kinds.iter().map(object).collect()
    }

    /// Where a tree stands as an object; `None` if its kind is none.
    pub fn placed(&self, tree: &PlacedTree, grid: &Grid, code: &HeightCode) -> Option<Placed> {
        let &(number, side) = self.numbers.get(&tree.kind)?;
        let voxel = ((tree.place - grid.origin) / grid.spacing).floor();
        let first = [voxel.x, voxel.y].map(|at| at as i64 - (side / 2) as i64);
        // Other bits than those that chose the kind.
        let symmetry = Symmetry::new(tree.hash >> 32);
        Some((first, Placement::new(number, symmetry, [0, 0], code.encode(tree.base_m))))
    }
}

/// An object of so many voxels, from solids over each of them whose heights count from its foot.
pub(super) fn shared<'s>(
    size: [u16; 2],
    grid: &Grid,
    code: HeightCode,
    solids_of: impl Fn(u16, u16) -> &'s [Solid],
) -> SharedObject {
    // Code 0 is kept for the ground.
    let above = HeightCode { offset: 0.0, ..code };
    SharedObject::new(size, SpanTable::rise(code, grid.spacing), |x, y, spans| {
        let first = spans.len();
        spans.extend(solids_of(x, y).iter().filter_map(|solid| solid.encode(&above, grid.spacing)));
        spans[first..].sort_by_key(|span| (span.low, span.high));
    })
}

/// Voxels of a block that something of an object lies over, by their index in it.
pub(super) fn covered<'o>(
    (first, placement): &'o Placed,
    object: &'o SharedObject,
    rect: Rect,
) -> impl Iterator<Item = (usize, impl Iterator<Item = Span> + 'o)> + 'o {
    let (first, placement, size) = (*first, *placement, object.size(*placement));
    let range = move |axis: usize, low: u32, high: u32| {
        let end = (first[axis] + i64::from(size[axis])).min(high.into());
        first[axis].max(low.into())..end
    };
    let voxels =
        range(1, rect.y0, rect.y1).flat_map(move |y| range(0, rect.x0, rect.x1).map(move |x| (x, y)));
    voxels.map(move |(x, y)| {
        let within = [(x - first[0]) as u16, (y - first[1]) as u16];
        (rect.index(x as u32, y as u32), object.spans_at(placement, within))
    })
}

/// A placement as the page over `rect` has it; `None` if it is too far away for that.
pub(super) fn on_page((first, placement): &Placed, rect: Rect) -> Option<Placement> {
    let place = |axis: usize, low: u32| i16::try_from(first[axis] - i64::from(low)).ok();
    Some(Placement { first: [place(0, rect.x0)?, place(1, rect.y0)?], ..*placement })
}
