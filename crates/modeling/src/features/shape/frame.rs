//! Hulls and rectangles around outlines.

use glam::{DVec2, Vec2Swizzles};

/// A rectangle of any direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub middle: DVec2,
    /// Direction of the longer side.
    pub along: DVec2,
    /// Half of the sides, the longer one first.
    pub half: DVec2,
}

impl Frame {
    /// The rectangle of least area around a convex hull.
    pub fn around(hull: &[DVec2]) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        let mut calipers = (hull.len() > MANY).then(Calipers::default);
        for (index, (a, b)) in hull.iter().zip(hull.iter().cycle().skip(1)).enumerate() {
            let Some(along) = (*b - *a).try_normalize() else { continue };
            let across = along.perp();
            let ((west, east), (south, north)) = match &mut calipers {
                Some(calipers) => calipers.turn(hull, index, along),
                None => (extent(hull, along, *a), extent(hull, across, *a)),
            };
            let half = 0.5 * DVec2::new(east - west, north - south);
            let middle = *a + along * west.midpoint(east) + across * south.midpoint(north);
            let frame = match half.x >= half.y {
                true => Self { middle, along, half },
                false => Self { middle, along: across, half: half.yx() },
            };
            let area = half.x * half.y;
            if best.as_ref().is_none_or(|(least, _)| area < *least) {
                best = Some((area, frame));
            }
        }

        best.filter(|(area, _)| *area > 0.0).map(|(_, frame)| frame)
    }
}

/// Least and greatest distance of places in a direction from a place.
pub(super) fn extent(places: &[DVec2], direction: DVec2, from: DVec2) -> (f64, f64) {
    let distances = places.iter().map(|place| direction.dot(*place - from));
    distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
}

/// Corners of a hull from which on calipers turn around it: the rectangles of all edges take a time that grows with its square.
const MANY: usize = 64;

/// Farthest corners in the directions of an edge, which turn around a convex hull as the edge does (Toussaint 1983).
#[derive(Default)]
struct Calipers {
    /// Ahead, to the left, behind; `None` before the first edge.
    corners: Option<[usize; 3]>,
}

impl Calipers {
    /// Least and greatest distances from the start of an edge along it, and to its left.
    fn turn(&mut self, hull: &[DVec2], edge: usize, along: DVec2) -> ((f64, f64), (f64, f64)) {
        let at = |index: usize| hull[index % hull.len()];
        let left = along.perp();
        let farthest = |from: usize, direction: DVec2| {
            let last = from + hull.len();
            (from..last).find(|index| direction.dot(at(index + 1) - at(*index)) <= 0.0).unwrap_or(last)
        };
        let known = self.corners.unwrap_or([edge + 1; 3]);
        let ahead = farthest(known[0].max(edge + 1), along);
        let beside = farthest(known[1].max(ahead), left);
        let behind = farthest(known[2].max(beside), -along);
        self.corners = Some([ahead, beside, behind]);

        let from = at(edge);
        let far = |index: usize, direction: DVec2| direction.dot(at(index) - from);
        ((far(behind, along).min(0.0), far(ahead, along)), (0.0, far(beside, left)))
    }
}

/// The convex hull, counter-clockwise (Andrew 1979).
pub(super) fn hull(places: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = places.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();

    let half = |places: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for place in places {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(place - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(place);
        }
        chain.pop();
        chain
    };

    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Calipers find the rectangle that all corners have.
    #[test]
    fn rectangles_of_large_hulls_are_those_of_all_corners() {
        for (count, [east, north]) in [(150, [40.0, 10.0]), (300, [7.0, 7.0]), (1000, [1.0, 90.0])] {
            let turn = DVec2::from_angle(0.4);
            let corner = |index: usize| {
                let place =
                    DVec2::from_angle(TAU * index as f64 / count as f64 + 0.01) * DVec2::new(east, north);
                // A rectangle with round corners.
                turn.rotate(place.clamp(-0.95 * DVec2::new(east, north), 0.95 * DVec2::new(east, north)))
            };
            let hull = hull(&(0..count).map(corner).collect::<Vec<_>>());
            assert!(hull.len() > MANY, "{}", hull.len());
            let area = |frame: &Frame| frame.half.x * frame.half.y;
            let every = hull.iter().zip(hull.iter().cycle().skip(1)).map(|(a, b)| {
                let along = (*b - *a).normalize();
                let ((w, e), (s, n)) = (extent(&hull, along, *a), extent(&hull, along.perp(), *a));
                0.25 * (e - w) * (n - s)
            });
            let least = every.fold(f64::INFINITY, f64::min);
            let found = Frame::around(&hull).expect("a rectangle");
            assert!((area(&found) / least - 1.0).abs() < 1e-9, "{count}: {} of {least}", area(&found));
        }
    }
}
