//! One row of a layer: its outline in metres, and what it says of its shadow.

use glam::{DVec2, dvec2};

use super::super::features::{Row, Value, length};
use super::bounds::PlaceBounds;
use hedgehop_geo::Transform;

/// Statement of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RowClaim {
    /// Height, which stays.
    Height(f64),
    /// The length of its shadow, metres.
    Length(f64),
    /// The place of its shadow's tip, metres.
    Tip(DVec2),
    /// Nothing.
    None,
}

/// An outline in metres, and what the row states.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RowOutline {
    pub rings: Vec<Vec<DVec2>>,
    pub claim: RowClaim,
}

impl RowOutline {
    /// Reads a row in the system to which `transform` leads; else says why not. Heights count unless `all` are to be measured.
    pub fn of(row: &Row, transform: &Transform, all: bool) -> Result<Self, String> {
        let claim = claim(row, transform, all)?;
        if row.geometry.areas.is_empty() {
            return Err("it has no area".to_owned());
        }
        let geometry = row.geometry.transformed(transform).ok_or("it has no place in metres")?;
        let rings = geometry
            .areas
            .into_iter()
            .flat_map(|area| std::iter::once(area.outer).chain(area.holes).map(|ring| ring.places));
        Ok(Self { rings: rings.collect(), claim })
    }

    /// Returns the bounds.
    pub fn bounds(&self) -> PlaceBounds {
        PlaceBounds::around(self.rings.iter().flatten().copied())
    }

    /// Whether a place lies within by the even-odd rule.
    pub fn holds(&self, place: DVec2) -> bool {
        let edges = self.rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let crosses = |(a, b): &(&DVec2, &DVec2)| {
            (a.y > place.y) != (b.y > place.y) && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        edges.filter(crosses).count() % 2 == 1
    }

    /// A place that lies within in most cases: the mean of the first ring's corners.
    pub fn middle(&self) -> DVec2 {
        let ring = self.rings.first().map(Vec::as_slice).unwrap_or_default();
        ring.iter().sum::<DVec2>() / ring.len().max(1) as f64
    }
}

fn claim(row: &Row, transform: &Transform, all: bool) -> Result<RowClaim, String> {
    let metres = |name: &str| match row.attributes.get(name) {
        None => Ok(None),
        Some(Value::Number(metres)) => Ok(Some(*metres)),
        Some(Value::Text(text)) => length(text)
            .map(Some)
            .ok_or_else(|| format!("its {name} is {:?}, which is no length", shortened(text))),
    };

    if let (false, Ok(Some(height))) = (all, metres("height"))
        && height > 0.0
    {
        return Ok(RowClaim::Height(height));
    }
    if let Some(length) = metres("shadow_length")? {
        return if length > 0.0 {
            Ok(RowClaim::Length(length))
        } else {
            Err(format!("its shadow_length is {length}, and must be above 0"))
        };
    }

    match row.attributes.get("shadow_tip") {
        None => Ok(RowClaim::None),
        Some(Value::Text(text)) if place(text).is_some() => {
            let tip = place(text).and_then(|tip| transform.apply(tip.x, tip.y));
            tip.map(|tip| RowClaim::Tip(tip.into()))
                .ok_or_else(|| "its shadow_tip has no place in metres".to_owned())
        }
        Some(value) => {
            let said = match value {
                Value::Number(number) => number.to_string(),
                Value::Text(text) => shortened(text),
            };
            Err(format!("its shadow_tip is {said:?}, and must be a place: x,y in the layer's system"))
        }
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Two numbers, with a comma, blanks or a semicolon between.
fn place(text: &str) -> Option<DVec2> {
    let text = text.trim().trim_start_matches('[').trim_end_matches(']');
    let mut numbers = text
        .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
        .filter(|part| !part.is_empty())
        .map(|part| part.parse::<f64>().ok().filter(|number| number.is_finite()));
    let place = dvec2(numbers.next()??, numbers.next()??);
    numbers.next().is_none().then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_two_numbers() {
        for text in ["12.5,-3", " [12.5, -3] ", "12.5 -3", "12.5;-3"] {
            assert_eq!(place(text), Some(dvec2(12.5, -3.0)), "{text}");
        }
        for text in ["", "12.5", "1,2,3", "a,b", "1,inf", "1,nan"] {
            assert_eq!(place(text), None, "{text}");
        }
    }
}
