//! Vertical rays through a model: what they are inside of, and what of its steep faces lies over each voxel.
//!
//! Whether a ray passes a triangle is told by edge functions of corners in an order that does not depend on the triangle, so that of two
//! triangles with an edge between them each ray passes one.

use glam::{DVec2, DVec3, Vec3, dvec2};

use super::mask::{RAYS, place};
use super::soup::{Face, Inside, Soup};

/// Stretch of a ray inside a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub ray: u8,
    pub low: f64,
    pub high: f64,
    /// Face at its upper end.
    pub top: u32,
    /// Whether it is a sheet, and encloses nothing.
    pub is_sheet: bool,
}

/// Steep faces of about one direction over a voxel, without a gap between their heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Steep {
    /// Sum of normals by area, eastward and northward.
    pub normal: DVec2,
    /// Area as it is seen from beside, square metres.
    pub area: f64,
    /// Sum of how far they lie from the voxel's centre in the direction of their normal, metres, by area.
    pub distance: f64,
    pub low: f64,
    pub high: f64,
    /// Sum of linear colours, by area.
    pub colour: Vec3,
    /// Whether they are parts of sheets.
    pub is_sheet: bool,
    /// Number of their direction.
    pub bin: u8,
    /// Number of the material of one of them.
    pub material: u32,
}

/// All over a voxel.
#[derive(Debug, Default)]
pub(super) struct RayCell {
    crossings: Vec<Crossing>,
    /// Steep faces by direction; parts of a model that stand above each other have walls of their own.
    pub steep: Vec<Steep>,
    /// The same by material, too, whose faces may have gaps between their heights: windows of all storeys.
    pub sides: Vec<Steep>,
}

#[derive(Debug, Clone, Copy)]
struct Crossing {
    ray: u8,
    is_up: bool,
    piece: u32,
    face: u32,
    height: f64,
}

/// Directions that steep faces are sorted by.
const BINS: f64 = 64.0;
/// Sine of the angle from the vertical below which a face is steep.
const STEEP: f64 = 0.5;
/// Thickness of a sheet in voxels.
const SHEET: f64 = 0.25;
/// Gap that a ray does not see, in voxels.
const GAP: f64 = 0.1;

/// Some voxels of a lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayWindow {
    /// South-west corner, metres from the foot.
    pub corner: DVec2,
    pub spacing: f64,
    pub columns: usize,
    pub rows: usize,
}

impl RayWindow {
    fn centre(&self, column: usize, row: usize) -> DVec2 {
        self.corner + dvec2(column as f64 + 0.5, row as f64 + 0.5) * self.spacing
    }

    /// Columns and rows that a face may lie over.
    fn touched(&self, face: &Face) -> [(usize, usize); 2] {
        let [west, south, east, north] = face.bounds();
        let range = |low: f64, high: f64, from: f64, count: usize| {
            // Casts saturate.
            let first = ((low - from) / self.spacing).floor().max(0.0) as usize;
            let end = (((high - from) / self.spacing).floor() + 1.0).max(0.0) as usize;
            (first.min(count), end.min(count))
        };
        [range(west, east, self.corner.x, self.columns), range(south, north, self.corner.y, self.rows)]
    }

    /// Finds what some faces are over each voxel, row by row.
    pub fn look(&self, soup: &Soup, faces: impl Iterator<Item = u32>) -> Vec<RayCell> {
        let mut cells: Vec<RayCell> = Vec::new();
        cells.resize_with(self.columns * self.rows, RayCell::default);
        for number in faces {
            let face = &soup.faces[number as usize];
            let across = face.across();
            let rise = across.z / across.length();
            let [(west, east), (south, north)] = self.touched(face);

            for row in south..north {
                for column in west..east {
                    let cell = &mut cells[row * self.columns + column];
                    let centre = self.centre(column, row);
                    if rise != 0.0 {
                        self.cross(soup, number, centre, cell);
                    }
                    if rise.abs() < STEEP {
                        self.lean(soup, face, centre, cell);
                    }
                }
            }
        }

        cells.iter_mut().for_each(RayCell::gather_sides);
        cells
    }

    /// Rays of a voxel that pass a face.
    fn cross(&self, soup: &Soup, number: u32, centre: DVec2, cell: &mut RayCell) {
        let face = &soup.faces[number as usize];
        let [a, b, c] = face.corners.map(|corner| dvec2(corner.x, corner.y));
        let across = face.across();
        let is_masked = soup.materials[face.material as usize].cutoff;
        let edges = [(a, b), (b, c), (c, a)];

        for ray in 0..RAYS {
            let at = centre + place(ray) * self.spacing;
            let sides = edges.map(|(from, to)| is_left(from, to, at));
            if sides[0] != sides[1] || sides[1] != sides[2] || sides[0] != (across.z > 0.0) {
                continue;
            }
            let from = at - a;
            let height = face.corners[0].z - (across.x * from.x + across.y * from.y) / across.z;
            if let Some(least) = is_masked {
                let weights = face.weights(at.extend(height));
                if face.colour(&soup.materials, weights, 0.0).w < least {
                    continue;
                }
            }
            let is_up = across.z > 0.0;
            cell.crossings.push(Crossing { ray: ray as u8, is_up, piece: face.piece, face: number, height });
        }
    }

    /// The part of a steep face over a voxel.
    fn lean(&self, soup: &Soup, face: &Face, centre: DVec2, cell: &mut RayCell) {
        let half = 0.5 * self.spacing;
        let local = face.corners.map(|corner| corner - centre.extend(0.0));
        let mut polygon = local.to_vec();
        for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            polygon = clipped(&polygon, axis, sign, half);
        }

        let [first, rest @ ..] = &polygon[..] else { return };
        let across: DVec3 =
            rest.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum::<DVec3>() * 0.5;
        let flat = dvec2(across.x, across.y);
        let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
        let seen = face.colour(&soup.materials, face.weights(middle + centre.extend(0.0)), self.spacing);
        let is_masked = soup.materials[face.material as usize].cutoff.is_some();
        let area = flat.length() * if is_masked { f64::from(seen.w.clamp(0.0, 1.0)) } else { 1.0 };
        if area <= 0.0 || !area.is_finite() {
            return;
        }

        let normal = flat.normalize();
        let inside = soup.pieces[face.piece as usize];
        let is_inverted = matches!(
            inside,
            Inside::Winding { is_inverted: true } | Inside::Standing { is_inverted: true, .. }
        );
        let normal = if is_inverted { -normal } else { normal };
        let is_sheet = matches!(inside, Inside::Open);
        let turn = (normal.y.atan2(normal.x) / std::f64::consts::TAU * BINS).round().rem_euclid(BINS);
        let (low, high) = polygon.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
            (low.min(corner.z), high.max(corner.z))
        });

        let own = Steep {
            normal: normal * area,
            area,
            distance: normal.dot(dvec2(middle.x, middle.y)) * area,
            low,
            high,
            colour: seen.truncate() * area as f32,
            is_sheet,
            bin: turn as u8,
            material: face.material,
        };

        let gap = GAP * self.spacing;
        let key = |steep: &Steep| (steep.bin, steep.is_sheet);
        add(&mut cell.steep, own, gap, key);
        add(&mut cell.sides, own, gap, |steep| (key(steep), steep.material));
    }
}

/// Adds faces to those of the same key between whose heights and theirs is no wider gap, and joins what they bridge.
fn add<K: PartialEq>(all: &mut Vec<Steep>, own: Steep, gap: f64, key: impl Fn(&Steep) -> K) {
    let joins =
        |known: &Steep| key(known) == key(&own) && known.low <= own.high + gap && own.low <= known.high + gap;
    let Some(first) = all.iter().position(joins) else { return all.push(own) };
    all[first].add(&own);

    let mut index = first + 1;
    while index < all.len() {
        if joins(&all[index]) {
            let bridged = all.remove(index);
            all[first].add(&bridged);
        } else {
            index += 1;
        }
    }
}

impl Steep {
    fn add(&mut self, other: &Self) {
        self.normal += other.normal;
        self.area += other.area;
        self.distance += other.distance;
        self.colour += other.colour;
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
    }

    /// Length of them over the voxel, metres, as if they were as high everywhere.
    pub fn length(&self) -> f64 {
        self.area / (self.high - self.low).max(1e-9)
    }
}

/// Whether a place lies to the left of a line; one on it lies to the left of one of its two directions.
fn is_left(from: DVec2, to: DVec2, place: DVec2) -> bool {
    if (from.x, from.y) > (to.x, to.y) {
        return !is_left(to, from, place);
    }
    (to - from).perp_dot(place - from) >= 0.0
}

/// Clips a polygon to a distance from the centre along an axis, on one side.
fn clipped(polygon: &[DVec3], axis: usize, sign: f64, half: f64) -> Vec<DVec3> {
    let room = |corner: &DVec3| half - sign * corner[axis];
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, corner) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (here, there) = (room(corner), room(next));
        if here >= 0.0 {
            kept.push(*corner);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(corner.lerp(*next, here / (here - there)));
        }
    }
    kept
}

impl RayCell {
    /// Joins sides of one material that are parts of one wall.
    fn gather_sides(&mut self) {
        let walls = &self.steep;
        let wall_of = |side: &Steep| {
            walls.iter().position(|wall| {
                (wall.bin, wall.is_sheet) == (side.bin, side.is_sheet)
                    && wall.low <= side.low
                    && side.high <= wall.high
            })
        };

        let mut gathered: Vec<(Option<usize>, Steep)> = Vec::with_capacity(self.sides.len());
        for side in &self.sides {
            let wall = wall_of(side);
            let known =
                gathered.iter_mut().find(|(of, known)| *of == wall && known.material == side.material);
            match known {
                Some((_, known)) => known.add(side),
                None => gathered.push((wall, *side)),
            }
        }

        self.sides = gathered.into_iter().map(|(_, side)| side).collect();
    }

    /// Finds where each ray is inside, from below, ray by ray.
    pub fn stretches(&mut self, pieces: &[Inside], spacing: f64) -> Vec<Stretch> {
        self.crossings.sort_by(|a, b| {
            (a.ray, a.piece)
                .cmp(&(b.ray, b.piece))
                .then(a.height.total_cmp(&b.height))
                .then(a.face.cmp(&b.face))
        });
        let mut all = Vec::new();
        for of_piece in self.crossings.chunk_by(|a, b| (a.ray, a.piece) == (b.ray, b.piece)) {
            enclosed(of_piece, pieces[of_piece[0].piece as usize], SHEET * spacing, &mut all);
        }

        all.sort_by(|a, b| a.ray.cmp(&b.ray).then(a.low.total_cmp(&b.low)).then(a.high.total_cmp(&b.high)));
        let mut joined: Vec<Stretch> = Vec::with_capacity(all.len());
        for stretch in all {
            match joined.last_mut().filter(|last| last.ray == stretch.ray) {
                Some(last)
                    if stretch.low <= last.high + GAP * spacing && last.is_sheet == stretch.is_sheet =>
                {
                    if stretch.high > last.high {
                        (last.high, last.top) = (stretch.high, stretch.top);
                    }
                }
                // Sheets within solids are not seen.
                Some(last) if stretch.is_sheet && stretch.high <= last.high => {}
                _ => joined.push(stretch),
            }
        }

        joined
    }
}

/// Stretches of one ray in one piece.
fn enclosed(crossings: &[Crossing], inside: Inside, thickness: f64, all: &mut Vec<Stretch>) {
    let stretch = |low: f64, upper: &Crossing| Stretch {
        ray: upper.ray,
        low,
        high: upper.height,
        top: upper.face,
        is_sheet: false,
    };

    let sheet =
        |crossing: &Crossing| Stretch { is_sheet: true, ..stretch(crossing.height - thickness, crossing) };
    let (is_inverted, foot) = match inside {
        Inside::Open => return all.extend(crossings.iter().map(sheet)),
        Inside::Parity => {
            let pairs = crossings.chunks_exact(2);
            all.extend(pairs.remainder().iter().map(sheet));
            return all.extend(pairs.map(|pair| stretch(pair[0].height, &pair[1])));
        }
        Inside::Winding { is_inverted } => (is_inverted, None),
        Inside::Standing { is_inverted, foot } => (is_inverted, Some(foot)),
    };

    let mut entered: Vec<&Crossing> = Vec::new();
    let first = all.len();
    for crossing in crossings {
        if crossing.is_up == is_inverted {
            entered.push(crossing);
            continue;
        }

        match (entered.pop(), foot) {
            (Some(lower), _) => all.push(stretch(lower.height, crossing)),
            (None, Some(foot)) => {
                // All below it is within it.
                all.truncate(first);
                all.push(stretch(foot, crossing));
            }
            (None, None) => all.push(sheet(crossing)),
        }
    }

    all.extend(entered.into_iter().map(sheet));
}
