//! Closed forms of cameras: straight flights, circles, walls, cuts.

use glam::{DVec2, DVec3};

use super::super::shot::{Chase, Orbit};
use super::super::timeline::{Pace, Playback};
use super::super::track::{Altitude, AltitudeMode, Fix, Horizontal, Track};
use super::*;
use hedgehop_geo::Crs;
use std::f64::consts::TAU;

fn fix(time: f64, place: DVec3) -> Fix {
    Fix {
        time,
        horizontal: Horizontal::Xy(place.x, place.y),
        altitude: Altitude { metres: place.z, mode: AltitudeMode::Msl },
        accuracy: None,
        yaw: None,
        pitch: None,
        roll: None,
        hfov: None,
    }
}

fn track(fixes: Vec<Fix>) -> Track {
    Track {
        path: "path.csv".into(),
        format: "CSV",
        fixes,
        clock: None,
        notes: Vec::new(),
        cameras: Vec::new(),
    }
}

/// A flight of places each second.
fn flight(seconds: u32, place: impl Fn(f64) -> DVec3) -> Arc<Trajectory> {
    let fixes = (0..=seconds).map(|second| fix(second.into(), place(second.into()))).collect();
    let flown = Trajectory::bind(&track(fixes), &Crs::local(), &|_| None, &BindOptions::default());
    Arc::new(flown.expect("a flight"))
}

/// To the north at 20 m/s, for two minutes.
fn north() -> Arc<Trajectory> {
    flight(120, |time| DVec3::new(5e5, 4e6 + 20.0 * time, 800.0))
}

fn timeline(flight: &Trajectory, speed: f64) -> Timeline {
    let span = flight.span();
    let playback = Playback { pace: Pace::Speed(speed), ..Playback::default() };
    Timeline::new("30".parse().expect("a rate"), span, &playback).expect("a timeline")
}

fn rig_over(
    flight: &Arc<Trajectory>,
    speed: f64,
    shots: &[Shot],
    ground: &dyn Fn(DVec2) -> Option<f64>,
) -> Rig {
    let site = FilmSite { crs: &Crs::local(), ground, object: &|_| None, clearance: None };
    Rig::bind(flight.clone(), &timeline(flight, speed), shots, &site).expect("a rig")
}

fn rig(flight: &Arc<Trajectory>, speed: f64, mount: Mount) -> Rig {
    rig_over(flight, speed, &[Shot { mount, ..Shot::default() }], &|_| None)
}

const BEHIND: Chase = Chase { back: 60.0, up: 15.0, side: 0.0 };

#[test]
fn without_a_camera_the_eye_is_aboard() {
    let flight = north();
    let plain = rig_over(&flight, 1.0, &[], &|_| None);
    for step in 0..=130 {
        let seconds = f64::from(step) + 0.3;
        assert_eq!(plain.pose_at(seconds), flight.pose_at(seconds));
    }
}

#[test]
fn a_chase_keeps_its_distance_and_looks_at_what_flies() {
    let flight = north();
    for (side, yaw) in [(0.0, 0.0_f64), (30.0, (-30.0_f64).atan2(60.0).to_degrees())] {
        let chase = rig(&flight, 1.0, Mount::Chase(Chase { side, ..BEHIND }));
        for step in 0..=240 {
            let seconds = 0.5 * f64::from(step);
            let Pose { eye, attitude, .. } = chase.pose_at(seconds);
            let offset = eye - flight.pose_at(seconds).eye;
            assert!((offset - DVec3::new(side, -60.0, 15.0)).length() < 0.01, "{offset} at {seconds}");
            let pitch = (-15.0_f64).atan2(side.hypot(60.0)).to_degrees();
            assert!((attitude.pitch - pitch).abs() < 0.01 && attitude.roll == 0.0, "{attitude:?}");
            let turn = (attitude.yaw - yaw + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turn.abs() < 0.01, "{attitude:?}");
        }
    }
}

/// Circles of 30 m at 10 m/s, which drift to the east.
fn thermal() -> Arc<Trajectory> {
    flight(1200, |time| {
        let (sin, cos) = (time / 3.0).sin_cos();
        DVec3::new(30.0 * sin + 2.0 * time, 30.0 * cos, 1000.0 + time)
    })
}

#[test]
fn a_fast_film_of_a_glider_that_circles_does_not_turn_with_it() {
    let flight = thermal();
    let frames = |rig: &Rig| -> f64 {
        // Largest turn from frame to frame, degrees, once it has settled.
        let axis = |frame: u32| rig.pose_at(f64::from(frame)).attitude.world_from_view().z_axis;
        (100..1100).map(|frame| axis(frame).angle_between(axis(frame + 1)).to_degrees()).fold(0.0, f64::max)
    };
    let (aboard, chased) =
        (rig_over(&flight, 30.0, &[], &|_| None), rig(&flight, 30.0, Mount::Chase(BEHIND)));
    assert!(frames(&aboard) > 15.0, "{}", frames(&aboard));
    assert!(frames(&chased) < 0.3, "{}", frames(&chased));

    // Seen from above, it does not turn about the middle, either.
    let look = Some(Look::Down);
    let above =
        Shot { mount: Mount::Chase(Chase { back: 0.0, up: 900.0, side: 0.0 }), look, ..Shot::default() };
    let above = rig_over(&flight, 30.0, &[above], &|_| None);
    for frame in 100..1100 {
        let [one, next] = [frame, frame + 1].map(|frame| above.pose_at(f64::from(frame)).attitude.yaw);
        let turn = (next - one + 180.0).rem_euclid(360.0) - 180.0;
        assert!(turn.abs() < 1.0, "{turn}° at {frame} s");
    }

    // The glider is near the middle all the while and not far off, though the camera does not turn with it.
    for step in 100..3500 {
        let seconds = f64::from(step) / 3.0;
        let Pose { eye, attitude, .. } = chased.pose_at(seconds);
        let way = flight.pose_at(seconds).eye - eye;
        assert!(way.length() < 2.5 * 60.0_f64.hypot(15.0), "{way} at {seconds} s");
        let off = attitude.world_from_view().z_axis.angle_between(way);
        assert!(off < 13.0_f64.to_radians(), "{}° at {seconds} s", off.to_degrees());
    }
}

#[test]
fn a_fast_film_that_looks_ahead_leads_into_turns_and_does_not_whirl() {
    let ahead = |flight: &Arc<Trajectory>, speed: f64, lead: f64| {
        let look = Some(Look::Ahead(lead));
        rig_over(flight, speed, &[Shot { look, ..Shot::default() }], &|_| None)
    };
    let flight = thermal();
    let film = ahead(&flight, 30.0, 4.0);
    for second in 100..1100 {
        let [one, next] = [0.0, 1.0].map(|later| film.pose_at(f64::from(second) + later));
        let turn =
            one.attitude.world_from_view().z_axis.angle_between(next.attitude.world_from_view().z_axis);
        assert!(turn < 1.0_f64.to_radians() && one.attitude.roll == 0.0, "{turn} at {second} s");
        assert_eq!(one.eye, flight.pose_at(second.into()).eye);
    }

    // To the north, and after five minutes to the east: it turns the earlier, the more it looks ahead.
    let bend = self::flight(600, |time| DVec3::new((time - 300.0).max(0.0), time.min(300.0), 500.0) * 10.0);
    let turned = |lead: f64| {
        let film = ahead(&bend, 5.0, lead);
        let is_east = |second: &u32| (45.0..180.0).contains(&film.pose_at(f64::from(*second)).attitude.yaw);
        (0..600).find(is_east).expect("a turn")
    };
    let [late, early] = [turned(0.0), turned(8.0)];
    // Halfway through the 40 s of flight that the film passes over in 8 s.
    assert!((300..308).contains(&late) && (270..290).contains(&early), "{late} {early}");
}

#[test]
fn a_chase_turns_round_where_the_flight_does() {
    // To the north at 12 m/s for 100 s, and straight back.
    let flight = flight(200, |time| DVec3::new(0.0, 12.0 * (100.0 - (time - 100.0).abs()), 300.0));
    let chase = rig(&flight, 1.0, Mount::Chase(BEHIND));
    let off = |seconds: f64| (chase.pose_at(seconds).attitude.yaw - 180.0).abs();
    assert!(
        (off(95.0) - 180.0).abs() < 1.0 && off(120.0) < 60.0 && off(135.0) < 15.0,
        "{} {}",
        off(120.0),
        off(135.0)
    );
    let turns = (0..2000).map(|step| {
        let [one, next] = [0.1, 0.2].map(|later| chase.pose_at(f64::from(step) * 0.1 + later).attitude.yaw);
        ((next - one + 180.0).rem_euclid(360.0) - 180.0).abs()
    });
    let quickest = turns.fold(0.0, f64::max);
    assert!(quickest < 3.0, "{quickest}° in a tenth of a second");
}

#[test]
fn an_orbit_takes_its_time_of_the_film() {
    let flight = flight(600, |time| DVec3::new(time, 0.0, 100.0));
    let orbit = Orbit { radius: 200.0, up: 50.0, period: 20.0 };
    let around = rig(&flight, 10.0, Mount::Orbit(orbit));
    for (film, bearing) in
        [(0.0_f64, 270.0), (5.0, 0.0), (10.0, 90.0), (15.0, 180.0), (20.0, 270.0), (45.0, 0.0)]
    {
        let seconds = 10.0 * film;
        let offset = around.pose_at(seconds).eye - flight.pose_at(seconds).eye;
        let (sin, cos) = f64::to_radians(bearing).sin_cos();
        let expected = DVec3::new(200.0 * sin, 200.0 * cos, 50.0);
        assert!((offset - expected).length() < 0.2, "{offset} not {expected} after {film} s");
    }

    // Around a place, which it looks at.
    let place = track(vec![fix(0.0, DVec3::new(700.0, 900.0, 30.0))]);
    let place =
        Track { fixes: place.fixes.iter().map(|fix| Fix { yaw: Some(0.0), ..*fix }).collect(), ..place };
    let shot = Shot { mount: Mount::Orbit(orbit), look: Some(Look::Place(place)), ..Shot::default() };
    let around = rig_over(&flight, 10.0, &[shot], &|_| None);
    for step in 0..60 {
        let Pose { eye, attitude, .. } = around.pose_at(10.0 * f64::from(step));
        let way = DVec3::new(700.0, 900.0, 30.0) - eye;
        assert!((way.truncate().length() - 200.0).abs() < 0.2 && (way.z + 50.0).abs() < 1e-6, "{way}");
        assert!(attitude.world_from_view().z_axis.angle_between(way) < 1e-6);
    }
}

#[test]
fn eyes_of_their_own_rise_over_what_stands_and_gently() {
    let flight = flight(120, |time| DVec3::new(0.0, 10.0 * time, 80.0));
    let wall = |place: DVec2| Some(if (500.0..510.0).contains(&place.y) { 100.0 } else { 0.0 });
    let low = Shot { mount: Mount::Chase(Chase { up: 5.0, ..BEHIND }), ..Shot::default() };
    let chase = rig_over(&flight, 1.0, &[low], &wall);
    let heights: Vec<f64> = (0..12_000)
        .map(|step| {
            let eye = chase.pose_at(0.01 * f64::from(step)).eye;
            let least = wall(eye.truncate()).unwrap_or_default() + CLEARANCE;
            assert!(eye.z >= least - 1e-6, "{eye}");
            eye.z
        })
        .collect();
    let fastest = heights.windows(2).map(|pair| (pair[1] - pair[0]).abs() / 0.01).fold(0.0, f64::max);
    assert!(fastest < 12.0, "{fastest} m/s");
    assert!(chase.notes()[0].contains("17.0 m"), "{:?}", chase.notes());
}

#[test]
fn a_look_ahead_is_at_where_the_flight_will_be_and_never_jumps() {
    // To the east at 10 m/s, sinking by 2 m/s, for a minute; then it stands for another.
    let flight = flight(120, |time| DVec3::new(10.0 * time.min(60.0), 0.0, 500.0 - 2.0 * time.min(60.0)));
    let ahead = |lead: f64| {
        let shot = Shot { look: Some(Look::Ahead(lead)), ..Shot::default() };
        rig_over(&flight, 1.0, &[shot], &|_| None)
    };
    let found = ahead(10.0).pose_at(20.0).attitude;
    assert!((found.yaw - 90.0).abs() < 1e-9 && found.roll == 0.0, "{found:?}");
    assert!((found.pitch + (0.2_f64).atan().to_degrees()).abs() < 1e-9, "{found:?}");

    // Beyond the last fix the flight goes straight on, and who stands looks along the nose, lowered to the ground.
    let standing = ahead(5.0).pose_at(118.0).attitude;
    assert!((standing.yaw - 90.0).abs() < 1e-9 && standing.pitch == -9.0, "{standing:?}");
    let near = ahead(5.0);
    let mut before = near.pose_at(30.0).attitude;
    for step in 1..9000 {
        let after = near.pose_at(30.0 + 0.01 * f64::from(step)).attitude;
        let turn = (after.yaw - before.yaw).abs().max((after.pitch - before.pitch).abs());
        assert!(turn < 1.0, "{turn}° at step {step}: {after:?}");
        before = after;
    }
}

#[test]
fn shots_behind_the_end_are_left_out_and_told() {
    let flight = north();
    let late = Shot { from: 120.5, mount: Mount::Chase(BEHIND), ..Shot::default() };
    let film = rig_over(&flight, 1.0, &[Shot::default(), late], &|_| None);
    assert_eq!(film.pose_at(120.0), flight.pose_at(120.0));
    assert!(film.notes()[0].contains("120.5 s"), "{:?}", film.notes());
}

#[test]
fn until_the_first_shot_the_eye_is_aboard() {
    let flight = north();
    let later = Shot { from: 60.0, mount: Mount::Chase(BEHIND), ..Shot::default() };
    let film = rig_over(&flight, 1.0, &[later], &|_| None);
    assert_eq!(film.pose_at(30.0), flight.pose_at(30.0));
    assert!(film.is_aboard_at(59.0) && !film.is_aboard_at(60.0));
}

#[test]
fn a_shutter_does_not_see_across_a_cut() {
    let flight = north();
    let shots = [
        Shot::default(),
        Shot {
            from: 60.0,
            mount: Mount::Chase(BEHIND),
            zoom: Some(Zoom { from: 60.0, to: 30.0, ease: Ease::None }),
            ..Shot::default()
        },
    ];
    let film = rig_over(&flight, 1.0, &shots, &|_| None);
    assert_eq!(film.pose_at(59.99), flight.pose_at(59.99));
    assert_eq!(film.pose_in_frame(59.99, 60.01), flight.pose_at(60.01));
    assert!((film.pose_at(60.0).eye - flight.pose_at(60.0).eye).length() > 60.0);
    assert!(film.is_one_shot(0.0, 59.9) && !film.is_one_shot(59.9, 60.0));
    assert!((film.pose_at(60.0).hfov - 60.0).abs() < 1e-9 && (film.pose_at(120.0).hfov - 30.0).abs() < 1e-9);
}

#[test]
fn keys_are_met_at_their_times_at_rest_or_in_passing() {
    let flight = north();
    let place = |time: f64| DVec3::new(5e5 + 30.0 * time, 4e6, 900.0);
    let fixes = [0.0, 10.0, 20.0].map(|time| {
        let angles = [Some(10.0 * time), Some(0.0), Some(0.0)];
        Fix { yaw: angles[0], pitch: angles[1], roll: angles[2], ..fix(time, place(time)) }
    });
    for ease in [Ease::None, Ease::InOut] {
        let keys = Keys { start: 5.0, track: track(fixes.to_vec()), ease };
        let film = rig(&flight, 1.0, Mount::Keys(keys));
        for time in [0.0, 10.0, 20.0] {
            let pose = film.pose_at(5.0 + time);
            assert!(
                (pose.eye - place(time)).length() < 1e-6 && (pose.attitude.yaw - 10.0 * time).abs() < 1e-6
            );
        }
        assert_eq!(film.pose_at(0.0), film.pose_at(5.0));
        let speed = (film.pose_at(15.0005).eye - film.pose_at(14.9995).eye).length() / 0.001;
        assert!((speed - if ease == Ease::None { 30.0 } else { 0.0 }).abs() < 0.1, "{ease:?}: {speed}");
    }
}

#[test]
fn quick_films_of_recordings_look_where_the_flight_goes() {
    // Circles of 30 m in 20 s that drift to the east at 3 m/s, for twenty minutes.
    let flight = flight(1200, |time| {
        let (sin, cos) = (TAU * time / 20.0).sin_cos();
        DVec3::new(3.0 * time + 30.0 * cos, 30.0 * sin, 500.0 + time)
    });
    let shot = Shot { look: Some(Look::Lowered), ..Shot::default() };
    let yaws = |pace: f64| {
        let rig = rig_over(&flight, pace, std::slice::from_ref(&shot), &|_| None);
        let attitudes = (200..1000).map(|second| rig.pose_at(second.into()).attitude);
        attitudes.inspect(|seen| assert_eq!(seen.pitch, -9.0)).map(|seen| seen.yaw).collect::<Vec<f64>>()
    };
    // As it was flown the view turns around; fifteen times as fast it goes with the wind.
    assert!(yaws(1.0).iter().any(|yaw| (yaw - 270.0).abs() < 20.0));
    let quick = yaws(15.0);
    assert!(quick.iter().all(|yaw| (yaw - 90.0).abs() < 8.0), "{quick:?}");
}
