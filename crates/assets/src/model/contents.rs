//! Contents of a model.

use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};

use crate::model::Texture;

/// Triangles of the largest model: some 300 MB of memory.
pub const MOST_TRIANGLES: usize = 2_000_000;

/// Corners of the largest model.
pub(super) const MOST_CORNERS: usize = 3 * MOST_TRIANGLES;

/// Result whose error is a clause without the file's name.
pub type Clause<T> = std::result::Result<T, String>;

/// Material of a part of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Linear Rec. 709 reflectance, 0…1; `None`: that of the body.
    pub colour: Option<Vec3>,
    /// 0…1.
    pub alpha: f32,
    /// Multiplies colour and alpha.
    pub texture: Option<Arc<Texture>>,
    /// Alpha, 0…1, below which there is nothing; `None`: it is all there.
    pub cutoff: Option<f32>,
    /// Whether it is seen from behind too: from where its triangles run clockwise.
    pub both_sides: bool,
}

impl Material {
    /// All there, seen from both sides.
    pub fn of(colour: Option<Vec3>) -> Self {
        Self { colour, alpha: 1.0, texture: None, cutoff: None, both_sides: true }
    }
}

/// A part of a model as its file has it.
#[derive(Debug)]
pub struct ModelPart {
    /// Corners, units of the model.
    pub positions: Vec<DVec3>,
    /// Normals, as many as positions, or none.
    pub normals: Vec<Vec3>,
    /// Places in the texture, 0…1 rightward and downward; as many as positions, or none.
    pub places: Vec<Vec2>,
    /// Linear factors on the colour; as many as positions, or none.
    pub colours: Vec<Vec3>,
    /// Three corners each, counterclockwise as seen from in front.
    pub triangles: Vec<[u32; 3]>,
    /// Material of all triangles.
    pub material: Material,
    /// Number of the node that it is in, of formats that have such.
    pub node: Option<usize>,
}

/// A node as its file has it.
#[derive(Debug)]
pub struct ModelNode {
    /// Name of the node, if it has one.
    pub name: Option<String>,
    /// Number of the one that it is below of.
    pub above: Option<usize>,
    /// Units of the model from its own.
    pub from_node: DMat4,
}

/// A model as its file has it.
#[derive(Debug)]
pub struct Model {
    /// Triangles by material.
    pub parts: Vec<ModelPart>,
    /// Each after the one above it.
    pub nodes: Vec<ModelNode>,
    /// Triangles and corners of all parts.
    pub(super) counts: [usize; 2],
    /// Columns: what the model's axes are in a body's (right, forward, up).
    pub body_from_model: DMat3,
    /// Parts of the file that are not shown.
    pub notes: Vec<String>,
}

impl Model {
    /// Nothing yet.
    pub(super) fn new(body_from_model: DMat3) -> Self {
        Self { parts: Vec::new(), nodes: Vec::new(), counts: [0; 2], body_from_model, notes: Vec::new() }
    }

    /// Counts a part's triangles and corners before there are any.
    pub(super) fn check(&self, triangles: usize, corners: usize) -> Clause<()> {
        within("triangles", self.counts[0].saturating_add(triangles), MOST_TRIANGLES)?;
        within("corners", self.counts[1].saturating_add(corners), MOST_CORNERS)
    }

    pub(super) fn push(&mut self, part: ModelPart) {
        self.counts[0] += part.triangles.len();
        self.counts[1] += part.positions.len();
        self.parts.push(part);
    }
}

pub(super) fn within(what: &str, count: usize, most: usize) -> Clause<()> {
    if count <= most {
        return Ok(());
    }
    Err(format!("it has {count} {what}, more than the {most} that a model may have; simplify it"))
}
