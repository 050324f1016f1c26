//! Patterns taken from fine imagery, each for ground of some roughness.
//!
//! ```text
//! cells      change of light relative to what voxels show, per relative deviation that they foretell
//! least      relative deviation from which on a class is the ground's
//! text       cells as bytes, 1/127 of the greatest one each, in base 64
//! ```

use std::sync::Arc;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use hedgehop_base::error::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::cells::{Cells, SIDE};

/// Most classes of roughness.
pub const MAX_CLASSES: usize = 4;

/// Value of the greatest byte.
const GREATEST: f64 = 127.0;

/// Pattern of ground that is as rough as a class, 255 × 255 cells.
#[derive(Debug, Clone, PartialEq)]
pub struct RoughnessClass {
    /// Relative deviation of light from which on ground is of this class, or of a rougher one.
    pub least: f32,
    /// Value of a byte of 1.
    unit: f32,
    bytes: Vec<i8>,
}

/// Patterns by roughness, the smoothest first; copies share them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<ClassText>", into = "Vec<ClassText>")]
pub struct MatchedPattern {
    classes: Arc<[RoughnessClass]>,
}

/// Class of roughness as text.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct ClassText {
    least: f32,
    unit: f32,
    cells: String,
}

impl RoughnessClass {
    /// Takes a pattern, in bytes.
    pub fn new(least: f32, cells: &Cells) -> Self {
        let greatest = cells.values().iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
        let unit = (greatest / GREATEST) as f32;
        let byte = |value: &f64| (value / f64::from(unit)).round().clamp(-GREATEST, GREATEST) as i8;
        Self { least, unit, bytes: cells.values().iter().map(byte).collect() }
    }

    /// The pattern.
    pub fn cells(&self) -> Cells {
        let unit = f64::from(self.unit);
        Cells::of(|column, row| unit * f64::from(self.bytes[row as usize * SIDE + column as usize]))
    }
}

impl MatchedPattern {
    /// Joins classes, of which each begins where the one before ends; the first one has all that is smoother.
    ///
    /// # Errors
    ///
    /// There are none, too many, or not in order; or a pattern holds nothing.
    pub fn new(classes: Vec<RoughnessClass>) -> Result<Self> {
        let refused = |why: String| Err(Error::Configuration(format!("a matched pattern has {why}")));
        if classes.is_empty() || classes.len() > MAX_CLASSES {
            return refused(format!("{} classes of roughness; want 1 to {MAX_CLASSES}", classes.len()));
        }
        if !classes.is_sorted_by(|one, next| one.least < next.least) || !classes[0].least.is_finite() {
            return refused("classes of roughness that are not in order".into());
        }
        for RoughnessClass { unit, bytes, .. } in &classes {
            if bytes.len() != SIDE * SIDE {
                return refused(format!("{} cells; want {}", bytes.len(), SIDE * SIDE));
            }
            if !(unit.is_finite() && *unit > 0.0) || bytes.iter().all(|byte| *byte == bytes[0]) {
                return refused("cells that are all the same".into());
            }
        }
        Ok(Self { classes: classes.into() })
    }

    /// Classes, the smoothest first.
    pub fn classes(&self) -> &[RoughnessClass] {
        &self.classes
    }
}

impl From<MatchedPattern> for Vec<ClassText> {
    fn from(pattern: MatchedPattern) -> Self {
        let text = |class: &RoughnessClass| {
            let bytes: Vec<u8> = class.bytes.iter().map(|byte| byte.cast_unsigned()).collect();
            ClassText { least: class.least, unit: class.unit, cells: BASE64_STANDARD.encode(bytes) }
        };
        pattern.classes.iter().map(text).collect()
    }
}

impl TryFrom<Vec<ClassText>> for MatchedPattern {
    type Error = Error;

    fn try_from(texts: Vec<ClassText>) -> Result<Self> {
        let class = |ClassText { least, unit, cells }: ClassText| {
            let bytes = BASE64_STANDARD.decode(cells).map_err(|error| {
                Error::Configuration(format!("a matched pattern's cells are no base 64: {error}"))
            })?;
            let bytes = bytes.into_iter().map(u8::cast_signed).collect();
            Ok(RoughnessClass { least, unit, bytes })
        };
        Self::new(texts.into_iter().map(class).collect::<Result<_>>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::Generator;

    fn class(least: f32, seed: u64) -> RoughnessClass {
        RoughnessClass::new(least, &Generator::White.cells(seed).unwrap())
    }

    #[test]
    fn patterns_come_back_from_their_text() {
        let pattern = MatchedPattern::new(vec![class(0.0, 1), class(0.25, 2)]).unwrap();
        let text = serde_json::to_string(&pattern).unwrap();
        assert_eq!(serde_json::from_str::<MatchedPattern>(&text).unwrap(), pattern);

        // Bytes are within half a unit of the values.
        let cells = Generator::Broad { octaves: 4 }.cells(3).unwrap();
        let class = RoughnessClass::new(0.0, &cells);
        let error = class.cells().joined(&cells, |a, b| (a - b).abs());
        assert!(error.values().iter().all(|error| *error <= 0.5001 * f64::from(class.unit)));
    }

    #[test]
    fn damaged_patterns_are_refused_by_a_sentence() {
        let good =
            serde_json::to_value(MatchedPattern::new(vec![class(0.0, 1), class(0.25, 2)]).unwrap()).unwrap();
        let refused = |change: &dyn Fn(&mut serde_json::Value)| {
            let mut text = good.clone();
            change(&mut text);
            serde_json::from_value::<MatchedPattern>(text).unwrap_err().to_string()
        };
        assert!(refused(&|text| text[1]["least"] = (-1.0).into()).contains("not in order"));
        assert!(refused(&|text| text[0]["unit"] = 0.0.into()).contains("all the same"));
        assert!(refused(&|text| text[0]["cells"] = "AAAA".into()).contains("3 cells; want 65025"));
        assert!(refused(&|text| text[0]["cells"] = "?".into()).contains("no base 64"));
        assert!(refused(&|text| *text = serde_json::json!([])).contains("0 classes"));
    }
}
