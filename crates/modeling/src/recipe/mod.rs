//! Recipes: what a database is made from, in a file that people write.
//!
//! ```text
//! place.toml ──▶ tables, each with all of its mistakes (line, sentence) ──▶ options of a build, and what comes after it
//! ```
//! A recipe says what the flags of a build say, file by file, and stays when the command is long forgotten (Hughes 1994: the data base modelling and
//! analysis system). Names of files count from its folder, so that a folder can be moved as it is.

mod below_voxel;
mod contents;
mod cover;
mod fields;
mod files;
mod objects;
mod patches;
mod pattern;
mod route;
mod synthetic;
mod tables;
#[cfg(test)]
mod tests;
mod values;
mod words;

use std::path::Path;

use toml::de::DeTable;

use crate::{Corridor, Input, Outline, check_name, check_shadows, faults, outline};
pub use contents::{Mistake, Recipe};
use fields::{Fields, Mistakes};
use hedgehop_base::document::{self, Kind, Reading};
use hedgehop_base::error::{Error, Result};
pub use pattern::matching;
pub use route::route;
use words::key_of_place;
pub use words::{InKeys, error_in_keys, in_keys};

const RECIPE: Kind = Kind { name: "recipe", manual: "docs/recipe.md" };

/// A recipe with all of its keys, most of them commented out.
pub const TEMPLATE: &str = include_str!("template.toml");

impl std::fmt::Display for Mistake {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "line {}: {}", self.line, self.what)
    }
}

impl Recipe {
    /// Reads a recipe.
    ///
    /// # Errors
    /// What is wrong with it, the first mistake and how many there are.
    pub fn read(path: &Path) -> Result<Self> {
        Self::check(path)?.map_err(|mistakes| refused(path, mistakes.first(), mistakes.len()))
    }

    /// Reads a recipe, or tells all that is wrong with it, by line.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn check(path: &Path) -> Result<std::result::Result<Self, Vec<Mistake>>> {
        let text = document::text_of(path, RECIPE, &mut blake3::Hasher::new())?;
        let mistakes = Mistakes::of(Reading::of(path, &text));
        let (table, errors) = DeTable::parse_recoverable(&text);
        for error in errors {
            mistakes.add(&error.span().unwrap_or(0..0), error.message().trim().replace('\n', ", "));
        }
        let read = tables::read(path, Fields::root(table.into_inner(), &mistakes));
        let mistakes = mistakes.into_vec();
        Ok(match read {
            Some(recipe) if mistakes.is_empty() => Ok(recipe),
            _ => Err(mistakes),
        })
    }
}

impl Recipe {
    /// Outlines what would be built, or all that is wrong with the files that it names, and with what it asks of them: no height is read.
    ///
    /// # Errors
    /// The mistakes, by line.
    pub fn outline(&self) -> std::result::Result<Outline, Vec<Mistake>> {
        let faults = faults(&self.options).into_iter();
        let mut mistakes: Vec<Mistake> =
            faults.map(|(input, error)| mistake(self.line_of_input(input), error)).collect();
        let mut found = None;

        if mistakes.is_empty() {
            match outline(&self.options) {
                Ok(outline) => {
                    mistakes.extend(self.wrong_shadows(&outline));
                    found = Some(outline);
                }
                Err(error) => mistakes.push(mistake(self.line_of(&error.to_string()), error)),
            }
        }

        mistakes.extend(self.wrong_output());
        match found {
            Some(found) if mistakes.is_empty() => Ok(self.with_lines(found)),
            _ => {
                mistakes.sort_by_key(|mistake| mistake.line);
                Err(mistakes)
            }
        }
    }

    /// The same error as a mistake of the recipe, with its line, if [`Self::outline`] tells it, too: for who met it in a build.
    #[must_use]
    pub fn located(&self, error: Error) -> Error {
        if matches!(error, Error::Io { .. } | Error::Interrupted(_)) {
            return error;
        }
        let mistakes = self.outline().err().unwrap_or_default();
        let said = error_in_keys(error);
        let text = said.to_string();
        match mistakes.iter().find(|mistake| mistake.what == text) {
            Some(met) => refused(&self.path, Some(met), mistakes.len()),
            None => said,
        }
    }

    /// Refuses an output that is the recipe itself.
    ///
    /// # Errors
    /// It is.
    pub fn check_output(&self, output: &Path) -> Result<()> {
        let both = self.path.canonicalize().ok().zip(output.canonicalize().ok());
        if both.is_none_or(|(recipe, output)| recipe != output) {
            return Ok(());
        }
        let what = format!("{} is the recipe; name another file with -o, like AREA.hop", self.path.display());
        Err(Error::Configuration(what))
    }

    /// Finds a fault of the database's name, and its line.
    fn wrong_output(&self) -> Option<Mistake> {
        let output = &self.options.output;
        let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
        let checked = self.check_output(output).and_then(|()| check_name(&self.options));
        let line = self.line_of("-o");
        if let Err(error) = checked {
            return Some(mistake(line, error));
        }
        let folder = folder.unwrap_or(Path::new("."));
        let what = match tempfile::tempfile_in(folder) {
            Ok(_) => return None,
            Err(_) if !folder.is_dir() => format!("{} is no folder; make it", folder.display()),
            Err(error) => format!("no file can be written into {} ({error}); change that", folder.display()),
        };
        Some(Mistake { line, what: format!("{what}, or say another `output`") })
    }

    /// Finds a fault of the sun over the place, and its line.
    fn wrong_shadows(&self, found: &Outline) -> Option<Mistake> {
        let middle = 0.5 * (found.grid.origin + found.grid.far_corner());
        let sky = self.shadows.as_ref()?.over(&found.crs, middle);
        sky.and_then(|sky| check_shadows(sky.sun)).err().map(|error| mistake(self.lines.shadows, error))
    }

    /// Adds lines to what lies outside the area, which is told before all else.
    fn with_lines(&self, mut found: Outline) -> Outline {
        let told = |(input, what): &(Input, String)| (self.line_of_input(*input), what.clone());
        let mut outside: Vec<(usize, String)> = found.outside.iter().map(told).collect();
        outside.sort_by_key(|(line, _)| *line);
        let outside = outside.into_iter().map(|(line, what)| format!("line {line}: {what}"));
        found.notes = outside.chain(found.notes).collect();
        found
    }

    /// The line of the table that names a part of the build.
    fn line_of_input(&self, input: Input) -> usize {
        let lines = &self.lines;
        match input {
            Input::Cloud(index) => lines.clouds[index],
            Input::Elevation(index) => lines.elevation[index],
            Input::Imagery(index) => lines.imagery[index],
            Input::LandCover(index) => lines.land_cover[index],
            Input::Features(index) => lines.features[index],
            Input::Object(index) => lines.objects[index],
            Input::Scatter(index) => lines.scatters[index],
            Input::Terrain(index) => lines.terrain[index],
            Input::Texture(index) => lines.textures[index],
            Input::Patch(index) => lines.patches[index],
        }
    }

    /// The line of what a build says of no file that it reads: that of the corridor or of the key of `[place]` that it names.
    fn line_of(&self, said: &str) -> usize {
        let corridors = self.options.corridors.iter().zip(&self.lines.corridors);
        let is_named =
            |corridor: &Corridor| said.starts_with(&format!("{}: ", corridor.route.file.display()));
        let named: Vec<_> = corridors.filter(|(corridor, _)| is_named(corridor)).collect();
        // One path may have several.
        let is_meant = |corridor: &Corridor| said.contains(&format!("--spacing {} ", corridor.spacing));
        let meant = named.iter().find(|(corridor, _)| is_meant(corridor)).or(named.first());
        if let Some((_, line)) = meant {
            return **line;
        }
        let key = key_of_place(said);
        let line = self.lines.keys.iter().find(|(known, _)| Some(*known) == key).map(|(_, line)| *line);
        line.unwrap_or(self.lines.place)
    }
}

/// Something wrong at a line, in the words of recipes.
fn mistake(line: usize, error: Error) -> Mistake {
    Mistake { line, what: error_in_keys(error).to_string() }
}

/// One of so many mistakes, for who ends at it.
fn refused(path: &Path, met: Option<&Mistake>, count: usize) -> Error {
    let met = met.map(Mistake::to_string).unwrap_or_default();
    let more = count.saturating_sub(1);
    let rest = format!(" (and {more} more: `hedgehop recipe check {}` tells all)", path.display());
    Error::invalid(path, if more > 0 { met + &rest } else { met })
}
