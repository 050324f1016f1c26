//! A band of rows of the screen: the lattice's rays, then pixels between them.

use std::ops::Range;

use crate::pixels::Pixels;
use crate::simd::{Floats, Ints, Kernel, LANES, Mask, Simd, Sixteen};
use crate::weather::clouds::CloudStage;
use crate::weather::clouds::cover::{CloudCover, STEPS};
use crate::weather::clouds::march::{CloudRays, CloudVeil, Pace, VALUES, bilinear, lanes, shadow};

/// Range that stands for that of the sky, metres.
const SKY: f32 = 1.0e30;

/// Mean difference of a lattice's rays from the mean of those above and below, as light, from which on it has twice as many rows: far clouds near the
/// horizon are that flat.
const FLAT: f32 = 0.012;

/// Values of a ray's profile.
const PROFILE: usize = (STEPS + 1) * VALUES * LANES;

pub(super) struct CloudFilling<'b, 'c> {
    pub stage: &'b CloudStage<'c>,
    /// Memory; nothing in it matters.
    pub lattice: &'b mut CloudLattice,
    pub first: usize,
    pub light: Pixels<'b>,
    pub range: &'b [f32],
}

/// Rays of the lattice in a band, `[rows][groups][LANES]`.
#[derive(Debug, Default)]
pub struct CloudLattice {
    groups: usize,
    /// Start of each row in memory, downward.
    rows: Vec<usize>,
    /// Pixels from row to row.
    spacing: f32,
    direction: [Vec<f32>; 3],
    /// Parts of a [`Pace`].
    per_onset: Vec<f32>,
    rate: Vec<f32>,
    /// `[rows][groups][STEPS + 1][VALUES][LANES]`, and behind them what another band left there.
    profiles: Vec<Sixteen>,
    /// Screen positions without a picture, by the rows and columns of the lattice.
    blind: Vec<bool>,
}

impl CloudStage<'_> {
    /// Puts clouds into a band that begins at a multiple of [`Self::band_rows`]; `range` of its pixels is metres, infinite for the sky. `lattice` is scratch memory.
    pub fn fill(&self, lattice: &mut CloudLattice, first: usize, light: Pixels<'_>, range: &[f32]) {
        self.isa.run(CloudFilling { stage: self, lattice, first, light, range });
    }
}

impl Kernel for CloudFilling<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { stage, lattice, first, mut light, range } = self;
        let width = stage.camera.width as usize;
        let rows = range.len() / width.max(1);
        lattice.renew(simd, stage, first, rows);
        let profiles: &[f32] = bytemuck::cast_slice(&lattice.profiles);
        let has_blind = lattice.blind.contains(&true);
        let mut line = [const { Vec::new() }; 3 + VALUES];

        for row in 0..rows {
            let down = (row as f32 + 0.5) / lattice.spacing;
            let upper = down as usize;
            let down = down - upper as f32;
            let between = [lattice.rows[upper], lattice.rows[upper + 1]];
            lattice.row(between, down, &mut line);

            for column in (0..width).step_by(LANES) {
                let start = row * width + column;
                let end = start + LANES.min(width - column);
                let pixels = Chunk { simd, stage, column, row: first + row };
                let ranges = simd.load(&lanes(&range[start..end], 0)).min(simd.splat(SKY));
                if has_blind && lattice.is_blind(between, column / stage.cell, (column + LANES) / stage.cell)
                {
                    pixels.by_rays(&mut light, start..end, ranges);
                } else {
                    let places = LatticeRow { lattice, profiles, line: &line, between, down };
                    pixels.by_lattice(&mut light, start..end, ranges, &places);
                }
            }
        }
    }
}

impl CloudLattice {
    /// Makes it that of so many rows of pixels.
    #[inline(always)]
    fn renew<V: Simd>(&mut self, simd: V, stage: &CloudStage<'_>, first: usize, rows: usize) {
        self.groups = ((stage.camera.width as usize).div_ceil(stage.cell) + 1).div_ceil(LANES);
        self.spacing = stage.cell as f32;
        self.blind.clear();
        self.direction.iter_mut().chain([&mut self.per_onset, &mut self.rate]).for_each(Vec::clear);
        let cells = rows.div_ceil(stage.cell);
        for row in 0..=cells {
            self.march(simd, stage, (first + row * stage.cell) as f64);
        }

        self.rows.clear();
        self.rows.extend(0..=cells);
        if stage.cell > 1 && self.flatness() > FLAT {
            for row in 0..cells {
                self.march(simd, stage, first as f64 + (row as f64 + 0.5) * stage.cell as f64);
            }
            // Those between follow in memory.
            self.rows.clear();
            self.rows.extend((0..=2 * cells).map(|row| row / 2 + row % 2 * (cells + 1)));
            self.spacing *= 0.5;
        }
    }

    /// Adds a row at a height of the screen, pixels.
    #[inline(always)]
    fn march<V: Simd>(&mut self, simd: V, stage: &CloudStage<'_>, height: f64) {
        let last = (stage.camera.width as usize).div_ceil(stage.cell);
        let first = self.blind.len();
        for column in 0..self.groups * LANES {
            let direction = stage.direction((column.min(last) * stage.cell) as f64, height);
            self.blind.push(direction.is_none());
            for (axis, target) in self.direction.iter_mut().enumerate() {
                target.push(direction.map_or(0.0, |direction| direction[axis]));
            }
        }

        for group in 0..self.groups {
            let mut direction = [simd.splat(0.0); 3];
            for (lanes_of, values) in direction.iter_mut().zip(&self.direction) {
                *lanes_of = simd.load(&lanes(values, first + group * LANES));
            }

            let rays = CloudRays::new(simd, &stage.cover, direction, simd.splat(SKY));
            let start = (first / LANES + group) * (PROFILE / LANES);
            let end = start + PROFILE / LANES;
            if self.profiles.len() < end {
                self.profiles.resize(end, Sixteen::default());
            }

            rays.march(simd, &stage.cover, &stage.air, Some(&mut self.profiles[start..end]));
            let Pace { per_onset, rate } = rays.pace;
            for (values, target) in [(per_onset, &mut self.per_onset), (rate, &mut self.rate)] {
                let mut stored = [0.0; LANES];
                values.store(&mut stored);
                target.extend(stored);
            }
        }
    }

    /// Mean difference of green light and transmittance of rays from the mean of those above and below.
    fn flatness(&self) -> f32 {
        let row = |row: usize| {
            let groups =
                &self.profiles[row * self.groups * PROFILE / LANES..][..self.groups * PROFILE / LANES];
            groups.chunks(PROFILE / LANES).flat_map(|profile| {
                let last = &profile[STEPS * VALUES..];
                last[1].0.into_iter().chain(last[VALUES - 1].0)
            })
        };
        let mut sum = 0.0;
        for middle in 1..self.rows.len() - 1 {
            let around = row(middle - 1).zip(row(middle + 1));
            sum += around
                .zip(row(middle))
                .map(|((above, below), own)| (0.5 * (above + below) - own).abs())
                .sum::<f32>();
        }
        sum / (2 * self.groups * LANES * self.rows.len().saturating_sub(2).max(1)) as f32
    }

    /// Directions, and what the last steps know, along a row of pixels that lies `down` the way from one row of the lattice to the next.
    #[inline(always)]
    fn row(&self, rows: [usize; 2], down: f32, line: &mut [Vec<f32>; 3 + VALUES]) {
        let width = self.groups * LANES;
        let between = |from: f32, to: f32| (to - from).mul_add(down, from);
        let profiles: &[f32] = bytemuck::cast_slice(&self.profiles);
        for (value, line) in line.iter_mut().enumerate() {
            line.clear();
            if let Some(direction) = self.direction.get(value) {
                let [from, to] = rows.map(|row| &direction[row * width..][..width]);
                line.extend(from.iter().zip(to).map(|(from, to)| between(*from, *to)));
                continue;
            }
            for group in 0..self.groups {
                let [from, to] = rows.map(|row| {
                    let at = (row * self.groups + group) * PROFILE;
                    &profiles[at + (STEPS * VALUES + value - 3) * LANES..][..LANES]
                });
                line.extend(from.iter().zip(to).map(|(from, to)| between(*from, *to)));
            }
        }
    }

    /// Whether the screen has no picture somewhere about these cells.
    fn is_blind(&self, rows: [usize; 2], from: usize, to: usize) -> bool {
        let width = self.groups * LANES;
        rows.into_iter()
            .any(|row| self.blind[row * width + from..row * width + (to + 2).min(width)].contains(&true))
    }
}

/// A row of pixels among the rays of the lattice.
struct LatticeRow<'l> {
    lattice: &'l CloudLattice,
    profiles: &'l [f32],
    line: &'l [Vec<f32>; 3 + VALUES],
    /// Starts of the lattice's rows above and below it, and the way from the one to the other.
    between: [usize; 2],
    down: f32,
}

/// Up to sixteen pixels.
struct Chunk<'s, 'c, V> {
    simd: V,
    stage: &'s CloudStage<'c>,
    column: usize,
    row: usize,
}

/// Pixels of a chunk by rays of their own.
struct OwnRays<'k, 's, 'c, 'p, V: Simd> {
    chunk: &'k Chunk<'s, 'c, V>,
    light: &'k mut Pixels<'p>,
    pixels: Range<usize>,
    range: V::F,
}

impl<V: Simd> Kernel for OwnRays<'_, '_, '_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.chunk.march(self.light, self.pixels, self.range);
    }
}

/// Pixels of a chunk behind the clouds that were found before them.
struct Veiling<'k, 's, 'c, 'p, V: Simd> {
    chunk: &'k Chunk<'s, 'c, V>,
    light: &'k mut Pixels<'p>,
    pixels: Range<usize>,
    veil: &'k CloudVeil<V>,
    direction: [V::F; 3],
    range: V::F,
    is_ground: V::M,
}

impl<V: Simd> Kernel for Veiling<'_, '_, '_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.veil();
    }
}

/// Clouds before pixels that end within the layer.
struct WithinLayer<'k, 'l, V: Simd> {
    simd: V,
    places: &'k LatticeRow<'l>,
    columns: [V::I; 2],
    across: V::F,
    gone: V::F,
}

impl<V: Simd> Kernel for WithinLayer<'_, '_, V> {
    type Output = CloudVeil<V>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> CloudVeil<V> {
        self.places.within(self.simd, self.columns, self.across, self.gone)
    }
}

impl<V: Simd> Chunk<'_, '_, V> {
    /// Pixels about which the lattice has no ray for all.
    #[inline(always)]
    fn by_rays(&self, light: &mut Pixels<'_>, pixels: Range<usize>, range: V::F) {
        self.simd.call(OwnRays { chunk: self, light, pixels, range });
    }

    #[inline(always)]
    fn march(&self, light: &mut Pixels<'_>, pixels: Range<usize>, range: V::F) {
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
        let mut rays = CloudRays::new(simd, &stage.cover, direction, range);
        rays.span = rays.span.select(simd.mask(seen), simd.splat(0.0));
        let veil = rays.march(simd, &stage.cover, &stage.air, None);
        let is_ground = range.lt(simd.splat(SKY)) & simd.mask(seen);
        simd.call(Veiling { chunk: self, light, pixels, veil: &veil, direction, range, is_ground });
    }

    #[inline(always)]
    fn by_lattice(&self, light: &mut Pixels<'_>, pixels: Range<usize>, range: V::F, places: &LatticeRow<'_>) {
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
        let rays = CloudRays::new(simd, &stage.cover, direction, simd.splat(SKY));
        let enters = rays.near.lt(range) & zero.lt(rays.span);
        let is_ground = range.lt(simd.splat(SKY));
        if !enters.any() && !is_ground.any() {
            return;
        }

        let mut veil: CloudVeil<V> = CloudVeil { light: [zero; 3], through: one };
        if enters.any() {
            for (value, line) in values.iter_mut().zip(places.line).skip(3) {
                let from = simd.gather(line, left);
                *value = (simd.gather(line, right) - from).mul_add(across, from);
            }

            let [.., red, green, blue, through] = values;
            let ends = enters & range.lt(rays.near + rays.span);
            veil = CloudVeil { light: [red, green, blue], through };
            if ends.any() {
                let gone = range - rays.near;
                let columns = [left, right];
                let within = simd.call(WithinLayer { simd, places, columns, across, gone });
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

        simd.call(Veiling { chunk: self, light, pixels, veil: &veil, direction, range, is_ground });
    }
}

impl<V: Simd> Veiling<'_, '_, '_, '_, V> {
    /// Writes pixels anew: ground in the shadow of clouds, and clouds before it.
    #[inline(always)]
    fn veil(self) {
        let Self { chunk: &Chunk { simd, stage, .. }, light, pixels, veil, direction, range, is_ground } =
            self;
        let one = simd.splat(1.0);
        let mut seen = light.load(simd, pixels.clone());
        let before = seen;

        if stage.cover.shadowed > 0.0 && is_ground.any() {
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
            light.store(simd, pixels, seen);
        }
    }
}

impl LatticeRow<'_> {
    /// Computes the veil before pixels that end within the layer, so many metres after their rays have entered it.
    #[inline(always)]
    fn within<V: Simd>(&self, simd: V, columns: [V::I; 2], across: V::F, gone: V::F) -> CloudVeil<V> {
        let zero = simd.splat(0.0);
        let mut corners = [[zero; 4]; VALUES];
        for corner in 0..4 {
            let row = self.between[corner / 2];
            let column = columns[corner % 2];
            let width = self.lattice.groups * LANES;
            let at = column + simd.splat_int((row * width) as i32);
            let per_onset = simd.gather(&self.lattice.per_onset, at);
            let pace: Pace<V> = Pace { per_onset, rate: simd.gather(&self.lattice.rate, at) };
            let steps = pace.steps(simd, gone);
            let whole = steps.floor().min(simd.splat((STEPS - 1) as f32));
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

        CloudVeil { light, through: bilinear::<V>(through, across, down) }
    }
}

/// Share of its light that ground keeps in the shadow of clouds; less of a shadow lies on ground that rises through the layer.
#[inline(always)]
fn lit<V: Simd>(simd: V, cover: &CloudCover<'_>, direction: [V::F; 3], range: V::F) -> V::F {
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let rise = direction[2] * range;
    let under = simd.splat(cover.heights[1]) - rise;
    let share = (under * simd.splat(cover.per_depth)).max(zero).min(one);
    let [east, north, up] = cover.shadows;
    let way = (simd.splat(cover.heights[0]) - rise).max(zero) * simd.splat(1.0 / up);
    let per_voxel = simd.splat(cover.per_voxel);
    let mut place = [way * simd.splat(east), way * simd.splat(north)];
    for (axis, place) in place.iter_mut().enumerate() {
        let at = direction[axis].mul_add(range, *place);
        *place = at.mul_add(per_voxel, simd.splat(cover.eye[axis]));
    }
    let through = shadow(simd, cover, place);
    one - share * (one - through) * simd.splat(cover.shadowed)
}
