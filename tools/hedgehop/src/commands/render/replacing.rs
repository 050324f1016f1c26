//! Whether frames may go where they are to: what is there may be another render's.
//!
//! ```text
//! the folder's manifest tells of the same database, flight and settings  → its frames are these
//!     of others, and its frames have the names that these would get      → refused
//!     of others, and its frames have other names                         → it stays, without these
//! a file without an entry shows something else than the frame of its name → refused
//! ```
//! `--overwrite` has them replaced. With `--skip-existing` all that shows something else is rendered again, as long as this leaves no frame without an entry.

use std::collections::BTreeSet;
use std::path::Path;

use crate::commands::render::flags::RenderArgs;
use crate::frame_ranges::ranges;
use crate::output::Files;
use hedgehop::encode::check::Existing;
use hedgehop::encode::sidecar::{FrameRecord, Manifest};
use hedgehop::progress::Observer;
use hedgehop::render::NumberedCamera;
use hedgehop::{Error, Result};

/// Frames that are there already, as a manifest lists them.
struct Earlier {
    /// Records whose files are there.
    frames: Vec<FrameRecord>,
    /// Says what made them otherwise; `None`: they are of the same render.
    difference: Option<String>,
}

impl Earlier {
    /// A manifest that cannot be read says nothing; the files themselves are looked at then.
    fn read(files: &Files<'_>, folder: &Path) -> Result<Option<Self>> {
        let Some(manifest) = Manifest::read(folder).ok().flatten() else { return Ok(None) };
        let difference = files.manifest()?.difference(&manifest);
        let is_there =
            |frame: &FrameRecord| frame.file.as_ref().is_some_and(|name| folder.join(name).is_file());
        let frames = manifest.frames.into_iter().filter(is_there).collect();
        Ok(Some(Self { frames, difference }))
    }

    fn numbers(&self) -> Vec<u64> {
        self.frames.iter().map(|frame| frame.frame).collect()
    }
}

/// Refuses frames that would take the place of another render's, or its place in the manifest. Returns whether the manifest is to list what comes.
pub fn check(
    args: &RenderArgs,
    files: &Files<'_>,
    cameras: &[NumberedCamera],
    observer: &dyn Observer,
) -> Result<bool> {
    let Some(folder) = files.folder() else { return Ok(true) };
    let place =
        if folder.as_os_str().is_empty() { "this folder".into() } else { folder.display().to_string() };
    let earlier = Earlier::read(files, folder)?;

    if !files.are_listed() {
        // A picture of its own has no entry, and may be given anew, but not in the place of a frame.
        let is_taken = |frame: &FrameRecord| {
            let name = frame.file.as_ref().map(|name| folder.join(name));
            cameras.iter().any(|frame| name.as_ref() == Some(&files.path(frame.number)))
        };
        let taken = earlier.iter().flat_map(|earlier| &earlier.frames).find(|frame| is_taken(frame));
        return match taken.and_then(|frame| frame.file.as_ref()).filter(|_| !args.overwrite) {
            Some(name) => Err(refused(&format!("{} is a frame of a flight", folder.join(name).display()))),
            None => Ok(true),
        };
    }

    let wanted: BTreeSet<u64> = cameras.iter().map(|frame| frame.number).collect();
    let mut known: BTreeSet<u64> = BTreeSet::new();
    let mut is_listed = true;
    match &earlier {
        Some(earlier @ Earlier { difference: None, .. }) => known = earlier.numbers().into_iter().collect(),
        Some(earlier @ Earlier { frames, difference: Some(what) }) if !frames.is_empty() => {
            let has_such_a_name = |frame: &FrameRecord| {
                frame.file.as_ref().map(|name| folder.join(name)) == Some(files.path(frame.frame))
            };
            let left = frames.iter().filter(|frame| !wanted.contains(&frame.frame)).count();

            if args.overwrite {
                if left > 0 {
                    observer.note(&format!(
                        "{left} frames of another render stay in {place}, and its manifest and poses do not list them any more"
                    ));
                }
            } else if !frames.iter().any(has_such_a_name) {
                observer.note(&format!(
                    "the manifest and the poses in {place} stay those of another render, and do not list these frames: {what}; --overwrite replaces them"
                ));
                is_listed = false;
            } else if left > 0 || !args.skip_existing {
                let numbers = ranges(&earlier.numbers());
                return Err(refused(&format!("{place} holds frames {numbers} of another render: {what}")));
            }
        }
        _ => {}
    }

    if args.overwrite || args.skip_existing {
        return Ok(is_listed);
    }

    for &NumberedCamera { number, ref camera, .. } in
        cameras.iter().filter(|frame| !known.contains(&frame.number))
    {
        if let Existing::Different(what) = files.state(number, camera) {
            return Err(refused(&format!("{} is of another render: {what}", files.path(number).display())));
        }
    }

    Ok(is_listed)
}

fn refused(what: &str) -> Error {
    Error::Configuration(format!(
        "{what}; give another folder to -o, or --overwrite to have such frames replaced"
    ))
}
