//! Checking a database from end to end.

/// What was checked.
#[derive(Debug, Clone)]
pub struct VerifyReport {}

/// Checks everything.
pub fn verify() {}
