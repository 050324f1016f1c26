//! Shadows that bodies throw.
//!
//! ```text
//! bodies as discs on a plane across the sun's rays, in order along one axis of it
//! a part of the screen, and from where to where its ground lies → the bodies that may hide the sun from some of it
//! the patch of ground in a pixel → sixteen rays from all over it to all over the sun's disc, the share of them that none of these holds up
//! ```

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::{DMat3, DVec2, DVec3};

use super::ray_coverage::{PLACES, SunBeam};
use super::{Body, Form, Shape};
use crate::earth::Curvature;
use crate::simd::{Isa, LANES};
use crate::sunlight::SUN_SEMIDIAMETER;

/// Half of the sun's width, metres per metre.
const SUN: f64 = SUN_SEMIDIAMETER * std::f64::consts::PI / 180.0;

/// Times as thick as a patch and half-shadow together that bodies must be for what all four corners say to hold in between.
const THICK: f64 = 4.0;

/// Distance from a body's own surface at which its ray starts, pixels: of a pixel with an edge in it means are known, not a point of the surface.
const STEP: f64 = 1.0;

/// Bodies under a sun.
#[derive(Debug)]
pub struct Casters {
    /// Casters in the order of their place on the first axis of the plane across the sun's rays.
    casters: Vec<Caster>,
    /// Rows: two axes across the sun's rays, and the direction to it.
    sun_from_world: DMat3,
    /// Greatest radius of a body, and how near to the sun the nearest is, metres.
    widest: f64,
    nearest: f64,
    /// Numbers among all by the bodies' own numbers.
    by_id: HashMap<u32, usize>,
    isa: Isa,
}

/// A box across the sun's rays that holds some ground, metres.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    low: DVec3,
    high: DVec3,
}

/// A body, and where it is seen from the sun.
#[derive(Debug)]
pub struct Caster {
    id: u32,
    /// A shape or a model.
    form: Form,
    /// Metres in the world.
    position: DVec3,
    body_from_world: DMat3,
    /// Direction to the sun's middle in its axes, of unit length, and what half of the sun to the right adds, and half of it up.
    to_sun: [DVec3; 3],
    /// Casters that may hide the sun from some part of it, by their number among all; found when it is asked for first.
    above: OnceLock<Vec<usize>>,
    /// Middle of the sphere around it: place across the sun's rays, and how near it is to the sun, metres.
    place: DVec3,
    /// Metres.
    radius: f64,
    /// Least extent, metres.
    thickness: f64,
}

/// Surface within a pixel.
#[derive(Debug, Clone, Copy)]
pub struct LitPatch {
    /// Metres in the world.
    pub middle: DVec3,
    /// Step from its middle to half a pixel to the right, and down, metres.
    pub right: DVec3,
    /// See [`Self::right`].
    pub down: DVec3,
}

impl LitPatch {
    /// A point of a body, where a pixel is so many metres wide, a little above its surface.
    pub fn above(point: DVec3, normal: DVec3, pixel: f64) -> Self {
        Self { middle: point + normal * (STEP * pixel), right: DVec3::ZERO, down: DVec3::ZERO }
    }
}

impl Casters {
    /// `bodies` under a sun in the direction `to_sun` (of unit length), lowered by the Earth's curvature as `eye` finds them.
    pub fn new(bodies: &[Body], to_sun: DVec3, eye: DVec3, curvature: Curvature, isa: Isa) -> Self {
        let (right, up) = to_sun.any_orthonormal_pair();
        let sun_from_world = DMat3::from_cols(right, up, to_sun).transpose();
        let mut casters: Vec<_> =
            bodies.iter().map(|body| Caster::new(body, sun_from_world, eye, curvature)).collect();
        casters.sort_by(|a, b| a.place.x.total_cmp(&b.place.x).then(a.id.cmp(&b.id)));
        let widest = casters.iter().map(|caster| caster.radius).fold(0.0, f64::max);
        let nearest = casters.iter().map(|caster| caster.place.z).fold(f64::NEG_INFINITY, f64::max);
        let by_id = casters.iter().enumerate().map(|(number, caster)| (caster.id, number)).collect();
        Self { casters, sun_from_world, widest, nearest, by_id, isa }
    }

    /// The box around some points (metres in the world) and `margin` metres beside them; `None`: there are none.
    pub fn bounds(&self, points: impl Iterator<Item = DVec3>, margin: f64) -> Option<Bounds> {
        let bounds = points.map(|point| self.sun_from_world * point).map(|place| Bounds::at(place, 0.0));
        bounds.reduce(|bounds, own| bounds.with(&own)).map(|bounds| bounds.grown(margin))
    }

    /// Returns the casters that may hide the sun from something in a box.
    pub fn over(&self, bounds: &Bounds) -> Vec<&Caster> {
        self.between(bounds).map(|number| &self.casters[number]).collect()
    }

    /// Numbers of those that may hide the sun from something in a box.
    fn between(&self, bounds: &Bounds) -> impl Iterator<Item = usize> {
        // No half-shadow that counts is wider than that of the body that is nearest to the sun.
        let reach = self.widest + SUN * (self.nearest - bounds.low.z).max(0.0);
        let from = self.casters.partition_point(|caster| caster.place.x < bounds.low.x - reach);
        let until = self.casters.partition_point(|caster| caster.place.x <= bounds.high.x + reach);
        (from..until.max(from)).filter(move |number| self.casters[*number].is_over(bounds))
    }

    /// The body of that number.
    pub fn of_body(&self, id: u32) -> Option<&Caster> {
        self.by_id.get(&id).map(|number| &self.casters[*number])
    }

    /// Share of the sun's disc, 0…1, that others, or other parts of it, leave to a patch of a body. What is convex hides nothing from itself that Lambert's law
    /// does not.
    pub fn share_of_body(&self, own: &Caster, patch: &LitPatch) -> f32 {
        let above = own.above.get_or_init(|| {
            let bounds = Bounds::at(own.place, own.radius);
            self.between(&bounds)
                .filter(|number| self.casters[*number].id != own.id || matches!(own.form, Form::Model(_)))
                .collect()
        });
        if above.is_empty() {
            return 1.0;
        }
        self.share_of(above.iter().map(|number| &self.casters[*number]), patch)
    }

    /// Whether one `among` them may hide the sun from something up to `size` metres around a point.
    pub fn is_near(&self, among: &[&Caster], point: DVec3, size: f64) -> bool {
        let place = self.sun_from_world * point;
        among.iter().any(|caster| caster.is_near(place, size))
    }

    /// Share of the sun's disc, 0…1, that bodies `among` them leave to a patch.
    pub fn share(&self, among: &[&Caster], patch: &LitPatch) -> f32 {
        self.share_of(among.iter().copied(), patch)
    }

    fn share_of<'c>(&self, among: impl Iterator<Item = &'c Caster>, patch: &LitPatch) -> f32 {
        let place = self.sun_from_world * patch.middle;
        let size = patch.right.length() + patch.down.length();
        let mut blocked = 0;
        let mut models: Vec<&Caster> = Vec::new();
        for caster in among.filter(|caster| caster.is_near(place, size)) {
            match caster.form {
                Form::Shape(_) if blocked == u16::MAX => break,
                Form::Shape(shape) => blocked |= self.isa.run(&caster.beam(shape, patch)),
                _ => models.push(caster),
            }
        }
        if !models.is_empty() && blocked != u16::MAX {
            blocked |= self.blocked_by(&models, place, size, patch);
        }
        blocked.count_zeros() as f32 / LANES as f32
    }

    /// Returns which of sixteen rays are held up by models.
    fn blocked_by(&self, models: &[&Caster], place: DVec3, size: f64, patch: &LitPatch) -> u16 {
        let blocked = |on_patch: DVec2, on_sun: DVec2| {
            let origin = patch.middle + patch.right * on_patch.x + patch.down * on_patch.y;
            let aside = (on_sun * SUN).extend(1.0).normalize();
            let towards = self.sun_from_world.transpose() * aside;
            models.iter().any(|caster| caster.blocks(origin, towards))
        };
        if models.iter().all(|caster| caster.thickness >= THICK * caster.blur(place, size)) {
            let corners = [[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]]
                .map(|corner| blocked(corner.into(), corner.into()));
            let crossed = blocked(DVec2::new(-1.0, -1.0), DVec2::new(1.0, 1.0));
            if corners.iter().all(|corner| *corner == crossed) {
                return if crossed { u16::MAX } else { 0 };
            }
        }
        let [on_patch, on_sun] =
            PLACES.map(|[x, y]| move |ray: usize| DVec2::new(f64::from(x[ray]), f64::from(y[ray])));
        (0..LANES).fold(0, |all, ray| all | u16::from(blocked(on_patch(ray), on_sun(ray))) << ray)
    }
}

impl Bounds {
    fn at(place: DVec3, margin: f64) -> Self {
        Self { low: place - margin, high: place + margin }
    }

    /// Returns the box around both.
    pub fn with(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn grown(&self, margin: f64) -> Self {
        Self { low: self.low - margin, high: self.high + margin }
    }
}

impl Caster {
    fn new(body: &Body, sun_from_world: DMat3, eye: DVec3, curvature: Curvature) -> Self {
        let distance = (body.position - eye).truncate().length();
        let position = body.position - DVec3::Z * curvature.drop_at(distance);
        let (form, axes) = match body.form.shape() {
            Some((shape, axes)) => (Form::Shape(shape), axes),
            None => (body.form.clone(), DMat3::IDENTITY),
        };
        let world_from_body = body.world_from_body() * axes;
        let [low, high] = form.corners();
        let size = high - low;
        let world_from_sun = sun_from_world.transpose();
        let to_sun = [world_from_sun.z_axis, world_from_sun.x_axis * SUN, world_from_sun.y_axis * SUN]
            .map(|part| world_from_body.transpose() * part);

        Self {
            id: body.id,
            form,
            position,
            body_from_world: world_from_body.transpose(),
            to_sun,
            above: OnceLock::new(),
            place: sun_from_world * (position + world_from_body * (0.5 * (low + high))),
            radius: 0.5 * size.length(),
            thickness: size.min_element(),
        }
    }

    /// Returns how far beside the caster light may be missing for something `size` metres large at a place, metres.
    fn blur(&self, place: DVec3, size: f64) -> f64 {
        size + SUN * (self.place.z - place.z).max(0.0)
    }

    /// Whether it may hide the sun from something in a box.
    pub fn is_over(&self, bounds: &Bounds) -> bool {
        let reach = self.radius + SUN * (self.place.z - bounds.low.z).max(0.0);
        let beside = (bounds.low - self.place).max(self.place - bounds.high);
        beside.x <= reach && beside.y <= reach && self.place.z + self.radius >= bounds.low.z
    }

    /// The rays of a patch before its shape.
    fn beam(&self, shape: Shape, patch: &LitPatch) -> SunBeam {
        let origin = self.body_from_world * (patch.middle - self.position);
        let begin = -origin.dot(self.to_sun[0]);
        let aside = [patch.right, patch.down].map(|side| (self.body_from_world * side).as_vec3());
        SunBeam {
            shape,
            origin: [(origin + self.to_sun[0] * begin).as_vec3(), aside[0], aside[1]],
            direction: self.to_sun.map(DVec3::as_vec3),
            begin: begin as f32,
        }
    }

    fn is_near(&self, place: DVec3, size: f64) -> bool {
        let reach = self.radius + self.blur(place, size);
        self.place.z + self.radius + size > place.z
            && (self.place - place).truncate().length_squared() <= reach * reach
    }

    /// Whether it holds up light that comes to a point of the world from a direction.
    fn blocks(&self, point: DVec3, direction: DVec3) -> bool {
        let origin = self.body_from_world * (point - self.position);
        self.form.blocks(origin, self.body_from_world * direction, f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::space::Attitude;

    fn ball(id: u32, position: DVec3, radius: f64) -> Body {
        Body {
            id,
            form: Shape::Ellipsoid { radii: DVec3::splat(radius) }.into(),
            position,
            attitude: Attitude::default(),
            albedo: Vec3::ONE,
            priority: 0,
        }
    }

    fn casters(bodies: &[Body], to_sun: DVec3) -> Casters {
        Casters::new(bodies, to_sun, DVec3::ZERO, Curvature::FLAT, Isa::best())
    }

    /// Share of the sun at a point of the ground.
    fn share(casters: &Casters, point: DVec3) -> f32 {
        let patch = LitPatch { middle: point, right: DVec3::X * 0.01, down: DVec3::Y * 0.01 };
        let bounds = casters.bounds(std::iter::once(point), 0.02).unwrap();
        casters.share(&casters.over(&bounds), &patch)
    }

    #[test]
    fn a_balls_shadow_is_an_ellipse() {
        // The sun in the east, 30° high: the shadow's middle lies 20/tan 30° to the west, and it is twice as long as wide.
        let to_sun = DVec3::new(30.0_f64.to_radians().cos(), 0.0, 0.5);
        let casters = casters(&[ball(0, DVec3::new(0.0, 0.0, 20.0), 3.0)], to_sun);
        let middle = DVec3::new(-20.0 * 3.0_f64.sqrt(), 0.0, 0.0);
        let at = |x: f64, y: f64| share(&casters, middle + DVec3::new(x, y, 0.0));
        assert_eq!([at(0.0, 0.0), at(5.5, 0.0), at(0.0, 2.7)], [0.0; 3]);
        assert_eq!([at(6.6, 0.0), at(0.0, 3.3), at(-200.0, 0.0)], [1.0; 3]);
        // Forty metres behind its edge the half-shadow is 0.37 m wide.
        let [inner, edge, outer] = [-0.1, 0.0, 0.1].map(|beside| at(0.0, 3.0 + beside));
        assert!(inner < edge && edge < outer && (edge - 0.5).abs() < 0.15, "{inner} {edge} {outer}");
    }

    #[test]
    fn nothing_hides_the_sun_from_what_lies_between() {
        let to_sun = DVec3::Z;
        let casters = casters(&[ball(0, DVec3::ZERO, 3.0)], to_sun);
        assert_eq!(share(&casters, DVec3::new(0.0, 0.0, 4.0)), 1.0);
        assert_eq!(share(&casters, DVec3::new(0.0, 0.0, -4.0)), 0.0);
    }

    #[test]
    fn all_that_may_matter_are_found() {
        let to_sun = DVec3::new(0.3, -0.5, 0.4).normalize();
        let bodies: Vec<_> = (0..300)
            .map(|index| {
                let at = |step: f64| 200.0 * (f64::from(index) * step).fract();
                ball(index, DVec3::new(at(0.618), at(0.755), at(0.57) * 0.2), 0.5 + at(0.3) * 0.02)
            })
            .collect();
        let casters = casters(&bodies, to_sun);
        let all: Vec<_> = casters.casters.iter().collect();
        let mut dark = 0;

        for step in 0..4000 {
            let at = |by: f64| 260.0 * (f64::from(step) * by).fract() - 30.0;
            let point = DVec3::new(at(0.618), at(0.755), 0.0);
            let patch = LitPatch { middle: point, right: DVec3::X * 0.2, down: DVec3::Y * 0.2 };
            let bounds = casters.bounds(std::iter::once(point), 0.4).unwrap();
            let found = casters.share(&casters.over(&bounds), &patch);
            assert_eq!(found, casters.share(&all, &patch), "{point}");
            dark += u32::from(found < 1.0);
        }

        assert!(dark > 100, "{dark}");
    }
}
