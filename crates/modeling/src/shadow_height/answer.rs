//! What is known of a row in the end.

/// Where a height comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// From a length or a tip that the row states.
    Stated,
    /// From the photograph.
    Photograph,
}

/// A height from a shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowHeight {
    /// Height of the roof above the lowest ground along the outline, metres, > 0.
    pub height_m: f64,
    /// Its standard deviation, metres, ≥ 0.
    pub error_m: f64,
    /// Length of the shadow along the ground from the corner that lies farthest from the sun, metres, seen from above.
    pub length_m: f64,
    /// Where it comes from.
    pub origin: Origin,
}

/// What became of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// It has a height.
    Height(ShadowHeight),
    /// It states a height, and is as it was.
    Kept,
    /// It has none, and why: what follows "it is left without a height:".
    Nothing(String),
}
