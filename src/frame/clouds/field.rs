//! The voxels of a layer of clouds.
//!
//! ```text
//! cover(x, y)      = gradient noise of two octaves, less the threshold that leaves the coverage
//! density(x, y, z) = cover + finer noise − a dome's height², between a flat base and the top
//! depth to the sun = that of the voxel above, where its ray comes from, and the way between      from the top down
//! ```

use glam::{DVec2, Vec3};

use crate::scene::Clouds;
use crate::sunlight::Sun;

/// Voxels eastward and northward, a power of two: the layer repeats after them.
pub const SIDE: usize = 256;

/// Heights at which densities stand, from the base to the top.
pub const LAYERS: usize = 16;

/// Levels: voxels of the next one are twice as wide, means of four.
pub const LEVELS: usize = 5;

/// Words in a row of the finest level: the first one again at the end, as in every level.
pub const ROW: usize = SIDE + 1;

/// Where each level's words begin.
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
const PER_CLOUD: f32 = 16.0;

/// Least sine of the elevation that light is followed along: rays of a lower sun would leap from voxel to voxel.
pub const LOWEST_SUN: f32 = 0.15;

/// Parts, at most, of the sun's way from layer to layer.
const MOST_PARTS: usize = 16;

/// Light in a cloud: what comes straight, and what has been scattered forward often (its share, and the share of extinction that it suffers).
const SCATTERED: [f32; 2] = [0.45, 0.15];

/// Densities of a layer and the light in it.
#[derive(Debug)]
pub struct Field {
    /// Level by level `[LAYERS − 1][side][side + 1]`, east along rows, north from row to row: density there and one layer higher, then light there and one layer
    /// higher, 8 bits each from the lowest, 255 for 1.
    pub words: Vec<u32>,
    /// Share of sunlight that comes down to the base, `[SIDE][ROW]`.
    pub shadow: Vec<f32>,
    /// Metres per voxel, eastward and northward.
    pub voxel: f64,
}

impl Field {
    /// The layer that `clouds` describe, with light of `sun` in it.
    pub fn new(clouds: &Clouds, sun: Sun) -> Self {
        let voxel = clouds.scale / f64::from(PER_CLOUD);
        let densities = densities(clouds, voxel);
        Self::of(&densities, clouds, voxel, sun)
    }

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

    /// Where a place (metres) lies among the voxels, when wind has blown for so many seconds: 0…`SIDE`.
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

/// What densities follow from.
struct Shapes<'c> {
    clouds: &'c Clouds,
    /// Layers' depth, voxels.
    rise: f32,
    /// How cloudy each place is, `[SIDE][SIDE]`.
    cover: Vec<f32>,
    /// What all places have besides: where clouds are closing no thin places are left.
    closed: f32,
    /// Less than 1 where hardly a cloud is left.
    few: f32,
}

/// Bound of [`noise`].
const MOST_NOISE: f32 = 1.04;

impl<'c> Shapes<'c> {
    fn new(clouds: &'c Clouds, voxel: f64) -> Self {
        let coverage = clouds.coverage as f32;
        let cover = |index: usize| {
            let place = [(index % SIDE) as f32, (index / SIDE) as f32, 0.0];
            noise(place, PER_CLOUD, clouds.seed) + 0.5 * noise(place, 0.5 * PER_CLOUD, clouds.seed ^ 0x51)
        };
        Self {
            clouds,
            rise: ((clouds.top - clouds.base) / voxel) as f32 / (LAYERS - 1) as f32,
            cover: (0..SIDE * SIDE).map(cover).collect(),
            closed: 1.2 * smooth((coverage - 0.75) / 0.25),
            few: (20.0 * coverage).min(1.0),
        }
    }

    /// What finer noise and the dome add to a voxel.
    fn detail(&self, index: usize, layer: usize) -> f32 {
        let seed = self.clouds.seed;
        let at = [(index % SIDE) as f32, (index / SIDE) as f32, layer as f32 * self.rise];
        let finer = noise(at, 8.0, seed ^ 0xa3) + 0.6 * noise(at, 4.0, seed ^ 0xb7);
        finer * finer_share(layer) - dome(layer)
    }

    /// Density of a voxel if there are clouds where the cover is above about a threshold.
    fn density(&self, index: usize, layer: usize, detail: f32, threshold: f32) -> f32 {
        let body = self.body(index, threshold) + detail;
        self.few * edges(layer) * (2.0 * body).clamp(0.0, 1.0)
    }

    fn body(&self, index: usize, threshold: f32) -> f32 {
        3.2 * (self.cover[index] - threshold) + self.closed
    }

    /// The threshold that leaves as much of the sky covered as was asked for, found by halving on a part of the columns. A column covers where less than half of light
    /// from the zenith comes through, or, of clouds too thin for that, where a quarter of the depth is dense.
    fn threshold(&self) -> f32 {
        let covers =
            (std::f32::consts::LN_2 / extinction(self.clouds) / (self.clouds.top - self.clouds.base) as f32)
                .min(0.25);
        let columns: Vec<usize> = (0..SIDE * SIDE)
            .filter(|index| (index % SIDE).is_multiple_of(SAMPLED) && (index / SIDE).is_multiple_of(SAMPLED))
            .collect();
        let details: Vec<[f32; LAYERS]> =
            columns.iter().map(|&index| std::array::from_fn(|layer| self.detail(index, layer))).collect();
        let share = |threshold: f32| {
            let covered = columns.iter().zip(&details).filter(|(index, details)| {
                let dense = |(layer, detail): (usize, &f32)| self.density(**index, layer, *detail, threshold);
                let depth: f32 = details.iter().enumerate().map(dense).sum();
                self.few * covers * ((LAYERS - 1) as f32) < depth
            });
            covered.count() as f64 / columns.len() as f64
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
    for layer in 0..LAYERS {
        let most = 1.6 * MOST_NOISE * finer_share(layer) - dome(layer);
        densities.extend((0..SIDE * SIDE).map(|index| {
            if edges(layer) == 0.0 || shapes.body(index, threshold) + most <= 0.0 {
                return 0.0;
            }
            shapes.density(index, layer, shapes.detail(index, layer), threshold)
        }));
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
    let mut depth = vec![0.0_f32; plane];
    let mut lights = vec![1.0; densities.len()];
    for layer in (0..LAYERS - 1).rev() {
        let (own, above) = (&densities[layer * plane..][..plane], &densities[(layer + 1) * plane..][..plane]);
        depth = (0..plane)
            .map(|index| {
                let at = |share: f32| {
                    [(index % SIDE) as f32 + step[0] * share, (index / SIDE) as f32 + step[1] * share]
                };
                let between: f32 = (1..parts)
                    .map(|part| part as f32 / parts as f32)
                    .map(|share| lerp(bilinear(own, at(share)), bilinear(above, at(share)), share))
                    .sum();
                let ends = 0.5 * (own[index] + bilinear(above, at(1.0)));
                bilinear(&depth, at(1.0)) + way * (ends + between)
            })
            .collect();
        for (light, depth) in lights[layer * plane..].iter_mut().zip(&depth) {
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
    -super::super::atmosphere::VANISHING_CONTRAST.ln() / clouds.visibility as f32
}

/// Between four values of a plane that repeats.
fn bilinear(plane: &[f32], [x, y]: [f32; 2]) -> f32 {
    let (left, low) = (x.floor(), y.floor());
    let wrap = |place: f32| (place as i32 & (SIDE as i32 - 1)) as usize;
    let columns = [wrap(left), (wrap(left) + 1) % SIDE];
    let rows = [wrap(low), (wrap(low) + 1) % SIDE].map(|row| row * SIDE);
    let along = rows.map(|row| lerp(plane[row + columns[0]], plane[row + columns[1]], x - left));
    lerp(along[0], along[1], y - low)
}

/// Gradient noise (Perlin 1985, 2002) in cells of `cell` voxels, a power of two, that repeats after [`SIDE`] of them eastward and northward; about −0.7…0.7.
fn noise(place: [f32; 3], cell: f32, seed: u32) -> f32 {
    let period = (SIDE as f32 / cell) as i32;
    let at = place.map(|place| place / cell);
    let base = at.map(f32::floor);
    let share = [at[0] - base[0], at[1] - base[1], at[2] - base[2]];
    let corner = |dx: i32, dy: i32, dz: i32| {
        let [x, y, z] = base.map(|base| base as i32);
        let index = [(x + dx) & (period - 1), (y + dy) & (period - 1), z + dz];
        let away = [share[0] - dx as f32, share[1] - dy as f32, share[2] - dz as f32];
        slope(hash(index, seed), away)
    };
    let [x, y, z] = share.map(|share| share * share * share * (share * (share * 6.0 - 15.0) + 10.0));
    let edge = |dy, dz| lerp(corner(0, dy, dz), corner(1, dy, dz), x);
    let face = |dz| lerp(edge(0, dz), edge(1, dz), y);
    lerp(face(0), face(1), z)
}

/// Product with one of the twelve directions to a cube's edges.
fn slope(hash: u32, [x, y, z]: [f32; 3]) -> f32 {
    let (first, second) = match hash % 3 {
        0 => (x, y),
        1 => (y, z),
        _ => (z, x),
    };
    let sign = |bit: u32, value: f32| if hash >> bit & 1 == 0 { value } else { -value };
    sign(8, first) + sign(9, second)
}

/// Bits without order from a place (after the finaliser of MurmurHash3, Appleby 2008).
fn hash(place: [i32; 3], seed: u32) -> u32 {
    let mut bits = seed;
    for place in place {
        bits = bits.wrapping_add(place as u32).wrapping_mul(0x9e37_79b1);
        bits = (bits ^ bits >> 16).wrapping_mul(0x85eb_ca6b);
        bits = (bits ^ bits >> 13).wrapping_mul(0xc2b2_ae35);
        bits ^= bits >> 16;
    }
    bits
}

fn smooth(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

fn lerp(from: f32, to: f32, share: f32) -> f32 {
    from + (to - from) * share
}
