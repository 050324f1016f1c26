//! Noise in rows of voxels.

/// Gradient noise (Perlin 1985, 2002) that repeats after [`SIDE`] voxels eastward and northward; about −0.7…0.7.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    /// Voxels from corner to corner, a power of two.
    cell: usize,
    seed: u32,
}

impl Noise {
    /// Noise in cells of `cell` voxels, a power of two.
    pub fn new(cell: usize, seed: u32) -> Self {
        Self { cell, seed }
    }

    /// Adds `factor` times the noise of voxels along a row, `[SIDE]`, that lies `north` and `up` voxels from the first.
    ///
    /// Between the corners of two cells the products with their gradients change linearly along the row: what those of four corners above each other come to is
    /// found once for each cell.
    pub fn add(&self, factor: f32, north: f32, up: f32, row: &mut [f32]) {
        let cell = self.cell as f32;
        let wrap = (SIDE / self.cell) as i32 - 1;
        let [north, up] = [north, up].map(|place| place / cell);
        let base = [north.floor(), up.floor()];
        let away = [north - base[0], up - base[1]];
        let base = base.map(|base| base as i32);

        // The product at the corners' meridian, and what it grows by from cell to cell.
        let line = |column: i32| {
            let mut line = [0.0; 2];
            for [dy, dz] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let place = [column & wrap, (base[0] + dy) & wrap, base[1] + dz];
                let [x, y, z] = gradient(hash(place, self.seed));
                let of = |step: i32, share: f32| if step == 1 { fade(share) } else { 1.0 - fade(share) };
                let weight = of(dy, away[0]) * of(dz, away[1]);
                line[0] += weight * (y * (away[0] - dy as f32) + z * (away[1] - dz as f32));
                line[1] += weight * x;
            }
            line
        };

        let mut west = line(0);
        for (column, voxels) in row.chunks_mut(self.cell).enumerate() {
            let east = line(column as i32 + 1);
            for (step, voxel) in voxels.iter_mut().enumerate() {
                let share = step as f32 / cell;
                let [from, to] = [west[0] + west[1] * share, east[0] + east[1] * (share - 1.0)];
                *voxel += factor * lerp(from, to, fade(share));
            }
            west = east;
        }
    }
}

/// Perlin's improved curve.
fn fade(share: f32) -> f32 {
    share * share * share * (share * (share * 6.0 - 15.0) + 10.0)
}

/// One of the twelve directions to a cube's edges.
fn gradient(hash: u32) -> [f32; 3] {
    let sign = |bit: u32| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
    match hash % 3 {
        0 => [sign(8), sign(9), 0.0],
        1 => [0.0, sign(8), sign(9)],
        _ => [sign(9), 0.0, sign(8)],
    }
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

/// Voxels eastward and northward, a power of two: the layer repeats after them.
pub const SIDE: usize = 256;

pub fn lerp(from: f32, to: f32, share: f32) -> f32 {
    from + (to - from) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(noise: Noise, north: f32, up: f32) -> Vec<f32> {
        let mut row = vec![0.0; SIDE];
        noise.add(1.0, north, up, &mut row);
        row
    }

    #[test]
    fn noise_is_nothing_at_corners_and_the_product_with_gradients_beside_them() {
        let noise = Noise::new(8, 7);
        assert!(row(noise, 16.0, 24.0).iter().step_by(8).all(|value| *value == 0.0));
        // The eighth of a cell away from a corner its gradient counts nearly alone: ±1 along an axis, or none.
        let along: Vec<f32> =
            row(noise, 16.0, 24.0).iter().skip(1).step_by(8).map(|value| value * 8.0).collect();
        let near = |to: f32| along.iter().filter(|value| (*value - to).abs() < 0.13).count();
        assert_eq!(near(-1.0) + near(0.0) + near(1.0), SIDE / 8, "{along:?}");
        assert!(near(-1.0) > 4 && near(0.0) > 4 && near(1.0) > 4, "{along:?}");
    }

    #[test]
    fn noise_is_smooth_repeats_and_is_neither_high_nor_low() {
        let noise = Noise::new(8, 3);
        let rows: Vec<Vec<f32>> = (0..SIDE).map(|north| row(noise, north as f32, 5.5)).collect();
        assert_eq!(row(noise, SIDE as f32, 5.5), rows[0]);
        let mut sum = 0.0;
        for north in 0..SIDE {
            for east in 0..SIDE {
                let own = rows[north][east];
                let beside = [rows[(north + 1) % SIDE][east], rows[north][(east + 1) % SIDE]];
                assert!(own.abs() < 1.04 && beside.iter().all(|beside| (beside - own).abs() < 0.4));
                sum += own;
            }
        }
        assert!((sum / (SIDE * SIDE) as f32).abs() < 0.02, "{sum}");
        let above = row(noise, 40.0, 5.51);
        assert!(above.iter().zip(&rows[40]).all(|(above, own)| (above - own).abs() < 0.01));
    }
}
