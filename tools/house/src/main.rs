//! Prints the figures of a review: `cargo run -p hedgehop-house`, with `--list WORD` the places behind one of them.

use std::path::Path;

use hedgehop_house::circles::{self, Circle};
use hedgehop_house::prose::Prose;
use hedgehop_house::sources::{Target, targets};
use hedgehop_house::{imports, names};

/// A place in the code, and what is there.
type Place = (String, usize, String);

#[expect(clippy::print_stdout, reason = "the program's purpose")]
fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let wanted = arguments.iter().position(|word| word == "--list").and_then(|at| arguments.get(at + 1));
    let targets = targets(&root);
    match wanted {
        None => figures(&root, &targets).iter().for_each(|line| println!("{line}")),
        Some(what) => list(&targets, what).iter().for_each(|line| println!("{line}")),
    }
}

/// Reads all files, those for tests or the others.
fn prose(targets: &[Target], is_test: bool) -> Prose {
    let mut prose = Prose::default();
    let files = targets.iter().flat_map(|target| &target.files).filter(|file| file.is_test == is_test);
    files.for_each(|file| prose.read(file));
    prose
}

fn figures(root: &Path, targets: &[Target]) -> Vec<String> {
    let share = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
    let mut lines = Vec::new();
    for (is_test, of) in [(false, "code"), (true, "tests beside it")] {
        let p = prose(targets, is_test);
        lines.push(format!("{of}:"));
        lines.push(format!(
            "  doc comments that lean on something else: {} of {} ({:.1} %)",
            p.leaning.len(),
            p.docs,
            share(p.leaning.len(), p.docs)
        ));

        lines.push(format!(
            "  functions over 30 lines without a paragraph: {} of {} ({:.1} %); over 60 lines: {} of {} ({:.1} %)",
            p.walls.len(),
            p.large,
            share(p.walls.len(), p.large),
            p.long.len(),
            p.functions,
            share(p.long.len(), p.functions)
        ));

        lines.push(format!(
            "  functions with tuples as parameters: {} ({:.1} %)",
            p.tuples.len(),
            share(p.tuples.len(), p.functions)
        ));
        lines.push(format!(
            "  bodies: {} lines, {} blank, {} comments",
            p.body_lines, p.blank_lines, p.comments
        ));
    }

    for target in targets {
        let types = names::types(target);
        let all: usize = types.values().map(Vec::len).sum();
        let twice: usize = types.values().map(Vec::len).filter(|count| *count > 1).sum();
        let arrows = imports::arrows(target);
        let code: usize =
            target.files.iter().filter(|file| !file.is_test).map(|file| file.text.lines().count()).sum();
        let tests: usize =
            target.files.iter().filter(|file| file.is_test).map(|file| file.text.lines().count()).sum();

        lines.push(format!(
            "{}: {code} lines and {tests} of tests in {} files; {all} types, {:.1} % of a name that is not theirs alone; {} public names; \
             circles of files {}, of folders {}",
            target.name,
            target.files.len(),
            share(twice, all),
            names::public(target).len(),
            circles::of_files(target, &arrows).len(),
            circles::of_folders(target, &arrows).len(),
        ));
    }

    let docs =
        ["README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|file| root.join(file));
    let more = std::fs::read_dir(root.join("docs")).into_iter().flatten().flatten().map(|entry| entry.path());
    for path in docs.into_iter().chain(more).filter(|path| path.extension().is_some_and(|kind| kind == "md"))
    {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        lines.push(format!("{name}: {} words", text.split_whitespace().count()));
    }

    lines
}

fn list(targets: &[Target], what: &str) -> Vec<String> {
    let code = prose(targets, false);
    let places = |places: &[Place]| {
        places.iter().map(|(path, line, text)| format!("{path}:{line}: {text}")).collect::<Vec<_>>()
    };

    match what {
        "docs" => places(&code.leaning),
        "walls" => places(&code.walls),
        "long" => places(&code.long),
        "tuples" => places(&code.tuples),
        "public" => {
            let of = |target: &Target| {
                let name = target.name.clone();
                names::public(target).into_iter().map(move |path| format!("{name}::{path}"))
            };
            targets.iter().flat_map(of).collect()
        }
        "types" => {
            let twice = targets.iter().flat_map(|target| {
                let types = names::types(target).into_iter().filter(|(_, files)| files.len() > 1);
                types.map(|(name, files)| format!("{} {name}: {}", target.name, files.join(" ")))
            });
            twice.collect()
        }
        "circles" => {
            let all = targets.iter().flat_map(|target| {
                let arrows = imports::arrows(target);
                let files = circles::of_files(target, &arrows);
                files.into_iter().chain(circles::of_folders(target, &arrows))
            });
            all.flat_map(|circle| described(&circle)).collect()
        }
        _ => vec!["one of: docs, walls, long, tuples, types, public, circles".to_owned()],
    }
}

fn described(circle: &Circle) -> Vec<String> {
    let rooms: Vec<String> = circle.rooms.iter().map(|room| room.display().to_string()).collect();
    let mut lines = vec![format!("circle of {}: {}", rooms.len(), rooms.join(" "))];
    for (from, to, names) in &circle.ties {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        lines.push(format!("    {} -> {}: {}", from.display(), to.display(), names.join(", ")));
    }
    lines
}
