use std::fs;
use std::path::PathBuf;

use super::*;
use crate::NodataFill;
use crate::synthetic::TextureExamples;
use hedgehop::voxel::{DetailRecord, Material};
use hedgehop_geo::VerticalDatum;
use hedgehop_texture::Generator;

mod fitting;
mod marks;
mod patches;
mod placing;

/// A folder with a small elevation raster, and recipes beside it.
struct Site {
    folder: tempfile::TempDir,
}

impl Site {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let heights = ["10 11 12 13 14 15 16 17"; 8].join("\n");
        let head = "ncols 8\nnrows 8\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n";
        fs::write(folder.path().join("dem.asc"), format!("{head}{heights}\n")).unwrap();
        fs::write(folder.path().join("text.tif"), "no raster").unwrap();
        fs::write(
            folder.path().join("flight.csv"),
            "time_s,x_m,y_m,alt_m\n0,500000,5000000,90\n9,500080,5000080,90\n",
        )
        .unwrap();
        Self { folder }
    }

    fn put(&self, text: &str) -> PathBuf {
        let path = self.folder.path().join("place.toml");
        fs::write(&path, text).unwrap();
        path
    }

    fn read(&self, text: &str) -> Recipe {
        let read = Recipe::check(&self.put(text)).unwrap();
        read.unwrap_or_else(|mistakes| panic!("{mistakes:?}"))
    }

    /// Every mistake, those of tables, or of files and what is asked of them.
    fn mistakes(&self, text: &str) -> Vec<Mistake> {
        match Recipe::check(&self.put(text)).unwrap() {
            Ok(recipe) => recipe.outline().err().unwrap_or_default(),
            Err(mistakes) => mistakes,
        }
    }
}

const ELEVATION: &str = "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n";

#[test]
fn a_recipe_says_what_flags_say() {
    let site = Site::new();
    let text = format!(
        "[place]\noutput = \"out/valley.hop\"\ncrs = \"EPSG:32632\"\nbbox = [500000, 5000000, 500080, 5000080]\nvoids = \"interpolate\"\n\
         outside_m = 16\n{ELEVATION}vertical_datum = \"egm2008\"\nnodata = -99\n\
         [[elevation]]\nfile = [\"dem.asc\", \"dem.asc\"]\n\
         [[imagery]]\nfile = \"text.tif\"\nbands = [3, 2, 1]\n\
         [[corridor]]\npath = \"flight.csv\"\nwidth_m = 50\nspacing_m = 4\n\
         [shadows]\nazimuth_deg = 250\nelevation_deg = 12\n"
    );

    let Recipe { options, shadows, lines, .. } = site.read(&text);
    assert_eq!(options.output, site.folder.path().join("out/valley.hop"));
    assert_eq!(
        (options.crs.as_deref(), options.spacing, options.outside),
        (Some("EPSG:32632"), Some(4.0), Some(16.0))
    );
    assert_eq!(options.bbox, Some([500_000.0, 5_000_000.0, 500_080.0, 5_000_080.0]));
    assert_eq!(options.nodata_fill, NodataFill::Interpolate);
    assert_eq!(options.elevation.len(), 3);
    let first = &options.elevation[0];
    assert_eq!((first.datum, &first.nodata[..]), (Some(VerticalDatum::Egm2008), &[-99.0][..]));
    assert_eq!(options.elevation[1].crs, None);
    assert_eq!(options.imagery[0].bands, Some([3, 2, 1]));
    assert_eq!((options.corridors[0].width, options.corridors[0].spacing), (50.0, 4.0));
    assert!(shadows.is_some());
    assert_eq!((lines.place, lines.elevation, lines.imagery), (1, vec![7, 12, 12], vec![14]));
}

#[test]
fn a_spacing_beside_corridors_is_that_of_pixels_without_georeferencing() {
    let site = Site::new();
    let bare = image::ImageBuffer::from_fn(8, 8, |x, y| image::Luma([(100 * x + y) as u16]));
    bare.save(site.folder.path().join("bare.png")).unwrap();
    let corridor = "[[corridor]]\npath = \"flight.csv\"\nwidth_m = 50\nspacing_m = 2.5\n";
    let bare = format!("[[elevation]]\nfile = \"bare.png\"\n{corridor}");
    let spacings = |text: &str| {
        let options = site.read(text).options;
        (options.spacing, options.raw_spacing)
    };
    assert_eq!(spacings(&format!("[place]\nspacing_m = 10\n{bare}")), (Some(2.5), Some(10.0)));

    // A finer corridor must not shrink the place.
    assert_eq!(spacings(&bare), (Some(2.5), None));
    let mistakes = site.mistakes(&format!("[place]\nlocal = true\n{bare}"));
    let told = |mistake: &Mistake| {
        mistake.line == 3 && mistake.what.contains("in metres with `spacing_m` of [place]")
    };
    assert!(mistakes.len() == 1 && told(&mistakes[0]), "{mistakes:?}");
    assert_eq!(spacings(&format!("{ELEVATION}{corridor}")), (Some(2.5), None));
    assert_eq!(
        spacings("[place]\nspacing_m = 10\n[[elevation]]\nfile = \"bare.png\"\n"),
        (Some(10.0), Some(10.0))
    );
}

#[test]
fn the_smallest_recipe_tells_what_it_would_build() {
    let site = Site::new();
    let recipe = site.read(ELEVATION);
    assert_eq!(recipe.options.output, site.folder.path().join("place.hop"));
    let outline = recipe.outline().unwrap();
    assert_eq!((outline.grid.nx, outline.grid.ny, outline.grid.spacing), (8, 8, 10.0));
}

/// Recipes, the line of what is wrong with each, and words that its sentence has.
const WRONG: &[(&str, usize, &[&str])] = &[
    ("", 1, &["[[elevation]]", "file"]),
    ("[place]\nspacing = 3\n", 2, &["no key `spacing`", "did you mean `spacing_m`"]),
    ("[place]\nspacing_m = -3\n", 2, &["spacing_m", "more than 0"]),
    ("[place]\nspacing_m = \"ten\"\n", 2, &["spacing_m is a number, not string"]),
    ("[place]\nspacing_m = nan\n", 2, &["spacing_m"]),
    ("[place]\nbbox = [1, 2, 3]\n", 2, &["bbox is west, south, east and north"]),
    ("[place]\nbbox = [3, 2, 1, 4]\n", 2, &["west is less than east"]),
    ("[place]\ncrs = \"EPSG:nothing\"\n", 2, &["EPSG"]),
    ("[place]\nvoids = \"fill\"\n", 2, &["interpolate", "height"]),
    ("[place]\nvoids = 1e9\n", 2, &["voids is", "−20000 to 20000"]),
    ("[place]\nlocal = 1\n", 2, &["local is true or false"]),
    ("[place\nlocal = true\n", 1, &["]"]),
    ("place = 3\n", 1, &["[place] is a table"]),
    ("[plaice]\n", 1, &["no key `plaice`", "did you mean `place`"]),
    ("[elevation]\nfile = \"dem.asc\"\n", 1, &["[[elevation]]", "two brackets"]),
    ("[[elevation]]\ncrs = \"EPSG:32632\"\n", 1, &["needs `file`"]),
    ("[[elevation]]\nfile = \"absent.tif\"\n", 2, &["absent.tif", "cannot read"]),
    ("[[elevation]]\nfile = \".\"\n", 2, &["no file"]),
    ("[[elevation]]\nfile = []\n", 2, &["file names none"]),
    ("[[elevation]]\nfile = \"dem.asc\"\nvertical_datum = \"sea\"\n", 3, &["vertical_datum is one of msl"]),
    ("[[elevation]]\nfile = \"dem.asc\"\nnodata = \"none\"\n", 3, &["nodata", "a value, or several"]),
    ("[[cloud]]\nground_only = true\n", 1, &["[[cloud]] needs `file`"]),
    ("[[cloud]]\nfile = \"text.tif\"\nground_only = 1\n", 3, &["ground_only is true or false"]),
    ("[[imagery]]\nfile = \"text.tif\"\nbands = [0, 1, 2]\n", 3, &["counted from 1"]),
    ("[[corridor]]\npath = \"flight.csv\"\nspacing_m = 1\n", 1, &["needs `width_m`"]),
    ("[[corridor]]\npath = \"text.tif\"\nwidth_m = 9\nspacing_m = 1\n", 2, &["text.tif"]),
    ("[place]\noutside_m = 16\n", 2, &["outside_m is about", "add a [[corridor]]"]),
    (
        "[place]\nspacing_m = 4\n[[elevation]]\nfile = \"dem.asc\"\n[[corridor]]\npath = \"flight.csv\"\nwidth_m = 9\nspacing_m = 1\n",
        2,
        &["spacing_m says nothing beside a [[corridor]]", "outside_m"],
    ),
    (
        "[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\ncrs = \"EPSG:32632\"\n",
        4,
        &["crs is of the file of area", "add area"],
    ),
    (
        "[[scatter]]\nobjects = [\"shrub\", \"rock\"]\nspacing_m = 5\npitch_deg = 5\n",
        4,
        &["pitch_deg is how models of files stand"],
    ),
    ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nroll_deg = 5\n", 4, &["roll_deg", "leave it out"]),
    ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nup = \"z\"\n", 4, &["up is how", "leave it out"]),
    (
        "[[texture]]\nkind = \"checkerboard\"\nsize_m = 3\ncolours = [\"red\", \"blue\"]\nseed = 7\n",
        5,
        &["checkerboards", "leave seed out", "\"checks\""],
    ),
    (
        "[[object]]\nfile = \"dem.asc\"\nat = [1, 2]\nmaterial = \"wodo\"\n",
        4,
        &["no material \"wodo\"", "did you mean \"wood\"?"],
    ),
    (
        "[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nmaterial = \"wood\"\n",
        4,
        &["material", "built-in plants and rocks have theirs"],
    ),
    (
        "[[object]]\nfile = \"dem.asc\"\nat = [1, 2]\nup_m = 1e6\n",
        4,
        &["up_m must be −10000 to 10000 m, not 1000000"],
    ),
    ("[[object]]\nfile = \"dem.asc\"\nat = [1, 2]\nup_m = -10001\n", 4, &["up_m must be −10000 to 10000 m"]),
    (
        "[[scatter]]\nobjects = [\"shrub\", \"dem.asc\"]\nspacing_m = 5\nscale = [1, 101]\n",
        4,
        &["scale of built-in plants and rocks must be at most 100, not 101"],
    ),
    (
        "[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nseed = -1\n",
        4,
        &["seed is a whole number from 0 to 4294967295, not integer `-1`"],
    ),
    (
        "[[texture]]\nkind = \"waves\"\nsize_m = 3\ncolours = [\"red\", \"blue\"]\nseed = 4294967296\n",
        5,
        &["seed is a whole number from 0 to 4294967295, not integer `4294967296`"],
    ),
    (
        "[[terrain]]\nkind = \"fractal\"\namplitude_m = 9\nwavelength_m = 9\nseed = 1.5\n",
        5,
        &["seed is a whole number from 0 to 4294967295, not decimal number `1.5`"],
    ),
    (
        "[detail]\nseed = 99999999999999999999\n",
        2,
        &["seed is a whole number from 0 to 4294967295, not integer `99999999999999999999`"],
    ),
    ("[material.hay]\nnumber = 300\n", 2, &["number is a whole number from 0 to 255, not integer `300`"]),
    ("[shadows]\n", 1, &["azimuth_deg", "time"]),
    ("[shadows]\nazimuth_deg = 900\nelevation_deg = 1\n", 2, &["azimuth_deg"]),
    ("[place]\nlocal = true\nlocal = true\n", 3, &["duplicate"]),
    ("[place]\ninterpolation = \"cubic\"\n", 2, &["interpolation is one of linear, bicubic, spline"]),
    ("[[terrain]]\nheight_m = 3\n", 1, &["needs `kind`"]),
    ("[[terrain]]\nkind = \"hill\"\n", 2, &["kind is one of plane, fractal", "\"hill\""]),
    ("[[terrain]]\nkind = \"plane\"\nheight_m = 1e9\n", 3, &["height_m must be −20000 to 20000 m"]),
    ("[[terrain]]\nkind = \"plane\"\nheight_m = 3\nslope_percent = 4\n", 1, &["needs `centre`"]),
    (
        "[[terrain]]\nkind = \"fractal\"\namplitude_m = 9\nwavelength_m = 0\n",
        4,
        &["wavelength_m", "more than 0"],
    ),
    (
        "[[terrain]]\nkind = \"fractal\"\namplitude_m = 9\nwavelength_m = 9\nroughness = 1\n",
        5,
        &["roughness must be 0.2 to 0.9"],
    ),
    (
        "[[terrain]]\nkind = \"fractal\"\namplitude_m = 9\nwavelength_m = 9\ncentre = [1, 2]\n",
        1,
        &["needs `radius_m`"],
    ),
    (
        "[[terrain]]\nkind = \"ridge\"\nline = [[1, 2], [1, 2]]\nheight_m = 9\nwidth_m = 99\n",
        3,
        &["line is 2 to 1000 places", "not all the same"],
    ),
    (
        "[[terrain]]\nkind = \"ridge\"\nline = [[1, 2], [3]]\nheight_m = 9\nwidth_m = 99\n",
        3,
        &["line is a place, [x, y]"],
    ),
    (
        "[[terrain]]\nkind = \"valley\"\nline = [[1, 2], [3, 4]]\ndepth_m = 9\nwidth_m = 9\nfloor_m = 9\n",
        1,
        &["floor_m is 9", "less than width_m"],
    ),
    (
        "[[terrain]]\nkind = \"cone\"\ncentre = [1, 2]\nradius_m = 9\nheight_m = 9\nheigth_m = 9\n",
        6,
        &["no key `heigth_m`", "did you mean `height_m`"],
    ),
    (
        "[[terrain]]\nkind = \"plateau\"\ncentre = [1, 2]\nradius_m = 9\nflank_m = 9\n",
        1,
        &["needs height_m", "or level_m"],
    ),
    (
        "[[terrain]]\nkind = \"pond\"\ncentre = [1, 2]\nradius_m = 9\nlevel_m = 9\nragged = 0.6\n",
        6,
        &["ragged must be 0 to 0.5"],
    ),
    ("[detail]\nroughness = \"rough\"\n", 2, &["roughness is \"auto\", or 0.2 to 0.9"]),
    ("[detail]\nseed = -1\n", 2, &["seed"]),
    (
        "[detail]\nimagery = \"gras\"\n",
        2,
        &["no texture is called \"gras\"", "\"maps\"", "or \"match\" or \"off\""],
    ),
    ("[detail]\nimagery = 3\n", 2, &["imagery is the name of a pattern", "[detail.imagery]"]),
    ("[detail.imagery]\nstrength = 3\n", 2, &["strength must be 0 to 2"]),
    ("[detail.imagery]\npattern = \"maps\"\noctaves = 3\n", 3, &["the pattern \"maps\" has no octaves"]),
    ("[detail.imagery]\noctaves = 9\n", 2, &["9 octaves; want 1 to 6"]),
    (
        "[detail.imagery]\npattern = \"quantity\"\nmode = 16\n",
        3,
        &["a mode of quantities is 0 to 15, not 16"],
    ),
    ("[detail.imagery]\npattern = \"quantity\"\nmode = 0\n", 1, &["nothing is left of a texture pattern"]),
    (
        "[detail.imagery]\npattern = \"waves\"\nwavelength_voxels = 3\n",
        3,
        &["wavelength_voxels must be 0.2 to 2"],
    ),
    (
        "[detail.imagery]\nmaterials = { grass = 5 }\n",
        2,
        &["the factor of grass must be a number from 0 to 4"],
    ),
    ("[detail.imagery]\nmaterials = { gras = 1 }\n", 2, &["there is no material \"gras\"", "did you mean"]),
    ("[detail.imagery]\nexamples = \"fine.tif\"\n", 2, &["examples is of pattern = \"match\" alone"]),
    ("[detail.imagery]\npattern = \"match\"\nexamples = \"no.tif\"\n", 3, &["no.tif"]),
    (
        "[detail.imagery]\npattern = \"match\"\npixel_m = 0.1\n",
        3,
        &["pixel_m is the side of the pixels of examples"],
    ),
    (
        "[detail.imagery]\ndisplacement = 7\n",
        2,
        &["displacement must be 0 to 5 m, or a table", "{ grass = 0.1 }"],
    ),
    ("[detail.imagery]\ndisplacement = \"high\"\n", 2, &["displacement must be 0 to 5 m"]),
    (
        "[detail.imagery]\ndisplacement = { grass = -0.1 }\n",
        2,
        &["the displacement of grass must be a number from 0 to 5 m"],
    ),
    (
        "[detail.imagery]\ndisplacement = { gras = 1 }\n",
        2,
        &["there is no material \"gras\"", "did you mean"],
    ),
    ("[detail.imagery]\nstrenght = 1\n", 2, &["has no key `strenght`", "did you mean `strength`"]),
    (
        "[[texture]]\nkind = \"waves\"\nsize_m = 3\ncolours = [\"#123456\", \"greenish\"]\n",
        4,
        &["#rrggbb", "greenish"],
    ),
    ("[[texture]]\nkind = \"waves\"\nsize_m = 3\ncolours = [\"#123456\"]\n", 4, &["colours are 2 to 256"]),
    ("[palette]\nheights = [[9, \"red\"], [3, \"blue\"]]\n", 2, &["heights are one stop at least", "higher"]),
    (
        "[palette]\nheights = [[9, \"red\"]]\nslopes = [[95, \"blue\"]]\n",
        3,
        &["slopes must be 1 to less than 90"],
    ),
];

#[test]
fn detail_of_imagery_is_not_that_of_heights() {
    let site = Site::new();
    let read = |text: &str| site.read(&format!("{MADE}{text}")).options.synthetic;

    let usual = read("[detail]\n");
    assert!(usual.detail.is_some() && usual.below_voxel.is_none());
    let off = read("[detail]\nimagery = \"off\"\n");
    assert_eq!((off.detail, off.below_voxel.unwrap().strength), (None, 0.0));
    let both = read("[detail]\nseed = 3\nimagery = \"maps\"\n");
    assert!(both.detail.is_some_and(|detail| detail.seed == 3));
    assert_eq!(both.below_voxel, Some(DetailRecord { pattern: Generator::Maps, ..DetailRecord::default() }));

    let all = "[detail.imagery]\npattern = \"waves\"\nwavelength_voxels = 0.4\nseed = 5\nstrength = 0.5\nrelief = 0\nmaterials = { grass = 2, water = 0.1 }\ndisplacement = { gravel = 0.05, grass = 1 }\n";
    let record = DetailRecord {
        pattern: Generator::Waves { wavelength: 6.0 },
        seed: 5,
        strength: 0.5,
        relief: 0.0,
        materials: [("grass".to_owned(), 2.0), ("water".to_owned(), 0.1)].into(),
        displacement: 0.0,
        displacements: [("gravel".to_owned(), 0.05), ("grass".to_owned(), 1.0)].into(),
        matched: None,
    };
    let found = read(all);
    assert_eq!((found.detail, found.below_voxel, found.examples), (None, Some(record), None));

    let everywhere = read("[detail.imagery]\ndisplacement = 0.25\n").below_voxel;
    assert_eq!(everywhere, Some(DetailRecord { displacement: 0.25, ..DetailRecord::default() }));

    // Light on the ground is in the imagery that patterns are matched from.
    let matched = read("[detail]\nimagery = \"match\"\n");
    assert_eq!(
        (matched.below_voxel.unwrap().relief, matched.examples),
        (0.0, Some(TextureExamples::default()))
    );
    fs::write(site.folder.path().join("fine.tif"), "").unwrap();
    let named =
        read("[detail.imagery]\npattern = \"match\"\nexamples = \"fine.tif\"\npixel_m = 0.1\nseed = 4\n");
    let examples = named.examples.unwrap();
    assert_eq!((examples.files.len(), examples.pixel_m, examples.seed), (1, Some(0.1), 4));
}

/// Ground without elevation.
const MADE: &str = "[place]\nlocal = true\nspacing_m = 4\nbbox = [0, 0, 800, 400]\n[[terrain]]\nkind = \"plane\"\nheight_m = 7\n";

#[test]
fn a_place_can_be_made_of_nothing_but_a_recipe() {
    let site = Site::new();
    let recipe = site.read(MADE);
    assert!(recipe.options.elevation.is_empty());
    let outline = recipe.outline().unwrap();
    assert_eq!((outline.grid.nx, outline.grid.ny, outline.grid.spacing), (200, 100, 4.0));

    for (without, line, key) in [
        ("bbox = [0, 0, 800, 400]\n", 1, "bbox"),
        ("spacing_m = 4\n", 1, "spacing_m"),
        ("local = true\n", 1, "local"),
    ] {
        let mistakes = site.mistakes(&MADE.replace(without, ""));
        let told =
            |mistake: &Mistake| mistake.line == line && mistake.what.contains(&format!("`{key}` of [place]"));
        assert!(mistakes.len() == 1 && told(&mistakes[0]), "{mistakes:?}");
    }

    let mistakes = site.mistakes(
        &MADE.replace("plane", "dome").replace("height_m", "centre = [1, 2]\nradius_m = 9\nheight_m"),
    );
    assert!(mistakes.len() == 1 && mistakes[0].what.contains("kind = \"plane\""), "{mistakes:?}");
}

#[test]
fn a_plane_in_which_something_is_wrong_is_no_missing_one() {
    let site = Site::new();
    for (plane, line, words) in [
        ("height_m = 7\nslope_percent = 3\n", 5, "[[terrain]] needs `centre`"),
        ("height_m = 1e9\n", 7, "height_m must be"),
        ("", 5, "[[terrain]] needs `height_m`"),
    ] {
        let mistakes = site.mistakes(&MADE.replace("height_m = 7\n", plane));
        let told = |mistake: &Mistake| mistake.line == line && mistake.what.contains(words);
        assert!(mistakes.len() == 1 && told(&mistakes[0]), "{plane}: {mistakes:?}");
    }
}

#[test]
fn every_mistake_is_told_with_its_line() {
    let site = Site::new();
    for (text, line, words) in WRONG {
        let mistakes = site.mistakes(text);
        let told =
            |mistake: &Mistake| mistake.line == *line && words.iter().all(|word| mistake.what.contains(word));
        assert!(mistakes.iter().any(told), "{text:?}: {mistakes:?}");
    }
}

#[test]
fn all_mistakes_of_a_long_recipe_are_told_at_once() {
    let site = Site::new();
    // Those that leave tables whole, one after the other, each in a table of its own.
    let tables = WRONG.iter().filter(|(text, ..)| text.starts_with("[["));
    let (mut text, mut wanted) = (String::new(), Vec::new());

    for (table, line, words) in tables.cycle().take(400) {
        wanted.push((text.lines().count() + line, *words));
        text += table;
        text += &format!("# {}\n", "a page of remarks ".repeat(20)).repeat(12);
    }

    let mistakes = site.mistakes(&text);
    for (line, words) in &wanted {
        let told =
            |mistake: &Mistake| mistake.line == *line && words.iter().all(|word| mistake.what.contains(word));
        assert!(mistakes.iter().any(told), "line {line}: {words:?}");
    }

    assert_eq!(mistakes.len(), wanted.len());
    assert!(mistakes.is_sorted_by_key(|mistake| mistake.line));
    let error = Recipe::read(&site.put(&text)).unwrap_err().to_string();
    assert!(error.contains("and 399 more") && error.contains("recipe check"), "{error}");
}

#[test]
fn what_is_wrong_with_files_is_told_with_their_tables_in_the_words_of_recipes() {
    let site = Site::new();
    for (text, line, words) in [
        (
            "[[elevation]]\nfile = \"dem.asc\"\n".to_owned(),
            1,
            ["states no coordinate reference system", "`crs` of [[elevation]]"],
        ),
        (format!("{ELEVATION}[[imagery]]\nfile = \"text.tif\"\n"), 4, ["text.tif", ""]),
        (
            format!("{ELEVATION}[[object]]\nfile = \"text.tif\"\nat = [0, 0]\n"),
            4,
            ["no model that is known by its name", ".glb"],
        ),
        (format!("{ELEVATION}\n[[cloud]]\nfile = \"text.tif\"\n"), 5, ["text.tif", "no LAS or LAZ file"]),
        (
            format!("[place]\nbbox = [0, 0, 9, 9]\n{ELEVATION}"),
            2,
            ["`bbox` of [place]", "outside the elevation"],
        ),
        (format!("[place]\ncrs = \"EPSG:4326\"\n{ELEVATION}"), 2, ["`crs` of [place]", "not in metres"]),
        (
            format!("{ELEVATION}[shadows]\nazimuth_deg = 9\nelevation_deg = -3\n"),
            4,
            ["above the horizon", ""],
        ),
    ] {
        let mistakes = site.mistakes(&text);
        let told =
            |mistake: &Mistake| mistake.line == line && words.iter().all(|word| mistake.what.contains(word));
        assert!(mistakes.len() == 1 && told(&mistakes[0]), "{text}: {mistakes:?}");
    }
}

#[test]
fn the_template_is_sound_but_for_its_file() {
    let site = Site::new();
    let mistakes = site.mistakes(TEMPLATE);
    assert!(mistakes.len() == 1 && mistakes[0].what.contains("dem.tif"), "{mistakes:?}");
    // With all that it has commented out it has all keys, none of which is unknown.
    let is_key = |line: &str| line.starts_with("# ") && (line.contains(" = ") || line.starts_with("# ["));
    let whole: Vec<_> = TEMPLATE.lines().map(|line| if is_key(line) { &line[2..] } else { line }).collect();
    let mistakes = site.mistakes(&whole.join("\n"));
    assert!(!mistakes.is_empty());
    assert!(mistakes.iter().all(|mistake| mistake.what.contains("cannot read")), "{mistakes:?}");
}

#[test]
fn objects_and_scatters_say_what_they_are() {
    let site = Site::new();
    let model = site.folder.path().join("box.obj");
    fs::write(&model, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let text = format!(
        "[place]\nlocal = true\n{ELEVATION}\n[[object]]\nfile = \"box.obj\"\nat = [[1, 2], [3, 4.5]]\nheading_deg = 30\nscale = 2\nmaterial = \"wood\"\n\
         [[scatter]]\nobjects = [\"conifer\", \"box.obj\"]\nper_hectare = 100\nscale = [0.5, 2]\nheights_m = [0, 9]\navoid = false\nmaterial = \"hay\"\n\
         [material.hay]\nnumber = 201\nlike = \"crop\"\n"
    );
    let recipe = Recipe::check(&site.put(&text)).unwrap().unwrap();
    let [object] = &recipe.options.objects[..] else { panic!() };
    assert_eq!((&object.paths[0], &object.places[..]), (&model, &[[1.0, 2.0], [3.0, 4.5]][..]));
    assert_eq!((object.stance.heading_deg, object.stance.scale), (30.0, 2.0));
    let [scatter] = &recipe.options.scatters[..] else { panic!() };
    assert_eq!(scatter.forms[1], crate::object::ScatterForm::File(model));
    assert_eq!((scatter.spacing_m, scatter.scale, scatter.heights_m), (10.0, [0.5, 2.0], Some([0.0, 9.0])));
    assert!(!scatter.avoid && scatter.slopes_deg.is_none());
    assert_eq!((object.material, scatter.material), (Material::Wood, Material::Own(201)));

    // Of plants and files together the files stand as it says, and polygons have a system.
    fs::write(site.folder.path().join("woods.geojson"), "{}").unwrap();
    let text = format!(
        "{ELEVATION}[[scatter]]\nobjects = [\"conifer\", \"box.obj\"]\nspacing_m = 9\nup = \"z\"\nroll_deg = 3\narea = \"woods.geojson\"\ncrs = \"EPSG:32632\"\n"
    );
    let both = site.read(&text);
    let [scatter] = &both.options.scatters[..] else { panic!() };
    assert_eq!((scatter.stance.is_z_up, scatter.stance.roll_deg), (Some(true), 3.0));
    assert_eq!(scatter.crs.as_deref(), Some("EPSG:32632"));

    for (table, words) in [
        ("[[object]]\nfile = \"box.obj\"\n", "[[object]] needs `at`"),
        ("[[object]]\nfile = \"box.obj\"\nat = []\n", "one place at least"),
        ("[[object]]\nfile = \"box.obj\"\nat = [1, 2]\nup = \"x\"\n", "\"y\" or \"z\""),
        ("[[object]]\nfile = \"box.obj\"\nat = [1, 2]\nscale = 0\n", "more than 0"),
        ("[[scatter]]\nobjects = \"oak\"\nspacing_m = 5\n", "neither a file nor one of broadleaf"),
        ("[[scatter]]\nobjects = \"shrub\"\n", "needs `spacing_m`"),
        ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nper_hectare = 5\n", "keep one"),
        ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nscale = [2, 1]\n", "the first is the least"),
        ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\non = \"conifers\"\n", "did you mean \"conifer\"?"),
        ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\non = []\n", "on names no material"),
        ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nheading_deg = 5\n", "has no key `heading_deg`"),
        ("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 5\nslopes_deg = [20, 95]\n", "less than 90"),
    ] {
        let mistakes = site.mistakes(&format!("{ELEVATION}{table}"));
        assert!(mistakes.len() == 1 && mistakes[0].what.contains(words), "{table}: {mistakes:?}");
    }
}
