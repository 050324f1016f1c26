//! Patterns on the ground: checkerboards, random checks, speckles, waves, fractals.
//!
//! ```text
//! value(place) → place among the colours
//! colour       = mean over the voxel where it is a good part of the pattern's size; the mean colour where it is more than the pattern's size
//! ```

use glam::DVec2;

use super::noise::{Waves, gradient, hash, share, turned};
use super::shapes::Circle;
use crate::tint::mix;
use hedgehop::voxel::Material;
use hedgehop_base::colour::linear_from_srgb8;

/// Pattern of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// Squares of the colours in turn.
    Checkerboard,
    /// Squares of colours by chance.
    Checks,
    /// The first colour with spots of the others at random places.
    Speckle,
    /// Stripes that wander, from the first colour to the last and back.
    Waves,
    /// Clouds of all sizes from the first colour to the last.
    Fractal,
}

/// A pattern on the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Pattern of the texture.
    pub pattern: Pattern,
    /// Linear light, at least two.
    pub colours: Vec<[f32; 3]>,
    /// Side of a square, mean distance of spots, length of a wave or of the longest, metres, > 0.
    pub size_m: f64,
    /// Seed that picks one texture among all alike.
    pub seed: u64,
    /// Azimuth of what is upward in it, degrees from grid north.
    pub turned_deg: f64,
    /// Share of it in the colour of bare ground, 0…1.
    pub strength: f32,
    /// Share of it in the colour of imagery, 0…1.
    pub over_imagery: f32,
    /// Circle in which it is; `None`: everywhere.
    pub within: Option<Circle>,
    /// Material of the ground under it, if it states that.
    pub material: Option<Material>,
}

/// Voxels along a pattern's size from which on a voxel has the colour of its centre.
const MANY: f64 = 12.0;
/// Places of a voxel along a side that its colour is the mean of.
const PLACES: u32 = 4;
/// Radius of spots, at least and at most, in mean distances.
const SPOTS: [f64; 2] = [0.12, 0.42];
/// Share of what is finest to what is longest in fractals.
const FINEST: f64 = 1.0 / 256.0;

impl Texture {
    /// Builds the texture of sRGB colours; `None` if they are fewer than two.
    pub fn new(pattern: Pattern, colours: &[[u8; 3]], size_m: f64) -> Option<Self> {
        let colours: Vec<_> = colours.iter().map(|colour| linear_from_srgb8(*colour)).collect();
        (colours.len() >= 2).then_some(Self {
            pattern,
            colours,
            size_m,
            seed: 0,
            turned_deg: 0.0,
            strength: 1.0,
            over_imagery: 0.0,
            within: None,
            material: None,
        })
    }

    /// Share of it in the colour of the voxel at `at` whose side is `side` metres, of which imagery gave the share `alpha`.
    pub(super) fn share(&self, at: DVec2, side: f64, alpha: f32) -> f32 {
        let inside = self.within.map_or(1.0, |circle| {
            let depth = circle.radius_m - (at - circle.centre).length();
            (0.5 + depth / side).clamp(0.0, 1.0) as f32
        });
        inside * (self.strength * (1.0 - alpha) + self.over_imagery * alpha)
    }

    /// Linear colour of the voxel at `at` whose side is `side` metres.
    pub(super) fn colour(&self, at: DVec2, side: f64) -> [f32; 3] {
        let up = turned(self.turned_deg);
        let place =
            |at: DVec2| DVec2::new(at.x * up.y - at.y * up.x, at.x * up.x + at.y * up.y) / self.size_m;
        let side = side / self.size_m;
        if side * MANY <= 1.0 {
            return self.colour_at(place(at), side);
        }

        let mean = self.mean();
        // What is finer than the voxel would be noise in its four by four places; of fractals it is left out.
        let fading =
            if self.pattern == Pattern::Fractal { 0.0 } else { ((side - 0.5) / 0.5).clamp(0.0, 1.0) as f32 };
        if fading >= 1.0 {
            return mean;
        }

        let centre = place(at);
        let offset = |index: u32| (f64::from(index) + 0.5) / f64::from(PLACES) - 0.5;
        let mut sum = [0.0; 3];
        for part in 0..PLACES * PLACES {
            let beside = side * DVec2::new(offset(part % PLACES), offset(part / PLACES));
            let colour = self.colour_at(centre + beside, side / f64::from(PLACES));
            sum = std::array::from_fn(|channel| sum[channel] + colour[channel]);
        }

        mix(sum.map(|sum| sum / (PLACES * PLACES) as f32), mean, fading)
    }

    /// At a place in sizes, without waves shorter than two of `side`.
    fn colour_at(&self, place: DVec2, side: f64) -> [f32; 3] {
        let cell = place.floor();
        let (x, y) = (cell.x as i64, cell.y as i64);
        let count = self.colours.len();
        match self.pattern {
            Pattern::Checkerboard => self.colours[x.wrapping_add(y).rem_euclid(count as i64) as usize],
            Pattern::Checks => self.colours[(hash(x, y, self.seed) % count as u64) as usize],
            Pattern::Speckle => self.spot(place, x, y).unwrap_or(self.colours[0]),
            Pattern::Waves => {
                let wander =
                    0.45 * gradient(place / 2.7, self.seed) + 0.2 * gradient(place * 0.8, self.seed ^ 1);
                let phase = place.y + 2.0 * wander;
                let up = 2.0 * (phase - phase.floor() - 0.5).abs();
                self.between(up * up * (3.0 - 2.0 * up))
            }
            Pattern::Fractal => {
                let waves = Waves { seed: self.seed, longest: 1.0, gain: 0.6 };
                let sum = waves.sum(place, waves.count((2.0 * side).max(FINEST)), |value| value);
                // Three deviations to either side: 1 / √(1 − gain²) = 1.25.
                self.between(0.5 + sum / 4.5)
            }
        }
    }

    /// Colour of the spot on a place in a cell; `None`: there is none.
    fn spot(&self, place: DVec2, x: i64, y: i64) -> Option<[f32; 3]> {
        let cells = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x.wrapping_add(dx), y.wrapping_add(dy))));
        let mut found = None;
        for (x, y) in cells {
            let part = |which: u64| share(x, y, hash(which as i64, 0, self.seed));
            let middle = DVec2::new(x as f64 + part(0), y as f64 + part(1));
            let radius = SPOTS[0] + (SPOTS[1] - SPOTS[0]) * part(2) * part(2);
            if middle.distance_squared(place) < radius * radius {
                let others = self.colours.len() as u64 - 1;
                found = Some(self.colours[1 + (hash(x, y, self.seed) % others) as usize]);
            }
        }
        found
    }

    /// Colour at a place from the first (0) to the last (1).
    fn between(&self, place: f64) -> [f32; 3] {
        let last = self.colours.len() - 1;
        let along = place.clamp(0.0, 1.0) * last as f64;
        let first = (along as usize).min(last - 1);
        mix(self.colours[first], self.colours[first + 1], (along - first as f64) as f32)
    }

    /// Colour from afar.
    fn mean(&self) -> [f32; 3] {
        let count = self.colours.len();
        let mean = |colours: &[[f32; 3]]| -> [f32; 3] {
            std::array::from_fn(|channel| {
                colours.iter().map(|colour| colour[channel]).sum::<f32>() / colours.len() as f32
            })
        };
        match self.pattern {
            Pattern::Checkerboard | Pattern::Checks => mean(&self.colours),
            Pattern::Speckle => mix(self.colours[0], mean(&self.colours[1..]), SPECKLED),
            Pattern::Waves | Pattern::Fractal => {
                let ends = (self.colours[0], self.colours[count - 1]);
                let inner: f32 = (count - 1) as f32;
                std::array::from_fn(|channel| {
                    let all: f32 = self.colours.iter().map(|colour| colour[channel]).sum();
                    (all - 0.5 * (ends.0[channel] + ends.1[channel])) / inner
                })
            }
        }
    }
}

/// Share of the ground under spots: 1 − the chance of being outside of all, with radii as they are drawn.
const SPECKLED: f32 = 0.157;

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: [u8; 3] = [0; 3];
    const WHITE: [u8; 3] = [255; 3];

    fn texture(pattern: Pattern) -> Texture {
        Texture { seed: 5, ..Texture::new(pattern, &[BLACK, WHITE], 10.0).unwrap() }
    }

    const ALL: [Pattern; 5] =
        [Pattern::Checkerboard, Pattern::Checks, Pattern::Speckle, Pattern::Waves, Pattern::Fractal];

    #[test]
    fn squares_alternate() {
        let board = texture(Pattern::Checkerboard);
        let red = |x, y| board.colour(DVec2::new(x, y), 0.1)[0];
        assert_eq!([red(5.0, 5.0), red(15.0, 5.0), red(15.0, 15.0), red(-5.0, 5.0)], [0.0, 1.0, 0.0, 1.0]);
        // A voxel over an edge has some of both, and one that is as large as the squares has the mean.
        assert_eq!(
            (board.colour(DVec2::new(10.0, 5.0), 2.0)[0], board.colour(DVec2::new(3.0, 5.0), 10.0)[0]),
            (0.5, 0.5)
        );
        let turned = Texture { turned_deg: 90.0, ..board };
        assert_eq!(turned.colour(DVec2::new(5.0, 5.0), 0.1)[0], 1.0);
    }

    #[test]
    fn a_texture_has_its_share_and_keeps_to_its_circle() {
        let within = Some(Circle { centre: DVec2::new(100.0, 0.0), radius_m: 50.0 });
        let texture = Texture { strength: 0.5, over_imagery: 0.25, within, ..texture(Pattern::Checks) };
        let share = |x: f64, alpha| texture.share(DVec2::new(x, 0.0), 2.0, alpha);
        assert_eq!([share(100.0, 0.0), share(100.0, 1.0), share(51.1, 0.5)], [0.5, 0.25, 0.375]);
        assert_eq!([share(50.0, 0.0), share(48.9, 0.0)], [0.25, 0.0]);
    }

    #[test]
    fn means_from_afar_are_those_of_what_is_near() {
        for pattern in ALL {
            let texture = texture(pattern);
            let places =
                (0..90_000).map(|step| DVec2::new(f64::from(step % 300), f64::from(step / 300)) * 7.7);
            let near = places.map(|at| texture.colour(at, 0.1)[0]).sum::<f32>() / 90_000.0;
            let far = texture.mean()[0];
            assert!((near - far).abs() < 0.02, "{pattern:?}: {near} near, {far} far");
        }
    }

    #[test]
    fn colours_of_coarse_voxels_are_means_of_fine_ones() {
        for pattern in ALL {
            let texture = texture(pattern);
            for cell in 0..40 {
                let at = DVec2::new(f64::from(cell) * 13.0, f64::from(cell * cell) * 3.1);
                let parts = (0..64)
                    .map(|part| at + 0.5 * (DVec2::new(f64::from(part % 8), f64::from(part / 8)) - 3.5));
                let mean = parts.map(|at| texture.colour(at, 0.5)[0]).sum::<f32>() / 64.0;
                let coarse = texture.colour(at, 4.0)[0];
                assert!((mean - coarse).abs() < 0.2, "{pattern:?}: {coarse}, not {mean}");
            }
        }
    }
}
