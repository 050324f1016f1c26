use glam::{DVec2, DVec3};

use super::*;
use crate::flight::{Altitude, AltitudeMode, Fix, FrameRate, Horizontal, Rig};
use hedgehop_geo::Crs;

/// A slope with a pit that has no ground.
fn ground(at: DVec2) -> Option<f64> {
    let is_inside = at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::splat(1000.0)).all();
    let is_pit = at.distance(DVec2::splat(500.0)) < 200.0;
    (is_inside && !is_pit).then_some(100.0 + 0.1 * at.x)
}

const AREA: [DVec2; 2] = [DVec2::ZERO, DVec2::splat(1000.0)];

fn timeline(count: u64) -> Timeline {
    Timeline::of_views(FrameRate::new(30, 1).unwrap(), count)
}

fn poses_with(views: &Views, numbers: &[u64], clearance: Option<f64>) -> Result<ViewPoses> {
    let crs = Crs::local();
    let site = FilmSite { crs: &crs, ground: &ground, object: &|_| None, clearance };
    views.poses(numbers.iter().copied(), &timeline(views.count()), &site)
}

fn poses(views: &Views, numbers: &[u64]) -> Vec<Pose> {
    poses_with(views, numbers, None).unwrap().poses.iter().map(|view| view.pose).collect()
}

fn random(seed: u64) -> Views {
    let layout = ViewLayout::Random(RandomViews {
        count: 2000,
        seed,
        heights: [20.0, 220.0],
        pitches: [-80.0, -10.0],
        headings: [300.0, 420.0],
    });
    Views { layout, area: AREA, target: None, hfov: 60.0 }
}

fn place_at(x: f64, y: f64, z: f64) -> Track {
    let fix = Fix {
        time: 0.0,
        horizontal: Horizontal::Xy(x, y),
        altitude: Altitude { metres: z, mode: AltitudeMode::Msl },
        accuracy: None,
        yaw: Some(0.0),
        pitch: Some(0.0),
        roll: Some(0.0),
        hfov: None,
    };
    Track {
        path: "--look-at".into(),
        format: "single eye",
        fixes: vec![fix],
        clock: None,
        cameras: Vec::new(),
        notes: Vec::new(),
    }
}

#[test]
fn random_views_are_a_function_of_seed_and_number() {
    let numbers: Vec<u64> = (1..=50).collect();
    let whole = poses(&random(7), &numbers);
    assert_eq!(poses(&random(7), &[3, 4, 40]), [whole[2], whole[3], whole[39]]);
    assert!(poses(&random(8), &numbers).iter().zip(&whole).all(|(other, pose)| other.eye != pose.eye));

    // These stay from version to version.
    let Pose { eye, attitude, .. } = whole[0];
    let told = format!("{:.3} {:.3} {:.3} {:.3} {:.3}", eye.x, eye.y, eye.z, attitude.yaw, attitude.pitch);
    assert_eq!(told, "167.982 52.385 183.277 337.066 -38.013");
}

#[test]
fn random_views_fill_their_ranges_above_ground() {
    let all = poses(&random(1), &(1..=2000).collect::<Vec<_>>());
    let mut quarters = [[0_u32; 4]; 5];
    for Pose { eye, attitude, .. } in &all {
        let ground = ground(eye.truncate()).expect("an eye above ground");
        let turn = (attitude.yaw - 300.0).rem_euclid(360.0);
        let shares = [
            eye.x / 1000.0,
            eye.y / 1000.0,
            (eye.z - ground - 20.0) / 200.0,
            turn / 120.0,
            (attitude.pitch + 80.0) / 70.0,
        ];
        for (quarters, share) in quarters.iter_mut().zip(shares) {
            assert!((-1e-9..1.0 + 1e-9).contains(&share), "{eye} {attitude:?}: {share}");
            quarters[((share * 4.0) as usize).min(3)] += 1;
        }
        assert_eq!(attitude.roll, 0.0);
    }
    // A quarter of 2000 is 500; the pit takes from the middle of the area.
    assert!(quarters.as_flattened().iter().all(|count| (400..620).contains(count)), "{quarters:?}");
}

#[test]
fn grids_go_east_then_north_with_all_combinations_at_each_place() {
    let layout = ViewLayout::Grid(GridViews {
        spacing: 300.0,
        heights: vec![10.0, 50.0],
        pitches: vec![-90.0],
        headings: vec![0.0, 90.0, 350.0],
    });
    let views = Views { layout, area: AREA, target: None, hfov: 60.0 };
    assert_eq!(views.count(), 3 * 3 * 2 * 3);
    let told = |number| {
        let Pose { eye, attitude, .. } = poses(&views, &[number])[0];
        [eye.x, eye.y, eye.z, attitude.yaw, attitude.pitch]
    };
    assert_eq!(told(1), [200.0, 200.0, 130.0, 0.0, -90.0]);
    assert_eq!(told(3), [200.0, 200.0, 130.0, 350.0, -90.0]);
    assert_eq!(told(4), [200.0, 200.0, 170.0, 0.0, -90.0]);
    assert_eq!(told(7), [500.0, 200.0, 160.0, 0.0, -90.0]);
    assert_eq!(told(19), [200.0, 500.0, 130.0, 0.0, -90.0]);
    assert_eq!(told(54), [800.0, 800.0, 230.0, 350.0, -90.0]);
    let pit = poses_with(&views, &[25], None).unwrap_err().to_string();
    assert!(pit.contains("view 25") && pit.contains("x 500.0, y 500.0"), "{pit}");
}

#[test]
fn orbits_look_at_their_place_and_keep_above_ground() {
    let layout = ViewLayout::Orbit(OrbitViews { count: 4, radius: 250.0, heights: vec![30.0, 90.0] });
    let views = Views { layout, area: AREA, target: Some(place_at(600.0, 500.0, 110.0)), hfov: 60.0 };
    let told = poses_with(&views, &(1..=8).collect::<Vec<_>>(), None).unwrap();
    // Due east the ground is at 185 m, and the first circle at 140 m.
    assert!((told.raised - 47.0).abs() < 1e-9, "{}", told.raised);
    let north = told.poses[0].pose;
    assert!((north.eye - DVec3::new(600.0, 750.0, 162.0)).length() < 1e-9, "{north:?}");
    for (view, yaw) in told.poses.iter().zip([180.0, 270.0, 0.0, 90.0, 180.0, 270.0, 0.0, 90.0]) {
        let Pose { eye, attitude, .. } = view.pose;
        let way = DVec3::new(600.0, 500.0, 110.0) - eye;
        assert!(way.normalize().dot(attitude.world_from_view().z_axis) > 1.0 - 1e-12);
        assert!(((attitude.yaw - yaw + 180.0).rem_euclid(360.0) - 180.0).abs() < 1e-9, "{attitude:?}");
        assert!(ground(eye.truncate()).is_none_or(|ground| eye.z >= ground + CLEARANCE - 1e-9));
    }
    assert_eq!(told.poses[5].pose.eye.z, 200.0);
}

#[test]
fn clearance_raises_what_would_be_lower() {
    let low = poses_with(&random(1), &[1], Some(500.0)).unwrap();
    let eye = low.poses[0].pose.eye;
    assert!((eye.z - ground(eye.truncate()).unwrap() - 500.0).abs() < 1e-9 && low.raised > 280.0);
}

#[test]
fn ground_that_is_nowhere_is_not_looked_for_for_ever() {
    let views = Views { area: [DVec2::splat(2000.0), DVec2::splat(2001.0)], ..random(1) };
    let said = poses_with(&views, &[9], None).unwrap_err().to_string();
    assert!(said.contains("view 9") && said.contains("--bbox"), "{said}");
}

#[test]
fn each_view_is_a_shot_of_its_own() {
    let (views, timeline) = (random(3), timeline(2000));
    let crs = Crs::local();
    let site = FilmSite { crs: &crs, ground: &ground, object: &|_| None, clearance: None };
    let rig = Rig::of_views(&views, [5, 6, 9].into_iter(), &timeline, &site).unwrap();
    for (number, pose) in [5, 6, 9].into_iter().zip(poses(&views, &[5, 6, 9])) {
        let seconds = timeline.seconds_at(number);
        assert_eq!(rig.pose_at(seconds), pose);
        assert_eq!(rig.pose_in_frame(seconds, seconds + 1.0), pose);
    }
    assert!(!rig.is_one_shot(timeline.seconds_at(5), timeline.seconds_at(6)));
}
