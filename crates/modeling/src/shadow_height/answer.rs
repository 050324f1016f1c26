//! Answers for the rows in the end.

/// Origin of a height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Length or tip that the row states.
    Stated,
    /// Shadow in the photograph.
    Photograph,
}

/// A height from a shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowHeight {
    /// Height of the roof above the lowest ground along the outline, metres, > 0.
    pub height_m: f64,
    /// Standard deviation, metres, ≥ 0.
    pub error_m: f64,
    /// Length of the shadow along the ground from the corner that lies farthest from the sun, metres, seen from above.
    pub length_m: f64,
    /// Origin of the height.
    pub origin: Origin,
}

/// Answer for a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Height of the row.
    Height(ShadowHeight),
    /// Row that states a height, and stays as it was.
    Kept,
    /// Row without a height, and why: what follows "it is left without a height:".
    Nothing(String),
}
