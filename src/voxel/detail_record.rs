//! Detail below the finest voxel, as a database asks for it.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use hedgehop_texture::{Generator, MatchedPattern};
use serde::{Deserialize, Serialize};

/// Detail below the finest voxel: its pattern, and how strong it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetailRecord {
    /// Pattern of the octaves that no voxel holds.
    #[serde(flatten)]
    pub pattern: Generator,
    /// Seed that picks one pattern among all alike.
    pub seed: u64,
    /// Factor on the amplitude that imagery asks for, 0…2; 0: there is no detail.
    pub strength: f64,
    /// Share of detail that is relief which the sun lights, per cotangent of the sun's elevation, 0…2; 0: the sun changes nothing.
    pub relief: f64,
    /// Factors on amplitudes of materials by name, 0…4, in place of the program's own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, f64>,
    /// Metres up and down that the ground is displaced by at most, 0…5; 0: it lies as its posts say.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub displacement: f64,
    /// The same of materials by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub displacements: BTreeMap<String, f64>,
    /// Pattern over the ground that was matched from fine imagery, in place of [`Self::pattern`], which walls have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matched: Option<MatchedPattern>,
}

/// Whether a number need not be written.
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl Default for DetailRecord {
    fn default() -> Self {
        Self {
            pattern: Generator::Broad { octaves: 4 },
            seed: 0,
            strength: 1.0,
            relief: 0.5,
            materials: BTreeMap::new(),
            matched: None,
            displacement: 0.0,
            displacements: BTreeMap::new(),
        }
    }
}

impl DetailRecord {
    /// Range of [`Self::strength`].
    pub const STRENGTHS: RangeInclusive<f64> = 0.0..=2.0;
    /// Range of [`Self::relief`].
    pub const RELIEFS: RangeInclusive<f64> = 0.0..=2.0;
    /// Range of factors of materials.
    pub const FACTORS: RangeInclusive<f64> = 0.0..=4.0;
    /// Range of displacements, metres.
    pub const DISPLACEMENTS: RangeInclusive<f64> = 0.0..=5.0;

    /// Whether every number is in range; otherwise a sentence that says which one is not.
    pub(super) fn check(&self) -> Result<(), String> {
        let factors = self.materials.iter().map(|(name, factor)| (name.as_str(), *factor, Self::FACTORS));
        let own = [
            ("strength", self.strength, Self::STRENGTHS),
            ("relief", self.relief, Self::RELIEFS),
            ("displacement", self.displacement, Self::DISPLACEMENTS),
        ];
        let displaced =
            self.displacements.iter().map(|(name, metres)| (name.as_str(), *metres, Self::DISPLACEMENTS));
        for (name, value, range) in own.into_iter().chain(factors).chain(displaced) {
            if !range.contains(&value) {
                let (least, most) = range.into_inner();
                return Err(format!(
                    "metadata: detail has a {name} of {value:?}, but it must be within {least} and {most}"
                ));
            }
        }
        self.pattern.check().map_err(|error| format!("metadata: detail: {error}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_texture::QuantityMode;

    #[test]
    fn records_come_back_from_their_text() {
        let modes = QuantityMode::ALL.map(|mode| Generator::Quantity { mode });
        for pattern in Generator::ALL.into_iter().chain(modes) {
            let materials = BTreeMap::from([("grass".to_owned(), 0.25)]);
            let displacements = BTreeMap::from([("gravel".to_owned(), 0.05)]);
            let record = DetailRecord {
                pattern,
                seed: u64::MAX,
                materials,
                displacement: 0.1,
                displacements,
                ..DetailRecord::default()
            };
            let text = serde_json::to_string(&record).unwrap();
            assert_eq!(serde_json::from_str::<DetailRecord>(&text).unwrap(), record, "{text}");
        }
        let text = serde_json::to_string(&DetailRecord::default()).unwrap();
        assert_eq!(text, r#"{"pattern":"broad","octaves":4,"seed":0,"strength":1.0,"relief":0.5}"#);
        assert_eq!(serde_json::from_str::<DetailRecord>(&text).unwrap(), DetailRecord::default());
    }

    #[test]
    fn what_is_out_of_range_is_named() {
        let usual = DetailRecord::default;
        let refused = |record: DetailRecord| record.check().unwrap_err();
        assert_eq!(usual().check(), Ok(()));
        assert!(refused(DetailRecord { strength: 3.0, ..usual() }).contains("a strength of 3.0"));
        assert!(refused(DetailRecord { relief: f64::NAN, ..usual() }).contains("a relief of NaN"));
        let materials = BTreeMap::from([("water".to_owned(), -1.0)]);
        assert!(refused(DetailRecord { materials, ..usual() }).contains("a water of -1.0"));
        assert!(refused(DetailRecord { displacement: 6.0, ..usual() }).contains("a displacement of 6.0"));
        let displacements = BTreeMap::from([("grass".to_owned(), f64::INFINITY)]);
        assert!(refused(DetailRecord { displacements, ..usual() }).contains("a grass of inf"));
        let pattern = Generator::Broad { octaves: 9 };
        assert!(refused(DetailRecord { pattern, ..usual() }).contains("9 octaves; want 1 to 6"));
    }
}
