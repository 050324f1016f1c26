//! Annuli tile the sphere, and everything that a pixel looks up has been marched.

use proptest::prelude::*;

use super::*;
use crate::simd::{Ints, Isa, Kernel, Mask};
use crate::space::{Attitude, Pose};

fn panorama(screen: Screen, attitude: Attitude, size: [u32; 2]) -> Panorama {
    let pose = Pose { eye: DVec3::ZERO, attitude, hfov: 60.0 };
    let camera = Camera::with_screen(pose, screen, size[0], size[1]);
    let mut directions = Directions::new(&camera);
    directions.parts().into_iter().for_each(|part| part.fill(&camera));
    Panorama::new(&camera, Arc::new(directions))
}

/// Counts looks at planes and rows that nobody marched.
struct LookUps<'a> {
    panorama: &'a Panorama,
    size: [u32; 2],
}

impl Kernel for LookUps<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> usize {
        let mut missing = 0;
        for row in 0..self.size[1] as usize {
            for column in (0..self.size[0] as usize).step_by(LANES) {
                let gaze = self.panorama.gaze(simd, column, row);
                let mut rows = [0.0; LANES];
                gaze.row.store(&mut rows);
                for (lane, row) in rows.into_iter().enumerate() {
                    if gaze.lit.bits() >> lane & 1 == 0 {
                        continue;
                    }

                    let below = row.floor() as i32;
                    let annulus = self.panorama.annulus(below);
                    for words in annulus.between(simd, gaze.azimuth).words {
                        for row in (below - 1..=below + 2).map(|row| row.clamp(0, self.panorama.last_row())) {
                            let mut found = [0; LANES];
                            (words + simd.splat_int(row * LANES as i32)).store(&mut found);
                            missing += usize::from(!self.panorama.holds(annulus, row, found[lane]));
                        }
                    }
                }
            }
        }

        missing
    }
}

impl Panorama {
    /// Whether a word is of a row that is kept of a group of an annulus.
    fn holds(&self, annulus: &Annulus, row: i32, word: i32) -> bool {
        let mut start = 0;
        self.needed.iter().any(|needed| {
            let first = start;
            start += needed.rows.len();
            std::ptr::eq(annulus, &self.annuli[needed.annulus])
                && needed.rows.contains(&(row as usize))
                && word >> 4 == first as i32 + row - needed.rows.start as i32
        })
    }
}

#[test]
fn annuli_tile_the_rows() {
    for (rows, step) in [(80, 0.02), (3000, 0.001_05), (300_000, 1.05e-5)] {
        let annuli = Annulus::all(rows, step, 1.0);
        assert_eq!(annuli[0].rows.start, 0);
        assert_eq!(annuli[annuli.len() - 1].rows.end, rows - 1);
        assert!(annuli.windows(2).all(|pair| pair[0].rows.end == pair[1].rows.start));
        // All together are not many more than the sphere has steps.
        let lattice: usize = annuli.iter().map(|annulus| annulus.rows.len() * annulus.planes()).sum();
        let sphere = 2.0 * TAU / (step * step);
        assert!((lattice as f64) < 1.6 * sphere + 30_000.0, "{lattice} {sphere}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(40) })]

    #[test]
    fn every_look_up_has_been_marched(
        kind in 0..4, fov in 1.0..150.0_f64,
        yaw in -400.0..400.0_f64, pitch in -90.0..90.0_f64, roll in -180.0..180.0_f64, steep: bool,
    ) {
        let pitch = if steep { 90.0_f64.copysign(pitch) } else { pitch };
        let screen = match kind {
            0 => Screen::Planar { hfov: fov },
            1 => Screen::Cylindrical { hfov: 2.4 * fov },
            2 => Screen::Equirectangular { hfov: 2.4 * fov, vfov: fov },
            _ => Screen::Fisheye { fov: 2.4 * fov },
        };
        let size = [70, 50];
        let panorama = panorama(screen, Attitude { yaw, pitch, roll }, size);
        prop_assert_eq!(Isa::best().run(LookUps { panorama: &panorama, size }), 0);
    }
}
