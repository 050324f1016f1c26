//! Path tables: CSV with declared columns, and what JSBSim writes.
//!
//! `columns` understands the header; here the rows are read. Cells are separated by comma, semicolon or tab, whichever
//! the header has most of; numbers have a decimal point; lines that begin with `#` are comments.

mod camera;
mod columns;
mod samples;

use csv::{ReaderBuilder, StringRecord, Trim};

use self::camera::CameraColumns;
use self::columns::{CsvColumn, CsvColumns, Quantity};
pub(crate) use self::samples::{Wanted, read_columns};
use super::raw::{Epoch, PathSource, RawFix, Reading};
use super::timestamp::unix_seconds;
use super::track::{Altitude, AltitudeMode, Fix, Horizontal};
use hedgehop_base::error::{Error, Result};

/// Numbers above this in a column of seconds are milliseconds or finer since 1970 (seconds reach it in the year 5138).
const SECONDS_LIMIT: f64 = 1e11;

pub(super) fn read(source: &PathSource<'_>, text: &str) -> Result<Reading> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(Trim::All)
        .delimiter(delimiter(text))
        .from_reader(text.as_bytes());

    let mut records = reader.records();
    let header = match records.next() {
        Some(record) => record.map_err(|error| damaged(source, &error))?,
        None => {
            return Err(Error::invalid(
                source.path,
                "the file holds only comments; give a header and positions",
            ));
        }
    };

    let line_of = |record: &StringRecord| record.position().map_or(0, csv::Position::line);
    let columns = CsvColumns::understand(source, line_of(&header), &header)?;
    let is_unix = columns.time.name.to_ascii_lowercase().starts_with("unix");
    let epoch = is_unix.then_some(Epoch::UNIX);
    let mut table = Table { source, columns: &columns, named: header.len(), epoch };
    let cameras = CameraColumns::of(&header);
    let (mut fixes, mut rows) = (Vec::new(), Vec::new());
    for record in records {
        let record = record.map_err(|error| damaged(source, &error))?;
        let line = line_of(&record);
        fixes.push(table.fix(&record, line)?);
        if !cameras.is_empty() {
            rows.push(cameras.row(source, &record, line)?);
        }
    }

    let mut notes = columns.notes.clone();
    drop_unknown_headings(&mut fixes, &mut notes);
    Ok(Reading { cameras: rows, ..Reading::of_one(columns.format, fixes, table.epoch, notes) })
}

fn damaged(source: &PathSource<'_>, error: &csv::Error) -> Error {
    let line = error.position().map_or(1, csv::Position::line);
    source.at_line(line, format!("the table is damaged ({error})"))
}

/// The separator that the first line with content has most of.
fn delimiter(text: &str) -> u8 {
    let header =
        text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let count = |separator: u8| header.bytes().filter(|&byte| byte == separator).count();
    // Of equals the last wins: comma.
    [b'\t', b';', b','].into_iter().max_by_key(|&separator| count(separator)).unwrap_or(b',')
}

struct Table<'a> {
    source: &'a PathSource<'a>,
    columns: &'a CsvColumns,
    named: usize,
    /// Moment that times count from, if they are dates, or seconds since 1970.
    epoch: Option<Epoch>,
}

impl Table<'_> {
    fn fix(&mut self, record: &StringRecord, line: u64) -> Result<RawFix> {
        if record.iter().skip(self.named).any(|cell| !cell.is_empty()) {
            return Err(self.source.at_line(
                line,
                format!(
                    "{} cells, but the header names {}; numbers need a decimal point, not a comma",
                    record.len(),
                    self.named
                ),
            ));
        }

        let columns = self.columns;
        let horizontal = match &columns.horizontal {
            columns::Position::LonLat(longitude, latitude) => Horizontal::LonLat(
                self.number(record, line, longitude)?,
                self.number(record, line, latitude)?,
            ),
            columns::Position::Xy(x, y) => {
                Horizontal::Xy(self.number(record, line, x)?, self.number(record, line, y)?)
            }
        };

        let metres = self.number(record, line, &columns.altitude)?;
        let Quantity::Altitude(stated) = columns.altitude.quantity else {
            return Err(self.source.at_line(line, "the altitude column has no mode"));
        };

        let mode = stated.or(self.source.options.altitude_mode).unwrap_or(AltitudeMode::Msl);
        let time = self.time(record, line)?;
        let raw = RawFix::positioned(line, time, horizontal, Altitude { metres, mode });

        let optional = |column: &Option<CsvColumn>| match column {
            Some(column) if !record.get(column.index).unwrap_or_default().is_empty() => {
                self.number(record, line, column).map(Some)
            }
            _ => Ok(None),
        };

        let fix = Fix {
            yaw: optional(&columns.yaw)?,
            pitch: optional(&columns.pitch)?,
            roll: optional(&columns.roll)?,
            hfov: optional(&columns.hfov)?,
            ..raw.fix
        };

        Ok(RawFix { line, fix })
    }

    fn time(&mut self, record: &StringRecord, line: u64) -> Result<f64> {
        let column = &self.columns.time;
        let cell = self.cell(record, line, column)?;
        if !column.plain || cell.parse::<f64>().is_ok() {
            let seconds = self.number(record, line, column)?;
            if column.plain && seconds.abs() > SECONDS_LIMIT {
                return Err(self.source.at_line(
                    line,
                    format!(
                        "column {}: {cell} are no seconds; name the column time_ms, time_us or time_ns",
                        column.name
                    ),
                ));
            }
            return Ok(seconds);
        }

        self.epoch = Some(Epoch::UNIX);
        unix_seconds(cell).ok_or_else(|| {
            self.source.at_line(
                line,
                format!(
                    "column {}: {cell:?} is neither a number of seconds nor an ISO 8601 date and time such as \
                     2026-05-01T12:00:00Z",
                    column.name
                ),
            )
        })
    }

    fn cell<'r>(&self, record: &'r StringRecord, line: u64, column: &CsvColumn) -> Result<&'r str> {
        match record.get(column.index) {
            Some("") => {
                Err(self.source.at_line(line, format!("column {} is empty; delete the row", column.name)))
            }
            Some(cell) => Ok(cell),
            None => Err(self.source.at_line(
                line,
                format!("the row ends before column {} (cell {})", column.name, column.index + 1),
            )),
        }
    }

    fn number(&self, record: &StringRecord, line: u64, column: &CsvColumn) -> Result<f64> {
        let cell = self.cell(record, line, column)?;
        let fail =
            |what: &str| Err(self.source.at_line(line, format!("column {}: {cell:?} {what}", column.name)));
        match cell.parse::<f64>() {
            Ok(value) if (value * column.scale).is_finite() => Ok(value * column.scale),
            Ok(_) => fail("is not finite"),
            Err(_) if cell.contains(',') => fail("is no number; write a decimal point"),
            Err(_) => fail("is no number"),
        }
    }
}

/// Loggers write −1 for a heading that they do not know, in a column that else runs from 0 to 360.
fn drop_unknown_headings(fixes: &mut [RawFix], notes: &mut Vec<String>) {
    const UNKNOWN: f64 = -1.0;
    let negative = |raw: &RawFix| raw.fix.yaw.is_some_and(|yaw| yaw < 0.0);
    if fixes.iter().any(|raw| negative(raw) && raw.fix.yaw != Some(UNKNOWN)) {
        return;
    }
    let mut dropped = 0_usize;
    for raw in fixes.iter_mut().filter(|raw| negative(raw)) {
        raw.fix.yaw = None;
        dropped += 1;
    }
    if dropped > 0 {
        notes.push(format!("{dropped} headings of −1 are taken as unknown."));
    }
}

#[cfg(test)]
mod tests;
