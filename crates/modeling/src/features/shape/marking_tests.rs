//! Lines of roads and rows of fields against closed forms.

use glam::{DVec2, dvec2};

use super::super::kinds::{Dashes, FieldRows, LaneLines, Leaf, Meaning, Way, Wood};
use super::super::layer::{Geometry, Junction};
use super::testing::{PAINT, at, level, natural, of_area, of_line, rectangle, road, square};
use super::{Bound, Square, bind};

const LINES: LaneLines = LaneLines {
    lanes: 2,
    is_one_way: false,
    lane_m: 3.5,
    dashes: Dashes { dash_m: 4.0, gap_m: 8.0 },
    width_m: 0.12,
    edge_m: Some(0.12),
    inset_m: 0.25,
};
const WHITE: [u8; 3] = [222, 222, 216];

fn lined(lines: LaneLines) -> Meaning {
    Meaning::Way(Way { lines: Some(lines), ..road(8.0) })
}

/// Area painted in a colour over a wide square of voxels, square metres.
fn painted(bound: &[Bound], square: &Square, colour: Option<[u8; 3]>) -> f64 {
    let natural = natural(square, &level);
    let graded = bound.iter().flat_map(|bound| bound.grade(square, &natural));
    let paints = graded.filter_map(|graded| graded.paint);
    let of_colour = paints.filter(|(paint, _)| colour.is_none_or(|colour| paint.colour == colour));
    of_colour.map(|(_, share)| share).sum::<f64>() * square.spacing * square.spacing
}

/// 2 km around the small square of other tests, in voxels of a side.
fn wide(spacing: f64) -> Square {
    let count = (2048.0 / spacing) as usize;
    let first = [-(count as i64) / 2; 2];
    Square { first, columns: count, rows: count, spacing, ..square(spacing) }
}

#[test]
fn dashes_cover_their_share_of_a_long_road_at_any_level() {
    for spacing in [0.5, 1.0, 4.0, 16.0] {
        for (turn, colour) in [(0.0, WHITE), (0.3, WHITE), (1.2, WHITE)] {
            let half = DVec2::from_angle(turn) * 480.0;
            let line = of_line(&[at(3.3, 7.1) - half, at(3.3, 7.1) + half]);
            let dashes = bind(&lined(LaneLines { edge_m: None, ..LINES }), &line, 1, &level);
            // 80 dashes of 4 m on 960 m.
            let found = painted(&dashes, &wide(spacing), Some(colour));
            let expected = 0.12 * 960.0 / 3.0;
            assert!((found / expected - 1.0).abs() < 0.005, "{spacing} m, {turn}: {found} of {expected} m²");
            let all = bind(&lined(LINES), &line, 1, &level);
            let found = painted(&all, &wide(spacing), Some(colour));
            let expected = expected + 2.0 * 0.12 * 960.0;
            assert!((found / expected - 1.0).abs() < 0.005, "{spacing} m, {turn}: {found} of {expected} m²");
        }
    }
}

#[test]
fn motorways_have_lines_beside_their_hard_shoulder() {
    let lines = LaneLines {
        is_one_way: true,
        lane_m: 3.75,
        dashes: Dashes { dash_m: 6.0, gap_m: 12.0 },
        width_m: 0.15,
        edge_m: Some(0.3),
        inset_m: 0.5,
        ..LINES
    };
    let way = Way { lines: Some(lines), ..road(12.0) };
    // Eastward: the left edge is the northern one.
    let line = of_line(&[at(0.0, 10.0), at(180.0, 10.0)]);
    let bound = bind(&Meaning::Way(way), &line, 1, &level);

    let square = Square { columns: 200, rows: 200, ..square(0.1) };
    let natural = natural(&square, &level);
    let graded = bound.iter().flat_map(|bound| bound.grade(&square, &natural));
    let white = graded.filter(|graded| graded.paint.is_some_and(|(paint, _)| paint.colour == WHITE));
    let mut rows: Vec<(usize, f64)> = Vec::new();
    for graded in white {
        let (row, share) = (graded.index / square.columns, graded.paint.map_or(0.0, |(_, share)| share));
        match rows.iter_mut().find(|known| known.0 == row) {
            Some(known) => known.1 += share,
            None => rows.push((row, share)),
        }
    }

    // Edge lines in the middle at 15.5 and at 8.0 m, the divider at 11.75; in 20 m one gap of 6 m, a dash, and 8 m of the next gap.
    let near = |y: f64, half: f64| -> f64 {
        let within = rows.iter().filter(|(row, _)| ((*row as f64 + 0.5) * 0.1 - y).abs() < half);
        within.map(|(_, share)| share * 0.01).sum()
    };
    assert!((near(15.5, 0.3) - 20.0 * 0.3).abs() < 1e-3, "{}", near(15.5, 0.3));
    assert!((near(8.0, 0.3) - 20.0 * 0.3).abs() < 1e-3, "{}", near(8.0, 0.3));
    assert!((near(11.75, 0.3) - 6.0 * 0.15).abs() < 1e-3, "{}", near(11.75, 0.3));
    let all: f64 = rows.iter().map(|(_, share)| share * 0.01).sum();
    assert!((all - 12.9).abs() < 3e-3, "{all}");
}

#[test]
fn bends_are_covered_once() {
    // A quarter of a circle of 60 m in steps of 5 degrees: an edge line is as long as its own arc.
    let bend: Vec<DVec2> = (0..=18)
        .map(|step| at(10.0, 5.0) + 60.0 * DVec2::from_angle(f64::from(step) * 5f64.to_radians()))
        .collect();
    let bound = bind(&lined(LINES), &of_line(&bend), 1, &level);
    let square = Square { first: [-600; 2], columns: 1400, rows: 1400, ..square(0.1) };
    let found = painted(&bound, &square, Some(WHITE));
    // Chords of radii 60 ± 3.75, and dashes: 94.2 m hold eight.
    let chord = 36.0 * 2.5f64.to_radians().sin();
    let expected = 0.12 * (chord * (60.0 + 3.75) + chord * (60.0 - 3.75) + 8.0 * 4.0);
    assert!((found / expected - 1.0).abs() < 0.005, "{found} of {expected} m²");
    let natural = natural(&square, &level);
    let most = bound[0]
        .grade(&square, &natural)
        .iter()
        .filter_map(|graded| graded.paint)
        .map(|(_, share)| share)
        .fold(0.0, f64::max);
    assert!(most <= 1.0);
}

#[test]
fn lines_end_at_junctions() {
    let line = of_line(&[at(-48.0, 0.0), at(0.0, 0.0), at(48.0, 0.0)]);
    let area = |junctions: Vec<Junction>| {
        let geometry = Geometry { junctions, ..line.clone() };
        painted(&bind(&lined(LINES), &geometry, 1, &level), &wide(1.0), Some(WHITE))
    };
    let junction = |goes_on: bool| vec![Junction { place: at(0.0, 0.0), half_m: 6.0, goes_on }];
    let free = 0.12 * (96.0 / 3.0 + 2.0 * 96.0);
    assert!((area(Vec::new()) - free).abs() < 1e-3);
    // Edges open by 12 m each; in the middle of the road lies a gap and the rims of two dashes, 2 m each.
    assert!((area(junction(true)) - (free - 0.12 * 24.0)).abs() < 1e-3);
    assert!((area(junction(false)) - (free - 0.12 * (24.0 + 4.0))).abs() < 1e-3);
}

#[test]
fn tramlines_and_rows_cover_their_share_of_a_field() {
    for spacing in [0.5, 4.0, 16.0] {
        for turn in [0.0, 0.7] {
            let field = of_area(rectangle(at(20.0, 30.0), dvec2(400.0, 180.0), DVec2::from_angle(turn)));
            for hash in 0..3 {
                let bound = bind(&Meaning::Field(PAINT, FieldRows::Tramlines), &field, hash, &level);
                let plain = painted(&bound, &wide(spacing), Some(PAINT.colour));
                let rows = painted(&bound, &wide(spacing), None) - plain;
                // 360 m hold so many widths of a sprayer, each with two tracks of 0.4 m and 800 m.
                let count = rows / (800.0 * 0.8);
                let steps =
                    [18.0, 21.0, 24.0, 27.0, 36.0].map(|step: f64| (360.0 / step - 0.5).floor() + 1.0);
                let is_whole = steps.iter().any(|step| (count - step).abs() < 0.02);
                assert!(is_whole, "{spacing} m, {turn}: {count} of {steps:?}");
            }

            let wood =
                Wood { height_m: 1.8, density: 1500.0, leaf: Leaf::Broad, rows: Some(FieldRows::Vines) };
            let bound = bind(&Meaning::Wood(wood), &field, 1, &level);
            let found = painted(&bound, &wide(spacing), None);
            let share = found / (800.0 * 360.0);
            assert!((0.19..0.31).contains(&share), "{share}");
        }
    }
}

#[test]
fn vines_stand_in_rows_whichever_square_asks() {
    let field = of_area(rectangle(at(20.0, 20.0), dvec2(30.0, 15.0), DVec2::from_angle(0.4)));
    let wood = Wood { height_m: 1.8, density: 1500.0, leaf: Leaf::Broad, rows: Some(FieldRows::Vines) };
    let bound = bind(&Meaning::Wood(wood), &field, 5, &level);
    let [Bound::Wood(wood)] = &bound[..] else { panic!("{bound:?}") };
    let all = wood.trees(&square(0.5), &level);
    assert!(all.len() > 100, "{}", all.len());
    let left = DVec2::from_angle(0.4).perp();
    let mut across: Vec<f64> = all.iter().map(|tree| left.dot(tree.place - at(20.0, 20.0))).collect();
    across.sort_by(f64::total_cmp);
    across.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    assert!(across.len() <= 16, "{} rows", across.len());
    assert!(across.windows(2).all(|pair| pair[1] - pair[0] > 1.99), "{across:?}");

    // Squares of 16 voxels find the trees on them as the whole one does.
    for (column, row) in [(1, 1), (2, 1), (1, 2), (3, 2)] {
        let part = Square { first: [column * 16, row * 16], columns: 16, rows: 16, ..square(0.5) };
        let [west, south, east, north] = part.bounds();
        let inside = |place: DVec2| (west..east).contains(&place.x) && (south..north).contains(&place.y);
        let count = |trees: &[super::PlacedTree]| trees.iter().filter(|tree| inside(tree.place)).count();
        assert_eq!(count(&wood.trees(&part, &level)), count(&all));
    }
}
