//! Roads, railways, runways and flowing water.

use super::super::kinds::{Meaning, Paint, Way, WayKind};
use super::road_lines::road_lines;
use super::tags::Tags;
use hedgehop::voxel::Material;

const ASPHALT: Paint = Paint { colour: [92, 92, 94], material: Material::Asphalt };
const GRAVEL: Paint = Paint { colour: [164, 152, 130], material: Material::Gravel };
const SOIL: Paint = Paint { colour: [142, 122, 94], material: Material::Soil };
const CONCRETE: Paint = Paint { colour: [150, 148, 144], material: Material::Concrete };

/// Usual width in metres, surface, and steepest grade of a class of roads.
fn usual(class: &str) -> Option<(f64, Paint, f64)> {
    Some(match class {
        "motorway" => (11.5, ASPHALT, 0.06),
        "trunk" => (9.5, ASPHALT, 0.07),
        "motorway_link" | "trunk_link" => (6.0, ASPHALT, 0.08),
        "primary" => (8.0, ASPHALT, 0.09),
        "secondary" | "primary_link" => (7.0, ASPHALT, 0.1),
        "tertiary" | "secondary_link" | "tertiary_link" => (6.5, ASPHALT, 0.12),
        "residential" | "busway" | "raceway" => (6.0, ASPHALT, 0.15),
        "unclassified" | "road" | "" => (5.5, ASPHALT, 0.15),
        "living_street" | "pedestrian" => (5.0, CONCRETE, 0.15),
        "service" => (4.0, ASPHALT, 0.18),
        "track" | "track_grade1" | "track_grade2" | "track_grade3" => (3.0, GRAVEL, 0.22),
        "track_grade4" | "track_grade5" => (2.8, SOIL, 0.25),
        "cycleway" => (2.5, ASPHALT, 0.15),
        "footway" | "sidewalk" | "platform" => (1.8, CONCRETE, 0.25),
        "bridleway" => (2.0, SOIL, 0.3),
        "path" | "via_ferrata" => (1.0, SOIL, 0.6),
        "steps" => (2.0, CONCRETE, 0.7),
        _ => return None,
    })
}

/// A road; `None` for what is planned, or is no way.
pub(super) fn road(tags: &mut Tags<'_>, class: &str) -> Option<Meaning> {
    let (width, paint, most_grade) = usual(class)?;
    let paint = surface(tags, paint);
    if tags.has_area() {
        return Some(Meaning::Pavement(paint));
    }
    let columns = &tags.options.columns;
    let said = tags.length(columns.width.as_ref(), &["width", "est_width"]);
    let lanes = tags.count(None, &["lanes"], &(1.0..=20.0));
    let lane = if matches!(class, "motorway" | "trunk") { 3.6 } else { 3.25 };
    // Shoulders and kerbs belong to what is seen as the road.
    let width_m = said.or_else(|| lanes.map(|lanes| lanes * lane + width * 0.2)).unwrap_or(width);
    let lines = road_lines(tags, class, paint, width_m);
    Some(Meaning::Way(Way { lines, ..way(tags, WayKind::Road, width_m, paint, most_grade) }))
}

fn surface(tags: &mut Tags<'_>, paint: Paint) -> Paint {
    let columns = &tags.options.columns;
    tags.paint(
        [columns.colour.as_ref(), columns.material.as_ref()],
        &["surface:colour", "colour"],
        &["surface"],
        paint,
    )
}

fn way(tags: &Tags<'_>, kind: WayKind, width_m: f64, paint: Paint, most_grade: f64) -> Way {
    let layer = tags.text("layer").and_then(|layer| layer.parse().ok()).unwrap_or(0);
    // dBASE says T and F, and so do extracts.
    let is_bridge = tags.yes("bridge").is_some_and(|bridge| bridge != "abandoned");
    Way { kind, width_m, paint, most_grade, is_bridge, layer, lines: None }
}

/// A railway; `None` for what is none any more, or runs elsewhere.
pub(super) fn railway(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let (width, paint) = match kind {
        "rail" | "light_rail" | "" => (4.5, Paint { colour: [124, 116, 108], material: Material::Gravel }),
        "narrow_gauge" | "miniature" | "funicular" => {
            (3.0, Paint { colour: [126, 118, 108], material: Material::Gravel })
        }
        "tram" | "monorail" => (2.6, Paint { colour: [110, 108, 104], material: Material::Concrete }),
        "disused" | "abandoned" | "preserved" => {
            (3.5, Paint { colour: [128, 122, 96], material: Material::Gravel })
        }
        _ => return None,
    };
    let columns = &tags.options.columns;
    let tracks = tags.count(None, &["tracks"], &(1.0..=30.0)).unwrap_or(1.0);
    let said = tags.length(columns.width.as_ref(), &["width"]);
    let width_m = said.unwrap_or(width + (tracks - 1.0) * 4.2);
    let paint = surface(tags, paint);
    Some(Meaning::Way(way(tags, WayKind::Railway, width_m, paint, 0.05)))
}

/// A runway, taxiway or apron.
pub(super) fn aeroway(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let (width, paint) = match kind {
        "runway" | "" => (45.0, ASPHALT),
        "taxiway" | "taxilane" | "parking_position" => (18.0, ASPHALT),
        "stopway" => (45.0, GRAVEL),
        "apron" | "helipad" => (20.0, CONCRETE),
        _ => return None,
    };
    let paint = surface(tags, paint);
    if tags.has_area() {
        return Some(Meaning::Pavement(paint));
    }
    let columns = &tags.options.columns;
    let width_m = tags.length(columns.width.as_ref(), &["width"]).unwrap_or(width);
    Some(Meaning::Way(way(tags, WayKind::Runway, width_m, paint, 0.02)))
}

/// Water that flows, or an area of it.
pub(super) fn waterway(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let width = match kind {
        "river" | "" => 12.0,
        "canal" | "tidal_channel" => 10.0,
        "stream" => 2.0,
        "ditch" | "drain" | "brook" => 1.2,
        "riverbank" | "dock" | "boatyard" => {
            return Some(if tags.has_area() { Meaning::River(0.0) } else { Meaning::Unknown });
        }
        _ => return None,
    };
    let columns = &tags.options.columns;
    let said = tags.length(columns.width.as_ref(), &["width", "est_width"]);
    Some(Meaning::River(said.unwrap_or(width)))
}
