//! The cover of a block of voxels.

use glam::DVec2;

use super::raster::SampleClass;
use crate::Materials;
use crate::footprint::Bounds;
use crate::kernel::Samples;
use crate::opened::Opened;
use crate::plan::Plan;
use crate::raster::Window;
use crate::synthetic::noise::gradient;
use crate::tint::mix;
use crate::warp::{self, LevelGrid, RasterPlacement, Rect, TOLERANCE, WarpField};
use hedgehop::Size;
use hedgehop::voxel::{Grid, Group, Material, RADIX};
use hedgehop_base::error::Result;

/// A map of classes, placed in the database's grid.
pub(crate) struct CoverInput {
    pub samples: Box<dyn Samples<SampleClass>>,
    pub placement: RasterPlacement,
    /// West, south, east, north of what it can reach, metres.
    pub reach: Bounds,
}

impl CoverInput {
    /// Places a raster in the grid.
    pub fn place(raster: Opened<SampleClass>, plan: &Plan) -> Result<Self> {
        let (placement, reach) = raster.place(plan)?;
        Ok(Self { samples: raster.samples, placement, reach })
    }
}

/// Cover of a voxel's ground.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct LandCover {
    /// Number of its material; 0: no raster knows it.
    pub material: u8,
    /// Colour in linear light; means nothing without a material.
    pub linear: [f32; 3],
    /// Liveliness: how much the colour may vary from place to place, 0…1: that of lakes and roofs hardly does.
    pub lively: f32,
}

/// Looks classes up; one per worker, since it keeps scratch memory.
pub(crate) struct Sampler<'a> {
    pub sources: &'a [CoverInput],
    pub materials: &'a Materials,
    /// The grid of level 1.
    pub grid: Grid,
    /// Largest window, bytes.
    pub window_bytes: usize,
    pub window: Vec<SampleClass>,
}

/// Pixels beside those under a block that its colours ask for: the noise, and the spline.
const BESIDE: i64 = 3;
/// Distance by which noise moves a place, pixels: its deviation is a fifth of this.
const SHIFT: f64 = 1.3;
/// Length of the longest waves of it, pixels; of the others, half as long and half as high.
const LONGEST: f64 = 1.9;
/// Power of the shares that classes have around a place: with 5 they change over a third of a pixel.
const SHARPNESS: u32 = 5;

impl Sampler<'_> {
    /// The cover of a block of a level.
    pub fn over(&mut self, rect: Rect, level: u8) -> Result<Vec<LandCover>> {
        if self.sources.is_empty() {
            return Ok(vec![LandCover::default(); rect.len()]);
        }
        if level == 0 {
            return self.of_centres(rect, &LevelGrid::of(&self.grid, 0).grid);
        }

        let finer = LevelGrid::of(&self.grid, level - 1).grid;
        let mut covers = Vec::with_capacity(rect.len());

        // Bands, so that what is finer takes no more memory than it must.
        for band in rect.bands() {
            let wide = Rect {
                x0: band.x0 * RADIX,
                y0: band.y0 * RADIX,
                x1: band.x1.saturating_mul(RADIX).min(finer.nx),
                y1: band.y1.saturating_mul(RADIX).min(finer.ny),
            };
            let parts = self.of_centres(wide, &finer)?;

            covers.extend((0..band.len()).map(|voxel| {
                let (x, y) = band.voxel(voxel);
                let columns = x * RADIX..((x + 1) * RADIX).min(wide.x1);
                let rows = y * RADIX..((y + 1) * RADIX).min(wide.y1);
                let all = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                mean(all.map(|(x, y)| parts[wide.index(x, y)]))
            }));
        }

        Ok(covers)
    }

    /// Samples the cover under centres of voxels of a grid.
    fn of_centres(&mut self, rect: Rect, grid: &Grid) -> Result<Vec<LandCover>> {
        let mut covers = Vec::with_capacity(rect.len());
        for band in rect.bands() {
            let mut found = vec![LandCover::default(); band.len()];
            for source in self.sources {
                if band.meets(&source.reach, grid) {
                    self.add(source, band, grid, &mut found)?;
                }
                if found.iter().all(|cover| cover.material > 0) {
                    break;
                }
            }
            covers.extend(found);
        }
        Ok(covers)
    }

    /// Adds what a raster knows to what is not known yet.
    fn add(&mut self, source: &CoverInput, band: Rect, grid: &Grid, covers: &mut [LandCover]) -> Result<()> {
        let field = warp::locate(&source.placement, grid, band);
        let places: Vec<Option<CoverPlace>> =
            (0..band.len()).map(|voxel| CoverPlace::of(voxel, &field, source, grid)).collect();
        let size = source.samples.size();
        let mut blocks = vec![band];

        while let Some(block) = blocks.pop() {
            let voxels =
                || (block.y0..block.y1).flat_map(|y| (block.x0..block.x1).map(move |x| band.index(x, y)));
            let wanted =
                || voxels().filter(|voxel| covers[*voxel].material == 0).filter_map(|voxel| places[voxel]);
            let Some(window) = around(wanted(), size) else { continue };
            let bytes = window.width as usize * window.height as usize * size_of::<SampleClass>();
            if bytes > self.window_bytes && block.len() > 1 {
                blocks.extend(block.halves());
                continue;
            }

            source.samples.read(window, &mut self.window)?;
            let pixels = CoverPixels { window, classes: &self.window };
            for voxel in voxels() {
                if let (Some(place), LandCover { material: 0, .. }) = (&places[voxel], &covers[voxel]) {
                    covers[voxel] = pixels.cover(place, self.materials);
                }
            }
        }

        Ok(())
    }
}

/// Place of a voxel in a raster.
#[derive(Debug, Clone, Copy)]
struct CoverPlace {
    /// Column and row, whole numbers at pixel centres.
    at: DVec2,
    /// Pixels per voxel.
    scale: f64,
}

impl CoverPlace {
    fn of(voxel: usize, field: &WarpField, source: &CoverInput, grid: &Grid) -> Option<Self> {
        let (x, y) = field.rect.voxel(voxel);
        let scale = field.scale(x, y);
        let scale = scale.0.max(scale.1);
        let mut at = DVec2::new(field.columns[voxel], field.rows[voxel]);
        // Near the edge of a pixel the lattice is not exact enough to tell which side of it the centre lies on.
        let from_edge = (at - at.round()).abs();
        if from_edge.max_element() > 0.5 - 2.0 * TOLERANCE * scale.max(1.0) || at.is_nan() {
            let (x, y) = warp::world(grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (column, row) = source.placement.pixel_from_world(x, y)?;
            at = DVec2::new(column, row);
        }
        let Size { width, height } = source.samples.size();
        let is_in = |at: f64, size: u32| (-0.5..f64::from(size) - 0.5).contains(&at);
        (is_in(at.x, width) && is_in(at.y, height)).then_some(Self { at, scale })
    }

    /// The pixel that its centre lies in.
    fn pixel(&self) -> (i64, i64) {
        let pixel = (self.at + 0.5).floor();
        (pixel.x as i64, pixel.y as i64)
    }

    /// Returns the place at which its colour is looked up.
    fn moved(&self) -> DVec2 {
        let (mut sum, mut weight, mut length) = (DVec2::ZERO, SHIFT, LONGEST);
        // Waves shorter than two voxels would be noise from voxel to voxel.
        for wave in 0..6 {
            if length < 2.0 * self.scale {
                break;
            }
            let of = |axis: u64| gradient(self.at / length + 17.3, 2 * wave + axis);
            sum += weight * DVec2::new(of(0), of(1));
            (weight, length) = (0.5 * weight, 0.5 * length);
        }
        self.at + sum.clamp(DVec2::splat(-1.0), DVec2::ONE)
    }
}

/// The window of pixels that places ask for, within a raster of this size.
fn around(places: impl Iterator<Item = CoverPlace>, size: Size) -> Option<Window> {
    let pixels = places.map(|place| place.pixel());
    let joined = |a: [i64; 4], (x, y): (i64, i64)| [a[0].min(x), a[1].min(y), a[2].max(x), a[3].max(y)];
    let all = pixels
        .fold(None, |all: Option<[i64; 4]>, (x, y)| Some(joined(all.unwrap_or([x, y, x, y]), (x, y))))?;
    let [x0, y0] = [all[0], all[1]].map(|first| (first - BESIDE).max(0) as u32);
    let x1 = (all[2] + BESIDE + 1).min(i64::from(size.width)) as u32;
    let y1 = (all[3] + BESIDE + 1).min(i64::from(size.height)) as u32;
    Some(Window { x: x0, y: y0, width: x1 - x0, height: y1 - y0 })
}

/// Pixels of a window.
struct CoverPixels<'w> {
    window: Window,
    classes: &'w [SampleClass],
}

impl CoverPixels<'_> {
    /// Number of a pixel's material, 0 if none is known there; beside the window as at its edge.
    fn material(&self, x: i64, y: i64) -> u8 {
        let Window { x: x0, y: y0, width, height } = self.window;
        let column = (x - i64::from(x0)).clamp(0, i64::from(width) - 1) as usize;
        let row = (y - i64::from(y0)).clamp(0, i64::from(height) - 1) as usize;
        match self.classes.get(row * width as usize + column) {
            Some(SampleClass::Known(number)) => *number,
            _ => 0,
        }
    }

    fn cover(&self, place: &CoverPlace, materials: &Materials) -> LandCover {
        let (x, y) = place.pixel();
        let material = self.material(x, y);
        if material == 0 {
            return LandCover::default();
        }

        let own = LandCover::of(material, materials);
        if place.scale >= 1.0 {
            return own;
        }

        let at = place.moved();
        let middle = (at + 0.5).floor();
        let (columns, rows) = (spline(at.x - middle.x), spline(at.y - middle.y));
        let (x, y) = (middle.x as i64 - 1, middle.y as i64 - 1);
        let mut shares = Shares::default();

        for (row, down) in (y..).zip(rows) {
            for (column, across) in (x..).zip(columns) {
                // Where nothing is known beside it, it goes on.
                let found = self.material(column, row);
                shares.add(if found == 0 { material } else { found }, (across * down) as f32);
            }
        }

        if shares.count == 1 && shares.all[0].0 == material {
            return own;
        }

        // A voxel is never sharper than itself.
        let power = ((1.5 / place.scale) as u32).clamp(1, SHARPNESS);
        let parts = || {
            shares.all[..shares.count]
                .iter()
                .map(|(class, share)| (*class, (1..power).fold(*share, |product, _| product * share)))
        };
        let whole: f32 = parts().map(|(_, share)| share).sum();

        parts().fold(Self::nothing(material), |sum, (class, share)| {
            let (part, weight) = (LandCover::of(class, materials), share / whole);
            LandCover {
                linear: std::array::from_fn(|channel| sum.linear[channel] + weight * part.linear[channel]),
                lively: sum.lively + weight * part.lively,
                material,
            }
        })
    }

    fn nothing(material: u8) -> LandCover {
        LandCover { linear: [0.0; 3], lively: 0.0, material }
    }
}

/// Weights of three pixels around a place that lies `beside` the middle one, −½…½: the quadratic B-spline.
fn spline(beside: f64) -> [f64; 3] {
    let (before, after) = (0.5 - beside, 0.5 + beside);
    [0.5 * before * before, 0.75 - beside * beside, 0.5 * after * after]
}

/// Shares of classes in what lies around a place, in the order in which they come.
#[derive(Default)]
struct Shares {
    all: [(u8, f32); 9],
    count: usize,
}

impl Shares {
    fn add(&mut self, class: u8, share: f32) {
        let known = self.all[..self.count].iter_mut().find(|(known, _)| *known == class);
        match known {
            Some((_, sum)) => *sum += share,
            None => {
                self.all[self.count] = (class, share);
                self.count += 1;
            }
        }
    }
}

impl LandCover {
    /// All of one material.
    pub fn of(material: u8, materials: &Materials) -> Self {
        let class = Material::of_code(material);
        let lively = match materials.like(class).group() {
            Group::Woods | Group::Low | Group::Bare | Group::Other => 1.0,
            Group::Built => 0.5,
            Group::Water => 0.15,
        };
        Self { material, linear: materials.linear(class), lively }
    }
}

/// Joins the covers of voxels: the most frequent material (the smaller number where two are), and the mean of the colours of those with one.
fn mean(parts: impl Iterator<Item = LandCover>) -> LandCover {
    let mut found: Vec<LandCover> = parts.collect();
    found.sort_by_key(|cover| cover.material);
    let material = most_frequent(&found);
    let known: Vec<&LandCover> = found.iter().filter(|cover| cover.material > 0).collect();
    if material == 0 || known.is_empty() {
        return LandCover::default();
    }
    let share = 1.0 / known.len() as f32;
    let of = |value: &dyn Fn(&LandCover) -> f32| known.iter().map(|cover| value(cover)).sum::<f32>() * share;
    LandCover {
        material,
        linear: std::array::from_fn(|channel| of(&|cover| cover.linear[channel])),
        lively: of(&|cover| cover.lively),
    }
}

/// The material of most of some voxels, which are sorted by it.
fn most_frequent(sorted: &[LandCover]) -> u8 {
    let runs = sorted.chunk_by(|a, b| a.material == b.material);
    runs.map(|run| (run.len(), std::cmp::Reverse(run[0].material)))
        .max()
        .map_or(0, |(_, std::cmp::Reverse(material))| material)
}

/// Share of the ramp by height and slope in the colour of bare ground of a known material.
const RAMP: f32 = 0.1;
/// Wavelengths by which lightness varies, metres, and how much with each.
const MOTTLING: [(f64, f32); 4] = [(310.0, 0.16), (83.0, 0.16), (23.0, 0.14), (6.1, 0.12)];

/// The colour of ground of a material where no imagery shows it, `ramp` being that by height and slope: linear light. `at` is the centre of the voxel, `side`
/// its side, metres.
pub(crate) fn varied(cover: &LandCover, ramp: [f32; 3], at: DVec2, side: f64) -> [f32; 3] {
    let waves = MOTTLING.iter().zip(1000_u64..).filter(|((length, _), _)| *length >= 2.0 * side);
    let mottled: f32 =
        waves.map(|((length, height), seed)| height * gradient(at / *length, seed) as f32).sum();
    let lightness = 1.0 + cover.lively * 1.8 * mottled;
    mix(cover.linear, ramp, RAMP * cover.lively).map(|linear| linear * lightness)
}
