//! Area that a database covers, in words and as JSON.

use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::degrees::lonlat_bounds;
use crate::reference::{crs, metres};
use crate::sharpness;
use hedgehop::Result;
use hedgehop::scene::Scene;
use hedgehop::sunlight::{Observatory, Sky, SunSetting};
use hedgehop::voxel::{CorridorRecord, DetailRecord, Directory, Grid, Header, Metadata};

/// Finds where sun and stars stand over the middle of the area.
pub fn sky(sun: SunSetting, header: &Header) -> Result<Sky> {
    sun.over(&crs(header)?, 0.5 * (header.grid.origin + header.grid.far_corner()))
}

/// Returns the middle of the area as a place that sun and stars are seen from.
pub fn observatory(header: &Header) -> Result<Observatory> {
    Observatory::new(&crs(header)?, 0.5 * (header.grid.origin + header.grid.far_corner()))
}

/// Finds where sun and stars of a scene stand over the middle of a database's area, if it says so.
pub fn sky_of(scene: &Scene, header: &Header) -> Result<Option<Sky>> {
    scene.sky_over(&crs(header)?, 0.5 * (header.grid.origin + header.grid.far_corner()))
}

/// The extents in one line, metres and degrees.
pub fn extents(header: &Header) -> Result<String> {
    let (near, far) = (header.grid.origin, header.grid.far_corner());
    let mut text =
        format!("x {:.1} to {:.1}, y {:.1} to {:.1} ({})", near.x, far.x, near.y, far.y, crs_label(header));
    if let Some([west, south, east, north]) = lonlat_bounds(header)? {
        // Writing to a String cannot fail.
        let across = if west > east { " across 180" } else { "" };
        let _ = write!(text, "; longitude {west:.5} to {east:.5}{across}, latitude {south:.5} to {north:.5}");
    }
    Ok(text)
}

/// A place from where something is to be seen: south of the centre, above the highest ground.
pub fn viewpoint(header: &Header) -> DVec3 {
    let (near, far) = (header.grid.origin, header.grid.far_corner());
    let size = far - near;
    let place = near + size * DVec2::new(0.5, 0.25);
    place.extend(header.height_range.high + 0.05 * size.min_element())
}

fn crs_label(header: &Header) -> String {
    match (header.metadata.crs_epsg, header.metadata.crs_name.as_str()) {
        (Some(code), name) if name.contains(&code.to_string()) => name.to_owned(),
        (Some(code), name) => format!("EPSG:{code}, {name}"),
        (None, "local") => "local metres".into(),
        (None, name) => name.to_owned(),
    }
}

fn sides(header: &Header) -> Vec<u32> {
    (0..header.level_count).map(Grid::side_units).collect()
}

/// The table that `build` and `info` print.
pub fn description(header: &Header) -> Result<String> {
    let (grid, metadata) = (&header.grid, &header.metadata);
    let size = (grid.far_corner() - grid.origin) / 1000.0;
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {name:<9} {value}");
    };

    row(
        "size",
        format!(
            "{:.2} x {:.2} km, {} x {} voxels of {} m",
            size.x,
            size.y,
            grid.nx,
            grid.ny,
            metres(grid.spacing)
        ),
    );

    row("extents", extents(header)?);
    row(
        "heights",
        format!(
            "{:.1} to {:.1} m above {}, in steps of {:.4} m",
            header.height_range.low, header.height_range.high, metadata.vertical_datum, header.heights.scale
        ),
    );

    row("sharp", sharpness::sentence(header));
    let levels: Vec<String> = sides(header).iter().map(ToString::to_string).collect();
    row("levels", levels.join(", "));
    row("voids", voids(metadata));

    for (index, source) in metadata.sources.iter().enumerate() {
        row(
            if index == 0 { "sources" } else { "" },
            format!("{index}: {} {}: {}", source.role, source.file, source.description),
        );
    }

    for (index, corridor) in metadata.corridors.iter().enumerate() {
        let CorridorRecord { route, width, spacing } = corridor;
        row(
            if index == 0 { "corridors" } else { "" },
            format!("{} m wide at {} m along {route}", metres(*width), metres(*spacing)),
        );
    }

    if let Some([azimuth, elevation]) = metadata.baked_sun {
        row(
            "shadows",
            format!("of a sun {azimuth:.1}° from grid north and {elevation:.1}° high, in the colours"),
        );
    }

    if let Some(detail) = &metadata.detail {
        let DetailRecord { pattern, seed, strength, relief, displacement, displacements, matched, .. } =
            detail;
        let pattern = pattern.name();
        let sentence = match *strength > 0.0 {
            true => format!("pattern {pattern}, seed {seed}, strength {strength}, relief {relief}"),
            false => "none below the voxels".to_owned(),
        };
        row("detail", sentence);
        if let Some(matched) = matched {
            let classes = matched.classes().len();
            row(
                "",
                format!(
                    "over the ground {classes} matched from finer imagery, by roughness; the pattern over walls"
                ),
            );
        }
        let most = displacements.values().fold(*displacement, |most, metres| most.max(*metres));
        if most > 0.0 {
            row("", format!("displaces the ground by up to {most} m"));
        }
    }

    for (index, note) in metadata.notes.iter().enumerate() {
        row(if index == 0 { "notes" } else { "" }, note.clone());
    }
    row("hash", header.content_hash.to_string());
    row("writer", format!("{}, format {}", metadata.writer, header.version));

    Ok(text)
}

/// Says what has no surface, and why, in one sentence.
fn voids(metadata: &Metadata) -> String {
    let Metadata { void_share, empty_share, .. } = *metadata;
    // Older databases tell no more than that.
    let filled = metadata.filled_share.unwrap_or((void_share - empty_share).max(0.0));
    let left = (void_share - filled).clamp(0.0, empty_share);
    let parts = [
        (empty_share - left, "lie where no elevation file reaches, without a surface"),
        (left, "lie in voids of the elevation, without a surface"),
        (filled, "lie in voids that were filled"),
    ];
    let told = parts.iter().filter(|(share, _)| *share >= 0.000_005);
    let told: Vec<String> = told.map(|(share, what)| format!("{:.3} % {what}", 100.0 * share)).collect();
    match told.first() {
        None => "none: all voxels have a surface from elevation".into(),
        Some(_) => format!("of the voxels, {}", told.join(", ")),
    }
}

/// Pages of one level that a database stores.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LevelShare {
    /// Pages that are stored.
    pub stored: u64,
    /// Pages of the grid.
    pub all: u64,
    /// Bytes of those that are stored.
    pub bytes: u64,
    /// Stored pages that have no surface, and so no bytes.
    pub empty: u64,
}

/// Returns the shares of each level, finest first.
pub fn shares(header: &Header, directory: &Directory) -> Vec<LevelShare> {
    let pages = |level| {
        let (columns, rows) = header.grid.page_dims(level);
        LevelShare { all: u64::from(columns) * u64::from(rows), ..LevelShare::default() }
    };
    let mut shares: Vec<LevelShare> = (0..header.level_count).map(pages).collect();
    for (id, entry) in directory.present().filter(|(id, _)| !id.is_bare()) {
        let share = &mut shares[usize::from(id.level)];
        share.stored += 1;
        share.bytes += u64::from(entry.length);
        share.empty += u64::from(entry.empty().is_some());
    }
    shares
}

/// Bare ground that a database stores, and what stands on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StandingShare {
    /// Pages of bare ground.
    pub pages: u64,
    /// Bytes of these pages, those of spans included.
    pub bytes: u64,
    /// Bytes of spans.
    pub spans: u64,
}

/// Returns the share of bare ground that is stored.
pub fn standing(directory: &Directory) -> StandingShare {
    let bare = directory.present().filter(|(id, _)| id.is_bare());
    bare.fold(StandingShare::default(), |share, (_, entry)| StandingShare {
        pages: share.pages + 1,
        bytes: share.bytes + u64::from(entry.length),
        spans: share.spans + u64::from(entry.spans),
    })
}

/// Describes the shares of each level, as further rows of the table.
pub fn stored(header: &Header, directory: &Directory) -> String {
    let mut text = String::new();
    for (index, (share, side)) in shares(header, directory).iter().zip(sides(header)).enumerate() {
        let LevelShare { stored, all, bytes, empty } = share;
        let percent = 100.0 * *stored as f64 / *all as f64;
        let megabytes = *bytes as f64 / 1e6;
        let empty = if *empty > 0 {
            format!("; {empty} of them have no surface and no bytes")
        } else {
            String::new()
        };
        let name = if index == 0 { "stored" } else { "" };

        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  {name:<9} level {side}: {stored} of {all} pages ({percent:.4} %), {megabytes:.1} MB{empty}"
        );
    }

    let StandingShare { pages, bytes, spans } = standing(directory);
    if pages > 0 {
        let [all, spans] = [bytes, spans].map(|bytes| bytes as f64 / 1e6);
        let _ = writeln!(
            text,
            "            bare ground: {pages} pages, {all:.1} MB, of which {spans:.1} MB are what stands on it"
        );
    }

    let objects = header.objects.len();
    if objects > 0 {
        let kilobytes = header.objects.to_bytes().len() as f64 / 1e3;
        let _ = writeln!(text, "            objects that are placed: {objects}, {kilobytes:.1} kB");
    }

    text
}

/// Everything the header says and what is stored, for programs.
pub fn json(header: &Header, directory: &Directory) -> Result<Value> {
    let (near, far) = (header.grid.origin, header.grid.far_corner());
    let standing = standing(directory);
    Ok(json!({
        "format_version": header.version,
        "content_hash": header.content_hash.to_string(),
        "voxels": [header.grid.nx, header.grid.ny],
        "spacing_m": header.grid.spacing,
        "bounds": { "west": near.x, "south": near.y, "east": far.x, "north": far.y },
        "lonlat_bounds": lonlat_bounds(header)?.map(|[west, south, east, north]| {
            json!({ "west": west, "south": south, "east": east, "north": north })
        }),
        "height_range_m": [header.height_range.low, header.height_range.high],
        "height_step_m": header.heights.scale,
        "sharp_from_m": sharpness::usual_height(header),
        "levels": sides(header),
        "placed_objects": header.objects.len(),

        "stored": shares(header, directory)
            .iter()
            .zip(sides(header))
            .map(|(share, side)| {
                json!({
                    "level": side, "pages": share.stored, "pages_of_grid": share.all, "bytes": share.bytes,
                    "empty_pages": share.empty,
                })
            })
            .collect::<Vec<_>>(),

        "bare_ground": {
            "pages": standing.pages, "bytes": standing.bytes, "span_bytes": standing.spans,
        },

        "metadata": header.metadata,
    }))
}

#[cfg(test)]
mod tests {
    use super::{Metadata, voids};
    use crate::reference::metres;

    #[test]
    fn voids_are_told_once_and_without_contradiction() {
        let told = |void_share: f64, filled: f64, empty_share: f64| {
            let filled_share = Some(filled).filter(|filled| *filled > 0.0);
            voids(&Metadata { void_share, filled_share, empty_share, ..Metadata::default() })
        };
        assert_eq!(told(0.0, 0.0, 0.0), "none: all voxels have a surface from elevation");
        assert_eq!(
            told(0.0, 0.0, 0.01175),
            "of the voxels, 1.175 % lie where no elevation file reaches, without a surface"
        );
        assert_eq!(told(0.02, 0.02, 0.0), "of the voxels, 2.000 % lie in voids that were filled");
        assert_eq!(
            told(0.03, 0.01, 0.05),
            "of the voxels, 3.000 % lie where no elevation file reaches, without a surface, \
             2.000 % lie in voids of the elevation, without a surface, 1.000 % lie in voids that were filled"
        );
    }

    #[test]
    fn spacings_are_short() {
        assert_eq!(metres(89.994_067_349_936_81), "89.9941");
        assert_eq!(metres(10.0), "10");
        assert_eq!(metres(0.25), "0.25");
        assert_eq!(metres(9265.5), "9265.5");
        assert_eq!(metres(1_234_567.0), "1234567");
    }
}
