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
//! vertical   → unit and direction as stated; datum by code, else by name
//! ```

use super::crs::{Crs, entry, shortened};
use super::datum::{VerticalCrs, VerticalDatum};
use super::geodetic::{Geodetic, in_degrees, on_earth};
use super::local::LocalSystem;
use super::projection::{CONVERT, Method, Parameters, proj_terms};
use super::wkt::{Item, Node, VERTICAL, parse};
use super::wkt_names::{UnitKind, method, plain, term};
use super::{heights, registry, units};
use hedgehop_base::error::{Error, Result};

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
const REPAIR: &str = "write a sound one with: gdalsrsinfo -o wkt1 EPSG:CODE";

impl Crs {
    /// Reads WKT 1 (OGC or Esri dialect) or WKT 2; of a compound system the horizontal part.
    pub fn from_wkt(text: &str) -> Result<Self> {
        Ok(Self::with_vertical_from_wkt(text)?.0)
    }

    /// Reads as [`Crs::from_wkt`] does, with the system of the heights where the text names one.
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
            Ok((crs, stated_vertical(root)?.or(own)))
        }
        "BOUNDCRS" => bound(root),
        word if PROJECTED.contains(&word) => Ok((projected(root)?, stated_vertical(root)?)),
        word if GEOGRAPHIC.contains(&word) => {
            Ok((geographic(root)?, stated_vertical(root)?.or_else(|| third_axis(root))))
        }
        "LOCAL_CS" | "ENGCRS" | "ENGINEERINGCRS" => Err(format!(
            "the WKT is of {} and names no place on Earth; give the right one with --crs or, for plain metres, --local",
            LocalSystem::of_node(root).map_or_else(|| "a local system".to_owned(), |local| local.words())
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

/// Finds the system by the code or the PROJ string that the node carries; the error is why a known code cannot be used.
fn ready_made(node: &Node) -> Option<Result<Crs, String>> {
    let code = node.code("EPSG").or_else(|| node.code("ESRI"));
    if let Some(code) = code.filter(|code| entry(*code).is_some()) {
        return Some(Crs::by_code(code));
    }
    let extension = node.children(&["EXTENSION"]).find(|node| node.name().eq_ignore_ascii_case("PROJ4"))?;
    match extension.items.get(1)? {
        Item::Text(text) => Crs::by_definition(text, &shortened(node.name())).ok().map(Ok),
        _ => None,
    }
}

fn geographic(node: &Node) -> Result<Crs, String> {
    match ready_made(node) {
        Some(Ok(crs)) if crs.is_geographic() => return Ok(crs),
        Some(Err(reason)) => return Err(reason),
        _ => {}
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
    Ok(Crs::of("+proj=longlat", &geodetic(node, Role::Alone)?, node.name())?.named(node.name()))
}

fn projected(node: &Node) -> Result<Crs, String> {
    match ready_made(node) {
        Some(Ok(crs)) if !crs.is_geographic() => return Ok(crs),
        Some(Err(reason)) => return Err(reason),
        _ => {}
    }

    let base = node.child(&GEOGRAPHIC).ok_or_else(|| format!("the WKT has no geographic part; {REPAIR}"))?;
    let conversion = node.child(&["CONVERSION"]).unwrap_or(node);
    let named = conversion.child(&["PROJECTION", "METHOD"]);
    let named = named.ok_or_else(|| format!("the WKT has no projection; {REPAIR}"))?;
    let method = method(named.name())
        .ok_or_else(|| format!("the projection '{}' is not read; {CONVERT}", shortened(named.name())))?;
    let unit = linear_unit(node);
    let parameters = parameters(conversion, method, angular_unit(base), unit)?;

    let mut terms = proj_terms(method, &parameters)?;
    if unit != 1.0 {
        terms += &format!(" +to_meter={unit}");
    }
    if let Some(axis) = axes(node, method)? {
        terms += &format!(" +axis={axis}");
    }

    Ok(Crs::of(&terms, &geodetic(base, Role::OfMap(node.name()))?, node.name())?.named(node.name()))
}

/// Directions of the axes in PROJ's letters, where they are not to the east and north. Where both axes leave a pole,
/// they run north or south both, and their order is that of the projection.
fn axes(node: &Node, method: Method) -> Result<Option<&'static str>, String> {
    let direction = |axis: &Node| {
        let words = axis.items.iter().filter_map(|item| match item {
            Item::Word(word) => Some(word.to_ascii_lowercase()),
            _ => None,
        });
        words
            .into_iter()
            .find(|word| matches!(word.as_str(), "east" | "west" | "north" | "south" | "up" | "down"))
    };

    let directions: Vec<String> = node.children(&["AXIS"]).filter_map(direction).collect();
    let directions: Vec<&str> = directions.iter().map(String::as_str).collect();
    Ok(match (method, directions.as_slice()) {
        (Method::SouthOrientated, [] | ["west", "south"] | ["south", "west"]) => Some("wsu"),
        (Method::Krovak, [] | ["south", "west"]) => Some("swu"),
        // In the order of maps, as all readers take them: first to the east, then to the north.
        (_, [] | ["east", "north"] | ["north", "east"] | ["north", "north"] | ["south", "south"]) => None,
        (_, ["west", "south"]) => Some("wsu"),
        (_, ["south", "west"]) => Some("swu"),
        (_, ["west", "north"]) => Some("wnu"),
        (_, ["east", "south"]) => Some("esu"),
        (_, other) => {
            return Err(format!(
                "the axes of the WKT run {}, which is not read; {CONVERT}",
                other.join(" and ")
            ));
        }
    })
}

/// Parameters in degrees and metres. `angle`: degrees per unit, `length`: metres per unit where a parameter does not say it.
fn parameters(node: &Node, method: Method, angle: f64, length: f64) -> Result<Parameters, String> {
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
            Some((Some(term), UnitKind::Angle)) => {
                parameters.set(term, value * own(&["ANGLEUNIT", "UNIT"]).map_or(angle, degrees));
            }
            Some((Some(term), UnitKind::Length)) => {
                parameters.set(term, value * own(&["LENGTHUNIT", "UNIT"]).unwrap_or(length));
            }
            Some((Some(term), UnitKind::Ratio)) => {
                parameters.set(term, value * own(&["SCALEUNIT", "UNIT"]).unwrap_or(1.0));
            }
            // Esri's turn of Krovak's axes to the east and north is told by the method.
            Some((None, _)) if method == Method::KrovakNorth => {}
            // Terms that are only read where they say nothing.
            Some((None, kind)) if value == if matches!(kind, UnitKind::Ratio) { 1.0 } else { 0.0 } => {}
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

/// Part that a geographic node has in a text.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role<'t> {
    Alone,
    /// System of the map of this name.
    OfMap(&'t str),
}

/// The datum of a geographic node, with the meridian and the ellipsoid that the text states.
fn geodetic(node: &Node, role: Role<'_>) -> Result<Geodetic, String> {
    let datum = node.child(&["DATUM", "GEODETICDATUM", "TRF", "ENSEMBLE"]);
    let datum = datum.ok_or_else(|| format!("the WKT has no datum; {REPAIR}"))?;
    let terms = ellipsoid(datum)?.map(|ellipsoid| format!("{ellipsoid}{}", meridian(node)));

    let shift: Vec<f64> = datum.child(&["TOWGS84"]).map(|node| node.numbers().collect()).unwrap_or_default();
    if matches!(shift.len(), 3 | 7) {
        let terms = terms.ok_or_else(|| format!("the WKT has no ellipsoid; {REPAIR}"))?;
        let shift: Vec<String> = shift.iter().map(f64::to_string).collect();
        return Geodetic::stated(terms, Some(&shift.join(",")), datum.name());
    }

    let by_code = || node.code("EPSG").and_then(registry::geographic);
    let by_datum = || datum.code("EPSG").and_then(registry::geographic_of_datum);
    let by_name = || Geodetic::named(datum.name());
    let coded = by_code().or_else(by_datum);

    // What PROJ knows of a system by its name counts as by its code, of a map also where only its datum has a code.
    let own_name = match role {
        Role::Alone => Some(node.name()).filter(|_| coded.is_none()),
        Role::OfMap(name) => Some(name),
    };
    let named = || registry::named_system(&plain(own_name?), &by_name()?, flattening(terms.as_deref()?)?);

    // WKT 1 states no area, by which PROJ would leave shifts out.
    let has_no_area = role == Role::Alone && node.word == "GEOGCS";
    let of_datum = || by_name().map(|system| (system, system.text_order.filter(|_| has_no_area)));
    let known = named().or_else(|| coded.map(|system| (system, None))).or_else(of_datum);

    match (known, terms) {
        // The shifts belong to the datum, whatever meridian and unit the text counts in.
        (Some((system, order)), Some(terms)) => {
            let mut geodetic = Geodetic::of_map(&system, order)?;
            if !geodetic.terms.contains("+datum=") || terms.contains("+pm=") {
                on_earth(&terms, datum.name())?;
                geodetic.terms = terms;
            }
            Ok(geodetic)
        }
        (Some((system, order)), None) => {
            in_degrees(&system)?;
            Geodetic::of_map(&system, order)
        }
        (None, Some(terms)) => Geodetic::stated(terms, None, datum.name()),
        (None, None) => Err(format!("the WKT has neither a known datum nor an ellipsoid; {REPAIR}")),
    }
}

/// PROJ's terms of the ellipsoid that a datum states; `None` where it states none.
fn ellipsoid(datum: &Node) -> Result<Option<String>, String> {
    let Some(ellipsoid) = datum.child(&["SPHEROID", "ELLIPSOID"]) else { return Ok(None) };
    let mut numbers = ellipsoid.numbers();
    let (Some(axis), Some(flattening)) = (numbers.next(), numbers.next()) else {
        return Err(format!("the ellipsoid of the WKT lacks its axis or flattening; {REPAIR}"));
    };
    let unit = ellipsoid.child(&["LENGTHUNIT", "UNIT"]).and_then(|unit| unit.numbers().next()).unwrap_or(1.0);
    let axis = axis * unit;
    Ok(Some(if flattening == 0.0 { format!("+R={axis}") } else { format!("+a={axis} +rf={flattening}") }))
}

/// The inverse flattening among PROJ's terms of an ellipsoid.
fn flattening(terms: &str) -> Option<f64> {
    terms.split_whitespace().find_map(|word| word.strip_prefix("+rf="))?.parse().ok()
}

/// PROJ's term of the prime meridian, empty for Greenwich. WKT 1 counts it in the unit of the system, as OGC 01-009 has
/// it, but for Esri's and GDAL's texts, which count it in degrees whatever that unit is.
fn meridian(node: &Node) -> String {
    let meridian = node.child(&["PRIMEM", "PRIMEMERIDIAN"]);
    let longitude = meridian.and_then(|node| node.numbers().next()).filter(|longitude| *longitude != 0.0);
    let unit =
        meridian.and_then(|node| node.child(&["ANGLEUNIT", "UNIT"])?.numbers().next()).map_or(1.0, degrees);
    longitude.map_or_else(String::new, |longitude| format!(" +pm={}", longitude * unit))
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
    let is_unknown = crs
        .definition()
        .is_some_and(|definition| definition.get("towgs84").is_none() && definition.get("datum").is_none());
    let shift = root.child(&["ABRIDGEDTRANSFORMATION"]).and_then(translation);

    match (crs.definition().filter(|_| is_unknown), shift) {
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
    if let Some(vertical) = node.code("EPSG").or_else(|| node.code("ESRI")).and_then(heights::part_of) {
        return Some(vertical);
    }
    let up = node.children(&["AXIS"]).find(|axis| {
        axis.items.iter().any(|item| matches!(item, Item::Word(word) if word.eq_ignore_ascii_case("up")))
    })?;
    // Without a unit of its own the axis counts as the whole system says, which for degrees says nothing of lengths.
    let own = up.child(&["LENGTHUNIT", "UNIT"]).and_then(|unit| unit.numbers().next());
    Some(VerticalCrs { metres_per_unit: Some(own.map_or(1.0, units::exact)), ..VerticalCrs::ellipsoidal() })
}

/// The vertical part of a node, if it has one.
fn stated_vertical(node: &Node) -> Result<Option<VerticalCrs>, String> {
    // A bound vertical system says how its geoid lies; its source is what counts here.
    let bound = node.children(&["BOUNDCRS"]).find_map(|bound| bound.child(&["SOURCECRS"])?.child(&VERTICAL));
    node.child(&VERTICAL).or(bound).map(vertical).transpose()
}

/// A vertical node's meaning: by its code, else by its datum's name, its unit and its direction.
fn vertical(node: &Node) -> Result<VerticalCrs, String> {
    let datum = node.child(&["VERT_DATUM", "VDATUM", "VERTICALDATUM", "VRF", "DATUM", "ENSEMBLE"]);
    let unit = unit_of(node, &["LENGTHUNIT", "UNIT"]).map(units::exact);
    let coded = node.code("EPSG").or_else(|| node.code("ESRI")).and_then(heights::by_code);
    let is_down = is_depth(node);

    // Esri's offset of all heights.
    if let Some(shift) = parameter(node, "verticalshift").filter(|shift| *shift != 0.0) {
        return Err(format!(
            "the heights of '{}' are shifted by {shift} units, which is not read; take them from the values with gdal_calc.py, \
             and name the plain system with --elevation-crs",
            shortened(node.name())
        ));
    }
    if let Some(coded) = coded {
        let own = coded.metres_per_unit.unwrap_or(1.0);
        let metres = unit.map_or(own.abs(), f64::abs);
        let is_down = is_down.unwrap_or(own < 0.0);
        return Ok(VerticalCrs { metres_per_unit: Some(if is_down { -metres } else { metres }), ..coded });
    }

    let datum_name = datum.map_or("", Node::name);
    let known = match datum {
        // Esri: a geodetic datum in a vertical system means heights above its ellipsoid.
        Some(datum) if datum.word == "DATUM" => Some(VerticalDatum::Ellipsoid),
        // OGC 01-009 §12.3.9: type 2002 is an ellipsoidal height.
        Some(datum) if datum.numbers().next() == Some(2002.0) => Some(VerticalDatum::Ellipsoid),
        _ => heights::datum_of(datum_name).or_else(|| heights::datum_of(node.name())),
    };

    let name = [node.name(), datum_name].into_iter().find(|name| !name.is_empty());
    let metres = unit.unwrap_or(1.0);
    Ok(VerticalCrs {
        datum: known,
        metres_per_unit: Some(if is_down == Some(true) { -metres } else { metres }),
        name: Some(name.map_or_else(|| "a vertical system without a name".to_owned(), shortened)),
    })
}

/// A parameter of a node by its plain name.
fn parameter(node: &Node, name: &str) -> Option<f64> {
    node.children(&["PARAMETER"]).find(|parameter| plain(parameter.name()) == name)?.numbers().next()
}

/// Whether heights count downward; `None` where the node does not say it. Esri gives a direction of −1.
fn is_depth(node: &Node) -> Option<bool> {
    if let Some(direction) = parameter(node, "direction") {
        return Some(direction < 0.0);
    }
    node.children(&["AXIS"]).flat_map(|axis| &axis.items).find_map(|item| match item {
        Item::Word(word) if word.eq_ignore_ascii_case("down") => Some(true),
        Item::Word(word) if word.eq_ignore_ascii_case("up") => Some(false),
        _ => None,
    })
}
