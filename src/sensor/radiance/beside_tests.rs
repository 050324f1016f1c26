//! Lines found by the place of another against lines that are sought.

use std::sync::atomic::AtomicU32;

use super::tests::{Holey, rough, sensor};
use super::*;
use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::voxel::PageId;

/// Radiance of sixteen planes, `[channel][plane]`.
type PlaneRadiance = [[f32; LANES]; 3];

/// A look at a line beside another.
struct LookingBeside<'s, 'a> {
    sampler: &'s mut LineSampler<'a>,
    planes: PlanesAbove,
    line: ImageLine,
    step: i64,
}

impl Kernel for LookingBeside<'_, '_> {
    /// Radiance of the line, found beside the other and sought; `None` where it must be sought.
    type Output = Option<[PlaneRadiance; 2]>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self { sampler, planes, line, step } = self;
        let mut crossings = sampler.under(simd, &planes);
        let place = crossings.seek(line).unwrap();
        let beside = crossings.beside(&place, &line, step)?;
        let sought = crossings.seek(ImageLine { index: line.index + step, ..line }).unwrap();
        Some([beside, sought].map(|place| {
            crossings.sample(&place).map(|channel| {
                let mut lanes = [0.0; LANES];
                channel.store(&mut lanes);
                lanes
            })
        }))
    }
}

#[test]
fn a_line_beside_another_is_the_one_that_is_sought() {
    // The last page has few lines, and posts; where one is absent the next coarser level stands in.
    let absent = |id: PageId| id.level == 0 && [id.px, id.py] == [0, 0];
    let source = Holey { whole: rough(300, 270, 0), absent, asked: AtomicU32::new(0) };
    let radiance = Radiance::new(sensor());
    let mut found = 0;

    for case in 0..1600_i64 {
        let major = (case % 2) as usize;
        let line = ImageLine {
            level: 0,
            index: case * 7 % 305 - 2,
            span: [1, 1, 1, 2][case as usize / 2 % 4],
            distance: 4.0 + (case % 83) as f32,
        };
        let planes = PlanesAbove {
            major,
            forward: case % 3 > 0,
            height: f64::INFINITY,
            eye: (case * 13 % 300) as f64,
            minor: std::array::from_fn(|lane| (case % 5) as f32 * 0.2 - 0.4 + 0.01 * lane as f32),
            pixel: 0.4 / f64::from(line.distance),
        };
        for (isa, step) in Isa::available().into_iter().flat_map(|isa| [(isa, -1), (isa, 1)]) {
            let mut sampler = LineSampler::new(RadiancePages::new(&source, &radiance));
            let looking = LookingBeside { sampler: &mut sampler, planes, line, step };
            if let Some([beside, sought]) = isa.run(looking) {
                assert_eq!(beside, sought, "{isa}, case {case}, step {step}");
                found += 1;
            }
        }
    }

    assert!(found > 1000, "{found}");
}
