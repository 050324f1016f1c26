//! Processes that work off a job here: one at a time for each job, and how to ask them to stop.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::process::Child;

use crate::farm::chunk_lock::{sign, signed_here};
use hedgehop::{Error, Result};

const LOCK: &str = "local.lock";

/// Asks a process to stop after the work in hand.
#[cfg(unix)]
pub fn ask_to_stop(child: &mut Child) {
    // It may have ended meanwhile.
    let _ =
        rustix::process::kill_process(rustix::process::Pid::from_child(child), rustix::process::Signal::TERM);
}

/// Asks a process to stop.
#[cfg(not(unix))]
pub fn ask_to_stop(child: &mut Child) {
    let _ = child.kill();
}

/// Keeps a second process from working off the same job; the file says whose process it is.
pub fn hold(folder: &Path) -> Result<Option<File>> {
    let path = folder.join(LOCK);
    let file = File::options().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(|error| Error::io(&path, "open it", error))?;
    match file.try_lock() {
        Ok(()) => {
            sign(&file);
            Ok(Some(file))
        }
        Err(TryLockError::WouldBlock) => Err(Error::Configuration(format!(
            "{} is being worked off already; `hedgehop farm status` tells how far it is, `farm cancel` stops it",
            folder.display()
        ))),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// Asks the process that works off a job here to stop; false if there is none.
pub fn cancel(folder: &Path) -> Result<bool> {
    let path = folder.join(LOCK);
    let Ok(file) = File::options().write(true).open(&path) else { return Ok(false) };
    if !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        return Ok(false);
    }
    match signed_here(&path) {
        Some(process) => stop(process).map(|()| true),
        None => Err(Error::Configuration(format!(
            "{} is held by a process of another machine; stop the job there",
            path.display()
        ))),
    }
}

/// Asks a process to stop after the work in hand.
pub fn stop(process: u32) -> Result<()> {
    ask_process(process).map_err(|error| Error::io(format!("process {process}"), "stop it", error))
}

#[cfg(unix)]
fn ask_process(process: u32) -> std::io::Result<()> {
    let process = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    let process = process.ok_or_else(|| std::io::Error::other("there is none of that number"))?;
    Ok(rustix::process::kill_process(process, rustix::process::Signal::TERM)?)
}

#[cfg(not(unix))]
fn ask_process(_: u32) -> std::io::Result<()> {
    Err(std::io::Error::other("press Ctrl-C where it runs"))
}
