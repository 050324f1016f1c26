//! Single rays: the nearest triangle, or any.
//!
//! A ray is taken to a place beside the mesh, where single precision is enough, and corners into axes of which it is one. Whether it passes inside of
//! an edge then is the sign of a cross product in two dimensions, which is exactly opposite for the two triangles of an edge: no ray passes between
//! them (Woop, Benthin and Wald, "Watertight ray/triangle intersection", 2013, whose shear is a turn here).

use glam::{DVec3, Vec3};

use super::bvh::STACK;
use super::{Mesh, Triangle};

/// Hit of a ray on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::objects) struct MeshHit {
    /// Multiples of the ray's direction, ≥ 0.
    pub range: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's corners.
    pub weights: [f32; 3],
    /// Whether the triangle is seen from behind.
    pub is_behind: bool,
}

/// A ray beside a mesh.
struct MeshRay {
    /// Point from which the ray matters.
    origin: Vec3,
    /// Direction, of unit length.
    direction: Vec3,
    /// Two axes across it: right-handed with it.
    across: [Vec3; 2],
    inverse: Vec3,
    /// Metres along the direction before which nothing counts.
    begin: f32,
}

/// Nearest hit so far.
struct Met {
    /// Metres from the ray's place beside the mesh.
    at: f32,
    triangle: u32,
    weights: [f32; 3],
    is_behind: bool,
}

impl MeshRay {
    /// The ray, and how many metres from its origin it begins.
    fn beside(mesh: &Mesh, origin: DVec3, direction: DVec3) -> Option<(Self, f64)> {
        let [low, high] = mesh.corners.map(Vec3::as_dvec3);
        let towards = direction.try_normalize()?;
        let reach = 0.5 * (high - low).length();
        let way = ((0.5 * (low + high) - origin).dot(towards) - reach).max(0.0);
        let place = (origin + towards * way).as_vec3();
        let direction = towards.as_vec3();
        let (right, up) = direction.any_orthonormal_pair();
        // Neither an axis is divided by 0, nor is anything multiplied by infinity.
        let inverse = direction
            .map(|speed| 1.0 / if speed.abs() < 1.0e-20 { 1.0e-20_f32.copysign(speed) } else { speed });
        let across = if right.cross(up).dot(direction) > 0.0 { [right, up] } else { [up, right] };
        place.is_finite().then_some((Self { origin: place, direction, across, inverse, begin: 0.0 }, way))
    }

    /// Returns the ray's way to a box, if it enters one before `end`.
    fn enters(&self, low: Vec3, high: Vec3, end: f32) -> Option<f32> {
        let (first, second) = ((low - self.origin) * self.inverse, (high - self.origin) * self.inverse);
        let enter = first.min(second).max_element().max(self.begin);
        let leave = first.max(second).min_element().min(end);
        (enter <= leave).then_some(enter)
    }

    /// Intersects the ray with a triangle.
    fn meets(&self, mesh: &Mesh, triangle: &Triangle, both_sides: bool) -> Option<Met> {
        let corners = mesh.places_of(triangle).map(|corner| corner - self.origin);
        let [right, up] = self.across;
        let [a, b, c] = corners.map(|corner| [corner.dot(right), corner.dot(up)]);
        let edge = |from: [f32; 2], to: [f32; 2]| from[0] * to[1] - from[1] * to[0];
        let edges = [edge(b, c), edge(c, a), edge(a, b)];
        let (least, most) = (edges[0].min(edges[1]).min(edges[2]), edges[0].max(edges[1]).max(edges[2]));
        let sum = edges[0] + edges[1] + edges[2];
        // Counterclockwise around the ray's direction is clockwise as its origin sees it.
        let is_behind = sum > 0.0;
        if least < 0.0 && most > 0.0 || sum == 0.0 || is_behind && !both_sides {
            return None;
        }
        let weights = edges.map(|edge| edge / sum);
        let along = corners.map(|corner| corner.dot(self.direction));
        let at = weights[0] * along[0] + weights[1] * along[1] + weights[2] * along[2];
        (at >= self.begin).then_some(Met { at, triangle: 0, weights, is_behind })
    }
}

impl Mesh {
    /// Finds where the ray from `origin` in `direction` (of any length but 0, both in the mesh's axes) first meets the mesh.
    pub(in crate::objects) fn touch(&self, origin: DVec3, direction: DVec3, metres: f32) -> Option<MeshHit> {
        let (ray, way) = MeshRay::beside(self, origin, direction)?;
        let mut nearest: Option<Met> = None;
        self.walk(&ray, f32::INFINITY, |index, triangle, end| {
            let met = ray.meets(self, triangle, self.is_two_sided(triangle))?;
            // Of triangles at one range the first one, whichever way the tree is walked.
            let is_nearer =
                met.at < *end || met.at == *end && nearest.as_ref().is_some_and(|near| index < near.triangle);
            if is_nearer && (!self.is_masked(triangle) || self.is_there(triangle, met.weights, metres)) {
                *end = met.at;
                nearest = Some(Met { triangle: index, ..met });
            }
            None::<()>
        });
        let Met { at, triangle, weights, is_behind } = nearest?;
        Some(MeshHit { range: (way + f64::from(at)) / direction.length(), triangle, weights, is_behind })
    }

    /// Whether anything of it lies on the ray from `origin` in `direction`, up to `end` multiples of that, seen from whichever side: whether it casts a
    /// shadow there.
    pub(in crate::objects) fn blocks(&self, origin: DVec3, direction: DVec3, end: f64) -> bool {
        let Some((ray, way)) = MeshRay::beside(self, origin, direction) else { return false };
        let end = (end * direction.length() - way) as f32;
        let found = self.walk(&ray, end, |_, triangle, end| {
            let met = ray.meets(self, triangle, true)?;
            let is_there = !self.is_masked(triangle) || self.is_there(triangle, met.weights, 0.0);
            (met.at <= *end && is_there).then_some(())
        });
        found.is_some()
    }

    /// Looks at the triangles of boxes that a ray enters before `end`, the nearer boxes first, until one of them tells something.
    fn walk<T>(
        &self,
        ray: &MeshRay,
        mut end: f32,
        mut look: impl FnMut(u32, &Triangle, &mut f32) -> Option<T>,
    ) -> Option<T> {
        let mut stack = [(0_u32, 0.0_f32); STACK];
        let mut waiting = 0;
        let root = &self.nodes[0];
        if let Some(enter) = ray.enters(root.low, root.high, end) {
            stack[0] = (0, enter);
            waiting = 1;
        }

        while waiting > 0 {
            waiting -= 1;
            let (index, enter) = stack[waiting];
            if enter > end {
                continue;
            }

            let node = &self.nodes[index as usize];
            if node.count > 0 {
                let range = node.first as usize..(node.first + node.count) as usize;
                for (index, triangle) in (node.first..).zip(&self.triangles[range]) {
                    if let Some(found) = look(index, triangle, &mut end) {
                        return Some(found);
                    }
                }
                continue;
            }

            let children = [node.first, node.first + 1].map(|child| {
                let node = &self.nodes[child as usize];
                ray.enters(node.low, node.high, end).map(|enter| (child, enter))
            });
            let [near, far] = match children {
                [Some(first), Some(second)] if second.1 < first.1 => [Some(second), Some(first)],
                children => children,
            };
            for child in [far, near].into_iter().flatten() {
                stack[waiting] = child;
                waiting += 1;
            }
        }

        None
    }
}
