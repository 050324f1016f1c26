//! Ranks of bodies that are as far as each other: a priority, and then a number.
//!
//! Planes that coincide have ranges that differ by rounding. Between bodies of different priority ranges count as equal up to a small part of them,
//! between others they do not. Bodies are asked by rank, the highest first.

use std::cmp::{Ordering, Reverse};

use super::body::PlacedBody;

/// Part of a range within which that of a body of another priority counts as equal: 6 cm at 1 km.
pub(super) const TIE: f64 = 1.0 / 16_384.0;

/// Orders bodies by rank.
pub(super) fn by_rank(one: &PlacedBody, other: &PlacedBody) -> Ordering {
    let rank = |body: &PlacedBody| (Reverse(body.priority), body.id);
    rank(one).cmp(&rank(other))
}

/// Returns the range up to which a body of a priority is seen before one of another, of the same or a higher rank, that is at `range`.
pub(super) fn limit(range: f64, priority: i32, other: i32) -> f64 {
    if priority < other { range * (1.0 - TIE) } else { range }
}

/// Returns the number of bodies, which stand by rank, whose priority is higher than that of the one at `index`.
pub(super) fn higher(bodies: &[&PlacedBody], index: usize) -> usize {
    bodies[..index].partition_point(|body| body.priority > bodies[index].priority)
}
