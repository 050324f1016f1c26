//! Colour and normal of the surface under a pixel, filtered over the pixel's footprint.
//!
//! ```text
//! width  = range · pixel angle, or constant            footprint across the ray
//! length = width / sine of the grazing angle           footprint along the ray, on the surface
//! taps   = length / width, at most 8, spread along the footprint
//! each tap: bilinear in the two levels whose voxels enclose the width, blended by log₄(width)
//! ```
//!
//! The hierarchy holds averages (Hughes patent, claim 17), so that a tap costs the same at any
//! range; blending between levels hides where one follows the other (Williams, *Pyramidal
//! parametrics*, 1983), and taps along the footprint keep grazing views sharp.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::{Contact, Face, GridRay, PageCursor, SolidHit};
use crate::detail::{
    DetailBlocks, DetailedColour, FacadePattern, GroundTile, LEAST_TOWARD, PostCell, Synthesis, WALL_SCALE,
    WallFootprint,
};
use crate::space::Footprint;
use crate::sunlight::{ShadeSampler, Shades};
use crate::voxel::{Attributes, Grid, PageSource, RADIX};
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_base::error::Result;

/// Most taps along a footprint; one that is longer, in widths, is filtered over this length only.
const MOST_TAPS: f64 = 8.0;

/// Surface sample of a pixel at the end of its ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSample {
    /// Range, metres.
    pub range: f64,
    /// Level index that was marched.
    pub level: u8,
    /// Diffuse reflectance, linear Rec. 709, 0…1.
    pub albedo: Vec3,
    /// Unit normal in world space.
    pub normal: Vec3,
    /// Attributes of the voxel of `level` that was hit; of a coarser one where its page is absent.
    pub attributes: Attributes,
    /// Share of the sun's disc that it sees, 0…1; 1 without shadows.
    pub sun: f32,
}

/// Least sine of a grazing angle over which a footprint goes on.
const LEAST_SINE: f64 = 1.0e-3;

/// Samples the surface for pixels of one footprint.
pub struct SurfaceFilter<'a> {
    cursor: PageCursor<'a>,
    /// The same on bare ground.
    bare: PageCursor<'a>,
    grid: Grid,
    footprint: Footprint,
    coarsest: u8,
    source: &'a dyn PageSource,
    shade: Option<ShadeSampler<'a>>,
    /// Detail of the finest level's posts.
    detail: DetailBlocks,
    /// Pattern below its voxels.
    synthesis: Option<&'a Synthesis>,
}

/// Level indices that enclose a footprint, and the share of the coarser one.
#[derive(Clone, Copy)]
struct LevelBlend {
    fine: u8,
    coarse: u8,
    share: f64,
}

/// Taps in a row along the footprint of a pixel on the surface.
#[derive(Clone, Copy)]
struct FootprintTaps {
    /// The footprint from end to end, units.
    along: DVec2,
    /// Number of taps, whole and at least 1.
    count: f64,
}

/// End of a ray, and the sunlight there.
#[derive(Clone, Copy)]
struct LitContact {
    blend: LevelBlend,
    /// Place, units.
    units: DVec2,
    /// See [`SurfaceFilter::along`].
    footprint: FootprintTaps,
    normal: DVec3,
    sun: f32,
}

impl<'a> SurfaceFilter<'a> {
    /// A filter over `source` for pixels that are as wide as `footprint` says.
    pub fn new(source: &'a dyn PageSource, footprint: Footprint) -> Self {
        let header = source.header();
        Self {
            cursor: PageCursor::new(source),
            bare: PageCursor::new(source).on_bare_ground(),
            grid: header.grid,
            footprint,
            coarsest: header.level_count - 1,
            source,
            shade: None,
            detail: DetailBlocks::new(header),
            synthesis: None,
        }
    }

    /// The same with shadows.
    pub fn shaded(self, shades: Option<&'a Shades>) -> Self {
        Self { shade: shades.map(ShadeSampler::new), ..self }
    }

    /// The same with detail below the finest voxel.
    pub fn detailed(self, synthesis: Option<&'a Synthesis>) -> Self {
        Self { synthesis, ..self }
    }

    /// The same over the area repeated without end.
    pub fn endless(self) -> Self {
        Self { cursor: self.cursor.endless(), bare: self.bare.endless(), ..self }
    }

    /// Samples the surface where `ray` ended.
    pub fn sample(&mut self, ray: &GridRay, contact: &Contact) -> Result<SurfaceSample> {
        self.on_ground_of(contact, |filter| filter.sample_here(ray, contact))
    }

    /// Looks at the ground on which `contact` lies.
    fn on_ground_of<T>(&mut self, contact: &Contact, look: impl FnOnce(&mut Self) -> T) -> T {
        if !contact.bare {
            return look(self);
        }
        std::mem::swap(&mut self.cursor, &mut self.bare);
        let seen = look(self);
        std::mem::swap(&mut self.cursor, &mut self.bare);
        seen
    }

    fn sample_here(&mut self, ray: &GridRay, contact: &Contact) -> Result<SurfaceSample> {
        let lit = self.lit(ray, contact)?;
        let LitContact { blend, units, footprint, normal, sun } = lit;
        let albedo = self.mean(units, footprint, |filter, units| filter.blended_colour(blend, units))?;
        let albedo = albedo * self.below_voxel(ray, contact, &lit)?;
        let attributes = self.attributes(units, contact)?;
        Ok(SurfaceSample {
            range: contact.range,
            level: contact.level,
            albedo,
            normal: normal.as_vec3(),
            attributes,
            sun,
        })
    }

    /// Factor on the light of a pixel where `ray` ended, by what lies below the finest voxel.
    pub fn below_finest(&mut self, ray: &GridRay, contact: &Contact) -> Result<f32> {
        self.on_ground_of(contact, |filter| {
            let lit = filter.lit(ray, contact)?;
            filter.below_voxel(ray, contact, &lit)
        })
    }

    /// Factor on the light of a pixel by what lies below the finest voxel.
    fn below_voxel(&mut self, ray: &GridRay, contact: &Contact, lit: &LitContact) -> Result<f32> {
        let LitContact { blend, units, footprint, normal, .. } = *lit;
        // Extent of the footprint along the ray's way over the ground, and across, units.
        let width = self.footprint.at(contact.range) / self.grid.spacing;
        let direction = self.direction(ray.slope.truncate().extend(ray.rise_at(contact.range)));
        let way = direction.truncate().normalize_or(DVec2::X);
        let along = width * normal.z / normal.dot(direction).abs().max(LEAST_SINE);

        let Some(Synthesis { tiles, strength }) = self.synthesis.filter(|_| blend.fine == 0) else {
            return Ok(1.0);
        };
        let over_ground = GroundTile::fading(DVec2::new(along, width));
        let rise = width * normal.truncate().dot(way).abs() / normal.dot(direction).abs().max(LEAST_SINE);
        let over_walls = GroundTile::fading(DVec2::new(rise, width));
        if over_ground.max(over_walls) == 0.0 {
            return Ok(1.0);
        }
        let deviations = self.mean(units, footprint, |filter, units| filter.deviations(units))?;
        let squares = way * way * (along * along) + way.perp() * way.perp() * (width * width);
        // The tile begins anew where an area that repeats does.
        let mut more = f64::from(deviations.x)
            * over_ground
            * tiles.ground.mean(deviations.x, self.within(units), squares.map(f64::sqrt));

        // Over (y, z) or (x, z).
        if deviations.y != 0.0 {
            let axis = usize::from(deviations.y > 0.0);
            let toward = way[1 - axis].powi(2).max(f64::from(LEAST_TOWARD)).sqrt();
            let place = DVec2::new(self.within(units)[axis], ray.at(contact.range).z / self.grid.spacing);
            let sides = DVec2::new(width / toward, rise);
            let mean = tiles.walls.mean(deviations.y.abs(), place * WALL_SCALE, sides * WALL_SCALE);
            more += f64::from(deviations.y.abs()) * over_walls * mean;
        }

        Ok((1.0 + strength * more).max(0.0) as f32)
    }

    /// Relative deviations of light below the finest voxel at a position in units, over the ground and over walls as [`DetailedColour`] tells them; 0 where its
    /// page is absent.
    fn deviations(&mut self, units: DVec2) -> Result<Vec2> {
        let (cell, fraction) = self.cursor.cells(0).cell_at(units);
        let Some((id, view, post)) = self.cursor.page_of_cell(0, cell)? else { return Ok(Vec2::ZERO) };
        let cell = PostCell { post, share: [fraction.x as f32, fraction.y as f32] };
        let DetailedColour { deviation, wall, .. } = self.detail.at(id, &view, cell);
        Ok(Vec2::new(deviation, wall))
    }

    /// Unit vector along a ray that changes by `slope` (units, units, metres) per metre of range.
    fn direction(&self, slope: DVec3) -> DVec3 {
        slope * DVec3::new(self.grid.spacing, self.grid.spacing, 1.0)
    }

    fn attributes(&mut self, units: DVec2, contact: &Contact) -> Result<Attributes> {
        // A wall stands on the border of two voxels; half a unit behind it lies the one that it belongs to.
        let behind = contact.face.map_or(DVec2::ZERO, |face| -0.5 * face.truncate());
        self.cursor.attributes_at(contact.level, units + behind)
    }

    /// Unit normal (world space) and attributes of the surface where `ray` ended, as [`Self::sample`] tells them, without its light.
    pub fn surface(&mut self, ray: &GridRay, contact: &Contact) -> Result<(Vec3, Attributes)> {
        self.on_ground_of(contact, |filter| {
            let units = ray.at(contact.range).truncate();
            let normal = filter.normal_at(units, contact)?;
            Ok((normal.as_vec3(), filter.attributes(units, contact)?))
        })
    }

    fn normal_at(&mut self, units: DVec2, contact: &Contact) -> Result<DVec3> {
        match contact.face {
            Some(face) => Ok(face),
            None => self.normal(self.levels_for(self.footprint.at(contact.range)), units),
        }
    }

    /// Samples the spans that `ray` hit above the ground.
    ///
    /// The share of the sun is that of the surface, which the highest of it is.
    pub fn sample_solid(&mut self, ray: &GridRay, hit: &SolidHit) -> Result<SurfaceSample> {
        let units = ray.at(hit.range).truncate();
        let colour = if hit.face == Face::Top { hit.span.top } else { hit.span.side };
        let mut albedo = Vec3::from_array(linear_from_srgb8(colour));
        if hit.face == Face::Side && !hit.span.facade.is_none() {
            albedo *= self.facade(ray, hit);
        }
        let mut attributes = self.cursor.attributes_at(0, units)?;
        attributes.material = hit.span.material;
        let within = self.within(units);
        let sun = match &mut self.shade {
            Some(shade) => shade.about(self.source, within)?,
            None => 1.0,
        };
        Ok(SurfaceSample {
            range: hit.range,
            level: 0,
            albedo,
            normal: hit.normal.as_vec3(),
            attributes,
            sun,
        })
    }

    /// Factor on the light of a wall by its façade.
    fn facade(&self, ray: &GridRay, hit: &SolidHit) -> Vec3 {
        let code = self.source.header().heights;
        let turns = hit.normal.y.atan2(hit.normal.x) / std::f64::consts::TAU;
        let facing = (turns * 256.0).round().rem_euclid(256.0) as u8;
        let Some(pattern) = FacadePattern::of_wall(&hit.span, facing, code) else { return Vec3::ONE };

        // On a wall a pixel is as wide as the ray passes it slantwise, and as high as it looks up or down.
        let direction = self.direction(ray.slope.truncate().extend(ray.rise_at(hit.range)));
        let (pixel, level) = (self.footprint.at(hit.range), direction.truncate().length().max(LEAST_SINE));
        let toward = hit.normal.truncate().dot(direction.truncate()).abs() / level;
        let floor = code.offset + code.scale * f64::from(hit.span.facade.floor);
        Vec3::from_array(pattern.factor(&WallFootprint {
            along: [pattern.place_along(hit.place.truncate()), (pixel / toward.max(LEAST_SINE)) as f32],
            up: [(hit.place.z - floor) as f32, (pixel / level) as f32],
        }))
    }

    /// Unit normal (world space) and share of the sun's disc (0…1; 1 without shadows) where `ray` ended, as [`Self::sample`] tells them, without its colour.
    pub fn light(&mut self, ray: &GridRay, contact: &Contact) -> Result<(Vec3, f32)> {
        let lit = self.on_ground_of(contact, |filter| filter.lit(ray, contact))?;
        Ok((lit.normal.as_vec3(), lit.sun))
    }

    fn lit(&mut self, ray: &GridRay, contact: &Contact) -> Result<LitContact> {
        let units = ray.at(contact.range).truncate();
        let width = self.footprint.at(contact.range);
        let blend = self.levels_for(width);
        let normal = self.normal_at(units, contact)?;
        let slope = ray.slope.truncate().extend(ray.rise_at(contact.range));
        let footprint = self.along(slope, width, normal);
        let sun = match self.shade {
            Some(_) => self.mean(units, footprint, |filter, units| filter.sun(blend, units))?,
            None => 1.0,
        };
        Ok(LitContact { blend, units, footprint, normal, sun })
    }

    /// Flags of a pixel whose ray ended at `contact`: [`Attributes::STAND_IN`] if the page that should be seen there is damaged.
    pub fn stand_in(&mut self, ray: &GridRay, contact: &Contact) -> Result<u8> {
        let units = ray.at(contact.range).truncate();
        let is_damaged =
            self.on_ground_of(contact, |filter| filter.cursor.is_damaged_at(contact.wanted, units))?;
        Ok(if is_damaged { Attributes::STAND_IN } else { 0 })
    }

    /// The contact of a ray with the surface that is to be seen at its range: at the level that stands in there where the page of that is absent.
    pub fn standing_in(&mut self, ray: &GridRay, contact: Contact) -> Result<Contact> {
        let units = ray.at(contact.range).truncate();
        let level = self.on_ground_of(&contact, |filter| filter.present(contact.wanted, units))?;
        Ok(Contact { level, ..contact })
    }

    /// Returns how far above the surface a ray is at a contact, metres; `None` where there is none.
    pub fn clearance(&mut self, ray: &GridRay, contact: &Contact) -> Result<Option<f64>> {
        let units = ray.at(contact.range).truncate();
        let height =
            self.on_ground_of(contact, |filter| filter.cursor.smooth_height(contact.level, units))?;
        Ok(height.map(|height| ray.height_at(contact.range) - height))
    }

    /// Width of a pixel at a range, across the ray, metres.
    pub fn pixel_at(&self, range: f64) -> f64 {
        self.footprint.at(range)
    }

    /// The finest level from `level` on whose page is present at a position in units.
    fn present(&mut self, level: u8, units: DVec2) -> Result<u8> {
        let (cell, _) = self.cursor.cells(level).cell_at(units);
        if level == self.coarsest || self.cursor.corners(level, cell)?.is_some() {
            return Ok(level);
        }
        self.present(level + 1, units)
    }

    /// Levels whose voxels enclose `width` metres.
    fn levels_for(&self, width: f64) -> LevelBlend {
        let position = (width / self.grid.spacing).max(1.0).ln() / f64::from(RADIX).ln();
        let position = position.min(f64::from(self.coarsest));
        let fine = position.floor() as u8;
        LevelBlend { fine, coarse: (fine + 1).min(self.coarsest), share: position.fract() }
    }

    /// The footprint of `width` metres (across the ray) along a ray that changes by `slope` (units, units, metres) per metre of range, units, and
    /// how many taps it takes.
    fn along(&self, slope: DVec3, width: f64, normal: DVec3) -> FootprintTaps {
        let direction = self.direction(slope);
        let grazing = normal.dot(direction).abs().max(1.0 / MOST_TAPS);
        let along = direction.truncate().normalize_or_zero() * (width / grazing / self.grid.spacing);
        FootprintTaps { along, count: (1.0 / grazing).ceil() }
    }

    /// Mean over a footprint around a position in units.
    fn mean<T>(
        &mut self,
        units: DVec2,
        footprint: FootprintTaps,
        value: impl Fn(&mut Self, DVec2) -> Result<T>,
    ) -> Result<T>
    where
        T: Default + std::ops::Add<Output = T> + std::ops::Div<f32, Output = T>,
    {
        let FootprintTaps { along, count: taps } = footprint;
        let mut sum = T::default();
        for tap in 0..taps as u32 {
            let offset = (f64::from(tap) + 0.5) / taps - 0.5;
            sum = sum + value(self, units + along * offset)?;
        }
        Ok(sum / taps as f32)
    }

    /// A position in units, brought into the area if that goes on without end.
    fn within(&self, units: DVec2) -> DVec2 {
        let area = DVec2::new(f64::from(self.grid.nx), f64::from(self.grid.ny));
        if self.cursor.is_endless() { units.rem_euclid(area) } else { units }
    }

    /// Share of the sun at a position in units, blended between two levels.
    fn sun(&mut self, blend: LevelBlend, units: DVec2) -> Result<f32> {
        let units = self.within(units);
        let Self { shade: Some(shade), source, .. } = self else { return Ok(1.0) };
        let fine = shade.share(*source, blend.fine, units)?;
        if blend.share == 0.0 {
            return Ok(fine);
        }
        let coarse = shade.share(*source, blend.coarse, units)?;
        Ok(fine + (coarse - fine) * blend.share as f32)
    }

    /// Colour at a position in units, blended between two levels.
    fn blended_colour(&mut self, blend: LevelBlend, units: DVec2) -> Result<Vec3> {
        let fine = self.colour(blend.fine, units)?;
        if blend.share == 0.0 {
            return Ok(fine);
        }
        Ok(fine.lerp(self.colour(blend.coarse, units)?, blend.share as f32))
    }

    /// Colour of a level at a position in units, bilinear in linear light; where its page is absent, of the
    /// next coarser level; black where the coarsest one is, too.
    fn colour(&mut self, level: u8, units: DVec2) -> Result<Vec3> {
        let (cell, fraction) = self.cursor.cells(level).cell_at(units);
        if level == 0
            && let Some((id, view, post)) = self.cursor.page_of_cell(level, cell)?
        {
            let cell = PostCell { post, share: [fraction.x as f32, fraction.y as f32] };
            return Ok(self.detail.at(id, &view, cell).albedo);
        }
        let Some(colours) = self.cursor.corner_colours(level, cell)? else {
            return if level < self.coarsest { self.colour(level + 1, units) } else { Ok(Vec3::ZERO) };
        };
        let [sw, se, nw, ne] = colours.map(|colour| Vec3::from_array(linear_from_srgb8(colour)));
        let (u, v) = (fraction.x as f32, fraction.y as f32);
        Ok(sw.lerp(se, u).lerp(nw.lerp(ne, u), v))
    }

    /// Unit normal of the smooth surface at a position in units, in world axes.
    fn normal(&mut self, blend: LevelBlend, units: DVec2) -> Result<DVec3> {
        let mut gradient = self.gradient(blend.fine, units)?;
        if blend.share > 0.0 {
            gradient = gradient.lerp(self.gradient(blend.coarse, units)?, blend.share);
        }
        Ok((-gradient).extend(1.0).normalize())
    }

    /// Slope eastward and northward, metres per metre: central differences over two voxels of the
    /// smooth surface, so that shading is continuous where facets meet. Beyond the outermost posts,
    /// where the surface goes level, the slope is that of the ground before.
    ///
    /// Where the level's page is absent, that of the next coarser one.
    fn gradient(&mut self, level: u8, units: DVec2) -> Result<DVec2> {
        let level = self.present(level, units)?;
        let side = f64::from(Grid::side_units(level));
        let dims = self.cursor.dims(level);
        let posts = |axis: usize| (0.5 * side, (dims[axis] as f64 - 0.5) * side);
        let endless = (f64::NEG_INFINITY, f64::INFINITY);
        let (east, north) = if self.cursor.is_endless() { (endless, endless) } else { (posts(0), posts(1)) };
        let (low, high) = (DVec2::new(east.0, north.0), DVec2::new(east.1, north.1));
        let centre_at = units.clamp(low, high);
        let centre = self.cursor.smooth_height(level, centre_at)?;
        let mut slope = [0.0; 2];

        for (axis, step) in [DVec2::new(side, 0.0), DVec2::new(0.0, side)].into_iter().enumerate() {
            let (behind_at, ahead_at) = ((centre_at - step).max(low), (centre_at + step).min(high));
            let ahead = self.cursor.smooth_height(level, ahead_at)?;
            let behind = self.cursor.smooth_height(level, behind_at)?;

            let (rise, run) = match (behind, centre, ahead) {
                (Some(behind), _, Some(ahead)) => (ahead - behind, ahead_at - behind_at),
                (None, Some(centre), Some(ahead)) => (ahead - centre, ahead_at - centre_at),
                (Some(behind), Some(centre), None) => (centre - behind, centre_at - behind_at),
                _ => (0.0, DVec2::ZERO),
            };
            if run[axis] > 0.0 {
                slope[axis] = rise / (run[axis] * self.grid.spacing);
            }
        }

        Ok(DVec2::from_array(slope))
    }
}
