//! Heights of buildings from their shadows in a photograph (Hughes 1994, shadows: Z = L·tan A, A the sun's elevation by place, date and time; refined
//! until computed and photographed shadow agree).
//!
//! ```text
//! each row:   its outline in metres around the layer's middle | the sun over it | the ground it stands on
//!   states a height:                    stays as it is
//!   states its shadow's length or tip:  Z = L·tan A on the ground's slope            (stated)
//!   else, with imagery:                 the height whose computed shadow agrees best  (site, edge)
//! twice:      first as if neighbours were as high as the building itself, then with what was found of them
//! at last:    what is much paler than most shadows of the same picture is none
//! ```
//! The shadow of a prism with a level roof, on any ground: a place q behind the building is shaded by a roof of height z above the building's foot if
//!
//! ```text
//! ground(q) − foot + t(q)·tan A < z            t: metres from q to the outline towards the sun
//! ```
//! The left side does not depend on z. So the computed shadows of all heights are known at once, by one number for each part of a pixel, and what is looked
//! for is the number at which the picture's brightness jumps.

mod answer;
mod bounds;
mod edge;
mod index;
mod notes;
mod patch;
mod report;
mod row;
mod site;
mod stated;
mod sunward;
mod survey;
mod table;
#[cfg(test)]
mod tests;
mod write;

use std::path::Path;

pub use answer::{Answer, Origin, ShadowHeight};
pub use report::{ShadowOptions, ShadowReport};

use super::features;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Measures the heights of buildings. What comes out does not depend on the number of threads.
///
/// # Errors
/// Files that cannot be read, or do not lie in systems that go with each other; a sun below the horizon or in the zenith; a request to stop.
pub fn shadow_heights(options: &ShadowOptions, observer: &dyn Observer) -> Result<ShadowReport> {
    let most = 2000.0;
    if !(options.highest_m > 0.0 && options.highest_m <= most) {
        let what = format!(
            "the highest building must be above 0 and up to {most} metres, not {}",
            options.highest_m
        );
        return Err(Error::Configuration(what));
    }
    let layer = features::read(&options.buildings, &options.layer)?;
    survey::survey(layer, options, observer).map_err(|error| match error {
        Error::Interrupted(_) => Error::Interrupted("no heights were written".into()),
        other => other,
    })
}

impl ShadowReport {
    /// The buildings with their heights, as GeoJSON. Of GeoJSON all members and properties stay as they were, to the letter; `height`, `height_error`,
    /// `shadow_length` (metres), and `shadow_note` where a row has no height, are put in their place or added.
    ///
    /// # Errors
    /// A file that has changed since it was read, or cannot be read again.
    pub fn geojson(&self) -> Result<String> {
        write::geojson(self)
    }

    /// The same as a table: attributes, the outline as well-known text, and the columns of [`Self::geojson`].
    ///
    /// # Errors
    /// As of [`Self::geojson`].
    pub fn csv(&self) -> Result<String> {
        table::write(self)
    }

    /// Whether the file is written as a table by its name.
    pub fn is_table(path: &Path) -> bool {
        table::is_table(path)
    }
}
