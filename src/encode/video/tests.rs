//! Tests of the video pipe. Those that need ffmpeg say so and pass without it.

use std::io::Write;
use std::process::Command;
use std::sync::Mutex;

use super::*;
use crate::encode::{FrameInfo, testing, write_frame};
use crate::flight::FrameRate;
use ffmpeg::TAGS;
use hedgehop_base::progress::Silent;

fn rate() -> FrameRate {
    "24000/1001".parse().unwrap()
}

fn film(out: &Path) -> VideoSettings {
    VideoSettings::new(out.to_owned(), rate())
}

/// Eight frames, of which `extension` decides the format.
fn frames(folder: &Path, extension: &str, size: (u32, u32)) -> Vec<PathBuf> {
    let numbers = 1..=8;
    let paths = numbers.map(|number| {
        let path = folder.join(format!("{number:04}.{extension}"));
        let info = FrameInfo { frame: number, ..testing::info() };
        write_frame(&path, &testing::frame(size.0, size.1), &info).unwrap();
        path
    });
    paths.collect()
}

fn ffmpeg_is_there() -> bool {
    let there = check_video(&film(Path::new("a.mp4"))).is_ok();
    if !there {
        writeln!(std::io::stderr(), "skipped: no ffmpeg with an H.264 or MPEG-4 encoder").unwrap();
    }
    there
}

/// What ffmpeg itself says about a file, and its first frame as rgb24.
fn probe(path: &Path) -> (String, Vec<u8>) {
    let run = |arguments: &[&str]| {
        Command::new("ffmpeg").args(["-hide_banner", "-i"]).arg(path).args(arguments).output().unwrap()
    };
    let words = run(&["-f", "null", "-"]).stderr;
    let first = run(&["-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]).stdout;
    (String::from_utf8_lossy(&words).into_owned(), first)
}

#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Observer for Notes {
    fn note(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }
}

#[test]
fn frames_become_a_video_with_exact_rate_and_tags() {
    if !ffmpeg_is_there() {
        return;
    }

    let (folder, out) = testing::place("a b:c.mp4");
    for (extension, size) in [("png", (64, 48)), ("exr", (65, 49))] {
        let notes = Notes::default();
        encode_video(frames(folder.path(), extension, size).into_iter(), &film(&out), &notes).unwrap();
        let (words, first) = probe(&out);
        assert!(words.contains("23.98 fps"), "{words}");
        assert!(words.contains("64x48"), "{words}");

        // Range, matrix, primaries, transfer.
        assert!(words.contains("yuv420p(tv, bt709/bt709/iec61966-2-1"), "{words}");
        assert!(words.contains("frame=    8"), "{words}");
        let expected = read_picture(&folder.path().join("0001.png")).unwrap().rgb;
        let error: u64 = first.iter().zip(&expected).map(|(&a, &b)| u64::from(a.abs_diff(b))).sum();
        assert!(extension == "exr" || error / (expected.len() as u64) < 4, "mean error {error}");
        assert_eq!(notes.0.lock().unwrap().iter().any(|note| note.contains("even sizes")), size.0 == 65);
    }

    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.contains("part"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn without_ffmpeg_the_remedy_is_named() {
    let (folder, out) = testing::place("out.mp4");
    let paths = frames(folder.path(), "png", (8, 6));
    let error =
        encode_with(OsStr::new("no-such-ffmpeg"), paths.into_iter(), &film(&out), &Silent).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }));
    let message = error.to_string();
    assert!(message.contains("apt-get install ffmpeg") && message.contains("-o -"), "{message}");
    assert!(!out.exists());
}

#[test]
fn containers_that_are_not_known_are_refused_before_anything_is_rendered() {
    let message = check_video(&film(Path::new("out.gif"))).unwrap_err().to_string();
    assert!(message.starts_with("--video out.gif") && message.contains(".mp4"), "{message}");
}

/// Stands in for ffmpeg: lists encoders, then does what `script` says.
#[cfg(unix)]
fn stand_in(folder: &Path, script: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join("ffmpeg.sh");
    let text = format!(
        "#!/bin/sh\ncase \"$*\" in *-encoders*) echo ' V....D libx264 x'; echo ' A....D aac x'; exit 0;; esac\n{script}\n"
    );
    let written = folder.join("ffmpeg.txt");
    std::fs::write(&written, text).unwrap();
    // Another process copies it: a file that any child of ours may have inherited open for writing does not run.
    assert!(Command::new("cp").arg(&written).arg(&path).status().unwrap().success());
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[cfg(unix)]
#[test]
fn colours_are_tagged_for_old_and_new_ffmpeg() {
    let (folder, out) = testing::place("out.mp4");
    let paths = frames(folder.path(), "png", (8, 6));
    let program = stand_in(folder.path(), "printf '%s\\n' \"$@\" > \"$0.asked\"; cat > /dev/null");
    encode_with(program.as_os_str(), paths.into_iter(), &film(&out), &Silent).unwrap();
    let asked = std::fs::read_to_string(folder.path().join("ffmpeg.sh.asked")).unwrap();
    let asked: Vec<&str> = asked.lines().collect();
    for pair in TAGS.chunks(2) {
        assert!(asked.windows(2).any(|words| words == pair), "{pair:?} of {asked:?}");
    }
    let filter = asked.iter().skip_while(|word| **word != "-vf").nth(1).unwrap();
    for part in [
        "scale=out_color_matrix=bt709:out_range=tv",
        "setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1",
    ] {
        assert!(filter.contains(part) && !filter.contains(' '), "{filter}");
    }
}

#[cfg(unix)]
#[test]
fn use_sound_and_chapters_decide_what_ffmpeg_is_asked_for() {
    let (folder, out) = testing::place("out.mp4");
    let program = stand_in(folder.path(), "printf '%s\\n' \"$@\" > \"$0.asked\"; cat > /dev/null");
    let asked = |settings: &VideoSettings| {
        let paths = frames(folder.path(), "png", (8, 6)).into_iter();
        encode_with(program.as_os_str(), paths, settings, &Silent).unwrap();
        std::fs::read_to_string(folder.path().join("ffmpeg.sh.asked")).unwrap().replace('\n', " ")
    };

    let plain = asked(&film(&out));
    assert!(plain.contains(" -i - -an -vf ") && plain.contains("-preset veryfast -crf 17"), "{plain}");
    let draft = asked(&VideoSettings { quality: VideoQuality::Draft, ..film(&out) });
    assert!(draft.contains("-preset veryfast"), "{draft}");

    let chapters = vec![Chapter { begin: 0.0, title: "Start".to_owned() }];
    let seconds = Some(60.0);
    let sound = Some(SoundTrack { file: "a.wav".into(), seconds });
    let both = asked(&VideoSettings { sound: sound.clone(), chapters: chapters.clone(), ..film(&out) });
    for part in [
        "-i - -t 0.333667 -i file:a.wav -f ffmetadata -i file:",
        "-map 0:v:0 -map_metadata:g -1 -map_chapters 2 -map 1:a:0 -c:a aac -b:a 192k -af afade=t=out:st=0.166833:d=0.166833 -vf",
    ] {
        assert!(both.contains(part), "{both}");
    }
    let heard = asked(&VideoSettings { sound, ..film(&out) });
    assert!(heard.contains("-map_chapters -1 -map 1:a:0"), "{heard}");
    let divided = asked(&VideoSettings { chapters: chapters.clone(), ..film(&out) });
    assert!(divided.contains("-map_chapters 1 -an"), "{divided}");

    // Containers that cannot hold it.
    for (name, settings) in [
        ("out.avi", VideoSettings { chapters, ..film(Path::new("out.avi")) }),
        ("out.webm", VideoSettings { quality: VideoQuality::Mezzanine, ..film(Path::new("out.webm")) }),
    ] {
        let message = check_with(program.as_os_str(), &settings).unwrap_err().to_string();
        assert!(message.contains(name) && message.contains(".mov"), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn pictures_reach_ffmpeg_as_they_come_and_in_order() {
    let (folder, out) = testing::place("out.mp4");
    let program = stand_in(folder.path(), "cat > \"$0.got\"");
    let pictures: Vec<_> =
        frames(folder.path(), "png", (8, 6)).iter().map(|path| read_picture(path).unwrap()).collect();
    let footage = Footage { size: Size { width: 8, height: 6 }, frame_count: 2 };
    let start = || VideoWriter::start_with(program.as_os_str(), &film(&out), footage, &Silent).unwrap();

    let mut writer = start();
    let inverted = Picture { rgb: pictures[0].rgb.iter().map(|code| !code).collect(), ..pictures[0].clone() };
    for picture in [&pictures[0], &inverted] {
        writer.push(picture, &out).unwrap();
    }
    writer.finish().unwrap();
    let got = std::fs::read(folder.path().join("ffmpeg.sh.got")).unwrap();
    assert_eq!(got, [&pictures[0].rgb[..], &inverted.rgb].concat());

    // One that is given up leaves what was there.
    std::fs::write(&out, b"earlier video").unwrap();
    let mut writer = start();
    writer.push(&pictures[0], &out).unwrap();
    drop(writer);
    assert_eq!(std::fs::read(&out).unwrap(), b"earlier video");
}

#[cfg(unix)]
#[test]
fn a_film_that_failed_is_never_finished() {
    let (folder, out) = testing::place("out.mp4");
    std::fs::write(&out, b"earlier video").unwrap();
    let program = stand_in(folder.path(), "echo 'No space left on device' >&2; exit 1");
    let footage = Footage { size: Size { width: 8, height: 6 }, frame_count: 9 };
    let mut writer = VideoWriter::start_with(program.as_os_str(), &film(&out), footage, &Silent).unwrap();
    let picture = Picture { width: 8, height: 6, rgb: vec![0; 144] };
    let error = std::iter::repeat_with(|| writer.push(&picture, &out)).find_map(Result::err).unwrap();
    assert!(error.to_string().contains("No space left on device"), "{error}");
    assert!(writer.push(&picture, &out).is_err() && writer.finish().is_err());
    assert_eq!(std::fs::read(&out).unwrap(), b"earlier video");
}

#[cfg(unix)]
#[test]
fn failures_of_ffmpeg_are_told_in_its_words() {
    let (folder, out) = testing::place("out.mp4");
    std::fs::write(&out, b"earlier video").unwrap();
    let paths = frames(folder.path(), "png", (256, 200));
    for (script, words, is_full) in [
        (
            "echo 'noise' >&2; echo 'Unknown pixel' >&2; exit 1",
            "ffmpeg could not encode it: Unknown pixel",
            false,
        ),
        ("cat >/dev/null; echo 'No space left on device' >&2; exit 228", "No space left on device", true),
        (
            "cat >/dev/null; echo 'x: No space left on device' >&2; echo 'End' >&2; exit 1",
            "No space left",
            true,
        ),
    ] {
        let program = stand_in(folder.path(), script);
        let error =
            encode_with(program.as_os_str(), paths.clone().into_iter(), &film(&out), &Silent).unwrap_err();
        let message = error.to_string();
        assert!(message.contains(words) && matches!(error, Error::Io { .. }) == is_full, "{message}");
        assert_eq!(std::fs::read(&out).unwrap(), b"earlier video");
    }
}

struct Cancels;

impl Observer for Cancels {
    fn cancelled(&self) -> bool {
        true
    }
}

#[cfg(unix)]
#[test]
fn cancelling_ends_ffmpeg_and_leaves_nothing() {
    let (folder, out) = testing::place("out.mp4");
    let paths = frames(folder.path(), "png", (8, 6));
    let program = stand_in(folder.path(), "exec sleep 60");
    let start = std::time::Instant::now();
    let error = encode_with(program.as_os_str(), paths.into_iter(), &film(&out), &Cancels).unwrap_err();
    assert!(matches!(error, Error::Interrupted(_)));
    assert!(start.elapsed().as_secs() < 30);
    assert!(!out.exists());
}

#[cfg(unix)]
#[test]
fn frames_must_be_whole_and_of_one_size() {
    let (folder, out) = testing::place("out.mp4");
    let mut paths = frames(folder.path(), "png", (8, 6));
    let program = stand_in(folder.path(), "cat >/dev/null");
    let run = |paths: &[PathBuf]| {
        let paths = paths.iter().cloned();
        encode_with(program.as_os_str(), paths, &film(&out), &Silent).map_err(|error| error.to_string())
    };
    let odd = folder.path().join("odd.png");
    write_frame(&odd, &testing::frame(10, 6), &testing::info()).unwrap();
    paths.push(odd.clone());
    assert!(run(&paths).unwrap_err().contains("--size"));
    std::fs::write(&odd, b"cut").unwrap();
    assert!(run(&paths).unwrap_err().contains("odd.png: no whole frame"));
    assert!(run(&[]).unwrap_err().contains("no frames"));
}
