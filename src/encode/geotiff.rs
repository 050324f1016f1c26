//! Maps as Cloud Optimized GeoTIFF: a file whose parts can be read one by one, also over a network.
//!
//! ```text
//! head │ directory of the whole │ directories of overviews, by twos │ their values │ tiles of the smallest overview │ … │ tiles of the whole
//! ```
//!
//! Tiles of 512 × 512 pixels, deflate after horizontal differences (TIFF 6.0 §14), GeoTIFF tags (OGC 19-008). The order of parts after OGC 21-026 (Cloud Optimized
//! GeoTIFF). Tiles are made in the order of a quadtree: an overview's tile when its four are there. So there is never more in memory than a tile of each
//! overview and the places of all; their bytes wait in a file without a name. Files beyond 4 GB have the offsets of BigTIFF.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::encode::atomic::write_with;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;
use hedgehop_geo::WrittenKeys;

/// Pixels along the side of a tile.
pub const TILE: u32 = 512;

/// Value of pixels without data, in all bands.
pub const NO_DATA: u8 = 0;

/// Beyond this, offsets take 64 bits; what lies before the tiles has room below.
const MOST_SMALL: u64 = 4_000_000_000;

/// Description of a map. Pixels are 8-bit.
#[derive(Debug, Clone, PartialEq)]
pub struct GeoTiff {
    /// Pixels in a row, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
    /// 1: grey, 3: red, green, blue.
    pub bands: usize,
    /// West and north edge, metres or degrees of the reference system.
    pub north_west: [f64; 2],
    /// Side of a pixel, in the same unit.
    pub pixel: f64,
    /// The reference system; `None`: none is said.
    pub keys: Option<WrittenKeys>,
}

/// Tiles that were made: offset and bytes in the file that they wait in.
type WaitingTiles = Vec<(u64, u32)>;

/// One resolution.
struct Resolution {
    width: u32,
    height: u32,
    places: WaitingTiles,
}

impl Resolution {
    fn tiles(&self) -> [u32; 2] {
        [self.width.div_ceil(TILE), self.height.div_ceil(TILE)]
    }
}

/// Writes a map whole or not at all, in which 0 in all bands says that there is no data, and declares so. `tile` gives the samples of tile (column, row), `[512][512][bands]`, the northernmost row first; what lies beside the map is
/// not looked at.
///
/// # Errors
/// What `tile` says; what the disk refuses; an interruption.
pub fn write_geotiff(
    path: &Path,
    map: &GeoTiff,
    tile: &mut dyn FnMut([u32; 2]) -> Result<Vec<u8>>,
    observer: &dyn Observer,
) -> Result<()> {
    write(path, &MapKind { map, has_voids: true }, tile, observer)
}

/// The same of a map all of which is data: 0 is a value like all others, and nothing is declared.
///
/// # Errors
/// As of [`write_geotiff`].
pub fn write_full_geotiff(
    path: &Path,
    map: &GeoTiff,
    tile: &mut dyn FnMut([u32; 2]) -> Result<Vec<u8>>,
    observer: &dyn Observer,
) -> Result<()> {
    write(path, &MapKind { map, has_voids: false }, tile, observer)
}

/// A map, and whether [`NO_DATA`] is one of its values or none.
struct MapKind<'m> {
    map: &'m GeoTiff,
    has_voids: bool,
}

fn write(
    path: &Path,
    kind: &MapKind<'_>,
    tile: &mut dyn FnMut([u32; 2]) -> Result<Vec<u8>>,
    observer: &dyn Observer,
) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let aside =
        tempfile::tempfile_in(folder).map_err(|error| Error::io(path, "create a file beside it", error))?;
    let mut maker = Maker { path, kind, layers: layers(kind.map), aside, end: 0, observer };
    let top = maker.layers.len() - 1;
    observer.begin("tiles", maker.layers.iter().map(|layer| layer.places.len() as u64).sum(), "tiles");
    let [columns, rows] = maker.layers[top].tiles();
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        maker.make(top, [column, row], tile)?;
    }
    observer.end();
    let Maker { layers, mut aside, .. } = maker;
    write_with(path, |file| assemble(file, kind, &layers, &mut aside))
}

/// The whole and its overviews, each half as wide, until one fits into a tile.
fn layers(map: &GeoTiff) -> Vec<Resolution> {
    let sizes = std::iter::successors(Some((map.width, map.height)), |&(width, height)| {
        (width.max(height) > TILE).then(|| (width.div_ceil(2), height.div_ceil(2)))
    });
    let layer = |(width, height): (u32, u32)| {
        let mut layer = Resolution { width, height, places: Vec::new() };
        let [columns, rows] = layer.tiles();
        layer.places = vec![(0, 0); columns as usize * rows as usize];
        layer
    };
    sizes.map(layer).collect()
}

/// Makes tiles and sets them aside.
struct Maker<'m> {
    path: &'m Path,
    kind: &'m MapKind<'m>,
    layers: Vec<Resolution>,
    aside: File,
    end: u64,
    observer: &'m dyn Observer,
}

impl Maker<'_> {
    /// Makes a tile of a layer from those under it, and returns its samples.
    fn make(
        &mut self,
        layer: usize,
        [column, row]: [u32; 2],
        tile: &mut dyn FnMut([u32; 2]) -> Result<Vec<u8>>,
    ) -> Result<Vec<u8>> {
        if self.observer.cancelled() {
            return Err(Error::Interrupted(format!("{} was not written", self.path.display())));
        }

        let bands = self.kind.map.bands;
        let mut samples = if layer == 0 {
            tile([column, row])?
        } else {
            let [columns, rows] = self.layers[layer - 1].tiles();
            let mut samples = vec![NO_DATA; TILE as usize * TILE as usize * bands];
            for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let finer = [2 * column + right, 2 * row + down];
                if finer[0] < columns && finer[1] < rows {
                    let finer = self.make(layer - 1, finer, tile)?;
                    halve(&finer, &mut samples, [right, down], self.kind);
                }
            }
            samples
        };

        self.fill_beside(&mut samples, layer, [column, row]);
        self.set_aside(&samples, layer, [column, row])?;
        self.observer.advance(1);

        Ok(samples)
    }

    /// Fills the pixels beside the map, which must not change overviews: without data, or as the map's edge where all is data.
    fn fill_beside(&self, samples: &mut [u8], layer: usize, [column, row]: [u32; 2]) {
        let Resolution { width, height, .. } = self.layers[layer];
        let inside = |size: u32, at: u32| (size - at * TILE).min(TILE) as usize;
        let bands = self.kind.map.bands;
        let line = TILE as usize * bands;
        let (kept, rows) = (inside(width, column) * bands, inside(height, row));
        let (own, beside) = samples.split_at_mut(rows * line);
        if self.kind.has_voids {
            own.chunks_exact_mut(line).for_each(|line| line[kept..].fill(NO_DATA));
            return beside.fill(NO_DATA);
        }
        for line in own.chunks_exact_mut(line) {
            (kept..line.len()).for_each(|at| line[at] = line[at - bands]);
        }
        let last = &own[(rows - 1) * line..];
        beside.chunks_exact_mut(line).for_each(|line| line.copy_from_slice(last));
    }

    fn set_aside(&mut self, samples: &[u8], layer: usize, [column, row]: [u32; 2]) -> Result<()> {
        let written = compressed(samples, self.kind.map.bands)
            .and_then(|bytes| self.aside.write_all(&bytes).map(|()| bytes.len()));
        let length = written.map_err(|error| Error::io(self.path, "write a file beside it", error))?;
        let columns = self.layers[layer].tiles()[0];
        let index = row as usize * columns as usize + column as usize;
        self.layers[layer].places[index] = (self.end, length as u32);
        self.end += length as u64;
        Ok(())
    }
}

/// Puts a tile at half its size into a quarter of another; means of those of four pixels that have data.
fn halve(finer: &[u8], coarser: &mut [u8], [right, down]: [u32; 2], kind: &MapKind<'_>) {
    let (bands, is_full) = (kind.map.bands, !kind.has_voids);
    let (side, half) = (TILE as usize, TILE as usize / 2);
    let sample = |x: usize, y: usize| &finer[(y * side + x) * bands..][..bands];
    for (y, x) in (0..half).flat_map(|y| (0..half).map(move |x| (y, x))) {
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| sample(2 * x + i, 2 * y + j));
        let known = || four.iter().filter(|pixel| is_full || pixel.iter().any(|band| *band != NO_DATA));
        let count = known().count() as u32;
        let to = ((y + down as usize * half) * side + x + right as usize * half) * bands;
        for band in 0..bands {
            let sum: u32 = known().map(|pixel| u32::from(pixel[band])).sum();
            coarser[to + band] = (sum + count / 2).checked_div(count).map_or(NO_DATA, |mean| mean as u8);
        }
    }
}

/// A tile's bytes: each sample less the one before it in its row, deflated.
fn compressed(samples: &[u8], bands: usize) -> io::Result<Vec<u8>> {
    let mut differences = Vec::with_capacity(samples.len());
    for line in samples.chunks_exact(TILE as usize * bands) {
        differences.extend_from_slice(&line[..bands]);
        differences.extend(line[bands..].iter().zip(line).map(|(own, before)| own.wrapping_sub(*before)));
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&differences)?;
    encoder.finish()
}

/// Values of a tag.
enum Values {
    Ascii(String),
    Short(Vec<u16>),
    Long(Vec<u32>),
    Long8(Vec<u64>),
    Double(Vec<f64>),
}

impl Values {
    /// Type, count and bytes.
    fn encode(&self) -> (u16, u64, Vec<u8>) {
        match self {
            Self::Ascii(text) => (2, text.len() as u64 + 1, [text.as_bytes(), &[0]].concat()),
            Self::Short(all) => {
                (3, all.len() as u64, all.iter().flat_map(|value| value.to_le_bytes()).collect())
            }
            Self::Long(all) => {
                (4, all.len() as u64, all.iter().flat_map(|value| value.to_le_bytes()).collect())
            }
            Self::Long8(all) => {
                (16, all.len() as u64, all.iter().flat_map(|value| value.to_le_bytes()).collect())
            }
            Self::Double(all) => {
                (12, all.len() as u64, all.iter().flat_map(|value| value.to_le_bytes()).collect())
            }
        }
    }
}

/// The tags of a layer whose tiles lie at these offsets.
fn tags(
    kind: &MapKind<'_>,
    layers: &[Resolution],
    index: usize,
    offsets: &[u64],
    is_big: bool,
) -> Vec<(u16, Values)> {
    use Values::{Ascii, Double, Long, Long8, Short};

    let (map, layer) = (kind.map, &layers[index]);
    let offsets = if is_big {
        Long8(offsets.to_vec())
    } else {
        Long(offsets.iter().map(|&offset| offset as u32).collect())
    };

    let mut tags = vec![
        (254, Long(vec![u32::from(index > 0)])),
        (256, Long(vec![layer.width])),
        (257, Long(vec![layer.height])),
        (258, Short(vec![8; map.bands])),
        (259, Short(vec![8])),
        (262, Short(vec![if map.bands == 1 { 1 } else { 2 }])),
        (277, Short(vec![map.bands as u16])),
        (284, Short(vec![1])),
        (317, Short(vec![2])),
        (322, Short(vec![TILE as u16])),
        (323, Short(vec![TILE as u16])),
        (324, offsets),
        (325, Long(layer.places.iter().map(|(_, length)| *length).collect())),
        (339, Short(vec![1; map.bands])),
    ];

    if index == 0 {
        let [west, north] = map.north_west;
        tags.push((33_550, Double(vec![map.pixel, map.pixel, 0.0])));
        tags.push((33_922, Double(vec![0.0, 0.0, 0.0, west, north, 0.0])));
        if let Some(WrittenKeys { directory, doubles, text }) = &map.keys {
            tags.push((34_735, Short(directory.clone())));
            if !doubles.is_empty() {
                tags.push((34_736, Double(doubles.clone())));
            }
            tags.push((34_737, Ascii(text.clone())));
        }
    }

    if kind.has_voids {
        tags.push((42_113, Ascii(NO_DATA.to_string())));
    }

    tags
}

/// Directories with their values, one behind the other; `start` is where they begin in the file.
fn directories(
    kind: &MapKind<'_>,
    layers: &[Resolution],
    offsets: &[Vec<u64>],
    start: u64,
    is_big: bool,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let word = |value: u64| {
        if is_big { value.to_le_bytes().to_vec() } else { (value as u32).to_le_bytes().to_vec() }
    };
    let room = if is_big { 8 } else { 4 };
    let mut all: Vec<(Vec<u8>, Vec<u8>)> = Vec::new();
    let entry = if is_big { 20 } else { 12 };
    let head = if is_big { 8 } else { 2 };
    let directory_bytes = |count: usize| (head + count * entry + room) as u64;
    let tags: Vec<_> =
        (0..layers.len()).map(|index| tags(kind, layers, index, &offsets[index], is_big)).collect();
    let mut place =
        start + tags.iter().map(|tags| directory_bytes(tags.len()).next_multiple_of(8)).sum::<u64>();
    let mut next = start;

    for (index, tags) in tags.iter().enumerate() {
        next += directory_bytes(tags.len()).next_multiple_of(8);
        let (mut directory, mut values) = (Vec::new(), Vec::new());
        directory.extend(if is_big {
            (tags.len() as u64).to_le_bytes().to_vec()
        } else {
            (tags.len() as u16).to_le_bytes().to_vec()
        });

        for (tag, value) in tags {
            let (kind, count, mut own) = value.encode();
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend(word(count));

            if own.len() <= room {
                own.resize(room, 0);
                directory.extend(own);
            } else {
                directory.extend(word(place));
                own.resize(own.len().next_multiple_of(8), 0);
                place += own.len() as u64;
                values.extend(own);
            }
        }

        directory.extend(word(if index + 1 < layers.len() { next } else { 0 }));
        directory.resize(directory.len().next_multiple_of(8), 0);
        all.push((directory, values));
    }

    all.iter().for_each(|(directory, _)| bytes.extend_from_slice(directory));
    all.iter().for_each(|(_, values)| bytes.extend_from_slice(values));
    bytes
}

/// Puts the file together from the tiles that were set aside.
fn assemble(file: &mut File, kind: &MapKind<'_>, layers: &[Resolution], aside: &mut File) -> io::Result<()> {
    let stored: u64 =
        layers.iter().flat_map(|layer| &layer.places).map(|(_, length)| u64::from(*length)).sum();
    let is_big = stored > MOST_SMALL;
    let start: u64 = if is_big { 16 } else { 8 };

    // Their length does not depend on where tiles lie.
    let nowhere: Vec<Vec<u64>> = layers.iter().map(|layer| vec![0; layer.places.len()]).collect();
    let mut end = start + directories(kind, layers, &nowhere, start, is_big).len() as u64;
    let mut offsets = nowhere;

    // Readers want what they show first in front: the smallest overview.
    for (layer, offsets) in layers.iter().zip(&mut offsets).rev() {
        for ((_, length), offset) in layer.places.iter().zip(offsets) {
            *offset = end;
            end += u64::from(*length);
        }
    }

    let mut file = io::BufWriter::new(file);
    file.write_all(b"II")?;
    if is_big {
        file.write_all(&43_u16.to_le_bytes())?;
        file.write_all(&8_u16.to_le_bytes())?;
        file.write_all(&0_u16.to_le_bytes())?;
        file.write_all(&start.to_le_bytes())?;
    } else {
        file.write_all(&42_u16.to_le_bytes())?;
        file.write_all(&(start as u32).to_le_bytes())?;
    }

    file.write_all(&directories(kind, layers, &offsets, start, is_big))?;
    for (from, length) in layers.iter().rev().flat_map(|layer| &layer.places) {
        aside.seek(SeekFrom::Start(*from))?;
        let copied = io::copy(&mut (&*aside).take(u64::from(*length)), &mut file)?;
        if copied != u64::from(*length) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
    }

    file.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::progress::Silent;
    use tiff::decoder::{Decoder, DecodingResult};
    use tiff::tags::Tag;

    fn value(x: u32, y: u32, band: usize) -> u8 {
        1 + ((x / 16 + y / 8 + 40 * band as u32) % 255) as u8
    }

    fn written(map: &GeoTiff, path: &Path) {
        let mut tile = |[column, row]: [u32; 2]| {
            let pixels = (0..TILE).flat_map(|y| (0..TILE).map(move |x| (column * TILE + x, row * TILE + y)));
            Ok(pixels.flat_map(|(x, y)| (0..map.bands).map(move |band| value(x, y, band))).collect())
        };
        write_geotiff(path, map, &mut tile, &Silent).unwrap();
    }

    #[test]
    fn all_layers_are_read_back_as_they_were_made() {
        let folder = tempfile::tempdir().unwrap();
        for (bands, width, height, layers) in [(1, 1300, 700, 3), (3, 513, 512, 2), (1, 5, 3, 1)] {
            let path = folder.path().join(format!("{bands}-{width}.tif"));
            let map = GeoTiff { width, height, bands, north_west: [500.0, 900.0], pixel: 2.0, keys: None };
            written(&map, &path);
            let mut decoder = Decoder::new(File::open(&path).unwrap()).unwrap();

            for layer in 0..layers {
                let wanted = (width.div_ceil(1 << layer), height.div_ceil(1 << layer));
                assert_eq!(decoder.dimensions().unwrap(), wanted);
                let DecodingResult::U8(samples) = decoder.read_image().unwrap() else { panic!() };

                // Blocks of equal values stay what they are in the middle.
                for (x, y) in [(3, 1), (wanted.0 - 1, 1), (wanted.0 / 2, wanted.1 - 1)] {
                    let sample = samples[(y * wanted.0 + x) as usize * bands];
                    let (x, y) = (x << layer, y << layer);
                    assert!(sample.abs_diff(value(x, y, 0)) <= 1, "{width} {layer} {x} {y}: {sample}");
                }

                assert_eq!(decoder.more_images(), layer + 1 < layers);
                if layer + 1 < layers {
                    decoder.next_image().unwrap();
                }
            }
        }
    }

    #[test]
    fn nought_is_a_value_where_all_is_data() {
        let folder = tempfile::tempdir().unwrap();
        // Columns of 0 and 200 by turns, an odd number of them; what `tile` gives beside the map is of no account.
        let (width, height) = (601, 515);
        let map = GeoTiff { width, height, bands: 3, north_west: [0.0; 2], pixel: 1.0, keys: None };
        let mut tile = |_: [u32; 2]| {
            let row = (0..TILE).flat_map(|x| [if x % 2 == 0 { 0 } else { 200 }; 3]);
            Ok(row.collect::<Vec<u8>>().repeat(TILE as usize))
        };
        let [voids, full] = ["voids.tif", "full.tif"].map(|name| folder.path().join(name));
        write_geotiff(&voids, &map, &mut tile, &Silent).unwrap();
        write_full_geotiff(&full, &map, &mut tile, &Silent).unwrap();

        for (path, mean) in [(voids, 200), (full, 100)] {
            let mut decoder = Decoder::new(File::open(&path).unwrap()).unwrap();
            let nodata = decoder.find_tag(Tag::GdalNodata).unwrap();
            assert_eq!(nodata.is_some(), mean == 200, "{nodata:?}");
            decoder.next_image().unwrap();
            assert_eq!(decoder.find_tag(Tag::GdalNodata).unwrap().is_some(), mean == 200);
            let (across, down) = decoder.dimensions().unwrap();
            assert_eq!((across, down), (301, 258));
            let DecodingResult::U8(samples) = decoder.read_image().unwrap() else { panic!() };

            for (row, line) in samples.chunks_exact(3 * across as usize).enumerate() {
                let (inside, last) = line.split_last_chunk::<3>().unwrap();
                assert!(inside.iter().all(|sample| *sample == mean), "row {row}");
                // Of the last two columns one is beside the map.
                assert_eq!(last, &[0; 3], "row {row}");
            }
        }
    }

    #[test]
    fn what_is_interrupted_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.tif");
        let map = GeoTiff { width: 600, height: 600, bands: 1, north_west: [0.0; 2], pixel: 1.0, keys: None };
        let mut fails = |[column, _]: [u32; 2]| match column {
            0 => Ok(vec![7; (TILE * TILE) as usize]),
            _ => Err(Error::Configuration("no page".into())),
        };
        assert!(write_geotiff(&path, &map, &mut fails, &Silent).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
