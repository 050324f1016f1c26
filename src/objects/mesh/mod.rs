//! Surfaces of triangles, with colours and textures.
//!
//! ```text
//! parts ──Mesh::new──▶ triangles in a tree of boxes ──▶ rays one at a time                       (ray)
//!                                                  └──▶ facets: triangles before a few pixels    (facet)
//! ```

mod bvh;
mod facet;
mod ray;
#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3, Vec4};

use bvh::BvhNode;
use hedgehop_assets::model::Material;

pub(super) use facet::{Basis, Facet, PixelBounds};
pub(super) use ray::MeshHit;

/// Metres from a mesh's origin beyond which no corner of it is.
const FARTHEST: f32 = 1.0e6;

/// Share of a texel within which the corners of a triangle must lie for it to have one colour.
const ONE_TEXEL: f32 = 0.25;

/// Triangles of one material, in axes of their own: x right, y forward, z up, metres.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshPart {
    /// Corners, metres.
    pub positions: Vec<Vec3>,
    /// Normals of the surface around each corner, of any length; none: each triangle is flat.
    pub normals: Vec<Vec3>,
    /// Place of each corner in the texture, 0…1 rightward and downward; none: the texture is not used.
    pub places: Vec<Vec2>,
    /// Linear factor on the colour at each corner; none: 1.
    pub colours: Vec<Vec3>,
    /// Three corners each, counterclockwise as seen from in front.
    pub triangles: Vec<[u32; 3]>,
    /// Material of all triangles.
    pub material: Material,
}

/// Triangles that can be looked at.
pub struct Mesh {
    nodes: Vec<BvhNode>,
    /// Triangles in the order of the leaves.
    triangles: Vec<Triangle>,
    positions: Vec<Vec3>,
    /// Normals, as many as positions, or none; of a flat part's corners 0.
    normals: Vec<Vec3>,
    /// Texture coordinates, as many as positions, or none.
    places: Vec<Vec2>,
    /// Colours, as many as positions, or none.
    colours: Vec<Vec3>,
    materials: Vec<Material>,
    corners: [Vec3; 2],
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub corners: [u32; 3],
    pub material: u32,
    /// Normal, of unit length.
    pub normal: Vec3,
    /// Without what the body gives; of what varies that of its middle.
    pub colour: Vec3,
    /// Texels per metre; 0: it has one colour.
    pub texels: f32,
    /// Whether the colours of the corners vary; where they hardly do, only the one in the middle is looked at.
    pub varies: bool,
}

impl std::fmt::Debug for Mesh {
    /// Writes the size; nobody would read millions of triangles.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (triangles, corners) = (self.triangles.len(), self.corners);
        f.debug_struct("Mesh")
            .field("triangles", &triangles)
            .field("corners", &corners)
            .finish_non_exhaustive()
    }
}

impl Mesh {
    /// A mesh of `parts`; triangles without area are left out.
    ///
    /// # Errors
    /// A clause that says what is wrong: a number that is not finite or too large, an index without corner, lists of unequal lengths, no
    /// triangle at all.
    pub fn new(parts: Vec<MeshPart>) -> Result<Self, String> {
        let corners: usize = parts.iter().map(|part| part.positions.len()).sum();
        if u32::try_from(corners).is_err() {
            return Err(format!("it has {corners} corners, more than there are numbers for"));
        }

        let has = |holds: fn(&MeshPart) -> bool| parts.iter().any(holds);
        let (normals, places, colours) = (
            has(|part| !part.normals.is_empty()),
            has(|part| !part.places.is_empty() && part.material.texture.is_some()),
            has(|part| !part.colours.is_empty()),
        );

        let mut mesh = Self {
            nodes: Vec::new(),
            triangles: Vec::new(),
            positions: Vec::with_capacity(corners),
            normals: Vec::with_capacity(if normals { corners } else { 0 }),
            places: Vec::with_capacity(if places { corners } else { 0 }),
            colours: Vec::with_capacity(if colours { corners } else { 0 }),
            materials: Vec::with_capacity(parts.len()),
            corners: [Vec3::INFINITY, Vec3::NEG_INFINITY],
        };

        for part in parts {
            check(&part)?;
            let (first, count) = (mesh.positions.len(), part.positions.len());
            let textured = !part.places.is_empty() && part.material.texture.is_some();
            mesh.positions.extend(&part.positions);
            if normals {
                mesh.normals.extend(part.normals.iter().map(|normal| normal.normalize_or_zero()));
                mesh.normals.resize(first + count, Vec3::ZERO);
            }

            if places {
                mesh.places.extend(part.places.iter().filter(|_| textured));
                mesh.places.resize(first + count, Vec2::ZERO);
            }

            if colours {
                mesh.colours.extend(part.colours.iter().map(|colour| colour.clamp(Vec3::ZERO, Vec3::ONE)));
                mesh.colours.resize(first + count, Vec3::ONE);
            }

            let material = mesh.materials.len() as u32;
            mesh.materials
                .push(Material { texture: part.material.texture.filter(|_| textured), ..part.material });
            let all = part.triangles.iter().map(|triangle| triangle.map(|corner| corner + first as u32));
            let kept: Vec<_> = all.filter_map(|corners| mesh.triangle(corners, material)).collect();
            mesh.triangles.extend(kept);
        }

        if mesh.triangles.is_empty() {
            return Err("it has no triangle with an area".to_owned());
        }

        mesh.plant();
        Ok(mesh)
    }

    /// Triangles that it has.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Bytes of memory that it takes, without its textures.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.triangles)
            + size_of_val(&*self.positions)
            + size_of_val(&*self.normals)
            + size_of_val(&*self.places)
            + size_of_val(&*self.colours)
    }

    /// Least and greatest corner of the box around it, metres.
    pub fn corners(&self) -> [Vec3; 2] {
        self.corners
    }

    /// `None`: it has no area.
    fn triangle(&self, corners: [u32; 3], material: u32) -> Option<Triangle> {
        let of = &self.materials[material as usize];
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize].as_dvec3());
        let across = (b - a).cross(c - a);
        let normal = across.try_normalize()?.as_vec3();
        let own = of.colour.unwrap_or(Vec3::ONE);
        let at = |weights: [f32; 3]| self.factor(corners, weights);
        let mean = at([1.0 / 3.0; 3]);
        let mut varies = corners.iter().any(|corner| {
            self.colours
                .get(*corner as usize)
                .is_some_and(|colour| (*colour - mean).abs().max_element() > 0.004)
        });
        let (mut colour, mut texels) = (own * mean, 0.0);

        if let Some(texture) = &of.texture {
            let [width, height] = texture.size().map(|size| size as f32);
            let [p, q, r] = corners.map(|corner| self.places[corner as usize] * Vec2::new(width, height));
            let spread = (q - p).abs().max((r - p).abs()).max_element();
            let area = f64::from((q - p).perp_dot(r - p).abs());
            colour *= texture.sample((p + q + r) / (3.0 * Vec2::new(width, height)), 1.0).truncate();
            if spread > ONE_TEXEL || of.cutoff.is_some() {
                varies = true;
                texels = (area / across.length()).sqrt() as f32;
            }
        }

        Some(Triangle { corners, material, normal, colour, texels, varies })
    }

    /// Builds the tree, and orders triangles by it.
    fn plant(&mut self) {
        let corners = self.triangles.iter().map(|triangle| self.places_of(triangle));
        let (nodes, order) = bvh::tree(corners);
        self.triangles = order.iter().map(|index| self.triangles[*index as usize]).collect();
        self.corners = [nodes[0].low, nodes[0].high];
        self.nodes = nodes;
    }

    /// Corners of a triangle, metres.
    fn places_of(&self, triangle: &Triangle) -> [Vec3; 3] {
        triangle.corners.map(|corner| self.positions[corner as usize])
    }

    pub(super) fn triangle_at(&self, index: u32) -> &Triangle {
        &self.triangles[index as usize]
    }

    /// Factor of the corners' colours.
    fn factor(&self, corners: [u32; 3], weights: [f32; 3]) -> Vec3 {
        if self.colours.is_empty() {
            return Vec3::ONE;
        }
        corners.into_iter().zip(weights).map(|(corner, weight)| self.colours[corner as usize] * weight).sum()
    }

    /// Normals at the corners of a triangle: of unit length, or all its own.
    pub(super) fn normals_of(&self, triangle: &Triangle) -> [Vec3; 3] {
        triangle.corners.map(|corner| match self.normals.get(corner as usize) {
            Some(normal) if *normal != Vec3::ZERO => *normal,
            _ => triangle.normal,
        })
    }

    /// Normal at `weights` of a triangle's corners, towards where it is seen from, of unit length.
    pub(super) fn normal(&self, triangle: &Triangle, weights: [f32; 3], is_behind: bool) -> Vec3 {
        let sum: Vec3 =
            self.normals_of(triangle).into_iter().zip(weights).map(|(normal, weight)| normal * weight).sum();
        let normal = sum.try_normalize().unwrap_or(triangle.normal);
        if is_behind { -normal } else { normal }
    }

    /// Colour of a triangle of a body of colour `body`, at `weights` of its corners, over `metres` of it.
    pub(super) fn colour(&self, triangle: &Triangle, weights: [f32; 3], metres: f32, body: Vec3) -> Vec3 {
        let material = &self.materials[triangle.material as usize];
        let given = if material.colour.is_some() { Vec3::ONE } else { body };
        if !triangle.varies {
            return triangle.colour * given;
        }
        let own = material.colour.unwrap_or(Vec3::ONE) * self.factor(triangle.corners, weights);
        own * given * self.texel(triangle, weights, metres).truncate()
    }

    fn texel(&self, triangle: &Triangle, weights: [f32; 3], metres: f32) -> Vec4 {
        let Some(texture) = &self.materials[triangle.material as usize].texture else { return Vec4::ONE };
        let places = triangle.corners.into_iter().zip(weights);
        let place: Vec2 = places.map(|(corner, weight)| self.places[corner as usize] * weight).sum();
        texture.sample(place, triangle.texels * metres)
    }

    /// Whether parts of a triangle may not be there.
    pub(super) fn is_masked(&self, triangle: &Triangle) -> bool {
        self.materials[triangle.material as usize].cutoff.is_some()
    }

    /// Whether a triangle is there, at `weights` of its corners, over `metres` of it.
    pub(super) fn is_there(&self, triangle: &Triangle, weights: [f32; 3], metres: f32) -> bool {
        let material = &self.materials[triangle.material as usize];
        material
            .cutoff
            .is_none_or(|cutoff| self.texel(triangle, weights, metres).w * material.alpha >= cutoff)
    }

    /// Whether a triangle is seen from behind.
    fn is_two_sided(&self, triangle: &Triangle) -> bool {
        self.materials[triangle.material as usize].both_sides
    }
}

/// Refuses what nothing can be made of.
fn check(part: &MeshPart) -> Result<(), String> {
    let count = part.positions.len();
    let fits = |list: usize| list == 0 || list == count;
    if !fits(part.normals.len()) || !fits(part.places.len()) || !fits(part.colours.len()) {
        return Err("it has not as many normals, places in textures or colours as corners".to_owned());
    }

    let is_near = |place: &&Vec3| place.is_finite() && place.abs().max_element() <= FARTHEST;
    if let Some(place) = part.positions.iter().find(|place| !is_near(place)) {
        return Err(format!(
            "a corner of it lies at {place}, which is not within {} km; see scale and origin",
            FARTHEST / 1000.0
        ));
    }

    let finite = part.normals.iter().all(|normal| normal.is_finite())
        && part.places.iter().all(|place| place.is_finite())
        && part.colours.iter().all(|colour| colour.is_finite());
    if !finite {
        return Err("a normal, a place in a texture or a colour of it is not finite".to_owned());
    }

    let outside = part.triangles.iter().flatten().find(|corner| **corner as usize >= count);
    outside.map_or(Ok(()), |corner| Err(format!("a triangle names corner {corner}, of {count}")))
}
