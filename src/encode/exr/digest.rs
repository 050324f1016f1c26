//! Digest of a file's entries and channels, since the format has no checksums over them.

use std::collections::BTreeMap;

use ::exr::prelude::FlatSamples;

use super::channels::Channels;

/// Name of the attribute that holds the digest of entries and channels.
pub(super) const DIGEST: &str = "hedgehop.digest";

/// Returns the BLAKE3 of the entries and of every channel's name, type and samples (little-endian).
pub(super) fn digest(entries: &BTreeMap<String, String>, channels: &Channels) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, value) in entries {
        hasher.update(format!("{name}={value}\0").as_bytes());
    }
    for channel in &channels.list {
        hasher.update(channel.name.as_slice());
        match &channel.sample_data {
            FlatSamples::U32(samples) => absorb(&mut hasher, 0, samples, |&sample| sample),
            FlatSamples::F16(samples) => {
                absorb(&mut hasher, 1, samples, |sample| u32::from(sample.to_bits()))
            }
            FlatSamples::F32(samples) => absorb(&mut hasher, 2, samples, |sample| sample.to_bits()),
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// Adds samples of the type `kind` to a digest, a block at a time.
fn absorb<T>(hasher: &mut blake3::Hasher, kind: u8, samples: &[T], bits: impl Fn(&T) -> u32) {
    const BLOCK: usize = 1 << 15; // the hash takes many parts at once
    hasher.update(&[0, kind]);
    let mut buffer = vec![[0; size_of::<u32>()]; BLOCK.min(samples.len())];
    for block in samples.chunks(BLOCK) {
        let bytes = &mut buffer[..block.len()];
        bytes.iter_mut().zip(block).for_each(|(bytes, sample)| *bytes = bits(sample).to_le_bytes());
        hasher.update(bytes.as_flattened());
    }
}
