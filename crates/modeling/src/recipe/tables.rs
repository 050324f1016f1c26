//! The tables of a recipe, and what they may hold.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::fields::{Fields, Mistakes};
use super::files::file;
use super::synthetic::synthetic;
use super::values::HEIGHT;
use super::words::error_in_keys;
use super::{cover, objects};
use crate::features::{Columns, FeatureClass, LayerOptions};
use crate::raster::{OpenOptions, open};
use crate::recipe::contents::Lines;
use crate::recipe::files::{OneOrMany, crs, files};
use crate::recipe::{Recipe, route};
use crate::{
    BuildOptions, CloudFile, Corridor, ElevationFile, FeatureFile, ImageryFile, Interpolation, NodataFill,
    check_shadows,
};
use hedgehop::flight::ReadOptions;
use hedgehop::sunlight::{SunSetting, written};
use hedgehop_base::document::Reading;
use hedgehop_geo::VerticalDatum;

/// Treatment of voids.
#[derive(Deserialize)]
#[serde(untagged, expecting = "voids is \"small\", \"none\", \"interpolate\", or a height in metres")]
enum Voids {
    Height(f64),
    Word(String),
}

/// Vertical datums by the names that flags have, too.
const DATUMS: [(&str, VerticalDatum); 5] = [
    ("msl", VerticalDatum::Msl),
    ("egm96", VerticalDatum::Egm96),
    ("egm2008", VerticalDatum::Egm2008),
    ("ellipsoid", VerticalDatum::Ellipsoid),
    ("navd88", VerticalDatum::Navd88),
];

/// Ways of interpolation by their names.
const INTERPOLATIONS: [(&str, Interpolation); 3] = [
    ("linear", Interpolation::Linear),
    ("bicubic", Interpolation::Bicubic),
    ("spline", Interpolation::Spline),
];

/// Reads all tables; `None` if what is wrong leaves nothing to build.
pub(super) fn read(path: &Path, mut root: Fields<'_, '_, '_>) -> Option<Recipe> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mistakes = root.mistakes;
    let mut options = BuildOptions::new(Vec::new(), Vec::new(), path.with_extension("hop"));
    options.steps = true;
    let mut lines = Lines { place: 1, ..Lines::default() };
    let mut spacing = None;

    if let Some(table) = root.table("place", "[place]") {
        lines.place = table.line();
        spacing = table.span_of("spacing_m");
        if !root.has("corridor") {
            table.refuse(
                "outside_m",
                "outside_m is about what lies outside of corridors; add a [[corridor]], or say spacing_m instead",
            );
        }
        lines.keys = place(table, &folder, &mut options);
    }

    let has_cloud = root.has("cloud");
    for table in root.tables("cloud", "[[cloud]]") {
        let line = table.line();
        let files = cloud(table, &folder);
        lines.clouds.extend(files.iter().map(|_| line));
        options.clouds.extend(files);
    }

    options.materials = cover::materials(&mut root);
    let is_whole;
    (options.synthetic, is_whole) = synthetic(&mut root, &options.materials, &folder, &mut lines);
    let tables = root.tables("elevation", "[[elevation]]");

    // Of shapes in which something is wrong one may be the plane.
    if tables.is_empty() && !has_cloud && !options.synthetic.has_base() && is_whole {
        let what = "there is no [[elevation]]; a place needs one at least, or a [[cloud]], with its `file`, or a [[terrain]] with kind = \"plane\"";
        mistakes.add(&(0..0), what);
    }

    for table in tables {
        let line = table.line();
        let files = elevation(table, &folder);
        lines.elevation.extend(files.iter().map(|_| line));
        options.elevation.extend(files);
    }

    for table in root.tables("imagery", "[[imagery]]") {
        let line = table.line();
        let files = imagery(table, &folder);
        lines.imagery.extend(files.iter().map(|_| line));
        options.imagery.extend(files);
    }

    for table in root.tables("land_cover", "[[land_cover]]") {
        let line = table.line();
        let files = cover::land_cover(table, &folder, &options.materials);
        lines.land_cover.extend(files.iter().map(|_| line));
        options.land_cover.extend(files);
    }

    for table in root.tables("features", "[[features]]") {
        let line = table.line();
        let files = features(table, &folder);
        lines.features.extend(files.iter().map(|_| line));
        options.features.extend(files);
    }

    for table in root.tables("object", "[[object]]") {
        lines.objects.push(table.line());
        options.objects.push(objects::object(table, &folder, &options.materials));
    }

    for table in root.tables("scatter", "[[scatter]]") {
        lines.scatters.push(table.line());
        options.scatters.push(objects::scatter(table, &folder, &options.materials));
    }

    for table in root.tables("corridor", "[[corridor]]") {
        let line = table.line();
        let corridor = corridor(table, &folder);
        lines.corridors.extend(corridor.iter().map(|_| line));
        options.corridors.extend(corridor);
    }

    spacings(&mut options, spacing, mistakes);
    let shadows = root.table("shadows", "[shadows]").and_then(|table| {
        lines.shadows = table.line();
        sun(table)
    });
    root.finish();

    Some(Recipe { path: path.to_owned(), options, shadows, lines })
}

/// `[place]`: where, and how finely. Returns the lines of its keys.
fn place(
    mut table: Fields<'_, '_, '_>,
    folder: &Path,
    options: &mut BuildOptions,
) -> Vec<(&'static str, usize)> {
    let mistakes = table.mistakes;
    if let Some(output) = table.take::<PathBuf>("output") {
        let span = output.span();
        let output = output.into_inner();
        if output.as_os_str().is_empty() {
            let what = "output is empty; name a file, as in output = \"place.hop\", or leave it out";
            mistakes.add(&span, what);
        }
        options.output = folder.join(output);
    }

    options.crs = crs(&mut table);
    options.local = table.take("local").is_some_and(Spanned::into_inner);
    options.spacing = table.number("spacing_m", |metres| metres > 0.0, "must be more than 0 m");
    options.outside = table.number("outside_m", |metres| metres > 0.0, "must be more than 0 m");

    options.bbox = table.take::<Vec<f64>>("bbox").and_then(|bbox| {
        let bounds = <[f64; 4]>::try_from(bbox.get_ref().as_slice());
        let wanted = "bbox is west, south, east and north, metres: [480000, 5120000, 520000, 5160000]";
        let [west, south, east, north] = mistakes.check(&bbox.span(), bounds.map_err(|_| wanted))?;
        let is_area =
            west < east && south < north && [west, south, east, north].iter().all(|at| at.is_finite());
        let area = if is_area {
            Ok([west, south, east, north])
        } else {
            Err(format!("{wanted}; west is less than east, south less than north"))
        };
        mistakes.check(&bbox.span(), area)
    });

    let voids = table.take::<Voids>("voids");
    options.nodata_fill = match voids.as_ref().map(Spanned::get_ref) {
        Some(Voids::Height(height)) if (HEIGHT.holds)(*height) => NodataFill::Value(*height),
        Some(Voids::Word(word)) if word == "interpolate" => NodataFill::Interpolate,
        Some(Voids::Word(word)) if word == "small" => NodataFill::Small,
        Some(Voids::Word(word)) if word == "none" => NodataFill::None,
        Some(_) => {
            let span = voids.map_or(0..0, |voids| voids.span());
            let what = "voids is \"none\", \"interpolate\", or a height in metres, −20000 to 20000";
            mistakes.add(&span, what);
            NodataFill::None
        }
        None => NodataFill::Small,
    };

    options.interpolation = interpolation(&mut table);
    table.finish()
}

/// Sides of voxels, and of the pixels of files without georeferencing: what `[place]` says, whose `spacing_m` stands at `span`, but voxels have
/// those of corridors if there are any. Pixels never have these: a finer corridor would shrink the place.
fn spacings(options: &mut BuildOptions, span: Option<Range<usize>>, mistakes: &Mistakes<'_>) {
    let finest = options.corridors.iter().map(|corridor| corridor.spacing).reduce(f64::min);
    options.raw_spacing = options.spacing;
    options.spacing = finest.or(options.spacing);
    // Where something else is wrong, a file may be missing that has these pixels.
    if let (Some(_), Some(span)) = (finest, span)
        && mistakes.is_empty()
        && !has_bare_raster(options)
    {
        mistakes.add(
            &span,
            "spacing_m says nothing beside a [[corridor]], which has its own: leave it out, or say outside_m for what lies outside of corridors",
        );
    }
}

/// Whether some raster has no georeferencing. One that cannot be opened may have none: what is wrong with it is told by itself.
fn has_bare_raster(options: &BuildOptions) -> bool {
    let elevation = options.elevation.iter().map(|file| &file.path);
    let imagery = options.imagery.iter().map(|file| &file.path);
    let land_cover = options.land_cover.iter().map(|file| &file.path);
    let is_bare = |path: &PathBuf| match open(path, &OpenOptions::default()) {
        Ok(raster) => raster.info().geo.is_none(),
        Err(_) => true,
    };
    elevation.chain(imagery).chain(land_cover).any(is_bare)
}

/// Reads the interpolation of heights between posts.
fn interpolation(table: &mut Fields<'_, '_, '_>) -> Interpolation {
    let Some(name) = table.take::<String>("interpolation") else { return Interpolation::default() };
    let known = INTERPOLATIONS.iter().find(|(known, _)| known == name.get_ref()).map(|(_, known)| *known);
    let names = INTERPOLATIONS.map(|(known, _)| known).join(", ");
    let wanted = || format!("interpolation is one of {names}, not {:?}", name.get_ref());
    table.mistakes.check(&name.span(), known.ok_or_else(wanted)).unwrap_or_default()
}

/// Reads the vertical datum, by its name.
fn datum(table: &mut Fields<'_, '_, '_>) -> Option<VerticalDatum> {
    let name = table.take::<String>("vertical_datum")?;
    let known = DATUMS.iter().find(|(known, _)| known == name.get_ref()).map(|(_, datum)| *datum);
    let names = DATUMS.map(|(known, _)| known).join(", ");
    let wanted = || format!("vertical_datum is one of {names}, not {:?}", name.get_ref());
    table.mistakes.check(&name.span(), known.ok_or_else(wanted))
}

fn cloud(mut table: Fields<'_, '_, '_>, folder: &Path) -> Vec<CloudFile> {
    let paths = files(&mut table, folder, "\"survey.laz\"");
    let (crs, datum) = (crs(&mut table), datum(&mut table));
    let ground_only = table.take("ground_only").is_some_and(Spanned::into_inner);
    table.finish();
    paths.into_iter().map(|path| CloudFile { path, crs: crs.clone(), datum, ground_only }).collect()
}

fn elevation(mut table: Fields<'_, '_, '_>, folder: &Path) -> Vec<ElevationFile> {
    let paths = files(&mut table, folder, "\"dem.tif\"");
    let (crs, datum) = (crs(&mut table), datum(&mut table));
    let nodata = table.take::<OneOrMany<f64>>("nodata").map(|nodata| nodata.into_inner().into_vec());
    table.finish();
    let nodata = nodata.unwrap_or_default();
    let of = |path| ElevationFile { path, crs: crs.clone(), datum, nodata: nodata.clone() };
    paths.into_iter().map(of).collect()
}

fn imagery(mut table: Fields<'_, '_, '_>, folder: &Path) -> Vec<ImageryFile> {
    let paths = files(&mut table, folder, "\"ortho.tif\"");
    let crs = crs(&mut table);
    let bands = table.take::<Vec<u32>>("bands").and_then(|bands| {
        let three = <[u32; 3]>::try_from(bands.get_ref().as_slice()).ok().filter(|bands| !bands.contains(&0));
        let wanted = "bands are those of red, green and blue, counted from 1: [3, 2, 1]";
        table.mistakes.check(&bands.span(), three.ok_or(wanted))
    });
    let extent = extent(&mut table, paths.len());
    table.finish();
    paths.into_iter().map(|path| ImageryFile { path, crs: crs.clone(), bands, extent }).collect()
}

/// Edges of an image that does not say where it lies.
fn extent(table: &mut Fields<'_, '_, '_>, files: usize) -> Option<[f64; 4]> {
    let edges = table.take::<Vec<f64>>("extent")?;
    let wanted = "extent is west, south, east and north, with west less than east and south less than north: [6.95, 50.92, 6.98, 50.95]";
    let bounds = <[f64; 4]>::try_from(edges.get_ref().as_slice()).ok();
    let is_area = |[west, south, east, north]: &[f64; 4]| west < east && south < north;
    let extent = table.mistakes.check(&edges.span(), bounds.filter(is_area).ok_or(wanted))?;
    if files > 1 {
        table.mistakes.add(&edges.span(), "extent is of one image; write an [[imagery]] for each");
    }
    Some(extent)
}

/// Names of the attributes that hold what, and where they are kept.
type Column = (&'static str, fn(&mut Columns) -> &mut Option<String>);

const COLUMNS: [Column; 11] = [
    ("height", |columns| &mut columns.height),
    ("min_height", |columns| &mut columns.min_height),
    ("levels", |columns| &mut columns.levels),
    ("width", |columns| &mut columns.width),
    ("diameter", |columns| &mut columns.diameter),
    ("roof_shape", |columns| &mut columns.roof_shape),
    ("roof_height", |columns| &mut columns.roof_height),
    ("colour", |columns| &mut columns.colour),
    ("roof_colour", |columns| &mut columns.roof_colour),
    ("material", |columns| &mut columns.material),
    ("class", |columns| &mut columns.class),
];

fn features(mut table: Fields<'_, '_, '_>, folder: &Path) -> Vec<FeatureFile> {
    let mistakes = table.mistakes;
    let paths = files(&mut table, folder, "\"town.geojson\"");
    let crs = crs(&mut table);
    let layer = table.take::<String>("layer").map(Spanned::into_inner);
    let kind = table
        .take::<String>("kind")
        .and_then(|kind| mistakes.check(&kind.span(), FeatureClass::of(kind.get_ref())));
    let mut columns = Columns::default();
    if let Some(mut named) = table.table("attributes", "attributes") {
        for (key, place) in COLUMNS {
            *place(&mut columns) = named.take::<String>(key).map(Spanned::into_inner);
        }
        named.finish();
    }
    let mut is_off = |key| !table.take(key).is_none_or(Spanned::into_inner);
    let (plain_walls, plain_ground) = (is_off("facades"), is_off("markings"));
    table.finish();
    let named = LayerOptions { crs, table: layer, kind, columns, ..LayerOptions::default() };
    let options = LayerOptions { plain_ground, plain_walls, ..named };
    paths.into_iter().map(|path| FeatureFile { path, options: options.clone() }).collect()
}

fn corridor(mut table: Fields<'_, '_, '_>, folder: &Path) -> Option<Corridor> {
    let path = table.need::<String>("path", "\"flight.csv\"");
    let positive = |metres: f64| metres > 0.0;
    let more = "must be more than 0 m";
    let [width, spacing] = [("width_m", "2000"), ("spacing_m", "1")].map(|(key, example)| {
        let number = table.need::<f64>(key, example)?;
        let checked = Reading::checked(key, *number.get_ref(), positive, more);
        table.mistakes.check(&number.span(), checked)
    });
    let track = table.take::<usize>("track").map(Spanned::into_inner);
    let sort = table.take("sort").is_some_and(Spanned::into_inner);
    let options = ReadOptions { track, sort, ..ReadOptions::default() };
    let route = path.and_then(|path| {
        let file = file(&table, &path.span(), &folder.join(path.get_ref()))?;
        table.mistakes.check(&path.span(), route(&file, &options).map_err(error_in_keys))
    });
    table.finish();
    Some(Corridor { route: route?, width: width?, spacing: spacing? })
}

/// `[shadows]`: the sun whose shadows go into the colours.
fn sun(mut table: Fields<'_, '_, '_>) -> Option<SunSetting> {
    let mistakes = table.mistakes;
    let span = table.span();

    // What is there but of the wrong kind is told by itself.
    let is_empty = ["azimuth_deg", "elevation_deg", "time"].iter().all(|key| !table.has(key));
    let azimuth = table.take("azimuth_deg");
    let elevation = table.take("elevation_deg");
    let time = table.take("time");
    table.finish();

    match written::sun("[shadows]", azimuth, elevation, time) {
        Ok(None) if is_empty => {
            mistakes.add(&span, "[shadows] needs azimuth_deg and elevation_deg, or time");
            None
        }
        Ok(Some(SunSetting::At(sun))) => {
            mistakes.check(&span, check_shadows(sun).map(|()| SunSetting::At(sun)))
        }
        Ok(sun) => sun,
        Err((span, what)) => {
            mistakes.add(&span, what);
            None
        }
    }
}
