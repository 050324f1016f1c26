//! A fine picture as ground in cells of a pattern, of which windows are taken.

use std::path::PathBuf;

use glam::DVec2;

use super::window::{FineWindow, WINDOW_VOXELS};
use crate::bare::canvas;
use crate::budget::Budget;
use crate::drape::Drape;
use crate::feather::Sheets;
use crate::fineness::short;
use crate::inputs::Opener;
use crate::kernel::Samples;
use crate::opened::Opened;
use crate::options::{BuildOptions, ImageryFile};
use crate::placed::ImageryInput;
use crate::plan::Plan;
use crate::raster::{ImageryRaster, OpenOptions, open};
use crate::synthetic::TextureExamples;
use crate::warp::{LevelGrid, RasterPlacement, Rect, world};
use hedgehop::Size;
use hedgehop::voxel::Grid;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Silent;
use hedgehop_geo::{Crs, Transform};
use hedgehop_texture::CELLS_PER_VOXEL;

/// Windows that are looked at in all.
const MOST_WINDOWS: usize = 32;

/// Pixels that a voxel must be wide, so that an octave of them is below it.
const LEAST_PIXELS: f64 = 2.0;

/// Ways along both axes from one window to the next, in sides of the ground: their places are even, whatever their number (Roberts 2018, *The unreasonable
/// effectiveness of quasirandom sequences*).
const STEPS: DVec2 = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053);

/// Picture that is finer than the voxels, in cells.
pub(super) struct FineGround {
    input: ImageryInput,
    /// Cells of the picture.
    grid: Grid,
    /// First and last cell of the part that counts, eastward and northward.
    part: [DVec2; 2],
    /// Octaves below the voxel that the picture has.
    pub octaves: f64,
    /// Windows to take.
    count: usize,
}

/// Picture and the length of its pixels.
struct FinePicture {
    samples: Box<dyn Samples<[u8; 4]>>,
    path: PathBuf,
    /// Along columns and rows, metres.
    pixel: DVec2,
    /// First and last pixel of the part that counts, columns eastward and rows southward.
    part: [DVec2; 2],
}

impl FineGround {
    /// Opens the pictures that a build matches patterns from.
    ///
    /// # Errors
    /// One cannot be read, or none is fine enough.
    pub fn all(
        examples: &TextureExamples,
        plan: &Plan,
        options: &BuildOptions,
        budget: &Budget,
    ) -> Result<Vec<Self>> {
        let spacing = plan.grid.spacing;
        let pictures = match examples.files.is_empty() {
            true => FinePicture::of_build(plan, options, budget)?,
            false => FinePicture::named(examples, plan, options, budget)?,
        };
        let is_fine = |picture: &FinePicture| picture.pixel.max_element() * LEAST_PIXELS <= spacing;
        let finest = pictures.iter().map(|picture| picture.pixel.max_element()).fold(f64::INFINITY, f64::min);

        let fine: Vec<FinePicture> = pictures.into_iter().filter(is_fine).collect();
        if fine.is_empty() {
            let pixels = match finest.is_finite() {
                true => format!("the finest has pixels of {} m", short(finest)),
                false => "there is none".to_owned(),
            };
            return Err(Error::Configuration(format!(
                "[detail.imagery] pattern = \"match\" wants imagery at least twice as fine as the voxels of {spacing} m, but {pixels}; \
                 name a finer picture of such ground, examples = \"fine.tif\", or write pattern = \"broad\""
            )));
        }

        // Of many pictures some are looked at, all over the list.
        let count = MOST_WINDOWS.div_ceil(fine.len());
        let step = fine.len().div_ceil(MOST_WINDOWS);
        fine.into_iter().step_by(step).map(|picture| Self::new(picture, spacing, count)).collect()
    }

    /// Lays a picture out in cells.
    fn new(picture: FinePicture, spacing: f64, count: usize) -> Result<Self> {
        let FinePicture { samples, path, pixel, part } = picture;
        let Size { width, height } = samples.size();
        let sides = DVec2::new(f64::from(width), f64::from(height)) * pixel;
        let cell = spacing / CELLS_PER_VOXEL as f64;
        let cells = (sides / cell).map(f64::floor);
        let grid = Grid { nx: cells.x as u32, ny: cells.y as u32, spacing: cell, origin: DVec2::ZERO };

        // In metres of its own, north up.
        let geo = [0.0, pixel.x, 0.0, sides.y, 0.0, -pixel.y];
        let own = Crs::local();
        let placement = RasterPlacement::new(Transform::new(&own, &own)?, &geo, samples.size())
            .ok_or_else(|| Error::invalid(&path, "its pixels have no size"))?;
        let [first, last] = part.map(|at| DVec2::new(at.x * pixel.x, sides.y - at.y * pixel.y) / cell);
        Ok(Self {
            input: ImageryInput {
                samples,
                placement,
                pixel_side: pixel.element_product().sqrt(),
                reach: [0.0, 0.0, sides.x, sides.y],
            },
            grid,
            part: [first.min(last), first.max(last)],
            octaves: (spacing / pixel.max_element()).log2(),
            count,
        })
    }

    /// Takes windows that have no gaps.
    ///
    /// # Errors
    /// The picture cannot be read.
    pub fn windows(self, window_bytes: usize) -> Result<Vec<FineWindow>> {
        let Self { input, grid, part: [first, last], count, .. } = self;
        let side = (WINDOW_VOXELS * CELLS_PER_VOXEL) as u32;
        let last = last.min(DVec2::new(f64::from(grid.nx), f64::from(grid.ny)));
        let room = last - first - DVec2::splat(f64::from(side));
        if room.min_element() < 0.0 {
            return Ok(Vec::new());
        }

        let sources = [input];
        let sheets = Sheets::of(sources.iter().map(|input| (&input.placement, input.samples.size())), &grid);
        let level = LevelGrid { grid, level: 0 };
        let mut drape = Drape { sources: &sources, sheets, level, window_bytes, window: Vec::new() };
        let mut windows = Vec::new();
        for number in 0..count {
            let share = (0.5 + STEPS * number as f64).fract();
            let at = first + room * share;
            let (x0, y0) = (at.x as u32, at.y as u32);
            let cells = drape.pigments(Rect { x0, y0, x1: x0 + side, y1: y0 + side })?;
            windows.extend(FineWindow::new(&cells));
        }
        Ok(windows)
    }
}

impl FinePicture {
    /// Opens the imagery of a build again, of which the part in its area counts.
    fn of_build(plan: &Plan, options: &BuildOptions, budget: &Budget) -> Result<Vec<Self>> {
        let open_options = open_options(budget, options.imagery.len());
        let mut opener = Opener::new(options, open_options, &Silent);
        let elevation = options.elevation.first().map(|file| opener.elevation(file)).transpose()?;
        let canvas = elevation.and_then(|elevation| canvas(&[elevation]));
        let all = Rect { x0: 0, y0: 0, x1: plan.grid.nx, y1: plan.grid.ny };

        let mut pictures = Vec::new();
        for file in &options.imagery {
            let input = opener.imagery(file, canvas.as_ref())?;
            let (placement, reach) = input.place(plan)?;
            let Some(pixel) = pixel(&input, plan)?.filter(|_| all.meets(&reach, &plan.grid)) else {
                continue;
            };
            let part = pixels_of_area(&placement, &plan.grid, input.samples.size());
            pictures.push(Self { samples: input.samples, path: input.path, pixel, part });
        }
        Ok(pictures)
    }

    /// Opens the examples that a recipe names.
    fn named(
        examples: &TextureExamples,
        plan: &Plan,
        options: &BuildOptions,
        budget: &Budget,
    ) -> Result<Vec<Self>> {
        let open_options = open_options(budget, examples.files.len());
        let mut opener = Opener::new(options, open_options.clone(), &Silent);
        let mut pictures = Vec::new();
        for path in &examples.files {
            let (samples, pixel): (Box<dyn Samples<[u8; 4]>>, _) = match examples.pixel_m {
                Some(side) => {
                    (Box::new(ImageryRaster::new(open(path, &open_options)?, None)?), DVec2::splat(side))
                }
                None => {
                    let file = ImageryFile { path: path.clone(), ..ImageryFile::default() };
                    let input = opener.imagery(&file, None)?;
                    let told = || Error::invalid(path, "its pixels have no size in metres; say pixel_m");
                    let pixel = pixel(&input, plan)?.ok_or_else(told)?;
                    (input.samples, pixel)
                }
            };
            let Size { width, height } = samples.size();
            let part = [DVec2::ZERO, DVec2::new(f64::from(width), f64::from(height))];
            pictures.push(Self { samples, path: path.clone(), pixel, part });
        }
        Ok(pictures)
    }
}

/// Shares the memory of decoded blocks among pictures.
fn open_options(budget: &Budget, count: usize) -> OpenOptions {
    OpenOptions { cache_bytes: budget.cache / count.max(1) as u64, ..OpenOptions::default() }
}

/// Length of a picture's pixels along columns and rows, metres: of its own system, if that has any.
fn pixel(input: &Opened<[u8; 4]>, plan: &Plan) -> Result<Option<DVec2>> {
    let crs = if input.crs.is_metric() { &input.crs } else { &plan.crs };
    let sides = input.pixel_sides(crs)?.map(DVec2::from);
    Ok(sides.filter(|sides| sides.is_finite() && sides.min_element() > 0.0))
}

/// First and last pixel of a picture that may lie in an area.
fn pixels_of_area(placement: &RasterPlacement, grid: &Grid, size: Size) -> [DVec2; 2] {
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
        let (x, y) = world(grid, x * f64::from(grid.nx), y * f64::from(grid.ny));
        placement.pixel_from_world(x, y).map(DVec2::from)
    });
    let whole = [DVec2::ZERO, DVec2::new(f64::from(size.width), f64::from(size.height))];
    let Some(first) = corners.iter().flatten().copied().reduce(DVec2::min) else { return whole };
    let last = corners.iter().flatten().copied().fold(first, DVec2::max);
    [first, last].map(|corner| corner.clamp(whole[0], whole[1]))
}
