//! Fixes of a path file that are flown.

use clap::Args;

use hedgehop::flight::{AltitudeMode, ReadOptions};
use hedgehop::{Error, Result};

/// Flags of the fixes of a path file: which of several tracks, and their order.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct TrackArgs {
    /// The one of several tracks (segments of GPX, gx:Tracks of KML) in the path file, counted from 1; a number that
    /// it has not lists them [default: all of them, joined]
    #[arg(long, value_name = "N")]
    pub track: Option<usize>,

    /// Put the fixes of the path file in the order of their times
    #[arg(long)]
    pub sort: bool,
}

impl TrackArgs {
    /// Returns the options of reading the file.
    pub fn options(self, altitude_mode: Option<AltitudeMode>) -> ReadOptions {
        ReadOptions { altitude_mode, track: self.track, sort: self.sort }
    }

    /// Returns the options of reading other files, of which all tracks count.
    pub fn of_others(self, altitude_mode: Option<AltitudeMode>) -> ReadOptions {
        ReadOptions { altitude_mode, track: None, sort: self.sort }
    }

    /// Refuses choices among fixes where no file has any; `flag` names it.
    pub fn check(self, has_file: bool, flag: &str) -> Result<()> {
        if has_file || (self.track.is_none() && !self.sort) {
            return Ok(());
        }
        Err(Error::Configuration(format!(
            "--track and --sort choose fixes of a path file; give {flag} FILE, or leave them out"
        )))
    }
}
