//! Reference systems: datums, units, directions, bodies, and what is said of them.

use super::replay::{Replay, assert_range};

/// Range of what all grids of heights hold, in metres if it is in US feet, and as depths.
const US_FEET: [f64; 2] = [275.1, 436.3];
const DEPTHS: [f64; 2] = [-1431.5, -902.7];

pub fn heights_and_depths(inputs: &Replay) {
    let table = [
        ("--elevation ngvd29_ftus.tif", US_FEET),
        ("--elevation msl_depth.tif", DEPTHS),
        ("--elevation navd88_ftus.asc", US_FEET),
        ("--elevation navd88_ftus_esri.asc", US_FEET),
        ("--elevation nocrs.tif --elevation-crs EPSG:32632+6360", US_FEET),
        ("--elevation nocrs.tif --elevation-crs EPSG:32632+5715", DEPTHS),
        ("--cloud ngvd29_ft.las --spacing 1", [200.0, 214.0]),
        ("--cloud msl_depth.las --spacing 1", [200.0, 214.0]),
    ];

    for (line, expected) in table {
        assert_range(&inputs.built(line), expected, 0.2);
    }

    let proj = "+proj=utm +zone=32 +datum=WGS84 +vunits=us-ft";
    let build = "build --elevation nocrs.tif -o built.hop --overwrite --elevation-crs";
    inputs.done_with(build, &[proj]);
    assert_range(&inputs.info("built.hop"), US_FEET, 0.2);

    let egm96 = inputs.built("--elevation nocrs.tif --elevation-crs EPSG:32632+5773");
    assert_eq!(egm96["metadata"]["vertical_datum"], "EGM96 mean sea level");

    // Heights above the ellipsoid come to mean sea level as those of any such system do.
    let stated = inputs.built("--elevation gda2020_3d.tif");
    let named = inputs.built("--elevation gda2020_3d.tif --elevation-crs EPSG:4979");
    let range = [0, 1].map(|end| named["height_range_m"][end].as_f64().expect("a height"));
    assert_range(&stated, range, 0.2);
    for info in [stated, named] {
        assert_eq!(info["metadata"]["vertical_datum"], "EGM96 mean sea level");
    }
}

pub fn datums_by_name(inputs: &Replay) {
    inputs.built("--elevation rt90.asc");
    inputs.heights("15.812311 59.340107", &[650.0], 5.0);
    for house in ["house_hk80.shp", "house_gdal.shp"] {
        inputs.built(&format!("--elevation dem_utm50.tif --features {house}"));
        inputs.heights("114.164565649 22.337063457", &[110.0], 0.5);
    }
}

pub fn codes_with_shifts(inputs: &Replay) {
    for (file, place) in [("korea5174.tif", "127.1 37.5"), ("bmn31289.tif", "14.3 47.8")] {
        inputs.built(&format!("--elevation {file}"));
        inputs.heights(place, &[650.0], 5.0);
    }
}

pub fn grads(inputs: &Replay) {
    let words = ["ntf_paris.prj", "NTF (Paris)", "0.9 degrees", "gdalwarp -t_srs"];
    inputs.refused("build --elevation ntf_paris.asc -o built.hop", 4, &words);
}

pub fn moon_and_mars(inputs: &Replay) {
    for (file, body) in [("moon_deg.tif", "1737400 m"), ("mars_deg.tif", "3396190 m")] {
        let words = [file, body, "not the Earth", "--local"];
        inputs.refused(&format!("build --elevation {file} -o built.hop"), 4, &words);
    }
}

pub fn sentences_that_are_true(inputs: &Replay) {
    for file in ["krovak2065.tif", "lo29.tif", "wgs84_g2139.tif"] {
        inputs.built(&format!("--elevation {file}"));
    }
    for (file, name) in [("mollweide.tif", "Mollweide"), ("ntf_grad.tif", "0.9 degrees")] {
        let words = [file, "that is not read", name, "gdalwarp"];
        inputs.refused(&format!("build --elevation {file} -o built.hop --overwrite"), 4, &words);
    }
    let features = "build --elevation lo29.tif --features esri_json.json -o built.hop --overwrite";
    inputs.refused(features, 4, &["esri_json.json", "Esri JSON"]);
}
