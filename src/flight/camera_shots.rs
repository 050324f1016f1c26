//! Shots of a film from rows of cameras.
//!
//! A row whose cells ask for another camera than the row before begins a shot. Within one the place that is looked at
//! moves from row to row; all else stays.

use super::camera_row::Cell::{
    Ahead, Back, Latitude, Longitude, OrbitUp, Pitch, Radius, Side, Turn, Up, X, Y, Z,
};
use super::camera_row::{CameraRow, Cell, TimedRow};
use super::shot::{Chase, Look, Mount, Orbit, Shot};
use super::track::{Altitude, AltitudeMode, Fix, Horizontal, Track};

/// Returns the cameras that a path file asks for, by their beginnings.
pub fn camera_shots(track: &Track) -> Vec<Shot> {
    let mut shots = Vec::new();
    let mut rest: &[TimedRow] = &track.cameras;
    while let Some((first, _)) = rest.split_first() {
        let count = rest.iter().take_while(|timed| timed.row.is_like(&first.row)).count();
        let (own, others) = rest.split_at(count);
        rest = others;

        let fixes: Vec<Fix> =
            own.iter().filter_map(|timed| place(&timed.row, timed.time - first.time)).collect();
        let looked_at = |fixes: Vec<Fix>| Track {
            path: track.path.clone(),
            format: "CSV",
            fixes,
            clock: None,
            notes: Vec::new(),
            cameras: Vec::new(),
        };
        let look = match (first.row.get(Ahead), first.row.get(Pitch)) {
            (Some(lead), _) => Some(Look::Ahead(lead)),
            (None, Some(pitch)) => Some(Look::Pitch(pitch)),
            (None, None) if fixes.is_empty() => None,
            (None, None) => Some(Look::Moving(looked_at(fixes))),
        };
        shots.push(Shot { from: first.time, mount: mount(&first.row), look, zoom: None });
    }
    shots
}

/// Returns the place of an eye behind the flight, if a row has a sound one.
pub(super) fn chase(row: &CameraRow) -> Option<Chase> {
    Chase::of(&[row.get(Back)?, row.get(Up)?, row.get(Side).unwrap_or_default()])
}

/// Returns the circle of an eye, if a row has a sound one.
pub(super) fn orbit(row: &CameraRow) -> Option<Orbit> {
    Orbit::of([row.get(Radius)?, row.get(OrbitUp)?], row.get(Turn))
}

fn mount(row: &CameraRow) -> Mount {
    let chase = chase(row).map(Mount::Chase);
    chase.or_else(|| orbit(row).map(Mount::Orbit)).unwrap_or(Mount::Aboard)
}

/// Returns the place that is looked at as a fix at a time; `None`: there is none.
fn place(row: &CameraRow, time: f64) -> Option<Fix> {
    let (horizontal, altitude) = match (row.get(X), row.get(Y), row.get(Longitude), row.get(Latitude)) {
        (Some(x), Some(y), ..) => (Horizontal::Xy(x, y), row.get(Z)),
        (_, _, Some(longitude), Some(latitude)) => {
            (Horizontal::LonLat(longitude, latitude), row.get(Cell::Altitude))
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
