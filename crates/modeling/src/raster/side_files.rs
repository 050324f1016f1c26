//! Files beside a raster: world files and `.prj`.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::decimal::decimal;
use super::georeference::set_crs;
use super::pam;
use crate::raster::{GeoTransform, RasterInfo};
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};

/// Side files are short; anything beyond is not what it claims to be.
const LONGEST: u64 = 1 << 20;

/// The path with another extension, in the spelling that exists (`prj`, `PRJ`).
pub(super) fn beside(path: &Path, extension: &str) -> Option<PathBuf> {
    [extension.to_owned(), extension.to_ascii_uppercase()]
        .into_iter()
        .map(|extension| path.with_extension(extension))
        .find(|candidate| candidate.is_file() && candidate != path)
}

/// Text of a side file; bytes that are no UTF-8 are replaced.
pub(super) fn text(path: &Path) -> Result<String> {
    let file = fs::File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let mut bytes = Vec::new();
    file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
    if bytes.len() as u64 > LONGEST {
        return Err(Error::invalid(path, "is longer than 1 MiB and so is no header of the raster beside it"));
    }
    Ok(String::from_utf8_lossy(unmarked(path, &bytes)?).into_owned())
}

/// Fills in what the file itself does not state: georeferencing from a world file, the CRS from a `.prj`, and before
/// these what `.aux.xml` says.
pub(super) fn complete(info: &mut RasterInfo) -> Result<()> {
    pam::apply(info)?;
    info.settle_bands();
    if info.geo.is_none() {
        info.geo = world_file(&info.path)?;
    }
    match beside(&info.path, "prj") {
        Some(prj) if info.crs.is_none() && info.crs_problem.is_none() => {
            let text = text(&prj)?;
            if !text.trim().is_empty() {
                set_crs(info, &prj, &text);
            }
        }
        _ => {}
    }
    Ok(())
}

/// Georeferencing from a world file beside `path`: `x.pgw`, `x.pngw` or `x.wld` for `x.png`.
fn world_file(path: &Path) -> Result<Option<GeoTransform>> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let mut candidates = Vec::new();
    if let (Some(first), Some(last)) = (extension.chars().next(), extension.chars().last()) {
        candidates.push(format!("{first}{last}w"));
        candidates.push(format!("{extension}w"));
    }
    candidates.push("wld".to_owned());
    match candidates.iter().find_map(|extension| beside(path, extension)) {
        Some(file) => parse_world_file(&file, &text(&file)?).map(Some),
        None => Ok(None),
    }
}

/// Six numbers, one per line: x per column, y per column, x per row, y per row, x and y of the first pixel's centre.
fn parse_world_file(path: &Path, text: &str) -> Result<GeoTransform> {
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().take(6).map(|token| decimal(token).ok()).collect();
    let [x_column, y_column, x_row, y_row, x, y] = numbers
        .and_then(|numbers| <[f64; 6]>::try_from(numbers).ok())
        .filter(|numbers| numbers.iter().all(|n| n.is_finite()))
        .ok_or_else(|| Error::invalid(path, "is no world file: six numbers, one per line, are expected"))?;
    Ok([x - (x_column + x_row) / 2.0, x_column, x_row, y - (y_column + y_row) / 2.0, y_column, y_row])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn world_files_state_the_centre_of_the_first_pixel() {
        let geo = parse_world_file(Path::new("a.pgw"), "2\n0\n0\n-2\n101\n499\n").unwrap();
        assert_eq!(geo, [100.0, 2.0, 0.0, 500.0, 0.0, -2.0]);
        assert!(parse_world_file(Path::new("a.pgw"), "2 0 0 -2 101").is_err());
        assert!(parse_world_file(Path::new("a.pgw"), "2 0 0 inf 101 1").is_err());
    }

    #[test]
    fn world_files_are_found_beside_their_picture() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("a.jpg");
        assert_eq!(world_file(&picture).unwrap(), None);
        fs::write(folder.path().join("a.jgw"), "1 0 0 -1 0.5 -0.5").unwrap();
        assert_eq!(world_file(&picture).unwrap(), Some([0.0, 1.0, 0.0, 0.0, 0.0, -1.0]));
    }
}
