//! Points of light as a screen shows them.
//!
//! A lamp is smaller than a pixel unless it is close: what the screen shows of it is how an eye or a lens spreads a point. Most of its light goes to a
//! core about a pixel wide, a small part to a glare that falls with the cube of the distance. So bright lamps look larger than dim ones; all look the same
//! wherever between pixels they lie, and the light that a lamp gives to a picture is that which reaches the eye, however large it is drawn.

use std::ops::Range;

use glam::{DVec2, Vec2, Vec3};

use super::SQUARE;

/// Standard deviation of the core, pixels: wide enough that a point between pixels is as bright as one on them.
const CORE: f32 = 0.65;

/// Share of the light that goes to the glare.
const GLARE: f32 = 0.06;

/// Width of the glare of a point, pixels, and radians: eyes spread light by angle, and no less than a pixel is of use.
const GLARE_PIXELS: f64 = 1.2;
const GLARE_ANGLE: f64 = 0.0012;

/// Linear light that nobody sees beside something that shines, and how far glare may go in widths of its own.
const UNSEEN: f32 = 0.0015;
const FARTHEST: f32 = 28.0;

/// Standard deviations after which the core ends.
const CORE_ENDS: f32 = 3.2;

/// A point of light on a screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glint {
    /// Pixels from the screen's upper left corner.
    position: Vec2,
    /// Linear light in the middle of its core, by channel.
    core: Vec3,
    /// Radius of what shines, pixels.
    radius: f32,
    /// Linear light in the middle of its glare, by channel.
    glare: Vec3,
    /// Width of the glare, pixels, and where it ends.
    width: f32,
    reach: f32,
}

impl Glint {
    /// At a `position` of the screen (pixels), of which pixels are `angle` radians wide: `light` is what all its pixels hold together, `radius` (pixels) how large it is;
    /// `None`: nobody sees it.
    pub fn new(position: DVec2, light: Vec3, radius: f64, angle: f64) -> Option<Self> {
        let (radius, width) = (radius as f32, GLARE_PIXELS.max(GLARE_ANGLE / angle).max(radius) as f32);
        let tau = std::f32::consts::TAU;
        // Areas under both: a disc with edges of half of Gauss's curve, and (1 + d²)^(−3/2).
        let core_area = 0.5 * tau * radius * radius + 0.5 * tau.powf(1.5) * radius * CORE + tau * CORE * CORE;
        let glare = light * GLARE / (tau * width * width);
        let far = ((glare.max_element() / UNSEEN).powf(2.0 / 3.0) - 1.0).max(0.0).sqrt();
        let reach = (far.min(FARTHEST) * width).max(radius + CORE_ENDS * CORE);
        // What the glare would hold beyond its end, and below what it has there, is the core's.
        let root = (1.0 + (reach / width).powi(2)).sqrt();
        let kept = 1.0 - 1.0 / root - 0.5 * (root * root - 1.0) / (root * root * root);
        let core = light * (1.0 - GLARE * kept) / core_area;
        if !light.is_finite() || core.max_element() < UNSEEN {
            return None;
        }
        Some(Self { position: position.as_vec2(), core, radius, glare, width, reach })
    }

    /// A number for each, by which they are put in order; of those with the same one order makes no difference.
    pub fn rank(&self) -> [u32; 5] {
        [self.position.y, self.position.x, self.core.x, self.core.y, self.core.z].map(f32::to_bits)
    }

    /// Columns and rows that it may shine in, of a screen of some size.
    pub fn extent(&self, size: [usize; 2]) -> [Range<usize>; 2] {
        let axis = |at: f32, size: usize| {
            // A float converts saturating.
            let (from, to) = ((at - self.reach).floor().max(0.0), (at + self.reach).ceil().max(0.0));
            (from as usize).min(size)..(to as usize).min(size)
        };
        [axis(self.position.x, size[0]), axis(self.position.y, size[1])]
    }

    /// Adds its light to the pixels of a square of [`SQUARE`] rows and columns that begins at `corner` of a screen of some size.
    pub fn add(&self, corner: [usize; 2], size: [usize; 2], square: &mut [Vec3]) {
        let [columns, rows] = self.extent(size);
        let within = |range: Range<usize>, from: usize| range.start.max(from)..range.end.min(from + SQUARE);
        let (columns, rows) = (within(columns, corner[0]), within(rows, corner[1]));
        let per_width = 1.0 / (self.width * self.width);
        let least = (1.0 + self.reach * self.reach * per_width).powf(-1.5);
        let edge = self.radius + CORE_ENDS * CORE;
        for row in rows {
            let down = row as f32 + 0.5 - self.position.y;
            let line = &mut square[(row - corner[1]) * SQUARE..][..SQUARE];
            for column in columns.clone() {
                let right = column as f32 + 0.5 - self.position.x;
                let square = right * right + down * down;
                let root = (1.0 + square * per_width).sqrt();
                let glare = (1.0 / (root * root * root) - least).max(0.0);
                let mut light = self.glare * glare;
                if square < edge * edge {
                    let beyond = (square.sqrt() - self.radius).max(0.0) / CORE;
                    light += self.core * (-0.5 * beyond * beyond).exp();
                }
                line[column - corner[0]] += light;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [320, 200];

    /// All that a screen shows of it.
    fn shown(glint: &Glint) -> Vec<Vec3> {
        let mut screen = vec![Vec3::ZERO; SIZE[0] * SIZE[1]];
        for top in (0..SIZE[1]).step_by(SQUARE) {
            for left in (0..SIZE[0]).step_by(SQUARE) {
                let mut square = vec![Vec3::ZERO; SQUARE * SQUARE];
                glint.add([left, top], SIZE, &mut square);
                for (at, light) in square.into_iter().enumerate() {
                    let [column, row] = [left + at % SQUARE, top + at / SQUARE];
                    if light != Vec3::ZERO {
                        screen[row * SIZE[0] + column] += light;
                    }
                }
            }
        }
        screen
    }

    #[test]
    fn all_of_its_light_is_shown_wherever_it_lies() {
        for radius in [0.0, 0.4, 3.0, 20.0] {
            for step in 0_u8..10 {
                let offset = 0.1 * f64::from(step);
                let position = DVec2::new(160.0 + offset, 100.0 + 0.37 * offset);
                let glint = Glint::new(position, Vec3::new(40.0, 20.0, 0.0), radius, 1.0e-3).unwrap();
                let sum: Vec3 = shown(&glint).into_iter().sum();
                // What lies beyond the end of the glare is missing.
                assert!((0.965..1.012).contains(&(sum.x / 40.0)), "{radius} {offset}: {sum}");
                assert!((sum.x / sum.y - 2.0).abs() < 1e-3 && sum.z == 0.0);
            }
        }
    }

    #[test]
    fn a_point_that_moves_does_not_flicker_and_stays_where_it_is() {
        let brightest = |offset: DVec2| {
            let glint = Glint::new(DVec2::new(160.0, 100.0) + offset, Vec3::splat(5.0), 0.0, 1.0e-3).unwrap();
            let screen = shown(&glint);
            let sum: Vec3 = screen.iter().sum();
            let middle: Vec2 = screen
                .iter()
                .enumerate()
                .map(|(at, light)| {
                    light.x * Vec2::new((at % SIZE[0]) as f32 + 0.5, (at / SIZE[0]) as f32 + 0.5)
                })
                .sum();
            let middle = middle / sum.x - (DVec2::new(160.0, 100.0) + offset).as_vec2();
            assert!(middle.length() < 0.02, "{offset}: {middle}");
            // What a lens with the pixels' own resolution sees of it.
            let squares: f32 = screen.iter().map(|light| light.x * light.x).sum();
            squares.sqrt()
        };
        let seen: Vec<_> =
            (0_u8..20).map(|step| brightest(DVec2::new(0.05, 0.023) * f64::from(step))).collect();
        let (low, high) =
            seen.iter().fold((f32::MAX, 0.0_f32), |(low, high), seen| (low.min(*seen), high.max(*seen)));
        assert!(high / low < 1.12, "{low} {high}");
    }

    #[test]
    fn brighter_ones_are_larger_and_faint_ones_are_none() {
        let size = |light: f32| {
            let glint = Glint::new(DVec2::new(160.0, 100.0), Vec3::splat(light), 0.0, 1.0e-3)?;
            Some(shown(&glint).into_iter().filter(|light| light.x > 0.05).count())
        };
        assert!(size(1.0) < size(30.0) && size(30.0) < size(1000.0));
        assert_eq!(size(0.001), None);
        assert!(Glint::new(DVec2::ZERO, Vec3::splat(f32::NAN), 0.0, 1.0e-3).is_none());
    }

    #[test]
    fn a_lamp_close_by_is_a_disc_of_its_own_size() {
        let glint = Glint::new(DVec2::new(160.0, 100.0), Vec3::splat(1000.0), 12.0, 1.0e-3).unwrap();
        let screen = shown(&glint);
        let half = 0.5 * screen[100 * SIZE[0] + 160].x;
        let count = screen.iter().filter(|light| light.x > half).count() as f32;
        let radius = (count / std::f32::consts::PI).sqrt();
        assert!((radius - 12.65).abs() < 0.3, "{radius}");
    }
}
