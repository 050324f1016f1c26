//! A model of flat faces, and its file: binary glTF 2.0 (Khronos Group 2021, section 4).
//!
//! ```text
//! header   "glTF", version 2, bytes of the file
//! chunks   bytes, "JSON" or "BIN\0", content: the text filled up with spaces, the buffer with zeros, to multiples of four
//! buffer   by material: corners × (x y z) f32, then faces × 3 × index u16, filled up likewise
//! ```

use std::error::Error;
use std::fmt::Write;

/// A corner, metres: right, up, front.
pub type Corner = [f32; 3];

/// Material of faces, and the faces made of it.
pub struct Part {
    pub name: &'static str,
    /// Reflectance, linear, 0 … 1.
    pub colour: [f32; 3],
    corners: Vec<Corner>,
    /// Counterclockwise from outside, three a face.
    indices: Vec<u16>,
}

impl Part {
    pub fn new(name: &'static str, colour: [f32; 3]) -> Self {
        Self { name, colour, corners: Vec::new(), indices: Vec::new() }
    }

    /// Adds the convex solid between two rings of as many corners each; both run counterclockwise seen from the side of `far`.
    pub fn add(mut self, near: &[Corner], far: &[Corner]) -> Self {
        let first = self.corners.len() as u16;
        let count = near.len().min(far.len()) as u16;
        let (near, far) = (&near[..usize::from(count)], &far[..usize::from(count)]);
        // To millimetres, and without a zero's sign: how they were computed does not show.
        let rounded = |corner: &Corner| corner.map(|metres| (metres * 1000.0).round() / 1000.0 + 0.0);
        self.corners.extend(near.iter().chain(far).map(rounded));
        for k in 0..count {
            let next = (k + 1) % count;
            let side = [k, next, count + next, k, count + next, count + k];
            self.indices.extend(side.map(|index| first + index));
        }
        for k in 1..count - 1 {
            let ends = [0, k + 1, k, count, count + k, count + k + 1];
            self.indices.extend(ends.map(|index| first + index));
        }
        self
    }

    /// Adds a box with a low and a high corner.
    pub fn block(self, [west, low, back]: Corner, [east, high, front]: Corner) -> Self {
        let ring = |y| [[west, y, front], [east, y, front], [east, y, back], [west, y, back]];
        self.add(&ring(low), &ring(high))
    }

    /// Bytes of its corners, and of its faces.
    fn bytes(&self) -> [Vec<u8>; 2] {
        let corners = self.corners.iter().flatten().flat_map(|metres| metres.to_le_bytes()).collect();
        let faces = self.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        [corners, filled(faces, 0)]
    }

    /// Least or greatest of the corners by axis.
    fn bound(&self, better: fn(f32, f32) -> f32) -> Corner {
        self.corners
            .iter()
            .copied()
            .reduce(|a, b| [0, 1, 2].map(|axis| better(a[axis], b[axis])))
            .unwrap_or_default()
    }

    /// Faces by their corners.
    #[cfg(test)]
    pub fn faces(&self) -> impl Iterator<Item = [Corner; 3]> {
        self.indices.chunks_exact(3).map(|face| [0, 1, 2].map(|k| self.corners[usize::from(face[k])]))
    }
}

fn filled(mut bytes: Vec<u8>, with: u8) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), with);
    bytes
}

/// The file's bytes.
pub fn encode(name: &str, parts: &[Part]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut buffer = Vec::new();
    let (mut primitives, mut materials, mut accessors, mut views) = (vec![], vec![], vec![], vec![]);
    for (k, part) in parts.iter().enumerate() {
        for (bytes, target) in part.bytes().into_iter().zip([34962, 34963]) {
            views.push(format!(
                r#"{{"buffer":0,"byteOffset":{},"byteLength":{},"target":{target}}}"#,
                buffer.len(),
                bytes.len()
            ));
            buffer.extend(bytes);
        }

        let (corners, faces) = (2 * k, 2 * k + 1);
        accessors.push(format!(
            r#"{{"bufferView":{corners},"componentType":5126,"count":{},"type":"VEC3","min":{:?},"max":{:?}}}"#,
            part.corners.len(),
            part.bound(f32::min),
            part.bound(f32::max)
        ));
        accessors.push(format!(
            r#"{{"bufferView":{faces},"componentType":5123,"count":{},"type":"SCALAR"}}"#,
            part.indices.len()
        ));
        primitives
            .push(format!(r#"{{"attributes":{{"POSITION":{corners}}},"indices":{faces},"material":{k}}}"#));
        let [red, green, blue] = part.colour;
        materials.push(format!(
            r#"{{"name":"{}","pbrMetallicRoughness":{{"baseColorFactor":[{red},{green},{blue},1],"metallicFactor":0,"roughnessFactor":1}}}}"#,
            part.name
        ));
    }

    let mut text = String::from(r#"{"asset":{"version":"2.0","generator":"hedgehop-valley"},"scene":0,"#);
    write!(text, r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"{name}","mesh":0}}],"#)?;
    let lists = [("materials", materials), ("accessors", accessors), ("bufferViews", views)];
    write!(text, r#""meshes":[{{"primitives":[{}]}}],"#, primitives.join(","))?;
    for (key, list) in lists {
        write!(text, r#""{key}":[{}],"#, list.join(","))?;
    }

    write!(text, r#""buffers":[{{"byteLength":{}}}]}}"#, buffer.len())?;
    file(&filled(text.into_bytes(), b' '), &buffer)
}

fn file(text: &[u8], buffer: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let length = u32::try_from(12 + 8 + text.len() + 8 + buffer.len())?;
    let mut bytes = Vec::new();
    bytes.extend(b"glTF");
    bytes.extend(2u32.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    for (kind, content) in [(b"JSON", text), (b"BIN\0", buffer)] {
        bytes.extend(u32::try_from(content.len())?.to_le_bytes());
        bytes.extend(kind);
        bytes.extend(content);
    }
    Ok(bytes)
}
