//! The march of one ray.

use glam::{DVec2, DVec3};

use super::displaced::DisplacedPatch;
use super::sectors::{RayHorizon, SectorLook};
use super::surface::{Patch, block_contact};
use super::walk::Lattice;
use super::{CellStep, CellWalk, GridRay, LevelBands, PageCursor, SectorHorizons, SolidHit, Solids, Surface};
use crate::detail::Displacement;
use crate::earth::Curvature;
use crate::voxel::{Grid, PageSource, RADIX};
use hedgehop_base::error::Result;

/// Contact of a ray with the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Range, metres, ≥ 0.
    pub range: f64,
    /// Level index of the surface.
    pub level: u8,
    /// Level index that was to be seen there; finer than `level` where its page is absent.
    pub wanted: u8,
    /// Normal of the voxel's face, for [`Surface::Blocks`].
    pub face: Option<DVec3>,
    /// Whether the surface is bare ground.
    pub bare: bool,
}

/// Marches rays through one database for one eye and field of view.
pub struct Marcher<'a> {
    cursor: PageCursor<'a>,
    /// The same on bare ground, and what stands on it.
    bare: PageCursor<'a>,
    solids: Option<Solids<'a>>,
    /// Ground distance up to which that is seen, metres.
    bare_until: f64,
    grid: Grid,
    /// Bands in which ground is seen, nearest first.
    bands: Vec<LevelBand>,
    surface: Surface,
    /// Voxels of level 1 eastward and northward.
    size: DVec2,
    /// Height that no surface reaches, metres above the datum.
    ceiling: f64,
    /// Index of the coarsest level.
    coarsest: u8,
    curvature: Curvature,
    /// Ground distance at which the search ends, metres: finite where the area repeats.
    far: f64,
    /// Bounds that tell where rays may begin, and those of the latest ray by its slope.
    horizons: Option<&'a SectorHorizons>,
    latest: Option<(DVec3, RayHorizon<'a>)>,
    /// Displacement of the smooth surface of the finest level.
    displacement: Option<&'a Displacement>,
}

/// Ground distance beyond which an area without end is not looked at, metres, whatever the air: from 10 km up
/// this is a third of a degree below the horizontal, if the Earth is flat.
const FARTHEST: f64 = 2.0e6;
/// The same in voxels of the coarsest level: a bound on the work where the area is tiny.
const MOST_VOXELS: f64 = 1.0e6;

/// Share of light behind what stands that counts as none.
const NOTHING_LEFT: f64 = 1.0 / 512.0;
/// Share at which what stands is what is seen.
const HALF: f64 = 0.5;

/// Voxels of a level along a way that are walked through without looking at coarser ones.
const FEW_VOXELS: f64 = 8.0;

/// Height above all posts of a cell from which on a ray does not meet its surface, metres: more than rounding takes.
const CLEAR: f64 = 1.0e-6;

/// Ground distances, metres, between which one level is seen.
#[derive(Debug, Clone, Copy)]
struct LevelBand {
    level: u8,
    bare: bool,
    start: f64,
    end: f64,
}

/// One ray's search for the surface of one level.
struct RaySearch<'r> {
    ray: &'r GridRay,
    level: u8,
    /// Whether bare ground alone is sought.
    bare: bool,
}

/// Heights at a cell's corners, metres, and the lattice that it belongs to.
struct SmoothCell<'l> {
    corners: [f64; 4],
    lattice: &'l Lattice,
}

/// Range at a ground distance, metres: a vertical ray stays at ground distance 0, in the first band, for ever.
fn range_at(ray: &GridRay, ground: f64) -> f64 {
    if ground == 0.0 { 0.0 } else { ground / ray.ground_cosine }
}

/// The bands of a database whose coarsest level is `coarsest`.
fn bands_of(bands: &LevelBands, coarsest: u8) -> Vec<LevelBand> {
    let bare_until = bands.bare_until();
    let mut found = Vec::new();
    for (level, start, end) in bands.iter() {
        let near = end.min(bare_until);
        if start < near {
            found.push(LevelBand { level: level.min(coarsest), bare: true, start, end: near });
        }
        if start.max(bare_until) < end {
            found.push(LevelBand {
                level: level.min(coarsest),
                bare: false,
                start: start.max(bare_until),
                end,
            });
        }
    }
    found
}

impl<'a> Marcher<'a> {
    /// A marcher over `source` that sees levels in `bands`; in place of those that `source` lacks it
    /// sees its coarsest.
    pub fn new(source: &'a dyn PageSource, bands: LevelBands, surface: Surface) -> Self {
        let header = source.header();
        let coarsest = header.level_count - 1;
        Self {
            cursor: PageCursor::new(source),
            bare: PageCursor::new(source).on_bare_ground(),
            solids: header
                .has_spans
                .then(|| Solids::new(&PageCursor::new(source)).in_bands(bands.span_bands())),
            bare_until: bands.bare_until(),
            grid: header.grid,
            bands: bands_of(&bands, coarsest),
            surface,
            size: DVec2::new(f64::from(header.grid.nx), f64::from(header.grid.ny)),
            // Codes are rounded, by half a step at most.
            ceiling: header.height_range.high + header.heights.scale,
            coarsest,
            curvature: Curvature::FLAT,
            far: f64::INFINITY,
            horizons: None,
            latest: None,
            displacement: None,
        }
    }

    /// The same over displaced ground, of a smooth surface that does not repeat.
    pub fn displaced(self, displacement: Option<&'a Displacement>) -> Self {
        let ceiling = self.ceiling + displacement.map_or(0.0, |displacement| displacement.bound(0.0));
        Self { displacement, ceiling, ..self }
    }

    /// The same with rays that begin where these horizons, of its own bands and curvature, let them meet something; they meet the same.
    pub fn beyond(self, horizons: Option<&'a SectorHorizons>) -> Self {
        Self { horizons, ..self }
    }

    /// The same over ground of this curvature.
    pub fn curved(self, curvature: Curvature) -> Self {
        Self { curvature, ..self }
    }

    /// The same over the area repeated without end. As a ray near the horizon may never meet the ground, it is
    /// followed no further than a ground distance of `far` metres, and in no case beyond 2000 km or a million
    /// voxels of the coarsest level.
    pub fn endless(self, far: f64) -> Self {
        let side = f64::from(Grid::side_units(self.coarsest)).min(self.size.min_element());
        let far = far.min(FARTHEST).min(MOST_VOXELS * side * self.grid.spacing);
        let (cursor, bare) = (self.cursor.endless(), self.bare.endless());
        let solids = self.solids.map(|solids| solids.on(&bare));
        Self { cursor, bare, solids, far, ..self }
    }

    /// A ray from a world point along a unit world direction, over the ground of this marcher.
    pub fn ray(&self, world_eye: DVec3, world_direction: DVec3) -> GridRay {
        GridRay::new(&self.grid, world_eye, world_direction).over(self.curvature)
    }

    /// The grid that is marched through.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The first contact at a ground distance of at least `from` metres (0 unless a neighbour's
    /// range is known to bound this one), or `None`: the sky.
    pub fn first_contact(&mut self, ray: &GridRay, from: f64) -> Result<Option<Contact>> {
        self.contact_between(ray, from, f64::INFINITY)
    }

    /// The first contact at a range of no more than `until` metres: whether the ground hides what is found there.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn contact_before(&mut self, ray: &GridRay, until: f64) -> Result<Option<Contact>> {
        self.contact_between(ray, 0.0, until)
    }

    fn contact_between(&mut self, ray: &GridRay, from: f64, until: f64) -> Result<Option<Contact>> {
        let Some((over_area, off_area)) = self.clip(ray) else { return Ok(None) };
        let [from, until] = [range_at(ray, from).max(over_area), off_area.min(until)];
        let Some(horizon) = self.horizon(ray)? else {
            return self.contact_within(ray, [from, until]);
        };

        for [begins, ends] in horizon.of_ground(until) {
            let contact = self.contact_within(ray, [from.max(begins), until.min(ends)])?;
            if contact.is_some() {
                return Ok(contact);
            }
        }
        Ok(None)
    }

    /// Finds the first contact between two ranges, metres, between which the ray is over the area.
    fn contact_within(&mut self, ray: &GridRay, [from, until]: [f64; 2]) -> Result<Option<Contact>> {
        for index in 0..self.bands.len() {
            let band = self.bands[index];
            let (start, end) = (range_at(ray, band.start).max(from), range_at(ray, band.end).min(until));
            if start.is_finite() && start <= end {
                let search = RaySearch { ray, level: band.level, bare: band.bare };
                if let Some(contact) = self.search(&search, start, end)? {
                    return Ok(Some(contact));
                }
            }
        }
        Ok(None)
    }

    /// Finds what stands before a ray's first contact, if that is in sight: puts it into `hits`, nearest first, and returns the share of light behind it
    /// that comes through.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn solids(
        &mut self,
        ray: &GridRay,
        contact: Option<&Contact>,
        hits: &mut Vec<SolidHit>,
    ) -> Result<f64> {
        let until = contact.map_or(f64::INFINITY, |contact| contact.range);
        let left = self.solids_until(ray, until, NOTHING_LEFT, hits)?;
        Ok(if left <= NOTHING_LEFT { 0.0 } else { left })
    }

    /// Finds, of the spans on a ray up to a range in metres, the one behind which half of the light or less is left: the range that a ray is said to see, unless it met
    /// the ground before. `hits` is memory for what stands before it.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn half_hidden(
        &mut self,
        ray: &GridRay,
        until: f64,
        hits: &mut Vec<SolidHit>,
    ) -> Result<Option<SolidHit>> {
        let left = self.solids_until(ray, until, HALF, hits)?;
        Ok(hits.last().filter(|_| left <= HALF).copied())
    }

    fn solids_until(
        &mut self,
        ray: &GridRay,
        until: f64,
        least: f64,
        hits: &mut Vec<SolidHit>,
    ) -> Result<f64> {
        hits.clear();
        if self.solids.is_none() || self.bare_until == 0.0 {
            return Ok(1.0);
        }
        let end = until.min(self.bare_until / ray.ground_cosine);
        let horizon = self.horizon(ray)?;
        let clipped = self.clip(ray);
        let (Some((enters, leaves)), Some(solids)) = (clipped, &mut self.solids) else { return Ok(1.0) };
        let end = end.min(leaves);
        let Some(horizon) = horizon else {
            return if enters < end { solids.along(ray, [enters, end], [1.0, least], hits) } else { Ok(1.0) };
        };

        let mut left = 1.0;
        for [from, until] in horizon.of_standing(end) {
            if left <= least {
                break;
            }
            let (from, until) = (from.max(enters), until.min(end));
            if from < until {
                left = solids.along(ray, [from, until], [left, least], hits)?;
            }
        }
        Ok(left)
    }

    /// Whether a ray surely meets nothing that stands, up to a range in metres.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn is_free_of_standing(&mut self, ray: &GridRay, range: f64) -> Result<bool> {
        if self.solids.is_none() || self.bare_until == 0.0 {
            return Ok(true);
        }
        Ok(self.horizon(ray)?.is_some_and(|horizon| horizon.is_free_of_standing(range)))
    }

    /// Returns the bounds of where a ray may meet something, if there are any.
    fn horizon(&mut self, ray: &GridRay) -> Result<Option<RayHorizon<'a>>> {
        let Some(horizons) = self.horizons else { return Ok(None) };
        if let Some((slope, horizon)) = self.latest
            && slope == ray.slope
            && horizons.eye() == ray.eye
        {
            return Ok(Some(horizon));
        }
        let Self { cursor, bare, solids, .. } = self;
        let blocks = solids.as_mut().map(Solids::blocks);
        let beside = self.latest.as_ref().map(|(_, horizon)| horizon);
        let horizon = horizons.of_ray(ray, beside, SectorLook { surface: cursor, bare, blocks })?;
        self.latest = horizon.map(|horizon| (ray.slope, horizon));
        Ok(horizon)
    }

    /// Whether a ray is over the area, and no higher than its ground, at a range in metres.
    pub fn is_within(&self, ray: &GridRay, range: f64) -> bool {
        self.clip(ray).is_some_and(|(enters, leaves)| (enters..=leaves).contains(&range))
    }

    /// Ranges between which the ray can meet a surface.
    fn clip(&self, ray: &GridRay) -> Option<(f64, f64)> {
        if !self.cursor.is_endless() {
            return ray.clip(self.size, self.ceiling);
        }
        let under = ray.under(self.ceiling)?;
        let (start, end) = (under.0.max(0.0), under.1.min(self.far / ray.ground_cosine));
        (start <= end).then_some((start, end))
    }

    fn search(&mut self, search: &RaySearch<'_>, start: f64, end: f64) -> Result<Option<Contact>> {
        if search.level == self.coarsest {
            return self.walk_surface(search, search.level, start, end);
        }
        // A short way is through a few coarse voxels, which bound little of it, or of none but its own.
        let way = (end - start) * search.ray.slope.truncate().length();
        if way <= FEW_VOXELS * f64::from(Grid::side_units(search.level)) {
            return self.walk_surface(search, search.level, start, end);
        }
        let is_wide = |level: &u8| f64::from(Grid::side_units(*level)) * FEW_VOXELS >= way;
        let level = (search.level + 1..self.coarsest).find(is_wide).unwrap_or(self.coarsest);
        let walk = CellWalk::new(search.ray, self.cursor.voxels(level), start, end);
        self.descend(search, level, walk)
    }

    /// Walks voxels of `level`, which is coarser than the one that is searched, and goes into those
    /// that the ray does not clear.
    fn descend(&mut self, search: &RaySearch<'_>, level: u8, walk: CellWalk) -> Result<Option<Contact>> {
        let ray = search.ray;
        for step in walk {
            let highest =
                self.cursor.upper_bound(level, step.cell)? + self.lift(search, search.level, step.enter);
            if ray.lowest_between(step.enter, step.leave) > highest {
                continue;
            }
            let contact = if level == search.level + 1 {
                self.walk_surface(search, search.level, step.enter, step.leave)?
            } else {
                let inside = self.cursor.voxels(level - 1).inside(&step, RADIX);
                self.descend(search, level - 1, CellWalk::new(ray, inside, step.enter, step.leave))?
            };
            if contact.is_some() {
                return Ok(contact);
            }
        }
        Ok(None)
    }

    /// Returns a bound of how far the surface of a level is displaced from a range on, metres.
    fn lift(&self, search: &RaySearch<'_>, level: u8, range: f64) -> f64 {
        let distance = || range * search.ray.ground_cosine / self.grid.spacing;
        self.displacement.filter(|_| level == 0).map_or(0.0, |displacement| displacement.bound(distance()))
    }

    /// Returns the cursor of the search's ground.
    fn on(&mut self, search: &RaySearch<'_>) -> &mut PageCursor<'a> {
        if search.bare { &mut self.bare } else { &mut self.cursor }
    }

    /// Intersects the cells of `level`'s surface between two ranges.
    fn walk_surface(
        &mut self,
        search: &RaySearch<'_>,
        level: u8,
        start: f64,
        end: f64,
    ) -> Result<Option<Contact>> {
        let lattice = match self.surface {
            Surface::Smooth => self.cursor.cells(level),
            Surface::Blocks => self.cursor.voxels(level),
        };
        for step in CellWalk::new(search.ray, lattice, start, end) {
            let contact = self.cell_contact(search, level, &step, &lattice)?;
            if contact.is_some() {
                return Ok(contact);
            }
        }
        Ok(None)
    }

    /// Finds where the ray first is on or under the surface within one cell. Where its page is absent, the next
    /// coarser level stands in.
    fn cell_contact(
        &mut self,
        search: &RaySearch<'_>,
        level: u8,
        step: &CellStep,
        lattice: &Lattice,
    ) -> Result<Option<Contact>> {
        let found = match self.surface {
            Surface::Smooth => match self.on(search).corners(level, step.cell)? {
                Some(corners) => {
                    let contact =
                        self.smooth_contact(search, level, step, SmoothCell { corners, lattice })?;
                    Some(contact.map(|range| (range, None)))
                }
                None => None,
            },
            Surface::Blocks => self.on(search).height(level, step.cell)?.map(|top| {
                let contact = block_contact(search.ray, step, top?, lattice.place(step));
                contact.map(|(range, face)| (range, Some(face)))
            }),
        };

        match found {
            Some(contact) => Ok(contact.map(|(range, face)| Contact {
                range,
                level,
                wanted: search.level,
                face,
                bare: search.bare,
            })),
            None if level < self.coarsest => self.walk_surface(search, level + 1, step.enter, step.leave),
            None => Ok(None),
        }
    }

    /// Finds the range at which the ray first is on or under the smooth surface within one cell with heights at its corners.
    fn smooth_contact(
        &mut self,
        search: &RaySearch<'_>,
        level: u8,
        step: &CellStep,
        cell: SmoothCell<'_>,
    ) -> Result<Option<f64>> {
        let SmoothCell { corners, lattice } = cell;
        let [a, b, c, d] = corners;
        let (lowest, highest) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        let lift = self.lift(search, level, step.enter);
        if search.ray.lowest_between(step.enter, step.leave) > highest + lift + CLEAR {
            return Ok(None);
        }

        let (ground, place) = (Patch::new(corners), lattice.place(step));
        let Some(displacement) = self.displacement.filter(|_| lift > 0.0) else {
            return Ok(ground.first_contact(search.ray, step, place));
        };
        let reach = Patch::new(self.reaches(search, step.cell, displacement)?);
        let displaced = DisplacedPatch { ground, reach, lowest: lowest - lift, displacement };
        Ok(displaced.first_contact(search.ray, step, place))
    }

    /// Returns how far displacements reach at the corners of a cell of the finest level, metres; 0 at those whose page is absent.
    fn reaches(
        &mut self,
        search: &RaySearch<'_>,
        [west, south]: [i64; 2],
        displacement: &Displacement,
    ) -> Result<[f64; 4]> {
        let cursor = self.on(search);
        let dims = cursor.dims(0);
        let mut reaches = [0.0; 4];
        for (corner, reach) in reaches.iter_mut().enumerate() {
            let voxel = [west + corner as i64 % 2, south + corner as i64 / 2];
            let voxel = [0, 1].map(|axis| voxel[axis].clamp(0, dims[axis] - 1));
            if let Some(attributes) = cursor.stored_attributes(0, voxel)? {
                *reach = displacement.relief().reach(attributes.material).into();
            }
        }
        Ok(reaches)
    }
}
