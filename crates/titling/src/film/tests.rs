use glam::{DVec2, DVec3};

use crate::{FilmLength, Readings, TimedCaption, TitleInputs, Titles, TrackPoint};
use hedgehop::frame::Picture;
use hedgehop::scene::{Figures, Titling};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::voxel::{Grid, MemPages, Metadata, build_in_memory};
use hedgehop_base::Size;

const SIZE: Size = Size { width: 640, height: 360 };

/// Ground that rises to the east, and a level flight over it to the east.
fn site() -> (MemPages, Vec<TrackPoint>) {
    let grid = Grid { nx: 256, ny: 256, spacing: 10.0, origin: DVec2::ZERO };
    let heights: Vec<f64> = (0..256 * 256).map(|post| f64::from(post % 256) * 2.0).collect();
    let source = build_in_memory(grid, &heights, &[[0; 3]; 256 * 256], None, &Metadata::default()).unwrap();
    let point = |index: u32| {
        let east = 400.0 + 18.0 * f64::from(index);
        TrackPoint {
            seconds: f64::from(index),
            place: DVec3::new(east, 1300.0, 700.0),
            ground: Some(0.2 * east),
        }
    };
    (source, (0..=100).map(point).collect())
}

/// Returns a grey picture with titles over it, `seconds` after the first fix, looking along `yaw`.
fn drawn(titling: &Titling, captions: &[TimedCaption], seconds: f64, yaw: f64) -> Picture {
    let (source, track) = site();
    let inputs = TitleInputs {
        titling,
        captions,
        length: FilmLength { frames: 100, seconds: 100.0 },
        size: SIZE,
        track: &track,
        is_endless: false,
        source: &source,
    };
    let titles = Titles::new(&inputs).unwrap();
    let attitude = Attitude { yaw, pitch: 0.0, roll: 0.0 };
    let eye = DVec3::new(400.0 + 18.0 * seconds, 1300.0, 700.0);
    let camera = Camera::new(Pose { eye, attitude, hfov: 60.0 }, SIZE.width, SIZE.height);
    let readings = Readings {
        heading: 90.0,
        altitude: 700.0,
        above_ground: Some(300.0),
        speed: Some([18.0, 0.0]),
        film_seconds: seconds,
        seconds,
        place: eye.truncate(),
        ..Readings::default()
    };
    let mut picture = Picture { width: SIZE.width, height: SIZE.height, rgb: vec![90; 640 * 360 * 3] };
    titles.draw(&mut picture, &camera, &readings);
    picture
}

/// Returns the least and greatest column and row of the pixels that are so; `None`: none is.
fn bounds(picture: &Picture, is_so: impl Fn([u8; 3]) -> bool) -> Option<[usize; 4]> {
    let mut found: Option<[usize; 4]> = None;
    for (index, codes) in picture.rgb.chunks(3).enumerate() {
        if is_so([codes[0], codes[1], codes[2]]) {
            let (column, row) = (index % 640, index / 640);
            let [left, right, top, bottom] = found.unwrap_or([column, column, row, row]);
            found = Some([left.min(column), right.max(column), top.min(row), bottom.max(row)]);
        }
    }
    found
}

fn differs(codes: [u8; 3]) -> bool {
    codes != [90; 3]
}

fn is_orange([red, green, blue]: [u8; 3]) -> bool {
    i32::from(red) - i32::from(blue) > 80 && red > green
}

#[test]
fn figures_stay_within_the_safe_area_and_apart() {
    let all = Titling { figures: Figures::ALL, ..Titling::default() };
    let [left, right, top, bottom] = bounds(&drawn(&all, &[], 40.0, 0.0), differs).unwrap();
    // Halos reach a little beyond.
    assert!(
        left >= 32 - 5 && right <= 608 + 5 && top >= 18 - 5 && bottom <= 342 + 5,
        "{left} {right} {top} {bottom}"
    );
    // Each figure alone changes pixels.
    for name in Figures::NAMES.into_iter().filter(|name| *name != "scale") {
        let figures = Figures::of_names([name]).unwrap();
        let alone = drawn(&Titling { figures, ..Titling::default() }, &[], 40.0, 0.0);
        assert!(bounds(&alone, differs).is_some(), "{name}");
    }
    // A bar needs a map.
    let scale = Titling { figures: Figures { scale: true, ..Figures::default() }, ..Titling::default() };
    assert_eq!(bounds(&drawn(&scale, &[], 40.0, 0.0), differs), None);
}

#[test]
fn the_compass_points_to_the_north() {
    let north = Titling { figures: Figures { north: true, ..Figures::default() }, ..Titling::default() };
    let middle = |yaw: f64| {
        let picture = drawn(&north, &[], 0.0, yaw);
        let [left, right, top, bottom] = bounds(&picture, differs).unwrap();
        let [west, east, upper, lower] = bounds(&picture, is_orange).unwrap();
        [(west + east) as f64 - (left + right) as f64, (upper + lower) as f64 - (top + bottom) as f64]
    };
    let [ahead, right_hand, behind] = [0.0, -90.0, 180.0].map(middle);
    assert!(ahead[1] < -5.0 && ahead[0].abs() < 3.0, "{ahead:?}");
    // Looking to the west, north is at the right.
    assert!(right_hand[0] > 5.0 && right_hand[1].abs() < 3.0, "{right_hand:?}");
    assert!(behind[1] > 5.0, "{behind:?}");
}

#[test]
fn map_and_profile_show_how_far_one_has_come() {
    for name in ["map", "profile"] {
        let titling = Titling { figures: Figures::of_names([name]).unwrap(), ..Titling::default() };
        let passed = |seconds: f64| {
            let [left, right, ..] = bounds(&drawn(&titling, &[], seconds, 0.0), is_orange).unwrap();
            (right - left) as f64
        };
        let (half, whole) = (passed(50.0), passed(100.0));
        assert!((half / whole - 0.5).abs() < 0.1 && whole > 40.0, "{name}: {half} {whole}");
    }
}

#[test]
fn cards_fade_and_make_way() {
    let titling =
        Titling { title: Some("Title".into()), credits: Some("Credits".into()), ..Titling::default() };
    let white = |seconds: f64| {
        let picture = drawn(&titling, &[], seconds, 0.0);
        picture.rgb.chunks(3).map(|codes| u32::from(codes[1].saturating_sub(90))).sum::<u32>()
    };
    assert!(white(0.0) > 1000 && white(0.0) == white(3.0));
    assert!(white(4.75) > 0 && white(4.75) < white(3.0) && white(5.0) == 0 && white(94.9) == 0);
    assert!(white(99.0) > 1000);

    let caption = TimedCaption { from: 40.0, to: 44.0, text: "A caption of several words".into() };
    let figures = Titling { figures: Figures::ALL, ..Titling::default() };
    let (plain, captioned) = (drawn(&figures, &[], 42.0, 0.0), drawn(&figures, &[caption], 42.0, 0.0));
    let changed: Vec<u8> =
        plain.rgb.iter().zip(&captioned.rgb).map(|(a, b)| if a == b { 90 } else { 0 }).collect();
    let changed = Picture { rgb: changed, ..plain };
    let [left, right, top, bottom] = bounds(&changed, differs).unwrap();
    // In the middle, above what is at the lower edge.
    assert!((left + right).abs_diff(640) < 6 && top > 200 && bottom < 305, "{left} {right} {top} {bottom}");
}

#[test]
fn long_titles_are_set_across_and_clear_of_map_and_compass() {
    let lines = "One\nTwo\nThree\nFour\nFive\nSix\nSeven\nEight\nNine\nTen\nEleven\nTwelve";
    let words = "Very long title word ".repeat(20);
    for title in [lines, words.trim()] {
        let with = Titling { title: Some(title.into()), figures: Figures::ALL, ..Titling::default() };
        let figures = Titling { figures: Figures::ALL, ..Titling::default() };
        let (titled, plain) = (drawn(&with, &[], 2.0, 0.0), drawn(&figures, &[], 2.0, 0.0));
        let changed = titled.rgb.iter().zip(&plain.rgb).map(|(a, b)| if a == b { 90 } else { 0 }).collect();
        let [left, right, top, _] = bounds(&Picture { rgb: changed, ..plain }, differs).unwrap();
        // The map begins some 150 pixels from the right border, and the compass ends 56 below the upper one.
        assert!(right - left > 40 && right < 640 - 150 && top > 56, "{title}: {left} {right} {top}");
    }
}

#[test]
fn films_without_a_way_or_of_one_frame_are_drawn() {
    let (source, track) = site();
    let titling = Titling { figures: Figures::ALL, title: Some("T".into()), ..Titling::default() };
    for (track, frames) in [(&track[..1], 1), (&[][..], 1), (&track[..2], 2)] {
        let inputs = TitleInputs {
            titling: &titling,
            captions: &[],
            length: FilmLength { frames, seconds: frames as f64 / 30.0 },
            size: SIZE,
            track,
            is_endless: true,
            source: &source,
        };
        let camera = Camera::new(
            Pose { eye: DVec3::new(500.0, 500.0, 900.0), attitude: Attitude::default(), hfov: 60.0 },
            640,
            360,
        );
        let mut picture = Picture { width: 640, height: 360, rgb: vec![90; 640 * 360 * 3] };
        Titles::new(&inputs).unwrap().draw(&mut picture, &camera, &Readings::default());
        assert!(bounds(&picture, |codes| codes[0] > 200).is_some());
    }
}
