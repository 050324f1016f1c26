//! Every raster with known true values is read exactly or refused with a remedy; damaged ones never panic.

#![expect(clippy::print_stdout, reason = "tests say what they skip and count")]

use std::path::{Path, PathBuf};

use serde_json::Value;

use hedgehop_modeling::raster::{
    ElevationRaster, ImageryRaster, OpenOptions, Raster, RasterInfo, SampleType, Window, open,
};
use hedgehop_testing::realdata;

fn whole(info: &RasterInfo) -> Window {
    Window { x: 0, y: 0, width: info.width, height: info.height }
}

/// The checksum of GDAL's `GDALChecksumImage`: samples, rounded half up, modulo a cycle of primes, summed in 16 bits.
fn gdal_checksum(samples: impl Iterator<Item = f64>) -> u64 {
    const PRIMES: [i64; 11] = [7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43];
    samples.zip(PRIMES.iter().cycle()).fold(0, |sum, (sample, prime)| {
        let integer = if sample.is_finite() {
            (sample + 0.5).floor().clamp(-f64::from(i32::MAX), f64::from(i32::MAX)) as i64
        } else {
            i64::from(i32::MIN)
        };
        (sum + integer % prime) & 0xffff
    }) as u64
}

/// A number as the expectations spell it; NaN is a string.
fn number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| (value.as_str() == Some("nan")).then_some(f64::NAN))
}

fn same(a: Option<f64>, b: Option<f64>) -> bool {
    a == b || matches!((a, b), (Some(a), Some(b)) if a.is_nan() && b.is_nan())
}

fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs())
}

/// What differs from the expectations.
fn differences(raster: &dyn Raster, expected: &Value) -> Vec<String> {
    let info = raster.info();
    let mut wrong = Vec::new();
    let mut check = |name: &str, right: bool, found: String| {
        if !right {
            wrong.push(format!("{name} is {found}"));
        }
    };
    for (name, found) in [("width", info.width), ("height", info.height), ("bands", info.bands)] {
        check(name, expected[name].as_u64() == Some(u64::from(found)), found.to_string());
    }

    check("dtype", expected["dtype"].as_str() == Some(info.sample.name()), info.sample.name().into());
    let geo: Vec<f64> = expected["geotransform"].as_array().unwrap().iter().filter_map(number).collect();
    let identity = geo == [0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let placed = match info.geo {
        Some(found) => found.iter().zip(&geo).all(|(a, b)| close(*a, *b, 1e-9)),
        None => identity,
    };
    check("geotransform", placed, format!("{:?}", info.geo));
    check("nodata", same(info.nodata, number(&expected["nodata"])), format!("{:?}", info.nodata));

    // Some systems are recognised only by GDAL's tables; then a definition without a code will do.
    if let Some(code) = expected["crs"].as_str().and_then(|crs| crs.strip_prefix("EPSG:")) {
        let right =
            info.crs.as_ref().is_some_and(|crs| crs.epsg().is_none_or(|epsg| epsg.to_string() == code));
        check("crs", right, format!("{:?} ({:?})", info.crs, info.crs_problem));
    }

    if !wrong.is_empty() {
        return wrong;
    }

    for (band, expected) in expected["band"].as_array().unwrap().iter().enumerate() {
        wrong.extend(band_differences(raster, band as u32, expected));
    }

    wrong
}

fn band_differences(raster: &dyn Raster, band: u32, expected: &Value) -> Vec<String> {
    let info = raster.info();
    let mut samples = Vec::new();
    raster.read(whole(info), &[band], &mut samples).unwrap();
    let valid: Vec<f64> =
        samples.iter().copied().filter(|s| !s.is_nan() && !same(Some(*s), info.nodata)).collect();
    let least = valid.iter().copied().reduce(f64::min);
    let most = valid.iter().copied().reduce(f64::max);
    let mean = (!valid.is_empty()).then(|| valid.iter().sum::<f64>() / valid.len() as f64);
    let checksum = gdal_checksum(samples.iter().copied());
    let mut wrong = Vec::new();
    let mut check = |name: &str, right: bool, found: String| {
        if !right {
            wrong.push(format!("{name} of band {band} is {found}, not {}", expected[name]));
        }
    };
    check("valid", expected["valid"].as_u64() == Some(valid.len() as u64), valid.len().to_string());
    check("min", least == number(&expected["min"]), format!("{least:?}"));
    check("max", most == number(&expected["max"]), format!("{most:?}"));
    let close_mean = match (mean, number(&expected["mean"])) {
        (Some(a), Some(b)) => close(a, b, 1e-9),
        (a, b) => a == b,
    };
    check("mean", close_mean, format!("{mean:?}"));
    check("checksum", expected["checksum"].as_u64() == Some(checksum), checksum.to_string());

    for sample in expected["samples"].as_array().unwrap() {
        let position = |i: usize| sample[i].as_u64().unwrap() as usize;
        let found = samples[position(1) * info.width as usize + position(0)];
        let mut pixel = Vec::new();
        let window = Window { x: position(0) as u32, y: position(1) as u32, width: 1, height: 1 };
        raster.read(window, &[band], &mut pixel).unwrap();
        let right = same(Some(found), number(&sample[2])) && same(Some(pixel[0]), Some(found));
        check("samples", right, format!("{found} ({} alone) at {sample}", pixel[0]));
    }

    wrong
}

#[test]
fn known_files_are_read_exactly_or_refused() {
    let Some(folder) = realdata().map(|folder| folder.join("conformance")) else { return };
    let expected: Value =
        serde_json::from_slice(&std::fs::read(folder.join("expected.json")).unwrap()).unwrap();
    let files = expected.as_object().unwrap();
    let (mut exact, mut refused, mut wrong) = (0, Vec::new(), Vec::new());

    for (name, expected) in files {
        let path = folder.join(name);
        let raster = open(&path, &OpenOptions::default());
        let unreadable = expected.get("unreadable").is_some();
        match raster {
            Ok(raster) if unreadable => {
                let mut samples = Vec::new();
                match raster.read(whole(raster.info()), &[0], &mut samples) {
                    Ok(()) => wrong.push(format!("{name}: was read although it is damaged")),
                    Err(error) => refused.push((name, error.to_string())),
                }
            }
            Ok(raster) => match differences(raster.as_ref(), expected) {
                found if found.is_empty() => exact += 1,
                found => wrong.push(format!("{name}: {}", found.join("; "))),
            },
            Err(error) => refused.push((name, error.to_string())),
        }
    }

    println!("{} files: {exact} exact, {} refused, {} wrong", files.len(), refused.len(), wrong.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for (name, error) in &refused {
        println!("refused {name}: {error}");
        assert!(error.contains("gdal_translate") || error.contains("fetch it again"), "{error}");
    }

    assert_eq!(files.len(), 73);
    assert_eq!(exact, 70, "all but three JPEG files, of which one is damaged too, are exact");
}

#[test]
fn real_pairs_open() {
    let Some(folder) = realdata() else { return };
    let elevation = [
        ("global_etopo5_bmng/etopo5_4320x2161_int16.tif", -10376.0, 7833.0),
        ("sf_srtm1_landsat7/srtm1_sf_485x349_int16.tif", -35.0, 289.0),
        ("odm_drone_dsm/dsm.tif", 57.2426, 112.926),
        ("rmnp/rmnp-dem.tif", 2281.0, 4261.0),
        ("sba_airport/sba_elev32_wgs84_512x512.tif", 2.52971, 20.7314),
        ("sba_airport/elev32_sba_512x512.bil", 2.52971, 20.7314),
        ("olinda/olinda_dem_utm25s.tif", -1.0, 88.0),
        ("craterlake/craterlake-elev-16bit-30m.tif", 1000.0, 3000.0),
        ("lakedistrict/eudem_lakedistrict_example.tif", 46.4235, 934.306),
        ("srtm_tiles/N40W074_srtm1_3601x3601_int16.tif", -56.0, 197.0),
    ];

    for (name, least, most) in elevation {
        let raster = open(&folder.join(name), &OpenOptions::default()).unwrap();
        let raster = ElevationRaster::new(raster, &[], 1.0).unwrap();
        let mut heights = Vec::new();
        raster.read(whole(raster.info()), &mut heights).unwrap();
        let valid = || heights.iter().copied().filter(|height| !height.is_nan());
        let (low, high) = (valid().fold(f64::INFINITY, f64::min), valid().fold(f64::NEG_INFINITY, f64::max));
        println!("{name}: {low} … {high} m, {:?}, {:?}", raster.info().crs, raster.notes());

        if name.starts_with("craterlake") {
            assert!(low > least && high < most, "{low} {high}");
            assert!(raster.notes()[0].contains("-32767"), "{:?}", raster.notes());
        } else {
            assert!(close(low, least, 1e-5) && close(high, most, 1e-5), "{name}: {low} {high}");
            assert!(raster.notes().is_empty(), "{:?}", raster.notes());
        }
    }

    for (name, transparent) in [
        ("global_etopo5_bmng/bmng.jpg", false),
        ("sf_srtm1_landsat7/landsat7_sf.tif", true),
        ("odm_drone_dsm/odm_ortho_rgb_0p25m.tif", true),
        ("rmnp/rmnp-rgb.tif", true),
        ("sba_airport/sba_rgb_wgs84_512x512.tif", false),
        ("olinda/L7_ETMs.tif", false),
        ("craterlake/craterlake-imagery-30m.tif", true),
    ] {
        let raster = open(&folder.join(name), &OpenOptions::default()).unwrap();
        let raster = ImageryRaster::new(raster, None).unwrap();
        let mut pixels = Vec::new();
        raster.read(whole(raster.info()), &mut pixels).unwrap();
        let clear = pixels.iter().filter(|pixel| pixel[3] == 0).count();

        println!(
            "{name}: {clear} of {} transparent, {:?}, {:?}",
            pixels.len(),
            raster.info().geo,
            raster.notes()
        );
        assert_eq!(clear > 0, transparent, "{name}");
    }
}

/// Deterministic numbers (SplitMix64; Steele, Lea and Flood, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: u64) -> usize {
        (self.next() % limit.max(1)) as usize
    }
}

/// Flips, cuts or scrambles some bytes, mostly in the header.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let length = bytes.len() as u64;
    match random.below(4) {
        0 => bytes.truncate(random.below(length)),
        1 => {
            let at = random.below(length);
            bytes[at] ^= 1 << random.below(8);
        }
        kind => {
            let reach = if kind == 2 { length.min(512) } else { length };
            for _ in 0..1 + random.below(8) {
                let at = random.below(reach);
                bytes[at] = random.next() as u8;
            }
        }
    }
}

/// Opens a raster and reads a few windows of it; whatever happens, it must be an answer or a sentence.
fn exercise(path: &Path, random: &mut Random) {
    let options = OpenOptions { cache_bytes: 16 << 20, ..OpenOptions::default() };
    let raster = match open(path, &options) {
        Ok(raster) => raster,
        Err(error) => return assert!(!error.to_string().contains('\n'), "{error}"),
    };
    let info = raster.info().clone();
    let bands: Vec<u32> = (0..info.bands.min(4)).collect();
    let mut samples = Vec::new();

    for _ in 0..3 {
        let x = random.below(u64::from(info.width)) as u32;
        let y = random.below(u64::from(info.height)) as u32;
        let window = Window { x, y, width: (info.width - x).min(300), height: (info.height - y).min(300) };
        match raster.read(window, &bands, &mut samples) {
            Ok(()) => assert_eq!(samples.len(), (window.width * window.height) as usize * bands.len()),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }

    let _ = ElevationRaster::new(raster, &[-1.0], 1.0);
    if let Ok(raster) = open(path, &options) {
        let _ = ImageryRaster::new(raster, None);
    }
}

/// Files beside a raster that belong to it.
fn side_files(path: &Path) -> Vec<PathBuf> {
    let extensions = ["hdr", "prj", "pgw"];
    extensions.iter().map(|extension| path.with_extension(extension)).filter(|side| side.is_file()).collect()
}

#[test]
fn damaged_files_give_values_or_a_sentence() {
    let Some(folder) = realdata().map(|folder| folder.join("conformance/encodings")) else { return };
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| {
        let extension = path.extension().unwrap_or_default();
        ["hdr", "prj", "pgw"].iter().all(|side| extension != *side)
    });
    files.sort();
    let work = tempfile::tempdir().unwrap();
    let mut random = Random(42);
    let mut count = 0;

    for path in &files {
        let copy = work.path().join(path.file_name().unwrap());
        let original = std::fs::read(path).unwrap();
        let sides = side_files(path);
        for _ in 0..if original.len() > 1 << 20 { 2 } else { 6 } {
            let mut bytes = original.clone();
            mutate(&mut bytes, &mut random);
            std::fs::write(&copy, &bytes).unwrap();
            for side in &sides {
                let mut bytes = std::fs::read(side).unwrap();
                if random.below(2) == 0 {
                    mutate(&mut bytes, &mut random);
                }
                std::fs::write(work.path().join(side.file_name().unwrap()), &bytes).unwrap();
            }

            exercise(&copy, &mut random);
            count += 1;
        }
    }

    println!("{count} damaged files gave values or a sentence");
    assert!(count >= 100);
}

#[test]
fn sample_type_names_are_numpy_names() {
    assert_eq!([SampleType::U8, SampleType::F64].map(SampleType::name), ["uint8", "float64"]);
}
