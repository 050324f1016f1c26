//! Sets of blocks of a file, and the bits in which they are stored.

use std::ops::Range;

/// Bytes of a block: that of systems' pages, at multiples of which pages of a database begin.
pub(crate) const BLOCK: u64 = 4096;

/// Returns the blocks that hold some of a range of bytes.
pub(crate) fn blocks_of(bytes: &Range<u64>) -> Range<u64> {
    if bytes.is_empty() { 0..0 } else { bytes.start / BLOCK..bytes.end.div_ceil(BLOCK) }
}

/// Blocks of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct BlockSet {
    /// Bit n of byte m is block 8·m + n.
    bits: Vec<u8>,
}

impl BlockSet {
    /// Makes an empty set of blocks of a file of `length` bytes.
    pub fn empty(length: u64) -> Self {
        Self { bits: vec![0; length.div_ceil(BLOCK).div_ceil(8) as usize] }
    }

    /// Makes the set that stored bits describe.
    pub fn of_bits(bits: Vec<u8>) -> Self {
        Self { bits }
    }

    /// Returns the bits as they are stored.
    pub fn bits(&self) -> &[u8] {
        &self.bits
    }

    /// Adds what other bits hold, from a byte of the bits on.
    pub fn unite(&mut self, first: usize, bits: &[u8]) {
        self.bits.iter_mut().skip(first).zip(bits).for_each(|(own, other)| *own |= other);
    }

    /// Whether it holds a block.
    pub fn has(&self, block: u64) -> bool {
        self.bits.get((block / 8) as usize).is_some_and(|bits| bits >> (block % 8) & 1 == 1)
    }

    /// Whether it holds all of these.
    pub fn has_all(&self, blocks: Range<u64>) -> bool {
        self.first_missing(blocks).is_none()
    }

    /// Finds the first of these that is not in the set.
    pub fn first_missing(&self, mut blocks: Range<u64>) -> Option<u64> {
        blocks.find(|block| !self.has(*block))
    }

    /// Adds blocks.
    pub fn insert(&mut self, blocks: Range<u64>) {
        for block in blocks {
            if let Some(bits) = self.bits.get_mut((block / 8) as usize) {
                *bits |= 1 << (block % 8);
            }
        }
    }

    /// Takes blocks out.
    pub fn remove(&mut self, blocks: Range<u64>) {
        for block in blocks {
            if let Some(bits) = self.bits.get_mut((block / 8) as usize) {
                *bits &= !(1 << (block % 8));
            }
        }
    }

    /// Lists the blocks that it holds as runs.
    pub fn runs(&self) -> Vec<Range<u64>> {
        let mut runs: Vec<Range<u64>> = Vec::new();
        for block in (0..self.bits.len() as u64 * 8).filter(|block| self.has(*block)) {
            match runs.last_mut() {
                Some(run) if run.end == block => run.end += 1,
                _ => runs.push(block..block + 1),
            }
        }
        runs
    }

    /// Counts the blocks.
    pub fn count(&self) -> u64 {
        self.bits.iter().map(|bits| u64::from(bits.count_ones())).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_those_that_bytes_touch() {
        assert_eq!(blocks_of(&(0..1)), 0..1);
        assert_eq!(blocks_of(&(4095..4097)), 0..2);
        assert_eq!(blocks_of(&(4096..8192)), 1..2);
        assert_eq!(blocks_of(&(9..9)), 0..0);
    }

    #[test]
    fn sets_hold_what_was_added() {
        let mut set = BlockSet::empty(100 * BLOCK + 1);
        set.insert(7..10);
        set.insert(100..101);
        assert_eq!((set.runs(), set.count()), (vec![7..10, 100..101], 4));
        assert!(set.has_all(7..10) && set.has_all(0..0) && !set.has_all(7..11));
        set.remove(8..9);
        assert_eq!(set.first_missing(7..10), Some(8));
        let mut other = BlockSet::empty(100 * BLOCK + 1);
        other.unite(1, &set.bits()[1..]);
        assert_eq!(other.runs(), [9..10, 100..101]);
    }
}
