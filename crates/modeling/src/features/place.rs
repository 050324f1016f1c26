//! Layers in the database's system: the first of the steps from a layer to what stands over voxels.
//!
//! ```text
//! for each layer:  what its rows mean | their form in the database's system | only those that reach the area
//! all of them:     bridges joined, outlines of buildings in parts dropped (`prepare`)
//! each:            bound to its ground (`bind`)
//! ```

use glam::DVec2;

use super::kinds::Meaning;
use super::layer::{Area, Geometry, Layer, LayerOptions, LeftOut};
use super::meaning::{hash, interpret_all};
use super::read::rings::crosses_itself;
use super::shape::Footprint;
use hedgehop_base::error::Result;
use hedgehop_geo::{Crs, Transform};

/// A row that means something, in the database's system.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// Meaning of the feature.
    pub meaning: Meaning,
    /// Form of the feature, metres.
    pub geometry: Geometry,
    /// Hash that tells it from others: of its file's name and its place there.
    pub hash: u64,
}

/// Farthest from its border that a feature changes the ground, metres: embankments.
const BESIDE: f64 = 100.0;

/// The features of a layer that may reach an area (west, south, east, north in `crs`), and notes on what is left out. Edges stay straight, in the
/// database's system as in the layer's.
///
/// # Errors
/// A layer that cannot be placed in `crs`: one of them is local.
pub fn place(
    layer: &Layer,
    options: &LayerOptions,
    crs: &Crs,
    area: [f64; 4],
) -> Result<(Vec<Feature>, Vec<String>)> {
    let transform = Transform::new(&layer.crs, crs)?;
    let file = crate::naming::file_name(&layer.path);
    let (meanings, mut notes) = interpret_all(layer, options);
    let (mut features, mut left_out) = (Vec::with_capacity(meanings.len()), LeftOut::default());
    let mut halved = LeftOut::in_part();

    let reaches = |[west, south, east, north]: [f64; 4], reach: f64| {
        west <= area[2] + reach
            && east >= area[0] - reach
            && south <= area[3] + reach
            && north >= area[1] - reach
    };

    for (index, meaning) in meanings {
        let row = &layer.rows[index];
        let Some(geometry) = row.geometry.transformed(&transform) else {
            left_out.add(&row.place, format!("it has no place in {}", crs.name()));
            continue;
        };

        let meaning = over_outline(meaning, &geometry);
        if needs_outline(&meaning) && geometry.areas.is_empty() {
            left_out.add(&row.place, "it is a building, and has no outline but a point or a line");
        } else if encloses_nothing(&meaning, &geometry) {
            left_out.add(&row.place, "its outline encloses nothing: it crosses itself, or is a line");
        } else if geometry.bounds().is_some_and(|bounds| reaches(bounds, reach(&meaning))) {
            if is_enclosed(&meaning, &geometry)
                && geometry.areas.iter().any(|area| crosses_itself(&area.outer.places))
            {
                halved.add(
                    &row.place,
                    "its outline crosses itself, and what that goes around the other way is no inside",
                );
            }
            features.push(Feature { meaning, geometry, hash: hash(&format!("{file} {}", row.place)) });
        } else {
            left_out.add(&row.place, "it lies outside of the area");
        }
    }

    notes.extend(halved.into_notes(&file));
    notes.extend(left_out.into_notes(&file));
    Ok((features, notes))
}

/// Farthest from its places that a feature changes the ground, metres.
fn reach(meaning: &Meaning) -> f64 {
    let half = match meaning {
        Meaning::Way(way) => 0.5 * way.width_m,
        Meaning::River(width_m) => 0.5 * width_m,
        Meaning::Barrier(barrier) => 0.5 * barrier.thickness_m,
        Meaning::Upright(upright) | Meaning::Pylon(upright, _) => 0.5 * upright.diameter_m.unwrap_or(0.0),
        _ => 0.0,
    };
    half + BESIDE
}

/// A structure as what its outline makes of it.
fn over_outline(meaning: Meaning, geometry: &Geometry) -> Meaning {
    match meaning {
        Meaning::Structure(structure) if geometry.areas.iter().all(is_circle) => {
            Meaning::Upright(structure.round)
        }
        Meaning::Structure(structure) => Meaning::Building(structure.walled),
        other => other,
    }
}

/// Whether an area has the corners of a circle, and enough of them.
fn is_circle(area: &Area) -> bool {
    /// Number of corners below which a tower has as many walls.
    const LEAST_CORNERS: usize = 12;
    /// Share of the mean by which radii may differ from it.
    const UNEVEN: f64 = 0.05;
    let Some(footprint) = Footprint::of(area).filter(|footprint| footprint.rings.len() == 1) else {
        return false;
    };
    let corners = &footprint.rings[0];
    let count = corners.len() as f64;
    let middle = corners.iter().sum::<DVec2>() / count;
    let radius = corners.iter().map(|corner| corner.distance(middle)).sum::<f64>() / count;
    corners.len() >= LEAST_CORNERS
        && corners.iter().all(|corner| (corner.distance(middle) - radius).abs() <= UNEVEN * radius)
}

/// Whether a feature is nothing without an area.
fn needs_outline(meaning: &Meaning) -> bool {
    matches!(meaning, Meaning::Building(_))
}

/// Whether a feature is what its outlines enclose.
fn is_enclosed(meaning: &Meaning, geometry: &Geometry) -> bool {
    let Geometry { points, lines, areas, .. } = geometry;
    // Walls and fences run along outlines.
    !areas.is_empty()
        && points.places.is_empty()
        && lines.is_empty()
        && !matches!(meaning, Meaning::Barrier(barrier) if !barrier.is_filled)
}

/// Whether a feature is an area and its outline none.
fn encloses_nothing(meaning: &Meaning, geometry: &Geometry) -> bool {
    is_enclosed(meaning, geometry) && geometry.areas.iter().all(|area| Footprint::of(area).is_none())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::dvec2;

    use super::super::layer::Path as Outline;
    use super::super::{Bound, PlacedSolid, Square, bind, prepare, read};
    use super::*;

    fn sample(name: &str) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/features").join(name)
    }

    const AREA: [f64; 4] = [612_000.0, 5_241_000.0, 612_130.0, 5_241_080.0];

    #[test]
    fn files_become_solids_where_the_database_has_them() {
        let options = LayerOptions::default();
        let layer = read(&sample("town.gpkg"), &options).unwrap();
        let (features, notes) = place(&layer, &options, &Crs::from_epsg(25832).unwrap(), AREA).unwrap();
        assert_eq!(features.len(), 3 + 2 + 60, "{notes:?}");
        let mut features = features;
        prepare(&mut features);
        let level = |_: DVec2| Some(600.0);
        let bound: Vec<Bound> = features
            .iter()
            .flat_map(|feature| bind(&feature.meaning, &feature.geometry, feature.hash, &level))
            .collect();

        // One row has two buildings.
        assert_eq!(bound.len(), 4 + 2 + 60);
        let square =
            Square { origin: dvec2(AREA[0], AREA[1]), first: [0; 2], spacing: 1.0, columns: 130, rows: 80 };
        let mut solids: Vec<PlacedSolid> = Vec::new();
        bound.iter().for_each(|bound| bound.raise(&square, &|_: DVec2| Some(600.0), &mut solids));
        let over = |x: usize, y: usize| {
            let here = solids.iter().filter(|placed| placed.voxel == square.index(x, y));
            here.map(|placed| placed.solid.high_m).fold(f64::NEG_INFINITY, f64::max)
        };

        // The church is 30 m high, and open in its middle; the pair has three levels and a roof.
        assert_eq!(over(42, 20), 630.0);
        assert_eq!(over(54, 20), f64::NEG_INFINITY);
        assert!((609.0..616.0).contains(&over(125, 5)));
    }

    #[test]
    fn degrees_come_to_metres_and_far_rows_stay_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.geojson");
        let crs = Crs::from_epsg(25832).unwrap();
        let back = Transform::new(&crs, &Crs::wgs84()).unwrap();
        let (x, y) = back.apply(612_050.0, 5_241_040.0).unwrap();
        let tree = |x: f64, y: f64| {
            format!(
                r#"{{"type":"Feature","geometry":{{"type":"Point","coordinates":[{x},{y}]}},"properties":{{"natural":"tree"}}}}"#
            )
        };
        std::fs::write(&path, format!("{}\n{}\n", tree(x, y), tree(x + 1.0, y))).unwrap();
        let options = LayerOptions::default();
        let (features, notes) = place(&read(&path, &options).unwrap(), &options, &crs, AREA).unwrap();
        let [feature] = &features[..] else { panic!("{features:?}") };
        assert!(feature.geometry.points.places[0].distance(dvec2(612_050.0, 5_241_040.0)) < 1e-3);
        assert_eq!(notes, ["a.geojson: feature 2 is left out: it lies outside of the area"]);
    }

    #[test]
    fn wide_features_reach_farther() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.geojson");

        // 190 m west of the area.
        let place_of = |tags: &str, is_point: bool| {
            let geometry = if is_point {
                r#""Point","coordinates":[611810,5241040]"#
            } else {
                r#""LineString","coordinates":[[611810,5240000],[611810,5242000]]"#
            };
            format!(r#"{{"type":"Feature","geometry":{{"type":{geometry}}},"properties":{{{tags}}}}}"#)
        };

        let table = [
            (r#""highway":"primary","width":120"#, false, 0),
            (r#""highway":"primary","width":200"#, false, 1),
            (r#""waterway":"river","width":900"#, false, 1),
            (r#""waterway":"stream""#, false, 0),
            (r#""man_made":"gasometer","height":90,"diameter":200"#, true, 1),
        ];

        for (tags, is_point, expected) in table {
            std::fs::write(&path, place_of(tags, is_point)).unwrap();
            let options = LayerOptions { crs: Some("EPSG:25832".into()), ..LayerOptions::default() };
            let crs = Crs::from_epsg(25832).unwrap();
            let (features, notes) = place(&read(&path, &options).unwrap(), &options, &crs, AREA).unwrap();
            assert_eq!(features.len(), expected, "{tags}: {notes:?}");
        }
    }

    #[test]
    fn outlines_that_enclose_nothing_are_told() {
        let polygon = |tags: &str, ring: &str| {
            format!(
                r#"{{"type":"Feature","geometry":{{"type":"Polygon","coordinates":[[{ring}]]}},"properties":{{{tags}}}}}"#
            )
        };
        let bow_tie = "[612010,5241010],[612020,5241020],[612020,5241010],[612010,5241020],[612010,5241010]";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.geojson");
        let uneven = "[612010,5241030],[612020,5241044],[612020,5241030],[612010,5241040],[612010,5241030]";
        let line = r#"{"type":"Feature","geometry":{"type":"LineString","coordinates":[[612010,5241010],[612020,5241020]]},"properties":{"building":"yes"}}"#;

        let lines = [
            polygon(r#""building":"yes""#, bow_tie),
            polygon(r#""barrier":"fence""#, bow_tie),
            polygon(r#""building":"yes""#, uneven),
            polygon(r#""barrier":"fence""#, uneven),
            line.to_owned(),
        ];

        std::fs::write(&path, lines.join("\n")).unwrap();
        let options = LayerOptions { crs: Some("EPSG:25832".into()), ..LayerOptions::default() };
        let crs = Crs::from_epsg(25832).unwrap();
        let (features, notes) = place(&read(&path, &options).unwrap(), &options, &crs, AREA).unwrap();
        assert_eq!(features.len(), 3, "{notes:?}");

        for expected in [
            "a.geojson: feature 1 is left out: its outline encloses nothing: it crosses itself, or is a line",
            "a.geojson: feature 3 is left out in part: its outline crosses itself, and what that goes around the other way is no inside",
            "a.geojson: feature 5 is left out: it is a building, and has no outline but a point or a line",
        ] {
            assert!(notes.iter().any(|note| note == expected), "{notes:?}");
        }

        assert!(!notes.iter().any(|note| note.contains("feature 4") || note.contains("rows")), "{notes:?}");
    }

    #[test]
    fn local_files_have_no_place_on_earth() {
        let options = LayerOptions { crs: Some("local".into()), ..LayerOptions::default() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        std::fs::write(&path, r#"{"type":"Point","coordinates":[5,5]}"#).unwrap();
        let layer = read(&path, &options).unwrap();
        let error = place(&layer, &options, &Crs::from_epsg(25832).unwrap(), AREA).unwrap_err().to_string();
        assert!(error.contains("local"), "{error}");
    }

    #[test]
    fn outlines_of_towers_are_round_or_have_walls() {
        let ring = |corners: u32, radius: f64, uneven: f64| -> Area {
            let place = |corner: u32| {
                let turn = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
                let radius = radius * if corner.is_multiple_of(2) { 1.0 } else { 1.0 + uneven };
                dvec2(612_050.0, 5_241_040.0) + DVec2::from_angle(turn) * radius
            };
            Area { outer: Outline::flat((0..corners).map(place).collect()), holes: vec![] }
        };
        for (corners, uneven, expected) in
            [(4, 0.0, false), (8, 0.0, false), (12, 0.0, true), (40, 0.02, true), (40, 0.2, false)]
        {
            assert_eq!(is_circle(&ring(corners, 9.0, uneven)), expected, "{corners} {uneven}");
        }
    }
}
