//! Formats from small samples, real files, and damaged ones.

use std::path::{Path, PathBuf};

use super::super::track::{AltitudeMode, Horizontal};
use super::super::{BindOptions, Trajectory};
use super::*;
use hedgehop_geo::Crs;

fn parse_with(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Track> {
    let path = PathBuf::from(name);
    let source = PathSource { path: &path, options };
    let text = text_of(&source, bytes)?;
    assemble(&source, read_text(&source, &text)?)
}

fn parse(name: &str, text: &str) -> Result<Track> {
    parse_with(name, text.as_bytes(), &ReadOptions::default())
}

#[track_caller]
fn assert_error(name: &str, text: &str, parts: &[&str]) {
    let message = parse(name, text).expect_err("an error").to_string();
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

const GPX: &str = r#"<?xml version="1.0"?>
<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">
<wpt lat="1" lon="2"><ele>3</ele></wpt>
<trk><trkseg>
<trkpt lat="47.5" lon="8.25"><ele>500.5</ele><time>2026-05-01T12:00:00Z</time>
  <extensions><x:time xmlns:x="x">no time</x:time><unknown><ele>9</ele></unknown></extensions></trkpt>
<trkpt lat="47.6" lon="8.26"><time>2026-05-01T12:00:01Z</time><magvar>1</magvar></trkpt>
<trkpt lon="8.27" lat="47.7"><ele>502</ele><time>2026-05-01T14:00:02.5+02:00</time></trkpt>
</trkseg></trk></gpx>"#;

const KML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">
<Placemark><Point></Point><gx:Track><altitudeMode>absolute</altitudeMode>
<when>2026-05-01T12:00:00Z</when>
<when>2026-05-01T12:00:10Z</when>
<gx:coord>8.25 47.5 1200.5</gx:coord>
<gx:coord>8.26 47.6 1210</gx:coord>
<gx:angles>45.5 -3 10</gx:angles>
<gx:angles>46.5 -4 11</gx:angles>
</gx:Track></Placemark></kml>"#;

const IGC: &str = "AXCT123\r\nHFDTE010526\r\nI023637LAD3838LOD\r\n\
    B2359584730000N00815000EA004000045012\r\n\
    B2359594730000N00815000EV004000000012\r\n\
    B0000004730600N00815600WA0041000460123\r\n\
    GSIGNATURE\r\n";

const JSBSIM: &str = "Time,Altitude ASL (ft),Altitude AGL (ft),Phi (deg),Theta (deg),Psi (deg),Latitude (deg),\
    Latitude Geodetic (deg),Longitude (deg),X_{ECEF} (ft)\n\
    0,1000,10,1,2,3,40.8,41,-100,5\n0.5,2000,10,4,5,6,40.8,41.5,-100.5,5\n";

const CSV: &str = "time_s,lon_deg,lat_deg,alt_msl_m,yaw_deg,pitch_deg,roll_deg,hfov_deg\n\
    0,8.25,47.5,1200,10,-5,3,60\n1,8.26,47.6,1300,20,-6,4,50\n";

#[test]
fn gpx_takes_direct_children_only_and_skips_points_without_elevation() {
    let track = parse("a.gpx", GPX).unwrap();
    assert_eq!(track.format, "GPX");
    assert_eq!(track.fixes.len(), 2);
    assert_eq!(track.fixes[0].horizontal, Horizontal::LonLat(8.25, 47.5));
    assert_eq!(track.fixes[0].altitude.metres, 500.5);
    assert_eq!(track.fixes[0].altitude.mode, AltitudeMode::Msl);
    assert_eq!(track.fixes[1].time, 2.5);
    assert!(
        track.notes.iter().any(|note| note.starts_with("1 points without elevation")),
        "{:?}",
        track.notes
    );
}

#[test]
fn fixes_tell_how_sure_they_are() {
    let gpx = |hdop: &str| {
        let with = GPX.replace("<ele>502</ele>", &format!("<ele>502</ele><hdop>{hdop}</hdop>"));
        parse("a.gpx", &with).unwrap().fixes[1].accuracy
    };
    assert_eq!(gpx("1.25"), Some(1.25));
    for nothing in ["0", "-1", "NaN", "good", ""] {
        assert_eq!(gpx(nothing), None, "{nothing}");
    }

    let igc = |fxa: &str| {
        let with = IGC.replace("I023637LAD3838LOD", "I033637LAD3838LOD3941FXA");
        let with = with.replace("0041000460123", &format!("0041000460123{fxa}"));
        parse("a.igc", &with).unwrap().fixes.last().unwrap().accuracy
    };
    assert_eq!((igc("017"), igc("000"), igc("---"), igc("")), (Some(17.0), None, None, None));
}

#[test]
fn gpx_errors_name_lines() {
    assert_error(
        "a.gpx",
        &GPX.replace("14:00:02.5", "13:59:59"),
        &["line 8", "out of order", "line 5", "sort"],
    );
    assert_error("a.gpx", &GPX.replace("2026-05-01T12:00:01Z", "noon"), &["line 7", "noon", "ISO 8601"]);
    assert_error(
        "a.gpx",
        &GPX.replace("<time>2026-05-01T12:00:01Z</time>", ""),
        &["line 7", "no time", "time_s"],
    );
    assert_error("a.gpx", &GPX.replace("lat=\"47.7\"", "lat=\"47,7\""), &["line 8", "lat", "47,7"]);
    assert_error("a.gpx", &GPX.replace("lat=\"47.7\"", ""), &["line 8", "lat", "missing"]);
    assert_error("a.gpx", &GPX.replace("502<", "NaN<"), &["line 8", "ele", "finite"]);
    assert_error("a.gpx", &GPX.replace("</trkseg></trk></gpx>", ""), &["line 9", "cut off"]);
    assert_error("a.gpx", &GPX[..GPX.len() - 3], &["line 9", "damaged"]);
    assert_error("a.gpx", "<gpx><rte><rtept lat='1' lon='2'/></rte></gpx>", &["no track", "export"]);
    assert_error("a.gpx", "time,lat\n", &["no XML"]);
    assert_error("a.xml", "<svg></svg>", &["neither GPX nor KML"]);
}

#[test]
fn kml_tracks_with_angles_and_altitude_modes() {
    let track = parse("a.kml", KML).unwrap();
    assert_eq!(track.format, "KML gx:Track");
    let fix = track.fixes[1];
    assert_eq!((fix.time, fix.horizontal), (10.0, Horizontal::LonLat(8.26, 47.6)));
    assert_eq!((fix.yaw, fix.pitch, fix.roll), (Some(46.5), Some(-4.0), Some(11.0)));
    assert_eq!(fix.altitude, super::super::Altitude { metres: 1210.0, mode: AltitudeMode::Msl });
    let mode = |text: &str| {
        let kml = KML.replace("<altitudeMode>absolute</altitudeMode>", text);
        parse("a.kml", &kml).unwrap().fixes[0].altitude
    };
    assert_eq!(mode("<gx:altitudeMode>relativeToGround</gx:altitudeMode>").mode, AltitudeMode::Agl);
    assert_eq!(mode("").mode, AltitudeMode::Msl);
    let clamped = mode("<altitudeMode>clampToGround</altitudeMode>");
    assert_eq!((clamped.metres, clamped.mode), (0.0, AltitudeMode::Agl));
}

#[test]
fn kml_errors_name_lines() {
    assert_error(
        "a.kml",
        &KML.replace("<when>2026-05-01T12:00:10Z</when>", ""),
        &["line 3", "1 when", "2 gx:coord"],
    );
    assert_error("a.kml", &KML.replace("8.26 47.6 1210", "8.26 47.6"), &["line 7", "altitude"]);
    assert_error("a.kml", &KML.replace("8.26 47.6", "8.26 x"), &["line 7", "\"x\""]);
    assert_error("a.kml", &KML.replace("absolute", "relativeToSeaFloor"), &["line 3", "relativeToSeaFloor"]);
    let line = "<kml><LineString><coordinates>1,2,3 4,5,6</coordinates></LineString></kml>";
    assert_error("a.kml", line, &["no times", "gx:Track", "CSV"]);
    assert_error("a.kmz", "PK\u{3}\u{4}rest", &["zip", "unzip"]);
}

#[test]
fn igc_flies_valid_gnss_fixes_through_midnight_with_extra_digits() {
    let track = parse("a.igc", IGC).unwrap();
    assert_eq!(track.format, "IGC");
    assert_eq!(track.fixes.len(), 2, "the V fix is dropped");
    let Horizontal::LonLat(longitude, latitude) = track.fixes[0].horizontal else { panic!("degrees") };
    assert!((latitude - (47.5 + 0.12 / 60_000.0)).abs() < 1e-12, "{latitude}");
    assert!((longitude - 8.25).abs() < 1e-12, "{longitude}");
    let Horizontal::LonLat(west, _) = track.fixes[1].horizontal else { panic!("degrees") };
    assert!((west + (8.26 + 0.3 / 60_000.0)).abs() < 1e-12, "{west}");
    assert_eq!(track.fixes[1].time, 2.0);
    assert_eq!(track.fixes[1].altitude.metres, 460.0);
    assert_eq!(track.fixes[1].altitude.mode, AltitudeMode::Msl, "not approved (X…)");
    let mode = |text: &str| parse("a.igc", text).unwrap().fixes[0].altitude.mode;
    assert_eq!(mode(&IGC.replace("AXCT", "ALXN")), AltitudeMode::Ellipsoid);
    let stated = IGC.replace("HFDTE010526", "HFALGALTGPS:ELL");
    assert_eq!(mode(&stated), AltitudeMode::Ellipsoid);
    let by_pressure = parse("a.igc", &IGC.replace("EA", "EV").replace("WA", "WV")).unwrap();
    assert_eq!(by_pressure.fixes.len(), 3);
    assert_eq!(by_pressure.fixes[0].altitude.metres, 400.0);
    assert!(by_pressure.notes.iter().any(|note| note.contains("pressure altitude")));
}

#[test]
fn clocks_tell_the_day_where_the_file_does() {
    let clock = |name: &str, text: &str| parse(name, text).unwrap().clock.unwrap();
    let igc = clock("a.igc", IGC);
    // 2026-05-01.
    let may = 1_777_593_600.0;
    assert_eq!((igc.midnight, igc.time_of_day.floor()), (Some(may), 86_398.0));
    assert_eq!(igc.unix_seconds(), Some(may + igc.time_of_day));
    for (header, midnight) in [
        ("HFDTEDATE:010526,01", Some(may)),
        ("HFDTE DATE: 010526", Some(may)),
        ("HFDTE310398", Some(891_302_400.0)),
        ("HFDTE320526", None),
        ("HFDTE", None),
        ("HFPLT010526", None),
    ] {
        assert_eq!(clock("a.igc", &IGC.replace("HFDTE010526", header)).midnight, midnight, "{header}");
    }

    let csv = |column: &str, cell: &str| parse("a.csv", &format!("{column},x,y,z\n{cell},1,2,3\n")).unwrap();
    let dated = csv("time", "2026-05-01T12:00:00+02:00").clock.unwrap();
    assert_eq!((dated.midnight, dated.time_of_day), (Some(may), 36_000.0));
    assert_eq!(csv("unix_time_s", "1777629600.5").clock.unwrap().unix_seconds(), Some(may + 36_000.5));
    assert_eq!(csv("time_s", "36000").clock, None);
}

#[test]
fn igc_errors_name_lines() {
    assert_error("a.igc", &IGC.replace("B2359594730000N", "B2359594730000Q"), &["line 5", "damaged"]);
    assert_error(
        "a.igc",
        &IGC.replace("EV", "EA").replace("B235959", "B235957"),
        &["line 5", "out of order", "line 4"],
    );
    assert_error("a.igc", "AXCT\r\nHFDTE010526\r\n", &["no fix"]);
    let cut = IGC.trim_end().trim_end_matches("GSIGNATURE").trim_end();
    let track = parse("a.igc", &cut[..cut.len() - 12]).unwrap();
    assert!(track.notes.iter().any(|note| note.contains("Line 6, the last")), "{:?}", track.notes);
}

#[test]
fn jsbsim_takes_geodetic_latitude_and_feet() {
    let track = parse("out.csv", JSBSIM).unwrap();
    assert_eq!(track.format, "JSBSim CSV");
    let fix = track.fixes[1];
    assert_eq!(fix.horizontal, Horizontal::LonLat(-100.5, 41.5));
    assert!((fix.altitude.metres - 609.6).abs() < 1e-9);
    assert_eq!(fix.altitude.mode, AltitudeMode::Msl);
    assert_eq!((fix.yaw, fix.pitch, fix.roll), (Some(6.0), Some(5.0), Some(4.0)));
    assert_error(
        "out.csv",
        &JSBSIM.replace("Latitude Geodetic", "Radius"),
        &["line 1", "Geodetic", "geocentric"],
    );
    let properties = "Time,/fdm/jsbsim/position/lat-geod-deg,/fdm/jsbsim/position/long-gc-rad,\
        /fdm/jsbsim/position/h-sl-ft,/fdm/jsbsim/attitude/psi-deg\n0,10,1,100,20\n";
    let fix = parse("out.csv", properties).unwrap().fixes[0];
    assert_eq!(fix.horizontal, Horizontal::LonLat(1.0_f64.to_degrees(), 10.0));
    assert_eq!((fix.altitude.metres, fix.yaw), (100.0 * 0.3048, Some(20.0)));
}

#[test]
fn a_csv_named_otherwise_and_binary_files() {
    assert_eq!(parse("flight.txt", CSV).unwrap().fixes.len(), 2);
    assert_eq!(parse("no_extension", IGC).unwrap().format, "IGC");
    assert_eq!(parse("flight.csv", &format!("\u{feff}{CSV}")).unwrap().fixes.len(), 2);
    assert_error("a.csv", "", &["empty"]);
    assert_error("a.csv", "\n  \n", &["empty"]);
    assert_error("a.csv", "a\0b", &["binary"]);
    let utf16 = parse_with("a.csv", &[0xff, 0xfe, b't', 0], &ReadOptions::default());
    assert!(utf16.unwrap_err().to_string().contains("UTF-16"));
    let missing = read_track(Path::new("does-not-exist.csv"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(missing, Error::Io { .. }), "{missing}");
}

/// A small generator (Steele, Lea and Flood 2014, SplitMix64), so that failures repeat.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }
}

fn mutated(text: &str, dice: &mut Dice) -> Vec<u8> {
    const PIECES: [&[u8]; 12] = [
        b"NaN",
        b"1e999",
        b"-",
        b",",
        b"<",
        b">",
        b"\"",
        b"\n",
        b"\xff\xfe",
        b"99999999999999999999",
        b"&#0;",
        b"",
    ];

    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=dice.below(4) {
        let place = dice.below(bytes.len());
        match dice.below(5) {
            0 => bytes[place] = dice.below(256) as u8,
            1 => bytes.truncate(place.max(1)),
            2 => drop(bytes.drain(place..(place + dice.below(40)).min(bytes.len()))),
            3 => {
                let copy = bytes[place..(place + dice.below(80)).min(bytes.len())].to_vec();
                bytes.splice(place..place, copy);
            }
            _ => drop(bytes.splice(place..place, PIECES[dice.below(PIECES.len())].iter().copied())),
        }

        if bytes.is_empty() {
            break;
        }
    }

    bytes
}

#[test]
fn damaged_files_give_an_error_or_a_sound_track() {
    let samples = [("a.gpx", GPX), ("a.kml", KML), ("a.igc", IGC), ("a.csv", JSBSIM), ("b.csv", CSV)];
    let crs = Crs::from_epsg(32632).unwrap();
    let mut dice = Dice(2026);
    let mut accepted = 0;

    for round in 0..600 {
        let (name, text) = samples[round % samples.len()];
        let bytes = mutated(text, &mut dice);
        let name = if dice.below(4) == 0 { "flight" } else { name };
        let Ok(track) = parse_with(name, &bytes, &ReadOptions::default()) else { continue };
        accepted += 1;
        assert!(!track.fixes.is_empty() && track.fixes[0].time == 0.0);
        assert!(track.fixes.windows(2).all(|pair| pair[0].time < pair[1].time));
        for fix in &track.fixes {
            let (Horizontal::LonLat(x, y) | Horizontal::Xy(x, y)) = fix.horizontal;
            assert!(x.is_finite() && y.is_finite() && fix.altitude.metres.is_finite());
        }

        assert_flies(&track, &crs);
    }

    assert!((50..550).contains(&accepted), "{accepted} of 600 were accepted: the mutations test nothing");
}

/// Bound to a system on Earth, a track gives an error or finite poses.
fn assert_flies(track: &Track, crs: &Crs) {
    let options = BindOptions { clearance: Some(20.0), ..BindOptions::default() };
    let Ok(flight) = Trajectory::bind(track, crs, &|at| Some(500.0 + (0.01 * at.x).sin()), &options) else {
        return;
    };
    for step in 0..=20 {
        let pose = flight.pose_at(flight.duration() * f64::from(step) / 20.0);
        assert!(pose.eye.is_finite() && pose.hfov > 0.0 && pose.hfov < 180.0, "{pose:?}");
        let view = pose.attitude.world_from_view();
        assert!(view.is_finite() && (view.determinant().abs() - 1.0).abs() < 1e-9, "{pose:?}");
        assert!(pose.attitude.pitch.abs() <= 90.0 && (0.0..=360.0).contains(&pose.attitude.yaw), "{pose:?}");
    }
}

#[test]
fn every_prefix_of_every_format_is_answered() {
    for (name, text) in [("a.gpx", GPX), ("a.kml", KML), ("a.igc", IGC), ("a.csv", JSBSIM), ("b.csv", CSV)] {
        for end in 0..text.len() {
            let _ = parse_with(name, &text.as_bytes()[..end], &ReadOptions::default());
        }
    }
}

#[test]
fn deep_xml_is_no_matter() {
    let deep = format!("<gpx>{}", "<a>".repeat(200_000));
    assert_error("a.gpx", &deep, &["cut off"]);
    let deep = format!("<kml>{}", "<Folder>".repeat(200_000));
    assert_error("a.kml", &deep, &["cut off"]);
}

fn real_trajectory(name: &str) -> Option<PathBuf> {
    hedgehop_testing::realdata().map(|root| root.join("trajectories").join(name))
}

#[test]
fn real_flights_are_read_whole() {
    for (name, rows, distinct) in [
        ("C152_N53398_KCPS_to_KSLO_2017-10-29_trim.csv", 2841, 2841 - 967),
        ("DA20-C1_N107TX_KSUS_to_KFYG_2018-10-15_trim.csv", 7407, 7407 - 3040),
    ] {
        let Some(path) = real_trajectory(name) else { continue };
        let track = read_track(&path, &ReadOptions::default()).unwrap();
        assert_eq!(track.fixes.len(), distinct, "{rows} rows, some with the time of their predecessor");
        assert!(track.fixes.iter().all(|fix| fix.yaw.is_some() && fix.pitch.is_none()));
        assert!(track.notes.iter().any(|note| note.contains("repeat the time")));
        assert!(track.notes.iter().any(|note| note.contains("speed_mps")));
        assert!(track.notes.iter().any(|note| note.contains("mean sea level")));
    }
}

#[test]
fn a_real_recording_whose_clock_runs_back_is_refused_with_its_line() {
    let Some(path) = real_trajectory("tuolumne.gpx") else { return };
    let message = read_track(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("out of order: this fix is 197.000 s before"), "{message}");
    // The same recording up to there flies.
    let text = std::fs::read_to_string(&path).unwrap();
    let line: usize = message.split("line ").nth(1).unwrap().split(':').next().unwrap().parse().unwrap();
    let before: String = text.lines().take(line - 1).flat_map(|line| [line, "\n"]).collect();
    let track = parse("tuolumne.gpx", &format!("{before}</trkseg></trk></gpx>")).unwrap();
    assert_eq!(track.fixes.len(), 990);
}
