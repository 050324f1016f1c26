//! Spans over a short way, from which height to which.

use glam::DVec2;

use hedgehop::voxel::{
    BARE, BLOCK_SIDE, BlockSpans, PAGE_SIDE, PageId, PageSource, Span, SpanTable, SpansView,
};
use hedgehop_base::error::Result;

/// Matter over a way that does not leave a voxel. Places on the way are shares of it, 0…1, heights metres above the datum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab {
    /// Part of the way over which it is there.
    pub part: [f64; 2],
    /// Height of its lower end at both ends of the way, linear in between; −∞ of what stands on the ground.
    pub low: [f64; 2],
    /// Height of its upper end there.
    pub high: [f64; 2],
    /// Share of the light that a side of a voxel of it hides, 0…1.
    pub opacity: f64,
    /// Number of its material.
    pub material: u8,
}

/// Reads what stands over ways that lie near each other.
pub(super) struct Slabs<'a> {
    source: &'a dyn PageSource,
    /// The block that was asked for last, and what stands on it.
    block: Option<[u32; 2]>,
    spans: BlockSpans,
    found: Vec<Slab>,
}

impl<'a> Slabs<'a> {
    pub fn new(source: &'a dyn PageSource) -> Self {
        Self { source, block: None, spans: BlockSpans::default(), found: Vec::new() }
    }

    /// Returns the spans over a way within a voxel of the area (units from the area's corner), in the order in which they are stored. Both ends may be the same place.
    pub fn along(&mut self, ends: [DVec2; 2]) -> Result<&[Slab]> {
        self.found.clear();
        let header = self.source.header();
        if !header.has_spans {
            return Ok(&self.found);
        }
        let grid = &header.grid;
        let middle = 0.5 * (ends[0] + ends[1]);
        let voxel = [(middle.x, grid.nx), (middle.y, grid.ny)].map(|(at, count)| (at as u32).min(count - 1));
        self.turn_to(voxel)?;
        let centre = DVec2::from(voxel.map(f64::from)) + 0.5;
        let [x, y] = voxel.map(|voxel| voxel % PAGE_SIDE);
        let source = self.source;
        let spans = self.spans.of(x, y).iter();
        self.found.extend(spans.filter_map(|span| slab(source, span, ends.map(|end| end - centre))));
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

/// A span along a way whose ends are given in sides of its voxel from its centre; `None`: the way passes beside it.
fn slab(source: &dyn PageSource, span: &Span, ends: [DVec2; 2]) -> Option<Slab> {
    let (code, spacing) = (source.header().heights, source.header().grid.spacing);
    let height = |height: u16| code.offset + code.scale * f64::from(height);
    let mut part = [0.0, 1.0];
    for (index, (normal, distance)) in span.walls().enumerate() {
        let normal = DVec2::from(normal.map(f64::from));
        let beyond = ends.map(|at| normal.dot(at) - f64::from(distance));
        if index == 0 && span.is(Span::STRIP) {
            let half = 0.5 * (height(span.high) - height(span.low)) / spacing;
            part = clip(part, beyond.map(|beyond| beyond - half))?;
            part = clip(part, beyond.map(|beyond| -beyond - half))?;
        } else {
            part = clip(part, beyond)?;
        }
    }

    let rise = ends.map(|at| DVec2::from(span.slopes().map(f64::from)).dot(at) * spacing);
    let high = rise.map(|rise| height(span.high) + rise);
    let low = match span.low {
        Span::GROUND => [f64::NEG_INFINITY; 2],
        low if span.is(Span::PARALLEL) => rise.map(|rise| height(low) + rise),
        low => [height(low); 2],
    };
    if span.low != Span::GROUND {
        part = clip(part, [low[0] - high[0], low[1] - high[1]])?;
    }

    let opacity = match f64::from(span.opacity()) {
        own if span.is(Span::STRIP) => {
            1.0 - (1.0 - own).powf(spacing / (f64::from(span.thickness()) * code.scale))
        }
        own => own,
    };

    Some(Slab { part, low, high, opacity, material: span.material })
}

/// Clips a part of a way to where a quantity is not positive, which is linear along the way and known at its ends.
pub(super) fn clip([begin, end]: [f64; 2], beyond: [f64; 2]) -> Option<[f64; 2]> {
    let crossing = beyond[0] / (beyond[0] - beyond[1]);
    let left = match beyond.map(|beyond| beyond <= 0.0) {
        [true, true] => [begin, end],
        [true, false] => [begin, end.min(crossing)],
        [false, true] => [begin.max(crossing), end],
        [false, false] => return None,
    };
    (left[0] < left[1]).then_some(left)
}
