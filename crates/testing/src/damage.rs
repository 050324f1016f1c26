//! Damage for tests of whatever reads pictures, and a count of what became of it.

use std::fmt;
use std::ops::Range;

/// Numbers without a pattern (Marsaglia's xorshift), from a seed that is not 0.
pub struct Damage(pub u64);

/// Count of how readers took damaged copies of a picture.
#[derive(Debug, Default, Clone, Copy)]
pub struct Count {
    /// Read as the sound one is, since what is damaged changes no sample.
    pub same: usize,
    /// Refused, or told in a note.
    pub told: usize,
    /// Read as something else, without a word.
    pub silent: usize,
}

impl Damage {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound.max(1) as u64) as usize
    }

    /// Flips, fills or scrambles bytes of a range, whose length stays.
    pub fn within(&mut self, bytes: &[u8], range: Range<usize>) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        let part = &mut bytes[range];
        let at = self.below(part.len());
        let to = at + 1 + self.below((part.len() - at).min(64));
        match self.below(4) {
            0 => part[at] ^= 1 << self.below(8),
            1 => part[at..to].fill(if self.below(2) == 0 { 0 } else { 0xff }),
            2 => part[at..to].rotate_left(1),
            _ => (0..=self.below(8)).for_each(|_| part[self.below(part.len())] = self.below(256) as u8),
        }
        bytes
    }

    /// Damages any of the bytes, cuts or fills the end, or leaves out or doubles a part.
    pub fn anywhere(&mut self, bytes: &[u8]) -> Vec<u8> {
        let at = self.below(bytes.len());
        let to = at + 1 + self.below(bytes.len() - at);
        match self.below(8) {
            0 => bytes[..at].to_vec(),
            // As a download that a tool made room for.
            1 => [&bytes[..at], &vec![0; bytes.len() - at]].concat(),
            2 => [&bytes[..at], &bytes[to..]].concat(),
            3 => [&bytes[..to], &bytes[at..]].concat(),
            _ => self.within(bytes, 0..bytes.len()),
        }
    }
}

impl Count {
    /// Prints what became of copies of one kind, for whoever runs the test with `--nocapture`.
    #[expect(clippy::print_stdout, reason = "figures of a test")]
    pub fn print(&self, taken: &str, name: &str) {
        println!("{taken:10} {name:14} {self}");
    }

    /// Takes in what one copy was read as; `None`: it was refused or told.
    pub fn add<T: PartialEq>(&mut self, read: Option<T>, sound: &T) {
        match read {
            None => self.told += 1,
            Some(read) if read == *sound => self.same += 1,
            Some(_) => self.silent += 1,
        }
    }
}

impl fmt::Display for Count {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { same, told, silent } = *self;
        let all = same + told + silent;
        write!(formatter, "{all:5} damaged: {told:5} told, {same:5} the same, {silent:5} silent")
    }
}
