//! `build PLACE.toml`, `new` and `recipe check` from outside.

mod common;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use common::{ends, run};

/// A folder with an elevation raster that says nothing of its reference system, and a path over it.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let row = |y: u32| (0..40_u32).map(|x| format!("{}", 100 + x * y % 37)).collect::<Vec<_>>().join(" ");
    let rows: Vec<_> = (0..40).map(row).collect();
    let head = "ncols 40\nnrows 40\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n";
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write("dem.asc", &format!("{head}{}\n", rows.join("\n")));
    write("place.toml", "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n");
    folder
}

#[test]
fn a_recipe_builds_what_the_flags_build() {
    let folder = site();
    ends(&run(&folder, "build place.toml"), 0);
    ends(&run(&folder, "build --elevation dem.asc --elevation-crs EPSG:32632 -o flags.hop"), 0);
    let [recipe, flags] =
        ["place.hop", "flags.hop"].map(|name| fs::read(folder.path().join(name)).expect("a database"));
    assert!(recipe == flags, "both say the same");
    let again = ends(&run(&folder, "build place.toml --jobs 1 --memory 300M"), 0);
    assert!(again.contains("pages are as before"), "{again}");
    assert!(fs::read(folder.path().join("place.hop")).expect("a database") == flags);
    let fresh = ends(&run(&folder, "build place.toml --fresh"), 0);
    assert!(!fresh.contains("as before"), "{fresh}");
    // What no build of a recipe left is not replaced unasked.
    fs::copy(folder.path().join("flags.hop"), folder.path().join("theirs.hop")).expect("a copy");
    let theirs = ends(&run(&folder, "build place.toml -o theirs.hop"), 2);
    assert!(theirs.contains("theirs.hop exists; --overwrite"), "{theirs}");
    ends(&run(&folder, "build place.toml -o theirs.hop --overwrite"), 0);
    ends(&run(&folder, "build place.toml -o other.hop"), 0);
    assert!(fs::read(folder.path().join("other.hop")).expect("a database") == flags);
}

#[test]
fn names_in_a_recipe_count_from_its_folder() {
    let folder = site();
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("a folder");
    ["dem.asc", "place.toml"].iter().for_each(|name| {
        fs::rename(folder.path().join(name), inner.join(name)).expect("the file moves");
    });
    let told = ends(&run(&folder, "recipe check inner/place.toml"), 0);
    assert!(told.contains("40 x 40 voxels of 10 m") && told.contains("inner/place.hop"), "{told}");
    ends(&run(&folder, "build inner/place.toml"), 0);
    assert!(inner.join("place.hop").exists());
}

#[test]
fn flags_that_a_recipe_says_are_refused_beside_it() {
    let folder = site();
    for flag in ["--spacing 3", "--local", "--nodata-fill interp", "--bbox 1,2,3,4", "--bake-shadows 250,12"]
    {
        let told = ends(&run(&folder, &format!("build place.toml {flag}")), 2);
        assert!(told.contains("cannot be used with"), "{told}");
    }
    assert!(ends(&run(&folder, "build"), 2).contains("PLACE.toml"));
}

#[test]
fn shadows_of_a_recipe_are_in_its_database() {
    let folder = site();
    let recipe = fs::read_to_string(folder.path().join("place.toml")).expect("the recipe");
    let recipe = recipe + "[shadows]\nazimuth_deg = 250\nelevation_deg = 12\n";
    fs::write(folder.path().join("place.toml"), recipe).expect("a file");
    ends(&run(&folder, "build place.toml"), 0);
    assert!(ends(&run(&folder, "info place.hop"), 0).contains("250"));
    let left: Vec<_> = fs::read_dir(folder.path()).expect("the folder").flatten().collect();
    // What the shadows were baked into is kept, for the next build.
    assert_eq!(left.len(), 6, "{left:?}");
    let first = fs::read(folder.path().join("place.hop")).expect("a database");
    let told = ends(&run(&folder, "build place.toml"), 0);
    assert!(told.contains("pages are as before"), "{told}");
    let told = ends(&run(&folder, "build place.toml --fresh"), 0);
    assert!(!told.contains("as before"), "{told}");
    assert!(fs::read(folder.path().join("place.hop")).expect("a database") == first);
    // No input is an output, with shadows or without.
    let raster = fs::read(folder.path().join("dem.asc")).expect("a raster");
    for (output, told) in [("dem.asc", "is an input"), ("place.toml", "is the recipe")] {
        let refused = ends(&run(&folder, &format!("build place.toml -o {output} --overwrite")), 2);
        assert!(refused.contains(told), "{refused}");
    }
    assert!(fs::read(folder.path().join("dem.asc")).expect("a raster") == raster);
    // Names that differ in their ending have each their own.
    ends(&run(&folder, "build place.toml -o place.v2"), 0);
    assert!(folder.path().join("place.v2.without-shadows.hop").is_file());
    // Somebody's own file is not touched.
    fs::write(folder.path().join("place.without-shadows.hop"), "mine").expect("a file");
    let told = ends(&run(&folder, "build place.toml"), 2);
    assert!(told.contains("place.without-shadows.hop is in the way"), "{told}");
    assert_eq!(fs::read(folder.path().join("place.without-shadows.hop")).expect("a file"), b"mine");
}

#[test]
fn a_new_recipe_can_be_checked_and_replaces_nothing() {
    let folder = site();
    ends(&run(&folder, "new alps.toml"), 0);
    let told = ends(&run(&folder, "recipe check alps.toml"), 3);
    assert!(told.contains("a mistake") && told.contains("dem.tif"), "{told}");
    assert!(ends(&run(&folder, "new alps.toml"), 2).contains("exists already"));
    assert!(ends(&run(&folder, "new"), 2).contains("place.toml exists already"));
}

#[test]
fn all_mistakes_are_told_by_check_and_the_first_by_build() {
    let folder = site();
    fs::write(folder.path().join("bad.toml"), "[place]\nspacing = 3\n[[elevation]]\nfile = \"absent.tif\"\n")
        .expect("a file");
    let told = ends(&run(&folder, "recipe check bad.toml"), 3);
    for part in [
        "has 2 mistakes",
        "line 2: [place] has no key `spacing`; did you mean `spacing_m`?",
        "line 4: cannot read",
    ] {
        assert!(told.contains(part), "{told}");
    }
    let built = ends(&run(&folder, "build bad.toml"), 3);
    assert!(built.contains("line 2") && built.contains("and 1 more"), "{built}");
    // What a build finds out is told in keys, too.
    fs::write(folder.path().join("bare.toml"), "[[elevation]]\nfile = \"dem.asc\"\n").expect("a file");
    for command in ["build bare.toml", "recipe check bare.toml"] {
        let told = String::from_utf8_lossy(&run(&folder, command).stderr).into_owned();
        assert!(told.contains("`crs` of [[elevation]]") && !told.contains("--elevation-crs"), "{told}");
    }
    assert!(ends(&run(&folder, "recipe check absent.toml"), 5).contains("absent.toml"));
}

/// The root of this repository.
fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Copies the files of a folder of the repository (or of one beside it) to `to`, which is made.
fn copy_files(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        if entry.path().is_file() {
            fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
        }
    }
}

/// The pair of rasters that the airport is made from; says so and answers `None` where it is not there.
fn airport_rasters() -> Option<PathBuf> {
    let beside = || repository().join("../shared/realdata");
    let folder = std::env::var_os("HEDGEHOP_REALDATA").map_or_else(beside, PathBuf::from).join("sba_airport");
    if folder.is_dir() {
        return Some(folder);
    }
    // Written past the test harness, which swallows what passing tests print.
    let _ =
        writeln!(std::io::stderr(), "skipped: no real data at {} (set HEDGEHOP_REALDATA)", folder.display());
    None
}

#[test]
fn recipes_that_come_with_it_are_sound() {
    let folder = TempDir::new().expect("a temporary folder");
    for part in ["data", "docs/gallery", "tests/data/places"] {
        copy_files(&repository().join(part), &folder.path().join(part));
    }
    // As docs/modeling.md has it.
    ends(
        &run(
            &folder,
            "shadow-heights docs/gallery/halls.geojson --sun 235,33 --imagery docs/gallery/halls.jpg --imagery-crs EPSG:32632 \
             --elevation data/valley-elevation.tif --highest 40 -o docs/gallery/halls-heights.geojson",
        ),
        0,
    );
    let rasters = airport_rasters();
    if let Some(rasters) = &rasters {
        copy_files(rasters, &folder.path().join("docs/gallery"));
    }
    // The other tables of the gallery are scenes.
    let gallery = fs::read_dir(folder.path().join("docs/gallery")).expect("the gallery").flatten();
    let recipes = gallery.filter_map(|entry| {
        let name = entry.file_name().into_string().ok().filter(|name| name.ends_with(".toml"))?;
        let text = fs::read_to_string(entry.path()).expect("a table");
        text.lines().any(|line| line == "[place]").then(|| format!("docs/gallery/{name}"))
    });
    let mut recipes: Vec<String> = recipes.chain(["data/valley.toml".into()]).collect();
    recipes.sort();
    for name in ["airport", "halls", "synthetic", "valley"] {
        assert!(recipes.contains(&format!("docs/gallery/{name}.toml")), "{name}: {recipes:?}");
    }
    recipes.retain(|name| rasters.is_some() || !name.ends_with("airport.toml"));
    for recipe in recipes {
        let told = ends(&run(&folder, &format!("recipe check {recipe}")), 0);
        assert!(told.contains("is sound"), "{recipe}: {told}");
    }
}
