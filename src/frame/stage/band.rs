//! A band of rows of the screen.

use std::ops::Range;

use glam::DVec3;

use super::air::Air;
use super::fan::{Fan, Seen};
use crate::error::Result;
use crate::frame::Atmosphere;
use crate::raymarch::scan::Upright;
use crate::sensor::radiance::{Radiance, RadiancePages, Sampler};
use crate::simd::math::{log2_rough, srgb8};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Mask, Simd};
use crate::voxel::PageSource;

/// Inverse depths of one row and the next that differ by more than this share belong to two surfaces.
const CUT: f32 = 0.25;

/// Longest footprint along the ray, in widths.
const LONGEST: f32 = 16.0;

/// What is added to log₂ of the footprint: half a level of four times the side sharper keeps what a box of
/// a pixel keeps.
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
pub struct ImageStage<'a, S: PageSource> {
    /// The database.
    pub source: &'a S,
    /// Its radiance under the sun.
    pub radiance: &'a Radiance,
    /// How the screen lies in the fan.
    pub upright: &'a Upright,
    /// Inverse depth, `[group][row][lane]`.
    pub inverse: &'a [f32],
    /// Haze and sky.
    pub atmosphere: &'a Atmosphere,
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// Pixels of a row.
    pub width: usize,
    /// Angle of a pixel, radians.
    pub pixel_angle: f64,
}

impl<S: PageSource> ImageStage<'_, S> {
    /// Makes the rows from `first` on.
    pub fn fill(&self, isa: Isa, first: usize, band: Band<'_>) -> Result<()> {
        isa.run(Filling { stage: self, first, band })
    }
}

struct Filling<'f, 'b, 'a, S: PageSource> {
    stage: &'f ImageStage<'a, S>,
    first: usize,
    band: Band<'b>,
}

/// Sixteen pixels of one row.
struct Row<V: Simd> {
    /// Radiance at the pixels' centres.
    centre: [V::F; 3],
    /// The same, after edges have taken their share of it.
    colour: [V::F; 3],
}

impl<S: PageSource> Kernel for Filling<'_, '_, '_, S> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { stage, first, mut band } = self;
        let width = stage.width;
        let rows = band.rows(width);
        let pages = RadiancePages::new(stage.source, stage.radiance);
        let mut pixels = Pixels {
            simd,
            fan: Fan::new(simd, stage.upright, stage.inverse, first..first + rows),
            sampler: Sampler::new(pages, stage.eye.truncate()),
            air: Air::new(stage.atmosphere, stage.eye.z),
            pixel_angle: stage.pixel_angle as f32,
            spacing: stage.source.header().grid.spacing as f32,
        };
        for column in (0..width).step_by(LANES) {
            let target = |row: usize| row * width + column..row * width + (column + LANES).min(width);
            let mut under = pixels.fan.see(column, first + rows);
            let mut below: Option<Row<V>> = None;
            for row in (0..rows).rev() {
                let seen = pixels.fan.see(column, first + row);
                let centre = pixels.radiance(&seen, &under)?;
                let mut this = Row { centre, colour: centre };
                if let Some([cover, uncover]) = seen.edges(simd) {
                    let edge = match &mut below {
                        Some(below) => {
                            below.colour = mix(below.colour, centre, uncover);
                            below.centre
                        }
                        // The row below belongs to another band.
                        None => pixels.radiance(&under, &pixels.fan.see(column, first + rows + 1))?,
                    };
                    this.colour = mix(this.colour, edge, cover);
                }
                if let Some(below) = &below {
                    band.put_colour(simd, target(row + 1), below.colour);
                }
                band.put_range(simd, target(row), &seen);
                (under, below) = (seen, Some(this));
            }
            let Some(mut top) = below else { continue };
            if first > 0 {
                let above = pixels.fan.see(column, first - 1);
                if let Some([_, uncover]) = above.edges(simd) {
                    top.colour = mix(top.colour, pixels.radiance(&above, &under)?, uncover);
                }
            }
            band.put_colour(simd, target(0), top.colour);
        }
        Ok(())
    }
}

/// `share` of the other colour.
#[inline(always)]
fn mix<F: Floats>(mut colour: [F; 3], other: [F; 3], share: F) -> [F; 3] {
    for (colour, other) in colour.iter_mut().zip(other) {
        *colour = (other - *colour).mul_add(share, *colour);
    }
    colour
}

struct Pixels<'p, S: PageSource, V: Simd> {
    simd: V,
    fan: Fan<'p, V>,
    sampler: Sampler<'p, S>,
    air: Air,
    pixel_angle: f32,
    spacing: f32,
}

impl<S: PageSource, V: Simd> Pixels<'_, S, V> {
    /// Radiance that reaches the eye; `below` is the row below.
    #[inline(always)]
    fn radiance(&mut self, seen: &Seen<V>, below: &Seen<V>) -> Result<[V::F; 3]> {
        let simd = self.simd;
        let ground = simd.splat(0.0).lt(seen.inverse);
        let sine = seen.slope[2] * seen.per_slant;
        if !ground.any() {
            return Ok(self.air.sky(simd, sine));
        }
        let depth = seen.depth * simd.splat(1.0 / self.spacing);
        let place = [seen.slope[0] * depth, seen.slope[1] * depth];
        let radiance = self.sampler.sample(simd, place, self.detail(seen, below), ground)?;
        let mut colour = self.air.haze(simd, radiance, seen.range, sine);
        if !ground.all() {
            let sky = self.air.sky(simd, sine);
            for (colour, sky) in colour.iter_mut().zip(sky) {
                *colour = colour.select(ground, sky);
            }
        }
        Ok(colour)
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
}

impl Band<'_> {
    fn rows(&self, width: usize) -> usize {
        match self {
            Self::Picture(bytes) => bytes.len() / (RGB * width.max(1)),
            Self::Frame { range, .. } => range.len() / width.max(1),
        }
    }

    /// Writes the colour of up to sixteen pixels.
    #[inline(always)]
    fn put_colour<V: Simd>(&mut self, simd: V, pixels: Range<usize>, colour: [V::F; 3]) {
        match self {
            Self::Picture(bytes) => {
                let (red, green, blue) =
                    (srgb8(simd, colour[0]), srgb8(simd, colour[1]), srgb8(simd, colour[2]));
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
            Self::Frame { colour: target, .. } => {
                let mut channels = [[0.0; LANES]; 3];
                for (lanes, channel) in colour.iter().zip(&mut channels) {
                    lanes.store(channel);
                }
                for (lane, pixel) in pixels.enumerate() {
                    target[pixel] = [channels[0][lane], channels[1][lane], channels[2][lane]];
                }
            }
        }
    }

    /// Writes the range of up to sixteen pixels.
    #[inline(always)]
    fn put_range<V: Simd>(&mut self, simd: V, pixels: Range<usize>, seen: &Seen<V>) {
        if let Self::Frame { range, .. } = self {
            let mut ranges = [0.0; LANES];
            let sky = seen.inverse.le(simd.splat(0.0));
            simd.splat(f32::INFINITY).select(sky, seen.range).store(&mut ranges);
            let target = &mut range[pixels];
            target.copy_from_slice(&ranges[..target.len()]);
        }
    }
}
