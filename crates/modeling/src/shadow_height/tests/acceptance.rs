//! Fifty buildings under five suns, and what must not be taken for shadows.

use glam::{DVec2, dvec2};

use super::super::site::{Neighbour, Reason, Seen, Site};
use super::super::sunward::Sunward;
use super::synthetic::{Prism, Random, World, hills};
use super::{dem, foot, placed, ring, turned, world};

/// Azimuths and elevations, degrees.
const SUNS: [(f64, f64); 5] = [(95.0, 15.0), (143.0, 24.0), (188.0, 35.0), (231.0, 47.0), (287.0, 60.0)];

const RANGE: (f64, f64) = (2.0, 80.0);

/// What the picture of a world shows of a ring.
fn look(world: World, ring: &[DVec2], others: &[(u32, Vec<DVec2>)], neighbours: &[Neighbour]) -> Seen {
    let sun = Sunward::new(world.azimuth, world.elevation);
    let ground = |place: DVec2| dem(sun.place(place));
    let rings = [turned(ring, &sun)];
    let base = foot(ring, |place| dem(place).unwrap());
    let site = Site { sun, base, rings: &rings, others, neighbours, ground: &ground, range: RANGE };
    site.look(&[placed(world)]).unwrap()
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures are what documents say")]
fn fifty_buildings_under_five_suns() {
    let mut random = Random(7);
    let buildings: Vec<(Vec<DVec2>, f64)> = (0..50)
        .map(|number| {
            let middle = dvec2(random.between(460.0, 540.0), random.between(460.0, 540.0));
            (ring(&mut random, middle), 5.0 + 55.0 * f64::from(number) / 49.0)
        })
        .collect();

    let under = |sun: (f64, f64)| -> Vec<(f64, f64, f64)> {
        let measured = (0..).zip(&buildings).map(|(seed, (ring, height))| {
            let roof = foot(ring, hills) + height;
            let world = world(vec![Prism { ring: ring.clone(), roof }], sun, 99 + seed);
            let Seen::Height(found) = look(world, ring, &[], &[]) else {
                panic!("a building of {height} m under {sun:?} is not seen");
            };
            (*height, found.height - height, found.error)
        });
        measured.collect()
    };

    let all: Vec<(f64, f64, f64)> = std::thread::scope(|scope| {
        let suns = SUNS.map(|sun| scope.spawn(move || under(sun)));
        suns.into_iter().flat_map(|sun| sun.join().unwrap()).collect()
    });
    let worst = all.iter().map(|(_, error, _)| error.abs()).fold(0.0, f64::max);
    let mean = all.iter().map(|(_, error, _)| error.abs()).sum::<f64>() / all.len() as f64;
    println!("{} heights: {mean:.3} m off in the mean, {worst:.3} m at worst", all.len());
    for (height, error, said) in all {
        assert!(error.abs() <= (0.03 * height).max(1.0), "{height} m: {error} m off");
        assert!(error.abs() <= 3.0 * said, "{height} m: {error} m off, said to be ± {said} m");
    }

    assert!(mean < 0.1, "{mean}");
}

#[test]
fn ground_without_a_shadow_is_told() {
    let (mut wrong, mut flat) = (0, 0);
    for seed in 0..12 {
        let ring = ring(&mut Random(1000 + seed), dvec2(500.0, 500.0));
        let bare = World { texture: 0.6, ..world(Vec::new(), (200.0, 40.0), seed) };
        wrong += i32::from(matches!(look(bare, &ring, &[], &[]), Seen::Height(_)));
        let roof = foot(&ring, hills) + 20.0;
        let clouded =
            World { direct: 0.03, ..world(vec![Prism { ring: ring.clone(), roof }], (200.0, 40.0), seed) };
        flat += i32::from(look(clouded, &ring, &[], &[]) == Seen::Nothing(Reason::NoShadow));
    }
    assert!(wrong <= 1 && flat >= 10, "{wrong} of 12 without a building, {flat} of 12 under clouds");
}

#[test]
fn shadows_that_leave_the_picture_have_no_end() {
    let sun = (180.0, 25.0);
    let ring = ring(&mut Random(3), dvec2(500.0, 500.0));
    let prism = Prism { roof: foot(&ring, hills) + 30.0, ring: ring.clone() };
    // The shadow falls northward, 64 m; of the picture the south is left.
    for (north, reason) in [(540.0, Reason::OutOfPicture), (470.0, Reason::OutOfPicture)] {
        let mut cut = world(vec![prism.clone()], sun, 5);
        cut.size.height = north as u32;
        assert_eq!(look(cut, &ring, &[], &[]), Seen::Nothing(reason), "{north}");
    }
}

#[test]
fn rows_of_houses_do_not_disturb_each_other() {
    let sun = (200.0, 40.0);
    let mut random = Random(5);
    let houses: Vec<(Vec<DVec2>, f64)> = (0..9)
        .map(|number| {
            let jitter = dvec2(random.between(-4.0, 4.0), random.between(-4.0, 4.0));
            let middle =
                dvec2(400.0 + 40.0 * f64::from(number % 3), 400.0 + 40.0 * f64::from(number / 3)) + jitter;
            let turn = DVec2::from_angle(random.between(-0.3, 0.3));
            let half = dvec2(random.between(6.0, 10.0), random.between(6.0, 10.0));
            let corners = [dvec2(-1.0, -1.0), dvec2(1.0, -1.0), dvec2(1.0, 1.0), dvec2(-1.0, 1.0)];
            (corners.map(|corner| middle + turn.rotate(corner * half)).to_vec(), random.between(6.0, 22.0))
        })
        .collect();

    let prism =
        |(ring, height): &(Vec<DVec2>, f64)| Prism { roof: foot(ring, hills) + height, ring: ring.clone() };
    let prisms: Vec<Prism> = houses.iter().map(prism).collect();
    let toward = Sunward::new(sun.0, sun.1);
    let neighbours: Vec<Neighbour> = houses
        .iter()
        .map(|(ring, _)| Neighbour { base: foot(ring, |place| dem(place).unwrap()), height: None })
        .collect();

    for (number, (ring, height)) in houses.iter().enumerate() {
        let others = (0_u32..).zip(&houses).filter(|(other, _)| *other as usize != number);
        let others: Vec<(u32, Vec<DVec2>)> =
            others.map(|(other, (ring, _))| (other, turned(ring, &toward))).collect();
        match look(world(prisms.clone(), sun, 8), ring, &others, &neighbours) {
            Seen::Height(found) => {
                assert!((found.height - height).abs() < 1.0, "{height} m is found as {found:?}");
            }
            Seen::Nothing(reason) => assert_eq!(reason, Reason::Hidden, "{height} m"),
        }
    }
}
