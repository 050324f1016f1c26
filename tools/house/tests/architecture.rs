//! Holds the layers of ARCHITECTURE.md against the code: who may import whom, and who may know what.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use hedgehop_house::circles;
use hedgehop_house::imports::{Outward, arrows, outward};
use hedgehop_house::sources::{Target, targets};

/// Rooms of the engine that database modelling may use: it makes what the rest flies over, and renders nothing. Patterns matched from fine imagery are
/// relative to what detail makes of posts.
const MODELING_MAY_USE: [&str; 7] =
    ["src/space", "src/earth", "src/simd", "src/voxel", "src/detail", "src/sunlight", "src/flight"];

/// The only files with unsafe code; each says why.
const UNSAFE_FILES: [&str; 5] = [
    "src/memory/guard.rs",
    "src/memory/page_file.rs",
    "src/simd/avx2.rs",
    "src/simd/avx512.rs",
    "src/simd/neon.rs",
];

/// Lines of a file beyond which a test warns: by then it mostly holds more than one concept.
const MANY_LINES: usize = 500;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The layers, lowest first, each of one room or several: the block after "## Layers" in ARCHITECTURE.md.
fn layers() -> Vec<Vec<String>> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let section = text.split("## Layers").nth(1).expect("a section on layers");
    let block = section.split("```").nth(1).expect("a block of layers");
    let rooms = |line: &str| {
        let names = line.split("  ").next().unwrap_or_default();
        names.split(", ").map(|name| name.trim().to_owned()).collect()
    };
    block.lines().skip(1).filter(|line| !line.trim().is_empty()).map(rooms).collect()
}

/// The room of a file: a folder of `src`, or a crate.
fn room_of(path: &Path) -> String {
    let mut parts = path.components().map(|part| part.as_os_str().to_string_lossy().into_owned());
    let (first, second) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    format!("{first}/{}", second.trim_end_matches(".rs"))
}

/// The room that a path leads to, from a file of the engine or from outside; `None` where it is none of a layer's.
fn room_meant(path: &[String], is_engine: bool) -> Option<String> {
    let second = path.get(1).map(String::as_str).unwrap_or_default();
    match path[0].as_str() {
        "crate" if is_engine => Some(format!("src/{second}")),
        "hedgehop" => Some(format!("src/{second}")),
        own => own.strip_prefix("hedgehop_").map(|name| format!("crates/{name}")),
    }
}

/// A library or program as the tests ask for it: syntax trees cannot be shared among their threads.
struct Reading {
    /// Name by which other crates import it.
    name: String,
    is_engine: bool,
    is_library: bool,
    files: Vec<FileText>,
    /// Paths that each file takes from other crates or rooms, by its number.
    outward: Vec<(usize, Outward)>,
    /// Files of each circle of imports.
    circles: Vec<Vec<PathBuf>>,
}

struct FileText {
    path: PathBuf,
    is_test: bool,
    text: String,
    /// Text without comments: what is said about code is not code.
    code: String,
}

/// All targets, parsed once for all tests.
static READINGS: LazyLock<Vec<Reading>> =
    LazyLock::new(|| targets(&root()).into_iter().map(Reading::of).collect());

impl Reading {
    fn of(target: Target) -> Self {
        let circles = circles::of_files(&target, &arrows(&target));
        let outward = outward(&target);
        let is_engine = target.folder.as_os_str().is_empty();
        let files = target.files.into_iter().map(|file| FileText {
            code: code(&file.text),
            path: file.path,
            is_test: file.is_test,
            text: file.text,
        });
        Self {
            name: target.name,
            is_engine,
            is_library: is_engine || target.folder.starts_with("crates"),
            files: files.collect(),
            outward,
            circles: circles.into_iter().map(|circle| circle.rooms).collect(),
        }
    }
}

fn libraries() -> impl Iterator<Item = &'static Reading> {
    READINGS.iter().filter(|target| target.is_library)
}

#[test]
fn imports_point_downward() {
    let layers = layers();
    let layer = |room: &str| layers.iter().position(|rooms| rooms.iter().any(|name| name == room));
    assert!(layer("src/voxel") < layer("src/render") && layer("crates/base") == Some(0), "{layers:?}");
    for target in libraries() {
        for (number, paths) in &target.outward {
            let file = &target.files[*number];
            let room = room_of(&file.path);
            if file.path == Path::new("src/lib.rs") || room == "crates/testing" {
                continue;
            }

            let own =
                layer(&room).unwrap_or_else(|| panic!("{}: give `{room}` a layer", file.path.display()));
            for path in paths {
                let Some(meant) = room_meant(path, target.is_engine) else { continue };
                let Some(other) = layer(&meant).filter(|_| meant != room) else { continue };
                let is_ours = room != "crates/modeling"
                    || !meant.starts_with("src/")
                    || MODELING_MAY_USE.contains(&meant.as_str());
                assert!(
                    other < own && is_ours,
                    "{}: `{room}` must not import `{meant}` ({})",
                    file.path.display(),
                    path.join("::")
                );
            }
        }
    }
}

#[test]
fn no_file_imports_in_a_circle() {
    for target in &*READINGS {
        assert!(target.circles.is_empty(), "{}: {:?} import each other", target.name, target.circles);
    }
}

/// Paths in a row of a table: what links lead to, and names in backticks that have a slash or end like a file.
fn paths_in(row: &str) -> Vec<&str> {
    let links = row.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let is_path = |name: &&str| {
        !name.contains(' ')
            && (name.contains('/') || [".rs", ".md", ".py"].iter().any(|end| name.ends_with(end)))
    };
    links.chain(row.split('`').skip(1).step_by(2).filter(is_path)).collect()
}

#[test]
fn tables_name_files_that_exist() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let mut count = 0;
    for row in text.lines().filter(|line| line.starts_with('|')) {
        // A bare name is a file beside the path before it, or in that folder.
        let mut folder = root();
        for name in paths_in(row) {
            let path = if name.contains('/') { root().join(name) } else { folder.join(name) };
            let path = if path.exists() { path } else { root().join(name) };
            assert!(path.exists(), "ARCHITECTURE.md names {name}, which is not there: {row}");
            folder = if path.is_dir() { path } else { path.parent().map(Path::to_owned).unwrap_or_default() };
            count += 1;
        }
    }
    assert!(count > 40, "{count} paths");
}

/// Source without comments: what is said about code is not code.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Code before its unit tests, if they stand in the same file.
fn without_tests(file: &FileText) -> &str {
    file.code.split("#[cfg(test)]\nmod tests {").next().unwrap_or(&file.code)
}

#[test]
fn only_subimage_knows_rayon() {
    for target in libraries() {
        for file in &target.files {
            assert!(
                room_of(&file.path) == "src/subimage" || !file.code.contains("rayon"),
                "{}: rayon belongs in src/subimage alone",
                file.path.display()
            );
        }
    }
}

#[test]
fn the_library_neither_prints_nor_exits_nor_parses_arguments() {
    let forbidden =
        ["println!", "eprintln!", "print!(", "eprint!(", "dbg!(", "process::exit", "clap", "indicatif"];
    for target in libraries().filter(|target| target.name != "hedgehop_testing") {
        for file in target.files.iter().filter(|file| !file.is_test) {
            for word in forbidden {
                let is_there = without_tests(file).contains(word);
                assert!(!is_there, "{}: `{word}` belongs in tools/", file.path.display());
            }
        }
    }
}

#[test]
fn unsafe_stands_only_in_the_files_that_declare_why() {
    for file in READINGS.iter().flat_map(|target| &target.files) {
        let name = file.path.to_string_lossy().replace('\\', "/");
        let code = &file.code;
        if UNSAFE_FILES.contains(&name.as_str()) {
            let squeezed: String = code.split_whitespace().collect();
            assert!(squeezed.contains("expect(unsafe_code,reason="), "{name}: say why it is unsafe");
            assert!(file.text.contains("SAFETY"), "{name}: write the contract down");
        } else {
            let words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            assert!(
                words.into_iter().all(|word| word != "unsafe"),
                "{name}: unsafe code outside {UNSAFE_FILES:?}"
            );
        }
    }
}

/// A long file is no fault, but a place to look whether it holds one concept.
#[test]
fn long_files_are_told() {
    use std::io::Write;
    for file in READINGS.iter().flat_map(|target| &target.files) {
        let lines = file.text.lines().count();
        if lines > MANY_LINES {
            // Written past the test harness, which swallows what passing tests print.
            let _ = writeln!(std::io::stderr(), "{}: {lines} lines; one concept?", file.path.display());
        }
    }
}
