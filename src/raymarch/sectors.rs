//! Upper bounds of the floating horizon in narrow sectors about an eye.
//!
//! ```text
//! for each ring of ground distance, from the eye outward:
//!     tangent[ring] = highest tangent of what lies in the sector's part of the ring
//!     highest[ring] = max(highest[ring before], tangent[ring])
//!
//! a ray of tangent t marches through rings with tangent[ring] ≥ t, from the first one with highest[ring] ≥ t on
//! ```
//!
//! Rays of one sector share this table, whatever their elevation: each marches where it may meet something, not from the eye.
//! Heights are those of the stored bounds (maximum mipmaps: Tevs, Ihrke and Seidel, 2008), of bare ground its posts', of what
//! stands its voxels', so that a ray meets what it would meet without the table. A sector is looked at when a ray first asks for it.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use super::Lattice;
use super::blocks::{OwnBlocks, corner_on_page};
use super::walk::Extent;
use super::{GridRay, LevelBands, PageCursor};
use crate::detail::Displacement;
use crate::earth::Curvature;
use crate::space::{Camera, Footprint};
use crate::voxel::{BLOCK_SIDE, Grid, HeightCode};
use hedgehop_base::error::Result;

/// Pixels across a sector, about.
const PIXELS: f64 = 2.0;

/// Fewest and most sectors of a quarter of a turn.
const LEAST_SECTORS: f64 = 8.0;
const MOST_SECTORS: f64 = 8192.0;

/// Depth of rings: units at least, and share of their distance.
const LEAST_DEPTH: f64 = 3.0;
const DEPTH_PER_DISTANCE: f64 = 1.0 / 96.0;

/// Depth of parts of rings of which posts are looked at together, units.
const POSTS_TOGETHER: f64 = 2.0;

/// Room about a sector's parts for what rounding takes: units, and for each unit of distance.
const ROOM: f64 = 1.0e-6;
const ROOM_PER_UNIT: f64 = 1.0e-9;

/// Sides of a cell before and behind a ring at which a march through it begins and ends: one that lies in two rings is passed whole.
const BESIDE: f64 = 1.5;

// No voxel of one stretch reaches into the next one, behind a ring at least: what stands is met once.
const _: () = assert!(LEAST_DEPTH >= 2.0 * BESIDE);

/// Rings up or down that a ray's first one is looked for, from that of the ray beside it.
const MOST_RINGS: usize = 8;

/// Places of the screen, along each side of it, of which the highest tangent is that of the view.
const PLACES: u32 = 9;

/// Upper bounds of the floating horizon about an eye, by sector and ground distance.
pub struct SectorHorizons {
    /// The eye: units, units, metres.
    eye: DVec3,
    grid: Grid,
    bands: LevelBands,
    /// Fall of the ground per square of the distance in units, metres.
    fall: f64,
    /// Ground distances at which rings begin, units; the last one's end.
    rings: Vec<f64>,
    /// Tangent above which rays are of no interest, metres per unit.
    top: f64,
    per_quarter: usize,
    sectors: Box<[OnceLock<Sector>]>,
    displacement: Option<Displacement>,
}

/// Bounds of one sector.
struct Sector {
    ground: Envelope,
    standing: Envelope,
}

/// Greatest tangents of what lies in rings.
#[derive(Default)]
struct Envelope {
    /// Tangent of each ring, metres per unit.
    tangents: Vec<f32>,
    /// Greatest tangent of each ring and those nearer.
    highest: Vec<f32>,
    /// Distance before and behind each ring at which a march through it begins and ends, units.
    room: Vec<f32>,
    /// Room before what lies beyond the last ring, units; `None`: nothing does.
    beyond: Option<f32>,
}

/// Readers of the database, for the bounds of a sector.
pub(super) struct SectorLook<'l, 'a> {
    /// The surface, and bare ground.
    pub surface: &'l mut PageCursor<'a>,
    pub bare: &'l mut PageCursor<'a>,
    /// Blocks of what stands on bare ground; `None`: nothing does.
    pub blocks: Option<&'l mut OwnBlocks<'a>>,
}

/// Part of a sector between two ground distances, as a rectangle of the area.
struct SectorPart {
    /// Units.
    reach: [f64; 2],
    low: DVec2,
    high: DVec2,
}

/// Bounds of one ray's sector.
#[derive(Clone, Copy)]
pub(super) struct RayHorizon<'h> {
    rings: &'h [f64],
    sector: &'h Sector,
    /// Metres per unit.
    tangent: f32,
    /// Units of ground distance per metre of range.
    per_range: f64,
    /// First rings in which the ray may meet the ground, and what stands.
    first: [usize; 2],
}

impl RayHorizon<'_> {
    /// Whether the ray surely meets nothing that stands, up to a range in metres.
    pub fn is_free_of_standing(&self, range: f64) -> bool {
        let standing = &self.sector.standing;
        let from = standing.begins(self.first[1], self.rings);
        range * self.per_range <= from.unwrap_or(f64::INFINITY)
    }

    /// Iterates over stretches of the ray before `until` in which it may meet the ground, ranges in metres, nearest first.
    pub fn of_ground(&self, until: f64) -> impl Iterator<Item = [f64; 2]> {
        self.stretches(&self.sector.ground, self.first[0], until)
    }

    /// Iterates over stretches of the ray in which it may meet something that stands, as of the ground.
    pub fn of_standing(&self, until: f64) -> impl Iterator<Item = [f64; 2]> {
        self.stretches(&self.sector.standing, self.first[1], until)
    }

    /// Iterates over runs of an envelope's rings whose bounds the ray does not clear, as ranges in metres.
    fn stretches<'e>(
        &'e self,
        envelope: &'e Envelope,
        first: usize,
        until: f64,
    ) -> impl Iterator<Item = [f64; 2]> + use<'e> {
        let Envelope { tangents, room, .. } = envelope;
        let Self { rings, tangent, per_range, .. } = *self;
        let until = until * per_range;
        let mut ring = first;
        let mut is_over = false;

        std::iter::from_fn(move || {
            while ring < tangents.len() && tangents[ring] < tangent {
                ring += 1;
                is_over |= envelope.begins(ring, rings).is_none_or(|begins| begins > until);
                if is_over {
                    return None;
                }
            }
            let from = envelope.begins(ring, rings).filter(|begins| !is_over && *begins <= until)?;
            ring = (ring + 1..tangents.len()).find(|at| tangents[*at] < tangent).unwrap_or(tangents.len());
            is_over = ring == tangents.len();
            // Nothing is known of what is farther.
            let end = match room.get(ring.wrapping_sub(1)) {
                Some(room) if !is_over || envelope.beyond.is_none() => rings[ring] + f64::from(*room),
                _ => f64::INFINITY,
            };
            Some([from, end].map(|at| at / per_range))
        })
    }
}

impl SectorHorizons {
    /// Horizons about the eye of `camera`, of which nothing is known yet; `None` where rays do not begin at one eye.
    pub fn new(grid: Grid, bands: LevelBands, curvature: Curvature, camera: &Camera) -> Option<Self> {
        let Footprint::Angle(pixel) = camera.footprint() else { return None };
        let ground = (camera.pose.eye.truncate() - grid.origin) / grid.spacing;
        let size = DVec2::new(f64::from(grid.nx), f64::from(grid.ny));
        let farthest = ground.abs().max((size - ground).abs()).length();

        let mut rings = vec![0.0];
        let mut last = 0.0;
        while last < farthest {
            last += LEAST_DEPTH.max(last * DEPTH_PER_DISTANCE);
            rings.push(last);
        }

        let per_quarter = (1.0 / (PIXELS * pixel)).clamp(LEAST_SECTORS, MOST_SECTORS) as usize;
        let place = |index: u32, count: u32| f64::from(index) / f64::from(PLACES - 1) * f64::from(count);
        let places = (0..PLACES * PLACES).filter_map(|index| {
            camera.ray(place(index % PLACES, camera.width), place(index / PLACES, camera.height))
        });
        let top = places.map(|ray| ray.direction.z / ray.direction.truncate().length() * grid.spacing);

        Some(Self {
            eye: ground.extend(camera.pose.eye.z),
            grid,
            bands,
            fall: curvature.drop_at(grid.spacing),
            rings,
            top: top.fold(f64::NEG_INFINITY, f64::max),
            per_quarter,
            sectors: (0..4 * per_quarter).map(|_| OnceLock::new()).collect(),
            displacement: None,
        })
    }

    /// The same over displaced ground.
    #[must_use]
    pub fn displaced(self, displacement: Option<&Displacement>) -> Self {
        Self { displacement: displacement.cloned(), ..self }
    }

    /// Returns a bound of how far ground is displaced at a ground distance (units) or beyond, metres.
    fn lift(&self, distance: f64) -> f64 {
        self.displacement.as_ref().map_or(0.0, |displacement| displacement.bound(distance))
    }

    /// Returns the eye: units, units, metres.
    pub(super) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Returns the bounds for a ray; `None` where there are none: of one from another eye, and straight up or down. What was found for a ray `beside` it is where
    /// to look first.
    ///
    /// # Errors
    /// A page that is damaged.
    pub(super) fn of_ray(
        &self,
        ray: &GridRay,
        beside: Option<&RayHorizon<'_>>,
        look: SectorLook<'_, '_>,
    ) -> Result<Option<RayHorizon<'_>>> {
        let ahead = ray.slope.truncate();
        let per_range = ahead.length();
        if per_range == 0.0 || ray.eye != self.eye {
            return Ok(None);
        }

        let index = (quarters(ahead) * self.per_quarter as f64) as usize % self.sectors.len();
        let known = &self.sectors[index];
        let sector = match known.get() {
            Some(sector) => sector,
            None => {
                let sector = self.look(index, look)?;
                known.get_or_init(|| sector)
            }
        };
        let tangent = (ray.slope.z / per_range) as f32;
        let beside = beside.map_or([0; 2], |beside| beside.first);
        let first = [sector.ground.first(tangent, beside[0]), sector.standing.first(tangent, beside[1])];
        Ok(Some(RayHorizon { rings: &self.rings, sector, tangent, per_range, first }))
    }

    /// Looks at all that lies in a sector.
    #[cold]
    fn look(&self, index: usize, look: SectorLook<'_, '_>) -> Result<Sector> {
        let SectorLook { surface, bare, blocks } = look;
        let ends = [index, index + 1].map(|end| direction(end as f64 / self.per_quarter as f64));
        let standing = blocks.map(|blocks| self.standing(ends, blocks, surface.source().header().heights));
        let ground = self.ground(ends, surface, bare)?;
        Ok(Sector { ground, standing: standing.transpose()?.unwrap_or_default() })
    }

    /// Finds the bounds of the ground between two directions: by its own posts where it is bare, and elsewhere by those that are stored.
    fn ground(
        &self,
        ends: [DVec2; 2],
        surface: &mut PageCursor<'_>,
        bare: &mut PageCursor<'_>,
    ) -> Result<Envelope> {
        let levels = surface.source().header().level_count;
        let bare_until = self.bands.bare_until() / self.grid.spacing;
        let mut envelope = Envelope::default();
        for ring in self.rings.windows(2) {
            let seen = self.bands.level_at(ring[1] * self.grid.spacing);
            let room = BESIDE * f64::from(Grid::side_units(seen));
            let mut highest = f64::NEG_INFINITY;

            if ring[1] <= bare_until {
                for part in self.parts(ends, [ring[0], ring[1]], POSTS_TOGETHER) {
                    let [[west, east], [south, north]] = part.span(&bare.cells(0));
                    if west <= east && south <= north {
                        let height = bare.highest_corner(0, [west, south], [east, north])?;
                        let height = height + self.lift(part.reach[0]);
                        highest = highest.max(self.tangent(height, part.reach));
                    }
                }
            } else {
                // The level that is seen there is bounded by coarser ones.
                let depth = ring[1] - ring[0];
                let fits = |level: &u8| f64::from(Grid::side_units(*level)) <= depth;
                let level = (seen + 1..levels).take_while(fits).last().unwrap_or(seen + 1);
                if level >= levels {
                    envelope.beyond = Some(room as f32);
                    break;
                }
                let lattice = surface.voxels(level);
                for part in self.parts(ends, [ring[0], ring[1]], lattice.side) {
                    for cell in part.cells(&lattice) {
                        let bound = surface.upper_bound(level, cell)? + self.lift(part.reach[0]);
                        highest = highest.max(self.tangent(bound, part.reach));
                    }
                }
            }

            if envelope.add(highest, room) >= self.top {
                envelope.beyond = Some(room as f32);
                break;
            }
        }

        Ok(envelope)
    }

    /// Finds the bounds of what stands between two directions, by voxels where a block holds something.
    fn standing(&self, ends: [DVec2; 2], blocks: &mut OwnBlocks<'_>, code: HeightCode) -> Result<Envelope> {
        let until = self.bands.bare_until() / self.grid.spacing;
        let coarser = self.bands.span_bands().iter().find(|band| band.shift > 0);
        // Of coarser cells nothing is said: their rays are followed.
        let voxels_until = coarser.map_or(f64::INFINITY, |band| band.start / self.grid.spacing);
        let voxels = blocks.voxels();
        let by_blocks = voxels.grouped(BLOCK_SIDE);
        let mut envelope = Envelope::default();
        for ring in self.rings.windows(2).take_while(|ring| ring[0] < until) {
            if ring[1] > voxels_until {
                envelope.beyond = Some(BESIDE as f32);
                break;
            }
            let mut stands = false;
            for part in self.parts(ends, [ring[0], ring[1]], by_blocks.side) {
                for block in part.cells(&by_blocks) {
                    let (_, view) = blocks.page(block)?;
                    let [x, y] = corner_on_page(block);
                    stands |= view.block(x, y).high > 0;
                }
            }

            let mut highest = f64::NEG_INFINITY;
            for part in self.parts(ends, [ring[0], ring[1]], 1.0).take_while(|_| stands) {
                for voxel in part.cells(&voxels) {
                    let top = blocks.top_at(voxel)?;
                    if top > 0.0 {
                        let height = code.offset + code.scale * f64::from(top);
                        highest = highest.max(self.tangent(height, part.reach));
                    }
                }
            }
            if envelope.add(highest, BESIDE) >= self.top {
                envelope.beyond = Some(BESIDE as f32);
                break;
            }
        }

        Ok(envelope)
    }

    /// Cuts a sector's part of a ring into parts no deeper than a cell, about.
    fn parts(&self, ends: [DVec2; 2], [near, far]: [f64; 2], side: f64) -> impl Iterator<Item = SectorPart> {
        let eye = self.eye.truncate();
        // An arc's height over its chord.
        let bulge = 0.125 * ends[0].distance_squared(ends[1]);
        let count = ((far - near) / side).ceil().max(1.0);
        (0..count as u32).map(move |part| {
            let reach = [0, 1].map(|end| near + (far - near) * f64::from(part + end) / count);
            let [[a, b], [c, d]] = ends.map(|end| reach.map(|at| eye + end * at));
            let room = ROOM + reach[1] * (ROOM_PER_UNIT + bulge);
            SectorPart { reach, low: a.min(b).min(c.min(d)) - room, high: a.max(b).max(c.max(d)) + room }
        })
    }

    /// Returns a bound of the tangents of what reaches up to a height (metres) between two ground distances in units, metres per unit.
    fn tangent(&self, height: f64, [near, far]: [f64; 2]) -> f64 {
        let above = height - self.eye.z;
        above / if above > 0.0 { near } else { far } - self.fall * near
    }
}

impl SectorPart {
    /// Returns the first and the last column and row of the cells of a lattice that it touches; beside the lattice there are none.
    fn span(&self, lattice: &Lattice) -> [[i64; 2]; 2] {
        [0, 1].map(|axis| {
            let Extent { first, last, .. } = lattice.spans[axis];
            let at = |units: f64| (units / lattice.side - lattice.shift).floor() as i64;
            [at(self.low[axis]).max(first), at(self.high[axis]).min(last)]
        })
    }

    /// Iterates over these cells.
    fn cells(&self, lattice: &Lattice) -> impl Iterator<Item = [i64; 2]> + use<> {
        let [[west, east], [south, north]] = self.span(lattice);
        (south..=north).flat_map(move |y| (west..=east).map(move |x| [x, y]))
    }
}

impl Envelope {
    /// Adds a ring with what is highest in it, and how far before and behind it marches through it go, units. Returns what is highest up to there.
    fn add(&mut self, tangent: f64, room: f64) -> f64 {
        // Rounded up, also if that of a ray is.
        let tangent = (tangent as f32).next_up();
        let highest = self.highest.last().map_or(tangent, |highest| highest.max(tangent));
        self.tangents.push(tangent);
        self.highest.push(highest);
        self.room.push(room as f32);
        highest.into()
    }

    /// Returns the first ring in which a ray of a tangent may meet something, or their number; it is looked for from a ring near it on.
    fn first(&self, tangent: f32, near: usize) -> usize {
        let mut ring = near.min(self.highest.len());
        for _ in 0..MOST_RINGS {
            let is_behind = self.highest.get(ring).is_none_or(|highest| *highest >= tangent);
            if !is_behind {
                ring += 1;
            } else if ring > 0 && self.highest[ring - 1] >= tangent {
                ring -= 1;
            } else {
                return ring;
            }
        }
        self.highest.partition_point(|highest| *highest < tangent)
    }

    /// Returns the ground distance at which a march through a ring begins, units; `None`: nothing is there.
    fn begins(&self, ring: usize, rings: &[f64]) -> Option<f64> {
        let room = self.room.get(ring).copied().or(self.beyond)?;
        Some((rings[ring] - f64::from(room)).max(0.0))
    }
}

/// Azimuth of a direction in quarters of a turn from east by north, 0…4: not an angle, but as monotone, and a division is all it takes.
fn quarters(direction: DVec2) -> f64 {
    let DVec2 { x, y } = direction;
    let (quarter, along, across) = match (x >= 0.0, y >= 0.0) {
        (true, true) => (0.0, x, y),
        (false, true) => (1.0, y, -x),
        (false, false) => (2.0, -x, -y),
        (true, false) => (3.0, -y, x),
    };
    quarter + across / (along + across)
}

/// Unit direction of an azimuth of [`quarters`].
fn direction(quarters: f64) -> DVec2 {
    let quarter = quarters.floor();
    let across = quarters - quarter;
    let along = 1.0 - across;
    let direction = match quarter as u32 % 4 {
        0 => DVec2::new(along, across),
        1 => DVec2::new(-across, along),
        2 => DVec2::new(-along, -across),
        _ => DVec2::new(across, -along),
    };
    direction.normalize()
}
