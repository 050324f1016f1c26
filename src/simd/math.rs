//! Functions of sixteen lanes.

use super::{Floats, Ints, Mask, Simd};

/// `e^−x` for x ≥ 0; relative error below 10⁻⁵, 0 from 87 on.
#[inline(always)]
pub fn exp_neg<V: Simd>(simd: V, x: V::F) -> V::F {
    // 2^−y of y = x·log₂e: the integer part goes to the exponent, a polynomial (least maximal error over
    // 0…1) takes the rest.
    let exponent = simd.splat(0.0) - x.min(simd.splat(87.0)) * simd.splat(std::f32::consts::LOG2_E);
    let whole = exponent.floor();
    let part = exponent - whole;
    let mut power = simd.splat(0.013_676_53);
    for coefficient in [0.051_666_88, 0.241_710_26, 0.692_931_3, 1.000_007_3] {
        power = power.mul_add(part, simd.splat(coefficient));
    }
    let scale = (whole.to_int() + simd.splat_int(127)).shl::<23>().as_floats();
    power * scale
}

/// Logarithm to the base 2 of x from 1 to 10³⁸, within 1.5·10⁻⁵; 0 for 1.
#[inline(always)]
pub fn log2<V: Simd>(simd: V, x: V::F) -> V::F {
    let bits = x.to_bits();
    let whole = (bits.shr::<23>() - simd.splat_int(127)).to_float();
    let part = ((bits & simd.splat_int(0x007f_ffff)) | simd.splat_int(0x3f80_0000)).as_floats();
    let part = part - simd.splat(1.0);
    // log₂(1 + y)/y over 0…1, interpolated at Chebyshev's points.
    let mut slope = simd.splat(-0.033_822_046);
    for coefficient in [0.144_471_1, -0.301_638, 0.468_658_9, -0.720_358_8, 1.442_681_5] {
        slope = slope.mul_add(part, simd.splat(coefficient));
    }
    slope.mul_add(part, whole)
}

/// 1.055·r^(5/6) − 0.055 for r from √0.0031308 to 1, from the highest power down (least maximal error, by linear programming).
const CURVE: [f32; 8] =
    [1.844_119, -7.558_081_8, 12.844_325, -11.813_048, 6.528_417, -2.425_803_4, 1.623_925_7, -0.043_782_97];

/// Root of the light up to which the sRGB curve is straight.
const ROOT_OF_TOE: f32 = 0.055_953_55;

/// 8-bit sRGB codes (0…255) of linear light ≥ 0 of which `one` is displayed as 255; what is brighter is clamped. Off by
/// one where the exact value lies within 0.04 of the middle between two codes.
#[inline(always)]
pub fn srgb8<V: Simd>(simd: V, linear: V::F, one: f32) -> V::I {
    let linear = linear.min(simd.splat(one));
    // Of no particular value for 0, which the toe takes.
    let curve = srgb8_curve(simd, linear.sqrt_rough() * simd.splat(1.0 / one.sqrt()));
    let toe = linear.mul_add(simd.splat(12.92 * 255.0 / one), simd.splat(0.5));
    toe.select(linear.lt(simd.splat(0.003_130_8 * one)), curve).to_int()
}

/// 8-bit sRGB codes of roots of linear light ≥ 0, of which 1 is displayed as 255; else as [`srgb8`].
#[inline(always)]
pub fn srgb8_of_roots<V: Simd>(simd: V, roots: [V::F; 3]) -> [V::I; 3] {
    let [red, green, blue] = roots;
    // The toe is for what is all but black, which few pixels are.
    let is_dark = red.min(green).min(blue).lt(simd.splat(ROOT_OF_TOE)).any();
    let mut codes = [simd.splat_int(0); 3];
    for (channel, code) in codes.iter_mut().enumerate() {
        let root = roots[channel].min(simd.splat(1.0));
        let mut shown = srgb8_curve(simd, root);
        if is_dark {
            let toe = (root * root).mul_add(simd.splat(12.92 * 255.0), simd.splat(0.5));
            shown = toe.select(root.lt(simd.splat(ROOT_OF_TOE)), shown);
        }
        *code = shown.to_int();
    }
    codes
}

/// 255 · (1.055·r^(5/6) − 0.055) + ½ for roots of light from √0.0031308 to 1, within 0.02.
#[inline(always)]
fn srgb8_curve<V: Simd>(simd: V, root: V::F) -> V::F {
    let mut curve = simd.splat(CURVE[0] * 255.0);
    for coefficient in &CURVE[1..7] {
        curve = curve.mul_add(root, simd.splat(coefficient * 255.0));
    }
    curve.mul_add(root, simd.splat(CURVE[7] * 255.0 + 0.5))
}

/// Angle of (x, y) against the x axis, −π…π radians, within 5·10⁻⁷, small ones within 10⁻⁶ of themselves; (0, 0) has
/// no particular one.
///
/// Arc tangent of 0…1 after Abramowitz and Stegun, *Handbook of Mathematical Functions* (1964), 4.4.49.
#[inline(always)]
pub fn atan2<V: Simd>(simd: V, y: V::F, x: V::F) -> V::F {
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let (across, along) = (y.abs(), x.abs());
    let steep = along.lt(across);
    let (less, more) = (across.min(along), across.max(along));
    let tangent = less * more.max(simd.splat(f32::MIN_POSITIVE)).recip();
    let square = tangent * tangent;
    let mut series = simd.splat(0.002_866_225_7);
    for coefficient in
        [-0.016_165_737, 0.042_909_614, -0.075_289_64, 0.106_562_64, -0.142_089, 0.199_935_51, -0.333_331_46]
    {
        series = series.mul_add(square, simd.splat(coefficient));
    }
    let angle = series.mul_add(square, one) * tangent;
    let angle = (simd.splat(std::f32::consts::FRAC_PI_2) - angle).select(steep, angle);
    let angle = (simd.splat(std::f32::consts::PI) - angle).select(x.lt(zero), angle);
    (zero - angle).select(y.lt(zero), angle)
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, Kernel, LANES};
    use super::*;

    struct All([f32; LANES]);

    impl Kernel for All {
        type Output = ([f32; LANES], [[i32; LANES]; 2]);

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let x = simd.load(&self.0);
            let (mut exp, mut codes) = ([0.0; LANES], [[0; LANES]; 2]);
            exp_neg(simd, x).store(&mut exp);
            srgb8(simd, x * simd.splat(3.0e13), 3.0e13).store(&mut codes[0]);
            srgb8_of_roots(simd, [x.sqrt(); 3])[2].store(&mut codes[1]);
            (exp, codes)
        }
    }

    #[test]
    fn functions_are_within_their_bounds() {
        for isa in Isa::available() {
            for step in 0..4000 {
                let lanes = std::array::from_fn(|lane| (step * LANES + lane) as f32 * 1.6e-5);
                let (exp, codes) = isa.run(All(lanes));
                for lane in 0..LANES {
                    let x = lanes[lane];
                    assert!((exp[lane] / (-x).exp() - 1.0).abs() < 1e-5, "{isa}: e^-{x}");
                    // A code that is right for a value a little off.
                    let curve = if x < 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
                    for code in codes.map(|codes| codes[lane]) {
                        let off = (curve.min(1.0) * 255.0 - code as f32).abs();
                        assert!(off < 0.54, "{isa}: {x}: {code} is off by {off}");
                    }
                }
            }
            let (far, _) = isa.run(All([60.0; LANES]));
            assert!((far[0] / (-60.0_f32).exp() - 1.0).abs() < 1e-5);
            assert_eq!(isa.run(All([f32::INFINITY; LANES])).0[0], isa.run(All([87.0; LANES])).0[0]);
            assert_eq!(isa.run(All([7.5; LANES])).1.map(|codes| codes[0]), [255; 2]);
        }
    }

    struct Logarithm([f32; LANES]);

    impl Kernel for Logarithm {
        type Output = [f32; LANES];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let mut logarithms = [0.0; LANES];
            log2(simd, simd.load(&self.0)).store(&mut logarithms);
            logarithms
        }
    }

    #[test]
    fn logarithms_are_within_their_bounds() {
        for isa in Isa::available() {
            for step in 0..2000 {
                let lanes = std::array::from_fn(|lane| 1.003_f32.powi(step * LANES as i32 + lane as i32));
                let lanes = lanes.map(|value: f32| value.min(1.0e38));
                for (value, found) in lanes.into_iter().zip(isa.run(Logarithm(lanes))) {
                    let exact = f64::from(value).log2();
                    assert!((f64::from(found) - exact).abs() < 1.5e-5, "{isa}: {value}: {found} {exact}");
                }
            }
            assert_eq!(isa.run(Logarithm([1.0; LANES]))[0], 0.0);
        }
    }

    struct Angle([f32; LANES], [f32; LANES]);

    impl Kernel for Angle {
        type Output = [f32; LANES];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let mut angles = [0.0; LANES];
            atan2(simd, simd.load(&self.0), simd.load(&self.1)).store(&mut angles);
            angles
        }
    }

    #[test]
    fn angles_are_within_their_bounds() {
        for isa in Isa::available() {
            for step in 0..2000_u32 {
                let turn =
                    |lane: usize| f64::from(step * 16 + lane as u32) * std::f64::consts::TAU / 32_000.0;
                let y = std::array::from_fn(|lane| (turn(lane).sin() * 0.7) as f32);
                let x = std::array::from_fn(|lane| (turn(lane).cos() * 0.7) as f32);
                for (lane, found) in isa.run(Angle(y, x)).into_iter().enumerate() {
                    let exact = f64::from(y[lane]).atan2(f64::from(x[lane]));
                    let wrong = (f64::from(found) - exact).abs();
                    // Both ends of −π…π are one direction.
                    let wrong = wrong.min((wrong - std::f64::consts::TAU).abs());
                    assert!(wrong < 5e-7, "{isa}: {} {}: {found} {exact}", y[lane], x[lane]);
                }
            }
            // Small angles have small errors: narrow views need them.
            let small = isa.run(Angle([1.0e-4; LANES], [1.0; LANES]))[0];
            assert!((small / 1.0e-4 - 1.0).abs() < 1e-6, "{isa}: {small}");
        }
    }
}
