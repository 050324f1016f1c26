//! Columns of cameras: the shots of a film, row by row.
//!
//! A row whose cells ask for another camera than the row before begins a shot. Within one the place that is looked at
//! moves from row to row; all else stays.

use csv::StringRecord;

use super::super::raw::{COORDINATE_LIMIT, PathSource};
use super::super::shot::{Chase, Look, Mount, Orbit, Shot};
use super::super::track::{Altitude, AltitudeMode, Fix, Horizontal, Track};
use hedgehop_base::error::Result;

/// Names of the columns, in the order of [`Cell`].
const NAMES: [&str; 14] = [
    "look_at_x_m",
    "look_at_y_m",
    "look_at_z_m",
    "look_at_lon_deg",
    "look_at_lat_deg",
    "look_at_alt_m",
    "look_ahead_s",
    "look_pitch_deg",
    "chase_back_m",
    "chase_up_m",
    "chase_side_m",
    "orbit_radius_m",
    "orbit_up_m",
    "orbit_turn_s",
];

/// A column of cameras.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
enum Cell {
    X,
    Y,
    Z,
    Longitude,
    Latitude,
    Altitude,
    Ahead,
    Pitch,
    Back,
    Up,
    Side,
    Radius,
    OrbitUp,
    Turn,
}

use Cell::{Ahead, Back, Latitude, Longitude, OrbitUp, Pitch, Radius, Side, Turn, Up, X, Y, Z};

/// Longest time that a view is ahead of its flight, seconds.
const LONGEST: f64 = 3600.0;

/// Columns of cameras that a table has.
#[derive(Debug, Default)]
pub(super) struct CameraColumns {
    /// Index of each column in the table; `None`: it has none.
    indices: [Option<usize>; NAMES.len()],
}

/// Cells of a row, and its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::flight) struct CameraRow {
    line: u64,
    cells: [Option<f64>; NAMES.len()],
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
        let mut cells = [None; NAMES.len()];
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
        row.check(source)?;
        Ok(row)
    }
}

impl CameraRow {
    /// Line of the row in its file.
    pub fn line(&self) -> u64 {
        self.line
    }

    fn get(&self, cell: Cell) -> Option<f64> {
        self.cells[cell as usize]
    }

    fn has(&self, cell: Cell) -> bool {
        self.get(cell).is_some()
    }

    /// Refuses cells that need another one, or exclude it.
    fn check(&self, source: &PathSource<'_>) -> Result<()> {
        let fail = |what: &str| Err(source.at_line(self.line, what));
        let needed = [
            (X, Y),
            (Y, X),
            (Z, X),
            (Longitude, Latitude),
            (Latitude, Longitude),
            (Cell::Altitude, Longitude),
        ];
        let needed = needed.into_iter().chain([(Back, Up), (Up, Back), (Side, Back)]);
        for (given, other) in needed.chain([(Radius, OrbitUp), (OrbitUp, Radius), (Turn, Radius)]) {
            if self.has(given) && !self.has(other) {
                let (given, other) = (NAMES[given as usize], NAMES[other as usize]);
                return fail(&format!(
                    "{given} needs {other} beside it; fill both cells, or leave both empty"
                ));
            }
        }

        let looks = [X, Longitude, Ahead, Pitch].into_iter().filter(|cell| self.has(*cell));
        let looks: Vec<&str> = looks.map(|cell| NAMES[cell as usize]).collect();
        if let [first, second, ..] = looks.as_slice() {
            return fail(&format!(
                "{first} and {second} both say where the view goes; leave one of them empty"
            ));
        }
        if self.has(Back) && self.has(Radius) {
            return fail(
                "chase_back_m and orbit_radius_m both say where the eye is; leave one of them empty",
            );
        }
        if self.has(Back) && self.chase().is_none() {
            return fail(
                "chase_back_m, chase_up_m and chase_side_m must be metres, not all 0, up to a million either way",
            );
        }
        if self.has(Radius) && self.orbit().is_none() {
            return fail("orbit_radius_m must be metres above 0, orbit_turn_s seconds, 1 or more either way");
        }
        if self.get(Ahead).is_some_and(|lead| !(0.0..=LONGEST).contains(&lead)) {
            return fail("look_ahead_s must be 0 to 3600 seconds");
        }
        if self.get(Pitch).is_some_and(|pitch| pitch.abs() > 90.0) {
            return fail("look_pitch_deg must be -90 to 90 degrees");
        }
        let [longitude, latitude] = [Longitude, Latitude].map(|cell| self.get(cell).unwrap_or_default());
        if latitude.abs() > 90.0 || !(-180.0..=360.0).contains(&longitude) {
            return fail(
                "look_at_lon_deg and look_at_lat_deg must lie on the Earth: -180 to 360 and -90 to 90 degrees",
            );
        }
        if [X, Y, Z, Cell::Altitude]
            .into_iter()
            .any(|cell| self.get(cell).is_some_and(|metres| metres.abs() > COORDINATE_LIMIT))
        {
            return fail(
                "the place looked at is too far away; give metres of the database's reference system",
            );
        }
        Ok(())
    }

    fn chase(&self) -> Option<Chase> {
        Chase::of(&[self.get(Back)?, self.get(Up)?, self.get(Side).unwrap_or_default()])
    }

    fn orbit(&self) -> Option<Orbit> {
        Orbit::of([self.get(Radius)?, self.get(OrbitUp)?], self.get(Turn))
    }

    /// Whether another row has the same camera, but for the place that is looked at.
    fn is_like(&self, other: &Self) -> bool {
        let same = |index: usize| {
            let is_place = index <= Cell::Altitude as usize;
            let (own, others) = (self.cells[index], other.cells[index]);
            if is_place { own.is_some() == others.is_some() } else { own == others }
        };
        (0..NAMES.len()).all(same)
    }

    fn mount(&self) -> Mount {
        let chase = self.chase().map(Mount::Chase);
        chase.or_else(|| self.orbit().map(Mount::Orbit)).unwrap_or(Mount::Aboard)
    }

    /// Returns the place that is looked at as a fix at a time; `None`: there is none.
    fn place(&self, time: f64) -> Option<Fix> {
        let (horizontal, altitude) = match (self.get(X), self.get(Y), self.get(Longitude), self.get(Latitude))
        {
            (Some(x), Some(y), ..) => (Horizontal::Xy(x, y), self.get(Z)),
            (_, _, Some(longitude), Some(latitude)) => {
                (Horizontal::LonLat(longitude, latitude), self.get(Cell::Altitude))
            }
            _ => return None,
        };
        let altitude = match altitude {
            Some(metres) => Altitude { metres, mode: AltitudeMode::Msl },
            None => Altitude { metres: 0.0, mode: AltitudeMode::Agl },
        };
        let [yaw, pitch, roll, hfov] = [Some(0.0), Some(0.0), Some(0.0), None];
        Some(Fix { time, horizontal, altitude, accuracy: None, yaw, pitch, roll, hfov })
    }
}

/// Makes shots of the rows that belong to fixes, in their order; each with its time, seconds after the first fix.
pub(in crate::flight) fn shots(source: &PathSource<'_>, rows: &[TimedRow]) -> Vec<Shot> {
    let mut shots = Vec::new();
    let mut rest = rows;
    while let Some((first, _)) = rest.split_first() {
        let count = rest.iter().take_while(|timed| timed.row.is_like(&first.row)).count();
        let (own, others) = rest.split_at(count);
        rest = others;

        let fixes: Vec<Fix> =
            own.iter().filter_map(|timed| timed.row.place(timed.time - first.time)).collect();
        let track = |fixes: Vec<Fix>| Track {
            path: source.path.to_owned(),
            format: "CSV",
            fixes,
            clock: None,
            notes: Vec::new(),
            shots: Vec::new(),
        };
        let look = match (first.row.get(Ahead), first.row.get(Pitch)) {
            (Some(lead), _) => Some(Look::Ahead(lead)),
            (None, Some(pitch)) => Some(Look::Pitch(pitch)),
            (None, None) if fixes.is_empty() => None,
            (None, None) => Some(Look::Moving(track(fixes))),
        };
        shots.push(Shot { from: first.time, mount: first.row.mount(), look, zoom: None });
    }
    shots
}

/// Row of cameras at the time of its fix.
#[derive(Debug, Clone, Copy)]
pub(in crate::flight) struct TimedRow {
    /// Seconds after the first fix.
    pub time: f64,
    /// Cells.
    pub row: CameraRow,
}
