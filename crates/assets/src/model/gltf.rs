//! glTF 2.0 (Khronos, 2021), as text or binary: what its scene shows at rest, of the base colour of its materials.

use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Mat3, Vec2, Vec3};
use gltf::material::AlphaMode;
use gltf::mesh::Mode;
use gltf::texture::WrappingMode;
use gltf::{Gltf, Node, Primitive, Semantic};

use super::files::{self, Files};
use super::picture::Pictures;
use super::{Texture, Wrap, accessor, numbers};
use crate::model::contents::MOST_CORNERS;
use crate::model::{MOST_TRIANGLES, Material, Model, ModelNode, ModelPart};
use hedgehop_base::error::Result;

/// Alpha below which what is meant to be seen through is not shown.
const SEEN_THROUGH: f32 = 0.5;

/// Bytes of a binary file's header.
const HEADER: usize = 12;

/// Extensions that a file may require.
const READ: [&str; 1] = ["KHR_texture_transform"];

/// Errors of a file that are told at once.
const MOST_TOLD: usize = 3;

/// A file while it is read.
struct Reader<'d> {
    document: &'d Gltf,
    buffers: Vec<Vec<u8>>,
    pictures: Pictures,
    /// Bytes of images, and textures made of them, by index.
    textures: Vec<Option<Arc<Texture>>>,
    raw: Model,
}

pub(super) fn read(bytes: &[u8], files: &mut Files<'_>) -> Result<Model> {
    numbers::check(bytes).map_err(|what| files.wrong(what))?;
    let mut document = parse(bytes, files)?;
    let blob = document.blob.take();
    let buffers = buffers(&document, blob, files)?;
    let count = document.textures().count();
    let raw = Model { notes: notes(&document), ..Model::new(axes()) };
    let mut reader = Reader {
        document: &document,
        buffers,
        pictures: Pictures::default(),
        textures: vec![None; count],
        raw,
    };
    reader.nodes(files)?;
    Ok(reader.raw)
}

/// Y is up, and the front looks along Z (3.4): X is to the left.
fn axes() -> DMat3 {
    DMat3::from_cols(DVec3::NEG_X, DVec3::Z, DVec3::Y)
}

fn parse(bytes: &[u8], files: &Files<'_>) -> Result<Gltf> {
    if bytes.starts_with(b"glTF") {
        let length =
            bytes.get(8..HEADER).and_then(<[u8]>::first_chunk).map(|length| u32::from_le_bytes(*length));
        if length.is_none_or(|length| (length as usize) < HEADER) {
            return Err(files.wrong("it is cut short in its header"));
        }
    }

    let bytes = files.text(bytes)?;
    let clause = |error: gltf::Error| match error {
        gltf::Error::Validation(errors) => {
            let told: Vec<_> =
                errors.iter().take(MOST_TOLD).map(|(path, error)| format!("{path}: {error}")).collect();
            format!("it is no glTF 2.0 that is understood: {}", told.join("; "))
        }
        gltf::Error::Deserialize(error) => format!("it is no glTF: {error}"),
        other => format!("it is no glTF that can be read, or cut short: {other}"),
    };

    let wrong = |error: gltf::Error| files.wrong(clause(error));
    let read = Gltf::from_slice_without_validation(bytes).map_err(wrong)?;
    let root = read.document.into_json();
    if let Some(extension) =
        root.extensions_required.iter().find(|extension| !READ.contains(&extension.as_str()))
    {
        let what = format!("it requires {extension:?} (extensionsRequired), which is not read");
        return Err(files.unsupported(what, "export it without compression and without such extensions"));
    }

    // The library's own validation takes these for granted.
    let mut used =
        root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|part| part.attributes.values());
    if let Some(outside) = used.find(|index| index.value() >= root.accessors.len()) {
        return Err(files.wrong(format!("it names accessor {outside}, of {}", root.accessors.len())));
    }

    Ok(Gltf { document: gltf::Document::from_json(root).map_err(wrong)?, blob: read.blob })
}

/// Names the parts of a file that are not shown.
fn notes(document: &Gltf) -> Vec<String> {
    let mut notes = Vec::new();
    if document.animations().next().is_some() {
        notes.push("its animations are not played".to_owned());
    }
    if document.skins().next().is_some() {
        notes.push("its skins are shown at rest".to_owned());
    }
    if document
        .meshes()
        .flat_map(|mesh| mesh.primitives())
        .any(|primitive| primitive.morph_targets().next().is_some())
    {
        notes.push("its morph targets are not applied".to_owned());
    }
    notes
}

fn buffers(document: &Gltf, blob: Option<Vec<u8>>, files: &mut Files<'_>) -> Result<Vec<Vec<u8>>> {
    let mut blob = blob;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => blob
                .take()
                .ok_or_else(|| files.wrong("it has a buffer without bytes; the file may be cut short"))?,
            gltf::buffer::Source::Uri(uri) => match files::data(uri) {
                Some(bytes) => bytes.map_err(|what| files.wrong(what))?,
                None => files.beside(&files::name_of(uri))?,
            },
        };

        if bytes.len() < buffer.length() {
            let what = format!(
                "its buffer {} has {} of {} bytes; the file is cut short",
                buffer.index(),
                bytes.len(),
                buffer.length()
            );
            return Err(files.wrong(what));
        }

        buffers.push(bytes);
    }

    Ok(buffers)
}

impl Reader<'_> {
    /// Goes through the nodes of the scene.
    fn nodes(&mut self, files: &mut Files<'_>) -> Result<()> {
        let document = self.document;
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let scene = scene.ok_or_else(|| files.wrong("it has no scene, so that nothing of it is seen"))?;

        let mut met = vec![false; document.nodes().count()];
        let mut waiting: Vec<(Node<'_>, DMat4, Option<usize>)> =
            scene.nodes().map(|node| (node, DMat4::IDENTITY, None)).collect();
        while let Some((node, from_parent, above)) = waiting.pop() {
            if std::mem::replace(&mut met[node.index()], true) {
                let what = format!("its node {} is met twice; nodes must be a tree", node.index());
                return Err(files.wrong(what));
            }

            // Nodes come after those above them, whose axes they are in.
            let own = glam::Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
            let from_node = from_parent * own;
            let number = self.raw.nodes.len();
            self.raw.nodes.push(ModelNode { name: node.name().map(str::to_owned), above, from_node });

            // A node's mesh is parts of the model, one for each material.
            for primitive in node.mesh().into_iter().flat_map(|mesh| mesh.primitives()) {
                let part = self.part(&primitive, from_node, files);
                let place = |what: String| {
                    let mesh = node.mesh().map_or(0, |mesh| mesh.index());
                    files_wrong(files, format!("mesh {mesh}, primitive {}: {what}", primitive.index()))
                };

                match part {
                    Ok(Some(part)) => {
                        self.raw.push(ModelPart { node: Some(number), ..part });
                    }
                    Ok(None) => {}
                    Err(Wrong::Here(what)) => return Err(place(what)),
                    Err(Wrong::Elsewhere(error)) => return Err(error),
                }
            }

            waiting.extend(node.children().map(|child| (child, from_node, Some(number))));
        }

        if self.raw.parts.is_empty() {
            return Err(files.wrong("it shows no triangles"));
        }

        Ok(())
    }

    /// `None`: nothing of it is seen.
    fn part(
        &mut self,
        primitive: &Primitive<'_>,
        from_node: DMat4,
        files: &mut Files<'_>,
    ) -> std::result::Result<Option<ModelPart>, Wrong> {
        let Some(material) = self.material(primitive, files)? else { return Ok(None) };
        let (material, transform, set) = material;

        // Refuses or leaves out what has no triangles, before anything large is read.
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.note("its points and lines are not shown");
            return Ok(None);
        }
        let Some(place) = primitive.get(&Semantic::Positions) else {
            return Err(Wrong::Here("it has no positions".to_owned()));
        };
        if !from_node.is_finite() {
            return Err(Wrong::Here("the matrices of its nodes are not finite".to_owned()));
        }

        let count = primitive.indices().map_or(place.count(), |indices| indices.count());
        self.raw.check(count / 3, place.count())?;

        // Corners and the triangles between them; a mirrored node turns these inside out.
        let buffers = &self.buffers;
        let positions = accessor::vectors::<3>(&place, &Semantic::Positions, buffers, MOST_CORNERS)?;
        let turn = DMat3::from_mat4(from_node);
        let normal_turn = turn.inverse().transpose().as_mat3();
        let list = match primitive.indices() {
            Some(indices) => accessor::indices(&indices, buffers, 3 * MOST_TRIANGLES)?,
            None => (0..positions.len() as u32).collect(),
        };
        let Some(mut triangles) = triangles(primitive.mode(), &list) else {
            self.note("its points and lines are not shown");
            return Ok(None);
        };

        if turn.determinant() < 0.0 {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }

        self.raw.check(triangles.len(), positions.len())?;

        // Attributes of corners besides their positions.
        let vectors = |semantic: Semantic| {
            let found = primitive.get(&semantic);
            found.map(|found| accessor::vectors::<3>(&found, &semantic, buffers, MOST_CORNERS)).transpose()
        };
        let normals = vectors(Semantic::Normals)?.unwrap_or_default();
        let colours = vectors(Semantic::Colors(0))?.unwrap_or_default();
        let semantic = Semantic::TexCoords(set);

        let places = match primitive.get(&semantic) {
            Some(found) if material.texture.is_some() => {
                accessor::vectors::<2>(&found, &semantic, buffers, MOST_CORNERS)?
            }
            _ => Vec::new(),
        };

        // All of it in the model's axes.
        let placed = |place: &[f32; 3]| from_node.transform_point3(Vec3::from_array(*place).as_dvec3());
        let is_sound = normal_turn.is_finite();

        Ok(Some(ModelPart {
            positions: positions.iter().map(placed).collect(),
            normals: if is_sound {
                normals.into_iter().map(|normal| normal_turn * Vec3::from_array(normal)).collect()
            } else {
                Vec::new()
            },
            places: places
                .into_iter()
                .map(|place| (transform * Vec2::from_array(place).extend(1.0)).truncate())
                .collect(),
            colours: colours.into_iter().map(Vec3::from_array).collect(),
            triangles,
            material,
            node: None,
        }))
    }

    /// Reads the material of a primitive, the turn of places in its texture, and which they are; `None`: it is not seen.
    fn material(
        &mut self,
        primitive: &Primitive<'_>,
        files: &mut Files<'_>,
    ) -> std::result::Result<Option<(Material, Mat3, u32)>, Wrong> {
        let found = primitive.material();
        let surface = found.pbr_metallic_roughness();
        let [red, green, blue, alpha] = surface.base_color_factor();

        let mut cutoff = match found.alpha_mode() {
            AlphaMode::Opaque => None,
            AlphaMode::Mask => Some(found.alpha_cutoff().unwrap_or(0.5)),
            AlphaMode::Blend => {
                self.note("its see-through materials are shown where they are half opaque or more");
                Some(SEEN_THROUGH)
            }
        };

        // The texture, and which places in it corners have.
        let (mut transform, mut set, mut texture) = (Mat3::IDENTITY, 0, None);
        if let Some(info) = surface.base_color_texture() {
            set = info.tex_coord();
            if let Some(turned) = info.texture_transform() {
                set = turned.tex_coord().unwrap_or(set);
                // Counterclockwise about the upper left corner, as KHR_texture_transform has it.
                transform = Mat3::from_scale_angle_translation(
                    Vec2::from_array(turned.scale()),
                    -turned.rotation(),
                    Vec2::from_array(turned.offset()),
                );
            }
            texture = Some(self.texture(&info.texture(), files)?);
        }

        // Without a texture, alpha is the same everywhere: all is seen, or nothing.
        if texture.is_none()
            && let Some(least) = cutoff.take()
            && alpha < least
        {
            return Ok(None);
        }

        // The default material is none of the file's.
        let has_own = found.index().is_some() || primitive.get(&Semantic::Colors(0)).is_some();
        let colour = Vec3::new(red, green, blue).clamp(Vec3::ZERO, Vec3::ONE);

        let material = Material {
            colour: has_own.then_some(colour),
            alpha,
            texture,
            cutoff,
            both_sides: found.double_sided(),
        };

        Ok(Some((material, transform, set)))
    }

    fn texture(
        &mut self,
        texture: &gltf::Texture<'_>,
        files: &mut Files<'_>,
    ) -> std::result::Result<Arc<Texture>, Wrong> {
        if let Some(known) = &self.textures[texture.index()] {
            return Ok(known.clone());
        }

        let image = texture.source().index();
        let image = &self.document.as_json().images[image];
        let wrap = [texture.sampler().wrap_s(), texture.sampler().wrap_t()].map(|mode| match mode {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        });

        // The picture lies in a buffer, in an address, or in a file beside.
        let read;
        let bytes = match (&image.buffer_view, &image.uri) {
            (Some(view), _) => {
                let view = self.document.views().nth(view.value());
                let bytes = view.and_then(|view| {
                    let end = view.offset().checked_add(view.length())?;
                    self.buffers.get(view.buffer().index())?.get(view.offset()..end)
                });
                bytes.ok_or_else(|| "its texture reaches beyond its buffer".to_owned())?
            }
            (None, Some(uri)) => {
                read = match files::data(uri) {
                    Some(bytes) => bytes?,
                    None => files.beside(&files::name_of(uri)).map_err(Wrong::Elsewhere)?,
                };
                &read
            }
            (None, None) => return Err(Wrong::Here("its texture has no image".to_owned())),
        };

        let decoded = self.pictures.decode(bytes, wrap);
        let decoded = decoded.map_err(|what| format!("texture {}: {what}", texture.index()))?;
        self.textures[texture.index()] = Some(decoded.clone());

        Ok(decoded)
    }

    fn note(&mut self, note: &str) {
        if !self.raw.notes.iter().any(|known| known == note) {
            self.raw.notes.push(note.to_owned());
        }
    }
}

/// Fault of a primitive.
enum Wrong {
    Here(String),
    Elsewhere(hedgehop_base::error::Error),
}

impl From<String> for Wrong {
    fn from(what: String) -> Self {
        Self::Here(what)
    }
}

fn files_wrong(files: &Files<'_>, what: String) -> hedgehop_base::error::Error {
    files.wrong(what)
}

/// Corners by threes; `None`: they are no triangles.
fn triangles(mode: Mode, list: &[u32]) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        Mode::Triangles => list.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect(),
        Mode::TriangleStrip => {
            let turned = |(index, corners): (usize, &[u32])| {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                if index % 2 == 0 { [a, b, c] } else { [b, a, c] }
            };
            list.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let first = list.first().copied().unwrap_or(0);
            list.get(1..).unwrap_or_default().windows(2).map(|pair| [first, pair[0], pair[1]]).collect()
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return None,
    })
}
