//! Walls that a roof rises from: of any place within a footprint the nearest ones, in a time that does not grow with their number.
//!
//! A lattice of cells knows which edges pass through it. Cells are searched from the place outward, until none farther away can hold a
//! wall that is nearer: along an edge that is the distance from it, and at a corner that points inward a share of it, by at most
//! 120° half at the least. Sharper corners are few, and always looked at.

use glam::DVec2;

use super::footprint::Footprint;

/// The line of a wall that a roof rises from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Eaves {
    /// A place on it.
    pub at: DVec2,
    /// Unit vector to the inside.
    pub inward: DVec2,
}

/// A wall, and how the one after it goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RoofWall {
    from: DVec2,
    to: DVec2,
    length: f64,
    /// Unit vectors along this one and along the next.
    along: DVec2,
    next: DVec2,
}

impl RoofWall {
    fn of([from, to, end]: [DVec2; 3]) -> Self {
        let [along, next] = [to - from, end - to].map(DVec2::normalize_or_zero);
        Self { from, to, length: from.distance(to), along, next }
    }

    /// Whether the corner at its end points inward.
    fn ends_inward(&self) -> bool {
        self.along.perp_dot(self.next) < 0.0
    }

    /// The least share of the distance from the corner at its end that a place has from the farther of the two walls, where it is nearest to that
    /// corner: on the bisector, the cosine of half the turn.
    fn share(&self) -> f64 {
        if self.ends_inward() { (0.5 + 0.5 * self.along.dot(self.next)).max(0.0).sqrt() } else { 1.0 }
    }
}

/// The walls of a footprint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Walls {
    walls: Vec<RoofWall>,
    /// Lattice that finds walls, if there are many.
    cells: Option<Cells>,
}

/// Walls from which on there is a lattice of cells.
const MANY: usize = 64;

/// Walls that are nearest so far.
struct Nearest {
    distance: f64,
    /// Place in the order of all, which decides between walls that are as near.
    order: usize,
    eaves: Vec<Eaves>,
}

impl Walls {
    pub fn of(footprint: &Footprint) -> Self {
        let of_ring = |ring: &Vec<DVec2>| {
            let at = |index: usize| ring[index % ring.len()];
            (0..ring.len())
                .map(|index| RoofWall::of([0, 1, 2].map(|next| at(index + next))))
                .collect::<Vec<_>>()
        };
        let walls: Vec<RoofWall> = footprint.rings.iter().flat_map(of_ring).collect();
        let cells = (walls.len() >= MANY).then(|| Cells::of(&walls, footprint.bounds));
        Self { walls, cells }
    }

    /// Returns how far a place within lies from the walls that the water of a roof over it runs to, metres, if the roof rises from all of them alike, and these: one, or
    /// the two of a corner that points inward. There they are valleys, and the farther one counts.
    pub fn eaves(&self, place: DVec2) -> Option<(f64, Vec<Eaves>)> {
        let mut nearest = None;
        match &self.cells {
            Some(cells) => cells.search(place, |corner| {
                self.consider(corner, place, &mut nearest);
                nearest.as_ref().map_or(f64::INFINITY, |nearest: &Nearest| nearest.distance)
            }),
            None => (0..self.walls.len()).for_each(|corner| self.consider(corner, place, &mut nearest)),
        }
        nearest.map(|nearest| (nearest.distance, nearest.eaves))
    }

    fn consider(&self, number: usize, place: DVec2, nearest: &mut Option<Nearest>) {
        let wall = &self.walls[number];
        let mut add = |distance: f64, order: usize, eaves: &[Eaves]| {
            let is_nearer = |known: &Nearest| (distance, order) < (known.distance, known.order);
            if distance >= 0.0 && nearest.as_ref().is_none_or(is_nearer) {
                *nearest = Some(Nearest { distance, order, eaves: eaves.to_vec() });
            }
        };

        let before = wall.along.dot(place - wall.from);
        let inward = wall.along.perp();
        if (0.0..=wall.length).contains(&before) {
            let distance = inward.dot(place - wall.from);
            add(distance, 2 * number, &[Eaves { at: wall.from, inward }]);
        }

        let past = place - wall.to;
        if before > wall.length && wall.next.dot(past) < 0.0 && wall.ends_inward() {
            let other = wall.next.perp();
            let distance = inward.dot(past).max(other.dot(past));
            add(
                distance,
                2 * number + 1,
                &[Eaves { at: wall.from, inward }, Eaves { at: wall.to, inward: other }],
            );
        }
    }
}

/// A lattice of cells over a footprint.
#[derive(Debug, Clone, PartialEq)]
struct Cells {
    corner: DVec2,
    /// Side of a cell, metres.
    side: f64,
    columns: usize,
    rows: usize,
    /// Numbers of the edges that pass through each cell, row by row.
    edges: Vec<Vec<u32>>,
    /// Corners that point inward by more than 120°.
    sharp: Vec<u32>,
    /// Share that all others leave of the distance from them.
    share: f64,
}

/// Cells along the longer side, at most.
const MOST_CELLS: f64 = 512.0;

/// Share of its distance that a corner that points inward leaves at the least: half of it at 120°.
const LEAST_SHARE: f64 = 0.5;

impl Cells {
    fn of(walls: &[RoofWall], [west, south, east, north]: [f64; 4]) -> Self {
        let size = DVec2::new(east - west, north - south);
        let side = size.max_element() / (walls.len() as f64).sqrt().min(MOST_CELLS);
        let [columns, rows] = [size.x, size.y].map(|size| (size / side).floor() as usize + 1);
        let is_sharp = |wall: &RoofWall| wall.share() < LEAST_SHARE;
        let shares = walls.iter().filter(|wall| !is_sharp(wall)).map(RoofWall::share);

        let mut cells = Self {
            corner: DVec2::new(west, south),
            side,
            columns,
            rows,
            edges: vec![Vec::new(); columns * rows],
            sharp: (0..).zip(walls).filter(|(_, wall)| is_sharp(wall)).map(|(number, _)| number).collect(),
            // A little less, for rounding.
            share: shares.fold(1.0, f64::min) - 1e-6,
        };

        for (number, wall) in (0..).zip(walls) {
            cells.enter(number, wall.from, wall.to);
        }

        cells
    }

    /// Notes an edge in all cells that it passes.
    fn enter(&mut self, number: u32, from: DVec2, to: DVec2) {
        let [from, to] = [from, to].map(|place| (place - self.corner) / self.side);
        let (low, high) = if from.y <= to.y { (from, to) } else { (to, from) };
        // Casts saturate.
        let within = |at: f64, count: usize| (at.floor().max(0.0) as usize).min(count - 1);
        for row in within(low.y, self.rows)..=within(high.y, self.rows) {
            let at = |y: f64| {
                let share = if high.y > low.y { (y - low.y) / (high.y - low.y) } else { 0.0 };
                low.x + share.clamp(0.0, 1.0) * (high.x - low.x)
            };
            let ends = if low.y == high.y { [low.x, high.x] } else { [at(row as f64), at(row as f64 + 1.0)] };
            let [first, last] = [ends[0].min(ends[1]), ends[0].max(ends[1])].map(|x| within(x, self.columns));
            for column in first..=last {
                self.edges[row * self.columns + column].push(number);
            }
        }
    }

    /// Hands over edges from a place outward. `look` returns the least distance so far, metres; the search ends when no other can be less.
    fn search(&self, place: DVec2, mut look: impl FnMut(usize) -> f64) {
        let mut least = f64::INFINITY;
        for corner in &self.sharp {
            least = look(*corner as usize);
        }

        let local = (place - self.corner) / self.side;
        let [x, y] = [(local.x, self.columns), (local.y, self.rows)]
            .map(|(at, count)| at.floor().clamp(0.0, count as f64 - 1.0) as i64);
        let (columns, rows) = (self.columns as i64, self.rows as i64);

        for ring in 0..columns.max(rows) {
            // All that is left lies beyond the rings that are done.
            if least < self.share * (ring - 1) as f64 * self.side {
                return;
            }

            for row in (y - ring).max(0)..=(y + ring).min(rows - 1) {
                let is_end = (row - y).abs() == ring;
                let step = if is_end || ring == 0 { 1 } else { 2 * ring };
                for column in (x - ring..=x + ring).step_by(step as usize) {
                    if (0..columns).contains(&column) {
                        for edge in &self.edges[(row * columns + column) as usize] {
                            least = look(*edge as usize);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::dvec2;
    use proptest::prelude::*;

    use super::super::super::layer::{Area, Path};
    use super::*;

    fn footprint(places: Vec<DVec2>) -> Footprint {
        Footprint::of(&Area { outer: Path::flat(places), holes: vec![] }).expect("it encloses something")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        /// The lattice finds what a search through all walls finds, of stars, combs and wobbly circles.
        #[test]
        fn the_nearest_walls_are_those_of_all(
            radii in prop::collection::vec(5.0..60.0_f64, MANY..400), is_smooth: bool, x in -60.0..60.0_f64, y in -60.0..60.0_f64,
        ) {
            let turn = |index: usize| TAU * index as f64 / radii.len() as f64;
            let radius = |radius: f64| if is_smooth { 50.0 + 0.1 * radius } else { radius };
            let places = radii.iter().enumerate().map(|(index, r)| DVec2::from_angle(turn(index)) * radius(*r));
            let footprint = footprint(places.collect());
            let walls = Walls::of(&footprint);
            let plain = Walls { cells: None, ..walls.clone() };
            prop_assert!(walls.cells.is_some());
            for place in [dvec2(x, y), 0.3 * dvec2(x, y), dvec2(-y, 0.5 * x)] {
                prop_assert_eq!(walls.eaves(place), plain.eaves(place));
            }
        }
    }
}
