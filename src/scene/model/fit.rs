//! Fit of a model into a body.

use glam::{DMat3, DVec3};

use crate::objects::{Mesh, MeshPart};
use crate::space::Attitude;
use hedgehop_assets::model::{Clause, Model, ModelPart};

/// Fit of a model into a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fit {
    pub size: Size,
    /// Whether Z points up.
    pub is_z_up: bool,
    /// Turns it about its own origin, after its axes were made right.
    pub turn: Attitude,
    pub origin: Origin,
}

/// Size of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Size {
    /// Metres per unit.
    Scale(f64),
    /// Metres of the longest side of its box, before it is turned.
    Length(f64),
}

/// Place of a body's origin in its model.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Origin {
    /// Origin of the file.
    Model,
    /// Middle of the lower side of its box.
    Base,
    /// Middle of its box.
    Middle,
}

/// Transformation of a model into a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitting {
    /// Metres of the body from units of the model.
    pub(super) turned: DMat3,
    /// Model's axes in an upright body's.
    pub(super) axes: DMat3,
    /// Turn of that.
    pub(super) turn: DMat3,
    /// Point of the model at the body's origin, metres.
    pub(super) origin: DVec3,
    pub(super) is_mirrored: bool,
    /// Corners of the box around it, metres from the body's origin.
    pub(super) corners: [DVec3; 2],
}

/// Cut of one model into several meshes.
#[derive(Debug, PartialEq)]
pub(super) struct Knife {
    pub(super) nodes: Vec<Option<String>>,
    pub(super) rests: Vec<Rest>,
}

impl Fitting {
    /// Fits a model into a body.
    pub(super) fn new(model: &Model, fit: &Fit) -> Clause<Self> {
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
    pub(super) fn mesh(
        &self,
        model: &Model,
        rest: Option<&Rest>,
        within: impl Fn(&ModelPart) -> bool,
    ) -> Clause<Mesh> {
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

/// Place of a part at rest, in the axes of what it goes with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    /// Pivot of the part: right, forward, up, metres.
    pub pivot: DVec3,
    /// Columns: its axes right, forward, up.
    pub turn: DMat3,
}
