//! The voxels of a layer of clouds.
//!
//! ```text
//! cover(x, y)      = gradient noise of two octaves, less its quantile that leaves the coverage
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

fn densities(clouds: &Clouds, voxel: f64) -> Vec<f32> {
    let seed = clouds.seed;
    let place = |index: usize| [(index % SIDE) as f32, (index / SIDE) as f32];
    let cover: Vec<f32> = (0..SIDE * SIDE)
        .map(|index| {
            let [x, y] = place(index);
            noise([x, y, 0.0], PER_CLOUD, seed) + 0.5 * noise([x, y, 0.0], 0.5 * PER_CLOUD, seed ^ 0x51)
        })
        .collect();
    let mut sorted = cover.clone();
    sorted.sort_by(f32::total_cmp);
    let coverage = clouds.coverage as f32;
    let clear = (1.0 - coverage) * (sorted.len() - 1) as f32;
    let threshold = sorted[clear as usize];
    // Where clouds are closing no thin places are left.
    let closed = 1.2 * smooth((coverage - 0.75) / 0.25);
    let few = (20.0 * coverage).min(1.0);
    let rise = ((clouds.top - clouds.base) / voxel) as f32 / (LAYERS - 1) as f32;
    let mut densities = Vec::with_capacity(LAYERS * SIDE * SIDE);
    for layer in 0..LAYERS {
        let height = layer as f32 / (LAYERS - 1) as f32;
        let edges = smooth(height / 0.15) * smooth((1.0 - height) / 0.15);
        for (index, cover) in cover.iter().enumerate() {
            let [x, y] = place(index);
            let at = [x, y, layer as f32 * rise];
            let body = 3.2 * (cover - threshold) + closed;
            if edges == 0.0 || body < -1.0 {
                densities.push(0.0);
                continue;
            }
            let finer = noise(at, 8.0, seed ^ 0xa3) + 0.6 * noise(at, 4.0, seed ^ 0xb7);
            let body = body + (0.5 + 0.6 * height) * finer - 1.1 * height * height;
            densities.push(few * edges * (2.0 * body).clamp(0.0, 1.0));
        }
    }
    densities
}

/// Light of the sun in each voxel, 0…1, and at the base.
fn lights(densities: &[f32], clouds: &Clouds, voxel: f64, sun: Sun) -> (Vec<f32>, Vec<f32>) {
    let to_sun = toward(sun);
    let rise = (clouds.top - clouds.base) as f32 / (LAYERS - 1) as f32;
    let step = [to_sun.x, to_sun.y].map(|along| rise * along / to_sun.z / voxel as f32);
    let way = extinction(clouds) * rise / to_sun.z;
    let plane = SIDE * SIDE;
    let mut depth = vec![0.0_f32; plane];
    let mut lights = vec![1.0; densities.len()];
    for layer in (0..LAYERS - 1).rev() {
        let (own, above) = (&densities[layer * plane..][..plane], &densities[(layer + 1) * plane..][..plane]);
        depth = (0..plane)
            .map(|index| {
                let at = [(index % SIDE) as f32 + step[0], (index / SIDE) as f32 + step[1]];
                bilinear(&depth, at) + 0.5 * way * (own[index] + bilinear(above, at))
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
    let wrap = |place: f32| (place as i64).rem_euclid(SIDE as i64) as usize;
    let columns = [wrap(left), (wrap(left) + 1) % SIDE];
    let rows = [wrap(low), (wrap(low) + 1) % SIDE].map(|row| row * SIDE);
    let along = rows.map(|row| lerp(plane[row + columns[0]], plane[row + columns[1]], x - left));
    lerp(along[0], along[1], y - low)
}

/// Gradient noise (Perlin 1985, 2002) in cells of `cell` voxels that repeats after [`SIDE`] of them eastward and northward; about −0.7…0.7.
fn noise(place: [f32; 3], cell: f32, seed: u32) -> f32 {
    let period = (SIDE as f32 / cell) as i32;
    let at = place.map(|place| place / cell);
    let base = at.map(f32::floor);
    let share = [at[0] - base[0], at[1] - base[1], at[2] - base[2]];
    let corner = |dx: i32, dy: i32, dz: i32| {
        let [x, y, z] = base.map(|base| base as i32);
        let index = [(x + dx).rem_euclid(period), (y + dy).rem_euclid(period), z + dz];
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
