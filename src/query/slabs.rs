//! What stands over a place, from which height to which.

use glam::DVec2;

use crate::error::Result;
use crate::voxel::{BARE, BLOCK_SIDE, BlockSpans, PAGE_SIDE, PageId, PageSource, Span, SpanTable, SpansView};

/// Matter over a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab {
    /// Metres above the datum; −∞ of what stands on the ground.
    pub low: f64,
    pub high: f64,
    /// Share of the light that a side of a voxel of it hides, 0…1.
    pub opacity: f64,
}

/// Reads what stands over places that lie near each other.
pub(super) struct Slabs<'a, S: PageSource> {
    source: &'a S,
    /// The block that was asked for last, and what stands on it.
    block: Option<[u32; 2]>,
    spans: BlockSpans,
    found: Vec<Slab>,
}

impl<'a, S: PageSource> Slabs<'a, S> {
    pub fn new(source: &'a S) -> Self {
        Self { source, block: None, spans: BlockSpans::default(), found: Vec::new() }
    }

    /// What stands over a place of the area (metres of the database's system), lowest first.
    pub fn over(&mut self, place: DVec2) -> Result<&[Slab]> {
        self.found.clear();
        let header = self.source.header();
        if !header.is_built {
            return Ok(&self.found);
        }
        let grid = &header.grid;
        let units = (place - grid.origin) / grid.spacing;
        let voxel = [(units.x, grid.nx), (units.y, grid.ny)].map(|(at, count)| (at as u32).min(count - 1));
        self.turn_to(voxel)?;
        // From the voxel's centre, in sides of it.
        let at = units - DVec2::from(voxel.map(f64::from)) - 0.5;
        let [x, y] = voxel.map(|voxel| voxel % PAGE_SIDE);
        let slabs = self.spans.of(x, y).iter().filter_map(|span| slab(self.source, span, at));
        self.found.extend(slabs);
        Ok(&self.found)
    }

    fn turn_to(&mut self, voxel: [u32; 2]) -> Result<()> {
        let block = voxel.map(|voxel| voxel / BLOCK_SIDE);
        if self.block == Some(block) {
            return Ok(());
        }
        let header = self.source.header();
        let [px, py] = voxel.map(|voxel| voxel / PAGE_SIDE);
        let view = self.source.spans(PageId { level: BARE, px, py })?.unwrap_or(SpansView::NONE);
        let rise = SpanTable::rise(header.heights, header.grid.spacing);
        self.spans.gather(&view, &header.objects, voxel.map(|voxel| voxel % PAGE_SIDE), rise);
        self.block = Some(block);
        Ok(())
    }
}

/// A span at a place, in sides of its voxel from its centre; `None`: it is not there.
fn slab<S: PageSource>(source: &S, span: &Span, at: DVec2) -> Option<Slab> {
    let (code, spacing) = (source.header().heights, source.header().grid.spacing);
    let height = |height: u16| code.offset + code.scale * f64::from(height);
    if let Some((normal, distance)) = span.wall() {
        let beyond = DVec2::from(normal.map(f64::from)).dot(at) - f64::from(distance);
        let half = 0.5 * (height(span.high) - height(span.low)) / spacing;
        let is_inside = if span.is(Span::STRIP) { beyond.abs() <= half } else { beyond <= 0.0 };
        if !is_inside {
            return None;
        }
    }
    let rise = DVec2::from(span.slopes().map(f64::from)).dot(at) * spacing;
    let low = match span.low {
        Span::GROUND => f64::NEG_INFINITY,
        low if span.is(Span::PARALLEL) => height(low) + rise,
        low => height(low),
    };
    let high = height(span.high) + rise;
    (low < high).then(|| Slab { low, high, opacity: f64::from(span.opacity()) })
}
