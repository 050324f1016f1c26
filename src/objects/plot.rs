//! Shapes that are alone in their pixels, on planar screens.
//!
//! ```text
//! each shape before a square: its outline → the exact share of each pixel; a pixel that one has a share in is its own, if no other one has, or it
//!     fills the pixel before all others
//! each row of its own pixels, sixteen at a time: middles and corners
//!     all see one face before the ground → that face
//!     else 16 rays → the faces of its share; where ground and shape meet 96 rays
//! what is left: pixels of several bodies, and of meshes
//! ```

use std::ops::Range;

use glam::{DVec2, Vec3};

use super::area_coverage::{Coverage, clip};
use super::body::{PlacedBody, SeenForm};
use super::outline::Outline;
use super::rank::limit;
use super::ray_coverage::{ALL, Aim, FEW, Grounds, Pencil, PixelMiddles, PixelRays, PixelRow, SeenFace};
use super::view::{Hit, SQUARE, ShownBody, Square};
use crate::objects::{BodyLight, PixelGround};
use crate::simd::{Isa, LANES};
use crate::space::Ray;

/// Share of a pixel below which a shape is not in it, and what is missing at most where it fills it.
const LEAST: f32 = 1.0e-4;

/// Offsets of the samples in it: parts of the way from the middle of what is left to its corners.
const WAYS: [f64; 2] = [0.45, 0.85];

/// Owner of a pixel: nobody, a body by its index, or it is left to be looked at ray by ray. A number, since squares have many, of which few are claimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Zeroable)]
#[repr(transparent)]
struct PixelClaim(u32);

impl PixelClaim {
    const FREE: Self = Self(0);
    const LEFT: Self = Self(u32::MAX);

    fn by(body: usize) -> Self {
        Self(body as u32 + 1)
    }

    /// Index of the body that has claimed it.
    fn body(self) -> Option<usize> {
        (self != Self::FREE && self != Self::LEFT).then(|| self.0 as usize - 1)
    }
}

/// Sixteen pixels of a row, the first of which is a body's own.
struct PixelRun<'p> {
    place: &'p ClaimedPixels,
    /// Number of the first pixel in the square.
    first: usize,
    /// Offset of its middle, pixels from that of the square.
    offset: [f32; 2],
}

/// Pixels that a body claimed.
#[derive(Debug, Clone)]
struct ClaimedPixels {
    body: usize,
    /// Rows of the square.
    rows: Range<usize>,
    /// Points of its outline, among all.
    points: Range<usize>,
}

/// A square of pixels, and who is alone in which of them.
#[derive(Debug)]
pub(super) struct Plot<'v> {
    square: &'v Square<'v>,
    isa: Isa,
    places: Vec<ClaimedPixels>,
    claims: Vec<PixelClaim>,
    shares: Vec<f32>,
    grounds: Vec<PixelGround>,
    coverage: Coverage,
    outline: Outline,
    /// Points of all outlines, pixels from the square's upper left corner.
    points: Vec<DVec2>,
    faces: Vec<SeenFace>,
    /// Part of an outline within the pixel, as reused memory.
    part: Vec<DVec2>,
    spare: Vec<DVec2>,
}

impl<'v> Plot<'v> {
    /// Finds out who is alone in which pixels before what `ground` says of a column and row.
    pub fn new(square: &'v Square<'v>, isa: Isa, ground: impl Fn(usize, usize) -> PixelGround) -> Self {
        let pixels = SQUARE * square.rows.len();
        let mut plot = Self {
            square,
            isa,
            places: Vec::new(),
            claims: bytemuck::zeroed_vec(pixels),
            shares: vec![0.0; pixels],
            grounds: bytemuck::zeroed_vec(pixels),
            coverage: Coverage::new(square.columns.len(), square.rows.len()),
            outline: Outline::default(),
            points: Vec::new(),
            faces: Vec::new(),
            part: Vec::new(),
            spare: Vec::new(),
        };

        for (index, shown) in square.bodies.iter().enumerate() {
            let is_plain = match &shown.placed.sight {
                SeenForm::Shape(shape) => plot.outline.find(&square.lens, &shown.placed, shape),
                SeenForm::Mesh(_) => false,
            };
            if is_plain {
                plot.claim(index, shown, &ground);
            } else {
                plot.leave(shown);
            }
        }

        plot
    }

    /// Whether a pixel of the screen is to be looked at ray by ray.
    pub fn is_left(&self, column: usize, row: usize) -> bool {
        let Square { columns, rows, .. } = self.square;
        self.claims[(row - rows.start) * SQUARE + column - columns.start] == PixelClaim::LEFT
    }

    /// Whether some are.
    pub fn has_left(&self) -> bool {
        self.claims.contains(&PixelClaim::LEFT)
    }

    /// Claims what a body's outline has a share in.
    fn claim(&mut self, index: usize, shown: &ShownBody, ground: &impl Fn(usize, usize) -> PixelGround) {
        let Square { lens, bodies, columns, rows } = self.square;
        let corner = DVec2::new(columns.start as f64, rows.start as f64);
        let first = self.points.len();
        self.points.extend(self.outline.points.iter().map(|point| *point - corner));
        let touched = self.coverage.put(&self.points[first..]);
        let eye = lens.camera.pose.eye;
        let ends = |placed: &PlacedBody| {
            let distance = (placed.centre - eye).length();
            [distance - placed.radius, distance + placed.radius]
        };
        let [nearest, farthest] = ends(&shown.placed);
        let mut own: Option<Range<usize>> = None;

        for row in touched {
            for (column, share) in self.coverage.shares(row) {
                if share < LEAST {
                    continue;
                }

                let pixel = row * SQUARE + column;
                let claim = &mut self.claims[pixel];
                if *claim == PixelClaim::LEFT {
                    continue;
                }

                if *claim == PixelClaim::FREE {
                    self.grounds[pixel] = ground(columns.start + column, rows.start + row);
                }
                if nearest * self.grounds[pixel].least() > 1.0 {
                    continue;
                }

                match claim.body() {
                    None => {
                        *claim = PixelClaim::by(index);
                        self.shares[pixel] = share;
                        own = Some(own.map_or(row, |own| own.start)..row + 1);
                    }
                    // Parts of a line that meet there.
                    Some(other) if bodies[other].placed.id == shown.placed.id => {
                        self.shares[pixel] = (self.shares[pixel] + share).min(1.0);
                    }
                    Some(other) => {
                        let [other_nearest, other_farthest] = ends(&bodies[other].placed);
                        // Nothing is seen of the farther one of two bodies where the nearer fills the pixel. The other one came before by rank.
                        let is_before = farthest
                            < limit(other_nearest, shown.placed.priority, bodies[other].placed.priority);
                        if share > 1.0 - LEAST && is_before {
                            *claim = PixelClaim::by(index);
                            self.shares[pixel] = share;
                            own = Some(own.map_or(row, |own| own.start)..row + 1);
                        } else if self.shares[pixel] <= 1.0 - LEAST || other_farthest > nearest {
                            *claim = PixelClaim::LEFT;
                        }
                    }
                }
            }
        }

        match own {
            Some(rows) => {
                self.places.push(ClaimedPixels { body: index, rows, points: first..self.points.len() })
            }
            None => self.points.truncate(first),
        }
    }

    /// Leaves all pixels in which a body may be.
    fn leave(&mut self, shown: &ShownBody) {
        let Square { columns, rows, .. } = self.square;
        let within = |range: &Range<usize>, all: &Range<usize>| {
            range.start.max(all.start) - all.start..range.end.min(all.end).max(all.start) - all.start
        };
        let columns = within(&shown.columns, columns);
        for row in within(&shown.rows, rows) {
            if columns.start < columns.end {
                self.claims[row * SQUARE + columns.start..row * SQUARE + columns.end].fill(PixelClaim::LEFT);
            }
        }
    }

    /// Tells `put` row and column of each pixel of the screen in which one shape is seen alone, and what is seen there; `shade` tells the colour of a hit on
    /// a ray.
    pub fn look(
        &mut self,
        shade: &impl Fn(&Hit, &Ray) -> Vec3,
        put: &mut impl FnMut(usize, usize, &BodyLight),
    ) -> Option<()> {
        let Square { lens, bodies, columns, rows } = self.square;
        let half = |range: &Range<usize>| 0.5 * range.len() as f32;
        let corner = DVec2::new(columns.start as f64, rows.start as f64);
        let middle = DVec2::new(f64::from(half(columns)), f64::from(half(rows)));
        let pencil = Pencil::new(lens, corner + middle)?;

        for place in std::mem::take(&mut self.places) {
            let placed = &bodies[place.body].placed;
            let SeenForm::Shape(shape) = placed.sight else { continue };
            let aim = pencil.aim(placed, shape);
            for row in place.rows.clone() {
                let mut first = 0;
                while let Some(skipped) = self.next_of(place.body, row, first) {
                    first += skipped;
                    let offset = [first as f32 + 0.5 - half(columns), row as f32 + 0.5 - half(rows)];
                    let run = PixelRun { place: &place, first: row * SQUARE + first, offset };
                    let (own, middles) = self.middles(&aim, &run, columns.len() - first);

                    for lane in (0..LANES).filter(|lane| own >> lane & 1 == 1) {
                        let (column, row) = (columns.start + first + lane, rows.start + row);
                        let ray = lens.ray(&lens.line(DVec2::new(column as f64, row as f64) + 0.5)?);
                        let shade = |hit: &Hit| shade(hit, &ray);
                        if let Some(seen) = self.pixel(&aim, &run, lane, placed, &middles, shade) {
                            put(row, column, &seen);
                        }
                    }

                    first += LANES;
                }
            }
        }

        Some(())
    }

    /// Returns the next pixel of a row that a body has claimed.
    fn next_of(&self, body: usize, row: usize, first: usize) -> Option<usize> {
        let end = self.square.columns.len();
        let line = self.claims.get(row * SQUARE + first.min(end)..row * SQUARE + end)?;
        line.iter().position(|claim| *claim == PixelClaim::by(body))
    }

    /// Returns what middles and corners of a run see, and which of its pixels, `width` at most, are the body's, bit by bit.
    fn middles(&self, aim: &Aim, run: &PixelRun<'_>, width: usize) -> (u16, PixelMiddles) {
        let (mut ground, mut middles) = (Grounds::default(), PixelMiddles::default());
        let mut columns = [0.0; LANES];
        let (mut own, mut corners) = (0, false);
        for (lane, offset) in columns.iter_mut().enumerate() {
            *offset = run.offset[0] + lane as f32;
            let pixel = run.first + lane;
            if lane < width && self.claims[pixel] == PixelClaim::by(run.place.body) {
                own |= 1 << lane;
                corners |= self.shares[pixel] > 1.0 - LEAST;
                let PixelGround { inverse, slope } = self.grounds[pixel];
                ground.inverse[lane] = inverse;
                (ground.slope[0][lane], ground.slope[1][lane]) = (slope[0], slope[1]);
            }
        }
        let (columns, row) = (&columns, run.offset[1]);
        self.isa.run(PixelRow { aim, columns, row, ground: &ground, corners, middles: &mut middles });
        (own, middles)
    }

    /// Returns what is seen of `placed` in a pixel of a run; `None`: nothing, or it is left.
    fn pixel(
        &mut self,
        aim: &Aim,
        run: &PixelRun<'_>,
        lane: usize,
        placed: &PlacedBody,
        middles: &PixelMiddles,
        shade: impl Fn(&Hit) -> Vec3,
    ) -> Option<BodyLight> {
        let (id, albedo) = (placed.id, placed.albedo);
        let middle = Hit {
            id,
            range: f64::from(middles.range[lane]),
            normal: Vec3::from_array(middles.normal.map(|axis| axis[lane])),
            albedo,
        };
        if middles.whole >> lane & 1 == 1 {
            return Some(BodyLight { share: 1.0, colour: shade(&middle), hit: middle });
        }
        let each = self.faces_of(aim, run, lane);
        let hit = |face: &SeenFace| Hit { id, range: f64::from(face.range), normal: face.normal, albedo };
        let colour = self.faces.iter().map(|face| shade(&hit(face)) * (face.rays as f32 * each)).sum();
        let most = self.faces.iter().reduce(|most, face| if face.rays > most.rays { face } else { most })?;
        let normal = most.normal.try_normalize().unwrap_or(Vec3::Z);
        let is_in_middle = middles.seen >> lane & 1 == 1;
        let share = self.faces.iter().map(|face| face.rays as f32 * each).sum::<f32>().min(1.0);
        Some(BodyLight {
            share,
            colour,
            hit: if is_in_middle { middle } else { Hit { normal, ..hit(most) } },
        })
    }

    /// Finds the faces that a pixel with an edge sees before the ground; the share of each of their rays.
    fn faces_of(&mut self, aim: &Aim, run: &PixelRun<'_>, lane: usize) -> f32 {
        let middle = [run.offset[0] + lane as f32, run.offset[1]];
        let ground = &self.grounds[run.first + lane];
        let faces = &mut self.faces;
        faces.clear();
        let mut met = self.isa.run(PixelRays { aim, rays: &FEW, middle, ground, faces });

        if met.all == 0 {
            let size = [&self.square.columns, &self.square.rows].map(|range| range.len() as f32);
            let corner = [0, 1].map(|axis| f64::from(middle[axis] - 0.5 + 0.5 * size[axis]));
            let outline = &self.points[run.place.points.clone()];
            clip(outline, corner.into(), &mut self.part, &mut self.spare);
            let Some(centre) = mean(&self.part) else { return 0.0 };
            let mut rays = [[[0.0; LANES]; 2]];

            for lane in 0..LANES {
                let corner = self.part[lane % self.part.len()];
                let place = centre.lerp(corner, WAYS[lane / self.part.len() % WAYS.len()]) - 0.5;
                (rays[0][0][lane], rays[0][1][lane]) = (place.x as f32, place.y as f32);
            }

            faces.clear();
            met = self.isa.run(PixelRays { aim, rays: &rays, middle, ground, faces });
        }

        if met.before == met.all || met.behind == met.all {
            return self.shares[run.first + lane] / met.all.count_ones().max(1) as f32;
        }

        faces.clear();
        self.isa.run(PixelRays { aim, rays: &ALL, middle, ground, faces });
        1.0 / (ALL.len() * LANES) as f32
    }
}

/// The mean of some points.
fn mean(points: &[DVec2]) -> Option<DVec2> {
    (!points.is_empty()).then(|| points.iter().sum::<DVec2>() / points.len() as f64)
}
