//! Roads, railways, runways and rivers: ribbons that are built into the ground, or over it.
//!
//! ```text
//! ground within the ribbon    = profile, a little lower to the sides (cross-slope)
//! beside it, d beyond its edge: ground, but no lower than the edge − d/1.5 and no higher than the edge + d/1.5
//! bridge                      = deck between the heights of its ends, raised between them where there is too little room below;
//!                               parapets at its edges, piers below; the ground stays, but where it would rise through the deck
//! ```

use super::super::kinds::{Paint, Way, WayKind};
use super::super::layer::Geometry;
use super::super::meaning::WATER;
use super::lane_lines::lane_lines;
use super::profile::{FixedPlace, Profile};
use super::ribbon::{Cross, Ends, Line};
use super::solid::{Ground, PlacedSolid, Solid, Square, Wall};
use super::strips::Strips;
use hedgehop::voxel::Material;

/// Rise over run of embankments and cuttings.
const SHOULDER: f64 = 1.0 / 1.5;
/// Farthest that they reach from a ribbon's edge, metres.
const MOST_REACH: f64 = 40.0;
/// Fall of a road's surface from its middle to its sides.
const CROSS_SLOPE: f64 = 0.02;
/// Metres to either side over which profiles are smoothed.
const SMOOTH: f64 = 24.0;

/// Ground of a voxel as a feature makes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Graded {
    /// Row-major index of the voxel in its square.
    pub index: usize,
    /// Height of the ground, metres; `None`: as it was.
    pub height_m: Option<f64>,
    /// Surface, and the share of the voxel that it covers, above 0…1; `None`: as it was.
    pub paint: Option<(Paint, f64)>,
    /// Rank of the feature; of several, the greatest is seen.
    pub rank: Rank,
    /// Height that the ground must rise above for all of this, metres.
    pub above_m: f64,
}

impl Graded {
    /// Begins a voxel of this index whatever its height; nothing is changed yet.
    pub fn any(index: usize, rank: Rank) -> Self {
        Self { index, height_m: None, paint: None, rank, above_m: f64::NEG_INFINITY }
    }
}

/// Order in which features lie over each other, lowest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// The ground itself, as maps show what grows or lies there.
    Ground,
    /// Embankments and cuttings beside ways.
    Shoulder,
    /// Areas with a surface of their own.
    Cover,
    /// Flowing water.
    River,
    /// Standing water.
    Lake,
    /// Ways, by their layer, then by their width, centimetres: side roads end below the edge of what they meet.
    Way(i32, u32),
}

/// Puts what features make of a square's ground into `heights` (row-major, metres), lowest rank first and else in the order that is given, and
/// hands over each surface with its voxel, share and rank in that order.
pub fn settle(mut graded: Vec<Graded>, heights: &mut [f64], mut paint: impl FnMut(usize, Paint, f64, Rank)) {
    graded.sort_by_key(|graded| graded.rank);
    for Graded { index, height_m, paint: surface, rank, above_m } in graded {
        let Some(slot) = heights.get_mut(index) else { continue };
        // Where there is no ground it rises above nothing.
        let rises = above_m == f64::NEG_INFINITY || *slot > above_m;
        if !rises {
            continue;
        }
        if let Some(height) = height_m {
            *slot = height;
        }
        if let Some((surface, share)) = surface {
            paint(index, surface, share, rank);
        }
    }
}

/// A way in the ground, where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundWay {
    pub(super) line: Line,
    pub(super) half: f64,
    profile: Profile,
    /// Distance from the line within which the ground may change, metres.
    pub(super) reach: f64,
    cross_slope: f64,
    ends: Ends,
    paint: Paint,
    /// Lines painted on it.
    lines: Strips,
    rank: Rank,
}

/// Paint of lines on roads of a surface, somewhat worn.
fn line_paint(surface: Paint) -> Paint {
    Paint { colour: [222, 222, 216], ..surface }
}

impl BoundWay {
    /// A way, and where its geometry says that it meets others; `None` where there is no ground.
    pub(super) fn bind(way: &Way, geometry: &Geometry, line: Line, ground: &dyn Ground) -> Option<Self> {
        let natural = Profile::of_ground(&line, ground)?;
        let window = if way.kind == WayKind::Road { SMOOTH } else { 3.0 * SMOOTH };
        let fixed: Vec<_> = geometry
            .joints
            .iter()
            .filter_map(|joint| Some(FixedPlace { along: line.along_of(joint.place)?, level: joint.half_m }))
            .collect();
        let profile = natural.clone().graded(window, way.most_grade, &fixed);
        let half = 0.5 * way.width_m;

        // A slope across the way has higher and lower ground at its sides.
        let deep = profile.difference(&natural) + 0.5 * half + 1.0;
        let reach = half + (deep / SHOULDER).min(MOST_REACH);
        let cross_slope = if way.kind == WayKind::Road { CROSS_SLOPE } else { 0.0 };
        let ends = if way.kind == WayKind::Runway { Ends::Butt } else { Ends::Round };

        let lines = way.lines.as_ref();
        let lines =
            lines.map(|lines| lane_lines(lines, half, &line, &geometry.junctions)).unwrap_or_default();

        Some(Self {
            line,
            half,
            profile,
            reach,
            cross_slope,
            ends,
            paint: way.paint,
            lines,
            rank: Rank::Way(way.layer, (100.0 * way.width_m) as u32),
        })
    }

    /// Flowing water of a width, metres.
    pub(super) fn river(width_m: f64, line: Line, ground: &dyn Ground) -> Option<Self> {
        let natural = Profile::of_ground(&line, ground)?;
        let profile = natural.clone().falling();
        let half = 0.5 * width_m;
        let reach = half + ((profile.difference(&natural) + 0.5) / SHOULDER).min(MOST_REACH);
        Some(Self {
            line,
            half,
            profile,
            reach,
            cross_slope: 0.0,
            ends: Ends::Round,
            paint: WATER,
            lines: Strips::default(),
            rank: Rank::River,
        })
    }

    /// Height of the ground of a voxel that has this height by itself; `None` where it stays.
    fn height(&self, cross: &Cross, natural: f64) -> Option<f64> {
        let (middle, _) = self.profile.at(cross.along);
        if cross.off <= self.half {
            return Some(middle - self.cross_slope * cross.off);
        }
        let edge = middle - self.cross_slope * self.half;
        let beyond = (cross.off - self.half) * SHOULDER;
        let graded = natural.clamp(edge - beyond, edge + beyond);
        (graded != natural).then_some(graded)
    }

    /// Grades the ground: `natural` are the heights of the square's voxels, NaN where there is none.
    pub fn grade(&self, square: &Square, natural: &[f64]) -> Vec<Graded> {
        let grade = |cross: Cross| {
            let index = square.index(cross.column, cross.row);
            let ground = natural.get(index).copied().filter(|height| height.is_finite())?;
            let share = cross.share(self.half, square.spacing);
            let paint = (share > 0.0).then_some((self.paint, share));
            let height_m = self.height(&cross, ground);
            let rank = if cross.off <= self.half { self.rank } else { Rank::Shoulder };
            (paint.is_some() || height_m.is_some()).then_some(Graded {
                height_m,
                paint,
                ..Graded::any(index, rank)
            })
        };
        let reach = self.reach.max(self.half + square.spacing);
        let mut graded: Vec<Graded> =
            self.line.crosses(square, reach, self.ends).into_iter().filter_map(grade).collect();
        if !self.lines.is_empty() {
            let has_ground =
                |(index, _): &(usize, f64)| natural.get(*index).is_some_and(|height| height.is_finite());
            let lines = self.lines.shares(square).into_iter().filter(has_ground);
            graded.extend(lines.map(|(index, share)| Graded {
                paint: Some((line_paint(self.paint), share)),
                ..Graded::any(index, self.rank)
            }));
        }
        graded
    }
}

/// A bridge where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundBridge {
    pub(super) line: Line,
    pub(super) half: f64,
    /// Heights of the deck's upper side at its ends, metres.
    ends_m: [f64; 2],
    /// Height of its middle above a line between its ends, metres.
    arch_m: f64,
    /// Thickness of the deck, metres.
    thickness_m: f64,
    /// Distances of the piers along the bridge, metres.
    piers: Vec<f64>,
    paint: Paint,
}

/// Room under a bridge that it should have, metres.
const CLEARANCE: f64 = 4.5;
/// Depth of the ground below the upper side of a deck where it would rise through that, metres.
const BEDDED: f64 = 0.1;
/// Parapets: height and thickness, metres.
const PARAPET: f64 = 1.0;
const PARAPET_THICKNESS: f64 = 0.4;
/// Largest voxels that have any: in others they would be as wide as lanes.
const PARAPET_COARSEST: f64 = 1.5;
/// Piers: farthest apart, half length along the bridge, share of its width; metres below the deck from which on there are any.
const PIER_STEP: f64 = 32.0;
const PIER_HALF: f64 = 0.9;
const PIER_WIDTH: f64 = 0.6;
const PIER_LEAST: f64 = 3.0;
const CONCRETE: Paint = Paint { colour: [158, 156, 150], material: Material::Concrete };

impl BoundBridge {
    /// A way over a bridge; `None` where there is no ground at its ends.
    pub(super) fn bind(way: &Way, line: Line, ground: &dyn Ground) -> Option<Self> {
        let length = line.length();
        let ends_m = [ground.height_at(line.at(0.0).0)?, ground.height_at(line.at(length).0)?];
        let thickness_m = (length / 25.0).clamp(0.5, 1.8);
        let straight = |along: f64| ends_m[0] + (ends_m[1] - ends_m[0]) * along / length;
        let below = |along: f64| ground.height_at(line.at(along).0).map(|height| straight(along) - height);
        let room = (1..8).filter_map(|part| below(length * f64::from(part) / 8.0)).fold(0.0, f64::max);

        // No steeper at its ends than a way may be.
        let arch_m = (CLEARANCE + thickness_m - room).clamp(0.0, 0.25 * way.most_grade * length);
        let spans = (length / PIER_STEP).ceil().clamp(1.0, 1000.0);

        let mut bridge = Self {
            line,
            half: 0.5 * way.width_m,
            ends_m,
            arch_m,
            thickness_m,
            piers: Vec::new(),
            paint: way.paint,
        };

        let pier = |index: usize| length * index as f64 / spans;
        let stands = |along: &f64| {
            let ground = ground.height_at(bridge.line.at(*along).0);
            ground.is_some_and(|ground| bridge.deck(*along).0 - ground > PIER_LEAST)
        };
        bridge.piers = (1..spans as usize).map(pier).filter(stands).collect();

        Some(bridge)
    }

    /// Height of the deck's upper side at a distance along the bridge, metres, and its grade.
    fn deck(&self, along: f64) -> (f64, f64) {
        let (length, [first, last]) = (self.line.length(), self.ends_m);
        let share = (along / length).clamp(0.0, 1.0);
        let height = first + (last - first) * share + 4.0 * self.arch_m * share * (1.0 - share);
        (height, (last - first + 4.0 * self.arch_m * (1.0 - 2.0 * share)) / length)
    }

    /// Height of its highest point, parapets included, metres.
    pub fn top_m(&self) -> f64 {
        self.ends_m[0].max(self.ends_m[1]) + self.arch_m + PARAPET
    }

    /// Grades the ground, after all ways: where that would reach the deck's upper side, it lies right below and looks like it. Else both would be seen in
    /// turns.
    pub fn grade(&self, square: &Square) -> Vec<Graded> {
        let grade = |cross: Cross| {
            let (high, _) = self.deck(cross.along);
            let share = cross.share(self.half, square.spacing);
            Graded {
                height_m: Some(high - BEDDED),
                paint: Some((self.paint, share)),
                above_m: high - BEDDED,
                ..Graded::any(square.index(cross.column, cross.row), Rank::Way(i32::MAX, 0))
            }
        };
        self.line.crosses(square, self.half, Ends::Butt).into_iter().map(grade).collect()
    }

    /// Whether a voxel of this side (metres) carries parapet: as thin as voxels allow, but without gaps. So all do that reach the outermost
    /// eighth of a voxel of the deck, however the bridge lies to the grid; in the middle of the narrowest there is room to walk.
    fn has_parapet(&self, cross: &Cross, spacing: f64) -> bool {
        let corner = 0.5 * spacing * (cross.outward.x.abs() + cross.outward.y.abs());
        let is_edge = self.half - cross.off < PARAPET_THICKNESS.max(corner + 0.125 * spacing);
        is_edge && cross.off >= 0.75 * spacing && spacing <= PARAPET_COARSEST
    }

    /// Raises its solids, with the index of their voxel.
    pub fn raise(&self, square: &Square, out: &mut Vec<PlacedSolid>) {
        // A corner of a voxel may be covered whose centre is not.
        let reach = self.half + 0.7072 * square.spacing;
        for cross in self.line.crosses(square, reach, Ends::Butt) {
            let index = square.index(cross.column, cross.row);
            let (high, grade) = self.deck(cross.along);
            let slope = (cross.tangent * grade).into();
            let wall = Wall::plane(cross.outward, self.half - cross.off);
            let low = high - self.thickness_m;

            // Below a parapet no road is seen; as wide as a wall is thick it would be, at the face.
            let has_parapet = self.has_parapet(&cross, square.spacing);
            let paint = if has_parapet { CONCRETE } else { self.paint };

            let deck = Solid {
                slope,
                wall,
                side: CONCRETE.colour,
                parallel: true,
                ..Solid::level(Some(low), high, paint)
            };

            out.push(deck.over(index));
            if has_parapet {
                let parapet = Solid::level(Some(high), high + PARAPET, CONCRETE);
                out.push(Solid { slope, wall, parallel: true, ..parapet }.over(index));
            }

            let half_pier = PIER_HALF.max(0.5 * square.spacing);
            let near = |pier: &&f64| (cross.along - **pier).abs() <= half_pier;
            if cross.off <= PIER_WIDTH * self.half && self.piers.iter().any(|pier| near(&pier)) {
                out.push(Solid { slope, ..Solid::level(None, low, CONCRETE) }.over(index));
            }
        }
    }
}
