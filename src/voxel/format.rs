//! FORMAT.md's numbers: fields as a chain in which each begins where the one before it ends.

#[cfg(target_endian = "big")]
compile_error!(
    "databases are mapped as they lie, in little endian; big-endian machines need a swapping reader"
);

/// First bytes of every database. Like PNG's signature, they reveal a transfer that changed line
/// ends or cleared the eighth bit.
pub(super) const MAGIC: [u8; 8] = *b"\x89HOP\r\n\x1a\n";
/// Version of the format that is written.
pub(super) const VERSION: u32 = 9;
/// The oldest one that is read, too.
pub(super) const OLDEST: u32 = 7;
/// The first one in which pages without any surface may have no bytes.
pub(super) const EMPTY_SINCE: u32 = 8;
/// Pages begin at multiples of this, so that each can be mapped and advised alone.
pub(super) const PAGE_ALIGNMENT: u64 = 4096;
/// Planes begin at multiples of this within their page, and the directory within the file.
pub(super) const PLANE_ALIGNMENT: usize = 64;
/// More metadata than this is taken for damage.
pub(super) const METADATA_LIMIT: u64 = 16 << 20;
/// More bytes of objects than this are taken for damage: all of them are held in memory.
pub(super) const OBJECTS_LIMIT: u64 = 1 << 30;
/// A grid of more pages than this is refused; its directory alone would take 2 GiB.
pub(super) const PAGE_LIMIT: u64 = 1 << 26;

/// Place of a value in a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Field {
    /// First byte, counted from the record's.
    pub offset: usize,
    /// Bytes.
    pub size: usize,
}

impl Field {
    const fn first(size: usize) -> Self {
        Self { offset: 0, size }
    }

    const fn then(self, size: usize) -> Self {
        Self { offset: self.end(), size }
    }

    /// First byte behind the field.
    pub const fn end(self) -> usize {
        self.offset + self.size
    }

    /// The field's bytes; `record` holds at least [`Self::end`] bytes.
    pub fn bytes(self, record: &[u8]) -> &[u8] {
        &record[self.offset..self.end()]
    }

    /// The field as `N` bytes; `N` is its size.
    pub fn array<const N: usize>(self, record: &[u8]) -> [u8; N] {
        let mut value = [0; N];
        value.copy_from_slice(self.bytes(record));
        value
    }

    pub fn u32(self, record: &[u8]) -> u32 {
        u32::from_le_bytes(self.array(record))
    }

    pub fn u64(self, record: &[u8]) -> u64 {
        u64::from_le_bytes(self.array(record))
    }

    pub fn f64(self, record: &[u8]) -> f64 {
        f64::from_le_bytes(self.array(record))
    }

    /// Writes `value`, as long as the field.
    pub fn put(self, record: &mut [u8], value: &[u8]) {
        record[self.offset..self.end()].copy_from_slice(value);
    }
}

/// The fixed header at the file's beginning.
pub(super) mod header {
    use super::Field;

    pub const MAGIC: Field = Field::first(8);
    pub const VERSION: Field = MAGIC.then(4);
    pub const HEADER_CRC: Field = VERSION.then(4);
    pub const NX: Field = HEADER_CRC.then(4);
    pub const NY: Field = NX.then(4);
    pub const SPACING: Field = NY.then(8);
    pub const ORIGIN_X: Field = SPACING.then(8);
    pub const ORIGIN_Y: Field = ORIGIN_X.then(8);
    pub const LEVEL_COUNT: Field = ORIGIN_Y.then(4);
    pub const PAGE_SIDE: Field = LEVEL_COUNT.then(4);
    pub const HEIGHT_SCALE: Field = PAGE_SIDE.then(8);
    pub const HEIGHT_OFFSET: Field = HEIGHT_SCALE.then(8);
    pub const HEIGHT_LOW: Field = HEIGHT_OFFSET.then(8);
    pub const HEIGHT_HIGH: Field = HEIGHT_LOW.then(8);
    pub const CONTENT_HASH: Field = HEIGHT_HIGH.then(32);
    pub const DIRECTORY_OFFSET: Field = CONTENT_HASH.then(8);
    pub const DIRECTORY_LENGTH: Field = DIRECTORY_OFFSET.then(8);
    pub const METADATA_OFFSET: Field = DIRECTORY_LENGTH.then(8);
    pub const METADATA_LENGTH: Field = METADATA_OFFSET.then(8);
    pub const DIRECTORY_CRC: Field = METADATA_LENGTH.then(4);
    pub const METADATA_CRC: Field = DIRECTORY_CRC.then(4);
    pub const FILE_LENGTH: Field = METADATA_CRC.then(8);
    pub const OBJECTS_OFFSET: Field = FILE_LENGTH.then(8);
    pub const OBJECTS_LENGTH: Field = OBJECTS_OFFSET.then(8);
    pub const OBJECTS_CRC: Field = OBJECTS_LENGTH.then(4);
    pub const RESERVED: Field = OBJECTS_CRC.then(68);
    /// Bytes of the fixed header.
    pub const SIZE: usize = RESERVED.end();
    const _: () = assert!(SIZE == 256);
}

/// One entry of the directory.
pub(super) mod entry {
    use super::Field;

    pub const OFFSET: Field = Field::first(8);
    pub const LENGTH: Field = OFFSET.then(4);
    pub const SPANS: Field = LENGTH.then(4);
    pub const HEIGHTS_CRC: Field = SPANS.then(4);
    pub const SECOND_CRC: Field = HEIGHTS_CRC.then(4);
    pub const PAINT_CRC: Field = SECOND_CRC.then(4);
    pub const HASH: Field = PAINT_CRC.then(16);
    /// Bytes of an entry.
    pub const SIZE: usize = HASH.end();
    const _: () = assert!(SIZE == 44);
}

/// The head of a page's spans.
pub(super) mod spans {
    use super::Field;

    pub const VOXELS: Field = Field::first(4);
    pub const SPANS: Field = VOXELS.then(4);
    pub const PLACEMENTS: Field = SPANS.then(4);
    pub const FACADES: Field = PLACEMENTS.then(4);
    /// Bytes of the head.
    pub const SIZE: usize = FACADES.end();
    /// Spans and placements begin at multiples of this.
    pub const ALIGNMENT: usize = 16;
    const _: () = assert!(SIZE == 16);
}

/// The head of the objects, and one record of each.
pub(super) mod objects {
    use super::Field;

    pub const COUNT: Field = Field::first(4);
    /// Bytes of the head.
    pub const HEAD: usize = COUNT.end() + 12;

    pub const WIDTH: Field = Field::first(2);
    pub const DEPTH: Field = WIDTH.then(2);
    pub const LOW: Field = DEPTH.then(2);
    pub const HIGH: Field = LOW.then(2);
    pub const SPANS: Field = HIGH.then(4);
    pub const RESERVED: Field = SPANS.then(4);
    /// Bytes of a record.
    pub const SIZE: usize = RESERVED.end();
    const _: () = assert!(SIZE == 16 && HEAD == 16);
}

/// The header of a page.
pub(super) mod page {
    use super::Field;

    pub const LEVEL: Field = Field::first(4);
    pub const PX: Field = LEVEL.then(4);
    pub const PY: Field = PX.then(4);
    pub const WIDTH: Field = PY.then(4);
    pub const HEIGHT: Field = WIDTH.then(4);
    pub const FLAGS: Field = HEIGHT.then(4);
    pub const RESERVED: Field = FLAGS.then(40);
    /// Bytes of a page's header.
    pub const SIZE: usize = RESERVED.end();
    const _: () = assert!(SIZE == super::PLANE_ALIGNMENT);

    /// The page has the planes `low` and `high`.
    pub const FLAG_BOUNDS: u32 = 1;
    /// The plane `attributes` is one value that holds for all voxels.
    pub const FLAG_UNIFORM: u32 = 2;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows `| offset | bytes | field | …` below a heading of FORMAT.md.
    fn documented(heading: &str) -> Vec<(String, Field)> {
        let text = include_str!("FORMAT.md");
        let section = text.split("\n## ").find(|part| part.starts_with(heading)).expect("section");
        let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
        section
            .lines()
            .map(cells)
            .filter(|cells| cells.len() >= 5)
            .filter_map(|cells| {
                let field = Field { offset: cells[1].parse().ok()?, size: cells[2].parse().ok()? };
                Some((cells[3].trim_matches('`').to_owned(), field))
            })
            .collect()
    }

    fn assert_documented(heading: &str, fields: &[(&str, Field)]) {
        let coded: Vec<_> = fields.iter().map(|&(name, field)| (name.to_owned(), field)).collect();
        assert_eq!(documented(heading), coded, "FORMAT.md and format.rs differ in {heading}");
    }

    #[test]
    fn document_and_constants_agree() {
        use header::*;

        assert_documented(
            "Fixed header",
            &[
                ("magic", header::MAGIC),
                ("version", header::VERSION),
                ("header_crc", HEADER_CRC),
                ("nx", NX),
                ("ny", NY),
                ("spacing", SPACING),
                ("origin_x", ORIGIN_X),
                ("origin_y", ORIGIN_Y),
                ("level_count", LEVEL_COUNT),
                ("page_side", PAGE_SIDE),
                ("height_scale", HEIGHT_SCALE),
                ("height_offset", HEIGHT_OFFSET),
                ("height_low", HEIGHT_LOW),
                ("height_high", HEIGHT_HIGH),
                ("content_hash", CONTENT_HASH),
                ("directory_offset", DIRECTORY_OFFSET),
                ("directory_length", DIRECTORY_LENGTH),
                ("metadata_offset", METADATA_OFFSET),
                ("metadata_length", METADATA_LENGTH),
                ("directory_crc", DIRECTORY_CRC),
                ("metadata_crc", METADATA_CRC),
                ("file_length", FILE_LENGTH),
                ("objects_offset", OBJECTS_OFFSET),
                ("objects_length", OBJECTS_LENGTH),
                ("objects_crc", OBJECTS_CRC),
                ("reserved", header::RESERVED),
            ],
        );

        assert_documented(
            "Directory",
            &[
                ("offset", entry::OFFSET),
                ("length", entry::LENGTH),
                ("spans", entry::SPANS),
                ("heights_crc", entry::HEIGHTS_CRC),
                ("second_crc", entry::SECOND_CRC),
                ("paint_crc", entry::PAINT_CRC),
                ("hash", entry::HASH),
            ],
        );

        assert_documented(
            "Spans",
            &[
                ("voxels", spans::VOXELS),
                ("spans", spans::SPANS),
                ("placements", spans::PLACEMENTS),
                ("facades", spans::FACADES),
            ],
        );

        assert_documented(
            "Objects",
            &[
                ("width", objects::WIDTH),
                ("depth", objects::DEPTH),
                ("low", objects::LOW),
                ("high", objects::HIGH),
                ("spans", objects::SPANS),
                ("reserved", objects::RESERVED),
            ],
        );

        assert_documented(
            "Page",
            &[
                ("level", page::LEVEL),
                ("px", page::PX),
                ("py", page::PY),
                ("width", page::WIDTH),
                ("height", page::HEIGHT),
                ("flags", page::FLAGS),
                ("reserved", page::RESERVED),
            ],
        );
    }

    #[test]
    fn document_states_the_other_constants() {
        let text = include_str!("FORMAT.md");
        for stated in [
            format!("version {VERSION}."),
            format!("version {OLDEST} "),
            format!("multiple of {PAGE_ALIGNMENT}"),
            format!("multiple of {PLANE_ALIGNMENT}"),
            format!("at most {} bytes", METADATA_LIMIT),
            format!("`page_side` is {}", super::super::PAGE_SIDE),
            format!("bit {} (`bounds`)", page::FLAG_BOUNDS.trailing_zeros()),
            format!("bit {} (`uniform`)", page::FLAG_UNIFORM.trailing_zeros()),
        ] {
            assert!(text.contains(&stated), "FORMAT.md does not say: {stated}");
        }
    }
}
