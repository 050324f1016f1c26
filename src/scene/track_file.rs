//! Path files that a scene names.

use std::fs;
use std::path::PathBuf;

use toml::Spanned;

use super::place::Above;
use crate::flight::{ReadOptions, Track, read_track};
use hedgehop_base::document::Reading;
use hedgehop_base::error::{Error, Result};

/// Keys of a path file.
pub(super) struct TrackFile<'t> {
    /// Owner of the track, as a clause.
    pub whose: &'t str,
    pub track: &'t Spanned<PathBuf>,
    pub number: Option<&'t Spanned<usize>>,
    pub sort: Option<&'t Spanned<bool>>,
    pub altitude: Option<&'t Spanned<Above>>,
}

impl TrackFile<'_> {
    /// Reads the file; `hasher` takes all bytes of it.
    pub fn read(&self, reading: &Reading<'_>, hasher: &mut blake3::Hasher) -> Result<Track> {
        let name = self.track.get_ref();
        if name.to_string_lossy().chars().any(char::is_control) {
            return Err(reading.wrong(self.track.span(), "track must be the name of a file"));
        }

        let path = reading.path.parent().unwrap_or(".".as_ref()).join(name);
        let of_scene = |error: Error| reading.through(self.track.span(), self.whose, error);
        let options = ReadOptions {
            altitude_mode: self.altitude.map(|above| (*above.get_ref()).into()),
            track: self.number.map(|number| *number.get_ref()),
            sort: self.sort.is_some_and(|sort| *sort.get_ref()),
        };

        let mut read = read_track(&path, &options).map_err(|error| of_scene(in_keys(error)))?;
        read.notes.iter_mut().for_each(|note| *note = of_track(note));
        let bytes = fs::read(&path).map_err(|source| of_scene(Error::io(&path, "read", source)))?;
        hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);

        Ok(read)
    }
}

/// Turns what is said of a track in flags into keys of a scene.
fn of_track(said: &str) -> String {
    said.replace("--track ", "track_number = ").replace("--sort ", "sort = true ")
}

fn in_keys(error: Error) -> Error {
    match error {
        Error::Invalid { path, what } => Error::Invalid { path, what: of_track(&what) },
        other => other,
    }
}
