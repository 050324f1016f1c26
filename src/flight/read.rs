//! Opens a path file and finds its format: content first, extension second.

use std::fs;
use std::path::Path;

use super::raw::{PathSource, Reading};
use super::track::{ReadOptions, Track};
use super::{csv, gpx, igc, kml};
use crate::flight::assemble::assemble;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};

/// Reads a path file; the format follows from its content, and from the extension only where the content leaves it
/// open.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Invalid`] with line and column if it holds something wrong;
/// [`Error::Unsupported`] with a remedy for zipped, binary or timeless files.
pub fn read_track(path: &Path, options: &ReadOptions) -> Result<Track> {
    check_file(path)?;
    let bytes = fs::read(path).map_err(|source| Error::io(path, "read", source))?;
    let source = PathSource { path, options };
    let text = text_of(&source, &bytes)?;
    assemble(&source, read_text(&source, &text)?)
}

/// Bytes of the largest path file: more than a year at ten fixes a second, and few enough to hold.
const MOST_BYTES: u64 = 2 << 30;

/// Refuses pipes and devices, which can be read only once or have no end, and files beyond any flight.
fn check_file(path: &Path) -> Result<()> {
    let found = fs::metadata(path).map_err(|source| Error::io(path, "read", source))?;
    if found.is_dir() {
        Err(Error::Configuration(format!("{} is a folder; --path takes a file", path.display())))
    } else if !found.is_file() {
        Err(Error::invalid(path, "is no regular file; write the path to one first"))
    } else if found.len() > MOST_BYTES {
        let what = format!("holds {} bytes, more than the {MOST_BYTES} that a path may have", found.len());
        Err(Error::unsupported(path, what, "cut it into one file per flight"))
    } else {
        Ok(())
    }
}

/// Text without byte order mark; what is not UTF-8 (old loggers write names in Latin-1) becomes �, which no number holds.
fn text_of<'a>(source: &PathSource<'_>, bytes: &'a [u8]) -> Result<std::borrow::Cow<'a, str>> {
    let refuse = |what: &str, remedy: &str| Err(Error::unsupported(source.path, what, remedy));
    if bytes.starts_with(b"PK\x03\x04") {
        return refuse("this is a zip file (KMZ?)", "unzip it and give the .kml inside");
    }
    let bytes = unmarked(source.path, bytes)?;
    if bytes.contains(&0) {
        return refuse("this is a binary file, no path", "give a CSV, JSBSim CSV, KML, GPX or IGC file");
    }
    Ok(String::from_utf8_lossy(bytes))
}

fn read_text(source: &PathSource<'_>, text: &str) -> Result<Reading> {
    let extension = source.path.extension().map(|name| name.to_string_lossy().to_ascii_lowercase());
    let named = |name: &str| extension.as_deref() == Some(name);
    if text.trim().is_empty() {
        return Err(Error::invalid(source.path, "the file is empty; give at least one position"));
    }

    if text.trim_start().starts_with('<') {
        let start: String = text.chars().take(4096).collect::<String>().to_ascii_lowercase();
        return match (start.contains("<gpx"), start.contains("<kml") || start.contains(":kml")) {
            (true, _) => gpx::read(source, text),
            (_, true) => kml::read(source, text),
            _ if named("gpx") => gpx::read(source, text),
            _ if named("kml") => kml::read(source, text),
            _ => Err(Error::unsupported(
                source.path,
                "this is XML, but neither GPX nor KML",
                "give a GPX or KML file",
            )),
        };
    }

    if named("gpx") || named("kml") {
        return Err(Error::invalid(
            source.path,
            "line 1: this is no XML; rename the file if it is a table (.csv)",
        ));
    }

    if named("igc") || igc::looks_like_igc(text) { igc::read(source, text) } else { csv::read(source, text) }
}

#[cfg(test)]
mod tests;
