//! A band of rows of the screen: the lattice's rays, then pixels between them.

use super::CloudStage;
use super::march::{Rays, VALUES, Veil, bilinear, lanes, shadow};
use super::{Cover, STEPS};
use crate::colour::linear_of_codes;
use crate::frame::stage::Pixels;
use crate::simd::math::srgb8;
use crate::simd::{Floats, Ints, Kernel, LANES, Mask, Simd, Sixteen};

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// Range that stands for that of the sky, metres.
const SKY: f32 = 1.0e30;

/// Share of the light on ground that clouds may keep from it: the sun's, but for what they scatter downward.
const SHADOWED: f32 = 0.55;

/// Values of a ray's profile.
const PROFILE: usize = (STEPS + 1) * VALUES * LANES;

pub(super) struct Filling<'b, 'c> {
    pub stage: &'b CloudStage<'c>,
    pub first: usize,
    pub light: Pixels<'b>,
    pub range: &'b [f32],
}

/// Rays of the lattice in a band, `[rows][groups][LANES]`.
struct Lattice {
    groups: usize,
    direction: [Vec<f32>; 3],
    near: Vec<f32>,
    span: Vec<f32>,
    /// `[rows][groups][STEPS + 1][VALUES][LANES]`
    profiles: Vec<Sixteen>,
    /// Screen positions without a picture, by the rows and columns of the lattice.
    blind: Vec<bool>,
}

impl Kernel for Filling<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { stage, first, mut light, range } = self;
        let width = stage.camera.width as usize;
        let rows = range.len() / width.max(1);
        let lattice = Lattice::new(simd, stage, first, rows.div_ceil(stage.cell) + 1);
        let profiles: &[f32] = bytemuck::cast_slice(&lattice.profiles);
        let has_blind = lattice.blind.contains(&true);
        let mut line = [const { Vec::new() }; 3 + VALUES];
        for row in 0..rows {
            let upper = row / stage.cell;
            let down = ((row % stage.cell) as f32 + 0.5) / stage.cell as f32;
            lattice.row(upper, down, &mut line);
            for column in (0..width).step_by(LANES) {
                let start = row * width + column;
                let end = start + LANES.min(width - column);
                let pixels = Chunk { simd, stage, column, row: first + row };
                let ranges = simd.load(&lanes(&range[start..end], 0)).min(simd.splat(SKY));
                if has_blind && lattice.is_blind(upper, column / stage.cell, (column + LANES) / stage.cell) {
                    pixels.by_rays(&mut light, start..end, ranges);
                } else {
                    let places = Places { lattice: &lattice, profiles, line: &line, upper, down };
                    pixels.by_lattice(&mut light, start..end, ranges, &places);
                }
            }
        }
    }
}

impl Lattice {
    #[inline(always)]
    fn new<V: Simd>(simd: V, stage: &CloudStage<'_>, first: usize, rows: usize) -> Self {
        let columns = (stage.camera.width as usize).div_ceil(stage.cell) + 1;
        let groups = columns.div_ceil(LANES);
        let size = rows * groups * LANES;
        let empty = || vec![0.0; size];
        let mut lattice = Self {
            groups,
            direction: [empty(), empty(), empty()],
            near: empty(),
            span: empty(),
            profiles: vec![Sixteen::default(); rows * groups * (STEPS + 1) * VALUES],
            blind: vec![false; size],
        };
        for index in 0..size {
            let (row, column) = (index / (groups * LANES), index % (groups * LANES));
            let at = [column.min(columns - 1) * stage.cell, first + row * stage.cell];
            let direction = stage.direction(at[0] as f64, at[1] as f64);
            lattice.blind[index] = direction.is_none();
            for (axis, target) in lattice.direction.iter_mut().enumerate() {
                target[index] = direction.map_or(0.0, |direction| direction[axis]);
            }
        }
        for group in 0..rows * groups {
            let start = group * LANES;
            let mut direction = [simd.splat(0.0); 3];
            for (lanes_of, values) in direction.iter_mut().zip(&lattice.direction) {
                *lanes_of = simd.load(&lanes(values, start));
            }
            let rays = Rays::new(simd, &stage.cover, direction, simd.splat(SKY));
            let profile = &mut lattice.profiles[group * PROFILE / LANES..][..PROFILE / LANES];
            rays.march(simd, &stage.cover, &stage.air, Some(profile));
            for (values, target) in [(rays.near, &mut lattice.near), (rays.span, &mut lattice.span)] {
                let mut stored = [0.0; LANES];
                values.store(&mut stored);
                target[start..start + LANES].copy_from_slice(&stored);
            }
        }
        lattice
    }

    /// Directions, and what the last steps know, along a row of pixels that lies `down` the way from one row of the lattice to the next.
    #[inline(always)]
    fn row(&self, upper: usize, down: f32, line: &mut [Vec<f32>; 3 + VALUES]) {
        let width = self.groups * LANES;
        let between = |from: f32, to: f32| (to - from).mul_add(down, from);
        let profiles: &[f32] = bytemuck::cast_slice(&self.profiles);
        for (value, line) in line.iter_mut().enumerate() {
            line.clear();
            if let Some(direction) = self.direction.get(value) {
                let [from, to] = [upper, upper + 1].map(|row| &direction[row * width..][..width]);
                line.extend(from.iter().zip(to).map(|(from, to)| between(*from, *to)));
                continue;
            }
            for group in 0..self.groups {
                let last = |row: usize| {
                    let at = (row * self.groups + group) * PROFILE;
                    &profiles[at + (STEPS * VALUES + value - 3) * LANES..][..LANES]
                };
                line.extend(last(upper).iter().zip(last(upper + 1)).map(|(from, to)| between(*from, *to)));
            }
        }
    }

    /// Whether the screen has no picture somewhere about these cells.
    fn is_blind(&self, upper: usize, from: usize, to: usize) -> bool {
        let width = self.groups * LANES;
        [upper, upper + 1]
            .into_iter()
            .any(|row| self.blind[row * width + from..row * width + (to + 2).min(width)].contains(&true))
    }
}

/// A row of pixels among the rays of the lattice.
struct Places<'l> {
    lattice: &'l Lattice,
    profiles: &'l [f32],
    line: &'l [Vec<f32>; 3 + VALUES],
    upper: usize,
    down: f32,
}

/// Up to sixteen pixels.
struct Chunk<'s, 'c, V> {
    simd: V,
    stage: &'s CloudStage<'c>,
    column: usize,
    row: usize,
}

impl<V: Simd> Chunk<'_, '_, V> {
    /// Pixels about which the lattice has no ray for all.
    #[inline(always)]
    fn by_rays(&self, light: &mut Pixels<'_>, pixels: std::ops::Range<usize>, range: V::F) {
        let Self { simd, stage, column, row } = *self;
        let mut parts = [[0.0; LANES]; 3];
        let mut seen = 0_u16;
        for lane in 0..pixels.len() {
            if let Some(direction) = stage.direction((column + lane) as f64 + 0.5, row as f64 + 0.5) {
                seen |= 1 << lane;
                for (axis, part) in parts.iter_mut().enumerate() {
                    part[lane] = direction[axis];
                }
            }
        }
        let direction = [simd.load(&parts[0]), simd.load(&parts[1]), simd.load(&parts[2])];
        let mut rays = Rays::new(simd, &stage.cover, direction, range);
        rays.span = rays.span.select(simd.mask(seen), simd.splat(0.0));
        let veil = rays.march(simd, &stage.cover, &stage.air, None);
        let is_ground = range.lt(simd.splat(SKY)) & simd.mask(seen);
        self.put(light, pixels, &veil, direction, range, is_ground);
    }

    #[inline(always)]
    fn by_lattice(
        &self,
        light: &mut Pixels<'_>,
        pixels: std::ops::Range<usize>,
        range: V::F,
        places: &Places<'_>,
    ) {
        let Self { simd, stage, column, .. } = *self;
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let mut columns = [0.0; LANES];
        for (lane, column_of) in columns.iter_mut().enumerate() {
            *column_of = (column + lane) as f32 + 0.5;
        }
        let across = simd.load(&columns) * simd.splat(1.0 / stage.cell as f32);
        let left = across.floor();
        let across = across - left;
        let left = left.to_int();
        let right = left + simd.splat_int(1);
        let mut values = [zero; 3 + VALUES];
        for (value, line) in values.iter_mut().zip(places.line).take(3) {
            let from = simd.gather(line, left);
            *value = (simd.gather(line, right) - from).mul_add(across, from);
        }
        let direction = [values[0], values[1], values[2]];
        let rays = Rays::new(simd, &stage.cover, direction, simd.splat(SKY));
        let enters = rays.near.lt(range) & zero.lt(rays.span);
        let is_ground = range.lt(simd.splat(SKY));
        if !enters.any() && !is_ground.any() {
            return;
        }
        let mut veil: Veil<V> = Veil { light: [zero; 3], through: one };
        if enters.any() {
            for (value, line) in values.iter_mut().zip(places.line).skip(3) {
                let from = simd.gather(line, left);
                *value = (simd.gather(line, right) - from).mul_add(across, from);
            }
            let [.., red, green, blue, through] = values;
            let ends = enters & range.lt(rays.near + rays.span);
            veil = Veil { light: [red, green, blue], through };
            if ends.any() {
                let gone = range - rays.near;
                let within = places.within(simd, [left, right], across, gone);
                for (light, within) in veil.light.iter_mut().zip(within.light) {
                    *light = within.select(ends, *light);
                }
                veil.through = within.through.select(ends, through);
            }
            for light in &mut veil.light {
                *light = light.select(enters, zero);
            }
            veil.through = veil.through.select(enters, one);
        }
        self.put(light, pixels, &veil, direction, range, is_ground);
    }

    /// Writes pixels anew: ground in the shadow of clouds, and clouds before it.
    #[inline(always)]
    fn put(
        &self,
        light: &mut Pixels<'_>,
        pixels: std::ops::Range<usize>,
        veil: &Veil<V>,
        direction: [V::F; 3],
        range: V::F,
        is_ground: V::M,
    ) {
        let (simd, stage) = (self.simd, self.stage);
        let one = simd.splat(1.0);
        let mut seen = load(simd, light, pixels.clone());
        let before = seen;
        if stage.cover.sunlight != [0.0; 3] && is_ground.any() {
            let range = range.select(is_ground, one);
            let lit = lit(simd, &stage.cover, direction, range).select(is_ground, one);
            if lit.lt(one).any() {
                let mut air = stage.air;
                air.turn(simd, [direction[0], direction[1]]);
                let haze = air.over(simd, [simd.splat(0.0); 3], range, direction[2] * range);
                for ((seen, haze), tint) in seen.iter_mut().zip(haze).zip(stage.tint) {
                    // Haze lies before the shadow.
                    let haze = (haze * simd.splat(tint)).min(*seen);
                    *seen = (*seen - haze).mul_add(lit, haze);
                }
            }
        }
        for ((seen, light), tint) in seen.iter_mut().zip(veil.light).zip(stage.tint) {
            *seen = seen.mul_add(veil.through, light * simd.splat(tint));
        }
        let mut changed = simd.mask(0);
        for (seen, before) in seen.iter().zip(before) {
            changed = changed | seen.lt(before) | before.lt(*seen);
        }
        if changed.any() {
            store(simd, light, pixels, seen);
        }
    }
}

impl Places<'_> {
    /// What lies before pixels that end within the layer, so many metres after their rays have entered it.
    #[inline(always)]
    fn within<V: Simd>(&self, simd: V, columns: [V::I; 2], across: V::F, gone: V::F) -> Veil<V> {
        let zero = simd.splat(0.0);
        let mut corners = [[zero; 4]; VALUES];
        for corner in 0..4 {
            let row = self.upper + corner / 2;
            let column = columns[corner % 2];
            let width = self.lattice.groups * LANES;
            let at = column + simd.splat_int((row * width) as i32);
            let near = simd.gather(&self.lattice.near, at);
            let span = simd.gather(&self.lattice.span, at);
            let steps = Rays::<V> { direction: [zero; 3], near, span }.steps(simd, gone);
            let whole = steps.floor().max(zero).min(simd.splat((STEPS - 1) as f32));
            let share = (steps - whole).max(zero).min(simd.splat(1.0));
            let group = column.shr::<4>() + simd.splat_int((row * self.lattice.groups) as i32);
            let first = group.mul(simd.splat_int(PROFILE as i32))
                + whole.to_int().mul(simd.splat_int((VALUES * LANES) as i32))
                + (column & simd.splat_int(LANES as i32 - 1));
            for (value, corners) in corners.iter_mut().enumerate() {
                let at = first + simd.splat_int((value * LANES) as i32);
                let from = simd.gather(self.profiles, at);
                let to = simd.gather(self.profiles, at + simd.splat_int((VALUES * LANES) as i32));
                corners[corner] = (to - from).mul_add(share, from);
            }
        }
        let down = simd.splat(self.down);
        let [red, green, blue, through] = corners;
        let light = [
            bilinear::<V>(red, across, down),
            bilinear::<V>(green, across, down),
            bilinear::<V>(blue, across, down),
        ];
        Veil { light, through: bilinear::<V>(through, across, down) }
    }
}

/// Share of its light that ground keeps in the shadow of clouds; less of a shadow lies on ground that rises through the layer.
#[inline(always)]
fn lit<V: Simd>(simd: V, cover: &Cover<'_>, direction: [V::F; 3], range: V::F) -> V::F {
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let rise = direction[2] * range;
    let under = simd.splat(cover.heights[1]) - rise;
    let share = (under * simd.splat(cover.per_depth)).max(zero).min(one);
    let [east, north, up] = cover.shadows;
    let way = (simd.splat(cover.heights[0]) - rise).max(zero) * simd.splat(1.0 / up);
    let per_voxel = simd.splat(cover.per_voxel);
    let place = |axis: usize, sun: f32| {
        direction[axis].mul_add(range, way * simd.splat(sun)).mul_add(per_voxel, simd.splat(cover.eye[axis]))
    };
    let through = shadow(simd, cover, [place(0, east), place(1, north)]);
    one - share * (one - through) * simd.splat(SHADOWED)
}

#[inline(always)]
fn load<V: Simd>(simd: V, light: &Pixels<'_>, pixels: std::ops::Range<usize>) -> [V::F; 3] {
    match light {
        Pixels::Srgb8(bytes) => {
            let mut all = [0; RGB * LANES];
            let own = &bytes[pixels.start * RGB..pixels.end * RGB];
            all[..own.len()].copy_from_slice(own);
            let (codes, byte) = (simd.load_triples(&all), simd.splat_int(255));
            let table = linear_of_codes();
            [
                simd.gather(table, codes & byte),
                simd.gather(table, codes.shr::<8>() & byte),
                simd.gather(table, codes.shr::<16>() & byte),
            ]
        }
        Pixels::Linear(colour) => {
            let mut parts = [[0.0; LANES]; 3];
            for (lane, pixel) in colour[pixels].iter().enumerate() {
                for (part, value) in parts.iter_mut().zip(pixel) {
                    part[lane] = *value;
                }
            }
            [simd.load(&parts[0]), simd.load(&parts[1]), simd.load(&parts[2])]
        }
    }
}

#[inline(always)]
fn store<V: Simd>(simd: V, light: &mut Pixels<'_>, pixels: std::ops::Range<usize>, seen: [V::F; 3]) {
    let [red, green, blue] = seen;
    match light {
        Pixels::Srgb8(bytes) => {
            let packed = srgb8(simd, red, 1.0) | srgb8(simd, green, 1.0).shl::<8>();
            let mut all = [0; RGB * LANES];
            simd.store_triples(packed | srgb8(simd, blue, 1.0).shl::<16>(), &mut all);
            let own = &mut bytes[pixels.start * RGB..pixels.end * RGB];
            own.copy_from_slice(&all[..own.len()]);
        }
        Pixels::Linear(colour) => {
            let mut parts = [[0.0; LANES]; 3];
            red.store(&mut parts[0]);
            green.store(&mut parts[1]);
            blue.store(&mut parts[2]);
            for (lane, pixel) in colour[pixels].iter_mut().enumerate() {
                *pixel = [parts[0][lane], parts[1][lane], parts[2][lane]];
            }
        }
    }
}
