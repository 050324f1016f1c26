//! Folder of the real data.

use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of real data; says so and answers `None` where there is none.
pub fn realdata() -> Option<PathBuf> {
    let folder = std::env::var_os("HEDGEHOP_REALDATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/realdata"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    // Written past the test harness, which swallows what passing tests print.
    let _ =
        writeln!(std::io::stderr(), "skipped: no real data at {} (set HEDGEHOP_REALDATA)", folder.display());
    None
}
