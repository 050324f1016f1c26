//! Local systems: coordinates in a unit of length, without a place on Earth.

use super::units;
use super::wkt::{Item, Node, parse};

/// A local (engineering) system that a file states.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalSystem {
    /// Name in the file; may be empty.
    pub name: String,
    /// Metres per unit of its coordinates.
    pub metres_per_unit: f64,
}

impl LocalSystem {
    /// Reads WKT (`LOCAL_CS`, `ENGCRS`); `None` for any other text.
    pub fn from_wkt(text: &str) -> Option<Self> {
        Self::of_node(&parse(text).ok()?)
    }

    pub(super) fn of_node(node: &Node) -> Option<Self> {
        if !matches!(node.word.as_str(), "LOCAL_CS" | "ENGCRS" | "ENGINEERINGCRS") {
            return None;
        }
        let own = node.child(&["LENGTHUNIT", "UNIT"]);
        let of_axis = || node.children(&["AXIS"]).find_map(|axis| axis.child(&["LENGTHUNIT", "UNIT"]));
        let size = own.or_else(of_axis).and_then(|unit| unit.numbers().next());
        let name = match node.items.first() {
            Some(Item::Text(name)) => name.clone(),
            _ => String::new(),
        };
        Some(Self { name, metres_per_unit: size.map_or(1.0, units::exact) })
    }

    /// Whether it counts in metres.
    pub fn is_metric(&self) -> bool {
        units::same(self.metres_per_unit, 1.0)
    }

    /// Describes the system, and its unit if that is not the metre, for sentences: `a local system, 'site', in units of 0.3048 m`.
    pub fn words(&self) -> String {
        let name = if self.name.is_empty() { String::new() } else { format!(", '{}'", self.name) };
        let unit = if self.is_metric() {
            String::new()
        } else {
            format!(", in units of {} m", self.metres_per_unit)
        };
        format!("a local system{name}{unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_systems_have_names_and_units() {
        let table = [
            (
                r#"LOCAL_CS["site",LOCAL_DATUM["x",0],UNIT["foot",0.3048],AXIS["E",EAST]]"#,
                "a local system, 'site', in units of 0.3048 m",
            ),
            (r#"LOCAL_CS["site",UNIT["metre",1]]"#, "a local system, 'site'"),
            (
                r#"ENGCRS["",EDATUM["x"],CS[Cartesian,2],AXIS["e",east],LENGTHUNIT["metre",1]]"#,
                "a local system",
            ),
            (
                r#"ENGCRS["a",EDATUM["x"],CS[Cartesian,2],AXIS["e",east,LENGTHUNIT["US survey foot",0.304800609601219]]]"#,
                "a local system, 'a', in units of 0.3048006096012192 m",
            ),
        ];

        for (text, words) in table {
            assert_eq!(
                LocalSystem::from_wkt(text).map(|local| local.words()).as_deref(),
                Some(words),
                "{text}"
            );
        }

        assert_eq!(LocalSystem::from_wkt(r#"GEOGCS["x"]"#), None);
        assert_eq!(LocalSystem::from_wkt("LOCAL_CS["), None);
    }
}
