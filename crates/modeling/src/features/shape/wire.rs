//! Wires between two places: parabolas, as hanging wires are where they sag little.
//!
//! `z(s) = z₀ + (z₁ − z₀) s/L − 4 f s/L (1 − s/L)`, f the sag: how far the middle hangs below the straight line. Between ends of one
//! height the catenary of the same sag (Irvine, *Cable Structures*, 1981) differs by f (f/L)²/3: 3 mm for 9 m in 300 m.

use glam::DVec2;

use super::super::kinds::{Paint, PowerLine, Upright};
use super::ribbon::Line;
use super::round::BoundUpright;
use super::solid::{Ground, PlacedSolid, Solid, Square, Wall, stored_facing, stored_slope};
use hedgehop::voxel::Material;

/// One span of one wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundWire {
    /// Ends of the wire.
    pub(super) ends: [DVec2; 2],
    /// Heights of its ends, metres.
    pub(super) ends_m: [f64; 2],
    /// Depth by which its middle hangs below the straight line, metres.
    pub(super) sag_m: f64,
    /// Thickness, metres.
    pub(super) thickness_m: f64,
}

/// Metal that has been in the weather.
const WIRE: Paint = Paint { colour: [92, 94, 96], material: Material::Metal };
/// Thickness of wires, metres.
const THICKNESS: f64 = 0.04;
/// Thickness of arms, metres.
const ARM: f64 = 0.3;
/// Most of a wire's height that it sags.
const MOST_SAG: f64 = 0.6;

impl BoundWire {
    /// Height at a share of its length, 0…1, metres, and its slope along the wire.
    pub fn height(&self, share: f64) -> (f64, f64) {
        let [first, last] = self.ends_m;
        let length = self.ends[0].distance(self.ends[1]);
        let height = first + (last - first) * share - 4.0 * self.sag_m * share * (1.0 - share);
        (height, (last - first - 4.0 * self.sag_m * (1.0 - 2.0 * share)) / length)
    }

    /// Raises its solids, with the index of their voxel: strips.
    pub fn raise(&self, square: &Square, out: &mut Vec<PlacedSolid>) {
        let [a, b] = self.ends;
        let Some(tangent) = (b - a).try_normalize() else { return };

        // Directions and slopes are stored in steps. In the middle of its way through a voxel a wire is where it should be, whatever they make of
        // its ends; else it would lie beside a voxel of which it cuts a corner.
        let facing = stored_facing((-tangent.x).atan2(tangent.y));
        let length = a.distance(b);
        let (low, high) = (a.min(b), a.max(b));
        let (columns, rows) = square.touched([low.x, low.y, high.x, high.y]);

        for row in rows {
            // Of each row, the voxels that the line crosses.
            let south = square.centre(0, row).y - 0.5 * square.spacing;
            let Some((from, to)) = within(a.y, tangent.y, length, south, south + square.spacing) else {
                continue;
            };

            let (x0, x1) = (a.x + tangent.x * from, a.x + tangent.x * to);
            let (touched, _) = square.touched([x0.min(x1), a.y, x0.max(x1), a.y]);
            for column in touched.start.max(columns.start)..touched.end.min(columns.end) {
                let centre = square.centre(column, row);
                let west = centre.x - 0.5 * square.spacing;
                let Some((enter, leave)) = within(a.x, tangent.x, length, west, west + square.spacing) else {
                    continue;
                };

                let (enter, leave) = (enter.max(from), leave.min(to));
                if leave - enter <= 1e-9 * square.spacing {
                    continue;
                }

                let along = enter.midpoint(leave);
                let (middle_m, grade) = self.height(along / length);
                let middle = a + tangent * along - centre;
                let slope = stored_grade(tangent, grade);
                let height = middle_m - middle.dot(slope.into());
                let half = 0.5 * self.thickness_m;

                let solid = Solid {
                    slope,
                    wall: Wall::Plane { facing, distance_m: middle.dot(DVec2::from_angle(facing)) },
                    parallel: true,
                    strip: true,
                    ..Solid::level(Some(height - half), height + half, WIRE)
                };

                out.push(solid.over(square.index(column, row)));
            }
        }
    }
}

/// The slope that is stored for a grade in a direction (a unit vector): the axis nearer to it makes up for what the other is rounded by, since
/// across a wire slope says little.
fn stored_grade(tangent: DVec2, grade: f64) -> [f64; 2] {
    let major = usize::from(tangent.y.abs() > tangent.x.abs());
    let minor = 1 - major;
    let mut slope = [0.0; 2];
    slope[minor] = stored_slope(grade * tangent[minor]);
    slope[major] = stored_slope((grade - slope[minor] * tangent[minor]) / tangent[major]);
    slope
}

/// Finds from where to where along a line of a length one coordinate lies within bounds.
fn within(start: f64, step: f64, length: f64, low: f64, high: f64) -> Option<(f64, f64)> {
    if step == 0.0 {
        return (start >= low && start < high).then_some((0.0, length));
    }
    let (a, b) = ((low - start) / step, (high - start) / step);
    let (from, to) = (a.min(b).max(0.0), a.max(b).min(length));
    (from < to).then_some((from, to))
}

/// Heights of the pylons' arms above the ground, and their lengths to either side, metres.
fn arms(power: &PowerLine) -> Vec<(f64, f64)> {
    let mut arms: Vec<(f64, f64)> = Vec::new();
    for wire in power.wires.iter().filter(|wire| wire.offset_m != 0.0) {
        let reach = wire.offset_m.abs();
        match arms.iter_mut().find(|(height, _)| *height == wire.height_m) {
            Some((_, longest)) => *longest = longest.max(reach),
            None => arms.push((wire.height_m, reach)),
        }
    }
    arms
}

/// The wires, arms and pylons of a power line; those over no ground are left out.
pub(super) fn bind(
    power: &PowerLine,
    line: &Line,
    ground: &dyn Ground,
) -> (Vec<BoundWire>, Vec<BoundUpright>) {
    let places = line.places();
    let foot: Vec<Option<f64>> = places.iter().map(|place| ground.height_at(*place)).collect();

    // Arms halve the angle of the line.
    let right: Vec<DVec2> = (0..places.len())
        .map(|index| {
            let before = index
                .checked_sub(1)
                .map_or(DVec2::ZERO, |before| (places[index] - places[before]).normalize_or_zero());
            let after = places
                .get(index + 1)
                .map_or(DVec2::ZERO, |after| (*after - places[index]).normalize_or_zero());
            let along = (before + after).try_normalize().unwrap_or(before);
            DVec2::new(along.y, -along.x)
        })
        .collect();

    // What stands at a vertex by a row of its own is as high as that says, and so are its arms.
    let pylons: Vec<&Upright> = places
        .iter()
        .map(|place| {
            let own = power.stated.iter().find(|(at, _)| at == place);
            own.map_or(&power.pylon, |(_, pylon)| pylon)
        })
        .collect();

    let scale: Vec<f64> = pylons.iter().map(|pylon| pylon.height_m / power.pylon.height_m).collect();
    let mut wires = Vec::new();
    for index in 0..places.len() - 1 {
        let (Some(first), Some(last)) = (foot[index], foot[index + 1]) else { continue };
        for wire in &power.wires {
            let end = |index: usize| places[index] + right[index] * wire.offset_m;
            let ends = [end(index), end(index + 1)];
            let span = ends[0].distance(ends[1]);
            let above = [index, index + 1].map(|end| wire.height_m * scale[end]);
            wires.push(BoundWire {
                ends,
                ends_m: [first + above[0], last + above[1]],
                sag_m: (power.sag_per_m * span * span).min(MOST_SAG * above[0].min(above[1])),
                thickness_m: THICKNESS,
            });
        }
    }

    for index in 0..places.len() {
        let Some(foot) = foot[index] else { continue };
        for (height_m, offset) in arms(power) {
            let reach = right[index] * offset;
            let ends = [places[index] - reach, places[index] + reach];
            let ends_m = [foot + height_m * scale[index]; 2];
            wires.push(BoundWire { ends, ends_m, sag_m: 0.0, thickness_m: ARM });
        }
    }

    let pylon = |((place, foot), upright): ((&DVec2, &Option<f64>), &&Upright)| {
        let radius = 0.5 * upright.diameter_m.unwrap_or(0.3);
        foot.map(|base_m| BoundUpright { middle: *place, radius, base_m, upright: **upright })
    };

    (wires, places.iter().zip(&foot).zip(&pylons).filter_map(pylon).collect())
}
