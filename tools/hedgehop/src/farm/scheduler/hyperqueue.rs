//! HyperQueue: one array of tasks.

use std::path::Path;

use super::{Call, Tasks, scripts};
use crate::frame_ranges::ranges;

/// Cores of the task that waits for the others, of which nearly nothing is needed.
const WAITING: &str = "0.01";

/// Returns the command of the array.
pub fn array(tasks: &Tasks, place: &Path) -> Call {
    let mut words = common(place);
    words.push(format!("--array={}", ranges(&tasks.chunks)));
    words.push(format!("--cpus={}", tasks.cores));
    words.extend(tasks.pass.iter().cloned());
    words.extend(["--".into(), "sh".into(), place.join(scripts::CHUNK).display().to_string()]);
    Call::Submit(words)
}

/// Returns the command of a task that waits until these jobs have ended, however they did, and then ends the job.
///
/// Dependencies within one job would keep it from running if a chunk failed.
pub fn finish(place: &Path, ids: &[String]) -> Vec<String> {
    let mut words = common(place);
    words.push(format!("--cpus={WAITING}"));
    words.extend(["--".into(), "sh".into(), place.join(scripts::FINISH).display().to_string()]);
    words.extend(ids.iter().cloned());
    words
}

/// Words that all jobs share. Scripts go to their own folder, and write logs of their own.
fn common(place: &Path) -> Vec<String> {
    let name = place.file_name().unwrap_or(place.as_os_str()).to_string_lossy().into_owned();
    let mut words: Vec<String> = ["hq", "submit", "--output-mode=quiet"].map(String::from).to_vec();
    words.push(format!("--name={name}"));
    words.extend(["--cwd=/", "--stdout=none", "--stderr=none", "--directives=off"].map(String::from));
    words
}
