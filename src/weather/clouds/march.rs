//! Sixteen rays through the layer.

use crate::simd::math::{exp_neg, log2};
use crate::simd::{Floats, Ints, Kernel, LANES, Mask, Simd, Sixteen};
use crate::weather::AtmosphereLanes;
use crate::weather::clouds::cover::{CloudCover, STEPS};
use crate::weather::clouds::field::{FIRST, LAYERS, LEVELS, ROW};
use crate::weather::clouds::noise::SIDE;
use crate::weather::glow::PHASE;

/// Range beyond which there are no clouds, metres, and where they begin to thin out: haze has hidden them long before, where there is any.
const FAR: f32 = 60_000.0;
const THINS: f32 = 30_000.0;

/// Metres over which steps double besides those before the layer: they grow with the range from there on. If they took the whole way for their measure, a
/// ray that leaves the layer a little later would meet all clouds at other places, and rows near the horizon would differ.
const ONSET: f32 = 200.0;

/// Share of the way from a level's voxels to the next one's from which on steps read both.
const BLENDS: f32 = 0.5;

/// Transmittance below which nothing more is added.
const OPAQUE: f32 = 0.002;

/// Linear Rec. 709 light that the sky sends into the base and the top of a cloud.
const AMBIENT: [[f32; 3]; 2] = [[0.36, 0.40, 0.45], [0.46, 0.52, 0.60]];

/// Sunlight that a cloud sends in any direction, and towards the sun's side besides.
const SUNLIT: [f32; 2] = [0.50, 0.55];

/// Directions and ranges of sixteen rays, and where they are in the layer.
#[derive(Clone, Copy)]
pub struct CloudRays<V: Simd> {
    /// Unit direction.
    pub direction: [V::F; 3],
    /// Range at which the ray enters the layer and what it has to go there, metres; the latter is 0 where it misses it.
    pub near: V::F,
    pub span: V::F,
    pub pace: Pace<V>,
}

/// Stride of rays through the layer: `steps = rate · log₂(1 + metres · per_onset)`.
#[derive(Clone, Copy)]
pub struct Pace<V: Simd> {
    /// 1/metres.
    pub per_onset: V::F,
    /// Steps per doubling.
    pub rate: V::F,
}

/// Light of clouds along a ray, and the share of what lies behind that comes through.
#[derive(Clone, Copy)]
pub struct CloudVeil<V: Simd> {
    pub light: [V::F; 3],
    pub through: V::F,
}

/// Values that a [`CloudVeil`] has.
pub const VALUES: usize = 4;

/// The march of sixteen rays.
struct CloudMarch<'m, 'c, V: Simd> {
    simd: V,
    rays: &'m CloudRays<V>,
    cover: &'m CloudCover<'c>,
    air: &'m AtmosphereLanes,
    profile: Option<&'m mut [Sixteen]>,
}

impl<V: Simd> Kernel for CloudMarch<'_, '_, V> {
    type Output = CloudVeil<V>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> CloudVeil<V> {
        self.rays.march_steps(self.simd, self.cover, self.air, self.profile)
    }
}

/// One look at one level of the field.
struct LevelSample<'m, 'c, V: Simd> {
    simd: V,
    rays: &'m CloudRays<V>,
    cover: &'m CloudCover<'c>,
    range: V::F,
    exponent: V::I,
}

impl<V: Simd> Kernel for LevelSample<'_, '_, V> {
    type Output = (V::F, V::F);

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> (V::F, V::F) {
        self.rays.read_level(self.simd, self.cover, self.range, self.exponent)
    }
}

impl<V: Simd> CloudRays<V> {
    /// Rays from the eye that end after `range` metres.
    #[inline(always)]
    pub fn new(simd: V, cover: &CloudCover<'_>, direction: [V::F; 3], range: V::F) -> Self {
        let (zero, least) = (simd.splat(0.0), simd.splat(1.0e-7));
        let up = direction[2];
        let slant = (least.select(up.lt(zero), least) + up.abs()).recip();
        let slant = (zero - slant).select(up.lt(zero), slant);
        let [base, top] = [simd.splat(cover.heights[0]) * slant, simd.splat(cover.heights[1]) * slant];
        let near = base.min(top).max(zero);
        let far = base.max(top).min(range).min(simd.splat(FAR));
        let span = (far - near).max(zero);
        Self { direction, near, span, pace: Pace::new(simd, near, span) }
    }

    /// Goes through the layer; `profile`, `[STEPS + 1][VALUES]`, learns light and share of what comes through up to each step's end.
    #[inline(always)]
    pub fn march(
        &self,
        simd: V,
        cover: &CloudCover<'_>,
        air: &AtmosphereLanes,
        profile: Option<&mut [Sixteen]>,
    ) -> CloudVeil<V> {
        simd.call(CloudMarch { simd, rays: self, cover, air, profile })
    }

    #[inline(always)]
    fn march_steps(
        &self,
        simd: V,
        cover: &CloudCover<'_>,
        air: &AtmosphereLanes,
        mut profile: Option<&mut [Sixteen]>,
    ) -> CloudVeil<V> {
        let (zero, one, least) = (simd.splat(0.0), simd.splat(1.0), simd.splat(1.0e-6));
        let mut veil: CloudVeil<V> = CloudVeil { light: [zero; 3], through: one };
        if let Some(profile) = profile.as_deref_mut() {
            veil.store(profile);
        }

        let is_missed = !zero.lt(self.span).any();
        let mut air = *air;
        air.turn(simd, [self.direction[0], self.direction[1]]);
        let sunlit = self.sunlit(simd, cover);
        let (onset, growth) = self.pace.growth(simd);
        let mut onward = onset;
        let mut before = self.near;
        let mut last = self.sample(simd, cover, before, zero);

        for step in 1..=STEPS {
            let is_done = is_missed || veil.through.greatest() < OPAQUE;
            if is_done && profile.is_none() {
                break;
            }
            if !is_done {
                onward = onward * growth;
                let gone = if step == STEPS { self.span } else { (onward - onset).min(self.span) };
                let range = self.near + gone;
                let next = self.sample(simd, cover, range, range - before);
                let mean = (last.0 + next.0) * simd.splat(0.5);

                if zero.lt(mean).any() {
                    let middle = (before + range) * simd.splat(0.5);
                    let thins = (simd.splat(FAR) - middle) * simd.splat(1.0 / (FAR - THINS));
                    let depth = mean * simd.splat(cover.extinction) * (range - before);
                    let left = exp_neg(simd, (depth * thins.max(zero).min(one)).max(zero));

                    // What is empty has no say in the light.
                    let lit = (last.1 + next.1) * (last.0 + next.0).max(least).recip() * sunlit;
                    let height = self.direction[2].mul_add(middle, simd.splat(-cover.heights[0]));
                    let height = (height * simd.splat(cover.per_depth)).max(zero).min(one);
                    let mut light = [zero; 3];

                    for (channel, light) in light.iter_mut().enumerate() {
                        let [low, high] = [AMBIENT[0][channel], AMBIENT[1][channel]];
                        let ambient = height.mul_add(simd.splat(high - low), simd.splat(low));
                        *light = lit.mul_add(simd.splat(cover.sunlight[channel]), ambient);
                    }

                    let seen = air.over(simd, light, middle.max(one), self.direction[2] * middle.max(one));
                    let weight = veil.through * (one - left);
                    for (channel, light) in veil.light.iter_mut().enumerate() {
                        *light = seen[channel].mul_add(weight, *light);
                    }

                    veil.through = veil.through * left;
                }

                (before, last) = (range, next);
            }
            if let Some(profile) = profile.as_deref_mut() {
                veil.store(&mut profile[step * VALUES..]);
            }
        }

        veil
    }

    /// Sunlight that comes this way from where all of it falls.
    #[inline(always)]
    fn sunlit(&self, simd: V, cover: &CloudCover<'_>) -> V::F {
        let mut cosine = simd.splat(0.0);
        for (axis, direction) in self.direction.iter().enumerate() {
            cosine = direction.mul_add(simd.splat(cover.to_sun[axis]), cosine);
        }
        let root = cosine.neg_mul_add(simd.splat(PHASE[1]), simd.splat(PHASE[0])).rsqrt();
        // 1 towards the sun.
        let scale = (PHASE[0] - PHASE[1]).powf(1.5);
        (root * root * root).mul_add(simd.splat(SUNLIT[1] * scale), simd.splat(SUNLIT[0]))
    }

    /// Density at a range, 0…1, and light times it, of levels whose voxels are about as wide as the `step` to there is long. Where it is nearly as long as the next level's are
    /// wide, that one has its share: voxels that change their level at once would leave lines.
    #[inline(always)]
    fn sample(&self, simd: V, cover: &CloudCover<'_>, range: V::F, step: V::F) -> (V::F, V::F) {
        let one = simd.splat(1.0);
        // ⌊log₂⌋ of the step in voxels, from the exponent.
        let ratio = (step * simd.splat(cover.per_voxel)).max(one).min(simd.splat((1 << (LEVELS - 1)) as f32));
        let exponent = ratio.to_bits().shr::<23>();
        let fine = self.level(simd, cover, range, exponent);
        let scale = (simd.splat_int(254) - exponent).shl::<23>().as_floats();
        let share = ratio.mul_add(scale, simd.splat(-1.0 - BLENDS)) * simd.splat(1.0 / (1.0 - BLENDS));
        let share = share.max(simd.splat(0.0));
        if !simd.splat(0.0).lt(share).any() {
            return fine;
        }
        let next = exponent + simd.splat_int(1);
        let coarse = self.level(simd, cover, range, next.min(simd.splat_int(126 + LEVELS as i32)));
        ((coarse.0 - fine.0).mul_add(share, fine.0), (coarse.1 - fine.1).mul_add(share, fine.1))
    }

    /// Density at a range, 0…1, and light times it, of the level whose voxels are 2^(`exponent` − 127) times as wide as the finest.
    #[inline(always)]
    fn level(&self, simd: V, cover: &CloudCover<'_>, range: V::F, exponent: V::I) -> (V::F, V::F) {
        simd.call(LevelSample { simd, rays: self, cover, range, exponent })
    }

    #[inline(always)]
    fn read_level(&self, simd: V, cover: &CloudCover<'_>, range: V::F, exponent: V::I) -> (V::F, V::F) {
        let per_voxel = simd.splat(cover.per_voxel);
        let one = simd.splat(1.0);
        let level = exponent - simd.splat_int(127);
        let scale = (simd.splat_int(254) - exponent).shl::<23>().as_floats();

        // A coarser voxel's middle lies between those that it is the mean of.
        let shift = (scale - one) * simd.splat(0.5);
        let mut place = [shift; 2];
        for (axis, place) in place.iter_mut().enumerate() {
            let fine = (self.direction[axis] * range).mul_add(per_voxel, simd.splat(cover.eye[axis]));
            *place = fine.mul_add(scale, *place);
        }

        let [x, y] = place;
        let z = self.direction[2].mul_add(range, simd.splat(-cover.heights[0]));
        let z = z * simd.splat(cover.per_depth * (LAYERS - 1) as f32);
        let z = z.max(simd.splat(0.0)).min(simd.splat((LAYERS - 1) as f32 - 1.0e-3));
        let (left, south, low) = (x.floor(), y.floor(), z.floor());
        let (x, y, z) = (x - left, y - south, z - low);
        let side = (simd.splat(SIDE as f32) * scale).to_int();
        let mask = side - simd.splat_int(1);
        let (left, south) = (left.to_int() & mask, south.to_int() & mask);
        let north = (south + simd.splat_int(1)) & mask;
        let layer = low.to_int().mul(side);
        let row = side + simd.splat_int(1);
        let first = simd.gather_words(&FIRST, level) + left;
        let rows = [(layer + south).mul(row) + first, (layer + north).mul(row) + first];
        let (a, b) = simd.gather_word_pairs(&cover.field.words, rows[0]);
        let (c, d) = simd.gather_word_pairs(&cover.field.words, rows[1]);
        let words = [a, b, c, d];
        let byte = simd.splat_int(255);
        let mut density = [simd.splat(0.0); 4];
        for (corner, density) in density.iter_mut().enumerate() {
            let word = words[corner];
            let (low, high) = ((word & byte).to_float(), (word.shr::<8>() & byte).to_float());
            *density = (high - low).mul_add(z, low);
        }

        let density = bilinear::<V>(density, x, y) * simd.splat(1.0 / 255.0);
        if !simd.splat(0.0).lt(density).any() {
            return (density, density);
        }

        let mut light = [simd.splat(0.0); 4];
        for (corner, light) in light.iter_mut().enumerate() {
            let word = words[corner];
            let (low, high) = ((word.shr::<16>() & byte).to_float(), word.shr::<24>().to_float());
            *light = (high - low).mul_add(z, low);
        }

        (density, bilinear::<V>(light, x, y) * density * simd.splat(1.0 / 255.0))
    }
}

impl<V: Simd> Pace<V> {
    /// Computes the pace of rays that enter the layer after `near` metres and go `span` metres there.
    #[inline(always)]
    fn new(simd: V, near: V::F, span: V::F) -> Self {
        let per_onset = (near + simd.splat(ONSET)).recip();
        let doublings = log2(simd, span.mul_add(per_onset, simd.splat(1.0)));
        Self { per_onset, rate: simd.splat(STEPS as f32) * doublings.max(simd.splat(1.0e-6)).recip() }
    }

    /// Steps, from 0 to [`STEPS`], that a ray has gone after so many metres in the layer.
    #[inline(always)]
    pub fn steps(&self, simd: V, gone: V::F) -> V::F {
        let doublings = log2(simd, gone.max(simd.splat(0.0)).mul_add(self.per_onset, simd.splat(1.0)));
        (doublings * self.rate).min(simd.splat(STEPS as f32))
    }

    /// Metres over which steps double at first, and the quotient of a step and the one before it.
    #[inline(always)]
    fn growth(&self, simd: V) -> (V::F, V::F) {
        let doublings = self.rate.recip() * simd.splat(std::f32::consts::LN_2);
        (self.per_onset.recip(), exp_neg(simd, doublings).recip())
    }
}

impl<V: Simd> CloudVeil<V> {
    #[inline(always)]
    fn store(&self, target: &mut [Sixteen]) {
        let [red, green, blue] = self.light;
        for (index, value) in [red, green, blue, self.through].iter().enumerate() {
            value.store(&mut target[index].0);
        }
    }
}

/// Between south-west, south-east, north-west and north-east.
#[inline(always)]
pub fn bilinear<V: Simd>(values: [V::F; 4], x: V::F, y: V::F) -> V::F {
    let south = (values[1] - values[0]).mul_add(x, values[0]);
    let north = (values[3] - values[2]).mul_add(x, values[2]);
    (north - south).mul_add(y, south)
}

/// Share of sunlight that clouds let through to ground at voxels `x`, `y` below their base.
#[inline(always)]
pub fn shadow<V: Simd>(simd: V, cover: &CloudCover<'_>, [x, y]: [V::F; 2]) -> V::F {
    let (left, south) = (x.floor(), y.floor());
    let (x, y) = (x - left, y - south);
    let mask = simd.splat_int(SIDE as i32 - 1);
    let (left, south) = (left.to_int() & mask, south.to_int() & mask);
    let north = (south + simd.splat_int(1)) & mask;
    let (row, one) = (simd.splat_int(ROW as i32), simd.splat_int(1));
    let [south, north] = [south.mul(row) + left, north.mul(row) + left];
    let mut values = [simd.splat(0.0); 4];
    let corners = [south, south + one, north, north + one];
    for (corner, value) in values.iter_mut().enumerate() {
        *value = simd.gather(&cover.field.shadow, corners[corner]);
    }
    bilinear::<V>(values, x, y)
}

/// Lanes of a slice, the last one again behind its end.
#[inline(always)]
pub fn lanes(values: &[f32], first: usize) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    for (lane, value) in lanes.iter_mut().enumerate() {
        *value = values.get(first + lane).or(values.last()).copied().unwrap_or_default();
    }
    lanes
}
