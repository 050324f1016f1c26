//! Tables of scene files that say what is made of light.

use super::read_beside;
use hedgehop::Result;
use hedgehop::scene::{Dither, Finish, Hud, Tone};

fn read(text: &str) -> Result<(Finish, Hud)> {
    read_beside(text, &[]).map(|scene| (scene.finish, scene.titling.hud))
}

#[test]
fn the_tables_say_what_is_made_of_light() {
    let (finish, hud) = read("").unwrap();
    assert_eq!((finish, hud), (Finish::default(), Hud::default()));
    assert!(!finish.is_developed() && !finish.gathers() && hud.is_empty());
    let text = "[picture]\nexposure_ev = -1.5\ntone = \"filmic\"\ngamma = 2.2\ndither = \"ordered\"\nvignette = 0.4\n\
                distortion = [-0.2, 0.01]\nantialias = 2\nshutter_deg = 180\n[hud]\nshow = [\"map\", \"time\"]\n";
    let (finish, hud) = read(text).unwrap();

    let expected = Finish {
        exposure: -1.5,
        tone: Tone::Filmic,
        gamma: Some(2.2),
        dither: Dither::Ordered,
        vignette: 0.4,
        distortion: [-0.2, 0.01],
        antialias: 2,
        shutter: 180.0,
    };

    assert_eq!(finish, expected);
    assert!(finish.check().is_ok() && finish.is_developed() && finish.gathers());
    assert_eq!(hud.names(), ["time", "map"]);
    assert_eq!(read("[hud]\n").unwrap().1, Hud::ALL);
    assert_eq!(read("[hud]\nshow = []\n").unwrap().1, Hud::default());
}

#[test]
fn what_is_wrong_is_told_by_line_and_key() {
    for (line, part) in [
        ("exposure_ev = 17", "line 2: exposure_ev must be -16 to 16 stops, not 17"),
        ("exposure_ev = nan", "exposure_ev must be"),
        ("tone = \"film\"", "line 2: tone must be none or filmic, not \"film\""),
        ("gamma = 0.5", "gamma must be 1 to 4"),
        ("dither = \"noise\"", "dither must be none or ordered"),
        ("vignette = 1", "vignette must be 0 to 0.95"),
        ("distortion = [0.1, inf]", "distortion must be [k1, k2]"),
        ("antialias = 3", "antialias must be 1, 2 or 4, not 3"),
        ("shutter_deg = -1", "shutter_deg must be 0 to 360 degrees"),
        ("shutter = 1", "unknown field"),
    ] {
        let said = read(&format!("[picture]\n{line}\n")).unwrap_err().to_string();
        assert!(said.contains(part), "{line}: {said}");
    }
    let said = read("[hud]\nshow = [\"time\", \"clock\"]\n").unwrap_err().to_string();
    assert!(said.contains("line 2: show takes horizon, heading") && said.contains("\"clock\""), "{said}");
}

#[test]
fn values_beyond_their_ranges_are_refused() {
    let plain = Finish::default();
    for finish in [
        Finish { exposure: f64::NAN, ..plain },
        Finish { gamma: Some(0.9), ..plain },
        Finish { vignette: 1.0, ..plain },
        Finish { distortion: [0.0, f64::INFINITY], ..plain },
        Finish { antialias: 0, ..plain },
        Finish { shutter: 361.0, ..plain },
    ] {
        assert!(finish.check().unwrap_err().to_string().contains("--"), "{finish:?}");
    }
}
