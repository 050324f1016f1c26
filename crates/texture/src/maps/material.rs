//! Strengths and levels of ground maps by material.

/// Strengths and levels of ground maps on a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapMaterial {
    /// Whether no map shows, as on a river.
    pub is_inhibited: bool,
    /// Strength of each of six maps, 1 as it is; a ploughed field has one of 1 and one of ¼.
    pub strengths: [f64; 6],
    /// Strength in each primary, 1 as it is.
    pub primaries: [f64; 3],
    /// Levels by which maps are coarser than the view asks for; below zero, finer.
    pub level_bias: i32,
}

impl MapMaterial {
    /// All maps in all primaries, as they are.
    pub const PLAIN: Self =
        Self { is_inhibited: false, strengths: [1.0; 6], primaries: [1.0; 3], level_bias: 0 };

    /// A ploughed field: furrows across the first map's axis, a little of the fourth, square to it.
    pub const PLOUGHED: Self = Self { strengths: [1.0, 0.0, 0.0, 0.25, 0.0, 0.0], ..Self::PLAIN };

    /// Water on which nothing shows.
    pub const RIVER: Self = Self { is_inhibited: true, ..Self::PLAIN };

    /// Level of maps, at least 1, where a view asks for another.
    pub fn level(&self, of_view: u32) -> u32 {
        of_view.saturating_add_signed(self.level_bias).max(1)
    }
}
