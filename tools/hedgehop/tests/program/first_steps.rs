//! Things that a new user meets first: patterns of files, recordings of phones, how sharp an area is, manuals.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};

/// A folder with level ground of 1.6 km by 1.6 km, in a zone of UTM.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let rows = vec![vec!["50"; 160].join(" "); 160].join("\n");
    let head = "ncols 160\nnrows 160\nxllcorner 500000\nyllcorner 5000000\ncellsize 10";
    fs::write(folder.path().join("dem.asc"), format!("{head}\n{rows}\n")).expect("the grid is written");
    folder
}

const BUILD: &str = "build --elevation-crs EPSG:32632 -o area.hop --elevation";

/// Pages and completions are of the program by its name, and of all its commands.
#[test]
fn shells_and_manuals_know_all_commands() {
    let folder = site();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = ends(&run(&folder, &format!("completions {shell}")), 0);
        for word in ["build", "contact-sheet", "nodata-fill"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }

    assert!(ends(&run(&folder, "man"), 0).contains(".TH hedgehop 1"));
    ends(&run(&folder, "man man/man1"), 0);
    for (name, word) in
        [("hedgehop", "recipe"), ("hedgehop-build", "imagery"), ("hedgehop-recipe-check", "recipe")]
    {
        let text = fs::read_to_string(folder.path().join(format!("man/man1/{name}.1"))).expect("a page");
        assert!(text.contains(word) && text.contains(&format!(".TH {name} 1")), "{name}: {text}");
    }
}

#[test]
fn patterns_are_expanded_and_sharpness_is_told() {
    let folder = site();
    let built = ends(&run(&folder, &format!("{BUILD} d?m.*")), 0);
    // 10 m over 8 pixels at twice the height, each 2 tan 30° / 1280 wide.
    assert!(built.contains("sharp     from about 690 m above the ground"), "{built}");
    let none = ends(&run(&folder, &format!("{BUILD} *.hgt --overwrite")), 2);
    assert!(none.contains("--elevation *.hgt: no file matches"), "{none}");

    let blurred = |height: u32| {
        let args = format!(
            "render area.hop --eye 500800,5000800,{height} --alt-mode agl --size 1280x720 -o view.png"
        );
        ends(&run(&folder, &args), 0).contains("this area shows more than it knows")
    };
    assert!(blurred(20) && !blurred(700));
}

#[test]
fn one_of_several_tracks_is_flown() {
    let folder = site();
    ends(&run(&folder, &format!("{BUILD} dem.asc")), 0);
    let walk = |hour: u32| {
        let point = |second: u32| {
            let time = format!("2026-05-01T{hour:02}:00:0{second}Z");
            format!("<trkpt lat=\"45.15{second}\" lon=\"9.01\"><ele>500</ele><time>{time}</time></trkpt>")
        };
        format!("<trk><name>at {hour}</name><trkseg>{}{}</trkseg></trk>", point(0), point(2))
    };

    // The latest comes first, as phones have it.
    fs::write(folder.path().join("walks.gpx"), format!("<gpx>{}{}</gpx>", walk(14), walk(9)))
        .expect("a file");

    let overview = "overview area.hop --path walks.gpx --whole --size 400 -o map.png";
    let refused = ends(&run(&folder, overview), 3);
    for word in ["out of order", "1 \"at 14\"", "--track N", "--sort"] {
        assert!(refused.contains(word), "{word}: {refused}");
    }

    ends(&run(&folder, &format!("{overview} --track 2")), 0);
    ends(&run(&folder, &format!("{overview} --sort")), 0);
    let nothing = ends(&run(&folder, "render area.hop --eye 9,9,900 --track 2 -o view.png"), 2);
    assert!(nothing.contains("--path FILE"), "{nothing}");
}
