//! Rays from a patch of a surface to the sun, and what holds them up.

use glam::Vec3;

use super::{Bundle, InsideStretch, inside, spread};
use crate::objects::Shape;
use crate::simd::{Floats, Kernel, LANES, Mask, Simd};

/// Steps of the lattices of starts in a patch and of ends on the sun: sixteen points with one in every row and column, two that share no direction.
const STEPS: [usize; 2] = [5, 7];

/// Sixteen rays from all over a patch to all over the sun, before a shape, in whose axes all is.
#[derive(Debug, Clone, Copy)]
pub(in crate::objects) struct SunBeam {
    pub shape: Shape,
    /// Middle of the patch, taken towards the sun's middle by `begin`, metres; what a half of the patch to the right adds, and a half down.
    pub origin: Bundle,
    /// Direction to the middle of the sun, of unit length, and what a half of it to the right adds, and a half up.
    pub direction: Bundle,
    /// Length of the rays so far, metres.
    pub begin: f32,
}

/// Places from −1 to 1: in the patch to the right and down, on the sun to the right and up.
pub(in crate::objects) const PLACES: [[[f32; LANES]; 2]; 2] = places();

const fn places() -> [[[f32; LANES]; 2]; 2] {
    let mut places = [[[0.0; LANES]; 2]; 2];
    let mut ray = 0;
    while ray < LANES {
        let other = ray * 3 % LANES;
        places[0][0][ray] = at(ray);
        places[0][1][ray] = at(ray * STEPS[0] % LANES);
        // A disc of the square's points: those on a square around the middle come to lie on a circle.
        let (x, y) = (at(other), at(other * STEPS[1] % LANES));
        let (wide, high) = (x.abs(), y.abs());
        let shrink = if wide > high { wide } else { high } / root(x * x + y * y);
        places[1][0][ray] = x * shrink;
        places[1][1][ray] = y * shrink;
        ray += 1;
    }
    places
}

const fn at(index: usize) -> f32 {
    (2 * index + 1) as f32 / LANES as f32 - 1.0
}

/// Square root by Newton's iteration, for numbers about 1.
const fn root(square: f32) -> f32 {
    let mut root = 1.0;
    let mut step = 0;
    while step < 20 {
        root = 0.5 * (root + square / root);
        step += 1;
    }
    root
}

impl Kernel for &SunBeam {
    /// Rays that the shape holds up, bit by bit.
    type Output = u16;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> u16 {
        let [on_patch, on_sun] = &PLACES;
        let on_sun = [simd.load(&on_sun[0]), simd.load(&on_sun[1])];
        let direction = spread(simd, &self.direction, on_sun);
        let aside = spread(simd, &[Vec3::ZERO, self.direction[1], self.direction[2]], on_sun);
        let mut origin = spread(simd, &self.origin, [simd.load(&on_patch[0]), simd.load(&on_patch[1])]);
        for axis in 0..3 {
            origin[axis] = aside[axis].mul_add(simd.splat(self.begin), origin[axis]);
        }
        let InsideStretch { side, caps, meets } = inside(simd, &self.shape, origin, direction);
        let (enter, leave) = (side[0].max(caps[0]), side[1].min(caps[1]));
        (meets & enter.le(leave) & simd.splat(-self.begin).le(leave)).bits()
    }
}
