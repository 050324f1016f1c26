//! Continuity of terrain whose file is sound: faults of the sources and of how they were joined.
//!
//! ```text
//! for each stored page of the finest level, with some voxels around it:
//!     spikes, pits   a voxel above or below its eight neighbours by far more than these leave a plane
//!     seams          steps along a column or row that those beside it do not have
//!     terraces       few heights on a slope, most voxels level with their neighbours
//!     plateaus       connected voxels of one height: flat tops of steep peaks; of none: voids
//!     cracks         an apron that is not what the neighbour says
//! ```
//!
//! Ground is looked at under what stands on it. All lengths are judged by the side of a voxel, so that the same limits hold for drones and for satellites.
//! What a coarser level should be by the finer one is a matter of [`hedgehop::voxel::verify`].

mod plateaus;
mod seams;
mod spikes;
mod terraces;

use glam::DVec2;

use super::posts::{PostReader, Sheet};
use hedgehop::voxel::{APRON, HeightCode, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

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

    fn number(self) -> usize {
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

/// Limits by which ground is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContinuityLimits {
    /// Ratio to the roughness around it by which a spike or pit stands out.
    pub spike: f64,
    /// Ratio of a seam's steps to those beside it.
    pub seam: f64,
}

impl Default for ContinuityLimits {
    fn default() -> Self {
        Self { spike: 5.0, seam: 3.0 }
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

/// Looks for faults in the finest level of a database, where it is stored.
///
/// # Errors
/// [`Error::Configuration`]: limits that are not above 1; a page that is damaged; an interruption.
pub fn continuity<S: PageSource>(
    source: &S,
    limits: &ContinuityLimits,
    observer: &dyn Observer,
) -> Result<ContinuityReport> {
    if [limits.spike, limits.seam].iter().any(|limit| !(limit.is_finite() && *limit > 1.0)) {
        return Err(Error::Configuration("limits of continuity are factors above 1".into()));
    }

    let header = source.header();
    let (columns, rows) = header.grid.page_dims(0);
    let mut found = Found::default();
    let (mut plateaus, mut seams) = (plateaus::Plateaus::default(), seams::Seams::default());
    let reader = PostReader::new(source, 0, Sheet::Bare);
    observer.begin("continuity", u64::from(columns) * u64::from(rows), "pages");

    for id in (0..rows).flat_map(|py| (0..columns).map(move |px| PageId { level: 0, px, py })) {
        if observer.cancelled() {
            return Err(Error::Interrupted("the area was not looked at to its end".into()));
        }

        if source.has(id) {
            let patch = Patch::read(&reader, source, id)?;
            spikes::find(&patch, limits.spike, &mut found);
            seams.find(&patch, limits.seam);
            terraces::find(&patch, &mut found);
            plateaus.add(&patch, &mut found);
            crack(source, &patch, &mut found)?;
            found.report.pages += 1;
        }

        observer.advance(1);
    }

    observer.end();
    seams.join(header, &mut found);
    plateaus.join(&mut found);

    Ok(found.sorted())
}

/// Findings so far.
#[derive(Default)]
struct Found {
    report: ContinuityReport,
    kinds: [Vec<Finding>; 7],
}

impl Found {
    fn add(&mut self, finding: Finding) {
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

    fn sorted(mut self) -> ContinuityReport {
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
struct Patch {
    id: PageId,
    /// First voxel, column and row of the level.
    first: [i64; 2],
    size: [i64; 2],
    /// Voxels of the level.
    dims: [i64; 2],
    /// Codes, with a margin of [`MARGIN`], row 0 southernmost.
    codes: Vec<u16>,
    /// The same as heights, metres; NaN where there is no surface.
    heights: Vec<f32>,
    code: HeightCode,
    /// Side of a voxel, metres.
    side: f64,
    origin: DVec2,
}

impl Patch {
    fn read<S: PageSource>(reader: &PostReader<'_, S>, source: &S, id: PageId) -> Result<Self> {
        let header = source.header();
        let (width, height) = header.grid.page_size(id).unwrap_or((0, 0));
        let first = [id.px, id.py].map(|page| i64::from(page) * i64::from(PAGE_SIDE));
        let size = [width, height].map(i64::from);
        let around = |axis: usize| first[axis] - MARGIN..first[axis] + size[axis] + MARGIN;
        let codes = reader.codes(around(0), around(1))?.values;
        let (code, lowest) = (header.heights, header.height_range.0);

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

    fn height(&self, x: i64, y: i64) -> f32 {
        self.heights[self.index(x, y)]
    }

    fn code_at(&self, x: i64, y: i64) -> u16 {
        self.codes[self.index(x, y)]
    }

    /// Corner of a voxel of the page, metres.
    fn corner(&self, x: i64, y: i64) -> DVec2 {
        self.origin + DVec2::new((self.first[0] + x) as f64, (self.first[1] + y) as f64) * self.side
    }

    /// A finding at a voxel of the page, of itself alone.
    fn finding(&self, fault: Fault, x: i64, y: i64, size: f64) -> Finding {
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

/// Compares the page's apron with its neighbours: one finding where it differs most.
fn crack<S: PageSource>(source: &S, patch: &Patch, found: &mut Found) -> Result<()> {
    let apron = i64::from(APRON);
    let Some(own) = source.heights(patch.id)? else { return Ok(()) };
    let reader = PostReader::new(source, 0, Sheet::Surface);
    let around = |axis: usize| patch.first[axis] - apron..patch.first[axis] + patch.size[axis] + apron;
    let others = reader.codes(around(0), around(1))?;
    let (mut worst, mut voxels) = (None, 0);
    let pairs = own.heights.iter().zip(&others.values).enumerate();

    for (index, (stated, there)) in pairs.filter(|(_, (stated, there))| stated != there) {
        let stride = patch.size[0] + 2 * apron;
        let (x, y) = (index as i64 % stride - apron, index as i64 / stride - apron);
        let inside = |at: i64, axis: usize| (0..patch.dims[axis]).contains(&(patch.first[axis] + at));
        let owner = [x, y].map(|at| at.div_euclid(i64::from(PAGE_SIDE)));

        // Beside the area, and where the neighbour is not stored, nobody else says anything.
        if !inside(x, 0) || !inside(y, 1) || owner == [0, 0] {
            continue;
        }

        let neighbour = PageId {
            level: 0,
            px: (i64::from(patch.id.px) + owner[0]) as u32,
            py: (i64::from(patch.id.py) + owner[1]) as u32,
        };
        if !source.has(neighbour) {
            continue;
        }

        voxels += 1;
        let step = f64::from(stated.abs_diff(*there)) * patch.code.scale;
        if worst.is_none_or(|(_, _, known)| step > known) {
            worst = Some((x, y, step));
        }
    }

    if let Some((x, y, step)) = worst {
        found.add(Finding { voxels, ..patch.finding(Fault::Crack, x, y, step) });
    }

    Ok(())
}

#[cfg(test)]
mod tests;
