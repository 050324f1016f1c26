//! Detail that is finer than the posts of elevation.

/// Detail below the posts of elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// Seed that picks one detail among all alike.
    pub seed: u64,
    /// Roughness of the detail.
    pub roughness: Roughness,
    /// Most that it adds or takes away, metres; `None`: a quarter of the distance of posts.
    pub limit_m: Option<f64>,
}

/// Height of waves half as long, as a share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Roughness {
    /// Roughness of elevation at its finest.
    Auto,
    /// 0 < share < 1: 0.5 is smooth, 0.7 rough.
    Given(f64),
}
