//! The database's reference system and grid, from the inputs and what the user asked for.
//!
//! ```text
//! system:  --crs | that of the first elevation file, if it is metric and true to scale | the best for its area
//! spacing: --spacing | the side of a square as large as a pixel of the finest elevation file at its centre
//! phase:   voxel centres on pixel centres, if an elevation file has this system and spacing; else multiples of the spacing
//! extent:  all voxels whose centres lie within --bbox and the elevation's area; whole ones of the outer level around corridors
//!          all within --bbox if synthetic ground has a base: without elevation, --bbox, --spacing and --crs or --local must be given
//! ```
//!
//! A pixel in degrees is not square on the ground. The square of equal area gives as many voxels as there were pixels,
//! so a database is as large as its source, whatever the latitude; the smaller side would oversample more and
//! more towards the poles.

use std::path::Path;

use glam::DVec2;

use super::corridor::{self, Corridors, Stored};
use super::footprint::{self, Bounds, RasterFootprint, joined};
use super::inputs::{FeatureInput, Inputs};
use super::options::BuildOptions;
use super::vertical::{self, Shift};
use crate::Input;
use crate::naming::crs_label;
use crate::opened::Opened;
use hedgehop::Size;
use hedgehop::voxel::{Directory, Grid, RADIX, limits};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, Transform};

/// Part of a voxel or pixel by which rounding may displace a boundary.
const ROUNDING: f64 = 1.0e-6;

/// Place and grid of the database.
#[derive(Debug)]
pub(super) struct Plan {
    pub crs: Crs,
    pub grid: Grid,
    pub stored: Stored,
    pub notes: Vec<String>,
}

/// Chooses system and grid.
pub(super) fn plan(inputs: &Inputs, options: &BuildOptions) -> Result<Plan> {
    let mut notes = Vec::new();
    let crs = choose_crs(inputs, options, &mut notes)?;
    if let Some((_, error)) = strangers(inputs, &crs).into_iter().next() {
        return Err(error);
    }

    let spacing = match options.spacing.or(corridor::finest(&options.corridors)?) {
        Some(spacing) => {
            limits::check_spacing(spacing)
                .map_err(|what| Error::Configuration(format!("--spacing: {what}")))?;
            spacing
        }
        None if inputs.elevation.is_empty() => return Err(needed("--spacing", "10")),
        None => {
            let spacing = finest_spacing(&inputs.elevation, options.bbox, &crs)?;
            worth_it(&inputs.elevation, options.bbox, spacing, &crs)?;
            notes.extend(coarse_note(&inputs.imagery, &crs, spacing)?);
            spacing
        }
    };

    let area = match options.bbox {
        None if inputs.elevation.is_empty() => return Err(needed("--bbox", "0,0,8000,8000")),
        None => union(&inputs.elevation, &crs)?,
        Some(bbox) if options.synthetic.has_base() => an_area(bbox, &crs)?,
        Some(bbox) => clip(bbox, union(&inputs.elevation, &crs)?, &crs, &mut notes)?,
    };
    let crs = settled(&crs, area)?;

    // Points lie where they lie.
    let mut rasters = inputs.elevation.iter().skip(inputs.clouds.len());
    let phase = rasters.find_map(|raster| phase_of(raster, &crs, spacing)).unwrap_or((0.0, 0.0));
    let (west, nx) = axis(area[0], area[2], phase.0, spacing)?;
    let (south, ny) = axis(area[1], area[3], phase.1, spacing)?;
    let mut grid = Grid { nx, ny, spacing, origin: DVec2::new(west, south) };

    // Before anybody goes through all of them.
    grid.check().and_then(|()| Directory::page_count(&grid)).map_err(Error::Configuration)?;
    if options.corridors.is_empty() {
        return Ok(Plan { crs, stored: Stored::all(&grid), grid, notes });
    }

    let coarsest = match inputs.elevation.is_empty() {
        // What is made by a rule has no pixels: as finely as one sees from a kilometre or so.
        true => spacing * f64::from(RADIX * RADIX),
        false => coarsest_spacing(&inputs.elevation, &crs)?,
    };
    let coarsest = coarsest.min(grid.side(grid.level_count() - 1));
    let corridors = Corridors::new(&options.corridors, &crs, spacing, options.outside, coarsest)?;
    cut_to_whole_voxels(&mut grid, corridors.outside)?;
    let stored = Stored::within(&grid, &corridors)?;

    Ok(Plan { crs, grid, stored, notes })
}

/// Leaves out, in the east and north, what makes no whole voxel of the level that is stored outside of corridors: the sources say
/// nothing of its middle.
fn cut_to_whole_voxels(grid: &mut Grid, outside: u8) -> Result<()> {
    let side = Grid::side_units(outside);
    if grid.nx < side || grid.ny < side {
        return Err(Error::Configuration(format!(
            "the area of {} x {} voxels of {} m is smaller than a voxel of {} m, as they are stored outside of corridors; \
             give a smaller --outside, or leave out --corridor",
            grid.nx,
            grid.ny,
            grid.spacing,
            grid.side(outside)
        )));
    }
    (grid.nx, grid.ny) = (grid.nx / side * side, grid.ny / side * side);
    Ok(())
}

fn choose_crs(inputs: &Inputs, options: &BuildOptions, notes: &mut Vec<String>) -> Result<Crs> {
    Ok(match &options.crs {
        Some(text) => {
            let crs = Crs::from_user(text)?;
            if !crs.is_metric() {
                return Err(Error::Configuration(format!(
                    "--crs {text} is not in metres, as a database must be; leave it out to get the best system for the area, or name a UTM zone"
                )));
            }
            notes.extend(scale_note(&crs));
            crs
        }
        None if inputs.elevation.is_empty() && options.local => Crs::local(),
        None if inputs.elevation.is_empty() => {
            return Err(Error::Configuration(
                "without elevation nothing says where the place is; say --local for plain metres, or name a metric system with --crs".into(),
            ));
        }
        None if is_suitable(&inputs.elevation[0].crs) => inputs.elevation[0].crs.clone(),
        None => {
            let area = footprint::on_earth(&inputs.elevation)?.ok_or_else(|| nowhere(&Crs::wgs84()))?;
            let crs = Crs::metric_for(area);
            notes.extend(scale_note(&crs));
            crs
        }
    })
}

/// The system with the shift of its datum that holds in the middle of the area.
fn settled(crs: &Crs, area: Bounds) -> Result<Crs> {
    if crs.is_local() {
        return Ok(crs.clone());
    }
    let (x, y) = (area[0].midpoint(area[2]), area[1].midpoint(area[3]));
    let place = Transform::new(crs, &Crs::wgs84())?.apply(x, y);
    Ok(place.map_or_else(|| crs.clone(), |(longitude, latitude)| crs.settled(longitude, latitude)))
}

/// Finds the faults of files that are sound by themselves, but not in the database; nothing where there can be none, as [`plan`] tells.
pub(super) fn misfits(inputs: &Inputs, options: &BuildOptions) -> Vec<(Input, Error)> {
    let Ok(plan) = plan(inputs, options) else {
        return choose_crs(inputs, options, &mut Vec::new())
            .map_or(Vec::new(), |crs| strangers(inputs, &crs));
    };
    let datums: Vec<_> = inputs.elevation.iter().map(|raster| raster.datum).collect();
    let datum = vertical::common_datum(&datums, plan.crs.is_local());
    let heights = datums.iter().enumerate().map(|(index, from)| {
        let shift = Shift::between(*from, datum, &plan.grid, &plan.crs);
        (elevation(inputs, index), shift.map(drop))
    });
    let objects =
        (0..).zip(&inputs.objects).map(|(index, object)| (Input::Object(index), object.fits(&plan.grid)));
    let scatters = (0..).zip(&inputs.scatters).map(|(index, scatter)| {
        (Input::Scatter(index), scatter.fits(&plan.grid).and_then(|()| scatter.areas(&plan.crs).map(drop)))
    });
    heights.chain(objects).chain(scatters).filter_map(|(input, fits)| Some((input, fits.err()?))).collect()
}

/// The file that a raster of heights stands for.
fn elevation(inputs: &Inputs, index: usize) -> Input {
    match index.checked_sub(inputs.clouds.len()) {
        None => Input::Cloud(index),
        Some(index) => Input::Elevation(index),
    }
}

/// Files in plain metres, if the database is a place on Earth, or the other way round.
fn strangers(inputs: &Inputs, crs: &Crs) -> Vec<(Input, Error)> {
    let mut strangers = Vec::new();
    let mut meet = |input: Input, path: &Path, own: &Crs, said_by: &str| {
        if own.is_local() != crs.is_local() {
            let remedy = match crs.is_local() {
                true => format!(
                    "name a system on Earth with --crs, or say {said_by} local if it states none and has plain metres"
                ),
                false => format!(
                    "name its system with {said_by}, and put a world file to it if it has no georeferencing"
                ),
            };

            let (path, own, name) = (path.display(), own.name(), crs.name());
            let what = format!(
                "{path}: is in {own} and the database in {name}: plain metres and places on Earth do not go together; {remedy}; \
                 or build without it"
            );
            strangers.push((input, Error::Configuration(what)));
        }
    };

    for (index, raster) in inputs.elevation.iter().enumerate() {
        let said_by = if index < inputs.clouds.len() { "--cloud-crs" } else { "--elevation-crs" };
        meet(elevation(inputs, index), &raster.path, &raster.crs, said_by);
    }

    for (index, raster) in inputs.imagery.iter().enumerate() {
        meet(Input::Imagery(index), &raster.path, &raster.crs, "--imagery-crs");
    }
    for (index, raster) in inputs.land_cover.iter().enumerate() {
        meet(Input::LandCover(index), &raster.path, &raster.crs, "--land-cover-crs");
    }
    for (index, FeatureInput { layer, .. }) in inputs.features.iter().enumerate() {
        meet(Input::Features(index), &layer.path, &layer.crs, "`crs` of [[features]]");
    }

    for (index, scatter) in inputs.scatters.iter().enumerate() {
        if let Some(layer) = &scatter.area {
            meet(Input::Scatter(index), &layer.path, &layer.crs, "`crs` of [[scatter]]");
        }
    }

    strangers
}

/// Tells whether the system is in metres, and true to scale.
fn is_suitable(crs: &Crs) -> bool {
    crs.is_metric() && !is_mercator(crs)
}

/// Builds the error of something that only elevation could have said otherwise.
fn needed(flag: &str, example: &str) -> Error {
    Error::Configuration(format!("without elevation {flag} is needed, as in {flag} {example}"))
}

/// Says where metres of the map are none of the ground, if it is so far from true that pictures show it.
fn scale_note(crs: &Crs) -> Option<String> {
    if is_mercator(crs) {
        return Some(format!(
            "lengths of {} are stretched away from the equator; heights are not",
            crs_label(crs)
        ));
    }
    crs.proj().is_some_and(|proj| proj.contains("+proj=eqc")).then(|| {
        format!(
            "lengths of {} from west to east are true at its equator alone: at 60° of latitude they are twice those of the ground; \
             for a smaller area give --bbox and its UTM zone with --crs",
            crs_label(crs)
        )
    })
}

/// Mercator in any guise: metres that are longer on the map than on the ground.
fn is_mercator(crs: &Crs) -> bool {
    crs.proj().is_some_and(|proj| proj.contains("+proj=merc") || proj.contains("+proj=webmerc"))
}

/// Pixel side of the finest raster, metres.
fn finest_spacing(elevation: &[Opened<f64>], bbox: Option<Bounds>, crs: &Crs) -> Result<f64> {
    // What lies elsewhere says nothing of this area.
    let meets = |raster: &Opened<f64>| -> Result<bool> {
        let (Some([west, south, east, north]), RasterFootprint::Whole(own)) = (bbox, raster.footprint(crs)?)
        else {
            return Ok(true);
        };
        Ok(own[0] < east && own[2] > west && own[1] < north && own[3] > south)
    };
    let meet = elevation.iter().map(meets).collect::<Result<Vec<_>>>()?;
    let none_does = !meet.contains(&true);
    let mut finest: Option<(f64, bool)> = None;

    for (raster, meets) in elevation.iter().zip(meet) {
        let Some(side) = raster.pixel_side(crs)?.filter(|_| meets || none_does) else { continue };
        if finest.is_none_or(|(finest, _)| side < finest) {
            finest = Some((side, Transform::new(&raster.crs, crs)?.is_identity()));
        }
    }

    match finest {
        Some((side, true)) => Ok(side),
        Some((side, false)) => Ok(rounded(side)),
        None => Err(Error::Configuration(format!(
            "no elevation file has its centre in the domain of {}; choose another system with --crs, or a --spacing",
            crs_label(crs)
        ))),
    }
}

/// Refuses a spacing that nobody chose where it makes far more voxels than the files have pixels: a file among them has pixels that
/// are much too small, most often because its georeferencing is wrong.
fn worth_it(elevation: &[Opened<f64>], bbox: Option<Bounds>, spacing: f64, crs: &Crs) -> Result<()> {
    /// Voxels that are made in a minute or so, whatever of.
    const FEW: f64 = 67_108_864.0;
    /// Voxels of a pixel: a metre in the place of 64.
    const MOST: f64 = 4096.0;

    let (mut voxels, mut pixels) = (0.0, 0.0);
    let (mut finest, mut coarsest): (Option<(f64, &Path)>, f64) = (None, 0.0);
    for raster in elevation {
        let (RasterFootprint::Whole(own) | RasterFootprint::Partial(own)) = raster.footprint(crs)? else {
            continue;
        };
        let side = raster.pixel_side(crs)?.unwrap_or(spacing);
        let [west, south, east, north] = bbox.map_or(own, |bbox| common(own, bbox));
        let area = (east - west).max(0.0) * (north - south).max(0.0);
        voxels += area / (spacing * spacing);
        pixels += area / (side * side);
        coarsest = side.max(coarsest);
        if finest.is_none_or(|(least, _)| side < least) {
            finest = Some((side, &raster.path));
        }
    }

    let Some((side, path)) = finest.filter(|_| voxels > FEW && voxels > MOST * pixels) else { return Ok(()) };
    Err(Error::Configuration(format!(
        "{} has pixels of {} m, and at that spacing the area takes {voxels:.1e} voxels, {:.0} times as many as the files have pixels; \
         choose one, as in --spacing {}, or see whether the georeferencing of that file is right",
        path.display(),
        rounded(side),
        voxels / pixels,
        rounded(coarsest)
    )))
}

/// Pixel side of the coarsest raster, metres; 0 if none has its centre in the domain of `crs`.
fn coarsest_spacing(elevation: &[Opened<f64>], crs: &Crs) -> Result<f64> {
    let mut sides = elevation.iter().map(|raster| raster.pixel_side(crs));
    sides.try_fold(0.0, |coarsest: f64, side| Ok(side?.map_or(coarsest, |side| coarsest.max(side))))
}

/// Says when voxels as large as the pixels of elevation blur imagery that is much finer.
fn coarse_note(imagery: &[Opened<[u8; 4]>], crs: &Crs, spacing: f64) -> Result<Option<String>> {
    /// Pixels of a voxel's side that are worth a word: as many as make a visible difference.
    const MUCH: f64 = 2.0;
    let mut finest = f64::INFINITY;
    for raster in imagery {
        finest = raster.pixel_side(crs)?.map_or(finest, |side| finest.min(side));
    }
    Ok((MUCH * finest <= spacing).then(|| {
        let growth = (spacing / finest).powi(2);
        format!(
            "voxels are as large as the pixels of elevation and lose detail of the imagery; \
             --spacing {} keeps it and makes the database about {growth:.0} times as large",
            rounded(finest)
        )
    }))
}

/// Rounds to three significant digits: a reprojected raster has no spacing of its own to keep.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Bounds of all rasters together, in `crs`.
fn union(rasters: &[Opened<f64>], crs: &Crs) -> Result<Bounds> {
    let mut all: Option<Bounds> = None;
    for raster in rasters {
        if let RasterFootprint::Whole(bounds) | RasterFootprint::Partial(bounds) = raster.footprint(crs)? {
            all = Some(joined(all.unwrap_or(bounds), bounds));
        }
    }
    all.ok_or_else(|| nowhere(crs))
}

fn nowhere(crs: &Crs) -> Error {
    Error::Configuration(format!(
        "the elevation lies outside the domain of {}; choose another system with --crs",
        crs_label(crs)
    ))
}

fn an_area(bbox: Bounds, crs: &Crs) -> Result<Bounds> {
    let [west, south, east, north] = bbox;
    if !(bbox.iter().all(|side| side.is_finite()) && west < east && south < north) {
        return Err(Error::Configuration(format!(
            "--bbox {west},{south},{east},{north} is no area; give west,south,east,north in {}",
            crs_label(crs)
        )));
    }
    Ok(bbox)
}

fn clip(bbox: Bounds, data: Bounds, crs: &Crs, notes: &mut Vec<String>) -> Result<Bounds> {
    let [west, south, east, north] = an_area(bbox, crs)?;
    let both = common([west, south, east, north], data);
    if both[0] >= both[2] || both[1] >= both[3] {
        return Err(Error::Configuration(format!(
            "--bbox {west},{south},{east},{north} lies outside the elevation, which covers {},{},{},{} in {}",
            data[0],
            data[1],
            data[2],
            data[3],
            crs_label(crs)
        )));
    }

    if both != bbox {
        notes.push(format!(
            "--bbox reaches beyond the elevation and was cut to {},{},{},{}",
            both[0], both[1], both[2], both[3]
        ));
    }

    Ok(both)
}

/// Returns the area that two areas share; its sides are turned where that is nothing.
fn common(a: Bounds, b: Bounds) -> Bounds {
    [a[0].max(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].min(b[3])]
}

/// Returns where the grid's lines lie if its voxels are the raster's pixels.
fn phase_of(raster: &Opened<f64>, crs: &Crs, spacing: f64) -> Option<(f64, f64)> {
    let geo = &raster.geo;
    let Size { width, height } = raster.samples.size();
    // Off by less than a millionth of a pixel over the whole raster.
    let agrees = |side: f64, count: u32| (side.abs() - spacing).abs() * f64::from(count) < ROUNDING * spacing;
    let same = Transform::new(&raster.crs, crs).is_ok_and(|transform| transform.is_identity());
    (same && geo[2] == 0.0 && geo[4] == 0.0 && agrees(geo[1], width) && agrees(geo[5], height))
        .then_some((geo[0], geo[3]))
}

/// First line and number of voxels whose centres lie in `low..=high`; at least the one in the middle.
fn axis(low: f64, high: f64, phase: f64, spacing: f64) -> Result<(f64, u32)> {
    let cell = |position: f64| (position - phase) / spacing;
    let mut first = (cell(low) - 0.5 - ROUNDING).ceil();
    let mut last = (cell(high) - 0.5 + ROUNDING).floor();
    if last < first {
        first = cell(0.5 * (low + high)).floor();
        last = first;
    }
    let count = last - first + 1.0;
    const MOST_VOXELS: u32 = limits::MOST_VOXELS;
    if !(count <= f64::from(MOST_VOXELS) && first.abs() < 1.0e15) {
        return Err(Error::Configuration(format!(
            "the area of {} m takes {count:.0} voxels of {spacing} m along a side, and {MOST_VOXELS} are possible; \
             choose a larger --spacing or a smaller --bbox",
            high - low
        )));
    }
    Ok((phase + first * spacing, count as u32))
}
