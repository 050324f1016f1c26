//! How much of a pixel bodies cover, and what they look like.

use glam::{DVec2, Vec3};

use super::body::Placed;
use super::view::{Hit, Square, nearest};
use crate::space::Ray;

/// Rays of a pixel in which an edge may lie, and columns from one to the next: a Fibonacci lattice, whose shares of half planes are twice as exact
/// as those of as many points of Hammersley's.
const RAYS: u32 = 89;
const STEP: u32 = 55;

/// Least cosine between normals of one face, which the middle of a pixel may stand for.
const ONE_FACE: f32 = 0.96;

/// Pixels that a body must be thick for its outline to be nearly straight in one: an outline that bulges between two corners of a pixel then hides
/// less than a hundredth of it.
const THICK: f64 = 16.0;

/// The ground in a pixel, as a plane.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ground {
    /// One over its range in the middle of the pixel, 1/metres; 0: sky.
    pub inverse: f32,
    /// How much that grows per pixel to the right, and per pixel down.
    pub slope: [f32; 2],
}

/// What bodies add to a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Share of the pixel that they cover, 0…1, more than 0.
    pub share: f32,
    /// Sum of colours times shares.
    pub colour: Vec3,
    /// Where the body that covers most of it is seen, nearest to its middle.
    pub hit: Hit,
}

impl Ground {
    /// One over its range, so many pixels to the right of the middle, and below it.
    fn at(&self, offset: DVec2) -> f64 {
        let [across, along] = self.slope.map(f64::from);
        f64::from(self.inverse) + across * offset.x + along * offset.y
    }

    /// Its farthest point in the pixel.
    fn least(&self) -> f64 {
        let [across, along] = self.slope.map(|slope| f64::from(slope).abs());
        f64::from(self.inverse) - 0.5 * (across + along)
    }

    fn shows(&self, hit: &Hit, offset: DVec2) -> bool {
        // At the eye both are infinite: there the ground is seen.
        hit.range * self.at(offset) < 1.0
    }
}

impl Square<'_> {
    /// What its bodies add to the pixel at `column` and `row` of the screen, before `ground`; `None`: nothing. `shade` tells the colour of a hit
    /// on a ray.
    pub fn pixel(
        &self,
        column: usize,
        row: usize,
        ground: &Ground,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
    ) -> Option<Seen> {
        let middle = self.ray(column, row, DVec2::ZERO)?;
        let footprint = self.camera.footprint();
        let is_candidate = |body: &&Placed| {
            let distance = (body.centre - middle.origin).length();
            // Hidden, whatever of it the pixel holds.
            let hides = (distance - body.radius) * ground.least() > 1.0;
            !hides && body.is_near(&middle, footprint.at(distance + body.radius))
        };
        let bodies: Vec<&Placed> = self.bodies.iter().copied().filter(is_candidate).collect();
        if bodies.is_empty() {
            return None;
        }
        let seen = self.corners_of(column, row);
        let centre = nearest(&bodies, &middle).map(|hit| (hit, DVec2::ZERO));
        let shown = |(hit, offset): (Hit, DVec2)| ground.shows(&hit, offset).then_some(hit);
        let points = seen.into_iter().chain([centre]).map(|point| point.and_then(shown));
        if let Some(hit) = centre.and_then(shown)
            && points.clone().all(|point| point.is_some_and(|point| is_one_face(&point, &hit)))
        {
            return Some(Seen { share: 1.0, colour: shade(&hit, &middle), hit });
        }
        let is_thick = |body: &&Placed| {
            let distance = (body.centre - middle.origin).length();
            body.thickness >= THICK * footprint.at(distance + body.radius)
        };
        if points.clone().all(|point| point.is_none()) && bodies.iter().all(is_thick) {
            return None;
        }
        let middle = centre.and_then(shown);
        self.shares(column, row, &bodies, ground, shade).map(|seen| match middle {
            Some(hit) if hit.id == seen.hit.id => Seen { hit, ..seen },
            _ => seen,
        })
    }

    /// Looks at a pixel with all rays.
    fn shares(
        &self,
        column: usize,
        row: usize,
        bodies: &[&Placed],
        ground: &Ground,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
    ) -> Option<Seen> {
        let mut colour = Vec3::ZERO;
        let mut hits: Vec<(Hit, f64)> = Vec::new();
        for offset in offsets() {
            let Some(ray) = self.ray(column, row, offset) else { continue };
            let Some(hit) = nearest(bodies, &ray).filter(|hit| ground.shows(hit, offset)) else { continue };
            colour += shade(&hit, &ray);
            hits.push((hit, offset.length_squared()));
        }
        let count = |id: u32| hits.iter().filter(|(hit, _)| hit.id == id).count();
        // Of those with the most rays the one with the lowest number, whichever ray came first.
        let most =
            hits.iter().map(|(hit, _)| hit.id).max_by_key(|id| (count(*id), std::cmp::Reverse(*id)))?;
        let of_most = hits.iter().filter(|(hit, _)| hit.id == most);
        let (hit, _) = of_most.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let each = 1.0 / RAYS as f32;
        Some(Seen { share: hits.len() as f32 * each, colour: colour * each, hit: *hit })
    }

    /// What the corners of a pixel see, and where they lie from its middle.
    fn corners_of(&self, column: usize, row: usize) -> [Option<(Hit, DVec2)>; 4] {
        let (x, y) = (column - self.columns.start, row - self.rows.start);
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| {
            let hit = self.corners[(y + down) * (self.columns.len() + 1) + x + right]?;
            Some((hit, DVec2::new(right as f64 - 0.5, down as f64 - 0.5)))
        })
    }

    /// The ray so many pixels from the middle of a pixel.
    fn ray(&self, column: usize, row: usize, offset: DVec2) -> Option<Ray> {
        self.camera.ray(column as f64 + 0.5 + offset.x, row as f64 + 0.5 + offset.y)
    }
}

fn is_one_face(a: &Hit, b: &Hit) -> bool {
    a.id == b.id && a.normal.dot(b.normal) >= ONE_FACE
}

/// Where the rays of a pixel go, from its middle, pixels: of as many columns and rows each has one.
fn offsets() -> impl Iterator<Item = DVec2> {
    (0..RAYS).map(|index| {
        let place = DVec2::new(f64::from(index), f64::from(index * STEP % RAYS));
        (place + 0.5) / f64::from(RAYS) - 0.5
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_half_planes_are_nearly_exact() {
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
        for turn in 0..360 {
            let (sin, cos) = f64::from(turn).to_radians().sin_cos();
            let (wide, high) = (cos.abs(), sin.abs());
            for place in -9..10 {
                let place = f64::from(place) * 0.07;
                let seen = offsets().filter(|offset| offset.dot(DVec2::new(cos, sin)) < place).count();
                // Area of a unit square on one side of a line: the convolution of two boxes.
                let ramp = |at: f64| at.max(0.0).powi(2) / 2.0;
                let exact = if wide.min(high) < 1e-9 {
                    (place + 0.5).clamp(0.0, 1.0)
                } else {
                    let (a, b) = (0.5 * (wide + high), 0.5 * (wide - high));
                    (ramp(place + a) - ramp(place + b) - ramp(place - b) + ramp(place - a)) / (wide * high)
                };
                let error = (seen as f64 / f64::from(RAYS) - exact).abs();
                (sum, worst, count) = (sum + error, worst.max(error), count + 1);
            }
        }
        let mean = sum / f64::from(count);
        assert!(mean < 1.0 / 128.0 && worst < 0.06, "{mean} {worst}");
    }
}
