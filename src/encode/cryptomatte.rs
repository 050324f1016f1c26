//! Mattes of objects as Cryptomatte: ids of names, channels, and the header.
//!
//! ```text
//! id of a name    MurmurHash3_32 of its UTF-8, seed 0, exponent kept off 0 and 255, taken for a float
//! of each pixel   bodies, ground: (id, share), the largest share first
//! channels        CryptoObject00: R G = first pair, B A = second; CryptoObject01: third and fourth; …
//! header          cryptomatte/KEY/name, hash, conversion, manifest (JSON: names, and ids in hexadecimal)
//! ```
//!
//! Sources: Friedman and Jones, *Fully automatic ID mattes with support for motion blur and transparency* (SIGGRAPH 2015 posters), and the
//! Cryptomatte specification 1.2.0 (Psyop); Appleby's MurmurHash3 (2011). The sky is no object: it is what shares leave of 1.

use std::collections::BTreeSet;

use crate::frame::{Frame, Matte, MatteCoverage};

/// Name of the layers.
const LAYER: &str = "CryptoObject";

/// Bodies of a pixel that are told, the largest first: two in each layer. As many as other renderers tell.
const RANKS: usize = 6;

/// Parts of a layer, in the order of ids and shares.
const PARTS: [&str; 4] = ["R", "G", "B", "A"];

impl Matte {
    /// Names and samples of the channels, each `[height][width]`.
    pub(super) fn channels(&self, frame: &Frame) -> Vec<(String, Vec<f32>)> {
        let pixels = frame.level.len();
        let mut planes = vec![vec![0.0; pixels]; 2 * RANKS];
        let ground = id(&self.name(MatteCoverage::GROUND));
        for (pixel, _) in frame.level.iter().enumerate().filter(|(_, level)| **level != Frame::SKY_LEVEL) {
            (planes[0][pixel], planes[1][pixel]) = (ground, 1.0);
        }

        let ids: Vec<f32> = (0..self.most_id()).map(|number| id(&self.name(number))).collect();
        let id_of = |number: u32| ids.get(number as usize).copied().unwrap_or(ground);
        let mut shares: Vec<(f32, f32)> = Vec::new();
        for covers in self.covers.chunk_by(|a, b| a.pixel == b.pixel) {
            let pixel = covers[0].pixel as usize;
            shares.clear();
            for cover in covers {
                let id = id_of(cover.id);
                match shares.iter_mut().find(|(known, _)| *known == id) {
                    Some((_, share)) => *share += cover.share,
                    None => shares.push((id, cover.share)),
                }
            }

            // Things of equal share stay in their order.
            shares.sort_by(|(_, a), (_, b)| b.total_cmp(a));
            for (rank, planes) in planes.chunks_exact_mut(2).enumerate() {
                (planes[0][pixel], planes[1][pixel]) = shares.get(rank).copied().unwrap_or_default();
            }
        }

        let name = |plane: usize| format!("{LAYER}{:02}.{}", plane / PARTS.len(), PARTS[plane % PARTS.len()]);
        planes.into_iter().enumerate().map(|(plane, samples)| (name(plane), samples)).collect()
    }

    /// Names and values of the header's attributes.
    pub(super) fn attributes(&self) -> [(String, String); 4] {
        let numbers = (0..self.most_id()).chain([MatteCoverage::GROUND]);
        let manifest: serde_json::Map<_, _> = numbers
            .map(|number| {
                let name = self.name(number);
                let id = format!("{:08x}", id(&name).to_bits());
                (name, id.into())
            })
            .collect();
        let key = format!("{:08x}", murmur3(LAYER.as_bytes()));
        let named = |what: &str, value: String| (format!("cryptomatte/{}/{what}", &key[..7]), value);
        [
            named("name", LAYER.to_owned()),
            named("hash", "MurmurHash3_32".to_owned()),
            named("conversion", "uint32_to_float32".to_owned()),
            named("manifest", serde_json::Value::Object(manifest).to_string()),
        ]
    }

    /// One more than the highest id of a body, at least as many as there are names.
    fn most_id(&self) -> u32 {
        let bodies = self.covers.iter().map(|cover| cover.id).filter(|id| *id != MatteCoverage::GROUND);
        bodies.max().map_or(0, |id| id + 1).max(self.names.len() as u32)
    }

    /// Names a body, or the ground.
    fn name(&self, number: u32) -> String {
        if number == MatteCoverage::GROUND {
            // Ids are those of names: the ground's must be its own.
            let taken: BTreeSet<&str> = self.names.iter().map(String::as_str).collect();
            let mut name = "ground".to_owned();
            while taken.contains(name.as_str()) {
                name.push('_');
            }
            return name;
        }
        self.names.get(number as usize).cloned().unwrap_or_else(|| format!("object {number}"))
    }
}

/// A name's id: its hash as a float that is neither infinite, nor no number, nor denormal.
fn id(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes());
    let exponent = (hash >> 23 & 0xff).clamp(1, 254);
    f32::from_bits(hash & !(0xff << 23) | exponent << 23)
}

/// MurmurHash3_32 with the seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, rest) = bytes.as_chunks::<4>();
    let mut hash = 0_u32;
    for block in blocks {
        hash = (hash ^ mix(u32::from_le_bytes(*block)))
            .rotate_left(13)
            .wrapping_mul(5)
            .wrapping_add(0xe654_6b64);
    }
    hash ^= mix(rest.iter().rev().fold(0, |block, byte| block << 8 | u32::from(*byte)));
    // The length counts modulo 2³², as in the original.
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
#[path = "cryptomatte_tests.rs"]
mod tests;
