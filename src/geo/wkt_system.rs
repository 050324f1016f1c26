//! Well-known text: what a tree means.
//!
//! ```text
//! compound   → its horizontal and its vertical part
//! bound      → its source, with the shift of its transformation
//! an EPSG code at the outermost node that is known here → that
//! EXTENSION["PROJ4", …]                                 → that
//! projected  → method + parameters + geodetic part + unit
//! geographic → geodetic part
//! geodetic part: shift given, else EPSG code, else name of the datum, else ellipsoid alone
//! ```

use super::crs::{Crs, shortened};
use super::datum::{VerticalCrs, VerticalDatum};
use super::definition::Definition;
use super::projection::{CONVERT, Parameters, proj_terms};
use super::wkt::{Item, Node, parse};
use super::wkt_names::{Kind, datum_code, method, plain, term};
use super::{epsg, units};
use crate::error::{Error, Result};

const PROJECTED: [&str; 3] = ["PROJCS", "PROJCRS", "PROJECTEDCRS"];
const GEOGRAPHIC: [&str; 8] = [
    "GEOGCS",
    "GEOGCRS",
    "GEOGRAPHICCRS",
    "GEODCRS",
    "GEODETICCRS",
    "BASEGEOGCRS",
    "BASEGEODCRS",
    "GEODETICCRS",
];
const VERTICAL: [&str; 4] = ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"];
const REPAIR: &str = "write a sound one with: gdalsrsinfo -o wkt1 EPSG:CODE";

impl Crs {
    /// From WKT 1 (OGC or Esri dialect) or WKT 2; of a compound system the horizontal part.
    pub fn from_wkt(text: &str) -> Result<Self> {
        Ok(Self::with_vertical_from_wkt(text)?.0)
    }

    /// As [`Crs::from_wkt`], with the system of the heights where the text names one.
    pub fn with_vertical_from_wkt(text: &str) -> Result<(Self, Option<VerticalCrs>)> {
        read(text).map_err(Error::Configuration)
    }
}

/// The system that a text names. The error is a sentence without a place.
pub(super) fn read(text: &str) -> Result<(Crs, Option<VerticalCrs>), String> {
    system(&parse(text)?)
}

/// The system of a tree.
fn system(root: &Node) -> Result<(Crs, Option<VerticalCrs>), String> {
    match root.word.as_str() {
        "COMPD_CS" | "COMPOUNDCRS" => {
            let horizontal = root.items.iter().find_map(|item| match item {
                Item::Node(node) if is_horizontal(&node.word) => Some(node),
                _ => None,
            });
            let horizontal = horizontal.ok_or_else(|| format!("the compound WKT has no horizontal part; {REPAIR}"))?;
            let (crs, own) = system(horizontal)?;
            Ok((crs, root.child(&VERTICAL).and_then(vertical).or(own)))
        }
        "BOUNDCRS" => bound(root),
        word if PROJECTED.contains(&word) => Ok((projected(root)?, root.child(&VERTICAL).and_then(vertical))),
        word if GEOGRAPHIC.contains(&word) => {
            Ok((geographic(root)?, root.child(&VERTICAL).and_then(vertical).or_else(|| third_axis(root))))
        }
        "LOCAL_CS" | "ENGCRS" | "ENGINEERINGCRS" => Err(format!(
            "the WKT '{}' is a local one and names no reference system; give the right one with --crs or, for plain metres, --local",
            shortened(root.name())
        )),
        "GEOCCS" => Err(format!("geocentric coordinates are no map; {CONVERT}")),
        word if VERTICAL.contains(&word) => {
            Err("the WKT measures only heights; give the horizontal system with --crs, and the heights as --src-vdatum".into())
        }
        word => Err(format!("the WKT begins with '{}', which is not read; {REPAIR}", shortened(word))),
    }
}

fn is_horizontal(word: &str) -> bool {
    PROJECTED.contains(&word) || GEOGRAPHIC.contains(&word) || matches!(word, "BOUNDCRS" | "LOCAL_CS")
}

/// By the code or the PROJ string that the node carries.
fn ready_made(node: &Node) -> Option<Crs> {
    let esri = || node.code("ESRI").filter(|code| epsg::current(*code) != *code);
    if let Some(code) = node.code("EPSG").or_else(esri)
        && let Ok(crs) = Crs::by_code(code)
    {
        return Some(crs);
    }
    let extension = node.children(&["EXTENSION"]).find(|node| node.name().eq_ignore_ascii_case("PROJ4"))?;
    match extension.items.get(1)? {
        Item::Text(text) => Crs::by_definition(text, &shortened(node.name())).ok(),
        _ => None,
    }
}

fn geographic(node: &Node) -> Result<Crs, String> {
    if let Some(crs) = ready_made(node).filter(Crs::is_geographic) {
        return Ok(crs);
    }
    let cartesian = node.child(&["CS"]).is_some_and(
        |cs| matches!(cs.items.first(), Some(Item::Word(kind)) if kind.eq_ignore_ascii_case("cartesian")),
    );
    if cartesian {
        return Err(format!("geocentric coordinates are no map; {CONVERT}"));
    }
    let unit = angular_unit(node);
    if !units::same(unit, 1.0) {
        return Err(format!(
            "the WKT gives coordinates in units of {unit} degrees, and only degrees are read; {CONVERT}"
        ));
    }
    let definition = format!("+proj=longlat {}", geodetic_terms(node)?);
    Ok(Crs::by_definition(&definition, &definition)?.named(node.name()))
}

fn projected(node: &Node) -> Result<Crs, String> {
    if let Some(crs) = ready_made(node).filter(|crs| !crs.is_geographic()) {
        return Ok(crs);
    }
    check_axes(node)?;
    let base = node.child(&GEOGRAPHIC).ok_or_else(|| format!("the WKT has no geographic part; {REPAIR}"))?;
    let conversion = node.child(&["CONVERSION"]).unwrap_or(node);
    let named = conversion.child(&["PROJECTION", "METHOD"]);
    let named = named.ok_or_else(|| format!("the WKT has no projection; {REPAIR}"))?;
    let method = method(named.name())
        .ok_or_else(|| format!("the projection '{}' is not read; {CONVERT}", shortened(named.name())))?;
    let unit = linear_unit(node);
    let parameters = parameters(conversion, angular_unit(base), unit)?;
    let text = format!("{} {}", proj_terms(method, &parameters)?, geodetic_terms(base)?);
    let mut definition = Definition::parse(&text)?;
    if unit != 1.0 {
        definition.set_metres_per_unit(unit);
    }
    Ok(Crs::by_definition(&definition.to_string(), &text)?.named(node.name()))
}

/// Refuses axes that run west (and with it south). South alone is usual at the poles, where both axes leave the centre.
fn check_axes(node: &Node) -> Result<(), String> {
    let west = node.children(&["AXIS"]).find(|axis| {
        axis.items.iter().any(|item| matches!(item, Item::Word(word) if word.eq_ignore_ascii_case("west")))
    });
    match west {
        None => Ok(()),
        Some(axis) => Err(format!(
            "the axis '{}' runs west, and only axes to the east and north are read; {CONVERT}",
            shortened(axis.name())
        )),
    }
}

/// Parameters in degrees and metres. `angle`: degrees per unit, `length`: metres per unit where a parameter does not say it.
fn parameters(node: &Node, angle: f64, length: f64) -> Result<Parameters, String> {
    let mut parameters = Parameters::default();
    for parameter in node.children(&["PARAMETER"]) {
        let value = parameter.numbers().next();
        let value = value.ok_or_else(|| {
            format!("the WKT gives no number for the parameter '{}'; {REPAIR}", shortened(parameter.name()))
        })?;
        let own = |words: &[&str]| {
            let node = parameter
                .children(&["UNIT", "ANGLEUNIT", "LENGTHUNIT", "SCALEUNIT"])
                .find(|unit| words.contains(&unit.word.as_str()));
            node.and_then(|node| node.numbers().next())
        };
        match term(parameter.name()) {
            Some((Some(term), Kind::Angle)) => {
                parameters.set(term, value * own(&["ANGLEUNIT", "UNIT"]).map_or(angle, degrees));
            }
            Some((Some(term), Kind::Length)) => {
                parameters.set(term, value * own(&["LENGTHUNIT", "UNIT"]).unwrap_or(length));
            }
            Some((Some(term), Kind::Ratio)) => {
                parameters.set(term, value * own(&["SCALEUNIT", "UNIT"]).unwrap_or(1.0));
            }
            // Terms that are only read where they say nothing.
            Some((None, kind)) if value == if matches!(kind, Kind::Ratio) { 1.0 } else { 0.0 } => {}
            _ => {
                return Err(format!(
                    "the parameter '{}' = {value} of the projection is not read; {CONVERT}",
                    shortened(parameter.name())
                ));
            }
        }
    }
    Ok(parameters)
}

/// PROJ's terms of datum, ellipsoid and prime meridian of a geographic node.
fn geodetic_terms(node: &Node) -> Result<String, String> {
    let datum = node.child(&["DATUM", "GEODETICDATUM", "TRF", "ENSEMBLE"]);
    let datum = datum.ok_or_else(|| format!("the WKT has no datum; {REPAIR}"))?;
    let shift: Vec<f64> = datum.child(&["TOWGS84"]).map(|node| node.numbers().collect()).unwrap_or_default();
    let ellipsoid = datum.child(&["SPHEROID", "ELLIPSOID"]);
    if !matches!(shift.len(), 3 | 7) {
        let code = node.code("EPSG");
        let by_datum =
            || datum.code("EPSG").filter(|code| (6001..7000).contains(code)).map(|code| code - 2000);
        let codes = [code, by_datum(), datum_code(datum.name())];
        if let Some(definition) = codes.into_iter().flatten().find_map(|code| epsg::definition(code).ok()) {
            return Ok(definition.geodetic_part());
        }
    }
    let ellipsoid =
        ellipsoid.ok_or_else(|| format!("the WKT has neither a known datum nor an ellipsoid; {REPAIR}"))?;
    let mut numbers = ellipsoid.numbers();
    let (Some(axis), Some(flattening)) = (numbers.next(), numbers.next()) else {
        return Err(format!("the ellipsoid of the WKT lacks its axis or flattening; {REPAIR}"));
    };
    let axis =
        axis * ellipsoid.child(&["LENGTHUNIT", "UNIT"]).and_then(|unit| unit.numbers().next()).unwrap_or(1.0);
    let mut terms =
        if flattening == 0.0 { format!("+R={axis}") } else { format!("+a={axis} +rf={flattening}") };
    if matches!(shift.len(), 3 | 7) {
        let shift: Vec<String> = shift.iter().map(f64::to_string).collect();
        terms = format!("{terms} +towgs84={}", shift.join(","));
    }
    let meridian = node.child(&["PRIMEM", "PRIMEMERIDIAN"]);
    let longitude = meridian.and_then(|node| node.numbers().next()).filter(|longitude| *longitude != 0.0);
    if let Some(longitude) = longitude {
        let unit = meridian
            .and_then(|node| node.child(&["ANGLEUNIT", "UNIT"])?.numbers().next())
            .map_or(1.0, degrees);
        terms = format!("{terms} +pm={}", longitude * unit);
    }
    Ok(terms)
}

/// A system together with its transformation to WGS 84.
fn bound(root: &Node) -> Result<(Crs, Option<VerticalCrs>), String> {
    let source = root.child(&["SOURCECRS"]).and_then(|source| {
        source.items.iter().find_map(|item| match item {
            Item::Node(node) => Some(node),
            _ => None,
        })
    });
    let source = source.ok_or_else(|| format!("the bound WKT has no source; {REPAIR}"))?;
    // One bound within another is no sound text, and must not nest without end.
    if source.word == "BOUNDCRS" {
        return Err(format!("the bound WKT holds another; {REPAIR}"));
    }
    let (crs, vertical) = system(source)?;
    let definition = crs
        .definition()
        .filter(|definition| definition.get("towgs84").is_none() && definition.get("datum").is_none());
    let shift = root.child(&["ABRIDGEDTRANSFORMATION"]).and_then(translation);
    match (definition, shift) {
        (Some(definition), Some(shift)) => {
            let text = format!("{definition} +towgs84={shift}");
            Ok((Crs::by_definition(&text, crs.name())?, vertical))
        }
        _ => Ok((crs, vertical)),
    }
}

/// `dx,dy,dz` of a geocentric translation. Other methods are left to the datum's name, as their parameters'
/// units and signs vary between writers.
fn translation(node: &Node) -> Option<String> {
    let method = plain(node.child(&["METHOD"])?.name());
    if !method.starts_with("geocentrictranslations") {
        return None;
    }
    let value = |name: &str| {
        let parameter = node.children(&["PARAMETER"]).find(|parameter| plain(parameter.name()) == name)?;
        parameter.numbers().next()
    };
    Some(format!(
        "{},{},{}",
        value("xaxistranslation")?,
        value("yaxistranslation")?,
        value("zaxistranslation")?
    ))
}

fn degrees(radians: f64) -> f64 {
    let degrees = radians.to_degrees();
    // Texts give 0.0174532925199433 for a degree; the digits that they drop must not shift anything.
    if units::same(degrees, 1.0) { 1.0 } else { degrees }
}

/// Degrees per unit of a geographic node.
fn angular_unit(node: &Node) -> f64 {
    unit_of(node, &["ANGLEUNIT", "UNIT"]).map_or(1.0, degrees)
}

/// Metres per unit of a projected or vertical node.
fn linear_unit(node: &Node) -> f64 {
    unit_of(node, &["LENGTHUNIT", "UNIT"]).unwrap_or(1.0)
}

/// Size of the unit of a node or of its axes, in metres or radians.
fn unit_of(node: &Node, words: &[&str]) -> Option<f64> {
    let size = |node: &Node| node.child(words)?.numbers().next().filter(|size| *size > 0.0);
    size(node).or_else(|| node.children(&["CS", "AXIS"]).find_map(size))
}

/// Heights above the ellipsoid as third coordinate of a geographic system.
fn third_axis(node: &Node) -> Option<VerticalCrs> {
    if let Some(vertical) = node.code("EPSG").and_then(epsg::vertical_part) {
        return Some(vertical);
    }
    let up = node.children(&["AXIS"]).find(|axis| {
        axis.items.iter().any(|item| matches!(item, Item::Word(word) if word.eq_ignore_ascii_case("up")))
    })?;
    Some(VerticalCrs { datum: VerticalDatum::Ellipsoid, metres_per_unit: linear_unit(up) })
}

/// A vertical node's meaning; `None` where the datum is not known here.
fn vertical(node: &Node) -> Option<VerticalCrs> {
    if let Some(known) = node.code("EPSG").and_then(epsg::vertical) {
        return Some(known);
    }
    // Esri writes depths as heights with direction −1.
    let direction = node.children(&["PARAMETER"]).find(|parameter| plain(parameter.name()) == "direction");
    if direction.and_then(|direction| direction.numbers().next()).is_some_and(|direction| direction < 0.0) {
        return None;
    }
    let datum = node.child(&["VERT_DATUM", "VDATUM", "VERTICALDATUM", "DATUM", "ENSEMBLE"])?;
    let name = plain(datum.name());
    let datum = if datum.word == "DATUM" {
        // Esri: a geodetic datum in a vertical system means heights above its ellipsoid.
        VerticalDatum::Ellipsoid
    } else if name.contains("navd88") || name.contains("northamericanverticaldatum1988") {
        VerticalDatum::Navd88
    } else if name.contains("egm96") || name.contains("egm1996") {
        VerticalDatum::Egm96
    } else if name.contains("egm2008") || name.contains("egm08") {
        VerticalDatum::Egm2008
    } else if name.contains("meansealevel") {
        VerticalDatum::Msl
    } else {
        return None;
    };
    Some(VerticalCrs { datum, metres_per_unit: linear_unit(node) })
}
