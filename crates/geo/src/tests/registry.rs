//! Codes and texts against PROJ, by tables that `tools/crs/truth.py` makes.
//!
//! `HEDGEHOP_CRS_TRUTH` names a larger table than that in the tree (all codes at several places, and their texts).

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::PathBuf;

use crate::{Crs, Transform};

/// Farthest that a place may lie from PROJ's, metres.
const FARTHEST: f64 = 1.0;

/// Codes that may be refused, as a share of those of EPSG.
const MOST_REFUSED: f64 = 0.03;

/// Metres of a degree of latitude.
const DEGREE: f64 = 111_195.0;

#[derive(Default, Debug)]
struct Tally {
    right: usize,
    wrong: Vec<String>,
    /// Sentences, by what was refused.
    refused: BTreeMap<String, String>,
    tried: BTreeSet<String>,
}

impl Tally {
    fn add(&mut self, name: &str, outcome: Result<f64, String>) {
        self.tried.insert(name.to_owned());
        match outcome {
            Ok(distance) if distance <= FARTHEST => self.right += 1,
            Ok(distance) => self.wrong.push(format!("{distance:.1} m: {name}")),
            Err(reason) => drop(self.refused.insert(name.to_owned(), reason)),
        }
    }

    fn summary(&self, kind: &str) -> String {
        format!(
            "{kind}: {} tried, {} places right, {} wrong, {} refused",
            self.tried.len(),
            self.right,
            self.wrong.len(),
            self.refused.len()
        )
    }
}

/// Distance between a place and where it should be, metres: forth, and back where both ways take the same shift.
fn distance(crs: &Crs, case: &[f64]) -> Result<f64, String> {
    let &[x, y, longitude, latitude] = case else { return Err("four numbers".to_owned()) };
    let there = Transform::new(crs, &Crs::wgs84()).map_err(|error| error.to_string())?;
    let back = Transform::new(&Crs::wgs84(), crs).map_err(|error| error.to_string())?;
    let apart = |(u, v): (f64, f64), (longitude, latitude): (f64, f64)| {
        let east = (u - longitude + 540.0).rem_euclid(360.0) - 180.0;
        DEGREE * (east * latitude.to_radians().cos()).hypot(v - latitude)
    };
    let forth = there.apply(x, y).map_or(f64::INFINITY, |place| apart(place, (longitude, latitude)));
    let again = back.apply(longitude, latitude).map_or(f64::INFINITY, |(u, v)| {
        if crs.is_geographic() {
            apart((u, v), (x, y))
        } else {
            (u - x).hypot(v - y) * crs.metres_per_unit().unwrap_or(1.0)
        }
    });
    // PROJ itself may take another shift on the way back.
    Ok(if crs.has_one_shift() { forth.max(again) } else { forth })
}

#[test]
fn codes_and_texts_place_as_proj_does() {
    let larger = std::env::var_os("HEDGEHOP_CRS_TRUTH").map(PathBuf::from);
    let is_larger = larger.is_some();
    let path =
        larger.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/truth.tsv"));
    let table = std::fs::read_to_string(&path).expect("the table");
    let (mut epsg, mut esri, mut texts, mut heights) =
        (Tally::default(), Tally::default(), Tally::default(), Tally::default());

    for line in table.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split('\t').collect();
        let numbers: Vec<f64> = fields[2..].iter().filter_map(|field| field.parse().ok()).collect();
        match fields[0] {
            "code" => {
                let code: u32 = fields[1].parse().expect("a code");
                let outcome = Crs::from_epsg(code).map_err(|error| error.to_string());
                let is_epsg = outcome.as_ref().map_or(code < 37_000, |crs| crs.epsg().is_some());
                let tally = if is_epsg { &mut epsg } else { &mut esri };
                tally.add(fields[1], outcome.and_then(|crs| distance(&crs, &numbers)));
            }
            "text" => {
                let outcome = Crs::from_wkt(fields[1]).map_err(|error| error.to_string());
                texts.add(fields[1], outcome.and_then(|crs| distance(&crs, &numbers)));
            }
            "height" => {
                let text = match fields[1].parse::<u32>() {
                    Ok(code) => format!("EPSG:32632+{code}"),
                    Err(_) => fields[1].to_owned(),
                };
                let outcome = Crs::with_vertical_from_user(&text).map_err(|error| error.to_string());
                let metres = outcome.map(|(_, vertical)| vertical.and_then(|v| v.metres_per_unit));
                let off =
                    |metres: Option<f64>| (metres.unwrap_or(f64::INFINITY) / numbers[0] - 1.0).abs() * 1e8;
                heights.add(fields[1], metres.map(off));
            }
            other => panic!("{other}"),
        }
    }

    let mut report = String::new();
    for (kind, tally) in [("EPSG", &epsg), ("ESRI", &esri), ("texts", &texts), ("heights", &heights)] {
        report += &format!("{}\n", tally.summary(kind));
        for wrong in tally.wrong.iter().take(60) {
            report += &format!("  {wrong}\n");
        }
        for (name, reason) in tally.refused.iter().filter(|_| is_larger) {
            report += &format!("  refused {}: {reason}\n", name.chars().take(300).collect::<String>());
        }
    }

    std::io::stderr().write_all(report.as_bytes()).expect("a report");
    for tally in [&epsg, &esri, &texts, &heights] {
        assert!(tally.wrong.is_empty(), "{} wrong, {:?}", tally.wrong.len(), tally.wrong.first());
    }

    let share = epsg.refused.len() as f64 / epsg.tried.len() as f64;
    assert!(share <= MOST_REFUSED, "{share}");
}
