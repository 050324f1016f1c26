//! End of the program: exit codes, and the one sentence on standard error.

use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use hedgehop::Error;

/// Something that no other code describes.
pub const UNFORESEEN: u8 = 1;
/// Flags that are wrong, contradict each other or do not fit the data (clap's own code, too).
pub const USAGE: u8 = 2;
/// An input file holds something that it must not hold.
pub const INVALID: u8 = 3;
/// An input file is sound but cannot be read as it is; a flag or a conversion helps.
pub const UNSUPPORTED: u8 = 4;
/// The operating system refused: file missing, no permission, disk full.
pub const IO: u8 = 5;
/// `verify`, `verify-frames` or `continuity` found problems, or frames of a job are missing.
pub const PROBLEMS: u8 = 6;
/// A worker of a farm has another database, program or setting than its job.
pub const MISMATCH: u8 = 7;
/// Stopped by Ctrl-C or a termination request.
pub const INTERRUPTED: u8 = 130;
/// The reader of standard output went away (as a shell reports it).
pub const PIPE_CLOSED: u8 = 141;

/// The table at the end of every `--help`.
pub const HELP: &str = "\
Exit codes:
  0    done
  1    something unforeseen
  2    wrong usage: a flag is wrong, or does not fit the data
  3    an input file is damaged or makes no sense
  4    an input file cannot be read as it is; the message says which flag or command helps
  5    the operating system refused: file missing, no permission, disk full or failed, database changed in use
  6    verify, verify-frames or continuity found problems, or frames of a farm's job are missing
  7    a worker of a farm has another database, program, flight or setting than its job
  101  a bug in hedgehop
  130  interrupted; what is finished is whole
  141  the reader of standard output went away";

/// Why a command did not end with 0.
#[derive(Debug)]
pub enum Failure {
    /// The library, or a check of this program, says why.
    Error(Error),
    /// Problems were found, and have been listed.
    Problems,
    /// Failure that no other kind describes.
    Unforeseen(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

/// Result of a command.
pub type Outcome = Result<(), Failure>;

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::Problems => PROBLEMS,
            Self::Error(error) if is_closed_stdout(error) => PIPE_CLOSED,
            Self::Error(Error::Io { .. }) => IO,
            Self::Error(Error::Invalid { .. }) => INVALID,
            Self::Error(Error::Unsupported { .. }) => UNSUPPORTED,
            Self::Error(Error::Configuration(_)) => USAGE,
            Self::Error(Error::Interrupted(_)) => INTERRUPTED,
            Self::Error(Error::Mismatch(_)) => MISMATCH,
            Self::Error(_) | Self::Unforeseen(_) => UNFORESEEN,
        }
    }

    fn sentence(&self) -> Option<String> {
        match self {
            Self::Problems => None,
            Self::Error(error) if is_closed_stdout(error) => None,
            Self::Error(Error::Interrupted(what)) => Some(format!("interrupted; {what}")),
            Self::Error(error) => Some(format!("error: {error}")),
            Self::Unforeseen(what) => Some(format!("error: {what}")),
        }
    }
}

/// Name of standard output in messages.
pub const STDOUT: &str = "standard output";

fn is_closed_stdout(error: &Error) -> bool {
    matches!(error, Error::Io { path, source, .. }
        if source.kind() == io::ErrorKind::BrokenPipe && path.as_os_str() == STDOUT)
}

/// Prints the sentence, if there is one, and gives the exit code.
pub fn report(outcome: Outcome) -> ExitCode {
    let Err(failure) = outcome else { return ExitCode::SUCCESS };
    if let Some(sentence) = failure.sentence() {
        // Nothing is left to tell the user with if standard error is closed.
        let _ = writeln!(io::stderr().lock(), "{sentence}");
    }
    ExitCode::from(failure.code())
}

/// Writes a command's result to standard output.
pub fn print(text: &str) -> hedgehop::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
        .map_err(|error| Error::io(STDOUT, "write", error))
}

/// Turns a panic into one sentence; the exit code stays Rust's 101.
pub fn install_panic_hook() {
    static SAID: AtomicBool = AtomicBool::new(false);
    std::panic::set_hook(Box::new(|panic| {
        if SAID.swap(true, Ordering::Relaxed) {
            return;
        }
        let payload = panic.payload();
        let text = payload
            .downcast_ref::<&str>()
            .copied()
            .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
            .unwrap_or("no message");
        let place = panic.location().map_or_else(|| "an unknown place".to_owned(), ToString::to_string);
        let _ = writeln!(
            io::stderr().lock(),
            "error: this is a bug in hedgehop {}: {text} (at {place}); please report it with the command line",
            env!("CARGO_PKG_VERSION")
        );
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_names_every_code() {
        for code in
            [UNFORESEEN, USAGE, INVALID, UNSUPPORTED, IO, PROBLEMS, MISMATCH, INTERRUPTED, PIPE_CLOSED]
        {
            let named = HELP.lines().any(|line| line.split_whitespace().next() == Some(&code.to_string()));
            assert!(named, "{code} is not explained");
        }
    }

    #[test]
    fn only_a_closed_standard_output_is_silent() {
        let broken =
            |path: &str| Failure::Error(Error::io(path, "write", io::Error::from(io::ErrorKind::BrokenPipe)));
        assert_eq!(broken(STDOUT).code(), PIPE_CLOSED);
        assert_eq!(broken(STDOUT).sentence(), None);
        assert_eq!(broken("film.mp4").code(), IO);
    }
}
