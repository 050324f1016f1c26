use proptest::prelude::*;

use crate::{Crs, VerticalDatum};

const ESRI_GEOGCS: &str = r#"GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;
const ESRI_LAEA: &str = r#"PROJCS["ETRS_1989_LAEA",GEOGCS["GCS_ETRS_1989",DATUM["D_ETRS_1989",SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Lambert_Azimuthal_Equal_Area"],PARAMETER["False_Easting",4321000.0],PARAMETER["False_Northing",3210000.0],PARAMETER["Central_Meridian",10.0],PARAMETER["Latitude_Of_Origin",52.0],UNIT["Meter",1.0]]"#;
const ESRI_FEET: &str = r#"PROJCS["NAD_1983_StatePlane_New_York_Long_Island_FIPS_3104_Feet",GEOGCS["GCS_North_American_1983",DATUM["D_North_American_1983",SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Lambert_Conformal_Conic"],PARAMETER["False_Easting",984250.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",-74.0],PARAMETER["Standard_Parallel_1",41.03333333333333],PARAMETER["Standard_Parallel_2",40.66666666666666],PARAMETER["Latitude_Of_Origin",40.16666666666666],UNIT["US survey foot",0.304800609601219]]"#;
const ESRI_SWISS: &str = r#"PROJCS["CH1903+_LV95",GEOGCS["GCS_CH1903+",DATUM["D_CH1903+",SPHEROID["Bessel_1841",6377397.155,299.1528128]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Hotine_Oblique_Mercator_Azimuth_Center"],PARAMETER["False_Easting",2600000.0],PARAMETER["False_Northing",1200000.0],PARAMETER["Scale_Factor",1.0],PARAMETER["Azimuth",90.0],PARAMETER["Longitude_Of_Center",7.439583333333333],PARAMETER["Latitude_Of_Center",46.95240555555556],UNIT["Meter",1.0]]"#;
const ESRI_POLAR: &str = r#"PROJCS["x",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Stereographic_North_Pole"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",0.0],PARAMETER["Standard_Parallel_1",71.0],UNIT["Meter",1.0]]"#;
const ESRI_WEB: &str = r#"PROJCS["WGS_1984_Web_Mercator_Auxiliary_Sphere",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Mercator_Auxiliary_Sphere"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",0.0],PARAMETER["Standard_Parallel_1",0.0],PARAMETER["Auxiliary_Sphere_Type",0.0],UNIT["Meter",1.0]]"#;
const OGC_WEB: &str = r#"PROJCS["WGS 84 / Pseudo-Mercator",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Mercator_1SP"],PARAMETER["central_meridian",0],PARAMETER["scale_factor",1],PARAMETER["false_easting",0],PARAMETER["false_northing",0],UNIT["metre",1],AXIS["Easting",EAST],AXIS["Northing",NORTH],EXTENSION["PROJ4","+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +lon_0=0 +x_0=0 +y_0=0 +k=1 +units=m +nadgrids=@null +wktext +no_defs"]]"#;
const OGC_COMPOUND: &str = r#"COMPD_CS["WGS 84 / UTM zone 33N + EGM96 height",PROJCS["WGS 84 / UTM zone 33N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",15],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST],AXIS["Northing",NORTH],AUTHORITY["EPSG","32633"]],VERT_CS["EGM96 height",VERT_DATUM["EGM96 geoid",2005,AUTHORITY["EPSG","5171"]],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Gravity-related height",UP],AUTHORITY["EPSG","5773"]]]"#;
const OGC_UTM_SOUTH: &str = r#"PROJCS["UTM Zone 25, Southern Hemisphere",GEOGCS["GRS 1980(IUGG, 1980)",DATUM["unknown",SPHEROID["GRS80",6378137,298.257222101],TOWGS84[0,0,0,0,0,0,0]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",-33],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",10000000],UNIT["Meter",1]]"#;
const WKT2_ALBERS: &str = r#"PROJCRS["NAD83 / Conus Albers",BASEGEOGCRS["NAD83",DATUM["North American Datum 1983",ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]],PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],CONVERSION["Conus Albers",METHOD["Albers Equal Area",ID["EPSG",9822]],PARAMETER["Latitude of false origin",23,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8821]],PARAMETER["Longitude of false origin",-96,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8822]],PARAMETER["Latitude of 1st standard parallel",29.5,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8823]],PARAMETER["Latitude of 2nd standard parallel",45.5,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8824]],PARAMETER["Easting at false origin",0,LENGTHUNIT["metre",1],ID["EPSG",8826]],PARAMETER["Northing at false origin",0,LENGTHUNIT["metre",1],ID["EPSG",8827]]],CS[Cartesian,2],AXIS["easting (X)",east,ORDER[1],LENGTHUNIT["metre",1]],AXIS["northing (Y)",north,ORDER[2],LENGTHUNIT["metre",1]]]"#;
const WKT2_COMPOUND: &str = r#"COMPOUNDCRS["x",GEOGCRS["NAD83",DATUM["North American Datum 1983",ELLIPSOID["GRS 1980",6378137,298.257222101]],CS[ellipsoidal,2],AXIS["latitude",north],AXIS["longitude",east],ANGLEUNIT["degree",0.0174532925199433]],VERTCRS["NAVD88 height (ftUS)",VDATUM["North American Vertical Datum 1988"],CS[vertical,1],AXIS["gravity-related height (H)",up,LENGTHUNIT["US survey foot",0.304800609601219]]]]"#;
const LOCAL: &str = r#"LOCAL_CS["WGS 84",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],AXIS["Easting",EAST],AXIS["Northing",NORTH]]"#;

/// Texts without a code of their own, and the EPSG code that they are equal to.
const EQUAL: [(&str, u32); 11] = [
    (ESRI_GEOGCS, 4326),
    (ESRI_LAEA, 3035),
    (ESRI_FEET, 2263),
    (ESRI_SWISS, 2056),
    (ESRI_POLAR, 3995),
    (ESRI_WEB, 3857),
    (OGC_WEB, 3857),
    (OGC_COMPOUND, 32_633),
    (OGC_UTM_SOUTH, 31_985),
    (WKT2_ALBERS, 5070),
    (WKT2_COMPOUND, 4269),
];

#[test]
fn texts_mean_their_codes() {
    for (text, code) in EQUAL {
        let crs = Crs::from_wkt(text).expect(text);
        let expected = Crs::from_epsg(code).expect("a known code");
        assert!(crs.is_equivalent(&expected), "EPSG:{code}: {:?} is not {:?}", crs.proj(), expected.proj());
        assert_eq!(Crs::from_user(text).expect("the same"), crs);
    }
    assert_eq!(
        Crs::from_wkt(OGC_COMPOUND).expect("sound").epsg(),
        Some(32_633),
        "the code of the outermost node"
    );
    assert_eq!(Crs::from_wkt(ESRI_LAEA).expect("sound").name(), "ETRS_1989_LAEA");
    let round = ESRI_LAEA.replace('[', "(").replace(']', ")");
    assert_eq!(
        Crs::from_wkt(&round).expect("round brackets"),
        Crs::from_wkt(ESRI_LAEA).expect("square brackets")
    );
}

#[test]
fn texts_name_their_heights() {
    let vertical = |text| Crs::with_vertical_from_wkt(text).expect("sound").1;
    assert_eq!(
        vertical(OGC_COMPOUND).map(|v| (v.datum, v.metres_per_unit)),
        Some((Some(VerticalDatum::Egm96), Some(1.0)))
    );
    let feet = vertical(WKT2_COMPOUND).expect("heights");
    assert_eq!(feet.datum, Some(VerticalDatum::Navd88));
    assert!(feet.metres_per_unit.is_some_and(|metres| (metres - 0.304_800_609_6).abs() < 1e-9));
    assert_eq!(vertical(ESRI_LAEA), None);
}

/// Esri writes heights behind the horizontal system, with their direction and a shift.
#[test]
fn heights_behind_a_system_are_its_own() {
    let esri = |direction: f64, shift: f64| {
        format!(
            "{ESRI_LAEA},VERTCS[\"NAVD88_height_(ftUS)\",VDATUM[\"North_American_Vertical_Datum_1988\"],\
             PARAMETER[\"Vertical_Shift\",{shift:?}],PARAMETER[\"Direction\",{direction:?}],UNIT[\"US survey foot\",0.304800609601219]]"
        )
    };

    for (direction, metres) in [(1.0, 0.304_800_609_6), (-1.0, -0.304_800_609_6)] {
        let (crs, vertical) = Crs::with_vertical_from_wkt(&esri(direction, 0.0)).expect("sound");
        assert!(crs.is_equivalent(&Crs::from_epsg(3035).expect("a known code")));
        let vertical = vertical.expect("heights");
        assert_eq!(vertical.datum, Some(VerticalDatum::Navd88));
        assert!(vertical.metres_per_unit.is_some_and(|found| (found - metres).abs() < 1e-9), "{vertical:?}");
    }

    for (text, part) in [
        (esri(1.0, 3.5), "shifted by 3.5 units"),
        (format!("{ESRI_LAEA},{ESRI_GEOGCS}"), "no vertical one"),
        (format!("{},VERTCS[\"x\"]", esri(1.0, 0.0)), "after the closing bracket"),
        (format!("{ESRI_LAEA},"), "breaks off"),
    ] {
        let error = Crs::from_wkt(&text).expect_err(&text).to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
}

#[test]
fn refusals_say_what_to_do() {
    let west = WKT2_ALBERS.replace("easting (X)\",east", "westing (X)\",west");
    let turned = Crs::from_wkt(&west).expect("axes to the west are read");
    assert!(turned.proj().is_some_and(|proj| proj.contains("+axis=wnu")) && !turned.is_metric());
    let up = WKT2_ALBERS.replace("northing (Y)\",north", "northing (Y)\",up");
    let grads = ESRI_GEOGCS.replace("\"Degree\",0.0174532925199433", "\"Grad\",0.015707963267948967");
    let unknown = ESRI_LAEA.replace("Lambert_Azimuthal_Equal_Area", "Peirce_Quincuncial");
    let parameter = ESRI_WEB.replace("\"Auxiliary_Sphere_Type\",0.0", "\"Auxiliary_Sphere_Type\",3.0");

    for (text, part) in [
        (LOCAL, "names no place on Earth"),
        ("GEOCCS[\"x\"]", "gdalwarp"),
        ("VERT_CS[\"x\"]", "--src-vdatum"),
        ("PROJCS[\"x\",GEOGCS[\"y\"]]", "no projection"),
        ("PROJCS[\"x\"", "breaks off"),
        ("PROJCS[\"x]", "closing quote"),
        ("PROJCS[\"x\"] more", "character 13"),
        (&up, "east and up"),
        (&grads, "only degrees"),
        (&unknown, "Peirce_Quincuncial"),
        (&parameter, "Auxiliary_Sphere_Type"),
    ] {
        let error = Crs::from_wkt(text).expect_err(text).to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
}

#[test]
fn deep_nesting_is_refused() {
    let text = "PROJCS[".repeat(100_000);
    assert!(Crs::from_wkt(&text).is_err());
}

proptest! {
    /// Characters of a sound text exchanged, dropped or doubled: an answer or an error, never a panic.
    #[test]
    fn mutated_texts_never_panic(
        which in 0..EQUAL.len(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..4u8, any::<char>()), 1..6),
    ) {
        let mut text: Vec<char> = EQUAL[which].0.chars().collect();
        for (place, edit, character) in edits {
            if text.is_empty() {
                break;
            }
            let place = place.index(text.len());
            match edit {
                0 => text[place] = character,
                1 => drop(text.remove(place)),
                2 => text.insert(place, text[place]),
                _ => text.truncate(place.max(1)),
            }
        }
        let text: String = text.into_iter().collect();
        let _ = Crs::from_wkt(&text);
        let _ = Crs::from_user(&text);
    }

    #[test]
    fn any_text_never_panics(text in ".{0,60}", proj in "(\\+[a-z_0-9]{1,6}=[-0-9a-z.,@]{1,9} ?){0,5}") {
        let _ = Crs::from_user(&text);
        let _ = Crs::from_proj(&proj, "random");
    }
}
