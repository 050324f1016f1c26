//! Tables of rays as EXR: the "image mapping" of screens that no formula describes.
//!
//! Three channels of 32-bit floats, `X Y Z` or, as image programs name them, `R G B`: for each pixel the direction of its
//! ray in the axes of the view, x right, y up, z forward, of any length. Zero, infinite or NaN: no ray. Other channels
//! are ignored. Halves are refused: their steps of 1/2048 are wider than a pixel.

use std::io::Cursor;
use std::path::Path;

use ::exr::prelude::{AnyChannel, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};

use crate::encode::refusal::PictureRefusal;
use crate::encode::{Written, atomic, exr, read_regular};
use crate::space::RayTable;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Names that the channels may have.
const CHANNELS: [[&str; 3]; 2] = [["X", "Y", "Z"], ["R", "G", "B"]];

/// Widest and highest table: as large as a picture may be.
const MOST_PIXELS_A_SIDE: u32 = 16384;

/// Reads a table of rays.
///
/// # Errors
/// [`Error::Io`] if there is no such file; [`Error::Invalid`] if it is no EXR, lacks the channels, or holds no direction;
/// [`Error::Unsupported`] if its channels are not 32-bit floats.
pub fn read_ray_table(path: &Path) -> Result<RayTable> {
    let bytes = read_regular(path, "read the table of rays")?;
    let no_table = |refusal: PictureRefusal| {
        Error::invalid(path, format!("this is no EXR with a table of rays: {refusal}; write it again"))
    };
    let Size { width, height } = exr::check_header(&bytes, None).map_err(no_table)?;
    if width.max(height) > MOST_PIXELS_A_SIDE {
        let what = format!(
            "a table of {width}×{height} rays is too large; make it at most {MOST_PIXELS_A_SIDE} a side, it is \
             interpolated"
        );
        return Err(Error::invalid(path, what));
    }

    let decoded = exr::decode(&bytes, None).map_err(no_table)?;
    let has = |names: &&[&str; 3]| names.iter().all(|name| decoded.channel(name).is_some());
    let Some(names) = CHANNELS.iter().find(has) else {
        let what = format!(
            "a table of rays needs channels X, Y, Z (or R, G, B), and this file has {}; rename its channels",
            decoded.channel_names().join(", ")
        );
        return Err(Error::invalid(path, what));
    };

    let pixels = width as usize * height as usize;
    let plane = |name: &str| match decoded.channel(name) {
        Some(FlatSamples::F32(samples)) if samples.len() == pixels => Ok(samples),
        _ => Err(Error::unsupported(
            path,
            format!("channel {name} does not hold a 32-bit float for every pixel"),
            "write the table of rays with float channels (pixel type FLOAT)",
        )),
    };

    let [x, y, z] = [plane(names[0])?, plane(names[1])?, plane(names[2])?];
    let directions = x.iter().zip(y).zip(z).map(|((&x, &y), &z)| [x, y, z]).collect();
    RayTable::new(width, height, directions).map_err(|error| match error {
        Error::Configuration(what) => Error::invalid(path, format!("{what}; write the table again")),
        other => other,
    })
}

/// Writes a table of rays as channels `X Y Z`, zero where there is no ray. The file appears whole or not at all.
pub fn write_ray_table(path: &Path, table: &RayTable) -> Result<Written> {
    let plane =
        |part: usize| FlatSamples::F32(table.directions().iter().map(|direction| direction[part]).collect());
    let named = ["X", "Y", "Z"].into_iter().enumerate();
    let channels = named.map(|(part, name)| AnyChannel::new(name, plane(part))).collect();
    let size = (table.size().x as usize, table.size().y as usize);
    let layer =
        Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, exr::by_name(channels));
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|source| Error::invalid(path, format!("the EXR encoder refuses the table: {source}")))?;
    atomic::write_bytes(path, &bytes)?;
    Ok(Written::from_bytes(&bytes))
}

#[cfg(test)]
mod tests {
    use ::exr::prelude::f16;

    use super::*;
    use crate::encode::{testing, write_frame};
    use crate::space::Screen;

    /// An EXR of the named channels.
    fn write(path: &Path, channels: Vec<(&str, FlatSamples)>, size: (usize, usize)) {
        let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
        let channels = exr::by_name(list);
        let layer = Layer::new(size, LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
        Image::from_layer(layer).write().non_parallel().to_file(path).unwrap();
    }

    fn refusal(path: &Path, parts: &[&str]) {
        let message = read_ray_table(path).unwrap_err().to_string();
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(parts.iter().chain([&name]).all(|part| message.contains(part)), "{message}");
    }

    #[test]
    fn a_table_comes_back() {
        let (_folder, path) = testing::place("dome.exr");
        let table = RayTable::of_screen(&Screen::Fisheye { fov: 220.0 }, 61, 47).unwrap();
        let written = write_ray_table(&path, &table).unwrap();
        let read = read_ray_table(&path).unwrap();
        assert_eq!(read.size(), table.size());
        let pairs = read.directions().iter().zip(table.directions());
        pairs.for_each(|(one, other)| assert!((*one - *other).length() < 2e-7));
        assert!(read.directions()[0] == glam::Vec3::ZERO, "a corner has no ray");
        assert_eq!(write_ray_table(&path, &table).unwrap(), written, "equal tables are equal bytes");
    }

    #[test]
    fn colours_of_any_length_are_directions() {
        let (_folder, path) = testing::place("rays.exr");
        let channels = [("R", [0.0, 3.0]), ("G", [0.0, 0.0]), ("B", [0.5, 4.0]), ("extra", [9.0, 9.0])];
        let channels = channels.into_iter().map(|(name, plane)| (name, FlatSamples::F32(plane.to_vec())));
        write(&path, channels.collect(), (2, 1));
        let table = read_ray_table(&path).unwrap();
        assert_eq!(table.directions(), [glam::Vec3::Z, glam::Vec3::new(0.6, 0.0, 0.8)]);
    }

    #[test]
    fn what_is_no_table_is_refused_with_the_reason() {
        let (folder, path) = testing::place("rays.exr");
        refusal(&path, &["read the table of rays"]);
        std::fs::write(&path, b"v/1\x01 no").unwrap();
        refusal(&path, &["no EXR"]);
        let floats = |value: f32| FlatSamples::F32(vec![value; 4]);
        write(&path, vec![("X", floats(1.0)), ("Y", floats(1.0))], (2, 2));
        refusal(&path, &["X, Y, Z", "has X, Y;"]);
        write(&path, ["X", "Y", "Z"].map(|name| (name, floats(f32::NAN))).to_vec(), (2, 2));
        refusal(&path, &["no pixel of the table has a direction"]);
        let half = FlatSamples::F16(vec![f16::ONE; 4]);
        write(&path, ["X", "Y", "Z"].map(|name| (name, half.clone())).to_vec(), (2, 2));
        refusal(&path, &["channel X", "float"]);
        let frame = folder.path().join("frame.exr");
        write_frame(&frame, &testing::frame(8, 6), &testing::info()).unwrap();
        refusal(&frame, &["channel R", "float"]);
    }

    #[test]
    fn no_prefix_of_a_table_is_one() {
        let (_folder, path) = testing::place("rays.exr");
        let table = RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 9, 6).unwrap();
        write_ray_table(&path, &table).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(read_ray_table(&path).is_err(), "{length} of {} bytes", bytes.len());
        }
        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x41;
            std::fs::write(&path, &bytes).unwrap();
            // Whatever it says: it returns, and a table is whole.
            if let Ok(table) = read_ray_table(&path) {
                assert_eq!(table.directions().len(), (table.size().x * table.size().y) as usize);
            }
        }
    }
}
