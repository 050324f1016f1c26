//! Well-known text: the names of methods, parameters and datums, as OGC, EPSG and Esri spell them.

use super::projection::{Method, Term};

/// Letters and digits of a name, in lower case: `Scale_Factor`, `scale_factor` and `Scale factor` are one.
pub(super) fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric() || *c == '+').flat_map(char::to_lowercase).collect()
}

/// Unit in which a parameter counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UnitKind {
    Angle,
    Length,
    Ratio,
}

/// Meaning of a parameter's name; without a term it must say nothing (0, or 1 for a ratio).
pub(super) fn term(name: &str) -> Option<(Option<Term>, UnitKind)> {
    Some(match plain(name).as_str() {
        "latitudeoforigin"
        | "latitudeofcenter"
        | "latitudeofcentre"
        | "latitudeofnaturalorigin"
        | "latitudeoffalseorigin"
        | "latitudeofprojectioncentre"
        | "centralparallel" => (Some(Term::Latitude), UnitKind::Angle),

        "centralmeridian"
        | "longitudeoforigin"
        | "longitudeofcenter"
        | "longitudeofcentre"
        | "longitudeofnaturalorigin"
        | "longitudeoffalseorigin"
        | "longitudeofprojectioncentre" => (Some(Term::Longitude), UnitKind::Angle),

        "pseudostandardparallel1" | "latitudeofpseudostandardparallel" => {
            (Some(Term::Parallel1), UnitKind::Angle)
        }
        "colatitudeofconeaxis" => (Some(Term::Azimuth), UnitKind::Angle),
        "scalefactoronpseudostandardparallel" => (Some(Term::Scale), UnitKind::Ratio),
        "standardparallel1" | "latitudeof1ststandardparallel" | "latitudeofstandardparallel" => {
            (Some(Term::Parallel1), UnitKind::Angle)
        }
        "standardparallel2" | "latitudeof2ndstandardparallel" => (Some(Term::Parallel2), UnitKind::Angle),

        "scalefactor"
        | "scalefactoratnaturalorigin"
        | "scalefactoratprojectioncentre"
        | "scalefactoroninitialline"
        | "scalefactorattheprojectioncentre" => (Some(Term::Scale), UnitKind::Ratio),
        "azimuth" | "azimuthofinitialline" | "azimuthatprojectioncentre" => {
            (Some(Term::Azimuth), UnitKind::Angle)
        }
        "rectifiedgridangle" | "anglefromrectifiedtoskewgrid" | "xyplanerotation" => {
            (Some(Term::RectifiedAngle), UnitKind::Angle)
        }

        "falseeasting" | "eastingatfalseorigin" | "eastingatprojectioncentre" => {
            (Some(Term::FalseEasting), UnitKind::Length)
        }
        "falsenorthing" | "northingatfalseorigin" | "northingatprojectioncentre" => {
            (Some(Term::FalseNorthing), UnitKind::Length)
        }

        // Said by some writers, and of no effect.
        "auxiliaryspheretype" => (None, UnitKind::Angle),
        "xscale" | "yscale" => (None, UnitKind::Ratio),
        _ => return None,
    })
}

/// Method of a name.
pub(super) fn method(name: &str) -> Option<Method> {
    Some(match plain(name).as_str() {
        "transversemercator" | "gausskruger" | "transversemercatorcomplex" => Method::TransverseMercator,
        "transversemercatorsouthorientated" | "transversemercatorsouthoriented" => Method::SouthOrientated,
        "krovak" => Method::Krovak,
        "krovaknorthorientated" => Method::KrovakNorth,

        "lambertconformalconic"
        | "lambertconformalconic1sp"
        | "lambertconformalconic2sp"
        | "lambertconicconformal1sp"
        | "lambertconicconformal2sp"
        | "lambertconicconformal1spvarianta" => Method::LambertConformal,
        "albers" | "albersconicequalarea" | "albersequalarea" => Method::Albers,
        "lambertazimuthalequalarea" => Method::LambertAzimuthal,

        "mercator" | "mercator1sp" | "mercator2sp" | "mercatorvarianta" | "mercatorvariantb" => {
            Method::Mercator
        }
        "mercatorauxiliarysphere" | "popularvisualisationpseudomercator" => Method::WebMercator,

        "polarstereographic"
        | "polarstereographicvarianta"
        | "polarstereographicvariantb"
        | "stereographicnorthpole"
        | "stereographicsouthpole" => Method::PolarStereographic,
        "obliquestereographic" | "doublestereographic" => Method::ObliqueStereographic,
        "stereographic" => Method::Stereographic,

        "equirectangular" | "equidistantcylindrical" | "platecarree" | "equidistantcylindricalspherical" => {
            Method::EquidistantCylindrical
        }

        "hotineobliquemercator"
        | "hotineobliquemercatorvarianta"
        | "hotineobliquemercatorazimuthnaturalorigin"
        | "rectifiedskeworthomorphicnaturalorigin" => Method::ObliqueMercatorA,
        "hotineobliquemercatorazimuthcenter"
        | "hotineobliquemercatorvariantb"
        | "obliquemercator"
        | "rectifiedskeworthomorphiccenter" => Method::ObliqueMercatorB,
        "swissobliquecylindrical" | "swissobliquemercator" => Method::SwissOblique,

        "azimuthalequidistant" | "modifiedazimuthalequidistant" => Method::AzimuthalEquidistant,
        "equidistantconic" => Method::EquidistantConic,
        "cylindricalequalarea" | "lambertcylindricalequalarea" => Method::CylindricalEqualArea,
        "cassini" | "cassinisoldner" => Method::Cassini,
        "polyconic" | "americanpolyconic" => Method::Polyconic,
        "sinusoidal" => Method::Sinusoidal,
        _ => return None,
    })
}
