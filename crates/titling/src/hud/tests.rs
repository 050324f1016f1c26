use glam::DVec3;

use super::*;
use hedgehop::space::{Attitude, Pose, RayTable, Screen};
use hedgehop::voxel::{Grid, Metadata, build_in_memory};

fn camera(ypr: [f64; 3]) -> Camera {
    let attitude = Attitude { yaw: ypr[0], pitch: ypr[1], roll: ypr[2] };
    Camera::new(Pose { eye: DVec3::new(500.0, 700.0, 90.0), attitude, hfov: 60.0 }, 320, 200)
}

fn black() -> Picture {
    Picture { width: 320, height: 200, rgb: vec![0; 320 * 200 * 3] }
}

/// Places that were drawn on.
fn drawn(picture: &Picture) -> Vec<DVec2> {
    let lit = |index: &usize| picture.rgb[3 * index + 1] > 100;
    let place = |index: usize| DVec2::new((index % 320) as f64 + 0.5, (index / 320) as f64 + 0.5);
    (0..320 * 200).filter(lit).map(place).collect()
}

const READINGS: Readings = Readings {
    heading: 359.7,
    altitude: 1234.4,
    above_ground: Some(56.6),
    speed: Some([61.74, -2.05]),
    frame: 120,
    film_seconds: 14.875,
    seconds: 14.875,
    clock: None,
    place: DVec2::new(500.0, 700.0),
    lonlat: None,
};

#[test]
fn figures_are_those_of_the_flight() {
    assert_eq!(READINGS.left(&Hud::ALL), ["SPD  61.7 M/S", "VS   -2.0 M/S", "FRAME 120", "T 14.88 S"]);
    assert_eq!(READINGS.right(&Hud::ALL), ["MSL   1234 M", "AGL     57 M"]);
    assert_eq!(READINGS.heading_text(), "360");
    assert_eq!(Readings { heading: 7.4, ..READINGS }.heading_text(), "007");
    assert_eq!(Readings { heading: -90.0, ..READINGS }.heading_text(), "270");
    let bare = Readings { above_ground: None, speed: None, ..READINGS };
    assert_eq!(bare.left(&Hud { time: false, ..Hud::ALL }), [""; 0]);
    assert_eq!(bare.right(&Hud::ALL)[1], "AGL    --- M");
    assert_eq!([0, 90, -90, 360, 340, 10].map(mark_text), ["N", "E", "W", "N", "34", "01"]);
}

#[test]
fn the_horizon_is_where_directions_are_level() {
    let hud = Hud { horizon: true, ..Hud::default() };
    for ypr in [[20.0, 0.0, 0.0], [20.0, 12.0, 0.0], [200.0, -8.0, 33.0]] {
        let camera = camera(ypr);
        let mut picture = black();
        draw(&mut picture, &camera, &hud, &READINGS, None);
        let axis = DVec2::new(160.0, 100.0);
        let line: Vec<_> = drawn(&picture).into_iter().filter(|at| (*at - axis).length() > 20.0).collect();
        assert!(line.len() > 200, "{ypr:?}: {}", line.len());
        for at in line {
            let up = camera.direction(at.x, at.y).z.asin() / camera.pixel_angle();
            assert!(up.abs() < 1.2, "{ypr:?} {at}: {up} pixels");
        }
    }
}

#[test]
fn a_lens_bends_the_horizon_and_a_table_has_none() {
    let hud = Hud { horizon: true, ..Hud::default() };
    let plane = camera([0.0, 15.0, 0.0]);
    let lens = Camera::with_screen(plane.pose, Screen::Lens { hfov: 60.0, k: [-0.2, 0.0] }, 320, 200);
    let mut picture = black();
    draw(&mut picture, &lens, &hud, &READINGS, None);

    let rows = |columns: std::ops::Range<f64>| {
        let at: Vec<f64> = drawn(&picture)
            .into_iter()
            .filter(|at| columns.contains(&at.x) && at.y > 125.0)
            .map(|at| at.y)
            .collect();
        at.iter().sum::<f64>() / at.len() as f64
    };

    // A barrel takes what is far from the axis nearer to it.
    assert!(rows(0.0..5.0) < rows(158.0..162.0) - 2.0);
    let table = RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 320, 200).unwrap();
    let table = Camera::with_screen(plane.pose, Screen::Table(std::sync::Arc::new(table)), 320, 200);
    let mut picture = black();
    draw(&mut picture, &table, &hud, &READINGS, None);
    assert_eq!(picture, black());
}

#[test]
fn the_tape_stands_with_its_numbers_where_they_are() {
    let hud = Hud { heading: true, ..Hud::default() };
    let mut picture = black();
    draw(&mut picture, &camera([0.0; 3]), &hud, &Readings { heading: 0.0, ..READINGS }, None);

    // Marks every 5° over 60° in 0.4 of the width.
    let light = |column: usize| f64::from(picture.rgb[3 * (27 * 320 + column) + 1]);
    let mut marks: Vec<f64> = Vec::new();
    let (mut sum, mut weight) = (0.0, 0.0);

    for column in 0..320 {
        (sum, weight) = (sum + light(column) * (column as f64 + 0.5), weight + light(column));
        if light(column) == 0.0 && weight > 0.0 {
            marks.push(sum / weight);
            (sum, weight) = (0.0, 0.0);
        }
    }

    assert_eq!(marks.len(), 13, "{marks:?}");
    for (index, at) in marks.iter().enumerate() {
        let expected = 160.0 + (index as f64 - 6.0) * 5.0 * 0.4 * 320.0 / 60.0;
        assert!((at - expected).abs() <= 0.1, "{at} {expected}");
    }
}

#[test]
fn the_map_shows_relief_path_and_place() {
    let grid = Grid { nx: 128, ny: 64, spacing: 10.0, origin: DVec2::ZERO };
    let heights: Vec<f64> = (0..128 * 64).map(|post| f64::from(post % 128) * 4.0).collect();
    let source = build_in_memory(grid, &heights, &[[0; 3]; 128 * 64], None, &Metadata::default()).unwrap();
    let path = [DVec2::new(100.0, 320.0), DVec2::new(1200.0, 320.0)];
    let map = MiniMap::new(&source, &path, false).unwrap();
    assert_eq!(map.relief.size, [256, 128]);

    // Higher ground is brighter.
    assert!(map.relief.pixels[64 * 256 + 200][0] > map.relief.pixels[64 * 256 + 40][0]);
    let mut picture = black();
    let hud = Hud { map: true, ..Hud::default() };

    draw(
        &mut picture,
        &camera([0.0; 3]),
        &hud,
        &Readings { place: DVec2::new(640.0, 320.0), ..READINGS },
        Some(&map),
    );

    // 60 pixels wide and 30 high, 10 from the border: the path goes along its middle.
    let pixel = |column: usize, row: usize| &picture.rgb[3 * (row * 320 + column)..][..3];
    assert_eq!(pixel(247, 157), [0, 0, 0]);
    assert!(pixel(262, 175)[0] > 140 && pixel(262, 175)[1] < 120, "{:?}", pixel(262, 175));
    assert!(pixel(262, 165)[1] > 20);

    // A wing behind the nose, which is at the own place.
    assert!(pixel(281, 178)[1] > 150 && pixel(281, 178)[0] < 190, "{:?}", pixel(281, 178));
}

#[test]
fn no_instrument_changes_nothing() {
    let mut picture = black();
    draw(&mut picture, &camera([0.0; 3]), &Hud::default(), &READINGS, None);
    assert_eq!(picture, black());
    // Nor does a picture of a few pixels end in a panic.
    let mut tiny = Picture { width: 3, height: 2, rgb: vec![0; 18] };
    draw(&mut tiny, &camera([0.0; 3]).moved_to(camera([0.0; 3]).pose), &Hud::ALL, &READINGS, None);
}
