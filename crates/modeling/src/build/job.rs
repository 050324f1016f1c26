//! Context of one build, the same through all of its phases.

use crate::budget::Budget;
use crate::options::BuildOptions;
use hedgehop::voxel::Metadata;
use hedgehop_base::progress::Observer;

/// Settings of a build, what it may hold, and who follows it.
#[derive(Clone, Copy)]
pub(super) struct BuildJob<'a> {
    pub options: &'a BuildOptions,
    pub budget: &'a Budget,
    pub observer: &'a dyn Observer,
}

/// Metadata of the database while they grow, whose notes are told as they come.
pub(super) struct BuildRecord<'a> {
    pub metadata: Metadata,
    observer: &'a dyn Observer,
}

impl<'a> BuildRecord<'a> {
    /// Starts from metadata with notes that nobody has been told.
    pub fn new(metadata: Metadata, observer: &'a dyn Observer) -> Self {
        metadata.notes.iter().for_each(|note| observer.note(note));
        Self { metadata, observer }
    }

    /// Tells a note and keeps it.
    pub fn note(&mut self, note: String) {
        self.observer.note(&note);
        self.metadata.notes.push(note);
    }

    /// Tells some notes and keeps them.
    pub fn notes(&mut self, notes: impl IntoIterator<Item = String>) {
        notes.into_iter().for_each(|note| self.note(note));
    }
}
