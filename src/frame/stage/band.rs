//! A band of rows of the screen, strip by strip, pass by pass.
//!
//! A strip is sixteen columns wide. Each pass goes up its rows with little to do in each, and leaves what it found in
//! memory that stays in the nearest cache: one long pass would be bound by the time that one row takes
//! from its first instruction to its last, because a processor looks only some hundred instructions ahead.

use std::ops::Range;

use glam::DVec3;

use super::air::Air;
use super::fan::{Fan, Seen};
use crate::error::Result;
use crate::frame::Atmosphere;
use crate::raymarch::scan::Upright;
use crate::sensor::radiance::{Radiance, RadiancePages, Sampler};
use crate::simd::math::{log2_rough, srgb8};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::voxel::PageSource;

/// Inverse depths of one row and the next that differ by more than this share belong to two surfaces.
const CUT: f32 = 0.25;

/// Longest footprint along the ray, in widths.
const LONGEST: f32 = 16.0;

/// What is added to log₂ of the footprint.
const SHARPNESS: f32 = 0.0;

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// Pixels of some rows, from the top.
pub enum Band<'b> {
    /// 8-bit sRGB, `[rows][width][3]`.
    Picture(&'b mut [u8]),
    /// Linear Rec. 709 and range in metres, `[rows][width]` each.
    Frame {
        /// Linear Rec. 709 radiance.
        colour: &'b mut [[f32; 3]],
        /// Range, metres; infinite: sky.
        range: &'b mut [f32],
    },
}

/// Everything that pixels are made of.
pub struct ImageStage<'a> {
    /// The database.
    pub source: &'a dyn PageSource,
    /// Its radiance under the sun.
    pub radiance: &'a Radiance,
    /// How the screen lies in the fan.
    pub upright: &'a Upright,
    /// Inverse depth, `[group][row]`.
    pub inverse: &'a [Sixteen],
    /// Haze and sky.
    pub atmosphere: &'a Atmosphere,
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// Pixels of a row.
    pub width: usize,
    /// Angle of a pixel, radians.
    pub pixel_angle: f64,
}

impl ImageStage<'_> {
    /// Makes the rows from `first` on.
    pub fn fill(&self, isa: Isa, first: usize, band: Band<'_>) -> Result<()> {
        isa.run(Filling { stage: self, first, band })
    }
}

struct Filling<'f, 'b, 'a> {
    stage: &'f ImageStage<'a>,
    first: usize,
    band: Band<'b>,
}

/// What passes leave of one row of sixteen pixels.
#[derive(Clone, Copy, Default)]
struct Row {
    /// East and north of the eye, units.
    place: [Sixteen; 2],
    /// log₂ of the footprint, units.
    detail: Sixteen,
    /// Range, metres.
    range: Sixteen,
    /// Sine of the elevation.
    sine: Sixteen,
    /// Shares that the surface of the row below covers, and that this one's is seen in the row below.
    edges: [Sixteen; 2],
    /// Linear radiance.
    colour: [Sixteen; 3],
    /// Pixels that see ground, and whether there is an edge to the row below.
    ground: u16,
    is_cut: bool,
}

impl Kernel for Filling<'_, '_, '_> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { stage, first, mut band } = self;
        let width = stage.width;
        let count = band.rows(width);
        let pages = RadiancePages::new(stage.source, stage.radiance);
        let mut strip = Strip {
            simd,
            fan: Fan::new(simd, stage.upright, stage.inverse, first..first + count),
            sampler: Sampler::new(pages, stage.eye.truncate()),
            air: Air::new(stage.atmosphere, stage.eye.z),
            pixel_angle: stage.pixel_angle as f32,
            spacing: stage.source.header().grid.spacing as f32,
            // From the row below the band to the row above it.
            rows: vec![Row::default(); count + 2],
        };
        for column in (0..width).step_by(LANES) {
            strip.look(column, first, count);
            let inner = 1..count + 1;
            strip.sample(inner.clone())?;
            strip.air(inner.clone());
            strip.blend_edges(inner)?;
            let end = (column + LANES).min(width);
            for (index, row) in strip.rows[1..=count].iter().enumerate() {
                let at = (count - 1 - index) * width;
                band.put(simd, at + column..at + end, row);
            }
        }
        Ok(())
    }
}

/// Sixteen columns of a band.
struct Strip<'p, V: Simd> {
    simd: V,
    fan: Fan<'p, V>,
    sampler: Sampler<'p>,
    air: Air,
    pixel_angle: f32,
    spacing: f32,
    rows: Vec<Row>,
}

impl<V: Simd> Strip<'_, V> {
    /// Where on the ground the pixels of each row see, and over which footprint.
    #[inline(always)]
    fn look(&mut self, column: usize, first: usize, count: usize) {
        let simd = self.simd;
        let per_unit = simd.splat(1.0 / self.spacing);
        let mut below = self.fan.see(column, first + count + 1);
        for index in 0..count + 2 {
            // There is nothing above the screen.
            let row = (first + count).checked_sub(index).unwrap_or(first);
            let seen = self.fan.see(column, row);
            let depth = seen.depth * per_unit;
            let detail = self.detail(&seen, &below);
            let target = &mut self.rows[index];
            (seen.slope[0] * depth).store(&mut target.place[0].0);
            (seen.slope[1] * depth).store(&mut target.place[1].0);
            detail.store(&mut target.detail.0);
            seen.range.store(&mut target.range.0);
            (seen.slope[2] * seen.per_slant).store(&mut target.sine.0);
            target.ground = simd.splat(0.0).lt(seen.inverse).bits();
            target.is_cut = false;
            if let Some([cover, uncover]) = seen.edges(simd) {
                cover.store(&mut target.edges[0].0);
                uncover.store(&mut target.edges[1].0);
                target.is_cut = true;
            }
            below = seen;
        }
        if first == 0 {
            self.rows[count + 1].is_cut = false;
        }
    }

    /// log₂ of the footprint, in units: the root of its width across and its length along the ray.
    #[inline(always)]
    fn detail(&self, seen: &Seen<V>, below: &Seen<V>) -> V::F {
        let simd = self.simd;
        let width = seen.range * simd.splat(self.pixel_angle / self.spacing);
        let step = (seen.range - below.range).abs() * simd.splat(1.0 / self.spacing);
        let length = step.max(width).min(width * simd.splat(LONGEST));
        // Behind an edge the row below belongs to something else.
        let apart = (seen.inverse - below.inverse).abs();
        let smooth = apart.le((seen.inverse + below.inverse) * simd.splat(CUT));
        let area = width * length.select(smooth, width + width);
        log2_rough(simd, area.max(simd.splat(1.0e-3))).mul_add(simd.splat(0.5), simd.splat(SHARPNESS))
    }

    /// Radiance of the ground.
    #[inline(always)]
    fn sample(&mut self, rows: Range<usize>) -> Result<()> {
        let simd = self.simd;
        for row in &mut self.rows[rows] {
            if row.ground != 0 {
                let place = [simd.load(&row.place[0].0), simd.load(&row.place[1].0)];
                let detail = simd.load(&row.detail.0);
                let radiance = self.sampler.sample(simd, place, detail, simd.mask(row.ground))?;
                for (target, channel) in row.colour.iter_mut().zip(radiance) {
                    channel.store(&mut target.0);
                }
            }
        }
        Ok(())
    }

    /// Haze before the ground, and sky.
    #[inline(always)]
    fn air(&mut self, rows: Range<usize>) {
        let simd = self.simd;
        for row in &mut self.rows[rows] {
            let sine = simd.load(&row.sine.0);
            let ground = simd.mask(row.ground);
            let mut colour = [sine; 3];
            if row.ground != 0 {
                for (colour, channel) in colour.iter_mut().zip(&row.colour) {
                    *colour = simd.load(&channel.0);
                }
                colour = self.air.haze(simd, colour, simd.load(&row.range.0), sine);
            }
            if !ground.all() {
                for (colour, sky) in colour.iter_mut().zip(self.air.sky(simd, sine)) {
                    *colour = colour.select(ground, sky);
                }
            }
            for (target, channel) in row.colour.iter_mut().zip(colour) {
                channel.store(&mut target.0);
            }
        }
    }

    /// Gives each side of an edge between two rows its share of both.
    #[inline(always)]
    fn blend_edges(&mut self, rows: Range<usize>) -> Result<()> {
        let (below, above) = (rows.start - 1, rows.end);
        // What lies beyond the band is computed only where an edge asks for it.
        if self.rows[rows.start].is_cut {
            self.sample(below..below + 1)?;
            self.air(below..below + 1);
        }
        if self.rows[above].is_cut {
            self.sample(above..above + 1)?;
            self.air(above..above + 1);
        }
        let mut lower = self.rows[below].colour;
        for index in rows.start..=above {
            let centre = self.rows[index].colour;
            if self.rows[index].is_cut {
                let [cover, uncover] = self.rows[index].edges;
                self.mix(index, lower, cover);
                self.mix(index - 1, centre, uncover);
            }
            lower = centre;
        }
        Ok(())
    }

    /// Takes `share` of another colour into a row.
    #[inline(always)]
    fn mix(&mut self, index: usize, other: [Sixteen; 3], share: Sixteen) {
        let simd = self.simd;
        let share = simd.load(&share.0);
        for (channel, other) in self.rows[index].colour.iter_mut().zip(&other) {
            let own = simd.load(&channel.0);
            (simd.load(&other.0) - own).mul_add(share, own).store(&mut channel.0);
        }
    }
}

impl Band<'_> {
    fn rows(&self, width: usize) -> usize {
        match self {
            Self::Picture(bytes) => bytes.len() / (RGB * width.max(1)),
            Self::Frame { range, .. } => range.len() / width.max(1),
        }
    }

    /// Writes up to sixteen pixels.
    #[inline(always)]
    fn put<V: Simd>(&mut self, simd: V, pixels: Range<usize>, row: &Row) {
        match self {
            Self::Picture(bytes) => {
                let red = srgb8(simd, simd.load(&row.colour[0].0));
                let green = srgb8(simd, simd.load(&row.colour[1].0));
                let blue = srgb8(simd, simd.load(&row.colour[2].0));
                let packed = red | green.shl::<8>() | blue.shl::<16>();
                let target = &mut bytes[pixels.start * RGB..pixels.end * RGB];
                match target.first_chunk_mut() {
                    Some(all) => simd.store_triples(packed, all),
                    None => {
                        let mut all = [0; RGB * LANES];
                        simd.store_triples(packed, &mut all);
                        target.copy_from_slice(&all[..target.len()]);
                    }
                }
            }
            Self::Frame { colour, range } => {
                for (lane, pixel) in pixels.enumerate() {
                    colour[pixel] = row.colour.map(|channel| channel.0[lane]);
                    let sees_ground = row.ground >> lane & 1 != 0;
                    range[pixel] = if sees_ground { row.range.0[lane] } else { f32::INFINITY };
                }
            }
        }
    }
}
