//! Holds the layers of the design against the code: who may import whom, and who may know what.

use std::fs;
use std::path::{Path, PathBuf};

/// Lowest first. Modules of one entry may not import each other.
const LAYERS: &[&[&str]] = &[
    &["error"],
    &["progress", "document"],
    &["space", "colour", "earth", "picture"],
    &["simd"],
    &["geo", "model"],
    &["voxel"],
    &["sunlight"],
    &["flight"],
    &["memory", "raymarch"],
    &["subimage", "query"],
    &["objects"],
    &["scene"],
    &["sensor"],
    &["frame"],
    &["render"],
];

/// Database modelling stands beside the layers that render, on these alone.
const MODELING_MAY_USE: &[&str] =
    &["error", "progress", "document", "space", "colour", "picture", "geo", "model", "voxel", "sunlight"];

/// Recipes say what to model, along paths as flights have them.
const RECIPES_MAY_USE: &[&str] = &["error", "progress", "document", "geo", "sunlight", "flight", "modeling"];

/// The only files with unsafe code; each says why.
const UNSAFE_FILES: &[&str] =
    &["src/memory/guard.rs", "src/memory/page_file.rs", "src/simd/avx2.rs", "src/simd/avx512.rs"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            found.extend(sources(&entry));
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            found.push((entry.clone(), fs::read_to_string(&entry).unwrap()));
        }
    }
    found
}

/// Source without comments: what is said about code is not code.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Whether a source under `src/` is compiled for tests only; such a file may say that it skips.
fn is_test_source(path: &Path) -> bool {
    let is_named =
        |part: &str| ["tests", "tests.rs", "testing.rs"].contains(&part) || part.ends_with("_tests.rs");
    path.components().any(|part| part.as_os_str().to_str().is_some_and(is_named))
}

/// Source before its unit tests, if they stand in the same file.
fn without_tests(code: &str) -> &str {
    code.split("#[cfg(test)]\nmod tests {").next().unwrap_or(code)
}

/// Top-level modules that a source names as `crate::module` (also inside `use crate::{…}`).
fn imports(code: &str) -> Vec<String> {
    let mut modules = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 1;
            let mut name = String::new();
            for character in group.chars() {
                match character {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    _ => {}
                }
                if depth == 1 && (character.is_alphanumeric() || character == '_') {
                    name.push(character);
                } else if depth <= 1 && !name.is_empty() {
                    modules.push(std::mem::take(&mut name));
                }
                if depth == 0 {
                    break;
                }
            }
        } else {
            modules.push(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
        }
    }
    modules
}

fn module_of(path: &Path) -> String {
    let inside = path.strip_prefix(root().join("src")).unwrap();
    let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
    first.trim_end_matches(".rs").to_owned()
}

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

#[test]
fn imports_point_downward() {
    for (path, text) in sources(&root().join("src")) {
        let module = module_of(&path);
        if module == "lib" {
            continue;
        }
        for imported in imports(&code(&text)) {
            // A name in the crate's root that is no module is a re-export of `error`.
            let is_module = layer(&imported).is_some() || ["modeling", "recipe"].contains(&imported.as_str());
            if imported == module || !is_module {
                continue;
            }
            let allowed = match module.as_str() {
                "modeling" => MODELING_MAY_USE.contains(&imported.as_str()),
                "recipe" => RECIPES_MAY_USE.contains(&imported.as_str()),
                _ => {
                    let own = layer(&module)
                        .unwrap_or_else(|| panic!("{}: give module `{module}` a layer", path.display()));
                    layer(&imported).is_some_and(|other| other < own)
                }
            };
            assert!(allowed, "{}: `{module}` must not import `{imported}`", path.display());
        }
    }
}

#[test]
fn only_subimage_knows_rayon() {
    for (path, text) in sources(&root().join("src")) {
        assert!(
            module_of(&path) == "subimage" || !code(&text).contains("rayon"),
            "{}: rayon belongs in src/subimage alone",
            path.display()
        );
    }
}

#[test]
fn the_library_neither_prints_nor_exits_nor_parses_arguments() {
    let forbidden =
        ["println!", "eprintln!", "print!(", "eprint!(", "dbg!(", "process::exit", "clap", "indicatif"];
    for (path, text) in sources(&root().join("src")) {
        if is_test_source(path.strip_prefix(root()).unwrap()) {
            continue;
        }
        let code = code(&text);
        for word in forbidden {
            assert!(!without_tests(&code).contains(word), "{}: `{word}` belongs in tools/", path.display());
        }
    }
}

#[test]
fn unsafe_stands_only_in_the_files_that_declare_why() {
    for folder in ["src", "tools"] {
        for (path, text) in sources(&root().join(folder)) {
            let name = path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
            let code = code(&text);
            if UNSAFE_FILES.contains(&name.as_str()) {
                let squeezed: String = code.split_whitespace().collect();
                let declared = squeezed.contains("expect(unsafe_code,reason=");
                assert!(declared, "{name}: say why it is unsafe");
                assert!(text.contains("SAFETY"), "{name}: write the contract down");
            } else {
                let uses =
                    code.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == "unsafe");
                assert!(!uses, "{name}: unsafe code outside {UNSAFE_FILES:?}");
            }
        }
    }
}

#[test]
fn files_stay_short() {
    for folder in ["src", "tools", "tests", "benches", "examples"] {
        let folder = root().join(folder);
        if !folder.exists() {
            continue;
        }
        for (path, text) in sources(&folder) {
            let lines = text.lines().count();
            assert!(lines <= 500, "{}: {lines} lines; split it", path.display());
        }
    }
}

#[test]
fn the_import_reader_reads_groups_and_paths() {
    let found =
        imports("use crate::{error::Result, voxel::{Grid, PageId}, space}; crate::frame::Frame::sky()");
    assert_eq!(found, ["error", "Result", "voxel", "space", "frame"].map(str::to_owned));
}
