//! What stands on the ground against closed forms.

use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::scenes::{
    APEX, CODE, DENSE, HALF_RIDGE, SIDE, SPACING, hipped, hipped_height, pillar, short_ridge, standing,
    standing_as, village, wood,
};
use hedgehop::earth::Curvature;
use hedgehop::raymarch::{Face, GridRay, LevelBands, Marcher, PageCursor, SolidHit, Solids, Surface};
use hedgehop::voxel::{Cut, MemPages, PageSource, Span};

/// A marcher that sees bare ground everywhere.
fn marcher(pages: &MemPages) -> Marcher<'_> {
    let bands = LevelBands::finest_only().with_bare_ground(&pages.header().grid, 1.0e-9, 0.0, 1.0);
    Marcher::new(pages, bands, Surface::Smooth)
}

/// A ray from a place in units and metres towards another, with its direction in metres.
fn ray(marcher: &Marcher<'_>, from: DVec3, to: DVec3) -> (GridRay, DVec3) {
    let grid = marcher.grid();
    let world = |at: DVec3| (grid.origin + at.truncate() * grid.spacing).extend(at.z);
    let direction = (world(to) - world(from)).normalize();
    (marcher.ray(world(from), direction), direction)
}

/// What a ray meets: hits, what comes through, and the range of the ground.
fn met(pages: &MemPages, from: DVec3, to: DVec3) -> (Vec<SolidHit>, f64, Option<f64>) {
    let mut marcher = marcher(pages);
    let (ray, _) = ray(&marcher, from, to);
    let contact = marcher.first_contact(&ray, 0.0).unwrap();
    let mut hits = Vec::new();
    let left = marcher.solids(&ray, contact.as_ref(), &mut hits).unwrap();
    (hits, left, contact.map(|contact| contact.range))
}

#[test]
fn a_pillar_is_met_on_its_faces_and_the_ground_beside_and_behind_it_is_bare() {
    let pages = standing(|x, y| if (x, y) == (100, 100) { vec![pillar(30.0)] } else { Vec::new() });
    // From the west, half way up: the western side of the voxel.
    let (hits, left, _) = met(&pages, DVec3::new(50.0, 100.5, 15.0), DVec3::new(100.5, 100.5, 15.0));
    assert_eq!((hits.len(), left, hits[0].face), (1, 0.0, Face::Side));
    assert!((hits[0].range - 50.0 * SPACING).abs() < 1e-9 && hits[0].normal == DVec3::NEG_X, "{hits:?}");
    // From above: its upper end.
    let (hits, ..) = met(&pages, DVec3::new(100.2, 100.6, 80.0), DVec3::new(100.3, 100.5, 0.0));
    assert!(hits[0].face == Face::Top && hits[0].normal == DVec3::Z, "{hits:?}");
    // Just beside it: the ground, where the surface would be a slope half a voxel away.
    let (hits, left, ground) = met(&pages, DVec3::new(99.9, 20.0, 10.0), DVec3::new(99.9, 100.5, 0.0));
    assert_eq!((hits.len(), left), (0, 1.0));
    let expected = DVec3::new(0.0, 80.5 * SPACING, 10.0).length();
    assert!((ground.unwrap() - expected).abs() < 1e-6, "{ground:?} {expected}");
}

/// Share of light from behind that rays through a place lose on average to what stands, of 900 level and sinking ones.
///
/// `shift`: log₂ of voxels along the cells that are seen.
fn hidden(pages: &MemPages, shift: u8) -> f64 {
    // From so high above, the coarsest cells are fine enough at any distance.
    let (pixel, clearance) = if shift == 0 { (1.0e-9, 0.0) } else { (0.008, 500.0) };
    let bands = LevelBands::finest_only().with_span_pixels(0.25).with_bare_ground(
        &pages.header().grid,
        pixel,
        clearance,
        1.0,
    );
    let nearest = bands.span_bands()[0];
    assert!(nearest.shift == shift && nearest.end > 900.0, "{nearest:?}");
    let mut marcher = Marcher::new(pages, bands, Surface::Smooth);
    let (mut sum, mut hits) = (0.0, Vec::new());
    for index in 0..900_u32 {
        let across = 100.0 + f64::from(index % 30) * 3.3;
        let turn = f64::from(index / 30 % 5) * 0.3;
        let eye = DVec3::new(60.0, across, 4.0 + 0.5 * f64::from(index / 30));
        let ahead = DVec3::new(turn.cos(), turn.sin(), -0.02);
        let (ray, _) = ray(&marcher, eye, eye + 100.0 * ahead);
        sum += 1.0 - marcher.solids(&ray, None, &mut hits).unwrap();
    }
    sum / 900.0
}

#[test]
fn cells_of_voxels_hide_as_much_as_these() {
    for (name, pages) in [("village", village(false)), ("wood", wood(DENSE)), ("thin wood", wood(3))] {
        let [fine, coarse] = [0, 2].map(|shift| hidden(&pages, shift));
        assert!((coarse - fine).abs() < 0.05, "{name}: {coarse} of the light for {fine}");
    }
}

/// A house of `half` sides, in units, about a point, turned by an angle in radians: voxels by the side whose line is nearest.
fn house(centre: DVec2, half: DVec2, turn: f64, high: f64) -> impl Fn(u32, u32) -> Vec<Span> {
    move |x, y| {
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - centre;
        let sides =
            [(0.0, half.x), (90.0, half.y), (180.0, half.x), (270.0, half.y)].map(|(quarter, half)| {
                let angle = turn + f64::to_radians(quarter);
                (angle, half - DVec2::from_angle(angle).dot(at))
            });
        let (angle, inside) = sides.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        if inside < -0.75 {
            return Vec::new();
        }
        let facing = (angle / std::f64::consts::TAU * 256.0).round().rem_euclid(256.0) as u8;
        let cut = Cut::wall(facing, (inside * f64::from(Cut::STEPS)).round() as i32);
        let cut = if inside > 0.75 { Cut::NONE } else { cut };
        vec![Span { cuts: [cut, Cut::NONE, Cut::NONE], ..pillar(high) }]
    }
}

#[test]
fn walls_are_straight_whatever_their_direction() {
    let (centre, half) = (DVec2::new(160.0, 160.0), DVec2::new(20.0, 12.0));
    let mut worst: f64 = 0.0;
    for turn in [0.0, 10.0, 30.0, 45.0, 71.0_f64].map(f64::to_radians) {
        let pages = standing(house(centre, half, turn, 9.0));
        for quarter in 0..4 {
            let normal = DVec2::from_angle(turn + f64::from(quarter) * std::f64::consts::FRAC_PI_2);
            let distance = if quarter % 2 == 0 { half.x } else { half.y };
            let width = if quarter % 2 == 0 { half.y } else { half.x };
            for step in -8..=8 {
                let beside = normal.perp() * (f64::from(step) / 8.0 * (width - 1.0));
                let (from, to) = (centre + beside + normal * 90.0, centre + beside);
                let (hits, left, _) = met(&pages, from.extend(4.0), to.extend(4.0));
                assert_eq!((left, hits[0].face), (0.0, Face::Side));
                let error = hits[0].range / SPACING - (90.0 - distance);
                worst = worst.max(error.abs());
                let normal = normal.extend(0.0);
                assert!(hits[0].normal.dot(normal) > 0.999, "{turn} {quarter} {step}: {:?}", hits[0].normal);
            }
        }
    }

    assert!(worst < 0.03, "{worst} of a voxel");
}

#[test]
fn roofs_are_planes() {
    // A slope of 0.5 northward over a block of voxels.
    let (low, slope) = (6.0, 0.5);
    let high = |y: u32| low + slope * (f64::from(y) + 0.5 - 100.0) * SPACING;
    let pages = standing(|x, y| {
        let is_house = (100..140).contains(&x) && (100..120).contains(&y);
        if is_house { vec![Span { slope: [0, 16], ..pillar(high(y)) }] } else { Vec::new() }
    });
    for step in 0..200 {
        let to = DVec3::new(101.0 + f64::from(step) * 0.17, 101.0 + f64::from(step) * 0.0907, 0.0);
        let from = DVec3::new(120.0, 95.0, 90.0);
        let to = to.with_z(low + slope * (to.y - 100.0) * SPACING);
        let (hits, left, _) = met(&pages, from, to + (to - from));
        assert_eq!((left, hits[0].face), (0.0, Face::Top));
        let length = ((to - from) * DVec3::new(SPACING, SPACING, 1.0)).length();
        assert!((hits[0].range - length).abs() < 2.0e-3, "{step}: {} {length}", hits[0].range);
        let expected = DVec3::new(0.0, -slope, 1.0).normalize();
        assert!((hits[0].normal - expected).length() < 1e-6);
    }
}

#[test]
fn four_planes_of_a_roof_meet_in_a_point_or_in_a_ridge_shorter_than_a_voxel() {
    assert!(short_ridge(160, 160).iter().filter(|span| span.cuts[2].is_wall()).count() == 2);
    for half_ridge in [0.0, HALF_RIDGE] {
        let pages = standing(|x, y| hipped(half_ridge, x, y));
        assert_eq!(hipped(half_ridge, 160, 160).len(), 4);
        let mut worst: f64 = 0.0;
        for step in 0..400 {
            let away = DVec2::from_angle(f64::from(step) * 0.377);
            let to =
                APEX + away.perp() * (f64::from(step % 41) - 20.0) / 20.0 + away * 0.3 * f64::from(step % 7);
            let to = to.extend(hipped_height(half_ridge, to));
            // From the side that the place is seen from, and flat enough that a joint that stood out would be hit.
            let from = to + (away * 40.0).extend(50.0);
            let (hits, left, _) = met(&pages, from, to + 0.5 * (to - from));
            assert_eq!((left, hits[0].face), (0.0, Face::Top), "{step}");
            let length = ((to - from) * DVec3::new(SPACING, SPACING, 1.0)).length();
            worst = worst.max((hits[0].range - length).abs());
        }

        // A step of a cut is 16 mm.
        assert!(worst < 0.02, "{worst} m");
    }
}

#[test]
fn corners_of_houses_are_sharp() {
    // Of the voxel the south-western quarter is left.
    let corner = Span { cuts: [Cut::wall(0, 0), Cut::wall(64, 0), Cut::NONE], ..pillar(9.0) };
    let pages = standing(|x, y| if (x, y) == (160, 160) { vec![corner] } else { Vec::new() });
    for (from, to, side) in [
        ((200.0, 160.25), (160.0, 160.25), Some((39.5, DVec3::X))),
        ((160.25, 200.0), (160.25, 160.0), Some((39.5, DVec3::Y))),
        ((200.0, 160.75), (160.0, 160.75), None),
        ((160.0, 200.0), (161.0, 160.5), None),
        // A way through the quarter's corner and no more.
        ((164.1, 157.0), (157.1, 164.0), None),
        ((163.9, 156.9), (156.9, 163.9), Some((f64::sqrt(2.0) * 3.4, DVec3::X))),
    ] {
        let (hits, left, _) = met(&pages, DVec2::from(from).extend(4.0), DVec2::from(to).extend(4.0));
        match side {
            None => assert_eq!(left, 1.0, "{from:?}"),
            Some((range, normal)) => {
                assert!((hits[0].range - SPACING * range).abs() < 1e-6, "{from:?} {hits:?}");
                assert!(hits[0].normal.distance(normal) < 1e-6, "{from:?} {hits:?}");
            }
        }
    }
}

#[test]
fn a_bridge_is_flown_under() {
    // A deck from 12 m to 13 m, over rows 150 to 153.
    let deck = Span { low: CODE.encode(12.0), ..pillar(13.0) };
    let pages = standing(|_, y| if (150..154).contains(&y) { vec![deck] } else { Vec::new() });
    let south = |z: f64| DVec3::new(160.3, 100.0, z);
    let level = |from: DVec3| from + DVec3::new(0.0, 50.0, 0.0);
    let (hits, left, _) = met(&pages, south(8.0), level(south(8.0)));
    assert_eq!((hits.len(), left), (0, 1.0), "under it");
    let (hits, _, _) = met(&pages, south(12.5), level(south(12.5)));
    assert!(hits[0].face == Face::Side && (hits[0].range - 50.0 * SPACING).abs() < 1e-9);
    let (hits, ..) = met(&pages, DVec3::new(160.3, 140.0, 2.0), DVec3::new(160.3, 151.0, 12.0));
    assert!(hits[0].face == Face::Bottom && hits[0].normal == DVec3::NEG_Z, "{hits:?}");
    let (.., ground) = met(&pages, DVec3::new(160.3, 145.0, 10.0), DVec3::new(160.3, 165.0, 0.0));
    assert!(
        (ground.unwrap() - DVec3::new(0.0, 20.0 * SPACING, 10.0).length()).abs() < 1e-6,
        "the ground under it"
    );
}

#[test]
fn what_comes_through_leaves_depends_on_the_way_alone() {
    // Leaves of opacity 8/15 per voxel's side.
    let leaf = Span { low: CODE.encode(2.0), state: 8, ..pillar(40.0) };
    let pages = standing(|x, y| {
        let is_in = (100..104).contains(&x) && y > 20 && y < 300;
        if is_in { vec![leaf] } else { Vec::new() }
    });
    let side = 1.0 - 8.0 / 15.0;
    for (dy, dz) in [(0.0, 0.0), (3.0, 0.0), (17.0, 0.0), (60.0, 10.0), (0.3, 20.0)] {
        let from = DVec3::new(90.0, 150.0, 15.0);
        let step = DVec3::new(20.0, dy, dz);
        let (hits, left, _) = met(&pages, from, from + step);
        let way = (step * DVec3::new(SPACING, SPACING, 1.0)).length() / (20.0 * SPACING) * 4.0;
        let expected = f64::powf(f64::from(side as f32), way);
        assert!((left - expected).abs() < 2e-3, "{dy} {dz}: {left} {expected} in {} hits", hits.len());
    }
}

#[test]
fn a_wire_is_a_strip_as_wide_as_it_is_high() {
    // Along x at y = 150.5 units, 10 m high, 0.2 m thick, rising by 0.25.
    let thick = 0.2;
    let pages = standing(|x, y| {
        let high = 10.0 + 0.25 * (f64::from(x) + 0.5 - 100.0) * SPACING;
        let wire = Span {
            low: CODE.encode(high - thick),
            slope: [8, 0],
            cuts: [Cut::wall(64, 0), Cut::NONE, Cut::NONE],
            state: Span::OPAQUE | Span::PARALLEL | Span::STRIP,
            ..pillar(high)
        };
        if y == 150 && (100..200).contains(&x) { vec![wire] } else { Vec::new() }
    });

    let at = |x: f64| 10.0 - 0.5 * thick + 0.25 * (x - 100.0) * SPACING;
    // From the south at its height: met half its width before the line; above and below it: not.
    for x in [100.2, 120.9, 133.0, 177.77] {
        let (hits, ..) = met(&pages, DVec3::new(x, 140.0, at(x)), DVec3::new(x, 150.0, at(x)));
        let expected = 10.5 * SPACING - 0.5 * thick;
        assert!((hits[0].range - expected).abs() < 1e-6, "{} {expected}", hits[0].range);
        for z in [at(x) - 0.6 * thick, at(x) + 0.6 * thick] {
            let (hits, ..) = met(&pages, DVec3::new(x, 140.0, z), DVec3::new(x, 150.0, z));
            assert!(hits.is_empty());
        }

        // From above it is narrow, too.
        for (aside, is_met) in [(0.04, true), (0.06, false)] {
            let over = DVec3::new(x, 150.5 + aside, 90.0);
            let (hits, ..) = met(&pages, over, over.with_z(0.0));
            assert_eq!(!hits.is_empty(), is_met, "{x} {aside}");
        }
    }
}

#[test]
fn a_thin_wire_hides_its_share_of_a_strip() {
    // A third of 0.2 m, hung along x at 10 m.
    let wire = Span {
        low: CODE.encode(9.8),
        cuts: [Cut::wall(64, 0), Cut::NONE, Cut::NONE],
        state: 5 | Span::PARALLEL | Span::STRIP,
        ..pillar(10.0)
    };
    let pages = standing(|x, y| if y == 150 && (100..200).contains(&x) { vec![wire] } else { Vec::new() });
    let left = |from: DVec3, to: DVec3| met(&pages, from, to).1;
    // From the south and from above it is as thick as it is wide; along it, a wall.
    let south = left(DVec3::new(120.3, 140.0, 9.9), DVec3::new(120.3, 160.0, 9.9));
    let above = left(DVec3::new(120.3, 150.5, 90.0), DVec3::new(120.3, 150.5, 0.0));
    assert!((south - 10.0 / 15.0).abs() < 1e-6 && (above - 10.0 / 15.0).abs() < 1e-6, "{south} {above}");
    assert_eq!(left(DVec3::new(90.0, 150.5, 9.9), DVec3::new(210.0, 150.5, 9.9)), 0.0);
}

#[test]
fn an_area_that_repeats_repeats_what_stands_in_it() {
    let pages = standing(house(DVec2::new(3.0, 160.0), DVec2::new(8.0, 5.0), 0.4, 12.0));
    let mut endless = marcher(&pages).endless(2000.0);
    let mut hits = Vec::new();
    let mut range = |x: f64| {
        let (ray, _) = ray(&endless, DVec3::new(x, 160.0, 5.0), DVec3::new(x + 10.0, 160.0, 5.0));
        endless.solids(&ray, None, &mut hits).unwrap();
        hits[0].range
    };
    // The part of the house that lies west of the border is not there: it begins there.
    assert!((range(300.0) - 20.0 * SPACING).abs() < 1e-9);
    assert!((range(300.0 - f64::from(SIDE)) - 20.0 * SPACING).abs() < 1e-9);
}

/// Something on every ninth voxel, and on parts of the area nothing: as it comes.
fn strewn(x: u32, y: u32) -> Vec<Span> {
    let mut seed = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
    let mut draw = |below: u32| {
        seed = (seed ^ seed >> 15).wrapping_mul(0x2c1b_3c6d).wrapping_add(0x297a_2d39);
        (seed >> 8) % below
    };
    if draw(9) > 0 || (x / 40 + y / 40).is_multiple_of(3) {
        return Vec::new();
    }

    let mut spans: Vec<_> = (0..1 + draw(2))
        .map(|index| {
            let low = 10.0 * f64::from(index) + f64::from(draw(4));
            let own = pillar(low + 0.5 + f64::from(draw(60)) / 10.0);
            let slope = [0, 1].map(|_| (draw(41) as i8 - 20) * i8::from(draw(2) > 0));
            let wall = Cut::wall(draw(256) as u8, draw(200) as i32 - 100);
            let cuts =
                [[Cut::NONE, Cut::round(draw(256) as u8), wall][draw(3) as usize], Cut::NONE, Cut::NONE];
            let state = [Span::OPAQUE, 11, 4, Span::OPAQUE | Span::PARALLEL][draw(4) as usize];
            let low = if index == 0 && draw(2) > 0 { Span::GROUND } else { CODE.encode(low) };
            Span { low, slope, cuts, state, ..own }
        })
        .collect();

    spans.sort_by_key(|span| (span.low, span.high));
    spans
}

static STREWN: LazyLock<[MemPages; 2]> =
    LazyLock::new(|| [false, true].map(|placed| standing_as(placed, strewn)));

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn what_is_passed_at_once_hides_nothing(
        eye in (-60.0..380.0_f64, -60.0..380.0_f64, -3.0..60.0_f64),
        (turn, rise) in (0.0..std::f64::consts::TAU, prop_oneof![Just(0.0), -0.3..0.2_f64, -9.0..9.0_f64]),
        is_snapped in any::<bool>(),
        (placed, is_endless, is_curved) in any::<(bool, bool, bool)>(),
        least in prop_oneof![Just(0.5), Just(1.0 / 512.0)],
    ) {
        let pages = &STREWN[usize::from(placed)];
        let curvature = if is_curved { Curvature::standard() } else { Curvature::FLAT };
        let base = Marcher::new(pages, LevelBands::finest_only(), Surface::Smooth).curved(curvature);

        // Along axes and diagonals, too; along a border or through a corner a ray may be on either side of it.
        let snap = |value: f64, step: f64| if is_snapped { (value / step).round() * step } else { value };
        let turn = snap(turn, std::f64::consts::FRAC_PI_4);
        let eye = DVec3::new(snap(eye.0, 8.0) + 0.25, snap(eye.1, 1.0) + 0.5, eye.2);
        let direction = DVec2::from_angle(turn).extend(rise).normalize();
        let world = (base.grid().origin + eye.truncate() * SPACING).extend(eye.z);
        let ray = base.ray(world, direction);
        let mut cursor = PageCursor::new(pages);
        if is_endless {
            cursor = cursor.endless();
        }

        let size = DVec2::splat(f64::from(SIDE));
        let over = if is_endless { Some((0.0, 1500.0)) } else { ray.clip(size, 100.0) };
        let Some((start, end)) = over else { return Ok(()) };
        let mut solids = Solids::new(&cursor);
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        let end = end.min(1.0e5);
        let left = [
            solids.along(&ray, [start, end], [1.0, least], &mut found).unwrap(),
            solids.along_each_voxel(&ray, [start, end], least, &mut expected).unwrap(),
        ];
        prop_assert_eq!(found.len(), expected.len(), "{:?} {:?}", found, expected);

        for (found, expected) in found.iter().zip(&expected) {
            let errors = [found.range - expected.range, found.end - expected.end, found.opacity - expected.opacity];
            prop_assert!(errors.iter().all(|error| error.abs() < 1e-9), "{:?} {:?}", found, expected);
            prop_assert!(found.span == expected.span);
        }

        prop_assert!((left[0] - left[1]).abs() < 1e-9);
    }
}
