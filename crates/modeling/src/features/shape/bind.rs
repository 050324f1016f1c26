//! Features on their ground: once for each, before pages are made. What comes after depends on them and on a voxel's place alone.

use glam::DVec2;

use super::super::kinds::{Meaning, Paint, Tree, Upright, Way, WayKind};
use super::super::layer::{Area, Geometry, bounds};
use super::super::meaning::{WATER, mix};
use super::building::BoundBuilding;
use super::cover::{BoundBarrier, BoundCover, BoundWood, Course};
use super::footprint::Footprint;
use super::frame::{Frame, hull};
use super::ribbon::Line;
use super::round::{BoundTree, BoundUpright, chance};
use super::solid::{Ground, PlacedSolid, Solid, Square};
use super::way::{BoundBridge, BoundWay, Graded};
use super::wire::{self, BoundWire};

/// A part of a feature where it stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Bound {
    /// A building.
    Building(Box<BoundBuilding>),
    /// A way in the ground.
    Way(Box<BoundWay>),
    /// A way over a bridge, or the deck of one.
    Bridge(Box<BoundBridge>),
    /// Water or pavement.
    Cover(Box<BoundCover>),
    /// A wall, fence or hedge.
    Barrier(Box<BoundBarrier>),
    /// Something round.
    Upright(BoundUpright),
    /// One span of one wire.
    Wire(BoundWire),
    /// A tree.
    Tree(BoundTree),
    /// A wood.
    Wood(BoundWood),
}

/// Most trees of one row of a file.
const MOST_TREES: usize = 200_000;

/// Binds a row's meaning and form (in the database's system, metres) to its ground; `hash` tells it from other rows. Parts that have no
/// ground, or a form that does not go with the meaning, are left out.
pub fn bind(meaning: &Meaning, geometry: &Geometry, hash: u64, ground: &dyn Ground) -> Vec<Bound> {
    let areas = || geometry.areas.iter();
    let footprints = || areas().filter_map(Footprint::of);
    let lines = || geometry.lines.iter().filter_map(|line| Line::of(&line.places));
    match meaning {
        Meaning::Building(building) => areas()
            .filter_map(|area| BoundBuilding::bind(building, area, ground))
            .map(|building| Bound::Building(Box::new(building)))
            .collect(),

        Meaning::Way(way) if way.is_bridge => lines()
            .filter_map(|line| BoundBridge::bind(way, line, ground))
            .map(|bridge| Bound::Bridge(Box::new(bridge)))
            .collect(),
        Meaning::Way(way) => lines()
            .filter_map(|line| BoundWay::bind(way, geometry, line, ground))
            .map(|way| Bound::Way(Box::new(way)))
            .collect(),
        Meaning::River(width) => {
            let covers = footprints().map(|footprint| covering(footprint, WATER, false));
            let covers = covers.map(|cover| Bound::Cover(Box::new(cover)));
            let ways =
                lines().filter(|_| *width > 0.0).filter_map(|line| BoundWay::river(*width, line, ground));
            covers.chain(ways.map(|way| Bound::Way(Box::new(way)))).collect()
        }

        // Covers of the ground.
        Meaning::Lake => footprints()
            .filter_map(|footprint| BoundCover::lake(footprint, ground))
            .map(|lake| Bound::Cover(Box::new(lake)))
            .collect(),
        Meaning::Pavement(paint) => {
            footprints().map(|footprint| Bound::Cover(Box::new(covering(footprint, *paint, false)))).collect()
        }
        Meaning::Ground(paint) => {
            footprints().map(|footprint| Bound::Cover(Box::new(covering(footprint, *paint, true)))).collect()
        }
        Meaning::Field(paint, rows) => footprints()
            .map(|footprint| Bound::Cover(Box::new(BoundCover::field(footprint, *paint, *rows, hash))))
            .collect(),

        // What stands on it.
        Meaning::Barrier(barrier) => {
            let rings = areas().flat_map(|area| std::iter::once(&area.outer).chain(&area.holes));
            let closed = rings.filter_map(|ring| {
                let places: Vec<_> = ring.places.iter().chain(ring.places.first()).copied().collect();
                Line::of(&places)
            });
            let courses: Vec<Course> = match barrier.is_filled {
                true => lines().map(Course::Line).chain(footprints().map(Course::Area)).collect(),
                false => lines().chain(closed).map(Course::Line).collect(),
            };
            let bound = |course| Bound::Barrier(Box::new(BoundBarrier { course, barrier: *barrier }));
            courses.into_iter().map(bound).collect()
        }
        Meaning::Upright(upright) | Meaning::Pylon(upright, _) => uprights(upright, geometry, ground),
        Meaning::Structure(structure) => uprights(&structure.round, geometry, ground),
        Meaning::PowerLine(power) => {
            let parts = lines().map(|line| wire::bind(power, &line, ground));
            parts
                .flat_map(|(wires, pylons)| {
                    wires.into_iter().map(Bound::Wire).chain(pylons.into_iter().map(Bound::Upright))
                })
                .collect()
        }
        Meaning::Trees(tree, step) => trees(tree, *step, geometry, hash, ground),
        Meaning::Wood(wood) => {
            footprints().map(|footprint| Bound::Wood(BoundWood::of(footprint, *wood, hash))).collect()
        }
        Meaning::Bridge(paint) => areas().filter_map(|area| deck(area, *paint, ground)).collect(),
        Meaning::Unknown | Meaning::Hidden(_) => Vec::new(),
    }
}

/// A cover of an area that leaves its heights.
fn covering(footprint: Footprint, paint: Paint, is_ground: bool) -> BoundCover {
    BoundCover { footprint, level_m: None, paint, rows: None, is_ground }
}

fn uprights(upright: &Upright, geometry: &Geometry, ground: &dyn Ground) -> Vec<Bound> {
    let points = geometry.points.places.iter().map(|place| (*place, None));
    // As large as its area, in the middle of it.
    let areas = geometry.areas.iter().filter_map(|area| {
        let footprint = Footprint::of(area)?;
        let frame = Frame::around(&hull(&footprint.rings[0]))?;
        Some((frame.middle, Some((footprint.area().abs() / std::f64::consts::PI).sqrt())))
    });
    points
        .chain(areas)
        .filter_map(|(middle, radius)| {
            let said = upright.diameter_m.map(|diameter| 0.5 * diameter);
            // A point says nothing of its size.
            let radius = said.or(radius).unwrap_or(0.15 * upright.height_m);
            let base_m = ground.height_at(middle)?;
            Some(Bound::Upright(BoundUpright { middle, radius, base_m, upright: *upright }))
        })
        .collect()
}

fn trees(tree: &Tree, step: f64, geometry: &Geometry, hash: u64, ground: &dyn Ground) -> Vec<Bound> {
    let rows = geometry.lines.iter().filter_map(|line| Line::of(&line.places));
    let along = rows.flat_map(|line| {
        let count = (line.length() / step).clamp(1.0, MOST_TREES as f64) as usize;
        (0..=count)
            .map(move |index| line.at(line.length() * index as f64 / count as f64).0)
            .collect::<Vec<_>>()
    });
    let places = geometry.points.places.iter().copied().chain(along).take(MOST_TREES);
    places
        .enumerate()
        .filter_map(|(index, place)| {
            let hash = mix(hash.wrapping_add(index as u64));
            // Those of a row are not all alike.
            let scale = if index == 0 { 1.0 } else { 0.8 + 0.4 * chance(hash, 0) };
            let tree = Tree { height_m: tree.height_m * scale, crown_m: tree.crown_m * scale, ..*tree };
            ground.height_at(place).map(|base_m| Bound::Tree(BoundTree { place, base_m, tree, hash }))
        })
        .collect()
}

/// The deck of a bridge from its area: along its longer side, as wide as its shorter one.
fn deck(area: &Area, paint: Paint, ground: &dyn Ground) -> Option<Bound> {
    let footprint = Footprint::of(area)?;
    let frame = Frame::around(&hull(&footprint.rings[0]))?;
    let end = frame.along * frame.half.x;
    let line = Line::of(&[frame.middle - end, frame.middle + end])?;
    let way = Way {
        kind: WayKind::Road,
        width_m: footprint.area() / (2.0 * frame.half.x),
        paint,
        most_grade: 0.08,
        is_bridge: true,
        layer: 1,
        lines: None,
    };
    BoundBridge::bind(&way, line, ground).map(|bridge| Bound::Bridge(Box::new(bridge)))
}

fn grown([west, south, east, north]: [f64; 4], reach: f64) -> [f64; 4] {
    [west - reach, south - reach, east + reach, north + reach]
}

impl Bound {
    /// West, south, east, north of what it may change of voxels of this side, metres.
    pub fn reach(&self, spacing: f64) -> [f64; 4] {
        // A mitre reaches half as far again; what is thin takes a voxel.
        const MITRE: f64 = 1.5;

        let around = |places: &[DVec2], reach: f64| {
            grown(bounds(places.iter().copied()).unwrap_or([0.0; 4]), MITRE * (reach + spacing))
        };
        match self {
            Self::Building(building) => building.footprint.bounds,
            Self::Way(way) => around(way.line.places(), way.reach),
            Self::Bridge(bridge) => around(bridge.line.places(), bridge.half),
            Self::Cover(cover) => cover.footprint.bounds,
            Self::Barrier(barrier) => match &barrier.course {
                Course::Line(line) => around(line.places(), barrier.barrier.thickness_m),
                Course::Area(footprint) => footprint.bounds,
            },
            Self::Upright(upright) => around(&[upright.middle], upright.radius),
            Self::Wire(wire) => around(&wire.ends, 0.0),
            Self::Tree(tree) => around(&[tree.place], 0.5 * tree.tree.crown_m),
            Self::Wood(wood) => grown(wood.footprint.bounds, wood.reach() + spacing),
        }
    }

    /// Returns how far beside a voxel it may ask for the ground to know what stands on it, metres.
    pub fn margin(&self) -> f64 {
        match self {
            Self::Wood(wood) => wood.reach(),
            _ => 0.0,
        }
    }

    /// Height that nothing of it rises above on ground up to `ground` metres high, over voxels of this side, metres.
    pub fn highest(&self, ground: f64, spacing: f64) -> f64 {
        match self {
            Self::Way(_) | Self::Cover(_) => ground,
            Self::Barrier(barrier) => ground + barrier.barrier.height_m,
            Self::Wood(wood) => ground + wood.highest(),
            Self::Tree(tree) => tree.base_m + tree.tree.height_m,
            Self::Building(building) => building.highest(spacing).max(ground),
            Self::Bridge(_) | Self::Upright(_) | Self::Wire(_) => {
                let [west, south, east, north] = self.reach(spacing);
                let [low, high] =
                    [DVec2::new(west, south), DVec2::new(east, north)].map(|at| (at / spacing).floor());
                let size = high - low + 1.0;
                let first = [low.x as i64, low.y as i64];
                let (origin, columns, rows) = (DVec2::ZERO, size.x as usize, size.y as usize);
                let square = Square { origin, first, spacing, columns, rows };
                let mut solids = Vec::new();
                self.raise(&square, &|_: DVec2| None, &mut solids);

                // Slopes rise from the voxel's centre to its corners.
                let top = |solid: &Solid| {
                    solid.high_m + 0.5 * spacing * (solid.slope[0].abs() + solid.slope[1].abs())
                };

                solids.iter().map(|placed| top(&placed.solid)).fold(ground, f64::max)
            }
        }
    }

    /// Raises its solids over the voxels of a square, with their row-major index.
    pub fn raise(&self, square: &Square, ground: &dyn Ground, out: &mut Vec<PlacedSolid>) {
        match self {
            Self::Building(building) => building.raise(square, out),
            Self::Bridge(bridge) => bridge.raise(square, out),
            Self::Barrier(barrier) => barrier.raise(square, ground, out),
            Self::Upright(upright) => upright.raise(square, out),
            Self::Wire(wire) => wire.raise(square, out),
            Self::Tree(tree) => tree.raise(square, out),
            Self::Wood(wood) => wood.trees(square, ground).iter().for_each(|tree| tree.raise(square, out)),
            Self::Way(_) | Self::Cover(_) => {}
        }
    }

    /// Grades the ground of a square: `natural` are the heights of its voxels, row-major, metres, NaN where there is none.
    pub fn grade(&self, square: &Square, natural: &[f64]) -> Vec<Graded> {
        match self {
            Self::Way(way) => way.grade(square, natural),
            Self::Cover(cover) => cover.grade(square),
            Self::Bridge(bridge) => bridge.grade(square),
            Self::Wood(wood) => wood.grade(square),
            _ => Vec::new(),
        }
    }
}
