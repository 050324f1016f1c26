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
//! entries and channels (`hedgehop.digest`) goes with them; [`decode`] compares it.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use ::exr::image::read::read;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Text};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, MetaData,
    ReadChannels, ReadLayers, WritableImage, f16,
};

use crate::encode::FrameInfo;
use crate::encode::info::{CAMERA_CONVENTIONS, Value};
use crate::encode::refusal::PictureRefusal;
use crate::frame::{Frame, Matte};
use crate::space::{Camera, Ray, Screen};
use hedgehop_base::Size;
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_base::error::{Error, Result};

type Channels = AnyChannels<FlatSamples>;

/// Meaning of the channels.
const CHANNEL_CONVENTIONS: &str = "R G B: linear Rec. 709, 1 is display white; Z: metres along the optical \
     axis (planar depth) on planar and orthographic screens, the range on others, range: metres along the ray \
     (slant), both +infinity for the sky; A: 0 where the screen has no picture, else 1; N: unit surface normal, \
     x east, y north, z up, 0 for the sky; level: index of the voxel level (side 4^level units), 255 for the \
     sky; id: source << 16 | material << 8 | flags, 4294967295 for the sky; worldToCamera: row vectors, \
     camera x right, y up, z forward; its translation is rounded to f32, the eye is exact in hedgehop.eye_m";

/// And of motion vectors.
const MOTION_CONVENTIONS: &str = "; forward: pixels to the right (u) and up (v) until the next frame";

/// Name of the attribute that holds the digest of entries and channels.
const DIGEST: &str = "hedgehop.digest";

/// Most bytes that one pixel of a file that is read may take in memory: ours takes 88 at most.
const PIXEL_BYTES: usize = 256;

/// The bytes of an EXR of `frame`.
pub(super) fn encode(path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Vec<u8>> {
    let channels = channels(frame);
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
    let mut bytes = Vec::new();
    image
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|source| Error::invalid(path, format!("the EXR encoder refuses the frame: {source}")))?;
    match sort_attributes(&bytes) {
        Some(sorted) => Ok(sorted),
        None => Err(Error::invalid(path, "the EXR encoder wrote a header that cannot be read back")),
    }
}

fn channels(frame: &Frame) -> Channels {
    let float = |plane: Vec<f32>| FlatSamples::F32(plane);
    let colour = |part: usize| {
        FlatSamples::F16(frame.colour.iter().map(|pixel| half_from_radiance(pixel[part])).collect())
    };
    let normal = |part: usize| {
        FlatSamples::F16(frame.normal.iter().map(|normal| f16::from_f32(normal[part])).collect())
    };
    let alpha = FlatSamples::F16(rays(frame).map(|ray| ray.map_or(f16::ZERO, |_| f16::ONE)).collect());
    let level = FlatSamples::U32(frame.level.iter().copied().map(u32::from).collect());

    let named = [
        ("R", colour(0)),
        ("G", colour(1)),
        ("B", colour(2)),
        ("A", alpha),
        ("Z", float(depth(frame))),
        ("range", float(frame.range.clone())),
        ("N.X", normal(0)),
        ("N.Y", normal(1)),
        ("N.Z", normal(2)),
        ("level", level),
        ("id", FlatSamples::U32(frame.id.clone())),
    ];

    let aov =
        further(frame).into_iter().map(|(name, samples)| AnyChannel::new(name.as_str(), float(samples)));
    AnyChannels::sort(
        named.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).chain(aov).collect(),
    )
}

/// Channels that were asked for.
fn further(frame: &Frame) -> Vec<(String, Vec<f32>)> {
    let mut channels = frame.aov.matte.as_ref().map_or_else(Vec::new, |matte| matte.channels(frame));
    if let Some(motion) = &frame.aov.motion {
        let part = |part: usize| motion.iter().map(|vector| vector[part]).collect();
        channels.extend(
            ["forward.u", "forward.v"].into_iter().zip([part(0), part(1)]).map(|(n, p)| (n.to_owned(), p)),
        );
    }
    if frame.aov.material {
        let mark = |id: &u32| {
            Frame::material_of(*id).map_or([0.0; 3], |material| linear_from_srgb8(material.mark()))
        };
        let part = |part: usize| frame.id.iter().map(|id| mark(id)[part]).collect();
        let names = ["material.R", "material.G", "material.B"].map(str::to_owned);
        channels.extend(names.into_iter().zip([part(0), part(1), part(2)]));
    }
    channels
}

/// Radiance as a half: what exceeds the largest half, 65504, is clipped to it, not made infinite.
fn half_from_radiance(radiance: f32) -> f16 {
    f16::from_f32(radiance.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
}

/// The ray of every pixel, row by row.
fn rays(frame: &Frame) -> impl Iterator<Item = Option<Ray>> + '_ {
    let camera = &frame.camera;
    let pixels = (0..camera.height).flat_map(|row| (0..camera.width).map(move |column| (column, row)));
    pixels.map(|(column, row)| camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5))
}

/// Metres along the optical axis of every pixel, `Z = range · cos`, where all of the picture lies before the eye; else the
/// range, since depth along an axis says nothing of what is beside or behind it.
fn depth(frame: &Frame) -> Vec<f32> {
    let camera = &frame.camera;
    if !matches!(camera.screen(), Screen::Planar { .. } | Screen::Lens { .. } | Screen::Orthographic { .. }) {
        return frame.range.clone();
    }
    let planar = |(ray, &range): (Option<Ray>, &f32)| match ray {
        Some(ray) => (f64::from(range) * camera.axis_cosine(ray.direction)) as f32,
        None => f32::INFINITY,
    };
    rays(frame).zip(&frame.range).map(planar).collect()
}

fn attributes(frame: &Frame, info: &FrameInfo, channels: &Channels) -> LayerAttributes {
    let camera = &frame.camera;
    let mut attributes = LayerAttributes::default();
    let mut entries = info.entries(camera);
    let texts = entries.iter().map(|(name, value)| ((*name).to_owned(), value.to_string())).collect();
    entries.push((DIGEST, Value::Text(digest(&texts, channels))));
    let motion = frame.aov.motion.as_ref().map_or("", |_| MOTION_CONVENTIONS);
    let conventions = format!("{CAMERA_CONVENTIONS}; {CHANNEL_CONVENTIONS}{motion}");
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

/// BLAKE3 of the entries and of every channel's name, type and samples (little-endian).
fn digest(entries: &BTreeMap<String, String>, channels: &Channels) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, value) in entries {
        hasher.update(format!("{name}={value}\0").as_bytes());
    }
    for channel in &channels.list {
        hasher.update(channel.name.as_slice());
        match &channel.sample_data {
            FlatSamples::U32(samples) => absorb(&mut hasher, 0, samples, |&sample| sample),
            FlatSamples::F16(samples) => {
                absorb(&mut hasher, 1, samples, |sample| u32::from(sample.to_bits()))
            }
            FlatSamples::F32(samples) => absorb(&mut hasher, 2, samples, |sample| sample.to_bits()),
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// Adds samples of the type `kind` to a digest, a block at a time.
fn absorb<T>(hasher: &mut blake3::Hasher, kind: u8, samples: &[T], bits: impl Fn(&T) -> u32) {
    const BLOCK: usize = 4096;
    hasher.update(&[0, kind]);
    let mut buffer = Vec::with_capacity(BLOCK * size_of::<u32>());
    for block in samples.chunks(BLOCK) {
        buffer.clear();
        buffer.extend(block.iter().flat_map(|sample| bits(sample).to_le_bytes()));
        hasher.update(&buffer);
    }
}

/// The file with its header's attributes in alphabetical order; `None` if the header cannot be walked.
fn sort_attributes(bytes: &[u8]) -> Option<Vec<u8>> {
    let start = 8; // magic number and version
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut rest = bytes.get(start..)?;
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
    let mut sorted = Vec::with_capacity(bytes.len());
    sorted.extend_from_slice(&bytes[..start]);
    sorted.extend(attributes.into_iter().flatten());
    sorted.extend_from_slice(rest);
    Some(sorted)
}

/// A file that was read: size, channels and entries.
pub(super) struct Decoded {
    pub width: u32,
    pub height: u32,
    channels: Channels,
    pub entries: BTreeMap<String, String>,
}

impl Decoded {
    /// The samples of a channel, `[height][width]`.
    pub fn channel(&self, name: &str) -> Option<&FlatSamples> {
        let found = self.channels.list.iter().find(|channel| &channel.name == name)?;
        Some(&found.sample_data)
    }

    /// Names of the channels.
    pub fn channel_names(&self) -> Vec<String> {
        self.channels.list.iter().map(|channel| channel.name.to_string()).collect()
    }

    /// Linear colour, `[height][width]`; `None` without half or float channels `R G B`.
    pub fn colour(&self) -> Option<Vec<[f32; 3]>> {
        let plane = |name: &str| match self.channel(name)? {
            FlatSamples::F16(samples) => Some(samples.iter().map(|sample| sample.to_f32()).collect()),
            FlatSamples::F32(samples) => Some(samples.clone()),
            FlatSamples::U32(_) => None,
        };
        let (red, green, blue): (Vec<f32>, Vec<f32>, Vec<f32>) = (plane("R")?, plane("G")?, plane("B")?);
        Some(red.into_iter().zip(green).zip(blue).map(|((red, green), blue)| [red, green, blue]).collect())
    }
}

/// Decodes a whole EXR and compares its digest. `size` is the only one that is accepted, if given.
pub(super) fn decode(bytes: &[u8], size: Option<Size>) -> Result<Decoded, PictureRefusal> {
    let Size { width, height } = check_header(bytes, size)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .pedantic()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;

    let layer = image.layer_data;
    let mut entries = entries_of(&layer.attributes);
    let channels = layer.channel_data;
    match entries.remove(DIGEST) {
        Some(recorded) if recorded == digest(&entries, &channels) => {}
        None if entries.is_empty() => {} // written by another program
        Some(_) => return Err("its content does not match the digest in its header".to_owned().into()),
        None => return Err("its header has lost the digest of its content".to_owned().into()),
    }

    Ok(Decoded { width, height, channels, entries })
}

/// Validates what decides how much memory decoding takes, and returns the size.
pub(super) fn check_header(bytes: &[u8], size: Option<Size>) -> Result<Size, PictureRefusal> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(|error| error.to_string())?;
    let [header] = meta.headers.as_slice() else { return Err("it has more than one part".to_owned().into()) };
    if header.deep {
        return Err("it has deep samples".to_owned().into());
    }
    let Vec2(width, height) = header.layer_size;
    let (Ok(width), Ok(height)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err("it is too large".to_owned().into());
    };
    let found = Size { width, height };
    PictureRefusal::other_size(found, size)?;
    if header.channels.bytes_per_pixel > PIXEL_BYTES {
        return Err(format!("it has {} bytes per pixel", header.channels.bytes_per_pixel).into());
    }
    Ok(found)
}

/// The entries that [`attributes`] put there, conventions left out.
fn entries_of(attributes: &LayerAttributes) -> BTreeMap<String, String> {
    let ours = attributes.other.iter().filter_map(|(name, value)| {
        let value = match value {
            AttributeValue::Text(value) => String::from_utf8_lossy(value.as_slice()).into_owned(),
            AttributeValue::F64(value) => value.to_string(),
            _ => return None,
        };
        let name = String::from_utf8_lossy(name.as_slice()).into_owned();
        (name.starts_with("hedgehop.") && name != "hedgehop.conventions").then_some((name, value))
    });
    ours.collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::encode::testing;

    fn encoded(frame: &Frame) -> Vec<u8> {
        encode(Path::new("a.exr"), frame, &testing::info()).unwrap()
    }

    fn flat(bytes: &[u8]) -> Layer<Channels> {
        let read = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
        read.all_attributes().non_parallel().from_buffered(Cursor::new(bytes)).unwrap().layer_data
    }

    fn plane(layer: &Layer<Channels>, name: &str) -> FlatSamples {
        layer.channel_data.list.iter().find(|channel| &channel.name == name).unwrap().sample_data.clone()
    }

    #[test]
    fn planes_come_back() {
        let frame = testing::frame(37, 40);
        let layer = flat(&encoded(&frame));
        let names: Vec<_> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "id", "level", "range"]);
        assert_eq!(plane(&layer, "range"), FlatSamples::F32(frame.range.clone()));
        assert_eq!(plane(&layer, "id"), FlatSamples::U32(frame.id.clone()));
        let levels = frame.level.iter().map(|&level| u32::from(level)).collect();
        assert_eq!(plane(&layer, "level"), FlatSamples::U32(levels));
        let greens = frame.colour.iter().map(|pixel| f16::from_f32(pixel[1])).collect();
        assert_eq!(plane(&layer, "G"), FlatSamples::F16(greens));
        let up = frame.normal.iter().map(|normal| f16::from_f32(normal[2])).collect();
        assert_eq!(plane(&layer, "N.Z"), FlatSamples::F16(up));
        assert_eq!(plane(&layer, "A"), FlatSamples::F16(vec![f16::ONE; frame.colour.len()]));
    }

    /// Z of a pixel is the forward coordinate of the point at its range, found the other way round:
    /// through the matrix in the header.
    #[test]
    fn z_is_planar_and_the_matrix_maps_to_the_camera() {
        let mut frame = testing::frame(16, 12);
        let mut pose = frame.camera.pose;
        pose.eye = DVec3::new(120.0, -45.0, 310.0);
        frame.camera = Camera::new(pose, 16, 12);
        let layer = flat(&encoded(&frame));
        let FlatSamples::F32(depth) = plane(&layer, "Z") else { panic!("Z is float") };
        let matrix = layer.attributes.world_to_camera.unwrap();

        for row in 4..12 {
            for column in 0..16 {
                let at = row * 16 + column;
                let direction = frame.camera.direction(column as f64 + 0.5, row as f64 + 0.5);
                let point = pose.eye + direction * f64::from(frame.range[at]);
                let homogeneous = [point.x, point.y, point.z, 1.0];
                let view: Vec<f64> = (0..4)
                    .map(|to| (0..4).map(|from| homogeneous[from] * f64::from(matrix[from * 4 + to])).sum())
                    .collect();
                let screen = (
                    8.0 + view[0] / view[2] * frame.camera.focal_px(),
                    6.0 - view[1] / view[2] * frame.camera.focal_px(),
                );
                assert!((f64::from(depth[at]) / view[2] - 1.0).abs() < 1e-5, "{} {}", depth[at], view[2]);
                assert!((screen.0 - column as f64 - 0.5).abs() < 1e-3, "{screen:?} {column}");
                assert!((screen.1 - row as f64 - 0.5).abs() < 1e-3, "{screen:?} {row}");
                assert_eq!(view[3], 1.0);
            }
        }

        assert_eq!(depth[0], f32::INFINITY, "the sky");
    }

    #[test]
    fn around_the_eye_z_is_range_and_nothing_is_transparent_beyond_the_picture() {
        let mut frame = testing::frame(16, 12);
        frame.camera = Camera::with_screen(frame.camera.pose, Screen::Fisheye { fov: 180.0 }, 16, 12);
        let layer = flat(&encoded(&frame));
        assert_eq!(plane(&layer, "Z"), FlatSamples::F32(frame.range.clone()));
        let FlatSamples::F16(alpha) = plane(&layer, "A") else { panic!("A is half") };
        assert_eq!((alpha[0], alpha[6 * 16 + 8]), (f16::ZERO, f16::ONE));
        let attributes = &layer.attributes;
        assert_eq!(attributes.horizontal_field_of_view, None);
        let decoded = decode(&encoded(&frame), None).unwrap();
        assert_eq!(decoded.entries["hedgehop.screen"], "fisheye fov_deg=180");
        assert!(!decoded.entries.contains_key("hedgehop.hfov_deg"));
    }

    #[test]
    fn attributes_say_what_made_the_frame() {
        let frame = testing::frame(16, 9);
        let bytes = encoded(&frame);
        let layer = flat(&bytes);
        let attributes = &layer.attributes;
        let other = |name: &str| attributes.other[&text(name)].clone();
        assert_eq!(other("hedgehop.yaw_deg"), AttributeValue::F64(33.0));
        assert_eq!(other("hedgehop.hfov_deg"), AttributeValue::F64(60.0));
        let decoded = decode(&bytes, None).unwrap();
        assert_eq!(decoded.entries["hedgehop.eye_m"], "500123.456789 4649776.225 312.75");
        assert_eq!(decoded.entries["hedgehop.database_file"], "Küste.hop");
        assert_eq!(attributes.software_name.as_ref().unwrap(), "hedgehop 0.1.0");
        assert_eq!(attributes.horizontal_field_of_view, Some(60.0));
        let width = 2.0 * 30.0_f64.to_radians().tan();
        assert!((f64::from(attributes.screen_window_width) - width).abs() < 1e-6);
        assert!(attributes.layer_name.is_none(), "the colour is the default layer");
    }

    #[test]
    fn equal_frames_are_equal_bytes_and_attributes_are_sorted() {
        let first = encoded(&testing::frame(40, 33));
        for _ in 0..4 {
            assert_eq!(first, encoded(&testing::frame(40, 33)));
        }
    }

    #[test]
    fn colours_beyond_half_are_clipped() {
        assert_eq!(half_from_radiance(1e9), f16::MAX);
        assert_eq!(half_from_radiance(f32::INFINITY), f16::MAX);
        assert_eq!(half_from_radiance(0.5), f16::from_f32(0.5));
    }

    #[test]
    fn colour_is_found_again() {
        let frame = testing::frame(8, 8);
        let colour = decode(&encoded(&frame), Some(Size { width: 8, height: 8 })).unwrap().colour().unwrap();
        assert!((colour[20][1] - frame.colour[20][1]).abs() < 1e-3);
        assert!(decode(&encoded(&frame), Some(Size { width: 8, height: 9 })).is_err());
    }
}
