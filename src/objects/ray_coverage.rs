//! Coverage of a pixel by bodies, in rays that meet them: the twin of [`super::shape`]'s closed forms, for sixteen rays at a time.
//!
//! Rays start beside the body that they are held against, not at the eye, so that single precision is enough. Where a ray lies in a pixel it differs from
//! the middle one by a multiple of what a pixel to the right and one down add to it. Loops stand for `map`: its closures are not inlined into
//! code of an instruction set.

mod alone;
mod meshes;
mod sun;

use glam::{DVec2, DVec3, Vec3};

use super::Shape;
use super::body::PlacedBody;
use super::lens::{Lens, Line};
use super::mesh::Basis;
use super::rank::TIE;
use crate::objects::PixelGround;
use crate::simd::{Floats, Kernel, LANES, Mask, Simd, Sixteen};

pub(super) use alone::{FEW, Grounds, PixelMiddles, PixelRays, PixelRow};
pub(super) use meshes::{CountAll, MeshItem, MeshPatch, Probe};
pub(super) use sun::{PLACES, SunBeam};

/// Rays of a pixel in which an edge may lie, and columns of their lattice from one row to the next: of all lattices of 96 points that with the most exact
/// shares of half planes, 0.0051 off in the mean, half as much as 64 points of Hammersley's.
pub(super) const RAYS: usize = 96;
const STEP: usize = 43;

/// Least cosine between normals of one face, which are lit alike: one of them may stand for all.
pub(super) const ONE_FACE: f32 = 0.96;

/// Distance beyond all others, and slowness beyond any direction's.
const FAR: f32 = 1.0e30;
const SLOW: f32 = 1.0e-12;

/// A vector of the middle ray, and what a pixel to the right and one down add to it.
type Bundle = [Vec3; 3];

/// Rays of a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pencil {
    /// Metres in the world.
    origin: [DVec3; 3],
    /// Direction, of any length, about 1.
    direction: [DVec3; 3],
}

/// A body before a pencil.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    shape: Shape,
    /// Origin in the body's axes, `begin` away from where rays start.
    origin: Bundle,
    direction: Bundle,
    /// Multiples of the direction.
    begin: f32,
    /// Columns: the body's axes in the world.
    axes: [Vec3; 3],
    albedo: Vec3,
    /// Number of aims before it whose bodies have a higher priority.
    pub higher: usize,
}

/// Rays that see one face of a body, or nearly so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenFace {
    /// Index of the body's aim.
    pub aim: usize,
    pub rays: u32,
    /// Mean of the unit normals, world axes.
    pub normal: Vec3,
    /// Mean, metres.
    pub range: f32,
    /// Mean, linear.
    pub albedo: Vec3,
}

/// Counts the rays of a pixel by what they see first.
pub(super) struct Count<'a> {
    pub aims: &'a [Aim],
    pub pencil: &'a Pencil,
    pub ground: &'a PixelGround,
    /// Output for the faces that are seen.
    pub faces: &'a mut Vec<SeenFace>,
}

/// Sixteen vectors.
type Lanes<F> = [F; 3];

/// First hits of sixteen rays.
#[derive(Clone, Copy)]
struct FirstHits<V: Simd> {
    /// Multiples of the direction.
    at: V::F,
    /// Index of the aim; −1: the ground, or the sky.
    aim: V::F,
    normal: Lanes<V::F>,
    /// Metres per unit of `at`.
    metres: V::F,
}

/// Stretches of rays inside of a shape.
struct InsideStretch<V: Simd> {
    /// Stretch inside its round or slanting side, and between its bounds above and below.
    side: [V::F; 2],
    caps: [V::F; 2],
    /// The line meets the side at all.
    meets: V::M,
}

impl<V: Simd> FirstHits<V> {
    /// Returns multiples of the direction up to which an aim comes before what is seen, if so many aims before it have a higher priority.
    #[inline(always)]
    fn limit(&self, simd: V, higher: usize) -> V::F {
        if higher == 0 {
            return self.at;
        }
        let yields = simd.splat(0.0).le(self.aim) & self.aim.lt(simd.splat(higher as f32));
        (self.at * simd.splat((1.0 - TIE) as f32)).select(yields, self.at)
    }
}

impl Pencil {
    /// Rays about a position of a screen; `None` where there are none.
    pub fn new(lens: &Lens<'_>, middle: DVec2) -> Option<Self> {
        let own = lens.line(middle)?;
        let length = own.direction.length();
        let (start, towards) = (|line: Line| line.origin(lens.camera), |line: Line| line.direction / length);
        // At the rim of a screen one of the two neighbours is not there.
        let next = |offset: DVec2| {
            let found =
                [1.0, -1.0].into_iter().find_map(|sign| Some((sign, lens.line(middle + offset * sign)?)));
            found.map_or([DVec3::ZERO; 2], |(sign, line)| {
                [start(line) - start(own), towards(line) - towards(own)].map(|step| step * sign * 2.0)
            })
        };
        let [right, down] = [DVec2::new(0.5, 0.0), DVec2::new(0.0, 0.5)].map(next);
        Some(Self { origin: [start(own), right[0], down[0]], direction: [towards(own), right[1], down[1]] })
    }

    /// Coordinates of the screen for a mesh in the place of `body`; `None`: the pencil has no width.
    pub fn basis(&self, body: &PlacedBody, middle: DVec3) -> Option<Basis> {
        let turned = |vectors: [DVec3; 3]| vectors.map(|vector| body.body_from_world * vector);
        let [origin, right, down] = self.origin;
        Basis::new(turned([origin - body.position, right, down]), turned(self.direction), middle, body.radius)
    }

    /// Aims at a `shape` in the place of `body`.
    pub fn aim(&self, body: &PlacedBody, shape: Shape) -> Aim {
        let [middle, ..] = self.direction;
        let begin = (body.centre - self.origin[0]).dot(middle) / middle.length_squared();
        let [origin, direction] = [self.origin, self.direction];
        let near = [0, 1, 2].map(|part| {
            let from = if part == 0 { origin[0] - body.position } else { origin[part] };
            (body.body_from_world * (from + direction[part] * begin)).as_vec3()
        });
        Aim {
            shape,
            origin: near,
            direction: direction.map(|part| (body.body_from_world * part).as_vec3()),
            begin: begin as f32,
            axes: body.axes(),
            albedo: body.albedo,
            higher: 0,
        }
    }
}

/// Offsets of the rays, sixteen at a time, from the middle of a pixel, pixels to the right and down.
pub(super) const ALL: [[[f32; LANES]; 2]; RAYS / LANES] = {
    let mut offsets = [[[0.0; LANES]; 2]; RAYS / LANES];
    let mut ray = 0;
    while ray < RAYS {
        let [right, down] = &mut offsets[ray / LANES];
        right[ray % LANES] = (ray as f32 + 0.5) / RAYS as f32 - 0.5;
        down[ray % LANES] = ((ray * STEP % RAYS) as f32 + 0.5) / RAYS as f32 - 0.5;
        ray += 1;
    }
    offsets
};

impl Kernel for Count<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { aims, pencil, ground, faces } = self;
        let zero = simd.splat(0.0);
        let mut batches =
            [FirstHits::<V> { at: zero, aim: zero, normal: [zero; 3], metres: zero }; RAYS / LANES];
        for (batch, seen) in batches.iter_mut().enumerate() {
            let [x, y] = &ALL[batch];
            let offsets = [simd.load(x), simd.load(y)];
            *seen = begin_rays(simd, pencil, ground, offsets);
            for (index, aim) in aims.iter().enumerate() {
                aim.look(simd, index, offsets, seen);
            }
        }
        for (index, aim) in aims.iter().enumerate() {
            count_faces(simd, index, aim.albedo, &batches, faces);
        }
    }
}

/// Begins sixteen rays, which see nothing but the ground as yet.
#[inline(always)]
fn begin_rays<V: Simd>(simd: V, pencil: &Pencil, ground: &PixelGround, offsets: [V::F; 2]) -> FirstHits<V> {
    let zero = simd.splat(0.0);
    let direction = pencil.direction.map(DVec3::as_vec3);
    let direction = spread(simd, &direction, offsets);
    let metres = dot::<V>(direction, direction).sqrt();
    let inverse = offsets[1].mul_add(
        simd.splat(ground.slope[1]),
        offsets[0].mul_add(simd.splat(ground.slope[0]), simd.splat(ground.inverse)),
    );
    let behind = (inverse * metres).max(simd.splat(1.0 / FAR)).recip();
    FirstHits { at: behind, aim: simd.splat(-1.0), normal: [zero; 3], metres }
}

/// Puts what rays see of a body into two faces at most: one of the first ray that meets it, and one of all others.
#[inline(always)]
fn count_faces<V: Simd>(
    simd: V,
    aim: usize,
    albedo: Vec3,
    batches: &[FirstHits<V>],
    faces: &mut Vec<SeenFace>,
) {
    let own = simd.splat(aim as f32);
    let mut first = None;
    for seen in batches {
        let bits = is_of(seen, own).bits();
        if bits != 0 {
            first = Some((seen.normal, bits.trailing_zeros() as usize));
            break;
        }
    }

    let Some(([x, y, z], lane)) = first else { return };
    let normal = [simd.splat(lane_of(x, lane)), simd.splat(lane_of(y, lane)), simd.splat(lane_of(z, lane))];
    let zero = simd.splat(0.0);
    for is_first in [true, false] {
        let (mut rays, mut sums) = (0, [zero; 4]);
        for seen in batches {
            let alike = simd.splat(ONE_FACE).le(dot::<V>(seen.normal, normal));
            let mask = is_of(seen, own) & if is_first { alike } else { !alike };
            rays += mask.bits().count_ones();
            let [x, y, z] = seen.normal;
            let values = [x, y, z, seen.at * seen.metres];
            for index in 0..4 {
                sums[index] = sums[index] + values[index].select(mask, zero);
            }
        }

        if rays > 0 {
            let [x, y, z, range] = sums;
            let normal = Vec3::new(total(x), total(y), total(z)) / rays as f32;
            faces.push(SeenFace { aim, rays, normal, range: total(range) / rays as f32, albedo });
        }
    }
}

/// Rays that see the body of an aim.
#[inline(always)]
fn is_of<V: Simd>(seen: &FirstHits<V>, aim: V::F) -> V::M {
    seen.aim.le(aim) & aim.le(seen.aim)
}

#[inline(always)]
fn lane_of<F: Floats>(lanes: F, lane: usize) -> f32 {
    let mut all = Sixteen::default();
    lanes.store(&mut all.0);
    all.0[lane]
}

#[inline(always)]
fn total<F: Floats>(lanes: F) -> f32 {
    let mut all = Sixteen::default();
    lanes.store(&mut all.0);
    all.0.iter().sum()
}

/// Vectors of sixteen rays.
#[inline(always)]
fn spread<V: Simd>(simd: V, [middle, right, down]: &Bundle, [x, y]: [V::F; 2]) -> Lanes<V::F> {
    let mut lanes = [x; 3];
    for axis in 0..3 {
        let across = x.mul_add(simd.splat(right[axis]), simd.splat(middle[axis]));
        lanes[axis] = y.mul_add(simd.splat(down[axis]), across);
    }
    lanes
}

#[inline(always)]
fn dot<V: Simd>(a: Lanes<V::F>, b: Lanes<V::F>) -> V::F {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Along the first two axes.
#[inline(always)]
fn flat<V: Simd>(a: Lanes<V::F>, b: Lanes<V::F>) -> V::F {
    a[1].mul_add(b[1], a[0] * b[0])
}

#[inline(always)]
fn times<V: Simd>(simd: V, lanes: Lanes<V::F>, by: Vec3) -> Lanes<V::F> {
    [lanes[0] * simd.splat(by.x), lanes[1] * simd.splat(by.y), lanes[2] * simd.splat(by.z)]
}

/// Points of rays.
#[inline(always)]
fn along<F: Floats>(origin: Lanes<F>, direction: Lanes<F>, at: F) -> Lanes<F> {
    let [x, y, z] = direction;
    [x.mul_add(at, origin[0]), y.mul_add(at, origin[1]), z.mul_add(at, origin[2])]
}

/// Roots of a·t² + 2b·t + c, where there are some; `a` is not 0.
#[inline(always)]
fn roots<V: Simd>(simd: V, a: V::F, b: V::F, c: V::F) -> ([V::F; 2], V::M) {
    let square = b * b - a * c;
    let zero = simd.splat(0.0);
    let (half, inverse) = (square.max(zero).sqrt(), a.recip());
    let [first, second] = [(zero - b - half) * inverse, (half - b) * inverse];
    ([first.min(second), first.max(second)], zero.le(square))
}

/// Keeps a divisor away from 0.
#[inline(always)]
fn not_zero<V: Simd>(simd: V, value: V::F) -> V::F {
    let slow = simd.splat(SLOW);
    slow.select(value.abs().lt(slow), value)
}

/// Between two planes across an axis.
#[inline(always)]
fn between<V: Simd>(simd: V, at: V::F, speed: V::F, low: f32, high: f32) -> [V::F; 2] {
    let inverse = not_zero(simd, speed).recip();
    let (first, second) = ((simd.splat(low) - at) * inverse, (simd.splat(high) - at) * inverse);
    [first.min(second), first.max(second)]
}

/// Finds the stretches of sixteen rays in a shape.
#[inline(always)]
fn inside<V: Simd>(simd: V, shape: &Shape, origin: Lanes<V::F>, direction: Lanes<V::F>) -> InsideStretch<V> {
    let all = [simd.splat(-FAR), simd.splat(FAR)];
    let always = simd.mask(u16::MAX);
    match *shape {
        Shape::Ellipsoid { radii } => {
            let inverse = radii.recip().as_vec3();
            let (origin, direction) = (times(simd, origin, inverse), times(simd, direction, inverse));
            let (side, meets) = roots(
                simd,
                dot::<V>(direction, direction),
                dot::<V>(origin, direction),
                dot::<V>(origin, origin) - simd.splat(1.0),
            );
            InsideStretch { side, caps: all, meets }
        }
        Shape::Box { size } => {
            let half = (0.5 * size).as_vec3();
            let x = between(simd, origin[0], direction[0], -half.x, half.x);
            let y = between(simd, origin[1], direction[1], -half.y, half.y);
            let side = [x[0].max(y[0]), x[1].min(y[1])];
            let caps = between(simd, origin[2], direction[2], 0.0, size.z as f32);
            InsideStretch { side, caps, meets: always }
        }
        Shape::Cylinder { radius, height } => {
            let (side, meets) = roots(
                simd,
                flat::<V>(direction, direction).max(simd.splat(SLOW)),
                flat::<V>(origin, direction),
                flat::<V>(origin, origin) - simd.splat((radius * radius) as f32),
            );
            let caps = between(simd, origin[2], direction[2], 0.0, height as f32);
            InsideStretch { side, caps, meets }
        }
        Shape::Cone { radius, height } => {
            let slope = simd.splat((radius / height * (radius / height)) as f32);
            let below = [origin[0], origin[1], origin[2] - simd.splat(height as f32)];
            let a = flat::<V>(direction, direction) - direction[2] * direction[2] * slope;
            let a = not_zero(simd, a);
            let b = flat::<V>(below, direction) - below[2] * direction[2] * slope;
            let c = flat::<V>(below, below) - below[2] * below[2] * slope;
            let ([low, high], meets) = roots(simd, a, b, c);

            // Steep rays leave one half of the double cone and enter the other, of which the lower one counts.
            let zero = simd.splat(0.0);
            let (is_steep, sinks) = (a.lt(zero), direction[2].lt(zero));
            let steep = [high.select(sinks, all[0]), all[1].select(sinks, low)];
            let side = [steep[0].select(is_steep, low), steep[1].select(is_steep, high)];
            let caps = between(simd, origin[2], direction[2], 0.0, height as f32);

            InsideStretch { side, caps, meets }
        }
        Shape::Ellipse { radii } => {
            let at = (simd.splat(0.0) - origin[2]) * not_zero(simd, direction[2]).recip();
            let point = times(simd, along(origin, direction, at), radii.recip().as_vec2().extend(0.0));
            let meets = flat::<V>(point, point).le(simd.splat(1.0));
            InsideStretch { side: all, caps: [at; 2], meets }
        }
    }
}

impl Aim {
    /// Keeps what of the body lies before what sixteen rays have `seen` so far.
    #[inline(always)]
    fn look<V: Simd>(&self, simd: V, index: usize, offsets: [V::F; 2], seen: &mut FirstHits<V>) {
        let origin = spread(simd, &self.origin, offsets);
        let direction = spread(simd, &self.direction, offsets);
        let InsideStretch { side, caps, meets } = inside(simd, &self.shape, origin, direction);
        let (enter, leave) = (side[0].max(caps[0]), side[1].min(caps[1]));
        let begin = simd.splat(-self.begin);
        let starts_outside = begin.le(enter);

        // From inside, the inner side is seen.
        let at = enter.select(starts_outside, leave);
        let is_cap = starts_outside & side[0].lt(caps[0]) | !starts_outside & caps[1].lt(side[1]);
        let far = at - begin;
        let is_seen = meets & enter.le(leave) & begin.le(leave) & far.lt(seen.limit(simd, self.higher));
        if !is_seen.any() {
            return;
        }

        let point = along(origin, direction, at);
        let normal = self.normal(simd, point, direction, is_cap);
        seen.at = far.select(is_seen, seen.at);
        seen.aim = simd.splat(index as f32).select(is_seen, seen.aim);

        for axis in 0..3 {
            let [right, forward, up] = &self.axes;
            let turned = normal[1].mul_add(simd.splat(forward[axis]), normal[0] * simd.splat(right[axis]));
            let turned = normal[2].mul_add(simd.splat(up[axis]), turned);
            seen.normal[axis] = turned.select(is_seen, seen.normal[axis]);
        }
    }

    /// Unit normals towards where rays come from, in the body's axes.
    #[inline(always)]
    fn normal<V: Simd>(
        &self,
        simd: V,
        point: Lanes<V::F>,
        direction: Lanes<V::F>,
        is_cap: V::M,
    ) -> Lanes<V::F> {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let [x, y, z] = point;
        let side = match self.shape {
            Shape::Ellipsoid { radii } => times(simd, point, (radii * radii).recip().as_vec3()),
            Shape::Box { size } => {
                let across = x.abs() * simd.splat((1.0 / size.x) as f32);
                let along = y.abs() * simd.splat((1.0 / size.y) as f32);
                let is_across = along.le(across);
                [x.select(is_across, zero), zero.select(is_across, y), zero]
            }
            Shape::Cylinder { .. } | Shape::Ellipse { .. } => [x, y, zero],
            Shape::Cone { radius, height } => {
                let slope = (radius / height * (radius / height)) as f32;
                [x, y, (simd.splat(height as f32) - z) * simd.splat(slope)]
            }
        };

        let normal =
            [zero.select(is_cap, side[0]), zero.select(is_cap, side[1]), one.select(is_cap, side[2])];
        let length = dot::<V>(normal, normal).max(simd.splat(SLOW * SLOW)).rsqrt();
        let length = (zero - length).select(zero.lt(dot::<V>(normal, direction)), length);

        [normal[0] * length, normal[1] * length, normal[2] * length]
    }
}

#[cfg(test)]
mod tests;
