//! IGC flight recorder files: B records.
//!
//! FAI, *Technical Specification for IGC-approved Flight Recorders*, appendix A. Times are UTC of day; a step back of
//! more than half a day is midnight. Fractions of seconds and of minutes (TDS, LAD, LOD) and the accuracy of fixes
//! (FXA) follow the I record.
//!
//! Altitude is the GNSS one of the fixes that are valid (`A`); other fixes (`V`) are dropped, since pressure altitude
//! differs from it by tens of metres and a mixture would jump. A file without any valid GNSS altitude is flown by
//! pressure altitude. The specification has GNSS altitude above the ellipsoid; recorders that are not approved (their
//! manufacturer's code begins with X, or there is none) mostly write it above mean sea level, as their receiver gives
//! it. An `HFALG` header decides where there is one.

use igc::records::{BRecord, FixValid, IRecord};
use time::{Date, Month};

use super::raw::{DAY, Epoch, PathSource, RawFix, Reading};
use super::track::{Altitude, AltitudeMode, Horizontal};
use hedgehop_base::error::{Error, Result};

/// Lines within which the first fix or date must stand.
const PREAMBLE: usize = 400;

/// Columns (byte ranges of a B record) of the digits that refine it.
#[derive(Default)]
struct Refinements {
    accuracy: Option<std::ops::Range<usize>>,
    seconds: Option<std::ops::Range<usize>>,
    latitude: Option<std::ops::Range<usize>>,
    longitude: Option<std::ops::Range<usize>>,
}

/// A fix before it is known which altitude is flown.
struct Logged {
    line: u64,
    time: f64,
    horizontal: Horizontal,
    gnss: Option<f64>,
    pressure: f64,
    /// Expected error, metres.
    accuracy: Option<f64>,
}

/// A line looks like an IGC fix: `B`, six digits of time, seven of latitude, `N` or `S`.
pub(super) fn looks_like_igc(text: &str) -> bool {
    text.lines().take(PREAMBLE).any(|line| {
        let bytes = line.as_bytes();
        bytes.len() >= 35 && bytes[0] == b'B' && are_digits(&bytes[1..14]) && matches!(bytes[14], b'N' | b'S')
    })
}

/// Unrolled where its length is known, the loop takes seconds to compile.
#[inline(never)]
fn are_digits(bytes: &[u8]) -> bool {
    bytes.iter().all(u8::is_ascii_digit)
}

pub(super) fn read(source: &PathSource<'_>, text: &str) -> Result<Reading> {
    let mut notes = Vec::new();
    let logged = log(source, text, &mut notes)?;
    if logged.is_empty() {
        return Err(Error::invalid(source.path, "there is no fix (B record) in this IGC file"));
    }

    let by_gnss = logged.iter().any(|fix| fix.gnss.is_some_and(|metres| metres != 0.0));
    let mode = if by_gnss { gnss_mode(source, text, &mut notes) } else { pressure_mode(source, &mut notes) };
    let total = logged.len();

    let fixes: Vec<RawFix> = logged
        .into_iter()
        .filter_map(|fix| {
            let metres = if by_gnss { fix.gnss? } else { fix.pressure };
            let mut raw = RawFix::positioned(fix.line, fix.time, fix.horizontal, Altitude { metres, mode });
            raw.fix.accuracy = fix.accuracy;
            Some(raw)
        })
        .collect();

    if fixes.len() < total {
        notes.push(format!("{} fixes without valid GNSS altitude were dropped.", total - fixes.len()));
    }

    Ok(Reading::of_one("IGC", fixes, Some(epoch(text)), notes))
}

/// Returns the midnight that times of fixes count from: that of the day in the last date header before the first fix (`HFDTE210626`, or
/// `HFDTEDATE:210626,01`).
fn epoch(text: &str) -> Epoch {
    let headers = text.lines().take_while(|line| !line.starts_with('B'));
    let date = headers.filter(|line| line.starts_with('H') && line.get(2..5) == Some("DTE")).last();
    let midnight = date.and_then(|line| {
        let digits: String = line.chars().filter(char::is_ascii_digit).take(6).collect();
        let pair = |at: usize| digits.get(at..at + 2)?.parse::<u8>().ok();
        // GNSS recorders are younger than 1980.
        let year = i32::from(pair(4)?);
        let year = if year < 80 { 2000 + year } else { 1900 + year };
        let date = Date::from_calendar_date(year, Month::try_from(pair(2)?).ok()?, pair(0)?).ok()?;
        Some(date.midnight().assume_utc().unix_timestamp() as f64)
    });
    midnight.map_or(Epoch::SomeDay, Epoch::Day)
}

fn log(source: &PathSource<'_>, text: &str, notes: &mut Vec<String>) -> Result<Vec<Logged>> {
    let mut refinements = Refinements::default();
    let mut logged: Vec<Logged> = Vec::new();
    let mut days = 0.0;
    let mut lines =
        (1_u64..).zip(text.lines().map(str::trim_end)).filter(|(_, line)| !line.is_empty()).peekable();

    while let Some((number, line)) = lines.next() {
        if line.starts_with('I') {
            refinements = refinements_of(line);
            continue;
        }
        if !line.starts_with('B') {
            continue;
        }

        let Ok(record) = BRecord::parse(line) else {
            if lines.peek().is_none() && !logged.is_empty() {
                notes.push(format!("Line {number}, the last, is cut off and was dropped."));
                break;
            }
            return Err(source
                .at_line(number, "this B record is damaged; delete the line or download the file again"));
        };

        let fraction = fraction(line, refinements.seconds.as_ref()).unwrap_or(0.0);
        let of_day = f64::from(record.timestamp.seconds_since_midnight()) + fraction;
        if let Some(previous) = logged.last()
            && of_day + days * DAY < previous.time - DAY / 2.0
        {
            days += 1.0;
        }

        logged.push(Logged {
            line: number,
            time: of_day + days * DAY,
            horizontal: position(line, &record, &refinements),
            gnss: (record.fix_valid == FixValid::Valid).then(|| f64::from(record.gps_alt)),
            pressure: f64::from(record.pressure_alt),
            accuracy: whole_number(line, refinements.accuracy.as_ref()).filter(|metres| *metres > 0.0),
        });
    }

    Ok(logged)
}

/// Degrees, with the extra digits of the minutes that the I record declares.
fn position(line: &str, record: &BRecord<'_>, refinements: &Refinements) -> Horizontal {
    let refine = |degrees: f64, columns: Option<&std::ops::Range<usize>>| {
        let extra = fraction(line, columns).unwrap_or(0.0) / 60_000.0;
        if degrees.is_sign_negative() { degrees - extra } else { degrees + extra }
    };
    let latitude = refine(f64::from(record.pos.lat.0), refinements.latitude.as_ref());
    let longitude = refine(f64::from(record.pos.lon.0), refinements.longitude.as_ref());
    Horizontal::LonLat(longitude, latitude)
}

/// A broken I record only costs the extra digits.
fn refinements_of(line: &str) -> Refinements {
    let mut refinements = Refinements::default();
    let Ok(record) = IRecord::parse(line) else { return refinements };
    for extension in &record.0.extensions {
        // Columns count from 1; the base of a B record has 35.
        if extension.start_byte <= 35 || extension.end_byte < extension.start_byte {
            continue;
        }
        let columns = Some(usize::from(extension.start_byte) - 1..usize::from(extension.end_byte));
        match extension.mnemonic {
            "FXA" => refinements.accuracy = columns,
            "TDS" => refinements.seconds = columns,
            "LAD" => refinements.latitude = columns,
            "LOD" => refinements.longitude = columns,
            _ => {}
        }
    }
    refinements
}

/// Digits in `columns` as a fraction: `25` is 0.25.
fn fraction(line: &str, columns: Option<&std::ops::Range<usize>>) -> Option<f64> {
    format!("0.{}", digits(line, columns)?).parse().ok()
}

/// Digits in `columns` as a whole number.
fn whole_number(line: &str, columns: Option<&std::ops::Range<usize>>) -> Option<f64> {
    digits(line, columns)?.parse().ok()
}

fn digits<'a>(line: &'a str, columns: Option<&std::ops::Range<usize>>) -> Option<&'a str> {
    let digits = line.get(columns?.clone())?;
    (!digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit())).then_some(digits)
}

fn gnss_mode(source: &PathSource<'_>, text: &str, notes: &mut Vec<String>) -> AltitudeMode {
    let header = |line: &str| {
        let line = line.to_ascii_uppercase();
        let kind = line.strip_prefix("HFALG")?.rsplit(':').next()?.trim().to_owned();
        kind.starts_with("ELL").then_some(AltitudeMode::Ellipsoid).or(kind
            .starts_with("GEO")
            .then_some(AltitudeMode::Msl)
            .or(kind.starts_with("MSL").then_some(AltitudeMode::Msl)))
    };

    if let Some(mode) = text.lines().take(PREAMBLE).find_map(header) {
        notes.push(format!("GNSS altitudes are flown, {} (HFALG header).", from_where(mode)));
        return mode;
    }
    if let Some(mode) = source.options.altitude_mode {
        notes.push(format!("GNSS altitudes are flown, {}.", from_where(mode)));
        return mode;
    }

    let approved = text.lines().next().is_some_and(|line| {
        let code = line.as_bytes();
        code.len() >= 4 && code[0] == b'A' && code[1].is_ascii_alphanumeric() && code[1] != b'X'
    });
    let (mode, why) = if approved {
        (AltitudeMode::Ellipsoid, "as IGC has it for approved recorders")
    } else {
        (AltitudeMode::Msl, "as recorders without IGC approval mostly write them")
    };
    notes.push(format!(
        "GNSS altitudes are flown, {}, {why}; the file does not say (--alt-mode says otherwise).",
        from_where(mode)
    ));

    mode
}

fn pressure_mode(source: &PathSource<'_>, notes: &mut Vec<String>) -> AltitudeMode {
    notes.push(
        "There is no valid GNSS altitude; pressure altitude is flown, which is off by the weather of the day.".into(),
    );
    source.options.altitude_mode.unwrap_or(AltitudeMode::Msl)
}

fn from_where(mode: AltitudeMode) -> &'static str {
    match mode {
        AltitudeMode::Msl => "above mean sea level",
        AltitudeMode::Agl => "above ground",
        AltitudeMode::Ellipsoid => "above the WGS 84 ellipsoid",
    }
}
