//! List of the formats that are read: what the program says of them, and README and manual repeat.

/// A format of rasters that is read.
#[derive(Debug, Clone, Copy)]
pub struct RasterFormat {
    /// Name for people, as in a list.
    pub name: &'static str,
    /// Endings of its files, in lower case, the commonest first; none where files of it are named in any way.
    pub endings: &'static [&'static str],
    /// Whether elevation comes in it.
    pub is_elevation: bool,
    /// Whether imagery comes in it.
    pub is_imagery: bool,
}

/// Formats that are read, the commonest first.
pub const FORMATS: [RasterFormat; 13] = [
    RasterFormat { name: "GeoTIFF", endings: &["tif", "tiff"], is_elevation: true, is_imagery: true },
    RasterFormat::elevation("SRTM .hgt", &["hgt"]),
    RasterFormat::elevation("DTED", &["dt2", "dt1", "dt0"]),
    RasterFormat::elevation("Esri ASCII", &["asc"]),
    RasterFormat::elevation("GridFloat", &["flt"]),
    RasterFormat::elevation("Esri BIL", &["bil", "bip", "bsq"]),
    RasterFormat::elevation("GTOPO30", &["dem"]),
    RasterFormat::elevation("ENVI", &[]),
    RasterFormat::elevation("VTP .bt", &["bt"]),
    RasterFormat::elevation("16-bit PNG", &["png"]),
    RasterFormat::elevation("raw float32", &[]),
    RasterFormat::imagery("JPEG", &["jpg", "jpeg"]),
    RasterFormat::imagery("PNG", &["png"]),
];

impl RasterFormat {
    const fn elevation(name: &'static str, endings: &'static [&'static str]) -> Self {
        Self { name, endings, is_elevation: true, is_imagery: false }
    }

    const fn imagery(name: &'static str, endings: &'static [&'static str]) -> Self {
        Self { name, endings, is_elevation: false, is_imagery: true }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::path::Path;

    use super::*;

    /// Reads a file of the repository; `None`, which is told, where this crate stands without it.
    fn document(name: &str) -> Option<String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name);
        if !path.exists() {
            // Written past the test harness, which swallows what passing tests print.
            let _ = writeln!(std::io::stderr(), "skipped: {} is not there", path.display());
            return None;
        }
        Some(std::fs::read_to_string(path).unwrap().replace('`', ""))
    }

    /// The part of a text from one mark to another.
    fn between<'t>(text: &'t str, from: &str, to: &str) -> &'t str {
        let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no {from:?}"));
        rest.split_once(to).unwrap_or_else(|| panic!("no {to:?} after {from:?}")).0
    }

    fn assert_names_all(place: &str, text: &str, is_meant: fn(&RasterFormat) -> bool) {
        for RasterFormat { name, .. } in FORMATS.iter().filter(|format| is_meant(format)) {
            assert!(text.contains(name), "{place} does not name {name}: {text}");
        }
    }

    #[test]
    fn the_readme_names_every_format() {
        let Some(text) = document("README.md") else { return };
        assert_names_all("README.md", between(&text, "Elevation may be", "; imagery"), |f| f.is_elevation);
        assert_names_all("README.md", between(&text, "; imagery", "; points"), |f| f.is_imagery);
    }

    #[test]
    fn the_manual_of_recipes_names_every_format() {
        let Some(text) = document("docs/recipe.md") else { return };
        let file = |table: &str| between(&text, &format!("| [[{table}]] file |"), "\n");
        assert_names_all("docs/recipe.md", file("elevation"), |f| f.is_elevation);
        assert_names_all("docs/recipe.md", file("imagery"), |f| f.is_imagery);
    }

    #[test]
    fn every_format_has_a_name_of_its_own_and_a_use() {
        for (number, format) in FORMATS.iter().enumerate() {
            assert!(format.is_elevation || format.is_imagery, "{}", format.name);
            assert!(FORMATS[..number].iter().all(|before| before.name != format.name), "{}", format.name);
            assert!(format.endings.iter().all(|ending| ending.to_ascii_lowercase() == **ending));
        }
    }
}
