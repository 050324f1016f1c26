//! What goes sixteen at a time, against the same one by one.

use super::column::{Column, Cover, Fill, Haze, Line, Passage};
use super::voxels::{Course, Passed, Veil};
use super::walk::Walk;
use crate::simd::{Isa, Kernel, LANES, Simd, Sixteen};
use crate::voxel::BLOCK_SIDE;

/// Numbers from 0 to 1 that follow no pattern (a linear congruential generator; Knuth, *The Art of Computer Programming* 2, 1997, 3.3.4).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn one_of<T: Copy>(&mut self, choice: &[T]) -> T {
        choice[(self.next() * choice.len() as f64) as usize]
    }
}

struct Pass<'a> {
    course: Course,
    corner: [i64; 2],
    tops: &'a [f32; 64],
    ends: [f64; 2],
    veil: Veil,
    passed: &'a mut Passed,
}

impl Kernel for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        self.course.pass(simd, (self.corner, self.tops), self.ends, self.veil, self.passed);
    }
}

#[test]
fn a_block_is_passed_as_voxel_by_voxel() {
    let side = f64::from(BLOCK_SIDE);
    let mut chance = Chance(1);
    for _ in 0..1500 {
        let far = chance.one_of(&[0.0, 0.0, 400.0, 60_000.0]);
        let eye = [0, 1].map(|_| far + chance.between(0.0, 64.0));
        let share = chance.next();
        let minor = chance.one_of(&[0.0, 1.0, -1.0, 1.3, 1.0e-9]) * chance.one_of(&[1.0, share]);
        let major = chance.one_of(&[1.0, -1.0]);
        let way = chance.one_of(&[[major, minor], [minor, major]]);
        let depth = chance.between(0.3, 40.0);
        let course = Course::new([eye, way], depth);
        let tops: [f32; 64] = std::array::from_fn(|_| chance.one_of(&[0.0, 1000.0, 2000.0, 60_000.0]));
        // Where it crosses a border that it almost runs along is as uncertain as how far across it is.
        let climb = way[0].abs().min(way[1].abs()) / way[0].abs().max(way[1].abs());
        let near = 1.0e-5 + if climb > 0.0 { 1.0e-6 / climb } else { 0.0 };
        let veil = Veil { base: chance.between(-500.0, 3000.0), per_unit: chance.between(-20.0, 20.0) };
        let limits = [[0, 1 << 20]; 2];
        for block in Walk::new(eye, way, side, limits, [1.0e-6, 60.0]) {
            let ends = [block.enter, block.leave];
            let corner = block.cell.map(|cell| cell * i64::from(BLOCK_SIDE));
            for isa in Isa::available() {
                let mut passed = Passed::default();
                isa.run(Pass { course, corner, tops: &tops, ends, veil, passed: &mut passed });
                let mut found = passed.voxels().peekable();
                let inside = corner.map(|first| [first, first + i64::from(BLOCK_SIDE) - 1]);
                for step in Walk::new(eye, way, 1.0, inside, ends) {
                    let cell = [0, 1].map(|axis| (step.cell[axis] - corner[axis]) as usize);
                    let place = cell[1] * BLOCK_SIDE as usize + cell[0];
                    let case = format!("{isa}: {eye:?} {way:?} {step:?}");
                    // What is shorter than this may be passed or not.
                    let is_long = step.leave - step.enter > 2.0 * near;
                    let hidden = [step.enter, step.leave]
                        .map(|at| veil.base + veil.per_unit * at)
                        .map(|code| code as f32);
                    let rises = tops[place] > 0.0 && tops[place] > hidden[0].min(hidden[1]) + 0.01;
                    let Some(passage) = found.next_if(|passage| passage.place == place) else {
                        assert!(!(is_long && rises), "{case} is missing");
                        continue;
                    };
                    assert!(tops[place] > hidden[0].min(hidden[1]) - 0.01, "{case} is hidden");
                    for (end, at) in [step.enter, step.leave].into_iter().enumerate() {
                        let off = f64::from(passage.distances[end]) - at;
                        assert!(off.abs() < near, "{case}: {end} is off by {off}");
                        let inverse = 1.0 / (depth * f64::from(passage.distances[end]));
                        assert!((f64::from(passage.inverse[end]) / inverse - 1.0).abs() < 1.0e-6, "{case}");
                        for axis in 0..2 {
                            let exact = eye[axis] + way[axis] * at - step.cell[axis] as f64 - 0.5;
                            let off = f64::from(passage.at[end][axis]) - exact;
                            assert!(off.abs() < 2.0 * near, "{case}: {end} on {axis} is off by {off}");
                        }
                    }
                }
                assert!(found.next().is_none(), "{isa}: {eye:?} {way:?} more than there is");
            }
        }
    }
}

/// A row of a column, one by one.
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

/// What fills rows: places, light, inverse depth, and share of light that is hidden.
#[derive(Debug, Clone, Copy)]
struct Filling {
    places: [f32; 2],
    light: f32,
    inverse: f32,
    opacity: f32,
}

impl Row {
    fn fill(&mut self, row: usize, filling: &Filling, has_depths: bool) {
        let [from, to] = filling.places.map(|place| (place - row as f32).clamp(0.0, 1.0));
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
    column: &'a mut Column,
    fillings: &'a [Filling],
    centres: &'a [Sixteen],
}

impl Kernel for Fills<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        for &Filling { places, light, inverse, opacity } in self.fillings {
            let passage =
                Passage { inverse: [1.0; 2], top: [f32::INFINITY; 2], bottom: [f32::NEG_INFINITY; 2] };
            let clearness = (1.0 - opacity).log2();
            let haze = Haze { clearness, level: 0.0, tangents: [-1.0, 1.0], passage };
            let fill = Fill {
                haze: (opacity < 1.0).then_some(haze),
                inverse: Line::level(inverse),
                across: 3.0,
                bounds: [inverse; 2],
                front: 2.0,
            };
            self.column.fill(simd, places, [light, 2.0 * light, 0.0], &fill, self.centres);
        }
    }
}

#[test]
fn rows_are_filled_as_one_by_one() {
    let mut chance = Chance(2);
    for round in 0..400 {
        let count = chance.between(1.0, 150.0) as usize;
        let has_depths = round % 2 == 0;
        let fillings: Vec<_> = (0..40)
            .map(|_| {
                let from = chance.between(-5.0, count as f64);
                let long = chance.one_of(&[0.05, 0.4, 3.0, 30.0]) * chance.next();
                Filling {
                    places: [from, from + long].map(|place| place as f32),
                    light: chance.next() as f32,
                    inverse: chance.next() as f32,
                    opacity: chance.one_of(&[1.0, 1.0, 0.3, 0.77]),
                }
            })
            .collect();
        let mut rows = vec![Row::default(); count];
        for filling in &fillings {
            for (row, is) in rows.iter_mut().enumerate() {
                is.fill(row, filling, has_depths);
            }
        }
        let centres = vec![Sixteen::default(); count.div_ceil(LANES)];
        for isa in Isa::available() {
            let mut columns: [Column; LANES] = Default::default();
            for column in &mut columns {
                column.begin(count, has_depths);
                isa.run(Fills { column, fillings: &fillings, centres: &centres });
            }
            let mut cover = Cover::default();
            cover.clear();
            cover.take(&columns);
            let mut seen = vec![[0.0; 6]; count];
            for (row, elements) in cover.rows() {
                for lane in 1..LANES {
                    assert!(elements.iter().all(|element| element.0[lane] == element.0[0]), "{isa}: {lane}");
                }
                seen[row] = std::array::from_fn(|element| elements[element].0[0]);
            }
            let column = &columns[0];
            for (row, (is, seen)) in rows.iter().zip(seen).enumerate() {
                let case = format!("{isa}, round {round}, row {row}: {is:?} {seen:?}");
                let expected = [is.light, 2.0 * is.light, 0.0, is.share, is.inverse];
                for (found, expected) in seen.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1.0e-4, "{case}");
                }
                assert!(!has_depths || (seen[5] - is.middle).abs() < 1.0e-6, "{case}");
                assert_eq!(column.is_full(row as f32, row as f32 + 1.0), is.full, "{case}");
            }
            assert_eq!(column.is_closed(), rows.iter().all(|row| row.full), "{isa}, round {round}");
        }
    }
}
