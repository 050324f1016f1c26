//! One octave of gradient noise (Perlin, "An image synthesizer", 1985), row by row.

/// Noise of one wavelength, a power of two.
pub struct Octave {
    log: u32,
    amplitude: f32,
    seed: u64,
    /// Shift of the lattice, so that those of two octaves do not line up.
    shift: u32,
    /// Weight of the far corner, by place in a cell.
    fade: Vec<f32>,
}

impl Octave {
    /// Wavelength 2^`log` posts, `amplitude` metres.
    pub fn new(log: u32, amplitude: f32, seed: u64) -> Self {
        let side = 1_u32 << log;
        let fade = |at: u32| {
            let t = f64::from(at) / f64::from(side);
            (t * t * t * (t * (t * 6.0 - 15.0) + 10.0)) as f32
        };
        let shift = hash(seed) as u32 & (side - 1);
        Self { log, amplitude, seed, shift, fade: (0..side).map(fade).collect() }
    }

    /// Posts from one wave to the next.
    pub fn wavelength(&self) -> u32 {
        1 << self.log
    }

    /// Adds the noise of row `y` at every `step`-th post from `x` on; two of them at least lie in a wave.
    pub fn add(&self, [x, y]: [u32; 2], step: u32, heights: &mut [f32]) {
        let (side, step) = (1_usize << self.log, step as usize);
        let y = y + self.shift;
        let (row, along) = (y >> self.log, y as usize & (side - 1));
        let (v, ty) = (self.fade[along], along as f32 / side as f32);
        let mut first = (self.shift + x) as usize;
        let mut done = 0;
        let mut west = self.edge(first as u32 >> self.log, row, ty, v);

        while done < heights.len() {
            let east = self.edge((first >> self.log) as u32 + 1, row, ty, v);
            let begin = first & (side - 1);
            let count = (side - begin).div_ceil(step).min(heights.len() - done);
            let scale = 1.0 / side as f32;
            let fades = self.fade[begin..].iter().step_by(step);

            for (index, (height, u)) in heights[done..done + count].iter_mut().zip(fades).enumerate() {
                let t = (begin + index * step) as f32 * scale;
                let near = west[0] + west[1] * t;
                let far = east[0] + east[1] * (t - 1.0);
                *height += near + (far - near) * u;
            }

            west = east;
            first += count * step;
            done += count;
        }
    }

    /// Returns, of the lattice line `column`, the noise between its corners of `row` and the next, and its slope across.
    fn edge(&self, column: u32, row: u32, ty: f32, v: f32) -> [f32; 2] {
        let corner = |row: u32, t: f32| {
            let mixed = hash(self.seed ^ u64::from(column) << 32 ^ u64::from(row));
            let part = |bits: u64| f32::from(bits as u16) / 32768.0 - 1.0;
            [part(mixed >> 16) * t, part(mixed)]
        };
        let (south, north) = (corner(row, ty), corner(row + 1, ty - 1.0));
        [0, 1].map(|index| self.amplitude * 1.9 * (south[index] + (north[index] - south[index]) * v))
    }
}

/// Well-mixed bits (the finaliser of SplitMix64: Steele, Lea and Flood, 2014).
fn hash(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
