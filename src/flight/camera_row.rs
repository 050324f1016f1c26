//! Rows of a path file's columns of cameras.

/// Number of the columns.
pub(super) const COUNT: usize = 14;

/// Names of the columns, in the order of [`Cell`].
pub(super) const NAMES: [&str; COUNT] = [
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
pub(super) enum Cell {
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

/// Cells of a row, and its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraRow {
    /// Line of the file, from 1.
    pub(super) line: u64,
    /// Numbers in the order of [`NAMES`]; `None`: the cell is empty.
    pub(super) cells: [Option<f64>; COUNT],
}

/// Row of cameras at the time of its fix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedRow {
    /// Seconds after the first fix.
    pub(super) time: f64,
    /// Cells.
    pub(super) row: CameraRow,
}

impl CameraRow {
    /// Returns the number of a cell.
    pub(super) fn get(&self, cell: Cell) -> Option<f64> {
        self.cells[cell as usize]
    }

    /// Whether a cell is filled.
    pub(super) fn has(&self, cell: Cell) -> bool {
        self.get(cell).is_some()
    }

    /// Whether another row has the same camera, but for the place that is looked at.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let same = |index: usize| {
            let is_place = index <= Cell::Altitude as usize;
            let (own, others) = (self.cells[index], other.cells[index]);
            if is_place { own.is_some() == others.is_some() } else { own == others }
        };
        (0..COUNT).all(same)
    }
}
