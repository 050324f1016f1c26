//! Relief: the part of finer slopes that a coarse voxel keeps.
//!
//! Light on rough ground is not the light on its mean slope, and an eye near the ground sees more of what faces it.
//! So a coarse voxel keeps mean and covariance of the slopes of its finer posts (moments of slopes
//! for filtering: Olano and Baker, "LEAN mapping", I3D 2010). Light is then that on four slopes with just
//! this mean and covariance:
//!
//! ```text
//! mean        = slopes of the level's own heights + correction
//! covariance  = L·Lᵀ,  L = | a 0 |      spread = (a, b, c)
//!                          | b c |
//! four slopes = mean ± √2·(a, b),  mean ± √2·(0, c)
//! ```
//!
//! The correction, not the mean, is what is rounded: on smooth ground it vanishes, and no contour lines show.

use crate::simd::{Each, Floats, Ints, LANES, Simd};

/// Steps of a correction per unit of slope.
const CORRECTION_STEPS: f32 = 128.0;
/// Steps of a spread per unit of slope.
const SPREAD_STEPS: f32 = 32.0;

/// Slopes of the next finer posts under a voxel, against those of its own level's heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Relief {
    /// Mean slope eastward and northward less the level's own, 1/128, up to one.
    pub correction: [i8; 2],
    /// `a`, `b` and `c` of the covariance's root, 1/32; the first and the last are not negative.
    pub spread: [i8; 3],
}

impl Relief {
    /// Sums up the finer slopes that `moments` has gathered, `own` being those of the level; nothing where there are none.
    pub fn new(moments: &Moments, own: [f32; 2]) -> Self {
        if moments.count == 0 {
            return Self::default();
        }
        let count = moments.count as f64;
        let mean = moments.sum.map(|sum| sum as f64 / count);
        let [xx, xy, yy] = moments.products.map(|sum| sum as f64 / count);
        let variance = [xx - mean[0] * mean[0], yy - mean[1] * mean[1]].map(|variance| variance.max(0.0));
        let a = variance[0].sqrt();
        let b = if a > 0.0 { (xy - mean[0] * mean[1]) / a } else { 0.0 };
        let c = (variance[1] - b * b).max(0.0).sqrt();
        let code = |slope: f32, steps: f32| (slope * steps).round().clamp(-127.0, 127.0) as i8;
        let mean = mean.map(|mean| (mean * moments.step) as f32);
        Self {
            correction: [0, 1].map(|axis| code(mean[axis] - own[axis], CORRECTION_STEPS)),
            spread: [a, b, c].map(|root| code((root * moments.step) as f32, SPREAD_STEPS)),
        }
    }
}

/// The highest byte of each lane, signed.
#[inline(always)]
fn highest<V: Simd>(_: V, lanes: V::I) -> V::F {
    lanes.sar::<24>().to_float()
}

/// Bytes of sixteen reliefs.
const RELIEFS: usize = LANES * size_of::<Relief>();

/// Reliefs of sixteen voxels.
#[derive(Debug, Clone, Copy)]
pub struct ReliefLanes<F> {
    /// Mean slope eastward and northward less the level's own.
    correction: [F; 2],
    /// `a`, `b` and `c` of the covariance's root, times √2: slopes.
    spread: [F; 3],
}

impl<F: Floats> ReliefLanes<F> {
    /// Loads relief from memory.
    #[inline(always)]
    pub fn load<V: Simd<F = F>>(simd: V, bytes: &[u8; RELIEFS]) -> Self {
        let [four, fifth] = simd.load_fives(bytes);
        let correction = simd.splat(1.0 / CORRECTION_STEPS);
        let spread = simd.splat(std::f32::consts::SQRT_2 / SPREAD_STEPS);
        Self {
            correction: [
                highest(simd, four.shl::<24>()) * correction,
                highest(simd, four.shl::<16>()) * correction,
            ],
            spread: [
                highest(simd, four.shl::<8>()) * spread,
                highest(simd, four) * spread,
                highest(simd, fifth.shl::<24>()) * spread,
            ],
        }
    }

    /// Mean slopes eastward and northward of the finer posts, `own` being those of the level.
    #[inline(always)]
    pub fn mean(&self, own: [F; 2]) -> [F; 2] {
        [own[0] + self.correction[0], own[1] + self.correction[1]]
    }

    /// Four slopes with such a mean, and the covariance of the finer posts'.
    #[inline(always)]
    pub fn slopes(&self, [x, y]: [F; 2]) -> [[F; 2]; 4] {
        let [a, b, c] = self.spread;
        [[x + a, y + b], [x - a, y - b], [x, y + c], [x, y - c]]
    }
}

/// Slopes of finer posts, gathered.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moments {
    /// Slope of one unit of `sum`.
    pub step: f64,
    count: i64,
    sum: [i64; 2],
    /// Sums of the products east × east, east × north, north × north.
    products: [i64; 3],
}

impl Moments {
    /// None yet; slopes will come in units of `step`.
    pub fn new(step: f64) -> Self {
        Self { step, ..Self::default() }
    }

    /// Counts posts that have a surface; slopes that are not zero must be [added](Self::add), one post after the other.
    #[inline(always)]
    pub fn count(&mut self, posts: usize) {
        self.count += posts as i64;
    }

    /// The slopes of a counted post eastward and northward.
    #[inline(always)]
    pub fn add(&mut self, [east, north]: [i32; 2]) {
        let [east, north] = [i64::from(east), i64::from(north)];
        self.sum = [self.sum[0] + east, self.sum[1] + north];
        let [xx, xy, yy] = self.products;
        self.products = [xx + east * east, xy + east * north, yy + north * north];
    }
}

/// Half steps of height per post from central differences; one-sided, and so twice, where one neighbour has no surface, 0 where
/// none has or there is none `here`.
#[inline(always)]
pub fn half_steps(here: u16, behind: u16, ahead: u16) -> i32 {
    let known = |code: u16| if code == super::HeightCode::EMPTY { here } else { code };
    let one_sided = behind == super::HeightCode::EMPTY || ahead == super::HeightCode::EMPTY;
    let rise = i32::from(known(ahead)) - i32::from(known(behind));
    let rise = if one_sided { 2 * rise } else { rise };
    if here == super::HeightCode::EMPTY { 0 } else { rise }
}

/// The same for sixteen posts.
#[inline(always)]
pub fn half_steps_of<V: Simd>(simd: V, here: V::I, behind: V::I, ahead: V::I) -> V::I {
    let empty = simd.splat_int(i32::from(super::HeightCode::EMPTY));
    let beside = [behind, ahead].each(|code| code.eq(empty));
    let rise = here.select(beside[1], ahead) - here.select(beside[0], behind);
    let rise = (rise + rise).select(beside[0] | beside[1], rise);
    simd.splat_int(0).select(here.eq(empty), rise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel};

    /// The four slopes of a relief in each lane.
    struct Four {
        relief: Relief,
        own: [f32; 2],
    }

    impl Kernel for Four {
        type Output = [[f32; 2]; 4];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let reliefs = [self.relief; LANES];
            let relief = ReliefLanes::load(simd, bytemuck::cast_slice(&reliefs).first_chunk().unwrap());
            let mean = relief.mean(self.own.map(|slope| simd.splat(slope)));
            relief.slopes(mean).map(|slopes| slopes.map(|slope| slope.least()))
        }
    }

    struct HalfSteps([[i32; LANES]; 3]);

    impl Kernel for HalfSteps {
        type Output = [i32; LANES];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let [here, behind, ahead] = self.0.map(|codes| simd.load_ints(&codes));
            let mut steps = [0; LANES];
            half_steps_of(simd, here, behind, ahead).store(&mut steps);
            steps
        }
    }

    #[test]
    fn four_slopes_have_the_mean_and_the_covariance() {
        let posts: Vec<[i32; 2]> = (0..16).map(|k| [(k * 37) % 23 - 9, (k * 53) % 31 - 11 + k]).collect();
        let mut moments = Moments::new(0.02);
        moments.count(posts.len());
        posts.iter().for_each(|slopes| moments.add(*slopes));
        let own = [0.3, -0.1];
        let four = Isa::best().run(Four { relief: Relief::new(&moments, own), own });
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let moment = |slopes: &[[f64; 2]], axes: [usize; 2]| {
            let [a, b] = axes.map(|axis| slopes.iter().map(|s| s[axis]).collect::<Vec<_>>());
            let products: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a * b).collect();
            (mean(&a), mean(&products) - mean(&a) * mean(&b))
        };
        let posts: Vec<[f64; 2]> = posts.iter().map(|slopes| slopes.map(|s| f64::from(s) * 0.02)).collect();
        let four: Vec<[f64; 2]> = four.iter().map(|slopes| slopes.map(f64::from)).collect();

        for axes in [[0, 0], [0, 1], [1, 1]] {
            let ((mean, covariance), (found, spread)) = (moment(&posts, axes), moment(&four, axes));
            assert!((mean - found).abs() < 0.005, "{mean} {found}");
            assert!((covariance - spread).abs() < 0.02, "{axes:?}: {covariance} {spread}");
        }
    }

    #[test]
    fn slopes_beside_voids_are_one_sided() {
        assert_eq!(half_steps(10, 8, 13), 5);
        assert_eq!(half_steps(10, 0, 13), 6);
        assert_eq!(half_steps(10, 8, 0), 4);
        assert_eq!(half_steps(10, 0, 0), 0);
        assert_eq!(half_steps(0, 8, 13), 0);
    }

    #[test]
    fn sixteen_posts_have_the_half_steps_of_each() {
        let codes = [0_u16, 1, 8, 10, 65535];
        let each: Vec<_> =
            (0..125).map(|case| [codes[case % 5], codes[case / 5 % 5], codes[case / 25]]).collect();
        for some in each.chunks(LANES) {
            let lane = |lane: usize| some[lane % some.len()];
            let planes = [0, 1, 2].map(|part: usize| std::array::from_fn(|at| i32::from(lane(at)[part])));
            let wanted = std::array::from_fn(|at| half_steps(lane(at)[0], lane(at)[1], lane(at)[2]));
            for isa in Isa::available() {
                assert_eq!(isa.run(HalfSteps(planes)), wanted, "{isa}");
            }
        }
    }

    #[test]
    fn no_slopes_are_no_relief() {
        assert_eq!(Relief::new(&Moments::new(1.0), [1.0, 2.0]), Relief::default());
    }
}
