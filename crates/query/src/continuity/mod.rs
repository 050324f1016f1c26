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

mod found;
mod plateaus;
mod seams;
mod spikes;
mod terraces;

pub use found::{ContinuityReport, Fault, Finding};

use super::posts::{PostReader, Sheet};
use crate::continuity::found::{Found, Patch};
use hedgehop::voxel::{APRON, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

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

/// Looks for faults in the finest level of a database, where it is stored.
///
/// # Errors
/// [`Error::Configuration`]: limits that are not above 1; a page that is damaged; an interruption.
pub fn continuity(
    source: &dyn PageSource,
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

/// Compares the page's apron with its neighbours: one finding where it differs most.
fn crack(source: &dyn PageSource, patch: &Patch, found: &mut Found) -> Result<()> {
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
