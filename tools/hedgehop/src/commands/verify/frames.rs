//! Whether the frames in a folder are whole, and those that its manifest lists.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use serde_json::{Value, json};

use crate::args::available_cores;
use crate::exit::{self, Failure, Outcome};
use crate::frame_ranges::ranges;
use crate::pictures;
use crate::progress::Reporter;
use hedgehop::encode::check::digest_of_whole;
use hedgehop::encode::sidecar::{FrameRecord, Manifest};
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// A frame, or a picture that may be one.
#[derive(Debug)]
struct Candidate {
    file: PathBuf,
    /// Number of the frame, if its entry or its name has one.
    number: Option<u64>,
    /// Hash that the manifest states.
    blake3: Option<String>,
}

/// Fault of one frame.
#[derive(Debug, PartialEq)]
struct Problem {
    file: PathBuf,
    number: Option<u64>,
    what: String,
}

/// Findings about a folder.
#[derive(Debug)]
struct FramesReport {
    checked: usize,
    /// Whether a manifest lists the frames.
    has_manifest: bool,
    problems: Vec<Problem>,
    /// Pictures that the manifest does not list.
    unlisted: usize,
    /// Numbers between the first and the last frame that no frame has.
    gaps: Vec<u64>,
}

/// Checks a folder, and says what was found.
pub fn run(folder: &Path, as_json: bool, reporter: &Reporter) -> Outcome {
    let report = check(folder, reporter)?;
    let text = if as_json { format!("{:#}\n", json(folder, &report)) } else { lines(folder, &report) };
    exit::print(&text)?;
    if report.problems.is_empty() { Ok(()) } else { Err(Failure::Problems) }
}

fn check(folder: &Path, observer: &dyn Observer) -> Result<FramesReport> {
    let manifest = Manifest::read(folder)?;
    let listed = manifest.as_ref().map(|manifest| manifest.frames.as_slice()).unwrap_or_default();
    let (candidates, unlisted) = candidates(folder, listed)?;
    let whats = each(&candidates, observer)?;
    let found = candidates.iter().zip(whats);
    let problems = found
        .filter_map(|(Candidate { file, number, .. }, what)| {
            Some(Problem { file: file.clone(), number: *number, what: what? })
        })
        .collect();
    Ok(FramesReport {
        checked: candidates.len(),
        has_manifest: manifest.is_some(),
        problems,
        unlisted,
        gaps: gaps(candidates.iter().filter_map(|candidate| candidate.number)),
    })
}

/// Frames that a manifest lists, and further frames in the folder; how many these are.
fn candidates(folder: &Path, listed: &[FrameRecord]) -> Result<(Vec<Candidate>, usize)> {
    let mut all: Vec<Candidate> = Vec::new();
    for record in listed {
        let Some(name) = &record.file else { continue };
        let (file, number) = (folder.join(name), Some(record.frame));
        all.push(Candidate { file, number, blake3: record.blake3.clone() });
    }

    let known: BTreeSet<PathBuf> = all.iter().map(|candidate| candidate.file.clone()).collect();

    let pictures = match pictures::in_folder(folder) {
        Ok(pictures) => pictures,
        // All that the manifest lists may be gone.
        Err(Error::Invalid { .. }) if !known.is_empty() => Vec::new(),
        Err(error) => return Err(error),
    };
    let is_frame = |path: &PathBuf| {
        let kind = path.extension().map(|kind| kind.to_string_lossy().to_ascii_lowercase());
        kind.is_some_and(|kind| kind == "png" || kind == "exr") && !known.contains(path)
    };
    let before = all.len();

    for file in pictures.into_iter().filter(is_frame) {
        let number = pictures::label(&file).parse().ok();
        // A map or a sheet beside the frames is none of them, and is checked where it is alone.
        if number.is_some() || listed.is_empty() {
            all.push(Candidate { file, number, blake3: None });
        }
    }

    if all.is_empty() {
        let what = "it holds no frames, which end in .png or .exr; name a folder that `render` wrote to";
        return Err(Error::invalid(folder, what));
    }

    let unlisted = if listed.is_empty() { 0 } else { all.len() - before };
    Ok((all, unlisted))
}

/// Checks each, in order; as many threads as cores decode them.
fn each(candidates: &[Candidate], observer: &dyn Observer) -> Result<Vec<Option<String>>> {
    let mut found: Vec<Mutex<Option<String>>> = Vec::new();
    found.resize_with(candidates.len(), Mutex::default);
    let (next, threads) = (AtomicUsize::new(0), available_cores().min(candidates.len()));
    observer.begin("frames", candidates.len() as u64, "frames");

    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while !observer.cancelled() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(candidate) = candidates.get(index) else { return };
                    *found[index].lock().unwrap_or_else(PoisonError::into_inner) = fault(candidate);
                    observer.advance(1);
                }
            });
        }
    });

    if observer.cancelled() {
        return Err(Error::Interrupted("not all frames were checked".into()));
    }

    observer.end();
    Ok(found.into_iter().map(|found| found.into_inner().unwrap_or_else(PoisonError::into_inner)).collect())
}

/// Says what is wrong with one.
fn fault(Candidate { file, blake3, .. }: &Candidate) -> Option<String> {
    if !file.is_file() {
        return Some("it is missing".to_owned());
    }
    match digest_of_whole(file) {
        Err(what) => Some(what),
        Ok(digest) if blake3.as_ref().is_some_and(|listed| *listed != digest) => {
            Some("it is whole, but not the file that the manifest lists".to_owned())
        }
        Ok(_) => None,
    }
}

/// Numbers that are left out between the first and the last, where steps of one are the rule.
fn gaps(numbers: impl Iterator<Item = u64>) -> Vec<u64> {
    let numbers: BTreeSet<u64> = numbers.collect();
    let (Some(first), Some(last)) = (numbers.first(), numbers.last()) else { return Vec::new() };
    let span = (last - first).saturating_add(1);
    // Every second or tenth frame of a flight has no gaps.
    if span / 2 >= numbers.len() as u64 {
        return Vec::new();
    }
    (*first..=*last).filter(|number| !numbers.contains(number)).collect()
}

impl FramesReport {
    /// Frames that are to be rendered again, as `--frames` takes them.
    fn again(&self) -> String {
        let numbers: BTreeSet<u64> = self.problems.iter().filter_map(|problem| problem.number).collect();
        ranges(&numbers.into_iter().collect::<Vec<_>>())
    }
}

fn lines(folder: &Path, report: &FramesReport) -> String {
    let mut text = String::new();
    for Problem { file, what, .. } in &report.problems {
        text += &format!("problem: {}: {what}\n", file.display());
    }
    if !report.gaps.is_empty() {
        text += &format!("note: there are no frames {}\n", ranges(&report.gaps));
    }
    if report.unlisted > 0 {
        let plural = if report.unlisted == 1 { " is" } else { "s are" };
        text += &format!("note: {} frame{plural} not listed in the manifest\n", report.unlisted);
    }

    let verdict = match (report.problems.len(), report.again()) {
        (0, _) => "sound".to_owned(),
        (count, again) if again.is_empty() => format!("{count} with problems"),
        (count, again) => format!("{count} with problems; render them again with --frames {again}"),
    };
    let beside = if report.has_manifest { "" } else { " (there is no manifest)" };
    text += &format!("{}: {} frames checked{beside}, {verdict}\n", folder.display(), report.checked);

    text
}

fn json(folder: &Path, report: &FramesReport) -> Value {
    let problem = |problem: &Problem| {
        json!({
            "frame": problem.number,
            "file": problem.file.display().to_string(),
            "what": problem.what,
        })
    };
    json!({
        "folder": folder.display().to_string(),
        "frames": report.checked,
        "manifest": report.has_manifest,
        "sound": report.problems.is_empty(),
        "problems": report.problems.iter().map(problem).collect::<Vec<_>>(),
        "render_again": report.again(),
        "unlisted": report.unlisted,
        "gaps": ranges(&report.gaps),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_told_where_steps_are_of_one() {
        let of = |numbers: &[u64]| gaps(numbers.iter().copied());
        assert_eq!(of(&[1, 2, 3, 5, 6, 9]), [4, 7, 8]);
        assert!(of(&[1, 11, 21, 31]).is_empty() && of(&[]).is_empty() && of(&[7]).is_empty());
        assert!(of(&[1, u64::MAX]).is_empty());
    }
}
