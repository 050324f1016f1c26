//! Stand-in for the guard on systems without SIGBUS: mapped files are not watched.

use hedgehop_base::error::Result;

/// Watches nothing.
#[derive(Debug)]
pub(super) struct Watch;

impl Watch {
    /// No byte is ever known to have failed.
    pub fn failed(&self) -> Option<u64> {
        None
    }
}

/// Does nothing on this system; elsewhere it has databases that cannot be read any more end what is rendered from them with an error.
///
/// # Errors
/// None here.
pub fn guard_mapped_files() -> Result<()> {
    Ok(())
}
