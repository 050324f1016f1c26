//! `build PLACE.toml`, `new` and `recipe check` from outside.

mod common;

use std::fs;

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
    assert_eq!(left.len(), 4, "{left:?}");
    // It is the recipe's own work, though all pages are made again.
    let told = ends(&run(&folder, "build place.toml"), 0);
    assert!(!told.contains("as before"), "{told}");
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
