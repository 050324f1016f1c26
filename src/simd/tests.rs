//! Every set against the portable one, operation by operation.

use super::*;

/// All operations on a pair of lanes.
struct Everything<'a> {
    a: [f32; LANES],
    b: [f32; LANES],
    bits: u16,
    table: &'a [u16],
}

impl Kernel for Everything<'_> {
    /// (results that are equal in every set, results that are nearly so, answers about all lanes)
    type Output = (Vec<[i32; LANES]>, Vec<[f32; LANES]>, Vec<i32>, [u8; 3 * LANES]);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let (a, b, mask) = (simd.load(&self.a), simd.load(&self.b), simd.mask(self.bits));
        let words: Vec<u32> = self.table.iter().map(|&x| u32::from(x) * 65_537).collect();
        let floats: Vec<f32> = self.table.iter().map(|&x| f32::from(x)).collect();
        let (i, j) = (a.floor().to_int(), b.floor().to_int());
        let (m, n) = (a.lt(b), a.le(b));
        let mut kept = [7.0; LANES];
        a.store_masked(mask, &mut kept);
        let pairs = simd.gather_word_pairs(&words, i);
        let index = (i & simd.splat_int(31)).min(simd.splat_int(30));
        let near = self.table.first_chunk().map(|near| simd.permute_pairs(near, index));
        let bytes: Vec<u8> = self.table.iter().flat_map(|x| x.to_le_bytes()).collect();
        let loaded = self.table.first_chunk().map(|shorts| simd.load_shorts(shorts));
        let mut shorts = [0; LANES];
        (i & simd.splat_int(0xffff)).store_shorts(&mut shorts);
        let triples_loaded = bytes[1..].first_chunk().map(|triples| simd.load_triples(triples));
        let fives_loaded = bytes.last_chunk().map(|fives| simd.load_fives(fives));

        let equal = [a + b, a - b, a * b, a / b, a.min(b), a.max(b), a.abs(), a.abs().sqrt(), a.floor()]
            .map(Floats::to_bits)
            .into_iter()
            .chain(
                [i.to_float(), a.select(mask, b), simd.gather(&floats, i), simd.load(&kept)]
                    .map(Floats::to_bits),
            )
            .chain(simd.permute_neighbours(a, b, index).map(Floats::to_bits))
            .chain([pairs.0, pairs.1])
            .chain(near)
            .chain([simd.load_shorts(&shorts)])
            .chain(loaded.into_iter().chain(triples_loaded).chain(fives_loaded.into_iter().flatten()))
            .chain([a.abs().to_int(), (a * simd.splat(70_000.0)).floor().to_int()])
            .chain([
                i,
                i + j,
                i - j,
                i.mul(j),
                i.dot_halves(j),
                i & j,
                i | j,
                i.shr::<3>(),
                i.sar::<3>(),
                i.shl::<5>(),
                i.min(j),
                i.max(j),
            ])
            .chain([i.select(m & mask, j), simd.gather_words(&words, i), simd.gather_pairs(self.table, i)])
            .map(|lanes| {
                let mut out = [0; LANES];
                lanes.store(&mut out);
                out
            })
            .collect();

        let positive = a.abs() + simd.splat(0.5);
        let near = [a.mul_add(b, a), a.neg_mul_add(b, a), positive.recip(), positive.rsqrt()]
            .map(|lanes| {
                let mut out = [0.0; LANES];
                lanes.store(&mut out);
                out
            })
            .to_vec();

        let bits = [m, n, m | mask, !m, i.eq(j), i.gt(j)].map(|mask| i32::from(mask.bits()));
        let answers = [m.any(), m.all(), (m | !m).all(), (m & !m).any()].map(i32::from);
        let mut triples = [0; 3 * LANES];
        simd.store_triples(i.mul(j), &mut triples);
        let rough = positive.sqrt_rough() * positive.sqrt_rough() * positive.recip();
        let rough = (rough - simd.splat(1.0)).abs().le(simd.splat(2.2e-4)).all();
        let answers = [&answers[..], &[i32::from(rough)]].concat();
        let ends = [a.least(), b.greatest()].map(|end| end.to_bits() as i32);

        (equal, near, [&bits[..], &answers, &ends, &[i.least(mask), i.least(m & !m)]].concat(), triples)
    }
}

#[test]
fn all_sets_agree_with_the_portable_one() {
    let table: Vec<u16> = (0..40_u16).map(|x| x.wrapping_mul(7919)).collect();
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ((state >> 40) as f32 / (1 << 24) as f32 - 0.3) * 60.0
    };

    for case in 0..200 {
        let a = std::array::from_fn(|_| random());
        let b = std::array::from_fn(|lane| if lane == case % LANES { a[lane] } else { random() });
        let bits = (random() * 1000.0) as i32 as u16;
        let run = |isa: Isa| isa.run(Everything { a, b, bits, table: &table });
        let expected = run(Isa::PORTABLE);

        for isa in Isa::available() {
            let found = run(isa);
            assert_eq!(found.0, expected.0, "{isa}");
            assert_eq!((found.2, found.3), (expected.2.clone(), expected.3), "{isa}");
            for (found, expected) in found.1.iter().flatten().zip(expected.1.iter().flatten()) {
                assert!(
                    (found - expected).abs() <= 3e-6 * expected.abs().max(60.0),
                    "{isa}: {found} {expected}"
                );
            }
        }
    }
}

/// Smaller and larger ones of pairs, as bits.
struct Ends([f32; LANES], [f32; LANES]);

impl Kernel for Ends {
    type Output = [[i32; LANES]; 2];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let (a, b) = (simd.load(&self.0), simd.load(&self.1));
        [a.min(b), a.max(b)].each(|end| {
            let mut bits = [0; LANES];
            end.to_bits().store(&mut bits);
            bits
        })
    }
}

#[test]
fn the_second_is_taken_where_neither_is_smaller() {
    let values = [f32::NAN, 0.0, -0.0, f32::INFINITY];
    let (a, b) = (std::array::from_fn(|lane| values[lane / 4]), std::array::from_fn(|lane| values[lane % 4]));
    let expected = Isa::PORTABLE.run(Ends(a, b));
    assert_eq!(expected[0][..4], values.map(|value| value.to_bits() as i32));
    for isa in Isa::available() {
        assert_eq!(isa.run(Ends(a, b)), expected, "{isa}");
    }
}

/// Reciprocals, those of roots, and rough roots.
struct Approximations([f32; LANES]);

impl Kernel for Approximations {
    type Output = [[f32; LANES]; 3];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let x = simd.load(&self.0);
        [x.recip(), x.rsqrt(), x.sqrt_rough()].each(|lanes| {
            let mut out = [0.0; LANES];
            lanes.store(&mut out);
            out
        })
    }
}

#[test]
fn approximations_are_within_their_bounds() {
    for isa in Isa::available() {
        for step in 0..4096_u32 {
            // Two octaves, as roots differ between odd ones and even ones, and far ones among them.
            let exponent = [0x3f00_0000, 0x0f00_0000, 0x6f00_0000][step as usize % 3];
            let lanes = std::array::from_fn(|lane| {
                f32::from_bits(exponent + (step * 16 + lane as u32) * 256 + step % 251)
            });
            let [reciprocals, inverse_roots, roots] = isa.run(Approximations(lanes));
            for lane in 0..LANES {
                let x = f64::from(lanes[lane]);
                let off = |found: f32, exact: f64| (f64::from(found) / exact - 1.0).abs();
                assert!(off(reciprocals[lane], x.recip()) < 4e-7, "{isa}: 1/{x}");
                assert!(off(inverse_roots[lane], x.sqrt().recip()) < 4e-7, "{isa}: 1/√{x}");
                assert!(off(roots[lane], x.sqrt()) < 1e-4, "{isa}: √{x}");
            }
        }
    }
}

#[test]
fn sets_are_named() {
    for isa in Isa::available() {
        assert_eq!(isa.name().parse(), Ok(isa));
    }
    assert!("mmx".parse::<Isa>().unwrap_err().contains("portable"));
}
