//! GNU parallel: chunks to as many processes as cores, here or over ssh.

use std::path::Path;

use super::{Call, Tasks, scripts};

/// Returns the command; what it tells of each chunk goes into a log.
///
/// The script is an argument, too: in the words of a command, `{}` and the like are taken for arguments.
pub fn run(tasks: &Tasks, place: &Path, at_once: usize) -> Call {
    let mut words: Vec<String> = ["parallel".into(), format!("--jobs={at_once}")].to_vec();
    words.push(format!("--joblog={}", place.join("logs").join("parallel.tsv").display()));
    words.extend(tasks.pass.iter().cloned());
    words.extend(["-q".into(), "sh".into()]);
    words.extend([":::".into(), place.join(scripts::CHUNK).display().to_string(), ":::".into()]);
    words.extend(tasks.chunks.iter().map(u64::to_string));
    Call::Wait(words)
}
