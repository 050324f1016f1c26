//! Numbers of a glTF file that its reader would cut to 32 bits.
//!
//! The library takes 2⁶³ for 0: a file that is damaged so would show something else without a word. So the JSON is looked through once before, without
//! keeping any of it.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use crate::model::Clause;

/// Bytes before the JSON of a binary file: its header, and the chunk's.
const BEFORE_JSON: usize = 20;

/// Keys whose numbers name something by index, or are codes.
const KEYS: [&str; 30] = [
    "accessor",
    "attributes",
    "buffer",
    "bufferView",
    "camera",
    "children",
    "componentType",
    "index",
    "indices",
    "input",
    "inverseBindMatrices",
    "joints",
    "magFilter",
    "material",
    "mesh",
    "minFilter",
    "mode",
    "node",
    "nodes",
    "output",
    "sampler",
    "scene",
    "skeleton",
    "skin",
    "source",
    "target",
    "targets",
    "texture",
    "wrapS",
    "wrapT",
];

/// Keys whose members are all indices.
const NAMED: [&str; 2] = ["attributes", "targets"];

/// Refuses indices and codes of more than 32 bits in a glTF file, text or binary. What is no JSON passes: its reader says so.
pub(super) fn check(bytes: &[u8]) -> Clause<()> {
    let json = if bytes.starts_with(b"glTF") {
        let length =
            bytes.get(12..16).and_then(<[u8]>::first_chunk).map_or(0, |length| u32::from_le_bytes(*length));
        bytes.get(BEFORE_JSON..).map(|rest| rest.get(..length as usize).unwrap_or(rest)).unwrap_or_default()
    } else {
        bytes
    };
    let mut wrong = None;
    let within = Within { is_index: false, are_members: false, wrong: &mut wrong };
    // What stops it otherwise, its reader says.
    let _ = within.deserialize(&mut serde_json::Deserializer::from_slice(json));
    match wrong {
        Some(number) => Err(format!("it is no glTF: {number} is more than any index or code is")),
        None => Ok(()),
    }
}

/// A value of the JSON.
struct Within<'w> {
    /// Whether the numbers are indices or codes.
    is_index: bool,
    /// Whether the numbers of its members are.
    are_members: bool,
    /// The number that is too large.
    wrong: &'w mut Option<u64>,
}

impl<'de> DeserializeSeed<'de> for Within<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Within<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        if self.is_index && u32::try_from(number).is_err() {
            *self.wrong = Some(number);
            return Err(E::custom("too large"));
        }
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<(), A::Error> {
        let Self { is_index, are_members, wrong } = self;
        while values.next_element_seed(Within { is_index, are_members, wrong: &mut *wrong })?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        while let Some(key) = members.next_key::<String>()? {
            let key = key.as_str();
            if key == "extras" {
                // Whatever a program likes.
                members.next_value::<IgnoredAny>()?;
                continue;
            }
            let is_index = self.are_members || KEYS.contains(&key);
            let are_members = NAMED.contains(&key);
            members.next_value_seed(Within { is_index, are_members, wrong: &mut *self.wrong })?;
        }
        Ok(())
    }
}
