//! Reference systems as people give them.
//!
//! ```text
//! local | +proj=… | +init=epsg:CODE | codes (notation.rs) | WKT | a file of any
//! ```

use std::fs;
use std::path::Path;

use super::crs::{Crs, shortened};
use super::datum::VerticalCrs;
use super::definition::Definition;
use super::notation::{Code, codes};
use super::{heights, wkt, wkt_system};
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};

/// Examples of what may be typed, for error messages.
const EXAMPLES: &str =
    "give for example EPSG:32633, local, '+proj=utm +zone=33 +datum=WGS84', WKT, or the path of a .prj file";

/// Longest text of a reference system that is read, in bytes.
const LONGEST_FILE: u64 = 1 << 20;

impl Crs {
    /// Parses what a user types: `EPSG:32633`, `32633`, `local`, `+proj=…`, WKT, or a `.prj` file's path.
    pub fn from_user(text: &str) -> Result<Self> {
        Ok(Self::with_vertical_from_user(text)?.0)
    }

    /// Parses as [`Crs::from_user`] does, with the system of the heights where the text names one
    /// (`EPSG:4326+5773`, `EPSG:9518`, compound WKT).
    pub fn with_vertical_from_user(text: &str) -> Result<(Self, Option<VerticalCrs>)> {
        let text = text.trim();
        if text.eq_ignore_ascii_case("local") {
            return Ok((Self::local(), None));
        }
        if looks_like_proj(text) {
            return from_proj_or_init(text);
        }
        if let Some(codes) = codes(text) {
            return from_codes(codes).map_err(Error::Configuration);
        }
        if wkt::looks_like_wkt(text) {
            return Self::with_vertical_from_wkt(text);
        }
        if looks_like_path(text) {
            return from_file(Path::new(text));
        }
        Err(Error::Configuration(format!("'{}' names no reference system; {EXAMPLES}", shortened(text))))
    }

    /// Parses the text of a file beside others (`.prj`): WKT, a PROJ definition, or a code. The error is a sentence
    /// without a place.
    pub fn with_vertical_from_text(text: &str) -> Result<(Self, Option<VerticalCrs>), String> {
        let text = text.trim_start_matches('\u{feff}').trim();
        if looks_like_proj(text) {
            from_proj_or_init(text).map_err(|error| error.to_string())
        } else if let Some(codes) = codes(text) {
            from_codes(codes)
        } else {
            wkt_system::read(text)
        }
    }
}

fn looks_like_proj(text: &str) -> bool {
    text.starts_with('+') || text.starts_with("proj=") || text.starts_with("init=")
}

fn from_proj_or_init(text: &str) -> Result<(Crs, Option<VerticalCrs>)> {
    let init = Definition::parse(text).map_err(Error::Configuration)?.get("init").map(str::to_owned);
    match init.as_deref().map(codes) {
        None => {
            let vertical = heights::of_definition(text).map_err(Error::Configuration)?;
            Ok((Crs::from_proj(text, text)?, vertical))
        }
        Some(Some(codes)) => from_codes(codes).map_err(Error::Configuration),
        Some(None) => {
            Err(Error::Configuration(format!("'{}' is not +init=epsg:CODE; {EXAMPLES}", shortened(text))))
        }
    }
}

/// A horizontal system, and perhaps a vertical one.
fn from_codes(codes: Vec<Code>) -> Result<(Crs, Option<VerticalCrs>), String> {
    let is_none = |text: String| format!("'{}' is no EPSG code; {EXAMPLES}", shortened(&text));
    let codes: Vec<u32> = codes.into_iter().collect::<Result<_, _>>().map_err(is_none)?;
    let (horizontal, vertical) = match codes[..] {
        [horizontal] => (horizontal, None),
        [horizontal, vertical] => (horizontal, Some(vertical)),
        _ => {
            return Err(format!(
                "a horizontal and a vertical system are two codes, not {}; {EXAMPLES}",
                codes.len()
            ));
        }
    };

    let vertical = match vertical {
        None => heights::part_of(horizontal),
        Some(code) => Some(heights::by_code(code).ok_or_else(|| {
            format!("EPSG:{code} is not known here as a system of heights; say what the heights are measured from with --src-vdatum")
        })?),
    };

    Ok((Crs::by_code(horizontal)?, vertical))
}

fn looks_like_path(text: &str) -> bool {
    let path = Path::new(text);
    let extension =
        path.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
    matches!(extension.as_str(), "prj" | "wkt" | "proj" | "txt") || path.is_file()
}

fn from_file(path: &Path) -> Result<(Crs, Option<VerticalCrs>)> {
    let length = fs::metadata(path).map_err(|error| Error::io(path, "read", error))?.len();
    if length > LONGEST_FILE {
        return Err(Error::invalid(
            path,
            format!("{length} bytes are too many for a reference system; {EXAMPLES}"),
        ));
    }
    let bytes = fs::read(path).map_err(|error| Error::io(path, "read", error))?;
    let text = String::from_utf8_lossy(unmarked(path, &bytes)?);
    Crs::with_vertical_from_text(&text).map_err(|reason| Error::invalid(path, reason))
}
