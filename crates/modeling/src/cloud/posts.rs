//! Heights of the ground from its points: a post for each voxel.
//!
//! ```text
//! a voxel with points of the ground: the plane through them and those of the voxels around, weighed by a tent, at its middle
//! a voxel with points of a surface: the same through those near the highest
//! ```
//! A voxel without any has no post; see [`super::surface`].

use bytemuck::{Pod, Zeroable};

use super::class::PointKind;
use super::fit::{PlaneFit, tent};
use super::store::TILE;
use super::window::{Mark, PointWindow, TileVoxel};
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_linear};

/// Voxels about a tile whose points are asked for.
pub(super) const HALO: i64 = 1;
/// Least weight of the points of a post: that of one half a voxel away along both axes.
const LEAST: f64 = 0.25;
/// Share of a voxel's points that lie below the robust top of a surface.
const TOP: f64 = 0.9;
/// Depth below the top within which points are of the same surface: metres, and sides of a voxel, the greater.
const DEPTH: (f64, f64) = (0.5, 1.0);

/// Ground of a voxel as its points tell it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Post {
    /// Height, metres above the database's datum; NaN where there is none.
    pub height: f32,
    /// sRGB.
    pub colour: [u8; 3],
    /// [`Self::HELD`], [`Self::COLOURED`].
    pub flags: u8,
}

impl Post {
    /// Bit of a voxel that holds points, of whatever.
    pub const HELD: u8 = 1;
    /// Bit of a voxel with a colour.
    pub const COLOURED: u8 = 2;
    /// Post of a voxel of which nothing is known.
    pub const NONE: Self = Self { height: f32::NAN, colour: [0; 3], flags: 0 };

    pub fn is_known(&self) -> bool {
        !self.height.is_nan()
    }

    pub fn srgb(&self) -> Option<[u8; 3]> {
        (self.flags & Self::COLOURED != 0).then_some(self.colour)
    }
}

/// A mean of colours.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mix {
    sum: [f32; 3],
    weight: f32,
}

impl Mix {
    pub fn add(&mut self, srgb: Option<[u8; 3]>, weight: f64) {
        if let Some(srgb) = srgb {
            let linear = linear_from_srgb8(srgb);
            self.sum.iter_mut().zip(linear).for_each(|(sum, linear)| *sum += weight as f32 * linear);
            self.weight += weight as f32;
        }
    }

    pub fn srgb(&self) -> Option<[u8; 3]> {
        (self.weight > 0.0).then(|| self.sum.map(|sum| srgb8_from_linear(sum / self.weight)))
    }
}

/// The posts of a tile, row by row from the south; `spacing` is a voxel's side, metres.
pub(super) fn posts(window: &PointWindow, spacing: f64) -> Vec<Post> {
    let halo = HALO as usize;
    let tile = halo..halo + TILE as usize;
    tile.clone()
        .flat_map(|row| tile.clone().map(move |column| TileVoxel { column, row }))
        .map(|voxel| post(window, voxel, spacing))
        .collect()
}

fn post(window: &PointWindow, voxel: TileVoxel, spacing: f64) -> Post {
    let own = window.at(voxel);
    let flags = if own.is_empty() { 0 } else { Post::HELD };
    let has = |kind: PointKind| own.iter().any(|mark| mark.kind() == kind);
    let (mut fit, mut mix) = (PlaneFit::new(), Mix::default());
    let mut add = |place, mark: &Mark| {
        let weight = tent(place, 1.0);
        fit.add(place, mark.z(), weight);
        mix.add(mark.srgb(), weight);
    };

    if !has(PointKind::Surface) {
        let ground = window.around(voxel, 1).filter(|(_, mark)| mark.kind() == PointKind::Ground);
        ground.for_each(|(place, mark)| add(place, mark));
    } else {
        let mut heights: Vec<f64> = own.iter().map(Mark::z).collect();
        heights.sort_by(f64::total_cmp);
        let top = heights[((heights.len() - 1) as f64 * TOP).round() as usize];
        let depth = DEPTH.0.max(DEPTH.1 * spacing);
        // What rises above is another surface, but for the slope of this one.
        let near = |mark: &Mark| (mark.z() - top).abs() <= depth;
        window.around(voxel, 1).filter(|(_, mark)| near(mark)).for_each(|(place, mark)| add(place, mark));
    }

    let is_enough = fit.weight() >= LEAST || has(PointKind::Ground) || has(PointKind::Surface);
    let Some(plane) = fit.plane().filter(|_| is_enough) else { return Post { flags, ..Post::NONE } };
    let colour = mix.srgb();
    let flags = flags | if colour.is_some() { Post::COLOURED } else { 0 };

    Post { height: plane.height as f32, colour: colour.unwrap_or_default(), flags }
}
