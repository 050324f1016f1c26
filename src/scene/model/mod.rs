//! Models of dynamic objects: fitted into bodies, and cut into parts that move.
//!
//! ```text
//! file ──hedgehop_assets::model──▶ Model in its own axes ──cut──▶ Mesh in a body's axes, and of each node that moves in its own
//! ```

mod nodes;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::objects::{Mesh, MeshPart};
use crate::space::Attitude;
use hedgehop_assets::model::{Clause, MOST_TRIANGLES, Model, ModelPart, Read, read};
use hedgehop_base::error::{Error, Result};
pub(super) use nodes::{NodeSplit, Rest};

/// Triangles of all models of a scene.
const MOST_OF_SCENE: usize = 4 * MOST_TRIANGLES;

/// Fit of a model into a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub size: Size,
    /// Whether Z points up.
    pub is_z_up: bool,
    /// Turns it about its own origin, after its axes were made right.
    pub turn: Attitude,
    pub origin: Origin,
}

/// Size of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Size {
    /// Metres per unit.
    Scale(f64),
    /// Metres of the longest side of its box, before it is turned.
    Length(f64),
}

/// Place of a body's origin in its model.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Origin {
    /// Origin of the file.
    Model,
    /// Middle of the lower side of its box.
    Base,
    /// Middle of its box.
    Middle,
}

/// Transformation of a model into a body.
#[derive(Debug, Clone, Copy)]
struct Fitting {
    /// Metres of the body from units of the model.
    turned: DMat3,
    /// Model's axes in an upright body's.
    axes: DMat3,
    /// Turn of that.
    turn: DMat3,
    /// Point of the model at the body's origin, metres.
    origin: DVec3,
    is_mirrored: bool,
    /// Corners of the box around it, metres from the body's origin.
    corners: [DVec3; 2],
}

/// Models of a scene, each of which is read once.
#[derive(Debug, Default)]
pub(super) struct Models {
    read: BTreeMap<PathBuf, Arc<Read>>,
    fitted: Vec<(PathBuf, Fit, Knife, Arc<NodeSplit>)>,
    triangles: usize,
}

/// Cut of one model into several meshes.
#[derive(Debug, PartialEq)]
struct Knife {
    nodes: Vec<Option<String>>,
    rests: Vec<Rest>,
}

/// A model for an object.
#[derive(Debug)]
pub(super) struct Fitted {
    pub cut: Arc<NodeSplit>,
    /// All files that it was read from.
    pub files: Vec<PathBuf>,
    /// Parts that are not shown, as clauses.
    pub notes: Vec<String>,
}

impl Models {
    /// The model in a file, of which `nodes` are cut off; what is read goes into `hasher`. `None` among the nodes is cut off nothing. They
    /// move in the axes `rests`, or, if there are none, in their own.
    ///
    /// # Errors
    /// [`Error::Io`] of files that cannot be read, [`Error::Invalid`] and [`Error::Unsupported`] of what is in them.
    pub fn get(
        &mut self,
        path: &Path,
        fit: &Fit,
        nodes: &[Option<&str>],
        rests: &[Rest],
        hasher: &mut blake3::Hasher,
    ) -> Result<Fitted> {
        let read = match self.read.get(path) {
            Some(read) => read.clone(),
            None => {
                let read = Arc::new(read(path, hasher)?);
                self.read.insert(path.to_owned(), read.clone());
                read
            }
        };

        let nodes = nodes.iter().map(|node| node.map(str::to_owned)).collect();
        let knife = Knife { nodes, rests: rests.to_vec() };
        let known =
            self.fitted.iter().find(|(known, its, by, _)| known == path && its == fit && *by == knife);

        let cut = match known {
            Some((.., cut)) => cut.clone(),
            None => {
                let wrong = |what: String| Error::invalid(path, what);
                let cut = Arc::new(NodeSplit::new(&read.model, fit, &knife).map_err(wrong)?);
                self.triangles += cut.triangle_count();
                if self.triangles > MOST_OF_SCENE {
                    return Err(wrong(format!(
                        "with it the models of the scene have {} triangles, more than the {MOST_OF_SCENE} that fit; models of one size and \
                         turn are counted once",
                        self.triangles
                    )));
                }

                self.fitted.push((path.to_owned(), *fit, knife, cut.clone()));
                cut
            }
        };

        Ok(Fitted { cut, files: read.files.clone(), notes: read.model.notes.clone() })
    }
}

impl Fitting {
    /// Fits a model into a body.
    fn new(model: &Model, fit: &Fit) -> Clause<Self> {
        let turn = fit.turn.world_from_view();
        let turn = DMat3::from_cols(turn.x_axis, turn.z_axis, turn.y_axis);
        let axes = if fit.is_z_up { DMat3::IDENTITY } else { model.body_from_model };

        let bounds = |turned: DMat3| {
            let used = model.parts.iter().flat_map(|part| {
                part.triangles.iter().flatten().filter_map(|corner| part.positions.get(*corner as usize))
            });
            used.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], place| {
                let place = turned * *place;
                [low.min(place), high.max(place)]
            })
        };

        let scale = match fit.size {
            Size::Scale(scale) => scale,
            Size::Length(metres) => {
                let [low, high] = bounds(axes);
                metres / (high - low).max_element()
            }
        };

        let turned = turn * axes * scale;
        if !turned.is_finite() {
            return Err("it has no size that a length could be given to".to_owned());
        }

        let [low, high] = bounds(turned);
        let middle = 0.5 * (low + high);
        let origin = match fit.origin {
            Origin::Model => DVec3::ZERO,
            Origin::Base => middle.with_z(low.z),
            Origin::Middle => middle,
        };
        let is_mirrored = axes.determinant() < 0.0;

        Ok(Self { turned, axes, turn, origin, is_mirrored, corners: [low - origin, high - origin] })
    }

    /// Makes the mesh of those parts that are `within`, in the axes of a body, or in those of a node at rest.
    fn mesh(&self, model: &Model, rest: Option<&Rest>, within: impl Fn(&ModelPart) -> bool) -> Clause<Mesh> {
        let Self { turned, turn, axes, origin, is_mirrored, .. } = *self;
        let rotation = match rest {
            None => (turn * axes).as_mat3(),
            Some(rest) => (rest.turn.transpose() * turn * axes).as_mat3(),
        };
        let place = |place: &DVec3| match rest {
            None => (turned * *place - origin).as_vec3(),
            Some(rest) => (rest.turn.transpose() * (turned * *place - origin - rest.pivot)).as_vec3(),
        };

        let part = |part: &ModelPart| MeshPart {
            positions: part.positions.iter().map(place).collect(),
            normals: part.normals.iter().map(|normal| rotation * *normal).collect(),
            places: part.places.clone(),
            colours: part.colours.clone(),
            triangles: part
                .triangles
                .iter()
                .map(|[a, b, c]| if is_mirrored { [*a, *c, *b] } else { [*a, *b, *c] })
                .collect(),
            material: part.material.clone(),
        };

        Mesh::new(model.parts.iter().filter(|part| within(part)).map(part).collect())
    }
}
