//! `build PLACE.toml`, `new` and `recipe check` from outside.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::common::{ends, run};

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

/// Names of all files of a folder, in order.
fn names(folder: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(folder.path()).expect("the folder").flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

const SHADOWS: &str = "[shadows]\nazimuth_deg = 250\nelevation_deg = 12\n";

#[test]
fn what_was_kept_without_shadows_becomes_the_result_when_they_go() {
    let folder = site();
    let put = |text: &str| fs::write(folder.path().join("place.toml"), text).expect("a file");
    let plain = fs::read_to_string(folder.path().join("place.toml")).expect("the recipe");
    let database = || fs::read(folder.path().join("place.hop")).expect("a database");
    ends(&run(&folder, "build --elevation dem.asc --elevation-crs EPSG:32632 -o flags.hop"), 0);
    let flags = fs::read(folder.path().join("flags.hop")).expect("a database");
    put(&(plain.clone() + SHADOWS));
    ends(&run(&folder, "build place.toml"), 0);
    assert!(database() != flags && folder.path().join("place.without-shadows.hop.steps").exists());
    put(&plain);
    let all = ["dem.asc", "flags.hop", "place.hop", "place.hop.steps", "place.toml"];

    for _ in 0..2 {
        // No page is made, and the next build knows all of them by their new name.
        let told = ends(&run(&folder, "build place.toml"), 0);
        assert!(told.contains("4 of 4 pages are as before") && told.contains("built place.hop"), "{told}");
        assert!(database() == flags, "the bytes of a build without shadows");
        assert_eq!(names(&folder), all);
    }

    // With a database that somebody removed, too; and with one of another origin only if that may be replaced.
    for (there, flag) in [(false, ""), (true, " --overwrite")] {
        put(&(plain.clone() + SHADOWS));
        ends(&run(&folder, "build place.toml"), 0);
        put(&plain);
        match there {
            false => fs::remove_file(folder.path().join("place.hop")).expect("it goes"),
            true => fs::remove_file(folder.path().join("place.hop.steps")).expect("it goes"),
        }

        if there {
            let told = ends(&run(&folder, "build place.toml"), 2);
            assert!(told.contains("place.hop exists; --overwrite"), "{told}");
        }

        let told = ends(&run(&folder, &format!("build place.toml{flag}")), 0);
        assert!(told.contains("4 of 4 pages are as before"), "{told}");
        assert!(database() == flags);
        assert_eq!(names(&folder), all);
    }
}

#[test]
fn what_another_recipe_built_is_not_taken_for_what_has_no_shadows() {
    let folder = site();
    let recipe = fs::read_to_string(folder.path().join("place.toml")).expect("the recipe");
    ends(&run(&folder, "build place.toml"), 0);
    // A recipe of its own keeps it there.
    let output = "[place]\noutput = \"place.without-shadows.hop\"\n";
    fs::write(folder.path().join("other.toml"), format!("{output}{recipe}")).expect("a file");
    ends(&run(&folder, "build other.toml"), 0);
    let others = || fs::read(folder.path().join("place.without-shadows.hop")).expect("a database");
    let before = others();
    let told = ends(&run(&folder, "build place.toml"), 0);
    assert!(told.contains("4 of 4 pages") && !told.contains("without-shadows"), "{told}");
    fs::remove_file(folder.path().join("place.hop")).expect("it goes");
    ends(&run(&folder, "build place.toml"), 0);
    fs::write(folder.path().join("place.toml"), recipe + SHADOWS).expect("a file");
    let told = ends(&run(&folder, "build place.toml"), 2);
    assert!(told.contains("place.without-shadows.hop is in the way"), "{told}");
    assert!(others() == before);
}

#[test]
fn outputs_that_cannot_be_are_refused_before_anything_is_made() {
    let folder = site();
    let recipe = fs::read_to_string(folder.path().join("place.toml")).expect("the recipe");
    fs::write(folder.path().join("shaded.toml"), recipe + SHADOWS).expect("a file");
    fs::create_dir(folder.path().join("there.hop")).expect("a folder");
    #[cfg(unix)]
    std::os::unix::fs::symlink("nowhere", folder.path().join("link.hop")).expect("a link");
    let before = names(&folder);

    for (output, words) in [
        ("there.hop", "there.hop is a folder; name a file"),
        ("there.hop --overwrite", "there.hop is a folder; name a file"),
        ("absent/", "absent/ is a folder; name a file"),
        ("link.hop", "link.hop exists already; give --overwrite"),
    ] {
        if output.starts_with("link") && !cfg!(unix) {
            continue;
        }
        let [plain, shaded] = ["place", "shaded"].map(|recipe| {
            ends(&run(&folder, &format!("build {recipe}.toml -o {output} --progress plain")), 2)
        });
        // The same sentence, and not a stage before it.
        assert!(plain.contains(words), "{plain}");
        assert_eq!(plain, shaded);
        assert!(!shaded.contains("voxels") && names(&folder) == before, "{shaded}");
    }
    // A link that leads nowhere is as much in the way of the database without shadows as a file.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere", folder.path().join("a.without-shadows.hop")).expect("a link");
        let told = ends(&run(&folder, "build shaded.toml -o a.hop"), 2);
        assert!(told.contains("a.without-shadows.hop is in the way"), "{told}");
    }
}

#[test]
fn what_a_build_refuses_of_a_recipe_is_told_with_its_line() {
    let folder = site();
    let recipe = fs::read_to_string(folder.path().join("place.toml")).expect("the recipe");
    for (text, line, words) in [
        (format!("{recipe}[shadows]\ntime = 2026-06-21T00:30:00Z\n"), 4, "the sun throws no shadows"),
        (format!("{recipe}[shadows]\ntime = 2026-06-21T09:30:00\n"), 5, "with an offset from UTC"),
        (
            format!("[place]\noutput = \".\"\n{recipe}"),
            2,
            "is a folder; name a file with `output` of [place]",
        ),
        (format!("[place]\ncrs = \"EPSG:4326\"\n{recipe}"), 2, "`crs` of [place] EPSG:4326 is not in metres"),
        (format!("[place]\nbbox = [0, 0, 9, 9]\n{recipe}"), 2, "lies outside the elevation"),
    ] {
        fs::write(folder.path().join("bad.toml"), text).expect("a file");
        let told = ends(&run(&folder, "build bad.toml --progress plain"), 3);
        assert!(told.contains(&format!("bad.toml: line {line}: ")) && told.contains(words), "{told}");
        assert!(!told.contains("voxels:"), "before a page was made: {told}");
    }

    // A command line has no lines, and is refused as early.
    let flags =
        "build --elevation dem.asc --elevation-crs EPSG:32632 -o a.hop --progress plain --bake-shadows";
    let told = ends(&run(&folder, &format!("{flags} 250,-3")), 2);
    assert!(told.contains("choose one above the horizon") && !told.contains("voxels:"), "{told}");
}

#[test]
fn a_check_tells_what_lies_outside_the_area() {
    let folder = site();
    let dome = "[[terrain]]\nkind = \"dome\"\ncentre = [5000200, 500200]\nradius_m = 50\nheight_m = 9\n";
    let recipe = fs::read_to_string(folder.path().join("place.toml")).expect("the recipe");
    fs::write(folder.path().join("place.toml"), recipe + dome).expect("a file");
    let told = ends(&run(&folder, "recipe check place.toml"), 0);
    assert!(told.contains("line 4: [[terrain]] number 1 lies outside the area"), "{told}");
    assert!(told.contains("with x and y the other way round"), "{told}");
    let told = ends(&run(&folder, "build place.toml"), 0);
    assert!(told.contains("[[terrain]] number 1 lies outside the area"), "{told}");
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
    for part in ["data", "docs/gallery", "crates/modeling/tests/data/places"] {
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
