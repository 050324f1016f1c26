//! Channels of an EXR file, from those of a frame.

use ::exr::block::samples::FromNativeSample;
use ::exr::prelude::{AnyChannel, AnyChannels, FlatSamples, f16};

use crate::encode::depth::depth;
use crate::frame::Frame;
use crate::space::{Camera, Screen};
use crate::subimage::Farm;
use hedgehop_base::colour::linear_from_srgb8;

/// Samples of all channels of a file.
pub(in crate::encode) type Channels = AnyChannels<FlatSamples>;

/// Meaning of the channels.
pub(super) const CHANNEL_CONVENTIONS: &str = "R G B: linear Rec. 709, 1 is display white; Z: metres along the optical \
     axis (planar depth) on planar and orthographic screens, the range on others, range: metres along the ray \
     (slant), both +infinity for the sky; A: 0 where the screen has no picture, else 1; N: unit surface normal, \
     x east, y north, z up, 0 for the sky; level: index of the voxel level (side 4^level units), 255 for the \
     sky; id: source << 16 | material << 8 | flags, 4294967295 for the sky; worldToCamera: row vectors, \
     camera x right, y up, z forward; its translation is rounded to f32, the eye is exact in hedgehop.eye_m";

/// Meaning of motion vectors, where a file has them.
pub(super) const MOTION_CONVENTIONS: &str =
    "; forward: pixels to the right (u) and up (v) until the next frame";

/// Meaning of positions, where a file has them.
pub(super) const POSITION_CONVENTIONS: &str = "; P: metres east (X), north (Y) and up (Z) of \
     hedgehop.position_offset_m, on the map, as high as in the database over a curved Earth too, +infinity for the sky";

/// Meaning of the share that is made up, where a file has it.
pub(super) const SYNTHESIS_CONVENTIONS: &str = "; synthesis: change of light by detail below the finest voxel, relative to \
     what imagery alone knows, before haze and snow, 0 where there is none";

/// Returns all channels of a frame, sorted by name.
pub(super) fn channels(frame: &Frame, farm: &Farm) -> Channels {
    let float = |plane: Vec<f32>| FlatSamples::F32(plane);
    let colour = |part: usize| halves(frame, farm, &frame.colour, |pixel| within_half(pixel[part]));
    let normal = |part: usize| halves(frame, farm, &frame.normal, |normal| normal[part]);
    let level = FlatSamples::U32(frame.level.iter().copied().map(u32::from).collect());

    let named = [
        ("R", colour(0)),
        ("G", colour(1)),
        ("B", colour(2)),
        ("A", FlatSamples::F16(alpha(&frame.camera, farm))),
        ("Z", float(depth(frame, farm))),
        ("range", float(frame.range.clone())),
        ("N.X", normal(0)),
        ("N.Y", normal(1)),
        ("N.Z", normal(2)),
        ("level", level),
        ("id", FlatSamples::U32(frame.id.clone())),
    ];

    let aov =
        aov_channels(frame).into_iter().map(|(name, samples)| AnyChannel::new(name.as_str(), float(samples)));
    by_name(named.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).chain(aov).collect())
}

/// Puts channels into the order of their names, which files must have. A sort of what is that large takes seconds to compile.
pub(in crate::encode) fn by_name(channels: Vec<AnyChannel<FlatSamples>>) -> Channels {
    let mut sorted = AnyChannels { list: Default::default() };
    for channel in channels {
        let at = sorted.list.partition_point(|other: &AnyChannel<FlatSamples>| other.name < channel.name);
        sorted.list.insert(at, channel);
    }
    sorted
}

/// Returns the further channels that were asked for: mattes, motion, positions, what is made up, materials.
fn aov_channels(frame: &Frame) -> Vec<(String, Vec<f32>)> {
    let mut channels = frame.aov.matte.as_ref().map_or_else(Vec::new, |matte| matte.channels(frame));
    if let Some(motion) = &frame.aov.motion {
        let part = |part: usize| motion.iter().map(|vector| vector[part]).collect();
        channels.extend(
            ["forward.u", "forward.v"].into_iter().zip([part(0), part(1)]).map(|(n, p)| (n.to_owned(), p)),
        );
    }
    if let Some(position) = &frame.aov.position {
        let part = |part: usize| position.points.iter().map(|point| point[part]).collect();
        let names = ["P.X", "P.Y", "P.Z"].map(str::to_owned);
        channels.extend(names.into_iter().zip([part(0), part(1), part(2)]));
    }
    if let Some(synthesis) = &frame.aov.synthesis {
        channels.push(("synthesis".to_owned(), synthesis.clone()));
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

/// Returns a plane of halves, of one value of every pixel.
fn halves(
    frame: &Frame,
    farm: &Farm,
    pixels: &[[f32; 3]],
    value: impl Fn(&[f32; 3]) -> f32 + Sync + Send,
) -> FlatSamples {
    /// Values that are converted at once.
    const BLOCK: usize = 256;
    let width = frame.camera.width as usize;
    let mut plane = vec![f16::ZERO; pixels.len()];
    farm.rows(&mut plane, width, |row, line| {
        let pixels = &pixels[row * width..][..line.len()];
        for (halves, pixels) in line.chunks_mut(BLOCK).zip(pixels.chunks(BLOCK)) {
            let mut floats = [0.0; BLOCK];
            floats.iter_mut().zip(pixels).for_each(|(float, pixel)| *float = value(pixel));
            f16::from_f32s(&floats[..halves.len()], halves);
        }
    });
    FlatSamples::F16(plane)
}

/// Returns 1 for every pixel that has a ray, else 0.
fn alpha(camera: &Camera, farm: &Farm) -> Vec<f16> {
    let mut alpha = vec![f16::ONE; camera.width as usize * camera.height as usize];
    if let Screen::Planar { .. } = camera.screen() {
        return alpha;
    }
    farm.rows(&mut alpha, camera.width as usize, |row, line| {
        for (column, alpha) in line.iter_mut().enumerate() {
            if camera.mapped(column as f64 + 0.5, row as f64 + 0.5).is_none() {
                *alpha = f16::ZERO;
            }
        }
    });
    alpha
}

/// Radiance that a half can hold: what exceeds the largest, 65504, is clipped to it, not made infinite.
pub(super) fn within_half(radiance: f32) -> f32 {
    radiance.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())
}
