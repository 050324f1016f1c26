//! A map's features, and their text: GeoJSON with projected coordinates (the member `crs` of its edition of 2008).

use std::fmt::Write;

use glam::DVec2;

use crate::geotiff::ORIGIN;

/// Form of a feature, metres in the area.
pub enum Geometry {
    Point(DVec2),
    Line(Vec<DVec2>),
    /// One ring, counterclockwise, the first place not repeated.
    Polygon(Vec<DVec2>),
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

/// A property of a feature.
pub struct Tag {
    /// Name of the property.
    pub key: &'static str,
    /// Value of the property.
    pub value: Value,
}

impl Tag {
    /// Gives a property a value.
    pub fn new(key: &'static str, value: impl Into<Value>) -> Self {
        Self { key, value: value.into() }
    }
}

/// One row of the map.
pub struct Feature {
    pub geometry: Geometry,
    pub tags: Vec<Tag>,
}

impl Feature {
    pub fn new<const N: usize>(geometry: Geometry, tags: [Tag; N]) -> Self {
        Self { geometry, tags: tags.into() }
    }

    /// Returns the value of a tag, if it is a text.
    #[cfg(test)]
    pub fn text(&self, key: &str) -> Option<&str> {
        self.tags.iter().find_map(|tag| match &tag.value {
            Value::Text(text) if tag.key == key => Some(text.as_str()),
            _ => None,
        })
    }

    /// Returns the value of a tag, if it is a number.
    #[cfg(test)]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.tags.iter().find_map(|tag| match tag.value {
            Value::Number(number) if tag.key == key => Some(number),
            _ => None,
        })
    }
}

/// A number in hundredths, without zeros at its end.
fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn position(DVec2 { x, y }: DVec2) -> String {
    format!("[{},{}]", hundredths(ORIGIN.x + x), hundredths(ORIGIN.y + y))
}

fn positions(places: &[DVec2]) -> String {
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
            let closed: Vec<DVec2> = ring.iter().chain(ring.first()).copied().collect();
            ("Polygon", format!("[[{}]]", positions(&closed)))
        }
    };

    let mut tags = String::new();
    for (k, Tag { key, value }) in feature.tags.iter().enumerate() {
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
