//! Contour lines of the ground.
//!
//! ```text
//! for each cell between four posts, rows from the south, block by block:
//!     for each elevation that lies between its lowest and its highest post:
//!         a post is above if its height ≥ elevation          (so that a line never ends on a post)
//!         the line crosses the sides whose posts differ, where the height is the elevation on a straight line
//!         4 crossings (a saddle): the mean of the posts says which pairs belong together
//!         join the piece with the lines that end at its crossings; both: the lines become one, or a ring
//! a cell with a post without a surface has no lines: they end there
//! ```
//!
//! Marching squares (Lorensen and Cline, "Marching cubes", SIGGRAPH 1987, in the plane). The higher ground is to the left of a line.

use std::collections::{HashMap, VecDeque};
use std::ops::Range;

use glam::DVec2;

use super::posts::{PostReader, Posts, Sheet};
use hedgehop::voxel::PageSource;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Cells of a block each way.
const BLOCK: i64 = 512;

/// Points of all lines together, at most: about 2 GB.
const MOST_POINTS: usize = 60_000_000;

/// Elevations between two neighbouring posts, at most: more are a mistake in the interval.
const MOST_ELEVATIONS: f64 = 10_000.0;

/// A contour line.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// Multiple of the interval.
    pub number: i64,
    /// Points in order, metres of the database's system, at least two; of a ring the last is the first.
    pub points: Vec<DVec2>,
}

impl Contour {
    /// Whether it comes back to where it begins.
    pub fn is_ring(&self) -> bool {
        self.points.len() > 2 && self.points.first() == self.points.last()
    }
}

/// The round interval (1, 2 or 5 times a power of ten) that gives between 10 and 25 lines over a range of heights, metres.
pub fn fitting_interval(low: f64, high: f64) -> f64 {
    let wanted = ((high - low) / 25.0).max(1e-3);
    let power = 10.0_f64.powf(wanted.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|step| step * power).find(|step| *step >= wanted).unwrap_or(10.0 * power)
}

/// Contour lines at multiples of `interval` metres of the posts of a level, in a box (west, south, east, north, metres), by elevation and from where
/// they begin. Of level index 0 it is the ground under what stands on it.
///
/// # Errors
/// [`Error::Configuration`]: an interval that is not positive, or so small that lines have too many points; a page that is damaged; an interruption.
pub fn contours(
    source: &dyn PageSource,
    level: u8,
    bounds: [f64; 4],
    interval: f64,
    observer: &dyn Observer,
) -> Result<Vec<Contour>> {
    if !(interval.is_finite() && interval > 0.0) {
        return Err(Error::Configuration(format!(
            "an interval of {interval} m has no lines; give one above 0"
        )));
    }

    let reader = PostReader::new(source, level, Sheet::Bare);
    let [columns, rows] = posts_in(source, level, bounds);
    let count = blocks(&columns).count() * blocks(&rows).count();
    observer.begin("contours", count as u64, "blocks");
    let mut tracer = Tracer { interval, ..Tracer::default() };

    for row in blocks(&rows) {
        for column in blocks(&columns) {
            if observer.cancelled() {
                return Err(Error::Interrupted("no lines were written".into()));
            }
            let posts = reader.heights(column..end(column, &columns), row..end(row, &rows))?;
            tracer.block(&posts)?;
            observer.advance(1);
        }
    }

    observer.end();
    Ok(tracer.lines(|point| reader.place(0, 0) + point * source.header().grid.side(level)))
}

/// Least and greatest height of the ground that lines are of, the cells between posts of a level in a box, metres above the datum. `None`: there are no cells, as in a gap of the data,
/// or in a box with less than two by two posts.
///
/// # Errors
/// A page that is damaged.
pub fn contour_range(source: &dyn PageSource, level: u8, bounds: [f64; 4]) -> Result<Option<[f64; 2]>> {
    let reader = PostReader::new(source, level, Sheet::Bare);
    let [columns, rows] = posts_in(source, level, bounds);
    let mut range: Option<[f64; 2]> = None;
    for (column, row) in blocks(&rows).flat_map(|row| blocks(&columns).map(move |column| (column, row))) {
        let posts = reader.heights(column..end(column, &columns), row..end(row, &rows))?;
        for corners in cells(&posts).map(|[column, row]| corners(&posts, column, row)) {
            if corners.iter().any(|height| height.is_nan()) {
                continue;
            }
            let known = range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            range =
                Some(corners.iter().fold(known, |[low, high], height| [low.min(*height), high.max(*height)]));
        }
    }
    Ok(range)
}

/// First columns, or rows, of blocks of cells between posts.
fn blocks(posts: &Range<i64>) -> impl Iterator<Item = i64> + use<> {
    (posts.start..posts.end - 1).step_by(BLOCK as usize)
}

/// The post behind the last of a block.
fn end(first: i64, posts: &Range<i64>) -> i64 {
    (first + BLOCK + 1).min(posts.end)
}

/// The south-western posts of cells, row by row.
fn cells(posts: &Posts<f64>) -> impl Iterator<Item = [i64; 2]> + use<> {
    let (columns, rows) = (posts.columns.clone(), posts.rows.clone());
    (rows.start..rows.end - 1)
        .flat_map(move |row| (columns.start..columns.end - 1).map(move |column| [column, row]))
}

/// Heights of a cell's posts, counter-clockwise from the south-west.
fn corners(posts: &Posts<f64>, column: i64, row: i64) -> [f64; 4] {
    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, up)| posts.at(column + right, row + up))
}

/// Columns and rows of the posts of a level in a box.
fn posts_in(source: &dyn PageSource, level: u8, [west, south, east, north]: [f64; 4]) -> [Range<i64>; 2] {
    let grid = &source.header().grid;
    let (nx, ny) = grid.dims(level);
    let range = |low: f64, high: f64, origin: f64, limit: u32| {
        let post = |at: f64| (at - origin) / grid.side(level) - 0.5;
        // A float converts saturating.
        let first = post(low).ceil().max(0.0) as i64;
        first..((post(high).floor() + 1.0).min(f64::from(limit)) as i64).max(first)
    };
    [range(west, east, grid.origin.x, nx), range(south, north, grid.origin.y, ny)]
}

/// The side of a cell that a line crosses: eastward from a post (`is_north` false) or northward.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Side {
    column: i32,
    row: i32,
    is_north: bool,
}

/// Crossing of a line and a side.
#[derive(Debug, Clone, Copy)]
struct SideCrossing {
    /// The side that is crossed.
    side: Side,
    /// Place, posts eastward and northward.
    point: DVec2,
}

/// A crossing of a line at a multiple of the interval.
type End = (Side, i64);

/// Joins pieces of lines.
#[derive(Debug, Default)]
struct Tracer {
    interval: f64,
    points: usize,
    /// Open lines; those that were taken up by others are empty. Points in posts.
    open: Vec<VecDeque<DVec2>>,
    /// Numbers of the open lines.
    numbers: Vec<i64>,
    /// Places of `open` that are free.
    free: Vec<usize>,
    /// Line that has an end at a crossing, and whether that is its last point.
    ends: HashMap<End, (usize, bool)>,
    /// The crossings at both ends of an open line.
    crossings: Vec<[Side; 2]>,
    rings: Vec<Contour>,
}

impl Tracer {
    fn block(&mut self, posts: &Posts<f64>) -> Result<()> {
        for row in posts.rows.start..posts.rows.end - 1 {
            for column in posts.columns.start..posts.columns.end - 1 {
                self.cell(posts, column, row)?;
            }
        }
        if self.points > MOST_POINTS {
            return Err(Error::Configuration(format!(
                "lines every {} m have more than {MOST_POINTS} points; give a larger --interval, a smaller --bbox or a coarser --level",
                self.interval
            )));
        }
        Ok(())
    }

    fn cell(&mut self, posts: &Posts<f64>, column: i64, row: i64) -> Result<()> {
        let corners = corners(posts, column, row);
        let (low, high) = corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
            (low.min(*height), high.max(*height))
        });
        if corners.iter().any(|height| height.is_nan()) {
            return Ok(());
        }

        let (first, last) = ((low / self.interval).floor(), (high / self.interval).floor());
        if last - first > MOST_ELEVATIONS {
            return Err(Error::Configuration(format!(
                "between two neighbouring posts there are {:.0} lines every {} m; give a larger --interval",
                last - first,
                self.interval
            )));
        }

        for number in first as i64..=last as i64 {
            let elevation = number as f64 * self.interval;
            if low < elevation && elevation <= high {
                self.pieces(corners, [column as i32, row as i32], number, elevation);
            }
        }

        Ok(())
    }

    /// The line or the two lines of an elevation through a cell.
    fn pieces(&mut self, corners: [f64; 4], [column, row]: [i32; 2], number: i64, elevation: f64) {
        let above = corners.map(|height| height >= elevation);
        let sides = [
            Side { column, row, is_north: false },
            Side { column: column + 1, row, is_north: true },
            Side { column, row: row + 1, is_north: false },
            Side { column, row, is_north: true },
        ];

        let point = |side: usize| {
            // Always from the same post of a side, so that both of its cells get the same point.
            let (from, to) = [(0, 1), (1, 2), (3, 2), (0, 3)][side];
            let share = (elevation - corners[from]) / (corners[to] - corners[from]);
            let Side { column, row, is_north } = sides[side];
            let along = if is_north { DVec2::Y } else { DVec2::X };
            DVec2::new(f64::from(column), f64::from(row)) + along * share
        };

        // Going counter-clockwise around the cell, lines enter where ground falls below the elevation, and leave where it rises above: what is higher is
        // on their left.
        let falls = (0..4).filter(|&side| above[side] && !above[(side + 1) % 4]);
        let is_joined = corners.iter().sum::<f64>() / 4.0 >= elevation;
        let is_saddle = above[0] == above[2] && above[1] == above[3] && above[0] != above[1];

        for enter in falls {
            // At a saddle the middle decides whether a line turns around the lower or the higher corner.
            let next = (1..4).map(|step| (enter + step) % 4);
            let mut rises = next.filter(|&side| !above[side] && above[(side + 1) % 4]);
            let leave = if is_saddle && !is_joined { rises.nth(1) } else { rises.next() };
            if let Some(leave) = leave {
                let [from, to] =
                    [enter, leave].map(|side| SideCrossing { side: sides[side], point: point(side) });
                self.join(from, to, number);
            }
        }
    }

    /// Adds a piece that goes from one crossing to another.
    fn join(&mut self, from: SideCrossing, to: SideCrossing, number: i64) {
        // All lines have the higher ground on one side: a piece goes on where a line ends, and ends where one begins.
        let before = self.ends.remove(&(from.side, number)).map(|(line, _)| line);
        let after = self.ends.remove(&(to.side, number)).map(|(line, _)| line);
        self.points += 1;

        match (before, after) {
            (None, None) => {
                let line = self.place();
                self.open[line].extend([from.point, to.point]);
                (self.numbers[line], self.crossings[line]) = (number, [from.side, to.side]);
                self.ends.insert((from.side, number), (line, false));
                self.ends.insert((to.side, number), (line, true));
            }
            (Some(line), None) => {
                self.open[line].push_back(to.point);
                self.crossings[line][1] = to.side;
                self.ends.insert((to.side, number), (line, true));
            }
            (None, Some(line)) => {
                self.open[line].push_front(from.point);
                self.crossings[line][0] = from.side;
                self.ends.insert((from.side, number), (line, false));
            }
            (Some(line), Some(same)) if line == same => {
                let mut points = Vec::from(std::mem::take(&mut self.open[line]));
                points.extend(points.first().copied());
                self.free.push(line);
                self.rings.push(Contour { number, points });
            }
            (Some(first), Some(second)) => self.link(first, second, number),
        }
    }

    /// Two lines become one.
    fn link(&mut self, first: usize, second: usize, number: i64) {
        let crossings = [self.crossings[first][0], self.crossings[second][1]];
        let mut head = std::mem::take(&mut self.open[first]);
        let mut tail = std::mem::take(&mut self.open[second]);
        // The longer one stays where it is.
        let (stays, goes) = if head.len() >= tail.len() { (first, second) } else { (second, first) };
        self.open[stays] = if stays == first {
            head.append(&mut tail);
            head
        } else {
            head.into_iter().rev().for_each(|point| tail.push_front(point));
            tail
        };
        self.crossings[stays] = crossings;
        self.free.push(goes);
        self.ends.insert((crossings[0], number), (stays, false));
        self.ends.insert((crossings[1], number), (stays, true));
    }

    fn place(&mut self) -> usize {
        self.free.pop().unwrap_or_else(|| {
            self.open.push(VecDeque::new());
            self.numbers.push(0);
            self.crossings.push([Side { column: 0, row: 0, is_north: false }; 2]);
            self.open.len() - 1
        })
    }

    /// All lines, in an order that does not depend on how they were joined.
    fn lines(self, place: impl Fn(DVec2) -> DVec2) -> Vec<Contour> {
        let open = self.open.into_iter().zip(self.numbers).filter(|(points, _)| !points.is_empty());
        let open = open.map(|(points, number)| Contour { number, points: points.into() });
        let mut lines: Vec<Contour> = open.chain(self.rings).collect();
        for line in &mut lines {
            if line.is_ring() {
                begin_in_south_west(&mut line.points);
            }
            line.points.dedup();
        }
        // What turns around a single post lies on it.
        lines.retain(|line| line.points.len() > 1 && (!line.is_ring() || line.points.len() > 3));
        let key = |line: &Contour| (line.number, line.points[0].y.to_bits(), line.points[0].x.to_bits());
        lines.sort_unstable_by_key(key);
        lines.iter_mut().flat_map(|line| &mut line.points).for_each(|point| *point = place(*point));
        lines
    }
}

/// Lets a ring begin at its southernmost, of these its westernmost point.
fn begin_in_south_west(points: &mut Vec<DVec2>) {
    points.pop();
    let order = |a: &DVec2, b: &DVec2| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x));
    let first = points.iter().enumerate().min_by(|(_, a), (_, b)| order(a, b)).map_or(0, |(first, _)| first);
    points.rotate_left(first);
    points.extend(points.first().copied());
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::voxel::{Grid, MemPages, Metadata, build_in_memory};
    use hedgehop_base::progress::Silent;

    const WHOLE: [f64; 4] = [f64::MIN, f64::MIN, f64::MAX, f64::MAX];

    fn area(nx: u32, ny: u32, height: impl Fn(f64, f64) -> f64) -> MemPages {
        let grid = Grid { nx, ny, spacing: 2.0, origin: DVec2::new(1000.0, 2000.0) };
        let post = |at: u32| 2.0 * f64::from(at) + 1.0;
        let heights: Vec<f64> = (0..ny)
            .flat_map(|y| (0..nx).map(move |x| (x, y)))
            .map(|(x, y)| height(post(x), post(y)))
            .collect();
        build_in_memory(grid, &heights, &vec![[9; 3]; heights.len()], None, &Metadata::default()).unwrap()
    }

    #[test]
    fn lines_of_a_cone_are_circles() {
        let middle = DVec2::new(620.0, 580.0);
        let cone = area(620, 600, |x, y| 500.0 - 0.8 * (DVec2::new(x, y) - middle).length());
        let lines = contours(&cone, 0, WHOLE, 50.0, &Silent).unwrap();
        let rings: Vec<_> = lines.iter().filter(|line| line.is_ring()).collect();
        // Down to where the nearest edge of the area is, 580 m away: 36 m above 0.
        assert_eq!(rings.len(), 9, "{:?}", rings.iter().map(|ring| ring.number).collect::<Vec<_>>());
        for ring in rings {
            let wanted = (500.0 - 50.0 * ring.number as f64) / 0.8;
            for point in &ring.points {
                let radius = (*point - DVec2::new(1000.0, 2000.0) - middle).length();
                assert!((radius - wanted).abs() < 1.0, "{}: {radius} for {wanted}", ring.number);
            }
            // The higher ground is on the left: counter-clockwise.
            let area: f64 = ring.points.windows(2).map(|ends| ends[0].perp_dot(ends[1])).sum();
            assert!(area > 0.0);
        }
        assert!(lines.windows(2).all(|pair| pair[0].number <= pair[1].number));
    }

    #[test]
    fn lines_of_a_plane_run_from_edge_to_edge_and_end_at_voids() {
        let plane = area(700, 300, |x, _| 0.1 * x);
        let lines = contours(&plane, 0, WHOLE, 10.0, &Silent).unwrap();
        assert_eq!(lines.len(), 13);
        for line in &lines {
            assert_eq!(line.points.len(), 300);
            assert!(
                line.points.iter().all(|point| (point.x - 1000.0 - 100.0 * line.number as f64).abs() < 0.1)
            );
        }
        let holed = area(700, 300, |x, y| if (200.0..260.0).contains(&y) { f64::NAN } else { 0.1 * x });
        assert_eq!(contours(&holed, 0, WHOLE, 10.0, &Silent).unwrap().len(), 26);
        let part = contours(&plane, 0, [1150.0, 2100.0, 1350.0, 2200.0], 10.0, &Silent).unwrap();
        assert_eq!(part.iter().map(|line| line.number).collect::<Vec<_>>(), [2, 3]);
        assert!(contours(&plane, 0, WHOLE, 0.0, &Silent).is_err());
        assert!(
            contours(&plane, 0, WHOLE, 1e-9, &Silent).unwrap_err().to_string().contains("larger --interval")
        );
    }

    #[test]
    fn the_range_of_lines_is_that_of_cells() {
        // More than a block of cells; one post stands alone in a void.
        let ground = |x: f64, y: f64| match (500.0..700.0).contains(&x) {
            true if (x, y) == (601.0, 301.0) => 900.0,
            true => f64::NAN,
            false => 100.0 + 0.1 * x,
        };
        let area = area(700, 300, ground);
        let range = |bounds| contour_range(&area, 0, bounds).unwrap();

        let near = |bounds, wanted: [f64; 2]| {
            let found: [f64; 2] = range(bounds).unwrap();
            assert!(
                found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 0.02),
                "{found:?}"
            );
        };

        near(WHOLE, [100.1, 239.9]);
        near([1200.0, 2100.0, 1300.0, 2200.0], [120.1, 129.9]);
        near([1400.0, 2100.0, 1700.0, 2500.0], [140.1, 149.9]);
        let gap = [1510.0, 2200.0, 1690.0, 2400.0];
        let narrow = [1200.0, 2100.0, 1202.0, 2200.0];
        for bounds in [gap, narrow] {
            assert_eq!(range(bounds), None, "{bounds:?}");
            assert!(contours(&area, 0, bounds, 1.0, &Silent).unwrap().is_empty());
        }
    }

    #[test]
    fn saddles_and_plateaus_neither_cross_nor_end() {
        // Posts of few heights, many of them on lines.
        let hash = |x: f64, y: f64| ((x * 12.9898 + y * 78.233).sin() * 43_758.545).rem_euclid(1.0);
        let rough = area(90, 80, |x, y| (hash(x, y) * 4.0).floor());
        let lines = contours(&rough, 0, WHOLE, 1.0, &Silent).unwrap();
        let (low, high) = (DVec2::new(1001.0, 2001.0), DVec2::new(1179.0, 2159.0));
        for line in lines.iter().filter(|line| !line.is_ring()) {
            for end in [line.points[0], line.points[line.points.len() - 1]] {
                let edge = (end - low).abs().min((end - high).abs()).min_element();
                assert!(edge < 1e-9, "a line of {} ends at {end}", line.number);
            }
        }
        assert!(lines.len() > 500);
    }

    #[test]
    fn intervals_fit_the_range() {
        for (range, wanted) in [(2400.0, 100.0), (400.0, 20.0), (30.0, 2.0), (0.0, 0.001)] {
            assert!((fitting_interval(100.0, 100.0 + range) / wanted - 1.0).abs() < 1e-9, "{range}");
        }
    }
}
