//! Strokes: pieces of ribbons on the screen, and what share of a pixel they cover.
//!
//! ```text
//! for each piece of a square, in order of time: for each pixel near it: the nearest place on the piece
//!     near to that of a stretch of the same ribbon that the pixel knows → the nearer of both to the pixel's middle
//!     else                                                             → another stretch: the ribbon crosses itself
//! for each pixel: what the ground does not hide of each stretch, the farthest first: its outline, then its colour
//! ```
//!
//! A stretch covers of a pixel what a band of its width covers of a pixel's width about the middle: that share grows and falls evenly as
//! the stretch moves, so that it neither jumps nor flickers.

use std::ops::Range;

use glam::{DVec2, Vec2, Vec3};

use super::view::SQUARE;
use crate::objects::PixelGround;
use crate::space::Footprint;

/// Share of what is behind them that outlines hide.
const OPAQUE: f32 = 0.7;

/// Share of inverse ranges by which ground that runs on from a pixel to the middle of a ribbon may rise or fall there.
const SAME: f64 = 0.01;

/// Pixels by which the ground may lie before a ribbon that runs over it: it is seen more coarsely than it was flown over.
const LIFT: f64 = 1.0;

/// No stretch.
const NONE: u32 = u32::MAX;

/// A straight piece of a ribbon on the screen.
#[derive(Debug, Clone, Copy)]
pub struct StrokePiece {
    /// Number of its ribbon.
    pub ribbon: u32,
    /// Pixels along the ribbon up to its beginning.
    pub along: f32,
    /// Pixels from its middle to the end of its colour, and to that of its outline.
    pub half: [f32; 2],
    /// Ends of the stroke.
    pub ends: [StrokeEnd; 2],
}

/// An end of a piece.
#[derive(Debug, Clone, Copy)]
pub struct StrokeEnd {
    /// Pixels from the screen's upper left corner.
    pub position: Vec2,
    /// One over its range, 1/metres.
    pub inverse: f32,
    /// Light of the ribbon, and of its outline, that reaches the eye: linear Rec. 709.
    pub light: [Vec3; 2],
}

/// A stretch of a ribbon in a pixel: the nearest place on it.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    piece: u32,
    /// Share of the way along the piece, 0…1.
    share: f32,
    /// Pixels along the ribbon.
    along: f32,
    /// Pixels from the middle of the pixel.
    distance: f32,
    /// The next stretch of the pixel, or [`NONE`].
    next: u32,
}

/// Something that covers a share of a pixel.
#[derive(Debug, Clone, Copy)]
struct Layer {
    /// One over its range, 1/metres, by which layers are put in order; and its own.
    rank: f32,
    inverse: f32,
    cover: f32,
    light: Vec3,
}

/// Covering of a pixel by ribbons.
#[derive(Debug, Clone, Copy)]
pub struct StrokeCover {
    /// Share of what is behind the ribbons that is seen.
    pub through: f32,
    /// Light of strokes, linear Rec. 709.
    pub light: Vec3,
    /// Range of the nearest that hides half of what is behind it or more, metres.
    pub range: Option<f32>,
}

/// Strokes of a screen.
#[derive(Debug, Clone, Copy)]
pub struct Strokes<'p> {
    /// All pieces; those of a ribbon follow each other in order of time.
    pub pieces: &'p [StrokePiece],
    /// Columns and rows of the screen.
    pub size: [usize; 2],
    /// Width of its pixels.
    pub footprint: Footprint,
}

/// Strokes in a square of the screen.
#[derive(Debug)]
pub struct StrokeSquare {
    /// First stretch of each pixel.
    heads: Vec<u32>,
    stretches: Vec<Stretch>,
    layers: Vec<Layer>,
}

impl Default for StrokeSquare {
    fn default() -> Self {
        Self { heads: vec![NONE; SQUARE * SQUARE], stretches: Vec::new(), layers: Vec::new() }
    }
}

impl Strokes<'_> {
    /// Width of a pixel as a share of the range there.
    fn pixel(&self, inverse: f32) -> f32 {
        match self.footprint {
            Footprint::Angle(angle) => angle as f32,
            Footprint::Width(width) => width as f32 * inverse,
        }
    }
}

impl StrokePiece {
    /// Pixels from its middle within which it covers some of a pixel.
    pub fn reach(&self) -> f32 {
        self.half[1] + 0.5
    }

    /// Columns and rows whose middles lie within its reach, of a screen of some size.
    pub fn extent(&self, size: [usize; 2]) -> [Range<usize>; 2] {
        let [from, to] = self.ends.map(|end| end.position);
        let (low, high) = (from.min(to) - self.reach() - 0.5, from.max(to) + self.reach() - 0.5);
        // A float converts saturating.
        [0, 1].map(|axis| {
            let first = low[axis].ceil().max(0.0) as usize;
            let end = (high[axis].floor() + 1.0).max(0.0) as usize;
            first.min(size[axis])..end.min(size[axis])
        })
    }

    /// The place nearest to a point: its share of the way, and its distance from there, pixels.
    fn nearest(&self, point: Vec2) -> (f32, f32) {
        let [from, to] = self.ends.map(|end| end.position);
        let (way, own) = (to - from, point - from);
        let square = way.length_squared();
        let share = if square > 0.0 { (own.dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
        (share, (own - way * share).length())
    }

    /// One over the range at a share of the way, 1/metres.
    fn inverse(&self, share: f32) -> f32 {
        let [from, to] = self.ends.map(|end| end.inverse);
        from + share * (to - from)
    }

    fn length(&self) -> f32 {
        (self.ends[1].position - self.ends[0].position).length()
    }
}

impl StrokeSquare {
    /// Goes to the square that begins at `corner`, in which those of some numbers are, and tells `put` row and column of each pixel of the screen that
    /// they cover, before what `ground` says of a column and row, and how.
    pub fn draw(
        &mut self,
        corner: [usize; 2],
        strokes: &Strokes<'_>,
        numbers: &[u32],
        ground: impl Fn(usize, usize) -> PixelGround,
        mut put: impl FnMut(usize, usize, &StrokeCover),
    ) {
        self.heads.fill(NONE);
        self.stretches.clear();
        for &number in numbers {
            self.take(corner, strokes, number);
        }

        for pixel in 0..self.heads.len() {
            if self.heads[pixel] == NONE {
                continue;
            }
            let [column, row] = [corner[0] + pixel % SQUARE, corner[1] + pixel / SQUARE];
            let middle = DVec2::new(column as f64, row as f64) + 0.5;
            self.find_layers(pixel, middle, strokes, &ground(column, row));
            if let Some(cover) = self.cover() {
                put(row, column, &cover);
            }
        }
    }

    /// Tells the pixels about a piece.
    fn take(&mut self, corner: [usize; 2], strokes: &Strokes<'_>, number: u32) {
        let piece = &strokes.pieces[number as usize];
        let [columns, rows] = piece.extent(strokes.size);
        let within = |range: Range<usize>, first: usize| {
            range.start.max(first)..range.end.min(first + SQUARE).max(range.start.max(first))
        };
        let (columns, rows) = (within(columns, corner[0]), within(rows, corner[1]));
        let (reach, length) = (piece.reach(), piece.length());

        for row in rows {
            for column in columns.clone() {
                let (share, distance) = piece.nearest(Vec2::new(column as f32 + 0.5, row as f32 + 0.5));
                if distance >= reach {
                    continue;
                }
                let along = piece.along + share * length;
                let pixel = (row - corner[1]) * SQUARE + column - corner[0];
                let found = Stretch { piece: number, share, along, distance, next: self.heads[pixel] };
                match self.alike(pixel, strokes, &found) {
                    Some(known) if self.stretches[known].distance <= distance => {}
                    Some(known) => {
                        let next = self.stretches[known].next;
                        self.stretches[known] = Stretch { next, ..found };
                    }
                    None => {
                        self.heads[pixel] = self.stretches.len() as u32;
                        self.stretches.push(found);
                    }
                }
            }
        }
    }

    /// Finds the stretch of a pixel that runs on into another.
    fn alike(&self, pixel: usize, strokes: &Strokes<'_>, found: &Stretch) -> Option<usize> {
        let own = &strokes.pieces[found.piece as usize];
        let mut at = self.heads[pixel];
        while let Some(known) = self.stretches.get(at as usize) {
            let is_same = strokes.pieces[known.piece as usize].ribbon == own.ribbon;
            // Two places of a straight stretch within reach of a pixel are no farther apart.
            if is_same && (known.along - found.along).abs() <= 2.0 * own.reach() + 1.0 {
                return Some(at as usize);
            }
            at = known.next;
        }
        None
    }

    /// Finds the layers of a pixel, the nearest first.
    fn find_layers(&mut self, pixel: usize, middle: DVec2, strokes: &Strokes<'_>, ground: &PixelGround) {
        self.layers.clear();
        let mut at = self.heads[pixel];

        while let Some(stretch) = self.stretches.get(at as usize) {
            let piece = &strokes.pieces[stretch.piece as usize];
            let seen = stretch.seen(piece, middle, ground);
            let inverse = piece.inverse(stretch.share);
            let [colour, outline] = piece.half.map(|half| covered(stretch.distance, half) * seen);
            let light = [0, 1].map(|part| {
                let [from, to] = piece.ends.map(|end| end.light[part]);
                from.lerp(to, stretch.share)
            });

            if colour > 0.0 {
                self.layers.push(Layer { rank: inverse, inverse, cover: colour, light: light[0] });
            }
            // An outline lies behind the colour of all stretches that are not farther behind it than it is wide.
            if outline > 0.0 && piece.half[1] > piece.half[0] {
                let rank = inverse * (1.0 - (2.0 * piece.half[1] * strokes.pixel(inverse)).min(1.0));
                self.layers.push(Layer { rank, inverse, cover: OPAQUE * outline, light: light[1] });
            }
            at = stretch.next;
        }

        let key = |layer: &Layer| [layer.rank, layer.cover, layer.light.x, layer.light.y, layer.light.z];
        self.layers.sort_by(|a, b| {
            let orders = key(b).into_iter().zip(key(a)).map(|(b, a)| b.total_cmp(&a));
            orders.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
    }

    /// Sums the layers; `None`: nothing is seen.
    fn cover(&self) -> Option<StrokeCover> {
        let mut cover = StrokeCover { through: 1.0, light: Vec3::ZERO, range: None };
        for layer in &self.layers {
            cover.light += layer.light * (cover.through * layer.cover);
            cover.through *= 1.0 - layer.cover;
            if cover.through <= 0.5 && cover.range.is_none() {
                cover.range = Some(1.0 / layer.inverse);
            }
        }
        (cover.through < 1.0).then_some(cover)
    }
}

impl Stretch {
    /// Share of it, 0…1, that the ground in a pixel, the middle of which is at `middle`, does not hide.
    fn seen(&self, piece: &StrokePiece, middle: DVec2, ground: &PixelGround) -> f32 {
        let own = f64::from(ground.inverse);
        if own == 0.0 {
            return 1.0;
        }
        let [from, to] = piece.ends.map(|end| end.position.as_dvec2());
        let nearest = from.lerp(to, f64::from(self.share));
        let slope = DVec2::from_array(ground.slope.map(f64::from));

        // Ground that a ribbon runs along lies before one half of its width, and behind the other: that below its middle counts.
        let most = SAME * own;
        let below = own + slope.dot(nearest - middle).clamp(-most, most);
        let below = below - (LIFT * slope.length()).min(most);

        // Where it runs into the ground, the cut lies across it.
        let before = f64::from(piece.inverse(self.share)) - below;
        let (way, length) = (to - from, (to - from).length());
        let rise = f64::from(piece.ends[1].inverse - piece.ends[0].inverse);
        let change = if length > 0.0 { (rise - slope.dot(way)).abs() / length } else { 0.0 };
        (0.5 + before / change.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) as f32
    }
}

/// Share of a pixel's width, about a place so many pixels from the middle of a band, that the band covers to so many pixels on either side.
fn covered(distance: f32, half: f32) -> f32 {
    ((distance + 0.5).min(half) - (distance - 0.5).max(-half)).clamp(0.0, 1.0)
}
