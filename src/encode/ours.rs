//! Files of other programs that stand where ours would go.

use std::path::Path;

use hedgehop_base::error::{Error, Result};

/// Refuses a file that is there already and not one of ours by its text.
pub(super) fn check_ours(path: &Path, is_ours: &dyn Fn(&str) -> bool) -> Result<()> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(Error::io(path, "read it", error)),
    };
    if is_ours(&String::from_utf8_lossy(&bytes)) {
        return Ok(());
    }
    let what = "it is not of a render by this program, which would replace it; give another folder to -o";
    Err(Error::Configuration(format!("{}: {what}", path.display())))
}
