//! Reading and writing at a place of a file, whatever the system.

use std::fs::File;
use std::io;

/// Writes all bytes from a place on.
#[cfg(unix)]
pub(crate) fn write_at(file: &File, bytes: &[u8], place: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, place)
}

/// Reads as many bytes from a place on.
#[cfg(unix)]
pub(crate) fn read_at(file: &File, bytes: &mut [u8], place: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, place)
}

/// Writes all bytes from a place on.
#[cfg(windows)]
pub(crate) fn write_at(file: &File, mut bytes: &[u8], mut place: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let written = std::os::windows::fs::FileExt::seek_write(file, bytes, place)?;
        if written == 0 {
            return Err(io::ErrorKind::WriteZero.into());
        }
        bytes = &bytes[written..];
        place += written as u64;
    }
    Ok(())
}

/// Reads as many bytes from a place on.
#[cfg(windows)]
pub(crate) fn read_at(file: &File, mut bytes: &mut [u8], mut place: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let read = std::os::windows::fs::FileExt::seek_read(file, bytes, place)?;
        if read == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        bytes = &mut bytes[read..];
        place += read as u64;
    }
    Ok(())
}

/// Frees the disk space of a range, which reads as zeros from then on; false: the system cannot do that.
#[cfg(any(target_os = "linux", target_os = "android"))]
pub(crate) fn punch(file: &File, place: u64, length: u64) -> bool {
    let flags = rustix::fs::FallocateFlags::PUNCH_HOLE | rustix::fs::FallocateFlags::KEEP_SIZE;
    rustix::fs::fallocate(file, flags, place, length).is_ok()
}

/// Frees the disk space of a range, which reads as zeros from then on; false: the system cannot do that.
#[cfg(not(any(target_os = "linux", target_os = "android")))]
pub(crate) fn punch(_: &File, _: u64, _: u64) -> bool {
    false
}
