//! Light of sixteen planes in one row: the plane image of a frame is written and read once, and what that takes is memory.
//!
//! Cells hold roots of linear light, which are about as far apart as the eye tells them, in 16 bits: with 10 and 11 one 8-bit
//! code in twelve to twenty was off by one.

use glam::Vec3;

use crate::simd::{Floats, Ints, LANES, Simd};

/// Roots of the light of sixteen planes, as codes.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(32))]
pub struct Cell {
    /// Red from bit 0, green from bit 16 on.
    red_green: [i32; LANES],
    blue: [u16; LANES],
}

/// Codes of sixteen lanes: red from bit 0 and green from bit 16 on; blue.
#[derive(Clone, Copy)]
pub struct Codes<V: Simd> {
    pub red_green: V::I,
    pub blue: V::I,
}

/// Largest code.
const LIMIT: f32 = 65535.0;

/// Bits of a code.
const BITS: u32 = 16;

/// Least light of which a root is taken: that of 0 has no particular value.
const LEAST: f32 = 1.0e-12;

impl Default for Cell {
    #[inline(always)]
    fn default() -> Self {
        Self { red_green: [0; LANES], blue: [0; LANES] }
    }
}

impl Cell {
    /// Loads the codes.
    #[inline(always)]
    pub fn load<V: Simd>(&self, simd: V) -> Codes<V> {
        Codes { red_green: simd.load_ints(&self.red_green), blue: simd.load_shorts(&self.blue) }
    }

    /// Puts roots in steps of its scale, none greater than the largest code, into it.
    #[inline(always)]
    pub fn put<V: Simd>(&mut self, simd: V, roots: [V::F; 3]) {
        self.store::<V>(Codes::nearest(simd, roots));
    }

    #[inline(always)]
    fn store<V: Simd>(&mut self, codes: Codes<V>) {
        codes.red_green.store(&mut self.red_green);
        codes.blue.store_shorts(&mut self.blue);
    }

    /// Gathers codes of planes out of `cells`; bits of `places` from bit 4 on are indices of cells, those below number the plane.
    #[inline(always)]
    pub fn gather<V: Simd>(simd: V, cells: &[Self], places: V::I) -> Codes<V> {
        const { assert!(size_of::<Cell>() == 6 * LANES) };
        let cell = places.shr::<{ LANES.ilog2() }>();

        // 24 words to a cell, the first of which are red and green; of 48 halves the last are blue. These are the second ones of pairs: the very last begins none.
        let red_green = simd.gather_words(bytemuck::cast_slice(cells), places + cell.shl::<3>());
        let before = places + cell.shl::<5>() + simd.splat_int(2 * LANES as i32 - 1);
        let blue = simd.gather_pairs(bytemuck::cast_slice(cells), before).shr::<BITS>();
        Codes { red_green, blue }
    }
}

impl<V: Simd> Codes<V> {
    /// Codes nearest to roots that lie between them.
    #[inline(always)]
    fn nearest(simd: V, roots: [V::F; 3]) -> Self {
        let half = simd.splat(0.5);
        let [red, green, blue] = roots;
        let (red, green) = ((red + half).to_int(), (green + half).to_int());
        Self { red_green: red | green.shl::<BITS>(), blue: (blue + half).to_int() }
    }

    /// The codes by channel.
    #[inline(always)]
    pub fn channels(self, simd: V) -> [V::F; 3] {
        let red = self.red_green & simd.splat_int(0xffff);
        [red.to_float(), self.red_green.shr::<BITS>().to_float(), self.blue.to_float()]
    }
}

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

    /// Root of linear light from one code to the next.
    pub fn step(self) -> f32 {
        self.root_of_brightest / LIMIT
    }

    /// Puts linear light into a cell.
    #[inline(always)]
    pub fn encode<V: Simd>(self, simd: V, light: [V::F; 3], cell: &mut Cell) {
        cell.put(simd, self.roots(simd, light));
    }

    /// Puts linear light of some planes into a cell.
    #[inline(always)]
    pub fn encode_masked<V: Simd>(self, simd: V, light: [V::F; 3], planes: V::M, cell: &mut Cell) {
        let known = cell.load(simd);
        let codes = Codes::<V>::nearest(simd, self.roots(simd, light));
        cell.store::<V>(Codes {
            red_green: codes.red_green.select(planes, known.red_green),
            blue: codes.blue.select(planes, known.blue),
        });
    }

    /// Returns roots of linear light, in [steps](Self::step), up to the largest code.
    #[inline(always)]
    pub fn roots<V: Simd>(self, simd: V, light: [V::F; 3]) -> [V::F; 3] {
        let (scale, limit) = (simd.splat(1.0 / self.step()), simd.splat(LIMIT));
        let mut roots = light;
        for root in &mut roots {
            *root = (root.max(simd.splat(LEAST)).sqrt_rough() * scale).min(limit);
        }
        roots
    }

    /// Linear light of a cell.
    #[inline(always)]
    pub fn decode<V: Simd>(self, simd: V, cell: &Cell) -> [V::F; 3] {
        let mut light = cell.load(simd).channels(simd);
        for light in &mut light {
            let root = *light * simd.splat(self.step());
            *light = root * root;
        }
        light
    }
}

/// Codes between others, `share` of the way from the first to the second.
#[inline(always)]
pub fn between<V: Simd>(simd: V, from: Codes<V>, to: Codes<V>, share: V::F) -> [V::F; 3] {
    let (mut between, to) = (from.channels(simd), to.channels(simd));
    for (channel, between) in between.iter_mut().enumerate() {
        *between = (to[channel] - *between).mul_add(share, *between);
    }
    between
}

/// Adds codes times a weight.
#[inline(always)]
pub fn add<V: Simd>(simd: V, sum: &mut [V::F; 3], codes: Codes<V>, weight: V::F) {
    let codes = codes.channels(simd);
    for (channel, sum) in sum.iter_mut().enumerate() {
        *sum = codes[channel].mul_add(weight, *sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel};

    struct There(Scale, [[f32; LANES]; 3]);

    impl Kernel for There {
        type Output = [[f32; LANES]; 3];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let mut cell = Cell::default();
            self.0.encode(simd, self.1.map(|light| simd.load(&light)), &mut cell);
            let mut light = [[0.0; LANES]; 3];
            for (lanes, seen) in light.iter_mut().zip(self.0.decode(simd, &cell)) {
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
                for channel in 0..3 {
                    // Besides the step, that of rough roots.
                    let tolerance = 0.65 * scale.step() + 1.0e-4;
                    for lane in 0..LANES {
                        let root = light[channel][lane].sqrt().min(scale.root_of_brightest);
                        let back = seen[channel][lane].sqrt();
                        assert!((back - root).abs() < tolerance, "{isa}: {root} comes back as {back}");
                    }
                }
            }
        }
    }
}
