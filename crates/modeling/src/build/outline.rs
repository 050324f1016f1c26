//! Build as far as the heads of its files tell of it.

use super::planned::sparse_note;
use crate::Input;
use crate::budget::Budget;
use crate::disk_space::DiskSpace;
use crate::inputs::FeatureInput;
use crate::options::BuildOptions;
use crate::reach::Reach;
use crate::{features, inputs, plan, warnings};
use hedgehop::voxel::Grid;
use hedgehop_base::error::Result;
use hedgehop_base::progress::Silent;
use hedgehop_geo::Crs;

/// Outline of a build that is not made yet.
#[derive(Debug)]
pub struct Outline {
    /// The database's reference system.
    pub crs: Crs,
    /// Grid of the database.
    pub grid: Grid,
    /// Bytes of the file at most, without what stands on the ground.
    pub most_bytes: u64,
    /// Notes on what the program chose or assumed.
    pub notes: Vec<String>,
    /// Inputs outside the area, which change nothing, a sentence for each: most often a mistake.
    pub outside: Vec<(Input, String)>,
}

/// Finds out what a build would make, from the heads of its files: no height is read.
///
/// # Errors
/// An input cannot be opened, read or placed, or the area has no grid: what [`build`](super::build()) refuses before it
/// reads heights.
pub fn outline(options: &BuildOptions) -> Result<Outline> {
    let budget = Budget::of(options)?;
    let inputs = inputs::open_all(options, budget.cache, &Silent)?;
    let plan = plan::plan(&inputs, options)?;
    let outside = warnings::all_outside(&inputs, &plan, options)?;
    let reaches =
        inputs.elevation.iter().map(|raster| Ok(raster.place(&plan)?.1)).collect::<Result<Vec<_>>>()?;
    let sparse = sparse_note(&reaches, &plan).filter(|_| !options.synthetic.has_base());
    // Features and objects may stand anywhere, but their bytes are not known yet.
    let reach = Reach::of(&inputs, &plan, options)?;
    let most_bytes =
        DiskSpace { plan: &plan, output: &options.output, builds: false, reach: &reach }.most_bytes();
    let told = inputs.features.into_iter().flat_map(|FeatureInput { mut layer, options }| {
        layer.notes.extend(features::unknown_columns(&layer, &options));
        layer.notes
    });
    let notes =
        inputs.notes.into_iter().chain(plan.notes.iter().cloned()).chain(told).chain(sparse).collect();
    Ok(Outline { crs: plan.crs, grid: plan.grid, most_bytes, notes, outside })
}
