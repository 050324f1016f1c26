//! Third phase: all inputs lie in the grid, and every height was looked at once.

use std::path::PathBuf;

use super::job::{BuildJob, BuildRecord};
use super::planned::{PlannedBuild, sparse_note};
use crate::cloud::{self, CloudSolids};
use crate::inputs::Inputs;
use crate::land_cover::{self, CoverInput};
use crate::mosaic;
use crate::naming::file_name;
use crate::opened::Opened;
use crate::options::{BuildOptions, NodataFill};
use crate::page::Project;
use crate::placed::{ElevationInput, ImageryInput};
use crate::plan::Plan;
use crate::survey_result::Survey;
use crate::synthetic::Roughness;
use crate::tint::Tint;
use crate::warp::Rect;
use crate::{elevation_survey, sources};
use hedgehop::voxel::{Grid, HeightCode, HeightRange, SharedObjects};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::VerticalDatum;

/// Build whose natural ground is known: sources in the grid, and the heights that they span.
pub(super) struct SurveyedBuild {
    pub elevation: Vec<ElevationInput>,
    pub imagery: Vec<ImageryInput>,
    pub land_cover: Vec<CoverInput>,
    /// Solids that point clouds show, if there are clouds with any.
    pub cloud_solids: Option<CloudSolids>,
    /// Colours of ground without imagery.
    pub tint: Tint,
    /// Heights of the natural ground, metres above the database's datum.
    pub heights: HeightRange,
    surveys: Vec<Survey>,
}

impl SurveyedBuild {
    /// Places all rasters and clouds of the inputs in the grid, and looks at every height once.
    ///
    /// # Errors
    /// A file cannot be read or placed, or no height lies in the area.
    pub fn new(
        mut inputs: Inputs,
        planned: &PlannedBuild,
        job: &BuildJob<'_>,
        record: &mut BuildRecord<'_>,
    ) -> Result<Self> {
        let BuildJob { options, budget, observer } = *job;
        let (plan, datum) = (&planned.plan, planned.datum);
        let imagery_paths: Vec<PathBuf> = inputs.imagery.iter().map(|raster| raster.path.clone()).collect();
        let clouds = std::mem::take(&mut inputs.clouds);

        // All that has a place in the grid, and notes on what lies elsewhere.
        let (land_cover, unknown) = cover(std::mem::take(&mut inputs.land_cover), plan, options)?;
        let (mut elevation, mut imagery) = place(inputs, plan, datum)?;
        record.notes(outsiders(&imagery_paths, &imagery, &plan.grid));
        record.notes(unknown);
        let reaches: Vec<_> = elevation.iter().map(|source| source.reach).collect();
        record.notes(sparse_note(&reaches, plan).filter(|_| !options.synthetic.has_base()));

        let mut cloud_solids = None;
        if !clouds.is_empty() {
            let prepared = cloud::prepare(&clouds, plan, datum, &options.output, budget, observer)?;
            // One raster holds the points of all; others say nothing then.
            for input in &mut elevation[..clouds.len()] {
                input.reach = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
            }
            elevation.iter_mut().zip(prepared.elevation).for_each(|(input, points)| *input = points);
            imagery.extend(prepared.imagery);
            cloud_solids = prepared.cloud_solids;
        }

        // Every height, once.
        let measure = options.synthetic.detail.is_some_and(|detail| detail.roughness == Roughness::Auto);
        let surveys =
            elevation_survey::survey(&elevation, plan, planned.traced(), measure, budget.threads, observer)?;
        let rough = sources::roughness(&surveys, &record.metadata.sources, clouds.len());
        record.notes(rough.into_iter().filter(|_| measure));
        record.notes(surveys.iter().flat_map(|survey| survey.notes.iter().cloned()));

        let heights = height_range(&elevation, &surveys, options, &plan.grid)?;
        let tint = Tint::new(heights.low, heights.high, !plan.crs.is_local());
        Ok(Self { elevation, imagery, land_cover, cloud_solids, tint, heights, surveys })
    }

    /// Returns the project of natural ground, without anything that stands on it.
    pub fn natural<'a>(
        &'a self,
        planned: &'a PlannedBuild,
        job: &BuildJob<'a>,
        shared: &'a SharedObjects,
    ) -> Project<'a> {
        let options = job.options;
        Project {
            grid: planned.plan.grid,
            stored: &planned.plan.stored,
            code: HeightCode::spanning(self.heights.low, self.heights.high),
            tint: self.tint,
            fill: options.nodata_fill,
            elevation: &self.elevation,
            surveys: &self.surveys,
            imagery: &self.imagery,
            land_cover: &self.land_cover,
            materials: &options.materials,
            synthetic: &options.synthetic,
            interpolation: options.interpolation,
            feature_solids: None,
            cloud_solids: None,
            objects: None,
            shared,
            window_bytes: job.budget.window,
        }
    }
}

/// Places all rasters in the grid.
fn place(
    inputs: Inputs,
    plan: &Plan,
    datum: VerticalDatum,
) -> Result<(Vec<ElevationInput>, Vec<ImageryInput>)> {
    let elevation = inputs.elevation.into_iter().map(|raster| ElevationInput::place(raster, plan, datum));
    let imagery = inputs.imagery.into_iter().map(|raster| ImageryInput::place(raster, plan));
    Ok((elevation.collect::<Result<_>>()?, imagery.collect::<Result<_>>()?))
}

/// Places maps of land cover, and tells what they hold that is no class.
fn cover(
    rasters: Vec<Opened<land_cover::SampleClass>>,
    plan: &Plan,
    options: &BuildOptions,
) -> Result<(Vec<CoverInput>, Vec<String>)> {
    let (mut placed, mut notes) = (Vec::new(), Vec::new());
    for (raster, file) in rasters.into_iter().zip(&options.land_cover) {
        let name = file_name(&raster.path);
        let input = CoverInput::place(raster, plan)?;
        notes.extend(land_cover::unknown(&input, &plan.grid, &name, file.scheme.name())?);
        placed.push(input);
    }
    Ok((placed, notes))
}

/// Imagery that has no part in the area: most often a wrong file or a wrong reference system.
fn outsiders(paths: &[PathBuf], imagery: &[ImageryInput], grid: &Grid) -> Vec<String> {
    let all = Rect { x0: 0, y0: 0, x1: grid.nx, y1: grid.ny };
    let outside = imagery.iter().zip(paths).filter(|(source, _)| !all.meets(&source.reach, grid));
    outside
        .map(|(source, path)| {
            let [west, south, east, north] = source.reach;
            format!(
                "{} lies outside the area and colours nothing: it is around x {:.0}, y {:.0}; \
                 check its reference system",
                path.display(),
                0.5 * (west + east),
                0.5 * (south + north)
            )
        })
        .collect()
}

/// Returns the heights that the code must hold, metres above the database's datum.
fn height_range(
    elevation: &[ElevationInput],
    surveys: &[Survey],
    options: &BuildOptions,
    grid: &Grid,
) -> Result<HeightRange> {
    let filled = match options.nodata_fill {
        NodataFill::Value(height) if !height.is_finite() => {
            return Err(Error::Configuration(format!("--nodata-fill {height} is no height in metres")));
        }
        NodataFill::Value(height) => Some((height, height)),
        NodataFill::None | NodataFill::Small | NodataFill::Interpolate => None,
    };

    let sampled = elevation.iter().zip(surveys).filter_map(|(source, survey)| {
        let ((low, high), shift) = (survey.range?, source.shift.range());
        let room = mosaic::room(source, low, high, options.interpolation, options.synthetic.detail.as_ref());
        Some((low - room + shift.0, high + room + shift.1))
    });
    let natural = sampled.chain(filled).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));

    let (low, high) = options.synthetic.heights(natural, grid).ok_or_else(|| {
        Error::Configuration(
            "no elevation file has a single height in the area; look at their nodata value, --nodata and --bbox".into(),
        )
    })?;
    Ok(HeightRange { low, high })
}
