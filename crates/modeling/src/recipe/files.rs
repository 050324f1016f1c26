//! Files and systems that tables name.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::fields::Fields;
use super::pattern::matching;
use hedgehop_geo::Crs;

/// One value, or several in brackets.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a value, or several in brackets")]
pub(super) enum OneOrMany<T> {
    One(T),
    Many(Vec<T>),
}

impl<T> OneOrMany<T> {
    pub(super) fn into_vec(self) -> Vec<T> {
        match self {
            Self::One(one) => vec![one],
            Self::Many(many) => many,
        }
    }
}

/// A reference system, as text that is understood.
pub(super) fn crs(table: &mut Fields<'_, '_, '_>) -> Option<String> {
    let text = table.take::<String>("crs")?;
    table.mistakes.check(&text.span(), Crs::from_user(text.get_ref()))?;
    Some(text.into_inner())
}

/// Files by names that count from the recipe's folder, all of which exist.
pub(super) fn files(table: &mut Fields<'_, '_, '_>, folder: &Path, example: &str) -> Vec<PathBuf> {
    files_of(table, "file", folder, example)
}

/// Files by names under any key.
pub(super) fn files_of(
    table: &mut Fields<'_, '_, '_>,
    key: &'static str,
    folder: &Path,
    example: &str,
) -> Vec<PathBuf> {
    let Some(names) = table.need::<OneOrMany<String>>(key, example) else { return Vec::new() };
    let span = names.span();
    let names = names.into_inner().into_vec();
    if names.is_empty() {
        table.mistakes.add(&span, format!("{key} names none; write {key} = {example}"));
    }
    let found = names.into_iter().filter_map(|name| table.mistakes.check(&span, matching(folder, &name)));
    found.flatten().filter_map(|path| file(table, &span, &path)).collect()
}

pub(super) fn file(
    table: &Fields<'_, '_, '_>,
    span: &std::ops::Range<usize>,
    path: &Path,
) -> Option<PathBuf> {
    let found = match std::fs::metadata(path) {
        Ok(found) if found.is_file() => Ok(path.to_owned()),
        Ok(_) => Err(format!("{} is no file", path.display())),
        Err(error) => Err(format!("cannot read {}: {error}", path.display())),
    };
    table.mistakes.check(span, found)
}
