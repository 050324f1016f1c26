use glam::{DVec2, dvec2};
use proptest::prelude::*;

use super::super::kinds::{
    Barrier, Cap, Leaf, Meaning, Paint, PowerLine, Rise, RoofShape, Tree, Upright, Way, WayKind, Wire, Wood,
};
use super::testing::{
    HEIGHTS, PAINT, at, hills, house, level, natural, of_area, of_line, of_point, raised, rectangle, road,
    square,
};
use super::{Bound, PlacedSolid, Solid, Square, Wall, bind, settle};
use hedgehop::voxel::{HeightCode, Material, Span};

#[test]
fn roads_are_as_wide_as_they_are_said_to_be() {
    let mut worst: f64 = 0.0;
    for (spacing, width) in [(1.0, 6.5), (1.0, 3.0), (2.5, 6.0), (2.5, 1.2), (0.5, 7.0)] {
        for step in 0..16 {
            let square = square(spacing);
            let middle = square.corner() + (dvec2(32.0, 24.0) + (0.31 * f64::from(step)).fract()) * spacing;
            let direction = DVec2::from_angle(0.2 * f64::from(step)) * 500.0;

            let bound = bind(
                &Meaning::Way(road(width)),
                &of_line(&[middle - direction, middle + direction]),
                1,
                &level,
            );
            let graded = bound[0].grade(&square, &natural(&square, &level));

            // Across the road, in the columns or rows that it crosses most steeply.
            let is_flat = direction.x.abs() > direction.y.abs();
            let foreshortened = direction.normalize().abs().max_element();
            for line in 20..26 {
                let painted: f64 = graded
                    .iter()
                    .filter(
                        |graded| if is_flat { graded.index % 64 == line } else { graded.index / 64 == line },
                    )
                    .filter_map(|graded| graded.paint.map(|(_, share)| share))
                    .sum();
                worst = worst.max((painted - width / spacing / foreshortened).abs());
            }
        }
    }

    // In voxels; 0.5 is what is asked for.
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn bends_are_mitred_and_sharp_ones_bevelled() {
    let painted = |places: &[DVec2], place: DVec2| {
        let square = square(0.5);
        let bound =
            bind(&Meaning::Way(Way { kind: WayKind::Runway, ..road(8.0) }), &of_line(places), 1, &level);
        let graded = bound[0].grade(&square, &natural(&square, &level));
        let local = (place - square.corner()) / square.spacing;
        let index = square.index(local.x as usize, local.y as usize);
        graded
            .iter()
            .find(|graded| graded.index == index)
            .and_then(|graded| graded.paint)
            .is_some_and(|(_, share)| share > 0.99)
    };

    // A right angle: its outer corner is there, 4 m to either side.
    let right = [at(2.0, 6.0), at(22.0, 6.0), at(22.0, 22.0)];
    assert!(painted(&right, at(25.6, 2.4)));
    assert!(!painted(&right, at(26.4, 2.4)) && !painted(&right, at(25.6, 1.6)));

    // Almost back: a mitre would reach 20 m ahead, the bevel ends with the edges.
    let sharp = [at(2.0, 10.0), at(15.0, 10.0), at(2.0, 15.0)];
    assert!(painted(&sharp, at(14.4, 6.5)) && painted(&sharp, at(15.3, 10.0)));
    assert!(!painted(&sharp, at(16.6, 10.0)) && !painted(&sharp, at(16.1, 6.4)));

    // A runway ends with its line.
    assert!(painted(&right, at(2.4, 6.0)) && !painted(&right, at(1.4, 6.0)));
}

#[test]
fn ground_is_graded_to_the_road_and_its_shoulders() {
    let square = square(1.0);
    let bound = bind(&Meaning::Way(road(6.0)), &of_line(&[at(-100.0, 24.2), at(300.0, 24.2)]), 1, &hills);
    let ground = natural(&square, &hills);
    let graded = bound[0].grade(&square, &ground);
    let mut heights = ground.clone();
    graded.iter().for_each(|graded| heights[graded.index] = graded.height_m.unwrap_or(heights[graded.index]));
    let row = |row: usize, column: usize| heights[square.index(column, row)];

    for column in 0..63 {
        // Along the road no steeper than a tenth; across it, only the cross-slope.
        assert!((row(24, column + 1) - row(24, column)).abs() <= 0.1 + 1e-9);
        let fall = row(24, column) - row(22, column);
        assert!((fall - 0.02 * (1.7 - 0.3)).abs() < 1e-9, "{fall}");
    }

    for column in 0..64 {
        for line in 0..20 {
            // Beyond the road, shoulders of 1:1.5, or the ground as it was.
            let (low, high) = (row(line, column), row(line + 1, column));
            let is_natural = [line, line + 1]
                .map(|line| heights[square.index(column, line)] == ground[square.index(column, line)]);
            if is_natural == [false; 2] {
                assert!((high - low).abs() < 1.0 / 1.5 + 1e-6, "{column} {line}: {low} {high}");
            }
        }
    }

    assert!(graded.iter().any(|graded| graded.height_m.is_some() && graded.paint.is_none()));
}

#[test]
fn shoulders_lie_below_ways_and_ways_below_higher_ones() {
    let square = square(1.0);
    let ground = natural(&square, &hills);
    let other = Paint { colour: [1, 2, 3], material: Material::Gravel };
    let lower = bind(&Meaning::Way(road(6.0)), &of_line(&[at(0.0, 24.2), at(64.0, 24.2)]), 1, &hills);
    let upper = Way { layer: 1, paint: other, ..road(4.0) };
    let upper = bind(&Meaning::Way(upper), &of_line(&[at(30.2, 0.0), at(30.2, 48.0)]), 2, &hills);
    let alone = upper[0].grade(&square, &ground);

    for order in [[&lower[0], &upper[0]], [&upper[0], &lower[0]]] {
        let (mut heights, mut surfaces) = (ground.clone(), vec![None; ground.len()]);
        let graded = order.into_iter().flat_map(|bound| bound.grade(&square, &ground)).collect();
        settle(graded, &mut heights, |index, paint, share, _| {
            if share > 0.5 {
                surfaces[index] = Some(paint)
            }
        });
        for graded in alone.iter().filter(|graded| graded.paint.is_some_and(|(_, share)| share > 0.99)) {
            assert_eq!((Some(heights[graded.index]), surfaces[graded.index]), (graded.height_m, Some(other)));
        }

        // Where both have shoulders or one its surface, the surface stays.
        assert_eq!(surfaces[square.index(34, 24)], Some(PAINT));
        assert_eq!(surfaces[square.index(34, 40)], None);
    }
}

#[test]
fn wires_hang_by_the_formula() {
    let (a, b) = (at(3.3, 5.1), at(58.7, 41.9));
    let length = a.distance(b);
    let pylon = Upright {
        height_m: 30.0,
        diameter_m: Some(4.0),
        taper: 0.2,
        cap: Cap::Flat,
        opacity: 0.3,
        paint: PAINT,
    };

    let wires = vec![Wire { offset_m: 0.0, height_m: 20.0 }];
    let power = PowerLine { wires, sag_per_m: 1e-3, pylon, stated: vec![] };
    let ground = |place: DVec2| Some(100.0 + if place.distance(b) < 20.0 { 7.0 } else { 0.0 });
    let bound = bind(&Meaning::PowerLine(power), &of_line(&[a, b]), 1, &ground);
    let sag = 1e-3 * length * length;
    let wire =
        bound.iter().find_map(|bound| if let Bound::Wire(wire) = bound { Some(wire) } else { None }).unwrap();
    assert!((wire.height(0.5).0 - (120.0 + 3.5 - sag)).abs() < 1e-9);
    let square = square(1.0);
    let mut strips = Vec::new();
    wire.raise(&square, &mut strips);
    let mut along: Vec<f64> = Vec::new();

    for PlacedSolid { voxel: index, solid } in &strips {
        let span = solid.encode(&HEIGHTS, 1.0).unwrap();
        let (normal, distance) = span.walls().next().unwrap();
        let centre = square.centre(index % 64, index / 64);
        let nearest = centre + dvec2(f64::from(normal[0]), f64::from(normal[1])) * f64::from(distance);
        let share = (nearest - a).dot(b - a) / (length * length);
        let expected = 120.0 + 7.0 * share - 4.0 * sag * share * (1.0 - share);
        let middle = 0.5 * (solid.high_m + solid.low_m.unwrap());
        assert!((middle - expected).abs() < 0.02, "{share}: {middle} {expected}");
        let (low, high) = (HEIGHTS.decode(span.low).unwrap(), HEIGHTS.decode(span.high).unwrap());
        assert!(low <= expected + 0.05 && high >= expected - 0.05, "{low} {expected} {high}");

        // It runs where the line does.
        assert!((nearest - a).perp_dot((b - a) / length).abs() < 0.03);
        assert!(span.is(Span::STRIP) && span.is(Span::PARALLEL));
        along.push(share * length);
    }

    // No voxel that it crosses is left out: those follow each other closely.
    along.sort_by(f64::total_cmp);
    assert!(along.windows(2).all(|pair| pair[1] - pair[0] < 1.5), "{along:?}");
    assert_eq!(strips.len(), 56 + 37 - 1);
}

/// Whether a place at a height lies in one of the spans over its voxel.
fn is_within(
    square: &Square,
    solids: &[PlacedSolid],
    heights: &HeightCode,
    place: DVec2,
    height_m: f64,
) -> bool {
    let local = square.local(place);
    let index = square.index(local.x as usize, local.y as usize);
    let at = place - square.centre(local.x as usize, local.y as usize);
    solids.iter().filter(|placed| placed.voxel == index).any(|PlacedSolid { solid, .. }| {
        let Some(span) = solid.encode(heights, square.spacing) else { return false };
        let [low, high] = [span.low, span.high].map(|code| heights.offset + heights.scale * f64::from(code));
        let rise = DVec2::from(span.slopes().map(f64::from)).dot(at);
        let is_inside = span.walls().all(|(normal, distance)| {
            let beyond = DVec2::from(normal.map(f64::from)).dot(at) - f64::from(distance) * square.spacing;
            if span.is(Span::STRIP) { beyond.abs() <= 0.5 * (high - low) } else { beyond <= 0.0 }
        });
        let is_dense = span.state & Span::OPACITY == Span::OPAQUE;
        is_dense && is_inside && (low + rise..=high + rise).contains(&height_m)
    })
}

#[test]
fn wires_have_no_gaps_whatever_their_direction() {
    let heights = HeightCode { scale: 0.0093, offset: 0.0 };
    for spacing in [0.5, 1.0, 1.25] {
        let square = square(spacing);
        for degrees in [0.0_f64, 1.0, 20.0, 37.0, 45.0, 63.0, 160.0] {
            let along = DVec2::from_angle(degrees.to_radians()) * (20.0 * spacing);
            let middle = square.corner() + dvec2(32.37, 24.21) * spacing;
            let length = 2.0 * along.length();
            let ends = [middle - along, middle + along];

            let wire = super::BoundWire {
                ends,
                ends_m: [120.0, 123.0],
                sag_m: 1e-3 * length * length,
                thickness_m: 0.04,
            };
            let mut strips = Vec::new();
            wire.raise(&square, &mut strips);
            let steps = (16.0 * length / spacing) as u32;

            for step in 1..steps {
                let share = f64::from(step) / f64::from(steps);
                let (place, height) = (ends[0].lerp(ends[1], share), wire.height(share).0);
                let is_there = is_within(&square, &strips, &heights, place, height);
                assert!(is_there, "nothing at {share} of a wire at {degrees}° over voxels of {spacing} m");
            }
        }
    }
}

#[test]
fn catenaries_differ_by_millimetres() {
    let (length, sag) = (300.0_f64, 9.0_f64);
    // The parameter of the catenary of that sag, by halving.
    let (mut low, mut high) = (100.0_f64, 1e5_f64);
    for _ in 0..200 {
        let middle = low.midpoint(high);
        if middle * ((0.5 * length / middle).cosh() - 1.0) > sag { low = middle } else { high = middle }
    }
    let ends = [at(0.0, 0.0), at(length, 0.0)];
    let wire = super::BoundWire { ends, ends_m: [50.0; 2], sag_m: sag, thickness_m: 0.04 };
    let difference = |share: f64| {
        let hanging = 50.0 - sag + low * (((share - 0.5) * length / low).cosh() - 1.0);
        (wire.height(share).0 - hanging).abs()
    };
    let worst = (0..=100).map(|part| difference(f64::from(part) / 100.0)).fold(0.0, f64::max);
    assert!((worst - sag * (sag / length).powi(2) / 3.0).abs() < 1e-4, "{worst}");
}

#[test]
fn lakes_are_exactly_flat_at_the_level_of_their_shore() {
    let ring: Vec<DVec2> =
        (0..40).map(|i| at(30.0, 24.0) + DVec2::from_angle(0.157 * f64::from(i)) * 17.3).collect();
    let bound = bind(&Meaning::Lake, &of_area(ring.clone()), 1, &hills);
    let square = square(1.0);
    let graded = bound[0].grade(&square, &natural(&square, &hills));
    let heights: Vec<f64> = graded.iter().filter_map(|graded| graded.height_m).collect();
    assert!(heights.len() > 900 && heights.iter().all(|height| *height == heights[0]));
    let shore: Vec<f64> = ring.iter().filter_map(|place| hills(*place)).collect();
    let below = shore.iter().filter(|height| **height < heights[0]).count();
    assert!((2..10).contains(&below), "{below} of 40 places of the shore are below");
    assert!(graded.iter().all(|graded| graded.paint.unwrap().0.material == Material::Water));
}

#[test]
fn bridges_span_valleys_and_leave_the_ground() {
    let valley =
        |place: DVec2| Some(if (at(12.0, 0.0).x..at(52.0, 0.0).x).contains(&place.x) { 80.0 } else { 100.0 });
    let bridge = Way { is_bridge: true, ..road(8.0) };
    let bound = bind(&Meaning::Way(bridge), &of_line(&[at(10.0, 24.0), at(54.0, 24.0)]), 1, &valley);
    let square = square(1.0);

    // Where its ends lie on the banks, these lie below its deck.
    let ground = natural(&square, &valley);
    let mut heights = ground.clone();
    settle(bound[0].grade(&square, &ground), &mut heights, |_, _, _, _| ());

    for (index, (height, natural)) in heights.iter().zip(&ground).enumerate() {
        let centre = square.centre(index % 64, index / 64) - at(0.0, 0.0);
        let is_deck = (10.0..54.0).contains(&centre.x) && (20.0..28.0).contains(&centre.y);
        let expected = if is_deck && *natural > 90.0 { 99.9 } else { *natural };
        assert!((height - expected).abs() < 1e-9, "{centre}: {height}");
    }

    let solids = raised(&bound, &square, &valley);
    let decks: Vec<&Solid> = solids
        .iter()
        .map(|PlacedSolid { solid, .. }| solid)
        .filter(|solid| (solid.high_m - 100.0).abs() < 1e-9)
        .collect();
    assert_eq!(decks.iter().filter(|deck| deck.encode(&HEIGHTS, 1.0).is_some()).count(), 44 * 8);
    assert!(
        decks.iter().all(|deck| deck.low_m.is_some_and(|low| (98.0..99.6).contains(&low)) && deck.parallel)
    );
    assert!(
        solids.iter().any(|PlacedSolid { solid, .. }| solid.low_m.is_none() && solid.high_m < 99.6),
        "no pier"
    );
    assert!(solids.iter().any(|PlacedSolid { solid, .. }| (solid.high_m - 101.0).abs() < 1e-9), "no parapet");

    // On level ground it is raised for what passes below.
    let bound = bind(&Meaning::Way(bridge), &of_line(&[at(-100.0, 24.0), at(160.0, 24.0)]), 1, &level);
    let highest = raised(&bound, &square, &level)
        .iter()
        .map(|PlacedSolid { solid, .. }| solid.high_m)
        .fold(0.0, f64::max);
    assert!((106.0..108.0).contains(&highest), "{highest}");
}

#[test]
fn bridges_have_parapets_along_both_edges_whatever_their_direction() {
    for spacing in [0.5, 1.0, 1.25] {
        let square = square(spacing);
        for (width, aside) in [(8.0, 0.0), (8.0, 1e-6), (8.2, 0.0), (7.3, 0.5)] {
            for degrees in [0.0_f64, 20.0, 45.0, 90.0, 117.0] {
                let direction = DVec2::from_angle(degrees.to_radians());
                let middle = square.corner() + (dvec2(32.0, 24.0) + aside) * spacing;

                // Beyond the square at both ends: the level deck is raised towards its middle.
                let ends = [middle - direction * 200.0, middle + direction * 200.0];
                let bridge = Way { is_bridge: true, ..road(width) };
                let solids =
                    raised(&bind(&Meaning::Way(bridge), &of_line(&ends), 1, &level), &square, &level);
                let deck =
                    solids.iter().map(|PlacedSolid { solid, .. }| solid.high_m).fold(0.0, f64::max) - 1.0;

                for step in -60..=60 {
                    let along = direction * (0.11 * f64::from(step) * spacing);
                    for side in [-1.0, 1.0] {
                        let place =
                            middle + along + direction.perp() * (side * (0.5 * width - spacing / 16.0));
                        let is_there = is_within(&square, &solids, &HEIGHTS, place, deck + 0.5);
                        assert!(
                            is_there,
                            "no parapet at {along} of {width} m at {degrees}°, voxels of {spacing} m"
                        );
                    }

                    // Between them one drives.
                    assert!(!is_within(&square, &solids, &HEIGHTS, middle + along, deck + 0.5));
                }
            }
        }
    }
}

#[test]
fn tanks_domes_and_poles_are_round() {
    let tank = |cap: Cap, diameter: f64, opacity: f64| {
        let upright =
            Upright { height_m: 12.0, diameter_m: Some(diameter), taper: 1.0, cap, opacity, paint: PAINT };
        raised(&bind(&Meaning::Upright(upright), &of_point(at(30.3, 24.6)), 1, &level), &square(1.0), &level)
    };
    let narrowing = |cap: Cap| {
        let upright =
            Upright { height_m: 12.0, diameter_m: Some(20.0), taper: 0.5, cap, opacity: 1.0, paint: PAINT };
        raised(&bind(&Meaning::Upright(upright), &of_point(at(30.3, 24.6)), 1, &level), &square(1.0), &level)
    };
    let flat = tank(Cap::Flat, 20.0, 1.0);
    let share = |wall: Wall| {
        let planes = wall
            .planes()
            .map(|(facing, distance)| super::patch::HalfPlane::towards(facing, distance))
            .collect::<Vec<_>>();
        super::patch::ConvexPatch::voxel(1.0).within_all(planes.iter().enumerate()).area()
    };
    let area: f64 = flat.iter().map(|PlacedSolid { solid, .. }| share(solid.wall)).sum();
    assert!((area - std::f64::consts::PI * 100.0).abs() < 2.0, "{area}");
    assert!(flat.iter().all(|PlacedSolid { solid, .. }| solid.high_m == 112.0 && solid.low_m.is_none()));

    for PlacedSolid { voxel: index, solid } in &flat {
        let outward = square(1.0).centre(index % 64, index / 64) - at(30.3, 24.6);
        let (Wall::Round(facing) | Wall::Plane { facing, .. }) = solid.wall else { continue };
        assert!(DVec2::from_angle(facing).dot(outward) > 0.99 * outward.length(), "{outward}");
    }

    let dome = tank(Cap::Dome, 20.0, 1.0);
    let highest = dome.iter().map(|PlacedSolid { solid, .. }| solid.high_m).fold(0.0, f64::max);
    assert!((highest - 112.0).abs() < 0.05);
    let highest = |solids: &[PlacedSolid]| {
        solids.iter().map(|PlacedSolid { solid, .. }| solid.high_m).fold(0.0, f64::max)
    };

    let plan = |solids: &[PlacedSolid], height: f64| -> f64 {
        let there = |PlacedSolid { solid, .. }: &&PlacedSolid| {
            solid.low_m.is_none_or(|low| low <= height) && solid.high_m > height
        };
        solids.iter().filter(there).map(|PlacedSolid { solid, .. }| share(solid.wall)).sum::<f64>()
    };
    // Narrow at three quarters of its height, and wider again above.
    let tower = narrowing(Cap::Waisted);
    let radii =
        [0.1, 6.0, 9.3, 11.9].map(|height| (plan(&tower, 100.0 + height) / std::f64::consts::PI).sqrt());
    for (radius, expected) in radii.into_iter().zip([9.9, 5.9, 5.0, 6.8]) {
        assert!((radius - expected).abs() < 0.4, "{radii:?}");
    }

    let chimney = narrowing(Cap::Flat);
    let radii = [0.1, 6.0, 11.9].map(|height| (plan(&chimney, 100.0 + height) / std::f64::consts::PI).sqrt());
    for (radius, expected) in radii.into_iter().zip([10.0, 7.5, 5.0]) {
        assert!((radius - expected).abs() < 0.4, "{radii:?}");
    }

    assert!((highest(&tower) - 112.0).abs() < 1e-9 && (highest(&chimney) - 112.0).abs() < 1e-9);
    // Half a metre thick in voxels of a metre: one voxel that hides half.
    let pole = tank(Cap::Flat, 0.5, 1.0);
    assert_eq!((pole.len(), pole[0].solid.opacity), (1, 0.5));
}

#[test]
fn trees_have_crowns_above_their_stems() {
    for leaf in [Leaf::Broad, Leaf::Needle] {
        let tree = Tree { height_m: 16.0, crown_m: 9.0, leaf, paint: PAINT };
        let solids = raised(
            &bind(&Meaning::Trees(tree, 9.0), &of_point(at(20.4, 20.4)), 1, &level),
            &square(0.5),
            &level,
        );

        // The sides of a conifer's tip are as high as at their centres only where they go on to these.
        let highest = |solid: &Solid| match solid.wall {
            Wall::Corner(walls) => {
                let [(a, a_m), (b, b_m)] = walls.map(|(facing, far_m)| (DVec2::from_angle(facing), far_m));
                let edge = dvec2(a_m * b.y - b_m * a.y, b_m * a.x - a_m * b.x) / a.perp_dot(b);
                solid.high_m + edge.dot(solid.slope.into())
            }
            _ => solid.high_m,
        };

        let highest = solids.iter().map(|PlacedSolid { solid, .. }| highest(solid)).fold(0.0, f64::max);
        assert!((115.0..=116.0 + 1e-9).contains(&highest), "{highest}");
        assert_eq!(solids.iter().filter(|PlacedSolid { solid, .. }| solid.low_m.is_none()).count(), 1);
        let crown =
            solids.iter().filter(|PlacedSolid { solid, .. }| solid.low_m.is_some()).count() as f64 * 0.25;
        assert!((crown - std::f64::consts::PI * 4.5 * 4.5).abs() < 4.0, "{crown}");
        assert!(
            solids.iter().all(|PlacedSolid { solid, .. }| solid
                .low_m
                .is_none_or(|low| low >= 100.0 + 0.2 * 16.0 - 1e-9))
        );
    }
}

/// One of each, over hills.
fn everything(middle: DVec2, turn: DVec2) -> Vec<Bound> {
    let ring = rectangle(middle, dvec2(9.0, 5.0), turn);
    let bend = [middle - turn * 30.0, middle, middle + turn.perp() * 25.0];
    let wood = Wood { height_m: 12.0, density: 400.0, leaf: Leaf::Mixed, rows: None };

    let tower = Upright {
        height_m: 20.0,
        diameter_m: Some(9.0),
        taper: 0.6,
        cap: Cap::Waisted,
        opacity: 1.0,
        paint: PAINT,
    };

    let barrier = Barrier { height_m: 2.0, thickness_m: 0.4, opacity: 1.0, paint: PAINT, is_filled: false };
    let power = PowerLine {
        wires: vec![Wire { offset_m: -3.0, height_m: 15.0 }, Wire { offset_m: 3.0, height_m: 15.0 }],
        sag_per_m: 1e-3,
        pylon: Upright { diameter_m: Some(0.4), ..tower },
        stated: vec![],
    };
    let tree = Tree { height_m: 9.0, crown_m: 5.0, leaf: Leaf::Broad, paint: PAINT };

    [
        (Meaning::Building(house(RoofShape::Gabled, Rise::Angle(40.0))), of_area(ring.clone())),
        (Meaning::Lake, of_area(ring.clone())),
        (Meaning::Wood(wood), of_area(ring)),
        (Meaning::Way(road(6.0)), of_line(&bend)),
        (Meaning::Way(Way { is_bridge: true, ..road(5.0) }), of_line(&bend)),
        (Meaning::River(4.0), of_line(&bend)),
        (Meaning::Barrier(barrier), of_line(&bend)),
        (Meaning::PowerLine(power), of_line(&bend)),
        (Meaning::Trees(tree, 7.0), of_line(&bend)),
        (Meaning::Upright(tower), of_point(middle)),
    ]
    .iter()
    .flat_map(|(meaning, geometry)| bind(meaning, geometry, 11, &hills))
    .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn squares_agree_on_what_they_share(x in 5.0..60.0_f64, y in 5.0..40.0_f64, turn in 0.0..6.3_f64, from in 0_usize..40, size in 5_usize..20) {
        let whole = square(1.0);
        let part = Square { first: [from as i64, 13], columns: size, rows: 17, ..whole };
        for bound in everything(at(x, y), DVec2::from_angle(turn)) {
            let place = |square: &Square, index: usize| {
                let centre = square.centre(index % square.columns, index / square.columns) - whole.corner();
                (centre.x as usize, centre.y as usize)
            };
            let shared = |(column, row): &(usize, usize)| (from..(from + size).min(64)).contains(column) && (13..30).contains(row);

            let spans = |square: &Square| {
                let mut out = Vec::new();
                bound.raise(square, &hills, &mut out);
                let mut spans: Vec<_> = out.iter().filter_map(|PlacedSolid { voxel, solid }| Some((place(square, *voxel), solid.encode(&HEIGHTS, 1.0)?))).collect();
                spans.retain(|(place, _)| shared(place));
                spans.sort_by_key(|(place, span)| (*place, span.low, span.high, span.cuts));
                spans
            };

            let (all, some) = (spans(&whole), spans(&part));
            prop_assert_eq!(all.len(), some.len(), "{:?}", bound);
            for (a, b) in all.iter().zip(&some) {
                // Corners of squares differ in their last bits, and codes with them by a step.
                prop_assert!(a.0 == b.0 && a.1.high.abs_diff(b.1.high) <= 1 && a.1.top == b.1.top, "{:?} {:?}", a, b);
            }

            let graded = |square: &Square| {
                let graded = bound.grade(square, &natural(square, &hills));
                let mut graded: Vec<_> = graded.iter().map(|graded| (place(square, graded.index), graded.height_m)).collect();
                graded.retain(|(place, _)| shared(place));
                graded.sort_by_key(|(place, _)| *place);
                graded
            };

            let (all, some) = (graded(&whole), graded(&part));
            prop_assert_eq!(all.len(), some.len());
            for (a, b) in all.iter().zip(&some) {
                prop_assert!(a.0 == b.0 && (a.1.unwrap_or(0.0) - b.1.unwrap_or(0.0)).abs() < 1e-6);
            }

            // Nothing happens beyond the reach.
            let [west, south, east, north] = bound.reach(1.0);
            let mut out = Vec::new();
            bound.raise(&whole, &hills, &mut out);

            for PlacedSolid { voxel: index, solid } in out.iter().filter(|PlacedSolid { solid, .. }| solid.encode(&HEIGHTS, 1.0).is_some()) {
                let centre = whole.centre(index % 64, index / 64);
                prop_assert!(centre.x > west - 0.5 && centre.x < east + 0.5 && centre.y > south - 0.5 && centre.y < north + 0.5);
                prop_assert!(solid.high_m.is_finite() && solid.slope.iter().all(|slope| slope.is_finite()));
            }
        }
    }
}
