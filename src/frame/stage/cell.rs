//! Light of sixteen planes in one row, in one word each: the plane image of a frame is written and read once, and what that takes is
//! memory.
//!
//! Words hold roots of linear light, which are about as far apart as the eye tells them: red and green in 11 bits, blue in 10.

use glam::Vec3;

use crate::simd::{Each, Floats, Ints, Simd, Sixteen};

/// Words of sixteen planes: red from bit 0, green from bit 11, blue from bit 22 on.
pub type Cell = Sixteen;

/// Largest codes.
const LIMITS: [f32; 3] = [2047.0, 2047.0, 1023.0];

/// First value of green in a word.
const GREEN: f32 = 2048.0;

/// Least light of which a root is taken: that of 0 has no particular value.
const LEAST: f32 = 1.0e-12;

/// Light that the largest codes stand for; what is brighter is clipped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    root_of_brightest: f32,
}

impl Scale {
    /// Up to display white.
    pub const DISPLAY: Self = Self { root_of_brightest: 1.0 };
    /// All that radiance holds.
    pub const ALL: Self = Self { root_of_brightest: 1.5 };

    /// Up to what is display white once it is multiplied by the `tint` of the hour, as far as radiance goes: slopes that face a low sun are brighter than white
    /// before.
    pub fn under(tint: Vec3) -> Self {
        let root = 1.0 / tint.min_element().sqrt();
        Self { root_of_brightest: root.clamp(Self::DISPLAY.root_of_brightest, Self::ALL.root_of_brightest) }
    }

    /// Linear light of the units in which light between words is counted, by channel: the square of a code, which green keeps in its place.
    #[inline(always)]
    pub fn units(self) -> [f32; 3] {
        let mut roots = LIMITS.each(|limit| self.root_of_brightest / limit);
        roots[1] /= GREEN;
        roots.each(|root| root * root)
    }

    /// Words of linear light.
    #[inline(always)]
    pub fn encode<V: Simd>(self, simd: V, light: [V::F; 3]) -> V::F {
        let mut codes = [simd.splat_int(0); 3];
        for (channel, code) in codes.iter_mut().enumerate() {
            let limit = LIMITS[channel];
            let root = light[channel].max(simd.splat(LEAST)).sqrt_rough();
            let scaled = root.mul_add(simd.splat(limit / self.root_of_brightest), simd.splat(0.5));
            *code = scaled.min(simd.splat(limit)).to_int();
        }
        let [red, green, blue] = codes;
        (red | green.shl::<11>() | blue.shl::<22>()).as_floats()
    }
}

impl Scale {
    /// Linear light of words.
    #[inline(always)]
    pub fn decode<V: Simd>(self, simd: V, words: V::F) -> [V::F; 3] {
        let words = words.to_bits();
        let mut light = between(simd, words, words, simd.splat(0.0));
        let units = self.units();
        for (channel, light) in light.iter_mut().enumerate() {
            *light = *light * simd.splat(units[channel]);
        }
        light
    }
}

/// Linear light between two words, in [units](Scale::units).
#[inline(always)]
pub fn between<V: Simd>(simd: V, from: V::I, to: V::I, share: V::F) -> [V::F; 3] {
    let (red, green) = (simd.splat_int(0x7ff), simd.splat_int(0x7ff << 11));
    [
        mix::<V>(from & red, to & red, share),
        mix::<V>(from & green, to & green, share),
        mix::<V>(from.shr::<22>(), to.shr::<22>(), share),
    ]
}

/// Adds light of words, in [units](Scale::units), times a weight.
#[inline(always)]
pub fn add<V: Simd>(simd: V, sum: &mut [V::F; 3], words: V::I, weight: V::F) {
    let (red, green) = (simd.splat_int(0x7ff), simd.splat_int(0x7ff << 11));
    let codes = [words & red, words & green, words.shr::<22>()];
    for (channel, sum) in sum.iter_mut().enumerate() {
        let code = codes[channel].to_float();
        *sum = (code * code).mul_add(weight, *sum);
    }
}

/// Square of a code between two.
#[inline(always)]
fn mix<V: Simd>(from: V::I, to: V::I, share: V::F) -> V::F {
    let (from, to) = (from.to_float(), to.to_float());
    let from = from * from;
    (to * to - from).mul_add(share, from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel, LANES};

    struct There(Scale, [[f32; LANES]; 3]);

    impl Kernel for There {
        type Output = [[f32; LANES]; 3];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let words = self.0.encode(simd, self.1.map(|light| simd.load(&light))).to_bits();
            let mut light = [[0.0; LANES]; 3];
            for (lanes, seen) in light.iter_mut().zip(between(simd, words, words, simd.splat(0.5))) {
                seen.store(lanes);
            }
            light
        }
    }

    #[test]
    fn pictures_of_an_evening_keep_what_is_white_after_it_was_darkened() {
        assert_eq!((Scale::under(Vec3::ONE), Scale::under(Vec3::splat(0.01))), (Scale::DISPLAY, Scale::ALL));
        let root = Scale::under(Vec3::new(0.6, 0.64, 0.7)).root_of_brightest;
        assert!((0.6 * root * root - 1.0).abs() < 1e-6, "{root}");
    }

    #[test]
    fn light_comes_back_within_a_step_of_its_root() {
        for (isa, scale) in
            Isa::available().into_iter().flat_map(|isa| [(isa, Scale::DISPLAY), (isa, Scale::ALL)])
        {
            for step in 0..500 {
                let light: [[f32; LANES]; 3] = std::array::from_fn(|channel| {
                    std::array::from_fn(|lane| ((step * LANES + lane) * (channel + 1)) as f32 * 1.0e-4)
                });
                let seen = isa.run(There(scale, light));
                for (channel, unit) in scale.units().into_iter().enumerate() {
                    let tolerance = 0.65 * scale.root_of_brightest / LIMITS[channel];
                    for lane in 0..LANES {
                        let root = light[channel][lane].sqrt().min(scale.root_of_brightest);
                        let back = (seen[channel][lane] * unit).sqrt();
                        assert!((back - root).abs() < tolerance, "{isa}: {root} comes back as {back}");
                    }
                }
            }
        }
    }
}
