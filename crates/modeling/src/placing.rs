//! Objects that pages place: collected while a build begins, laid over blocks while pages are made.

use super::features::PlacedSolid;
use super::materials::Materials;
use super::object::Shape;
use super::warp::Rect;
use hedgehop::voxel::{Grid, HeightCode, Placement, SharedObject, SharedObjects, Span};

/// Voxels that all objects may have together: all who open the database hold them in memory.
const MOST_VOXELS: usize = 1 << 22;

/// An object on the voxels of the area: its south-west one, and the placement without it.
pub(super) type Placed = ([i64; 2], Placement);

/// Solids and objects on a block.
pub(super) type Raised = (Vec<PlacedSolid>, Vec<Placed>);

/// Objects in the order of their numbers, on the finest voxels of a grid.
pub(super) struct Collection<'m> {
    grid: Grid,
    code: HeightCode,
    materials: &'m Materials,
    objects: Vec<SharedObject>,
    /// Voxels of all of them.
    voxels: usize,
}

impl<'m> Collection<'m> {
    /// Without any, for heights of a code.
    pub fn new(grid: Grid, code: HeightCode, materials: &'m Materials) -> Self {
        Self { grid, code, materials, objects: Vec::new(), voxels: 0 }
    }

    /// Takes a shape. Returns its number; `None` if there is no room for it, so that it has spans of its own wherever it stands.
    pub fn take(&mut self, shape: &Shape) -> Option<u16> {
        let voxels = self.voxels + shape.columns * shape.rows;
        if voxels > MOST_VOXELS || self.objects.len() >= SharedObjects::MOST {
            return None;
        }
        self.objects.push(shape.shared(&self.grid, self.code, self.materials)?);
        self.voxels = voxels;
        Some(self.objects.len() as u16 - 1)
    }

    /// The objects.
    pub fn into_shared(self) -> SharedObjects {
        SharedObjects::new(self.objects)
    }
}

/// The voxels of a block that an object lies over, by their index in it, each with its spans.
pub(super) fn covered<'o>(
    (first, placement): &Placed,
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
