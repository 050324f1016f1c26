//! Preparation of clouds: from files to ground, colours and solids, stage after stage, tile by tile.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use super::super::budget::Budget;
use super::super::placed::{ElevationInput, ImageryInput};
use super::super::plan::Plan;
use super::super::workers::in_order;
use super::bin::bin;
use super::columns;
use super::open::Cloud;
use super::posts::{self, Post};
use super::raster::{self, TileArea};
use super::scene::TileScene;
use super::solids::CloudSolids;
use super::store::{CloudTile, Store, TILE};
use super::surface::{self, PostField};
use super::window::PointWindow;
use hedgehop_base::error::Result;
use hedgehop_base::progress::Observer;
use hedgehop_geo::VerticalDatum;

/// Bytes that a worker holds at most while it makes a tile: points of its voxels, and posts about them.
const TILE_WORK: u64 = 24 << 20;

/// Ground, colours and solids of all clouds of a build.
pub(crate) struct Prepared {
    /// Heights of the ground; `None`: no point lies in the area.
    pub elevation: Option<ElevationInput>,
    /// Colours of the ground; `None`: no point has one.
    pub imagery: Option<ImageryInput>,
    /// Solids that stand on it.
    pub cloud_solids: Option<CloudSolids>,
}

/// Makes ground, colours and solids of the points of all clouds, with heights above `datum`. Files without names beside `output` hold what
/// does not fit into memory.
pub(crate) fn prepare(
    clouds: &[Cloud],
    plan: &Plan,
    datum: VerticalDatum,
    output: &Path,
    budget: &Budget,
    observer: &dyn Observer,
) -> Result<Prepared> {
    let bins = bin(clouds, plan, datum, Store::beside(output, budget.cache / 2)?, observer)?;
    let making = Making {
        plan,
        output,
        threads: (budget.threads as u64).min(budget.cache / TILE_WORK).max(1) as usize,
        observer,
    };
    let spacing = plan.grid.spacing;
    let here: BTreeSet<CloudTile> = bins.tiles().filter(|tile| making.is_inside(*tile)).collect();
    let own = making.each("ground", &here, |tile| {
        let posts = posts::posts(&PointWindow::of(&bins, tile, posts::HALO)?, spacing);
        Ok(if posts.iter().any(|post| post.is_known() || post.flags != 0) { posts } else { Vec::new() })
    })?;
    let reach = surface::reach(spacing);
    let about = making.grown(own.tiles(), (reach + TILE - 1) / TILE);
    let filled = making.each("gaps", &about, |tile| {
        let posts = PostField::of(&own, tile, reach)?.filled();
        Ok(if posts.iter().any(Post::is_known) { posts } else { Vec::new() })
    })?;
    drop(own);
    let area: f64 = clouds.iter().map(|cloud| cloud.head.count as f64 / cloud.density).sum();
    let density = clouds.iter().map(|cloud| cloud.head.count as f64).sum::<f64>() / area * spacing * spacing;

    let cloud_solids = if clouds.iter().all(|cloud| cloud.ground_only || !cloud.look.is_classified()) {
        None
    } else {
        let solids = making.each("solids", &making.grown(here.iter().copied(), 1), |tile| {
            let window = PointWindow::of(&bins, tile, columns::HALO)?;
            let field = PostField::of(&filled, tile, columns::HALO)?;
            let ground = field.posts().map(|post| f64::from(post.height)).collect();
            Ok(columns::solids(&TileScene { window: &window, ground, spacing, density }))
        })?;
        let is_coloured = clouds.iter().any(Cloud::is_coloured);
        Some(CloudSolids::new(solids, &plan.grid, is_coloured)?)
    };

    let Some(area) = TileArea::of(&filled, &plan.grid)? else {
        return Ok(Prepared { elevation: None, imagery: None, cloud_solids: None });
    };

    let filled = Arc::new(filled);
    let elevation = raster::elevation(&filled, area, plan)?;
    let imagery = if area.is_coloured { Some(raster::imagery(&filled, area, plan)?) } else { None };

    Ok(Prepared { elevation: Some(elevation), imagery, cloud_solids })
}

/// Settings of how tiles are made.
struct Making<'a> {
    plan: &'a Plan,
    output: &'a Path,
    threads: usize,
    observer: &'a dyn Observer,
}

impl Making<'_> {
    fn is_inside(&self, tile: CloudTile) -> bool {
        let grid = &self.plan.grid;
        let inside = |tile: i64, voxels: u32| tile >= 0 && tile * TILE < i64::from(voxels);
        inside(tile.0, grid.nx) && inside(tile.1, grid.ny)
    }

    /// Tiles, and those up to so many around them.
    fn grown(&self, tiles: impl Iterator<Item = CloudTile>, rings: i64) -> BTreeSet<CloudTile> {
        let around = |tile: CloudTile| {
            (-rings..=rings)
                .flat_map(move |north| (-rings..=rings).map(move |east| (tile.0 + east, tile.1 + north)))
        };
        tiles.flat_map(around).filter(|tile| self.is_inside(*tile)).collect()
    }

    /// Makes the records of each tile.
    fn each<T: bytemuck::Pod + Send>(
        &self,
        stage: &str,
        tiles: &BTreeSet<CloudTile>,
        make: impl Fn(CloudTile) -> Result<Vec<T>> + Sync,
    ) -> Result<Store<T>> {
        let tiles: Vec<CloudTile> = tiles.iter().copied().collect();
        let mut store = Store::beside(self.output, 0)?;
        self.observer.begin(stage, tiles.len() as u64, "tiles");
        in_order(
            tiles.len() as u64,
            self.threads,
            self.observer,
            || (),
            |(), task| make(tiles[task as usize]),
            |task, made| {
                self.observer.advance(1);
                store.append(tiles[task as usize], &made)
            },
        )?;
        self.observer.end();
        Ok(store)
    }
}
