//! Bytes in memory that begin where any plane may begin.

use super::format::PLANE_ALIGNMENT;

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Block([u8; PLANE_ALIGNMENT]);

/// A growable run of bytes, aligned to 64.
#[derive(Debug, Clone, Default)]
pub struct AlignedBytes {
    blocks: Vec<Block>,
    length: usize,
}

impl AlignedBytes {
    /// `length` zero bytes.
    pub fn zeroed(length: usize) -> Self {
        let mut bytes = Self::default();
        bytes.resize(length);
        bytes
    }

    /// A copy of `bytes`.
    pub fn copy_of(bytes: &[u8]) -> Self {
        let mut copy = Self::zeroed(bytes.len());
        copy.as_mut_slice().copy_from_slice(bytes);
        copy
    }

    /// Changes the length. What is new is zero, unless the bytes were longer before.
    pub fn resize(&mut self, length: usize) {
        self.blocks.resize(length.div_ceil(PLANE_ALIGNMENT), Block([0; PLANE_ALIGNMENT]));
        self.length = length;
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.length]
    }

    /// The bytes, to be written.
    pub fn as_mut_slice(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.blocks)[..self.length]
    }
}
