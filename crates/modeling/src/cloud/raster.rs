//! Posts as rasters: heights and colours in the database's grid.

use std::sync::Arc;

use super::super::kernel::Samples;
use super::super::placed::{ElevationInput, ImageryInput};
use super::super::plan::Plan;
use super::super::synthetic::Lattice;
use super::super::vertical::Shift;
use super::super::warp::RasterPlacement;
use super::posts::Post;
use super::store::{CloudTile, Store, TILE};
use crate::raster::{GeoTransform, Window};
use hedgehop::Size;
use hedgehop::voxel::Grid;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Transform;

/// The voxels that have posts.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileArea {
    /// South-west voxel.
    first: [i64; 2],
    /// Voxels eastward and northward.
    size: [i64; 2],
    /// Whether some have colours.
    pub is_coloured: bool,
}

impl TileArea {
    /// The least that holds all posts in the grid.
    pub fn of(store: &Store<Post>, grid: &Grid) -> Result<Option<Self>> {
        let (mut low, mut high, mut is_coloured) = ([i64::MAX; 2], [i64::MIN; 2], false);
        let last = [grid.nx, grid.ny].map(|voxels| i64::from(voxels) - 1);
        for tile in store.tiles() {
            each(store, tile, |voxel, post| {
                if post.is_known() && voxel[0] <= last[0] && voxel[1] <= last[1] {
                    low = [low[0].min(voxel[0]), low[1].min(voxel[1])];
                    high = [high[0].max(voxel[0]), high[1].max(voxel[1])];
                    is_coloured |= post.srgb().is_some();
                }
            })?;
        }
        let size = [high[0].saturating_sub(low[0]) + 1, high[1].saturating_sub(low[1]) + 1];
        Ok((low[0] <= high[0]).then_some(Self { first: low, size, is_coloured }))
    }

    fn size(&self) -> Size {
        Size { width: self.size[0] as u32, height: self.size[1] as u32 }
    }

    /// West, south, east, north, metres.
    fn bounds(&self, grid: &Grid) -> [f64; 4] {
        let at = |axis: usize, step: i64| (self.first[axis] + step) as f64 * grid.spacing;
        let (x, y) = (grid.origin.x, grid.origin.y);
        [x + at(0, 0), y + at(1, 0), x + at(0, self.size[0]), y + at(1, self.size[1])]
    }

    fn place(&self, plan: &Plan) -> Result<(RasterPlacement, [f64; 4])> {
        let [west, south, east, north] = self.bounds(&plan.grid);
        let side = plan.grid.spacing;
        let geo: GeoTransform = [west, side, 0.0, north, 0.0, -side];
        let placement = RasterPlacement::new(Transform::new(&plan.crs, &plan.crs)?, &geo, self.size());
        let placement = placement
            .ok_or_else(|| Error::Configuration(format!("--spacing is {side}, which is too little")))?;
        // Kernels hang over the edge.
        let room = 2.0 * plan.grid.side(plan.stored.outside());
        Ok((placement, [west - room, south - room, east + room, north + room]))
    }
}

/// Hands over the posts of a tile with their voxels.
fn each(store: &Store<Post>, tile: CloudTile, mut take: impl FnMut([i64; 2], &Post)) -> Result<()> {
    let mut next = 0_i64;
    store.read(tile, |posts| {
        for post in posts {
            take([tile.0 * TILE + next % TILE, tile.1 * TILE + next / TILE], post);
            next += 1;
        }
    })
}

/// One of the things that posts say, as a raster.
struct TilePosts<F> {
    store: Arc<Store<Post>>,
    area: TileArea,
    sample: F,
}

impl<T: Copy, F: Fn(&Post) -> T + Send + Sync> Samples<T> for TilePosts<F> {
    fn size(&self) -> Size {
        self.area.size()
    }

    fn read(&self, window: Window, samples: &mut Vec<T>) -> Result<()> {
        let (width, height) = (i64::from(window.width), i64::from(window.height));
        samples.clear();
        samples.resize((width * height) as usize, (self.sample)(&Post::NONE));

        // Rows of rasters go southward.
        let west = self.area.first[0] + i64::from(window.x);
        let north = self.area.first[1] + self.area.size[1] - 1 - i64::from(window.y);
        let south = north - height + 1;
        let range = |low: i64, high: i64| low.div_euclid(TILE)..=high.div_euclid(TILE);

        for row in range(south, north) {
            for column in range(west, west + width - 1) {
                each(&self.store, (column, row), |voxel, post| {
                    let (x, y) = (voxel[0] - west, north - voxel[1]);
                    if (0..width).contains(&x) && (0..height).contains(&y) {
                        samples[(y * width + x) as usize] = (self.sample)(post);
                    }
                })?;
            }
        }

        Ok(())
    }
}

/// Heights of posts in the grid.
pub(super) fn elevation(store: &Arc<Store<Post>>, area: TileArea, plan: &Plan) -> Result<ElevationInput> {
    let (placement, reach) = area.place(plan)?;
    let sample = |post: &Post| f64::from(post.height);
    let samples = Box::new(TilePosts { store: store.clone(), area, sample });
    let (block, pixel_side) = (Size { width: 256, height: 256 }, plan.grid.spacing);
    Ok(ElevationInput {
        samples,
        block,
        placement,
        shift: Shift::Zero,
        pixel_side,
        lattice: Lattice::SQUARES,
        reach,
    })
}

/// Colours of posts in the grid.
pub(super) fn imagery(store: &Arc<Store<Post>>, area: TileArea, plan: &Plan) -> Result<ImageryInput> {
    let (placement, reach) = area.place(plan)?;
    let sample = |post: &Post| post.srgb().map_or([0; 4], |[red, green, blue]| [red, green, blue, 255]);
    let samples = Box::new(TilePosts { store: store.clone(), area, sample });
    Ok(ImageryInput { samples, placement, pixel_side: plan.grid.spacing, reach })
}
