//! Films: of frames in files and without them, their presets, sound and chapters.

use std::fs;
use std::io::Write;
use std::process::Command;

use tempfile::TempDir;

use crate::common::{ends, run};
use crate::films::site;

/// Five frames, ahead of the flags of a film.
const FLY: &str = "render area.hop --path climb.csv --speed 25x --fps 1 --progress none";

/// A tone as WAV: one channel, 8000 samples a second.
fn wave(seconds: u32) -> Vec<u8> {
    let samples: Vec<u8> = (0..8000 * seconds)
        .map(|at| ((f64::from(at) * 440.0 * std::f64::consts::TAU / 8000.0).sin() * 9000.0) as i16)
        .flat_map(i16::to_le_bytes)
        .collect();
    let mut file = b"RIFF".to_vec();
    file.extend((36 + samples.len() as u32).to_le_bytes());
    file.extend(b"WAVEfmt \x10\0\0\0\x01\0\x01\0");
    file.extend([8000_u32, 16_000].into_iter().flat_map(u32::to_le_bytes));
    file.extend(b"\x02\0\x10\0data");
    file.extend((samples.len() as u32).to_le_bytes());
    file.extend(samples);
    file
}

/// What ffmpeg says of a film, if it is there.
fn described(site: &TempDir, film: &str) -> Option<String> {
    let said = Command::new("ffmpeg").current_dir(site.path()).args(["-hide_banner", "-i", film]).output();
    let told = said.map(|output| String::from_utf8_lossy(&output.stderr).into_owned()).ok();
    if told.is_none() {
        writeln!(std::io::stderr(), "skipped: no ffmpeg to make films with").expect("a line");
    }
    told
}

/// Names in the folder, those of temporary files included.
fn names(site: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(site.path()).expect("the folder").flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Width, height, frames a second and number of frames of an AVI film.
fn head(site: &TempDir, film: &str) -> [u32; 4] {
    let bytes = fs::read(site.path().join(film)).expect("a film");
    let after = |word: &[u8], field: usize| {
        let place = bytes.windows(4).position(|window| window == word).expect("a chunk") + 8 + field;
        u32::from_le_bytes(bytes[place..place + 4].try_into().expect("four bytes"))
    };
    assert_eq!(after(b"strh", 20), 1);
    [after(b"avih", 32), after(b"avih", 36), after(b"strh", 24), after(b"dmlh", 0)]
}

#[test]
fn films_need_neither_frames_in_files_nor_ffmpeg() {
    let site = site();
    let before = names(&site);
    let told = ends(&run(&site, &format!("{FLY} --size 33x18 --video film.avi")), 0);
    assert!(told.contains("rendered 5 frames") && told.contains("film.avi"), "{told}");
    assert_eq!(names(&site), [&before[..], &["film.avi".to_owned()]].concat());
    assert_eq!(head(&site, "film.avi"), [33, 18, 1, 5]);

    // The same film of frames in files, also of those that are there already.
    let film = fs::read(site.path().join("film.avi")).expect("a film");
    for more in ["", "--skip-existing"] {
        ends(&run(&site, &format!("{FLY} --size 33x18 -o f/####.png {more} --video again.avi")), 0);
        assert!(film == fs::read(site.path().join("again.avi")).expect("a film"));
    }
    ends(&run(&site, &format!("{FLY} --size 33x18 --frames 2,4 --video part.avi")), 0);
    assert_eq!(head(&site, "part.avi"), [33, 18, 1, 2]);
}

#[test]
fn presets_say_what_flags_do_not() {
    let site = site();
    let flight = "render area.hop --path climb.csv --frames 1 --progress none";
    for (flags, expected) in [
        ("--film preview", [640, 360, 15, 1]),
        ("--film preview --size 32x18", [32, 18, 15, 1]),
        ("--film 4k60 --fps 24 --size 32x18", [32, 18, 24, 1]),
        ("--film 4k60 --size 32x18", [32, 18, 60, 1]),
        ("--film 1080p", [1920, 1080, 30, 1]),
        ("", [1280, 720, 30, 1]),
    ] {
        ends(&run(&site, &format!("{flight} {flags} --video film.avi")), 0);
        assert_eq!(head(&site, "film.avi"), expected, "{flags}");
    }
}

#[test]
fn sound_and_chapters_are_in_the_film() {
    let site = site();
    fs::write(site.path().join("sound.wav"), wave(9)).expect("sound");
    fs::write(site.path().join("short.wav"), wave(1)).expect("sound");
    fs::write(site.path().join("parts.txt"), "0:00 Start = here\n0:02.5 Lake; blue\n").expect("chapters");
    fs::write(site.path().join("late.txt"), "0:00 Start\n0:05 Lake\n").expect("chapters");
    let has_ffmpeg = described(&site, "sound.wav").is_some();
    let late = run(&site, &format!("{FLY} --size 32x18 --chapters late.txt --video film.mkv"));
    let late = ends(&late, if has_ffmpeg { 2 } else { 4 });
    if !has_ffmpeg {
        assert!(late.contains("apt-get install ffmpeg"), "{late}");
        return;
    }
    assert!(late.contains("`Lake` begins at 5 s"), "{late}");

    for (film, flags, codecs) in [
        ("film.mp4", "", ["h264", "aac"]),
        ("film.webm", "", ["vp9", "opus"]),
        ("film.mov", "--film prores", ["prores (HQ)", "pcm_s24le"]),
    ] {
        let flags = format!("{flags} --size 32x18 --audio sound.wav --chapters parts.txt");
        ends(&run(&site, &format!("{FLY} {flags} --video {film}")), 0);
        let said = described(&site, film).expect("ffmpeg");
        for part in [
            "Duration: 00:00:05.0",
            "Start = here",
            "start 2.500000, end 5.0",
            "Lake; blue",
            "bt709/bt709/iec61966-2-1",
        ] {
            assert!(said.contains(part), "{film}: {part}: {said}");
        }
        assert!(codecs.iter().all(|codec| said.contains(codec)), "{film}: {said}");
    }

    let short = ends(&run(&site, &format!("{FLY} --size 32x18 --audio short.wav --video film.mp4")), 0);
    assert!(short.contains("short.wav lasts 1.0 s, and the film 5.0 s"), "{short}");
    assert!(described(&site, "film.mp4").expect("ffmpeg").contains("Duration: 00:00:05.0"));
    assert!(names(&site).iter().all(|name| !name.contains("part.")), "{:?}", names(&site));

    // The same film with and without frames in files.
    for flags in ["--video a.mp4", "-o f/####.png --video b.mp4"] {
        ends(&run(&site, &format!("{FLY} --size 33x18 {flags}")), 0);
    }
    let films = ["a.mp4", "b.mp4"].map(|film| fs::read(site.path().join(film)).expect("a film"));
    assert!(films[0] == films[1]);
}

#[test]
fn what_films_cannot_have_is_told_before_the_first_frame() {
    let site = site();
    fs::write(site.path().join("notes.txt"), "no chapter\n").expect("a text");
    let before = names(&site);
    for (flags, word) in [
        ("", "--output"),
        ("--film 1080p -o f/####.png", "--video"),
        ("--video film.avi --skip-existing", "-o frames/####.png"),
        ("--video film.avi --overwrite", "replaces what was there"),
        ("--video film.avi -o film.y4m", "leave out -o"),
        ("--video film.avi --aov material", "-o frames/####.exr"),
        ("--video film.avi --film prores", "no ProRes; write .mp4 or .mov"),
        ("--video film.avi --film 1080p --screen fisheye", "--size"),
        ("--video film.gif", ".avi, which needs no ffmpeg"),
        ("--video -", "-o -"),
        ("--video climb.csv", "climb.csv"),
        ("-o film.mp4", "--video film.mp4"),
        ("--video film.avi --chapters absent.txt", "absent.txt"),
        ("--video film.avi --chapters notes.txt", "notes.txt: line 1: `no chapter`"),
        ("--video film.mp4 --audio absent.wav", "absent.wav"),
        ("--video area.hop/film.avi", "area.hop"),
    ] {
        let output = run(&site, &format!("{FLY} {flags}"));
        assert!(!output.status.success(), "{flags}");
        let said = ends(&output, output.status.code().expect("an exit code"));
        assert!(said.contains(word), "{flags}: {said}");
        assert_eq!(names(&site), before, "{flags}");
    }

    if described(&site, "notes.txt").is_some() {
        let said = ends(&run(&site, &format!("{FLY} --video film.mp4 --audio notes.txt")), 3);
        assert!(said.contains("notes.txt: ffmpeg finds no sound in it"), "{said}");
    }
}
