//! Trails of scenes: whose way they are, which part of it, and in which colours.

use glam::Vec3;

use super::{CAR, read_beside, slope};
use hedgehop::Result;
use hedgehop::geo::Crs;
use hedgehop::objects::{ChordNode, Ribbon, RibbonSample, Sight};
use hedgehop::scene::Scene;

/// A climb of 60 s to 60 m, half of the time level.
const CLIMB: (&str, &[u8]) = (
    "climb.csv",
    b"time,x,y,alt_msl_m,yaw\n0,0,0,500,0\n10,0,100,500,0\n20,0,200,500,0\n30,0,300,500,0\n40,0,400,520,0\n50,0,500,540,0\n60,0,600,560,0\n",
);

fn read(text: &str) -> Result<Scene> {
    let car =
        "[[object]]\nname = \"car\"\nshape = \"sphere\"\nradius_m = 1\ntrack = \"car.csv\"\nstart_s = 5\n";
    let post = "[[object]]\nname = \"post\"\nshape = \"sphere\"\nradius_m = 1\nat = [1, 2, 3]\n";
    read_beside(&format!("{text}\n{car}{post}"), &[CAR, CLIMB])
}

fn at(text: &str, seconds: f64) -> Vec<Ribbon> {
    read(text).unwrap().bind(&Crs::local(), &slope).unwrap().at(seconds).trails
}

fn samples(ribbon: &Ribbon) -> Vec<RibbonSample> {
    let mut all = Vec::new();
    let fine = |_: &ChordNode| Sight::Coarse;
    ribbon.line.pieces(ribbon.span, fine, |from, to| {
        all.extend(all.is_empty().then_some(*from));
        all.push(*to);
    });
    all
}

#[test]
fn trails_reach_from_where_their_flight_was_to_where_it_is() {
    let trail = "[[trail]]\nobject = \"car\"\n";
    assert!(at(trail, 5.0).is_empty());
    let ribbon = &at(trail, 17.0)[0];
    let (first, last) = (samples(ribbon)[0], *samples(ribbon).last().unwrap());
    assert_eq!((first.time, last.time), (0.0, 12.0));
    assert!((last.position.x - 130.0).abs() < 0.1 && (last.position.z - 113.0).abs() < 0.1, "{last:?}");

    let span =
        |text: &str, seconds: f64| at(&format!("{trail}{text}"), seconds).first().map(|ribbon| ribbon.span);
    assert_eq!(span("", 900.0), Some([0.0, 20.0]));
    assert_eq!(span("tail_s = 4", 17.0), Some([8.0, 12.0]));
    assert_eq!(span("tail_s = 4", 900.0), None);
    assert_eq!(span("whole = true", 0.0), Some([0.0, 20.0]));
    assert_eq!(at("[[trail]]\ntrack = \"climb.csv\"\nstart_s = -10\n", 10.0)[0].span, [0.0, 20.0]);
}

#[test]
fn colours_are_those_of_the_quantity() {
    let colours = |text: &str, seconds: [f64; 2]| {
        let ribbon = &at(&format!("[[trail]]\ntrack = \"climb.csv\"\n{text}"), 60.0)[0];
        let samples = samples(ribbon);
        seconds.map(|time| ribbon.ramp.at(samples.iter().find(|sample| sample.time >= time).unwrap().value))
    };
    let luminance = |colour: Vec3| colour.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let [low, high] = colours("by = \"altitude\"", [0.0, 60.0]);
    assert!(luminance(high) > 5.0 * luminance(low));
    let [level, up] = colours("by = \"climb\"\nrange = [-2, 2]", [10.0, 55.0]);
    assert!(level.min_element() > 0.7 && up.x > 0.5 && up.y < 0.1, "{level} {up}");
    let [one, other] = colours("by = \"speed\"\nrange = [0, 20]", [10.0, 50.0]);
    assert!((one - other).length() < 0.05, "{one} {other}");
    assert_eq!(colours("colour = \"#00ff00\"", [0.0, 30.0]), [Vec3::Y; 2]);
}

#[test]
fn mistakes_are_told_with_their_line() {
    for (text, parts) in [
        ("", ["line 1", "needs object"]),
        ("object = \"ghost\"", ["line 2", "no object `ghost`"]),
        ("object = \"post\"", ["line 2", "stands"]),
        ("object = \"car\"\ntrack = \"climb.csv\"", ["line 3", "not both"]),
        ("object = \"car\"\nstart_s = 3", ["line 3", "its object says"]),
        ("track = \"none.csv\"", ["line 2", "none.csv"]),
        ("object = \"car\"\nby = \"height\"", ["line 3", "height"]),
        ("object = \"car\"\nby = \"speed\"\ncolour = \"#ffffff\"", ["line 3", "not both"]),
        ("object = \"car\"\nby = \"speed\"\nrange = [3, 1]", ["line 4", "low below high"]),
        ("object = \"car\"\nrange = [1, 3]", ["line 3", "give by"]),
        ("object = \"car\"\ncolour = \"red\"", ["line 3", "#rrggbb"]),
        ("object = \"car\"\nwidth_px = 0", ["line 3", "0.1 to 100"]),
        ("object = \"car\"\ntail_s = 0", ["line 3", "more than 0"]),
        ("object = \"car\"\ntail_s = 3\nwhole = true", ["line 3", "leave one"]),
    ] {
        let said = read(&format!("[[trail]]\n{text}")).unwrap_err().to_string();
        for part in parts {
            assert!(said.contains(part), "{text:?}: {said}");
        }
    }
}
