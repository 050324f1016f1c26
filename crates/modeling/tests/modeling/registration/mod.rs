//! Real pairs: heights and imagery lie where their files say.
//!
//! Where a file's pixels lie is written down here from its tags, and the mean under a voxel's tent is taken
//! anew, so that what is checked is not what checks.

mod placement;

use hedgehop_modeling::BuildOptions;
use hedgehop_testing::realdata;
use placement::{Lattice, assert_coast, check_pair, linear};

fn valid(value: f64, nodata: f64) -> f64 {
    if value == nodata { f64::NAN } else { value }
}

fn byte(value: f64) -> f64 {
    linear(value as u8)
}

#[test]
fn san_francisco() {
    let Some(folder) = realdata() else { return };
    // Column 1730, row 684 of a tile whose first post is at 123° west, 38° north.
    let second = 1.0 / 3600.0;

    let elevation = Lattice {
        file: "sf_srtm1_landsat7/srtm1_sf_485x349_int16.tif",
        crs: 4326,
        west: -123.0 + (1730.0 - 0.5) * second,
        north: 38.0 - (684.0 - 0.5) * second,
        pixel: [second; 2],
    };

    let imagery = Lattice {
        file: "sf_srtm1_landsat7/landsat7_sf.tif",
        crs: 3857,
        west: -13_651_650.0,
        north: 4_576_290.0,
        pixel: [30.0; 2],
    };

    // A pixel whose infrared is 0 may still be water; the nearest-lying rule is all three.
    let light = |pixel: &[f64]| if pixel.iter().all(|&band| band == 0.0) { f64::NAN } else { byte(pixel[0]) };
    let area = check_pair(&folder, &elevation, &imagery, |_| {}, |pixel| valid(pixel[0], -32768.0), light);

    // Near infrared, which water swallows, is shown as red.
    let land = |voxel| Some(area.height(voxel)).filter(|height| !height.is_nan()).map(|height| height > 1.0);
    assert_coast(&area, land, |voxel| area.light(voxel, 0).sqrt(), 0.6);
}

#[test]
fn rocky_mountains() {
    let Some(folder) = realdata() else { return };
    let elevation = Lattice {
        file: "rmnp/rmnp-dem.tif",
        crs: 4326,
        west: -105.912_5,
        north: 40.553_678_069_620_155,
        pixel: [0.002_75, 0.002_11],
    };
    let imagery = Lattice {
        file: "rmnp/rmnp-rgb.tif",
        crs: 4326,
        west: -106.056_600_560_355_6,
        north: 40.619_681_535_764_29,
        pixel: [0.0015; 2],
    };
    let light =
        |pixel: &[f64]| if pixel.iter().all(|&band| band == 255.0) { f64::NAN } else { byte(pixel[0]) };
    check_pair(&folder, &elevation, &imagery, |_| {}, |pixel| valid(pixel[0], 65535.0), light);
}

#[test]
fn olinda() {
    let Some(folder) = realdata() else { return };
    let corner = (288_776.250_000_803_15, 9_120_760.750_028_737);
    let lattice =
        |file, side| Lattice { file, crs: 31985, west: corner.0, north: corner.1, pixel: [side; 2] };
    let elevation = lattice("olinda/olinda_dem_utm25s.tif", 89.994_067_349_451_16);
    let imagery = lattice("olinda/L7_ETMs.tif", 28.499_999_999_274_54);
    let natural = |options: &mut BuildOptions| options.imagery[0].bands = Some([3, 2, 1]);
    check_pair(&folder, &elevation, &imagery, natural, |pixel| pixel[0], |pixel| byte(pixel[2]));
}

#[test]
fn drone_survey() {
    let Some(folder) = realdata() else { return };
    let lattice =
        |file, north, side| Lattice { file, crs: 32651, west: 292_540.291_6, north, pixel: [side; 2] };
    let elevation = lattice("odm_drone_dsm/dsm.tif", 2_731_225.049_25, 0.8);
    let imagery = lattice("odm_drone_dsm/odm_ortho_rgb_0p25m.tif", 2_731_224.549_25, 0.25);
    let light = |pixel: &[f64]| if pixel[3] < 255.0 { f64::NAN } else { byte(pixel[0]) };
    check_pair(&folder, &elevation, &imagery, |_| {}, |pixel| pixel[0], light);
}

#[test]
fn santa_barbara() {
    let Some(folder) = realdata() else { return };
    let side = 3.027_343_75e-5;
    let lattice = |file| Lattice { file, crs: 4326, west: -119.8337, north: 34.4448, pixel: [side; 2] };
    let elevation = lattice("sba_airport/sba_elev32_wgs84_512x512.tif");
    let imagery = lattice("sba_airport/sba_rgb_wgs84_512x512.tif");
    let said = |options: &mut BuildOptions| options.elevation[0].crs = Some("EPSG:4326".into());
    check_pair(&folder, &elevation, &imagery, said, |pixel| valid(pixel[0], -9999.0), |pixel| byte(pixel[0]));
}

#[test]
fn crater_lake() {
    let Some(folder) = realdata() else { return };
    let side = 0.000_269_965_978_544_445;

    // The heights' tie point is a pixel's centre, the picture's a pixel's corner.
    let elevation = Lattice {
        file: "craterlake/craterlake-elev-16bit-30m.tif",
        crs: 4326,
        west: -122.165_447_703_198_64 - 0.5 * side,
        north: 42.979_316_644_842_47 + 0.5 * side,
        pixel: [side; 2],
    };

    let imagery = Lattice {
        file: "craterlake/craterlake-imagery-30m.tif",
        crs: 4326,
        west: -122.165_582_686_187_9,
        north: 42.979_451_627_831_74,
        pixel: [side; 2],
    };

    let light = |pixel: &[f64]| if pixel[3] < 255.0 { f64::NAN } else { byte(pixel[0]) };
    check_pair(&folder, &elevation, &imagery, |_| {}, |pixel| valid(pixel[0], -32767.0), light);
}

#[test]
fn the_whole_earth() {
    let Some(folder) = realdata() else { return };
    // Posts at the poles and at multiples of 5′; the picture's world file names its first pixel's centre.
    let arc = 5.0 / 60.0;

    let elevation = Lattice {
        file: "global_etopo5_bmng/etopo5_4320x2161_int16.tif",
        crs: 4326,
        west: -180.0 - 0.5 * arc,
        north: 90.0 + 0.5 * arc,
        pixel: [arc; 2],
    };

    let imagery = Lattice {
        file: "global_etopo5_bmng/bmng.jpg",
        crs: 4326,
        west: -180.0,
        north: 90.0,
        pixel: [1.0 / 15.0; 2],
    };

    let adjust = |options: &mut BuildOptions| {
        options.imagery[0].crs = Some("EPSG:4326".into());
        options.spacing = Some(40_000.0);
    };
    let area = check_pair(&folder, &elevation, &imagery, adjust, |pixel| pixel[0], |pixel| byte(pixel[0]));

    // Between 60° north and south, where the sea does not freeze: it is blue, and land is not.
    let sea = |voxel| {
        let temperate = area.centre(voxel).y.abs() < 60.0 * 111_320.0;
        temperate.then(|| area.height(voxel) < 0.0)
    };
    let blueness = |voxel| {
        let [red, green, blue] = [0, 1, 2].map(|channel| area.light(voxel, channel));
        blue / (red + green + blue)
    };
    assert_coast(&area, sea, blueness, 0.6);
}
