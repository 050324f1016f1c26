//! NumPy's format of arrays: depth of every pixel, and what made it behind.
//!
//! ```text
//! \x93NUMPY 1 0 │ length of the header, u16 │ header, blanks, \n │ f32 [height][width], little-endian    the depth
//! \x93NUMPY 1 0 │ length of the header, u16 │ header, blanks, \n │ bytes                                 JSON of entries
//! ```
//!
//! Headers have no room for entries of one's own. Several arrays one behind the other are a file that `numpy.save` makes, too:
//! `numpy.load` reads the first, and of an open file the next when it is called again (NumPy, NEP 1, *A Simple File Format
//! for NumPy Arrays*). The entries hold a digest of themselves and the depth, since the format has no checksums.

use std::collections::BTreeMap;
use std::path::Path;

use super::depth::depth;
use super::refusal::PictureRefusal;
use crate::encode::FrameInfo;
use crate::frame::Frame;
use crate::subimage::Farm;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// First bytes of an array: magic number and version.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
/// Multiple that the data of an array begins at.
const ALIGNMENT: usize = 64;
/// Name of the entry with the digest.
const DIGEST: &str = "hedgehop.digest";

/// The bytes of the depth of `frame`: metres along the optical axis, `[height][width]`, as in an EXR's `Z`.
pub(super) fn encode(path: &Path, frame: &Frame, info: &FrameInfo, farm: &Farm) -> Result<Vec<u8>> {
    let camera = &frame.camera;
    let size = Size { width: camera.width, height: camera.height };
    let mut bytes = depth_header(size);
    bytes.extend(depth(frame, farm).into_iter().flat_map(f32::to_le_bytes));

    let named = info.entries(camera).into_iter().map(|(name, value)| (name.to_owned(), value.to_string()));
    let mut entries: BTreeMap<String, String> = named.collect();
    entries.insert("Software".to_owned(), info.writer.clone());
    entries.insert(DIGEST.to_owned(), digest(&bytes, &entries));
    let text = serde_json::to_vec(&entries)
        .map_err(|error| Error::invalid(path, format!("its entries are no JSON: {error}")))?;

    bytes.extend(entries_header(text.len()));
    bytes.extend(text);
    Ok(bytes)
}

/// Reads the entries of a file of ours, as a whole. `size` is the only one that is accepted, if given.
pub(super) fn decode(bytes: &[u8], size: Option<Size>) -> Result<BTreeMap<String, String>, PictureRefusal> {
    let broken = |what: &str| PictureRefusal::Broken(what.to_owned());
    let found = shape(bytes).ok_or_else(|| broken("it does not begin as an array of depth"))?;
    let header = depth_header(found);
    if !bytes.starts_with(&header) {
        return Err(broken("its header is not one of a render"));
    }
    PictureRefusal::other_size(found, size)?;

    let samples = u64::from(found.width) * u64::from(found.height) * 4;
    let length = usize::try_from(samples).ok().and_then(|samples| samples.checked_add(header.len()));
    let (array, behind) =
        length.and_then(|length| bytes.split_at_checked(length)).ok_or_else(|| broken("it is cut short"))?;

    // The text is what follows the header, which must tell its length.
    let start = behind.iter().position(|&byte| byte == b'\n').map_or(behind.len(), |at| at + 1);
    let (header, text) = behind.split_at(start);
    if header != entries_header(text.len()) {
        return Err(broken("what made it is not said behind the depth, or is cut short"));
    }
    let mut entries: BTreeMap<String, String> = serde_json::from_slice(text)
        .map_err(|error| broken(&format!("what made it is not to be read: {error}")))?;
    let recorded = entries.remove(DIGEST);
    if recorded != Some(digest(array, &entries)) {
        return Err(broken("its content does not match its digest"));
    }
    Ok(entries)
}

/// Header of an array of the type `descr` and the shape `shape`, both as Python writes them.
fn header(descr: &str, shape: &str) -> Vec<u8> {
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    let before = MAGIC.len() + size_of::<u16>();
    let whole = (before + text.len() + 1).next_multiple_of(ALIGNMENT);
    // A hundred characters: far less than a u16 counts.
    let length = (whole - before) as u16;

    let mut bytes = Vec::with_capacity(whole);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    bytes.resize(whole - 1, b' ');
    bytes.push(b'\n');
    bytes
}

fn depth_header(Size { width, height }: Size) -> Vec<u8> {
    header("<f4", &format!("({height}, {width})"))
}

fn entries_header(length: usize) -> Vec<u8> {
    header(&format!("|S{length}"), "()")
}

/// The size that a header of an array with two dimensions tells.
fn shape(bytes: &[u8]) -> Option<Size> {
    let line = bytes.split(|&byte| byte == b'\n').next()?;
    let text = String::from_utf8_lossy(line);
    let (_, shape) = text.split_once("'shape': (")?;
    let (height, width) = shape.split_once(')')?.0.split_once(", ")?;
    Some(Size { width: width.parse().ok()?, height: height.parse().ok()? })
}

/// BLAKE3 of an array and its entries, hexadecimal.
fn digest(array: &[u8], entries: &BTreeMap<String, String>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(array);
    for (name, value) in entries {
        hasher.update(format!("{name}={value}\0").as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::testing;

    #[test]
    fn depth_stands_behind_a_header_that_numpy_reads() {
        let frame = testing::frame(9, 6);
        let farm = Farm::new(1).unwrap();
        let bytes = encode(Path::new("a.npy"), &frame, &testing::info(), &farm).unwrap();
        let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (6, 9), }";
        assert_eq!(bytes[..10], *b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(bytes[10..128], *format!("{text:<117}\n").as_bytes());
        let samples: Vec<f32> =
            bytes[128..].as_chunks().0.iter().take(54).map(|bytes| f32::from_le_bytes(*bytes)).collect();
        assert_eq!(samples, depth(&frame, &farm));
        assert_eq!(samples[0], f32::INFINITY, "the sky");
        let behind = &bytes[128 + 4 * 54..];
        assert!(behind.starts_with(b"\x93NUMPY\x01\x00") && behind.ends_with(b"}"));

        let entries = decode(&bytes, Some(Size { width: 9, height: 6 })).unwrap();
        assert_eq!(entries["hedgehop.frame"], "42");
        assert_eq!(entries["Software"], "hedgehop 0.1.0");
        let other = decode(&bytes, Some(Size { width: 6, height: 9 }));
        assert_eq!(other, Err(PictureRefusal::Size(Size { width: 9, height: 6 })));
    }
}
