//! Shapes with a closed form.

use glam::{DVec2, DVec3};

/// A solid or a flat ellipse, in axes of its own: x right, y forward, z up, metres. All are convex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Around the origin.
    Ellipsoid {
        /// Half axes, metres, > 0; equal ones make a sphere.
        radii: DVec3,
    },
    /// Stands on the origin.
    Box {
        /// Sides, metres, > 0.
        size: DVec3,
    },
    /// Upright on the origin.
    Cylinder {
        /// Metres, > 0.
        radius: f64,
        /// Metres, > 0.
        height: f64,
    },
    /// Upright on the origin, its tip up.
    Cone {
        /// Radius of the base, metres, > 0.
        radius: f64,
        /// Metres, > 0.
        height: f64,
    },
    /// Level, around the origin, seen from both sides.
    Ellipse {
        /// Half axes to the right and forward, metres, > 0.
        radii: DVec2,
    },
}

/// Hit of a ray on a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    /// Multiples of the ray's direction, ≥ 0.
    pub range: f64,
    /// Normal towards where the ray comes from, not of unit length.
    pub normal: DVec3,
}

/// The part of a line that lies inside of something convex, and the outward normals at its ends.
#[derive(Debug, Clone, Copy)]
struct Inside {
    from: f64,
    to: f64,
    normals: [DVec3; 2],
}

impl Shape {
    /// Makes an ellipse that is a circle, of `radius` metres, > 0.
    pub const fn disc(radius: f64) -> Self {
        Self::Ellipse { radii: DVec2::splat(radius) }
    }

    /// Least and greatest corner of the box around it, metres.
    pub fn corners(&self) -> [DVec3; 2] {
        let upright = |radius: f64, height: f64| {
            [DVec3::new(-radius, -radius, 0.0), DVec3::new(radius, radius, height)]
        };
        match *self {
            Self::Ellipsoid { radii } => [-radii, radii],
            Self::Box { size: DVec3 { x, y, z } } => {
                [DVec3::new(-0.5 * x, -0.5 * y, 0.0), DVec3::new(0.5 * x, 0.5 * y, z)]
            }
            Self::Cylinder { radius, height } | Self::Cone { radius, height } => upright(radius, height),
            Self::Ellipse { radii } => [(-radii).extend(0.0), radii.extend(0.0)],
        }
    }

    /// A shape that holds all that is up to `margin` metres from this one, and how far below this one's origin its own lies, metres; `None`: no closed form
    /// does so closely.
    pub(super) fn grown(&self, margin: f64) -> Option<(Self, f64)> {
        match *self {
            Self::Ellipsoid { radii } if radii.min_element() == radii.max_element() => {
                Some((Self::Ellipsoid { radii: radii + margin }, 0.0))
            }
            Self::Cylinder { radius, height } => {
                Some((Self::Cylinder { radius: radius + margin, height: height + 2.0 * margin }, margin))
            }
            Self::Cone { radius, height } => {
                // Its side moves outward by the margin, its tip by more.
                let taller = height + margin + margin * radius.hypot(height) / radius;
                Some((Self::Cone { radius: radius * taller / height, height: taller }, margin))
            }
            Self::Ellipsoid { .. } | Self::Box { .. } | Self::Ellipse { .. } => None,
        }
    }

    /// Finds where the ray from `origin` in `direction` (of any length but 0) first meets the shape; from inside, its inner side.
    pub(super) fn touch(&self, origin: DVec3, direction: DVec3) -> Option<Touch> {
        let Self::Ellipse { radii } = *self else { return self.touch_solid(origin, direction) };
        let range = -origin.z / direction.z;
        let place = (origin + direction * range).truncate() / radii;
        let meets = range >= 0.0 && place.length_squared() <= 1.0;
        let normal = DVec3::Z * -direction.z.signum();
        meets.then_some(Touch { range, normal })
    }

    fn touch_solid(&self, origin: DVec3, direction: DVec3) -> Option<Touch> {
        let Inside { from, to, normals } = self.inside(origin, direction)?;
        if from > to || to < 0.0 {
            return None;
        }
        Some(if from >= 0.0 {
            Touch { range: from, normal: normals[0] }
        } else {
            Touch { range: to, normal: -normals[1] }
        })
    }

    /// The part of a line that lies in the solid; `None`, or an end before its beginning: none does.
    fn inside(&self, origin: DVec3, direction: DVec3) -> Option<Inside> {
        match *self {
            Self::Ellipsoid { radii } => {
                let (origin, direction) = (origin / radii, direction / radii);
                let [from, to] = roots(
                    direction.length_squared(),
                    origin.dot(direction),
                    // Of the line's nearest point, whose digits a difference of squares would lose.
                    origin.cross(direction).length_squared(),
                    direction.length_squared(),
                )?;
                let normal = |at: f64| (origin + direction * at) / radii;
                Some(Inside { from, to, normals: [normal(from), normal(to)] })
            }
            Self::Box { size } => {
                let along =
                    |axis: usize, low: f64, high: f64| Inside::between(axis, low, high, origin, direction);
                let wide = along(0, -0.5 * size.x, 0.5 * size.x)?.and(along(1, -0.5 * size.y, 0.5 * size.y)?);
                Some(wide.and(along(2, 0.0, size.z)?))
            }
            Self::Cylinder { radius, height } => {
                let (flat, level) = (origin.truncate(), direction.truncate());
                let round = if level.length_squared() > 0.0 {
                    let square = level.length_squared();
                    let offset = flat.perp_dot(level);
                    let [from, to] =
                        roots(square, flat.dot(level), offset * offset, square * radius * radius)?;
                    let normal = |at: f64| (flat + level * at).extend(0.0);
                    Inside { from, to, normals: [normal(from), normal(to)] }
                } else if flat.length_squared() <= radius * radius {
                    Inside::ALL
                } else {
                    return None;
                };

                Some(round.and(Inside::between(2, 0.0, height, origin, direction)?))
            }
            Self::Cone { radius, height } => {
                let slab = Inside::between(2, 0.0, height, origin, direction)?;
                Some(cone(radius / height, origin - DVec3::Z * height, direction)?.and(slab))
            }
            Self::Ellipse { .. } => None,
        }
    }
}

/// Solves `a²(t + b/a)² = limit − offset`, the lesser root first; `None` where that is negative.
fn roots(a: f64, b: f64, offset: f64, limit: f64) -> Option<[f64; 2]> {
    let half = (limit - offset).sqrt();
    (limit >= offset).then(|| [(-b - half) / a, (-b + half) / a])
}

/// The part of a line in the cone below its tip, the origin, that widens by `slope` per metre.
fn cone(slope: f64, origin: DVec3, direction: DVec3) -> Option<Inside> {
    let square = slope * slope;
    let product = |a: DVec3, b: DVec3| a.x * b.x + a.y * b.y - square * a.z * b.z;
    let (a, b, c) = (product(direction, direction), product(origin, direction), product(origin, origin));
    let normal = |at: f64| {
        let point = origin + direction * at;
        DVec3::new(point.x, point.y, -square * point.z)
    };
    let half = b * b - a * c;

    // Below the tip is one of the two halves of the double cone.
    let is_below = |at: f64| origin.z + direction.z * at <= 0.0;
    if half < 0.0 {
        return (a < 0.0 && is_below(0.0)).then_some(Inside::ALL);
    }

    // Without the difference of like numbers.
    let sum = -(b + half.sqrt().copysign(b));
    let [first, second] = if sum == 0.0 { [0.0; 2] } else { [sum / a, c / sum] };
    let [low, high] = [first.min(second), first.max(second)];
    if a > 0.0 {
        return is_below(0.5 * (low + high)).then(|| Inside {
            from: low,
            to: high,
            normals: [normal(low), normal(high)],
        });
    }

    // The line leaves one half and enters the other.
    let (never, unknown) = (f64::INFINITY, DVec3::Z);
    if direction.z < 0.0 {
        let at = if a == 0.0 { c / (-2.0 * b) } else { high };
        Some(Inside { from: at, to: never, normals: [normal(at), unknown] })
    } else {
        let at = if a == 0.0 { c / (-2.0 * b) } else { low };
        Some(Inside { from: -never, to: at, normals: [unknown, normal(at)] })
    }
}

impl Inside {
    /// A line that is inside all along.
    const ALL: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY, normals: [DVec3::Z; 2] };

    /// Between two planes across an axis.
    fn between(axis: usize, low: f64, high: f64, origin: DVec3, direction: DVec3) -> Option<Self> {
        let (at, speed) = (origin[axis], direction[axis]);
        if speed == 0.0 {
            return (at >= low && at <= high).then_some(Self::ALL);
        }
        let outward = DVec3::AXES[axis] * speed.signum();
        let [from, to] = if speed > 0.0 { [low, high] } else { [high, low] };
        Some(Self { from: (from - at) / speed, to: (to - at) / speed, normals: [-outward, outward] })
    }

    /// Inside of both.
    fn and(self, other: Self) -> Self {
        let (enters, leaves) = (other.from > self.from, other.to < self.to);
        Self {
            from: if enters { other.from } else { self.from },
            to: if leaves { other.to } else { self.to },
            normals: [
                if enters { other.normals[0] } else { self.normals[0] },
                if leaves { other.normals[1] } else { self.normals[1] },
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 7] = [
        Shape::Ellipsoid { radii: DVec3::new(2.0, 2.0, 2.0) },
        Shape::Ellipsoid { radii: DVec3::new(1.0, 4.0, 0.5) },
        Shape::Box { size: DVec3::new(2.0, 6.0, 3.0) },
        Shape::Cylinder { radius: 1.5, height: 4.0 },
        Shape::Cone { radius: 2.0, height: 5.0 },
        Shape::disc(3.0),
        Shape::Ellipse { radii: DVec2::new(1.5, 5.0) },
    ];

    /// How far inside a point is, by another way than the library's; 0 on the surface.
    fn depth(shape: &Shape, point: DVec3) -> f64 {
        let flat = point.truncate().length();
        match *shape {
            Shape::Ellipsoid { radii } => 1.0 - (point / radii).length(),
            Shape::Box { size } => {
                let middle = (point - DVec3::Z * 0.5 * size.z).abs();
                (0.5 * size - middle).min_element()
            }
            Shape::Cylinder { radius, height } => (radius - flat).min(point.z).min(height - point.z),
            Shape::Cone { radius, height } => (radius * (1.0 - point.z / height) - flat).min(point.z),
            Shape::Ellipse { radii } => (1.0 - (point.truncate() / radii).length()).min(0.0) - point.z.abs(),
        }
    }

    /// Rays from around, most of them towards the shape.
    fn rays() -> impl Iterator<Item = (DVec3, DVec3)> {
        let angle = |index: u32, step: f64| f64::from(index) * step;
        (0..4000_u32).map(move |index| {
            let (sin, cos) = angle(index, 2.399_963).sin_cos();
            let (lift, level) = angle(index, 0.754_877).sin_cos();
            let origin = DVec3::new(sin * level, cos * level, lift) * (7.0 + angle(index % 50, 20.0));
            let (x, y) = angle(index, 1.3).sin_cos();
            let target = DVec3::new(2.0 * x, 3.0 * y, angle(index % 7, 0.5));
            (origin, target - origin)
        })
    }

    #[test]
    fn rays_end_on_the_surface_and_nowhere_before() {
        for shape in SHAPES {
            let mut met = 0;
            for (origin, direction) in rays() {
                let touch = shape.touch(origin, direction);
                met += u32::from(touch.is_some());
                if let Some(Touch { range, normal }) = touch {
                    let on = depth(&shape, origin + direction * range);
                    assert!(on.abs() < 1e-9, "{shape:?}: {on}");
                    assert!(normal.dot(direction) <= 0.0, "{shape:?}: a normal that looks away");
                }
                let until = touch.map_or(2.0, |touch| touch.range * (1.0 - 1e-9));
                let deepest = (0..500)
                    .map(|step| depth(&shape, origin + direction * until * f64::from(step) / 499.0))
                    .fold(f64::NEG_INFINITY, f64::max);
                assert!(deepest < 1e-6, "{shape:?}: passed {deepest} m inside");
            }
            assert!((100..4000).contains(&met), "{shape:?}: {met} rays met it");
        }
    }

    #[test]
    fn grown_shapes_hold_what_is_near() {
        for (shape, margin) in SHAPES.into_iter().flat_map(|shape| [0.1, 3.0].map(|margin| (shape, margin))) {
            let Some((grown, below)) = shape.grown(margin) else { continue };
            for (origin, direction) in rays() {
                let Some(Touch { range, normal }) = shape.touch(origin, direction) else { continue };
                let beside = origin + direction * range + normal.normalize() * margin;
                let inside = depth(&grown, beside + DVec3::Z * below);
                assert!(inside > -1e-9, "{shape:?}: {inside} at {beside}");
            }
        }
    }

    #[test]
    fn normals_are_those_of_the_surface() {
        for shape in SHAPES {
            for (origin, direction) in rays() {
                let Some(Touch { range, normal }) = shape.touch(origin, direction) else { continue };
                let (point, out) = (origin + direction * range, normal.normalize());
                // Outward the depth falls at once, by about as much as one goes; at edges by less.
                let fall = depth(&shape, point - out * 1e-4) - depth(&shape, point + out * 1e-4);
                assert!(
                    fall > 2e-5 || matches!(shape, Shape::Ellipse { .. }),
                    "{shape:?}: {fall} at {point}"
                );
            }
        }
    }

    #[test]
    fn from_inside_the_inner_side_is_seen() {
        for shape in &SHAPES[..5] {
            let origin = DVec3::new(0.1, 0.1, 0.2);
            for direction in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z, DVec3::new(1.0, 2.0, 0.5)] {
                let touch = shape.touch(origin, direction).unwrap();
                assert!(depth(shape, origin + direction * touch.range).abs() < 1e-9, "{shape:?}");
                assert!(touch.normal.dot(direction) < 0.0, "{shape:?}");
            }
        }
    }

    #[test]
    fn boxes_around_shapes_hold_them() {
        for shape in SHAPES {
            let [low, high] = shape.corners();
            for (origin, direction) in rays() {
                let Some(touch) = shape.touch(origin, direction) else { continue };
                let point = origin + direction * touch.range;
                assert!(point.cmpge(low - 1e-9).all() && point.cmple(high + 1e-9).all(), "{shape:?}");
            }
        }
    }
}
