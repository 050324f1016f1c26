//! Spans of cells of several voxels, for what is seen from afar: made of those of the voxels, and like them.
//!
//! ```text
//! for each cell of 2 × 2 or 4 × 4 voxels:
//!     sort its spans by kind (opaque or not, on the ground or not, strips) and height: what is as high is one group, if it stands side by side
//!     for each group:
//!         ends     = means over the areas that the spans cover
//!         opaque:    it fills the cell, or the half-plane of the same area, if it lies as that does
//!         otherwise: opacity = 1 − the mean, over the cell's rows and columns of voxels, of what comes through
//! ```
//!
//! So houses keep walls and roofs where a voxel is less than a pixel, and a crown hides as much as its leaves do. That opacity says what comes
//! through a coarser voxel is how volumes are filtered (Crassin et al., *GigaVoxels*, I3D 2009).

use super::{BLOCK_SIDE, Cut, Facade, Span};
use crate::simd::Each;
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_light};

/// Share of a cell from which on it is full.
const FULL: f32 = 0.97;

/// Share of a half-plane's distance from the cell's centre at which the middle of what is covered must lie, for the half-plane to stand for it.
const LEAST_ASIDE: f32 = 0.7;

/// Share of light that a group hides below which it is left out, alone and where something else is in the cell, such as the crown about a trunk.
const LEAST_HIDDEN: [f32; 2] = [0.02, 0.1];

/// Weight in the colour of sides of what has no wall of its own: within a house all that may stand out is roof.
const WITHIN: f32 = 0.02;

/// Most rows of voxels of a cell.
const MOST_ROWS: usize = 4;

/// Cells along which a block lies, and how many voxels lie along each.
#[derive(Debug, Clone, Copy)]
pub(super) struct CoarseCells {
    /// Voxels along a cell, 2 or 4.
    pub side: u32,
    /// Codes by which a slope of one step rises over half a voxel, as for [`super::SpanTable::new`].
    pub rise: f32,
}

/// Part of a cell that a voxel's span covers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Number of the cell in its block.
    pub cell: u8,
    /// Column and row of the voxel in the cell.
    voxel: [u8; 2],
    span: Span,
    /// Share of the cell.
    area: f32,
    /// Its middle, east and north of the cell's centre, sides of a cell.
    middle: [f32; 2],
    /// Codes of its ends there.
    ends: [f32; 2],
    /// Share of light that it hides on a way through its voxel.
    hides: f32,
    /// Number of its group in the cell.
    group: usize,
}

impl Piece {
    /// Height that it has in common with another one, codes; less than 0: they are apart.
    fn overlap(&self, other: &Self) -> f32 {
        self.ends[1].min(other.ends[1]) - self.ends[0].max(other.ends[0])
    }

    /// Weight in the colour of sides.
    fn side_weight(&self) -> f32 {
        let walls = self.span.cuts.iter().enumerate();
        let is_wall = |(index, cut): (usize, &Cut)| cut.is_wall() && !self.span.is_joined(index);
        self.area * if walls.into_iter().any(is_wall) { 1.0 } else { WITHIN }
    }
}

/// Kind of a span: what differs in it is not mixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct SpanKind {
    is_strip: bool,
    is_opaque: bool,
    hangs: bool,
}

impl SpanKind {
    fn of(span: &Span) -> Self {
        Self {
            is_strip: span.is(Span::STRIP),
            is_opaque: span.state & Span::OPACITY == Span::OPAQUE,
            hangs: span.low != Span::GROUND,
        }
    }
}

impl CoarseCells {
    /// Appends the parts that the spans of a block of voxels cover, `at` so many blocks east and north of the first one under a block of cells.
    pub fn cut<'s>(self, spans_at: impl Fn(usize) -> &'s [Span], at: [u32; 2], pieces: &mut Vec<Piece>) {
        let side = self.side;
        for voxel in 0..BLOCK_SIDE * BLOCK_SIDE {
            let place = [at[0] * BLOCK_SIDE + voxel % BLOCK_SIDE, at[1] * BLOCK_SIDE + voxel / BLOCK_SIDE];
            let cell = (place[1] / side * BLOCK_SIDE + place[0] / side) as u8;
            let within = place.each(|place| place % side);
            let centre = within.each(|within| (within as f32 + 0.5) / side as f32 - 0.5);
            for span in spans_at(voxel as usize) {
                pieces.extend(self.piece(span, cell, within.each(|within| within as u8), centre));
            }
        }
    }

    /// The part of a cell that a span of one of its voxels covers; `None`: nothing.
    fn piece(self, span: &Span, cell: u8, voxel: [u8; 2], centre: [f32; 2]) -> Option<Piece> {
        let is_strip = span.is(Span::STRIP);
        let (share, [east, north]) = if is_strip { (1.0, [0.0; 2]) } else { covered(span.walls()) };
        if share <= 0.0 {
            return None;
        }

        let per_voxel = 1.0 / self.side as f32;
        // A slope of one step rises by twice this over a voxel.
        let [a, b] = span.slope.each(f32::from);
        let rise = (a * east + b * north) * 2.0 * self.rise;
        let top = f32::from(span.high) + rise;
        let low = f32::from(span.low) + if span.is(Span::PARALLEL) { rise } else { 0.0 };

        Some(Piece {
            cell,
            voxel,
            span: *span,
            area: share * per_voxel * per_voxel,
            middle: [centre[0] + east * per_voxel, centre[1] + north * per_voxel],
            ends: [low, top],
            hides: span.opacity() * share.sqrt(),
            group: 0,
        })
    }

    /// Appends the spans of a cell to `spans`, lowest first.
    pub fn join(self, pieces: &mut [Piece], spans: &mut Vec<Span>) {
        pieces.sort_by(|a, b| {
            SpanKind::of(&a.span).cmp(&SpanKind::of(&b.span)).then(a.ends[1].total_cmp(&b.ends[1]))
        });
        let mut groups = 0;
        for index in 0..pieces.len() {
            let (before, piece) = pieces.split_at_mut(index);
            let fits =
                |group: &usize| self.belongs(&piece[0], before.iter().filter(|other| other.group == *group));
            piece[0].group = (0..groups).rev().find(fits).unwrap_or(groups);
            groups = groups.max(piece[0].group + 1);
        }

        pieces.sort_by_key(|piece| piece.group);
        let first = spans.len();
        let least = LEAST_HIDDEN[usize::from(groups > 1)];
        spans
            .extend(pieces.chunk_by(|a, b| a.group == b.group).filter_map(|group| self.joined(group, least)));
        spans[first..].sort_by_key(|span| (span.low, span.high));
    }

    /// Whether a piece stands beside those of a group, which are no higher than it.
    fn belongs<'p>(self, piece: &Piece, group: impl Iterator<Item = &'p Piece>) -> bool {
        // A step as high as a cell is wide is to be seen, but for one in leaves.
        let step = self.side as f32 * 2.0 * self.rise * Span::SLOPE_STEPS;
        let kind = SpanKind::of(&piece.span);
        let mut is_near = false;
        for other in group {
            let overlap = piece.overlap(other);
            let is_stacked = piece.voxel == other.voxel && overlap <= 0.0;
            if SpanKind::of(&other.span) != kind || is_stacked {
                return false;
            }
            is_near |= piece.ends[1] - other.ends[1] < step || (!kind.is_opaque && overlap > 0.0);
        }
        is_near
    }

    /// One span for pieces of one kind.
    fn joined(self, group: &[Piece], least: f32) -> Option<Span> {
        let area: f32 = group.iter().map(|piece| piece.area).sum();
        let mean =
            |of: &dyn Fn(&Piece) -> f32| group.iter().map(|piece| piece.area * of(piece)).sum::<f32>() / area;
        let kind = SpanKind::of(&group[0].span);
        let largest = group.iter().reduce(|a, b| if a.area < b.area { b } else { a })?.span;
        let middle = [0, 1].map(|axis| mean(&|piece| piece.middle[axis]));

        // Ends over the cell's centre, no higher than what stands there.
        let slope = [0, 1].map(|axis| mean(&|piece| f32::from(piece.span.slope[axis])).round() as i8);
        let per_side = 2.0 * self.rise * self.side as f32;
        let rise = (f32::from(slope[0]) * middle[0] + f32::from(slope[1]) * middle[1]) * per_side;
        let room = |slope: [i8; 2], rise: f32| {
            (f32::from(slope[0].unsigned_abs()) + f32::from(slope[1].unsigned_abs())) * rise
        };
        let highest = group
            .iter()
            .map(|piece| f32::from(piece.span.high) + room(piece.span.slope, self.rise))
            .fold(0.0, f32::max);
        let high = (mean(&|piece| piece.ends[1]) - rise).min(highest - 0.5 * room(slope, per_side));
        let high = high.round().max(1.0) as u16;
        let is_parallel = kind.hangs && largest.is(Span::PARALLEL);
        let low = mean(&|piece| piece.ends[0]) - if is_parallel { rise } else { 0.0 };
        let low = if kind.hangs { (low.round().max(1.0) as u16).min(high) } else { Span::GROUND };

        let colour = |of: &dyn Fn(&Piece) -> ([u8; 3], f32)| {
            let (mut light, mut weights) = ([0.0; 3], 0.0);
            for (colour, weight) in group.iter().map(of) {
                let linear = linear_from_srgb8(colour);
                light = [0, 1, 2].map(|channel| light[channel] + weight * linear[channel]);
                weights += weight;
            }
            srgb8_from_light(light.map(|light| light / weights))
        };
        let hidden = self.hidden(group);
        if hidden < least && !kind.is_strip {
            return None;
        }
        let (cuts, opacity) = match kind {
            SpanKind { is_strip: true, .. } => {
                let opacities: f32 = group.iter().map(|piece| piece.span.opacity()).sum();
                (strip(group, middle, largest.cuts[0].facing), (opacities / self.side as f32).min(1.0))
            }
            SpanKind { is_opaque: true, .. } if area >= FULL => ([Cut::NONE; 3], 1.0),
            SpanKind { is_opaque: true, .. } => match half_plane(area, middle) {
                Some(wall) => ([wall, Cut::NONE, Cut::NONE], 1.0),
                None => ([Cut::NONE; 3], hidden),
            },
            _ => {
                let round = largest.cuts[0];
                let first = if round.is_round() { round } else { Cut::NONE };
                ([first, Cut::NONE, Cut::NONE], hidden)
            }
        };

        let opaque = f32::from(Span::OPAQUE);
        let mut state = (opacity * opaque).round().clamp(1.0, opaque) as u8;
        state |= if is_parallel { Span::PARALLEL } else { 0 } | if kind.is_strip { Span::STRIP } else { 0 };
        Some(Span {
            low,
            high,
            slope,
            cuts,
            top: colour(&|piece| (piece.span.top, piece.area)),
            state,
            side: colour(&|piece| (piece.span.side, piece.side_weight())),
            material: largest.material,
            facade: facade_of(group),
        })
    }

    /// Share of light that pieces hide on a way through the cell along an axis.
    fn hidden(self, group: &[Piece]) -> f32 {
        let mut left = [[1.0; MOST_ROWS]; 2];
        for piece in group {
            for (axis, left) in left.iter_mut().enumerate() {
                left[usize::from(piece.voxel[axis])] *= 1.0 - piece.hides;
            }
        }
        let rows = self.side as usize;
        let sum: f32 = left.iter().flat_map(|rows_left| &rows_left[..rows]).sum();
        1.0 - sum / (2 * rows) as f32
    }
}

/// Façade of the largest piece that has one.
fn facade_of(group: &[Piece]) -> Facade {
    let with_facade = group.iter().filter(|piece| !piece.span.facade.is_none());
    let largest = with_facade.reduce(|a, b| if a.area < b.area { b } else { a });
    largest.map_or(Facade::NONE, |piece| piece.span.facade)
}

/// Cuts of a strip that goes through the middles of others.
fn strip(group: &[Piece], middle: [f32; 2], facing: u8) -> [Cut; 3] {
    let normal = Cut::wall(facing, 0).normal();
    let first = &group[0];
    let side = first.area.sqrt();
    // The strips' own distances from their voxels' centres, in sides of a cell, count as well.
    let own: f32 = group.iter().map(|piece| piece.span.cuts[0].distance()).sum::<f32>() / group.len() as f32;
    let distance = normal[0] * middle[0] + normal[1] * middle[1] + own * side;
    [Cut::wall(facing, (distance * Cut::STEPS).round() as i32), Cut::NONE, Cut::NONE]
}

/// The half-plane that covers a share of a cell, on the side where its middle lies; `None` where that is too near to the centre for one.
fn half_plane(area: f32, middle: [f32; 2]) -> Option<Cut> {
    let aside = middle[0].hypot(middle[1]);
    if aside == 0.0 {
        return None;
    }

    // Outside lies away from the middle.
    let angle = (-middle[1]).atan2(-middle[0]) * (256.0 / std::f32::consts::TAU);
    let facing = (angle.round() as i32).rem_euclid(256) as u8;
    let normal = Cut::wall(facing, 0).normal();
    let wall = Cut::wall(facing, (distance_of(area, normal) * Cut::STEPS).round() as i32);
    let (_, own) = covered([(normal, wall.distance())].into_iter());
    (aside >= LEAST_ASIDE * own[0].hypot(own[1])).then_some(wall)
}

/// Distance from the centre of a square of side 1 of a wall behind which a share of it lies.
fn distance_of(area: f32, normal: [f32; 2]) -> f32 {
    let [a, b] = normal.each(f32::abs);
    let (long, short) = (a.max(b), a.min(b));
    // The corners cut off a triangle, between them the share is linear in the distance.
    let corner = 0.5 * short / long;
    let from_corner = if area < corner {
        (2.0 * long * short * area).sqrt()
    } else if area <= 1.0 - corner {
        long * area + 0.5 * short
    } else {
        long + short - (2.0 * long * short * (1.0 - area)).max(0.0).sqrt()
    };
    from_corner - 0.5 * (long + short)
}

/// Share of a square of side 1 within walls, and its middle from the square's centre.
fn covered(walls: impl Iterator<Item = ([f32; 2], f32)>) -> (f32, [f32; 2]) {
    let mut square = Polygon { corners: [[0.0; 2]; MOST_CORNERS], count: 0 };
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].into_iter().for_each(|corner| square.push(corner));
    let mut is_cut = false;
    for (normal, distance) in walls {
        is_cut = true;
        square = square.within(normal, distance);
    }
    if is_cut { square.area_and_middle() } else { (1.0, [0.0; 2]) }
}

/// Corners of a square and of what three walls cut off.
const MOST_CORNERS: usize = 4 + 3;

/// Convex polygon, counter-clockwise.
struct Polygon {
    corners: [[f32; 2]; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    fn push(&mut self, corner: [f32; 2]) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    /// Iterates over its edges.
    fn edges(&self) -> impl Iterator<Item = [[f32; 2]; 2]> {
        let next = |index: usize| if index + 1 == self.count { 0 } else { index + 1 };
        (0..self.count).map(move |index| [self.corners[index], self.corners[next(index)]])
    }

    /// Returns what lies within a wall.
    fn within(&self, normal: [f32; 2], distance: f32) -> Self {
        let beyond = |[east, north]: [f32; 2]| normal[0] * east + normal[1] * north - distance;
        let mut inside = Self { corners: self.corners, count: 0 };
        for [from, to] in self.edges() {
            let [here, there] = [beyond(from), beyond(to)];
            if here <= 0.0 {
                inside.push(from);
            }
            if (here <= 0.0) != (there <= 0.0) {
                let share = here / (here - there);
                inside.push([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]);
            }
        }
        inside
    }

    fn area_and_middle(&self) -> (f32, [f32; 2]) {
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for [from, to] in self.edges() {
            let cross = from[0] * to[1] - to[0] * from[1];
            twice += cross;
            moment = [moment[0] + (from[0] + to[0]) * cross, moment[1] + (from[1] + to[1]) * cross];
        }
        if twice <= 0.0 { (0.0, [0.0; 2]) } else { (0.5 * twice, moment.each(|sum| sum / (3.0 * twice))) }
    }
}

#[cfg(test)]
#[path = "coarse_spans_tests.rs"]
mod tests;
