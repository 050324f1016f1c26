//! Spans of coarse cells against closed forms and the voxels that they are made of.

use proptest::prelude::*;

use super::*;
use crate::Size;
use crate::voxel::{BlockSpans, SharedObjects, SpanTable};

/// Voxels along a page of the tests: a block of the coarsest cells.
const SIDE: u32 = 32;

/// Codes that a slope of one step rises by over half a voxel.
const RISE: f64 = 0.25;

/// An opaque span on the ground.
const PILLAR: Span = Span {
    low: Span::GROUND,
    high: 900,
    slope: [0; 2],
    cuts: [Cut::NONE; 3],
    top: [200, 60, 50],
    state: Span::OPAQUE,
    side: [220, 210, 190],
    material: 2,
    facade: Facade::NONE,
};

/// Spans of the block of cells of `1 << shift` voxels in the south-west corner of a page.
fn coarse(shift: u8, spans_of: impl Fn(u32, u32) -> Vec<Span>) -> BlockSpans {
    let size = Size { width: SIDE, height: SIDE };
    let table = SpanTable::new(size, RISE, |x, y, spans| spans.extend(spans_of(x, y)));
    let mut coarse = BlockSpans::default();
    coarse.gather_coarse(&table.view(SIDE), &SharedObjects::default(), [0; 2], shift, RISE);
    coarse
}

/// Cells of a block.
fn cells(spans: &BlockSpans) -> impl Iterator<Item = (usize, &[Span])> {
    (0..(BLOCK_SIDE * BLOCK_SIDE) as usize).map(|cell| (cell, spans.at(cell)))
}

#[test]
fn what_is_alike_everywhere_stays() {
    for shift in [1, 2] {
        let sloped = |x: u32, _| vec![Span { slope: [16, 0], high: 900 + (8 * x) as u16, ..PILLAR }];
        let spans = coarse(shift, sloped);
        for (cell, own) in cells(&spans) {
            let east = (cell as u32 % BLOCK_SIDE) as f32 + 0.5;
            let high = 900.0 - 4.0 + 8.0 * east * (1 << shift) as f32;
            let [span] = own else { panic!("{own:?}") };
            assert!((f32::from(span.high) - high).abs() <= 1.0, "{span:?} for {high}");
            assert_eq!(Span { high: 900, ..*span }, Span { slope: [16, 0], ..PILLAR });
        }
    }
}

#[test]
fn leaves_hide_as_much() {
    for (shift, opacity) in [(1, 4_u8), (1, 9), (2, 2), (2, 5)] {
        let leaves = Span { low: 300, state: opacity, ..PILLAR };
        let through = (1.0 - leaves.opacity()).powi(1 << shift);
        for (_, own) in cells(&coarse(shift, |_, _| vec![leaves])) {
            let [span] = own else { panic!("{own:?}") };
            assert!((span.opacity() - (1.0 - through)).abs() <= 0.5 / 15.0 + 1e-6, "{span:?} for {through}");
            assert_eq!((span.low, span.high), (300, 900));
        }
    }
}

#[test]
fn storeys_of_one_place_stay_apart_and_what_is_under_a_crown_is_left_out() {
    let storeys = [(300, 500), (500, 700), (800, 820)];
    let stacked = |_, _| storeys.map(|(low, high)| Span { low, high, ..PILLAR }).to_vec();
    for (_, own) in cells(&coarse(1, stacked)) {
        assert_eq!(own.iter().map(|span| (span.low, span.high)).collect::<Vec<_>>(), storeys);
    }

    let stem = Span { cuts: [Cut::wall(0, -60), Cut::NONE, Cut::NONE], high: 400, ..PILLAR };
    let crown = Span { low: 350, state: 9, ..PILLAR };
    let tree = |x: u32, y: u32| if (x % 4, y % 4) == (0, 0) { vec![stem, crown] } else { vec![crown] };
    for (_, own) in cells(&coarse(2, tree)) {
        assert!(own.len() == 1 && own[0].low == 350, "{own:?}");
    }
}

#[test]
fn sides_of_houses_have_the_colour_of_their_walls() {
    let wall = Span { cuts: [Cut::wall(128, 20), Cut::NONE, Cut::NONE], ..PILLAR };
    let within = Span { side: PILLAR.top, ..PILLAR };
    let house = |x: u32, _| vec![if x == 0 { wall } else { within }];
    let spans = coarse(2, house);
    let [span] = spans.at(0) else { panic!("{:?}", spans.at(0)) };
    let off = span.side.iter().zip(PILLAR.side).map(|(own, wanted)| own.abs_diff(wanted)).max();
    assert!(off < Some(12), "{span:?}");
}

proptest! {
    #[test]
    fn walls_leave_the_share_that_is_asked_for(share in 0.001..0.999_f32, facing in 0..=255_u8) {
        let normal = Cut::wall(facing, 0).normal();
        let (area, _) = covered([(normal, distance_of(share, normal))].into_iter());
        prop_assert!((area - share).abs() < 1e-5, "{} for {}", area, share);
    }

    /// A wall across the page: each cell has the share that its voxels have, and nothing of the wall moves by more than steps take.
    #[test]
    fn straight_walls_stay_where_they_are(
        shift in 1..=2_u8, facing in 0..=255_u8, place in (4.0..12.0_f32, 4.0..12.0_f32),
    ) {
        let normal = Cut::wall(facing, 0).normal();
        // Sides of voxels from the wall to a voxel's centre.
        let before = |x: u32, y: u32| {
            normal[0] * (place.0 - x as f32 - 0.5) + normal[1] * (place.1 - y as f32 - 0.5)
        };
        let wall = |x: u32, y: u32| match before(x, y) {
            distance if distance > 0.75 => vec![PILLAR],
            distance if distance < -0.75 => Vec::new(),
            distance => {
                let steps = (distance * Cut::STEPS).round() as i32;
                vec![Span { cuts: [Cut::wall(facing, steps), Cut::NONE, Cut::NONE], ..PILLAR }]
            }
        };

        let side = 1_u32 << shift;
        let spans = coarse(shift, wall);
        for (cell, own) in cells(&spans) {
            let first = [cell as u32 % BLOCK_SIDE * side, cell as u32 / BLOCK_SIDE * side];
            let voxels = (0..side * side).map(|voxel| wall(first[0] + voxel % side, first[1] + voxel / side));
            let share = |spans: &[Span]| spans.iter().map(|span| covered(span.walls()).0).sum::<f32>();
            let wanted = voxels.map(|spans| share(&spans)).sum::<f32>() / (side * side) as f32;
            prop_assert!((share(own) - wanted).abs() < 0.05, "{} for {} in {:?}", share(own), wanted, own);
            for span in own.iter().filter(|span| span.cuts[0].is_wall()) {
                let turned = span.cuts[0].facing.wrapping_sub(facing) as i8;
                let is_narrow = !(0.1..0.9).contains(&wanted);
                prop_assert!(is_narrow || turned.unsigned_abs() < 24, "{} off in {:?}", turned, span);
            }
        }
    }
}
