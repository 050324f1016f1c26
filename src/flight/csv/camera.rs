//! Columns of cameras.

use csv::StringRecord;

use super::super::camera_row::Cell::{
    Ahead, Back, Latitude, Longitude, OrbitUp, Pitch, Radius, Side, Turn, Up, X, Y, Z,
};
use super::super::camera_row::{COUNT, CameraRow, Cell, NAMES};
use super::super::camera_shots::{chase, orbit};
use super::super::raw::{COORDINATE_LIMIT, PathSource};
use hedgehop_base::error::Result;

/// Longest time that a view is ahead of its flight, seconds.
const LONGEST: f64 = 3600.0;

/// Columns of cameras that a table has.
#[derive(Debug, Default)]
pub(super) struct CameraColumns {
    /// Index of each column in the table; `None`: it has none.
    indices: [Option<usize>; COUNT],
}

impl CameraColumns {
    /// Whether a column of this name is one of cameras.
    pub fn is_one(name: &str) -> bool {
        NAMES.iter().any(|known| known.eq_ignore_ascii_case(name.trim()))
    }

    /// Finds the columns in a header.
    pub fn of(header: &StringRecord) -> Self {
        let index = |name: &str| header.iter().position(|cell| cell.trim().eq_ignore_ascii_case(name));
        Self { indices: NAMES.map(index) }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.indices.iter().all(Option::is_none)
    }

    /// Reads the cells of a row.
    ///
    /// # Errors
    /// A cell that is no number, or none of its range.
    pub fn row(&self, source: &PathSource<'_>, record: &StringRecord, line: u64) -> Result<CameraRow> {
        let mut cells = [None; COUNT];
        for ((cell, index), name) in cells.iter_mut().zip(self.indices).zip(NAMES) {
            let Some(text) = index.and_then(|index| record.get(index)).filter(|text| !text.is_empty()) else {
                continue;
            };
            let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
            *cell = Some(
                number
                    .ok_or_else(|| source.at_line(line, format!("column {name}: {text:?} is no number")))?,
            );
        }

        let row = CameraRow { line, cells };
        check(source, &row)?;
        Ok(row)
    }
}

/// Refuses cells that need another one, or exclude it.
fn check(source: &PathSource<'_>, row: &CameraRow) -> Result<()> {
    let fail = |what: &str| Err(source.at_line(row.line, what));
    let needed =
        [(X, Y), (Y, X), (Z, X), (Longitude, Latitude), (Latitude, Longitude), (Cell::Altitude, Longitude)];
    let needed = needed.into_iter().chain([(Back, Up), (Up, Back), (Side, Back)]);
    for (given, other) in needed.chain([(Radius, OrbitUp), (OrbitUp, Radius), (Turn, Radius)]) {
        if row.has(given) && !row.has(other) {
            let (given, other) = (NAMES[given as usize], NAMES[other as usize]);
            return fail(&format!("{given} needs {other} beside it; fill both cells, or leave both empty"));
        }
    }

    let looks = [X, Longitude, Ahead, Pitch].into_iter().filter(|cell| row.has(*cell));
    let looks: Vec<&str> = looks.map(|cell| NAMES[cell as usize]).collect();
    if let [first, second, ..] = looks.as_slice() {
        return fail(&format!("{first} and {second} both say where the view goes; leave one of them empty"));
    }
    if row.has(Back) && row.has(Radius) {
        return fail("chase_back_m and orbit_radius_m both say where the eye is; leave one of them empty");
    }
    if row.has(Back) && chase(row).is_none() {
        return fail(
            "chase_back_m, chase_up_m and chase_side_m must be metres, not all 0, up to a million either way",
        );
    }
    if row.has(Radius) && orbit(row).is_none() {
        return fail("orbit_radius_m must be metres above 0, orbit_turn_s seconds, 1 or more either way");
    }
    if row.get(Ahead).is_some_and(|lead| !(0.0..=LONGEST).contains(&lead)) {
        return fail("look_ahead_s must be 0 to 3600 seconds");
    }
    if row.get(Pitch).is_some_and(|pitch| pitch.abs() > 90.0) {
        return fail("look_pitch_deg must be -90 to 90 degrees");
    }
    let [longitude, latitude] = [Longitude, Latitude].map(|cell| row.get(cell).unwrap_or_default());
    if latitude.abs() > 90.0 || !(-180.0..=360.0).contains(&longitude) {
        return fail(
            "look_at_lon_deg and look_at_lat_deg must lie on the Earth: -180 to 360 and -90 to 90 degrees",
        );
    }
    if [X, Y, Z, Cell::Altitude]
        .into_iter()
        .any(|cell| row.get(cell).is_some_and(|metres| metres.abs() > COORDINATE_LIMIT))
    {
        return fail("the place looked at is too far away; give metres of the database's reference system");
    }
    Ok(())
}
