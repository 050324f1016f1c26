//! Which pages planes may touch, told from the coarse levels alone.
//!
//! ```text
//! for each wedge of neighbouring groups of planes:
//!     for each ring, as long as the blocks of lines that are read there, nearest first:
//!         its highest surface lies below the horizon, and so did the last ring's → nothing of it is touched
//!         else its pages are needed, at every level that some plane may read there
//!         the lowest surface of each strip of it, a quarter as long, may raise the horizon
//! ```
//!
//! It is the march of [`super::march`] with bounds in place of heights: `low` lies below the surface that a plane will find, so the
//! horizon is never above its crest, and what this passes over the march passes over too. Rings begin and end where
//! blocks of the march do. What is read to know what to read are bounds of levels from 16 on, most of which the march needs too.

use std::collections::HashMap;

use glam::DVec3;

use super::march::MOST_VOXELS;
use super::{Field, PlaneGroup, Strides};
use crate::error::Result;
use crate::simd::LANES;
use crate::voxel::{BoundsView, Grid, HeightCode, PAGE_SIDE, PageId, PageNeeds, PagePart, PageSource, RADIX};

/// Groups of planes that are looked at together: one takes five thirds of the time, and names 4 to 6 % fewer bytes.
const WEDGE: usize = 2;

/// Lines before a ring that are read where a segment or a stride begins, and posts around it that interpolation takes.
const BEFORE: f64 = 5.0;
const AROUND: f64 = 2.0;
/// Those around it where a coarser level stands in.
const COARSER: f64 = 16.0;

/// Sides of a voxel that a strip must have for the march to read a line in it for sure.
const SURE: f64 = 9.0;

/// Collects parts of pages that planes may touch.
pub struct Footprint<'a> {
    source: &'a dyn PageSource,
    /// By level.
    sides: Vec<Sides>,
    heights: HeightCode,
    level_count: u8,
    strides: Strides,
    /// Height that no surface reaches, metres above the datum.
    ceiling: f64,
    /// Every ray that goes down meets the surface: no voxel of the area is empty.
    is_opaque: bool,
    /// By level, the last page whose bounds were looked at.
    bounds: Vec<Option<(PageId, Option<BoundsView<'a>>)>>,
    /// By level, the columns and rows of pages whose posts, and bounds, this wedge was found to need last, if all are there, and whether
    /// likely so.
    noted: Vec<[Option<Noted>; 2]>,
    /// What is needed, and where first; heights stand for all posts.
    parts: HashMap<PagePart, Place>,
    /// Wedges before this one.
    wedges: u32,
}

/// Columns and rows of pages, first and last, and whether they are likely to be touched.
type Noted = ([[u32; 2]; 2], bool);

/// Where a part of a page is needed first.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Likely nothing of it is touched.
    is_doubtful: bool,
    /// By which wedge.
    wedge: u32,
    /// At which ground distance, metres.
    distance: f64,
}

/// Slopes below which nothing is seen behind a ring, metres of height per unit of major distance.
#[derive(Debug, Clone, Copy)]
struct Horizon {
    /// That of the lowest surface that may be there.
    sure: f64,
    /// That of a surface in the middle between the lowest and the highest.
    likely: f64,
}

/// Whether something of a ring is seen.
#[derive(Debug, Clone, Copy)]
struct Sight {
    /// It may rise above the sure horizon.
    may_be: bool,
    /// And above the likely one.
    is_likely: bool,
}

/// Groups side by side.
struct Wedge {
    major: usize,
    forward: f64,
    /// Units across per unit of major distance, least and greatest.
    minor: [f64; 2],
    drop: [f64; 2],
    /// Ground distance per unit of major distance, metres.
    ground: [f64; 2],
    /// Major distances between which some plane lies over the area, and between which all do.
    over: [f64; 2],
    inner: [f64; 2],
    /// Metres of height per unit of major distance: below the lowest rows, and above the highest.
    slopes: [f64; 2],
    /// Major distance before which all rays are above the highest surface.
    begin: f64,
}

/// Voxels of a level.
#[derive(Debug, Clone, Copy)]
struct Sides {
    /// One over the side of a voxel, units.
    per_unit: f64,
    /// The last one along each axis.
    last: [u32; 2],
}

/// A stretch along the major axis, with all that lies across it between the outermost planes.
#[derive(Debug, Clone, Copy)]
struct Ring {
    /// Major distances.
    from: f64,
    to: f64,
    /// Units of the longest block in it.
    side: f64,
    /// Levels that some plane may read in it, finest and coarsest.
    levels: [u8; 2],
    /// Level of the bounds by which it is skipped.
    skip_level: u8,
}

/// Major distance of the next multiple of `side` behind another.
fn edge_after(eye: f64, forward: f64, side: f64, distance: f64) -> f64 {
    let here = (eye + forward * distance) / side;
    let end = if forward > 0.0 { here.floor() + 1.0 } else { here.ceil() - 1.0 };
    let edge = (end * side - eye) * forward;
    // Rounding may leave it where it was.
    if edge > distance { edge } else { distance + side }
}

impl<'a> Footprint<'a> {
    /// Of planes over `source` that read lines as far apart as `strides` says.
    pub fn new(source: &'a dyn PageSource, strides: Strides) -> Self {
        let header = source.header();
        Self {
            source,
            sides: (0..header.level_count).map(|level| Sides::new(&header.grid, level)).collect(),
            heights: header.heights,
            level_count: header.level_count,
            strides,
            ceiling: header.height_range.1 + header.heights.scale,
            is_opaque: header.metadata.empty_share == 0.0,
            bounds: vec![None; usize::from(header.level_count)],
            noted: vec![[None; 2]; usize::from(header.level_count)],
            parts: HashMap::new(),
            wedges: 0,
        }
    }

    /// Adds what groups of planes, neighbours in order, may touch from `eye` (units, units, metres).
    ///
    /// # Errors
    /// A page with bounds that is damaged.
    pub fn add(&mut self, eye: DVec3, groups: &[(PlaneGroup, Field)]) -> Result<()> {
        let is_same = |a: &(PlaneGroup, Field), b: &(PlaneGroup, Field)| {
            a.0.major == b.0.major && a.0.forward == b.0.forward
        };
        for side in groups.chunk_by(is_same) {
            for groups in side.chunks(WEDGE) {
                let wedge = Wedge::new(groups, self.ceiling - eye.z);
                self.sweep(eye, &wedge)?;
                self.wedges += 1;
            }
        }
        Ok(())
    }

    /// The parts of pages as planes come to them: those that are likely to be touched, then the others; of both wedge by wedge, and the nearest of
    /// each first.
    pub fn into_needs(self) -> PageNeeds {
        let mut parts: Vec<_> = self.parts.into_iter().collect();
        parts.sort_unstable_by(|(a, first), (b, second)| {
            let places = first.is_doubtful.cmp(&second.is_doubtful).then(first.wedge.cmp(&second.wedge));
            places.then(first.distance.total_cmp(&second.distance)).then(a.cmp(b))
        });
        let all_of = |part: PagePart| {
            let paint = matches!(part, PagePart::Heights(_)).then(|| PagePart::Paint(part.page()));
            [Some(part), paint].into_iter().flatten()
        };
        let (likely, others) = parts.split_at(parts.partition_point(|(_, place)| !place.is_doubtful));
        let [likely, others] = [likely, others].map(|parts| parts.iter().flat_map(|(part, _)| all_of(*part)));
        let mut parts: Vec<_> = likely.collect();
        let likely = parts.len();
        parts.extend(others);
        PageNeeds { parts, likely }
    }

    fn sweep(&mut self, eye: DVec3, wedge: &Wedge) -> Result<()> {
        let (nearest, farthest) = (wedge.over[0].max(wedge.begin), wedge.over[1]);
        let ceiling = self.ceiling - eye.z;
        let top = wedge.slopes[1];
        let mut horizon = Horizon { sure: wedge.slopes[0], likely: wedge.slopes[0] };
        let mut at = nearest;
        let mut before = Sight { may_be: true, is_likely: true };
        self.noted.fill([None; 2]);
        while at < farthest {
            if horizon.sure >= top || horizon.sure >= 0.0 && ceiling < horizon.sure * at {
                break;
            }
            let ring = self.ring(eye, wedge, at);
            let sight = self.sight(eye, wedge, &ring, horizon)?;
            for level in ring.levels[0]..=ring.levels[1] {
                // A segment that ends in a hidden block began before.
                if sight.may_be || before.may_be {
                    let own = self.part_of_level(wedge, &ring, level);
                    let is_likely = sight.is_likely || before.is_likely;
                    self.need(eye, wedge, &own, (level, PagePart::Heights, is_likely), [BEFORE, AROUND]);
                }
            }
            // Whose bounds the march looks at.
            for level in (ring.levels[0] + 2).min(ring.skip_level)..=ring.skip_level {
                self.need(eye, wedge, &ring, (level, PagePart::Bounds, true), [BEFORE, AROUND]);
            }
            before = sight;
            // What lies below the horizon does not raise it.
            if sight.may_be && self.is_opaque {
                horizon = self.raised(eye, wedge, &ring, horizon)?;
            }
            at = ring.to;
        }
        Ok(())
    }

    fn height(&self, code: u16) -> f64 {
        self.heights.offset + self.heights.scale * f64::from(code)
    }

    /// Whether something in a ring may rise above the horizon, and whether it is likely to, seen with the march's own bounds.
    fn sight(&mut self, eye: DVec3, wedge: &Wedge, ring: &Ring, horizon: Horizon) -> Result<Sight> {
        let unknown = Sight { may_be: true, is_likely: true };
        if ring.side > MOST_VOXELS as f64 * f64::from(Grid::side_units(ring.skip_level)) {
            return Ok(unknown);
        }
        let Some([_, high]) = self.bounds_over(eye, wedge, ring, ring.skip_level)? else {
            return Ok(unknown);
        };
        let z = self.height(high) - eye.z;
        let rises = |horizon: f64| {
            let above = |distance: f64| z - wedge.drop[0] * distance * distance >= horizon * distance;
            high != HeightCode::EMPTY && (above(ring.from) || above(ring.to))
        };
        Ok(Sight { may_be: rises(horizon.sure), is_likely: rises(horizon.likely) })
    }

    /// The horizon behind a ring: the lowest surface of each strip of some lines stands before it, and likely one in the middle between lowest and
    /// highest.
    fn raised(&mut self, eye: DVec3, wedge: &Wedge, ring: &Ring, horizon: Horizon) -> Result<Horizon> {
        let mut horizon = horizon;
        let level = (ring.levels[0] + 2).min(self.level_count - 1);
        let side = f64::from(Grid::side_units(level));
        let least = SURE * f64::from(Grid::side_units(ring.levels[1]));
        let mut from = ring.from;
        while from < ring.to {
            let to = edge_after(eye[wedge.major], wedge.forward, side, from).min(ring.to);
            let is_sure = to - from >= least && from >= wedge.inner[0] && to <= wedge.inner[1];
            let strip = Ring { from, to, ..*ring };
            if is_sure
                && let Some([low, high]) = self.bounds_over(eye, wedge, &strip, level)?
                && low != HeightCode::EMPTY
            {
                let slope = |height: f64| {
                    let z = height - eye.z - wedge.drop[1] * to * to;
                    (z / from.max(f64::MIN_POSITIVE)).min(z / to)
                };
                let [low, high] = [low, high].map(|code| self.height(code));
                horizon.sure = horizon.sure.max(slope(low));
                horizon.likely = horizon.likely.max(slope((low + high) / 2.0));
            }
            from = to;
        }
        Ok(horizon)
    }

    /// The ring that begins at a major distance; it may end beyond the area. It is as long as the longest block that some plane may read in it: one that is
    /// not hidden as a whole is read as a whole.
    fn ring(&self, eye: DVec3, wedge: &Wedge, at: f64) -> Ring {
        let index_at = |distance: f64, ground: f64| self.strides.index_at((distance * ground).max(0.0), 0);
        let length = |index: usize| self.strides.get(index).block_units();
        // The last block of a stride may reach beyond its distance.
        let farthest = index_at(at, wedge.ground[0]);
        let holds = |index: &usize| index_at(at - length(*index), wedge.ground[0]) <= *index;
        let first = (0..farthest).find(holds).unwrap_or(farthest);
        let mut last = first;
        loop {
            let strides = (first..=last).map(|index| self.strides.get(index));
            let side = (first..=last).map(length).fold(0.0, f64::max);
            let to = edge_after(eye[wedge.major], wedge.forward, side, at);
            let skip_level = strides.map(|stride| stride.skip_level()).max().unwrap_or(0);
            let levels = [first, last].map(|index| self.strides.get(index).level);
            let beyond = index_at(to, wedge.ground[1]);
            if beyond <= last {
                return Ring { from: at, to, side, levels, skip_level: skip_level.min(self.level_count - 1) };
            }
            last = beyond;
        }
    }

    /// What of a ring may be read at a level: others may be before and behind it.
    fn part_of_level(&self, wedge: &Wedge, ring: &Ring, level: u8) -> Ring {
        if ring.levels[0] == ring.levels[1] {
            return *ring;
        }
        let own = || self.strides.of_level(level);
        let begin = own().map(|(stride, _)| stride.from / wedge.ground[1]).fold(f64::INFINITY, f64::min);
        let end = own().map(|(stride, until)| until / wedge.ground[0] + stride.block_units());
        let (begin, end) = (begin.max(ring.from), end.fold(0.0, f64::max).min(ring.to));
        Ring { from: begin.min(end), to: end, ..*ring }
    }

    /// Voxels of `level`, first and last along each axis, of a ring, and of so many units before and around it.
    fn voxels(
        &self,
        eye: DVec3,
        wedge: &Wedge,
        ring: &Ring,
        level: u8,
        [before, around]: [f64; 2],
    ) -> [[u32; 2]; 2] {
        let Sides { per_unit, last } = self.sides[usize::from(level)];
        let Wedge { major, forward, minor: [low, high], .. } = *wedge;
        let along = [ring.from - before, ring.to + around].map(|distance| eye[major] + forward * distance);
        let across = eye[1 - major];
        let across = [
            across + (low * ring.from).min(low * ring.to) - around,
            across + (high * ring.from).max(high * ring.to) + around,
        ];
        let mut voxels = [[0; 2]; 2];
        let ends = [along[0].min(along[1]), along[0].max(along[1])];
        // What is negative becomes 0.
        let voxel = |unit: f64, axis: usize| ((unit * per_unit) as u32).min(last[axis]);
        voxels[major] = ends.map(|unit| voxel(unit, major));
        voxels[1 - major] = across.map(|unit| voxel(unit, 1 - major));
        voxels
    }

    /// Notes that a part of a ring's pages of a level is needed, or what stands in for it where pages are absent.
    fn need(
        &mut self,
        eye: DVec3,
        wedge: &Wedge,
        ring: &Ring,
        (level, part, is_likely): (u8, fn(PageId) -> PagePart, bool),
        margins: [f64; 2],
    ) {
        let is_posts = matches!(part(PageId { level, px: 0, py: 0 }), PagePart::Heights(_));
        let units = margins.map(|voxels| voxels * f64::from(Grid::side_units(level)));
        let [x, y] =
            self.voxels(eye, wedge, ring, level, units).map(|range| range.map(|voxel| voxel / PAGE_SIDE));
        let noted = [usize::from(level), usize::from(!is_posts)];
        // Nearer, since rings go outward.
        if let Some((known, was_likely)) = self.noted[noted[0]][noted[1]]
            && known == [x, y]
            && (was_likely || !is_likely)
        {
            return;
        }
        let place =
            Place { is_doubtful: !is_likely, wedge: self.wedges, distance: ring.from * wedge.ground[0] };
        let mut is_whole = true;
        for py in y[0]..=y[1] {
            for px in x[0]..=x[1] {
                let id = PageId { level, px, py };
                is_whole &= self.source.has(id);
                // Rings go outward: the first one is the nearest.
                let known = self.parts.entry(part(id)).or_insert(place);
                if known.is_doubtful && is_likely {
                    *known = place;
                }
            }
        }
        self.noted[noted[0]][noted[1]] = is_whole.then_some(([x, y], is_likely));
        if !is_whole {
            // Blocks there begin and end elsewhere, and are skipped by bounds of their own.
            self.need(eye, wedge, ring, (level + 1, part, is_likely), [COARSER; 2]);
            let last = self.level_count - 1;
            for level in ((level + 3).min(last)..=(level + 4).min(last)).filter(|_| is_posts) {
                self.need(eye, wedge, ring, (level, PagePart::Bounds, is_likely), [COARSER; 2]);
            }
        }
    }

    /// Least lower and greatest upper bound over a ring, of voxels of `level`; `None` where not all are known.
    fn bounds_over(&mut self, eye: DVec3, wedge: &Wedge, ring: &Ring, level: u8) -> Result<Option<[u16; 2]>> {
        let voxels = self.voxels(eye, wedge, ring, level, [0.0; 2]);
        self.bounds_of(level, voxels)
    }

    /// The same of voxels, first and last along each axis; of the coarser ones where their page is absent.
    fn bounds_of(&mut self, level: u8, [x, y]: [[u32; 2]; 2]) -> Result<Option<[u16; 2]>> {
        // No surface in some voxel: the lowest is lower than any.
        let mut bounds = [u16::MAX, u16::MIN];
        for py in y[0] / PAGE_SIDE..=y[1] / PAGE_SIDE {
            for px in x[0] / PAGE_SIDE..=x[1] / PAGE_SIDE {
                let part = [part_on_page(x, px), part_on_page(y, py)];
                let found = match self.bounds_page(PageId { level, px, py })? {
                    Some(view) => bounds_on_page(&view, part.map(|range| range.map(|at| at % PAGE_SIDE))),
                    None if level + 1 < self.level_count => {
                        self.bounds_of(level + 1, part.map(|range| range.map(|at| at / RADIX)))?
                    }
                    None => None,
                };
                let Some([low, high]) = found else { return Ok(None) };
                bounds = [bounds[0].min(low), bounds[1].max(high)];
            }
        }
        Ok(Some(bounds))
    }

    fn bounds_page(&mut self, id: PageId) -> Result<Option<BoundsView<'a>>> {
        let slot = &mut self.bounds[usize::from(id.level)];
        if let Some((known, view)) = slot
            && *known == id
        {
            return Ok(*view);
        }
        let view = self.source.bounds(id)?;
        *slot = Some((id, view));
        Ok(view)
    }
}

impl Sides {
    fn new(grid: &Grid, level: u8) -> Self {
        let (nx, ny) = grid.dims(level);
        Self { per_unit: 1.0 / f64::from(Grid::side_units(level)), last: [nx - 1, ny - 1] }
    }
}

/// What of a range of voxels, first and last, lies on a page.
fn part_on_page([first, last]: [u32; 2], page: u32) -> [u32; 2] {
    [first.max(page * PAGE_SIDE), last.min(page * PAGE_SIDE + PAGE_SIDE - 1)]
}

/// Least lower and greatest upper bound of voxels of a page, first and last along each axis; `None` where there are none.
fn bounds_on_page(view: &BoundsView<'_>, [x, y]: [[u32; 2]; 2]) -> Option<[u16; 2]> {
    let mut bounds = [u16::MAX, u16::MIN];
    for row in y[0]..=y[1] {
        let row = (row * view.width + x[0]) as usize..=(row * view.width + x[1]) as usize;
        let (low, high) = (view.low.get(row.clone())?, view.high.get(row)?);
        bounds[0] = low.iter().fold(bounds[0], |least, code| least.min(*code));
        bounds[1] = high.iter().fold(bounds[1], |most, code| most.max(*code));
    }
    Some(bounds)
}

impl Wedge {
    /// `ceiling`: height of the highest surface, metres above the eye.
    fn new(groups: &[(PlaneGroup, Field)], ceiling: f64) -> Self {
        let extremes = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        };
        let lanes = |of: &dyn Fn(&PlaneGroup) -> [f32; LANES]| {
            extremes(&mut groups.iter().flat_map(|(group, _)| of(group)).map(f64::from))
        };
        let enter = lanes(&|group| group.over[0]);
        let leave = lanes(&|group| group.over[1]);
        let slopes = groups.iter().flat_map(|(group, field)| {
            group.depth.map(|depth| field.tangents.map(|tangent| f64::from(tangent) * f64::from(depth)))
        });
        let slopes = slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [least, most]| {
            [low.min(least), high.max(most)]
        });
        let begin = groups.iter().map(|(group, field)| f64::from(field.begin(group, ceiling)));
        let first = &groups[0].0;
        Self {
            major: first.major,
            forward: first.forward,
            minor: lanes(&|group| group.minor),
            drop: lanes(&|group| group.drop),
            ground: extremes(&mut groups.iter().map(|(group, _)| group.ground)),
            over: [enter[0], leave[1]],
            inner: [enter[1], leave[0]],
            slopes,
            begin: begin.fold(f64::INFINITY, f64::min),
        }
    }
}
