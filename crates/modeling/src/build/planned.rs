//! Second phase: the place, the grid and the pages of the database.

use super::job::BuildJob;
use crate::build_cache::BuildCache;
use crate::corridor::Corridor;
use crate::disk_space::DiskSpace;
use crate::footprint::Bounds;
use crate::inputs::Inputs;
use crate::options::BuildOptions;
use crate::page_keys::SourceKeys;
use crate::plan::{self, Plan};
use crate::reach::Reach;
use crate::{fineness, sources, texture_match, vertical, warnings, warp};
use hedgehop::voxel::{Directory, ENTRY_BYTES, Metadata, PAGE_SIDE};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::VerticalDatum;

/// Build whose grid is known, and what a build before left for it.
pub(super) struct PlannedBuild {
    pub plan: Plan,
    /// Common datum of all heights.
    pub datum: VerticalDatum,
    /// Results of builds before, if the options allow them.
    pub cache: Option<BuildCache>,
    /// Keys of the inputs, where there is a cache.
    pub keys: Option<SourceKeys>,
    /// Pages that have more than an entry.
    reach: Reach,
    /// Whether something may stand on the ground.
    has_spans: bool,
}

impl PlannedBuild {
    /// Plans a build from its open inputs.
    ///
    /// # Errors
    /// The inputs have no common place; the directory does not fit into memory, or a file cannot be read.
    pub fn new(inputs: &Inputs, job: &BuildJob<'_>) -> Result<Self> {
        let BuildJob { options, budget, .. } = *job;
        let plan = plan::plan(inputs, options)?;
        let reach = Reach::of(inputs, &plan, options)?;
        if !plan.stored.is_all() {
            budget.check_directory(Directory::page_count(&plan.grid).map_err(Error::Configuration)?)?;
        }

        let datums: Vec<VerticalDatum> = inputs.elevation.iter().map(|raster| raster.datum).collect();
        let datum = vertical::common_datum(&datums, plan.crs.is_local());
        let cache =
            options.steps.then(|| BuildCache::of(&options.output).kept_for(options.kept_for.as_deref()));
        Ok(Self { plan, datum, cache, keys: None, reach, has_spans: inputs.has_spans() })
    }

    /// Refuses a disk without room, unless a build before left pages; then hashes the inputs for the cache.
    ///
    /// # Errors
    /// The disk has not the least that the build takes, or a file cannot be read.
    pub fn prepare(&mut self, inputs: &Inputs, job: &BuildJob<'_>) -> Result<()> {
        if !self.cache.as_ref().is_some_and(BuildCache::knows_pages) {
            self.disk_space(job.options).check(job.observer)?;
        }
        let keys_of = |cache| SourceKeys::of(inputs, &self.plan, self.datum, job.options, cache);
        self.keys = self.cache.as_ref().map(keys_of).transpose()?;
        Ok(())
    }

    /// Returns what the files of the build take.
    pub fn disk_space<'a>(&'a self, options: &'a BuildOptions) -> DiskSpace<'a> {
        DiskSpace { plan: &self.plan, output: &options.output, builds: self.has_spans, reach: &self.reach }
    }

    /// Returns cache and keys, if there is a cache.
    pub fn traced(&self) -> Option<(&BuildCache, &SourceKeys)> {
        self.cache.as_ref().zip(self.keys.as_ref())
    }

    /// Builds the metadata that are known before the first page.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn describe(&self, inputs: &Inputs, job: &BuildJob<'_>) -> Result<Metadata> {
        let BuildJob { options, budget, .. } = *job;
        let plan = &self.plan;
        let fineness = fineness::of_imagery(inputs, plan, options)?;

        let mut notes = inputs.notes.clone();
        notes.extend(plan.notes.iter().cloned());
        notes.extend(fineness.note);
        notes.extend(warnings::outside(options, &plan.grid).into_iter().map(|(_, note)| note));
        notes.extend(warnings::clouds_outside(inputs, plan)?);

        let mut detail = options.synthetic.below_voxel.clone();
        if let Some(examples) = &options.synthetic.examples {
            let matched = texture_match::find(examples, plan, options, budget)?;
            detail.get_or_insert_default().matched = Some(matched);
        }

        Ok(Metadata {
            crs_name: plan.crs.name().to_owned(),
            crs_epsg: plan.crs.epsg(),
            crs_proj: plan.crs.proj().map(str::to_owned),
            sources: sources::records(inputs, options, &plan.grid),
            corridors: options.corridors.iter().map(Corridor::record).collect(),
            notes,
            imagery_pixel: fineness.coarser_pixel,
            detail,
            writer: concat!("hedgehop ", env!("CARGO_PKG_VERSION")).to_owned(),
            ..Metadata::default()
        })
    }
}

/// Tells of an area that is mostly the gap between files that lie far apart: one of them may lie elsewhere than was thought.
pub(super) fn sparse_note(reaches: &[Bounds], plan: &Plan) -> Option<String> {
    const SPARSE: f64 = 0.25;
    let grid = &plan.grid;
    let (west, south) = warp::world(grid, 0.0, 0.0);
    let (east, north) = warp::world(grid, f64::from(grid.nx), f64::from(grid.ny));
    let covered: f64 = reaches
        .iter()
        .map(|[w, s, e, n]| (e.min(east) - w.max(west)).max(0.0) * (n.min(north) - s.max(south)).max(0.0))
        .sum();
    let share = covered / ((east - west) * (north - south));
    (plan.stored.is_all() && share < SPARSE).then(|| {
        format!(
            "elevation covers less than {:.2} % of the area of {} x {} voxels: the rest has no surface, and takes {ENTRY_BYTES} bytes \
             for each {PAGE_SIDE} x {PAGE_SIDE} of them; if that is not what is meant, look at where the files lie, or give --bbox",
            100.0 * share,
            grid.nx,
            grid.ny
        )
    })
}
