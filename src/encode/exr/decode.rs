//! EXR files that are read back, and the header that decides how much memory that takes.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::exr::image::read::read;
use ::exr::math::Vec2;
use ::exr::meta::attribute::AttributeValue;
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{FlatSamples, MetaData, ReadChannels, ReadLayers};

use super::channels::Channels;
use super::digest::{DIGEST, digest};
use crate::encode::refusal::PictureRefusal;
use hedgehop_base::Size;

/// Most bytes that one pixel of a file that is read may take in memory: hedgehop's own takes fewer than 128.
const PIXEL_BYTES: usize = 256;

/// A file that was read: size, channels and entries.
pub(in crate::encode) struct Decoded {
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
pub(in crate::encode) fn decode(bytes: &[u8], size: Option<Size>) -> Result<Decoded, PictureRefusal> {
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
pub(in crate::encode) fn check_header(bytes: &[u8], size: Option<Size>) -> Result<Size, PictureRefusal> {
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

/// Returns the entries that hedgehop put there, conventions left out.
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
