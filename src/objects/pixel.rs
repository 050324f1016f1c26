//! Coverage of a pixel by bodies, and their light there.

mod meshes;
mod shares;

pub use shares::BodyShare;

use glam::{DVec2, Vec3};

use super::body::{PlacedBody, SeenForm};
use super::plot::Plot;
use super::rank::higher;
use super::ray_coverage::{Aim, Count, ONE_FACE, Pencil, RAYS, SeenFace};
use super::sheet::Sheets;
use super::view::{Hit, ShownBody, Square, nearest};
use crate::objects::{BodyLight, PixelGround};
use crate::simd::Isa;
use crate::space::Ray;

/// Pixels that a body must be thick for its outline to be nearly straight in one: an outline that bulges between two corners of a pixel then hides
/// less than a hundredth of it.
const THICK: f64 = 16.0;

/// Radius of the sphere around a body, pixels, below which all its pixels are looked at with all rays.
const SMALL: f64 = 6.0;

/// Pixels from the middle of a pixel to its corners, and a little more, since pixels are not all alike.
const HALF_DIAGONAL: f64 = 0.8;

impl Square<'_> {
    /// Tells `put` row and column of every pixel of the screen in which bodies are seen, and what is seen there before what `ground` says of
    /// a pixel. `shade` tells the colour of a hit on a ray.
    pub fn look(
        &self,
        isa: Isa,
        ground: impl Fn(usize, usize) -> PixelGround,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
        mut put: impl FnMut(usize, usize, &BodyLight),
    ) {
        self.each(isa, ground, shade, |row, column, seen, _| put(row, column, seen));
    }

    /// [`Self::look`], and where several bodies may be what was found out about them.
    fn each(
        &self,
        isa: Isa,
        ground: impl Fn(usize, usize) -> PixelGround,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
        mut put: impl FnMut(usize, usize, &BodyLight, Option<&Looking<'_>>),
    ) {
        let mut plot = Plot::new(self, isa, &ground);
        plot.look(&shade, &mut |row, column, seen| put(row, column, seen, None));
        if !plot.has_left() {
            return;
        }
        let mut looking = Looking::at(self, isa);
        for row in self.rows.clone() {
            for column in looking.begin(row) {
                if !plot.is_left(column, row) {
                    continue;
                }
                if let Some(seen) = looking.pixel(column, row, || ground(column, row), &shade) {
                    put(row, column, &seen, Some(&looking));
                }
            }
        }
    }
}

/// State of a square while its pixels are looked at.
#[derive(Debug)]
struct Looking<'v> {
    square: &'v Square<'v>,
    /// Bodies that may be in the row, by rank.
    row: Vec<&'v ShownBody>,
    /// Bodies that the pixel's ray comes near.
    near: Vec<&'v PlacedBody>,
    /// Hits at the pixels' corners, row by row, as far as they were asked for.
    corners: Vec<Option<Option<Hit>>>,
    isa: Isa,
    /// Memory for what rays see.
    aims: Vec<Aim>,
    faces: Vec<SeenFace>,
    sheets: Sheets,
}

impl<'v> Looking<'v> {
    /// Nothing is known yet.
    fn at(square: &'v Square<'v>, isa: Isa) -> Self {
        Self {
            square,
            row: Vec::new(),
            near: Vec::new(),
            corners: Vec::new(),
            isa,
            aims: Vec::new(),
            faces: Vec::new(),
            sheets: Sheets::default(),
        }
    }

    /// Goes on to a row; the columns in which bodies may be.
    fn begin(&mut self, row: usize) -> std::ops::Range<usize> {
        self.row.clear();
        self.row.extend(self.square.bodies.iter().filter(|body| body.rows.contains(&row)));
        let first = self.row.iter().map(|body| body.columns.start).min().unwrap_or(0);
        let end = self.row.iter().map(|body| body.columns.end).max().unwrap_or(0);
        first.max(self.square.columns.start)..end.min(self.square.columns.end)
    }

    /// Returns what bodies add to the pixel at `column` and `row` of the screen, before `ground`, which is asked for if there may be some; `None`: nothing.
    /// `shade` tells the colour of a hit on a ray.
    fn pixel(
        &mut self,
        column: usize,
        row: usize,
        ground: impl FnOnce() -> PixelGround,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
    ) -> Option<BodyLight> {
        self.faces.clear();
        if !self.row.iter().any(|body| body.columns.contains(&column)) {
            return None;
        }

        let ground = ground();
        let (lens, place) = (self.square.lens, DVec2::new(column as f64, row as f64) + 0.5);
        let middle = lens.line(place)?;
        let (origin, footprint) = (middle.origin(lens.camera), lens.camera.footprint());
        let distance = |body: &PlacedBody| (body.centre - origin).length();

        let is_near = |body: &PlacedBody| {
            let distance = distance(body);
            // Hidden, whatever of it the pixel holds.
            let hides = (distance - body.radius) * ground.least() > 1.0;
            !hides && body.is_near(&middle, HALF_DIAGONAL * footprint.at(distance + body.radius))
        };
        let in_column = self.row.iter().filter(|body| body.columns.contains(&column));
        self.near.clear();
        self.near.extend(in_column.map(|body| &body.placed).filter(|body| is_near(body)));
        if self.near.iter().any(|body| matches!(body.sight, SeenForm::Mesh(_)))
            && let Some(seen) = self.with_meshes(place, &middle, &ground, &shade)
        {
            return seen;
        }
        if self.near.is_empty() {
            return None;
        }

        let shown = |(hit, offset): (Hit, DVec2)| ground.shows(&hit, offset).then_some(hit);
        let look = |near: &[&PlacedBody]| {
            nearest(near.iter().copied(), &middle, footprint).map(|hit| (hit, DVec2::ZERO)).and_then(shown)
        };
        let pixels = |body: &PlacedBody, metres: f64| metres / footprint.at(distance(body) + body.radius);

        // Of small bodies nearly all pixels have an edge.
        if self.near.iter().any(|body| pixels(body, body.radius) >= SMALL) {
            let centre = look(&self.near);
            let corners = self.corners_of(column, row).map(|corner| corner.and_then(shown));
            if let Some(hit) = centre
                && corners.iter().all(|corner| corner.is_some_and(|corner| is_one_face(&corner, &hit)))
            {
                return Some(BodyLight { share: 1.0, colour: shade(&hit, &lens.ray(&middle)), hit });
            }
            let is_thick = |body: &&PlacedBody| pixels(body, body.thickness) >= THICK;
            if centre.is_none() && corners.iter().all(Option::is_none) && self.near.iter().all(is_thick) {
                return None;
            }
        }

        let seen = self.shares(place, &ground, shade)?;
        Some(match look(&self.near) {
            Some(hit) if hit.id == seen.hit.id => BodyLight { hit, ..seen },
            _ => seen,
        })
    }

    /// Looks at a pixel with all rays.
    fn shares(
        &mut self,
        middle: DVec2,
        ground: &PixelGround,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
    ) -> Option<BodyLight> {
        let lens = self.square.lens;
        let pencil = Pencil::new(&lens, middle)?;
        self.aims.clear();
        let aims = self.near.iter().filter_map(|body| match body.sight {
            SeenForm::Shape(shape) => Some(pencil.aim(body, shape)),
            SeenForm::Mesh(_) => None,
        });
        self.aims.extend(aims);
        for (index, aim) in self.aims.iter_mut().enumerate() {
            aim.higher = higher(&self.near, index);
        }
        self.faces.clear();
        self.isa.run(Count { aims: &self.aims, pencil: &pencil, ground, faces: &mut self.faces });
        let ray = lens.ray(&lens.line(middle)?);
        self.sum(&ray, shade)
    }

    /// Sums the light of the faces.
    fn sum(&self, ray: &Ray, shade: impl Fn(&Hit, &Ray) -> Vec3) -> Option<BodyLight> {
        let each = 1.0 / RAYS as f32;
        let hit = |face: &SeenFace| Hit {
            id: self.near[face.aim].id,
            range: f64::from(face.range),
            normal: face.normal,
            albedo: face.albedo,
        };
        let colour = self.faces.iter().map(|face| shade(&hit(face), ray) * (face.rays as f32 * each)).sum();
        // Faces with as many rays: the body with the highest rank has it, since it comes first.
        let most = self.faces.iter().reduce(|most, face| if face.rays > most.rays { face } else { most })?;
        let normal = most.normal.try_normalize().unwrap_or(Vec3::Z);
        let rays: u32 = self.faces.iter().map(|face| face.rays).sum();
        Some(BodyLight { share: rays as f32 * each, colour, hit: Hit { normal, ..hit(most) } })
    }

    /// Returns the hits at the corners of a pixel, and their offsets from its middle.
    fn corners_of(&mut self, column: usize, row: usize) -> [Option<(Hit, DVec2)>; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| {
            let hit = self.corner(column + right, row + down)?;
            Some((hit, DVec2::new(right as f64 - 0.5, down as f64 - 0.5)))
        })
    }

    /// Returns the hit at the upper left corner of a pixel, whichever of the four around asks.
    fn corner(&mut self, column: usize, row: usize) -> Option<Hit> {
        let Square { lens, bodies, columns, rows } = self.square;
        let index = (row - rows.start) * (columns.len() + 1) + column - columns.start;
        if self.corners.is_empty() {
            self.corners.resize((columns.len() + 1) * (rows.len() + 1), None);
        }
        if let Some(known) = self.corners[index] {
            return known;
        }
        let touches = |range: &std::ops::Range<usize>, at: usize| range.start <= at && at <= range.end;
        let about = |body: &&&ShownBody| touches(&body.columns, column) && touches(&body.rows, row);
        let placed = bodies.iter().filter(about).map(|body| &body.placed);
        let hit = lens
            .line(DVec2::new(column as f64, row as f64))
            .and_then(|line| nearest(placed, &line, lens.camera.footprint()));
        self.corners[index] = Some(hit);
        hit
    }
}

fn is_one_face(a: &Hit, b: &Hit) -> bool {
    a.id == b.id && a.normal.dot(b.normal) >= ONE_FACE
}
