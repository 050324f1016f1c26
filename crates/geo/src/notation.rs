//! Codes of reference systems, as standards and programs write them.
//!
//! ```text
//! EPSG:32633   ESRI:102100   32633                        as programs do
//! EPSG:4326+5773   EPSG:4326+EPSG:5773                    a horizontal and a vertical system
//! urn:ogc:def:crs:EPSG::32633   …:EPSG:9.8:32633          OGC 07-092r1
//! urn:ogc:def:crs,crs:EPSG::4326,crs:EPSG::5773           the same of two
//! http://www.opengis.net/def/crs/EPSG/0/32633             OGC 09-048r5
//! http://www.opengis.net/def/crs-compound?1=…&2=…         the same of two
//! OGC:CRS84, CRS84   WGS84   NAD83   NAD27                degrees, longitudes first
//! ```

/// A code, or the part of a text that should be one.
pub(super) type Code = Result<u32, String>;

/// The codes of a text, one of each system; `None` for texts that are none of the above.
pub(super) fn codes(text: &str) -> Option<Vec<Code>> {
    let lower = text.trim().to_ascii_lowercase();
    for scheme in ["urn:ogc:def:crs,", "urn:x-ogc:def:crs,"] {
        if let Some(rest) = lower.strip_prefix(scheme) {
            return rest.split(',').map(|part| of_registry(part.trim().strip_prefix("crs:")?, ':')).collect();
        }
    }

    for scheme in ["urn:ogc:def:crs:", "urn:x-ogc:def:crs:"] {
        if let Some(rest) = lower.strip_prefix(scheme) {
            return Some(vec![of_registry(rest, ':')?]);
        }
    }

    if let Some(rest) = of_url(&lower, "def/crs-compound?") {
        let url = |part: &str| of_registry(of_url(part.split_once('=')?.1, "def/crs/")?, '/');
        return rest.split('&').map(url).collect();
    }
    if let Some(rest) = of_url(&lower, "def/crs/") {
        return Some(vec![of_registry(rest, '/')?]);
    }
    if let Some(rest) = of_url(&lower, "gml/srs/epsg.xml#") {
        return Some(vec![number(rest)]);
    }

    short(&lower)
}

/// Returns the text after a prefix of OGC's names on the web.
fn of_url<'t>(text: &'t str, prefix: &str) -> Option<&'t str> {
    let rest = text.strip_prefix("http://").or_else(|| text.strip_prefix("https://"))?;
    rest.strip_prefix("www.opengis.net/")?.strip_prefix(prefix)
}

/// `EPSG::32633`, `EPSG/0/32633`, `OGC:1.3:CRS84`.
fn of_registry(text: &str, separator: char) -> Option<Code> {
    let mut parts = text.trim_end_matches('/').split(separator);
    let (authority, _version, code) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() {
        return None;
    }
    match authority {
        "epsg" | "esri" => Some(number(code)),
        "ogc" | "crs" => degrees(code).map(Ok),
        _ => None,
    }
}

/// `EPSG:32633`, `ESRI:102100+EPSG:5773`, `32633`, `CRS84`.
fn short(text: &str) -> Option<Vec<Code>> {
    if let Some(code) = degrees(text.strip_prefix("ogc:").unwrap_or(text)) {
        return Some(vec![Ok(code)]);
    }
    let without = |part: &str| -> Option<String> {
        let rest = part.strip_prefix("epsg:").or_else(|| part.strip_prefix("esri:"))?;
        Some(rest.to_owned())
    };
    let is_number = text.starts_with(|c: char| c.is_ascii_digit()) && !text.contains(['/', '.', '\\']);
    if without(text).is_none() && !is_number {
        return None;
    }
    Some(
        text.split('+')
            .map(str::trim)
            .map(|part| number(&without(part).unwrap_or(part.to_owned())))
            .collect(),
    )
}

fn number(text: &str) -> Code {
    text.trim().parse().map_err(|_| text.trim().to_owned())
}

/// Systems that are known by a name of their own.
fn degrees(name: &str) -> Option<u32> {
    Some(match name {
        "crs84" | "wgs84" | "wgs 84" => 4326,
        "crs84h" => 4979,
        "crs83" | "nad83" => 4269,
        "crs27" | "nad27" => 4267,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standards_write_codes_in_many_ways() {
        let table: [(&str, &[u32]); 22] = [
            ("EPSG:32633", &[32_633]),
            (" epsg:32633 ", &[32_633]),
            ("32633", &[32_633]),
            ("ESRI:102100", &[102_100]),
            ("EPSG:4326+5773", &[4326, 5773]),
            ("EPSG:4326+EPSG:5773", &[4326, 5773]),
            ("4326+5773", &[4326, 5773]),
            ("EPSG:32632 + ESRI:105703", &[32_632, 105_703]),
            ("urn:ogc:def:crs:EPSG::32633", &[32_633]),
            ("urn:ogc:def:crs:EPSG:9.8.1:32633", &[32_633]),
            ("urn:x-ogc:def:crs:EPSG::32633", &[32_633]),
            ("urn:ogc:def:crs:ESRI::102100", &[102_100]),
            ("urn:ogc:def:crs,crs:EPSG::4326,crs:EPSG::5773", &[4326, 5773]),
            ("http://www.opengis.net/def/crs/EPSG/0/32633", &[32_633]),
            ("https://www.opengis.net/def/crs/EPSG/9.9.1/32633/", &[32_633]),
            (
                "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/4326&2=http://www.opengis.net/def/crs/EPSG/0/5773",
                &[4326, 5773],
            ),
            ("http://www.opengis.net/gml/srs/epsg.xml#4326", &[4326]),
            ("urn:ogc:def:crs:OGC:1.3:CRS84", &[4326]),
            ("http://www.opengis.net/def/crs/OGC/0/CRS84h", &[4979]),
            ("OGC:CRS84", &[4326]),
            ("WGS84", &[4326]),
            ("NAD27", &[4267]),
        ];

        for (text, expected) in table {
            let found = codes(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(found.into_iter().collect::<Result<Vec<_>, _>>().as_deref(), Ok(expected), "{text}");
        }

        for text in [
            "IGNF:LAMB93",
            "a.prj",
            "12/a.prj",
            "urn:ogc:def:crs:IAU::30100",
            "+proj=longlat",
            "GEOGCS[]",
            "",
        ] {
            assert_eq!(codes(text), None, "{text}");
        }

        assert_eq!(codes("EPSG:32632@2010.0"), Some(vec![Err("32632@2010.0".to_owned())]));
        assert_eq!(codes("EPSG:"), Some(vec![Err(String::new())]));
    }
}
