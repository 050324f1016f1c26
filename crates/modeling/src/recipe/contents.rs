//! Contents of a recipe.

use std::path::PathBuf;

use crate::BuildOptions;
use hedgehop::sunlight::SunSetting;

/// Recipe of a database.
#[derive(Debug)]
pub struct Recipe {
    /// The file.
    pub path: PathBuf,
    /// Options of the build; memory, threads and whether to replace the database are not for recipes.
    pub options: BuildOptions,
    /// The sun whose shadows go into the colours, if any does.
    pub shadows: Option<SunSetting>,
    pub(super) lines: Lines,
}

/// Lines of a recipe by what they say, from 1 on.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines {
    /// Lines of every file, in their order.
    pub(super) clouds: Vec<usize>,
    pub(super) elevation: Vec<usize>,
    pub(super) imagery: Vec<usize>,
    pub(super) features: Vec<usize>,
    pub(super) land_cover: Vec<usize>,
    pub(super) objects: Vec<usize>,
    pub(super) scatters: Vec<usize>,
    /// Lines of every shape, every pattern and every patch.
    pub(super) terrain: Vec<usize>,
    pub(super) textures: Vec<usize>,
    pub(super) patches: Vec<usize>,
    /// Lines of every corridor.
    pub(super) corridors: Vec<usize>,
    /// Lines of the table `[place]`, and of its keys.
    pub(super) place: usize,
    pub(super) keys: Vec<(&'static str, usize)>,
    pub(super) shadows: usize,
}

/// Something that is wrong with a recipe.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// Number of the line, from 1 on.
    pub line: usize,
    /// Fault of the line, and what helps.
    pub what: String,
}
