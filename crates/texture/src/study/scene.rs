//! Scene of the study's pictures, in the order of its priorities: runway, terrain, ground, sky.
//!
//! ```text
//! shares of a pixel     runway ρ = γ(runway), terrain τ = γ(terrain) − γ(terrain and runway),
//!                       ground = γ(below the horizon) − γ(terrain or runway), sky the rest
//! tone                  sum of shares times tones; terrain's is the shade of the exact mean over the footprint
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), image pipeline and runway scene.

use super::ground_quad::GroundQuad;
use super::pixel_share::{HalfPlane, ScreenPoint, pixel_share};
use super::view::GroundView;
use crate::cell_box::CellBox;
use crate::footprint::Footprint;
use crate::shades::Shades;
use crate::subterrain::SubterrainCode;

/// Grey tones of a picture, line by line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GreyPicture {
    /// Pixels of a line.
    pub width: u32,
    /// Tones, 0 to 255.
    pub greys: Vec<u8>,
}

/// Ground with texture.
#[derive(Debug, Clone)]
pub struct TexturedTerrain {
    /// Outline on the ground.
    pub outline: GroundQuad,
    /// Code over it; lines are rows of cells along x.
    pub code: SubterrainCode,
    /// Side of a cell, feet.
    pub cell: f64,
    /// Shades that tones become.
    pub shades: Shades,
    /// Parts of a cell, as a power of two, that corners of footprints are rounded to.
    pub subdivision: u32,
    /// Slices of a footprint.
    pub slices: u32,
    /// Whether cells blend into each other where they are larger than pixels.
    pub is_smooth_nearby: bool,
}

/// Ground of one tone over everything else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Runway {
    /// Outline on the ground.
    pub outline: GroundQuad,
    /// Tone, 0 to 255.
    pub tone: u8,
}

/// Sky, ground and what lies on it.
#[derive(Debug, Clone)]
pub struct StudyScene {
    /// Tone of the sky.
    pub sky: u8,
    /// Tone of flat ground.
    pub ground: u8,
    /// Ground with texture.
    pub terrain: TexturedTerrain,
    /// Runway, if there is one.
    pub runway: Option<Runway>,
    /// Whether pixels at edges mix tones by area; else each shows what is in its middle.
    pub has_smooth_edges: bool,
}

/// Outlines on the screen of a view.
struct Outlines {
    horizon: [HalfPlane; 1],
    terrain: Option<Vec<HalfPlane>>,
    runway: Option<Vec<HalfPlane>>,
}

/// Shares of a pixel.
struct Visible {
    sky: f64,
    ground: f64,
    terrain: f64,
    runway: f64,
}

impl TexturedTerrain {
    /// Shade of a pixel by its footprint in cells.
    pub fn shade(&self, footprint: &Footprint) -> u8 {
        let slices = footprint.slices(self.slices);
        let mean: f64 =
            slices.iter().map(|slice| slice.share * self.code.mean(self.rounded(slice.over))).sum();
        self.shades.shade(mean.round().clamp(0.0, 255.0) as u8)
    }

    /// Box in parts of cells, about whose corners means blend if cells shall have no edges.
    fn rounded(&self, over: CellBox) -> CellBox {
        let parts = f64::from(1_u32 << self.subdivision.min(31));
        let over = if self.is_smooth_nearby { over.at_least(1.0) } else { over };
        let [x0, x1, y0, y1] =
            [over.x0, over.x1, over.y0, over.y1].map(|side| (side * parts).round() / parts);
        CellBox { x0, x1, y0, y1 }
    }
}

impl StudyScene {
    /// Draws the scene.
    pub fn picture(&self, view: &GroundView) -> GreyPicture {
        let screen = view.screen();
        let outlines = Outlines {
            horizon: [view.below_horizon()],
            terrain: self.terrain.outline.sides(view),
            runway: self.runway.and_then(|runway| runway.outline.sides(view)),
        };
        let runway = self.runway.map_or(0, |runway| runway.tone);

        let tone = |number: u32| {
            let at = screen.pixel(number);
            let shares = outlines.visible(at, self.has_smooth_edges);
            let textured = if shares.terrain > 0.0 {
                view.footprint(at, self.terrain.cell).map_or(self.ground, |over| self.terrain.shade(&over))
            } else {
                0
            };
            let parts = [
                (shares.sky, self.sky),
                (shares.ground, self.ground),
                (shares.terrain, textured),
                (shares.runway, runway),
            ];
            parts.into_iter().map(|(share, tone)| share * f64::from(tone)).sum::<f64>().round() as u8
        };
        GreyPicture { width: screen.projection.pixels, greys: (0..screen.size()).map(tone).collect() }
    }
}

impl Outlines {
    /// Shares of the pixel about a place that each part of the scene has.
    fn visible(&self, at: ScreenPoint, is_smooth: bool) -> Visible {
        let covered = |sides: &[&[HalfPlane]]| {
            let mut all = sides.iter().copied().flatten();
            if is_smooth {
                pixel_share(at, all)
            } else {
                f64::from(u8::from(all.all(|half| half.at(at) > 0.0)))
            }
        };
        let of = |outline: &Option<Vec<HalfPlane>>| outline.as_ref().map_or(0.0, |sides| covered(&[sides]));
        let (terrain, runway) = (of(&self.terrain), of(&self.runway));
        let both = match (&self.terrain, &self.runway) {
            (Some(first), Some(second)) if terrain * runway > 0.0 => covered(&[first, second]),
            _ => 0.0,
        };

        let either = terrain + runway - both;
        let below = covered(&[&self.horizon]).max(either);
        Visible { sky: 1.0 - below, ground: below - either, terrain: terrain - both, runway }
    }
}

#[cfg(test)]
#[path = "scene_tests.rs"]
mod tests;
