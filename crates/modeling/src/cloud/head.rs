//! The head of a LAS or LAZ file: what it says of its points, held against its length before anything is made of it.
//!
//! ```text
//! public header block → records of variable length, extended ones behind the points → reference system
//! LAZ: its record of items, the table of chunks, the sizes of layers
//! ```
//! Layout: ASPRS, LAS Specification 1.4 R15 (2019); LASzip's parts as Isenburg (2013) and its reference code have them. The decoder
//! trusts the counts and sizes in there, so that none is left to it that the file is too short for.

use std::cmp::Ordering;
use std::path::Path;

use super::super::raster::InputFile;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, VerticalCrs, parse_geokeys};

/// Bytes of the header block of version 1.4, the longest.
const LONGEST: u64 = 375;
/// Bytes of it in all versions.
const SHORTEST: usize = 227;
/// Bytes of a point record by format, without extra bytes.
const RECORDS: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];
/// Positions of red, green and blue in a record, by format; 0: nowhere.
const COLOURS: [usize; 11] = [0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30];
/// Formats from this one on are those of version 1.4.
const EXTENDED: u8 = 6;
/// More points than all sensors have measured.
const MOST_POINTS: u64 = 1 << 44;
/// Bytes of the heads of records, and of extended ones.
const RECORD_HEADS: [u64; 2] = [54, 60];
/// Longest record that is read for a reference system.
const LONGEST_TEXT: u64 = 1 << 20;
/// Record of the items of a compressed point.
const ITEMS: (&str, u16) = ("laszip encoded", 22204);
/// Least bytes of a chunk: its first point as it is.
const LEAST_CHUNK: u64 = 20;

/// Head of a file: what it says of its points.
#[derive(Debug, Clone)]
pub(super) struct Head {
    /// Points.
    pub count: u64,
    /// Bytes of a record.
    pub record: usize,
    /// Whether records are those of formats 6 to 10.
    pub is_extended: bool,
    /// Position of red, green and blue in a record.
    pub colour: Option<usize>,
    /// Units of a coordinate per count, and the coordinate of count 0: x, y, z.
    pub scale: [f64; 3],
    pub offset: [f64; 3],
    /// Least and greatest coordinates as it claims: x, y, z. Only to be compared with those of the points.
    pub low: [f64; 3],
    pub high: [f64; 3],
    /// `LAS 1.2` or `LAZ 1.4`.
    pub format: String,
    /// Horizontal system, if it states one that is understood.
    pub crs: Option<Crs>,
    /// Why what it states is not understood.
    pub crs_problem: Option<String>,
    /// System of the heights, as far as it states one.
    pub vertical: VerticalCrs,
}

/// A file and what is known of it.
struct Reading<'a> {
    file: &'a InputFile,
    head: Vec<u8>,
    /// Begin of the points.
    points: u64,
    record: u64,
    count: u64,
}

/// Records that say something about the reference system or about compression.
#[derive(Default)]
struct Records {
    wkt: Option<String>,
    directory: Option<Vec<u16>>,
    doubles: Vec<f64>,
    ascii: String,
    items: Option<Vec<u8>>,
}

impl Head {
    /// Reads and checks the head of a file.
    pub fn read(path: &Path) -> Result<Self> {
        let file = InputFile::open(path)?;
        let head = file.head(LONGEST)?;
        let wrong = |what: &str| Error::invalid(path, what);
        if !head.starts_with(b"LASF") {
            return Err(wrong("is no LAS or LAZ file: it does not begin with LASF"));
        }
        if head.len() < SHORTEST {
            return Err(wrong("ends within its header; it is cut short, fetch it again"));
        }

        let reading = Reading::of(&file, head)?;
        let (version, format) = (reading.head[25], reading.head[104]);
        let is_compressed = format & 0xc0 != 0;
        let format = usize::from(format & 0x3f);
        let records = reading.records(version)?;

        if is_compressed {
            reading.check_compressed(records.items.as_deref())?;
        } else {
            reading.check_plain()?;
        }

        let triple = |at: usize, step: usize| [0, 1, 2].map(|axis| f64_at(&reading.head, at + axis * step));
        let (scale, offset) = (triple(131, 8), triple(155, 8));
        let (high, low) = (triple(179, 16), triple(187, 16));
        sound_places(path, scale, offset)?;

        let mut head = Self {
            count: reading.count,
            record: reading.record as usize,
            is_extended: format >= usize::from(EXTENDED),
            colour: Some(COLOURS[format]).filter(|at| *at > 0),
            scale,
            offset,
            low,
            high,
            format: format!("{} 1.{version}", if is_compressed { "LAZ" } else { "LAS" }),
            crs: None,
            crs_problem: None,
            vertical: VerticalCrs::default(),
        };

        head.place(&records);
        Ok(head)
    }

    /// Takes the reference system from records.
    fn place(&mut self, records: &Records) {
        if let Some(wkt) = &records.wkt {
            match Crs::with_vertical_from_wkt(wkt) {
                Ok((crs, vertical)) => {
                    self.crs = Some(crs);
                    self.vertical = vertical.unwrap_or_default();
                }
                Err(problem) => self.crs_problem = Some(problem.to_string()),
            }
        } else if let Some(directory) = &records.directory {
            match parse_geokeys(directory, &records.doubles, &records.ascii) {
                Ok(keys) => {
                    self.crs = keys.crs;
                    self.vertical = keys.vertical;
                }
                Err(problem) => self.crs_problem = Some(problem),
            }
        }
    }
}

/// Refuses scales and offsets that no coordinate can be told from.
fn sound_places(path: &Path, scale: [f64; 3], offset: [f64; 3]) -> Result<()> {
    const REMEDY: &str = "write it anew with `pdal translate` or `las2las`";
    for (axis, (scale, offset)) in ["x", "y", "z"].into_iter().zip(scale.into_iter().zip(offset)) {
        if !(scale.is_normal() && scale > 0.0) {
            let why = if scale < 0.0 { "all would lie mirrored" } else { "none could be told" };
            let what = format!(
                "its header states a scale of {scale} for its {axis} coordinates, of which {why}; a scale is above 0; {REMEDY}"
            );
            return Err(Error::invalid(path, what));
        }
        if !offset.is_finite() {
            let what =
                format!("its header states an offset of {offset} for its {axis} coordinates; {REMEDY}");
            return Err(Error::invalid(path, what));
        }
    }
    Ok(())
}

impl<'a> Reading<'a> {
    /// Checks versions, counts and sizes.
    fn of(file: &'a InputFile, head: Vec<u8>) -> Result<Self> {
        let wrong = |what: String| Error::invalid(file.path(), what);
        let (major, minor) = (head[24], head[25]);
        if major != 1 || minor > 4 {
            let remedy = "write it as version 1.4 with `las2las` or `pdal translate`";
            return Err(Error::unsupported(
                file.path(),
                format!("is of LAS version {major}.{minor}"),
                remedy,
            ));
        }

        let length = if minor == 4 {
            375
        } else if minor == 3 {
            235
        } else {
            SHORTEST
        };

        let (stated, points) = (u64::from(u16_at(&head, 94)), u64::from(u32_at(&head, 96)));
        if head.len() < length || stated < length as u64 || points < stated || points > file.length() {
            return Err(wrong(format!(
                "its header of {stated} bytes and its points from byte {points} on do not fit into {} bytes; \
                 it is cut short or damaged, fetch it again",
                file.length()
            )));
        }

        let format = usize::from(head[104] & 0x3f);
        let record = u16_at(&head, 105);
        match RECORDS.get(format) {
            None => {
                let remedy = "write it with one of the formats 0 to 10";
                return Err(Error::unsupported(
                    file.path(),
                    format!("has points of format {format}"),
                    remedy,
                ));
            }
            Some(least) if record < *least => {
                return Err(wrong(format!(
                    "states {record} bytes for a point of format {format}, which takes {least}; it is damaged, fetch it again"
                )));
            }
            Some(_) => {}
        }

        // Writers of version 1.4 may leave the older count at zero.
        let legacy = u64::from(u32_at(&head, 107));
        let own = if minor == 4 { u64_at(&head, 247) } else { legacy };
        if legacy != 0 && own != 0 && legacy != own {
            return Err(wrong(format!(
                "its header states {own} points in one place and {legacy} in another; count them with `lasinfo -repair_counters`"
            )));
        }

        let count = if own == 0 { legacy } else { own };
        if count == 0 {
            return Err(wrong("holds no points".into()));
        }
        if count > MOST_POINTS {
            return Err(wrong(format!("states {count} points; it is damaged, fetch it again")));
        }

        Ok(Self { file, head, points, record: u64::from(record), count })
    }

    fn damaged(&self, what: &str) -> Error {
        Error::invalid(self.file.path(), format!("{what}; it is cut short or damaged, fetch it again"))
    }

    /// Goes through all records.
    fn records(&self, version: u8) -> Result<Records> {
        let mut records = Records::default();
        let mut at = u64::from(u16_at(&self.head, 94));
        for _ in 0..u32_at(&self.head, 100) {
            at = self.record(at, false, &mut records)?;
            if at > self.points {
                return Err(self.damaged("its records reach into its points"));
            }
        }
        if version == 4 {
            let mut at = u64_at(&self.head, 235);
            for _ in 0..u32_at(&self.head, 243) {
                at = self.record(at, true, &mut records)?;
            }
        }
        Ok(records)
    }

    /// Takes the record at a byte; where the next one begins.
    fn record(&self, at: u64, is_extended: bool, records: &mut Records) -> Result<u64> {
        let size = RECORD_HEADS[usize::from(is_extended)];
        let head = self.file.bytes_at(at, size)?;
        let length = if is_extended { u64_at(&head, 20) } else { u64::from(u16_at(&head, 20)) };
        let end = (at + size).checked_add(length).filter(|end| *end <= self.file.length());
        let end = end.ok_or_else(|| {
            self.damaged(&format!("its record at byte {at} of {length} bytes reaches beyond its end"))
        })?;
        let user = head[2..18].split(|byte| *byte == 0).next().unwrap_or_default();
        let number = u16_at(&head, 18);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned();

        if user == ITEMS.0.as_bytes() && number == ITEMS.1 {
            records.items = Some(self.file.bytes_at(at + size, length)?);
        } else if user == b"LASF_Projection" && length <= LONGEST_TEXT {
            let bytes = self.file.bytes_at(at + size, length)?;
            match number {
                2112 => records.wkt = Some(text(&bytes)).filter(|text| !text.trim().is_empty()),
                34735 => records.directory = Some(bytes.chunks_exact(2).map(|two| u16_at(two, 0)).collect()),
                34736 => records.doubles = bytes.chunks_exact(8).map(|eight| f64_at(eight, 0)).collect(),
                34737 => records.ascii = text(&bytes),
                _ => {}
            }
        }

        Ok(end)
    }

    fn check_plain(&self) -> Result<()> {
        let held = (self.points_end() - self.points) / self.record;
        match held.cmp(&self.count) {
            Ordering::Equal => Ok(()),
            Ordering::Less => Err(self.damaged(&format!("states {} points and holds {held}", self.count))),
            Ordering::Greater => Err(self.more_points(held)),
        }
    }

    /// Finds where what follows the points begins: waveforms or extended records, as the header states, or else the file's end.
    fn points_end(&self) -> u64 {
        let (minor, length) = (self.head[25], self.file.length());
        let waveforms = if minor >= 3 { u64_at(&self.head, 227) } else { 0 };
        let extended = if minor == 4 && u32_at(&self.head, 243) > 0 { u64_at(&self.head, 235) } else { 0 };
        let behind = |at: &u64| *at >= self.points && *at <= length;
        [waveforms, extended].into_iter().filter(behind).min().unwrap_or(length)
    }

    /// Points that nobody counted are not dropped without a word.
    fn more_points(&self, held: u64) -> Error {
        let what = format!(
            "states {} points and has room for {held}: it was not closed when it was written, or is damaged; \
             `lasinfo -repair_counters` counts them, `pdal translate` writes it anew",
            self.count
        );
        Error::invalid(self.file.path(), what)
    }

    /// Checks what the decoder takes for granted.
    fn check_compressed(&self, items: Option<&[u8]>) -> Result<()> {
        let items =
            items.ok_or_else(|| self.damaged("has compressed points, but no record that says how"))?;
        let layers = self.layers(items)?;
        match u16_at(items, 0) {
            1 => Ok(()),
            2 => self.check_chunks(items),
            3 => {
                self.check_chunks(items)?;
                self.check_layers(layers)
            }
            other => Err(self.damaged(&format!("states compression {other}, which does not exist"))),
        }
    }

    /// Checks the items of a point; how many layers they make.
    fn layers(&self, items: &[u8]) -> Result<u64> {
        let damaged = || self.damaged("its record of compression does not go with its points");
        let count = if items.len() < 34 { 0 } else { usize::from(u16_at(items, 32)) };
        let items = items.get(34..34 + 6 * count).filter(|items| !items.is_empty()).ok_or_else(damaged)?;
        let (mut bytes, mut layers) = (0, 0);
        let is_extended = self.head[104] & 0x3f >= EXTENDED;

        for (index, item) in items.chunks_exact(6).enumerate() {
            let (kind, size) = (u16_at(item, 0), u16_at(item, 2));
            // Size of each kind of item, and its layers; 0: as many as the item says.
            let known = match kind {
                0 => (0, 0),
                6 => (20, 0),
                7 => (8, 0),
                8 => (6, 0),
                9 => (29, 0),
                10 => (30, 9),
                11 => (6, 1),
                12 => (8, 2),
                13 => (29, 1),
                14 => (0, u64::from(size)),
                _ => return Err(damaged()),
            };

            let is_first = kind == if is_extended { 10 } else { 6 };
            let is_of_its_time = matches!(kind, 10..=14) == is_extended;
            if (known.0 != 0 && known.0 != size) || is_first != (index == 0) || !is_of_its_time {
                return Err(damaged());
            }

            bytes += u64::from(size);
            layers += known.1;
        }

        if bytes == self.record { Ok(layers) } else { Err(damaged()) }
    }

    /// The table of chunks may not state more of them than there is room for.
    fn check_chunks(&self, items: &[u8]) -> Result<()> {
        let word = |at: u64| Ok(u64_at(&self.file.bytes_at(at, 8)?, 0));
        let mut table = word(self.points)?;
        if table == u64::MAX {
            // Where it could not be written at the beginning it stands at the end.
            table = word(self.file.length() - 8)?;
        }

        if table <= self.points {
            return Ok(());
        }

        let chunks = match table.checked_add(8).filter(|end| *end <= self.file.length()) {
            Some(_) => u64::from(u32_at(&self.file.bytes_at(table, 8)?, 4)),
            None => {
                return Err(
                    self.damaged(&format!("states its table of chunks at byte {table}, beyond its end"))
                );
            }
        };

        if chunks * LEAST_CHUNK > self.file.length() {
            return Err(self.damaged(&format!("states {chunks} chunks of points")));
        }

        // All but the last are full, unless they are of any size.
        let size = u64::from(u32_at(items, 12));
        if size > 0 && size < u64::from(u32::MAX) && chunks > self.count.div_ceil(size) {
            return Err(self.more_points(chunks * size));
        }

        Ok(())
    }

    /// No layer of a chunk may be longer than the file.
    fn check_layers(&self, layers: u64) -> Result<()> {
        let mut at = self.points + 8;
        let mut left = self.count;
        while left > 0 {
            let head = self.file.bytes_at(at + self.record, 4 + 4 * layers);
            let head = head.map_err(|_| self.damaged(&format!("ends {left} points before its last")))?;
            let points = u64::from(u32_at(&head, 0));
            let bytes: u64 = head[4..].chunks_exact(4).map(|four| u64::from(u32_at(four, 0))).sum();
            let end = at + self.record + head.len() as u64 + bytes;
            if points == 0 || end > self.file.length() {
                return Err(self
                    .damaged(&format!("its chunk of {points} points at byte {at} reaches beyond its end")));
            }
            left = left.saturating_sub(points);
            at = end;
        }
        Ok(())
    }
}

fn bytes<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes.get(at..at + N).and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
}

fn u16_at(from: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(bytes(from, at))
}

fn u32_at(from: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes(from, at))
}

fn u64_at(from: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes(from, at))
}

fn f64_at(from: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes(from, at))
}
