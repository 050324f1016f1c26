//! Keys of sixteen bytes that tell what something was made of.

use std::fmt::{Debug, Write};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// First bytes of a hash of all that something is made of: the same key, the same result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(crate) struct Key([u8; 16]);

impl Key {
    /// Returns the key as text.
    pub fn hex(self) -> String {
        format!("{:032x}", u128::from_be_bytes(self.0))
    }

    /// Parses the key from text.
    pub fn from_hex(text: &str) -> Option<Self> {
        u128::from_str_radix(text, 16).ok().map(|number| Self(number.to_be_bytes()))
    }
}

/// Takes what goes into a key, piece by piece.
pub(crate) struct Keyer(blake3::Hasher);

impl Write for Keyer {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Keyer {
    /// Begins the key of a kind of things, made by this program.
    pub fn of(kind: &str) -> Self {
        // What another version made may differ, whatever number it has.
        Self(blake3::Hasher::new()).with(&env!("HEDGEHOP_SOURCES")).with(&kind)
    }

    /// Takes all that a value tells of itself. `Debug` of the types here tells every field, floating point to the last bit, so that a
    /// field that is added later cannot be forgotten.
    pub fn with(mut self, value: &dyn Debug) -> Self {
        // A hash takes everything.
        let _ = write!(self, "{value:?}\0");
        self
    }

    /// Takes bytes.
    pub fn with_bytes(mut self, bytes: &[u8]) -> Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Takes another key.
    pub fn with_key(self, key: Key) -> Self {
        self.with_bytes(&key.0)
    }

    /// The key.
    pub fn key(self) -> Key {
        let mut key = [0; 16];
        key.copy_from_slice(&self.0.finalize().as_bytes()[..16]);
        Key(key)
    }
}

/// Bytes that are read at once.
const CHUNK: usize = 1 << 20;

/// Hash of a file's bytes.
pub(super) fn content(path: &Path) -> std::io::Result<Key> {
    let mut file = File::open(path)?;
    let mut hasher = blake3::Hasher::new();
    let mut chunk = vec![0; CHUNK];
    loop {
        match file.read(&mut chunk)? {
            0 => return Ok(Keyer(hasher).key()),
            count => drop(hasher.update(&chunk[..count])),
        }
    }
}
