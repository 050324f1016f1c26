//! A file's points, all of them gone through once: where they lie, and what they are of.
//!
//! A header's box is a claim of the program that wrote it, and many write zeros, or the box of a file that this one was cut from.
//! What is built is therefore taken from the points. Ranges of them are read at the same time, as far as a file can be entered in its middle.

use std::ops::Range;
use std::path::Path;

use super::super::workers::in_order;
use super::class::{self, PointKind};
use super::head::Head;
use super::read::{Points, RawPoint};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Points that a thread reads in a row: many chunks of a LAZ file, which can be entered at their beginnings only.
const RANGE: u64 = 1 << 20;
/// Points between two looks at whether to go on.
const STEP: u64 = 1 << 16;
/// Farthest coordinate that anything on Earth has, in any unit.
const FARTHEST: f64 = 1.0e10;

/// Summary of the points of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Points that are of use, and those of the ground among them.
    pub used: u64,
    pub ground: u64,
    /// The greatest code of a colour.
    pub brightest: u16,
    /// Least and greatest coordinates of points that are of use: x, y, z.
    pub low: [f64; 3],
    pub high: [f64; 3],
    /// The same of all points, which a header's box is about.
    pub all: [[f64; 3]; 2],
}

impl Look {
    /// Goes through all points of a file, on so many threads.
    pub fn at(path: &Path, head: &Head, threads: usize, observer: &dyn Observer) -> Result<Self> {
        observer.begin("extents", head.count, "points");
        let ranges = head.count.div_ceil(RANGE);
        let look = match ranges == 1 || Points::open(path, head)?.seek(RANGE) {
            true => {
                let mut look = Self::none();
                let read = |reader: &mut Option<Points>, range: u64| {
                    Self::of_range(path, head, reader, range * RANGE..(range + 1) * RANGE, observer)
                };

                in_order(
                    ranges,
                    threads,
                    observer,
                    || None,
                    read,
                    |_, part| {
                        look.join(&part);
                        Ok(())
                    },
                )?;

                look
            }
            false => Self::of_range(path, head, &mut None, 0..head.count, observer)?,
        };

        observer.end();

        let is_far = |value: &f64| value.abs() > FARTHEST;
        if look.used > 0 && look.all.iter().flatten().any(is_far) {
            return Err(Error::invalid(
                path,
                format!(
                    "its points lie from {:?} to {:?}, which is no place on Earth: its header states scales of {:?} and offsets of {:?}, \
                 one of which is wrong; write it anew with `pdal translate` or `las2las`",
                    look.all[0], look.all[1], head.scale, head.offset
                ),
            ));
        }

        Ok(look)
    }

    /// Goes through points by their numbers; `reader` is opened where it is not yet.
    fn of_range(
        path: &Path,
        head: &Head,
        reader: &mut Option<Points>,
        range: Range<u64>,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let points = match reader {
            Some(points) => points,
            None => reader.insert(Points::open(path, head)?),
        };
        if range.start > 0 && !points.seek(range.start) {
            let what = format!("cannot be read from point {} on; it is damaged, fetch it again", range.start);
            return Err(Error::invalid(path, what));
        }

        let (mut look, mut left) = (Self::none(), range.end - range.start);
        while left > 0 && !observer.cancelled() {
            let count = points.take(left.min(STEP), |point| look.meet(&point))?;
            if count == 0 {
                break;
            }
            left -= count;
            observer.advance(count);
        }

        Ok(look)
    }

    fn none() -> Self {
        let (low, high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        Self { used: 0, ground: 0, brightest: 0, low, high, all: [low, high] }
    }

    fn meet(&mut self, point: &RawPoint) {
        let kind = class::kind(point.class).filter(|_| !point.is_withheld);
        let place = point.place;
        let own = Self {
            used: u64::from(kind.is_some()),
            ground: u64::from(kind == Some(PointKind::Ground)),
            brightest: point.colour.into_iter().fold(0, u16::max),
            all: [place, place],
            ..Self::none()
        };
        let own = if kind.is_some() { Self { low: place, high: place, ..own } } else { own };
        self.join(&own);
    }

    fn join(&mut self, other: &Self) {
        self.used += other.used;
        self.ground += other.ground;
        self.brightest = self.brightest.max(other.brightest);
        let least = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis].min(b[axis]));
        let most = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis].max(b[axis]));
        (self.low, self.high) = (least(self.low, other.low), most(self.high, other.high));
        self.all = [least(self.all[0], other.all[0]), most(self.all[1], other.all[1])];
    }

    /// Whether points are classified: without ground they are a surface.
    pub fn is_classified(&self) -> bool {
        self.ground > 0
    }

    /// sRGB of a colour as stored; `None` where the file has none.
    pub fn srgb(&self, colour: [u16; 3]) -> Option<[u8; 3]> {
        // Some writers leave colours of eight bits as they are.
        let shift = if self.brightest > 255 { 8 } else { 0 };
        (self.brightest > 0).then(|| colour.map(|code| (code >> shift).min(255) as u8))
    }

    /// A sentence about a header whose box is not that of the points; `None` where it is, but for rounding.
    pub fn contradiction(&self, name: &str, head: &Head) -> Option<String> {
        let stated = [head.low, head.high];
        let differs = |side: usize, axis: usize| {
            let off = (stated[side][axis] - self.all[side][axis]).abs();
            // Writers round the box to counts, or write a few decimals of it.
            let rounding = (2.0 * head.scale[axis]).max(0.01);
            off.is_nan() || off > rounding
        };
        let is_off = (0..2).any(|side| (0..2).any(|axis| differs(side, axis)));
        let extent =
            |[low, high]: [[f64; 3]; 2]| format!("x {} to {}, y {} to {}", low[0], high[0], low[1], high[1]);
        is_off.then(|| {
            format!(
                "{name}: its points lie in {}, and its header says {}; the points count",
                extent(self.all),
                extent(stated)
            )
        })
    }
}
