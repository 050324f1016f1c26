//! Databases as version 7 of the format has them, for tests of those who read them.

use super::fixed_header::FixedHeader;
use super::format::{Field, header as at};
use super::{Header, MemPages, PageSource, PageWriter};
use hedgehop_base::error::{Error, Result};

/// Writes all pages in full, as version 7 does, also those without any surface.
///
/// # Errors
/// Errors of a writer of pages in the folder for temporary files.
pub fn in_full(pages: &MemPages) -> Result<MemPages> {
    let folder = tempfile::tempdir().map_err(|source| Error::io("full.hop", "create", source))?;
    let path = folder.path().join("full.hop");
    let Header { grid, heights, objects, metadata, height_range, .. } = pages.header();
    let mut writer = PageWriter::create(&path, *grid, *heights, false)?.with_objects(objects.clone());

    for (id, _) in pages.directory().present() {
        if let Some(page) = pages.whole_page(id)? {
            writer.append(&page.to_buffer().encode_in_full(id))?;
        }
    }

    writer.finish(metadata, *height_range)?;

    let mut bytes = std::fs::read(&path).map_err(|source| Error::io(&path, "read", source))?;
    let mut header = FixedHeader::decode(&path, &bytes)?;
    header.version = 7;
    let section = |offset: Field, length: Field| {
        let start = offset.u64(&bytes) as usize;
        start..start + length.u64(&bytes) as usize
    };
    let json = section(at::METADATA_OFFSET, at::METADATA_LENGTH);
    let directory = MemPages::from_bytes(&path, &bytes)?.directory().clone();
    header.content_hash = header.identity(&bytes[json], &objects.to_bytes(), &directory);
    bytes[..at::SIZE].copy_from_slice(&header.encode());

    MemPages::from_bytes(&path, &bytes)
}
