//! Tables of numbers by time, under names that are agreed on.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::delimiter;
use crate::flight::Samples;
use crate::flight::raw::CLOCK;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};

/// Names of the column of seconds.
const TIMES: [&str; 3] = ["time_s", "t_s", "time"];

/// Latest time of a table, seconds.
const LATEST: f64 = 1.0e9;

/// A column that a table may have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted {
    /// Name in the header.
    pub name: &'static str,
    /// Whether values are degrees, which go the shorter way round from one to the next.
    pub is_angle: bool,
    /// Greatest number either way.
    pub most: f64,
}

/// Reads a table that has a column `time_s` and one or more of those that are `wanted`, and gives these in that order; the bytes are those of the file
/// at `path`. An empty cell lies on the line between its neighbours.
///
/// # Errors
/// [`Error::Invalid`] with the line: a column that is not wanted, or is there twice, no time, times that do not increase, what is no number or too large.
pub(crate) fn read_columns(path: &Path, bytes: &[u8], wanted: &[Wanted]) -> Result<Vec<Option<Samples>>> {
    let wrong = |line: u64, what: String| Error::invalid(path, format!("line {line}: {what}"));
    let text = String::from_utf8_lossy(unmarked(path, bytes)?);
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(Trim::All)
        .delimiter(delimiter(&text))
        .from_reader(text.as_bytes());

    let line_of = |record: &StringRecord| record.position().map_or(1, csv::Position::line);
    let damaged = |error: csv::Error| {
        wrong(error.position().map_or(1, csv::Position::line), format!("the table is damaged ({error})"))
    };
    let mut records = reader.records();
    let header = records.next().transpose().map_err(damaged)?.unwrap_or_default();
    let columns = SampleColumns::new(&header, wanted).map_err(|what| wrong(line_of(&header), what))?;
    let mut times: Vec<f64> = Vec::new();
    let mut cells: Vec<Vec<(f64, Option<f64>)>> = vec![Vec::new(); wanted.len()];

    for record in records {
        let record = record.map_err(damaged)?;
        let line = line_of(&record);
        let number = |at: usize, name: &str, most: f64| -> Result<Option<f64>> {
            let cell = record.get(at).unwrap_or_default();
            let holds = |number: &f64| number.abs() <= most;
            match cell.parse::<f64>() {
                _ if cell.is_empty() => Ok(None),
                Ok(number) if holds(&number) => Ok(Some(number)),
                _ => Err(wrong(
                    line,
                    format!("column {name}: {cell:?} is no number of {most} at most, with a decimal point"),
                )),
            }
        };

        if record.iter().skip(header.len()).any(|cell| !cell.is_empty()) {
            let what = format!("{} cells, but the header names {}", record.len(), header.len());
            return Err(wrong(line, format!("{what}; numbers need a decimal point, not a comma")));
        }

        let time = number(columns.time, "time_s", LATEST)?;
        let time = time.ok_or_else(|| wrong(line, "column time_s is empty".to_owned()))?;
        if times.last().is_some_and(|last| time - last < CLOCK) {
            let what =
                format!("the time {time} s is not after that of the line before; sort the table by time");
            return Err(wrong(line, what));
        }

        times.push(time);
        for ((own, wanted), cells) in columns.wanted.iter().zip(wanted).zip(&mut cells) {
            if let Some(at) = own {
                cells.push((time, number(*at, wanted.name, wanted.most)?));
            }
        }
    }

    if times.is_empty() {
        return Err(wrong(line_of(&header), "the table has no row of numbers below its header".to_owned()));
    }

    let samples = |(cells, wanted): (Vec<(f64, Option<f64>)>, &Wanted)| {
        let cells = cells.into_iter();
        if wanted.is_angle { Samples::angles(cells) } else { Samples::new(cells) }
    };

    Ok(cells.into_iter().zip(wanted).map(samples).collect())
}

/// Positions of the columns in a row.
struct SampleColumns {
    time: usize,
    /// Position of each column that is wanted, if there.
    wanted: Vec<Option<usize>>,
}

impl SampleColumns {
    fn new(header: &StringRecord, wanted: &[Wanted]) -> std::result::Result<Self, String> {
        let names: Vec<&str> = wanted.iter().map(|wanted| wanted.name).collect();
        let known = format!("time_s and one or more of {}", names.join(", "));
        let mut columns = Self { time: usize::MAX, wanted: vec![None; wanted.len()] };
        for (at, name) in header.iter().enumerate() {
            let twice = if TIMES.contains(&name) {
                std::mem::replace(&mut columns.time, at) != usize::MAX
            } else if let Some(index) = names.iter().position(|known| *known == name) {
                columns.wanted[index].replace(at).is_some()
            } else {
                return Err(format!("there is no column {name:?} in such a table; it has {known}"));
            };
            if twice {
                return Err(format!("the column {name:?} is there twice"));
            }
        }

        if columns.time == usize::MAX || columns.wanted.iter().all(Option::is_none) {
            return Err(format!("the header must name {known}"));
        }

        Ok(columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: [Wanted; 2] = [
        Wanted { name: "yaw_deg", is_angle: true, most: 3600.0 },
        Wanted { name: "up_m", is_angle: false, most: 10.0 },
    ];

    fn read(text: &str) -> Result<Vec<Option<Samples>>> {
        read_columns(Path::new("angles.csv"), text.as_bytes(), &WANTED)
    }

    #[test]
    fn angles_go_the_shorter_way_and_hold_beyond() {
        let both = read("up_m;time_s;yaw_deg\n0;1;350\n;2;\n# then\n4;3;30\n").unwrap();
        let [yaw, up] = [0, 1].map(|index| both[index].clone().unwrap());
        for (time, angle, height) in
            [(-5.0, 350.0, 0.0), (1.0, 350.0, 0.0), (2.0, 370.0, 2.0), (9.0, 390.0, 4.0)]
        {
            assert!((yaw.at(time) - angle).abs() < 1e-9 && (up.at(time) - height).abs() < 1e-9, "{time}");
        }
        assert!(read("time_s,yaw_deg\n0,1\n").unwrap()[1].is_none());
    }

    #[test]
    fn mistakes_name_line_and_column() {
        for (text, line, word) in [
            ("", 1, "time_s"),
            ("time_s,yaw_deg\n", 1, "no row"),
            ("time_s\n1\n", 1, "up_m"),
            ("yaw_deg\n1\n", 1, "time_s"),
            ("time_s,yaw\n0,1\n", 1, "\"yaw\""),
            ("time_s,yaw_deg,yaw_deg\n0,1,1\n", 1, "twice"),
            ("time_s,t_s,yaw_deg\n0,1,1\n", 1, "twice"),
            ("time_s,yaw_deg\n0,1\n0,1\n", 3, "after"),
            ("time_s,yaw_deg\n0,1\n1,x\n", 3, "yaw_deg"),
            ("time_s,yaw_deg\n0,1\n1,nan\n", 3, "yaw_deg"),
            ("time_s,yaw_deg\n0,1\n,1\n", 3, "time_s"),
            ("time_s,yaw_deg\n0,1\n1e12,1\n", 3, "time_s"),
            ("time_s;yaw_deg;up_m\n0;1;11\n", 2, "up_m"),
            ("time_s,yaw_deg\n0,1,5\n", 2, "decimal point"),
        ] {
            let message = read(text).unwrap_err().to_string();
            let place = format!("angles.csv: line {line}: ");
            assert!(message.contains(&place) && message.contains(word), "{text:?}: {message}");
            assert!(!message.contains('\n'), "{message:?}");
        }
    }
}
