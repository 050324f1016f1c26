//! Model files: glTF, Wavefront OBJ, MagicaVoxel.
//!
//! ```text
//! file ──gltf, obj, vox──▶ Raw: parts in the model's axes ──cut──▶ Mesh in a body's axes, and of each node that moves in its own
//! ```
//!
//! Whatever a file says is checked before it is used: no sum of sizes overflows, nothing is allocated that the file's own bytes do not fill, and what
//! exceeds the limits below is refused. Functions here tell what is wrong as a clause; the name of the file is put before it at the end.

mod accessor;
mod files;
mod gltf;
mod nodes;
mod numbers;
mod obj;
mod picture;
#[cfg(test)]
mod tests;
mod vox;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec2, Vec3};

use crate::error::{Error, Result};
use crate::objects::{Material, Mesh, Part};
use crate::space::Attitude;
use files::Files;
use nodes::RawNode;
pub(super) use nodes::{Cut, Rest};

/// Triangles of the largest model: some 300 MB of memory.
const MOST_TRIANGLES: usize = 2_000_000;

/// Corners of the largest model.
const MOST_CORNERS: usize = 3 * MOST_TRIANGLES;

/// Triangles of all models of a scene.
const MOST_OF_SCENE: usize = 4 * MOST_TRIANGLES;

/// What is wrong, as a clause without the file's name.
type Clause<T> = std::result::Result<T, String>;

/// How a model is fitted into a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub size: Size,
    /// It is Z that points up.
    pub is_z_up: bool,
    /// Turns it about its own origin, after its axes were made right.
    pub turn: Attitude,
    pub origin: Origin,
}

/// How large a model is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Size {
    /// Metres per unit.
    Scale(f64),
    /// Metres of the longest side of its box, before it is turned.
    Length(f64),
}

/// Where a body's origin is in its model.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Origin {
    /// Where the file has it.
    Model,
    /// In the middle of the lower side of its box.
    Base,
    /// In the middle of its box.
    Middle,
}

/// A part of a model as its file has it.
#[derive(Debug)]
struct RawPart {
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    places: Vec<Vec2>,
    colours: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    material: Material,
    /// Number of the node that it is in, of formats that have such.
    node: Option<usize>,
}

/// A model as its file has it.
#[derive(Debug)]
struct Raw {
    parts: Vec<RawPart>,
    /// Each after the one above it.
    nodes: Vec<RawNode>,
    /// Triangles and corners of all parts.
    counts: [usize; 2],
    /// Columns: what the model's axes are in a body's (right, forward, up).
    body_from_model: DMat3,
    notes: Vec<String>,
}

/// How a model becomes a body.
#[derive(Debug, Clone, Copy)]
struct Fitting {
    /// Metres of the body from units of the model.
    turned: DMat3,
    /// What the model's axes are in an upright body's.
    axes: DMat3,
    /// How that is turned then.
    turn: DMat3,
    /// What of it is at the body's origin, metres.
    origin: DVec3,
    is_mirrored: bool,
    /// Of the box around it, metres from the body's origin.
    corners: [DVec3; 2],
}

/// A model that was read.
#[derive(Debug)]
struct Read {
    raw: Raw,
    files: Vec<PathBuf>,
}

/// Models of a scene, each of which is read once.
#[derive(Debug, Default)]
pub(super) struct Models {
    read: BTreeMap<PathBuf, Arc<Read>>,
    fitted: Vec<(PathBuf, Fit, Knife, Arc<Cut>)>,
    triangles: usize,
}

/// What makes several meshes of one model.
#[derive(Debug, PartialEq)]
struct Knife {
    nodes: Vec<Option<String>>,
    rests: Vec<Rest>,
}

/// A model for an object.
#[derive(Debug)]
pub(super) struct Fitted {
    pub cut: Arc<Cut>,
    /// All files that it was read from.
    pub files: Vec<PathBuf>,
    /// What of it is not shown.
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
                let cut = Arc::new(read.raw.cut(fit, &knife).map_err(wrong)?);
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
        Ok(Fitted { cut, files: read.files.clone(), notes: read.raw.notes.clone() })
    }
}

fn read(path: &Path, hasher: &mut blake3::Hasher) -> Result<Read> {
    let mut files = Files::new(path, hasher);
    let bytes = files.first()?;
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let raw = match extension.as_deref() {
        Some("glb" | "gltf") => gltf::read(&bytes, &mut files)?,
        Some("obj") => obj::read(&bytes, &mut files)?,
        Some("vox") => vox::read(&bytes).map_err(|what| Error::invalid(path, what))?,
        _ => {
            let what = "is no model that is known by its name";
            return Err(Error::unsupported(path, what, "models end in .glb, .gltf, .obj or .vox"));
        }
    };
    Ok(Read { raw, files: files.read() })
}

impl Raw {
    /// Counts a part's triangles and corners before there are any.
    fn check(&self, triangles: usize, corners: usize) -> Clause<()> {
        within("triangles", self.counts[0].saturating_add(triangles), MOST_TRIANGLES)?;
        within("corners", self.counts[1].saturating_add(corners), MOST_CORNERS)
    }

    fn push(&mut self, part: RawPart) {
        self.counts[0] += part.triangles.len();
        self.counts[1] += part.positions.len();
        self.parts.push(part);
    }

    /// How it becomes a body.
    fn fitting(&self, fit: &Fit) -> Clause<Fitting> {
        let turn = fit.turn.world_from_view();
        let turn = DMat3::from_cols(turn.x_axis, turn.z_axis, turn.y_axis);
        let axes = if fit.is_z_up { DMat3::IDENTITY } else { self.body_from_model };
        let bounds = |turned: DMat3| {
            let used = self.parts.iter().flat_map(|part| {
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
        Ok(Fitting { turned, axes, turn, origin, is_mirrored, corners: [low - origin, high - origin] })
    }

    /// The mesh of those parts that are `within`, in the axes of a body, or in those of a node at rest.
    fn mesh(
        &self,
        fitting: &Fitting,
        rest: Option<&Rest>,
        within: impl Fn(&RawPart) -> bool,
    ) -> Clause<Mesh> {
        let Fitting { turned, turn, axes, origin, is_mirrored, .. } = *fitting;
        let rotation = match rest {
            None => (turn * axes).as_mat3(),
            Some(rest) => (rest.turn.transpose() * turn * axes).as_mat3(),
        };
        let place = |place: &DVec3| match rest {
            None => (turned * *place - origin).as_vec3(),
            Some(rest) => (rest.turn.transpose() * (turned * *place - origin - rest.pivot)).as_vec3(),
        };
        let part = |part: &RawPart| Part {
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
        Mesh::new(self.parts.iter().filter(|part| within(part)).map(part).collect())
    }
}

fn within(what: &str, count: usize, most: usize) -> Clause<()> {
    if count <= most {
        return Ok(());
    }
    Err(format!("it has {count} {what}, more than the {most} that a model may have; simplify it"))
}
