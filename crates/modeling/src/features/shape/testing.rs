//! Forms and grounds for tests.

use glam::{DVec2, dvec2};

use super::super::kinds::{Building, Paint, Rise, Roof, RoofShape, Top, Way, WayKind};
use super::super::layer::{Area, Geometry, Path};
use super::{Bound, Ground, PlacedSolid, Square};
use hedgehop::voxel::HeightCode;
use hedgehop::voxel::Material;

pub(super) const PAINT: Paint = Paint { colour: [100, 110, 120], material: Material::Asphalt };
pub(super) const HEIGHTS: HeightCode = HeightCode { scale: 0.05, offset: 0.0 };

pub(super) fn square(spacing: f64) -> Square {
    Square { origin: dvec2(612_000.0, 5_241_000.0), first: [0; 2], spacing, columns: 64, rows: 48 }
}

pub(super) fn at(x: f64, y: f64) -> DVec2 {
    square(1.0).corner() + dvec2(x, y)
}

pub(super) fn of_area(places: Vec<DVec2>) -> Geometry {
    Geometry { areas: vec![Area { outer: Path::flat(places), holes: vec![] }], ..Geometry::default() }
}

pub(super) fn of_line(places: &[DVec2]) -> Geometry {
    Geometry { lines: vec![Path::flat(places.to_vec())], ..Geometry::default() }
}

pub(super) fn of_point(place: DVec2) -> Geometry {
    Geometry { points: Path::flat(vec![place]), ..Geometry::default() }
}

pub(super) fn rectangle(centre: DVec2, half: DVec2, turn: DVec2) -> Vec<DVec2> {
    [dvec2(-1.0, -1.0), dvec2(1.0, -1.0), dvec2(1.0, 1.0), dvec2(-1.0, 1.0)]
        .map(|c| centre + turn.rotate(c * half))
        .into()
}

pub(super) fn level(_: DVec2) -> Option<f64> {
    Some(100.0)
}

pub(super) fn hills(place: DVec2) -> Option<f64> {
    let local = place - square(1.0).corner();
    Some(100.0 + 6.0 * (local.x / 9.0).sin() + 4.0 * (local.y / 13.0).cos() + 0.05 * local.x)
}

pub(super) fn raised(bound: &[Bound], square: &Square, ground: &dyn Ground) -> Vec<PlacedSolid> {
    let mut out = Vec::new();
    bound.iter().for_each(|bound| bound.raise(square, ground, &mut out));
    out
}

pub(super) fn natural(square: &Square, ground: &dyn Ground) -> Vec<f64> {
    let all = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
    square
        .voxels(all)
        .map(|(column, row)| ground.height_at(square.centre(column, row)).unwrap_or(f64::NAN))
        .collect()
}

pub(super) fn house(shape: RoofShape, rise: Rise) -> Building {
    let roof = Roof { shape, rise, direction: None, across: false, is_guess: false };
    Building {
        top: Top::Eaves(6.0),
        min_height_m: 0.0,
        roof,
        walls: PAINT,
        cover: PAINT,
        is_part: false,
        facade: None,
    }
}

pub(super) fn road(width_m: f64) -> Way {
    Way {
        kind: WayKind::Road,
        width_m,
        paint: PAINT,
        most_grade: 0.1,
        is_bridge: false,
        layer: 0,
        lines: None,
    }
}
