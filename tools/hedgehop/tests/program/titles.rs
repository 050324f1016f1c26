//! Text and figures over films, as flags and scenes ask for them.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};
use crate::films::site;

/// Codes of a frame that is rendered with some flags.
fn pixels(site: &TempDir, flags: &str, folder: &str, number: u32) -> Vec<u8> {
    let flight = "render area.hop --path climb.csv --size 320x180 --fps 1 --speed 10x --progress none";
    ends(&run(site, &format!("{flight} {flags} -o {folder}/####.png")), 0);
    let path = site.path().join(format!("{folder}/{number:04}.png"));
    hedgehop::encode::read_picture(&path).expect("a picture").rgb
}

const FILM: &str = "--overlay film --title Climb --credits Nobody --caption 5s-7s=Half_way";

#[test]
fn pictures_are_the_same_for_any_workers_and_frames() {
    let site = site();
    let whole = |number| pixels(&site, &format!("{FILM} -j 1 --overwrite"), "whole", number);
    let some = pixels(&site, &format!("{FILM} -j 3 --in-flight 3 --frames 6-9"), "some", 7);
    assert!(whole(7) == some);
    assert!(whole(7) != pixels(&site, "", "plain", 7));
}

#[test]
fn cards_come_and_go_by_the_films_time() {
    let site = site();
    // Eleven frames, a second each: the title is shown for 0.4 of them, as are the credits.
    let cards = "--title Climb --credits Nobody --caption 14:00:50-14:01:10=Half";
    pixels(&site, cards, "cards", 1);
    pixels(&site, "", "plain", 1);
    let read = |folder: &str, number: u32| {
        let path = site.path().join(format!("{folder}/{number:04}.png"));
        hedgehop::encode::read_picture(&path).expect("a picture").rgb
    };
    let shown: Vec<u32> =
        (1..=11).filter(|number| read("cards", *number) != read("plain", *number)).collect();
    assert_eq!(shown, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
    // The caption alone, by the clock: from the sixth frame to before the eighth.
    let caption = "--caption 14:00:50-14:01:10=Half";
    pixels(&site, caption, "caption", 1);
    let shown: Vec<u32> =
        (1..=11).filter(|number| read("caption", *number) != read("plain", *number)).collect();
    assert_eq!(shown, [6, 7]);
}

#[test]
fn scenes_and_flags_say_the_same() {
    let site = site();
    let scene = "[overlay]\nstyle = \"film\"\ntitle = \"Climb\"\nunits = \"aviation\"\nutc_offset_hours = 2\n[[caption]]\nfrom_s = 30\ntext = \"Three\"\n";
    fs::write(site.path().join("titles.toml"), scene).expect("a scene");
    let flags = "--overlay film --title Climb --units aviation --utc-offset +2 --caption 14:00:30=Three";
    for number in [1, 5] {
        let by_scene = pixels(&site, "--scene titles.toml --overwrite", "scene", number);
        assert!(by_scene == pixels(&site, &format!("{flags} --overwrite"), "flags", number), "{number}");
    }
    let other = pixels(&site, "--scene titles.toml --overlay none --overwrite", "scene", 11);
    assert!(other == pixels(&site, "", "plain", 11));

    let said = ends(&run(&site, "scene check titles.toml"), 0);
    assert!(said.contains("figures clock, place") && said.contains("a title; a caption"), "{said}");
    // Another title is another film.
    let flags = flags.replace("Climb", "Fall");
    let again = format!(
        "render area.hop --path climb.csv --size 320x180 --fps 1 --speed 10x {flags} --skip-existing -o flags/####.png"
    );
    assert!(ends(&run(&site, &again), 0).contains("rendered again"));
}

#[test]
fn what_cannot_be_shown_is_refused_in_a_sentence() {
    let site = site();
    fs::write(site.path().join("no.ttf"), "text").expect("a file");
    for (flags, code, part) in [
        ("--overlay movie", 2, "want film, pilot, none, or some of clock"),
        ("--overlay clock,horizon", 2, "\"horizon\""),
        ("--title 山", 2, "no font has the letter '山' (U+5C71)"),
        ("--title Climb --font no.ttf", 3, "no.ttf: is no font"),
        ("--title Climb --font missing.ttf", 5, "missing.ttf: cannot read"),
        ("--subtitle Low", 2, "--title"),
        ("--caption Text", 2, "want TIME=TEXT"),
        ("--caption 9s-5s=Text", 2, "not after its beginning"),
        ("--caption 15:00=Late", 2, "the caption \"Late\": its time lies outside the flight"),
        ("--utc-offset 15", 2, "-14 to 14"),
        ("--font no.ttf", 2, "give a --title"),
        ("--title A --units metric", 2, "--units is of figures"),
        ("--overlay map --utc-offset 2", 2, "--utc-offset is of the clock"),
        ("--units miles", 2, "metric, aviation, imperial"),
    ] {
        let said =
            run(&site, &format!("render area.hop --path climb.csv --size 64x36 {flags} -o no/####.png"));
        let said = ends(&said, code);
        assert!(said.contains(part), "{flags}: {said}");
    }

    let scene = |text: &str| {
        fs::write(site.path().join("wrong.toml"), text).expect("a scene");
        ends(&run(&site, "scene check wrong.toml"), 3)
    };
    for (text, part) in [
        ("[overlay]\nstyle = \"movie\"\n", "line 2"),
        ("[overlay]\nshow = [\"clock\", \"horizon\"]\n", "line 2: show takes clock, place"),
        ("[overlay]\nstyle = \"pilot\"\nshow = [\"clock\"]\n", "line 3: show is of the style film"),
        ("[overlay]\ntitle = \"\"\n", "line 2: title is empty"),
        ("[overlay]\ntitle = \"a\\tb\"\n", "U+0009"),
        ("[overlay]\nmargin = 0.5\n", "line 2: margin must be 0 to 0.25"),
        ("[overlay]\nutc_offset_hours = 20\n", "line 2"),
        ("[overlay]\ntitel = \"a\"\n", "line 2"),
        ("[[caption]]\ntext = \"a\"\n", "line 1: a caption needs from_s"),
        (
            "[[caption]]\ntext = \"a\"\nfrom_s = 1\nfilm_from_s = 2\n",
            "line 4: from_s is a moment of the flight",
        ),
        ("[[caption]]\ntext = \"a\"\nfrom_s = 5\nto_s = 2\n", "must end after it begins"),
        ("[[caption]]\ntext = \"a\"\nfrom_s = -1\n", "line 3"),
        ("[[caption]]\nfrom_s = 1\n", "text"),
    ] {
        let said = scene(text);
        assert!(said.contains("wrong.toml") && said.contains(part), "{text}: {said}");
    }
    fs::write(site.path().join("wrong.toml"), "[overlay]\nfonts = [\"gone.ttf\"]\n").expect("a scene");
    assert!(ends(&run(&site, "scene check wrong.toml"), 5).contains("gone.ttf"));
}

#[test]
fn tiny_and_odd_pictures_have_what_has_room() {
    let site = site();
    for size in ["1x1", "7x3", "40x300", "300x40", "160x90"] {
        let flags =
            format!("render area.hop --path climb.csv --size {size} --frames 1,40 {FILM} -o {size}/####.png");
        ends(&run(&site, &flags), 0);
    }
    let still =
        "render area.hop --eye 800,200,100 --size 160x90 --overlay film --title A --credits B -o still.png";
    ends(&run(&site, still), 0);
    for screen in ["orthographic --ground-width 900", "equirectangular", "fisheye"] {
        let flags = format!(
            "render area.hop --path climb.csv --screen {screen} --frames 1 {FILM} -o other/####.png --overwrite"
        );
        ends(&run(&site, &flags), 0);
    }
    // Files of light hold no text, and say so.
    let exr = "render area.hop --path climb.csv --size 32x18 --frames 1 --title A -o light/####.exr";
    assert!(ends(&run(&site, exr), 0).contains("text and figures are left out"));
}
