//! Solids of clouds, handed over block by block.

use super::super::features::{PlacedSolid, Solid, Wall};
use super::super::warp::{LevelGrid, Rect};
use super::class::PointKind;
use super::posts::Mix;
use super::scene::shaded;
use super::store::{Store, TILE};
use super::stored::StoredSolid;
use hedgehop::voxel::Grid;
use hedgehop_base::error::Result;

/// Least opacity of what is seen from afar as a surface.
const DENSE: f64 = 0.4;

/// Solids that stand on the ground of clouds.
#[derive(Debug)]
pub(crate) struct CloudSolids {
    store: Store<StoredSolid>,
    /// Height of the highest, metres; none stands if it is less than all heights.
    highest: f64,
    /// Whether points have colours of their own.
    pub is_coloured: bool,
}

/// Sums of the solids over a coarser voxel.
#[derive(Default)]
struct SolidPile {
    /// Finest voxels with something on them, and the sum of its heights.
    count: u32,
    sum: f64,
    mix: Mix,
    /// The first.
    solid: Option<Solid>,
}

impl CloudSolids {
    /// Builds the solids of a grid.
    pub(super) fn new(store: Store<StoredSolid>, grid: &Grid, is_coloured: bool) -> Result<Self> {
        let mut highest = f64::NEG_INFINITY;
        for tile in store.tiles() {
            store.read(tile, |solids| {
                highest = solids.iter().map(|solid| solid.top_m(grid.spacing)).fold(highest, f64::max);
            })?;
        }
        Ok(Self { store, highest, is_coloured })
    }

    /// Greatest height of ground up to `high` and of what stands on it, metres.
    pub fn highest(&self, high: f64) -> f64 {
        self.highest.max(high)
    }

    /// Solids over a block of voxels of a level.
    pub fn solids(&self, rect: Rect, level: &LevelGrid) -> Result<Vec<PlacedSolid>> {
        let side = i64::from(Grid::side_units(level.level));
        let low = [i64::from(rect.x0) * side, i64::from(rect.y0) * side];
        let high = [i64::from(rect.x1) * side, i64::from(rect.y1) * side];
        let mut found = Vec::new();
        let mut piles = Vec::new();
        piles.resize_with(if side > 1 { rect.len() } else { 0 }, SolidPile::default);
        let range = |axis: usize| low[axis].div_euclid(TILE)..=(high[axis] - 1).div_euclid(TILE);

        for tile in range(1).flat_map(|row| range(0).map(move |column| (column, row))) {
            self.store.read(tile, |solids| {
                for stored in solids {
                    let voxel = [
                        tile.0 * TILE + i64::from(stored.voxel[0]),
                        tile.1 * TILE + i64::from(stored.voxel[1]),
                    ];
                    if (0..2).any(|axis| voxel[axis] < low[axis] || voxel[axis] >= high[axis]) {
                        continue;
                    }

                    let index = rect.index((voxel[0] / side) as u32, (voxel[1] / side) as u32);
                    match piles.get_mut(index) {
                        Some(pile) => SolidPile::add(pile, stored.solid()),
                        None => found.push(stored.solid().over(index)),
                    }
                }
            })?;
        }

        let least = (side * side) as u32 / 2;
        found.extend(
            piles.iter().enumerate().filter_map(|(index, pile)| Some(pile.solid(least)?.over(index))),
        );
        Ok(found)
    }
}

/// Gives roofs, decks and plants the colours that the ground below them has in imagery, if it has; wires and towers are seen too thinly there.
pub(crate) fn drape(solids: &mut [PlacedSolid], colour: impl Fn(usize) -> Option<[u8; 3]>) {
    let is_broad = |solid: &Solid| !solid.strip && solid.material != PointKind::Tower.paint().material.code();
    for PlacedSolid { voxel, solid } in solids.iter_mut().filter(|placed| is_broad(&placed.solid)) {
        if let Some(colour) = colour(*voxel) {
            (solid.top, solid.side) = (colour, shaded(colour));
        }
    }
}

impl SolidPile {
    fn add(&mut self, solid: Solid) {
        if solid.opacity >= DENSE && !solid.strip {
            self.count += 1;
            self.sum += solid.high_m;
            self.mix.add(Some(solid.top), 1.0);
            self.solid.get_or_insert(solid);
        }
    }

    /// Makes a solid as high as they are in the mean, if they cover half of the voxel.
    fn solid(&self, least: u32) -> Option<Solid> {
        let solid = self.solid.filter(|_| self.count > least)?;
        Some(Solid {
            low_m: None,
            high_m: self.sum / f64::from(self.count),
            slope: [0.0; 2],
            wall: Wall::Whole,
            top: self.mix.srgb().unwrap_or(solid.top),
            ..solid
        })
    }
}
