//! Planes and rows for any screen around one eye.
//!
//! Planes stand at equal steps of azimuth and rows at equal steps of elevation, both on a lattice that is the
//! world's and not the screen's, so that screens that abut share them. Towards nadir and zenith
//! azimuths crowd: the sphere is cut into *annuli* of elevation (Hughes patent, claim 15), and planes of each
//! are a step apart where it is nearest to the horizon:
//!
//! ```text
//! annuli begin at 0, 45, 60, 75, 82.5, 86.25, … degrees above and below the horizon
//! for each cone that holds some pixels' directions:
//!     mark the groups of planes, and their rows, that it touches        in each annulus
//! march the marked groups
//! for each pixel: azimuth and elevation → annulus, plane, row → light and inverse range, between neighbours
//! ```
//!
//! Rows lie half a step beside the horizon, so that ground that ends there ends between two of them, and
//! the outermost ones are nadir and zenith. Of distances inverse *range* is kept: it has no pole at the nadir,
//! and along a plane it is `A·sin ε + B·cos ε` over any flat ground, which weights of
//! `sin((1 − t)·s) / sin s` and `sin(t·s) / sin s` interpolate exactly.

mod annulus;
mod directions;

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use self::annulus::MARGIN;

pub use annulus::{Annulus, Between};
use directions::DirectionCell;
pub use directions::Directions;

use super::{PlaneGroup, RowCoordinate};
use crate::simd::math::atan2;
use crate::simd::{Each, Floats, LANES, Simd, Sixteen};
use crate::space::{Camera, Screen};
use crate::voxel::Grid;

/// Least angle of a pixel, radians: single precision tells a hundredth of it.
const LEAST_STEP: f64 = 5.0e-6;

/// Least square of a direction's level part: roots of 0 have no particular value.
const LEAST_SQUARE: f32 = 1.0e-20;

/// Widest step between planes and between rows, radians: the surface between them is taken for flat, however wide pixels are.
const WIDEST_STEP: f64 = 0.004;

/// Planar fields of view from which on most of a picture lies near its border, degrees; and the widest step there, radians: ground that is seen only at
/// the border is seen at a glance, and its curvature counts twice as much.
const WIDE: f64 = 150.0;
const BESIDE_STEP: f64 = 0.002;

/// Share of a step by which the outermost rows keep from nadir and zenith, whose tangent is infinite: light is counted
/// in tangents, and where they are large, single precision is short of digits.
const OFF_POLE: f64 = 0.25;

/// Pixels of a screen at most: the table of their directions takes twelve bytes for each.
const MOST_PIXELS: usize = MOST_WORDS / 4;

/// Crossings of planes and rows that directions may need for each of them, and besides: a table of rays with a stray direction
/// makes planes march what nobody sees, and the reference is faster.
const MOST_PER_PIXEL: f64 = 16.0;
const MOST_BESIDES: f64 = 4.0e6;

/// One group of planes that some pixel needs.
#[derive(Debug, Clone, PartialEq)]
struct Needed {
    annulus: usize,
    group: usize,
    rows: Range<usize>,
}

/// A screen of any kind as scan planes see it.
#[derive(Debug, Clone)]
pub struct Panorama {
    directions: Arc<Directions>,
    world_from_mapping: [[f32; 3]; 3],
    /// East and north of the azimuth from which pixels count theirs: that of the screen's axis, so that
    /// narrow views have small numbers.
    ahead: [f32; 2],
    /// Angle from one row to the next, radians.
    step: f64,
    /// Rows from nadir to zenith.
    rows: usize,
    annuli: Vec<Annulus>,
    /// Index of each row's annulus: a search would have pixels wait for it.
    by_row: Vec<u8>,
    needed: Vec<Needed>,
    /// Rows that some group has.
    extent: Range<usize>,
}

/// Why planes at equal steps of azimuth cannot serve a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Rays without a common origin.
    NoEye,
    /// Pixels closer than single precision can tell.
    FinePixels,
    /// Pixels too many for a table of them.
    ManyPixels,
}

/// Directions of sixteen pixels, and their places in the plane image.
pub struct Gaze<V: Simd> {
    /// Angle to the right of the screen's axis, radians.
    pub azimuth: V::F,
    /// Row, fractional.
    pub row: V::F,
    /// Pixels that have a ray.
    pub lit: V::M,
}

impl Panorama {
    /// Tells why planes cannot serve `camera`, before its rays are looked at; `None`: nothing speaks against it.
    pub fn refuses(camera: &Camera) -> Option<Refusal> {
        if matches!(camera.screen(), Screen::Orthographic { .. }) {
            Some(Refusal::NoEye)
        } else if fine_angle(camera) < LEAST_STEP {
            Some(Refusal::FinePixels)
        } else {
            let pixels = camera.width as usize * camera.height as usize;
            (pixels > MOST_PIXELS).then_some(Refusal::ManyPixels)
        }
    }

    /// Whether planes for the `directions` of `camera` are about as many as pixels.
    pub fn serves(camera: &Camera, directions: &Directions) -> bool {
        let step = fine_angle(camera).min(WIDEST_STEP);
        let pixels = f64::from(camera.width) * f64::from(camera.height);
        directions.solid_angle() <= step * step * (MOST_PER_PIXEL * pixels + MOST_BESIDES)
    }

    /// Builds the panorama for a screen that has `directions`.
    pub fn new(camera: &Camera, directions: Arc<Directions>) -> Self {
        let angle = fine_angle(camera).min(WIDEST_STEP);
        let half = (FRAC_PI_2 / angle - 0.5).ceil().max(1.0) as usize;
        let step = FRAC_PI_2 / (half as f64 + 0.5);
        let rows = 2 * half + 2;
        let world_from_mapping = camera.world_from_mapping();
        let ahead = world_from_mapping.z_axis.truncate().try_normalize().unwrap_or(DVec2::Y);
        let mut annuli = Annulus::all(rows, step, ahead.x.atan2(ahead.y));
        mark(&mut annuli, &directions, &world_from_mapping, [step, rows as f64]);
        let needed = place(&mut annuli);
        let begun = |row: usize| annuli.iter().filter(|annulus| annulus.rows.start <= row).count();

        Self {
            by_row: (0..rows).map(|row| begun(row).saturating_sub(1) as u8).collect(),
            directions,
            world_from_mapping: world_from_mapping.to_cols_array_2d().map(|axis| axis.map(|it| it as f32)),
            ahead: ahead.as_vec2().to_array(),
            step,
            rows,
            extent: Range {
                start: needed.iter().map(|needed| needed.rows.start).min().unwrap_or(0),
                end: needed.iter().map(|needed| needed.rows.end).max().unwrap_or(0),
            },
            annuli,
            needed,
        }
    }

    /// Elevation of a row, fractional, radians.
    fn elevation(&self, row: f64) -> f64 {
        let elevation = (row - 0.5 * (self.rows - 1) as f64) * self.step;
        let most = FRAC_PI_2 - OFF_POLE * self.step;
        elevation.clamp(-most, most)
    }

    /// Rows of the extent by the tangent of elevation.
    pub fn row_coordinate(&self, edges: &[f32]) -> RowCoordinate {
        let horizon = 0.5 * self.rows as f64 - self.extent.start as f64;
        RowCoordinate::angular(1.0 / self.step, horizon, edges)
    }

    /// Rows that some group has.
    pub fn extent(&self) -> Range<usize> {
        self.extent.clone()
    }

    /// Tangents of elevation of the lower edges of the rows of the extent, rising, and of the last one's upper edge.
    pub fn edges(&self) -> Vec<f32> {
        let Range { start, end } = self.extent;
        (start..=end).map(|row| self.elevation(row as f64 - 0.5).tan() as f32).collect()
    }

    /// Tangents of elevation of the middles of the rows of the extent, rising.
    pub fn centres(&self) -> Vec<f32> {
        self.extent().map(|row| self.elevation(row as f64).tan() as f32).collect()
    }

    /// Rows of all groups.
    pub fn all_rows(&self) -> usize {
        self.needed.iter().map(|needed| needed.rows.len()).sum()
    }

    /// Groups of sixteen planes.
    pub fn groups(&self) -> usize {
        self.needed.len()
    }

    /// Rows that a group fills; no others are kept of it.
    pub fn rows(&self, index: usize) -> Range<usize> {
        self.needed[index].rows.clone()
    }

    /// The planes of a group, from `eye` (units); depth is ground distance.
    pub fn group(&self, index: usize, grid: &Grid, eye: DVec3, inverse_diameter: f64) -> PlaneGroup {
        let needed = &self.needed[index];
        let planes = self.annuli[needed.annulus].planes() as f64;
        let directions = std::array::from_fn(|lane| {
            let azimuth = (needed.group * LANES + lane) as f64 * (TAU / planes);
            DVec2::new(azimuth.sin(), azimuth.cos())
        });
        PlaneGroup::new(grid, eye.truncate(), &directions, inverse_diameter)
    }

    /// Azimuth from one plane of a group to the next, radians.
    pub fn plane_angle(&self, index: usize) -> f64 {
        TAU / self.annuli[self.needed[index].annulus].planes() as f64
    }

    /// Inverse depth of a group's rows becomes inverse range, and how it goes on to the next plane and per unit of the tangent becomes how that goes on to the
    /// next plane and to the next row. `tilts` are empty, or as long as `inverse`.
    pub fn to_ranges(&self, index: usize, inverse: &mut [Sixteen], [across, along]: [&mut [Sixteen]; 2]) {
        let step = self.step as f32;
        for (nth, (row, lanes)) in self.rows(index).zip(inverse).enumerate() {
            let (sine, cosine) = self.elevation(row as f64).sin_cos();
            let (sine, cosine) = (sine as f32, cosine as f32);
            if let (Some(across), Some(along)) = (across.get_mut(nth), along.get_mut(nth)) {
                for ((across, along), inverse) in across.0.iter_mut().zip(&mut along.0).zip(&lanes.0) {
                    // Along a plane inverse depth is A + B·tan ε, and inverse range A·cos ε + B·sin ε.
                    let level = inverse - *along * sine / cosine;
                    *along = (*along * cosine - level * sine) * step;
                    *across *= cosine;
                }
            }
            lanes.0.iter_mut().for_each(|lane| *lane *= cosine);
        }
    }

    /// Weights of the row below and of the one above for inverse range at a share of the way between: sin((1 − t)·s) / sin s
    /// and sin(t·s) / sin s.
    #[inline(always)]
    pub fn harmonic<V: Simd>(&self, simd: V, share: V::F) -> [V::F; 2] {
        // sin(t·s) / sin s = t·(1 + s²/6·(1 − t²)) but for terms of s⁴.
        let bend = simd.splat((self.step * self.step / 6.0) as f32);
        let one = simd.splat(1.0);
        let mut weights = [one - share, share];
        for weight in &mut weights {
            *weight = *weight * bend.mul_add(weight.neg_mul_add(*weight, one), one);
        }
        weights
    }

    /// The zenith's row.
    pub fn last_row(&self) -> i32 {
        self.rows as i32 - 1
    }

    /// The annulus in which pixels between `row` and the next look their inverse range up.
    #[inline(always)]
    pub fn annulus(&self, row: i32) -> &Annulus {
        let row = row.clamp(0, self.last_row()) as usize;
        &self.annuli[usize::from(self.by_row[row])]
    }

    /// Sixteen pixels from `column` (a multiple of sixteen) of a `row` on.
    #[inline(always)]
    pub fn gaze<V: Simd>(&self, simd: V, column: usize, row: usize) -> Gaze<V> {
        let [x, y, z] = self.directions.strip(column, row);
        let (x, y, z) = (simd.load(x), simd.load(y), simd.load(z));
        let [right, up, forward] = self.world_from_mapping;
        let mut direction = [x; 3];
        for (axis, turned) in direction.iter_mut().enumerate() {
            let sum = y.mul_add(simd.splat(up[axis]), z * simd.splat(forward[axis]));
            *turned = x.mul_add(simd.splat(right[axis]), sum);
        }

        let [sine, cosine] = self.ahead.each(|it| simd.splat(it));
        let along = direction[0].mul_add(sine, direction[1] * cosine);
        let across = direction[1].neg_mul_add(sine, direction[0] * cosine);
        let square = along.mul_add(along, across * across).max(simd.splat(LEAST_SQUARE));
        let level = square * square.rsqrt();
        let elevation = atan2(simd, direction[2], level);
        let middle = simd.splat(0.5 * (self.rows - 1) as f32);

        Gaze {
            azimuth: atan2(simd, across, along),
            row: elevation.mul_add(simd.splat((1.0 / self.step) as f32), middle),
            lit: !(x.abs() + y.abs() + z.abs()).le(simd.splat(0.0)),
        }
    }
}

/// Angle of a pixel of some part of the screen between its middle and its border, radians.
fn fine_angle(camera: &Camera) -> f64 {
    match camera.screen() {
        // Planar pixels shrink with the square of the cosine, and most are near the border of a wide view.
        Screen::Planar { hfov } | Screen::Lens { hfov, .. } => {
            let angle = camera.pixel_angle() * (0.5 * hfov).to_radians().cos().sqrt();
            if *hfov > WIDE { angle.min(BESIDE_STEP) } else { angle }
        }
        _ => camera.pixel_angle(),
    }
}

/// Marks what the pixels need.
fn mark(annuli: &mut [Annulus], directions: &Directions, turn: &DMat3, [step, rows]: [f64; 2]) {
    for DirectionCell { axis, radius } in directions.cells() {
        let axis = *turn * axis;
        let elevation = axis.z.atan2(axis.truncate().length());
        let middle = 0.5 * (rows - 1.0);
        let row = |elevation: f64| elevation / step + middle;
        let low = (row(elevation - radius) - MARGIN).floor().max(0.0) as usize;
        let high = (row(elevation + radius) + MARGIN).ceil().min(rows - 1.0) as usize;

        // A cone of this radius touches azimuths up to here; all of them, where it holds the pole.
        let polar = FRAC_PI_2 - elevation.abs();
        let spread = if radius < polar { Some((radius.sin() / polar.sin()).min(1.0).asin()) } else { None };
        let azimuth = axis.x.atan2(axis.y);

        for annulus in annuli.iter_mut() {
            let looked_up = annulus.looked_up(rows as usize);
            let rows = low.max(looked_up.start)..(high + 1).min(looked_up.end);
            if rows.start < rows.end {
                annulus.mark(rows, azimuth, spread);
            }
        }
    }
}

/// Gives each marked group its place, annulus by annulus.
fn place(annuli: &mut [Annulus]) -> Vec<Needed> {
    let mut needed = Vec::new();
    let mut next = 0;
    for (index, annulus) in annuli.iter_mut().enumerate() {
        for (group, rows) in annulus.place(&mut next) {
            needed.push(Needed { annulus: index, group, rows });
        }
    }
    needed
}

/// Most words of a plane image, 1 GiB: more, and their indices would be too long for a gather.
pub const MOST_WORDS: usize = 1 << 28;

#[cfg(test)]
mod tests;
