//! Features on the ground of a database: what they make of its voxels.
//!
//! ```text
//! once:      layers → features in the database's system → bound to the ground, as the rasters have it
//! a block:   natural ground, some voxels around included
//!            → graded: roads and runways cut in, lakes levelled, surfaces painted      bare ground
//!            → solids over each voxel                                                  spans
//!            → the highest of them that is dense and holds the voxel's centre          the surface
//! ```
//!
//! What a voxel gets depends on the features that reach it and on the natural ground about it, never on the block that is made.

use std::cell::RefCell;
use std::collections::HashMap;

use glam::DVec2;

use super::features::{self, Bound, Graded, Ground, Layer, LayerOptions, Paint, Solid, Square, Wall};
use super::page::PageMaker;
use super::plan::Plan;
use super::warp::{LevelGrid, Rect};
use crate::error::Result;
use crate::voxel::{Grid, PAGE_SIDE};

/// Least opacity of what is seen from afar as a surface.
const DENSE: f64 = 0.4;

/// Voxels along a tile of natural ground that features are bound to.
const TILE: u32 = 64;
/// Tiles that are kept.
const TILES: usize = 256;

/// Features of a database, by where they are.
#[derive(Debug, Default)]
pub(super) struct Standing {
    bound: Vec<Bound>,
    /// West, south, east, north of what each may change, metres.
    reaches: Vec<[f64; 4]>,
    /// Their numbers, by cell of a page's side of level index 0.
    cells: HashMap<(i64, i64), Vec<u32>>,
    cell: f64,
    origin: DVec2,
    /// Farthest that one of them asks for ground beside a voxel, metres.
    margin: f64,
}

/// What features make of a block of voxels, all `[rows][columns]` of it.
pub(super) struct Built {
    /// Heights of the bare ground, metres; NaN where there is none.
    pub ground: Vec<f64>,
    /// Surfaces of the bare ground: voxel, surface, and share of the voxel, in the order in which they lie on each other.
    pub paints: Vec<(usize, Paint, f64)>,
    /// Solids by voxel, in no order.
    pub solids: Vec<(usize, Solid)>,
    /// Which of them have no colours of their own.
    pub uncoloured: std::ops::Range<usize>,
}

impl Standing {
    /// Binds what layers have to the ground that `maker` makes. Returns notes on what is left out, too.
    pub fn bind(
        layers: &[(Layer, LayerOptions)],
        plan: &Plan,
        maker: PageMaker<'_>,
    ) -> Result<(Self, Vec<String>)> {
        let grid = &plan.grid;
        let (low, high) = (grid.origin, grid.far_corner());
        let mut notes = Vec::new();
        let mut placed = Vec::new();
        for (layer, options) in layers {
            let (features, told) =
                features::place(layer, options, &plan.crs, [low.x, low.y, high.x, high.y])?;
            placed.extend(features);
            notes.extend(layer.notes.iter().cloned().chain(told));
        }
        let natural = Natural {
            grid: *grid,
            state: RefCell::new(State { maker, tiles: HashMap::new(), failed: None }),
        };
        let bound = features::bind_all(placed, &natural);
        if let Some(error) = natural.state.into_inner().failed {
            return Err(error);
        }
        Ok((Self::new(bound, grid), notes))
    }

    fn new(bound: Vec<Bound>, grid: &Grid) -> Self {
        let (cell, origin) = (grid.spacing * f64::from(PAGE_SIDE), grid.origin);
        let reaches: Vec<_> = bound.iter().map(|bound| bound.reach(grid.spacing)).collect();
        let mut cells: HashMap<_, Vec<u32>> = HashMap::new();
        for (index, reach) in reaches.iter().enumerate() {
            // What reaches beyond the area is asked for within it alone.
            let far = grid.far_corner();
            let [west, south, east, north] = *reach;
            let within = [west.max(origin.x), south.max(origin.y), east.min(far.x), north.min(far.y)];
            for key in cells_of(within, origin, cell) {
                cells.entry(key).or_default().push(index as u32);
            }
        }
        let margin = bound.iter().map(Bound::margin).fold(0.0, f64::max);
        Self { bound, reaches, cells, cell, origin, margin }
    }

    /// Least and greatest height that features may bring about, metres, if natural ground lies between `low` and `high`.
    pub fn heights(&self, low: f64, high: f64, spacing: f64) -> (f64, f64) {
        let top = self.bound.iter().map(|bound| bound.highest(high, spacing));
        (low, top.fold(high, f64::max))
    }

    /// Numbers of features that may change voxels within an area, in their order.
    fn within(&self, area: [f64; 4]) -> Vec<u32> {
        let cells = cells_of(area, self.origin, self.cell);
        let mut found: Vec<u32> = cells.filter_map(|key| self.cells.get(&key)).flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        let [west, south, east, north] = area;
        found.retain(|&index| {
            let reach = &self.reaches[index as usize];
            reach[0] <= east && reach[2] >= west && reach[1] <= north && reach[3] >= south
        });
        found
    }

    /// How many voxels of a level around a block its features may ask for; `None`: none reaches it.
    pub fn margin(&self, rect: Rect, level: &LevelGrid) -> Option<u32> {
        let margin = (self.margin / level.grid.spacing).ceil() as u32 + 2;
        let wide = rect.grown(margin, &level.grid);
        (!self.within(square(wide, &level.grid).bounds()).is_empty()).then_some(margin)
    }

    /// What features make of a block, `natural` being the heights of the voxels of `wide` about it (metres, NaN where there is none).
    pub fn build(&self, rect: Rect, (wide, natural): (Rect, &[f64]), level: &LevelGrid) -> Built {
        let around = square(wide, &level.grid);
        let bound: Vec<&Bound> =
            self.within(around.bounds()).into_iter().map(|index| &self.bound[index as usize]).collect();
        let graded: Vec<Graded> = bound.iter().flat_map(|bound| bound.grade(&around, natural)).collect();
        let mut heights = natural.to_vec();
        let mut paints = Vec::new();
        let inside = |index: usize| {
            let (x, y) = wide.voxel(index);
            let is_in = (rect.x0..rect.x1).contains(&x) && (rect.y0..rect.y1).contains(&y);
            is_in.then(|| rect.index(x, y))
        };
        features::settle(graded, &mut heights, |index, paint, share| {
            paints.extend(inside(index).map(|index| (index, paint, share)));
        });
        let mut solids = Vec::new();
        let here = square(rect, &level.grid);
        let ground = |place: DVec2| between(&around, natural, place);
        bound.iter().for_each(|bound| bound.raise(&here, &ground, &mut solids));
        let ground =
            (0..rect.len()).map(|index| rect.voxel(index)).map(|(x, y)| heights[wide.index(x, y)]).collect();
        Built { ground, paints, solids, uncoloured: 0..0 }
    }
}

impl Built {
    /// Nothing on this ground.
    pub fn on(natural: &[f64]) -> Self {
        Self { ground: natural.to_vec(), paints: Vec::new(), solids: Vec::new(), uncoloured: 0..0 }
    }

    /// The solid that is the surface over each voxel of so many, if one is: the highest that is dense and holds the voxel's centre.
    pub fn surfaces(&self, voxels: usize) -> Vec<Option<&Solid>> {
        let mut surfaces: Vec<Option<&Solid>> = vec![None; voxels];
        for (index, solid) in &self.solids {
            let holds_centre = !matches!(solid.wall, Wall::Plane { distance_m, .. } if distance_m < 0.0);
            let is_surface = holds_centre && !solid.strip && solid.opacity >= DENSE;
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

/// Natural ground anywhere, tile by tile.
struct Natural<'a> {
    grid: Grid,
    state: RefCell<State<'a>>,
}

struct State<'a> {
    maker: PageMaker<'a>,
    tiles: HashMap<(u32, u32), Vec<f64>>,
    /// What went wrong first.
    failed: Option<crate::error::Error>,
}

impl Natural<'_> {
    /// Height of a post, metres; NaN where there is none.
    fn post(&self, x: u32, y: u32) -> f64 {
        let key = (x / TILE, y / TILE);
        let (x0, y0) = (key.0 * TILE, key.1 * TILE);
        let rect = Rect { x0, y0, x1: (x0 + TILE).min(self.grid.nx), y1: (y0 + TILE).min(self.grid.ny) };
        let state = &mut *self.state.borrow_mut();
        if !state.tiles.contains_key(&key) {
            if state.tiles.len() >= TILES {
                state.tiles.clear();
            }
            let heights = state.maker.natural(rect).unwrap_or_else(|error| {
                state.failed.get_or_insert(error);
                vec![f64::NAN; rect.len()]
            });
            state.tiles.insert(key, heights);
        }
        state.tiles.get(&key).map_or(f64::NAN, |heights| heights[rect.index(x, y)])
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
