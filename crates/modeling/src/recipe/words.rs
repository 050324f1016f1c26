//! Keys of recipes for what a build says in flags.

use hedgehop_base::error::Error;
use hedgehop_base::progress::Observer;

/// Flags, the tables of a recipe in which the same is said, and their keys there; without a key it is the table itself.
const WORDS: [(&str, &str, &str); 24] = [
    ("--bands", "[[imagery]]", "bands"),
    ("--bbox", "[place]", "bbox"),
    ("--cloud", "[[cloud]]", ""),
    ("--cloud-crs", "[[cloud]]", "crs"),
    ("--corridor", "[[corridor]]", ""),
    ("--crs", "[place]", "crs"),
    ("--elevation", "[[elevation]]", ""),
    ("--elevation-crs", "[[elevation]]", "crs"),
    ("--features", "[[features]]", ""),
    ("--imagery", "[[imagery]]", ""),
    ("--imagery-crs", "[[imagery]]", "crs"),
    ("--imagery-extent", "[[imagery]]", "extent"),
    ("--land-cover", "[[land_cover]]", ""),
    ("--land-cover-crs", "[[land_cover]]", "crs"),
    ("--local", "[place]", "local"),
    ("--nodata", "[[elevation]]", "nodata"),
    ("--nodata-fill", "[place]", "voids"),
    ("--outside", "[place]", "outside_m"),
    ("--sort", "[[corridor]]", "sort"),
    ("--spacing", "[place]", "spacing_m"),
    ("--src-vdatum", "[[elevation]]", "vertical_datum"),
    ("--track", "[[corridor]]", "track"),
    ("--width", "[[corridor]]", "width_m"),
    ("-o", "[place]", "output"),
];

/// The words of a text, and what lies between them, in turn.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let is_of_flag = |char: char| char.is_ascii_alphanumeric() || char == '-';
    let mut rest = text;
    std::iter::from_fn(move || {
        let first = rest.chars().next()?;
        let end = rest.find(|char| is_of_flag(char) != is_of_flag(first)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        rest = after;
        Some(word)
    })
}

fn known(word: &str) -> Option<(&'static str, &'static str)> {
    WORDS.iter().find(|(flag, ..)| *flag == word).map(|(_, table, key)| (*table, *key))
}

/// The same sentence for somebody who reads and writes a recipe.
pub fn in_keys(said: &str) -> String {
    let mut told = String::with_capacity(said.len());
    let mut rest = said;
    for word in words(said) {
        rest = &rest[word.len()..];
        match known(word) {
            // Its own spacing, not that of the place.
            Some((_, key)) if told.ends_with("corridor of ") => told += &format!("`{key}`"),
            Some((table, "")) => told += table,
            Some((table, key)) => told += &format!("`{key}` of {table}"),
            None => told += word,
        }
        if known(word).is_some_and(|(_, key)| !key.is_empty()) && begins_with_number(rest) {
            told += " =";
        }
    }
    told
}

/// Whether a flag's value, a number or several, follows.
fn begins_with_number(rest: &str) -> bool {
    let value = rest.strip_prefix(' ').map(|value| value.strip_prefix('-').unwrap_or(value));
    value.is_some_and(|value| value.starts_with(|char: char| char.is_ascii_digit()))
}

/// Key of the table `[place]` that a sentence is about: of those that it names the first.
pub(super) fn key_of_place(said: &str) -> Option<&'static str> {
    words(said)
        .filter_map(known)
        .find(|(table, key)| *table == "[place]" && !key.is_empty())
        .map(|(_, key)| key)
}

/// The same error for somebody who reads and writes a recipe.
pub fn error_in_keys(error: Error) -> Error {
    match error {
        Error::Invalid { path, what } => Error::Invalid { path, what: in_keys(&what) },
        Error::Unsupported { path, what, remedy } => {
            Error::Unsupported { path, what: in_keys(&what), remedy: in_keys(&remedy) }
        }
        Error::Configuration(what) => Error::Configuration(in_keys(&what)),
        other => other,
    }
}

/// Passes on what a build tells, its notes in the keys of recipes.
pub struct InKeys<'o>(pub &'o dyn Observer);

impl Observer for InKeys<'_> {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        self.0.begin(stage, total, unit);
    }

    fn advance(&self, count: u64) {
        self.0.advance(count);
    }

    fn end(&self) {
        self.0.end();
    }

    fn note(&self, text: &str) {
        self.0.note(&in_keys(text));
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn flags_become_keys_and_other_words_stay() {
        let said = "say --elevation-crs EPSG:4326 if you know it, or --local; --memory is little, a -b 1 too, x--crs";
        let wanted = "say `crs` of [[elevation]] EPSG:4326 if you know it, or `local` of [place]; --memory is little, a -b 1 too, x--crs";
        assert_eq!(in_keys(said), wanted);
        let said = "a corridor of --spacing 2.5 adds nothing; --outside 32 would do, --bbox -1,2,3,4 not, --bbox 4; --nodata";
        let wanted = "a corridor of `spacing_m` = 2.5 adds nothing; `outside_m` of [place] = 32 would do, \
                      `bbox` of [place] = -1,2,3,4 not, `bbox` of [place] = 4; `nodata` of [[elevation]]";
        assert_eq!(in_keys(said), wanted);
        assert_eq!(key_of_place("--elevation: --bbox lies outside, and --spacing"), Some("bbox"));
        assert_eq!(key_of_place("--memory"), None);
    }

    /// Flags in the texts of a folder's sources.
    fn flags(folder: &Path, found: &mut Vec<(String, String)>) {
        for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            if path.is_dir() {
                if !["tests", "recipe"].contains(&name.as_str()) {
                    flags(&path, found);
                }
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            let all = lines.flat_map(words).filter(|word| {
                word.strip_prefix("--")
                    .is_some_and(|rest| rest.starts_with(|char: char| char.is_ascii_lowercase()))
            });
            found.extend(all.map(|word| (name.clone(), word.to_owned())));
        }
    }

    #[test]
    fn all_flags_that_a_build_names_have_keys() {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut found = Vec::new();
        ["src", "../geo/src"].iter().for_each(|folder| flags(&package.join(folder), &mut found));
        assert!(found.len() > 20, "{found:?}");
        for (file, flag) in found {
            // These are no matter of recipes, but of the command that builds them.
            let is_known = known(&flag).is_some() || ["--memory", "--overwrite"].contains(&flag.as_str());
            assert!(is_known, "{file} names {flag}, which recipes say otherwise: add it to WORDS");
        }
    }
}
