//! One build, from inputs to a finished database.
//!
//! ```text
//! open      heads of all files: what do their coordinates and heights mean?             inputs
//! plan      reference system, spacing, grid; stored pages: all, or those near routes    plan, corridor
//! survey    sources in the grid; every height once, for the code and for wide voids     elevation_survey, cloud
//! raise     features and objects bound to the ground                                    feature_solids, object
//! write     each page of level 1, in parallel, in the order of the file:                writing
//!               taken over if it was made of the same before, or else made              build_cache, page
//!                   locate its voxels in each raster                                    warp
//!                   merge elevation by priority, fill voids                             kernel, mosaic, void_fill
//!                   drape imagery, tint what it leaves bare                             drape, tint
//!           each page of coarser levels: of the 16 below it, as far as they are stored,
//!               or else straight from the rasters                                       page
//! publish   metadata, header, name; or new pages go into the file that has the name     build_cache
//! ```
//!
//! Every sample is a function of its place in the grid and of the inputs, so two builds agree byte by byte,
//! whatever the number of threads and the memory (see [`super::budget`] for how that is shared out).

mod check;
mod job;
mod outline;
mod planned;
mod raised;
mod report;
mod surveyed;
mod written;

use std::time::Instant;

use crate::budget::Budget;
use crate::inputs::{self, Inputs};
use crate::options::BuildOptions;
use hedgehop_base::error::Result;
use hedgehop_base::progress::Observer;
use job::{BuildJob, BuildRecord};
use planned::PlannedBuild;
use raised::{RaisedBuild, StandingInputs};
use surveyed::SurveyedBuild;
use written::WrittenBuild;

pub use check::{check_name, check_output};
pub use outline::{Outline, outline};
pub use report::BuildReport;

/// Builds `options.output`. Nothing is left behind on error, on cancellation or on a kill that opens as a database.
pub fn build(options: &BuildOptions, observer: &dyn Observer) -> Result<BuildReport> {
    let begun = Instant::now();
    check_output(options)?;
    let budget = Budget::of(options)?;
    let inputs = inputs::open_all(options, budget.cache, observer)?;
    let mut report = build_from(inputs, options, budget, observer)?;
    report.seconds = begun.elapsed().as_secs_f64();
    Ok(report)
}

/// Makes the database from inputs that are open: plan, survey, raise, write, publish.
pub(super) fn build_from(
    mut inputs: Inputs,
    options: &BuildOptions,
    budget: Budget,
    observer: &dyn Observer,
) -> Result<BuildReport> {
    let job = BuildJob { options, budget: &budget, observer };

    let mut planned = PlannedBuild::new(&inputs, &job)?;
    let mut record = BuildRecord::new(planned.describe(&inputs, &job)?, observer);
    planned.prepare(&inputs, &job)?;

    let standing = StandingInputs::take_from(&mut inputs);
    let surveyed = SurveyedBuild::new(inputs, &planned, &job, &mut record)?;
    let raised = RaisedBuild::new(standing, &planned, &surveyed, &job, &mut record)?;
    let written = WrittenBuild::new(&planned, &surveyed, &raised, &job)?;
    written.publish(&planned, &surveyed, &raised, &job, record)
}
