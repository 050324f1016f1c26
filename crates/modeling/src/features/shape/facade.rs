//! Façades of buildings: storeys that fit their walls, and bays that fit each wall.
//!
//! ```text
//! storeys = as many as are stated, or as make them nearly as high as is usual; together as high as the walls
//! bays    = as many to a wall as make them nearly as wide as is usual; together in its middle
//! a voxel has those of the nearest wall, and of the nearest that runs another way
//! ```

use glam::DVec2;

use super::super::kinds::FacadeKind;
use super::super::meaning::mix;
use super::footprint::Footprint;
use super::solid::{SolidFacade, stored_facing, turn};
use hedgehop::voxel::{Bays, Facade, FacadeStyle};

/// Walls that are lower than this have no façade, metres.
const LOWEST: f64 = 1.8;
/// Storeys that are stated are believed if they are this high, metres.
const BELIEVED: std::ops::RangeInclusive<f64> = 2.0..=7.0;
/// Widest bay, metres: more is not stored.
const WIDEST: f64 = 7.9;
/// Least width of a wall with one bay, as a share of what is usual.
const LEAST_WALL: f64 = 0.7;
/// Edges that turn by less than this are one wall, cosine.
const STRAIGHT: f64 = 0.998;
/// Most edges of an outline with a façade: each voxel looks at all of them.
const MOST_EDGES: usize = 512;
/// Least turn between the two walls of a voxel, 256ths.
const LEAST_TURN: u8 = 16;

/// A straight wall and its bays.
#[derive(Debug, Clone, PartialEq)]
struct BayWall {
    from: DVec2,
    to: DVec2,
    bays: Bays,
}

/// Façade of a building.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BoundFacade {
    walls: Vec<BayWall>,
    floor_m: f64,
    eaves_m: f64,
    storeys: u8,
    look: u8,
}

/// Usual height of storeys and width of bays, metres, and whether the levels that are stated are such storeys.
fn usual(style: FacadeStyle) -> (f64, f64, bool) {
    match style {
        FacadeStyle::House => (2.8, 2.9, true),
        FacadeStyle::Apartments => (2.9, 3.0, true),
        FacadeStyle::Office => (3.4, 3.2, true),
        FacadeStyle::Shop => (3.6, 4.0, true),
        FacadeStyle::Hall => (8.0, 6.0, false),
        FacadeStyle::Barn => (6.0, 4.6, false),
        FacadeStyle::Church => (9.0, 4.4, false),
        FacadeStyle::Garage => (3.2, 3.0, false),
    }
}

impl BoundFacade {
    /// The façade of walls between two heights, metres; `None`: they are plain.
    pub fn of(kind: FacadeKind, footprint: &Footprint, [floor_m, eaves_m]: [f64; 2]) -> Option<Self> {
        let height = eaves_m - floor_m;
        let edges: usize = footprint.rings.iter().map(Vec::len).sum();
        // A height that is not a number has no façade.
        if height.is_nan() || height < LOWEST || edges > MOST_EDGES {
            return None;
        }

        let (storey, width, counts) = usual(kind.style);
        let stated = kind
            .levels
            .filter(|levels| counts && *levels >= 1.0 && BELIEVED.contains(&(height / levels.round())));
        let storeys = stated.unwrap_or(height / storey).round().clamp(1.0, f64::from(u8::MAX)) as u8;
        let [west, south, ..] = footprint.bounds;
        let seed = mix(west.to_bits() ^ mix(south.to_bits()));

        let mut sides: Vec<(DVec2, DVec2)> = footprint.rings.iter().flat_map(|ring| straight(ring)).collect();
        sides.retain(|(from, to)| from.distance(*to) > 0.0);
        let count = |(from, to): &(DVec2, DVec2)| bays_along(from.distance(*to), width);
        let with_room: Vec<usize> = (0..sides.len()).filter(|side| count(&sides[*side]) >= 2.0).collect();
        let entrance = with_room.get((seed >> 8) as usize % with_room.len().max(1)).copied();
        let wall = |(index, side): (usize, &(DVec2, DVec2))| BayWall {
            from: side.0,
            to: side.1,
            bays: bays(*side, count(side), (entrance == Some(index)).then_some(seed >> 16)),
        };

        let walls = sides.iter().enumerate().map(wall).collect();
        Some(Self { walls, floor_m, eaves_m, storeys, look: Facade::look(kind.style, seed) })
    }

    /// Façade of a voxel by its centre.
    pub fn at(&self, centre: DVec2) -> SolidFacade {
        let distance = |wall: &&BayWall| {
            let way = wall.to - wall.from;
            let share = ((centre - wall.from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            centre.distance_squared(wall.from + way * share)
        };
        let nearest = |a: &&BayWall, b: &&BayWall| distance(a).total_cmp(&distance(b));
        let one = self.walls.iter().min_by(nearest).map(|wall| wall.bays).unwrap_or_default();
        let others = self.walls.iter().filter(|wall| wall.bays.turn_to(one.facing) >= LEAST_TURN);
        let other = others.min_by(nearest).map(|wall| wall.bays).unwrap_or_default();

        let Self { floor_m, eaves_m, storeys, look, .. } = *self;
        SolidFacade { floor_m, eaves_m, storeys, look, bays: [one, other] }
    }
}

/// Counts the bays of a wall.
fn bays_along(length: f64, usual: f64) -> f64 {
    if length < LEAST_WALL * usual {
        0.0
    } else {
        (length / usual).round().max(1.0).max((length / WIDEST).ceil())
    }
}

/// Divides a wall in `count` bays, with a door in the one that `entrance` chooses, or in none if there are not too many.
fn bays((from, to): (DVec2, DVec2), count: f64, entrance: Option<u64>) -> Bays {
    let along = to - from;
    let angle = (-along.perp()).to_angle();
    let facing = turn(angle);
    if count == 0.0 {
        return Bays::new(facing, 0.0, 0.0);
    }

    // The direction is stored in steps, and so is the width.
    let along = DVec2::from_angle(stored_facing(angle)).perp();
    let ends = [from, to].map(|end| along.dot(end));
    let width = ((ends[1] - ends[0]) / count * Bays::STEPS).floor() / Bays::STEPS;
    let start = 0.5 * (ends[0] + ends[1] - count * width);
    let door = match entrance {
        Some(entrance) => (entrance % count as u64) as f64,
        None if count < Bays::PERIOD => -1.0,
        None => (0.5 * count).floor(),
    };
    Bays::new(facing, width, start + door * width)
}

/// Straight sides of a ring, with the inside to their left.
fn straight(ring: &[DVec2]) -> Vec<(DVec2, DVec2)> {
    let at = |index: usize| ring[index % ring.len()];
    let way = |index: usize| (at(index + 1) - at(index)).normalize_or_zero();
    let is_corner = |index: usize| way(index + ring.len() - 1).dot(way(index)) < STRAIGHT;
    let Some(first) = (0..ring.len()).find(|index| is_corner(*index)) else { return Vec::new() };

    let mut sides = Vec::new();
    let mut from = first;
    for index in first + 1..=first + ring.len() {
        // A curve of small turns is many walls.
        if is_corner(index) || way(index).dot(way(from)) < STRAIGHT {
            sides.push((at(from), at(index)));
            from = index;
        }
    }
    if from < first + ring.len() {
        sides.push((at(from), at(first)));
    }
    sides
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::super::super::layer::{Area, Path};
    use super::*;

    fn footprint(places: &[[f64; 2]]) -> Footprint {
        let places = places.iter().map(|place| DVec2::from(*place)).collect();
        Footprint::of(&Area { outer: Path::flat(places), holes: vec![] }).expect("it encloses something")
    }

    fn facade(style: FacadeStyle, levels: Option<f64>, height: f64) -> Option<BoundFacade> {
        let house =
            footprint(&[[100.0, 200.0], [112.0, 200.0], [112.0, 204.0], [112.0, 208.0], [100.0, 208.0]]);
        BoundFacade::of(FacadeKind { style, levels }, &house, [50.0, 50.0 + height])
    }

    #[test]
    fn storeys_fill_the_walls() {
        for (style, levels, height, storeys) in [
            (FacadeStyle::House, None, 5.6, 2),
            (FacadeStyle::House, None, 2.2, 1),
            (FacadeStyle::House, Some(3.0), 8.0, 3),
            (FacadeStyle::House, Some(9.0), 6.0, 2),
            (FacadeStyle::Apartments, Some(12.0), 36.0, 12),
            (FacadeStyle::Hall, Some(3.0), 9.0, 1),
        ] {
            assert_eq!(
                facade(style, levels, height).unwrap().storeys,
                storeys,
                "{style:?} {levels:?} {height}"
            );
        }
        assert_eq!(facade(FacadeStyle::House, None, 1.5), None);
    }

    #[test]
    fn bays_lie_in_the_middle_of_straight_walls() {
        let facade = facade(FacadeStyle::House, None, 5.6).unwrap();
        assert_eq!(facade.walls.len(), 4, "two edges are one wall: {:?}", facade.walls);
        for wall in &facade.walls {
            let (length, width) = (wall.from.distance(wall.to), wall.bays.width_m());
            let count = (length / width).floor();
            assert!((2.3..3.5).contains(&width), "{width}");
            // From the wall's start to that of its first bay.
            let along =
                DVec2::from_angle(stored_facing(f64::from(wall.bays.facing) * std::f64::consts::TAU / 256.0))
                    .perp();
            let before = wall.bays.within(along.dot(wall.from)) / width;
            let rest = (before.ceil() - before) * width;
            let margin = 0.5 * (length - count * width);
            let off = (rest - margin).abs();
            assert!(off.min(width - off) < 0.06, "{off} m of {margin} m");
        }
    }

    #[test]
    fn one_wall_has_the_entrance() {
        let facade = facade(FacadeStyle::House, None, 5.6).unwrap();
        let has_door = |wall: &&BayWall| {
            let along = DVec2::from_angle(f64::from(wall.bays.facing) * std::f64::consts::TAU / 256.0).perp();
            let count = (wall.from.distance(wall.to) / wall.bays.width_m()).floor() as u32;
            let middle = 0.5 * (along.dot(wall.from) + along.dot(wall.to));
            (0..count).any(|bay| {
                let at = middle + (f64::from(bay) + 0.5 - 0.5 * f64::from(count)) * wall.bays.width_m();
                wall.bays.within(at) < wall.bays.width_m()
            })
        };
        assert_eq!(facade.walls.iter().filter(has_door).count(), 1);
    }

    #[test]
    fn voxels_have_the_walls_that_they_lie_at() {
        let facade = facade(FacadeStyle::House, None, 5.6).unwrap();
        let facings = |centre: DVec2| facade.at(centre).bays.map(|bays| bays.facing);
        assert_eq!(facings(dvec2(106.0, 200.2))[0], 192);
        assert_eq!(facings(dvec2(111.9, 204.0))[0], 0);
        let mut corner = facings(dvec2(111.9, 207.9));
        corner.sort_unstable();
        assert_eq!(corner, [0, 64]);
    }
}
