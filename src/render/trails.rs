//! Trails: ways that were flown, drawn where nothing stands before them.
//!
//! ```text
//! each ribbon:    chords as fine as the view tells them apart ──▶ pieces of the screen, each nearly straight and of one range
//! each square:    its pieces ──▶ strokes ──▶ over what the passes before have drawn
//! ```
//!
//! Trails are no surfaces: frames keep ranges, normals, ids and shares of what is behind them. Passes after this one, which
//! ask what lies before and behind air, see the ranges of trails.

use std::borrow::Cow;

use glam::{DMat3, DVec2, DVec3, Vec3};

use super::canvas::{BodyRows, Canvas};
use super::finder::Finder;
use super::overlays::Pass;
use super::renderer::Renderer;
use super::shown_ground::ShownGround;
use crate::earth::Curvature;
use crate::objects::{
    ChordNode, Ribbon, RibbonSample, SQUARE, Sight, StrokeEnd, StrokePiece, StrokeSquare, Strokes,
};
use crate::simd::LANES;
use crate::space::{Camera, Footprint, Screen};
use crate::subimage::{Farm, Stage};
use crate::weather::Atmosphere;
use hedgehop_base::error::Result;

/// Pixels by which a chord may be off the samples that it stands for, and difference of their values.
const OFF: f64 = 0.15;
const UNLIKE: f32 = 0.02;

/// Pixels of a piece at most, by which a screen may bend it, and of one that nobody sees bend.
const LONGEST: f64 = 32.0;
const BENT: f64 = 0.15;
const SHORTEST: f64 = 2.0;

/// Distance from the eye at which ribbons begin, metres: one that ends in it would fill the view.
const NEAR: f64 = 1.0;

/// Least range, metres: where a ribbon passes the eye on a screen that sees all around.
const CLOSEST: f64 = 1.0e-3;

/// Halvings of a chord at most, and of one of which an end is on no screen.
const MOST_HALVINGS: u32 = 40;
const MOST_AT_EDGE: u32 = 10;

/// Share of its distance that a chord is long of which no end is on the screen, and that is looked at no closer.
const UNSEEN: f64 = 0.05;

/// Light of outlines, before haze.
const DARK: Vec3 = Vec3::splat(0.008);

/// Trails that a view may show.
pub(super) struct TrailPass<'c> {
    camera: &'c Camera,
    pieces: Vec<StrokePiece>,
    /// Numbers of pieces by square of the screen, row by row.
    squares: Vec<Vec<u32>>,
    /// Whether passes after it see the ranges of trails.
    pub has_ranges: bool,
}

/// Observer of ribbons.
struct RibbonEye<'c> {
    camera: &'c Camera,
    finder: Finder<'c>,
    view_from_world: DMat3,
    curvature: Curvature,
    atmosphere: Atmosphere,
    /// Factor on the light of the air, by channel.
    tint: Vec3,
    size: DVec2,
    /// Whether lines of the world are lines of the screen.
    is_straight: bool,
    /// Pixels after which a row of the screen begins again, if it goes all around.
    turn: Option<f64>,
}

/// A place of a ribbon before an eye.
#[derive(Clone, Copy)]
struct Vertex {
    /// Metres in the world, lowered by the Earth's curvature.
    place: DVec3,
    value: f32,
    /// Pixels; `None` where the screen does not show it.
    position: Option<DVec2>,
}

/// A ribbon as it is taken to the screen.
struct Tracing<'e, 'c> {
    eye: &'e RibbonEye<'c>,
    ribbon: &'e Ribbon,
    number: u32,
    pieces: Vec<StrokePiece>,
    /// Time of the end of the last chord, seconds, and pixels along the ribbon up to there.
    time: f64,
    along: f64,
}

impl<'c> TrailPass<'c> {
    /// Finds what `camera` may see of `ribbons`.
    pub fn find(
        renderer: &Renderer<'_>,
        camera: &'c Camera,
        ribbons: &[Ribbon],
        farm: &Farm,
    ) -> Result<Self> {
        let mut pass = Self { camera, pieces: Vec::new(), squares: Vec::new(), has_ranges: false };
        if ribbons.is_empty() {
            return Ok(pass);
        }

        let eye = RibbonEye::new(renderer, camera);
        let mut traced: Vec<Vec<StrokePiece>> = vec![Vec::new(); ribbons.len()];
        farm.each(Stage::Image, ribbons.iter().zip(&mut traced).collect(), |index, (ribbon, pieces)| {
            *pieces = eye.trace(ribbon, index as u32);
            Ok(())
        })?;
        pass.pieces = traced.concat();

        let size = pass.size();
        let across = size[0].div_ceil(SQUARE);
        pass.squares = vec![Vec::new(); across * size[1].div_ceil(SQUARE)];
        for (number, piece) in (0..).zip(&pass.pieces) {
            let [columns, rows] = piece.extent(size);
            for row in rows.start / SQUARE..rows.end.div_ceil(SQUARE) {
                for column in columns.start / SQUARE..columns.end.div_ceil(SQUARE) {
                    pass.squares[row * across + column].push(number);
                }
            }
        }

        Ok(pass)
    }

    /// Whether the screen shows none.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Adds the parts of rows, [`LANES`] pixels wide, whose range tells whether trails are hidden, to those of which it is known that they are asked for, `[rows][parts of a
    /// row]`; empty: none is.
    pub fn mark(&self, parts: &mut Vec<bool>) {
        let [width, height] = self.size();
        let count = width.div_ceil(LANES);
        parts.resize(if self.is_empty() { parts.len() } else { count * height }, false);
        for piece in &self.pieces {
            let [columns, rows] = piece.extent([width, height]);
            if columns.is_empty() {
                continue;
            }
            // Neighbours tell how the ground in a pixel lies.
            let first = columns.start.saturating_sub(1) / LANES;
            let end = (columns.end + 1).min(width).div_ceil(LANES);
            for row in rows.start.saturating_sub(1)..(rows.end + 1).min(height) {
                parts[row * count + first..row * count + end].fill(true);
            }
        }
    }

    fn size(&self) -> [usize; 2] {
        [self.camera.width as usize, self.camera.height as usize]
    }
}

impl Pass for TrailPass<'_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }

        let (camera, width) = (self.camera, canvas.width());
        let (rows, range) = if self.has_ranges {
            canvas.body_rows()
        } else {
            let (pixels, range) = canvas.light_and_range(SQUARE);
            let bare = |pixels| BodyRows { pixels, range: &mut [], surface: None };
            (pixels.into_iter().map(bare).collect(), Cow::Borrowed(range))
        };
        let shown = ShownGround { range: &range, width };
        let strokes = Strokes { pieces: &self.pieces, size: self.size(), footprint: camera.footprint() };
        let has_blind =
            matches!(camera.screen(), Screen::Fisheye { .. } | Screen::Table(_) | Screen::Lens { .. });

        let tasks = self.squares.chunks(width.div_ceil(SQUARE)).zip(rows).collect();
        farm.each_with(Stage::Image, tasks, StrokeSquare::default, |scratch, index, (squares, mut rows)| {
            let first = index * SQUARE;
            for (square, numbers) in squares.iter().enumerate().filter(|(_, numbers)| !numbers.is_empty()) {
                let ground = |column, row| shown.ground(column, row);
                scratch.draw([square * SQUARE, first], &strokes, numbers, ground, |row, column, cover| {
                    let middle = DVec2::new(column as f64, row as f64) + 0.5;
                    if has_blind && camera.ray(middle.x, middle.y).is_none() {
                        return;
                    }
                    let pixel = (row - first) * width + column;
                    let behind = rows.pixels.light(pixel);
                    rows.pixels.put(pixel, cover.light + behind * cover.through);
                    if let (Some(range), Some(own)) = (rows.range.get_mut(pixel), cover.range) {
                        *range = own;
                    }
                });
            }
            Ok(())
        })
    }
}

impl<'c> RibbonEye<'c> {
    fn new(renderer: &Renderer<'_>, camera: &'c Camera) -> Self {
        let options = &renderer.options;
        let screen = camera.screen();
        let is_round = match screen {
            Screen::Cylindrical { hfov } | Screen::Equirectangular { hfov, .. } => *hfov == 360.0,
            _ => false,
        };
        Self {
            camera,
            finder: Finder::new(camera),
            view_from_world: camera.world_from_view().transpose(),
            curvature: options.curvature,
            atmosphere: options.atmosphere(renderer.source.header()),
            tint: options.brightness().tint(),
            size: DVec2::new(f64::from(camera.width), f64::from(camera.height)),
            is_straight: matches!(screen, Screen::Planar { .. } | Screen::Orthographic { .. }),
            turn: is_round.then(|| f64::from(camera.width)),
        }
    }

    /// Whether rays are parallel.
    fn is_parallel(&self) -> bool {
        matches!(self.camera.footprint(), Footprint::Width(_))
    }

    /// Takes a ribbon to the screen.
    fn trace(&self, ribbon: &Ribbon, number: u32) -> Vec<StrokePiece> {
        let mut tracing =
            Tracing { eye: self, ribbon, number, pieces: Vec::new(), time: f64::NAN, along: 0.0 };
        ribbon.line.pieces(
            ribbon.span,
            |node| self.judge(node, ribbon.reach()),
            |from, to| tracing.chord(from, to),
        );
        tracing.pieces
    }

    /// Judges how finely a part of a ribbon is to be looked at.
    fn judge(&self, node: &ChordNode, reach: f64) -> Sight {
        let centre = self.lowered(node.centre) - self.camera.pose.eye;
        let across = centre.truncate().length();
        let bend = self.curvature.drop_at(across + node.radius) - self.curvature.drop_at(across);
        let radius = node.radius + bend;
        let view = self.view_from_world * centre;

        if self.is_beside(view, radius, reach) {
            return Sight::Beside;
        }
        let planar = matches!(self.camera.screen(), Screen::Planar { .. });
        let nearest = if planar { view.z } else { view.length() } - radius;
        let pixel = self.camera.footprint().at(nearest.max(0.0));
        let is_fine = node.off <= OFF * pixel && (node.unlike <= UNLIKE || radius <= pixel);
        if is_fine { Sight::Fine } else { Sight::Coarse }
    }

    /// Whether a sphere in the axes of the view is in none of its pixels, where that is easily told.
    fn is_beside(&self, view: DVec3, radius: f64, reach: f64) -> bool {
        let half = (0.5 * self.size + reach + 1.0) / self.camera.focal_px();
        let off = view.truncate().abs();
        match self.camera.screen() {
            Screen::Planar { .. } => {
                let beyond = (off - view.z * half) / (half * half + 1.0).map(f64::sqrt);
                view.z + radius < NEAR || beyond.max_element() > radius
            }
            Screen::Orthographic { .. } => view.z + radius < 0.0 || (off - half).max_element() > radius,
            _ => false,
        }
    }

    /// A place of the world as the Earth's curvature has the eye see it.
    fn lowered(&self, place: DVec3) -> DVec3 {
        let way = place - self.camera.pose.eye;
        let across = if self.is_parallel() {
            let axis = self.camera.world_from_view().z_axis;
            way.dot(axis) * axis.truncate().length()
        } else {
            way.truncate().length()
        };
        place - DVec3::Z * self.curvature.drop_at(across)
    }

    /// A vertex at a place that is lowered already; `known` is a position near to its own.
    fn vertex(&self, place: DVec3, value: f32, known: Option<DVec2>) -> Vertex {
        Vertex { place, value, position: self.finder.position_near(place, known) }
    }

    /// End of a piece at a vertex.
    fn end(&self, vertex: &Vertex, position: DVec2, ribbon: &Ribbon) -> StrokeEnd {
        let way = vertex.place - self.camera.pose.eye;
        let (range, direction) = if self.is_parallel() {
            let axis = self.camera.world_from_view().z_axis;
            (way.dot(axis), axis)
        } else {
            (way.length(), way.normalize_or_zero())
        };
        let from = vertex.place.z - direction.z * range;
        let veil = self.atmosphere.veil(from, direction.as_vec3(), range as f32);
        let light = [ribbon.ramp.at(vertex.value), DARK];
        StrokeEnd {
            position: position.as_vec2(),
            inverse: (1.0 / range.max(CLOSEST)) as f32,
            light: light.map(|light| self.tint * veil.light + light * veil.through),
        }
    }
}

impl Tracing<'_, '_> {
    /// Takes a straight piece of the ribbon to the screen.
    fn chord(&mut self, from: &RibbonSample, to: &RibbonSample) {
        if from.time != self.time {
            self.skip();
        }
        self.time = to.time;

        let ends = [from, to].map(|sample| self.eye.lowered(sample.position));
        let Some([begin, end]) = self.shares_in_front(ends) else { return self.skip() };
        if begin > 0.0 {
            self.skip();
        }
        let at = |share: f64| {
            let value = from.value + share as f32 * (to.value - from.value);
            self.eye.vertex(ends[0].lerp(ends[1], share), value, None)
        };
        let (one, other) = (at(begin), at(end));
        self.halve(&one, &other, 0);
        if end < 1.0 {
            self.skip();
        }
    }

    /// Shares of the way between which a chord is in front of the eye; `None`: nowhere.
    fn shares_in_front(&self, ends: [DVec3; 2]) -> Option<[f64; 2]> {
        let Screen::Planar { .. } = self.eye.camera.screen() else { return Some([0.0, 1.0]) };
        let axis = self.eye.camera.world_from_view().z_axis;
        let [from, to] = ends.map(|end| (end - self.eye.camera.pose.eye).dot(axis) - NEAR);
        let cut = from / (from - to);
        match (from >= 0.0, to >= 0.0) {
            (true, true) => Some([0.0, 1.0]),
            (true, false) => Some([0.0, cut]),
            (false, true) => Some([cut, 1.0]),
            (false, false) => None,
        }
    }

    /// Leaves a gap.
    fn skip(&mut self) {
        self.along += 4.0 * self.ribbon.reach() + 8.0;
    }

    /// Puts pieces between two vertices, or halves what lies between them until it is straight and short enough.
    fn halve(&mut self, from: &Vertex, to: &Vertex, halvings: u32) {
        let eye = self.eye;
        let is_last = halvings >= MOST_HALVINGS;
        let middle = || {
            let place = 0.5 * (from.place + to.place);
            eye.vertex(place, 0.5 * (from.value + to.value), from.position.or(to.position))
        };

        let middle = match (from.position, to.position) {
            (Some(one), Some(other)) => {
                let length = (other - one).length();
                let is_short = length <= LONGEST;
                if self.is_off_screen(one, other) {
                    return self.skip();
                }
                if is_last && !is_short {
                    // A row that goes all around begins again where it ends.
                    return if eye.turn.is_none() {
                        self.skip()
                    };
                }
                if is_short && (eye.is_straight || length <= SHORTEST) || is_last {
                    return self.put(from, to, [one, other]);
                }
                let middle = middle();
                let bent = middle.position.map(|at| (at - 0.5 * (one + other)).length());
                if is_short && bent.is_some_and(|bent| bent <= BENT) {
                    return self.put(from, to, [one, other]);
                }
                middle
            }
            (None, None) => {
                let ways = [from, to].map(|vertex| (vertex.place - eye.camera.pose.eye).length());
                let is_small = (to.place - from.place).length() < UNSEEN * ways[0].min(ways[1]);
                if is_small || eye.is_straight || halvings >= MOST_AT_EDGE {
                    return self.skip();
                }
                middle()
            }
            _ if halvings >= MOST_AT_EDGE + 6 => return self.skip(),
            _ => middle(),
        };
        self.halve(from, &middle, halvings + 1);
        self.halve(&middle, to, halvings + 1);
    }

    /// Whether nothing between two positions is on the screen.
    fn is_off_screen(&self, one: DVec2, other: DVec2) -> bool {
        let length = (other - one).length();
        let bend = if self.eye.is_straight { 0.0 } else { length.min(self.eye.size.max_element()) };
        let margin = self.ribbon.reach() + 1.0 + bend;
        let (low, high) = (one.min(other) - margin, one.max(other) + margin);
        high.cmplt(DVec2::ZERO).any() || low.cmpgt(self.eye.size).any()
    }

    /// Puts a piece, and once more where the screen begins again.
    fn put(&mut self, from: &Vertex, to: &Vertex, positions: [DVec2; 2]) {
        let half = [0.5 * self.ribbon.width, self.ribbon.reach()].map(|half| half as f32);
        let [one, other] = positions;
        let ends = [self.eye.end(from, one, self.ribbon), self.eye.end(to, other, self.ribbon)];
        let piece = StrokePiece { ribbon: self.number, along: self.along as f32, half, ends };
        self.along += (other - one).length();
        self.pieces.push(piece);

        let Some(turn) = self.eye.turn else { return };
        let margin = self.ribbon.reach() + 1.0;
        let (low, high) = (one.x.min(other.x), one.x.max(other.x));
        for shift in [(low < margin).then_some(turn), (high > turn - margin).then_some(-turn)] {
            let Some(shift) = shift else { continue };
            let mut again = piece;
            for end in &mut again.ends {
                end.position.x += shift as f32;
            }
            self.pieces.push(again);
        }
    }
}
