//! Rectangles of places.

use glam::DVec2;

/// Rectangle of places along the axes of their system, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaceBounds {
    /// Least of both coordinates.
    pub low: DVec2,
    /// Greatest of both coordinates.
    pub high: DVec2,
}

impl PlaceBounds {
    /// Returns the least rectangle around places.
    pub fn around(places: impl IntoIterator<Item = DVec2>) -> Self {
        let nothing = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };
        places
            .into_iter()
            .fold(nothing, |Self { low, high }, place| Self { low: low.min(place), high: high.max(place) })
    }
}
