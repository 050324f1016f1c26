//! Outputs that a build refuses before any work is done.

use std::path::{Path, PathBuf};

use crate::object::ScatterFile;
use crate::options::BuildOptions;
use hedgehop::voxel::PageWriter;
use hedgehop_base::error::{Error, Result};

/// Bytes of a database's name: those of files have 255, and what is kept beside it is named after it.
const LONGEST_NAME: usize = 200;

/// Refuses an output that no database can be, whether anything may be replaced or not.
///
/// # Errors
/// The output is an input, a folder or a device, or has no name that a file can have.
pub fn check_name(options: &BuildOptions) -> Result<()> {
    let name = options.output.to_string_lossy();
    let refuse =
        |what: String| Err(Error::Configuration(format!("{what}; name a file with -o, like AREA.hop")));
    if name.is_empty() {
        return refuse("the output has no name".into());
    }
    if name.contains('\0') {
        return refuse(format!(
            "{} has a NUL character in it, as no name can",
            name.replace('\0', "\u{fffd}")
        ));
    }

    // The system would refuse such names only after all pages were made.
    let last = name.rsplit(std::path::is_separator).next().unwrap_or_default();
    if ["", ".", ".."].contains(&last) {
        return refuse(format!("{name} is a folder"));
    }
    if last.len() > LONGEST_NAME {
        return refuse(format!("{last} is too long a name: {LONGEST_NAME} bytes are the most"));
    }

    // Paths that do not resolve are no inputs that could be lost.
    if let Ok(output) = options.output.canonicalize() {
        let is_output = |input: &&PathBuf| input.canonicalize().is_ok_and(|input| input == output);
        let clouds = options.clouds.iter().map(|file| &file.path);
        let elevation = options.elevation.iter().map(|file| &file.path).chain(clouds);
        let imagery = options.imagery.iter().map(|file| &file.path);
        let land_cover = options.land_cover.iter().map(|file| &file.path);
        let features = options.features.iter().map(|file| &file.path);
        let models = options.objects.iter().flat_map(|file| &file.paths);
        let scattered = options.scatters.iter().flat_map(ScatterFile::paths);
        let routes = options.corridors.iter().map(|corridor| &corridor.route.file);
        let others = features.chain(models).chain(scattered).chain(routes);
        if let Some(input) = elevation.chain(imagery).chain(land_cover).chain(others).find(is_output) {
            return Err(Error::Configuration(format!(
                "{} is an input; name another file with -o, like AREA.hop",
                input.display()
            )));
        }
    }

    PageWriter::check_target(&options.output, true)
}

/// Refuses an output that must not be written, before any work is done.
///
/// # Errors
/// The name is refused by [`check_name`]; a file exists there and may not be replaced, or nothing can be written there.
pub fn check_output(options: &BuildOptions) -> Result<()> {
    check_name(options)?;
    PageWriter::check_target(&options.output, options.overwrite)?;
    // A folder that is missing, or not writable, would show only after the heights were scanned.
    let folder = options.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    tempfile::tempfile_in(folder.unwrap_or(Path::new(".")))
        .map(drop)
        .map_err(|error| Error::io(&options.output, "create a file beside it", error))
}
