//! Ground, detail and colours that no file holds.
//!
//! ```text
//! height = elevation, with detail below its posts                 mosaic, refine
//!          → shapes, in their order; ponds after all others       shapes, line
//! colour = palette by height and slope, or the tint               palette
//!          → textures, in their order → water of ponds            texture
//!          → features → patches                                  patch, markings
//! ```
//! All of it is a function of the place and of the level's voxels alone, and is made of `noise` that is the same on every machine.
//! After Nack et al., US 5,317,689 (1994): synthetic surfaces, random fractals as a transform of elevation, textures and palettes.

mod detail;
mod examples;
mod lattice;
mod line;
mod markings;
pub(super) mod noise;
mod palette;
mod patch;
mod refine;
mod shapes;
mod texture;

use glam::DVec2;

pub use detail::{Detail, Roughness};
pub use examples::TextureExamples;
pub(super) use lattice::Lattice;
pub use markings::{TouchdownZone, bomb_circle, lake};
pub use palette::{Palette, Stop};
pub(super) use patch::PaintedVoxel;
pub use patch::{EllipsePiece, GroundPatch, PaintCoat, Sector};
pub(super) use refine::{Energies, Refinement};
pub use shapes::{Circle, Hills, PlateauTop, Terrain};
pub use texture::{Pattern, Texture};

use super::tint::mix;
use super::warp::{self, LevelGrid, Rect};
use hedgehop::voxel::{DetailRecord, Grid, Material, VoxelBlock};
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_linear};

/// Terrain, detail and textures of a database besides what its files hold.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Synthetic {
    /// Shapes of the ground, in the order in which they change it.
    pub terrain: Vec<Terrain>,
    /// Materials of shapes, by their places in `terrain`: of the ground that lies on them.
    pub materials: Vec<(usize, Material)>,
    /// Detail that is finer than the posts of elevation.
    pub detail: Option<Detail>,
    /// Detail below the finest voxels, which no page holds; `None`: as usual.
    pub below_voxel: Option<DetailRecord>,
    /// Imagery that its pattern is matched from; `None`: it is generated.
    pub examples: Option<TextureExamples>,
    /// Colours of bare ground; `None`: by the program's own ramp.
    pub palette: Option<Palette>,
    /// Patterns over it, each over those before it.
    pub textures: Vec<Texture>,
    /// Paint over all that lies on the ground.
    pub patches: Vec<GroundPatch>,
}

/// Water in a block: index of the voxel, share of it, and its colour (sRGB).
pub(super) type Water = (usize, f32, [u8; 3]);

impl Synthetic {
    /// Whether there is ground everywhere, without any elevation.
    pub fn has_base(&self) -> bool {
        self.terrain.iter().any(|shape| matches!(shape, Terrain::Plane { .. }))
    }

    /// Whether colours of bare ground are its own.
    pub fn has_colours(&self) -> bool {
        self.palette.is_some() || !self.textures.is_empty()
    }

    /// West, south, east, north of shapes that do not go on everywhere, by their places in `terrain`.
    pub(super) fn shape_bounds(&self) -> impl Iterator<Item = (usize, [f64; 4])> + '_ {
        self.terrain.iter().enumerate().filter_map(|(index, shape)| Some((index, shape.bounds()?)))
    }

    /// The same of `textures`.
    pub(super) fn texture_bounds(&self) -> impl Iterator<Item = (usize, [f64; 4])> + '_ {
        let within = |texture: &Texture| texture.within.map(|circle| circle.bounds(0.0));
        self.textures.iter().enumerate().filter_map(move |(index, texture)| Some((index, within(texture)?)))
    }

    /// The same of `patches`.
    pub(super) fn patch_bounds(&self) -> impl Iterator<Item = (usize, [f64; 4])> + '_ {
        self.patches.iter().enumerate().filter_map(|(index, patch)| Some((index, patch.bounds()?)))
    }

    /// Finds what patches paint on a block, in the order in which it lies on the ground.
    pub(super) fn painted(&self, level: &LevelGrid, rect: Rect) -> Vec<PaintedVoxel> {
        patch::painted(&self.patches, level, rect)
    }

    /// Shapes in the order in which they change the ground: ponds last, so that their water is level.
    fn shapes(&self) -> impl Iterator<Item = &Terrain> {
        let is_pond = |shape: &&Terrain| matches!(shape, Terrain::Pond { .. });
        self.terrain.iter().filter(move |shape| !is_pond(shape)).chain(self.terrain.iter().filter(is_pond))
    }

    /// Least and greatest height, metres, of ground that lies between those of `before` (`None`: there is none).
    pub(super) fn heights(&self, before: Option<(f64, f64)>, grid: &Grid) -> Option<(f64, f64)> {
        let (low, high) = (grid.origin, grid.far_corner());
        let area = [low.x, low.y, high.x, high.y];
        self.shapes().fold(before, |range, shape| shape.heights(range, area))
    }

    /// Changes the heights of a block of voxels, metres, NaN where there is no ground.
    pub(super) fn shape(&self, level: &LevelGrid, rect: Rect, heights: &mut [f64]) {
        let side = level.grid.spacing;
        for shape in self.shapes() {
            if !reaches(shape, level, rect) {
                continue;
            }
            let is_base = matches!(shape, Terrain::Plane { .. });
            for (index, height) in heights.iter_mut().enumerate() {
                if !is_base || height.is_nan() {
                    let effect = shape.effect(centre(level, rect, index), side, level.level);
                    *height = effect.on(*height);
                }
            }
        }
    }

    /// Water of ponds in a block, in the order in which it lies on the ground.
    pub(super) fn water(&self, level: &LevelGrid, rect: Rect) -> Vec<Water> {
        let ponds = self.terrain.iter().filter(|shape| matches!(shape, Terrain::Pond { .. }));
        let near = ponds.filter(|pond| reaches(pond, level, rect));
        near.flat_map(|pond| {
            (0..rect.len()).filter_map(move |index| {
                let (share, colour) = pond.water(centre(level, rect, index), level.grid.spacing)?;
                Some((index, share as f32, colour))
            })
        })
        .collect()
    }

    /// Whether shapes state what the ground is made of.
    pub(super) fn states_materials(&self) -> bool {
        !self.materials.is_empty()
    }

    /// Material of the ground at a place that shapes and textures state, over what else is `known` of it.
    pub(super) fn material(&self, at: DVec2, known: Material) -> Material {
        let mut material = known;
        for (index, own) in &self.materials {
            let Some(shape) = self.terrain.get(*index) else { continue };
            let is_below = matches!(shape, Terrain::Plane { .. }) && material != Material::Unknown;
            if !is_below && shape.holds(at) {
                material = *own;
            }
        }
        let is_in = |texture: &&Texture| {
            texture.within.is_none_or(|circle| at.distance(circle.centre) < circle.radius_m)
        };
        let mut stated = self.textures.iter().filter(is_in).filter_map(|texture| texture.material);
        stated.next_back().unwrap_or(material)
    }

    /// Textures over a colour, of which imagery gave the share `alpha`: linear light. `at` is the voxel's centre, `side` its side, metres.
    pub(super) fn textured(&self, colour: [f32; 3], alpha: f32, at: DVec2, side: f64) -> [f32; 3] {
        self.textures.iter().fold(colour, |colour, texture| {
            let share = texture.share(at, side, alpha);
            if share > 0.0 { mix(colour, texture.colour(at, side), share) } else { colour }
        })
    }
}

/// Puts a share of water of a colour (sRGB) on a voxel of a block.
pub(super) fn flood(voxels: &mut VoxelBlock, at: usize, share: f32, water: [u8; 3]) {
    let mixed = mix(linear_from_srgb8(voxels.colours[at]), linear_from_srgb8(water), share);
    voxels.colours[at] = mixed.map(srgb8_from_linear);
    if share >= 0.5 {
        voxels.attributes[at].material = Material::Water.code();
    }
}

fn reaches(shape: &Terrain, level: &LevelGrid, rect: Rect) -> bool {
    shape.bounds().is_none_or(|bounds| rect.meets(&bounds, &level.grid))
}

/// Centre of a voxel of a block, metres.
fn centre(level: &LevelGrid, rect: Rect, index: usize) -> DVec2 {
    let (x, y) = rect.voxel(index);
    warp::world(&level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5).into()
}
