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
mod contents;
mod files;
mod gltf;
mod numbers;
mod obj;
mod picture;
mod texture;
mod vox;

use std::path::{Path, PathBuf};

pub use contents::{Clause, MOST_TRIANGLES, Material, Model, ModelNode, ModelPart};
use files::Files;
use hedgehop_base::error::{Error, Result};
pub use texture::{Texture, Wrap};

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
