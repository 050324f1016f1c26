//! Solids over one voxel, in metres, and their code.

use std::f64::consts::TAU;

use glam::{DVec2, dvec2};

use super::super::kinds::Paint;
use hedgehop::voxel::{Bays, Cut, Facade, HeightCode, Span};

/// A rectangle of voxels: row-major from the south-west, rows northward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Origin of voxels, metres in the database's system: the same for all squares of a database, so that a voxel has one place to the last
    /// bit.
    pub origin: DVec2,
    /// South-west voxel of the square, counted eastward and northward.
    pub first: [i64; 2],
    /// Side of a voxel, metres, > 0.
    pub spacing: f64,
    /// Voxels eastward.
    pub columns: usize,
    /// Voxels northward.
    pub rows: usize,
}

impl Square {
    /// South-west corner, metres in the database's system.
    pub fn corner(&self) -> DVec2 {
        self.origin + dvec2(self.first[0] as f64, self.first[1] as f64) * self.spacing
    }

    /// A place in voxels from the south-west corner.
    pub fn local(&self, place: DVec2) -> DVec2 {
        (place - self.origin) / self.spacing - dvec2(self.first[0] as f64, self.first[1] as f64)
    }

    /// Centre of a voxel, metres.
    pub fn centre(&self, column: usize, row: usize) -> DVec2 {
        let [x, y] =
            [(column, 0), (row, 1)].map(|(index, axis)| (self.first[axis] + index as i64) as f64 + 0.5);
        self.origin + dvec2(x, y) * self.spacing
    }

    /// Row-major index of a voxel.
    pub fn index(&self, column: usize, row: usize) -> usize {
        row * self.columns + column
    }

    /// West, south, east, north, metres.
    pub fn bounds(&self) -> [f64; 4] {
        let near = self.corner();
        let far = near + dvec2(self.columns as f64, self.rows as f64) * self.spacing;
        [near.x, near.y, far.x, far.y]
    }

    /// Columns and rows that touch an area of west, south, east, north.
    pub(super) fn touched(
        &self,
        [west, south, east, north]: [f64; 4],
    ) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let range = |low: f64, high: f64, count: usize| {
            // Casts saturate, and NaN is 0.
            let first = low.floor().max(0.0) as usize;
            let end = high.floor() + 1.0;
            first.min(count)..(end.max(0.0) as usize).min(count).max(first.min(count))
        };
        let (low, high) = (self.local(dvec2(west, south)), self.local(dvec2(east, north)));
        (range(low.x, high.x, self.columns), range(low.y, high.y, self.rows))
    }

    /// All voxels that touch an area.
    pub(super) fn voxels(&self, area: [f64; 4]) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (columns, rows) = self.touched(area);
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }
}

/// Distance by which a plane may be off by rounding, metres.
const BY_ROUNDING: f64 = 1e-9;

/// End of a solid within its voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wall {
    /// Fills the voxel.
    Whole,
    /// A plane; there is nothing beyond it.
    Plane {
        /// Direction of its outside, radians counter-clockwise from east.
        facing: f64,
        /// Distance from the voxel's centre in that direction, metres.
        distance_m: f64,
    },
    /// Ends at two planes; facings and distances as above.
    Corner([(f64, f64); 2]),
    /// Ends at three; beyond the third one the same thing goes on.
    Wedge([(f64, f64); 3]),
    /// Fills the voxel, and its sides look in this direction, radians counter-clockwise from east.
    Round(f64),
}

impl Wall {
    /// A plane whose outside lies in the direction of `normal`.
    pub(super) fn plane(normal: DVec2, distance_m: f64) -> Self {
        Self::Plane { facing: normal.y.atan2(normal.x), distance_m }
    }

    /// Iterates over its planes: facings and distances.
    pub fn planes(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let planes = match *self {
            Self::Plane { facing, distance_m } => [Some((facing, distance_m)), None, None],
            Self::Corner([one, other]) => [Some(one), Some(other), None],
            Self::Wedge(planes) => planes.map(Some),
            Self::Whole | Self::Round(_) => [None; 3],
        };
        planes.into_iter().flatten()
    }

    /// Whether what it bounds holds the voxel's centre. Of two planes of a roof that meet there both do, however either is rounded: pages that share a
    /// voxel must agree.
    pub fn holds_centre(&self) -> bool {
        self.planes().all(|(_, distance_m)| distance_m >= -BY_ROUNDING)
    }
}

/// A solid over one voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// Height of its lower end, metres; `None`: it stands on the ground.
    pub low_m: Option<f64>,
    /// Height of its upper end over the voxel's centre, metres.
    pub high_m: f64,
    /// Slope of the upper end, eastward and northward, rise over run.
    pub slope: [f64; 2],
    /// End within the voxel.
    pub wall: Wall,
    /// Colour of the upper end, sRGB.
    pub top: [u8; 3],
    /// Colour of sides and lower end, sRGB.
    pub side: [u8; 3],
    /// Share of the light that it hides, 0…1.
    pub opacity: f64,
    /// Material class.
    pub material: u8,
    /// The lower end has the slope of the upper one.
    pub parallel: bool,
    /// A strip along the wall's line, as wide as the solid is high.
    pub strip: bool,
    /// Whether the same thing goes on beyond the first planes of its wall, another plane of its roof.
    pub joined: [bool; 2],
    /// Façade of its sides; `None`: they are plain.
    pub facade: Option<SolidFacade>,
}

/// Façade of a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidFacade {
    /// Heights of the lowest floor and of the uppermost ceiling, metres.
    pub floor_m: f64,
    pub eaves_m: f64,
    /// Number of storeys, at least 1; look and bays as [`Facade`] has them.
    pub storeys: u8,
    pub look: u8,
    pub bays: [Bays; 2],
}

/// A solid over a voxel of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedSolid {
    /// Row-major index of the voxel in the block.
    pub voxel: usize,
    /// The solid.
    pub solid: Solid,
}

impl Solid {
    /// Places it over a voxel of a block.
    pub fn over(self, voxel: usize) -> PlacedSolid {
        PlacedSolid { voxel, solid: self }
    }

    /// One that is level, dense, and fills its voxel.
    pub(super) fn level(low_m: Option<f64>, high_m: f64, paint: Paint) -> Self {
        Self {
            low_m,
            high_m,
            slope: [0.0; 2],
            wall: Wall::Whole,
            top: paint.colour,
            side: paint.colour,
            opacity: 1.0,
            material: paint.material.code(),
            parallel: false,
            strip: false,
            joined: [false; 2],
            facade: None,
        }
    }

    /// Encodes it for voxels of this side (metres); `None` if nothing of it is left.
    pub fn encode(&self, heights: &HeightCode, spacing: f64) -> Option<Span> {
        let (mut low, mut high) =
            (self.low_m.map_or(Span::GROUND, |low| heights.encode(low)), heights.encode(self.high_m));
        let mut opacity = self.opacity;
        if let (true, Some(low_m)) = (self.strip, self.low_m) {
            // A wire is as many steps thick as fits best, and dense: a ray loses next to nothing on so short a way through what is not. Of
            // less than half a step there is one, which hides less.
            let thickness = (self.high_m - low_m) / heights.scale;
            let steps = thickness.round().max(1.0);
            high = heights.encode(0.5 * (self.high_m + low_m) + 0.5 * steps * heights.scale);
            // Casts saturate.
            low = high.saturating_sub(steps as u16).max(1);
            opacity *= if thickness < 0.5 { thickness } else { 1.0 };
        }

        let opacity = (opacity * f64::from(Span::OPAQUE)).round().clamp(0.0, f64::from(Span::OPAQUE)) as u8;
        if self.high_m.is_nan() || low >= high || opacity == 0 {
            return None;
        }

        let (cuts, joined) = self.cuts(spacing)?;
        let bit = |is: bool, bit: u8| if is { bit } else { 0 };
        Some(Span {
            low,
            high,
            slope: self.slope.map(slope_steps),
            cuts,
            top: self.top,
            state: opacity | bit(self.parallel, Span::PARALLEL) | bit(self.strip, Span::STRIP) | joined,
            side: self.side,
            material: self.material,
            facade: self.facade.map_or(Facade::NONE, |facade| facade.encode(heights)),
        })
    }

    /// Cuts, and the bits of those beyond which the same goes on; `None` if they leave nothing.
    fn cuts(&self, spacing: f64) -> Option<([Cut; 3], u8)> {
        if let Wall::Round(facing) = self.wall {
            return Some(([Cut::round(turn(facing)), Cut::NONE, Cut::NONE], 0));
        }

        let (mut cuts, mut count) = ([(false, Cut::NONE); 3], 0);
        // Planes of a roof that meet in a point are stored in steps, and no longer do: they overlap by as much, or there would be a hole.
        let lap = if self.joined == [true; 2] { LAP } else { 0.0 };
        let joined = self.joined.into_iter().chain([true]);

        for ((facing, distance_m), is_joined) in self.wall.planes().zip(joined) {
            let (normal, distance) = (DVec2::from_angle(facing).abs(), distance_m / spacing);
            let reach = 0.5 * (normal.x + normal.y);

            // One beside the voxel leaves all of it, and says how its corner is lit.
            if !self.strip && distance >= reach + if is_joined { 0.0 } else { Cut::BESIDE } {
                continue;
            }
            if !self.strip && distance <= -reach {
                return None;
            }

            // Casts saturate.
            let steps = (distance * f64::from(Cut::STEPS) + lap).round() as i32;
            cuts[count] = (is_joined, Cut::wall(turn(facing), steps));
            count += 1;
        }

        // The order in which they were found says nothing, but that a third one is a joint.
        if !self.strip {
            cuts[..count].sort_unstable();
        }
        let bits = [0, 1].map(|index| if cuts[index].0 { Span::JOINED[index] } else { 0 });

        Some((cuts.map(|(_, cut)| cut), bits[0] | bits[1]))
    }
}

impl SolidFacade {
    fn encode(&self, heights: &HeightCode) -> Facade {
        let Self { storeys, look, bays, .. } = *self;
        let [floor, eaves] = [self.floor_m, self.eaves_m].map(|height| heights.encode(height));
        Facade { floor, eaves, storeys, look, bays }
    }
}

/// Steps of a cut by which parts of a roof lap over each other where more than two meet.
const LAP: f64 = 1.0;

/// A slope in [`Span::SLOPE_STEPS`].
fn slope_steps(slope: f64) -> i8 {
    (slope * f64::from(Span::SLOPE_STEPS)).round().clamp(-127.0, 127.0) as i8
}

/// A direction (radians counter-clockwise from east) in 256ths of a turn.
pub(super) fn turn(angle: f64) -> u8 {
    // Casts wrap: a whole turn is none.
    (angle / TAU * 256.0).round().rem_euclid(256.0) as u8
}

/// The slope that is stored for one.
pub(super) fn stored_slope(slope: f64) -> f64 {
    f64::from(slope_steps(slope)) / f64::from(Span::SLOPE_STEPS)
}

/// The direction that is stored for one, radians counter-clockwise from east.
pub(super) fn stored_facing(angle: f64) -> f64 {
    f64::from(turn(angle)) * (TAU / 256.0)
}

/// Heights of the bare ground.
pub trait Ground {
    /// Metres above the database's datum; `None` where there is none. Always the same for a place, whoever asks and when.
    fn height_at(&self, place: DVec2) -> Option<f64>;
}

impl<F: Fn(DVec2) -> Option<f64>> Ground for F {
    fn height_at(&self, place: DVec2) -> Option<f64> {
        self(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::voxel::Material;

    const HEIGHTS: HeightCode = HeightCode { scale: 0.05, offset: 99.95 };

    fn block() -> Solid {
        Solid::level(None, 112.0, Paint { colour: [1, 2, 3], material: Material::Brick })
    }

    #[test]
    fn solids_are_encoded_to_the_nearest_step() {
        let solid = Solid {
            slope: [0.5, -9.0],
            wall: Wall::plane(dvec2(0.0, -1.0), 0.25),
            low_m: Some(104.02),
            opacity: 0.5,
            parallel: true,
            ..block()
        };
        let span = solid.encode(&HEIGHTS, 2.0).unwrap();
        assert_eq!((HEIGHTS.decode(span.low), HEIGHTS.decode(span.high)), (Some(104.0), HEIGHTS.decode(241)));
        assert_eq!((span.slope, span.cuts), ([16, -127], [Cut::wall(192, 16), Cut::NONE, Cut::NONE]));
        assert_eq!((span.state, span.material), (8 | Span::PARALLEL, Material::Brick.code()));
        assert_eq!(block().encode(&HEIGHTS, 2.0).unwrap().low, Span::GROUND);
    }

    #[test]
    fn walls_beyond_the_voxel_are_none() {
        let with = |distance_m: f64| Solid { wall: Wall::plane(dvec2(1.0, 1.0), distance_m), ..block() };
        assert_eq!(with(1.5).encode(&HEIGHTS, 2.0).unwrap().cuts, [Cut::NONE; 3]);
        assert_eq!(with(-1.5).encode(&HEIGHTS, 2.0), None);
        assert_eq!(with(0.0).encode(&HEIGHTS, 2.0).unwrap().cuts[0], Cut::wall(32, 0));
        assert_eq!(Solid { low_m: Some(112.0), ..block() }.encode(&HEIGHTS, 2.0), None);
        assert_eq!(Solid { opacity: 0.01, ..block() }.encode(&HEIGHTS, 2.0), None);
        assert_eq!(Solid { high_m: f64::NAN, ..block() }.encode(&HEIGHTS, 2.0), None);
    }

    #[test]
    fn thin_wires_hide_less_where_a_step_is_thicker() {
        let wire =
            Solid { low_m: Some(111.98), strip: true, wall: Wall::plane(dvec2(1.0, 0.0), 0.1), ..block() };
        let span = wire.encode(&HEIGHTS, 1.0).unwrap();
        assert_eq!(span.high - span.low, 1);
        assert_eq!(span.state & Span::OPACITY, 6);
        assert!(span.is(Span::STRIP));
    }

    #[test]
    fn wires_are_dense_wherever_they_hang_between_steps() {
        // 0.04 m are 4.3 steps or 0.7 of one, and hide all wherever they end between two steps.
        let cases = [(0.0093, 4), (0.06, 1)].map(|case| (0..120).map(move |part| (case, part)));
        for ((scale, steps), part) in cases.into_iter().flatten() {
            let heights = HeightCode { scale, offset: 99.95 };
            let middle = 112.0 + 0.001 * f64::from(part);
            let wire = Solid {
                low_m: Some(middle - 0.02),
                high_m: middle + 0.02,
                strip: true,
                wall: Wall::plane(dvec2(1.0, 0.0), 0.1),
                ..block()
            };

            let span = wire.encode(&heights, 1.25).unwrap();
            assert_eq!(
                (span.high - span.low, span.state & Span::OPACITY),
                (steps, Span::OPAQUE),
                "at {middle} m"
            );
            let [low, high] = [span.low, span.high].map(|code| heights.decode(code).unwrap());
            let off = (0.5 * (low + high) - middle).abs();
            assert!(off <= 0.5 * heights.scale + 1e-9, "off by {off} m at {middle} m");
        }
    }
}
