//! Light of what stands on the ground: faces of spans.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::VisualSensor;
use crate::raymarch::scan::{FaceDirection, FacetLight};
use crate::simd::Each;
use crate::sunlight::{SHADE_APRON, ShadePage, Shades};
use crate::voxel::{PageId, PageSource, Span};
use hedgehop_base::colour::linear_from_srgb8;

/// Directions of walls.
const DIRECTIONS: usize = 256;

/// Light on faces by the way they look: for one sun, and for all pages.
#[derive(Debug, Clone)]
pub struct Facets {
    sensor: VisualSensor,
    /// On walls: what falls on them without the sun, and what the sun adds.
    walls: Vec<[Vec3; 2]>,
    below: Vec3,
    /// Linear reflectances of 8-bit codes, with the water that is on them.
    albedo: [f32; 256],
}

/// The same with the shadows that lie on one database's pages.
pub struct ShadedFacets<'a> {
    facets: &'a Facets,
    source: &'a dyn PageSource,
    shades: Option<&'a Shades>,
    latest: Option<(PageId, Option<Arc<ShadePage>>)>,
}

impl Facets {
    /// Under the light that a sensor sees by.
    pub fn new(sensor: VisualSensor) -> Self {
        let daylight = sensor.daylight();
        let direction = |index: usize| {
            let angle = index as f32 * (std::f32::consts::TAU / DIRECTIONS as f32);
            let normal = Vec2::from_angle(angle).extend(0.0);
            let shaded = daylight.on_body(normal, 0.0);
            [shaded, daylight.on_body(normal, 1.0) - shaded]
        };
        let grey = |code: u8| linear_from_srgb8([code; 3])[0];
        Self {
            walls: (0..DIRECTIONS).map(direction).collect(),
            below: daylight.on_body(Vec3::NEG_Z, 0.0),
            albedo: std::array::from_fn(|code| sensor.wetted(grey(code as u8))),
            sensor,
        }
    }

    /// Joins the facets with the shadows on the pages of `source`.
    pub fn on<'a>(&'a self, source: &'a dyn PageSource, shades: Option<&'a Shades>) -> ShadedFacets<'a> {
        ShadedFacets { facets: self, source, shades, latest: None }
    }

    fn light(&self, span: &Span, facet: FaceDirection, sun: f32) -> Vec3 {
        let albedo = |colour: [u8; 3]| Vec3::from_array(colour.each(|code| self.albedo[usize::from(code)]));
        match facet {
            FaceDirection::Side(facing) => {
                let [shaded, direct] = self.walls[usize::from(facing)];
                albedo(span.side) * (shaded + direct * sun)
            }
            FaceDirection::Top(slope) => {
                // Most ends are level.
                let normal = if slope == [0; 2] {
                    Vec3::Z
                } else {
                    let [east, north] = slope.each(|slope| f32::from(slope) / Span::SLOPE_STEPS);
                    Vec3::new(-east, -north, 1.0).normalize()
                };
                let albedo = self.sensor.snowed_on(normal, albedo(span.top));
                albedo * self.sensor.daylight().on_body(normal, sun)
            }
            FaceDirection::Bottom => albedo(span.side) * self.below,
        }
    }
}

impl ShadedFacets<'_> {
    /// Share of the sun that comes to what stands over a voxel. A page that cannot be read is an error of whoever reads its heights.
    fn sun(&mut self, page: PageId, voxel: [u32; 2]) -> f32 {
        let Some(shades) = self.shades else { return 1.0 };
        let surface = page.surface();
        if self.latest.as_ref().is_none_or(|(known, _)| *known != surface) {
            self.latest = Some((surface, shades.page(self.source, surface).ok().flatten()));
        }
        let shade = self.latest.as_ref().and_then(|(_, shade)| shade.as_ref());
        shade.map_or(1.0, |shade| shade.about(voxel.each(|at| at as usize + SHADE_APRON as usize)))
    }
}

impl FacetLight for ShadedFacets<'_> {
    #[inline]
    fn light(&mut self, page: PageId, voxel: [u32; 2], span: &Span, facet: FaceDirection) -> [f32; 3] {
        let sun = self.sun(page, voxel);
        self.facets.light(span, facet, sun).to_array()
    }
}
