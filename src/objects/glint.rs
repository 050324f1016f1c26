//! Points of light as a screen shows them.
//!
//! A lamp is smaller than a pixel unless it is close: what the screen shows of it is how an eye or a lens spreads a point. Most of its light goes to a
//! core about a pixel wide, a small part to a glare that falls with the cube of the distance. So bright lamps look larger than dim ones; all look the same
//! wherever between pixels they lie, and the light that a lamp gives to a picture is that which reaches the eye, however large it is drawn.

use std::ops::Range;

use glam::{DVec2, Vec2, Vec3};

use super::SQUARE;
use crate::simd::math::exp_neg;
use crate::simd::{Each, Floats, LANES, Simd, Sixteen};

/// Parts of a square's rows, each of [`LANES`] pixels.
pub const PARTS: usize = SQUARE / LANES;

/// Middles of a part's pixels.
const MIDDLES: [f32; LANES] =
    [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 10.5, 11.5, 12.5, 13.5, 14.5, 15.5];

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

    /// Adds its light to that of a square of the screen.
    #[inline(always)]
    pub fn add<V: Simd>(&self, simd: V, glow: &mut GlowSums) {
        let place = self.position - Vec2::new(glow.corner[0] as f32, glow.corner[1] as f32);
        let [columns, rows] = [place.x, place.y].each(|at| {
            // A float converts saturating.
            let (from, to) = ((at - self.reach).floor() as usize, (at + self.reach).ceil() as usize);
            from..to.min(SQUARE)
        });
        glow.rows = if glow.rows.is_empty() {
            rows.clone()
        } else {
            glow.rows.start.min(rows.start)..glow.rows.end.max(rows.end)
        };
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let per_width = 1.0 / (self.width * self.width);
        let least = simd.splat((1.0 + self.reach * self.reach * per_width).powf(-1.5));
        let (edge, radius) = (self.radius + CORE_ENDS * CORE, simd.splat(self.radius));
        let parts = columns.start / LANES..columns.end.div_ceil(LANES);

        for row in rows {
            let down = row as f32 + 0.5 - place.y;
            for part in parts.clone() {
                let right = simd.load(&MIDDLES) + simd.splat((part * LANES) as f32 - place.x);
                let square = right.mul_add(right, simd.splat(down * down));
                let inverse = square.mul_add(simd.splat(per_width), one).rsqrt();
                let glare = (inverse * inverse * inverse - least).max(zero);
                let mut core = zero;

                if down.abs() < edge {
                    let beyond = (square.sqrt() - radius).max(zero) * simd.splat(1.0 / CORE);
                    let share = exp_neg(simd, beyond * beyond * simd.splat(0.5));
                    core = share.select(square.lt(simd.splat(edge * edge)), zero);
                }

                for (channel, sum) in glow.sums[row * PARTS + part].iter_mut().enumerate() {
                    let light = core.mul_add(simd.splat(self.core[channel]), simd.load(&sum.0));
                    glare.mul_add(simd.splat(self.glare[channel]), light).store(&mut sum.0);
                }
            }
        }
    }
}

/// Light of points in a square of the screen, as it is added up.
#[derive(Debug)]
pub struct GlowSums {
    /// The square's first column and row.
    corner: [usize; 2],
    /// Sums by row, part of a row, and channel.
    sums: Vec<[Sixteen; 3]>,
    /// Rows that were added to.
    rows: Range<usize>,
}

impl GlowSums {
    /// None, of the square of [`SQUARE`] columns and rows that begins at `corner`.
    pub fn none(corner: [usize; 2]) -> Self {
        Self { corner, sums: vec![Default::default(); SQUARE * PARTS], rows: 0..0 }
    }

    /// Goes to another square, to which nothing was added yet. What was added to this one has been [taken](Self::take), or goes there.
    pub fn begin(&mut self, corner: [usize; 2]) {
        self.corner = corner;
        self.rows = 0..0;
    }

    /// Rows of the square that were added to.
    pub fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// Takes the light of a part of a row, [`LANES`] pixels of the [`PARTS`] in a row: linear Rec. 709, by channel.
    #[inline(always)]
    pub fn take(&mut self, row: usize, part: usize) -> [Sixteen; 3] {
        std::mem::take(&mut self.sums[row * PARTS + part])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel};

    const SIZE: [usize; 2] = [320, 224];

    /// All that a screen shows of it.
    struct Shown<'g>(&'g Glint);

    impl Kernel for Shown<'_> {
        type Output = Vec<Vec3>;

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Vec<Vec3> {
            let mut screen = vec![Vec3::ZERO; SIZE[0] * SIZE[1]];
            let mut glow = GlowSums::none([0, 0]);
            for top in (0..SIZE[1]).step_by(SQUARE) {
                for left in (0..SIZE[0]).step_by(SQUARE) {
                    glow.begin([left, top]);
                    self.0.add(simd, &mut glow);
                    for row in glow.rows() {
                        for part in 0..PARTS {
                            let [red, green, blue] = glow.take(row, part);
                            let start = (top + row) * SIZE[0] + left + part * LANES;
                            for (lane, pixel) in screen[start..start + LANES].iter_mut().enumerate() {
                                *pixel = Vec3::new(red.0[lane], green.0[lane], blue.0[lane]);
                            }
                        }
                    }
                }
            }
            screen
        }
    }

    fn shown(glint: &Glint) -> Vec<Vec3> {
        let portable = Isa::PORTABLE.run(Shown(glint));
        for isa in Isa::available() {
            for (own, expected) in isa.run(Shown(glint)).into_iter().zip(&portable) {
                assert!(
                    (own - expected).abs().max_element() <= 1.0e-4 * (1.0 + expected.max_element()),
                    "{isa}"
                );
            }
        }
        portable
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
