//! Whether the frames in a folder are whole, and those that a job or its manifest lists.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::frame_ranges::ranges;
use crate::pictures;
use crate::side_by_side::side_by_side;
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
    /// Hash that is stated of it.
    blake3: Option<String>,
    /// Whether anybody finished it.
    is_finished: bool,
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
pub struct FramesReport {
    checked: usize,
    /// Source of the list of frames; `None`: there is none.
    listed_by: Option<&'static str>,
    problems: Vec<Problem>,
    /// Pictures that are not listed.
    unlisted: usize,
    /// Numbers between the first and the last frame that no frame has.
    gaps: Vec<u64>,
}

/// Frame that ought to be in a folder.
#[derive(Debug, Clone)]
pub struct ExpectedFrame {
    /// Absolute number, 1…
    pub number: u64,
    /// Name of the file; `None`: nobody has finished it.
    pub file: Option<String>,
    /// BLAKE3 of the file, hexadecimal, if that is known.
    pub blake3: Option<String>,
}

/// Checks a folder against what a job expects in it, or else against its manifest.
pub fn check(
    folder: &Path,
    job: Option<Vec<ExpectedFrame>>,
    observer: &dyn Observer,
) -> Result<FramesReport> {
    let manifest = if job.is_some() { None } else { Manifest::read(folder)? };
    let (listed_by, listed) = match (job, manifest) {
        (Some(job), _) => (Some("job"), job),
        (None, Some(manifest)) => (Some("manifest"), manifest.frames.iter().map(expected).collect()),
        (None, None) => (None, Vec::new()),
    };
    let (candidates, unlisted) = candidates(folder, &listed)?;
    let whats = each(&candidates, listed_by.unwrap_or("folder"), observer)?;
    let found = candidates.iter().zip(whats);
    let problems = found
        .filter_map(|(Candidate { file, number, .. }, what)| {
            Some(Problem { file: file.clone(), number: *number, what: what? })
        })
        .collect();
    Ok(FramesReport {
        checked: candidates.len(),
        listed_by,
        problems,
        unlisted,
        gaps: gaps(candidates.iter().filter_map(|candidate| candidate.number)),
    })
}

fn expected(record: &FrameRecord) -> ExpectedFrame {
    ExpectedFrame { number: record.frame, file: record.file.clone(), blake3: record.blake3.clone() }
}

/// Frames that are listed, and further frames in the folder; how many these are.
fn candidates(folder: &Path, listed: &[ExpectedFrame]) -> Result<(Vec<Candidate>, usize)> {
    let place = |frame: &ExpectedFrame| match &frame.file {
        Some(name) => folder.join(name),
        None => folder.to_owned(),
    };
    let mut all: Vec<Candidate> = listed
        .iter()
        .map(|frame| Candidate {
            file: place(frame),
            number: Some(frame.number),
            blake3: frame.blake3.clone(),
            is_finished: frame.file.is_some(),
        })
        .collect();

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
            all.push(Candidate { file, number, blake3: None, is_finished: true });
        }
    }

    if all.is_empty() {
        let what = "it holds no frames, which end in .png or .exr; name a folder that `render` wrote to";
        return Err(Error::invalid(folder, what));
    }

    let unlisted = if listed.is_empty() { 0 } else { all.len() - before };
    Ok((all, unlisted))
}

/// Checks each, in order.
fn each(candidates: &[Candidate], listed_by: &str, observer: &dyn Observer) -> Result<Vec<Option<String>>> {
    observer.begin("frames", candidates.len() as u64, "frames");
    let found = side_by_side(candidates.len(), observer, &|index| fault(&candidates[index], listed_by));
    observer.end();
    found.ok_or_else(|| Error::Interrupted("not all frames were checked".into()))
}

/// Says what is wrong with one.
fn fault(Candidate { file, blake3, is_finished, number }: &Candidate, listed_by: &str) -> Option<String> {
    if !is_finished {
        return Some(format!("frame {} was never finished", number.unwrap_or_default()));
    }
    if !file.is_file() {
        return Some("it is missing".to_owned());
    }
    match digest_of_whole(file) {
        Err(what) => Some(format!("it does not decode to its end: {}", what.trim_end_matches('.'))),
        Ok(digest) if blake3.as_ref().is_some_and(|listed| *listed != digest) => {
            Some(format!("it is whole, but not the file that the {listed_by} lists"))
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
    /// Whether nothing is wrong.
    pub fn is_sound(&self) -> bool {
        self.problems.is_empty()
    }

    /// Returns the numbers of frames that are to be rendered again, rising.
    pub fn numbers(&self) -> Vec<u64> {
        let numbers: BTreeSet<u64> = self.problems.iter().filter_map(|problem| problem.number).collect();
        numbers.into_iter().collect()
    }

    /// Frames that are to be rendered again, as `--frames` takes them.
    fn again(&self) -> String {
        ranges(&self.numbers())
    }
}

/// Says what was found, for people.
pub fn lines(folder: &Path, report: &FramesReport) -> String {
    let mut text = String::new();
    for Problem { file, what, .. } in &report.problems {
        text += &format!("problem: {}: {what}\n", file.display());
    }
    if !report.gaps.is_empty() {
        text += &format!("note: there are no frames {}\n", ranges(&report.gaps));
    }
    if report.unlisted > 0 {
        let plural = if report.unlisted == 1 { " is" } else { "s are" };
        let list = report.listed_by.unwrap_or("folder");
        text += &format!("note: {} frame{plural} not listed in the {list}\n", report.unlisted);
    }

    let verdict = match (report.problems.len(), report.again()) {
        (0, _) => "sound".to_owned(),
        (count, again) if again.is_empty() => format!("{count} with problems"),
        (count, again) if report.listed_by == Some("job") => {
            format!(
                "{count} with problems; --repair renders them again, as render does with --frames {again}"
            )
        }
        (count, again) => format!("{count} with problems; render them again with --frames {again}"),
    };
    let beside = if report.listed_by.is_some() { "" } else { " (there is no manifest)" };
    text += &format!("{}: {} frames checked{beside}, {verdict}\n", folder.display(), report.checked);

    text
}

/// Returns what was found as JSON.
pub fn json(folder: &Path, report: &FramesReport) -> Value {
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
        "manifest": report.listed_by == Some("manifest"),
        "job": report.listed_by == Some("job"),
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
