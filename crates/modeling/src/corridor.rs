//! Pages that a database stores: all of the coarse levels, and finer ones near a route.
//!
//! ```text
//! for each corridor: its level is that of its spacing
//!     for each leg of the route, each page of that level or a coarser one whose square is no more than half a width away: stored
//! outside of all: levels from that of the outer spacing on
//! ```
//! After Nack et al., US 5,317,689 (1994), figures 1b and 1c: a strip of fine data within coarser ones.

use std::path::PathBuf;

use glam::DVec2;

use crate::naming::file_name;
use hedgehop::voxel::{CorridorRecord, Grid, PAGE_SIDE, PageId, RADIX};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, Transform};

/// A part of the area that is stored more finely than what lies around it.
#[derive(Debug, Clone)]
pub struct Corridor {
    /// Route of the corridor.
    pub route: Route,
    /// Width from side to side, metres, > 0: half of it on either side of the route, and round its ends.
    pub width: f64,
    /// Side of the finest voxels in it, metres: the finest of all corridors, or 4, 16, 64, … times that.
    pub spacing: f64,
}

/// A line over the ground, straight from place to place.
#[derive(Debug, Clone)]
pub struct Route {
    /// The file that it was read from, for errors and notes.
    pub file: PathBuf,
    /// Places of the route; at least one.
    pub places: Vec<Place>,
}

/// A place on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// WGS 84 longitude and latitude, degrees.
    LonLat(f64, f64),
    /// Metres in the database's reference system, x east, y north.
    Xy(f64, f64),
}

impl Corridor {
    /// Returns the database's record of it.
    pub(super) fn record(&self) -> CorridorRecord {
        CorridorRecord { route: file_name(&self.route.file), width: self.width, spacing: self.spacing }
    }

    /// Why it cannot be, by a clause that begins with a verb.
    fn refused(&self, what: &str) -> Error {
        let (file, spacing) = (self.route.file.display(), self.spacing);
        Error::Configuration(format!("{file}: a corridor of --spacing {spacing} {what}"))
    }
}

impl Route {
    /// Returns its places in the database's reference system, metres.
    fn line(&self, crs: &Crs) -> Result<Vec<DVec2>> {
        let refuse = |what: String| Err(Error::invalid(&self.file, what));
        let is_geographic = self.places.iter().any(|place| matches!(place, Place::LonLat(..)));
        if is_geographic && crs.is_local() {
            return refuse(
                "longitudes and latitudes have no place in a database of plain metres; give columns x_m and y_m"
                    .into(),
            );
        }

        let world_from_degrees = if is_geographic { Some(Transform::new(&Crs::wgs84(), crs)?) } else { None };
        let mut line = Vec::with_capacity(self.places.len());
        for (index, place) in self.places.iter().enumerate() {
            let found = match *place {
                Place::LonLat(longitude, latitude) => {
                    world_from_degrees.as_ref().and_then(|world| world.apply(longitude, latitude))
                }
                Place::Xy(x, y) => Some((x, y)),
            };
            match found.map(|(x, y)| DVec2::new(x, y)).filter(|at| at.is_finite()) {
                Some(at) => line.push(at),
                None => return refuse(format!("fix {} has no place in {}", index + 1, crs.name())),
            }
        }

        if line.is_empty() {
            return refuse("it has no fix; a corridor needs one at least".into());
        }

        Ok(line)
    }
}

/// Corridors that are asked of a build, in the database's reference system, and what lies outside.
#[derive(Debug)]
pub(super) struct Corridors {
    /// Level and metres to either side, with the line.
    strips: Vec<Strip>,
    /// Finest level outside of all.
    pub outside: u8,
}

#[derive(Debug)]
struct Strip {
    file: PathBuf,
    line: Vec<DVec2>,
    reach: f64,
    level: u8,
}

/// The level whose voxels have sides of `spacing` metres if those of level 1 have `unit`; else a clause that says which sides would do.
///
/// Sides of at least `least` levels are named.
fn level_of(spacing: f64, unit: f64, least: f64) -> Result<u8, String> {
    /// Rounding of the ratio: decimal fractions do not divide exactly.
    const ROUNDING: f64 = 1.0e-9;
    let ratio = spacing / unit;
    let level = (ratio.ln() / f64::from(RADIX).ln()).round();
    let side = f64::from(RADIX).powf(level);
    if !(0.0..=15.0).contains(&level) || (ratio / side - 1.0).abs() > ROUNDING {
        let below = f64::from(RADIX).powf((ratio.ln() / f64::from(RADIX).ln()).floor().clamp(least, 14.0));
        return Err(format!(
            "is not 1, 4, 16, 64, … times the finest spacing, {unit} m; {} or {} would do",
            unit * below,
            unit * below * f64::from(RADIX)
        ));
    }
    Ok(level as u8)
}

/// The finest of the corridors' spacings, which is the unit; an error if a corridor makes no sense.
pub(super) fn finest(corridors: &[Corridor]) -> Result<Option<f64>> {
    for Corridor { width, spacing, .. } in corridors {
        for (flag, value) in [("--width", width), ("--spacing", spacing)] {
            if !(value.is_finite() && *value > 0.0) {
                return Err(Error::Configuration(format!(
                    "{flag} is {value}, but must be a positive number of metres"
                )));
            }
        }
    }
    Ok(corridors.iter().map(|corridor| corridor.spacing).reduce(f64::min))
}

impl Corridors {
    /// Places corridors over voxels of `unit` metres. Outside, voxels are as wide as `outside` says, or else no wider than `coarsest`, the
    /// pixels of the coarsest raster (both metres).
    pub fn new(
        corridors: &[Corridor],
        crs: &Crs,
        unit: f64,
        outside: Option<f64>,
        coarsest: f64,
    ) -> Result<Self> {
        let outside = match outside {
            Some(outside) => level_of(outside, unit, 1.0)
                .map_err(|what| Error::Configuration(format!("--outside {outside} {what}")))?,
            // A pixel that is a hair too small for it fills a voxel.
            None => ((coarsest / unit * 1.000_001).ln() / f64::from(RADIX).ln()).clamp(0.0, 15.0) as u8,
        };
        let level = |corridor: &Corridor| {
            level_of(corridor.spacing, unit, 0.0).map_err(|what| corridor.refused(&what))
        };
        let levels: Vec<u8> = corridors.iter().map(level).collect::<Result<_>>()?;
        let mut strips = Vec::new();

        for (corridor, level) in corridors.iter().zip(levels) {
            if level >= outside {
                return Err(corridor.refused(&format!(
                    "adds nothing, since all of the area is stored at {} m already; --outside {} would store the rest more coarsely",
                    unit * f64::from(Grid::side_units(outside)),
                    unit * f64::from(Grid::side_units(level + 1))
                )));
            }

            let Corridor { route, width, .. } = corridor;
            strips.push(Strip {
                file: route.file.clone(),
                line: route.line(crs)?,
                reach: 0.5 * width,
                level,
            });
        }

        Ok(Self { strips, outside })
    }
}

/// Pages that a database stores.
#[derive(Debug)]
pub(super) struct Stored {
    grid: Grid,
    /// Pages of the levels that are not stored as a whole, finest first.
    partial: Vec<PageSet>,
}

/// Pages of one level.
#[derive(Debug)]
struct PageSet {
    columns: u32,
    rows: u32,
    bits: Vec<u64>,
    count: u64,
}

impl PageSet {
    /// None of the pages of a level.
    fn none(grid: &Grid, level: u8) -> Self {
        let (columns, rows) = grid.page_dims(level);
        let bits = (u64::from(columns) * u64::from(rows)).div_ceil(u64::from(u64::BITS));
        Self { columns, rows, bits: vec![0; bits as usize], count: 0 }
    }

    fn place(&self, px: u32, py: u32) -> (usize, u64) {
        let index = u64::from(py) * u64::from(self.columns) + u64::from(px);
        ((index / u64::from(u64::BITS)) as usize, 1 << (index % u64::from(u64::BITS)))
    }

    fn has(&self, px: u32, py: u32) -> bool {
        let (word, bit) = self.place(px, py);
        self.bits[word] & bit != 0
    }

    fn add(&mut self, px: u32, py: u32) {
        let (word, bit) = self.place(px, py);
        self.count += u64::from(self.bits[word] & bit == 0);
        self.bits[word] |= bit;
    }

    fn is_full(&self) -> bool {
        self.count == u64::from(self.columns) * u64::from(self.rows)
    }

    /// Adds the pages of `level` within `reach` metres of a leg.
    fn add_leg(&mut self, grid: &Grid, level: u8, leg: [DVec2; 2], reach: f64) {
        let side = grid.side(level) * f64::from(PAGE_SIDE);
        let [low, high] = [leg[0].min(leg[1]) - reach, leg[0].max(leg[1]) + reach];
        let range = |low: f64, high: f64, count: u32| {
            let first = (low / side).floor().clamp(0.0, f64::from(count));
            let last = (high / side).floor().clamp(-1.0, f64::from(count) - 1.0);
            first as u32..(last + 1.0) as u32
        };
        let columns = range(low.x - grid.origin.x, high.x - grid.origin.x, self.columns);
        for py in range(low.y - grid.origin.y, high.y - grid.origin.y, self.rows) {
            for px in columns.clone() {
                if !self.has(px, py) && distance(grid.page_square(PageId { level, px, py }), leg) <= reach {
                    self.add(px, py);
                }
            }
        }
    }
}

/// Distance between a rectangle and a straight line from place to place.
fn distance([low, high]: [DVec2; 2], [from, to]: [DVec2; 2]) -> f64 {
    if crosses([low, high], [from, to]) {
        return 0.0;
    }
    let outside = |at: DVec2| at.distance(at.clamp(low, high));
    let along = to - from;
    let beside = |corner: DVec2| {
        let share = (corner - from).dot(along) / along.length_squared();
        // A leg may be a point.
        let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
        corner.distance(from + along * share)
    };
    let corners = [low, DVec2::new(high.x, low.y), DVec2::new(low.x, high.y), high];
    corners.map(beside).into_iter().chain([from, to].map(outside)).fold(f64::INFINITY, f64::min)
}

/// Whether some of a straight line lies in a rectangle (Liang and Barsky, 1984).
fn crosses([low, high]: [DVec2; 2], [from, to]: [DVec2; 2]) -> bool {
    let mut within = [0.0_f64, 1.0_f64];
    for axis in 0..2 {
        let (start, run) = (from[axis], to[axis] - from[axis]);
        if run == 0.0 {
            if start < low[axis] || start > high[axis] {
                return false;
            }
            continue;
        }
        let [a, b] = [low[axis], high[axis]].map(|edge| (edge - start) / run);
        within = [within[0].max(a.min(b)), within[1].min(a.max(b))];
    }
    within[0] <= within[1]
}

impl Stored {
    /// All pages.
    pub fn all(grid: &Grid) -> Self {
        Self { grid: *grid, partial: Vec::new() }
    }

    /// Chooses the pages that corridors ask for.
    pub fn within(grid: &Grid, corridors: &Corridors) -> Result<Self> {
        let side = |level: u8| grid.spacing * f64::from(Grid::side_units(level));
        if corridors.outside >= grid.level_count() {
            return Err(Error::Configuration(format!(
                "--outside {} is more than {} m, the coarsest level of an area of this size",
                side(corridors.outside),
                side(grid.level_count() - 1)
            )));
        }

        let mut partial: Vec<PageSet> =
            (0..corridors.outside).map(|level| PageSet::none(grid, level)).collect();
        for strip in &corridors.strips {
            let before: u64 = partial.iter().map(|pages| pages.count).sum();
            for (level, pages) in partial.iter_mut().enumerate().skip(usize::from(strip.level)) {
                let ends = strip.line.iter().skip(1).chain(strip.line.last());
                for (from, to) in strip.line.iter().zip(ends) {
                    if pages.is_full() {
                        break;
                    }
                    pages.add_leg(grid, level as u8, [*from, *to], strip.reach);
                }
            }

            let after: u64 = partial.iter().map(|pages| pages.count).sum();
            // One that lies in another one adds no page either.
            if after == before && !strip.line.iter().any(|at| grid.contains(*at)) {
                let (near, far, at) = (grid.origin, grid.far_corner(), strip.line[0]);
                return Err(Error::Configuration(format!(
                    "{}: the corridor lies outside the area: it begins at x {:.1}, y {:.1}, and the area is x {:.1} to {:.1}, \
                     y {:.1} to {:.1}; check its reference system and --bbox",
                    strip.file.display(),
                    at.x,
                    at.y,
                    near.x,
                    far.x,
                    near.y,
                    far.y
                )));
            }
        }

        Ok(Self { grid: *grid, partial })
    }

    /// Whether a page is.
    pub fn has(&self, id: PageId) -> bool {
        self.partial.get(usize::from(id.level)).is_none_or(|pages| pages.has(id.px, id.py))
    }

    /// Whether all pages are.
    pub fn is_all(&self) -> bool {
        self.partial.is_empty()
    }

    /// The finest level that is stored as a whole.
    pub fn outside(&self) -> u8 {
        self.partial.len() as u8
    }

    /// Counts the stored pages of a level.
    pub fn count(&self, level: u8) -> u64 {
        let (columns, rows) = self.grid.page_dims(level);
        let all = u64::from(columns) * u64::from(rows);
        self.partial.get(usize::from(level)).map_or(all, |pages| pages.count)
    }

    /// The stored pages of a level in rows from the north, as rasters are stored, so that decoded blocks serve neighbouring pages
    /// before they leave the cache.
    pub fn tasks(&self, level: u8) -> Tasks {
        let (columns, rows) = self.grid.page_dims(level);
        let id = |task: u64| {
            let (column, row) = (task % u64::from(columns), task / u64::from(columns));
            PageId { level, px: column as u32, py: rows - 1 - row as u32 }
        };
        let chosen = self.partial.get(usize::from(level)).map(|pages| {
            let all = u64::from(columns) * u64::from(rows);
            (0..all).filter(|task| pages.has(id(*task).px, id(*task).py)).collect()
        });
        Tasks { level, columns, rows, chosen }
    }
}

/// Pages of a level in the order in which they are made.
#[derive(Debug)]
pub(super) struct Tasks {
    level: u8,
    columns: u32,
    rows: u32,
    /// Numbers of the chosen pages; `None`: all.
    chosen: Option<Vec<u64>>,
}

impl Tasks {
    pub fn count(&self) -> u64 {
        self.chosen
            .as_ref()
            .map_or(u64::from(self.columns) * u64::from(self.rows), |chosen| chosen.len() as u64)
    }

    pub fn id(&self, task: u64) -> PageId {
        let task = self.chosen.as_ref().map_or(task, |chosen| chosen[task as usize]);
        let (column, row) = (task % u64::from(self.columns), task / u64::from(self.columns));
        PageId { level: self.level, px: column as u32, py: self.rows - 1 - row as u32 }
    }
}
