//! Convex parts of a voxel, and the half-planes that bound them.

use glam::{DVec2, dvec2};

/// Half-plane within a line: `normal · place ≤ distance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    /// Unit vector to the outside.
    pub normal: DVec2,
    /// Distance of the line from the origin in that direction.
    pub distance: f64,
}

impl HalfPlane {
    /// Builds the half-plane whose outside lies towards `facing`, radians counter-clockwise from east.
    pub fn towards(facing: f64, distance: f64) -> Self {
        Self { normal: DVec2::from_angle(facing), distance }
    }

    /// Direction of its outside, radians counter-clockwise from east.
    pub fn facing(&self) -> f64 {
        self.normal.to_angle()
    }

    /// Finds where its line crosses that of another one; `None` if they are parallel.
    pub fn crossing(&self, other: &Self) -> Option<DVec2> {
        let turn = self.normal.perp_dot(other.normal);
        let at = (other.normal.perp() * self.distance - self.normal.perp() * other.distance) / -turn;
        at.is_finite().then_some(at)
    }

    /// Returns how far a place lies beyond it.
    pub fn beyond(&self, place: DVec2) -> f64 {
        self.normal.dot(place) - self.distance
    }
}

/// A convex part of a voxel: corners counter-clockwise, each with the number of the half-plane that bounds what is between it and the next
/// one, if that is not the voxel's own side. Places count from the voxel's centre.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ConvexPatch {
    corners: Vec<(DVec2, Option<usize>)>,
}

impl ConvexPatch {
    /// All of a voxel of this side.
    pub fn voxel(side: f64) -> Self {
        let corners = [dvec2(-0.5, -0.5), dvec2(0.5, -0.5), dvec2(0.5, 0.5), dvec2(-0.5, 0.5)];
        Self { corners: corners.map(|corner| (corner * side, None)).into() }
    }

    pub fn corners(&self) -> impl Iterator<Item = DVec2> + Clone + '_ {
        self.corners.iter().map(|(corner, _)| *corner)
    }

    /// Clips it to a half-plane of that number (Sutherland and Hodgman 1974).
    #[must_use]
    pub fn within(&self, half: &HalfPlane, number: usize) -> Self {
        let mut kept = Vec::with_capacity(self.corners.len() + 1);
        for (index, &(here, side)) in self.corners.iter().enumerate() {
            let (next, _) = self.corners[(index + 1) % self.corners.len()];
            let (is, will) = (half.beyond(here), half.beyond(next));
            let crossing = || here.lerp(next, is / (is - will));
            match (is <= 0.0, will <= 0.0) {
                (true, true) => kept.push((here, side)),
                (true, false) => kept.extend([(here, side), (crossing(), Some(number))]),
                (false, true) => kept.push((crossing(), side)),
                (false, false) => {}
            }
        }
        Self { corners: kept }
    }

    /// Clips it to all of some half-planes, by their index.
    #[must_use]
    pub fn within_all<'h>(self, halves: impl IntoIterator<Item = (usize, &'h HalfPlane)>) -> Self {
        halves.into_iter().fold(self, |patch, (number, half)| patch.within(half, number))
    }

    pub fn area(&self) -> f64 {
        let next = self.corners().cycle().skip(1);
        0.5 * self.corners().zip(next).map(|(a, b)| a.perp_dot(b)).sum::<f64>()
    }

    /// Returns the centroid: a place within, wherever rounding leaves two corners for one.
    pub fn middle(&self) -> DVec2 {
        let mean = self.corners().sum::<DVec2>() / self.corners.len().max(1) as f64;
        let pairs = self.corners().zip(self.corners().cycle().skip(1));
        let (area, sum) = pairs.fold((0.0, DVec2::ZERO), |(area, sum), (a, b)| {
            let (a, b) = (a - mean, b - mean);
            let doubled = a.perp_dot(b);
            (area + doubled, sum + (a + b) * doubled)
        });
        let off = sum / (3.0 * area);
        if off.is_finite() { mean + off } else { mean }
    }

    /// Numbers of the half-planes that bound it along more than a length, in rising order.
    pub fn bounded_by(&self, length: f64) -> Vec<usize> {
        let next = self.corners().cycle().skip(1);
        let sides = self.corners.iter().zip(next);
        let mut numbers: Vec<usize> =
            sides.filter(|((a, _), b)| a.distance(*b) > length).filter_map(|((_, side), _)| *side).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_voxel_know_what_bounds_them() {
        let half = |x: f64, y: f64, distance: f64| HalfPlane { normal: dvec2(x, y), distance };
        let halves = [half(1.0, 0.0, 0.5), half(0.0, 1.0, 0.0), half(0.6, 0.8, 3.0)];
        let patch = ConvexPatch::voxel(2.0).within_all(halves.iter().enumerate());
        assert_eq!((patch.area(), patch.bounded_by(0.0)), (1.5, vec![0, 1]));
        assert_eq!(patch.middle(), dvec2(-0.25, -0.5));
        let nothing = patch.within(&half(1.0, 0.0, -1.5), 3);
        assert_eq!((nothing.area(), nothing.corners().count()), (0.0, 0));
        // 0.6 x + 0.8 y = 3 and x = 0.5.
        let crossing = halves[0].crossing(&halves[2]).unwrap();
        assert!(crossing.distance(dvec2(0.5, 3.375)) < 1e-12, "{crossing}");
        assert_eq!(halves[0].crossing(&half(-1.0, 0.0, 2.0)), None);
        // What only touches a corner bounds nothing.
        let corner = HalfPlane { normal: DVec2::ONE.normalize(), distance: std::f64::consts::SQRT_2 };
        assert!(ConvexPatch::voxel(2.0).within(&corner, 0).bounded_by(1e-9).is_empty());
    }
}
