use glam::{DVec2, dvec2};
use proptest::prelude::*;

use super::super::layer::{Area, Path};
use super::footprint::{Footprint, VoxelCover};
use super::solid::{Square, Wall};

fn area(outer: Vec<DVec2>, holes: Vec<Vec<DVec2>>) -> Area {
    Area { outer: Path::flat(outer), holes: holes.into_iter().map(Path::flat).collect() }
}

fn rectangle(centre: DVec2, half: DVec2, turn: f64) -> Vec<DVec2> {
    let turn = DVec2::from_angle(turn);
    [dvec2(-1.0, -1.0), dvec2(1.0, -1.0), dvec2(1.0, 1.0), dvec2(-1.0, 1.0)]
        .map(|c| centre + turn.rotate(c * half))
        .into()
}

fn square(spacing: f64) -> Square {
    Square { origin: dvec2(612_000.0, 5_241_000.0), first: [0; 2], spacing, columns: 40, rows: 30 }
}

/// Whether the wall of a voxel leaves a place of it.
fn keeps(cover: &VoxelCover, square: &Square, place: DVec2) -> bool {
    let from = place - square.centre(cover.column, cover.row);
    cover.wall.planes().all(|(facing, distance_m)| DVec2::from_angle(facing).dot(from) <= distance_m)
}

/// Distance of a place from the nearest edge, metres, and the direction away from it.
fn nearest_edge(footprint: &Footprint, place: DVec2) -> (f64, DVec2) {
    let from = |(a, b): (DVec2, DVec2)| {
        let along = ((place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        place - (a + (b - a) * along)
    };
    let away = footprint.edges().map(from).min_by(|a, b| a.length().total_cmp(&b.length())).unwrap();
    (away.length(), away.normalize_or_zero())
}

/// Greatest distance from the outline, in voxels, of a place that is told wrongly: looked at by 16 × 16 places of each voxel.
fn error(footprint: &Footprint, square: &Square) -> f64 {
    let covers = footprint.cover(square);
    let mut by_voxel = vec![None; square.columns * square.rows];
    covers.iter().for_each(|cover| by_voxel[square.index(cover.column, cover.row)] = Some(*cover));
    let mut worst: f64 = 0.0;
    for (column, row) in square.voxels(footprint.bounds) {
        for sample in 0..16 * 16 {
            let within = dvec2(f64::from(sample % 16) + 0.5, f64::from(sample / 16) + 0.5) / 16.0 - 0.5;
            let place = square.centre(column, row) + within * square.spacing;
            let told = by_voxel[square.index(column, row)].is_some_and(|cover| keeps(&cover, square, place));
            if told != footprint.holds(place) {
                worst = worst.max(nearest_edge(footprint, place).0 / square.spacing);
            }
        }
    }
    worst
}

#[test]
fn walls_of_any_direction_are_straight_and_corners_sharp() {
    let mut worst: f64 = 0.0;
    for step in 0..60 {
        let step = f64::from(step);
        let square = square(1.5);
        let centre = square.corner() + dvec2(29.0 + 0.37 * step, 22.0 + 0.11 * step) * 1.0;
        let ring = rectangle(centre, dvec2(9.0, 5.0), 0.1 * step);
        let footprint = Footprint::of(&area(ring.clone(), vec![])).unwrap();
        worst = worst.max(error(&footprint, &square));

        // Away from corners, a wall is the edge itself.
        for cover in footprint.cover(&square) {
            let place = square.centre(cover.column, cover.row);
            if let Wall::Plane { facing, distance_m } = cover.wall
                && ring.iter().all(|corner| corner.distance(place) > 1.5 * square.spacing)
            {
                let (distance, away) = nearest_edge(&footprint, place);
                let inward = if footprint.holds(place) { away } else { -away };
                let signed = if footprint.holds(place) { distance } else { -distance };
                assert!(DVec2::from_angle(facing).dot(-inward) > 1.0 - 1e-9);
                assert!((distance_m - signed).abs() < 1e-6);
            }
        }
    }

    assert!(worst < 0.02, "{worst}");
}

#[test]
fn walls_along_borders_of_voxels_are_walls_however_they_are_rounded() {
    let square = square(1.0);
    let ring = rectangle(square.corner() + dvec2(15.0, 15.0), dvec2(10.0, 8.0), 0.0);
    for nudge in [f64::next_down, |metres| metres, f64::next_up] {
        let ring = ring.iter().map(|place| dvec2(nudge(place.x), nudge(place.y))).collect();
        let covers = Footprint::of(&area(ring, vec![])).unwrap().cover_with_walls(&square);
        assert_eq!(covers.len(), 20 * 16);
        for cover in covers {
            let is_outermost = [5, 24].contains(&cover.column) || [7, 22].contains(&cover.row);
            assert_eq!(cover.wall != Wall::Whole, is_outermost, "{} {}", cover.column, cover.row);
        }
    }
}

#[test]
fn walls_along_borders_leave_all_of_voxels_beyond_their_ends() {
    // A corner that points inward, on a border of voxels and a little beside it.
    for off in [0.0, 0.01, -0.01, 0.03] {
        let corners = [(4.0, 4.0), (24.0, 4.0), (24.0, 13.0), (13.0, 13.0), (13.0, 22.0), (4.0, 22.0)];
        let square = square(1.0);
        let outline = corners.map(|(x, y)| square.corner() + dvec2(x + off, y + off)).to_vec();
        let footprint = Footprint::of(&area(outline, vec![])).unwrap();
        let mut left = 0.0;
        for cover in footprint.cover_with_walls(&square).iter().filter(|cover| cover.share > 0.999_999) {
            let sides = cover
                .wall
                .planes()
                .map(|(facing, distance_m)| distance_m - 0.5 * DVec2::from_angle(facing).abs().element_sum());
            left += 1.0;
            assert!(sides.fold(0.0, f64::min) > -1e-5, "{} {}: {:?}", cover.column, cover.row, cover.wall);
        }
        assert!(left > 200.0, "{left}");
    }
}

#[test]
fn areas_add_up_whatever_the_form() {
    let square = square(1.0);
    let at = |x: f64, y: f64| square.corner() + dvec2(x, y);
    let star: Vec<DVec2> = (0..14)
        .map(|i| {
            at(20.0, 15.0)
                + DVec2::from_angle(0.448_798_95 * f64::from(i)) * if i % 2 == 0 { 11.0 } else { 4.0 }
        })
        .collect();
    let touching = vec![at(2.0, 2.0), at(8.0, 2.0), at(8.0, 8.0), at(5.0, 2.0), at(2.0, 8.0)];

    let doubled = vec![
        at(2.0, 2.0),
        at(2.0, 2.0),
        at(9.3, 2.0),
        at(9.3, 2.0),
        at(9.3, 7.7),
        at(2.0, 7.7),
        at(2.0, 2.0),
    ];

    let tiny = rectangle(at(7.3, 9.4), dvec2(0.2, 0.3), 0.4);
    let holed = area(
        rectangle(at(20.0, 15.0), dvec2(12.0, 9.0), 0.3),
        vec![rectangle(at(20.0, 15.0), dvec2(5.0, 3.0), 1.0)],
    );

    for area in [area(star, vec![]), area(touching, vec![]), area(doubled, vec![]), area(tiny, vec![]), holed]
    {
        let mut turned = area.clone();
        turned.outer.places.reverse();
        for area in [area, turned] {
            let footprint = Footprint::of(&area).unwrap();
            let covers = footprint.cover(&square);
            let sum: f64 = covers.iter().map(|cover| cover.share).sum();
            // Shares below a 256th are nothing, and so near to all they are all.
            assert!(
                (sum - footprint.area()).abs() < 0.003 * covers.len() as f64 + 1e-6,
                "{sum} {}",
                footprint.area()
            );
            assert!(covers.iter().all(|cover| cover.share > 0.0 && cover.share <= 1.0));
        }
    }
}

#[test]
fn voxels_do_not_depend_on_the_square_that_asks() {
    let whole = square(1.0);
    let footprint =
        Footprint::of(&area(rectangle(whole.corner() + dvec2(20.0, 15.0), dvec2(9.0, 6.0), 0.5), vec![]))
            .unwrap();
    let part = Square { first: [16, 8], columns: 9, rows: 11, ..whole };
    let all = footprint.cover(&whole);
    let some = footprint.cover(&part);
    let shifted: Vec<VoxelCover> = all
        .iter()
        .filter(|cover| (16..25).contains(&cover.column) && (8..19).contains(&cover.row))
        .map(|cover| VoxelCover { column: cover.column - 16, row: cover.row - 8, ..*cover })
        .collect();
    assert_eq!(shifted.len(), some.len());

    for (a, b) in shifted.iter().zip(&some) {
        assert_eq!((a.column, a.row), (b.column, b.row));
        assert!((a.share - b.share).abs() < 1e-9);
        if let (Wall::Plane { facing: f, distance_m: d }, Wall::Plane { facing: g, distance_m: e }) =
            (a.wall, b.wall)
        {
            assert!((f - g).abs() < 1e-6 && (d - e).abs() < 1e-6, "{a:?} {b:?}");
        }
    }
}

#[test]
fn walls_through_centres_lie_there_whichever_square_asks() {
    for step in 0..40 {
        let whole = square(1.0);
        let (middle, half) = (dvec2(20.0, 14.9 + 0.0137 * f64::from(step)), dvec2(13.5, 11.3));
        let footprint = Footprint::of(&area(rectangle(whole.corner() + middle, half, 0.0), vec![])).unwrap();
        for first in 0..20 {
            let part = Square { first: [2, first], rows: 9, ..whole };
            for cover in footprint.cover(&part) {
                if let (Wall::Plane { distance_m, .. }, 4 | 31) = (cover.wall, cover.column) {
                    let is_corner = cover.share < 0.5;
                    assert!(is_corner || distance_m == 0.0, "{first}: {cover:?}");
                }
            }
        }
    }
}

#[test]
fn what_encloses_nothing_is_nothing() {
    let line = vec![dvec2(0.0, 0.0), dvec2(5.0, 5.0), dvec2(9.0, 9.0)];
    assert_eq!(Footprint::of(&area(line, vec![])), None);
    assert_eq!(Footprint::of(&area(vec![dvec2(1.0, 1.0); 5], vec![])), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_ring_is_covered_without_harm(places in prop::collection::vec((-60.0..60.0_f64, -60.0..60.0_f64), 3..12)) {
        let square = square(1.0);
        let ring = places.into_iter().map(|(x, y)| square.corner() + dvec2(x, y)).collect();
        if let Some(footprint) = Footprint::of(&area(ring, vec![])) {
            for cover in footprint.cover(&square) {
                prop_assert!(cover.column < 40 && cover.row < 30 && cover.share > 0.0 && cover.share <= 1.0);
                if let Wall::Plane { facing, distance_m } = cover.wall {
                    prop_assert!(facing.is_finite() && distance_m.abs() < 1.0);
                }
            }
        }
    }
}
