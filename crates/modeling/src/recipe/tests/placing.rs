//! What lies outside the area, and outputs that cannot be: told with their lines.

use super::*;
use crate::{BuildOptions, build};
use hedgehop_base::progress::Silent;

/// What a check tells of a sound recipe, besides what it assumed.
fn told(site: &Site, text: &str) -> Vec<String> {
    let outline = site.read(text).outline().unwrap();
    outline.notes.into_iter().filter(|note| note.starts_with("line ")).collect()
}

#[test]
fn what_lies_outside_the_area_is_told_with_its_line() {
    let site = Site::new();
    fs::write(site.folder.path().join("box.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let dome =
        |place: &str| format!("[[terrain]]\nkind = \"dome\"\ncentre = {place}\nradius_m = 9\nheight_m = 5\n");
    let waves = |place: &str| {
        format!(
            "[[texture]]\nkind = \"waves\"\nsize_m = 3\ncolours = [\"red\", \"blue\"]\ncentre = {place}\nradius_m = 9\n"
        )
    };
    let object = |places: &str| format!("[[object]]\nfile = \"box.obj\"\nat = {places}\n");
    let bushes = |bbox: &str| format!("[[scatter]]\nobjects = \"shrub\"\nspacing_m = 40\nbbox = {bbox}\n");
    let [inside, swapped, far] = ["[500040, 5000040]", "[5000040, 500040]", "[700000, 5000040]"];
    let within = "[500000, 5000000, 500040, 5000040]";
    let sound = [dome(inside), waves(inside), object(inside), bushes(within)].concat();
    assert_eq!(told(&site, &format!("{ELEVATION}{sound}")), Vec::<String>::new());
    let swap = "with x and y the other way round";

    for (table, line, words) in [
        (dome(swapped), 4, ["[[terrain]] number 1 lies outside the area", swap]),
        (dome(inside) + &dome(far), 9, ["[[terrain]] number 2 lies outside", "around x 700000, y 5000040"]),
        (waves(swapped), 4, ["[[texture]] number 1 lies outside the area", swap]),
        (object(swapped), 4, ["box.obj lies outside the area", swap]),
        (object(far), 4, ["box.obj lies outside the area", "check its coordinates"]),
        (object(&format!("[{inside}, {far}]")), 4, ["1 of its 2 places", "at x 700000, y 5000040"]),
        (
            bushes("[700000, 5000000, 700100, 5000100]"),
            4,
            ["the bbox of [[scatter]] number 1 lies outside", "500000 to 500080"],
        ),
    ] {
        let told = told(&site, &format!("{ELEVATION}{table}"));
        let is_told = |told: &String| {
            told.starts_with(&format!("line {line}: ")) && words.iter().all(|word| told.contains(word))
        };
        assert!(told.len() == 1 && is_told(&told[0]), "{table}: {told:?}");
    }
}

#[test]
fn files_outside_the_area_are_told_with_their_lines() {
    let site = Site::new();
    let put = |name: &str, text: &str| fs::write(site.folder.path().join(name), text).unwrap();
    let point = |x: f64| format!("{{\"type\":\"Point\",\"coordinates\":[{x},5000040]}}");
    put("far.geojson", &point(700_000.0));
    put("here.geojson", &point(500_040.0));
    let ring = "[[[700000,5000000],[700050,5000000],[700050,5000050],[700000,5000000]]]";
    put("woods.geojson", &format!("{{\"type\":\"Polygon\",\"coordinates\":{ring}}}"));
    image::RgbImage::new(8, 8).save(site.folder.path().join("photo.png")).unwrap();
    put("photo.pgw", "10\n0\n0\n-10\n700005\n5000075\n");
    let crs = "crs = \"EPSG:32632\"\n";
    let features = |name: &str| format!("[[features]]\nfile = \"{name}\"\nkind = \"tree\"\n{crs}");
    let text = format!(
        "{ELEVATION}{}{}[[imagery]]\nfile = \"photo.png\"\n{crs}[[scatter]]\nobjects = \"shrub\"\nspacing_m = 40\narea = \"woods.geojson\"\n{crs}",
        features("here.geojson"),
        features("far.geojson")
    );
    let told = told(&site, &text);
    let wanted = ["line 8: far.geojson lies", "line 12: photo.png lies", "line 15: the area of [[scatter]]"];
    let are_told = told.len() == wanted.len()
        && told.iter().zip(wanted).all(|(told, wanted)| told.starts_with(wanted) && told.contains("outside"));
    assert!(are_told, "{told:?}");
}

#[test]
fn outputs_that_cannot_be_are_told_with_their_line() {
    let site = Site::new();
    fs::create_dir(site.folder.path().join("there")).unwrap();
    for (output, words) in [
        ("", "output is empty; name a file, as in output = \"place.hop\""),
        ("there", "is a folder; name a file with `output` of [place]"),
        ("there/", "is a folder"),
        ("not_there/", "is a folder"),
        ("not_there/.", "is a folder"),
        ("..", "is a folder"),
        ("a\\u0000b", "a\u{fffd}b has a NUL character in it"),
        ("place.toml", "is the recipe; name another file"),
        ("dem.asc", "is an input; name another file"),
    ] {
        let text = format!("[place]\nlocal = false\noutput = \"{output}\"\n{ELEVATION}");
        let mistakes = site.mistakes(&text);
        let is_told = |mistake: &Mistake| mistake.line == 3 && mistake.what.contains(words);
        assert!(mistakes.len() == 1 && is_told(&mistakes[0]), "{output}: {mistakes:?}");
    }

    // Together with all else.
    let text = "[place]\noutput = \"there\"\n[[elevation]]\nfile = \"text.tif\"\n";
    let mistakes = site.mistakes(text);
    assert!(mistakes.len() == 2 && (mistakes[0].line, mistakes[1].line) == (2, 3), "{mistakes:?}");

    // No more than a check does a build begin with it.
    let text = format!("[place]\noutput = \"not_there/\"\n{ELEVATION}");
    let error = build(&site.read(&text).options, &Silent).unwrap_err().to_string();
    assert!(error.contains("is a folder"), "{error}");
}

#[test]
fn errors_that_a_build_meets_have_their_lines() {
    let site = Site::new();
    let photo = image::RgbImage::new(8, 8);
    photo.save(site.folder.path().join("photo.png")).unwrap();
    fs::write(site.folder.path().join("photo.pgw"), "10\n0\n0\n-10\n500005\n5000075\n").unwrap();
    let imagery = "[[imagery]]\nfile = \"photo.png\"\ncrs = \"EPSG:32632\"\nbands = [4, 2, 1]\n";
    let recipe = site.read(&format!("{ELEVATION}{imagery}"));
    let error = recipe.located(build(&recipe.options, &Silent).unwrap_err());
    let told = error.to_string();
    assert!(matches!(&error, Error::Invalid { path, .. } if *path == recipe.path), "{error:?}");
    assert!(
        told.contains("line 4: ") && told.contains("bands 1 to 3, not 4 (`bands` of [[imagery]])"),
        "{told}"
    );

    // Of several it tells the one that was met.
    let recipe = site.read(&format!("[place]\noutput = \"absent/a.hop\"\n{ELEVATION}{imagery}"));
    let options = BuildOptions { output: site.folder.path().join("a.hop"), ..recipe.options.clone() };
    let told = recipe.located(build(&options, &Silent).unwrap_err()).to_string();
    assert!(told.contains("line 6: ") && told.contains("and 1 more"), "{told}");

    // What is no matter of the recipe stays as it is, in its words.
    let other = recipe.located(Error::Configuration("a.hop exists; take another -o".into())).to_string();
    assert_eq!(other, "a.hop exists; take another `output` of [place]");
}

#[test]
fn times_without_their_offset_and_dark_ones_have_their_lines() {
    let site = Site::new();
    for (time, line, words) in [
        (
            "2026-06-21T09:30:00",
            5,
            "with an offset from UTC, 2026-06-21T09:30:00Z, not \"2026-06-21T09:30:00\"",
        ),
        ("\"2026-06-21 09:30\"", 5, "with an offset from UTC"),
        ("2026-06-21", 5, "with an offset from UTC"),
        ("3", 5, "time must be a date and time with an offset from UTC"),
        ("2026-06-21T00:30:00Z", 4, "the sun throws no shadows; choose one above the horizon"),
    ] {
        let mistakes = site.mistakes(&format!("{ELEVATION}[shadows]\ntime = {time}\n"));
        let is_told = |mistake: &Mistake| mistake.line == line && mistake.what.contains(words);
        assert!(mistakes.len() == 1 && is_told(&mistakes[0]), "{time}: {mistakes:?}");
        assert!(!mistakes[0].what.contains("time: time"), "{mistakes:?}");
    }
}
