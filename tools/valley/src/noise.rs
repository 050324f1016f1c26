//! Seeded noise: gradient noise (Perlin, "An image synthesizer", 1985), its fractal sum, and tree crowns.
//!
//! Every octave is turned by an angle whose tangent is 3/4 and shifted, so that the lattices of two octaves
//! never line up and no direction of the grid shows. All arithmetic is `f64`: what is left of it after
//! quantisation is the same on every platform.

use glam::DVec2;

/// Well-mixed 64 bits of a lattice point (the finaliser of SplitMix64, Steele et al. 2014).
pub fn hash(x: i64, y: i64, seed: u64) -> u64 {
    let mut z = (x as u64)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .wrapping_add((y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F))
        .wrapping_add(seed.wrapping_mul(0x1656_67B1_9E37_79F9));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Uniform in 0 ≤ u < 1.
pub fn uniform(x: i64, y: i64, seed: u64) -> f64 {
    (hash(x, y, seed) >> 11) as f64 / (1u64 << 53) as f64
}

/// Gradient noise, about −1 … 1, features one unit wide.
pub fn gradient(x: f64, y: f64, seed: u64) -> f64 {
    let (fx, fy) = (x.floor(), y.floor());
    let (ix, iy) = (fx as i64, fy as i64);
    let (tx, ty) = (x - fx, y - fy);
    let corner = |i: i64, j: i64| {
        let h = hash(ix + i, iy + j, seed);
        let gx = f64::from((h & 0xFFFF) as u16) / 32768.0 - 1.0;
        let gy = f64::from((h >> 16 & 0xFFFF) as u16) / 32768.0 - 1.0;
        gx * (tx - i as f64) + gy * (ty - j as f64)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(tx), fade(ty));
    1.9 * mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
}

/// Fractal sum of `octaves` octaves, each half as wide and half as strong; about −1 … 1.
pub fn fractal(x: f64, y: f64, octaves: u32, seed: u64) -> f64 {
    octave_sum(x, y, octaves, seed, |value| value)
}

/// Fractal sum with sharp crests at 1 and broad valleys towards −1.
pub fn ridged(x: f64, y: f64, octaves: u32, seed: u64) -> f64 {
    octave_sum(x, y, octaves, seed, |value| 1.0 - 2.2 * value.abs())
}

fn octave_sum(mut x: f64, mut y: f64, octaves: u32, seed: u64, shape: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut amplitude, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..u64::from(octaves) {
        sum += amplitude * shape(gradient(x, y, seed + octave));
        total += amplitude;
        amplitude *= 0.5;
        (x, y) = (2.0 * (0.8 * x - 0.6 * y) + 17.3, 2.0 * (0.6 * x + 0.8 * y) - 9.1);
    }
    sum / total * 1.25
}

/// The crown of a tree above a place.
pub struct Crown {
    /// Height of the crown's surface, 0 (gap) … 1 (tallest tree's top).
    pub height: f64,
    /// Number of the tree, for its species and colour.
    pub tree: u64,
}

/// Canopy of trees about `spacing` metres apart: the highest of the domes around (x, y).
pub fn crown(x: f64, y: f64, spacing: f64, seed: u64) -> Crown {
    let (u, v) = ((0.8 * x - 0.6 * y) / spacing, (0.6 * x + 0.8 * y) / spacing);
    let (iu, iv) = (u.floor() as i64, v.floor() as i64);
    let mut best = Crown { height: 0.0, tree: 0 };
    for j in iv - 1..=iv + 1 {
        for i in iu - 1..=iu + 1 {
            let tree = hash(i, j, seed);
            let du = u - i as f64 - uniform(i, j, seed + 1);
            let dv = v - j as f64 - uniform(i, j, seed + 2);
            let radius = 0.55 + 0.4 * uniform(i, j, seed + 3);
            let inside = 1.0 - (du * du + dv * dv) / (radius * radius);
            let height = tallness(i, j, seed) * inside.max(0.0).sqrt();
            if height > best.height {
                best = Crown { height, tree };
            }
        }
    }
    best
}

fn tallness(i: i64, j: i64, seed: u64) -> f64 {
    0.62 + 0.38 * uniform(i, j, seed + 4)
}

/// The trees of [`crown`] no farther than `reach` from the origin: their place, height and number.
pub fn stems(spacing: f64, seed: u64, reach: f64) -> impl Iterator<Item = (f64, f64, Crown)> {
    let cells = (reach / spacing).ceil() as i64;
    (-cells..=cells).flat_map(move |i| (-cells..=cells).map(move |j| (i, j))).map(move |(i, j)| {
        let (u, v) = (i as f64 + uniform(i, j, seed + 1), j as f64 + uniform(i, j, seed + 2));
        let crown = Crown { height: tallness(i, j, seed), tree: hash(i, j, seed) };
        (spacing * (0.8 * u + 0.6 * v), spacing * (0.8 * v - 0.6 * u), crown)
    })
}

/// Linear blend.
pub fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Smooth step from 0 at `from` to 1 at `to` (which may be smaller).
pub fn smooth(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Smooth curve through knots (x, y) with rising x: cubic Hermite, tangents by central differences, constant beyond.
pub fn curve(knots: &[DVec2], x: f64) -> f64 {
    let last = knots.len() - 1;
    let k = knots.partition_point(|knot| knot.x <= x);
    if k == 0 {
        return knots[0].y;
    }
    if k > last {
        return knots[last].y;
    }

    let tangent = |i: usize| {
        let (a, b) = (knots[i.saturating_sub(1)], knots[(i + 1).min(last)]);
        (b.y - a.y) / (b.x - a.x)
    };
    let (a, b) = (knots[k - 1], knots[k]);
    let width = b.x - a.x;
    let t = (x - a.x) / width;
    let (t2, t3) = (t * t, t * t * t);

    (2.0 * t3 - 3.0 * t2 + 1.0) * a.y
        + (t3 - 2.0 * t2 + t) * width * tangent(k - 1)
        + (3.0 * t2 - 2.0 * t3) * b.y
        + (t3 - t2) * width * tangent(k)
}
