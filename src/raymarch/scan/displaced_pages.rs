//! Pages whose materials displaced ground depends on: those between an eye and where displacement ends along planes.

use std::collections::BTreeSet;

use glam::DVec2;

use super::PlaneGroup;
use crate::detail::Displacement;
use crate::simd::LANES;
use crate::voxel::{PAGE_SIDE, PageId, PageSource};

/// Posts around planes that they may come to by rounding.
const BESIDE: f64 = 2.0;

/// Length of stretches along planes whose pages are found one by one, units.
const STRETCH: f64 = 64.0;

/// Bits of a post's index within its page.
pub(super) const PAGE_BITS: u32 = PAGE_SIDE.trailing_zeros();

/// Pages of displaced ground, and the rectangle of posts that planes may come to on them.
#[derive(Debug)]
pub struct DisplacedPages {
    /// Level index: the finest one, or bare ground.
    pub(super) level: u8,
    pub(super) window: PostRect,
    ids: Vec<PageId>,
}

/// Posts of the finest level in a rectangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct PostRect {
    /// South-western and north-eastern post.
    pub low: [i64; 2],
    pub high: [i64; 2],
}

impl PostRect {
    /// No post at all.
    const NONE: Self = Self { low: [i64::MAX; 2], high: [i64::MIN; 2] };

    /// The least rectangle that holds both.
    fn with(&self, other: &Self) -> Self {
        Self {
            low: [0, 1].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1].map(|axis| self.high[axis].max(other.high[axis])),
        }
    }

    /// Posts that both hold.
    pub fn within(&self, other: &Self) -> Self {
        Self {
            low: [0, 1].map(|axis| self.low[axis].max(other.low[axis])),
            high: [0, 1].map(|axis| self.high[axis].min(other.high[axis])),
        }
    }

    /// Posts eastward and northward.
    pub fn size(&self) -> [usize; 2] {
        [0, 1].map(|axis| (self.high[axis] - self.low[axis] + 1) as usize)
    }
}

/// Iterates over the posts about stretches of a group's planes from an eye to a ground distance (units) in an area of so many posts.
fn stretches(group: &PlaneGroup, eye: DVec2, until: f64, dims: [i64; 2]) -> impl Iterator<Item = PostRect> {
    let ways = [0, LANES - 1].map(|lane| DVec2::from_array(group.way(lane)));
    let shortest = ways.iter().fold(f64::INFINITY, |shortest, way| shortest.min(way.length()));
    let end = until / shortest;
    (0..(end / STRETCH).ceil() as u32).map(move |part| {
        let ends = [part, part + 1].map(|part| (f64::from(part) * STRETCH).min(end));
        let [[a, b], [c, d]] = ways.map(|way| ends.map(|at| eye + way * at - 0.5));
        let post = |at: f64, axis: usize| (at.floor() as i64).clamp(0, dims[axis] - 1);
        let (low, high) = (a.min(b).min(c.min(d)) - BESIDE, a.max(b).max(c.max(d)) + BESIDE + 1.0);
        PostRect {
            low: [0, 1].map(|axis| post(low[axis], axis)),
            high: [0, 1].map(|axis| post(high[axis], axis)),
        }
    })
}

impl DisplacedPages {
    /// Finds the pages of a level, the finest one or bare ground, between an eye in units and where displacement ends in groups of planes.
    pub fn of(
        source: &dyn PageSource,
        displacement: &Displacement,
        level: u8,
        groups: impl Iterator<Item = PlaneGroup>,
    ) -> Self {
        let grid = source.header().grid;
        let dims = [grid.nx, grid.ny].map(i64::from);
        let mut window = PostRect::NONE;
        let mut pages = BTreeSet::new();
        for group in groups {
            for rect in stretches(&group, displacement.eye(), displacement.until(), dims) {
                window = window.with(&rect);
                let [px, py] = [0, 1].map(|axis| rect.low[axis] >> PAGE_BITS..=rect.high[axis] >> PAGE_BITS);
                pages.extend(py.flat_map(|py| px.clone().map(move |px| [px, py])));
            }
        }
        let ids = pages.into_iter().map(|[px, py]| PageId { level, px: px as u32, py: py as u32 });
        Self { level, window, ids: ids.map(|id| source.ground_of(id)).collect() }
    }

    /// Pages, bare ones where there are any.
    pub fn ids(&self) -> &[PageId] {
        &self.ids
    }
}
