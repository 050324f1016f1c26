//! Solids and ground of a block.

use std::collections::HashMap;

use super::features::{Paint, PlacedSolid, Solid};
use super::placing::Placed;
use hedgehop_base::error::Result;

/// Solids and ground of a block as features make them, all `[rows][columns]` of it.
pub(super) struct Built {
    /// Heights of the bare ground, metres; NaN where there is none.
    pub ground: Vec<f64>,
    /// Surfaces of the bare ground: voxel, surface, and share of the voxel, in the order in which they lie on each other.
    pub paints: Vec<(usize, Paint, f64)>,
    /// Ground itself, likewise; below all of these.
    pub natural: Vec<(usize, Paint, f64)>,
    /// Solids by voxel, in no order.
    pub solids: Vec<PlacedSolid>,
    /// Objects that reach the block, by voxel of the area.
    pub placed: Vec<Placed>,
    /// Solids that have no colours of their own.
    pub uncoloured: std::ops::Range<usize>,
}

impl Built {
    /// Nothing on this ground.
    pub fn on(natural: &[f64]) -> Self {
        let (paints, natural_paints, solids, placed) = Default::default();
        Self { ground: natural.to_vec(), paints, natural: natural_paints, solids, placed, uncoloured: 0..0 }
    }

    /// The solid that is the surface over each voxel of so many, if one is: the highest that is dense and holds the voxel's centre.
    pub fn surfaces(&self, voxels: usize) -> Vec<Option<&Solid>> {
        let mut surfaces: Vec<Option<&Solid>> = vec![None; voxels];
        for PlacedSolid { voxel: index, solid } in &self.solids {
            let is_surface = solid.wall.holds_centre() && !solid.strip && solid.opacity >= DENSE;
            let known = &mut surfaces[*index];
            if is_surface
                && known.is_none_or(|known| known.high_m < solid.high_m)
                && self.ground[*index] < solid.high_m
            {
                *known = Some(solid);
            }
        }
        surfaces
    }
}

/// Natural ground by tiles, as far as it was asked for.
#[derive(Debug, Default)]
pub(super) struct Tiles(HashMap<[u32; 2], Vec<f64>>);

impl Tiles {
    /// The tile whose south-west voxel is `first`, made by `make` unless it is there.
    pub(super) fn get(&mut self, first: [u32; 2], make: impl FnOnce() -> Result<Vec<f64>>) -> Result<&[f64]> {
        if !self.0.contains_key(&first) {
            if self.0.len() >= TILES {
                self.0.clear();
            }
            self.0.insert(first, make()?);
        }
        Ok(&self.0[&first])
    }
}

/// Least opacity of what is seen from afar as a surface.
pub(super) const DENSE: f64 = 0.4;

/// Tiles that are kept by each worker.
pub(super) const TILES: usize = 128;
