//! Few kinds of error, each with the place and the remedy in its sentence.

use std::io;
use std::path::{Path, PathBuf};

/// Failure, in one sentence that names the file, the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused something.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// File that was touched.
        path: PathBuf,
        /// Action that was tried, as a verb phrase: `read`, `create`, `rename it to AREA.hop`.
        action: String,
        /// Answer of the operating system.
        source: io::Error,
    },
    /// A file holds something that it must not hold.
    #[error("{}: {what}", path.display())]
    Invalid {
        /// The offending file.
        path: PathBuf,
        /// Place in the file (byte, line, tag), what is wrong there, and the remedy.
        what: String,
    },
    /// A file is sound, but uses something that is not read here.
    #[error("{}: {what}; {remedy}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Feature that is not supported.
        what: String,
        /// The command or flag that helps.
        remedy: String,
    },
    /// Options that contradict each other or the data; the sentence names the flag.
    #[error("{0}")]
    Configuration(String),
    /// Work was planned for something else than what is here: another database, program or setting.
    #[error("{0}")]
    Mismatch(String),
    /// The user asked to stop; everything finished so far is whole.
    #[error("interrupted; {0}")]
    Interrupted(String),
}

/// `Result` with [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An I/O error on `path` while trying to `action`.
    pub fn io(path: impl AsRef<Path>, action: impl Into<String>, source: io::Error) -> Self {
        Self::Io { path: path.as_ref().to_owned(), action: action.into(), source }
    }

    /// A file that holds something wrong; `what` names place and remedy.
    pub fn invalid(path: impl AsRef<Path>, what: impl Into<String>) -> Self {
        Self::Invalid { path: path.as_ref().to_owned(), what: what.into() }
    }

    /// A sound file that uses something unsupported; `remedy` is a command or flag.
    pub fn unsupported(path: impl AsRef<Path>, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { path: path.as_ref().to_owned(), what: what.into(), remedy: remedy.into() }
    }
}
