//! Nodes of a model that move by themselves.
//!
//! ```text
//! nodes that are cut off ──▶ each in axes of its own, without those below it that are cut off too
//! all other nodes        ──▶ one mesh
//! ```
//!
//! A node's axes are those that its file gives it (glTF 2.0, 3.5.3, without scale and shear), in the order right, forward, up that all bodies have: of glTF
//! −X, +Z, +Y.

use crate::scene::model::Rest;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::objects::Mesh;
use crate::scene::model::Fit;
use crate::scene::model::fit::{Fitting, Knife};
use hedgehop_assets::model::{Clause, Model, ModelNode, ModelPart};

/// Names of nodes that are told to who asks for another one.
const MOST_TOLD: usize = 8;

/// A model in several meshes.
#[derive(Debug)]
pub(crate) struct NodeSplit {
    /// Mesh that is left of it.
    pub rest: Arc<Mesh>,
    /// Each node that was to be cut off, or why it was not: a clause.
    pub nodes: Vec<Clause<Node>>,
    /// Least and greatest corner of the box around all of it at rest, metres.
    pub corners: [DVec3; 2],
}

/// A node that was cut off.
#[derive(Debug)]
pub(in crate::scene) struct Node {
    /// Mesh in its own axes.
    pub mesh: Arc<Mesh>,
    /// Place of these on the whole.
    pub rest: Rest,
    /// Number of the nearest other node of the cut that it is below of.
    pub above: Option<usize>,
}

impl NodeSplit {
    /// Makes one mesh of a model, and another of each node that is cut off.
    pub(super) fn new(model: &Model, fit: &Fit, knife: &Knife) -> Clause<Self> {
        let fitting = Fitting::new(model, fit)?;
        let found: Vec<Clause<usize>> =
            knife.nodes.iter().map(|name| find_node(model, name.as_deref())).collect();

        // The cut node that each node goes with; the one above it is known before.
        let mut goes_with: Vec<Option<usize>> = Vec::with_capacity(model.nodes.len());
        for (number, node) in model.nodes.iter().enumerate() {
            let own = found.iter().position(|found| found.as_ref() == Ok(&number));
            goes_with.push(own.or_else(|| node.above.and_then(|above| goes_with[above])));
        }

        let of = |part: &ModelPart| part.node.and_then(|node| goes_with[node]);
        let node = |(index, found): (usize, Clause<usize>)| -> Clause<Node> {
            let number = found?;
            let own = || fitting.rest(&model.nodes[number]);
            let rest = knife.rests.get(index).copied().unwrap_or_else(own);
            if !rest.pivot.is_finite() {
                return Err(format!("has the node {:?} at no finite place", name_of(model, number)));
            }
            let mesh = fitting.mesh(model, Some(&rest), |part| of(part) == Some(index));
            let mesh = mesh.map_err(|_| format!("shows nothing in the node {:?}", name_of(model, number)))?;
            let above = model.nodes[number].above.and_then(|above| goes_with[above]);
            Ok(Node { mesh: Arc::new(mesh), rest, above })
        };

        let is_cut = found.iter().any(Clause::is_ok);
        let nodes = found.into_iter().enumerate().map(node).collect();
        let rest = fitting.mesh(model, None, |part| of(part).is_none());
        let rest = rest.map_err(|what| {
            let nothing =
                "nothing of it is left besides the nodes that are parts; leave the outermost to the object";
            if is_cut { nothing.to_owned() } else { what }
        })?;

        Ok(Self { rest: Arc::new(rest), nodes, corners: fitting.corners })
    }

    /// Triangles of all its meshes.
    pub fn triangle_count(&self) -> usize {
        let nodes = self.nodes.iter().flatten().map(|node| node.mesh.triangle_count());
        nodes.sum::<usize>() + self.rest.triangle_count()
    }
}

/// Finds the one node of a name.
fn find_node(model: &Model, name: Option<&str>) -> Clause<usize> {
    let Some(name) = name else { return Err("moves nothing there".to_owned()) };
    let is_it = |node: &ModelNode| node.name.as_deref() == Some(name);
    let mut found = model.nodes.iter().enumerate().filter(|(_, node)| is_it(node));
    let others = found.clone().count();
    match found.next() {
        Some((number, _)) if others == 1 => Ok(number),
        Some(_) => Err(format!("has {others} nodes of the name {name:?}; give each its own")),
        None => {
            let names: Vec<&str> = model.nodes.iter().filter_map(|node| node.name.as_deref()).collect();
            let more = if names.len() > MOST_TOLD { ", …" } else { "" };
            let told = names.iter().take(MOST_TOLD).map(|name| format!("{name:?}")).collect::<Vec<_>>();
            Err(match told.as_slice() {
                [] => format!("has no node {name:?}, nor any other with a name; only glTF has such"),
                told => format!("has no node {name:?}; there are {}{more}", told.join(", ")),
            })
        }
    }
}

fn name_of(model: &Model, node: usize) -> &str {
    model.nodes[node].name.as_deref().unwrap_or_default()
}

impl Fitting {
    /// Places a node's own axes in a body.
    fn rest(&self, node: &ModelNode) -> Rest {
        let own = DMat3::from_mat4(node.from_node);
        // Y stays, Z and X give way to shear; a mirrored node's X would make left of right.
        let y = own.y_axis.try_normalize().unwrap_or(DVec3::Y);
        let z = (own.z_axis - y * own.z_axis.dot(y)).try_normalize();
        let z = z.unwrap_or_else(|| y.any_orthonormal_vector());
        let model_from_own = DMat3::from_cols(y.cross(z), y, z);
        let Fitting { turned, axes, turn, origin, .. } = *self;
        let pivot = turned * node.from_node.transform_point3(DVec3::ZERO) - origin;
        Rest { pivot, turn: turn * axes * model_from_own * axes.transpose() }
    }
}
