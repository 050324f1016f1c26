//! A map's features, and their text: GeoJSON with projected coordinates (the member `crs` of its edition of 2008).

use std::fmt::Write;

use crate::geotiff::ORIGIN;
use crate::outline::Place;

/// Form of a feature, metres in the area.
pub enum Geometry {
    Point(Place),
    Line(Vec<Place>),
    /// One ring, counterclockwise, the first place not repeated.
    Polygon(Vec<Place>),
}

/// Value of a tag.
pub enum Value {
    Text(String),
    Number(f64),
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// One row of the map.
pub struct Feature {
    pub geometry: Geometry,
    pub tags: Vec<(&'static str, Value)>,
}

impl Feature {
    pub fn new<const N: usize>(geometry: Geometry, tags: [(&'static str, Value); N]) -> Self {
        Self { geometry, tags: tags.into() }
    }

    /// Returns the value of a tag, if it is a text.
    #[cfg(test)]
    pub fn text(&self, key: &str) -> Option<&str> {
        self.tags.iter().find_map(|(name, value)| match value {
            Value::Text(text) if *name == key => Some(text.as_str()),
            _ => None,
        })
    }

    /// Returns the value of a tag, if it is a number.
    #[cfg(test)]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.tags.iter().find_map(|(name, value)| match value {
            Value::Number(number) if *name == key => Some(*number),
            _ => None,
        })
    }
}

/// A number in hundredths, without zeros at its end.
fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn position((x, y): Place) -> String {
    format!("[{},{}]", hundredths(ORIGIN.0 + x), hundredths(ORIGIN.1 + y))
}

fn positions(places: &[Place]) -> String {
    places.iter().map(|&place| position(place)).collect::<Vec<_>>().join(",")
}

/// The file's text, a feature on each line.
pub fn to_geojson(features: &[Feature]) -> String {
    let mut text = String::from(
        "{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"urn:ogc:def:crs:EPSG::32632\"}},\"features\":[\n",
    );
    let lines: Vec<String> = features.iter().map(line).collect();
    text.push_str(&lines.join(",\n"));
    text.push_str("\n]}\n");
    text
}

fn line(feature: &Feature) -> String {
    let (kind, coordinates) = match &feature.geometry {
        Geometry::Point(place) => ("Point", position(*place)),
        Geometry::Line(places) => ("LineString", format!("[{}]", positions(places))),
        Geometry::Polygon(ring) => {
            let closed: Vec<Place> = ring.iter().chain(ring.first()).copied().collect();
            ("Polygon", format!("[[{}]]", positions(&closed)))
        }
    };

    let mut tags = String::new();
    for (k, (key, value)) in feature.tags.iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        let written = match value {
            Value::Text(text) => write!(tags, "{comma}\"{key}\":\"{text}\""),
            Value::Number(number) => write!(tags, "{comma}\"{key}\":{}", hundredths(*number)),
        };
        written.expect("writing to a string cannot fail");
    }

    format!(
        "{{\"type\":\"Feature\",\"geometry\":{{\"type\":\"{kind}\",\"coordinates\":{coordinates}}},\"properties\":{{{tags}}}}}"
    )
}
