//! Where along planes ground may be displaced, and by how much.

use super::displaced_field::DisplacedField;

/// Bounds of displacement as a march asks for them.
#[derive(Debug, Clone, Copy)]
pub(super) struct DisplacedStretch<'d> {
    field: Option<&'d DisplacedField<'d>>,
    /// Major distance up to which lines are sampled between, units; 0: nowhere.
    pub until: f32,
}

impl<'d> DisplacedStretch<'d> {
    /// Bounds of a field; of none there is no displacement.
    pub fn new(field: Option<&'d DisplacedField<'d>>) -> Self {
        Self { field, until: field.map_or(0.0, DisplacedField::until) }
    }

    /// Parts of the stretch between two lines that ends at a major distance, units.
    #[inline(always)]
    pub fn parts(&self, distance: f32) -> i32 {
        self.field.map_or(1, |field| field.parts(distance))
    }

    /// Bound of displacements at a major distance or beyond, metres.
    #[inline(always)]
    pub fn bound(&self, distance: f32) -> f64 {
        match self.field {
            Some(field) if distance < self.until => field.bound(distance.into()),
            _ => 0.0,
        }
    }
}
