//! Triangles before a few pixels: what of a mesh rays of these may meet, in coordinates of the screen.
//!
//! Corners become homogeneous positions (x, y, w) around a pixel, in pixels, and edges linear functions of x and y that are 0 or more inside, whatever lies
//! behind the eye (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997). Functions of an edge are exactly opposite for its
//! two triangles: no ray passes between them. A ray is then tested by three sums of products.

use glam::{DMat3, DVec3, Vec3};

use super::bvh::STACK;
use super::{Mesh, Triangle};

/// Share of the distance to a mesh nearer to the eye than which a corner has no position.
const BEHIND: f32 = 1.0e-3;

/// Coordinates of the screen around a pixel, for a mesh.
#[derive(Debug, Clone, Copy)]
pub(in crate::objects) struct Basis {
    /// Origin in the mesh's axes, metres.
    origin: Vec3,
    /// Rows of the matrix that gives x, y and the way along the middle ray of a place beside the origin.
    rows: [Vec3; 3],
    /// w at the origin, and what it grows by per way.
    depth: [f32; 2],
    /// Way of the middle ray to the origin, multiples of its direction.
    pub begin: f32,
    /// Sign of the volume that the axes span.
    hand: f32,
}

/// A part of the screen, pixels to the right and down.
#[derive(Debug, Clone, Copy)]
pub(in crate::objects) struct PixelBounds {
    pub low: [f32; 2],
    pub high: [f32; 2],
}

/// A triangle on the screen. Functions are `f[0] x + f[1] y + f[2]`.
#[derive(Debug, Clone, Copy)]
pub(in crate::objects) struct Facet {
    /// Each opposite to a corner: 0 or more inside.
    pub edges: [[f32; 3]; 3],
    /// Sum of the corners.
    pub sum: [f32; 3],
    /// Way beyond the basis's beginning, times the sum.
    pub way: [f32; 3],
    pub bounds: PixelBounds,
    /// Least and greatest way of the corners.
    pub near: f32,
    pub far: f32,
    /// Index in the mesh.
    pub triangle: u32,
    pub is_behind: bool,
}

/// A place in homogeneous coordinates, and how far along the ray.
#[derive(Debug, Clone, Copy)]
struct FacetPlace {
    x: f32,
    y: f32,
    w: f32,
    way: f32,
}

pub(super) fn at(function: [f32; 3], x: f32, y: f32) -> f32 {
    function[0] * x + function[1] * y + function[2]
}

impl PixelBounds {
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// Greatest value of a function in them.
    fn most(&self, function: [f32; 3]) -> f32 {
        let of = |axis: usize| (function[axis] * self.low[axis]).max(function[axis] * self.high[axis]);
        of(0) + of(1) + function[2]
    }
}

impl Basis {
    /// Rays from `origin` in `direction`, and what a pixel to the right and a pixel down add to these, in the mesh's axes. Either origins or directions
    /// differ. `radius`: of a sphere around the mesh's box, `middle` its middle.
    pub fn new(origin: [DVec3; 3], direction: [DVec3; 3], middle: DVec3, radius: f64) -> Option<Self> {
        let [ahead, right, down] = direction;
        let way = (middle - origin[0]).dot(ahead) / ahead.length_squared();
        let reach = radius / ahead.length();
        let begin = if way > reach { way } else { 0.0 };
        let is_parallel = right == DVec3::ZERO && down == DVec3::ZERO;
        let scale = way.max(reach);
        let axes = if is_parallel {
            DMat3::from_cols(origin[1], origin[2], ahead)
        } else {
            DMat3::from_cols(right * scale, down * scale, ahead)
        };
        let volume = axes.determinant();
        let rows = axes.inverse().transpose();
        let depth = if is_parallel { [1.0, 0.0] } else { [begin / scale, 1.0 / scale] };

        let basis = Self {
            origin: (origin[0] + ahead * begin).as_vec3(),
            rows: [rows.x_axis, rows.y_axis, rows.z_axis].map(DVec3::as_vec3),
            depth: depth.map(|depth| depth as f32),
            begin: begin as f32,
            hand: volume.signum() as f32,
        };

        let is_sound =
            volume != 0.0 && basis.origin.is_finite() && basis.rows.iter().all(|row| row.is_finite());
        is_sound.then_some(basis)
    }

    fn place(&self, position: Vec3) -> FacetPlace {
        let from = position - self.origin;
        let way = self.rows[2].dot(from);
        FacetPlace {
            x: self.rows[0].dot(from),
            y: self.rows[1].dot(from),
            w: self.depth[1] * way + self.depth[0],
            way,
        }
    }

    /// Planes that hold all places in `bounds` on the side where `normal · place + offset ≥ 0`.
    fn planes(&self, bounds: &PixelBounds) -> [(Vec3, f32); 5] {
        let [x, y, way] = self.rows;
        let plane = |row: Vec3, sign: f32, end: f32| {
            // sign · (row − end · w) ≥ 0
            let normal = (row - way * (end * self.depth[1])) * sign;
            (normal, -end * self.depth[0] * sign - normal.dot(self.origin))
        };
        [
            plane(x, 1.0, bounds.low[0]),
            plane(x, -1.0, bounds.high[0]),
            plane(y, 1.0, bounds.low[1]),
            plane(y, -1.0, bounds.high[1]),
            (way, self.begin - way.dot(self.origin)),
        ]
    }

    /// Projects a triangle to the pixels of `bounds`; `None`: it is not there.
    fn facet(&self, mesh: &Mesh, index: u32, triangle: &Triangle, bounds: &PixelBounds) -> Option<Facet> {
        let [a, b, c] = mesh.places_of(triangle).map(|corner| self.place(corner));
        let (near, far) = (a.way.min(b.way).min(c.way), a.way.max(b.way).max(c.way));
        let mut around = PixelBounds { low: [f32::NEG_INFINITY; 2], high: [f32::INFINITY; 2] };
        if a.w.min(b.w).min(c.w) > BEHIND {
            let [a, b, c] = [a, b, c].map(|place| [place.x / place.w, place.y / place.w]);
            for axis in 0..2 {
                around.low[axis] = a[axis].min(b[axis]).min(c[axis]);
                around.high[axis] = a[axis].max(b[axis]).max(c[axis]);
            }
            if !around.meets(bounds) {
                return None;
            }
        }

        let edge = |from: FacetPlace, to: FacetPlace| {
            [from.y * to.w - from.w * to.y, from.w * to.x - from.x * to.w, from.x * to.y - from.y * to.x]
        };
        let mut edges = [edge(b, c), edge(c, a), edge(a, b)];
        let volume = a.x * edges[0][0] + a.y * edges[0][1] + a.w * edges[0][2];
        let is_behind = volume * self.hand > 0.0;
        if volume == 0.0 || !volume.is_finite() || is_behind && !mesh.is_two_sided(triangle) {
            return None;
        }

        if volume < 0.0 {
            edges = edges.map(|edge| edge.map(|part| -part));
        }
        if edges.iter().any(|edge| bounds.most(*edge) < 0.0) {
            return None;
        }

        let sum = [0, 1, 2].map(|part| edges[0][part] + edges[1][part] + edges[2][part]);
        let way =
            [0, 1, 2].map(|part| edges[0][part] * a.way + edges[1][part] * b.way + edges[2][part] * c.way);

        Some(Facet { edges, sum, way, bounds: around, near, far, triangle: index, is_behind })
    }
}

impl Facet {
    /// Whether it may be in `bounds`.
    #[inline]
    pub fn is_in(&self, bounds: &PixelBounds) -> bool {
        self.bounds.meets(bounds) && self.edges.iter().all(|edge| bounds.most(*edge) >= 0.0)
    }

    /// The same around another place, so many pixels to the right and down.
    pub fn around(&self, x: f32, y: f32) -> Self {
        let moved = |function: [f32; 3]| [function[0], function[1], at(function, x, y)];
        let PixelBounds { low, high } = self.bounds;
        Self {
            edges: self.edges.map(moved),
            sum: moved(self.sum),
            way: moved(self.way),
            bounds: PixelBounds { low: [low[0] - x, low[1] - y], high: [high[0] - x, high[1] - y] },
            ..*self
        }
    }

    /// Whether the pixel around 0 shows nothing but it, or what is before it.
    pub fn covers(&self) -> bool {
        self.edges.iter().all(|edge| edge[2] - 0.5 * (edge[0].abs() + edge[1].abs()) >= 0.0)
    }

    /// Least and greatest way in the pixel around 0, beyond the basis's beginning: never outside of the corners' own, nor the greatest before the least.
    pub fn ways(&self) -> [f32; 2] {
        let corners = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
        if corners.iter().any(|[x, y]| at(self.sum, *x, *y) <= 0.0) {
            return [self.near, self.far];
        }
        let ways = corners.map(|[x, y]| at(self.way, x, y) / at(self.sum, x, y));
        let least = ways.into_iter().fold(f32::INFINITY, f32::min);
        let most = ways.into_iter().fold(f32::NEG_INFINITY, f32::max);
        [least, most].map(|way| self.within(way))
    }

    /// A way as it was found from sums of products, among those of the corners: rounding leads out of a face that is seen flat, whose corners all have one
    /// way, and anywhere on one that is seen edge-on, whose sum is nearly 0.
    fn within(&self, way: f32) -> f32 {
        way.max(self.near).min(self.far)
    }

    /// Way, beyond the basis's beginning, at which the ray in the middle meets it, and the weights of its corners.
    pub fn middle(&self) -> Option<(f32, [f32; 3])> {
        let inside = self.edges.map(|edge| edge[2]);
        let meets = inside.iter().all(|edge| *edge >= 0.0) && self.sum[2] > 0.0;
        meets.then(|| (self.within(self.way[2] / self.sum[2]), inside.map(|edge| edge / self.sum[2])))
    }

    /// Weights of its corners at a place.
    pub fn weights(&self, x: f32, y: f32) -> [f32; 3] {
        let sum = at(self.sum, x, y);
        self.edges.map(|edge| at(edge, x, y) / sum)
    }
}

impl Mesh {
    /// Puts its triangles that rays in `bounds` may meet into `facets`.
    pub(in crate::objects) fn before(&self, basis: &Basis, bounds: &PixelBounds, facets: &mut Vec<Facet>) {
        let planes = basis.planes(bounds);
        let mut stack = [0_u32; STACK];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting] as usize];
            let (middle, half) = (0.5 * (node.low + node.high), 0.5 * (node.high - node.low));
            let is_outside = planes
                .iter()
                .any(|(normal, offset)| normal.dot(middle) + offset + normal.abs().dot(half) < 0.0);
            if is_outside {
                continue;
            }
            if node.count == 0 {
                stack[waiting] = node.first + 1;
                stack[waiting + 1] = node.first;
                waiting += 2;
                continue;
            }

            let range = node.first as usize..(node.first + node.count) as usize;
            let triangles = (node.first..).zip(&self.triangles[range]);
            facets
                .extend(triangles.filter_map(|(index, triangle)| basis.facet(self, index, triangle, bounds)));
        }
    }
}
