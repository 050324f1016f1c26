//! Faults that were found, and the patch they are sought in.

use glam::DVec2;

use super::super::posts::PostReader;
use hedgehop::voxel::{HeightCode, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::Size;
use hedgehop_base::error::Result;

/// Voxels around a page that are looked at.
const MARGIN: i64 = 8;

/// Findings of a kind that are kept, at most: the worst.
const MOST_FINDINGS: usize = 100_000;

/// Kinds of faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fault {
    /// A voxel far above all of its neighbours.
    Spike,
    /// A voxel far below all of its neighbours.
    Pit,
    /// Steps along a straight column or row, as between tiles that do not fit.
    Seam,
    /// The level top of something steep, as of data that were cut at a height.
    FlatTop,
    /// A slope of few heights, as of data in whole metres.
    Terrace,
    /// Voxels without a surface.
    Void,
    /// A page that does not say of its neighbours what they say.
    Crack,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Spike, Self::Pit, Self::Seam, Self::FlatTop, Self::Terrace, Self::Void, Self::Crack];

    pub(super) fn number(self) -> usize {
        self as usize
    }
}

/// A fault, and where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Kind of fault.
    pub fault: Fault,
    /// Place where it is worst, metres of the database's system.
    pub place: DVec2,
    /// South-west and north-east corner of what it covers, metres.
    pub extent: [DVec2; 2],
    /// Height there, metres above the datum; NaN where there is no surface.
    pub height: f64,
    /// Severity, metres: of spikes and pits how far they stand out, of seams the mean step, of flat tops how far ground falls from voxel to voxel at their rim, of terraces from height to height, of voids
    /// the square root of their area, of cracks the largest difference.
    pub size: f64,
    /// Voxels that it has; of seams their length.
    pub voxels: u64,
    /// Whether it touches the edge of the area. Voids that do are the end of the data.
    pub is_at_edge: bool,
}

/// Findings so far.
#[derive(Default)]
pub(super) struct Found {
    pub(super) report: ContinuityReport,
    kinds: [Vec<Finding>; 7],
}

impl Found {
    pub(super) fn add(&mut self, finding: Finding) {
        let kind = finding.fault.number();
        if finding.fault == Fault::Void && finding.is_at_edge {
            self.report.ends += 1;
            return;
        }
        self.report.counts[kind] += 1;
        self.kinds[kind].push(finding);
        if self.kinds[kind].len() > 2 * MOST_FINDINGS {
            worst(&mut self.kinds[kind]);
        }
    }

    pub(super) fn sorted(mut self) -> ContinuityReport {
        self.kinds.iter_mut().for_each(worst);
        self.report.findings = self.kinds.into_iter().flatten().collect();
        self.report
    }
}

/// Keeps the worst, in their order.
fn worst(findings: &mut Vec<Finding>) {
    let place = |finding: &Finding| (finding.place.y, finding.place.x);
    findings.sort_by(|a, b| {
        let ((ay, ax), (by, bx)) = (place(a), place(b));
        b.size.total_cmp(&a.size).then(ay.total_cmp(&by)).then(ax.total_cmp(&bx))
    });
    findings.truncate(MOST_FINDINGS);
}

/// A page and what lies around it.
pub(super) struct Patch {
    pub(super) id: PageId,
    /// First voxel, column and row of the level.
    pub(super) first: [i64; 2],
    pub(super) size: [i64; 2],
    /// Voxels of the level.
    pub(super) dims: [i64; 2],
    /// Codes, with a margin of [`MARGIN`], row 0 southernmost.
    codes: Vec<u16>,
    /// The same as heights, metres; NaN where there is no surface.
    heights: Vec<f32>,
    pub(super) code: HeightCode,
    /// Side of a voxel, metres.
    pub(super) side: f64,
    origin: DVec2,
}

impl Patch {
    pub(super) fn read(reader: &PostReader<'_>, source: &dyn PageSource, id: PageId) -> Result<Self> {
        let header = source.header();
        let Size { width, height } = header.grid.page_size(id).unwrap_or_default();
        let first = [id.px, id.py].map(|page| i64::from(page) * i64::from(PAGE_SIDE));
        let size = [width, height].map(i64::from);
        let around = |axis: usize| first[axis] - MARGIN..first[axis] + size[axis] + MARGIN;
        let codes = reader.codes(around(0), around(1))?.values;
        let (code, lowest) = (header.heights, header.height_range.low);

        // From the lowest ground, single precision loses nothing that codes have.
        let height = |value: &u16| code.decode(*value).map_or(f32::NAN, |height| (height - lowest) as f32);
        let (nx, ny) = header.grid.dims(0);

        Ok(Self {
            id,
            first,
            size,
            dims: [nx, ny].map(i64::from),
            heights: codes.iter().map(height).collect(),
            codes,
            code,
            side: header.grid.spacing,
            origin: header.grid.origin,
        })
    }

    /// Returns the index of a voxel of the page in the planes; −8 … size + 7.
    fn index(&self, x: i64, y: i64) -> usize {
        ((y + MARGIN) * (self.size[0] + 2 * MARGIN) + x + MARGIN) as usize
    }

    pub(super) fn height(&self, x: i64, y: i64) -> f32 {
        self.heights[self.index(x, y)]
    }

    pub(super) fn code_at(&self, x: i64, y: i64) -> u16 {
        self.codes[self.index(x, y)]
    }

    /// Corner of a voxel of the page, metres.
    pub(super) fn corner(&self, x: i64, y: i64) -> DVec2 {
        self.origin + DVec2::new((self.first[0] + x) as f64, (self.first[1] + y) as f64) * self.side
    }

    /// A finding at a voxel of the page, of itself alone.
    pub(super) fn finding(&self, fault: Fault, x: i64, y: i64, size: f64) -> Finding {
        Finding {
            fault,
            place: self.corner(x, y) + 0.5 * self.side,
            extent: [self.corner(x, y), self.corner(x + 1, y + 1)],
            height: self.code.decode(self.code_at(x, y)).unwrap_or(f64::NAN),
            size,
            voxels: 1,
            is_at_edge: false,
        }
    }
}

/// Faults of a database's terrain.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContinuityReport {
    /// Findings by kind, the worst first; at most 100,000 of each.
    pub findings: Vec<Finding>,
    /// Number of each kind, in the order of [`Fault::ALL`]. Voids at the edge do not count.
    pub counts: [u64; 7],
    /// Voids at the edge of the area.
    pub ends: u64,
    /// Pages of the finest level that were looked at.
    pub pages: u64,
}

impl ContinuityReport {
    /// Returns the number of a kind.
    pub fn count(&self, fault: Fault) -> u64 {
        self.counts[fault.number()]
    }
}
