use glam::{DVec2, dvec2};

use super::super::kinds::{Building, Meaning, Rise, Roof, RoofShape, Top};
use super::testing::{HEIGHTS, at, house, level, of_area, raised, rectangle, square};
use super::{Bound, PlacedSolid, Solid, Square, Wall, bind};
use hedgehop::voxel::Span;

/// Whether a span's plan holds a place, and the height of its upper end there.
fn top_over(span: &Span, centre: DVec2, spacing: f64, place: DVec2) -> Option<f64> {
    let from = place - centre;
    for (normal, distance) in span.walls() {
        let normal = dvec2(f64::from(normal[0]), f64::from(normal[1]));
        // A place on a ridge may lie to either side of it.
        if normal.dot(from) > f64::from(distance) * spacing + 1e-6 {
            return None;
        }
    }
    let slope = dvec2(f64::from(span.slopes()[0]), f64::from(span.slopes()[1]));
    HEIGHTS.decode(span.high).map(|high| high + slope.dot(from))
}

/// Greatest error of encoded roofs over places within a footprint, metres, against a formula in its own frame; every place has a roof.
fn roof_error(shape: RoofShape, half: DVec2, formula: impl Fn(DVec2) -> f64) -> f64 {
    let mut worst: f64 = 0.0;
    for step in 0..24 {
        let step = f64::from(step);
        let (square, turn) = (square(0.5), DVec2::from_angle(0.13 * step));
        let middle = at(15.0 + 0.11 * step, 12.0 + 0.07 * step);
        let building = Meaning::Building(house(shape, Rise::Height(3.0)));
        let bound = bind(&building, &of_area(rectangle(middle, half, turn)), 7, &level);
        let mut over: Vec<Vec<Span>> = vec![Vec::new(); square.columns * square.rows];
        for PlacedSolid { voxel: index, solid } in raised(&bound, &square, &level) {
            over[index].extend(solid.encode(&HEIGHTS, square.spacing));
        }

        for (index, spans) in over.iter().enumerate() {
            let centre = square.centre(index % square.columns, index / square.columns);
            for sample in 0..23 * 23 {
                let within = dvec2(f64::from(sample % 23) - 11.0, f64::from(sample / 23) - 11.0) / 22.5;
                let place = centre + within * square.spacing;
                let local = turn.rotate_inverse_of(place - middle);
                // Walls are stored in steps, and next to nothing of a voxel may be left out.
                if local.abs().cmplt(half - 0.02).all() {
                    let tops = spans.iter().filter_map(|span| top_over(span, centre, square.spacing, place));
                    let top = tops.fold(f64::NEG_INFINITY, f64::max);
                    worst = worst.max((top - (106.0 + formula(local))).abs());
                }
            }
        }
    }

    worst
}

trait Turned {
    fn rotate_inverse_of(self, place: DVec2) -> DVec2;
}

impl Turned for DVec2 {
    fn rotate_inverse_of(self, place: DVec2) -> DVec2 {
        dvec2(self.x, -self.y).rotate(place)
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures are what documents say")]
fn roofs_are_within_a_step_of_their_height() {
    // Half a step of a height, and half a step of a slope at a voxel's corner.
    let half = dvec2(8.0, 4.0);
    let wide = dvec2(4.1, 4.0);
    let gabled = roof_error(RoofShape::Gabled, half, |p| 3.0 * (1.0 - p.y.abs() / 4.0));
    let flat = roof_error(RoofShape::Flat, half, |_| 0.0);
    let hips = |half: DVec2| move |p: DVec2| 3.0 * ((half.x - p.x.abs()).min(4.0 - p.y.abs()) / 4.0).min(1.0);
    let hipped = roof_error(RoofShape::Hipped, half, hips(half));

    // A ridge of 0.2 m, less than a voxel: each side has three joints.
    let short = roof_error(RoofShape::Hipped, wide, hips(wide));
    let pyramid =
        roof_error(RoofShape::Pyramidal, half, |p| 3.0 * (1.0 - (p.x.abs() / 8.0).max(p.y.abs() / 4.0)));

    // Straight between rings of the ellipsoid.
    let dome = roof_error(RoofShape::Dome, half, |p| {
        let out = (p.x.abs() / 8.0).max(p.y.abs() / 4.0);
        let rings = [0.0_f64, 15.0, 30.0, 45.0, 60.0, 90.0].map(|ring| ring.to_radians().sin_cos());
        let between = |pair: &[(f64, f64)]| {
            pair[0].1 + (pair[1].1 - pair[0].1) * (out - pair[0].0) / (pair[1].0 - pair[0].0)
        };
        3.0 * rings.windows(2).map(between).fold(f64::INFINITY, f64::min)
    });

    println!(
        "flat {flat:.3} m, gabled {gabled:.3}, hipped {hipped:.3}, a short ridge {short:.3}, pyramid {pyramid:.3}, dome {dome:.3}"
    );
    for error in [flat, gabled, hipped, short, pyramid, dome] {
        assert!(error < HEIGHTS.scale, "{error}");
    }
}

/// The surface over each voxel, as pages have it: the highest solid that holds its centre.
fn surfaces(bound: &[Bound], square: &Square) -> Vec<f64> {
    let mut heights = vec![f64::NEG_INFINITY; square.columns * square.rows];
    for PlacedSolid { voxel: index, solid } in raised(bound, square, &level) {
        if solid.wall.holds_centre() {
            heights[index] = heights[index].max(solid.high_m);
        }
    }
    heights
}

#[test]
fn surfaces_of_houses_do_not_depend_on_the_square_that_asks() {
    let shapes = [
        RoofShape::Flat,
        RoofShape::Gabled,
        RoofShape::Hipped,
        RoofShape::Pyramidal,
        RoofShape::Skillion,
        RoofShape::Dome,
    ];

    // On borders and centres of voxels, and thin, where ties are.
    let halves = [dvec2(6.0, 6.0), dvec2(4.0, 0.5), dvec2(0.25, 3.0), dvec2(2.5, 1.0)];
    let places = [dvec2(12.0, 9.0), dvec2(10.0, 8.5), dvec2(11.13, 7.77)];
    for (spacing, shape) in [0.25, 0.5].into_iter().flat_map(|spacing| shapes.map(|shape| (spacing, shape))) {
        for (half, place) in halves.into_iter().flat_map(|half| places.map(|place| (half, place))) {
            for turn in [0.0, std::f64::consts::FRAC_PI_4, 0.3] {
                let outline = rectangle(at(place.x, place.y), half, DVec2::from_angle(turn));
                let building = Meaning::Building(house(shape, Rise::Height(3.0)));
                let bound = bind(&building, &of_area(outline), 7, &level);
                let whole = Square { columns: 100, rows: 80, ..square(spacing) };
                let all = surfaces(&bound, &whole);

                for from in [11, 30, 48] {
                    let part = Square { first: [from, from - 9], columns: 37, rows: 29, ..whole };
                    let some = surfaces(&bound, &part);
                    for (index, found) in some.into_iter().enumerate() {
                        let [column, row] = [index % part.columns, index / part.columns];
                        let (column, row) = (column + from as usize, row + from as usize - 9);
                        if column < whole.columns && row < whole.rows {
                            let expected = all[whole.index(column, row)];
                            let is_same = expected == found || (expected - found).abs() < 1e-6;
                            assert!(
                                is_same,
                                "{shape:?} {half} at {place} turned {turn}, {spacing}: {expected} {found}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn roofs_over_wide_voxels_rise_little_above_their_ridges() {
    for shape in [RoofShape::Gabled, RoofShape::Hipped, RoofShape::Pyramidal, RoofShape::Dome] {
        for (spacing, half) in [(1.0, dvec2(3.0, 0.5)), (10.0, dvec2(4.0, 3.0)), (300.0, dvec2(4.0, 4.0))] {
            let outline = rectangle(at(12.3, 9.1), half, DVec2::from_angle(0.3));
            let bound =
                bind(&Meaning::Building(house(shape, Rise::Height(3.0))), &of_area(outline), 7, &level);
            let solids = raised(&bound, &square(spacing), &level);
            let high = solids.iter().map(|PlacedSolid { solid, .. }| solid.high_m).fold(0.0, f64::max);
            // By half of its own height eastward and northward.
            assert!(high < 109.0 + 3.0, "{shape:?} {spacing}: {high}");
            let highest = bound.iter().map(|bound| bound.highest(100.0, spacing)).fold(0.0, f64::max);
            assert!(high <= highest + 1e-9, "{shape:?} {spacing}: {high} {highest}");
        }
    }
}

#[test]
fn ridges_and_eaves_have_the_height_that_is_said() {
    let footprint = of_area(rectangle(at(15.0, 12.0), dvec2(8.0, 4.0), DVec2::X));
    for (building, eaves, ridge) in [
        (Building { top: Top::Ridge(11.0), ..house(RoofShape::Gabled, Rise::Height(4.0)) }, 107.0, 111.0),
        (house(RoofShape::Gabled, Rise::Angle(45.0)), 106.0, 110.0),
        (house(RoofShape::Hipped, Rise::Angle(45.0)), 106.0, 110.0),
        (house(RoofShape::Skillion, Rise::Height(2.0)), 106.0, 108.0),
        (house(RoofShape::Dome, Rise::Height(5.0)), 106.0, 111.0),
    ] {
        let bound = bind(&Meaning::Building(building), &footprint, 7, &level);
        let [Bound::Building(house)] = &bound[..] else { panic!() };
        assert!((house.top_m() - ridge).abs() < 1e-9, "{building:?}: {}", house.top_m());
        let solids = raised(&bound, &square(0.5), &level);

        // Of a ridge, the side that holds the voxel's centre.
        let holds =
            |solid: &&Solid| !matches!(solid.wall, Wall::Plane { distance_m, .. } if distance_m < 0.0);
        let high = solids
            .iter()
            .map(|PlacedSolid { solid, .. }| solid)
            .filter(holds)
            .map(|solid| solid.high_m)
            .fold(0.0, f64::max);
        let low = solids.iter().map(|PlacedSolid { solid, .. }| solid.high_m).fold(f64::INFINITY, f64::min);

        // Centres of voxels lie up to a quarter of a metre from ridge and eaves.
        assert!(ridge - high < 0.3 && high <= ridge + 1e-9, "{building:?}: {high}");
        let is_dome = building.roof.shape == RoofShape::Dome;
        assert!((low - eaves).abs() < 0.3 || is_dome, "{building:?}: {low}");
    }
}

#[test]
fn roofs_look_where_they_are_said_to() {
    let footprint = of_area(rectangle(at(15.0, 12.0), dvec2(8.0, 4.0), DVec2::X));
    let slope_at = |roof: Roof, place: DVec2| {
        let bound = bind(
            &Meaning::Building(Building { roof, ..house(RoofShape::Flat, Rise::Height(0.0)) }),
            &footprint,
            1,
            &level,
        );
        let square = square(0.5);
        let inside = |PlacedSolid { voxel: index, .. }: &&PlacedSolid| {
            let centre = square.centre(index % square.columns, index / square.columns);
            (centre - place).abs().max_element() < 0.26
        };

        raised(&bound, &square, &level)
            .iter()
            .find(inside)
            .map(|PlacedSolid { solid, .. }| DVec2::from(solid.slope))
            .unwrap()
    };

    let roof = house(RoofShape::Skillion, Rise::Height(2.0)).roof;
    // Water runs off to the east.
    let east = slope_at(Roof { direction: Some(90.0), ..roof }, at(15.1, 12.1));
    assert!((east - dvec2(-2.0 / 16.0, 0.0)).length() < 1e-9, "{east}");
    let gabled = Roof { shape: RoofShape::Gabled, ..roof };
    let north_side = slope_at(gabled, at(15.1, 14.1));
    assert!((north_side - dvec2(0.0, -0.5)).length() < 1e-9, "{north_side}");
    let across = slope_at(Roof { across: true, ..gabled }, at(19.1, 12.1));
    assert!((across - dvec2(-0.25, 0.0)).length() < 1e-9, "{across}");

    // Hips at both ends: of a ridge across they take half of the shorter side.
    let hipped = Roof { shape: RoofShape::Hipped, ..roof };
    for across in [Roof { across: true, ..hipped }, Roof { direction: Some(270.0), ..hipped }] {
        for (place, expected) in [(at(19.1, 12.1), dvec2(-0.25, 0.0)), (at(15.1, 15.6), dvec2(0.0, -1.0))] {
            let slope = slope_at(across, place);
            assert!((slope - expected).length() < 1e-9, "{place}: {slope}");
        }
    }

    for along in [hipped, Roof { direction: Some(0.0), ..hipped }] {
        for (place, expected) in [(at(15.1, 14.1), dvec2(0.0, -0.5)), (at(22.6, 12.1), dvec2(-0.5, 0.0))] {
            let slope = slope_at(along, place);
            assert!((slope - expected).length() < 1e-9, "{place}: {slope}");
        }
    }
}

#[test]
fn crooked_houses_have_hips_from_their_walls() {
    let corners = [(5.0, 5.0), (25.0, 5.0), (25.0, 13.0), (13.0, 13.0), (13.0, 25.0), (5.0, 25.0)];
    let building = house(RoofShape::Hipped, Rise::Angle(45.0));
    let bound =
        bind(&Meaning::Building(building), &of_area(corners.map(|(x, y)| at(x, y)).into()), 1, &level);
    let [Bound::Building(house)] = &bound[..] else { panic!() };

    // As high over both wings, each 8 m wide.
    assert!((house.top_m() - 110.0).abs() < 0.02, "{}", house.top_m());
    let mut worst: f64 = 0.0;
    let square = square(0.5);
    let mut tops = std::collections::BTreeMap::new();

    for PlacedSolid { voxel: index, solid } in raised(&bound, &square, &level) {
        let centre = square.centre(index % 64, index / 64);
        let Some(span) = solid.encode(&HEIGHTS, square.spacing) else { continue };
        for sample in 0..25 {
            let within =
                dvec2(f64::from(sample % 5) - 2.0, f64::from(sample / 5) - 2.0) * (0.24 * square.spacing);
            let place = centre + within;
            if let Some(top) = top_over(&span, centre, square.spacing, place) {
                let known = tops.entry((index, sample)).or_insert((place, top));
                known.1 = known.1.max(top);
            }
        }
    }

    for (place, top) in tops.into_values() {
        let (x, y) = (place - at(0.0, 0.0)).into();
        // Walls are stored in steps.
        let is_inside = x.min(y) > 5.02 && x.max(y) < 24.98 && x.min(y) < 12.98;
        if is_inside {
            let valley = (13.0 - x).max(13.0 - y);
            let expected = 106.0 + (x - 5.0).min(y - 5.0).min(25.0 - x).min(25.0 - y).min(valley);
            worst = worst.max((top - expected).abs());
        }
    }

    assert!(worst < HEIGHTS.scale, "{worst}");
}

#[test]
fn roofs_over_needles_are_no_higher_than_they_are_said_to_be() {
    let needle = vec![at(10.0, 12.0), at(40.0, 12.0), at(40.0, 12.02)];
    for shape in
        [RoofShape::Pyramidal, RoofShape::Hipped, RoofShape::Gabled, RoofShape::Skillion, RoofShape::Dome]
    {
        let bound =
            bind(&Meaning::Building(house(shape, Rise::Height(5.0))), &of_area(needle.clone()), 1, &level);
        let [Bound::Building(house)] = &bound[..] else { panic!() };
        let square = square(0.5);
        let highest = house.highest(square.spacing);
        assert!(highest <= house.top_m() + 4.0, "{shape:?}: {highest}");
        for PlacedSolid { solid, .. } in raised(&bound, &square, &level) {
            let rise = 0.5 * square.spacing * (solid.slope[0].abs() + solid.slope[1].abs());
            assert!(solid.high_m + rise <= highest + 1e-6, "{shape:?}: {solid:?}");
        }
    }
}

#[test]
fn a_pyramid_of_many_corners_is_a_cone_of_few_solids() {
    let middle = at(15.0, 12.0);
    let corners = (0..500)
        .map(|index| middle + DVec2::from_angle(std::f64::consts::TAU / 500.0 * f64::from(index)) * 9.0);
    let building = Meaning::Building(house(RoofShape::Pyramidal, Rise::Height(3.0)));
    let bound = bind(&building, &of_area(corners.collect()), 1, &level);
    let square = square(0.5);
    let mut over = vec![0; square.columns * square.rows];
    for PlacedSolid { voxel: index, solid } in raised(&bound, &square, &level) {
        over[index] += 1;
        let centre = square.centre(index % 64, index / 64);
        let from_middle = centre.distance(middle);
        if solid.wall.holds_centre() && from_middle < 8.5 {
            let error = solid.high_m - (109.0 - 3.0 * from_middle / 9.0);
            assert!(error.abs() < HEIGHTS.scale, "{from_middle}: {error}");
        }
    }
    assert!(over.iter().all(|count| *count <= 8), "{:?}", over.iter().max());
}
