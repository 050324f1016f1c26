//! Rows against a loop of scalars over stretches.

use glam::{DVec2, DVec3};
use proptest::array::{uniform3, uniform16};
use proptest::collection::vec;
use proptest::prelude::*;

use super::cell::{Cell, Scale};
use super::rows::{ChunkLights, SegmentLights};
use super::segment_light::{ChunkDetail, GROUND, PlaneLight, WALL};
use super::{DetailView, EdgeSums, PlaneAir, RowDetail, RowFill};
use crate::detail::{DetailTiles, SunAngles, Synthesis};
use crate::raymarch::scan::{
    NO_SLOPE, PlaneGroup, Post, Profile, RowCoordinate, RowTable, SampleLine, VisibleSegment,
};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Simd, Sixteen};
use crate::voxel::{DetailRecord, Grid};
use crate::weather::{Atmosphere, AtmosphereLanes};
use hedgehop_base::error::Result;

const ROWS: usize = 40;

/// Rows of the plane image below and above them.
const BELOW: usize = 7;

/// A profile from posts: slopes, and whether the march began anew there.
struct Posts<'a>(&'a [(Sixteen, bool)], &'a mut Profile);

impl Kernel for Posts<'_> {
    type Output = ();

    fn run<V: Simd>(self, simd: V) {
        for (index, (slopes, begins)) in self.0.iter().enumerate() {
            let mark = SampleLine { line: index as i64, ..SampleLine::default() };
            let inverse = simd.splat(1.0 / (index + 1) as f32);
            let post = Post::<V> { slope: simd.load(&slopes.0), inverse, line: mark };
            if *begins { self.1.begin(&post) } else { self.1.add(&post, true) }
        }
    }
}

/// Given lights.
struct Given<'l>(&'l [PlaneLight]);

impl SegmentLights for Given<'_> {
    fn begin<'f, V: Simd, const FOG_OR_GLOW: bool>(
        self,
        _: V,
        segments: &[VisibleSegment],
        _: PlaneAir<'f>,
    ) -> Result<impl ChunkLights> {
        assert_eq!(segments.len(), self.0.len());
        Ok(self)
    }
}

impl ChunkLights for Given<'_> {
    fn next(
        &mut self,
        chunk: &[VisibleSegment],
        later: &[VisibleSegment],
        lights: &mut [PlaneLight],
    ) -> Result<ChunkDetail> {
        let (here, rest) = self.0.split_at(chunk.len());
        assert_eq!(rest.len(), later.len());
        lights.copy_from_slice(here);
        self.0 = rest;
        // Chunks without detail, with some over the ground and over walls, too, take turns.
        let kinds = [ChunkDetail::Walls, ChunkDetail::None, ChunkDetail::Ground];
        let detail = kinds[rest.len() / chunk.len().max(1) % kinds.len()];
        for light in lights {
            if detail < ChunkDetail::Walls {
                light[WALL] = Sixteen::default();
            }
            if detail < ChunkDetail::Ground {
                light[GROUND] = Sixteen::default();
            }
        }
        Ok(detail)
    }
}

/// Light without detail.
fn lit([red, green, blue]: [[f32; LANES]; 3]) -> PlaneLight {
    [Sixteen(red), Sixteen(green), Sixteen(blue), Sixteen::default(), Sixteen::default()]
}

/// Light with detail.
fn with_deviation(light: &PlaneLight, deviation: f32) -> PlaneLight {
    let mut light = *light;
    light[GROUND] = Sixteen([deviation; LANES]);
    light[WALL] = Sixteen(std::array::from_fn(|lane| if lane % 3 == 0 { -deviation } else { deviation }));
    light
}

/// Planes along the x axis.
fn planes() -> PlaneGroup {
    let grid = Grid { nx: 1000, ny: 1000, spacing: 1.0, origin: DVec2::ZERO };
    let directions = std::array::from_fn(|lane| DVec2::new(1.0, 0.001 * lane as f64));
    PlaneGroup::new(&grid, DVec2::new(70.0, 90.0), &directions, 0.0)
}

/// A table of any rows; nobody asks for their coordinate.
fn row_table(edges: Vec<f32>, centres: Vec<f32>) -> RowTable {
    let coordinate = RowCoordinate::angular(1.0, 0.0, &edges);
    RowTable::new(edges, centres, coordinate)
}

/// Linear light of a plane's word.
fn decode(cell: &Cell, lane: usize) -> [f32; 3] {
    struct Decoding<'c>(&'c Cell);
    impl Kernel for Decoding<'_> {
        type Output = [Sixteen; 3];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let mut lanes = [Sixteen::default(); 3];
            for (lanes, light) in lanes.iter_mut().zip(Scale::ALL.decode(simd, self.0)) {
                light.store(&mut lanes.0);
            }
            lanes
        }
    }
    Isa::PORTABLE.run(Decoding(cell)).map(|channel| channel.0[lane])
}

fn fill(
    isa: Isa,
    edges: &[f32],
    profile: &Profile,
    lights: &[PlaneLight],
    inverse: &mut [Sixteen],
    detail: Option<RowDetail<'_>>,
    stale: f32,
) -> Vec<Cell> {
    // The plane image has other rows above and below.
    let below = (1..=BELOW).rev().map(|row| edges[0] - 0.02 * row as f32);
    let above = (1..=BELOW).map(|row| edges[ROWS] + 0.02 * row as f32);
    let all: Vec<f32> = below.chain(edges.iter().copied()).chain(above).collect();
    let centres = all.windows(2).map(|edge| 0.5 * (edge[0] + edge[1])).collect();
    let row_table = row_table(all, centres);
    let mut cells = vec![Cell::default(); ROWS];
    let air = AtmosphereLanes::new(&Atmosphere::new(20_000.0, 0.0), 100.0, 500.0);
    let rows = RowFill {
        row_table: &row_table,
        first: BELOW,
        cells: &mut cells,
        scale: Scale::ALL,
        inverse,
        detail,
    };
    // What was in the memory before must not matter.
    let unknown = Sixteen([stale; LANES]);
    let mut sums = EdgeSums::of(unknown, 2 * ROWS);
    let plane_air = PlaneAir { air: &air, squares: &[1.0; LANES] };
    rows.fill(isa, profile, Given(lights), plane_air, &mut sums).unwrap();
    cells
}

/// Light and inverse depth of one row of one plane.
fn expect(row: [f32; 2], floor: f32, stretches: &[([f32; 2], [f32; 2], [f32; 2])], sky: f32) -> (f32, f32) {
    let [bottom, top] = row.map(f64::from);
    let centre = 0.5 * (row[0] + row[1]);
    let (mut covered, mut light, mut inverse) = (f64::from(floor), 0.0, 0.0);
    for (slopes, inverses, lights) in stretches {
        let [low, high] = slopes.map(f64::from);
        if high <= covered {
            continue;
        }

        let (from, to) = (covered.max(bottom), high.min(top));
        let at = |tangent: f64, ends: [f32; 2]| {
            let share = (tangent - low) / (high - low);
            f64::from(ends[0]) + share * f64::from(ends[1] - ends[0])
        };
        if to > from {
            light += (to - from) / (top - bottom) * at(0.5 * (from + to), *lights);
        }
        if covered <= centre.into() && f64::from(centre) < high {
            inverse = at(centre.into(), *inverses);
        }

        covered = high;
    }

    let left = ((top - covered.max(bottom)) / (top - bottom)).max(0.0);
    ((light + left * f64::from(sky)) as f32, inverse as f32)
}

/// A post's rises above the horizons, light, and whether it is where the march begins anew.
type Step = ([f32; LANES], [[f32; LANES]; 3], f32);

fn steps() -> impl Strategy<Value = Vec<Step>> {
    vec((uniform16(-0.02_f32..0.06), uniform3(uniform16(0.02_f32..1.0)), 0.0_f32..1.0), 2..40)
}

/// Posts as a march would find them: one in twenty is a hole, one in ten begins, at or below the horizon.
fn posts(steps: &[Step], steepness: f32) -> Vec<(Sixteen, bool)> {
    let mut horizon = [-0.7_f32; LANES];
    let mut begun = false;
    let place = |(index, (rises, _, dice)): (usize, &Step)| {
        // A beginning of which nothing comes is no segment.
        let begins = index == 0 || *dice < 0.1 && !begun && index + 1 < steps.len();
        begun = begins;
        let mut slopes = Sixteen::default();
        for ((slope, rise), horizon) in slopes.0.iter_mut().zip(rises).zip(&mut horizon) {
            let is_hole = rise.to_bits() % 20 == 0;
            *slope = if is_hole { NO_SLOPE } else { *horizon + rise * steepness };
            if begins {
                *slope = slope.min(*horizon);
            }
            *horizon = horizon.max(*slope);
        }
        (slopes, begins)
    };
    steps.iter().enumerate().map(place).collect()
}

/// Edges that a row table finds between pairs of tangents.
struct Between<'l>(&'l RowTable, [[f32; LANES]; 2]);

impl Kernel for Between<'_> {
    type Output = [std::ops::Range<usize>; LANES];

    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let [low, high] = self.1.map(|tangents| simd.load(&tangents));
        let mut cells = [[0; LANES]; 2];
        for (cells, found) in cells.iter_mut().zip(self.0.cells(simd, low, high)) {
            found.store(cells);
        }
        std::array::from_fn(|lane| self.0.between(cells[0][lane], cells[1][lane]))
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn ladders_find_all_edges_between_tangents_and_few_others(
        bottom in -1.5_f32..1.4,
        rows in 1_usize..3000,
        ends in uniform16((-1.7_f32..1.7, 0.0_f32..0.1)),
    ) {
        // Equal steps of elevation, up to 80 degrees and beyond.
        let edge = |row: usize| (bottom + (1.45 - bottom) * row as f32 / rows as f32).tan();
        let edges: Vec<f32> = (0..=rows).map(edge).collect();
        let row_table = row_table(edges.clone(), vec![0.0; rows]);
        let low = ends.map(|(low, _)| if low < -1.5 { NO_SLOPE } else { low.tan() });
        let high = ends.map(|(low, rise)| if low + rise > 1.5 { -NO_SLOPE } else { (low + rise).tan() });
        for isa in Isa::available() {
            let found = isa.run(Between(&row_table, [low, high]));
            for (lane, found) in found.into_iter().enumerate() {
                let first = edges.partition_point(|&edge| edge <= low[lane]);
                let end = edges.partition_point(|&edge| edge <= high[lane]).max(first);
                prop_assert!(first == end || found.start <= first && end <= found.end, "{found:?} for {first}..{end}");
                prop_assert!(found.len() <= end - first + 4, "{found:?} for {first}..{end}");
            }
        }
    }

    #[test]
    fn rows_are_means_of_what_covers_them(
        heights in vec(0.01_f32..0.03, ROWS),
        steps in steps(),
        steepness in prop::sample::select(vec![0.02_f32, 1.0]),
    ) {
        let mut edges = vec![-0.6_f32];
        heights.iter().for_each(|height| edges.push(edges[edges.len() - 1] + height));
        let posts = posts(&steps, steepness);
        let lights: Vec<PlaneLight> = steps.iter().map(|(_, light, _)| lit(*light)).collect();

        for isa in Isa::available() {
            let mut profile = Profile::default();
            isa.run(Posts(&posts, &mut profile));
            prop_assert_eq!(profile.segments().len(), posts.len());
            let sky = fill(isa, &edges, &Profile::default(), &[], &mut [], None, f32::NAN);
            let mut inverse = vec![Sixteen([f32::NAN; LANES]); ROWS];
            let cells = fill(isa, &edges, &profile, &lights, &mut inverse, None, f32::NAN);
            let again = fill(isa, &edges, &profile, &lights, &mut [], None, f32::NAN);
            let same = cells.iter().zip(&again).all(|(a, b)| a == b);
            prop_assert!(same, "depth changes light");

            // Detail of 0.3 at most: some rows have it, whatever was in the memory before.
            let rough: Vec<PlaneLight> = lights.iter().map(|light| with_deviation(light, 0.3)).collect();
            let eye = DVec3::new(70.0, 90.0, 100.0);
            let tiles = DetailTiles::of(&DetailRecord::default(), SunAngles { azimuth: 135.0, elevation: 40.0 }).unwrap();
            let synthesis = &Synthesis { tiles, strength: 1.0 };
            let view = DetailView { synthesis, eye, angle: 1.0e-3, row: 1.0e-3, spacing: 1.0 };
            let detail = Some(RowDetail::new(&planes(), &view));
            let [one, other] = [f32::NAN, 1.0].map(|stale| fill(isa, &edges, &profile, &rough, &mut [], detail, stale));
            prop_assert!(one == other, "{isa}: rows depend on what was in the memory");

            for (lane, channel) in (0..LANES).flat_map(|lane| (0..3).map(move |channel| (lane, channel))) {
                let stretch = |to: usize| {
                    (
                        [to - 1, to].map(|post| posts[post].0.0[lane]),
                        [to, to + 1].map(|depth| 1.0 / depth as f32),
                        [to - 1, to].map(|post| lights[post][channel].0[lane]),
                    )
                };

                let stretches: Vec<_> = (1..posts.len()).filter(|&to| !posts[to].1).map(stretch).collect();
                for row in 0..ROWS {
                    let above = decode(&sky[row], lane)[channel];
                    let (light, depth) = expect([edges[row], edges[row + 1]], edges[0], &stretches, above);
                    let seen = decode(&cells[row], lane)[channel];
                    let is_near = (seen.sqrt() - light.sqrt()).abs() < 2.5e-3;
                    prop_assert!(is_near, "{isa}: plane {lane}, row {row}: {seen} for {light}");
                    let seen = inverse[row].0[lane];
                    let is_near = (seen - depth).abs() < 2e-3 * depth.max(0.01);
                    prop_assert!(is_near, "{isa}: plane {lane}, row {row}: depth {seen} for {depth}");
                }
            }
        }
    }
}
