//! What features are.

/// What a whole layer is, where its rows do not say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// Houses, halls, sheds.
    Building,
}
