//! Rasters without georeferencing: pictures and bare numbers, which do not say where they lie.
//!
//! ```text
//! edges that the user names           in the system that is named, or in degrees, or in elevation's own
//! imagery over elevation in metres    all over it
//! over elevation on Earth             refused, with the command that says it lies all over it
//! else                                at (0, 0), with pixels of the voxels' side
//! ```

use super::footprint::{Bounds, corner_bounds};
use super::plausible::plausible;
use crate::naming::{crs_label, file_name};
use crate::opened::Opened;
use crate::raster::{GeoTransform, RasterInfo};
use hedgehop::Size;
use hedgehop::voxel::limits;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// The first elevation file, which other rasters are most often of the same ground as.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    name: String,
    geo: GeoTransform,
    size: Size,
    crs: Crs,
}

/// The canvas of a build, unless there is no elevation.
pub(super) fn canvas(elevation: &[Opened<f64>]) -> Option<Canvas> {
    let first = elevation.first()?;
    Some(Canvas {
        name: file_name(&first.path),
        geo: first.geo,
        size: first.samples.size(),
        crs: first.crs.clone(),
    })
}

/// Role of a raster in a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RasterRole {
    /// Heights.
    Elevation,
    /// Colours.
    Imagery,
    /// Classes.
    LandCover,
}

impl RasterRole {
    /// The flag that names the reference system of files that state none.
    pub fn crs_flag(self) -> &'static str {
        match self {
            Self::Elevation => "--elevation-crs",
            Self::Imagery => "--imagery-crs",
            Self::LandCover => "--land-cover-crs",
        }
    }
}

/// Statements of the user about a raster that says nothing of itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Said<'a> {
    /// Role of the raster.
    pub role: RasterRole,
    /// Reference system.
    pub crs: Option<&'a str>,
    /// Edges of its outer pixels.
    pub extent: Option<Bounds>,
    /// Side of its pixels, metres.
    pub spacing: Option<f64>,
    /// Coordinates are plain metres.
    pub local: bool,
}

/// Finds where a raster without georeferencing lies, and what is to be noted of that.
pub(super) fn place(
    info: &RasterInfo,
    said: Said<'_>,
    canvas: Option<&Canvas>,
) -> Result<(GeoTransform, Crs, String)> {
    let name = file_name(&info.path);
    if let Some(extent) = said.extent {
        return within(info, extent, said, canvas);
    }

    match canvas.filter(|_| said.role != RasterRole::Elevation) {
        Some(canvas) if canvas.crs.is_local() && said.role == RasterRole::Imagery => {
            let geo = canvas.laid_over(info);
            let note =
                format!("{name}: has no georeferencing, laid over the whole of the first elevation file");
            return Ok((geo, Crs::local(), note));
        }
        Some(canvas) if !canvas.crs.is_local() => return Err(canvas.refusal(info, said.role)),
        _ => {}
    }

    let Some(spacing) = said.spacing else {
        return Err(Error::unsupported(
            &info.path,
            "has no georeferencing",
            "give the side of its pixels in metres with --spacing, or put a world file and --elevation-crs or --imagery-crs to it",
        ));
    };

    limits::check_spacing(spacing).map_err(|what| Error::Configuration(format!("--spacing: {what}")))?;
    let geo = [0.0, spacing, 0.0, f64::from(info.height) * spacing, 0.0, -spacing];
    let note = format!("{name}: has no georeferencing, placed at (0, 0) with pixels of {spacing} m");

    Ok((geo, Crs::local(), note))
}

/// A raster between edges that the user names.
fn within(
    info: &RasterInfo,
    extent: Bounds,
    said: Said<'_>,
    canvas: Option<&Canvas>,
) -> Result<(GeoTransform, Crs, String)> {
    let [west, south, east, north] = extent;
    let is_area = extent.iter().all(|edge| edge.is_finite()) && west < east && south < north;
    if !is_area {
        return Err(Error::Configuration(format!(
            "--imagery-extent {west},{south},{east},{north} is no area: want west, south, east and north, with west less than east and south less than north"
        )));
    }

    let of_elevation = canvas.map(|canvas| canvas.crs.clone());
    let crs = match (said.crs, of_elevation) {
        (Some(text), _) => Crs::from_user(text)?,
        (None, Some(crs)) if crs.is_local() || crs.is_geographic() || !could_be_degrees(extent) => crs,
        (None, None) if said.local => Crs::local(),
        (None, _) if could_be_degrees(extent) => Crs::wgs84(),
        (None, _) => {
            return Err(Error::Configuration(
                "--imagery-extent is not in degrees, and there is no elevation file whose reference system it could be in; name one with --imagery-crs"
                    .into(),
            ));
        }
    };

    let pixel = |from: f64, to: f64, count: u32| (to - from) / f64::from(count);
    let geo = [west, pixel(west, east, info.width), 0.0, north, 0.0, pixel(north, south, info.height)];
    plausible(info, &geo, &crs, said.role.crs_flag())?;
    let note = format!(
        "{}: has no georeferencing, laid over {west} to {east} east and {south} to {north} north ({}), as --imagery-extent says",
        file_name(&info.path),
        crs_label(&crs)
    );

    Ok((geo, crs, note))
}

/// Whether numbers may be longitudes and latitudes. Of a projected system they would be a place of a few hundred metres at its origin.
fn could_be_degrees([west, south, east, north]: Bounds) -> bool {
    west >= -180.0 && east <= 540.0 && south >= -90.0 && north <= 90.0
}

impl Canvas {
    /// A raster of the same extent.
    fn laid_over(&self, info: &RasterInfo) -> GeoTransform {
        let share = |of: u32, by: u32| f64::from(of) / f64::from(by);
        let (across, down) = (share(self.size.width, info.width), share(self.size.height, info.height));
        let geo = self.geo;
        [geo[0], geo[1] * across, geo[2] * down, geo[3], geo[4] * across, geo[5] * down]
    }

    /// Why a raster that does not say where it lies cannot be put on ground that does.
    fn refusal(&self, info: &RasterInfo, role: RasterRole) -> Error {
        // A millimetre, or a tenth of one.
        let decimals = if self.crs.is_geographic() { 9 } else { 3 };
        let number = |edge: f64| {
            let text = format!("{edge:.decimals$}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        };
        let [west, south, east, north] = corner_bounds(&self.geo, self.size).map(number);

        let label = crs_label(&self.crs);
        let system = match (self.crs.epsg(), self.crs.proj()) {
            (None, Some(proj)) => format!("\"{proj}\""),
            _ => label.clone(),
        };
        let (file, copy) = (info.path.display(), info.path.with_extension("placed.tif"));
        let command = format!(
            "gdal_translate -a_srs {system} -a_ullr {west} {north} {east} {south} \"{file}\" \"{}\"",
            copy.display()
        );
        let whole = format!("if it shows all that {} does", self.name);

        let remedy = match role {
            RasterRole::Imagery => format!(
                "say where its edges lie with --imagery-extent W,S,E,N ({whole}: --imagery-extent {west},{south},{east},{north}, in {label}), or write it into a copy: {command}"
            ),
            _ => format!("write where it lies into a copy; {whole}: {command}"),
        };

        Error::unsupported(&info.path, "has no georeferencing", remedy)
    }
}
