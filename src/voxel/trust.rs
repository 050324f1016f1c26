//! Trust in a database's bytes, and the fate of damaged pages.

/// Time at which pages are checked against their checksums.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Verify {
    /// Once, when they are first touched.
    #[default]
    FirstTouch,
    /// Never. Shape and place are checked all the same: wrong bytes give a wrong picture, nothing worse.
    Never,
}

/// Fate of a damaged page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Damaged {
    /// Whoever touches it is told so.
    #[default]
    Fail,
    /// Left out as if it were absent: the next coarser level stands in. Nothing stands in for the coarsest one, so that a
    /// damaged page there is an error still. Which pages are damaged is a property of the file, so that pictures are the same for any
    /// number of workers and under any budget.
    Coarser,
}

/// Trust with which a database is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trust {
    /// Time at which pages are checked.
    pub verify: Verify,
    /// Fate of damaged ones.
    pub damaged: Damaged,
}
