//! Patterns of file names, for who writes them where no shell expands them.

use std::path::{Path, PathBuf};

use glob::{MatchOptions, Pattern, glob_with};

use hedgehop_base::error::{Error, Result};

/// Letters that make a name a pattern.
const WILD: [char; 3] = ['*', '?', '['];

/// Options of shells: names that begin with a dot are matched only by patterns that do, and `*` does not cross folders, as `**` does.
const OPTIONS: MatchOptions = MatchOptions {
    case_sensitive: !cfg!(windows),
    require_literal_separator: true,
    require_literal_leading_dot: true,
};

/// Files that a name means, seen from `folder`: the one of that name, or all that match it as a pattern with `*`, `?`, `[…]` and `**`, sorted
/// by name.
///
/// # Errors
/// A pattern that no file matches, or that is none; folders below it that cannot be read.
pub fn matching(folder: &Path, name: &str) -> Result<Vec<PathBuf>> {
    let literal = folder.join(name);
    // A file may have such a letter in its name.
    if !name.contains(WILD) || literal.exists() {
        return Ok(vec![literal]);
    }

    let pattern = match (Path::new(name).is_absolute(), folder.as_os_str().is_empty()) {
        (false, false) => Path::new(&Pattern::escape(&folder.to_string_lossy())).join(name),
        _ => PathBuf::from(name),
    };
    let wrong = |what: String| Error::Configuration(format!("{}: {what}", literal.display()));
    let found = glob_with(&pattern.to_string_lossy(), OPTIONS)
        .map_err(|error| wrong(format!("is no pattern ({error}); * stands for any letters, ? for one")))?;

    let mut files = Vec::new();
    for entry in found {
        let path = entry.map_err(|error| wrong(format!("cannot be searched: {error}")))?;
        if path.is_file() {
            files.push(path);
        }
    }

    match files.is_empty() {
        true => Err(wrong("no file matches this pattern".into())),
        false => Ok(files),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path, pattern: &str) -> Vec<String> {
        let found = matching(folder, pattern).unwrap();
        found
            .iter()
            .map(|path| path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/"))
            .collect()
    }

    #[test]
    fn patterns_mean_files() {
        let outer = tempfile::tempdir().unwrap();
        // Letters of a pattern in a folder's own name mean themselves.
        let folder = outer.path().join("survey [2]");
        std::fs::create_dir_all(folder.join("deep/er")).unwrap();
        std::fs::create_dir(folder.join("folder.tif")).unwrap();
        for name in ["b.tif", "a.tif", "c.hgt", ".hidden.tif", "deep/d.tif", "deep/er/e.tif", "odd[1].tif"] {
            std::fs::write(folder.join(name), b"").unwrap();
        }

        assert_eq!(names(&folder, "?.tif"), ["a.tif", "b.tif"]);
        assert_eq!(names(&folder, "[bc].*"), ["b.tif", "c.hgt"]);
        assert_eq!(names(&folder, "deep/**/*.tif"), ["deep/d.tif", "deep/er/e.tif"]);
        assert_eq!(names(&folder, "odd[1].tif"), ["odd[1].tif"]);
        assert_eq!(names(&folder, "missing.tif"), ["missing.tif"]);
        for (pattern, words) in [("*.laz", "no file matches this pattern"), ("a***", "is no pattern")] {
            let error = matching(&folder, pattern).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains(pattern), "{error}");
        }

        let absolute = folder.parent().unwrap().join("*").join("c.*");
        assert_eq!(
            matching(Path::new("elsewhere"), &absolute.to_string_lossy()).unwrap(),
            [folder.join("c.hgt")]
        );
    }
}
