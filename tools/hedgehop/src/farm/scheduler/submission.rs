//! Scripts in the job's folder and commands by which a scheduler gets chunks; printed, or run.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use super::process::{ask_to_stop, hold};
use super::{Call, Scheduler, Tasks, hyperqueue, openjd, parallel, scripts, slurm};
use crate::farm::job::FarmJob;
use crate::farm::shell::{named, quoted};
use hedgehop::encode::atomic::write_bytes;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Time between looks at a command that runs.
const LOOK: Duration = Duration::from_millis(50);

/// Scripts and commands by which a scheduler gets chunks.
#[derive(Debug)]
pub struct Submission {
    engine: Scheduler,
    tasks: Tasks,
    place: PathBuf,
    files: Vec<(&'static str, String)>,
    calls: Vec<Call>,
}

impl Submission {
    /// Puts together what `engine` needs; `at_once` bounds the processes of this machine. `limit` is how long Slurm's arrays may be.
    pub fn new(engine: Scheduler, tasks: &Tasks, job: &FarmJob, at_once: usize, limit: Option<u64>) -> Self {
        let place = job.folder.join(&job.place);
        let mut files = vec![
            (scripts::CHUNK, scripts::chunk(tasks, job)),
            (scripts::FINISH, scripts::finish(tasks, job)),
        ];
        let calls = match engine {
            Scheduler::Local => Vec::new(),
            Scheduler::Parallel => vec![parallel::run(tasks, &place, at_once)],
            Scheduler::Hyperqueue => vec![hyperqueue::array(tasks, &place)],
            Scheduler::Slurm => slurm::arrays(tasks, &place, limit.unwrap_or(slurm::USUAL_LIMIT)),
            Scheduler::Openjd => {
                files.push((openjd::TEMPLATE, openjd::template(tasks, &place)));
                vec![openjd::run(tasks, &place)]
            }
        };
        Self { engine, tasks: tasks.clone(), place, files, calls }
    }

    /// Asks the scheduler what bounds its arrays, if it has a bound.
    pub fn limit(engine: Scheduler) -> Result<Option<u64>> {
        if engine == Scheduler::Slurm { slurm::limit().map(Some) } else { Ok(None) }
    }

    /// Prints scripts and commands as a shell would run them.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (name, content) in &self.files {
            text += &format!("# {}\n{content}\n", self.place.join(name).display());
        }
        if self.engine == Scheduler::Local {
            text.extend(self.tasks.chunks.iter().map(|number| self.line(*number)));
        }

        let mut ids = Vec::new();
        for call in &self.calls {
            let line = quoted(call.words());
            text += &match call {
                Call::Wait(_) => format!("{line}\n"),
                Call::Submit(_) => {
                    ids.push(format!("$id{}", ids.len() + 1));
                    format!("id{}=$({line})\n", ids.len())
                }
            };
        }
        text + &self.last_line(&ids)
    }

    /// The command of one chunk.
    fn line(&self, number: u64) -> String {
        let script = self.place.join(scripts::CHUNK).display().to_string();
        quoted(&["sh".into(), script, number.to_string()]) + "\n"
    }

    /// The command that ends the job once those of these names have ended; `None` of one whose commands wait.
    fn finish(&self, ids: &[String]) -> Option<Vec<String>> {
        match self.engine {
            Scheduler::Slurm => Some(slurm::finish(&self.tasks, &self.place, ids)),
            Scheduler::Hyperqueue => Some(hyperqueue::finish(&self.place, ids)),
            Scheduler::Local | Scheduler::Parallel | Scheduler::Openjd => None,
        }
    }

    /// The command that ends the job, as a shell would run it.
    fn last_line(&self, ids: &[String]) -> String {
        let script = self.place.join(scripts::FINISH).display().to_string();
        match self.finish(ids) {
            // Names of variables are to be read by the shell.
            Some(words) => words.iter().map(|word| unquoted(word, ids)).collect::<Vec<_>>().join(" ") + "\n",
            None => quoted(&["sh".into(), script]) + "\n",
        }
    }

    /// Writes the scripts into the job's folder.
    pub fn write(&self) -> Result<()> {
        for (name, content) in &self.files {
            let path = self.place.join(name);
            write_bytes(&path, content.as_bytes())?;
            make_executable(&path)?;
        }
        Ok(())
    }

    /// Runs the commands; returns the names of what was submitted, which `keep` gets as they come.
    ///
    /// # Errors
    /// A command cannot be started, or refuses; an interruption.
    pub fn run(
        &self,
        keep: &dyn Fn(&[String]) -> Result<()>,
        observer: &dyn Observer,
    ) -> Result<Vec<String>> {
        let mut ids = Vec::new();
        for call in &self.calls {
            match call {
                Call::Submit(words) => {
                    ids.push(submit(words)?);
                    keep(&ids)?;
                }
                Call::Wait(words) => self.wait(words, observer)?,
            }
        }
        if let Some(words) = self.finish(&ids) {
            // What waits for the others is stopped first, lest it begins when they are.
            ids.insert(0, submit(&words)?);
            keep(&ids)?;
        }
        Ok(ids)
    }

    /// Runs a command to its end. That some chunk failed is for the end of the job to say.
    fn wait(&self, words: &[String], observer: &dyn Observer) -> Result<()> {
        let _hold: Option<File> = hold(&self.place)?;
        let refused = |error| Error::io(&words[0], "run it", error);
        let mut child =
            Command::new(&words[0]).args(&words[1..]).stdin(Stdio::null()).spawn().map_err(refused)?;
        loop {
            if let Some(status) = child.try_wait().map_err(refused)? {
                if !status.success() {
                    observer.note(&format!("{} ended with {status}", words[0]));
                }
                return Ok(());
            }
            if observer.cancelled() {
                ask_to_stop(&mut child);
                child.wait().map_err(refused)?;
                return Err(Error::Interrupted(format!(
                    "finished frames are whole; go on with `hedgehop farm retry {}`",
                    named(&self.place)
                )));
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// Quotes a word, but for names of variables at its end.
fn unquoted(word: &str, ids: &[String]) -> String {
    let variables = ids.join(":");
    if ids.iter().any(|id| id == word) {
        return word.to_owned();
    }
    match word.strip_suffix(&variables) {
        Some(before) if !ids.is_empty() => quoted(&[before.to_owned()]) + &variables,
        _ => quoted(&[word.to_owned()]),
    }
}

/// Runs a command that prints the name of what it submitted.
fn submit(words: &[String]) -> Result<String> {
    let output = Command::new(&words[0])
        .args(&words[1..])
        .stdin(Stdio::null())
        .output()
        .map_err(|error| Error::io(&words[0], "run it", error))?;
    let (text, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // Slurm puts the name of its cluster behind the number.
    let id = text.trim().split(';').next().unwrap_or_default().to_owned();
    if !output.status.success() || id.is_empty() {
        let said = said.trim().lines().next().unwrap_or("it said nothing").to_owned();
        return Err(Error::io(&words[0], "submit chunks with it", std::io::Error::other(said)));
    }
    Ok(id)
}

/// Whether a scheduler has tasks of these names that wait or run, as far as it tells.
pub fn has_open_tasks(engine: Scheduler, ids: &[String]) -> bool {
    let (command, words): (&str, Vec<String>) = match engine {
        Scheduler::Slurm => ("squeue", vec!["-h".into(), "-j".into(), ids.join(",")]),
        Scheduler::Hyperqueue => {
            let words = ["job", "task-ids", &ids.join(","), "--filter=waiting,running"];
            ("hq", words.map(String::from).to_vec())
        }
        Scheduler::Local | Scheduler::Parallel | Scheduler::Openjd => return false,
    };
    if ids.is_empty() {
        return false;
    }
    // A scheduler that has forgotten the job, or is gone, has none.
    let output = Command::new(command).args(words).output();
    output.is_ok_and(|output| output.status.success() && !output.stdout.trim_ascii().is_empty())
}

/// Asks a scheduler to stop what it has of a job; returns what was asked to.
pub fn cancel(engine: Scheduler, ids: &[String]) -> Result<Vec<String>> {
    let words: &[&str] = match engine {
        Scheduler::Slurm => &["scancel"],
        Scheduler::Hyperqueue => &["hq", "job", "cancel"],
        Scheduler::Local | Scheduler::Parallel | Scheduler::Openjd => return Ok(Vec::new()),
    };
    if ids.is_empty() {
        return Ok(Vec::new());
    }
    let ids = if engine == Scheduler::Hyperqueue { vec![ids.join(",")] } else { ids.to_vec() };
    let output = Command::new(words[0])
        .args(&words[1..])
        .args(&ids)
        .output()
        .map_err(|error| Error::io(words[0], "stop tasks with it", error))?;
    if !output.status.success() {
        let said =
            String::from_utf8_lossy(&output.stderr).trim().lines().next().unwrap_or_default().to_owned();
        return Err(Error::io(words[0], "stop tasks with it", std::io::Error::other(said)));
    }
    Ok(vec![format!("{} {}", engine.name(), ids.join(", "))])
}

#[cfg(unix)]
fn make_executable(path: &Path) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let refused = |error| Error::io(path, "make it executable", error);
    let mut permissions = std::fs::metadata(path).map_err(refused)?.permissions();
    permissions.set_mode(permissions.mode() | 0o111);
    std::fs::set_permissions(path, permissions).map_err(refused)
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> Result<()> {
    Ok(())
}
