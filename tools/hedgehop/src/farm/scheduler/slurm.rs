//! Slurm: job arrays of chunks, and a job that waits for them.

use std::path::Path;
use std::process::Command;

use super::{Call, Tasks, scripts};
use crate::frame_ranges::ranges;
use hedgehop::{Error, Result};

/// Indices that an array may have where the site does not say so: 0 to one less.
pub const USUAL_LIMIT: u64 = 1001;
const MIB: u64 = 1 << 20;

/// Returns the arrays, whose indices stay below `limit`; the number of a chunk is the index and an offset.
pub fn arrays(tasks: &Tasks, place: &Path, limit: u64) -> Vec<Call> {
    let span = limit.max(2);
    let mut groups: Vec<(u64, Vec<u64>)> = Vec::new();
    for &number in &tasks.chunks {
        let offset = number / span * span;
        match groups.last_mut() {
            Some((of, numbers)) if *of == offset => numbers.push(number - offset),
            _ => groups.push((offset, vec![number - offset])),
        }
    }

    let array = |(offset, numbers): (u64, Vec<u64>)| {
        let at_once = tasks.at_once.map_or_else(String::new, |count| format!("%{count}"));
        let mut words = common(place);
        words.push(format!("--array={}{at_once}", ranges(&numbers)));
        words.push("--requeue".into());
        words.push(format!("--export=ALL,HEDGEHOP_CHUNK_OFFSET={offset}"));
        words.extend(resources(tasks));
        words.push(place.join(scripts::CHUNK).display().to_string());
        Call::Submit(words)
    };
    groups.into_iter().map(array).collect()
}

/// Returns the command of a job that runs once these have ended, however they did.
pub fn finish(tasks: &Tasks, place: &Path, ids: &[String]) -> Vec<String> {
    let mut words = common(place);
    words.push(format!("--dependency=afterany:{}", ids.join(":")));
    words.extend(resources(tasks));
    words.push(place.join(scripts::FINISH).display().to_string());
    words
}

/// Words about what a task takes, and the user's own.
fn resources(tasks: &Tasks) -> Vec<String> {
    let mut words = vec![format!("--cpus-per-task={}", tasks.cores)];
    words.extend(tasks.memory_asked().map(|bytes| format!("--mem={}M", bytes.div_ceil(MIB))));
    words.extend(tasks.pass.iter().cloned());
    words
}

/// Words that all jobs share. Scripts go to their own folder, and write logs of their own.
fn common(place: &Path) -> Vec<String> {
    let name = place.file_name().unwrap_or(place.as_os_str()).to_string_lossy().into_owned();
    // Slurm takes a percent sign in a name for one of its own.
    let output = place.join("logs").display().to_string().replace('%', "%%");
    let output = format!("--output={output}/slurm-%A.log");
    let name = format!("--job-name={name}");
    let folder = format!("--chdir={}", place.display());
    vec!["sbatch".into(), "--parsable".into(), name, folder, "--open-mode=append".into(), output]
}

/// Returns how large an index of an array may be here, plus one.
///
/// # Errors
/// Slurm does not answer.
pub fn limit() -> Result<u64> {
    let output = Command::new("scontrol")
        .args(["show", "config"])
        .output()
        .map_err(|error| Error::io("scontrol", "ask Slurm for its configuration", error))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.strip_prefix("MaxArraySize"));
    Ok(line.and_then(|rest| rest.trim_start_matches([' ', '=']).trim().parse().ok()).unwrap_or(USUAL_LIMIT))
}
