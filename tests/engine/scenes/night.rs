//! What scenes say of night, lights, plumes and what falls.

use glam::{DVec2, DVec3};

use super::{CAR as CAR_TRACK, read_beside, slope};
use hedgehop::Result;
use hedgehop::geo::Crs;
use hedgehop::objects::PointLight;
use hedgehop::scene::*;
use hedgehop::weather::{GroundCover, Precipitation, PrecipitationKind};

fn read(text: &str) -> Result<Scene> {
    read_beside(text, &[CAR_TRACK])
}

/// Ground that ends 5 km to the east, metres.
fn ground(place: DVec2) -> Option<f64> {
    slope(place).filter(|_| place.x < 5000.0)
}

fn bind(text: &str) -> Result<Cast> {
    read(text)?.bind(&Crs::local(), &ground)
}

fn lights(text: &str, seconds: f64) -> Vec<PointLight> {
    bind(text).unwrap().lights_at(seconds)
}

const CAR: &str = "[[object]]\nname = \"car\"\nshape = \"sphere\"\nradius_m = 1\ntrack = \"car.csv\"\n";

#[test]
fn nights_are_as_the_scene_says() {
    let plain = read("[sun]\nazimuth_deg = 10\nelevation_deg = -20").unwrap();
    assert_eq!(plain.night, NightSky { lux: 0.1, stars: true });
    let dark = read("[night]\nlight_lx = 0.001\nstars = false").unwrap();
    assert_eq!(dark.night, NightSky { lux: 0.001, stars: false });
}

#[test]
fn what_falls_lies_on_the_ground_unless_the_scene_says_otherwise() {
    let weather = |text: &str| read(text).unwrap().weather;
    let rain = weather("[precipitation]\nkind = \"rain\"\nrate_mm_h = 5\nwind_mps = [2, -1]");
    let falls = Precipitation { kind: PrecipitationKind::Rain, rate: 5.0, wind: [2.0, -1.0] };
    assert_eq!((rain.precipitation, rain.ground), (Some(falls), GroundCover { wet: 1.0, snow: 0.0 }));
    let snow = weather("[precipitation]\nkind = \"snow\"\nrate_mm_h = 1\n[ground]\nsnow = 0.25\nwet = 0.5");
    assert_eq!(snow.ground, GroundCover { wet: 0.5, snow: 0.25 });
    assert_eq!(weather("[ground]\nsnow = 1").ground.snow, 1.0);
}

#[test]
fn lamps_stand_on_their_own_ground_and_are_turned_as_the_scene_says() {
    let runway =
        lights("[[light]]\nkind = \"runway\"\nat = [1000, 500, 0.5]\nyaw_deg = 90\nlength_m = 600", 0.0);
    assert!(runway.iter().all(|lamp| (lamp.position.z - 100.5 - 0.1 * lamp.position.x).abs() < 1e-9));
    let (low, high) = runway.iter().fold((f64::MAX, f64::MIN), |(low, high), lamp| {
        (low.min(lamp.position.x), high.max(lamp.position.x))
    });

    // Eastward from the threshold on.
    assert!((low - 999.0).abs() < 1e-6 && (high - 1601.0).abs() < 1e-6, "{low} {high}");
    let msl = lights("[[light]]\nkind = \"papi\"\nat = [1000, 500, 321]\naltitude = \"msl\"", 0.0);
    assert!(msl.len() == 4 && msl.iter().all(|lamp| lamp.position.z == 321.0));
    let string = "[[light]]\nkind = \"string\"\nat = [0, 0, 1]\nto = [0, 100, 3]\nspacing_m = 24\n";
    let heights: Vec<_> = lights(string, 0.0).iter().map(|lamp| (lamp.position.y, lamp.position.z)).collect();
    assert_eq!(heights, [(0.0, 101.0), (25.0, 101.5), (50.0, 102.0), (75.0, 102.5), (100.0, 103.0)]);

    // A flash runs along.
    let running = format!("{string}flash_s = [4, 0.9]\nrunning_s = 4");
    for (seconds, place) in [(0.1, 0.0), (1.1, 25.0), (2.1, 50.0), (3.1, 75.0)] {
        let lit: Vec<_> = lights(&running, seconds).iter().map(|lamp| lamp.position.y).collect();
        assert!(lit.contains(&place) && lit.len() <= 2, "{seconds}: {lit:?}");
    }
}

#[test]
fn lamps_go_with_objects_flash_and_turn() {
    let text = format!(
        "{CAR}[[light]]\nobject = \"car\"\noffset_m = [0.5, 2, 1]\nyaw_deg = 180\nbeam_deg = [20, 10]\nflash_s = [1, 0.5]\n"
    );
    let lamp = &lights(&text, 5.0)[0];

    // Eastward: its right is south.
    let body = bind(&text).unwrap().bodies_at(5.0)[0].position;
    let off = lamp.position - body;
    assert!((off.x - 2.0).abs() < 0.3 && (off.y + 0.5).abs() < 0.01 && (off.z - 1.0).abs() < 0.3, "{off}");
    let towards = |at: DVec3| lamp.towards(lamp.position + at);
    assert!(
        towards(DVec3::new(-100.0, 0.0, -10.0)).x > 50.0 && towards(DVec3::new(100.0, 0.0, 0.0)).x == 0.0
    );
    assert!(lights(&text, 5.6).is_empty());
    let beacon = "[[light]]\nkind = \"beacon\"\nat = [100, 100, 20]\nturn_rpm = 15\n";
    let north = |seconds: f64| {
        let lamp = &lights(beacon, seconds)[0];
        lamp.towards(lamp.position + DVec3::new(0.0, 5000.0, 350.0)).y
    };

    // A turn takes four seconds; white first, green half a turn later.
    assert!(
        north(0.0) > 1000.0 * north(1.0)
            && north(4.0) > 1000.0 * north(1.0)
            && north(2.0) > 100.0 * north(1.0)
    );
}

#[test]
fn plumes_come_from_objects_and_places() {
    let text = format!("{CAR}[[plume]]\nkind = \"dust\"\nobject = \"car\"\n");
    let puffs = bind(&text).unwrap().puffs_at(10.0);
    assert!(puffs.len() > 50 && puffs.iter().all(|puff| puff.centre.x > 20.0 && puff.centre.x < 115.0));
    assert!(bind(&text).unwrap().puffs_at(60.0).is_empty(), "a car that stands raises no dust");
    let fire = "[[plume]]\nkind = \"smoke\"\nat = [100, 100, 2]\nwind_mps = [4, 0]\n";
    let puffs = bind(fire).unwrap().puffs_at(3.0);
    assert!((150..=160).contains(&puffs.len()), "{}", puffs.len());
}

#[test]
fn mistakes_are_told_with_line_and_key() {
    let cases = [
        ("[night]\nlight_lx = -1", "line 2", "light_lx"),
        ("[precipitation]\nkind = \"hail\"\nrate_mm_h = 3", "line 2", "hail"),
        ("[precipitation]\nkind = \"rain\"\nrate_mm_h = 0", "line 3", "rate_mm_h"),
        ("[precipitation]\nkind = \"rain\"\nrate_mm_h = 3\nwind_mps = [1]", "line 4", "2 numbers"),
        ("[ground]\nwet = 2", "line 2", "wet"),
        ("[[light]]\ncandela = 3", "line 1", "at or at_lonlat"),
        ("[[light]]\nkind = \"star\"\nat = [1, 2, 3]", "line 2", "star"),
        ("[[light]]\nat = [1, 2]", "line 2", "3 numbers"),
        ("[[light]]\nat = [1, 2, 3]\ncolour = \"puce\"", "line 3", "colour"),
        ("[[light]]\nat = [1, 2, 3]\ncandela = -1", "line 3", "candela"),
        ("[[light]]\nat = [1, 2, 3]\nflash_s = [1, 2]", "line 3", "flash_s"),
        ("[[light]]\nat = [1, 2, 3]\nphase_s = 1", "line 3", "flash_s"),
        ("[[light]]\nat = [1, 2, 3]\ntwo_sided = true", "line 3", "beam_deg"),
        ("[[light]]\nat = [1, 2, 3]\nlength_m = 100", "line 3", "a lamp has no length_m"),
        ("[[light]]\nkind = \"runway\"\nat = [1, 2, 3]", "line 1", "length_m"),
        (
            "[[light]]\nkind = \"town\"\nat = [1, 2, 3]\nextent_m = [10, 10]\ncount = 5000000",
            "line 5",
            "count",
        ),
        ("[[light]]\nkind = \"string\"\nat = [1, 2, 3]\nto = [9, 2, 3]", "line 1", "spacing_m"),
        ("[[light]]\nobject = \"car\"\nat = [1, 2, 3]", "line 3", "offset_m"),
        ("[[plume]]\nat = [1, 2, 3]", "line 1", "kind"),
        ("[[plume]]\nkind = \"dust\"\nat = [1, 2, 3]", "line 2", "object"),
        ("[[plume]]\nkind = \"smoke\"\nat = [1, 2, 3]\nlife_s = 600\nper_s = 100", "line 1", "puffs"),
        ("[[plume]]\nkind = \"smoke\"\nat = [1, 2, 3]\nopacity = 1", "line 4", "opacity"),
    ];

    for (text, line, key) in cases {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(line) && error.contains(key), "{text}: {error}");
    }

    for (text, what) in [
        ("\n[[light]]\nobject = \"bus\"\n", "no object `bus`"),
        ("\n[[plume]]\nkind = \"smoke\"\nobject = \"bus\"\n", "no object `bus`"),
        ("\n[[light]]\nkind = \"runway\"\nat = [4900, 5, 1]\nyaw_deg = 90\nlength_m = 500\n", "no ground"),
        (
            "\n[[light]]\nkind = \"string\"\nat = [0, 0, 1]\nto = [4000, 4000, 1]\nspacing_m = 0.1\naltitude = \"msl\"\n[[light]]\nkind = \"town\"\nat = [9, 9, 1]\nextent_m = [9, 9]\ncount = 999999\n",
            "1000000 lamps",
        ),
    ] {
        let error = bind(text).unwrap_err().to_string();
        assert!(error.contains(what) && error.contains("scene.toml: line "), "{text}: {error}");
    }
}
