//! What goes sixteen at a time, against the same one by one.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::column::{Fill, FreeRows, Haze, LinearTerm, PlanePassage, SpanCoverage};
use super::voxels::{Passed, PassedVoxel, PlaneCourse, VoxelVeil};
use super::walk::{VoxelStep, Walk};
use crate::simd::{Isa, Kernel, LANES, Simd, Sixteen};
use crate::voxel::BLOCK_SIDE;

struct Pass<'a> {
    course: PlaneCourse,
    corner: [i64; 2],
    tops: &'a [f32; 64],
    ends: [f64; 2],
    veil: VoxelVeil,
    passed: &'a mut Passed,
}

impl Kernel for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        self.course.pass(simd, self.corner, self.tops, self.ends, self.veil, self.passed);
    }
}

/// A plane over voxels of some heights: where the eye is, and how it runs.
#[derive(Debug, Clone)]
struct Scene {
    eye: [f64; 2],
    way: [f64; 2],
    depth: f64,
    tops: [f32; 64],
    veil: VoxelVeil,
}

fn scenes() -> impl Strategy<Value = Scene> {
    let eye = (select(vec![0.0, 400.0, 60_000.0]), 0.0..64.0_f64, 0.0..64.0_f64);
    let minor = (select(vec![0.0, 1.0, -1.0, 1.3, 1.0e-9]), prop_oneof![Just(1.0), 0.0..1.0_f64]);
    let major = (select(vec![1.0, -1.0]), any::<bool>());
    let tops = vec(select(vec![0.0_f32, 1000.0, 2000.0, 60_000.0]), 64);
    let veil = (-500.0..3000.0_f64, -20.0..20.0_f64);
    (eye, minor, major, 0.3..40.0_f64, tops, veil).prop_map(|(eye, minor, major, depth, tops, veil)| {
        let (far, x, y) = eye;
        let (minor, (major, is_along_x)) = (minor.0 * minor.1, major);
        Scene {
            eye: [far + x, far + y],
            way: if is_along_x { [major, minor] } else { [minor, major] },
            depth,
            tops: tops.try_into().unwrap_or([0.0; 64]),
            veil: VoxelVeil { base: veil.0, per_unit: veil.1 },
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn a_block_is_passed_as_voxel_by_voxel(scene in scenes()) {
        passes_as_voxel_by_voxel(&scene);
    }

    #[test]
    fn rows_are_filled_as_one_by_one(count in 1_usize..150, has_depths in any::<bool>(), fillings in vec(fillings(), 40)) {
        let places = |filling: &Filling| filling.places.map(|place| place * count as f32);
        let fillings: Vec<_> =
            fillings.iter().map(|filling| Filling { places: places(filling), ..*filling }).collect();
        fills_as_one_by_one(count, has_depths, &fillings);
    }
}

fn passes_as_voxel_by_voxel(scene: &Scene) {
    let Scene { eye, way, depth, tops, veil } = *scene;
    let course = PlaneCourse::new([eye, way], depth);
    for block in Walk::new(eye, way, f64::from(BLOCK_SIDE), [[0, 1 << 20]; 2], [1.0e-6, 60.0]) {
        let ends = [block.enter, block.leave];
        let corner = block.cell.map(|cell| cell * i64::from(BLOCK_SIDE));
        let inside = corner.map(|first| [first, first + i64::from(BLOCK_SIDE) - 1]);
        for isa in Isa::available() {
            let mut passed = Passed::default();
            isa.run(Pass { course, corner, tops: &tops, ends, veil, passed: &mut passed });
            let mut found = passed.voxels().peekable();
            for step in Walk::new(eye, way, 1.0, inside, ends) {
                let [column, row] = [0, 1].map(|axis| (step.cell[axis] - corner[axis]) as usize);
                let place = row * BLOCK_SIDE as usize + column;
                let voxel = found.next_if(|voxel| voxel.place == place);
                assert!(scene.is_as(&step, tops[place], voxel), "{isa}: {scene:?} {step:?} {voxel:?}");
            }
            assert!(found.next().is_none(), "{isa}: {scene:?} more than there is");
        }
    }
}

impl Scene {
    /// Whether what was found of a voxel with a height code is right: that it is passed over, or where it is entered and left.
    fn is_as(&self, step: &VoxelStep, top: f32, found: Option<PassedVoxel>) -> bool {
        let [along, across] = self.way.map(f64::abs);
        let climb = along.min(across) / along.max(across);

        // Where it crosses a border that it almost runs along is as uncertain as how far across it is.
        let near = 1.0e-5 + if climb > 0.0 { 1.0e-6 / climb } else { 0.0 };
        let ends = [step.enter, step.leave];
        let hidden = ends.map(|at| self.veil.base + self.veil.per_unit * at);
        let above = f64::from(top) - hidden[0].min(hidden[1]);
        let Some(found) = found else {
            // What is shorter than this may be passed or not.
            return top == 0.0 || above <= 0.01 || step.leave - step.enter <= 2.0 * near;
        };

        let is_near = |end: usize| {
            let told = f64::from(found.distances[end]);
            let exact =
                [0, 1].map(|axis| self.eye[axis] + self.way[axis] * ends[end] - step.cell[axis] as f64 - 0.5);
            let off = [0, 1].map(|axis| (f64::from(found.at[end][axis]) - exact[axis]).abs());
            (told - ends[end]).abs() < near
                && (f64::from(found.inverse[end]) * self.depth * told - 1.0).abs() < 1.0e-6
                && off[0].max(off[1]) < 2.0 * near
        };

        top > 0.0 && above > -0.01 && is_near(0) && is_near(1)
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
    column: &'a mut FreeRows,
    fillings: &'a [Filling],
    centres: &'a [Sixteen],
}

impl Kernel for Fills<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        for &Filling { places, light, inverse, opacity } in self.fillings {
            let passage =
                PlanePassage { inverse: [1.0; 2], top: [f32::INFINITY; 2], bottom: [f32::NEG_INFINITY; 2] };
            let clearness = (1.0 - opacity).log2();
            let haze = Haze { clearness, level: 0.0, tangents: [-1.0, 1.0], passage };
            let fill = Fill {
                haze: (opacity < 1.0).then_some(haze),
                inverse: LinearTerm::level(inverse),
                across: 3.0,
                bounds: [inverse; 2],
                front: 2.0,
            };
            self.column.fill(simd, places, [light, 2.0 * light, 0.0], &fill, self.centres);
        }
    }
}

/// Places as shares of all rows.
fn fillings() -> impl Strategy<Value = Filling> {
    let long = (select(vec![0.0005_f32, 0.004, 0.03, 0.3]), 0.0..1.0_f32);
    let opacity = select(vec![1.0_f32, 1.0, 0.3, 0.77]);
    (-0.05..1.0_f32, long, 0.0..1.0_f32, 0.0..1.0_f32, opacity).prop_map(
        |(from, long, light, inverse, opacity)| Filling {
            places: [from, from + long.0 * long.1],
            light,
            inverse,
            opacity,
        },
    )
}

fn fills_as_one_by_one(count: usize, has_depths: bool, fillings: &[Filling]) {
    let mut rows = vec![Row::default(); count];
    for filling in fillings {
        for (row, is) in rows.iter_mut().enumerate() {
            is.fill(row, filling, has_depths);
        }
    }

    let centres = vec![Sixteen::default(); count.div_ceil(LANES)];
    for isa in Isa::available() {
        let mut columns: [FreeRows; LANES] = Default::default();
        for column in &mut columns {
            column.begin(count, has_depths);
            isa.run(Fills { column, fillings, centres: &centres });
        }

        let mut cover = SpanCoverage::default();
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
            let case = format!("{isa}, row {row}: {is:?} {seen:?}");
            let expected = [is.light, 2.0 * is.light, 0.0, is.share, is.inverse];
            for (found, expected) in seen.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1.0e-4, "{case}");
            }
            assert!(!has_depths || (seen[5] - is.middle).abs() < 1.0e-6, "{case}");
            assert_eq!(column.is_full(row as f32, row as f32 + 1.0), is.full, "{case}");
        }

        assert_eq!(column.is_closed(), rows.iter().all(|row| row.full), "{isa}");
    }
}
