//! Closed forms: circle, climb, straight line; and the rules of altitude and standstill.

use std::path::PathBuf;

use super::super::angles::short_way;
use super::super::track::Altitude;
use super::*;

const OPTIONS: BindOptions =
    BindOptions { level: false, hfov: 60.0, clearance: None, smoothing: Smoothing::Noise };

fn fix(time: f64, x: f64, y: f64, z: f64) -> Fix {
    Fix {
        time,
        horizontal: Horizontal::Xy(x, y),
        altitude: Altitude { metres: z, mode: AltitudeMode::Msl },
        accuracy: None,
        yaw: None,
        pitch: None,
        roll: None,
        hfov: None,
    }
}

fn track(fixes: Vec<Fix>) -> Track {
    Track {
        path: PathBuf::from("path.csv"),
        format: "CSV",
        fixes,
        clock: None,
        notes: Vec::new(),
        cameras: Vec::new(),
    }
}

fn no_ground(_: DVec2) -> Option<f64> {
    None
}

fn local(fixes: Vec<Fix>) -> Trajectory {
    Trajectory::bind(&track(fixes), &Crs::local(), &no_ground, &OPTIONS).unwrap()
}

fn failure(fixes: Vec<Fix>, crs: &Crs, options: &BindOptions) -> String {
    Trajectory::bind(&track(fixes), crs, &no_ground, options).expect_err("an error").to_string()
}

/// Clockwise, `speed` m/s, `rate` rad/s, `seconds` long, a fix each second.
fn circle(speed: f64, rate: f64, seconds: u32) -> Vec<Fix> {
    let radius = speed / rate;
    (0..=seconds)
        .map(|second| {
            let t = f64::from(second);
            fix(t, 1e5 - radius * (rate * t).cos(), 2e5 + radius * (rate * t).sin(), 300.0)
        })
        .collect()
}

#[test]
fn circle_has_the_bank_of_a_coordinated_turn_and_turns_through_north() {
    let (speed, rate) = (60.0, 0.06_f64);
    let flight = local(circle(speed, rate, 240));
    let bank = (speed * rate / 9.806_65).atan().to_degrees();
    let mut previous: Option<f64> = None;
    let mut turned = 0.0;

    for step in 0..=2400 {
        let t = 0.1 * f64::from(step);
        let attitude = flight.pose_at(t).attitude;
        assert!((attitude.roll - bank).abs() < 0.01 * bank, "bank {} at {t}, not {bank}", attitude.roll);
        assert!(attitude.pitch.abs() < 1e-9);
        assert!(short_way(attitude.yaw - (rate * t).to_degrees()).abs() < 0.3, "yaw {} at {t}", attitude.yaw);

        if let Some(previous) = previous {
            let step = short_way(attitude.yaw - previous);
            assert!((0.0..0.7).contains(&step), "yaw jumps by {step} at {t}");
            turned += step;
        }

        previous = Some(attitude.yaw);
        let centre = DVec2::new(1e5, 2e5);
        let radius = flight.pose_at(t).eye.truncate().distance(centre);
        assert!((radius - speed / rate).abs() < 0.05, "radius {radius} at {t}");
    }

    assert!((turned - (rate * 240.0).to_degrees()).abs() < 1.0 && turned > 720.0, "{turned}");
}

#[test]
fn a_steep_turn_keeps_its_bank_through_the_smoothing() {
    let (speed, rate) = (50.0, 0.2_f64);
    let bank = (speed * rate / 9.806_65).atan().to_degrees();
    let flown = local(circle(speed, rate, 60)).pose_at(30.3).attitude.roll;
    assert!((flown - bank).abs() < 0.5, "{flown}, not {bank}");
}

#[test]
fn left_turns_bank_left_and_level_does_not() {
    let mut fixes = circle(60.0, 0.06, 60);
    for fix in &mut fixes {
        let Horizontal::Xy(x, y) = fix.horizontal else { continue };
        fix.horizontal = Horizontal::Xy(-x, y);
    }
    assert!(local(fixes.clone()).pose_at(30.0).attitude.roll < -15.0);
    let options = BindOptions { level: true, ..OPTIONS };
    let level = Trajectory::bind(&track(fixes), &Crs::local(), &no_ground, &options).unwrap();
    assert_eq!(level.pose_at(30.0).attitude.roll, 0.0);
    assert!(level.notes()[0].contains("level"), "{:?}", level.notes());
}

#[test]
fn straight_climb_has_the_pitch_of_its_slope() {
    let flight = local((0..30).map(f64::from).map(|t| fix(t, -40.0 * t, 0.0, 100.0 + 10.0 * t)).collect());
    for t in [0.0, 0.3, 7.77, 29.0] {
        let pose = flight.pose_at(t);
        assert!((pose.attitude.pitch - (0.25_f64).atan().to_degrees()).abs() < 1e-9);
        assert!((pose.attitude.yaw - 270.0).abs() < 1e-9 && pose.attitude.roll.abs() < 1e-9);
        assert!((pose.eye - DVec3::new(-40.0 * t, 0.0, 100.0 + 10.0 * t)).length() < 1e-9);
    }
}

#[test]
fn steep_and_tight_flights_stay_within_limits() {
    let steep = local((0..20).map(f64::from).map(|t| fix(t, 5.0 * t, 0.0, 50.0 * t)).collect());
    assert_eq!(steep.pose_at(10.0).attitude.pitch, 45.0);
    let tight = local(circle(80.0, 0.5, 60));
    assert_eq!(tight.pose_at(30.0).attitude.roll, 60.0);
}

#[test]
fn at_a_standstill_the_nearest_heading_is_held() {
    let mut fixes: Vec<Fix> = (0..=20).map(f64::from).map(|t| fix(t, 10.0 * t, 0.0, 0.0)).collect();
    fixes.extend((21..=79).map(f64::from).map(|t| fix(t, 200.0, 0.0, 0.0)));
    fixes.extend((80..=100).map(f64::from).map(|t| fix(t, 200.0, -10.0 * (t - 80.0), 0.0)));
    let flight = local(fixes);
    let yaw = |t: f64| flight.pose_at(t).attitude.yaw;
    assert!((yaw(10.0) - 90.0).abs() < 1e-6 && (yaw(40.0) - 90.0).abs() < 1.0, "{} {}", yaw(10.0), yaw(40.0));

    assert!(
        (yaw(60.0) - 180.0).abs() < 1.0 && (yaw(95.0) - 180.0).abs() < 1e-6,
        "{} {}",
        yaw(60.0),
        yaw(95.0)
    );

    for step in 0..10_000 {
        let t = 0.01 * f64::from(step);
        assert!(
            short_way(yaw(t + 0.01) - yaw(t)).abs() < 1.0,
            "jump at {t}: {} to {}",
            yaw(t),
            yaw(t + 0.01)
        );
    }
}

#[test]
fn a_path_that_never_moves_needs_a_yaw() {
    let stands: Vec<Fix> = (0..5).map(f64::from).map(|t| fix(t, 7.0, 8.0, 9.0 + t)).collect();
    let message = failure(stands.clone(), &Crs::local(), &OPTIONS);
    assert!(message.contains("never moves") && message.contains("yaw_deg"), "{message}");
    let turning =
        local(stands.iter().map(|&fix| Fix { yaw: Some(350.0 + 10.0 * fix.time), ..fix }).collect());
    let attitude = turning.pose_at(1.5).attitude;
    assert!((attitude.yaw - 5.0).abs() < 1e-9, "{attitude:?}");
    assert_eq!((attitude.pitch, attitude.roll), (0.0, 0.0));
    let picture = local(vec![fix(0.0, 1.0, 2.0, 3.0)]);
    assert_eq!((picture.duration(), picture.frame_count(25.0)), (0.0, 1));
    assert_eq!(picture.pose_at(0.0).attitude, Attitude::default());
    assert_eq!(picture.pose_at(0.0).eye, DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn given_attitude_is_slerped_and_hfov_linear() {
    let given = |t: f64, yaw: f64, hfov: f64| Fix {
        yaw: Some(yaw),
        pitch: Some(-10.0),
        roll: Some(20.0),
        hfov: Some(hfov),
        ..fix(t, 100.0 * t, 0.0, 0.0)
    };
    let flight = local(vec![given(0.0, 350.0, 60.0), given(2.0, 10.0, 40.0)]);
    let pose = flight.pose_at(1.0);
    assert!(short_way(pose.attitude.yaw).abs() < 1e-9, "{pose:?}");
    assert!((pose.hfov - 50.0).abs() < 1e-9);
    let start = flight.pose_at(0.0).attitude;
    assert!(
        (start.yaw - 350.0).abs() < 1e-9
            && (start.pitch + 10.0).abs() < 1e-9
            && (start.roll - 20.0).abs() < 1e-9
    );
    assert!(flight.notes().is_empty(), "{:?}", flight.notes());
}

#[test]
fn frames_are_counted_exactly() {
    let lasting = |seconds: f64| local(vec![fix(0.0, 0.0, 0.0, 0.0), fix(seconds, 10.0, 0.0, 0.0)]);
    assert_eq!(lasting(10.0).frame_count(25.0), 251);
    assert_eq!(lasting(0.3).frame_count(10.0), 4);
    assert_eq!(lasting(9.99).frame_count(25.0), 250);
    // Seconds since 1970 in a double: ten seconds come out a quarter of a microsecond short.
    let unix = 1_539_642_886.999_725_f64 - 1_539_642_876.999_725_f64 - 2.4e-7;
    assert_eq!(lasting(unix).frame_count(30.0), 301);
    assert_eq!(lasting(1.0).frame_count(f64::NAN), 1);
    let flight = lasting(unix);
    assert_eq!(flight.pose_at(10.0), flight.pose_at(flight.duration()));
    assert_eq!(flight.pose_at(-1.0), flight.pose_at(0.0));
    assert_eq!(flight.pose_at(f64::NAN), flight.pose_at(0.0));
}

#[test]
fn heights_above_ground_follow_the_ground_and_need_one() {
    let agl = |t: f64| Fix {
        altitude: Altitude { metres: 50.0, mode: AltitudeMode::Agl },
        ..fix(t, 100.0 * t, 0.0, 0.0)
    };
    let hill = |at: DVec2| (at.x < 950.0).then(|| 300.0 * (-((at.x - 400.0) / 100.0).powi(2)).exp());
    // Fixes only at both sides of the hill.
    let flight = Trajectory::bind(&track(vec![agl(0.0), agl(9.0)]), &Crs::local(), &hill, &OPTIONS).unwrap();
    for step in 0..=900 {
        let eye = flight.pose_at(0.01 * f64::from(step)).eye;
        let height = eye.z - hill(eye.truncate()).unwrap();
        assert!(height > 50.0 - 0.5, "{height} m above ground at {eye}");
    }
    assert!(flight.notes().iter().any(|note| note.contains("raised")), "{:?}", flight.notes());
    let message =
        Trajectory::bind(&track(vec![agl(0.0), agl(10.0)]), &Crs::local(), &hill, &OPTIONS).unwrap_err();
    let message = message.to_string();
    assert!(message.contains("at 10.000 s, x 1000") && message.contains("no ground"), "{message}");
}

#[test]
fn clearance_raises_low_flight_and_leaves_the_rest() {
    let ground = |at: DVec2| Some(if (400.0..600.0).contains(&at.x) { 100.0 } else { 0.0 });
    let fixes: Vec<Fix> = (0..=100).map(f64::from).map(|t| fix(t, 10.0 * t, 0.0, 60.0)).collect();
    let options = BindOptions { clearance: Some(30.0), ..OPTIONS };
    let flight = Trajectory::bind(&track(fixes), &Crs::local(), &ground, &options).unwrap();
    for step in 0..=1000 {
        let eye = flight.pose_at(0.1 * f64::from(step)).eye;
        let surface = ground(eye.truncate()).unwrap();
        assert!(eye.z >= surface + 30.0 - 1e-9, "{eye}");
        if !(350.0..650.0).contains(&eye.x) {
            assert!((eye.z - 60.0).abs() < 1e-9, "{eye}");
        }
    }
}

#[test]
fn yaw_is_turned_from_true_to_grid_north() {
    // Ten degrees east of the central meridian at 60° N: convergence γ = atan(tan Δλ · sin φ) on the sphere, 8.68°.
    let utm = Crs::from_epsg(32633).unwrap();
    let placed = |longitude: f64, yaw: Option<f64>, t: f64| Fix {
        horizontal: Horizontal::LonLat(longitude, 60.0 + 1e-4 * t),
        yaw,
        ..fix(t, 0.0, 0.0, 500.0)
    };
    let expected = -(10.0_f64.to_radians().tan() * 60.0_f64.to_radians().sin()).atan().to_degrees();
    let given = track(vec![placed(25.0, Some(0.0), 0.0), placed(25.0, Some(0.0), 1.0)]);
    let flight = Trajectory::bind(&given, &utm, &no_ground, &OPTIONS).unwrap();
    let yaw = short_way(flight.pose_at(0.5).attitude.yaw);
    assert!((yaw - expected).abs() < 0.05, "{yaw}, not {expected}");
    // Derived from flying true north, it must come out the same.
    let derived = track(vec![placed(25.0, None, 0.0), placed(25.0, None, 1.0)]);
    let flown = Trajectory::bind(&derived, &utm, &no_ground, &OPTIONS).unwrap();
    assert!((short_way(flown.pose_at(0.5).attitude.yaw) - yaw).abs() < 0.01);
}

#[test]
fn ellipsoid_heights_lose_the_undulation() {
    let crs = Crs::from_epsg(32630).unwrap();
    let mut placed = fix(0.0, 0.0, 0.0, 500.0);
    placed.horizontal = Horizontal::LonLat(-3.0, 54.5);
    placed.altitude.mode = AltitudeMode::Ellipsoid;
    let flight = Trajectory::bind(&track(vec![placed]), &crs, &no_ground, &OPTIONS).unwrap();
    let z = flight.pose_at(0.0).eye.z;
    assert!(
        (445.0..452.0).contains(&z),
        "{z}: the geoid is some 52 m above the ellipsoid in the Lake District"
    );
    let in_metres = Fix { horizontal: Horizontal::Xy(0.0, 0.0), ..placed };
    let message = failure(vec![in_metres], &Crs::local(), &OPTIONS);
    assert!(message.contains("ellipsoid") && message.contains("alt_msl_m"), "{message}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut placed = fix(0.0, 0.0, 0.0, 500.0);
    placed.horizontal = Horizontal::LonLat(-3.0, 54.5);
    let message = failure(vec![placed], &Crs::local(), &OPTIONS);
    assert!(message.contains("x_m and y_m") && message.contains("--crs"), "{message}");
    assert!(failure(vec![], &Crs::local(), &OPTIONS).contains("no fix"));
    let backwards = vec![fix(0.0, 0.0, 0.0, 0.0), fix(0.0, 1.0, 0.0, 0.0)];
    assert!(failure(backwards, &Crs::local(), &OPTIONS).contains("increase"));
    let wide = BindOptions { hfov: 180.0, ..OPTIONS };
    assert!(failure(vec![fix(0.0, 0.0, 0.0, 0.0)], &Crs::local(), &wide).contains("--hfov"));
    assert!(failure(vec![fix(0.0, f64::NAN, 0.0, 0.0)], &Crs::local(), &OPTIONS).contains("finite"));
}

/// A fix each second on Earth, with noise of 1.5 m along each axis, of a place in UTM 33 by its time.
fn recorded(seconds: u32, seed: u64, place: impl Fn(f64) -> DVec3) -> Trajectory {
    let utm = Crs::from_epsg(32633).unwrap();
    let to_wgs84 = Transform::new(&utm, &Crs::wgs84()).unwrap();
    let mut random = hedgehop_testing::Random(seed);
    let mut noise = || {
        let [length, turn] = [random.share(), random.share()];
        1.5 * (-2.0 * (1.0 - length).ln().min(0.0)).sqrt() * (std::f64::consts::TAU * turn).cos()
    };
    let fixes = (0..=seconds).map(|second| {
        let time = f64::from(second);
        let at = place(time) + DVec3::new(noise(), noise(), noise());
        let (longitude, latitude) = to_wgs84.apply(at.x, at.y).unwrap();
        Fix { horizontal: Horizontal::LonLat(longitude, latitude), ..fix(time, 0.0, 0.0, at.z) }
    });
    Trajectory::bind(&track(fixes.collect()), &utm, &no_ground, &OPTIONS).unwrap()
}

/// A paraglider's glide: 10 m/s, and a metre of height lost a second.
#[test]
fn noise_turns_no_view_of_a_straight_glide() {
    let flight = recorded(300, 7, |time| DVec3::new(5e5 + 8.0 * time, 5e6 + 6.0 * time, 1500.0 - time));
    let (heading, pitch) = (8.0_f64.atan2(6.0).to_degrees(), (-0.1_f64).atan().to_degrees());
    for step in 0..=3000 {
        let attitude = flight.pose_at(0.1 * f64::from(step)).attitude;
        let off = [short_way(attitude.yaw - heading), attitude.pitch - pitch];
        assert!(off.iter().all(|off| off.abs() <= 0.3), "{off:?} at step {step}");
    }
    let said = |note: &String| note.contains("about 1.5 m across") && note.contains("--smooth 0");
    assert!(flight.notes().iter().any(said), "{:?}", flight.notes());
}

#[test]
fn noise_shrinks_no_turn() {
    let middle = DVec2::new(5e5, 5e6);
    let circle = |time: f64| (middle + 30.0 * DVec2::from_angle(-time / 3.0)).extend(900.0 + time);
    let flight = recorded(300, 8, circle);
    let radius = |step: u32| (flight.pose_at(0.1 * f64::from(step)).eye.truncate() - middle).length();
    let mean = (0..=3000).map(radius).sum::<f64>() / 3001.0;
    assert!((mean / 30.0 - 1.0).abs() < 0.02, "{mean} m");
    let bank =
        (100..2900).map(|step| flight.pose_at(0.1 * f64::from(step)).attitude.roll).sum::<f64>() / 2800.0;
    let coordinated = (100.0_f64 / 30.0 / 9.806_65).atan().to_degrees();
    assert!((bank / coordinated - 1.0).abs() < 0.05, "{bank}° for {coordinated}°");
}

#[test]
fn any_path_is_smoothed_when_asked() {
    let zigzag: Vec<Fix> =
        (0..200).map(|k| fix(f64::from(k), 20.0 * f64::from(k), f64::from(k % 2), 300.0)).collect();
    let flown = |fixes: &[Fix], smoothing| {
        let options = BindOptions { smoothing, ..OPTIONS };
        Trajectory::bind(&track(fixes.to_vec()), &Crs::local(), &no_ground, &options).unwrap()
    };
    let across = |smoothing| flown(&zigzag, smoothing).pose_at(100.0).eye.y;
    assert_eq!((across(Smoothing::Noise), across(Smoothing::Period(0.0))), (0.0, 0.0));
    assert!((across(Smoothing::Period(30.0)) - 0.5).abs() < 0.01);

    for period in [-1.0, f64::NAN, 601.0] {
        let options = BindOptions { smoothing: Smoothing::Period(period), ..OPTIONS };
        let error = failure(zigzag.clone(), &Crs::local(), &options);
        assert!(error.contains("--smooth") && error.contains("0 to 600 s"), "{error}");
    }
    let said = |fixes: &[Fix], part: &str| {
        flown(fixes, Smoothing::Period(1.5)).notes().iter().any(|note| note.contains(part))
    };
    assert!(said(&zigzag, "next to nothing") && said(&zigzag[..3], "four fixes"));
}

#[test]
fn a_real_flight_is_smooth_and_near_its_fixes() {
    let Some(root) = hedgehop_testing::realdata() else { return };
    let path = root.join("trajectories/DA20-C1_N107TX_KSUS_to_KFYG_2018-10-15_trim.csv");
    let mut track = super::super::read_track(&path, &super::super::ReadOptions::default()).unwrap();
    for fix in &mut track.fixes {
        fix.yaw = None;
    }

    let crs = Crs::from_epsg(32615).unwrap();
    let flight = Trajectory::bind(&track, &crs, &no_ground, &OPTIONS).unwrap();
    let from_wgs84 = Transform::new(&Crs::wgs84(), &crs).unwrap();
    for fix in &track.fixes {
        let Horizontal::LonLat(longitude, latitude) = fix.horizontal else { continue };
        let (x, y) = from_wgs84.apply(longitude, latitude).unwrap();
        let moved = flight.pose_at(fix.time).eye - DVec3::new(x, y, fix.altitude.metres);
        assert!(moved.truncate().length() < 3.0 && moved.z.abs() < 3.0, "{moved} at {}", fix.time);
    }

    let (mut steepest_turn, mut previous) = (0.0_f64, flight.pose_at(0.0).attitude);
    let mut most_bank = 0.0_f64;
    for frame in 1..flight.frame_count(25.0) {
        let attitude = flight.pose_at(frame as f64 / 25.0).attitude;
        steepest_turn = steepest_turn.max(short_way(attitude.yaw - previous.yaw).abs());
        assert!(short_way(attitude.roll - previous.roll).abs() < 4.0, "roll jumps at frame {frame}");
        most_bank = most_bank.max(attitude.roll.abs());
        previous = attitude;
    }

    assert!((35.0..60.0).contains(&most_bank), "the flight has steep turns, {most_bank}");
    assert!(steepest_turn < 20.0, "yaw jumps by {steepest_turn} from one frame to the next");
}
