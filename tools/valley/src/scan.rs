//! The farm as a laser scanner in an aeroplane sees it: points of ground, roofs, walls and crowns.
//!
//! ```text
//! ground: one point in each half metre square, somewhere in it, but not below roofs, and rarely below crowns
//! roofs:  the same, two points; walls a few, at places along them
//! trees:  points in the outer part of an ellipsoid and few on the stem
//! ```

use std::error::Error;
use std::io::Cursor;

use glam::{DVec2, dvec2};
use las::point::{Classification, Format};
use las::{Builder, Color, Point, Transform, Vector, Vlr, Writer};

use crate::farm::{
    FENCE, Farm, FarmPart, FarmTree, PARTS, TREES, area_from_farm, farm_from_area, roof_colour,
};
use crate::geotiff::{GEO_KEYS, ORIGIN};
use crate::grid::{around, sample};
use crate::land::Valley;
use crate::noise::uniform;
use crate::palette::{Material, colour};
use crate::sites::FARM;

/// Side of the squares that hold a point of ground each, metres.
const STEP: f64 = 0.5;

/// ASPRS classes (LAS Specification 1.4 R15, table 17).
pub const GROUND: u8 = 2;
const LOW: u8 = 3;
const HIGH: u8 = 5;
pub const BUILDING: u8 = 6;

/// A point: metres in the area, metres above the sea.
pub struct Mark {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub class: u8,
    pub colour: [u8; 3],
}

/// A number 0 … 1 of a point and a use.
fn chance(point: i64, salt: u64) -> f64 {
    uniform(point, 0, 780 + salt)
}

/// All points.
pub fn take(valley: &Valley) -> Vec<Mark> {
    let farm = Farm::new(&valley.bare);
    let [west, south, east, north] = FARM;
    let (columns, rows) = (((east - west) / STEP) as i64, ((north - south) / STEP) as i64);
    let mut marks = Vec::new();

    for cell in 0..columns * rows {
        let (row, column) = (cell / columns, cell % columns);
        for echo in 0..2i64 {
            let point = 2 * cell + echo;
            let x = west + STEP * (column as f64 + chance(point, 0));
            let y = south + STEP * (row as f64 + chance(point, 1));
            let (u, v) = farm_from_area(x, y);
            if let Some((z, part)) = farm.roof(u, v) {
                marks.push(Mark { x, y, z, class: BUILDING, colour: roof_colour(part, u, v) });
            } else if echo == 0 && (!below_crown(u, v) || chance(point, 2) < 0.3) {
                let z = sample(&valley.bare, x, y);
                let seen = around(x, y, 0.0).next().map_or([106, 122, 66], |pixel| valley.colours[pixel]);
                marks.push(Mark { x, y, z, class: GROUND, colour: seen });
            }
        }
    }

    for part in PARTS.iter().filter(|part| part.walls.is_some()) {
        walls(part, &farm, &valley.bare, &mut marks);
    }
    for (number, tree) in TREES.iter().enumerate() {
        grow(number as i64, tree, &valley.bare, &mut marks);
    }

    fence(&valley.bare, &mut marks);
    marks
}

fn below_crown(u: f64, v: f64) -> bool {
    TREES.iter().any(|tree| (u - tree.place.x).hypot(v - tree.place.y) < tree.radius)
}

/// Three points a metre along the walls, between ground and roof.
fn walls(part: &FarmPart, farm: &Farm, bare: &[f64], marks: &mut Vec<Mark>) {
    let DVec2 { x: mu, y: mv } = part.middle;

    // Just within the roof's edge.
    let (length, width) = (part.half.x - 0.05, part.half.y - 0.05);
    let corners =
        [dvec2(-length, -width), dvec2(length, -width), dvec2(length, width), dvec2(-length, width)];
    for (side, (a, b)) in corners.into_iter().zip(corners.into_iter().cycle().skip(1)).enumerate() {
        let count = (3.0 * (b.x - a.x).hypot(b.y - a.y)) as i64;
        for k in 0..count {
            let point = (mu * 1000.0) as i64 * 10_000 + side as i64 * 1000 + k;
            let t = (k as f64 + chance(point, 3)) / count as f64;
            let (u, v) = (mu + a.x + t * (b.x - a.x), mv + a.y + t * (b.y - a.y));
            let Some((roof, _)) = farm.roof(u, v) else { continue };
            let DVec2 { x, y } = area_from_farm(u, v);
            // Nothing is seen of walls inside of the house.
            if inner(u, v) {
                continue;
            }
            let ground = sample(bare, x, y);
            let z = ground + 0.3 + (roof - ground - 0.3) * chance(point, 4);
            marks.push(Mark { x, y, z, class: BUILDING, colour: part.walls.unwrap_or([200; 3]) });
        }
    }
}

/// Whether a place lies in two parts at once, or at their joint.
fn inner(u: f64, v: f64) -> bool {
    let holds = |part: &&FarmPart| {
        (u - part.middle.x).abs() < part.half.x + 0.1 && (v - part.middle.y).abs() < part.half.y + 0.1
    };
    PARTS.iter().filter(holds).count() > 1
}

fn grow(number: i64, tree: &FarmTree, bare: &[f64], marks: &mut Vec<Mark>) {
    let &FarmTree { place, radius, tall } = tree;
    let DVec2 { x: x0, y: y0 } = area_from_farm(place.x, place.y);
    let base = sample(bare, x0, y0);
    let crown = 0.36 * tall;
    let middle = tall - crown;
    let count = (22.0 * radius * radius) as i64;

    for k in 0..count {
        let point = number * 10_000 + k;
        // Even on the sphere; mostly on its upper side, where the light of the scanner ends.
        let up = 1.0 - 1.75 * chance(point, 5);
        let (s, c) = (std::f64::consts::TAU * chance(point, 6)).sin_cos();
        let out = radius * (1.0 - up * up).max(0.0).sqrt();
        let deep = 1.0 - 0.35 * chance(point, 7).powi(2);
        let shade = (3.0 * up).round() / 3.0 - 0.4;

        marks.push(Mark {
            x: x0 + out * deep * c,
            y: y0 + out * deep * s,
            z: base + middle + crown * up * deep,
            class: HIGH,
            colour: colour(Material::BroadMid, shade),
        });
    }

    for k in 0..10 {
        let point = number * 10_000 + 9000 + k;
        let (s, c) = (std::f64::consts::TAU * chance(point, 8)).sin_cos();
        marks.push(Mark {
            x: x0 + 0.15 * c,
            y: y0 + 0.15 * s,
            z: base + 0.4 + (middle - 0.8 * crown).max(1.0) * (k as f64 + chance(point, 9)) / 10.0,
            class: HIGH,
            colour: [92, 76, 58],
        });
    }
}

/// Posts and rails: points in three heights.
fn fence(bare: &[f64], marks: &mut Vec<Mark>) {
    for (side, pair) in FENCE.windows(2).enumerate() {
        let [DVec2 { x: au, y: av }, DVec2 { x: bu, y: bv }] = [pair[0], pair[1]];
        let count = (6.0 * (bu - au).hypot(bv - av)) as i64;
        for k in 0..count {
            let t = (k as f64 + chance(k + 1000 * side as i64, 10)) / count as f64;
            let DVec2 { x, y } = area_from_farm(au + t * (bu - au), av + t * (bv - av));
            let z = sample(bare, x, y) + 0.45 + 0.35 * (k % 3) as f64;
            marks.push(Mark { x, y, z, class: LOW, colour: [128, 112, 90] });
        }
    }
}

/// The file: LAZ 1.2, point format 2, centimetres.
pub fn encode(marks: &[Mark]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut builder = Builder::from((1, 2));
    builder.point_format = Format::new(2)?;
    builder.point_format.is_compressed = true;

    // The same bytes on every day.
    builder.date = None;
    builder.system_identifier = String::from("synthetic");
    builder.generating_software = String::from("hedgehop-valley");
    let axis = |offset: f64| Transform { scale: 0.01, offset };
    builder.transforms = Vector { x: axis(ORIGIN.x), y: axis(ORIGIN.y), z: axis(0.0) };
    let data = GEO_KEYS.iter().flat_map(|key| key.to_le_bytes()).collect();

    builder.vlrs.push(Vlr {
        user_id: "LASF_Projection".into(),
        record_id: 34735,
        description: "EPSG:32632".into(),
        data,
    });
    let mut writer = Writer::new(Cursor::new(Vec::new()), builder.into_header()?)?;

    for mark in marks {
        let [red, green, blue] = mark.colour.map(|code| u16::from(code) << 8);
        writer.write_point(Point {
            x: ORIGIN.x + mark.x,
            y: ORIGIN.y + mark.y,
            z: mark.z,
            classification: Classification::new(mark.class)?,
            color: Some(Color::new(red, green, blue)),
            return_number: 1,
            number_of_returns: 1,
            ..Point::default()
        })?;
    }

    Ok(writer.into_inner()?.into_inner())
}
