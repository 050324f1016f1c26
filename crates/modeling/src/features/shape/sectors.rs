//! Edges of a hull that are seen from its middle in the directions of a place: of many planes around a roof's top only those over
//! them can be the lowest there.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// Directions of a hull's corners from its middle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sectors {
    middle: DVec2,
    /// Direction of the first corner, radians.
    first: f64,
    /// Turn from there to the start of each edge, radians, rising.
    starts: Vec<f64>,
}

/// Edges from which on looking at all of them takes long.
const MANY: usize = 64;

impl Sectors {
    /// Divides a counter-clockwise hull; `None` where it has few edges, or the middle does not lie within all of them.
    pub fn of(hull: &[DVec2], middle: DVec2) -> Option<Self> {
        let edges = || hull.iter().zip(hull.iter().cycle().skip(1));
        if hull.len() < MANY || !edges().all(|(a, b)| (*b - *a).perp_dot(middle - *a) > 0.0) {
            return None;
        }
        let first = (hull[0] - middle).to_angle();
        let starts: Vec<f64> =
            hull.iter().map(|corner| ((*corner - middle).to_angle() - first).rem_euclid(TAU)).collect();
        starts.is_sorted().then_some(Self { middle, first, starts })
    }

    /// Number of edges.
    pub fn count(&self) -> usize {
        self.starts.len()
    }

    /// Numbers of the edges between the directions of a convex patch's corners, and of one more on either side.
    pub fn over(&self, corners: &[DVec2]) -> impl Iterator<Item = usize> + use<> {
        let count = self.starts.len();
        let mut turns: Vec<f64> = corners
            .iter()
            .map(|corner| ((*corner - self.middle).to_angle() - self.first).rem_euclid(TAU))
            .collect();
        turns.sort_by(f64::total_cmp);

        // The widest gap between directions lies on the other side; a patch around the middle leaves none of half a turn.
        let next = |index: usize| match turns.get(index + 1) {
            Some(next) => *next,
            None => turns[0] + TAU,
        };
        let gap = (0..turns.len()).max_by(|a, b| (next(*a) - turns[*a]).total_cmp(&(next(*b) - turns[*b])));
        let range = gap.filter(|gap| next(*gap) - turns[*gap] > PI).map(|gap| (next(gap), turns[gap]));

        let (start, length) = match range {
            Some((from, to)) => {
                let edge = |turn: f64| {
                    self.starts.partition_point(|start| *start <= turn.rem_euclid(TAU)).max(1) - 1
                };
                let (from, to) = (edge(from), edge(to));
                let length = (to + count - from) % count + 3;
                ((from + count - 1) % count, length.min(count))
            }
            None => (0, count),
        };

        (start..start + length).map(move |edge| edge % count)
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;

    #[test]
    fn edges_in_a_direction_are_found() {
        let corner =
            |index: usize| dvec2(3.0, 4.0) + 10.0 * DVec2::from_angle(TAU * index as f64 / 360.0 - 2.0);
        let hull: Vec<DVec2> = (0..360).map(corner).collect();
        let sectors = Sectors::of(&hull, dvec2(3.0, 4.0)).expect("many edges");
        let patch = |middle: DVec2| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| middle + dvec2(x, y) * 0.1)
        };

        for turn in 0..360 {
            let place = dvec2(3.0, 4.0) + 5.0 * DVec2::from_angle(f64::from(turn).to_radians());
            let found: Vec<usize> = sectors.over(&patch(place)).collect();

            // All edges whose planes are the least at a corner of the patch.
            for corner in patch(place) {
                let outward = |edge: usize| {
                    let along = hull[(edge + 1) % 360] - hull[edge];
                    let normal = dvec2(along.y, -along.x).normalize();
                    normal.dot(corner - dvec2(3.0, 4.0)) / normal.dot(hull[edge] - dvec2(3.0, 4.0))
                };
                let least = (0..360).max_by(|a, b| outward(*a).total_cmp(&outward(*b)));
                assert!(least.is_some_and(|least| found.contains(&least)), "{turn}");
            }

            assert!(found.len() < 10, "{turn}: {found:?}");
        }

        assert_eq!(sectors.over(&patch(dvec2(3.0, 4.0))).count(), 360);
        assert!(
            Sectors::of(&hull, dvec2(30.0, 4.0)).is_none()
                && Sectors::of(&hull[..9], dvec2(3.0, 4.0)).is_none()
        );
    }
}
