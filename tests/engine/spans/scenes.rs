//! Ground with houses, roofs, trees and bridges on it.

use std::collections::BTreeMap;

use glam::DVec2;

use hedgehop::voxel::{
    Arrays, Cut, Facade, Grid, HeightCode, MemPages, Metadata, Placement, SharedObject, SharedObjects, Span,
    SpanArrays, SpanTable, Symmetry, build_standing,
};

/// Voxels along the area's side, and the side of one, metres.
pub const SIDE: u32 = 320;
pub const SPACING: f64 = 2.0;

/// Steps of 1 mm from 10 m below the datum on.
pub const CODE: HeightCode = HeightCode { scale: 1.0e-3, offset: -10.0 };

/// An opaque span on the ground, its upper end `high` metres high.
pub fn pillar(high: f64) -> Span {
    Span {
        low: Span::GROUND,
        high: CODE.encode(high),
        slope: [0, 0],
        cuts: [Cut::NONE; 3],
        top: [200, 60, 50],
        state: Span::OPAQUE,
        side: [220, 210, 190],
        material: 2,
        facade: Facade::NONE,
    }
}

/// Level ground at 0 m with spans; the surface is their highest upper end.
pub fn standing(spans_of: impl Fn(u32, u32) -> Vec<Span>) -> MemPages {
    standing_as(false, spans_of)
}

/// The same with all that stands as objects of 20 × 20 voxels, each of them placed once.
pub fn standing_as(objects: bool, spans_of: impl Fn(u32, u32) -> Vec<Span>) -> MemPages {
    standing_on(|_, _| 0.0, objects, spans_of)
}

/// The same on ground of that height over the centres of voxels, metres.
pub fn standing_on(
    ground_of: impl Fn(u32, u32) -> f64,
    objects: bool,
    spans_of: impl Fn(u32, u32) -> Vec<Span>,
) -> MemPages {
    raised(&ground_of, objects, &spans_of)
}

/// Builds a database of ground and spans; compiled once for all closures.
fn raised(
    ground_of: &dyn Fn(u32, u32) -> f64,
    objects: bool,
    spans_of: &dyn Fn(u32, u32) -> Vec<Span>,
) -> MemPages {
    const PART: u32 = 20;
    const FOOT: u16 = 5000;

    let grid = Grid { nx: SIDE, ny: SIDE, spacing: SPACING, origin: DVec2::new(1000.0, 2000.0) };
    let voxels = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let spans: BTreeMap<_, _> =
        voxels().map(|at| (at, spans_of(at.0, at.1))).filter(|(_, spans)| !spans.is_empty()).collect();
    let ground: Vec<f64> = voxels().map(|(x, y)| ground_of(x, y)).collect();
    let top = |at: (u32, u32)| spans.get(&at).into_iter().flatten().map(|span| span.high).max();
    let top = |at: (u32, u32)| top(at).and_then(|code| CODE.decode(code)).unwrap_or(f64::NEG_INFINITY);
    let heights: Vec<f64> = voxels().zip(&ground).map(|(at, ground)| top(at).max(*ground)).collect();
    let grass = vec![[80, 120, 60]; ground.len()];
    let arrays = Arrays { grid, heights: &heights, colours: &grass, attributes: None };
    let (mut parts, mut placed) = (Vec::new(), Vec::new());
    let corners = (0..SIDE / PART).flat_map(|y| (0..SIDE / PART).map(move |x| (PART * x, PART * y)));

    for corner in corners.filter(|_| objects) {
        let above = |code: u16| if code == Span::GROUND { code } else { code - FOOT };
        let part = SharedObject::new([PART as u16; 2], SpanTable::rise(CODE, SPACING), |x, y, out| {
            let here = spans.get(&(corner.0 + u32::from(x), corner.1 + u32::from(y))).into_iter().flatten();
            out.extend(here.map(|span| Span { low: above(span.low), high: above(span.high), ..*span }));
        });
        let placement = Placement::new(parts.len() as u16, Symmetry::new(0), [0, 0], FOOT);
        placed.push(([i64::from(corner.0), i64::from(corner.1)], placement));
        parts.push(part);
    }

    let own = if objects { BTreeMap::new() } else { spans.clone() };
    let standing = SpanArrays {
        heights: &ground,
        colours: &grass,
        spans: &own,
        objects: &SharedObjects::new(parts),
        placed: &placed,
        code: CODE,
    };

    build_standing(&arrays, &standing, &Metadata::default()).unwrap()
}

/// Middle of [`pyramid`], units.
pub const APEX: DVec2 = DVec2::new(160.3, 160.6);

/// Half a ridge shorter than a voxel, units eastward.
pub const HALF_RIDGE: f64 = 0.18;

/// Height of a roof with hips to the north-east and so on, and half a ridge of this length (units), metres.
pub fn hipped_height(half_ridge: f64, at: DVec2) -> f64 {
    let [x, y] = (at - APEX).abs().to_array();
    20.0 - 0.5 * SPACING * (x - half_ridge).max(y).max(0.0)
}

/// The wedges of a pyramid over a voxel; four in that of its apex.
pub fn pyramid(x: u32, y: u32) -> Vec<Span> {
    hipped(0.0, x, y)
}

/// The parts of a hipped roof over a voxel; in that of its ridge, which is shorter, two of them lie within three joints.
pub fn short_ridge(x: u32, y: u32) -> Vec<Span> {
    hipped(HALF_RIDGE, x, y)
}

pub fn hipped(half_ridge: f64, x: u32, y: u32) -> Vec<Span> {
    let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    if (centre - APEX).abs().max_element() > 8.0 {
        return Vec::new();
    }

    let side = |quarter: u8| {
        let out = DVec2::from_angle(f64::from(quarter) * std::f64::consts::FRAC_PI_2).round();
        let (mut cuts, mut joined, mut count) = ([Cut::NONE; 3], 0, 0);

        // Lines at an eighth of a turn to either side of `out`, beyond which the neighbours are lower, and the ridge.
        let has_ridge = half_ridge > 0.0 && quarter % 2 == 1;
        for turn in [96_u8, 160, 128].into_iter().take(if has_ridge { 3 } else { 2 }) {
            let facing = turn.wrapping_add(64 * quarter);
            let normal = DVec2::from(Cut::wall(facing, 0).normal().map(f64::from));
            let end = half_ridge * if quarter.is_multiple_of(2) { out.x } else { normal.x.signum() };
            let end = if turn == 128 { APEX } else { APEX + DVec2::new(end, 0.0) };
            let distance = normal.dot(end - centre);
            let reach = 0.5 * normal.abs().element_sum();
            if distance <= -reach {
                return None;
            }

            if distance < reach {
                cuts[count] = Cut::wall(facing, (distance * f64::from(Cut::STEPS)).round() as i32);
                joined |= Span::JOINED.get(count).copied().unwrap_or_default();
                count += 1;
            }
        }

        let high = 20.0 - 0.5 * SPACING * (out.dot(centre - APEX) - out.x.abs() * half_ridge);
        let slope = (out * -0.5 * f64::from(Span::SLOPE_STEPS)).to_array().map(|slope| slope.round() as i8);
        Some(Span { cuts, slope, state: Span::OPAQUE | joined, ..pillar(high) })
    };

    (0..4).filter_map(side).collect()
}

/// Houses with gabled roofs, trees with stems, a bridge, a wire.
pub fn village(as_objects: bool) -> MemPages {
    standing_as(as_objects, |x, y| {
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let mut spans = Vec::new();
        for (index, (centre, turn)) in
            [((150.0, 140.0), 0.3), ((175.0, 150.0), 1.2), ((160.0, 170.0), 0.0), ((140.0, 165.0), -0.5)]
                .into_iter()
                .enumerate()
        {
            let to = DVec2::from_angle(-turn).rotate(at - DVec2::from(centre));
            let half = DVec2::new(7.0, 4.5);
            let Some(cuts) = walls_of(to, turn, half) else { continue };

            let down = DVec2::from_angle(turn).rotate(DVec2::new(0.0, -to.y.signum())) * 0.7;
            let wall = Span {
                cuts,
                slope: [(down.x * 32.0).round() as i8, (down.y * 32.0).round() as i8],
                top: [150 - 20 * index as u8, 60, 40],
                side: [225, 215, 190 - 30 * index as u8],
                ..pillar(6.0 + 0.7 * SPACING * (half.y - to.y.abs()))
            };

            spans.push(wall);
        }

        for (centre, high) in
            [((130.0, 140.0), 14.0), ((134.0, 150.0), 11.0), ((165.0, 185.0), 16.0), ((190.0, 170.0), 12.0)]
        {
            let out = at - DVec2::from(centre);
            tree(out, high, DENSE, &mut spans);
        }

        if (118..123).contains(&x) {
            spans.push(Span {
                low: CODE.encode(8.0),
                side: [130, 130, 130],
                top: [90, 90, 95],
                ..pillar(9.5)
            });
        }

        spans.sort_by_key(|span| (span.low, span.high));
        spans
    })
}

/// Walls in a voxel that lies `to` from the middle of a rectangle, along its axes, which is turned and has half sides; units. `None`: it is outside.
pub fn walls_of(to: DVec2, turn: f64, half: DVec2) -> Option<[Cut; 3]> {
    let inside = half - to.abs();
    if inside.min_element() < -0.75 {
        return None;
    }

    // Two walls at corners.
    let mut cuts = [Cut::NONE; 3];
    let walls = [(DVec2::new(to.x.signum(), 0.0), inside.x), (DVec2::new(0.0, to.y.signum()), inside.y)];
    let walls = walls.into_iter().filter(|(_, beyond)| *beyond <= 0.75);
    for (cut, (normal, beyond)) in cuts.iter_mut().zip(walls) {
        let angle = DVec2::from_angle(turn).rotate(normal).to_angle();
        *cut = Cut::wall(turn_of(angle), (beyond * 128.0).round() as i32);
    }
    Some(cuts)
}

/// A direction (radians) in 256ths of a turn.
fn turn_of(angle: f64) -> u8 {
    (angle / std::f64::consts::TAU * 256.0).round().rem_euclid(256.0) as u8
}

/// State of a crown that lets some light through.
pub const DENSE: u8 = 11;

/// A stem and a crown, `out` voxels from their middle.
fn tree(out: DVec2, high: f64, crown: u8, spans: &mut Vec<Span>) {
    if out.length() < 0.8 {
        spans.push(Span { side: [90, 70, 50], ..pillar(5.0) });
    }
    let radius = 3.6;
    if out.length() < radius {
        let half = 0.5 * (high - 4.0) * (1.0 - (out.length() / radius).powi(2)).sqrt();
        let middle = 0.5 * (high + 4.0);
        spans.push(Span {
            low: CODE.encode(middle - half),
            cuts: [Cut::round(turn_of(out.to_angle())), Cut::NONE, Cut::NONE],
            top: [60, 110, 40],
            side: [45, 85, 35],
            state: crown,
            ..pillar(middle + half)
        });
    }
}

/// Trees of many heights, some six voxels from each other.
pub fn wood(crown: u8) -> MemPages {
    standing_as(false, |x, y| {
        let mut spans = Vec::new();
        let (i, j) = (i64::from(x) / 6, i64::from(y) / 6);
        for (i, j) in (-1..=1).flat_map(|dj| (-1..=1).map(move |di| (i + di, j + dj))) {
            let chance = ((i * 73 + j * 151).rem_euclid(97)) as f64 / 97.0;
            let middle = DVec2::new(6.0 * i as f64 + 1.0 + 4.0 * chance, 6.0 * j as f64 + 5.0 - 4.0 * chance);
            let out = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - middle;
            tree(out, 9.0 + 9.0 * chance, crown, &mut spans);
        }
        spans.sort_by_key(|span| (span.low, span.high));
        spans
    })
}
