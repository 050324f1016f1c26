//! Shadows that bodies throw.
//!
//! ```text
//! bodies as discs on a plane across the sun's rays, in order along one axis of it
//! some points → the bodies that may hide the sun from one of them
//! the patch of ground in a pixel → sixteen rays from all over it to all over the sun's disc, the share of them that none of these holds up
//! ```

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::{DMat3, DVec2, DVec3};

use super::body::world_from_body;
use super::{Body, Form};
use crate::earth::Curvature;
use crate::sunlight::SUN_SEMIDIAMETER;

/// Half of the sun's width, metres per metre.
const SUN: f64 = SUN_SEMIDIAMETER * std::f64::consts::PI / 180.0;

/// Rays from a patch.
const RAYS: usize = 16;

/// Where rays start in a patch, and where they end on the sun, both in a square from −1 to 1 each way: of lattices of sixteen points with one in every row and
/// column, two that share no direction.
const STEPS: [usize; 2] = [5, 7];

/// Times as thick as a patch and half-shadow together that bodies must be for what all four corners say to hold in between.
const THICK: f64 = 4.0;

/// How far from its own surface a body's ray starts, pixels: of a pixel with an edge in it means are known, not a point of the surface.
const STEP: f64 = 1.0;

/// Bodies under a sun.
#[derive(Debug)]
pub struct Casters {
    /// By place on the first axis of the plane across the sun's rays.
    casters: Vec<Caster>,
    /// Rows: two axes across the sun's rays, and the direction to it.
    sun_from_world: DMat3,
    /// Greatest radius of a body, and how near to the sun the nearest is, metres.
    widest: f64,
    nearest: f64,
    /// Numbers among all by the bodies' own numbers.
    by_id: HashMap<u32, usize>,
}

/// A body, and where it is seen from the sun.
#[derive(Debug)]
pub struct Caster {
    id: u32,
    form: Form,
    /// Metres in the world.
    position: DVec3,
    body_from_world: DMat3,
    /// Those that may hide the sun from some part of it, by their number among all; found when it is asked for first.
    above: OnceLock<Vec<usize>>,
    /// Middle of the sphere around it: place across the sun's rays, and how near it is to the sun, metres.
    place: DVec3,
    /// Metres.
    radius: f64,
    /// Least extent, metres.
    thickness: f64,
}

/// What a pixel holds of a surface.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    /// Metres in the world.
    pub middle: DVec3,
    /// From its middle to half a pixel to the right, and down, metres.
    pub right: DVec3,
    /// See [`Self::right`].
    pub down: DVec3,
}

impl Patch {
    /// A point of a body, where a pixel is so many metres wide, a little above its surface.
    pub fn above(point: DVec3, normal: DVec3, pixel: f64) -> Self {
        Self { middle: point + normal * (STEP * pixel), right: DVec3::ZERO, down: DVec3::ZERO }
    }
}

impl Casters {
    /// `bodies` under a sun in the direction `to_sun` (of unit length), lowered by the Earth's curvature as `eye` finds them.
    pub fn new(bodies: &[Body], to_sun: DVec3, eye: DVec3, curvature: Curvature) -> Self {
        let (right, up) = to_sun.any_orthonormal_pair();
        let sun_from_world = DMat3::from_cols(right, up, to_sun).transpose();
        let mut casters: Vec<_> =
            bodies.iter().map(|body| Caster::new(body, sun_from_world, eye, curvature)).collect();
        casters.sort_by(|a, b| a.place.x.total_cmp(&b.place.x).then(a.id.cmp(&b.id)));
        let widest = casters.iter().map(|caster| caster.radius).fold(0.0, f64::max);
        let nearest = casters.iter().map(|caster| caster.place.z).fold(f64::NEG_INFINITY, f64::max);
        let by_id = casters.iter().enumerate().map(|(number, caster)| (caster.id, number)).collect();
        Self { casters, sun_from_world, widest, nearest, by_id }
    }

    /// Those that may hide the sun from a point among `points` or up to `margin` metres beside the box around them.
    pub fn over(&self, points: impl Iterator<Item = DVec3>, margin: f64) -> Vec<&Caster> {
        let places = points.map(|point| self.sun_from_world * point);
        let [low, high] = places.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], place| {
            [low.min(place), high.max(place)]
        });
        self.between([low, high], margin).map(|number| &self.casters[number]).collect()
    }

    /// Numbers of those that may hide the sun from a box of places, or from up to `margin` metres beside it.
    fn between(&self, [low, high]: [DVec3; 2], margin: f64) -> impl Iterator<Item = usize> {
        // No half-shadow that counts is wider than that of the body that is nearest to the sun.
        let reach = self.widest + margin + SUN * (self.nearest - low.z).max(0.0);
        let from = self.casters.partition_point(|caster| caster.place.x < low.x - reach);
        let until = self.casters.partition_point(|caster| caster.place.x <= high.x + reach);
        let may = move |number: &usize| {
            let caster = &self.casters[*number];
            let reach = caster.radius + margin + SUN * (caster.place.z - low.z).max(0.0);
            let beside = (low - caster.place).max(caster.place - high);
            beside.x <= reach && beside.y <= reach && caster.place.z + caster.radius + margin >= low.z
        };
        (from..until.max(from)).filter(may)
    }

    /// Share of the sun's disc, 0…1, that others, or other parts of it, leave to a patch of body `id`. What is convex hides nothing from itself that Lambert's law
    /// does not.
    pub fn share_of_body(&self, id: u32, patch: &Patch) -> f32 {
        let Some(own) = self.by_id.get(&id).map(|number| &self.casters[*number]) else { return 1.0 };
        let above = own.above.get_or_init(|| {
            let margin = own.radius;
            let others = self.between([own.place; 2], margin);
            others
                .filter(|number| self.casters[*number].id != id || matches!(own.form, Form::Model(_)))
                .collect()
        });
        if above.is_empty() {
            return 1.0;
        }
        let among: Vec<_> = above.iter().map(|number| &self.casters[*number]).collect();
        self.share(&among, patch)
    }

    /// Whether one `among` them may hide the sun from something up to `size` metres around a point.
    pub fn is_near(&self, among: &[&Caster], point: DVec3, size: f64) -> bool {
        let place = self.sun_from_world * point;
        among.iter().any(|caster| caster.is_near(place, size))
    }

    /// Share of the sun's disc, 0…1, that bodies `among` them leave to a patch.
    pub fn share(&self, among: &[&Caster], patch: &Patch) -> f32 {
        let place = self.sun_from_world * patch.middle;
        let size = patch.right.length() + patch.down.length();
        let near: Vec<_> = among.iter().filter(|caster| caster.is_near(place, size)).collect();
        if near.is_empty() {
            return 1.0;
        }
        let blocked = |on_patch: DVec2, on_sun: DVec2| {
            let origin = patch.middle + patch.right * on_patch.x + patch.down * on_patch.y;
            let aside = (on_sun * SUN).extend(1.0).normalize();
            let towards = self.sun_from_world.transpose() * aside;
            near.iter().any(|caster| caster.blocks(origin, towards))
        };
        if near.iter().all(|caster| caster.thickness >= THICK * caster.blur(place, size)) {
            let corners = [[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]]
                .map(|corner| blocked(corner.into(), corner.into()));
            let crossed = blocked(DVec2::new(-1.0, -1.0), DVec2::new(1.0, 1.0));
            if corners.iter().all(|corner| *corner == crossed) {
                return if crossed { 0.0 } else { 1.0 };
            }
        }
        let lattice = |step: usize, ray: usize| {
            let at = |index: usize| (2 * index + 1) as f64 / RAYS as f64 - 1.0;
            DVec2::new(at(ray), at(ray * step % RAYS))
        };
        let free = (0..RAYS).filter(|ray| {
            // A disc of the square's points.
            let on_sun = lattice(STEPS[1], ray * 3 % RAYS);
            let on_sun = on_sun * on_sun.abs().max_element() / on_sun.length();
            !blocked(lattice(STEPS[0], *ray), on_sun)
        });
        free.count() as f32 / RAYS as f32
    }
}

impl Caster {
    fn new(body: &Body, sun_from_world: DMat3, eye: DVec3, curvature: Curvature) -> Self {
        let distance = (body.position - eye).truncate().length();
        let position = body.position - DVec3::Z * curvature.drop_at(distance);
        let world_from_body = world_from_body(body.attitude);
        let [low, high] = body.form.corners();
        let size = high - low;
        Self {
            id: body.id,
            form: body.form.clone(),
            position,
            body_from_world: world_from_body.transpose(),
            above: OnceLock::new(),
            place: sun_from_world * (position + world_from_body * (0.5 * (low + high))),
            radius: 0.5 * size.length(),
            thickness: size.min_element(),
        }
    }

    /// How far beside it light may be missing for something `size` metres large at a place, metres.
    fn blur(&self, place: DVec3, size: f64) -> f64 {
        size + SUN * (self.place.z - place.z).max(0.0)
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
    use crate::objects::Shape;
    use crate::space::Attitude;

    fn ball(id: u32, position: DVec3, radius: f64) -> Body {
        Body {
            id,
            form: Shape::Ellipsoid { radii: DVec3::splat(radius) }.into(),
            position,
            attitude: Attitude::default(),
            albedo: Vec3::ONE,
        }
    }

    /// Share of the sun at a point of the ground.
    fn share(casters: &Casters, point: DVec3) -> f32 {
        let patch = Patch { middle: point, right: DVec3::X * 0.01, down: DVec3::Y * 0.01 };
        casters.share(&casters.over(std::iter::once(point), 0.0), &patch)
    }

    #[test]
    fn a_balls_shadow_is_an_ellipse() {
        // The sun in the east, 30° high: the shadow's middle lies 20/tan 30° to the west, and it is twice as long as wide.
        let to_sun = DVec3::new(30.0_f64.to_radians().cos(), 0.0, 0.5);
        let casters =
            Casters::new(&[ball(0, DVec3::new(0.0, 0.0, 20.0), 3.0)], to_sun, DVec3::ZERO, Curvature::FLAT);
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
        let casters = Casters::new(&[ball(0, DVec3::ZERO, 3.0)], to_sun, DVec3::ZERO, Curvature::FLAT);
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
        let casters = Casters::new(&bodies, to_sun, DVec3::ZERO, Curvature::FLAT);
        let all: Vec<_> = casters.casters.iter().collect();
        let mut dark = 0;
        for step in 0..4000 {
            let at = |by: f64| 260.0 * (f64::from(step) * by).fract() - 30.0;
            let point = DVec3::new(at(0.618), at(0.755), 0.0);
            let patch = Patch { middle: point, right: DVec3::X * 0.2, down: DVec3::Y * 0.2 };
            let found = casters.share(&casters.over(std::iter::once(point), 0.4), &patch);
            assert_eq!(found, casters.share(&all, &patch), "{point}");
            dark += u32::from(found < 1.0);
        }
        assert!(dark > 100, "{dark}");
    }
}
