//! Maps as files: which part of an area, how large a pixel is, and where the picture lies on Earth.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::{args, reference};
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::encode::geotiff::GeoTiff;
use hedgehop::geo::Crs;
use hedgehop::progress::Observer;
use hedgehop::voxel::{Grid, Header};
use hedgehop::{Error, Result};
use hedgehop_query::MapExtent;

/// All of an area, west, south, east and north.
pub const WHOLE: [f64; 4] = [f64::MIN, f64::MIN, f64::MAX, f64::MAX];

/// Flags of a map's part of the area, and of its pixels.
#[derive(Debug, Clone, Args)]
pub struct PartArgs {
    /// Part of the area, metres of its reference system [default: all of it]
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    pub bbox: Option<[f64; 4]>,

    /// A level's voxels as pixels: 1, 4, 16, 64, … [default: 1]
    #[arg(long, value_name = "LEVEL", conflicts_with = "pixel")]
    pub level: Option<u32>,

    /// Side of a pixel, metres
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    pub pixel: Option<f64>,
}

impl PartArgs {
    /// The pixels that were asked for.
    pub fn extent(&self, header: &Header) -> Result<MapExtent> {
        let bounds = self.bbox.unwrap_or(WHOLE);
        match self.pixel {
            Some(pixel) => MapExtent::of_pixels(&header.grid, pixel, bounds),
            None => MapExtent::of_level(&header.grid, level_index(self.level.unwrap_or(1), header)?, bounds),
        }
    }
}

/// The index of a level that a database has.
///
/// # Errors
/// [`Error::Configuration`]: it has none of that name.
pub fn level_index(level: u32, header: &Header) -> Result<u8> {
    let found = (0..header.level_count).find(|index| Grid::side_units(*index) == level);
    found.ok_or_else(|| {
        let all: Vec<String> =
            (0..header.level_count).map(|index| Grid::side_units(index).to_string()).collect();
        Error::Configuration(format!("--level {level}: the database has the levels {}", all.join(", ")))
    })
}

/// Refuses maps beyond `most` pixels or `side` of them in a row or column; the remedy is a pixel that fits.
pub fn check_size(extent: &MapExtent, kind: &str, most: u64, side: u32) -> Result<()> {
    let (pixels, longer) = (extent.pixels(), extent.width.max(extent.height));
    if pixels <= most && longer <= side {
        return Ok(());
    }
    let factor = (pixels as f64 / most as f64).sqrt().max(f64::from(longer) / f64::from(side));
    // A little above, since both sides are rounded.
    let pixel = (extent.pixel * factor * 1.01).ceil();
    Err(Error::Configuration(format!(
        "{} x {} pixels are too many for {kind}; give --pixel {pixel} or a smaller --bbox",
        extent.width, extent.height
    )))
}

/// The world file of a picture: sides of a pixel, and the middle of the upper left one.
pub fn world_file(extent: &MapExtent) -> String {
    let first = extent.place(0.0, 0.0);
    format!("{:.10}\n0\n0\n{:.10}\n{:.4}\n{:.4}\n", extent.pixel, -extent.pixel, first.x, first.y)
}

/// The files beside a picture: where it lies, and in which reference system.
pub fn beside(picture: &Path) -> [PathBuf; 2] {
    [picture.with_extension("pgw"), picture.with_extension("prj")]
}

/// Refuses a picture that cannot be written, or would replace an input, with what stands beside it.
pub fn check_output(output: &Path, inputs: &[&Path]) -> Result<()> {
    args::check_no_input("-o", output, inputs)?;
    if is(output, "png") {
        for file in beside(output) {
            args::check_no_input("the world file of -o", &file, inputs)?;
        }
    }
    check_writable(output)
}

/// Whether a file's name ends so.
pub fn is(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

/// Writes what says where a picture lies.
pub fn write_beside(
    picture: &Path,
    extent: &MapExtent,
    header: &Header,
    observer: &dyn Observer,
) -> Result<()> {
    let [world, projection] = beside(picture);
    write_bytes(&world, world_file(extent).as_bytes())?;
    let crs: Crs = reference::crs(header)?;
    match crs.to_esri_wkt() {
        Some(text) => write_bytes(&projection, text.as_bytes()),
        None if crs.is_local() => Ok(()),
        None => {
            observer.note(&no_words(&crs, "a .prj"));
            Ok(())
        }
    }
}

/// A map as GeoTIFF: where it lies, and in which reference system. `bands` is 1 or 3.
pub fn geotiff(
    extent: &MapExtent,
    bands: usize,
    header: &Header,
    observer: &dyn Observer,
) -> Result<GeoTiff> {
    let crs = reference::crs(header)?;
    let keys = crs.to_geo_keys();
    if keys.is_none() && !crs.is_local() {
        observer.note(&no_words(&crs, "a GeoTIFF"));
    }
    let (north_west, pixel) = (extent.north_west.to_array(), extent.pixel);
    Ok(GeoTiff { width: extent.width, height: extent.height, bands, north_west, pixel, keys })
}

/// Builds the error of a system that a file cannot name.
fn no_words(crs: &Crs, file: &str) -> String {
    format!("{file} has no words for the reference system {}: give it to other programs by hand", crs.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn world_files_name_the_middle_of_a_pixel() {
        let extent = MapExtent { north_west: DVec2::new(100.0, 900.0), pixel: 4.0, width: 5, height: 6 };
        assert_eq!(world_file(&extent), "4.0000000000\n0\n0\n-4.0000000000\n102.0000\n898.0000\n");
    }

    #[test]
    fn large_maps_are_refused_with_what_fits() {
        let extent = MapExtent { north_west: DVec2::ZERO, pixel: 2.0, width: 60_000, height: 30_000 };
        assert!(check_size(&extent, "a PNG", 2_000_000_000, 60_000).is_ok());
        let told = check_size(&extent, "a PNG", 400_000_000, 32_768).unwrap_err().to_string();
        assert!(told.contains("--pixel 5 "), "{told}");
    }
}
