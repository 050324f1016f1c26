//! Processes on this machine, each of which works off one chunk after another.

use std::collections::VecDeque;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::Duration;

use super::Tasks;
use super::process::{ask_to_stop, hold};
use super::scripts::FINAL;
use crate::farm::job::{self, FarmJob};
use crate::farm::shell::named;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Time between looks at the processes.
const LOOK: Duration = Duration::from_millis(20);

/// A chunk that was given up, and how its last process ended.
#[derive(Debug)]
pub struct FailedChunk {
    /// Number of the chunk.
    pub number: u64,
    /// Clause about the end.
    pub what: String,
}

/// A chunk that waits for a process, or has one.
#[derive(Debug, Clone, Copy)]
struct Turn {
    number: u64,
    tries: u32,
}

/// Works off chunks; returns those that were given up.
///
/// # Errors
/// Another process does it already; no process can be started; an interruption, after which the processes have ended.
pub fn run(
    tasks: &Tasks,
    job: &FarmJob,
    folder: &Path,
    at_once: usize,
    observer: &dyn Observer,
) -> Result<Vec<FailedChunk>> {
    let _lock = hold(folder)?;
    let mut queue: VecDeque<Turn> =
        dearest_first(tasks, job).into_iter().map(|number| Turn { number, tries: 0 }).collect();
    let mut running = Running(Vec::new());
    let mut failed = Vec::new();

    observer.begin("farm", queue.len() as u64, "chunks");
    while !(queue.is_empty() && running.0.is_empty()) {
        if observer.cancelled() {
            running.stop();
            return Err(Error::Interrupted(format!(
                "finished frames are whole; go on with `hedgehop farm retry {}`",
                named(folder)
            )));
        }

        while running.0.len() < at_once
            && let Some(turn) = queue.pop_front()
        {
            running.0.push((turn, start(tasks, job, folder, turn.number)?));
        }

        for (turn, status) in running.ended()? {
            if status.success() {
                observer.advance(1);
                continue;
            }
            let code = status.code().and_then(|code| u8::try_from(code).ok());
            let is_final = code.is_some_and(|code| FINAL.contains(&code));
            if turn.tries < tasks.retries && !is_final {
                observer.note(&format!("chunk {}: {}; it is tried again", turn.number, said(status)));
                queue.push_back(Turn { tries: turn.tries + 1, ..turn });
            } else {
                failed.push(FailedChunk { number: turn.number, what: said(status) });
            }
        }
        sleep(LOOK);
    }
    observer.end();

    failed.sort_by_key(|chunk| chunk.number);
    Ok(failed)
}

/// Processes that run; none outlives it.
#[derive(Debug)]
struct Running(Vec<(Turn, Child)>);

impl Running {
    /// Takes out those that have ended.
    fn ended(&mut self) -> Result<Vec<(Turn, ExitStatus)>> {
        let mut ended = Vec::new();
        let mut at = 0;
        while at < self.0.len() {
            let (turn, child) = &mut self.0[at];
            match child.try_wait() {
                Ok(None) => at += 1,
                Ok(Some(status)) => {
                    ended.push((*turn, status));
                    self.0.swap_remove(at);
                }
                Err(error) => return Err(Error::io("hedgehop render", "wait for its end", error)),
            }
        }
        Ok(ended)
    }

    /// Asks all to stop after the frames in hand, and waits until they have.
    fn stop(&mut self) {
        self.0.iter_mut().for_each(|(_, child)| ask_to_stop(child));
        self.0.drain(..).for_each(|(_, mut child)| drop(child.wait()));
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Chunks that take longest first, so that none of them is alone at the end.
fn dearest_first(tasks: &Tasks, job: &FarmJob) -> Vec<u64> {
    let cost = |number: &u64| {
        let index = usize::try_from(*number).unwrap_or(usize::MAX).wrapping_sub(1);
        job.chunks.get(index).map_or(0.0, |chunk| chunk.predicted_s)
    };
    let mut numbers = tasks.chunks.clone();
    numbers.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
    numbers
}

fn start(tasks: &Tasks, job: &FarmJob, folder: &Path, number: u64) -> Result<Child> {
    let words = tasks.worker(job);
    let path = log(folder, number);
    let log = File::options().create(true).append(true).open(&path);
    let log = log.map_err(|error| Error::io(&path, "write it", error))?;
    let second = log.try_clone().map_err(|error| Error::io(&path, "write it", error))?;

    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).args(["--chunk", &number.to_string()]).current_dir(&job.folder);
    command.stdin(Stdio::null()).stdout(log).stderr(second);
    command.spawn().map_err(|error| Error::io(&words[0], "start a worker", error))
}

/// Returns the file that the workers of a chunk write to.
pub fn log(folder: &Path, number: u64) -> PathBuf {
    job::logs(folder).join(format!("{number}.log"))
}

fn said(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("its process ended with {code}"),
        None => "its process was killed".to_owned(),
    }
}
