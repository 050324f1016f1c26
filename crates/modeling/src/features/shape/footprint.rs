//! Polygons over voxels: how much of each they cover, and by which straight wall that is said best.
//!
//! ```text
//! for each row of voxels: clip the rings to it
//!   for each voxel of the row: clip them to it; covered = area of what is left
//!     no edge in its columns: whole or none, by how often the rings go around it
//!     all or nothing covered: whole or none
//!     one edge within: that edge is the wall, exactly
//!     several: of the planes along each edge, of those that keep the covered area (along each edge, and along all of them
//!              together), and of what two edges bound together, the one with the least difference of areas to what is covered
//! ```
//! Clipping after Sutherland and Hodgman (1974). It leaves edges along the border that cancel in areas, so that rings of any form,
//! touching themselves or with holes, need nothing more.

use std::ops::Range;

use glam::{DVec2, dvec2};

use super::super::layer::{Area, bounds};
use super::super::read::rings::{doubled_area, is_inside};
use super::patch::{ConvexPatch, HalfPlane};
use super::solid::{Square, Wall};
use hedgehop::voxel::Cut;

/// A polygon in the database's system.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Footprint {
    /// Outsides counter-clockwise, holes clockwise.
    pub rings: Vec<Vec<DVec2>>,
    pub bounds: [f64; 4],
}

/// Part of a voxel that a polygon covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VoxelCover {
    pub column: usize,
    pub row: usize,
    /// Share of the voxel, above 0…1.
    pub share: f64,
    /// The wall that says it best.
    pub wall: Wall,
}

/// Steps of shares, and of distances of walls in voxels: far above what rounding takes, which depends on where places are counted from.
const STEPS: f64 = (1 << 20) as f64;
/// Shares below this are nothing: what is left out where a wall comes into a voxel is thinner than where walls of
/// neighbours are told apart, or the neighbour's side would show.
const LEAST: f64 = 1.0 / 4096.0;
/// Edges of one voxel that are tried as walls: the longest of them.
const MOST_TRIED: usize = 4;
/// Share of a voxel by which two walls must be nearer than one to what is covered.
const BETTER: f64 = 1e-4;

impl Footprint {
    /// The outline of an area; `None` if it encloses nothing.
    pub fn of(area: &Area) -> Option<Self> {
        let mut rings = vec![turned(&area.outer.places, true)?];
        rings.extend(area.holes.iter().filter_map(|hole| turned(&hole.places, false)));
        let bounds = bounds(rings[0].iter().copied())?;
        Some(Self { rings, bounds })
    }

    /// A circle, of so many corners that they are no farther than `error` (metres) from it.
    pub fn circle(centre: DVec2, radius: f64, error: f64) -> Self {
        let step = 2.0 * (1.0 - (error / radius).clamp(1e-4, 0.5)).acos();
        let count = (std::f64::consts::TAU / step).ceil().max(8.0);
        let corner = |index: f64| centre + DVec2::from_angle(std::f64::consts::TAU * index / count) * radius;
        let ring = (0..count as usize).map(|index| corner(index as f64)).collect();
        let reach = DVec2::splat(radius);
        let (low, high) = (centre - reach, centre + reach);
        Self { rings: vec![ring], bounds: [low.x, low.y, high.x, high.y] }
    }

    /// Whether a place lies within.
    pub fn holds(&self, place: DVec2) -> bool {
        self.rings.iter().filter(|ring| is_inside(ring, place)).count() % 2 == 1
    }

    /// Area, square metres.
    pub fn area(&self) -> f64 {
        0.5 * self.rings.iter().map(|ring| doubled_area(ring)).sum::<f64>()
    }

    /// All edges, with the inside to their left.
    pub fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        self.rings.iter().flat_map(|ring| ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)))
    }

    /// Places along the outline, `step` metres apart or closer, `most` at the most.
    pub fn outline(&self, step: f64, most: usize) -> Vec<DVec2> {
        let length: f64 = self.edges().map(|(a, b)| a.distance(b)).sum();
        let step = step.max(length / most.max(1) as f64);
        let along = |(a, b): (DVec2, DVec2)| {
            let parts = (a.distance(b) / step).ceil().clamp(1.0, most as f64) as usize;
            (0..parts).map(move |part| a.lerp(b, part as f64 / parts as f64))
        };
        self.edges().flat_map(along).collect()
    }

    /// Finds what it covers of each voxel that it touches.
    pub fn cover(&self, square: &Square) -> Vec<VoxelCover> {
        self.cover_within(square, 0.0)
    }

    /// The same, with the walls of voxels, too, that one passes so near by that it seems to be theirs: voxels beside them show their corners by as
    /// much as walls are rounded. Where a corner points inward a voxel comes twice, with each of its walls.
    pub fn cover_with_walls(&self, square: &Square) -> Vec<VoxelCover> {
        self.cover_within(square, Cut::BESIDE)
    }

    fn cover_within(&self, square: &Square, margin: f64) -> Vec<VoxelCover> {
        let (columns, rows) = square.touched(self.bounds);
        // In voxels from the square's corner, so that clipping is against whole numbers.
        let local = |place: &DVec2| square.local(*place);
        let rings: Vec<Vec<DVec2>> =
            self.rings.iter().map(|ring| ring.iter().map(local).collect::<Vec<_>>()).collect();
        let mut covers = Vec::new();
        let part = FootprintPart { columns, rows, margin, spacing: square.spacing };
        part.cover(&rings, &mut covers);
        // Parts of a large one are done one by one.
        covers.sort_by_key(|cover| (cover.row, cover.column));
        covers
    }
}

/// Corners of what lies in a part, above which it is done in two halves: each row and each voxel looks at all of them.
const MOST_CORNERS: usize = 512;

/// Some of the voxels that a polygon touches.
struct FootprintPart {
    columns: Range<usize>,
    rows: Range<usize>,
    /// Distance beside a voxel at which walls count, voxels.
    margin: f64,
    /// Side of a voxel, metres.
    spacing: f64,
}

impl FootprintPart {
    /// Finds what rings, in voxels, cover of each voxel, row by row.
    fn cover(&self, rings: &[Vec<DVec2>], covers: &mut Vec<VoxelCover>) {
        let Self { columns, rows, margin, spacing } = self;
        let (margin, spacing) = (*margin, *spacing);
        let low = dvec2(columns.start as f64, rows.start as f64);
        let high = dvec2(columns.end as f64, rows.end as f64);
        let near: Vec<Vec<DVec2>> =
            rings.iter().map(|ring| clipped(ring, low - margin, high + margin)).collect();
        let corners: usize = near.iter().map(Vec::len).sum();
        if corners > MOST_CORNERS && columns.len().max(rows.len()) > 1 {
            self.halves().iter().for_each(|half| half.cover(&near, covers));
            return;
        }

        for row in rows.clone() {
            let (bottom, top) = (row as f64, row as f64 + 1.0);
            let band = clip_all(&near, dvec2(low.x, bottom), dvec2(high.x, top));
            let Some([west, _, east, _]) = bounds(band.iter().flatten().copied()) else { continue };
            let beside =
                if margin > 0.0 { Beside::new(&near, [bottom, top], margin) } else { Beside::default() };
            let crossing = crossing(&band, bottom, top);
            let first = (west.floor().max(low.x) as usize).min(columns.end);

            for column in first..(east.ceil().max(0.0) as usize).min(columns.end) {
                let left = column as f64;
                let centre = dvec2(left + 0.5, bottom + 0.5);
                if !crossing.iter().any(|(from, to)| *from < left + 1.0 && *to > left) {
                    if windings(&band, centre) > 0 {
                        let wall = beside.wall(centre, spacing).unwrap_or(Wall::Whole);
                        covers.push(VoxelCover { column, row, share: 1.0, wall });
                    }
                    continue;
                }

                let rings = clip_all(&band, dvec2(left, bottom), dvec2(left + 1.0, top));
                let covered = Covered { rings: &rings, centre, half: 0.5 };
                let Some((share, wall)) = covered.wall(spacing) else { continue };

                // Where no edge crosses the voxel but by rounding, one may still lie along its border.
                let wall = match wall {
                    Wall::Whole => beside.wall(centre, spacing).unwrap_or(Wall::Whole),
                    wall => wall,
                };

                match covered.inward_corner(share, spacing).filter(|_| margin > 0.0) {
                    // What two walls bound one by one.
                    Some(walls) => covers.extend(walls.map(|wall| VoxelCover { column, row, share, wall })),
                    None => covers.push(VoxelCover { column, row, share, wall }),
                }
            }
        }
    }

    /// Two parts, divided across the longer side.
    fn halves(&self) -> [Self; 2] {
        let Self { columns, rows, margin, spacing } = self;
        let split = |range: &Range<usize>| {
            let middle = range.start.midpoint(range.end);
            [range.start..middle, middle..range.end]
        };

        match columns.len() >= rows.len() {
            true => split(columns).map(|columns| Self {
                columns,
                rows: rows.clone(),
                margin: *margin,
                spacing: *spacing,
            }),
            false => split(rows).map(|rows| Self {
                columns: columns.clone(),
                rows,
                margin: *margin,
                spacing: *spacing,
            }),
        }
    }
}

/// Distance by which a wall along a voxel's border may reach into it by rounding, voxels.
const BY_ROUNDING: f64 = 1e-6;

/// Edges in and beside a row of voxels; all in voxels.
#[derive(Default)]
struct Beside {
    rings: Vec<Vec<DVec2>>,
    /// Extent of each edge eastward.
    crossing: Vec<(f64, f64)>,
    /// Distance beside a voxel at which they count.
    margin: f64,
}

impl Beside {
    fn new(near: &[Vec<DVec2>], [bottom, top]: [f64; 2], margin: f64) -> Self {
        let (bottom, top) = (bottom - margin, top + margin);
        let far = f64::INFINITY;
        let rings = clip_all(near, dvec2(-far, bottom), dvec2(far, top));
        let crossing = crossing(&rings, bottom, top);
        Self { rings, crossing, margin }
    }

    /// The nearest walls that pass beside a voxel of which all is covered, two at most.
    fn wall(&self, centre: DVec2, spacing: f64) -> Option<Wall> {
        let half = 0.5 + self.margin;
        let (left, right) = (centre.x - half, centre.x + half);
        if !self.crossing.iter().any(|(from, to)| *from < right && *to > left) {
            return None;
        }

        let rings = clip_all(&self.rings, centre - half, centre + half);
        let mut edges = Covered { rings: &rings, centre, half }.edges();

        // Beyond its end, where a corner points inward, a wall's line may run through the voxel, and leaves none of it out.
        edges.retain(|(_, normal, distance)| *distance >= 0.5 * normal.abs().element_sum() - BY_ROUNDING);
        edges.sort_by(|a, b| a.2.total_cmp(&b.2));

        // Whichever page asks.
        let kept = |distance: f64| (distance * STEPS).round() / STEPS * spacing;
        match edges[..] {
            [] => None,
            [(_, normal, distance)] => Some(Wall::plane(normal, kept(distance))),
            [(_, one, near), (_, other, far), ..] => {
                Some(Wall::Corner([(one.to_angle(), kept(near)), (other.to_angle(), kept(far))]))
            }
        }
    }
}

/// A ring that runs counter-clockwise or clockwise, without places that follow on themselves.
fn turned(ring: &[DVec2], counter_clockwise: bool) -> Option<Vec<DVec2>> {
    let mut places = ring.to_vec();
    places.dedup();
    while places.len() > 1 && places.first() == places.last() {
        places.pop();
    }
    let area = doubled_area(&places);
    if places.len() < 3 || area == 0.0 || !area.is_finite() {
        return None;
    }
    if (area > 0.0) != counter_clockwise {
        places.reverse();
    }
    Some(places)
}

/// Finds the extent of each edge within a row of voxels; those along its border cross no voxel.
fn crossing(band: &[Vec<DVec2>], bottom: f64, top: f64) -> Vec<(f64, f64)> {
    let edges = band.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    let inside = edges.filter(|(a, b)| a.y != b.y || (a.y != bottom && a.y != top));
    inside.map(|(a, b)| (a.x.min(b.x), a.x.max(b.x))).collect()
}

/// Counts how often rings go around a place, counter-clockwise: what areas count, too.
fn windings(rings: &[Vec<DVec2>], place: DVec2) -> i32 {
    let edges = rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    let crosses = |(a, b): (&DVec2, &DVec2)| {
        let is_east = place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x);
        match ((a.y > place.y) != (b.y > place.y) && is_east, b.y > a.y) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => -1,
        }
    };
    edges.map(crosses).sum()
}

pub(super) fn clip_all(rings: &[Vec<DVec2>], low: DVec2, high: DVec2) -> Vec<Vec<DVec2>> {
    rings.iter().map(|ring| clipped(ring, low, high)).filter(|ring| ring.len() > 2).collect()
}

/// Clips a ring to a box.
fn clipped(ring: &[DVec2], low: DVec2, high: DVec2) -> Vec<DVec2> {
    let ring = clip(ring, |place| place.x - low.x);
    let ring = clip(&ring, |place| high.x - place.x);
    let ring = clip(&ring, |place| place.y - low.y);
    clip(&ring, |place| high.y - place.y)
}

/// Clips a ring to where its distance is 0 and more.
pub(super) fn clip(ring: &[DVec2], distance: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(ring.len() + 4);
    let Some(&last) = ring.last() else { return kept };
    let (mut before, mut was) = (last, distance(last));
    for &place in ring {
        let is = distance(place);
        if (is >= 0.0) != (was >= 0.0) {
            kept.push(before.lerp(place, was / (was - is)));
        }
        if is >= 0.0 {
            kept.push(place);
        }
        (before, was) = (place, is);
    }
    kept
}

/// Part of one voxel that is covered, in voxels.
struct Covered<'r> {
    rings: &'r [Vec<DVec2>],
    centre: DVec2,
    /// Half of its side: more than a half of one with what lies beside it.
    half: f64,
}

impl Covered<'_> {
    fn area(rings: &[Vec<DVec2>]) -> f64 {
        0.5 * rings.iter().map(|ring| doubled_area(ring)).sum::<f64>()
    }

    /// Share and wall; `None` if next to nothing is covered.
    fn wall(&self, spacing: f64) -> Option<(f64, Wall)> {
        // Maps with whole metres have edges through centres of voxels: half a voxel is half of one, whichever page asks.
        let share = (Self::area(self.rings) * STEPS).round() / STEPS;
        let share = share.clamp(0.0, 1.0);
        if share < LEAST {
            return None;
        }

        let mut edges = self.edges();
        if edges.is_empty() {
            return Some((1.0, Wall::Whole));
        }

        edges.sort_by(|a, b| b.0.total_cmp(&a.0));
        let sum: DVec2 = edges.iter().map(|(length, normal, _)| *normal * *length).sum();
        let mut tried = Vec::new();
        for (_, normal, distance) in edges.iter().take(MOST_TRIED) {
            tried.push(HalfPlane { normal: *normal, distance: *distance });
            if edges.len() > 1 {
                tried.push(HalfPlane { normal: *normal, distance: distance_of_share(*normal, share) });
            }
        }

        if let (true, Some(normal)) = (edges.len() > 1, sum.try_normalize()) {
            tried.push(HalfPlane { normal, distance: distance_of_share(normal, share) });
        }
        let error = |half: &HalfPlane| self.error(&[*half], share);
        let best = tried.iter().min_by(|a, b| error(a).total_cmp(&error(b)))?;
        let longest = edges
            .iter()
            .take(MOST_TRIED)
            .map(|(_, normal, distance)| HalfPlane { normal: *normal, distance: *distance });
        let pairs = longest
            .clone()
            .enumerate()
            .flat_map(|(at, one)| longest.clone().skip(at + 1).map(move |other| [one, other]));
        let two = pairs.min_by(|a, b| self.error(a, share).total_cmp(&self.error(b, share)));

        // A wall through the centre holds it, whichever page asks: that decides on the surface there.
        let kept = |distance: f64| (distance * STEPS).round() / STEPS * spacing;
        match two.filter(|two| self.error(two, share) + BETTER < error(best)) {
            Some(two) => Some((share, Wall::Corner(two.map(|half| (half.facing(), kept(half.distance)))))),
            None => Some((share, Wall::plane(best.normal, kept(best.distance)))),
        }
    }

    /// The two walls of a corner that points inward, if nothing else bounds what is covered: either of them, all of which lies within one.
    fn inward_corner(&self, share: f64, spacing: f64) -> Option<[Wall; 2]> {
        let [(_, one, near), (_, other, far)] = self.edges()[..] else { return None };
        let beyond = [(-one, -near), (-other, -far)].map(|(normal, distance)| HalfPlane { normal, distance });
        let left_out = ConvexPatch::voxel(1.0).within_all(beyond.iter().enumerate()).area();
        let walls =
            [(one, near), (other, far)].map(|(normal, distance)| Wall::plane(normal, distance * spacing));
        let within = beyond.map(|half| HalfPlane { normal: -half.normal, distance: -half.distance });
        let common = ConvexPatch::voxel(1.0).within_all(within.iter().enumerate()).area();
        // Walls that are nearly one leave the same, whichever way the corner points.
        let is_inward = (1.0 - left_out - share).abs() < BETTER && (common - share).abs() >= BETTER;
        is_inward.then_some(walls)
    }

    /// Length, outward normal and distance from the centre of each edge that is not the voxel's own border.
    fn edges(&self) -> Vec<(f64, DVec2, f64)> {
        /// Size of what clipping leaves beside the border, voxels.
        const SLACK: f64 = 1e-9;

        let on_border = |a: DVec2, b: DVec2| {
            let (a, b) = (a - self.centre, b - self.centre);
            let (same, far) = ((a - b).abs(), (a.abs() - self.half).abs());
            (same.x < SLACK && far.x < SLACK) || (same.y < SLACK && far.y < SLACK)
        };
        let pairs = self.rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let mut edges: Vec<(f64, DVec2, f64)> = Vec::new();

        for (&a, &b) in pairs {
            let Some(along) = (b - a).try_normalize() else { continue };
            if on_border(a, b) {
                continue;
            }

            let normal = dvec2(along.y, -along.x);
            let (length, distance) = (a.distance(b), normal.dot(a - self.centre));

            // Parts of one straight edge count as one.
            let same = |edge: &&mut (f64, DVec2, f64)| {
                edge.1.distance(normal) < 1e-6 && (edge.2 - distance).abs() < 1e-6
            };
            match edges.iter_mut().find(same) {
                Some(edge) => edge.0 += length,
                None => edges.push((length, normal, distance)),
            }
        }

        edges
    }

    /// Area in which what is covered and what walls leave differ.
    fn error(&self, walls: &[HalfPlane], share: f64) -> f64 {
        let within = |ring: &[DVec2]| {
            let mut ring = ring.to_vec();
            for HalfPlane { normal, distance } in walls {
                ring = clip(&ring, |place| distance - normal.dot(place - self.centre));
            }
            ring
        };
        let both: Vec<Vec<DVec2>> = self.rings.iter().map(|ring| within(ring)).collect();
        let left = ConvexPatch::voxel(1.0).within_all(walls.iter().enumerate()).area();
        share + left - 2.0 * Self::area(&both)
    }
}

/// Share of a voxel on the inner side of a plane at a distance from its centre, voxels.
pub(super) fn share_of(normal: DVec2, distance: f64) -> f64 {
    ConvexPatch::voxel(1.0).within(&HalfPlane { normal, distance }, 0).area()
}

/// The distance of [`share_of`], by halving: the share grows with it.
fn distance_of_share(normal: DVec2, share: f64) -> f64 {
    let reach = 0.5 * (normal.x.abs() + normal.y.abs());
    let (mut low, mut high) = (-reach, reach);
    // Finer than a step of a cut by far.
    for _ in 0..16 {
        let middle = low.midpoint(high);
        if share_of(normal, middle) < share { low = middle } else { high = middle }
    }
    low.midpoint(high)
}
