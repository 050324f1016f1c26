//! Reference systems as other programs read them: geo keys of a GeoTIFF, and the well-known text of a `.prj` file.
//!
//! Both are made from the PROJ definition. A system with an EPSG code has that as its geo key. Names are those of Esri's well-known text, which all
//! readers know; GeoTIFF keys after OGC GeoTIFF 1.1, codes of methods after GeoTIFF 1.0 §6.3.3.3. What cannot be said in
//! these words is left out.

use std::fmt::Write;

use super::Crs;
use super::definition::Definition;

/// Geo keys and their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WrittenKeys {
    /// `GeoKeyDirectoryTag`: four numbers for the head and for each key.
    pub directory: Vec<u16>,
    /// `GeoDoubleParamsTag`.
    pub doubles: Vec<f64>,
    /// `GeoAsciiParamsTag`.
    pub text: String,
}

/// A datum and its ellipsoid.
#[derive(Clone, Copy)]
struct Datum {
    /// Name at Esri, without `GCS_` and `D_`.
    name: &'static str,
    ellipsoid: &'static str,
    axis: f64,
    inverse_flattening: f64,
    /// EPSG code of the geographic system, if it is known; and of the ellipsoid.
    code: Option<u16>,
    ellipsoid_code: u16,
}

const fn datum(
    name: &'static str,
    ellipsoid: &'static str,
    [axis, inverse_flattening]: [f64; 2],
    code: Option<u16>,
    ellipsoid_code: u16,
) -> Datum {
    Datum { name, ellipsoid, axis, inverse_flattening, code, ellipsoid_code }
}

const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];
const GRS80: [f64; 2] = [6_378_137.0, 298.257_222_101];
const CLARKE_1866: [f64; 2] = [6_378_206.4, 294.978_698_2];

/// Datums by PROJ's names of datums and ellipsoids.
const DATUMS: [(&str, Datum); 10] = [
    ("WGS84", datum("WGS_1984", "WGS_1984", WGS84, Some(4326), 7030)),
    ("NAD83", datum("North_American_1983", "GRS_1980", GRS80, Some(4269), 7019)),
    ("GRS80", datum("GRS_1980", "GRS_1980", GRS80, None, 7019)),
    ("clrk66", datum("North_American_1927", "Clarke_1866", CLARKE_1866, Some(4267), 7008)),
    ("OSGB36", datum("OSGB_1936", "Airy_1830", [6_377_563.396, 299.324_964_6], Some(4277), 7001)),
    ("airy", datum("OSGB_1936", "Airy_1830", [6_377_563.396, 299.324_964_6], Some(4277), 7001)),
    ("bessel", datum("Bessel_1841", "Bessel_1841", [6_377_397.155, 299.152_812_8], None, 7004)),
    ("intl", datum("International_1924", "International_1924", [6_378_388.0, 297.0], None, 7022)),
    ("krass", datum("Krasovsky_1940", "Krasovsky_1940", [6_378_245.0, 298.3], None, 7024)),
    ("nzgd49", datum("New_Zealand_1949", "International_1924", [6_378_388.0, 297.0], Some(4272), 7022)),
];

/// A projection: Esri's name, the code of its method, and its parameters.
struct WrittenProjected {
    name: &'static str,
    method: u16,
    /// Esri's name, geo key, value in degrees, metres or 1.
    parameters: Vec<(&'static str, u16, f64)>,
}

impl Crs {
    /// Well-known text as of a `.prj` file; `None` for local metres, and for what it has no words for.
    pub fn to_esri_wkt(&self) -> Option<String> {
        let definition = self.definition()?;
        let datum = datum_of(definition)?;
        let Datum { name, ellipsoid, axis, inverse_flattening, .. } = datum;
        let geographic = format!(
            "GEOGCS[\"GCS_{name}\",DATUM[\"D_{name}\",SPHEROID[\"{ellipsoid}\",{axis:?},{inverse_flattening:?}]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]]"
        );
        if definition.is_geographic() {
            return Some(geographic);
        }

        let WrittenProjected { name: method, parameters, .. } = projected(definition)?;
        // A system without a name is called by its definition, which is no name.
        let name = Some(self.name()).filter(|name| !name.starts_with('+')).unwrap_or("Unnamed");
        let title: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let mut text = format!("PROJCS[\"{title}\",{geographic},PROJECTION[\"{method}\"]");
        for (name, _, value) in parameters {
            // Writing to a String cannot fail.
            let _ = write!(text, ",PARAMETER[\"{name}\",{value:?}]");
        }

        text += ",UNIT[\"Meter\",1.0]]";
        Some(text)
    }

    /// Geo keys for pixels that are areas; `None` for local metres, and for what they have no words for.
    pub fn to_geo_keys(&self) -> Option<WrittenKeys> {
        let definition = self.definition()?;
        let is_geographic = definition.is_geographic();
        let mut keys = KeyEntries::default();
        // Model type: 1 projected, 2 geographic. Raster type: 1, pixels are areas.
        keys.short(1024, if is_geographic { 2 } else { 1 });
        keys.short(1025, 1);
        keys.ascii(1026, self.name());
        let code = self.epsg().and_then(|code| u16::try_from(code).ok());
        match (code, is_geographic) {
            (Some(code), true) => keys.short(2048, code),
            (Some(code), false) => {
                keys.short(3072, code);
                keys.short(3076, METRE);
            }
            (None, _) => keys.by_parameters(definition)?,
        }
        Some(keys.written())
    }
}

const USER_DEFINED: u16 = 32_767;
const METRE: u16 = 9001;
const DEGREE: u16 = 9102;

/// Geo keys in rising order: key, tag (0: the value itself), count, value or offset.
#[derive(Default)]
struct KeyEntries {
    entries: Vec<[u16; 4]>,
    doubles: Vec<f64>,
    text: String,
}

impl KeyEntries {
    fn short(&mut self, key: u16, value: u16) {
        self.entries.push([key, 0, 1, value]);
    }

    fn double(&mut self, key: u16, value: f64) {
        self.entries.push([key, 34_736, 1, self.doubles.len() as u16]);
        self.doubles.push(value);
    }

    fn ascii(&mut self, key: u16, text: &str) {
        // A bar ends a text.
        let text: String = text
            .chars()
            .filter(|c| c.is_ascii_graphic() || *c == ' ')
            .filter(|c| *c != '|')
            .take(200)
            .collect();
        self.entries.push([key, 34_737, text.len() as u16 + 1, self.text.len() as u16]);
        self.text += &text;
        self.text.push('|');
    }

    fn by_parameters(&mut self, definition: &Definition) -> Option<()> {
        let datum = datum_of(definition)?;
        match datum.code {
            Some(code) => self.short(2048, code),
            None => {
                self.short(2048, USER_DEFINED);
                self.short(2050, USER_DEFINED);
                self.short(2056, datum.ellipsoid_code);
            }
        }

        self.short(2054, DEGREE);
        if datum.code.is_none() {
            self.double(2057, datum.axis);
            // A sphere has two equal axes.
            match datum.inverse_flattening {
                0.0 => self.double(2058, datum.axis),
                inverse => self.double(2059, inverse),
            }
            self.entries.sort_by_key(|entry| entry[0]);
        }

        if definition.is_geographic() {
            return Some(());
        }

        let WrittenProjected { method, mut parameters, .. } = projected(definition)?;
        for (key, value) in [(3072, USER_DEFINED), (3074, USER_DEFINED), (3075, method), (3076, METRE)] {
            self.short(key, value);
        }

        parameters.sort_by_key(|(_, key, _)| *key);
        parameters.into_iter().for_each(|(_, key, value)| self.double(key, value));
        Some(())
    }

    fn written(self) -> WrittenKeys {
        let head = [1, 1, 0, self.entries.len() as u16];
        let directory = head.into_iter().chain(self.entries.into_iter().flatten()).collect();
        WrittenKeys { directory, doubles: self.doubles, text: self.text }
    }
}

/// Largest relative difference of axes, and of inverse flattenings, that mean the same ellipsoid.
const SAME: f64 = 1e-9;

fn datum_of(definition: &Definition) -> Option<Datum> {
    let value = |key: &str| definition.get(key).and_then(|text| text.parse::<f64>().ok());
    if definition.get("pm").is_some_and(|meridian| meridian != "greenwich" && meridian != "0") {
        return None;
    }
    let Some(axis) = value("a").or_else(|| value("R")).filter(|axis| *axis > 0.0) else {
        let name = definition.get("datum").or(definition.get("ellps")).unwrap_or("GRS80");
        return DATUMS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, datum)| *datum);
    };

    // A sphere is said to have an inverse flattening of 0.
    let inverse_flattening = match (value("rf"), value("b")) {
        (Some(inverse), _) => inverse,
        (None, Some(minor)) if minor < axis => axis / (axis - minor),
        _ => 0.0,
    };
    let near = |one: f64, other: f64| (one - other).abs() <= SAME * one.abs().max(1.0);
    let known = DATUMS.iter().map(|(_, datum)| datum).find(|datum| {
        // Ellipsoids alone: the same one lies under several datums.
        datum.code.is_none() && near(datum.axis, axis) && near(datum.inverse_flattening, inverse_flattening)
    });
    let own = datum("Unknown", "Unknown", [axis, inverse_flattening], None, USER_DEFINED);

    Some(known.copied().unwrap_or(own))
}

fn projected(definition: &Definition) -> Option<WrittenProjected> {
    let value = |key: &str, default: f64| match definition.get(key) {
        Some(text) => text.parse::<f64>().ok().filter(|value| value.is_finite()),
        None => Some(default),
    };
    let scale = match definition.get("k") {
        Some(_) => value("k", 1.0)?,
        None => value("k_0", 1.0)?,
    };
    if definition.get("units").is_some_and(|unit| unit != "m") || value("to_meter", 1.0)? != 1.0 {
        return None;
    }

    let (x, y) = (value("x_0", 0.0)?, value("y_0", 0.0)?);
    let (latitude, longitude) = (value("lat_0", 0.0)?, value("lon_0", 0.0)?);
    let false_origin = [("False_Easting", 3082, x), ("False_Northing", 3083, y)];
    let origin = [("Central_Meridian", 3080, longitude), ("Latitude_Of_Origin", 3081, latitude)];
    let with_scale = |origin: [(&'static str, u16, f64); 2], scale: f64| {
        [false_origin.as_slice(), &origin, &[("Scale_Factor", 3092, scale)]].concat()
    };

    let false_point = [
        ("False_Easting", 3086, x),
        ("False_Northing", 3087, y),
        ("Central_Meridian", 3084, longitude),
        ("Latitude_Of_Origin", 3085, latitude),
    ];

    let conic = |name, method, begin: &[(&'static str, u16, f64)]| -> Option<WrittenProjected> {
        let first = value("lat_1", latitude)?;
        let parallels =
            [("Standard_Parallel_1", 3078, first), ("Standard_Parallel_2", 3079, value("lat_2", first)?)];
        // A scale other than 1 belongs to one parallel, for which the keys have another method.
        (scale == 1.0).then(|| WrittenProjected { name, method, parameters: [begin, &parallels].concat() })
    };

    let pole = [("Central_Meridian", 3095, longitude), ("Latitude_Of_Origin", 3081, latitude)];
    let centre = [("Central_Meridian", 3088, longitude), ("Latitude_Of_Origin", 3089, latitude)];
    Some(match definition.get("proj")? {
        "utm" => {
            let zone = value("zone", 0.0)?;
            let northing = if definition.has("south") { 10_000_000.0 } else { 0.0 };
            let parameters = vec![
                ("False_Easting", 3082, 500_000.0),
                ("False_Northing", 3083, northing),
                ("Central_Meridian", 3080, 6.0 * zone - 183.0),
                ("Latitude_Of_Origin", 3081, 0.0),
                ("Scale_Factor", 3092, 0.9996),
            ];
            WrittenProjected { name: "Transverse_Mercator", method: 1, parameters }
        }
        "tmerc" | "etmerc" => {
            WrittenProjected { name: "Transverse_Mercator", method: 1, parameters: with_scale(origin, scale) }
        }
        "lcc" => conic("Lambert_Conformal_Conic", 8, &false_point)?,
        "aea" => conic("Albers", 11, &[false_origin, origin].concat())?,
        "laea" => WrittenProjected {
            name: "Lambert_Azimuthal_Equal_Area",
            method: 10,
            parameters: [false_origin.as_slice(), &centre].concat(),
        },
        "stere" if latitude.abs() == 90.0 && definition.get("lat_ts").is_none() => {
            WrittenProjected { name: "Stereographic", method: 15, parameters: with_scale(pole, scale) }
        }
        "sterea" => WrittenProjected {
            name: "Double_Stereographic",
            method: 16,
            parameters: with_scale(centre, scale),
        },
        "merc" if definition.get("lat_ts").is_none() && scale == 1.0 => WrittenProjected {
            name: "Mercator",
            method: 7,
            parameters: [false_origin.as_slice(), &origin[..1], &[("Standard_Parallel_1", 3078, 0.0)]]
                .concat(),
        },
        "eqc" if latitude == 0.0 => WrittenProjected {
            name: "Equidistant_Cylindrical",
            method: 17,
            parameters: [
                false_origin.as_slice(),
                &origin[..1],
                &[("Standard_Parallel_1", 3078, value("lat_ts", 0.0)?)],
            ]
            .concat(),
        },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse_geokeys;

    #[test]
    fn what_is_written_is_read_as_the_same_system() {
        let codes = [4326, 32633, 32733, 25832, 26913, 3035, 2154, 5070, 27700, 28992, 2193, 31370];
        for code in codes {
            let crs = Crs::from_epsg(code).unwrap();
            let Some(text) = crs.to_esri_wkt() else {
                // Of systems whose ellipsoid is known; grids and odd ones have none.
                assert!(![4326, 32633, 32733, 25832, 26913, 3035, 2154, 5070].contains(&code), "{code}");
                continue;
            };

            let read = Crs::from_wkt(&text).unwrap();
            let bare = |crs: &Crs| crs.proj().map(|proj| proj.split(" +towgs84").next().map(str::to_owned));

            // Shifts to WGS 84 are no part of these words.
            let is_shifted =
                crs.proj().is_some_and(|proj| proj.contains("towgs84") && !proj.contains("towgs84=0,0,0"));

            assert!(
                is_shifted || read.is_equivalent(&crs),
                "{code}: {text}: {:?} {:?}",
                bare(&read),
                bare(&crs)
            );
            let keys = crs.to_geo_keys().unwrap();
            let read = parse_geokeys(&keys.directory, &keys.doubles, &keys.text).unwrap();
            assert_eq!(read.crs.and_then(|crs| crs.epsg()), Some(code));

            // The same by its parameters.
            let own = Crs::from_proj(crs.proj().unwrap(), "own").unwrap();
            let keys = own.to_geo_keys().unwrap();
            let read = parse_geokeys(&keys.directory, &keys.doubles, &keys.text).unwrap();
            let read = read.crs.unwrap();

            assert!(
                is_shifted || read.is_equivalent(&crs),
                "{code}: {keys:?}: {:?} {:?}",
                read.proj(),
                crs.proj()
            );
        }

        assert_eq!((Crs::local().to_esri_wkt(), Crs::local().to_geo_keys()), (None, None));
        let stated = "+proj=laea +lat_0=52 +lon_0=10 +x_0=4321000 +y_0=3210000 +a=6378137 +rf=298.257222101 +towgs84=0,0,0";
        let stated = Crs::from_proj(stated, "stated").unwrap();
        assert!(Crs::from_wkt(&stated.to_esri_wkt().unwrap()).unwrap().is_equivalent(&stated));
        let odd = Crs::from_proj(
            "+proj=omerc +lat_0=4 +lonc=115 +alpha=53 +k=1 +x_0=0 +y_0=0 +ellps=evrstSS",
            "odd",
        );
        assert!(
            odd.is_err() || odd.is_ok_and(|odd| odd.to_esri_wkt().is_none() && odd.to_geo_keys().is_none())
        );
    }
}
