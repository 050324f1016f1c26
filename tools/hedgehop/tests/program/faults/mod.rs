//! Faults injected into files, disks and processes: every run ends with what an undisturbed one gives, or with a sentence and a documented
//! code; no panic, no hang, no pixel that is silently wrong.
//!
//! `HEDGEHOP_INJECTIONS` says how many (default: few), `HEDGEHOP_SEED` which; `HEDGEHOP_MOUNT=1` adds those that mount file systems,
//! which takes root. `HEDGEHOP_FAULTS_REPORT` names a file for the counts by kind and outcome (docs/reliability.md).
#![cfg(unix)]

mod at_rest;
mod disks;
mod in_flight;
mod random;
mod site;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use random::Random;
use site::{Site, frames_in, stderr};

/// Injections of a usual test run.
const FEW: usize = 64;

/// How a run ended that did nothing wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// All of what an undisturbed run gives.
    Same,
    /// An error with this code and a sentence that names the file.
    Refused(i32),
    /// Coarser levels stood in, which was asked for and is said.
    StoodIn,
    /// A sound database of an input that reads differently.
    OtherInput,
    /// It was killed, left nothing half under a final name, and a second run gave what an undisturbed one gives.
    Recovered,
}

impl Outcome {
    fn name(self) -> String {
        match self {
            Self::Same => "same bytes".into(),
            Self::Refused(code) => format!("error, code {code}"),
            Self::StoodIn => "coarser level, said so".into(),
            Self::OtherInput => "sound, of other input".into(),
            Self::Recovered => "killed; second run same bytes".into(),
        }
    }
}

/// What a run did that it must not do, in words.
pub type Verdict = Result<Outcome, String>;

/// A kind of fault.
struct Kind {
    name: &'static str,
    inject: fn(&Site, &mut Random) -> Verdict,
    /// It mounts file systems.
    mounts: bool,
}

const KINDS: [Kind; 16] = [
    Kind { name: "bit flips, `render`", inject: at_rest::flips_rendered, mounts: false },
    Kind { name: "bit flips, `verify`", inject: at_rest::flips_verified, mounts: false },
    Kind {
        name: "blocks of 4096 lost or swapped, `render`",
        inject: at_rest::blocks_rendered,
        mounts: false,
    },
    Kind {
        name: "bit flips in pages, `render --damaged coarser`",
        inject: at_rest::flips_left_out,
        mounts: false,
    },
    Kind { name: "truncated or lengthened file", inject: at_rest::resized, mounts: false },
    Kind { name: "damaged elevation, `build`", inject: at_rest::inputs, mounts: false },
    Kind { name: "damaged path, `render`", inject: at_rest::paths, mounts: false },
    Kind { name: "database truncated under `render`", inject: in_flight::truncated, mounts: false },
    Kind { name: "database written anew under `render`", inject: in_flight::rewritten, mounts: false },
    Kind { name: "`render` killed", inject: in_flight::render_killed, mounts: false },
    Kind { name: "`build` killed", inject: in_flight::build_killed, mounts: false },
    Kind { name: "second `build` of a recipe killed", inject: in_flight::update_killed, mounts: false },
    Kind { name: "file size limit reached", inject: disks::limited, mounts: false },
    Kind { name: "full disk (small tmpfs)", inject: disks::full, mounts: true },
    Kind { name: "hole of a file on a full tmpfs", inject: disks::holed, mounts: true },
    Kind { name: "failing disk (EIO under ext4)", inject: disks::failing, mounts: true },
];

/// The exit code if the run ended in one of the ways that are allowed: with one of `codes`, and unless it is 0, with a sentence that names `file`.
pub fn ended(output: &Output, codes: &[i32], file: &str) -> Result<i32, String> {
    let said = stderr(output);
    let Some(code) = output.status.code() else {
        return Err(format!("died or hung: {:?}: {said}", output.status));
    };
    if !codes.contains(&code) || said.contains("panicked") {
        return Err(format!("code {code}: {said}"));
    }
    if code != 0 && !said.lines().any(|line| line.starts_with("error: ") && line.contains(file)) {
        return Err(format!("code {code}, but no sentence names {file}: {said}"));
    }
    Ok(code)
}

/// Whether the frames of a folder are those of an undisturbed run, all of them or some.
pub fn frames_are_right(site: &Site, folder: &Path, all: bool) -> Result<(), String> {
    let found = frames_in(folder);
    for (name, bytes) in &found {
        if site.frames.get(name) != Some(bytes) {
            return Err(format!("frame {name} differs from that of an undisturbed run"));
        }
    }
    let missing = site.frames.len() - found.len();
    if all && missing > 0 { Err(format!("{missing} frames are missing")) } else { Ok(()) }
}

fn setting(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

fn number(name: &str, default: u64) -> u64 {
    setting(name)
        .map_or(default, |value| value.parse().unwrap_or_else(|_| panic!("{name}: no number: {value}")))
}

/// Counts by kind and outcome, as a table.
fn table(counts: &BTreeMap<(usize, Outcome), usize>) -> String {
    let mut text = String::from("| fault | injections | outcomes |\n|---|---:|---|\n");
    let mut total = 0;
    for (index, kind) in KINDS.iter().enumerate() {
        let of_kind: Vec<_> = counts.iter().filter(|((of, _), _)| *of == index).collect();
        let injections: usize = of_kind.iter().map(|(_, count)| **count).sum();
        let outcomes: Vec<String> =
            of_kind.iter().map(|((_, outcome), count)| format!("{}: {count}", outcome.name())).collect();
        total += injections;
        let _ = writeln!(text, "| {} | {injections} | {} |", kind.name, outcomes.join("; "));
    }
    let _ = writeln!(text, "| all | {total} | |");
    text
}

#[test]
fn no_fault_ends_in_a_panic_a_hang_or_a_wrong_picture() {
    let site = Site::new();
    let (seed, mounts) = (number("HEDGEHOP_SEED", 1), setting("HEDGEHOP_MOUNT").is_some());
    let kinds: Vec<usize> = (0..KINDS.len()).filter(|index| mounts || !KINDS[*index].mounts).collect();
    let mut counts = BTreeMap::new();
    let mut breaches = Vec::new();
    for injection in 0..number("HEDGEHOP_INJECTIONS", FEW as u64) {
        let kind = kinds[injection as usize % kinds.len()];
        let mut random = Random(seed.wrapping_mul(1_000_003).wrapping_add(injection));
        match (KINDS[kind].inject)(&site, &mut random) {
            Ok(outcome) => *counts.entry((kind, outcome)).or_insert(0) += 1,
            Err(breach) => breaches.push(format!("injection {injection}, {}: {breach}", KINDS[kind].name)),
        }
    }
    if let Some(report) = setting("HEDGEHOP_FAULTS_REPORT") {
        std::fs::write(report, table(&counts) + &breaches.join("\n")).expect("the report is written");
    }
    assert!(breaches.is_empty(), "{} breaches:\n{}", breaches.len(), breaches.join("\n"));
}
