//! What sixteen planes do at a time, against planes one by one.

use glam::DVec2;
use proptest::array::uniform16;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::horizon::FloatingHorizon;
use super::order::{MetSpan, next_of};
use super::packet::{BlockPassage, CellExtent, PlanePacket, VoxelPassage};
use crate::raymarch::scan::{NO_SLOPE, PlaneGroup, Post, Profile, SampleLine};
use crate::simd::{Floats, Isa, Kernel, LANES, Mask, Simd};
use crate::voxel::{BLOCK_SIDE, Grid, Span};

const SIDE: i64 = BLOCK_SIDE as i64;

/// A voxel that a plane crosses, and the major distances at which it enters and leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Crossed {
    voxel: [i64; 2],
    distances: [f64; 2],
    /// Places there from the voxel's centre, of what was found sixteen at a time.
    ends: [[f32; 2]; 2],
}

impl Crossed {
    fn is_shorter(&self, than: f64) -> bool {
        self.distances[1] - self.distances[0] <= than
    }
}

/// Planes over an area, and where the eye is.
#[derive(Debug, Clone)]
struct Scene {
    grid: Grid,
    eye: DVec2,
    group: PlaneGroup,
    until: f64,
}

fn scenes() -> impl Strategy<Value = Scene> {
    let eye = (select(vec![0.0, 8.0, 40.0, 61_000.0]), -20.0..90.0_f64, -20.0..90.0_f64);
    let azimuth = (select(vec![0.0, 0.25, 0.5, 0.75, 0.125]), prop_oneof![Just(0.0), -0.12..0.12_f64]);
    let width = select(vec![1.0e-4, 0.001, 0.01, 0.03]);
    (eye, azimuth, width, 0.5..90.0_f64).prop_map(|((far, x, y), (quarter, turn), width, until)| {
        let grid = Grid { nx: 61_060, ny: 61_050, spacing: 2.5, origin: DVec2::ZERO };
        let middle = (quarter + turn) * std::f64::consts::TAU;
        let directions = std::array::from_fn(|lane| DVec2::from_angle(middle + width * (8.0 - lane as f64)));
        let eye = DVec2::new(far + x, far + y);
        Scene { grid, eye, group: PlaneGroup::new(&grid, eye, &directions, 0.0), until }
    })
}

impl Scene {
    /// Voxels that a plane crosses, from near to far.
    fn crossed(&self, plane: usize) -> Vec<Crossed> {
        let way = self.group.way(plane);
        let [enter, leave] = self.group.over.map(|over| f64::from(over[plane]));
        let (from, to) = (enter.max(1.0e-6), leave.min(self.until));
        if from >= to {
            return Vec::new();
        }
        let mut borders = vec![from, to];
        for (eye, way) in self.eye.to_array().into_iter().zip(way) {
            let [near, far] = [from, to].map(|at| eye + way * at);
            let whole = near.min(far).ceil() as i64..=near.max(far).floor() as i64;
            borders.extend(whole.map(|border| (border as f64 - eye) / way));
        }
        borders.retain(|at| (from..=to).contains(at));
        borders.sort_by(f64::total_cmp);
        let voxel = |ends: &[f64]| {
            let middle = 0.5 * (ends[0] + ends[1]);
            let voxel = [0, 1].map(|axis| (self.eye[axis] + way[axis] * middle).floor() as i64);
            Crossed { voxel, distances: [ends[0], ends[1]], ends: [[0.0; 2]; 2] }
        };
        borders.windows(2).map(voxel).collect()
    }
}

/// Follows the planes of a scene.
struct Following<'s>(&'s Scene);

impl Kernel for Following<'_> {
    type Output = [Vec<Crossed>; LANES];

    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Scene { grid, eye, group, until } = self.0;
        let extent = CellExtent { grid, shift: 0, over: [0.0, *until] };
        let mut crossed = <[Vec<Crossed>; LANES]>::default();
        let lanes = |values: V::F| {
            let mut lanes = [0.0; LANES];
            values.store(&mut lanes);
            lanes
        };

        for upward in [true, false] {
            let packet = PlanePacket::new(simd, group, extent, eye.to_array(), upward);
            let Some(packet) = packet else { continue };
            each_voxel(simd, &packet, |block, at, voxel| {
                let place = packet.place(at[0], at[1]) as i64;
                let place = [place % SIDE, place / SIDE];
                let ends = packet.ends(simd, block, voxel, at).map(|end| end.map(lanes));
                let distances = voxel.distances.map(lanes);

                for plane in (0..LANES).filter(|plane| voxel.planes.bits() >> plane & 1 != 0) {
                    crossed[plane].push(Crossed {
                        voxel: [0, 1].map(|axis| block.cell[axis] * SIDE + place[axis]),
                        distances: distances.map(|at| f64::from(at[plane])),
                        ends: ends.map(|end| end.map(|axis| axis[plane])),
                    });
                }
            });
        }

        crossed
    }
}

/// Shows each voxel that some plane of a packet crosses, with its block, and its column and place there.
fn each_voxel<V: Simd>(
    simd: V,
    packet: &PlanePacket<'_, V>,
    mut see: impl FnMut(&BlockPassage<V>, [i32; 2], &VoxelPassage<V>),
) {
    for column in packet.columns().map(|number| packet.column(simd, number)) {
        for block in packet.rows(simd, &column).filter_map(|row| packet.block(simd, &column, row)) {
            for number in packet.voxel_columns(simd, &block) {
                let voxels = packet.voxel_column(simd, &block, number);
                for up in voxels.voxels.clone() {
                    if let Some(voxel) = packet.voxel(simd, &block, &voxels, up) {
                        see(&block, [number, up], &voxel);
                    }
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn planes_cross_voxels_as_one_by_one(scene in scenes()) {
        crosses_as_one_by_one(&scene);
    }

    #[test]
    fn spans_are_met_in_the_order_of_each_plane(
        begins in vec((any::<u16>(), uniform16(select(vec![0.0_f32, 0.2, 0.2001, 0.7]))), 1..8),
    ) {
        for isa in Isa::available() {
            for (plane, found) in isa.run(Order(&begins)).iter().enumerate() {
                let mut exact: Vec<usize> =
                    (0..begins.len()).filter(|index| begins[*index].0 >> plane & 1 != 0).collect();
                exact.sort_by(|a, b| begins[*a].1[plane].total_cmp(&begins[*b].1[plane]));
                prop_assert_eq!(found, &exact, "{}, plane {}", isa, plane);
            }
        }
    }

    #[test]
    fn horizons_are_found_as_one_by_one(
        steps in vec((uniform16(-0.3_f32..0.5), 0.1_f32..30.0, 0.0_f32..1.0), 1..30),
        distances in vec(uniform16(0.0_f32..1.0), 12),
    ) {
        has_horizons_as_one_by_one(&steps, &distances);
    }
}

fn crosses_as_one_by_one(scene: &Scene) {
    for isa in Isa::available() {
        for (plane, found) in isa.run(Following(scene)).iter().enumerate() {
            let way = scene.group.way(plane);
            // Where it crosses a border that it almost runs along is as uncertain as how far across it is.
            let climb = way[0].abs().min(way[1].abs());
            let near = 2.0e-5 + if climb > 0.0 { 2.0e-6 / climb } else { 0.0 };
            let mut found = found.iter().peekable();

            for exact in scene.crossed(plane) {
                let case = || format!("{isa}, plane {plane}: {scene:?} {exact:?}");
                while found.next_if(|told| told.voxel != exact.voxel && told.is_shorter(2.0 * near)).is_some()
                {
                }
                let Some(told) = found.next_if(|told| told.voxel == exact.voxel) else {
                    assert!(exact.is_shorter(2.0 * near), "{} is missing", case());
                    continue;
                };
                for end in 0..2 {
                    let off = (told.distances[end] - exact.distances[end]).abs();
                    assert!(off < near, "{} {told:?}", case());
                    let ends = told.ends[end].into_iter().zip(way);
                    for ((place, way), (eye, voxel)) in
                        ends.zip(scene.eye.to_array().into_iter().zip(exact.voxel))
                    {
                        let exact = eye + way * exact.distances[end] - voxel as f64 - 0.5;
                        assert!((f64::from(place) - exact).abs() < 2.0 * near, "{} {told:?}", case());
                    }
                }
            }
            let more = found.find(|told| !told.is_shorter(2.0 * near));
            assert!(more.is_none(), "{isa}, plane {plane}: {scene:?}: {more:?} is more than there is");
        }
    }
}

/// Spans by the planes that cross them and the shares of the way at which they begin there; tells each plane's order.
struct Order<'a>(&'a [(u16, [f32; LANES])]);

impl Kernel for Order<'_> {
    type Output = [Vec<usize>; LANES];

    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let span: Span = bytemuck::Zeroable::zeroed();
        let met = |(planes, begins): &(u16, [f32; LANES])| {
            Some(MetSpan::<V> {
                span: &span,
                planes: simd.mask(*planes),
                shares: [simd.load(begins), simd.splat(1.0)],
            })
        };
        let mut met: Vec<_> = self.0.iter().map(met).collect();
        let mut order = <[Vec<usize>; LANES]>::default();
        while let Some((index, planes)) = next_of(simd, &met) {
            if let Some(span) = &mut met[index] {
                span.planes = span.planes & !planes;
            }
            for plane in (0..LANES).filter(|plane| planes.bits() >> plane & 1 != 0) {
                order[plane].push(index);
            }
        }
        order
    }
}

/// A profile of posts with rises, distances between them, and a draw of whether the march began anew there.
struct Horizons<'a> {
    steps: &'a [([f32; LANES], f32, f32)],
    /// Inverse depths, each set as near as the one before or farther.
    inverse: &'a [[f32; LANES]],
    profile: &'a mut Profile,
}

const LOWEST: f32 = -0.9;

impl Kernel for Horizons<'_> {
    type Output = Vec<[f32; LANES]>;

    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let mut distance = 0.0;
        let mut horizon = simd.splat(NO_SLOPE);
        for (index, (rises, step, draw)) in self.steps.iter().enumerate() {
            distance += step;
            let slope = horizon.max(simd.splat(-1.0)) + simd.load(rises);
            let post = Post::<V> {
                slope,
                inverse: simd.splat(1.0 / distance),
                line: SampleLine { line: index as i64, ..SampleLine::default() },
            };
            if index == 0 || *draw < 0.15 {
                self.profile.begin(&post)
            } else {
                self.profile.add(&post, true)
            }
            horizon = horizon.max(slope);
        }

        let all = simd.mask(u16::MAX);
        let mut horizon = FloatingHorizon::new(simd, self.profile, LOWEST);
        let mut found = Vec::new();
        for inverse in self.inverse {
            let inverse = simd.load(inverse);
            let mut lanes = [0.0; LANES];
            // Not past what is near in one plane only.
            horizon.advance(simd, all, inverse);
            horizon.at(simd, all, inverse).store(&mut lanes);
            found.push(lanes);
        }
        found
    }
}

fn has_horizons_as_one_by_one(steps: &[([f32; LANES], f32, f32)], distances: &[[f32; LANES]]) {
    let whole: f32 = 1.2 * steps.iter().map(|step| step.1).sum::<f32>();
    let inverse: Vec<[f32; LANES]> = distances
        .iter()
        .enumerate()
        .map(|(index, spread)| {
            let least = whole * index as f32 / distances.len() as f32;
            spread.map(|share| 1.0 / (least + 0.01 + share * whole / distances.len() as f32))
        })
        .collect();

    for isa in Isa::available() {
        let mut profile = Profile::default();
        let found = isa.run(Horizons { steps, inverse: &inverse, profile: &mut profile });
        for (inverse, found) in inverse.iter().zip(found) {
            for plane in 0..LANES {
                let exact = horizon_of(&profile, plane, inverse[plane]);
                assert!((found[plane] - exact).abs() < 1.0e-4, "{isa}: {exact} {}", found[plane]);
            }
        }
    }
}

/// The horizon of one plane at an inverse depth.
fn horizon_of(profile: &Profile, plane: usize, inverse: f32) -> f32 {
    let mut horizon = LOWEST;
    let mut behind: Option<[f32; 2]> = None;
    for segment in profile.segments() {
        let [slope, far] = [segment.slope.0[plane], segment.inverse.0[plane]];
        if far <= inverse {
            if let Some([from, near]) = behind
                && !segment.line.begins
                && slope > horizon
            {
                let share = ((near - inverse) / (near - far)).clamp(0.0, 1.0);
                horizon = horizon.max(from + (slope - from) * share);
            }
            return horizon;
        }
        horizon = horizon.max(slope);
        behind = Some([slope, far]);
    }
    horizon
}
