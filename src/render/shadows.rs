//! Shadows of bodies on the ground, put into what was rendered of it, and what sun reaches bodies.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use super::Renderer;
use super::merge::Shown;
use super::sunlit::Sunlit;
use crate::error::Result;
use crate::frame::Atmosphere;
use crate::frame::stage::Pixels;
use crate::objects::{Body, Caster, Casters, Hit, Lens, Patch, SQUARE};
use crate::raymarch::{Contact, GridRay, SurfaceFilter};
use crate::space::{Camera, Footprint, Ray};
use crate::subimage::{Farm, Stage};
use crate::sunlight::Daylight;
use crate::voxel::PageSource;

/// Pixels from one to the next of those that tell where the ground of a square lies.
const STRIDE: usize = 8;

/// Bodies and ground under a sun.
pub struct Shadows<'r, 'a, S> {
    renderer: &'r Renderer<'a, S>,
    casters: Casters,
    sunlit: Sunlit<'r, 'a, S>,
    footprint: Footprint,
    daylight: Daylight,
    atmosphere: Atmosphere,
}

impl<'r, 'a, S: PageSource> Shadows<'r, 'a, S> {
    /// Those of `bodies` as `camera` finds them; `None` without shadows.
    pub fn of(renderer: &'r Renderer<'a, S>, camera: &Camera, bodies: &[Body]) -> Option<Self> {
        let options = &renderer.options;
        if !options.has_shadows() || bodies.is_empty() {
            return None;
        }
        let to_sun = options.sun.direction().as_dvec3().normalize();
        let casters = Casters::new(bodies, to_sun, camera.pose.eye, options.curvature);
        let atmosphere = options.atmosphere(renderer.source.header());
        let footprint = camera.footprint();
        let (sunlit, daylight) = (Sunlit::new(renderer, bodies), Daylight::new(options.sun));
        Some(Self { renderer, casters, sunlit, footprint, daylight, atmosphere })
    }

    /// What samples the ground.
    fn filter(&self, camera: &Camera) -> SurfaceFilter<'r, S> {
        let Renderer { source, options, shared, .. } = self.renderer;
        let filter = SurfaceFilter::new(*source, camera.footprint()).shaded(shared.radiance.shades());
        if options.tile_world { filter.endless() } else { filter }
    }

    /// Darkens the ground that lies in the shadow of bodies; `range` tells how far it is.
    pub fn cast(&self, camera: &Camera, pixels: Vec<Pixels<'_>>, range: &[f32], farm: &Farm) -> Result<()> {
        let width = camera.width as usize;
        let shown = Shown { range, width };
        let lens = Lens::new(camera);
        farm.each(Stage::Image, pixels, |index, mut pixels| {
            let mut filter = None;
            let first = index * SQUARE;
            let rows = first..(first + SQUARE).min(camera.height as usize);
            for column in (0..width).step_by(SQUARE) {
                let columns = column..(column + SQUARE).min(width);
                let among = self.among(&lens, &shown, [&columns, &rows]);
                if among.is_empty() {
                    continue;
                }
                let filter = filter.get_or_insert_with(|| self.filter(camera));
                for row in rows.clone() {
                    for column in columns.clone() {
                        let pixel = (row - first) * width + column;
                        if let Some((left, air)) = self.left(&lens, &shown, filter, &among, [column, row])? {
                            let seen = pixels.light(pixel);
                            pixels.put(pixel, air + (seen - air) * left);
                        }
                    }
                }
            }
            Ok(())
        })
    }

    /// Bodies that may throw shadows into a square.
    fn among(&self, lens: &Lens<'_>, shown: &Shown<'_>, [columns, rows]: [&Range<usize>; 2]) -> Vec<&Caster> {
        let ends = |range: &Range<usize>| {
            (range.start..range.end).step_by(STRIDE).chain([range.end - 1]).collect::<Vec<_>>()
        };
        let columns = ends(columns);
        let mut points = Vec::new();
        let mut margin: f64 = 0.0;
        for row in ends(rows) {
            for &column in &columns {
                let range = f64::from(shown.range[row * shown.width + column]);
                let ray = lens.ray_at(DVec2::new(column as f64, row as f64) + 0.5);
                if let Some(ray) = ray.filter(|_| range.is_finite()) {
                    points.push(ray.origin + ray.direction * range);
                    margin = margin.max(STRIDE as f64 * self.footprint.at(range));
                }
            }
        }
        self.casters.over(points.into_iter(), margin)
    }

    /// Which part of a pixel's light is left where bodies hide the sun, and the light of the air before it; `None`: all is.
    fn left(
        &self,
        lens: &Lens<'_>,
        shown: &Shown<'_>,
        filter: &mut SurfaceFilter<'_, S>,
        among: &[&Caster],
        [column, row]: [usize; 2],
    ) -> Result<Option<(f32, Vec3)>> {
        let plane = shown.ground(column, row);
        if plane.inverse <= 0.0 {
            return Ok(None);
        }
        let middle = DVec2::new(column as f64, row as f64) + 0.5;
        let point = |offset: DVec2| {
            let ray = lens.ray_at(middle + offset)?;
            let inverse = plane.at(offset);
            (inverse > 0.0).then(|| ray.origin + ray.direction / inverse)
        };
        let Some(ray) = lens.ray_at(middle) else { return Ok(None) };
        let own = ray.origin + ray.direction / f64::from(plane.inverse);
        let range = 1.0 / f64::from(plane.inverse);
        let [across, along] = plane.slope.map(|slope| f64::from(slope).abs() * range * range);
        if !self.casters.is_near(among, own, self.footprint.at(range) + across + along) {
            return Ok(None);
        }
        let side = |offset: DVec2| point(offset).map_or(DVec3::ZERO, |beside| beside - own);
        let patch =
            Patch { middle: own, right: side(DVec2::new(0.5, 0.0)), down: side(DVec2::new(0.0, 0.5)) };
        let share = self.casters.share(among, &patch);
        if share == 1.0 {
            return Ok(None);
        }
        let contact = Contact { range, level: 0, wanted: 0, face: None };
        let Renderer { source, options, .. } = self.renderer;
        let over_ground =
            GridRay::new(&source.header().grid, ray.origin, ray.direction).over(options.curvature);
        let sample = filter.sample(&over_ground, &contact)?;
        let left =
            self.daylight.on(sample.normal, sample.sun * share) / self.daylight.on(sample.normal, sample.sun);
        let air = self.atmosphere.haze(Vec3::ZERO, ray.origin.z, ray.direction.as_vec3(), range as f32);
        Ok(Some((left, air)))
    }

    /// What went wrong with what was asked of it.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn check(self) -> Result<()> {
        self.sunlit.check()
    }

    /// Share of the sun, 0…1, that the ground, other bodies, or other parts of the same, leave to a hit on a ray.
    pub fn on_body(&self, hit: &Hit, ray: &Ray) -> f32 {
        let share = self.sunlit.share(hit.id);
        if share == 0.0 {
            return share;
        }
        let (point, pixel) = (ray.origin + ray.direction * hit.range, self.footprint.at(hit.range));
        let patch = Patch::above(point, hit.normal.as_dvec3(), pixel);
        share * self.casters.share_of_body(hit.id, &patch)
    }
}
