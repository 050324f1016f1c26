//! Rasters in memory, and databases to be looked into.

use std::path::{Path, PathBuf};

use crate::budget::Budget;
use crate::inputs::Inputs;
use crate::kernel::Samples;
use crate::opened::Opened;
use crate::raster::{GeoTransform, Window};
use crate::{BuildOptions, build};
use hedgehop::Size;
use hedgehop::voxel::{Attributes, Grid, MemPages, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::error::Result;
use hedgehop_base::progress::Silent;
use hedgehop_geo::{Crs, VerticalDatum};

/// A raster that lies in memory.
struct Sheet<T> {
    size: (u32, u32),
    samples: Vec<T>,
}

impl<T: Copy + Send + Sync> Samples<T> for Sheet<T> {
    fn size(&self) -> Size {
        Size { width: self.size.0, height: self.size.1 }
    }
    fn read(&self, window: Window, samples: &mut Vec<T>) -> Result<()> {
        samples.clear();
        for y in window.y..window.y + window.height {
            let start = y as usize * self.size.0 as usize + window.x as usize;
            samples.extend_from_slice(&self.samples[start..start + window.width as usize]);
        }
        Ok(())
    }
}

/// A raster whose pixel (column, row) is `sample(column, row)`.
pub fn sheet<T: Copy + Send + Sync + 'static>(
    crs: &Crs,
    geo: GeoTransform,
    size: (u32, u32),
    sample: impl Fn(u32, u32) -> T,
) -> Opened<T> {
    sheet_of(crs, geo, size, &sample)
}

/// Makes a raster of samples; compiled once for all closures.
fn sheet_of<T: Copy + Send + Sync + 'static>(
    crs: &Crs,
    geo: GeoTransform,
    size: (u32, u32),
    sample: &dyn Fn(u32, u32) -> T,
) -> Opened<T> {
    let samples = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
    let samples = samples.map(|(column, row)| sample(column, row)).collect();
    Opened {
        facts: String::new(),
        path: PathBuf::from("memory.tif"),
        samples: Box::new(Sheet { size, samples }),
        block: Size { width: 64, height: 64 },
        geo,
        crs: crs.clone(),
        datum: VerticalDatum::Msl,
        description: "in memory".into(),
    }
}

/// North-up pixels of `side` metres with the north-west corner at (x, y).
pub fn north_up(x: f64, y: f64, side: f64) -> GeoTransform {
    [x, side, 0.0, y, 0.0, -side]
}

/// Heights `height(x, y)` at pixel centres.
pub fn terrain(
    crs: &Crs,
    geo: GeoTransform,
    size: (u32, u32),
    height: impl Fn(f64, f64) -> f64,
) -> Opened<f64> {
    sheet(crs, geo, size, |column, row| {
        let (x, y) = crate::warp::apply(&geo, f64::from(column) + 0.5, f64::from(row) + 0.5);
        height(x, y)
    })
}

/// Options for a build in a folder.
pub fn options(folder: &Path) -> BuildOptions {
    BuildOptions {
        overwrite: true,
        threads: 2,
        ..BuildOptions::new(Vec::new(), Vec::new(), folder.join("area.hop"))
    }
}

/// A finished database in memory.
pub struct Area {
    pub pages: MemPages,
    pub bytes: Vec<u8>,
    pub grid: Grid,
}

/// Builds from rasters in memory; `adjust` changes the options.
pub fn try_build(
    elevation: Vec<Opened<f64>>,
    imagery: Vec<Opened<[u8; 4]>>,
    adjust: impl Fn(&mut BuildOptions),
) -> Result<Area> {
    try_build_with(elevation, imagery, &adjust)
}

/// Builds a database; compiled once for all closures.
fn try_build_with(
    elevation: Vec<Opened<f64>>,
    imagery: Vec<Opened<[u8; 4]>>,
    adjust: &dyn Fn(&mut BuildOptions),
) -> Result<Area> {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let mut options = options(folder.path());
    adjust(&mut options);
    let budget = Budget::of(&options)?;
    let inputs = Inputs { elevation, imagery, ..Inputs::default() };
    build::build_from(inputs, &options, budget, &Silent)?;
    Area::open(&options.output)
}

/// As [`try_build`], and it must succeed.
pub fn built(
    elevation: Vec<Opened<f64>>,
    imagery: Vec<Opened<[u8; 4]>>,
    adjust: impl Fn(&mut BuildOptions),
) -> Area {
    try_build(elevation, imagery, adjust).expect("a database")
}

impl Area {
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).expect("the database that was built");
        let pages = MemPages::from_bytes(path, &bytes)?;
        let grid = pages.header().grid;
        Ok(Self { pages, bytes, grid })
    }

    fn at<R>(&self, x: u32, y: u32, look: impl Fn(&hedgehop::voxel::PageView<'_>, u32, u32) -> R) -> R {
        let id = PageId { level: 0, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
        let page = self.pages.page(id).expect("a good page").expect("a page");
        look(&page, x % PAGE_SIDE, y % PAGE_SIDE)
    }

    /// Height of voxel (x, y) from the south-west, metres.
    pub fn height(&self, x: u32, y: u32) -> Option<f64> {
        let code = self.at(x, y, |page, x, y| page.heights[page.sample(x, y)]);
        self.pages.header().heights.decode(code)
    }

    pub fn colour(&self, x: u32, y: u32) -> [u8; 3] {
        self.at(x, y, |page, x, y| page.colours[page.sample(x, y)])
    }

    pub fn attributes(&self, x: u32, y: u32) -> Attributes {
        self.at(x, y, |page, x, y| page.attributes_at(x, y))
    }

    /// World position of a voxel's centre.
    pub fn centre(&self, x: u32, y: u32) -> (f64, f64) {
        crate::warp::world(&self.grid, f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    pub fn voxels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (nx, ny) = (self.grid.nx, self.grid.ny);
        (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y)))
    }

    /// Half a step of the height code, and rounding.
    pub fn step(&self) -> f64 {
        0.5 * self.pages.header().heights.scale * (1.0 + 1.0e-6)
    }

    /// Largest distance of the heights from `expected(x, y)` in world space; every voxel must have one.
    pub fn worst(&self, expected: impl Fn(f64, f64) -> f64) -> f64 {
        let expected: &dyn Fn(f64, f64) -> f64 = &expected;
        self.voxels()
            .map(|(x, y)| {
                let (east, north) = self.centre(x, y);
                let height = self.height(x, y).unwrap_or_else(|| panic!("voxel {x}, {y} is empty"));
                (height - expected(east, north)).abs()
            })
            .fold(0.0, f64::max)
    }
}
