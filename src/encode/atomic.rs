//! Files that appear whole or not at all.
//!
//! ```text
//! create .NAME.XXXXXX.part in the folder of NAME     (same file system, so that renaming is one step)
//! write, then sync                                   (a full disk or quota may only say so here)
//! rename over NAME                                   (replaces what was there)
//! on any error: remove the .part file, leave NAME as it was
//! ```
//!
//! A process that is killed outright can leave a `.part` file, never a half file under its final name.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::path::Path;

use tempfile::{Builder, NamedTempFile};

use hedgehop_base::error::{Error, Result};

/// Puts `bytes` into `path`, replacing what is there, whole or not at all. Missing folders are made.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// Writes as [`write_bytes`] does, but leaves what is there already.
///
/// # Errors
/// [`Error::Configuration`]: there is something already.
pub fn write_new_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut temporary = temporary_for(path)?;
    let file = temporary.as_file_mut();
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|source| write_error(path, source))?;
    temporary.persist_noclobber(path).map(drop).map_err(|error| match error.error.kind() {
        io::ErrorKind::AlreadyExists => {
            Error::Configuration(format!("{} exists already; name another file", path.display()))
        }
        _ => Error::io(path, "rename the finished file to it", error.error),
    })
}

/// Whether a file could be written to `path` now, which stays as it is: known before the work that is to fill it. Missing folders are made.
pub fn check_writable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::Configuration(format!("{} is a folder; name a file in it", path.display())));
    }
    temporary_for(path).map(drop)
}

/// Writes as [`write_bytes`] does, with a writer that fills the file itself.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    let mut temporary = temporary_for(path)?;
    let file = temporary.as_file_mut();
    fill(file).and_then(|()| file.sync_all()).map_err(|source| write_error(path, source))?;
    persist(temporary, path)
}

/// An empty temporary file that [`persist`] can rename to `path`; it keeps the extension, by which
/// other programs choose a format.
pub(super) fn temporary_for(path: &Path) -> Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let Some(name) = path.file_name() else {
        return Err(Error::Configuration(format!("{}: names no file to write to", path.display())));
    };

    // Renaming would put a file in the place of a device or a pipe.
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Err(Error::Configuration(format!("{} is no regular file; write to one", path.display())));
    }

    std::fs::create_dir_all(folder).map_err(|source| {
        Error::io(path, format!("write it, since there can be no folder {}", folder.display()), source)
    })?;
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    let mut suffix = std::ffi::OsString::from(".part");
    if let Some(extension) = path.extension() {
        suffix.push(".");
        suffix.push(extension);
    }

    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(&suffix);
    if let Some(permissions) = usual_permissions() {
        builder.permissions(permissions);
    }

    builder.tempfile_in(folder).map_err(|source| write_error(path, own_words(source)))
}

/// Drops the name of a temporary file, which nobody gave, from what the system said.
fn own_words(error: io::Error) -> io::Error {
    // The library that makes these files appends it, and keeps what is before it to itself.
    match error.to_string().rsplit_once(" at path \"") {
        Some((own, _)) => io::Error::new(error.kind(), own.to_owned()),
        None => error,
    }
}

/// Renames a finished temporary file to `path`.
pub(super) fn persist(temporary: NamedTempFile, path: &Path) -> Result<()> {
    temporary
        .persist(path)
        .map(drop)
        .map_err(|error| Error::io(path, "rename the finished file to it", error.error))
}

/// The permissions that any new file gets: temporary files are private otherwise.
#[cfg(unix)]
fn usual_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn usual_permissions() -> Option<Permissions> {
    None
}

/// The sentence for a write that failed.
pub(super) fn write_error(path: &Path, source: io::Error) -> Error {
    let action = match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "write it; free some space and repeat the command, files that are finished stay whole and \
             `render --skip-existing` keeps frames"
        }
        _ => "write it",
    };
    Error::io(path, action, source)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::testing::place;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn what_is_there_stays_where_a_new_file_is_wanted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        write_new_bytes(&path, b"first").unwrap();
        let refused = write_new_bytes(&path, b"second").unwrap_err().to_string();
        assert!(refused.contains("exists already"), "{refused}");
        assert_eq!(
            (std::fs::read(&path).unwrap(), names(folder.path())),
            (b"first".to_vec(), vec!["a.toml".into()])
        );
    }

    #[test]
    fn replaces_the_target_and_makes_folders() {
        let (folder, _) = place("");
        let path = folder.path().join("a/b/frame.png");
        write_bytes(&path, b"first, and longer").unwrap();
        write_bytes(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(names(path.parent().unwrap()), ["frame.png"]);
    }

    #[test]
    fn a_full_disk_leaves_the_old_file_and_names_the_remedy() {
        let (folder, path) = place("frame.png");
        write_bytes(&path, b"old").unwrap();
        let error = write_with(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        })
        .unwrap_err()
        .to_string();
        assert!(error.contains("frame.png") && error.contains("--skip-existing"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["frame.png"]);
    }

    #[test]
    fn places_that_cannot_be_written() {
        let (folder, path) = place("file");
        write_bytes(&path, b"").unwrap();
        let below_a_file = path.join("frame.png");
        let message = write_bytes(&below_a_file, b"x").unwrap_err().to_string();
        assert!(message.starts_with(&below_a_file.display().to_string()), "{message}");
        assert!(message.contains("no folder"), "{message}");
        let message = write_bytes(folder.path(), b"x").unwrap_err().to_string();
        assert!(message.contains("rename"), "a folder is in the way: {message}");
        assert!(write_bytes(Path::new("/"), b"x").is_err());
    }

    #[test]
    fn a_check_leaves_what_is_there() {
        let (folder, path) = place("map.svg");
        check_writable(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        write_bytes(&path, b"old").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["map.svg"]);
        assert!(check_writable(folder.path()).unwrap_err().to_string().contains("is a folder"));
        assert!(check_writable(&path.join("x.svg")).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn names_of_temporary_files_are_not_told() {
        let message = check_writable(Path::new("/proc/map.svg")).unwrap_err().to_string();
        assert!(
            message.starts_with("/proc/map.svg: cannot write it") && !message.contains(".part"),
            "{message}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_the_file_as_far_as_the_umask_allows() {
        use std::os::unix::fs::PermissionsExt;
        let (folder, path) = place("frame.png");
        write_bytes(&path, b"x").unwrap();
        let plain = folder.path().join("plain");
        std::fs::write(&plain, b"x").unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain));
    }
}
