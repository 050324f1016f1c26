//! Detail that is finer than the posts of elevation, and leaves these as they are.
//!
//! ```text
//! height(place) = I[post − A(post)·n(post)](place) + A(place)·n(place)
//!     I  the interpolation between posts; at a post it is the post, so that what is subtracted there is what is added
//!     n  waves from four posts' length down to two voxels', each half as long as the one before and as high as the roughness says
//!     A  their height: so that the mean square of the posts' curvature, around the place, is that of the waves'
//! ```
//! This is a conditional simulation (Journel, "Geostatistics for conditional simulation of ore bodies", Economic Geology 69, 1974): what the
//! interpolation loses between posts is given back by noise of the same spectrum, for which reason the waves begin at twice the length
//! that posts can hold. A surface whose profiles have power f^−β goes on as it is if the roughness is 2^−(β−1)/2; curvatures over one and over two
//! posts measure it: their mean squares are as roughness² to 1. Posts on level ground (water) have waves of no height.

use serde::{Deserialize, Serialize};

use super::super::kernel::Samples;
use super::super::placed::ElevationInput;
use super::noise::Waves;
use crate::raster::Window;
use crate::synthetic::{Detail, Lattice, Roughness};
use hedgehop::Size;
use hedgehop_base::error::Result;

impl Detail {
    /// Most that it adds to posts so many metres apart, metres.
    pub(crate) fn most(&self, apart: f64) -> f64 {
        self.limit_m.unwrap_or(LIMIT * apart)
    }
}

/// Length of the first waves, in posts.
const LONGEST: f64 = 4.0;
/// Mean squares of the curvature of waves of mean square 1, four posts long and shorter: height of a post above the mean of the four beside it.
const CURVATURE: [f64; 4] = [0.0782, 0.6467, 1.498, 1.25];
/// Curvature of waves of eight posts, and the part by which each longer one has less.
const LONG_CURVATURE: (f64, f64) = (0.006_02, 1.0 / 15.5);
/// Roughnesses that elevation can be taken to have; what has been smoothed has less, and what is mostly errors more.
const MEASURED: (f64, f64) = (0.4, 0.85);
/// Roughness of elevation with too few posts to tell.
const USUAL: f64 = 0.6;
/// Part of the distance of posts that detail may add, unless told otherwise.
const LIMIT: f64 = 0.25;
/// Posts to either side over which curvature is averaged, their weights, and posts beyond them that curvature takes.
const AROUND: usize = 2;
const WEIGHTS: [f64; 2 * AROUND + 1] = [1.0, 4.0, 6.0, 4.0, 1.0];
const MARGIN: u32 = AROUND as u32 + 1;

/// Sums of squared curvatures along rows, over one post and over two.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Energies {
    near: f64,
    far: f64,
}

impl Energies {
    /// Takes a line of heights, NaN where there is none.
    pub fn meet(&mut self, line: &[f64]) {
        for posts in line.windows(5) {
            let (near, far) = (posts[1] + posts[3] - 2.0 * posts[2], posts[0] + posts[4] - 2.0 * posts[2]);
            if !(near + far).is_nan() {
                (self.near, self.far) = (self.near + near * near, self.far + far * far);
            }
        }
    }

    pub fn add(&mut self, other: &Self) {
        (self.near, self.far) = (self.near + other.near, self.far + other.far);
    }

    /// Roughness of what was met.
    pub fn roughness(&self) -> f64 {
        let roughness = (self.near / self.far).sqrt();
        if roughness.is_nan() { USUAL } else { roughness.clamp(MEASURED.0, MEASURED.1) }
    }
}

/// Detail of one source for voxels of one level.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Refinement {
    waves: Waves,
    /// Number of them that voxels can hold.
    count: u32,
    lattice: Lattice,
    /// Mean square of the curvature of all waves, if the first has the mean square 1.
    curvature: f64,
    /// Most that is added, metres.
    limit: f64,
}

impl Refinement {
    /// Builds the refinement for voxels of `spacing` metres; `None` where these are no finer than the posts.
    pub fn of(detail: &Detail, source: &ElevationInput, measured: f64, spacing: f64) -> Option<Self> {
        if spacing >= source.pixel_side || !source.pixel_side.is_finite() {
            return None;
        }
        let gain = match detail.roughness {
            Roughness::Auto => measured,
            Roughness::Given(roughness) => roughness,
        };
        let waves = Waves { seed: detail.seed, longest: LONGEST, gain };
        let count = waves.count(2.0 * spacing / source.pixel_side);
        let limit = detail.most(source.pixel_side);
        Some(Self { waves, count, lattice: source.lattice, curvature: curvature_of(gain), limit })
    }

    /// Returns what is added at a pixel position where waves are `amplitude` metres high.
    pub fn at(&self, column: f64, row: f64, amplitude: f64) -> f64 {
        if amplitude == 0.0 {
            return 0.0;
        }
        let wave = amplitude * self.waves.sum(self.lattice.place(column, row), self.count, |value| value);
        // Hardly less than the wave where that is small, and never more than the limit.
        let part = wave / self.limit;
        wave / (1.0 + part * part).sqrt()
    }

    /// The posts, less what is added at them.
    pub fn posts<'a>(&'a self, samples: &'a dyn Samples<f64>) -> RasterPosts<'a> {
        RasterPosts { samples, refinement: self }
    }

    /// Heights of waves at the posts, metres.
    pub fn amplitudes<'a>(&'a self, samples: &'a dyn Samples<f64>) -> Amplitudes<'a> {
        Amplitudes { samples, refinement: self }
    }
}

/// Mean square of the curvature over posts of waves of all lengths, the one of four posts having the mean square 1.
fn curvature_of(gain: f64) -> f64 {
    let square = gain * gain;
    let (long, less) = LONG_CURVATURE;
    let [first, second, third, rest] = CURVATURE;
    let longer = long / square / (1.0 - less / square).max(0.1);
    longer + first + square * (second + square * (third + square * rest / (1.0 - square)))
}

/// See [`Refinement::posts`].
pub(crate) struct RasterPosts<'a> {
    samples: &'a dyn Samples<f64>,
    refinement: &'a Refinement,
}

/// See [`Refinement::amplitudes`].
pub(crate) struct Amplitudes<'a> {
    samples: &'a dyn Samples<f64>,
    refinement: &'a Refinement,
}

impl Samples<f64> for RasterPosts<'_> {
    fn size(&self) -> Size {
        self.samples.size()
    }

    fn read(&self, window: Window, samples: &mut Vec<f64>) -> Result<()> {
        let wide = Sheet::around(self.samples, window, samples)?;
        samples.clear();
        samples.extend(wide.posts(window).map(|(column, row)| {
            let amplitude = wide.amplitude(column, row, self.refinement.curvature);
            wide.height(column, row) - self.refinement.at(f64::from(column), f64::from(row), amplitude)
        }));
        Ok(())
    }
}

impl Samples<f64> for Amplitudes<'_> {
    fn size(&self) -> Size {
        self.samples.size()
    }

    fn read(&self, window: Window, samples: &mut Vec<f64>) -> Result<()> {
        let wide = Sheet::around(self.samples, window, samples)?;
        samples.clear();
        let posts = wide.posts(window);
        samples.extend(posts.map(|(column, row)| wide.amplitude(column, row, self.refinement.curvature)));
        Ok(())
    }
}

/// Posts of a window and as many around it as their curvature takes.
struct Sheet {
    window: Window,
    heights: Vec<f64>,
    /// Squared curvatures; NaN where posts are missing beside.
    energies: Vec<f64>,
}

impl Sheet {
    fn around(samples: &dyn Samples<f64>, window: Window, scratch: &mut Vec<f64>) -> Result<Self> {
        let Size { width, height } = samples.size();
        let grown = |first: u32, count: u32, size: u32| {
            let low = first.saturating_sub(MARGIN);
            (low, (first + count).saturating_add(MARGIN).min(size) - low)
        };
        let (x, width) = grown(window.x, window.width, width);
        let (y, height) = grown(window.y, window.height, height);
        let window = Window { x, y, width, height };
        samples.read(window, scratch)?;
        let heights = std::mem::take(scratch);
        let (columns, rows) = (width as usize, height as usize);

        let energies = (0..heights.len()).map(|index| {
            let (column, row) = (index % columns, index / columns);
            if column == 0 || row == 0 || column + 1 == columns || row + 1 == rows {
                return f64::NAN;
            }
            let beside =
                [heights[index - 1], heights[index + 1], heights[index - columns], heights[index + columns]];
            let curvature = heights[index] - 0.25 * (beside[0] + beside[1] + beside[2] + beside[3]);
            curvature * curvature
        });

        let energies = energies.collect();
        Ok(Self { window, heights, energies })
    }

    /// Columns and rows of the raster in a part of it.
    fn posts(&self, window: Window) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = window.x..window.x + window.width;
        (window.y..window.y + window.height)
            .flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    fn index(&self, column: u32, row: u32) -> usize {
        (row - self.window.y) as usize * self.window.width as usize + (column - self.window.x) as usize
    }

    fn height(&self, column: u32, row: u32) -> f64 {
        self.heights[self.index(column, row)]
    }

    /// Posts around one that the sheet has, in rows and columns.
    fn around_post(&self, column: u32, row: u32, reach: u32) -> impl Iterator<Item = (u32, u32)> {
        let Window { x, y, width, height } = self.window;
        let range = |at: u32, first: u32, count: u32| {
            at.saturating_sub(reach).max(first)..(at + reach + 1).min(first + count)
        };
        let columns = range(column, x, width);
        range(row, y, height).flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    /// Height of waves at a post, metres; 0 where there is none, and on level ground.
    fn amplitude(&self, column: u32, row: u32, curvature: f64) -> f64 {
        let here = self.height(column, row);
        let is_level = self.around_post(column, row, 1).all(|(column, row)| self.height(column, row) == here);
        if here.is_nan() || is_level {
            return 0.0;
        }
        let (mut sum, mut weight) = (0.0, 0.0);
        for (x, y) in self.around_post(column, row, AROUND as u32) {
            let energy = self.energies[self.index(x, y)];
            if !energy.is_nan() {
                let part = WEIGHTS[(x + AROUND as u32 - column) as usize]
                    * WEIGHTS[(y + AROUND as u32 - row) as usize];
                (sum, weight) = (sum + part * energy, weight + part);
            }
        }
        if weight > 0.0 { (sum / weight / curvature).sqrt() } else { 0.0 }
    }
}
