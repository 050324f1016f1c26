//! One object of a scene file.

use std::ops::Range;
use std::path::PathBuf;

use toml::Spanned;

use super::Object;
use super::appearance::appearance;
use super::model::Models;
use super::part::{Whole, parts, refuse_keys};
use super::place::{PLACE_KEYS, Place};
use super::track_file::TrackFile;
use crate::flight::{Altitude, AltitudeMode, Track};
use crate::scene::object_table::{ObjectTable, check_name};
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Grey of objects that are given no colour.
const GREY: [u8; 3] = [150; 3];

pub(super) fn object(
    reading: &Reading<'_>,
    table: Spanned<ObjectTable>,
    models: &mut Models,
    hasher: &mut blake3::Hasher,
) -> Result<Object> {
    let span = table.span();
    let table = table.into_inner();
    let line = reading.line(&span);
    check_name(reading, "an object", &table.name, &span)?;
    refuse_keys(reading, &table, Whole::Object)?;
    let whose = format!("object `{}`", table.name);
    let appearance = appearance(reading, &table, &whose, &span, models, hasher)?;
    let albedo = table.albedo(reading)?.unwrap_or_else(|| linear_from_srgb8(GREY));

    let start = match &table.start_s {
        Some(_) if table.track.is_none() => {
            return Err(
                reading.wrong(span, "start_s says when a track begins; give one, or leave start_s out")
            );
        }
        Some(start) => reading.number("start_s", start, |_| true, "must be finite")?,
        None => 0.0,
    };

    if table.track.is_none() && (table.track_number.is_some() || table.sort.is_some()) {
        let what = "track_number and sort are about a track; give one, or leave them out";
        return Err(reading.wrong(span, what));
    }

    let mut track = match &table.track {
        Some(track) => moving(reading, &table, track, hasher)?,
        None => standing(reading, &table, span)?,
    };
    if table.leans() {
        lean(reading, &table, &mut track)?;
    }

    let to = table.to.as_ref().map(|to| end(reading, &table, to)).transpose()?;
    let beyond = match &table.beyond {
        Some(beyond) if table.track.is_none() => {
            let what = "beyond says what an object does beyond its track; give one, or leave beyond out";
            return Err(reading.wrong(beyond.span(), what));
        }
        beyond => beyond.as_ref().map(|beyond| *beyond.get_ref()).unwrap_or_default(),
    };

    let mut object = Object {
        line,
        form: appearance.form,
        files: appearance.files,
        notes: appearance.notes,
        albedo,
        priority: table.priority(reading)?.unwrap_or(0),
        track,
        to,
        start,
        beyond,
        banks: table.bank.as_ref().is_some_and(|bank| *bank.get_ref()),
        leans: table.leans(),
        from_aboard: table.from_aboard.as_ref().is_none_or(|seen| *seen.get_ref()),
        parts: Vec::new(),
        name: table.name.clone(),
    };

    parts(reading, &table, appearance.nodes, &mut object, models, hasher)?;
    Ok(object)
}

/// Makes a track one that the ground below says the height and the lean of.
fn lean(reading: &Reading<'_>, table: &ObjectTable, track: &mut Track) -> Result<()> {
    let wrong = |span: Range<usize>, what: &str| Err(reading.wrong(span, what));
    if let Some(angle) = [&table.pitch_deg, &table.roll_deg].into_iter().flatten().next() {
        return wrong(angle.span(), "with slope the ground says pitch and roll; leave them out, or slope");
    }
    if let Some(bank) = table.bank.as_ref().filter(|bank| *bank.get_ref()) {
        return wrong(
            bank.span(),
            "with slope the ground says how an object leans; leave bank out, or slope",
        );
    }
    if let Some(to) = &table.to {
        return wrong(to.span(), "a line that goes to a place leans as its ends say; leave slope out");
    }

    let is_above_ground = |mode: AltitudeMode| mode == AltitudeMode::Agl;
    if let Some(altitude) =
        table.altitude.as_ref().filter(|above| !is_above_ground((*above.get_ref()).into()))
    {
        return wrong(altitude.span(), "with slope altitudes are above the ground; give altitude = \"agl\"");
    }

    let mut is_lowered = false;
    for fix in track.fixes.iter_mut().filter(|fix| !is_above_ground(fix.altitude.mode)) {
        fix.altitude = Altitude { metres: 0.0, mode: AltitudeMode::Agl };
        is_lowered = true;
    }

    if is_lowered {
        track
            .notes
            .push("With slope it stands on the ground; the altitudes of its track are left out.".into());
    }

    Ok(())
}

/// The track of something that stands.
fn standing(reading: &Reading<'_>, table: &ObjectTable, object: Range<usize>) -> Result<Track> {
    if table.at.is_none() && table.at_lonlat.is_none() {
        let what = format!("object `{}` needs at, at_lonlat or track", table.name);
        return Err(reading.wrong(object, what));
    }
    if let Some(bank) = &table.bank {
        return Err(
            reading.wrong(bank.span(), "bank is for objects with a track; a standing one has roll_deg")
        );
    }
    place(table, &format!("object `{}`", table.name), object).track(reading)
}

/// Returns the place that its table gives.
fn place<'t>(table: &'t ObjectTable, whose: &'t str, span: Range<usize>) -> Place<'t> {
    Place {
        whose,
        keys: PLACE_KEYS,
        at: table.at.as_ref(),
        at_lonlat: table.at_lonlat.as_ref(),
        altitude: table.altitude.as_ref().map(|above| *above.get_ref()),
        yaw: table.yaw_deg.as_ref(),
        pitch: table.pitch_deg.as_ref(),
        roll: table.roll_deg.as_ref(),
        span,
    }
}

/// Reads the end of a line.
fn end(reading: &Reading<'_>, table: &ObjectTable, to: &Spanned<Vec<f64>>) -> Result<Track> {
    if table.track.is_some() {
        let what = "to is where a line ends that stands; one with a track has length_m";
        return Err(reading.wrong(to.span(), what));
    }
    let angles = [&table.yaw_deg, &table.pitch_deg, &table.roll_deg];
    if let Some(angle) = angles.into_iter().flatten().next() {
        return Err(reading.wrong(angle.span(), "a line goes to its other end; leave angles out, or to"));
    }
    let whose = format!("object `{}`", table.name);
    let begin = place(table, &whose, to.span());
    let is_xy = table.at_lonlat.is_none();
    let end = Place {
        keys: ["to"; 2],
        at: Some(to).filter(|_| is_xy),
        at_lonlat: Some(to).filter(|_| !is_xy),
        ..begin
    };
    end.track(reading)
}

/// The track of something that moves.
fn moving(
    reading: &Reading<'_>,
    table: &ObjectTable,
    track: &Spanned<PathBuf>,
    hasher: &mut blake3::Hasher,
) -> Result<Track> {
    let places = [table.at.as_ref().map(Spanned::span), table.at_lonlat.as_ref().map(Spanned::span)];
    let angles = [&table.yaw_deg, &table.pitch_deg, &table.roll_deg];
    let angles = angles.into_iter().map(|angle| angle.as_ref().map(Spanned::span));
    if let Some(span) = places.into_iter().chain(angles).flatten().next() {
        return Err(reading.wrong(span, "an object with a track is where, and turned as, its track says"));
    }

    let file = TrackFile {
        whose: &format!("the track of object `{}`", table.name),
        track,
        number: table.track_number.as_ref(),
        sort: table.sort.as_ref(),
        altitude: table.altitude.as_ref(),
    };
    file.read(reading, hasher)
}
