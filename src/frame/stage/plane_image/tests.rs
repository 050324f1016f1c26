//! Rolled columns against what the plane image shows in closed form, and what columns reach.

use glam::DVec3;
use proptest::prelude::*;

use super::super::cell::{Cell, Scale};
use super::{AlongRow, Depths, LookUp, UprightImage};
use crate::raymarch::scan::Upright;
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Simd, Sixteen};
use crate::space::{Attitude, Camera, Pose};

const SIZE: [u32; 2] = [160, 120];

/// Light of a plane and row, by channel: waves long enough for a cubic.
fn light(plane: f64, row: f64) -> [f64; 3] {
    [0.0, 1.0, 2.0].map(|phase| 0.5 + 0.2 * (plane / 9.0 + phase).sin() + 0.2 * (row / 11.0 - phase).cos())
}

/// Reads the light of pixels of a screen of such a size, row by row downward from a first one, and their planes and rows.
struct Looking<'u>(&'u Upright, &'u [Cell], [u32; 2], usize);

impl Kernel for Looking<'_> {
    type Output = Vec<([Sixteen; 3], [Sixteen; 2])>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self(upright, cells, [width, height], first) = self;
        let rows = first..height as usize;
        let depths = Depths { inverse: &[], tilts: [&[], &[]] };
        let plane_image = UprightImage::new(simd, upright, cells, depths, rows.clone());
        let mut seen = Vec::new();
        let mut strip = plane_image.strip();
        for column in (0..width as usize).step_by(LANES) {
            plane_image.begin(&mut strip, column);
            for row in rows.clone() {
                let place = plane_image.place(column, row);
                let mut lanes = [Sixteen::default(); 3];
                for (lanes, light) in lanes.iter_mut().zip(plane_image.roots(&mut strip, &place)) {
                    light.store(&mut lanes.0);
                }
                let mut at = [Sixteen::default(); 2];
                let columns = std::array::from_fn(|lane| (column + lane) as f32 + 0.5 - 0.5 * width as f32);
                let gaze = upright.look(simd, simd.load(&columns), row as f32 + 0.5);
                gaze.plane.store(&mut at[0].0);
                gaze.row.store(&mut at[1].0);
                seen.push((lanes, at));
            }
        }
        seen
    }
}

/// Encodes light of sixteen planes.
struct Encoding([[f32; LANES]; 3]);

impl Kernel for Encoding {
    type Output = Cell;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Cell {
        let mut cell = Cell::default();
        Scale::DISPLAY.encode(simd, self.0.map(|light| simd.load(&light)), &mut cell);
        cell
    }
}

#[test]
fn rolled_screens_see_the_plane_image_at_any_roll() {
    for (pitch, roll) in
        [(0.0, 0.5), (-6.0, 3.0), (-8.0, -20.0), (12.0, 26.5), (-15.0, 33.0), (-3.0, -60.0), (0.0, 150.0)]
    {
        let attitude = Attitude { yaw: 25.0, pitch, roll };
        let camera = Camera::new(Pose { eye: DVec3::ZERO, attitude, hfov: 60.0 }, SIZE[0], SIZE[1]);
        let upright = Upright::new(&camera).expect("a planar screen");
        let [planes, rows] = upright.size;
        let cell = |group: usize, row: usize| {
            let lights: [[f64; 3]; LANES] =
                std::array::from_fn(|lane| light((group * LANES + lane) as f64, row as f64));
            let channel = |channel: usize| lights.map(|light| light[channel] as f32);
            Isa::PORTABLE.run(Encoding([channel(0), channel(1), channel(2)]))
        };
        let groups = 0..planes / LANES;
        let cells: Vec<Cell> = groups
            .flat_map(|group| (0..rows).map(move |row| (group, row)))
            .map(|(g, r)| cell(g, r))
            .collect();
        let inside = |at: f64, count: usize| (2.0..count as f64 - 3.0).contains(&at);

        for isa in Isa::available() {
            let all = isa.run(Looking(&upright, &cells, SIZE, 0));
            for (seen, [plane, row]) in &all {
                for lane in 0..LANES {
                    let at = [plane, row].map(|at| f64::from(at.0[lane]));
                    if !inside(at[0], planes) || !inside(at[1], rows) {
                        continue;
                    }
                    for (channel, exact) in light(at[0], at[1]).into_iter().enumerate() {
                        let found = f64::from(seen[channel].0[lane] * Scale::DISPLAY.step()).powi(2);
                        let case =
                            format!("{isa}, pitch {pitch}, roll {roll}: {found} for {exact} at {at:?}");
                        assert!((found - exact).abs() < 3.0e-3, "{case}");
                    }
                }
            }

            // Wherever a band begins.
            let (height, first) = (SIZE[1] as usize, 71);
            let below = isa.run(Looking(&upright, &cells, SIZE, first));
            let others = all.chunks(height).flat_map(|strip| &strip[first..]);
            assert!(
                others.zip(&below).all(|(whole, part)| whole == part),
                "{isa}, pitch {pitch}, roll {roll}"
            );
        }
    }
}

/// Integers at or below what lanes have.
struct Floors(AlongRow, usize, usize);

impl Kernel for Floors {
    type Output = [i32; LANES];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self(along, first, width) = self;
        let columns: [f32; LANES] =
            std::array::from_fn(|lane| (first + lane) as f32 + 0.5 - 0.5 * width as f32);
        let mut floors = [0; LANES];
        along.values(simd, simd.load(&columns)).floor().to_int().store(&mut floors);
        floors
    }
}

proptest! {
    #[test]
    fn screens_of_any_size_are_read_from_within_the_plane_image(
        size in (1..300_u32, 1..40_u32), hfov in 1.0..150.0_f64, pitch in -45.0..45.0_f64,
        roll in prop_oneof![Just(0.0), -0.1..0.1_f64, -27.0..27.0_f64],
    ) {
        let (size, attitude) = ([size.0, size.1], Attitude { yaw: 25.0, pitch, roll });
        let camera = Camera::new(Pose { eye: DVec3::ZERO, attitude, hfov }, size[0], size[1]);
        if let Some(upright) = Upright::new(&camera) {
            let [planes, rows] = upright.size;
            let grey = Isa::PORTABLE.run(Encoding([[0.25; LANES]; 3]));
            let cells = vec![grey; planes / LANES * rows];
            let step = Scale::DISPLAY.step();
            for isa in Isa::available() {
                for (seen, _) in isa.run(Looking(&upright, &cells, size, 0)) {
                    let is_grey = |light: &f32| ((light * step).powi(2) - 0.25).abs() < 1.0e-3;
                    prop_assert!(seen[0].0.iter().all(is_grey), "{isa}: {seen:?}");
                }
            }
        }
    }

    #[test]
    fn no_lane_is_beyond_what_sixteen_columns_reach(
        per_column in -1.8_f64..1.8,
        middle in 0.0_f64..4000.0,
        width in 1_usize..5000,
        strip in 0_usize..300,
    ) {
        let along = AlongRow::new([per_column, middle], width);
        let first = LANES * (strip % width.div_ceil(LANES));
        let [least, greatest] = along.reach(first);
        for isa in Isa::available() {
            let floors = isa.run(Floors(along, first, width));
            // Lanes convert no values below nothing.
            if middle - per_column.abs() * (0.5 * width as f64 + 16.0) < 0.0 {
                continue;
            }
            prop_assert!(floors.iter().all(|floor| (least..=greatest).contains(floor)), "{isa}: {floors:?}");
            let ends = floors[0].abs_diff(floors[LANES - 1]);
            prop_assert!(greatest.abs_diff(least) <= ends + 2, "{isa}: {least}…{greatest} of {floors:?}");
        }
    }
}
