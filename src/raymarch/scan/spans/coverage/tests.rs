//! Coverage against rows that are filled plane by plane.

use proptest::array::uniform16;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::super::fill::{Fill, Haze, LinearTerm, PlanePassage};
use super::{FilledFace, SpanCoverage};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Simd, Sixteen};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn rows_are_filled_as_one_by_one(count in 1_usize..150, has_depths in any::<bool>(), fillings in vec(fillings(), 40)) {
        let places = |filling: &Filling| filling.places.map(|place| place.map(|place| place * count as f32));
        let fillings: Vec<_> =
            fillings.iter().map(|filling| Filling { places: places(filling), ..*filling }).collect();
        fills_as_one_by_one(count, has_depths, &fillings);
    }
}

/// A row of one plane.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    covered: u8,
    hidden: f32,
    clear: f32,
    light: f32,
    share: f32,
    inverse: f32,
    middle: f32,
    full: bool,
}

/// Filling of rows: places in each plane, light, inverse depth, and share of light that is hidden.
#[derive(Debug, Clone, Copy)]
struct Filling {
    planes: u16,
    places: [[f32; LANES]; 2],
    light: f32,
    inverse: f32,
    opacity: f32,
}

impl Row {
    fn fill(&mut self, row: usize, places: [f32; 2], filling: &Filling, has_depths: bool) {
        let [from, to] = places.map(|place| (place - row as f32).clamp(0.0, 1.0));
        if from >= to || self.full {
            return;
        }

        let [begin, end] = [from, to].map(|share| (share * 8.0 + 0.5) as u32);
        let bits = (((1_u32 << end) - (1 << begin)) as u8) & !self.covered;
        let is_narrow = begin == end;
        let share = match is_narrow {
            true if self.covered == u8::MAX => 0.0,
            true => to - from,
            false => bits.count_ones() as f32 / 8.0,
        };
        let left = 1.0 - self.clear;
        let weight = left * share * filling.opacity;
        self.light += weight * filling.light;
        self.share += weight;
        self.inverse += weight * filling.inverse;

        if from <= 0.5 && to > 0.5 && self.hidden < 0.5 {
            self.hidden += (1.0 - self.hidden) * filling.opacity;
            if self.hidden >= 0.5 {
                self.middle = filling.inverse;
            }
        }

        if filling.opacity >= 1.0 && !is_narrow {
            self.covered |= bits;
        } else {
            self.clear = 1.0 - left * (1.0 - share * filling.opacity);
        }

        if self.covered == u8::MAX || 1.0 - self.clear < 1.0 / 256.0 {
            self.clear = 1.0;
            self.full = !has_depths || self.hidden >= 0.5;
        }
    }
}

struct Fills<'a> {
    coverage: &'a mut SpanCoverage,
    fillings: &'a [Filling],
    centres: &'a [f32],
}

impl Kernel for Fills<'_> {
    type Output = ();

    fn run<V: Simd>(self, simd: V) {
        for &Filling { planes, places, light, inverse, opacity } in self.fillings {
            // Planes beside the filling hold no numbers: nothing of theirs may reach a row.
            let of_planes = |value: f32| simd.splat(value).select(simd.mask(planes), simd.splat(f32::NAN));
            let [high, low] = [f32::INFINITY, f32::NEG_INFINITY].map(|tangent| [simd.splat(tangent); 2]);
            let passage = PlanePassage { inverse: [simd.splat(1.0); 2], top: high, bottom: Some(low) };
            let haze = Haze {
                clearness: of_planes((1.0 - opacity).log2()),
                level: simd.splat(0.0),
                tangents: [simd.splat(-1.0), simd.splat(1.0)],
                passage,
            };

            let mut fill = Fill {
                light: [light, 2.0 * light, 0.0].map(of_planes),
                haze: (opacity < 1.0).then_some(haze),
                inverse: LinearTerm {
                    tangent: simd.splat(0.0),
                    value: of_planes(inverse),
                    slope: simd.splat(0.0),
                },
                across: of_planes(3.0),
                bounds: [of_planes(inverse); 2],
                front: of_planes(2.0),
            };
            fill.keep(simd, simd.mask(planes));

            let places =
                places.map(|places| simd.load(&places).select(simd.mask(planes), simd.splat(f32::NAN)));
            let rows = self.coverage.rows_between(simd, simd.mask(planes), places);
            if self.coverage.has_open(planes, rows.clone()) {
                self.coverage.fill(
                    simd,
                    planes,
                    rows,
                    places,
                    &FilledFace { fill: &fill, facade: None },
                    self.centres,
                );
            }
        }
    }
}

/// Lookup of the lowest row of each plane that is not hidden.
struct Lowest<'c>(&'c mut SpanCoverage);

impl Kernel for Lowest<'_> {
    type Output = [i32; LANES];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let mut lowest = [0; LANES];
        self.0.close_below(simd, simd.mask(u16::MAX), simd.splat(0.0)).store(&mut lowest);
        lowest
    }
}

/// Places as shares of all rows.
fn fillings() -> impl Strategy<Value = Filling> {
    let long = (select(vec![0.0005_f32, 0.004, 0.03, 0.3]), uniform16(0.0..1.0_f32));
    let opacity = select(vec![1.0_f32, 1.0, 0.3, 0.77]);
    let from = (-0.05..1.0_f32, select(vec![0.0, 0.01, 0.3_f32]), uniform16(-1.0..1.0_f32));
    (1..u16::MAX, from, long, 0.0..1.0_f32, 0.0..1.0_f32, opacity).prop_map(
        |(planes, (from, spread, shifts), (most, long), light, inverse, opacity)| {
            let low = shifts.map(|shift| from + spread * shift);
            let high = std::array::from_fn(|plane| low[plane] + most * long[plane]);
            Filling { planes, places: [low, high], light, inverse, opacity }
        },
    )
}

fn fills_as_one_by_one(count: usize, has_depths: bool, fillings: &[Filling]) {
    let mut rows = vec![[Row::default(); LANES]; count];
    for filling in fillings {
        for (row, planes) in rows.iter_mut().enumerate() {
            for plane in (0..LANES).filter(|plane| filling.planes >> plane & 1 != 0) {
                let places = filling.places.map(|places| places[plane]);
                planes[plane].fill(row, places, filling, has_depths);
            }
        }
    }

    let centres = vec![0.0; count];
    for isa in Isa::available() {
        let mut coverage = SpanCoverage::default();
        // The second time the memory holds rows of the first, which must not matter.
        for _ in 0..2 {
            coverage.begin(count, has_depths);
            isa.run(Fills { coverage: &mut coverage, fillings, centres: &centres });
        }

        let mut seen = vec![[Sixteen::default(); 6]; count];
        for (row, shown, middle) in coverage.rows() {
            let [red, green, blue] = shown.light;
            let middle = middle.map(|middle| middle.inverse).unwrap_or_default();
            seen[row] = [red, green, blue, shown.share, shown.inverse, middle];
        }

        for (row, (planes, seen)) in rows.iter().zip(seen).enumerate() {
            for (plane, is) in planes.iter().enumerate() {
                let seen = seen.map(|element| element.0[plane]);
                let case = format!("{isa}, row {row}, plane {plane}: {is:?} {seen:?}");
                let expected = [is.light, 2.0 * is.light, 0.0, is.share, is.inverse];
                for (found, expected) in seen.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1.0e-4, "{case}");
                }
                assert!(!has_depths || (seen[5] - is.middle).abs() < 1.0e-6, "{case}");
                assert_eq!(coverage.has_open(1 << plane, row..row + 1), !is.full, "{case}");
            }
        }

        let lowest = isa.run(Lowest(&mut coverage));
        for (plane, found) in lowest.into_iter().enumerate() {
            let lowest = rows.iter().position(|planes| !planes[plane].full).unwrap_or(count);
            assert_eq!(found as usize, lowest, "{isa}, plane {plane}");
        }
    }
}
