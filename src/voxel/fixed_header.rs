//! The fixed header's bytes, and opening a file by them.

use std::path::Path;
use std::sync::Arc;

use glam::DVec2;

use super::format::{
    EMPTY_SINCE, Field, MAGIC, METADATA_LIMIT, OBJECTS_LIMIT, OLDEST, PAGE_ALIGNMENT, PLANE_ALIGNMENT,
    VERSION, header as at,
};
use super::{
    ContentHash, Directory, Grid, Header, HeightCode, HeightRange, Metadata, PAGE_SIDE, SharedObjects,
    SpanTable,
};
use hedgehop_base::error::{Error, Result};

/// A run of bytes of the file, with its checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Section {
    pub offset: u64,
    pub length: u64,
    pub crc: u32,
}

impl Section {
    pub fn of(offset: u64, bytes: &[u8]) -> Self {
        Self { offset, length: bytes.len() as u64, crc: crc32fast::hash(bytes) }
    }

    fn end(&self) -> Option<u64> {
        self.offset.checked_add(self.length)
    }

    /// The section's bytes in `file`, checked against the checksum.
    fn of_file<'a>(&self, file: &'a [u8], path: &Path, name: &str) -> Result<&'a [u8]> {
        let range =
            usize::try_from(self.offset).ok().zip(self.end().and_then(|end| usize::try_from(end).ok()));
        let bytes = range.and_then(|(start, end)| file.get(start..end));
        bytes.filter(|bytes| crc32fast::hash(bytes) == self.crc).ok_or_else(|| {
            let at = self.offset;
            Error::invalid(path, format!("wrong checksum of the {name} at byte {at}; {DAMAGED}"))
        })
    }
}

/// Checksum of a header. It covers the version since there are two that are read.
pub(super) fn header_crc(record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    if at::VERSION.u32(record) >= EMPTY_SINCE {
        hasher.update(at::VERSION.bytes(record));
    }
    hasher.update(&record[at::HEADER_CRC.end()..at::SIZE]);
    hasher.finalize()
}

/// Remedy for a damaged file, as errors state it.
pub(super) const DAMAGED: &str = "the file is damaged: copy it again, or build it again";
const TRUNCATED: &str = "the build was killed or the copy is incomplete; build it again";

/// The fixed header: all of [`Header`] that is not metadata, and where the rest of the file lies.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FixedHeader {
    /// Version of the format.
    pub version: u32,
    pub grid: Grid,
    pub heights: HeightCode,
    pub height_range: HeightRange,
    pub content_hash: ContentHash,
    pub directory: Section,
    pub metadata: Section,
    /// Zeros if there are none.
    pub objects: Section,
    pub file_length: u64,
}

impl FixedHeader {
    pub fn encode(&self) -> [u8; at::SIZE] {
        let mut record = [0; at::SIZE];
        let mut put_u32 = |field: Field, value: u32| field.put(&mut record, &value.to_le_bytes());
        put_u32(at::VERSION, self.version);
        put_u32(at::NX, self.grid.nx);
        put_u32(at::NY, self.grid.ny);
        put_u32(at::LEVEL_COUNT, self.grid.level_count().into());
        put_u32(at::PAGE_SIDE, PAGE_SIDE);
        put_u32(at::DIRECTORY_CRC, self.directory.crc);
        put_u32(at::METADATA_CRC, self.metadata.crc);
        put_u32(at::OBJECTS_CRC, self.objects.crc);

        for (field, value) in [
            (at::SPACING, self.grid.spacing),
            (at::ORIGIN_X, self.grid.origin.x),
            (at::ORIGIN_Y, self.grid.origin.y),
            (at::HEIGHT_SCALE, self.heights.scale),
            (at::HEIGHT_OFFSET, self.heights.offset),
            (at::HEIGHT_LOW, self.height_range.low),
            (at::HEIGHT_HIGH, self.height_range.high),
        ] {
            field.put(&mut record, &value.to_le_bytes());
        }

        for (field, value) in [
            (at::DIRECTORY_OFFSET, self.directory.offset),
            (at::DIRECTORY_LENGTH, self.directory.length),
            (at::METADATA_OFFSET, self.metadata.offset),
            (at::METADATA_LENGTH, self.metadata.length),
            (at::OBJECTS_OFFSET, self.objects.offset),
            (at::OBJECTS_LENGTH, self.objects.length),
            (at::FILE_LENGTH, self.file_length),
        ] {
            field.put(&mut record, &value.to_le_bytes());
        }

        at::MAGIC.put(&mut record, &MAGIC);
        at::CONTENT_HASH.put(&mut record, &self.content_hash.0);
        let crc = header_crc(&record);
        at::HEADER_CRC.put(&mut record, &crc.to_le_bytes());

        record
    }

    /// Reads and checks the first bytes of `file`; `path` is for the error's sentence.
    pub fn decode(path: &Path, file: &[u8]) -> Result<Self> {
        Self::decode_start(path, file, file.len() as u64)
    }

    /// The same of a file of `length` bytes, of which `start` are the first.
    pub fn decode_start(path: &Path, start: &[u8], length: u64) -> Result<Self> {
        let record = Self::recognise(path, start)?;
        let invalid = |what: String| Error::invalid(path, format!("{what}; {DAMAGED}"));
        if header_crc(record) != at::HEADER_CRC.u32(record) {
            return Err(invalid(format!("wrong checksum of the header at byte {}", at::HEADER_CRC.offset)));
        }
        let header = Self::fields(record);
        header.check(record).map_err(|what| invalid(format!("header: {what}")))?;
        if length < header.file_length {
            let expected = header.file_length;
            return Err(Error::invalid(
                path,
                format!("truncated at byte {length} of {expected}; {TRUNCATED}"),
            ));
        }
        if length > header.file_length {
            return Err(invalid(format!("more bytes follow its end at byte {}", header.file_length)));
        }
        Ok(header)
    }

    /// Tells a database of a version that is read from everything else, before any checksum.
    fn recognise<'a>(path: &Path, file: &'a [u8]) -> Result<&'a [u8]> {
        if file.is_empty() {
            return Err(Error::invalid(path, format!("the file is empty; {TRUNCATED}")));
        }

        let start = &file[..file.len().min(at::SIZE)];
        if start.iter().all(|&byte| byte == 0) {
            return Err(Error::invalid(path, format!("it has no header yet; {TRUNCATED}")));
        }
        if !start.iter().zip(&MAGIC).all(|(byte, magic)| byte == magic) {
            return Err(Error::invalid(
                path,
                "not a hedgehop database (byte 0); make one with `hedgehop build --elevation FILE -o AREA.hop`",
            ));
        }
        if start.len() < at::SIZE {
            return Err(Error::invalid(path, format!("truncated at byte {}; {TRUNCATED}", start.len())));
        }

        let version = at::VERSION.u32(start);
        if !(OLDEST..=VERSION).contains(&version) {
            let (age, remedy) = match version {
                0 => ("an unknown", "build the database again"),
                1..=VERSION => ("an older", "build the database again from its sources"),
                _ => ("a newer", "update hedgehop, or build the database again with this version"),
            };

            return Err(Error::unsupported(
                path,
                format!(
                    "written by {age} version of hedgehop: format {version}, and this one reads {OLDEST} to {VERSION}"
                ),
                remedy,
            ));
        }

        Ok(start)
    }

    fn fields(record: &[u8]) -> Self {
        let section = |offset: Field, length: Field, crc: Field| Section {
            offset: offset.u64(record),
            length: length.u64(record),
            crc: crc.u32(record),
        };

        Self {
            version: at::VERSION.u32(record),
            grid: Grid {
                nx: at::NX.u32(record),
                ny: at::NY.u32(record),
                spacing: at::SPACING.f64(record),
                origin: DVec2::new(at::ORIGIN_X.f64(record), at::ORIGIN_Y.f64(record)),
            },
            heights: HeightCode {
                scale: at::HEIGHT_SCALE.f64(record),
                offset: at::HEIGHT_OFFSET.f64(record),
            },
            height_range: HeightRange { low: at::HEIGHT_LOW.f64(record), high: at::HEIGHT_HIGH.f64(record) },
            content_hash: ContentHash(at::CONTENT_HASH.array(record)),
            directory: section(at::DIRECTORY_OFFSET, at::DIRECTORY_LENGTH, at::DIRECTORY_CRC),
            metadata: section(at::METADATA_OFFSET, at::METADATA_LENGTH, at::METADATA_CRC),
            objects: section(at::OBJECTS_OFFSET, at::OBJECTS_LENGTH, at::OBJECTS_CRC),
            file_length: at::FILE_LENGTH.u64(record),
        }
    }

    /// Everything that later arithmetic relies on.
    pub fn check(&self, record: &[u8]) -> Result<(), String> {
        self.grid.check()?;
        self.heights.check()?;
        self.heights.check_range(self.height_range)?;
        let levels = at::LEVEL_COUNT.u32(record);
        if levels != u32::from(self.grid.level_count()) {
            return Err(format!("{levels} levels do not fit the grid"));
        }
        let page_side = at::PAGE_SIDE.u32(record);
        if page_side != PAGE_SIDE {
            return Err(format!("pages of {page_side} voxels, but only {PAGE_SIDE} are read"));
        }
        if at::RESERVED.bytes(record).iter().any(|&byte| byte != 0) {
            return Err("reserved bytes are not zero".into());
        }
        self.check_sections()
    }

    fn check_sections(&self) -> Result<(), String> {
        let possible = Directory::sizes(&self.grid)?;
        let Section { offset, length, .. } = self.directory;
        if !possible.contains(&length) {
            return Err(format!("a directory of {length} bytes, but the grid needs {}", possible[0]));
        }
        if offset < PAGE_ALIGNMENT || !offset.is_multiple_of(PLANE_ALIGNMENT as u64) {
            return Err(format!("no directory can begin at byte {offset}"));
        }

        let Section { offset: first, length: objects, .. } = self.objects;
        let fits = objects <= OBJECTS_LIMIT
            && first >= PAGE_ALIGNMENT
            && first.is_multiple_of(PLANE_ALIGNMENT as u64)
            && self.objects.end() == Some(offset);
        if !(fits || self.objects == Section::default()) {
            return Err(format!("{objects} bytes of objects cannot begin at byte {first}"));
        }

        let follows = self.directory.end() == Some(self.metadata.offset);
        let ends = self.metadata.end() == Some(self.file_length);
        if !(follows && ends && self.metadata.length <= METADATA_LIMIT) {
            return Err("directory, metadata and length of the file do not fit together".into());
        }

        Ok(())
    }

    /// Reads and checks header, metadata and directory of a whole file.
    pub fn parse(path: &Path, file: &[u8]) -> Result<(Header, Directory)> {
        let fixed = Self::decode(path, file)?;
        let invalid = |what: String| Error::invalid(path, format!("{what}; {DAMAGED}"));
        let json = fixed.metadata.of_file(file, path, "metadata")?;
        let metadata: Metadata =
            serde_json::from_slice(json).map_err(|error| invalid(format!("metadata: {error}")))?;
        metadata.check().map_err(invalid)?;
        let bytes = fixed.directory.of_file(file, path, "directory")?;
        let directory =
            Directory::decode(&fixed.grid, bytes, fixed.pages_end(), fixed.version).map_err(invalid)?;
        let rise = SpanTable::rise(fixed.heights, fixed.grid.spacing);
        let objects = SharedObjects::decode(fixed.objects_of(file, path)?, rise).map_err(invalid)?;

        let header = Header {
            version: fixed.version,
            grid: fixed.grid,
            level_count: fixed.grid.level_count(),
            heights: fixed.heights,
            height_range: fixed.height_range,
            has_spans: directory.has_bare(),
            objects: Arc::new(objects),
            content_hash: fixed.content_hash,
            metadata,
        };

        Ok((header, directory))
    }

    /// The bytes of the objects.
    fn objects_of<'a>(&self, file: &'a [u8], path: &Path) -> Result<&'a [u8]> {
        self.objects.of_file(file, path, "objects")
    }

    /// Identity of a database with this header (whose `content_hash` is not looked at), `metadata`, objects and pages.
    pub fn identity(&self, metadata: &[u8], objects: &[u8], directory: &Directory) -> ContentHash {
        let record = self.encode();
        let mut hasher = blake3::Hasher::new();
        hasher.update(at::VERSION.bytes(&record));
        hasher.update(&record[at::NX.offset..at::HEIGHT_HIGH.end()]);
        hasher.update(at::METADATA_LENGTH.bytes(&record));
        hasher.update(metadata);
        hasher.update(objects);
        for (id, entry) in directory.present() {
            for number in [u32::from(id.level), id.px, id.py, entry.length] {
                hasher.update(&number.to_le_bytes());
            }
            hasher.update(&entry.hash);
        }
        ContentHash(*hasher.finalize().as_bytes())
    }

    /// [`Self::identity`] of a whole file that has been parsed.
    pub fn identity_of_file(path: &Path, file: &[u8], directory: &Directory) -> Result<ContentHash> {
        let fixed = Self::decode(path, file)?;
        let metadata = fixed.metadata.of_file(file, path, "metadata")?;
        Ok(fixed.identity(metadata, fixed.objects_of(file, path)?, directory))
    }

    /// First byte behind the pages and what pads them.
    pub fn pages_end(&self) -> u64 {
        if self.objects.length > 0 { self.objects.offset } else { self.directory.offset }
    }

    /// The same of a whole file.
    pub fn pages_end_of_file(path: &Path, file: &[u8]) -> Result<u64> {
        Ok(Self::decode(path, file)?.pages_end())
    }
}
