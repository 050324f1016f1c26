//! Land cover from files: what is told of them, mistakes, and builds that go on from builds before.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tempfile::TempDir;

use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::voxel::{Material, PageSource};
use hedgehop_modeling::object::{BuiltIn, ScatterFile, ScatterForm};
use hedgehop_modeling::recipe::Recipe;
use hedgehop_modeling::{
    BuildOptions, ElevationFile, FeatureFile, Finish, LandCoverFile, Materials, Scheme, build,
};
use hedgehop_query::{attributes_at, tally};

const WEST: f64 = 500_000.0;
const SOUTH: f64 = 5_000_000.0;
/// Voxels of a metre along a side: 2 × 2 pages.
const SIDE: u32 = 512;
/// Pixels of 8 m along a side.
const PIXELS: u32 = 64;

/// A GeoTIFF of bytes with a palette, in UTM zone 32.
fn tiff(path: &Path, pixels: &[u8], nodata: Option<&str>) {
    let (doubles, keys): (Vec<f64>, Vec<u16>) = (
        vec![8.0, 8.0, 0.0, 0.0, 0.0, 0.0, WEST, SOUTH + 8.0 * f64::from(PIXELS), 0.0],
        vec![1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32_632],
    );
    let palette = vec![0_u16; 768];
    let mut data: Vec<u8> = Vec::new();

    let mut put = |bytes: &[u8]| {
        let at = 8 + data.len() as u32;
        data.extend_from_slice(bytes);
        data.resize(data.len().next_multiple_of(2), 0);
        at
    };
    let shorts = |values: &[u16]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let bytes = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let strip = put(pixels);
    let (scale, tie) = (put(&bytes(&doubles[..3])), put(&bytes(&doubles[3..])));
    let (directory, colours) = (put(&shorts(&keys)), put(&shorts(&palette)));
    let text = nodata.map(|text| format!("{text}\0\0\0\0"));
    let text_at = text.as_ref().map(|text| put(text.as_bytes()));

    let mut entries: Vec<(u16, u16, u32, u32)> = vec![
        (256, 4, 1, PIXELS),
        (257, 4, 1, PIXELS),
        (258, 3, 1, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 3),
        (273, 4, 1, strip),
        (277, 3, 1, 1),
        (278, 4, 1, PIXELS),
        (279, 4, 1, pixels.len() as u32),
        (320, 3, 768, colours),
        (33_550, 12, 3, scale),
        (33_922, 12, 6, tie),
        (34_735, 3, keys.len() as u32, directory),
    ];

    entries.extend(text.zip(text_at).map(|(text, at)| (42_113, 2, text.len() as u32, at)));
    let mut file = b"II\x2a\0".to_vec();
    file.extend((8 + data.len() as u32).to_le_bytes());
    file.extend(&data);
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend(tag.to_le_bytes().into_iter().chain(kind.to_le_bytes()));
        file.extend(count.to_le_bytes().into_iter().chain(value.to_le_bytes()));
    }

    file.extend([0; 4]);
    fs::write(path, file).unwrap();
}

/// Meadows, a lake, a wood, and some pixels of numbers that nobody knows.
fn classes() -> Vec<u8> {
    let class = |index: u32| match (index % PIXELS, index / PIXELS) {
        (5..10, 5..8) => 77,
        (40, 60) => 33,
        (0..20, _) => 80,
        (40.., 0..30) => 10,
        _ => 30,
    };
    (0..PIXELS * PIXELS).map(class).collect()
}

fn site() -> TempDir {
    let folder = TempDir::new().unwrap();
    let row = |row: u32| {
        (0..PIXELS).map(|column| format!("{}", 100 + (row * column) % 17)).collect::<Vec<_>>().join(" ")
    };
    let rows: Vec<_> = (0..PIXELS).map(row).collect();
    let head = format!("ncols {PIXELS}\nnrows {PIXELS}\nxllcorner {WEST}\nyllcorner {SOUTH}\ncellsize 8\n");
    fs::write(folder.path().join("dem.asc"), head + &rows.join("\n") + "\n").unwrap();
    tiff(&folder.path().join("cover.tif"), &classes(), None);
    let line = format!("[[{},{}],[{},{}]]", WEST + 10.0, SOUTH + 100.3, WEST + 500.0, SOUTH + 100.3);
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    let road = format!(
        r#"{{"type":"FeatureCollection",{crs},"features":[{{"type":"Feature","properties":{{"highway":"primary","width":9}},"geometry":{{"type":"LineString","coordinates":{line}}}}}]}}"#
    );
    fs::write(folder.path().join("road.geojson"), road).unwrap();
    folder
}

fn options(folder: &Path, output: &str) -> BuildOptions {
    let path = |name: &str| folder.join(name);
    let mut options = BuildOptions::new(Vec::new(), Vec::new(), path(output));
    options.elevation = vec![ElevationFile {
        path: path("dem.asc"),
        crs: Some("EPSG:32632".into()),
        ..ElevationFile::default()
    }];
    options.features = vec![FeatureFile::from(path("road.geojson"))];
    options.land_cover = vec![LandCoverFile {
        path: path("cover.tif"),
        crs: None,
        scheme: Scheme::WorldCover,
        nodata: Vec::new(),
    }];
    options.spacing = Some(1.0);
    (options.steps, options.overwrite) = (true, true);
    options
}

fn material(pages: &PageFile, x: f64, y: f64) -> String {
    let found = attributes_at(pages, glam::dvec2(WEST + x, SOUTH + y)).unwrap().unwrap();
    pages.header().metadata.material_name(found.material)
}

#[test]
fn files_give_their_classes_and_features_lie_over_them() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    build(&options, &Silent).unwrap();
    let pages = PageFile::open(&options.output).unwrap();
    assert_eq!(pages.verify(&Silent).unwrap().problems, []);
    assert_eq!(material(&pages, 100.0, 20.0), "water");
    assert_eq!(material(&pages, 300.0, 20.0), "grass");
    assert_eq!(material(&pages, 500.0, 500.0), "mixed-forest");
    assert_eq!(material(&pages, 300.0, 100.3), "asphalt");
    assert_eq!(material(&pages, 60.0, 460.0), "unknown");
    let metadata = &pages.header().metadata;
    let names: Vec<&str> = metadata.materials.iter().map(|record| record.name.as_str()).collect();
    assert_eq!(names, ["water", "asphalt", "grass", "mixed-forest"]);
    let told = metadata.notes.join("; ");
    assert!(told.contains("no classes of worldcover: 77 (15 pixels), 33 (1 pixels);"), "{told}");
    let tally = tally(&pages, None).unwrap();
    assert_eq!(tally.materials[&0].area, 16.0 * 64.0);
    assert_eq!(tally.materials[&Material::MixedForest.code()].area, 24.0 * 30.0 * 64.0);
    assert_eq!(tally.area + tally.empty, f64::from(SIDE * SIDE));
}

#[test]
fn nodata_of_files_and_of_recipes_says_nothing() {
    let folder = site();
    tiff(&folder.path().join("cover.tif"), &classes(), Some("77"));
    let mut options = options(folder.path(), "a.hop");
    options.land_cover[0].nodata = vec![80.0];
    build(&options, &Silent).unwrap();
    let pages = PageFile::open(&options.output).unwrap();
    assert_eq!(
        (material(&pages, 60.0, 460.0), material(&pages, 100.0, 20.0)),
        ("unknown".into(), "unknown".into())
    );
    let told = pages.header().metadata.notes.join("; ");
    assert!(told.contains("33 (1 pixels)") && !told.contains("77"), "{told}");
}

#[test]
fn plants_keep_to_their_ground() {
    let folder = site();
    let trees = |on: &[Material]| ScatterFile {
        forms: vec![ScatterForm::BuiltIn(BuiltIn::Broadleaf)],
        spacing_m: 12.0,
        grounds: on.to_vec(),
        ..ScatterFile::default()
    };
    let mut options = options(folder.path(), "a.hop");
    options.scatters = vec![trees(&[Material::Grass])];
    build(&options, &Silent).unwrap();
    let pages = PageFile::open(&options.output).unwrap();
    assert_eq!(pages.verify(&Silent).unwrap().problems, []);
    let count = |left: u32, right: u32, class: &str| {
        let places = (36..64).flat_map(|row| (left..right).map(move |column| (column, row)));
        let at = |(column, row)| material(&pages, 8.0 * f64::from(column) + 4.0, 8.0 * f64::from(row) + 4.0);
        places.map(at).filter(|found| found == class).count()
    };

    // A crown reaches into the next field, and no farther.
    assert_eq!((count(0, 18, "broadleaf"), count(42, 64, "broadleaf")), (0, 0));
    let trees = count(21, 39, "broadleaf");
    assert!((100..600).contains(&trees), "{trees}");
}

#[test]
fn a_changed_colour_gives_the_bytes_of_a_clean_build() {
    let folder = site();
    let mut options = options(folder.path(), "a.hop");
    let both = |options: &BuildOptions| {
        let report = build(options, &Silent).unwrap();
        let clean = BuildOptions { output: folder.path().join("clean.hop"), steps: false, ..options.clone() };
        let whole = build(&clean, &Silent).unwrap();
        assert_eq!(report.content_hash, whole.content_hash);
        assert!(fs::read(&options.output).unwrap() == fs::read(&clean.output).unwrap(), "the same bytes");
        report
    };

    let colour = |path: &Path, x: u32, y: u32| {
        let pages = PageFile::open(path).unwrap();
        let id = hedgehop::voxel::PageId { level: 0, px: x / 256, py: y / 256 };
        let page = pages.page(id).unwrap().unwrap();
        page.colours[page.sample(x % 256, y % 256)]
    };
    assert_eq!(both(&options).reused, 0);
    let again = both(&options);
    assert_eq!(again.reused, again.pages);
    let asphalt = colour(&options.output, 300, 100);

    // Asphalt is the road's, whose colour is another one than the table's.
    let said = |material: Material, colour| Finish {
        material,
        name: material.name().unwrap().into(),
        colour: Some(colour),
        ..Finish::default()
    };
    options.materials = Materials::new(vec![said(Material::Asphalt, [20, 20, 120])]);
    assert_eq!(both(&options).reused, 0);
    let changed = colour(&options.output, 300, 100);
    assert!(changed[2] > asphalt[2] && changed[0] < asphalt[0], "{asphalt:?} became {changed:?}");

    // Another class somewhere.
    let mut pixels = classes();
    pixels[(PIXELS * PIXELS - 1) as usize] = 60;
    tiff(&folder.path().join("cover.tif"), &pixels, None);
    both(&options);
    let pages = PageFile::open(&options.output).unwrap();
    assert_eq!(material(&pages, 510.0, 2.0), "bare-soil");
}

#[test]
fn damaged_rasters_are_refused_or_read() {
    let folder = site();
    let path = folder.path().join("cover.tif");
    let whole = fs::read(&path).unwrap();
    let directory = u32::from_le_bytes(whole[4..8].try_into().unwrap()) as usize;
    let mut options = options(folder.path(), "a.hop");
    (options.steps, options.spacing) = (false, Some(32.0));
    let mut refused = 0;

    for at in (0..8).chain(directory..whole.len()).step_by(3) {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            fs::write(&path, bytes).unwrap();
            refused += u32::from(build(&options, &Silent).is_err());
        }
    }

    for length in (0..whole.len()).step_by(whole.len() / 40) {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(build(&options, &Silent).is_err(), "a prefix of {length} bytes");
    }

    assert!(refused > 20, "{refused}");
}

/// The mistakes of a recipe whose elevation and land cover are there.
fn mistakes(text: &str) -> Vec<String> {
    let folder = site();
    let path = folder.path().join("place.toml");
    let whole = format!("[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n{text}");
    fs::write(&path, whole).unwrap();
    match Recipe::check(&path).unwrap() {
        Ok(recipe) => recipe.outline().err().unwrap_or_default().iter().map(ToString::to_string).collect(),
        Err(mistakes) => mistakes.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn mistakes_are_told_with_their_lines() {
    let cover = "[[land_cover]]\nfile = \"cover.tif\"\n";
    for (text, line, words) in [
        (format!("{cover}scheme = \"clc\"\n"), 6, "worldcover, corine, nlcd"),
        (cover.to_owned(), 4, "needs scheme"),
        (format!("{cover}scheme = \"nlcd\"\nclasses = {{ 1 = \"water\" }}\n"), 4, "not both"),
        (format!("{cover}classes = {{ 1 = \"watr\" }}\n"), 6, "did you mean \"water\"?"),
        (format!("{cover}classes = {{ one = \"water\" }}\n"), 6, "one is no class"),
        (format!("{cover}classes = {{}}\n"), 6, "names none"),
        (format!("{cover}scheme = \"nlcd\"\nnodat = 0\n"), 7, "did you mean `nodata`?"),
        ("[material.asphal]\ncolour = \"#404040\"\n".to_owned(), 4, "did you mean \"asphalt\"?"),
        ("[material.asphalt]\ncolour = \"#40404\"\n".to_owned(), 5, "a colour is #rrggbb"),
        ("[material.maize]\nnumber = 7\n".to_owned(), 5, "must be 31 to 255"),
        ("[material.maize]\nnumber = 200\nlike = \"corn\"\n".to_owned(), 6, "like is a material"),
        ("[material.sand]\nnumber = 200\n".to_owned(), 5, "has the number 17"),
        ("[material.sand]\ntint = 2\n".to_owned(), 5, "must be 0 to 1"),
        (
            "[material.a]\nnumber = 200\n[material.b]\nnumber = 200\n".to_owned(),
            6,
            "both have the number 200",
        ),
    ] {
        let told = mistakes(&text);
        assert!(told.len() == 1 && told[0].contains(words), "{text}: {told:?}");
        assert!(told[0].starts_with(&format!("line {line}:")), "{text}: {told:?}");
    }

    assert_eq!(
        mistakes(&format!("{cover}scheme = \"worldcover\"\n[material.maize]\nnumber = 200\n")),
        [""; 0]
    );
    let float = mistakes("[[land_cover]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\nscheme = \"nlcd\"\n");
    assert!(float.len() == 1 && float[0].contains("whole numbers"), "{float:?}");
}

#[test]
fn a_recipe_has_classes_of_its_own() {
    let folder = site();
    let path = folder.path().join("place.toml");
    let text = "[place]\nspacing_m = 8\n[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n[material.maize]\nnumber = 200\nlike = \"crop\"\n\
        [[land_cover]]\nfile = \"cover.tif\"\nclasses = { 30 = \"maize\", 80 = \"water\" }\nnodata = [77, 33, 10]\n";
    fs::write(&path, text).unwrap();
    let recipe = Recipe::read(&path).unwrap();
    let known = BTreeMap::from([(30, Material::Own(200)), (80, Material::Water)]);
    assert_eq!(recipe.options.land_cover[0].scheme, Scheme::Own(known));
    build(&recipe.options, &Silent).unwrap();
    let pages = PageFile::open(&recipe.options.output).unwrap();
    assert_eq!(material(&pages, 300.0, 20.0), "maize");
    let metadata = &pages.header().metadata;
    assert_eq!((metadata.materials[1].number, metadata.material(200)), (200, Material::Crops));
}

#[test]
fn natural_areas_are_ground_and_leave_imagery_as_it_is() {
    let folder = site();
    let ring: Vec<String> = [(300.0, 200.0), (400.0, 200.0), (400.0, 300.0), (300.0, 300.0), (300.0, 200.0)]
        .iter()
        .map(|(x, y)| format!("[{},{}]", WEST + x, SOUTH + y))
        .collect();
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    let sand = format!(
        r#"{{"type":"FeatureCollection",{crs},"features":[{{"type":"Feature","properties":{{"natural":"sand"}},"geometry":{{"type":"Polygon","coordinates":[[{}]]}}}}]}}"#,
        ring.join(",")
    );
    fs::write(folder.path().join("road.geojson"), sand).unwrap();
    let image = image::RgbImage::from_pixel(64, 64, image::Rgb([10, 20, 200]));
    image.save(folder.path().join("photo.png")).unwrap();
    let (x, y) = (WEST + 4.0, SOUTH + 508.0);
    fs::write(folder.path().join("photo.pgw"), format!("8\n0\n0\n-8\n{x}\n{y}\n")).unwrap();
    let mut options = options(folder.path(), "a.hop");

    let colour = |options: &BuildOptions, x: u32, y: u32| {
        build(options, &Silent).unwrap();
        let pages = PageFile::open(&options.output).unwrap();
        assert_eq!(material(&pages, 350.0, 250.0), "sand");
        assert_eq!(material(&pages, 305.0, 205.0), "sand");
        assert_eq!(material(&pages, 295.0, 205.0), "grass");
        let id = hedgehop::voxel::PageId { level: 0, px: x / 256, py: y / 256 };
        let page = pages.page(id).unwrap().unwrap();
        page.colours[page.sample(x % 256, y % 256)]
    };

    let [red, _, blue] = colour(&options, 350, 250);
    assert!(red > 150 && red > blue, "{red} {blue}");
    options.imagery = vec![hedgehop_modeling::ImageryFile {
        path: folder.path().join("photo.png"),
        crs: Some("EPSG:32632".into()),
        bands: None,
        extent: None,
    }];
    assert_eq!(colour(&options, 350, 250), [10, 20, 200]);
    let sand = Material::Sand;
    let finish = Finish { material: sand, name: "sand".into(), tint: 0.5, ..Finish::default() };
    options.materials = Materials::new(vec![finish]);
    let [red, _, blue] = colour(&options, 350, 250);
    assert!((100..200).contains(&red) && (150..200).contains(&blue), "{red} {blue}");
}

#[test]
fn synthetic_ground_states_its_material() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("place.toml");
    let text = "[place]\nlocal = true\nbbox = [0, 0, 1000, 1000]\nspacing_m = 10\n\
        [[terrain]]\nkind = \"plane\"\nheight_m = 100\nmaterial = \"grass\"\n\
        [[terrain]]\nkind = \"dome\"\ncentre = [500, 500]\nradius_m = 200\nheight_m = 50\nmaterial = \"rock\"\n\
        [[texture]]\nkind = \"checks\"\ncolours = [\"#808080\", \"#909090\"]\nsize_m = 40\ncentre = [500, 500]\nradius_m = 50\nmaterial = \"concrete\"\n";
    fs::write(&path, text).unwrap();
    let recipe = Recipe::read(&path).unwrap();
    build(&recipe.options, &Silent).unwrap();
    let pages = PageFile::open(&recipe.options.output).unwrap();
    let at = |x: f64, y: f64| {
        let found = attributes_at(&pages, glam::dvec2(x, y)).unwrap().unwrap();
        pages.header().metadata.material_name(found.material)
    };
    assert_eq!([at(105.0, 105.0), at(605.0, 505.0), at(515.0, 505.0)], ["grass", "rock", "concrete"]);
}
