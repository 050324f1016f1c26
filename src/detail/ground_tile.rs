//! The tile of hidden octaves that lies over the ground, and its mean over a pixel's footprint.
//!
//! ```text
//! pattern, lit by the sun      → n, standard deviation 1
//! light over its mean          → (1 + n/3)² over its own mean, less 1     roots of light vary evenly, light is never negative
//! less means over voxels       → tile
//! ```
//!
//! Patterns matched from fine imagery are light over its mean as they are, one for each class of roughness: the ground's own relative deviation picks among them.
//!
//! A footprint is a parallelogram on the ground; the box with the same second moments along the grid's axes stands for it, whose mean is exact.

use glam::DVec2;
use hedgehop_texture::{CELLS_PER_VOXEL, CellBox, Cells, SIDE, Tile};

use crate::simd::{Each, Floats, Ints, Simd};
use hedgehop_base::error::Result;

/// Deviation of roots of light, relative to their mean, that the tile's skewness is right for.
const SKEW: f64 = 1.0 / 3.0;

/// Steps of the tile per standard deviation: so few that sums have 16 bits.
const STEPS: f64 = 32.0;

/// Entries of a row of sums.
const STRIDE: u32 = SIDE as u32 + 1;

/// Sums of squares of a footprint's sides, in squared voxels, from which detail begins to fade, and beyond which there is none: averages over voxels have little left,
/// and where one pixel is as wide as that, posts are too fine for it.
pub const FADING: [f64; 2] = [1.0, 2.6];

/// Parts of the way between two rows of sums.
const PARTS: i32 = 1 << 14;

/// Entries of the sums of a class.
const CLASS_ENTRIES: usize = STRIDE as usize * SIDE;

/// Repeating pattern of light below the voxel, mean 0 over each voxel; of a generator, standard deviation 1, or several by roughness.
#[derive(Debug)]
pub struct GroundTile {
    /// Classes of roughness, the smoothest first; one at least.
    classes: Vec<TileClass>,
    /// Summed areas, `[class][north][east]`, 256 × 255: of 16 bits each an entry, and the one north of it.
    sums: Vec<u32>,
}

/// Tile of a class of roughness.
#[derive(Debug)]
struct TileClass {
    /// Relative deviation from which on ground is of this class.
    least: f32,
    tile: Tile,
    /// Change of light where the tile is 1, per relative deviation.
    unit: f64,
}

/// Sum in 16 bits; `None` where it is too great.
fn halfword(sum: i32) -> Option<u16> {
    i16::try_from(sum).ok().map(|sum| sum as u16)
}

/// Sums of a tile, each with the one north of it; `None` where one is too great.
fn paired(tile: &Tile) -> Option<Vec<u32>> {
    let (southern, northern) = (tile.sums(), tile.sums().get(STRIDE as usize..)?);
    let pair = |(&south, &north)| Some(u32::from(halfword(south)?) | u32::from(halfword(north)?) << 16);
    southern.iter().zip(northern).map(pair).collect()
}

/// A coordinate among sums: the entry below it, and the share of the way to the next.
#[derive(Clone, Copy)]
struct SumPlace<V: Simd> {
    entry: V::I,
    share: V::F,
}

impl GroundTile {
    /// Makes the tile of a pattern.
    ///
    /// # Errors
    /// Nothing is left of the pattern without its means over voxels.
    pub fn new(pattern: &Cells) -> Result<Self> {
        let (mean, unit) = (pattern.mean(), 1.0 / pattern.deviation());
        Self::of(&pattern.joined(pattern, |value, _| (1.0 + SKEW * unit * (value - mean)).max(0.0).powi(2)))
    }

    /// Makes a tile of cells as they are, but for their means over voxels and their unit.
    ///
    /// # Errors
    /// Nothing is left of them.
    pub fn of(cells: &Cells) -> Result<Self> {
        let mut tile = Self { classes: Vec::new(), sums: Vec::new() };
        tile.add(f32::NEG_INFINITY, cells, |_| 1.0)?;
        Ok(tile)
    }

    /// Makes tiles of light over its mean, per relative deviation, by the relative deviation from which on each is the ground's.
    ///
    /// # Errors
    /// As of [`Self::new`], of any of them.
    pub fn by_roughness(patterns: &[RoughPattern]) -> Result<Self> {
        let mut tile = Self { classes: Vec::new(), sums: Vec::new() };
        for RoughPattern { least, light } in patterns {
            tile.add(*least, light, |tile| light.deviation() * tile.contrast_kept())?;
        }
        Ok(tile)
    }

    /// Adds a class.
    fn add(&mut self, least: f32, light: &Cells, unit: impl Fn(&Tile) -> f64) -> Result<()> {
        // Patterns with high peaks have fewer steps, so that sums have 16 bits.
        let mut steps = STEPS;
        loop {
            let tile = Tile::with_steps(light, steps)?;
            if let Some(sums) = paired(&tile) {
                self.sums.extend(sums);
                self.classes.push(TileClass { least, unit: unit(&tile), tile });
                return Ok(());
            }
            steps *= 0.5;
        }
    }

    /// Returns the greatest value, of either sign, that any mean may have.
    pub fn peak(&self) -> f64 {
        self.classes.iter().map(TileClass::peak).fold(0.0, f64::max)
    }

    /// Share that detail has under a footprint of so many voxels along and across.
    pub fn fading(sides: DVec2) -> f64 {
        ((FADING[1] - sides.length_squared()) / (FADING[1] - FADING[0])).clamp(0.0, 1.0)
    }

    /// Mean over a box about a place, units of the grid, on ground of a relative deviation; sides in units, > 0.
    pub fn mean(&self, roughness: f32, centre: DVec2, sides: DVec2) -> f64 {
        let cells = CELLS_PER_VOXEL as f64;
        // As wide as a cell more, so that cells have no edges.
        let half = (sides * sides * (cells * cells) + DVec2::ONE).map(f64::sqrt) * 0.5;
        let centre = centre * cells;
        let (low, high) = (centre - half, centre + half);
        let class = self.classes.iter().rfind(|class| class.least <= roughness).unwrap_or(&self.classes[0]);
        class.unit * class.tile.mean(CellBox { x0: low.x, x1: high.x, y0: low.y, y1: high.y })
    }

    /// Mean over sixteen boxes about places, eastward and northward, in cells from a corner of the tile, on ground of relative deviations; squares of their sides,
    /// cells².
    #[inline(always)]
    pub fn means<V: Simd>(&self, simd: V, roughness: V::F, centre: [V::F; 2], squares: [V::F; 2]) -> V::F {
        let (one, half) = (simd.splat(1.0), simd.splat(0.5));
        let [wide, high] = [(squares[0] + one).sqrt_rough(), (squares[1] + one).sqrt_rough()];
        let west = sum_place(simd, wide.neg_mul_add(half, centre[0]));
        let east = sum_place(simd, wide.mul_add(half, centre[0]));
        let mut south = SumRow::of(simd, sum_place(simd, high.neg_mul_add(half, centre[1])));
        let mut north = SumRow::of(simd, sum_place(simd, high.mul_add(half, centre[1])));
        let mut per_sum = simd.splat(self.classes[0].per_sum());
        if self.classes.len() > 1 {
            let class = self.class(simd, roughness);
            (south.entry, north.entry) = (south.entry + class.entry, north.entry + class.entry);
            per_sum = class.per_sum;
        }

        let upper = self.sum(simd, east, north) - self.sum(simd, west, north);
        let lower = self.sum(simd, east, south) - self.sum(simd, west, south);
        (upper - lower) * per_sum * (wide * high).recip()
    }

    /// Finds the classes of ground.
    #[inline(always)]
    fn class<V: Simd>(&self, simd: V, roughness: V::F) -> ClassLanes<V> {
        let (mut entry, mut per_sum) = (simd.splat(0.0), simd.splat(self.classes[0].per_sum()));
        for (number, class) in self.classes.iter().enumerate().skip(1) {
            let is_rough = simd.splat(class.least).le(roughness);
            entry = simd.splat((number * CLASS_ENTRIES) as f32).select(is_rough, entry);
            per_sum = simd.splat(class.per_sum()).select(is_rough, per_sum);
        }
        ClassLanes { entry: entry.to_int(), per_sum }
    }

    /// Sums from the tile's corner to places, parts of steps.
    #[inline(always)]
    fn sum<V: Simd>(&self, simd: V, x: SumPlace<V>, y: SumRow<V>) -> V::F {
        let (west, east) = simd.gather_word_pairs(&self.sums, y.entry + x.entry);
        let [west, east] = [west, east].each(|sums| sums.dot_halves(y.weights).to_float());
        (east - west).mul_add(x.share, west)
    }
}

/// Light over its mean, per relative deviation, of ground that is as rough as this or rougher.
pub struct RoughPattern {
    /// Relative deviation from which on.
    pub least: f32,
    /// Light, less its mean.
    pub light: Cells,
}

impl TileClass {
    /// Greatest change of light, of either sign.
    fn peak(&self) -> f64 {
        let steps = self.tile.steps().iter().map(|step| step.unsigned_abs()).max();
        f64::from(steps.unwrap_or_default()) * self.tile.scale() * self.unit
    }

    /// Change of light per part of a step.
    #[inline(always)]
    fn per_sum(&self) -> f32 {
        (self.unit * self.tile.scale()) as f32 / PARTS as f32
    }
}

/// Classes of sixteen places.
struct ClassLanes<V: Simd> {
    /// First entry of their sums.
    entry: V::I,
    per_sum: V::F,
}

/// A coordinate between two rows of sums.
#[derive(Clone, Copy)]
struct SumRow<V: Simd> {
    /// First entry of the southern row.
    entry: V::I,
    /// Weights of both, which add up to [`PARTS`]: the southern one's in the lower half.
    weights: V::I,
}

impl<V: Simd> SumRow<V> {
    #[inline(always)]
    fn of(simd: V, place: SumPlace<V>) -> Self {
        let northern = place.share.mul_add(simd.splat(PARTS as f32), simd.splat(0.5)).to_int();
        let weights = northern.shl::<16>() - northern + simd.splat_int(PARTS);
        Self { entry: place.entry.shl::<{ STRIDE.ilog2() }>(), weights }
    }
}

/// Finds cells among sums, wherever the tile repeats.
#[inline(always)]
fn sum_place<V: Simd>(simd: V, cell: V::F) -> SumPlace<V> {
    let below = cell.floor();
    let tiles = ((below + simd.splat(0.5)) * simd.splat(1.0 / SIDE as f32)).floor();
    let entry = tiles.neg_mul_add(simd.splat(SIDE as f32), below);
    SumPlace { entry: entry.to_int(), share: cell - below }
}
