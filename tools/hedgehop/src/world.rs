//! World beyond the database: the bend of the Earth, and the area again.

use glam::DVec2;

use crate::args;
use hedgehop::Result;
use hedgehop::earth::Curvature;
use hedgehop::progress::Observer;
use hedgehop::raymarch::{endless_ground_height, ground_height};
use hedgehop::render::RenderOptions;
use hedgehop::voxel::{Grid, Header, PageSource};

/// Flags of the world beyond the database: the Earth's curvature, and repetition of the area.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
#[command(next_help_heading = "World")]
pub struct WorldArgs {
    /// Earth's curvature with refraction: auto (on for a place on Earth, off for local metres), on, off, or a
    /// refraction coefficient from -1 to 1; on is 1/7, and 0 is no refraction
    #[arg(long, value_name = "auto|on|off|K", default_value = "auto", value_parser = bend, allow_hyphen_values = true)]
    pub curvature: Bend,

    /// Repeat the area without end, eastward and northward
    #[arg(long)]
    pub tile_world: bool,
}

/// `--curvature` as users give it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Bend {
    /// Bend that the database asks for
    #[default]
    Auto,
    /// Standard refraction
    On,
    /// Flat
    Off,
    /// A refraction coefficient
    Refraction(f64),
}

/// Reads `--curvature`.
///
/// # Errors
/// What is wanted.
pub fn bend(text: &str) -> std::result::Result<Bend, String> {
    match text.trim().to_ascii_lowercase().as_str() {
        "auto" => Ok(Bend::Auto),
        "on" => Ok(Bend::On),
        "off" => Ok(Bend::Off),
        text => args::number(text)
            .ok()
            .filter(|k| (-1.0..=1.0).contains(k))
            .map(Bend::Refraction)
            .ok_or_else(|| "want auto, on, off, or a refraction coefficient from -1 to 1".into()),
    }
}

impl WorldArgs {
    /// Sets what the world decides of the library's options.
    pub fn apply(&self, header: &Header, options: RenderOptions) -> RenderOptions {
        let curvature = match self.curvature {
            Bend::Auto => RenderOptions::of(header).curvature,
            Bend::On => Curvature::standard(),
            Bend::Off => Curvature::FLAT,
            Bend::Refraction(k) => Curvature::refracted(k),
        };
        RenderOptions { curvature, tile_world: self.tile_world, ..options }
    }

    /// Height of the ground, metres; `None` where there is none.
    pub fn ground(&self, source: &dyn PageSource, position: DVec2) -> Result<Option<f64>> {
        if self.tile_world {
            endless_ground_height(source, position)
        } else {
            ground_height(source, position)
        }
    }

    /// Says where copies of the area meet in voxels that are not whole.
    pub fn note_seam(&self, header: &Header, observer: &dyn Observer) {
        let Grid { nx, ny, .. } = header.grid;
        let sides = (1..header.level_count).map(Grid::side_units);
        let split = |side: &u32| !nx.is_multiple_of(*side) || !ny.is_multiple_of(*side);
        if let Some(side) = sides.into_iter().find(split).filter(|_| self.tile_world) {
            observer.note(&format!(
                "--tile-world: {nx} x {ny} voxels are no multiple of {side}, so from afar the last ones before a \
                 seam are narrower than the others. Build with a --bbox of whole multiples of {} \
                 voxels to have them all alike",
                Grid::side_units(header.level_count - 1)
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curvature_is_a_word_or_a_coefficient() {
        assert_eq!(bend("auto"), Ok(Bend::Auto));
        assert_eq!(bend("OFF"), Ok(Bend::Off));
        assert_eq!(bend("-0.25"), Ok(Bend::Refraction(-0.25)));
        for wrong in ["", "yes", "1.5", "nan", "-2", "1/7"] {
            assert!(bend(wrong).is_err(), "{wrong}");
        }
    }
}
