//! Names of files and systems in messages.

use std::path::Path;

use hedgehop_base::error::Result;
use hedgehop_geo::Crs;

/// Builds the error of a file that states a reference system, if another one is given for it.
pub(super) fn contradiction(
    name: &str,
    stated: &Crs,
    given: Option<&str>,
    flag: &str,
) -> Result<Option<String>> {
    let given = given.map(Crs::from_user).transpose()?;
    Ok(given.filter(|given| given != stated && given.name() != stated.name()).map(|given| {
        format!(
            "{name}: states {}, which counts, and not {}; {flag} is of files that state none",
            stated.name(),
            given.name()
        )
    }))
}

/// File name without folders.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// `EPSG:32633`, or the name of a system without a code.
pub(super) fn crs_label(crs: &Crs) -> String {
    crs.epsg().map_or_else(|| crs.name().to_owned(), |code| format!("EPSG:{code}"))
}
