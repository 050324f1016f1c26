//! Where real data lies.

use std::path::{Path, PathBuf};

/// The folder of real data; says so and answers `None` where there is none.
pub fn realdata() -> Option<PathBuf> {
    let folder = std::env::var_os("HEDGEHOP_REALDATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/realdata"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: {} is absent (HEDGEHOP_REALDATA)", folder.display());
    None
}
