//! Names the sources that databases are made by, so that pages of another version are not taken for those of this one.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

/// Sources of this crate and of the crates below it, as far as they lie in this repository: a package of its own has a
/// version for each.
const SOURCES: [&str; 6] =
    ["src", "../assets/src", "../base/src", "../geo/src", "../../src", "../../Cargo.lock"];

fn main() {
    let mut files = vec![PathBuf::from("Cargo.toml")];
    for source in SOURCES.map(Path::new).into_iter().filter(|source| source.exists()) {
        println!("cargo::rerun-if-changed={}", source.display());
        if source.is_dir() {
            collect(source, &mut files);
        } else {
            files.push(source.to_owned());
        }
    }
    files.sort();

    let mut hasher = DefaultHasher::new();
    for file in files {
        fs::read(&file).unwrap_or_default().hash(&mut hasher);
    }
    println!("cargo::rustc-env=HEDGEHOP_SOURCES={:016x}", hasher.finish());
}

/// Adds all files below a folder.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { collect(&path, files) } else { files.push(path) }
    }
}
