//! Features on the ground of a database: what they make of its voxels.
//!
//! ```text
//! once:      layers → features in the database's system
//! a feature: bound to the ground, as the rasters have it, as soon as a page asks for it
//! a block:   natural ground, some voxels around included
//!            → graded: roads and runways cut in, lakes levelled, surfaces painted      bare ground
//!            → solids over each voxel                                                  spans
//!            → the highest of them that is dense and holds the voxel's centre          the surface
//! ```
//!
//! What a voxel gets depends on the features that reach it and on the natural ground about it, never on the block that is made.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::OnceLock;

use glam::DVec2;

use super::build_cache::{BuildCache, Extent, Key, Keyer};
use super::features::{self, Bound, Feature, Graded, Ground, Rank, Square};
use super::groves::Groves;
use super::inputs::FeatureInput;
use super::natural::{NaturalBlock, NaturalGround};
use super::placing::Collection;
use super::plan::Plan;
use super::warp::{LevelGrid, Rect};
use super::workers::in_order;
use crate::built::Built;
use hedgehop::voxel::{Grid, PAGE_SIDE};
use hedgehop_base::error::Result;
use hedgehop_base::progress::Observer;

/// Voxels along a tile of natural ground that features are bound to.
const TILE: u32 = 64;
/// Features of a database, by where they are.
#[derive(Debug, Default)]
pub(super) struct FeatureSolids {
    features: Vec<Feature>,
    /// Groves: their trees that are objects.
    groves: Groves,
    /// Keys of what each of them is; empty if steps are not kept.
    keys: Vec<Key>,
    /// Extents of what each of them may change.
    extents: Vec<Extent>,
    /// Each on its ground, as soon as it was asked for.
    bound: Vec<OnceLock<Vec<Bound>>>,
    /// Numbers of features, by cell of a page's side of level index 0.
    cells: HashMap<(i64, i64), Vec<u32>>,
    cell: f64,
    origin: DVec2,
    /// Farthest that one of them asks for ground beside a voxel, metres.
    margin: f64,
}

/// Features of layers that may reach the area, and notes on what is left out.
pub(super) fn place(layers: &[FeatureInput], plan: &Plan) -> Result<(Vec<Feature>, Vec<String>)> {
    let (low, high) = (plan.grid.origin, plan.grid.far_corner());
    let mut notes = Vec::new();
    let mut placed = Vec::new();
    for FeatureInput { layer, options } in layers {
        let (features, told) = features::place(layer, options, &plan.crs, [low.x, low.y, high.x, high.y])?;
        placed.extend(features);
        notes.extend(layer.notes.iter().cloned().chain(told));
    }
    features::prepare(&mut placed);
    Ok((placed, notes))
}

impl FeatureSolids {
    /// Finds out what each feature may change on ground that `ground` makes, up to `highest` metres high. Those that `cache` knows need not
    /// be bound for that; `ground` is the key of all elevation.
    pub fn new<G: NaturalGround>(
        features: Vec<Feature>,
        ground: impl Fn() -> G + Sync,
        highest: f64,
        cache: Option<(&BuildCache, Key)>,
        threads: usize,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let grid = ground().grid();
        let key = |feature: &Feature| {
            let ground = cache.map(|(_, ground)| ground)?;
            Some(Keyer::of("feature").with_key(ground).with(&highest).with(feature).key())
        };
        let keys: Vec<Key> = features.iter().filter_map(key).collect();
        let bound = features.iter().map(|_| OnceLock::new()).collect();
        let mut feature_solids = Self { features, keys, bound, ..Self::default() };
        let mut extents = Vec::with_capacity(feature_solids.features.len());
        observer.begin("features", feature_solids.features.len() as u64, "features");

        in_order(
            feature_solids.features.len() as u64,
            threads,
            observer,
            &ground,
            |maker, index| {
                let known =
                    cache.and_then(|(cache, _)| cache.extent(*feature_solids.keys.get(index as usize)?));
                known.map_or_else(|| feature_solids.extent(index as usize, maker, highest), Ok)
            },
            |index, extent| {
                if let (Some((cache, _)), Some(key)) = (cache, feature_solids.keys.get(index as usize)) {
                    cache.bound(*key, &extent);
                }
                extents.push(extent);
                observer.advance(1);
                Ok(())
            },
        )?;

        observer.end();
        feature_solids.extents = extents;
        feature_solids.sort_in(&grid);

        Ok(feature_solids)
    }

    /// Adds the trees of its woods to the objects that the database places.
    pub fn share(&mut self, spacing: f64, objects: &mut Collection<'_>) {
        self.groves = Groves::of(&self.features, spacing, objects);
    }

    /// Finds what a feature may change.
    fn extent(&self, index: usize, maker: &mut dyn NaturalGround, highest: f64) -> Result<Extent> {
        let spacing = maker.grid().spacing;
        let bound = self.bind(index, maker)?;
        let reaches = bound.iter().map(|bound| bound.reach(spacing));
        let joined =
            |a: [f64; 4], b: [f64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
        Ok(Extent {
            reach: reaches.reduce(joined).unwrap_or([f64::NAN; 4]),
            margin: bound.iter().map(Bound::margin).fold(0.0, f64::max),
            highest: bound.iter().map(|bound| bound.highest(highest, spacing)).fold(f64::MIN, f64::max),
        })
    }

    /// A feature on the ground that `maker` makes.
    fn bind(&self, index: usize, maker: &mut dyn NaturalGround) -> Result<&[Bound]> {
        if let Some(bound) = self.bound[index].get() {
            return Ok(bound);
        }
        let natural = Natural { grid: maker.grid(), state: RefCell::new((maker, None)) };
        let Feature { meaning, geometry, hash } = &self.features[index];
        let bound = features::bind(meaning, geometry, *hash, &natural);
        match natural.state.into_inner().1 {
            Some(error) => Err(error),
            None => Ok(self.bound[index].get_or_init(|| bound)),
        }
    }

    /// Sorts features in cells of a grid.
    fn sort_in(&mut self, grid: &Grid) {
        (self.cell, self.origin) = (grid.spacing * f64::from(PAGE_SIDE), grid.origin);
        for (index, extent) in self.extents.iter().enumerate() {
            // What reaches beyond the area is asked for within it alone.
            let far = grid.far_corner();
            let [west, south, east, north] = extent.reach;
            if west.is_nan() {
                continue;
            }
            let within =
                [west.max(self.origin.x), south.max(self.origin.y), east.min(far.x), north.min(far.y)];
            for key in cells_of(within, self.origin, self.cell) {
                self.cells.entry(key).or_default().push(index as u32);
            }
        }
        self.margin = self.extents.iter().map(|extent| extent.margin).fold(0.0, f64::max);
    }

    /// Greatest height that features may bring about, metres, if natural ground lies between `low` and `high`. Of what rises above
    /// that the next power of two counts, in metres: what is built a little higher then leaves the code of heights, and with it all pages
    /// that it does not stand on, as they are.
    pub fn highest(&self, high: f64) -> f64 {
        with_room(high, self.extents.iter().map(|extent| extent.highest).fold(high, f64::max))
    }

    /// Numbers of features that may change voxels within an area, in their order.
    fn within(&self, area: [f64; 4]) -> Vec<u32> {
        let cells = cells_of(area, self.origin, self.cell);
        let mut found: Vec<u32> = cells.filter_map(|key| self.cells.get(&key)).flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        let [west, south, east, north] = area;
        found.retain(|&index| {
            let reach = &self.extents[index as usize].reach;
            reach[0] <= east && reach[2] >= west && reach[1] <= north && reach[3] >= south
        });
        found
    }

    /// Keys of features that may change voxels of a block of a level, in their order.
    pub fn keys_around(&self, rect: Rect, level: &LevelGrid) -> Vec<Key> {
        let wide = rect.grown(self.voxels_asked(level), &level.grid);
        let found = self.within(square(wide, &level.grid).bounds());
        found.into_iter().filter_map(|index| self.keys.get(index as usize).copied()).collect()
    }

    /// Returns how many voxels of a level around a block features may ask for at most.
    fn voxels_asked(&self, level: &LevelGrid) -> u32 {
        (self.margin / level.grid.spacing).ceil() as u32 + 2
    }

    /// Returns how many voxels of a level around a block its features may ask for; `None`: none reaches it.
    pub fn margin(&self, rect: Rect, level: &LevelGrid) -> Option<u32> {
        let margin = self.voxels_asked(level);
        let wide = rect.grown(margin, &level.grid);
        (!self.within(square(wide, &level.grid).bounds()).is_empty()).then_some(margin)
    }

    /// Raises the features of a block, `natural` being its ground and that of the voxels about it; `maker` makes the ground of those that were
    /// not bound yet.
    pub fn build(
        &self,
        rect: Rect,
        natural: NaturalBlock<'_>,
        level: &LevelGrid,
        maker: &mut dyn NaturalGround,
    ) -> Result<Built> {
        let NaturalBlock { rect: wide, heights: natural } = natural;
        let around = square(wide, &level.grid);
        let mut bound: Vec<&Bound> = Vec::new();
        for index in self.within(around.bounds()) {
            bound.extend(self.bind(index as usize, maker)?);
        }

        let graded: Vec<Graded> = bound.iter().flat_map(|bound| bound.grade(&around, natural)).collect();
        let mut heights = natural.to_vec();
        let (mut paints, mut bare) = (Vec::new(), Vec::new());
        let inside = |index: usize| {
            let (x, y) = wide.voxel(index);
            let is_in = (rect.x0..rect.x1).contains(&x) && (rect.y0..rect.y1).contains(&y);
            is_in.then(|| rect.index(x, y))
        };
        features::settle(graded, &mut heights, |index, paint, share, rank| {
            let on = if rank == Rank::Ground { &mut bare } else { &mut paints };
            on.extend(inside(index).map(|index| (index, paint, share)));
        });
        let (mut solids, mut placed) = (Vec::new(), Vec::new());
        let here = square(rect, &level.grid);
        let ground = |place: DVec2| between(&around, natural, place);

        for bound in bound {
            match bound {
                Bound::Wood(wood) if level.level == 0 => {
                    for tree in wood.trees(&here, &ground) {
                        match self.groves.placed(&tree, &level.grid, &maker.code()) {
                            Some(found) => placed.push(found),
                            None => tree.raise(&here, &mut solids),
                        }
                    }
                }
                bound => bound.raise(&here, &ground, &mut solids),
            }
        }

        let ground =
            (0..rect.len()).map(|index| rect.voxel(index)).map(|(x, y)| heights[wide.index(x, y)]).collect();
        Ok(Built { ground, paints, natural: bare, solids, placed, uncoloured: 0..0 })
    }
}

/// `high`, and as much of a power of two of metres above it as holds `top`.
pub(super) fn with_room(high: f64, top: f64) -> f64 {
    let mut room = 0.0;
    while high + room < top {
        room = if room == 0.0 { 8.0 } else { 2.0 * room };
    }
    high + room
}

/// Cells that an area touches.
fn cells_of(
    [west, south, east, north]: [f64; 4],
    origin: DVec2,
    cell: f64,
) -> impl Iterator<Item = (i64, i64)> {
    let range = |low: f64, high: f64, from: f64| {
        ((low - from) / cell).floor() as i64..=((high - from) / cell).floor() as i64
    };
    let columns = range(west, east, origin.x);
    range(south, north, origin.y).flat_map(move |row| columns.clone().map(move |column| (column, row)))
}

/// A block in metres.
fn square(rect: Rect, grid: &Grid) -> Square {
    let first = [i64::from(rect.x0), i64::from(rect.y0)];
    Square { origin: grid.origin, first, spacing: grid.spacing, columns: rect.width(), rows: rect.height() }
}

/// Height between the posts of a square, which go on as its outermost beside it; `None` where there is none.
fn between(square: &Square, heights: &[f64], place: DVec2) -> Option<f64> {
    let last = DVec2::new(square.columns as f64, square.rows as f64) - 1.0;
    let at = (square.local(place) - 0.5).clamp(DVec2::ZERO, last);
    let [column, row] = [at.x as usize, at.y as usize];
    let share = at.fract();
    let (east, north) = ((column + 1).min(square.columns - 1), (row + 1).min(square.rows - 1));
    let height = |column: usize, row: usize| heights[square.index(column, row)];
    let line = |row: usize| height(column, row) * (1.0 - share.x) + height(east, row) * share.x;
    let height = line(row) * (1.0 - share.y) + line(north) * share.y;
    (!height.is_nan()).then_some(height)
}

/// Natural ground anywhere, and what went wrong first while it was made.
struct Natural<'m> {
    grid: Grid,
    state: RefCell<(&'m mut dyn NaturalGround, Option<hedgehop_base::error::Error>)>,
}

impl Natural<'_> {
    /// Height of a post, metres; NaN where there is none.
    fn post(&self, x: u32, y: u32) -> f64 {
        let (x0, y0) = (x / TILE * TILE, y / TILE * TILE);
        let rect = Rect { x0, y0, x1: (x0 + TILE).min(self.grid.nx), y1: (y0 + TILE).min(self.grid.ny) };
        let (maker, failed) = &mut *self.state.borrow_mut();
        let mut tiles = std::mem::take(maker.tiles());
        let height = tiles.get([x0, y0], || maker.natural(rect)).map(|heights| heights[rect.index(x, y)]);
        *maker.tiles() = tiles;
        height.unwrap_or_else(|error| {
            failed.get_or_insert(error);
            f64::NAN
        })
    }
}

impl Ground for Natural<'_> {
    fn height_at(&self, place: DVec2) -> Option<f64> {
        let far = self.grid.far_corner();
        if !(place.cmpge(self.grid.origin).all() && place.cmple(far).all()) {
            return None;
        }
        let last = DVec2::new(f64::from(self.grid.nx), f64::from(self.grid.ny)) - 1.0;
        let at = ((place - self.grid.origin) / self.grid.spacing - 0.5).clamp(DVec2::ZERO, last);
        let (x, y, share) = (at.x as u32, at.y as u32, at.fract());
        let (east, north) = ((x + 1).min(self.grid.nx - 1), (y + 1).min(self.grid.ny - 1));
        let line = |y: u32| self.post(x, y) * (1.0 - share.x) + self.post(east, y) * share.x;
        let height = line(y) * (1.0 - share.y) + line(north) * share.y;
        (!height.is_nan()).then_some(height)
    }
}
