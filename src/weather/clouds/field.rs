//! The voxels of a layer of clouds.
//!
//! ```text
//! cover(x, y)      = gradient noise of two octaves, less the threshold that leaves the coverage
//! density(x, y, z) = cover + finer noise − a dome's height², between a flat base and the top
//! depth to the sun = that of the voxel above, where its ray comes from, and the way between      from the top down
//! ```

use glam::{DVec2, Vec3};

use crate::sunlight::Sun;
use crate::weather::Clouds;
use crate::weather::clouds::noise::{Noise, SIDE, lerp};

/// Heights at which densities stand, from the base to the top.
pub const LAYERS: usize = 16;

/// Levels: voxels of the next one are twice as wide, means of four.
pub const LEVELS: usize = 5;

/// Words in a row of the finest level: the first one again at the end, as in every level.
pub const ROW: usize = SIDE + 1;

/// First word of each level.
pub const FIRST: [u32; LEVELS] = {
    let mut first = [0; LEVELS];
    let mut level = 1;
    while level < LEVELS {
        let side = SIDE >> (level - 1);
        first[level] = first[level - 1] + ((LAYERS - 1) * side * (side + 1)) as u32;
        level += 1;
    }
    first
};

/// Voxels from cloud to cloud.
const PER_CLOUD: usize = 16;

/// Least sine of the elevation that light is followed along: rays of a lower sun would leap from voxel to voxel.
pub const LOWEST_SUN: f32 = 0.15;

/// Parts, at most, of the sun's way from layer to layer.
const MOST_PARTS: usize = 16;

/// Light in a cloud: what comes straight, and what has been scattered forward often (its share, and the share of extinction that it suffers).
const SCATTERED: [f32; 2] = [0.45, 0.15];

/// Densities of a layer and the light in it.
#[derive(Debug)]
pub struct CloudField {
    /// Level by level `[LAYERS − 1][side][side + 1]`, east along rows, north from row to row: density there and one layer higher, then light there and one layer
    /// higher, 8 bits each from the lowest, 255 for 1.
    pub words: Vec<u32>,
    /// Share of sunlight that comes down to the base, `[SIDE][ROW]`.
    pub shadow: Vec<f32>,
    /// Metres per voxel, eastward and northward.
    pub voxel: f64,
}

/// Densities of a layer, which any sun may light.
#[derive(Debug)]
pub struct CloudDensities {
    /// Shares of the densest, 0…1, `[LAYERS][SIDE][SIDE]`.
    densities: Vec<f32>,
    /// Metres per voxel, eastward and northward.
    voxel: f64,
}

impl CloudDensities {
    /// The layer that `clouds` describe.
    pub fn new(clouds: &Clouds) -> Self {
        let voxel = clouds.scale / PER_CLOUD as f64;
        Self { densities: densities(clouds, voxel), voxel }
    }

    /// Returns the layer with light of `sun` in it.
    pub fn lit(&self, clouds: &Clouds, sun: Sun) -> CloudField {
        CloudField::of(&self.densities, clouds, self.voxel, sun)
    }
}

impl CloudField {
    /// A layer of `densities`, 0…1, `[LAYERS][SIDE][SIDE]`.
    pub fn of(densities: &[f32], clouds: &Clouds, voxel: f64, sun: Sun) -> Self {
        let (lights, shadow) = lights(densities, clouds, voxel, sun);
        let mut words = Vec::new();
        let mut level = [densities.to_vec(), lights];
        for side in (0..LEVELS).map(|level| SIDE >> level) {
            if side < SIDE {
                level = level.map(|values| coarser(&values, side));
            }
            pack(&level, side, &mut words);
        }
        let shadow = (0..SIDE)
            .flat_map(|row| (0..ROW).map(move |column| row * SIDE + column % SIDE))
            .map(|index| shadow[index]);
        Self { words, shadow: shadow.collect(), voxel }
    }

    /// Finds a place (metres) among the voxels, when wind has blown for so many seconds: 0…`SIDE`.
    pub fn place(&self, at: DVec2, clouds: &Clouds, seconds: f64) -> DVec2 {
        let still = at - DVec2::from_array(clouds.wind) * seconds;
        (still / self.voxel).map(|place| place.rem_euclid(SIDE as f64))
    }
}

/// Means of four voxels; the coarser level has `side` of them each way.
fn coarser(values: &[f32], side: usize) -> Vec<f32> {
    let fine = 2 * side;
    (0..LAYERS * side * side)
        .map(|index| {
            let first = 2 * (index / side) * fine + 2 * (index % side);
            let four = [first, first + 1, first + fine, first + fine + 1];
            0.25 * four.map(|place| values[place]).iter().sum::<f32>()
        })
        .collect()
}

/// Words of one level of densities and light.
fn pack([densities, lights]: &[Vec<f32>; 2], side: usize, words: &mut Vec<u32>) {
    let code = |value: f32| (255.0 * value + 0.5) as u32;
    for row in 0..(LAYERS - 1) * side {
        for column in 0..=side {
            let low = row * side + column % side;
            let high = low + side * side;
            let densities = code(densities[low]) | code(densities[high]) << 8;
            words.push(densities | code(lights[low]) << 16 | code(lights[high]) << 24);
        }
    }
}

/// Shapes that densities follow from.
struct Shapes<'c> {
    clouds: &'c Clouds,
    /// Cloudiness of each place, `[SIDE][SIDE]`.
    cover: Vec<f32>,
    /// Finer noise and the dome, added to a voxel, `[LAYERS][SIDE][SIDE]`.
    detail: Vec<f32>,
    /// Density added everywhere: where clouds are closing no thin places are left.
    closed: f32,
    /// Less than 1 where hardly a cloud is left.
    few: f32,
}

impl<'c> Shapes<'c> {
    fn new(clouds: &'c Clouds, voxel: f64) -> Self {
        let (coverage, seed) = (clouds.coverage as f32, clouds.seed);
        // Layers' depth, voxels.
        let rise = ((clouds.top - clouds.base) / voxel) as f32 / (LAYERS - 1) as f32;
        let noise = |cell: usize, salt: u32| Noise::new(cell, seed ^ salt);
        let mut cover = vec![0.0; SIDE * SIDE];
        for (row, cover) in cover.chunks_mut(SIDE).enumerate() {
            noise(PER_CLOUD, 0).add(1.0, row as f32, 0.0, cover);
            noise(PER_CLOUD / 2, 0x51).add(0.5, row as f32, 0.0, cover);
        }

        let mut detail = vec![0.0; LAYERS * SIDE * SIDE];
        for (row, detail) in detail.chunks_mut(SIDE).enumerate() {
            let (layer, row) = (row / SIDE, row % SIDE);
            let (share, up) = (finer_share(layer), layer as f32 * rise);
            detail.fill(-dome(layer));
            noise(8, 0xa3).add(share, row as f32, up, detail);
            noise(4, 0xb7).add(0.6 * share, row as f32, up, detail);
        }

        let (closed, few) = (1.2 * smooth((coverage - 0.75) / 0.25), (20.0 * coverage).min(1.0));
        Self { clouds, cover, detail, closed, few }
    }

    /// Density of a voxel, if there are clouds where the cover is above about a threshold; `edge` is the share that base and top leave to its layer.
    fn density(&self, edge: f32, [cover, detail]: [f32; 2], threshold: f32) -> f32 {
        let body = 3.2 * (cover - threshold) + self.closed + detail;
        self.few * edge * (2.0 * body).clamp(0.0, 1.0)
    }

    /// The threshold that leaves as much of the sky covered as was asked for, found by halving on a part of the columns. A column covers where less than half of light
    /// from the zenith comes through, or, of clouds too thin for that, where a quarter of the depth is dense.
    fn threshold(&self) -> f32 {
        let covers =
            (std::f32::consts::LN_2 / extinction(self.clouds) / (self.clouds.top - self.clouds.base) as f32)
                .min(0.25);
        let least = self.few * covers * (LAYERS - 1) as f32;
        let sampled = |plane: &[f32]| -> Vec<f32> {
            let rows = plane.chunks(SIDE).step_by(SAMPLED);
            rows.flat_map(|row| row.iter().step_by(SAMPLED)).copied().collect()
        };
        let cover = sampled(&self.cover);
        let details: Vec<_> = self.detail.chunks(SIDE * SIDE).map(sampled).collect();

        let share = |threshold: f32| {
            let mut depths = vec![0.0; cover.len()];
            for (layer, details) in details.iter().enumerate() {
                let edge = edges(layer);
                for (depth, (cover, detail)) in depths.iter_mut().zip(cover.iter().zip(details)) {
                    *depth += self.density(edge, [*cover, *detail], threshold);
                }
            }
            depths.iter().filter(|depth| least < **depth).count() as f64 / cover.len() as f64
        };

        let (mut low, mut high) = (-3.0, 3.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if share(middle) > self.clouds.coverage { low = middle } else { high = middle }
        }

        0.5 * (low + high)
    }
}

/// Every so many columns each way tell of the others, which are like them: noise has no finer cells than twice that.
const SAMPLED: usize = 2;

/// A threshold within 6·2⁻¹⁴.
const HALVINGS: usize = 14;

fn height(layer: usize) -> f32 {
    layer as f32 / (LAYERS - 1) as f32
}

/// Density fades towards base and top.
fn edges(layer: usize) -> f32 {
    smooth(height(layer) / 0.15) * smooth((1.0 - height(layer)) / 0.15)
}

fn finer_share(layer: usize) -> f32 {
    0.5 + 0.6 * height(layer)
}

fn dome(layer: usize) -> f32 {
    1.1 * height(layer) * height(layer)
}

fn densities(clouds: &Clouds, voxel: f64) -> Vec<f32> {
    let shapes = Shapes::new(clouds, voxel);
    let threshold = shapes.threshold();
    let mut densities = Vec::with_capacity(LAYERS * SIDE * SIDE);
    for (layer, details) in shapes.detail.chunks(SIDE * SIDE).enumerate() {
        let (edge, places) = (edges(layer), shapes.cover.iter().zip(details));
        densities.extend(places.map(|(cover, detail)| shapes.density(edge, [*cover, *detail], threshold)));
    }
    densities
}

/// Light of the sun in each voxel, 0…1, and at the base.
fn lights(densities: &[f32], clouds: &Clouds, voxel: f64, sun: Sun) -> (Vec<f32>, Vec<f32>) {
    let to_sun = toward(sun);
    let rise = (clouds.top - clouds.base) as f32 / (LAYERS - 1) as f32;
    let step = [to_sun.x, to_sun.y].map(|along| rise * along / to_sun.z / voxel as f32);

    // Under a low sun rays pass several voxels from layer to layer; what they leap over would leave the others' light in combs.
    let parts = (step[0].hypot(step[1]).ceil() as usize).clamp(1, MOST_PARTS);
    let way = extinction(clouds) * rise / to_sun.z / parts as f32;
    let plane = SIDE * SIDE;
    let shifts: Vec<_> = (1..=parts)
        .map(|part| part as f32 / parts as f32)
        .map(|share| (share, Shift::new(step, share)))
        .collect();
    let (from_above, between) =
        shifts.split_last().map_or((Shift::new(step, 1.0), &[][..]), |(last, all)| (last.1, all));
    let mut depth = vec![0.0_f32; plane];
    let mut lights = vec![1.0; densities.len()];

    for layer in (0..LAYERS - 1).rev() {
        let (own, above) = (&densities[layer * plane..][..plane], &densities[(layer + 1) * plane..][..plane]);
        depth = (0..plane)
            .map(|index| {
                let of_part = |(share, shift): &(f32, Shift)| {
                    lerp(shift.at(own, index), shift.at(above, index), *share)
                };
                let between: f32 = between.iter().map(of_part).sum();
                let ends = 0.5 * (own[index] + from_above.at(above, index));
                from_above.at(&depth, index) + way * (ends + between)
            })
            .collect();

        for (light, depth) in
            lights[layer * plane..].iter_mut().zip(&depth).filter(|(_, depth)| **depth > 0.0)
        {
            let [share, slow] = SCATTERED;
            *light = (1.0 - share) * (-depth).exp() + share * (-slow * depth).exp();
        }
    }

    (lights, depth.into_iter().map(|depth| (-depth).exp()).collect())
}

/// Direction along which light comes, from a sun that is not lower than [`LOWEST_SUN`].
pub fn toward(sun: Sun) -> Vec3 {
    let direction = sun.direction();
    direction.with_z(direction.z.max(LOWEST_SUN))
}

/// Extinction where clouds are densest, 1/metres.
pub fn extinction(clouds: &Clouds) -> f32 {
    -crate::weather::fog::VANISHING_CONTRAST.ln() / clouds.visibility as f32
}

/// A way across a plane of voxels that repeats.
#[derive(Debug, Clone, Copy)]
struct Shift {
    whole: [usize; 2],
    share: [f32; 2],
}

impl Shift {
    /// A `share` of `step`, voxels.
    fn new(step: [f32; 2], share: f32) -> Self {
        let way = step.map(|step| step * share);
        let whole = way.map(f32::floor);
        let share = [way[0] - whole[0], way[1] - whole[1]];
        Self { whole: whole.map(|whole| (whole as i32).rem_euclid(SIDE as i32) as usize), share }
    }

    /// Between the four values about where the way from a voxel ends.
    fn at(&self, plane: &[f32], index: usize) -> f32 {
        let [east, north] = [index % SIDE + self.whole[0], index / SIDE + self.whole[1]];
        let value = |east: usize, north: usize| plane[(north % SIDE) * SIDE + east % SIDE];
        let along =
            [north, north + 1].map(|north| lerp(value(east, north), value(east + 1, north), self.share[0]));
        lerp(along[0], along[1], self.share[1])
    }
}

fn smooth(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
