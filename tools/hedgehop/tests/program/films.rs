//! Films of a flight: which part of it, how fast, and where they look.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};

/// Level ground, and a flight over it: from two in the afternoon on, for 100 s, at 12 m/s to the north, which climbs by half as much.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let rows = vec![vec!["50"; 160].join(" "); 160].join("\n");
    let head = "ncols 160\nnrows 160\nxllcorner 0\nyllcorner 0\ncellsize 10";
    fs::write(folder.path().join("dem.asc"), format!("{head}\n{rows}\n")).expect("the grid is written");
    let fixes: String = (0..=10)
        .map(|fix| {
            let (minute, second) = (fix / 6, fix % 6 * 10);
            format!("2026-05-01T14:0{minute}:{second:02}Z,800,{},{}\n", 200 + 120 * fix, 100 + 60 * fix)
        })
        .collect();
    fs::write(folder.path().join("climb.csv"), format!("time,x_m,y_m,alt_msl_m\n{fixes}")).expect("a path");
    ends(&run(&folder, "build --local --elevation dem.asc -o area.hop"), 0);
    folder
}

/// A column of the poses of a film in `folder`.
fn column(site: &TempDir, folder: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(site.path().join(folder).join("poses.csv")).expect("poses");
    let mut rows = text.lines();
    let index =
        rows.next().and_then(|head| head.split(',').position(|column| column == name)).expect("a column");
    rows.map(|row| row.split(',').nth(index).expect("a cell").parse().expect("a number")).collect()
}

fn render(site: &TempDir, flags: &str, folder: &str) {
    let flight = "render area.hop --path climb.csv --size 16x9 --fps 1";
    ends(&run(site, &format!("{flight} {flags} -o {folder}/####.png")), 0);
}

#[test]
fn parts_of_a_flight_are_shown_as_fast_as_they_are_asked_for() {
    let site = site();
    for (folder, flags, expected) in [
        ("quick", "--speed 25x", [0.0, 25.0, 50.0, 75.0, 100.0].as_slice()),
        ("short", "--duration 4s", &[0.0, 25.0, 50.0, 75.0]),
        ("part", "--from 14:00:30 --to 0m50s --speed 10x", &[30.0, 40.0, 50.0]),
        ("slow", "--from 16:01:38+02:00 --speed 0.5", &[98.0, 98.5, 99.0, 99.5, 100.0]),
    ] {
        render(&site, flags, folder);
        assert_eq!(column(&site, folder, "t_s"), expected, "{flags}");
    }

    // Frames of another length of film show other moments, and are not kept.
    let other = "render area.hop --path climb.csv --size 16x9 --fps 1 --duration 5s -o short/####.png";
    assert!(ends(&run(&site, &format!("{other} --skip-existing")), 0).contains("rendered again"));
}

#[test]
fn a_climb_is_seen_with_the_ground_in_view() {
    let site = site();
    for (folder, flags, pitch) in [
        ("nose", "", 26.6),
        ("pitched", "--pitch -10", -10.0),
        ("down", "--look down", -90.0),
        ("led", "--look 20s", 26.6),
    ] {
        render(&site, &format!("{flags} --speed 25x"), folder);
        for found in column(&site, folder, "pitch_deg") {
            assert!((found - pitch).abs() < 0.5, "{flags}: {found}");
        }
    }
}

#[test]
fn what_is_no_film_is_told_in_a_sentence() {
    let site = site();
    for (flags, word) in [
        ("--speed 0x", "30x"),
        ("--speed 2x --duration 9s", "cannot be used"),
        ("--duration 0", "above 0"),
        ("--from 200", "lasts 100.0 s, from 14:00:00 to 14:01:40 UTC"),
        ("--from 50 --to 20s", "before --from"),
        ("--to 13:00", "--to lies outside"),
        ("--pitch 91", "-90"),
        ("--look up", "want ahead"),
        ("--look down --pitch 3", "cannot be used"),
    ] {
        let said = ends(&run(&site, &format!("render area.hop --path climb.csv {flags} -o f/####.png")), 2);
        assert!(said.contains(word), "{flags}: {said}");
    }
    let single = run(&site, "render area.hop --eye 800,800,300 --speed 2x -o view.png");
    assert!(ends(&single, 2).contains("cannot be used"));
}
