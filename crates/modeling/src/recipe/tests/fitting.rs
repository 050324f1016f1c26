//! What a build refuses though each file is sound by itself: a check tells it before, by line.

use super::*;
use crate::build;
use hedgehop_base::progress::Silent;

impl Site {
    fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).unwrap();
    }

    /// A recipe has these mistakes alone, by line and words, and a build refuses it with the words of the first.
    fn refuses(&self, text: &str, wanted: &[(usize, &[&str])]) {
        let recipe = self.read(text);
        let mistakes = recipe.outline().err().unwrap_or_default();
        let is_told = |(mistake, (line, words)): (&Mistake, &(usize, &[&str]))| {
            mistake.line == *line && words.iter().all(|word| mistake.what.contains(word))
        };
        let are_told = mistakes.len() == wanted.len() && mistakes.iter().zip(wanted).all(is_told);
        assert!(are_told, "{text}: {mistakes:?}");
        let error = error_in_keys(build(&recipe.options, &Silent).unwrap_err()).to_string();
        assert!(error.contains(wanted[0].1[0]), "{text}: {error}");
    }
}

const POLYGON: &str = r#"{"type":"Polygon","coordinates":[[[5,5],[6,5],[6,6],[5,5]]]}"#;

#[test]
fn files_on_earth_and_plain_metres_do_not_go_together() {
    let site = Site::new();
    site.write("woods.geojson", POLYGON);
    let features = "[[features]]\nfile = \"woods.geojson\"\nkind = \"wood\"\n";
    let scatter = "[[scatter]]\nobjects = \"shrub\"\nspacing_m = 9\narea = \"woods.geojson\"\n";
    let apart = "do not go together";

    site.refuses(
        &format!("{MADE}{features}{scatter}"),
        &[
            (8, &[apart, "woods.geojson", "`crs` of [[features]] local", "`crs` of [place]"]),
            (11, &[apart, "`crs` of [[scatter]] local"]),
        ],
    );

    let local = "crs = \"local\"\n";
    site.refuses(&format!("{ELEVATION}{features}{local}"), &[(4, &[apart, "`crs` of [[features]]"])]);
    site.refuses(&format!("{ELEVATION}{scatter}{local}"), &[(4, &[apart, "`crs` of [[scatter]]"])]);
    let second = "[[elevation]]\nfile = \"dem.asc\"\n";
    site.refuses(
        &format!("[place]\nlocal = true\n{ELEVATION}{second}"),
        &[(6, &[apart, "`crs` of [[elevation]]"])],
    );

    // What goes together is no mistake.
    assert!(site.read(&format!("{MADE}{features}{local}")).outline().is_ok());
}

#[test]
fn heights_that_cannot_be_brought_together_are_told() {
    let site = Site::new();
    let second = ELEVATION.replace("EPSG:32632\"", "EPSG:32632\"\nvertical_datum = \"navd88\"");
    site.refuses(
        &format!("{ELEVATION}{second}"),
        &[(4, &["cannot be brought to", "`vertical_datum` of [[elevation]]"])],
    );
}

#[test]
fn areas_without_a_place_in_the_database_are_told() {
    let site = Site::new();
    // No metres from any meridian.
    site.write("far.geojson", &POLYGON.replace("5,", "5e12,").replace("6,", "6e12,"));
    let scatter =
        "[[scatter]]\nobjects = \"shrub\"\nspacing_m = 9\narea = \"far.geojson\"\ncrs = \"EPSG:32633\"\n";
    site.refuses(&format!("{ELEVATION}{scatter}"), &[(4, &["has no place in", "far.geojson"])]);
}

#[test]
fn models_too_wide_for_voxels_are_told() {
    let site = Site::new();
    site.write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let object = "[[object]]\nfile = \"sheet.obj\"\nat = [9, 9]\nup = \"z\"\nscale = 19000\n";
    site.refuses(&format!("{MADE}{object}"), &[(8, &["4750 by 4750 voxels wide", "see `scale`"])]);
    let scatter = "[[scatter]]\nobjects = \"sheet.obj\"\nspacing_m = 300\nup = \"z\"\nscale = 1200\n";
    let fine = MADE.replace("spacing_m = 4", "spacing_m = 1");
    let trees = "[[scatter]]\nobjects = \"broadleaf\"\nspacing_m = 300\nscale = 100\n";
    site.refuses(
        &format!("{fine}{trees}{scatter}"),
        &[(8, &["voxels wide, but", "[[object]]"]), (12, &["1202 voxels wide, but"])],
    );
    let beyond = object.replace("19000", "30000");
    site.refuses(&format!("{MADE}{beyond}"), &[(8, &["beyond 20000 m of its origin", "sheet.obj"])]);
}

#[test]
fn corridors_that_make_no_sense_are_told_by_their_tables() {
    let site = Site::new();
    let corridor =
        |spacing: f64| format!("[[corridor]]\npath = \"flight.csv\"\nwidth_m = 20\nspacing_m = {spacing}\n");
    let two = |spacing: f64| format!("{ELEVATION}{}{}", corridor(2.5), corridor(spacing));

    site.refuses(
        &two(10.0),
        &[(
            8,
            &[
                "a corridor of `spacing_m` = 10 adds nothing",
                "stored at 10 m already",
                "`outside_m` of [place] = ",
            ],
        )],
    );

    site.refuses(
        &two(5.0),
        &[(8, &["a corridor of `spacing_m` = 5 is not 1, 4, 16, 64", "2.5 or 10 would do"])],
    );
    site.write("away.csv", "time_s,x_m,y_m,alt_m\n0,0,0,90\n9,50,80,90\n");
    let away = corridor(2.5).replace("flight", "away");
    site.refuses(&format!("{}{away}", two(2.5)), &[(12, &["the corridor lies outside the area"])]);
    site.refuses(
        &format!("[place]\noutside_m = 7\n{}", two(2.5)),
        &[(2, &["`outside_m` of [place] = 7 is not 1, 4, 16, 64"])],
    );
}

#[test]
fn areas_of_too_many_pages_and_names_that_are_too_long_are_told() {
    let site = Site::new();
    let wide = MADE.replace("[0, 0, 800, 400]", "[0, 0, 1e8, 1e8]");
    site.refuses(&wide, &[(3, &["more than the 67108864 that a database may have", "`bbox` of [place]"])]);
    let long = MADE.replace("[place]\n", &format!("[place]\noutput = \"{}.hop\"\n", "a".repeat(240)));
    site.refuses(&long, &[(2, &["is too long a name", "`output` of [place]"])]);
}

/// What a recipe is sound with, and what is told of it beside.
#[test]
fn what_is_most_often_a_mistake_is_told_beside() {
    let site = Site::new();
    let scan = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/valley-scan.laz");
    let made = MADE
        .replace("local = true", "crs = \"EPSG:32632\"")
        .replace("[0, 0, 800, 400]", "[500000, 5000000, 500800, 5000400]");
    let system = r#"{"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:32632"}},"features":[
        {"type":"Feature","properties":{"building":"yes"},"geometry":{"type":"Polygon","coordinates":[[[500005,5000005],[500016,5000005],[500016,5000016],[500005,5000005]]]}}]}"#;
    site.write("houses.geojson", system);
    let far = fs::read_to_string(site.folder.path().join("dem.asc"))
        .unwrap()
        .replace("xllcorner 500000", "xllcorner 600000");
    site.write("far.asc", &far);
    let houses = "[[features]]\nfile = \"houses.geojson\"\n";

    for (text, words) in [
        (format!("{made}[[cloud]]\nfile = {scan:?}\n"), "valley-scan.laz lies outside the area"),
        (format!("{made}{houses}attributes = {{ height = \"HOEHE\" }}\n"), "no row has the attribute HOEHE"),
        (format!("{made}{houses}crs = \"EPSG:32633\"\n"), "which counts, and not WGS 84 / UTM zone 33N"),
        (format!("{ELEVATION}{}", ELEVATION.replace("dem", "far")), "covers less than"),
    ] {
        let notes = site.read(&text).outline().unwrap().notes;
        assert!(notes.iter().any(|note| note.contains(words)), "{words}: {notes:?}");
    }

    let plain = site.read(&format!("{made}{houses}crs = \"EPSG:32632\"\n")).outline().unwrap().notes;
    assert!(!plain.iter().any(|note| note.contains("which counts")), "{plain:?}");
}

#[test]
fn a_folder_that_is_not_there_is_told() {
    let site = Site::new();
    let text = MADE.replace("[place]\n", "[place]\noutput = \"absent/place.hop\"\n");
    let mistakes = site.read(&text).outline().unwrap_err();
    let told = |mistake: &Mistake| mistake.line == 2 && mistake.what.contains("is no folder; make it");
    assert!(mistakes.len() == 1 && told(&mistakes[0]), "{mistakes:?}");
    fs::create_dir(site.folder.path().join("absent")).unwrap();
    assert!(site.read(&text).outline().is_ok());
}
