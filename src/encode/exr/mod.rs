//! OpenEXR: linear colour, distances, normals and identities of every pixel in one file.
//!
//! | channel | type | content |
//! |---|---|---|
//! | `R G B A` | half | linear Rec. 709, 1 is display white; A is 1, 0 where the screen has no picture |
//! | `Z` | float | metres along the optical axis (planar depth) on planar and orthographic screens, `range` on others |
//! | `range` | float | metres along the ray (slant range), +∞ for the sky |
//! | `N.X N.Y N.Z` | half | unit normal, x east, y north, z up; 0 for the sky |
//! | `level` | uint | level index of the surface, 255 for the sky |
//! | `id` | uint | source << 16 \| material << 8 \| flags, 4294967295 for the sky |
//! | `material.R`, `.G`, `.B` | float | a colour for each material, linear, if asked for |
//! | `forward.u`, `forward.v` | float | pixels to the right and up until the next frame, if asked for ([`crate::frame::motion`]) |
//! | `P.X`, `P.Y`, `P.Z` | float | metres from `hedgehop.position_offset_m` on the map, +∞ for the sky, if asked for ([`crate::frame::MapPositions`]) |
//! | `CryptoObject00.R` … | float | ids and shares of bodies and ground, if asked for ([`crate::frame::Matte`]) |
//!
//! The colour channels have no layer prefix, since viewers open a blank picture without a default
//! layer. ZIP compression, 16 scan lines at a time, every reader knows it.
//!
//! The `exr` crate keeps custom attributes in a hash map and writes them in its order, which differs
//! from run to run. [`sort_attributes`] puts the finished header into alphabetical order, which moves
//! nothing behind it. With that, equal frames are equal bytes.
//!
//! The format has no checksums over its header, nor over blocks that do not compress, so that a digest of
//! entries and channels (`hedgehop.digest`) goes with them; [`decode()`] compares it.

mod channels;
mod decode;
mod digest;
#[cfg(test)]
mod tests;
mod zip;

use std::io::Cursor;
use std::path::Path;

use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::block::writer::ChunksWriter;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Text};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{Blocks, Compression, Encoding, Image, Layer, WritableImage};

use crate::encode::FrameInfo;
use crate::encode::info::{CAMERA_CONVENTIONS, Value};
use crate::frame::{Frame, Matte};
use crate::space::{Camera, Screen};
use crate::subimage::{Farm, Stage};
pub(super) use channels::by_name;
use channels::{
    CHANNEL_CONVENTIONS, Channels, MOTION_CONVENTIONS, POSITION_CONVENTIONS, SYNTHESIS_CONVENTIONS,
};
use digest::{DIGEST, digest};
use hedgehop_base::error::{Error, Result};
use zip::Zip;

pub(super) use decode::{check_header, decode};

/// Lines of a chunk.
const CHUNK_ROWS: usize = Compression::ZIP16.scan_lines_per_block();

/// Bytes of a header and its table of chunks, about.
const HEADER_BYTES: usize = 1 << 14;

/// The bytes of an EXR of `frame`, made by the workers of `farm`; they are the same for any number.
pub(super) fn encode(path: &Path, frame: &Frame, info: &FrameInfo, farm: &Farm) -> Result<Vec<u8>> {
    let channels = channels::channels(frame, farm);
    let attributes = attributes(frame, info, &channels);
    let size = Vec2(frame.camera.width as usize, frame.camera.height as usize);
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let mut image = Image::from_layer(Layer::new(size, attributes, encoding, channels));

    image.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    let headers = image.write().infer_meta_data();
    let chunks = chunks(&image.layer_data.channel_data, size, farm)?;

    let mut bytes = Vec::with_capacity(HEADER_BYTES + chunks.iter().map(Vec::len).sum::<usize>());
    ::exr::block::write(Cursor::new(&mut bytes), headers, true, |_, writer| {
        for (index, (top, compressed_pixels_le)) in (0..).step_by(CHUNK_ROWS).zip(chunks).enumerate() {
            let block = CompressedScanLineBlock { y_coordinate: top, compressed_pixels_le };
            let compressed_block = CompressedBlock::ScanLine(block);
            writer.write_chunk(index, Chunk { layer_index: 0, compressed_block })?;
        }
        Ok(())
    })
    .map_err(|source| Error::invalid(path, format!("the EXR encoder refuses the frame: {source}")))?;

    match sort_attributes(&mut bytes) {
        Some(()) => Ok(bytes),
        None => Err(Error::invalid(path, "the EXR encoder wrote a header that cannot be read back")),
    }
}

/// Compresses channels, chunk by chunk.
fn chunks(channels: &Channels, size: Vec2<usize>, farm: &Farm) -> Result<Vec<Vec<u8>>> {
    let mut chunks = vec![Vec::new(); size.height().div_ceil(CHUNK_ROWS)];
    let tasks = chunks.iter_mut().collect();
    farm.each_with(Stage::Image, tasks, Zip::default, |zip, index, chunk| {
        let top = index * CHUNK_ROWS;
        *chunk = zip.compress(channels, size.width(), top..size.height().min(top + CHUNK_ROWS));
        Ok(())
    })?;
    Ok(chunks)
}

fn attributes(frame: &Frame, info: &FrameInfo, channels: &Channels) -> LayerAttributes {
    let camera = &frame.camera;
    let mut attributes = LayerAttributes::default();
    let mut entries = info.entries(camera);
    if let Some(position) = &frame.aov.position {
        let [x, y, z] = position.offset.to_array();
        entries.push(("hedgehop.position_offset_m", Value::Text(format!("{x} {y} {z}"))));
    }
    let texts = entries.iter().map(|(name, value)| ((*name).to_owned(), value.to_string())).collect();
    entries.push((DIGEST, Value::Text(digest(&texts, channels))));
    let motion = frame.aov.motion.as_ref().map_or("", |_| MOTION_CONVENTIONS);
    let position = frame.aov.position.as_ref().map_or("", |_| POSITION_CONVENTIONS);
    let synthesis = frame.aov.synthesis.as_ref().map_or("", |_| SYNTHESIS_CONVENTIONS);
    let conventions = format!("{CAMERA_CONVENTIONS}; {CHANNEL_CONVENTIONS}{motion}{position}{synthesis}");
    entries.push(("hedgehop.conventions", Value::Text(conventions)));

    for (name, value) in entries {
        let value = match value {
            Value::Text(value) => AttributeValue::Text(text(&value)),
            Value::Number(value) => AttributeValue::F64(value),
        };
        attributes.other.insert(text(name), value);
    }

    for (name, value) in frame.aov.matte.iter().flat_map(Matte::attributes) {
        attributes.other.insert(text(&name), AttributeValue::Text(text(&value)));
    }
    attributes.software_name = Some(text(&info.writer));
    attributes.world_to_camera = Some(camera_from_world(camera));

    // OpenEXR's own attributes know planes only; `hedgehop.screen` says what others are.
    if let Screen::Planar { hfov } = *camera.screen() {
        attributes.horizontal_field_of_view = Some(hfov as f32);
        let half_height = 0.5 * f64::from(camera.height) / camera.focal_px();
        attributes.vertical_field_of_view = Some((2.0 * half_height.atan()).to_degrees() as f32);
        // The window that the screen covers in the plane at distance 1 (OpenEXR, Technical Introduction).
        attributes.screen_window_width = (f64::from(camera.width) / camera.focal_px()) as f32;
    }

    attributes
}

/// EXR text is bytes; UTF-8 is what readers assume now.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// `v_camera = v_world · M` with row vectors, as OpenEXR wants it, row by row.
fn camera_from_world(camera: &Camera) -> [f32; 16] {
    let axes = camera.world_from_view();
    let eye = camera.pose.eye;
    let columns = [axes.x_axis, axes.y_axis, axes.z_axis];
    let mut matrix = [0.0; 16];
    for (column, axis) in columns.into_iter().enumerate() {
        for (row, value) in [axis.x, axis.y, axis.z, -axis.dot(eye)].into_iter().enumerate() {
            matrix[row * 4 + column] = value as f32;
        }
    }
    matrix[15] = 1.0;
    matrix
}

/// Puts the attributes of a file's header into alphabetical order; `None` if the header cannot be walked.
fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    let header = bytes.get_mut(8..)?; // behind magic number and version
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut rest = &*header;
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&byte| byte == 0)?;
        let kind = rest.get(name + 1..)?.iter().position(|&byte| byte == 0)?;
        let value = name + kind + 2;
        let length = u32::from_le_bytes(rest.get(value..value + 4)?.try_into().ok()?);
        let (attribute, behind) = rest.split_at_checked(value + 4 + usize::try_from(length).ok()?)?;
        attributes.push(attribute);
        rest = behind;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    header.get_mut(..sorted.len())?.copy_from_slice(&sorted);
    Some(())
}
