//! Nodes that ways share.

use glam::DVec2;

/// Place that ends of ways meet in, centimetres: transforms may move it by rounding.
pub(super) type Node = (i64, i64);

/// Finds the node of a place, metres.
pub(super) fn node(place: DVec2) -> Node {
    // Casts saturate.
    ((place.x * 100.0).round() as i64, (place.y * 100.0).round() as i64)
}
