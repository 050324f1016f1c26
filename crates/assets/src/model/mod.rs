//! Model files: glTF, Wavefront OBJ, MagicaVoxel.
//!
//! ```text
//! file ──gltf, obj, vox──▶ Model: parts of triangles in the model's own axes, with colours and textures
//! ```
//! Dynamic objects and the database are made from the same models.
//!
//! Whatever a file says is checked before it is used: no sum of sizes overflows, nothing is allocated that the file's own bytes do not fill, and what
//! exceeds the limits below is refused. Functions here tell what is wrong as a clause; the name of the file is put before it at the end.

mod accessor;
mod files;
mod gltf;
mod numbers;
mod obj;
mod picture;
mod texture;
mod vox;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};

use files::Files;
use hedgehop_base::error::{Error, Result};
pub use texture::{Texture, Wrap};

/// Triangles of the largest model: some 300 MB of memory.
pub const MOST_TRIANGLES: usize = 2_000_000;

/// Corners of the largest model.
const MOST_CORNERS: usize = 3 * MOST_TRIANGLES;

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
    counts: [usize; 2],
    /// Columns: what the model's axes are in a body's (right, forward, up).
    pub body_from_model: DMat3,
    /// Parts of the file that are not shown.
    pub notes: Vec<String>,
}

/// A model that was read.
#[derive(Debug)]
pub struct Read {
    /// Model in the file.
    pub model: Model,
    /// All files that it was read from.
    pub files: Vec<PathBuf>,
}

/// Reads a model by its file's extension; all bytes go into `hasher`.
///
/// # Errors
/// [`Error::Io`] of files that cannot be read, [`Error::Invalid`] and [`Error::Unsupported`] of what is in them.
pub fn read(path: &Path, hasher: &mut blake3::Hasher) -> Result<Read> {
    let mut files = Files::new(path, hasher);
    let bytes = files.first()?;
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let model = match extension.as_deref() {
        Some("glb" | "gltf") => gltf::read(&bytes, &mut files)?,
        Some("obj") => obj::read(&bytes, &mut files)?,
        Some("vox") => vox::read(&bytes).map_err(|what| Error::invalid(path, what))?,
        _ => {
            let what = "is no model that is known by its name";
            return Err(Error::unsupported(path, what, "models end in .glb, .gltf, .obj or .vox"));
        }
    };
    Ok(Read { model, files: files.read() })
}

impl Model {
    /// Nothing yet.
    fn new(body_from_model: DMat3) -> Self {
        Self { parts: Vec::new(), nodes: Vec::new(), counts: [0; 2], body_from_model, notes: Vec::new() }
    }

    /// Counts a part's triangles and corners before there are any.
    fn check(&self, triangles: usize, corners: usize) -> Clause<()> {
        within("triangles", self.counts[0].saturating_add(triangles), MOST_TRIANGLES)?;
        within("corners", self.counts[1].saturating_add(corners), MOST_CORNERS)
    }

    fn push(&mut self, part: ModelPart) {
        self.counts[0] += part.triangles.len();
        self.counts[1] += part.positions.len();
        self.parts.push(part);
    }
}

fn within(what: &str, count: usize, most: usize) -> Clause<()> {
    if count <= most {
        return Ok(());
    }
    Err(format!("it has {count} {what}, more than the {most} that a model may have; simplify it"))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Triangles, corners and colours of a model.
    fn shape(path: &Path) -> Result<String> {
        let read = read(path, &mut blake3::Hasher::new())?;
        let part =
            |part: &ModelPart| format!("{:?} {:?} {:?}", part.positions, part.triangles, part.material);
        Ok(read.model.parts.iter().map(part).collect())
    }

    #[test]
    fn a_mark_of_the_encoding_changes_nothing() {
        const OBJ: &str = "v 0 0 0\nmtllib a.mtl\nusemtl red\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 9 9 9\n";
        const MTL: &str = "newmtl red\nKd 1 0 0\n";
        const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let (obj, gltf) = (put("a.obj", OBJ), put("a.gltf", GLTF));
        put("a.mtl", MTL);
        let plain = [shape(&obj).unwrap(), shape(&gltf).unwrap()];

        for (name, text) in [("a.obj", OBJ), ("a.mtl", MTL), ("a.gltf", GLTF)] {
            put(name, &format!("\u{feff}{text}"));
            assert_eq!([shape(&obj).unwrap(), shape(&gltf).unwrap()], plain, "{name}");
            fs::write(folder.path().join(name), b"\xff\xfev\0 \0").unwrap();
            let told = [&obj, &gltf].map(|path| shape(path).map_err(|error| error.to_string()));
            assert!(told.iter().any(|told| matches!(told, Err(told) if told.contains("UTF-16"))), "{told:?}");
            put(name, text);
        }
    }
}
