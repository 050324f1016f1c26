//! One build, from inputs to a finished database.
//!
//! ```text
//! open all rasters; what do their coordinates and heights mean?                     inputs
//! choose the database's reference system, spacing and grid                          plan
//! look at every height once: the range of the code, the broad shape for wide voids  scan
//! which pages are stored: all, or near routes only                                  corridor
//! for each page of level 1, in parallel, written in order:                          writing
//!     taken over if it was made of the same before, or else made:                   steps, page
//!     locate its voxels in each raster                                              warp
//!     merge elevation by priority, fill voids                                       kernel, mosaic, fill
//!     drape imagery, tint what it leaves bare                                       kernel, drape, tint
//! for each coarser level: each page from the 16 below it, as far as these are stored voxel
//!     the rest straight from the rasters, as level 1 is                             page
//! write metadata, header, give the file its name; or write pages that were made into the one that has it
//! ```
//!
//! Every sample is a function of its place in the grid and of the inputs, so two builds agree byte by byte,
//! whatever the number of threads and the memory (see [`super::budget`] for how that is shared out).

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::budget::Budget;
use super::build_cache::{self, BuildCache};
use super::corridor::Corridor;
use super::counts::PageCounts;
use super::disk_space::DiskSpace;
use super::feature_solids::{self, FeatureSolids};
use super::footprint::Bounds;
use super::inputs::{self, Inputs};
use super::land_cover::{self, CoverInput};
use super::naming::file_name;
use super::object::{Objects, ScatterFile};
use super::opened::Opened;
use super::options::{BuildOptions, NodataFill};
use super::page::Project;
use super::placed::{ElevationInput, ImageryInput};
use super::placing::Collection;
use super::plan::{self, Plan};
use super::reach::Reach;
use super::synthetic::Roughness;
use super::tint::Tint;
use super::warp::{self, Rect};
use super::writing::{Written, write_pages};
use super::{cloud, features, fineness, mosaic, scan, sources, vertical, warnings};
use crate::Input;
use crate::page::PageMaker;
use crate::page_keys::{PageKeys, SourceKeys};
use crate::surveyed::Survey;
use hedgehop::voxel::{
    ContentHash, Directory, ENTRY_BYTES, Grid, HeightCode, HeightRange, Metadata, PAGE_SIDE, PageWriter,
    SharedObjects,
};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::{Observer, Silent};
use hedgehop_geo::{Crs, VerticalDatum};

/// Report of a build.
#[derive(Debug, Clone)]
pub struct BuildReport {
    /// Grid that was built.
    pub grid: Grid,
    /// Identity of the result.
    pub content_hash: ContentHash,
    /// Bytes of the file.
    pub bytes: u64,
    /// Voxels that were made from the sources: all of level 1, and coarser ones outside of corridors.
    pub voxels: u64,
    /// Share of void voxels, 0…1.
    pub void_share: f64,
    /// Pages that were written.
    pub pages: u64,
    /// Pages of these that a build before made.
    pub reused: u64,
    /// Wall time, seconds.
    pub seconds: f64,
}

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
/// Those of [`build`] that show before heights are read.
pub fn outline(options: &BuildOptions) -> Result<Outline> {
    let budget = Budget::of(options)?;
    let inputs = inputs::open_all(options, budget.cache, &Silent)?;
    let plan = plan::plan(&inputs, options)?;
    let outside = warnings::all_outside(&inputs, &plan, options)?;
    let reaches =
        inputs.elevation.iter().map(|raster| Ok(raster.place(&plan)?.1)).collect::<Result<Vec<_>>>()?;
    let sparse = sparse_note(&reaches, &plan).filter(|_| !options.synthetic.has_base());
    // What stands on the ground is not counted, but may be anywhere.
    let reach = Reach::of(&inputs, &plan, options)?;
    let most_bytes =
        DiskSpace { plan: &plan, output: &options.output, builds: false, reach: &reach }.most_bytes();
    let told = inputs.features.into_iter().flat_map(|(mut layer, options)| {
        layer.notes.extend(features::unknown_columns(&layer, &options));
        layer.notes
    });
    let notes =
        inputs.notes.into_iter().chain(plan.notes.iter().cloned()).chain(told).chain(sparse).collect();
    Ok(Outline { crs: plan.crs, grid: plan.grid, most_bytes, notes, outside })
}

/// Bytes of a database's name: those of files have 255, and what is kept beside it is named after it.
const LONGEST_NAME: usize = 200;

/// Refuses an output that no database can be, whether anything may be replaced or not.
///
/// # Errors
/// It is an input, a folder or a device, or has no name that a file can have.
pub fn check_name(options: &BuildOptions) -> Result<()> {
    let name = options.output.to_string_lossy();
    let refuse =
        |what: String| Err(Error::Configuration(format!("{what}; name a file with -o, like AREA.hop")));
    if name.is_empty() {
        return refuse("the output has no name".into());
    }
    if name.contains('\0') {
        return refuse(format!(
            "{} has a NUL character in it, as no name can",
            name.replace('\0', "\u{fffd}")
        ));
    }

    // Of names that end so the system knows only after the pages were made that they are no files.
    let last = name.rsplit(std::path::is_separator).next().unwrap_or_default();
    if ["", ".", ".."].contains(&last) {
        return refuse(format!("{name} is a folder"));
    }
    if last.len() > LONGEST_NAME {
        return refuse(format!("{last} is too long a name: {LONGEST_NAME} bytes are the most"));
    }

    // Paths that do not resolve are no inputs that could be lost.
    if let Ok(output) = options.output.canonicalize() {
        let is_output = |input: &&PathBuf| input.canonicalize().is_ok_and(|input| input == output);
        let clouds = options.clouds.iter().map(|file| &file.path);
        let elevation = options.elevation.iter().map(|file| &file.path).chain(clouds);
        let imagery = options.imagery.iter().map(|file| &file.path);
        let land_cover = options.land_cover.iter().map(|file| &file.path);
        let features = options.features.iter().map(|file| &file.path);
        let models = options.objects.iter().flat_map(|file| &file.paths);
        let scattered = options.scatters.iter().flat_map(ScatterFile::paths);
        let routes = options.corridors.iter().map(|corridor| &corridor.route.file);
        let others = features.chain(models).chain(scattered).chain(routes);
        if let Some(input) = elevation.chain(imagery).chain(land_cover).chain(others).find(is_output) {
            return Err(Error::Configuration(format!(
                "{} is an input; name another file with -o, like AREA.hop",
                input.display()
            )));
        }
    }

    PageWriter::check_target(&options.output, true)
}

/// Refuses an output that must not be written, before any work is done.
///
/// # Errors
/// Those of [`check_name`]; it exists and may not be replaced, or lies where nothing can be written.
pub fn check_output(options: &BuildOptions) -> Result<()> {
    check_name(options)?;
    PageWriter::check_target(&options.output, options.overwrite)?;
    // A folder that is missing, or not writable, would show only after the heights were scanned.
    let folder = options.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    tempfile::tempfile_in(folder.unwrap_or(Path::new(".")))
        .map(drop)
        .map_err(|error| Error::io(&options.output, "create a file beside it", error))
}

/// All of a build after the files are open.
pub(super) fn build_from(
    mut inputs: Inputs,
    options: &BuildOptions,
    budget: Budget,
    observer: &dyn Observer,
) -> Result<BuildReport> {
    let plan = plan::plan(&inputs, options)?;
    let reach = Reach::of(&inputs, &plan, options)?;
    let room = DiskSpace { plan: &plan, output: &options.output, builds: inputs.has_spans(), reach: &reach };
    if !plan.stored.is_all() {
        budget.check_directory(Directory::page_count(&plan.grid).map_err(Error::Configuration)?)?;
    }

    let mut metadata = describe(&inputs, &plan, options)?;
    metadata.notes.extend(warnings::outside(options, &plan.grid).into_iter().map(|(_, note)| note));
    metadata.notes.extend(warnings::clouds_outside(&inputs, &plan)?);
    metadata.notes.iter().for_each(|note| observer.note(note));
    let datum = vertical::common_datum(&datums(&inputs), plan.crs.is_local());
    let cache = options.steps.then(|| BuildCache::of(&options.output).kept_for(options.kept_for.as_deref()));
    if !cache.as_ref().is_some_and(BuildCache::knows_pages) {
        room.check(observer)?;
    }

    let keys =
        cache.as_ref().map(|cache| SourceKeys::of(&inputs, &plan, datum, options, cache)).transpose()?;
    let traced = cache.as_ref().zip(keys.as_ref());
    let imagery_paths: Vec<PathBuf> = inputs.imagery.iter().map(|raster| raster.path.clone()).collect();
    let features = std::mem::take(&mut inputs.features);
    let clouds = std::mem::take(&mut inputs.clouds);
    let land_cover = cover(std::mem::take(&mut inputs.land_cover), &plan, options)?;
    let models = (std::mem::take(&mut inputs.objects), std::mem::take(&mut inputs.scatters));
    let (mut elevation, mut imagery) = place(inputs, &plan, datum)?;
    let misplaced = outsiders(&imagery_paths, &imagery, &plan.grid);
    let (land_cover, unknown) = land_cover;
    let misplaced = misplaced.into_iter().chain(unknown);
    let reaches: Vec<_> = elevation.iter().map(|source| source.reach).collect();
    for note in misplaced.chain(sparse_note(&reaches, &plan).filter(|_| !options.synthetic.has_base())) {
        observer.note(&note);
        metadata.notes.push(note);
    }

    let mut cloud_solids = None;
    if !clouds.is_empty() {
        let beside = (options.output.as_path(), &budget);
        let prepared = cloud::prepare(&clouds, &plan, datum, beside, observer)?;
        // One raster holds the points of all; others say nothing then.
        for input in &mut elevation[..clouds.len()] {
            input.reach = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        }
        elevation.iter_mut().zip(prepared.elevation).for_each(|(input, points)| *input = points);
        imagery.extend(prepared.imagery);
        cloud_solids = prepared.cloud_solids;
    }

    let measure = options.synthetic.detail.is_some_and(|detail| detail.roughness == Roughness::Auto);
    let surveys = scan::survey(&elevation, &plan, (traced, measure), budget.threads, observer)?;
    let rough = sources::roughness(&surveys, &metadata.sources, clouds.len());
    for note in rough.into_iter().filter(|_| measure) {
        observer.note(&note);
        metadata.notes.push(note);
    }

    for note in surveys.iter().flat_map(|survey| survey.notes.iter().cloned()) {
        observer.note(&note);
        metadata.notes.push(note);
    }

    let (low, high) = height_span(&elevation, &surveys, options, &plan.grid)?;
    let tint = Tint::new(low, high, !plan.crs.is_local());
    let natural = Project {
        grid: plan.grid,
        stored: &plan.stored,
        code: HeightCode::spanning(low, high),
        tint,
        fill: options.nodata_fill,
        elevation: &elevation,
        surveys: &surveys,
        imagery: &imagery,
        land_cover: &land_cover,
        materials: &options.materials,
        synthetic: &options.synthetic,
        interpolation: options.interpolation,
        feature_solids: None,
        cloud_solids: None,
        objects: None,
        shared: &SharedObjects::default(),
        window_bytes: budget.window,
    };

    let mut feature_solids = if features.is_empty() {
        None
    } else {
        let (features, notes) = feature_solids::place(&features, &plan)?;
        notes.iter().for_each(|note| observer.note(note));
        metadata.notes.extend(notes);
        let cache = traced.map(|(cache, keys)| (cache, keys.ground()));
        Some(FeatureSolids::new(
            features,
            || PageMaker::new(&natural),
            high,
            cache,
            budget.threads,
            observer,
        )?)
    };

    let mut objects = if models.0.is_empty() && models.1.is_empty() {
        None
    } else {
        let (objects, notes) =
            Objects::new(models, &plan, &mut PageMaker::new(&natural), (natural.materials, high))?;
        notes.iter().for_each(|note| observer.note(note));
        metadata.notes.extend(notes);
        Some(objects)
    };

    let tops = objects.as_ref().map_or(high, |objects| feature_solids::with_room(high, objects.highest()));
    let high = feature_solids.as_ref().map_or(high, |feature_solids| feature_solids.highest(high));
    let high = cloud_solids.as_ref().map_or(high, |cloud_solids| cloud_solids.highest(high));
    let code = HeightCode::spanning(low, high.max(tops));
    if let Some(note) = warnings::coarse_steps(HeightCode::spanning(low, high), code) {
        observer.note(&note);
        metadata.notes.push(note);
    }

    let mut collection = Collection::new(plan.grid, code, &options.materials);
    if let Some(feature_solids) = &mut feature_solids {
        feature_solids.share(plan.grid.spacing, &mut collection);
    }
    if let Some(objects) = &mut objects {
        objects.share(&plan.grid, &mut collection);
    }

    let shared = Arc::new(collection.into_shared());
    let (feature_solids, objects, cloud_solids) =
        (feature_solids.as_ref(), objects.as_ref(), cloud_solids.as_ref());
    let project = Project { code, feature_solids, cloud_solids, objects, shared: &shared, ..natural };
    let page_keys = keys.as_ref().map(|keys| {
        let sources = (&elevation[..], &imagery[..], &land_cover[..]);
        PageKeys::new(keys, sources, options.nodata_fill, (plan.grid, code), &tint, (feature_solids, objects))
            .with_shared(&shared)
    });
    let mut writer = PageWriter::create(&options.output, plan.grid, code, options.overwrite)?
        .with_objects(Arc::clone(&shared));
    writer.expect(room.most_bytes() + shared.to_bytes().len() as u64);
    let trace = cache.as_ref().zip(page_keys.as_ref());
    let mut writer = build_cache::begin(cache.as_ref(), writer, budget.changes)?;
    let mut written = Written::default();
    if let Err(error) = write_pages(&project, budget.threads, trace, &mut writer, &mut written, observer) {
        return Err(build_cache::kept(cache.as_ref(), writer, written.pages, error));
    }

    let counts = written.counts;
    if counts.empty == counts.voxels {
        return Err(Error::Configuration(format!(
            "no voxel of {} m gets a height: elevation data covers less than half of each; \
             choose a smaller --spacing or look at --bbox",
            plan.grid.spacing
        )));
    }

    let is_dressed = imagery.is_empty() || options.synthetic.has_colours();
    let bare = warnings::bare(&counts, is_dressed, !land_cover.is_empty());
    for note in bare.into_iter().chain(warnings::voids(&counts, options)) {
        observer.note(&note);
        metadata.notes.push(note);
    }

    let share = |count: u64| count as f64 / counts.voxels.max(1) as f64;
    metadata.vertical_datum = datum.label().to_owned();
    metadata.materials = options.materials.records(counts.classes.numbers());
    metadata.void_share = share(counts.voids);
    metadata.filled_share = Some(share(counts.filled)).filter(|share| *share > 0.0);
    metadata.empty_share = share(counts.empty);
    let range = decoded_range(&code, &counts);
    let (content_hash, bytes) = build_cache::publish(cache.as_ref(), writer, &metadata, range)?;

    Ok(BuildReport {
        grid: plan.grid,
        content_hash,
        bytes,
        voxels: counts.made,
        void_share: metadata.void_share,
        pages: written.pages,
        reused: written.reused,
        seconds: 0.0,
    })
}

fn datums(inputs: &Inputs) -> Vec<VerticalDatum> {
    inputs.elevation.iter().map(|raster| raster.datum).collect()
}

/// Builds the metadata that are known before the first page.
fn describe(inputs: &Inputs, plan: &Plan, options: &BuildOptions) -> Result<Metadata> {
    let mut notes = inputs.notes.clone();
    notes.extend(plan.notes.iter().cloned());
    let fineness = fineness::of_imagery(inputs, plan, options)?;
    notes.extend(fineness.note);
    Ok(Metadata {
        crs_name: plan.crs.name().to_owned(),
        crs_epsg: plan.crs.epsg(),
        crs_proj: plan.crs.proj().map(str::to_owned),
        sources: sources::records(inputs, options, &plan.grid),
        corridors: options.corridors.iter().map(Corridor::record).collect(),
        notes,
        imagery_pixel: fineness.coarser_pixel,
        writer: concat!("hedgehop ", env!("CARGO_PKG_VERSION")).to_owned(),
        ..Metadata::default()
    })
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
        notes.extend(land_cover::unknown(&input, &plan.grid, (&name, file.scheme.name()))?);
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

/// Tells of an area that is mostly the gap between files that lie far apart: one of them may lie elsewhere than was thought.
fn sparse_note(reaches: &[Bounds], plan: &Plan) -> Option<String> {
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

/// Heights that the code must hold, metres above the database's datum.
fn height_span(
    elevation: &[ElevationInput],
    surveys: &[Survey],
    options: &BuildOptions,
    grid: &Grid,
) -> Result<(f64, f64)> {
    let filled = match options.nodata_fill {
        NodataFill::Value(height) if !height.is_finite() => {
            return Err(Error::Configuration(format!("--nodata-fill {height} is no height in metres")));
        }
        NodataFill::Value(height) => Some((height, height)),
        NodataFill::None | NodataFill::Small | NodataFill::Interpolate => None,
    };

    let sampled = elevation.iter().zip(surveys).filter_map(|(source, survey)| {
        let ((low, high), shift) = (survey.range?, source.shift.range());
        let room =
            mosaic::room(source, (low, high), options.interpolation, options.synthetic.detail.as_ref());
        Some((low - room + shift.0, high + room + shift.1))
    });
    let natural = sampled.chain(filled).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));

    options.synthetic.heights(natural, grid).ok_or_else(|| {
        Error::Configuration(
            "no elevation file has a single height in the area; look at their nodata value, --nodata and --bbox".into(),
        )
    })
}

fn decoded_range(code: &HeightCode, counts: &PageCounts) -> HeightRange {
    let (low, high) = counts.codes.unwrap_or((1, 1));
    let height = |stored: u16| code.offset + code.scale * f64::from(stored);
    HeightRange { low: height(low), high: height(high) }
}
