//! Warnings of what can be as it is said, but is most often a mistake: what lies outside the area, models that are kilometres high.

use glam::DVec2;

use super::counts::PageCounts;
use super::features::Layer;
use super::footprint::{Bounds, joined};
use super::inputs::{FeatureInput, Inputs};
use super::options::{BuildOptions, NodataFill};
use super::plan::Plan;
use crate::Input;
use crate::naming::file_name;
use crate::opened::Opened;
use hedgehop::voxel::{Grid, HeightCode};
use hedgehop_base::error::Result;
use hedgehop_geo::{Crs, Transform};

/// Farthest from its places that anything changes the ground, metres: as features do.
const REACH: f64 = 100.0;

/// Steps of height that are worth a word, metres, and how many times as large as they need be.
const COARSE: f64 = 0.05;
const COARSER: f64 = 4.0;

/// Shapes, patterns and boxes of scatters that lie wholly outside the area, a sentence for each.
pub(super) fn outside(options: &BuildOptions, grid: &Grid) -> Vec<(Input, String)> {
    let synthetic = &options.synthetic;
    let number = |index: usize| index + 1;
    let shapes = synthetic.shape_bounds().map(|(index, bounds)| {
        (Input::Terrain(index), format!("[[terrain]] number {}", number(index)), bounds)
    });
    let textures = synthetic.texture_bounds().map(|(index, bounds)| {
        (Input::Texture(index), format!("[[texture]] number {}", number(index)), bounds)
    });
    let patches = synthetic
        .patch_bounds()
        .map(|(index, bounds)| (Input::Patch(index), format!("[[patch]] number {}", number(index)), bounds));
    let scatters = (0..).zip(&options.scatters).filter_map(|(index, scatter)| {
        Some((
            Input::Scatter(index),
            format!("the bbox of [[scatter]] number {}", number(index)),
            scatter.bbox?,
        ))
    });
    let all = shapes.chain(textures).chain(patches).chain(scatters);
    all.filter_map(|(input, what, bounds)| Some((input, misplaced(&what, bounds, grid)?))).collect()
}

/// The same of everything that has a place: files, and objects, of which single places count.
///
/// # Errors
/// A file that has no place in the database's system.
pub(super) fn all_outside(
    inputs: &Inputs,
    plan: &Plan,
    options: &BuildOptions,
) -> Result<Vec<(Input, String)>> {
    let Plan { crs, grid, .. } = plan;
    let mut found = outside(options, grid);
    let mut add = |input: Input, what: Option<String>| found.extend(what.map(|what| (input, what)));

    // Points come first of all elevation.
    for (index, points) in inputs.elevation.iter().take(inputs.clouds.len()).enumerate() {
        add(Input::Cloud(index), misplaced_raster(points, plan)?);
    }
    for (index, raster) in inputs.imagery.iter().enumerate() {
        add(Input::Imagery(index), misplaced_raster(raster, plan)?);
    }
    for (index, raster) in inputs.land_cover.iter().enumerate() {
        add(Input::LandCover(index), misplaced_raster(raster, plan)?);
    }
    for (index, FeatureInput { layer, .. }) in inputs.features.iter().enumerate() {
        add(Input::Features(index), misplaced_layer(layer, crs, grid)?);
    }

    for (index, scatter) in inputs.scatters.iter().enumerate() {
        let areas = scatter.areas(crs)?.unwrap_or_default();
        let bounds = areas.iter().map(|area| area.bounds).reduce(joined);
        let what = || format!("the area of [[scatter]] number {}", index + 1);
        add(Input::Scatter(index), bounds.and_then(|bounds| misplaced(&what(), bounds, grid)));
    }

    for (index, object) in options.objects.iter().enumerate() {
        let name = object.paths.first().map(|path| file_name(path)).unwrap_or_default();
        add(Input::Object(index), misplaced_object(&name, &object.places, grid));
    }

    Ok(found)
}

/// Clouds that lie wholly outside the area.
///
/// # Errors
/// As of [`all_outside`].
pub(super) fn clouds_outside(inputs: &Inputs, plan: &Plan) -> Result<Vec<String>> {
    let clouds = inputs.elevation.iter().take(inputs.clouds.len());
    clouds.filter_map(|points| misplaced_raster(points, plan).transpose()).collect()
}

/// Warns of a raster that lies wholly outside the area.
pub(super) fn misplaced_raster<T>(raster: &Opened<T>, plan: &Plan) -> Result<Option<String>> {
    let (_, reach) = raster.place(plan)?;
    Ok(misplaced(&file_name(&raster.path), reach, &plan.grid))
}

fn misplaced_layer(layer: &Layer, crs: &Crs, grid: &Grid) -> Result<Option<String>> {
    let transform = Transform::new(&layer.crs, crs)?;
    let mut all: Option<Bounds> = None;
    for row in &layer.rows {
        let placed = row.geometry.transformed(&transform);
        let Some(bounds) = placed.and_then(|geometry| geometry.bounds()) else { continue };
        if meets(bounds, grid) {
            return Ok(None);
        }
        all = Some(all.map_or(bounds, |all| joined(all, bounds)));
    }
    // Rows about the area, none of which lies in it, are told one by one.
    Ok(all.and_then(|bounds| misplaced(&file_name(&layer.path), bounds, grid)))
}

fn misplaced_object(name: &str, places: &[[f64; 2]], grid: &Grid) -> Option<String> {
    let is_outside = |place: &&[f64; 2]| !grid.contains(DVec2::from_array(**place));
    let outside: Vec<_> = places.iter().filter(is_outside).collect();
    let [x, y] = **outside.first()?;
    if outside.len() == places.len() {
        return misplaced(name, [x, y, x, y], grid).or_else(|| Some(beside(name, [x, y], grid)));
    }
    Some(format!(
        "{name}: {} of its {} places lie outside the area and are left out, the first at x {x}, y {y}",
        outside.len(),
        places.len()
    ))
}

/// Something that stands so near the area that it is no mistake of its coordinates, but is left out all the same.
fn beside(name: &str, [x, y]: [f64; 2], grid: &Grid) -> String {
    format!("{name} stands outside the area, at x {x}, y {y}, and is left out: {}", extent(grid))
}

/// Warns of something with these bounds, unless it reaches the area.
fn misplaced(what: &str, bounds: Bounds, grid: &Grid) -> Option<String> {
    if meets(bounds, grid) {
        return None;
    }
    let [west, south, east, north] = bounds;
    let (x, y) = (0.5 * (west + east), 0.5 * (south + north));
    let remedy = match meets([south, west, north, east], grid) {
        true => "with x and y the other way round it would lie in it",
        false => "check its coordinates, or its reference system",
    };
    Some(format!(
        "{what} lies outside the area and changes nothing: it is around x {x:.0}, y {y:.0}, and {}; {remedy}",
        extent(grid)
    ))
}

/// The area in words.
fn extent(grid: &Grid) -> String {
    let (low, high) = (grid.origin, grid.far_corner());
    format!("the area is x {:.0} to {:.0}, y {:.0} to {:.0}", low.x, high.x, low.y, high.y)
}

fn meets([west, south, east, north]: Bounds, grid: &Grid) -> bool {
    let (low, high) = (grid.origin - REACH, grid.far_corner() + REACH);
    west <= high.x && east >= low.x && south <= high.y && north >= low.y
}

/// Warns of models that make the steps of all heights much larger than those of ground and features, `without` them.
pub(super) fn coarse_steps(without: HeightCode, with: HeightCode) -> Option<String> {
    (with.scale >= COARSE && with.scale >= COARSER * without.scale).then(|| {
        format!(
            "models are so high above the ground that all heights come in steps of {:.2} m instead of {:.4} m; \
             look at `scale` and `up_m` of [[object]] and [[scatter]]",
            with.scale, without.scale
        )
    })
}

/// Says how much of the ground the imagery leaves without colour, if it does.
pub(super) fn bare(counts: &PageCounts, no_imagery: bool, is_covered: bool) -> Option<String> {
    let share = 100.0 * counts.bare as f64 / counts.voxels.saturating_sub(counts.empty).max(1) as f64;
    // Less would be shown as nothing.
    const LEAST: f64 = 0.005;
    (!no_imagery && share >= LEAST).then(|| {
        let from = if is_covered { "land cover" } else { "height and slope" };
        format!("imagery leaves {share:.2} % of the ground bare: colours there were derived from {from}")
    })
}

/// Shares of voxels that would be shown as nothing.
const LEAST_SHARE: f64 = 0.000_5;

/// Says how much of the area lies in voids of elevation, what became of them, and what helps.
pub(super) fn voids(counts: &PageCounts, options: &BuildOptions) -> Vec<String> {
    let percent = |count: u64| 100.0 * count as f64 / counts.voxels.max(1) as f64;
    let (filled, left) = (percent(counts.filled), percent(counts.voids - counts.filled));
    let mut notes = Vec::new();
    if options.nodata_fill == NodataFill::Small && filled >= LEAST_SHARE {
        notes.push(format!(
            "{filled:.3} % of the voxels lie in small voids of elevation, which were filled from the heights around; \
             --nodata-fill none keeps them"
        ));
    }
    let is_helped = matches!(options.nodata_fill, NodataFill::None | NodataFill::Small);
    if is_helped && left >= LEAST_SHARE {
        notes.push(format!(
            "{left:.3} % of the voxels lie in voids of elevation and have no surface, with walls down from their rims; \
             --nodata-fill interp fills them from the heights around (voids = \"interpolate\" in a recipe)"
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { nx: 100, ny: 50, spacing: 10.0, origin: DVec2::new(500_000.0, 5_000_000.0) };

    #[test]
    fn what_reaches_the_area_is_no_mistake() {
        for bounds in [
            [500_100.0, 5_000_100.0, 500_100.0, 5_000_100.0],
            [0.0, 0.0, 1e7, 1e7],
            // Embankments reach further than what they are of.
            [501_050.0, 5_000_100.0, 501_060.0, 5_000_110.0],
        ] {
            assert_eq!(misplaced("it", bounds, &GRID), None);
        }
        let west = misplaced("it", [499_000.0, 5_000_100.0, 499_800.0, 5_000_200.0], &GRID).unwrap();
        assert!(
            west.contains("around x 499400, y 5000150") && west.contains("check its coordinates"),
            "{west}"
        );
        assert!(west.contains("x 500000 to 501000, y 5000000 to 5000500"), "{west}");
    }

    #[test]
    fn coordinates_the_wrong_way_round_are_recognised() {
        let told = misplaced_object("barn.glb", &[[5_000_100.0, 500_200.0]], &GRID).unwrap();
        assert!(told.starts_with("barn.glb lies outside") && told.contains("the other way round"), "{told}");
    }

    #[test]
    fn places_of_objects_count_one_by_one() {
        let (inside, far, near) = ([500_200.0, 5_000_100.0], [0.5, 7.0], [499_990.0, 5_000_100.0]);
        assert_eq!(misplaced_object("barn.glb", &[inside], &GRID), None);
        let some = misplaced_object("barn.glb", &[inside, far, near], &GRID).unwrap();
        assert!(some.contains("2 of its 3 places") && some.contains("at x 0.5, y 7"), "{some}");
        let beside = misplaced_object("barn.glb", &[near], &GRID).unwrap();
        assert!(
            beside.contains("stands outside the area, at x 499990") && beside.contains("left out"),
            "{beside}"
        );
    }

    #[test]
    fn steps_are_told_where_models_make_them_large() {
        let ground = HeightCode::spanning(100.0, 140.0);
        assert_eq!(coarse_steps(ground, HeightCode::spanning(100.0, 900.0)), None);
        let told = coarse_steps(ground, HeightCode::spanning(100.0, 16_484.0)).unwrap();
        assert!(told.contains("steps of 0.25 m instead of 0.0006 m") && told.contains("`scale`"), "{told}");
        // Mountains have such steps by themselves.
        let alps = HeightCode::spanning(0.0, 4_000.0);
        assert_eq!(coarse_steps(alps, HeightCode::spanning(0.0, 6_000.0)), None);
    }
}
