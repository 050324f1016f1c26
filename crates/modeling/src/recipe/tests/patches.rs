//! The table `[[patch]]`: what each kind becomes, and one sentence for each mistake.

use glam::DVec2;

use super::*;
use crate::synthetic::{EllipsePiece, GroundPatch, Sector};

fn patch(site: &Site, text: &str) -> GroundPatch {
    let recipe = site.read(&format!("{MADE}[[patch]]\n{text}"));
    let [patch] = recipe.options.synthetic.patches.as_slice() else { panic!("{text}") };
    patch.clone()
}

#[test]
fn kinds_become_what_they_say() {
    let site = Site::new();
    let ring = patch(
        &site,
        "centre = [400, 200]\nradii_m = [30, 50]\ninner_radii_m = [20, 45]\nazimuth_deg = 12\ncolour = \"#ff0080\"\n\
         material = \"concrete\"\npriority = -3\nstrength = 0.5\n",
    );
    let piece = EllipsePiece {
        centre: DVec2::new(400.0, 200.0),
        radii: DVec2::new(30.0, 50.0),
        azimuth_deg: 12.0,
        inner: Some(DVec2::new(20.0, 45.0)),
        sector: None,
        fade_m: 0.0,
    };
    assert_eq!(ring.coats[0].pieces, [piece]);
    assert_eq!(ring.coats[0].colour, Some([255, 0, 128]));
    assert_eq!((ring.material, ring.priority, ring.strength), (Some(Material::Concrete), -3, 0.5));

    let road = patch(
        &site,
        "kind = \"ellipse\"\ncentre = [400, 200]\nradius_m = 80\ninner_radius_m = 72\nfrom_deg = -20\nsweep_deg = 70\n\
         material = \"asphalt\"\n",
    );
    let arc = EllipsePiece {
        inner: Some(DVec2::splat(72.0)),
        sector: Some(Sector { from_deg: -20.0, width_deg: 70.0 }),
        ..EllipsePiece::circle(DVec2::new(400.0, 200.0), 80.0)
    };
    assert_eq!(road.coats[0].pieces, [arc]);
    assert_eq!((road.coats[0].colour, road.material), (None, Some(Material::Asphalt)));
    let wake = patch(&site, "centre = [1, 2]\nradius_m = 8\nfade_m = 7.5\ncolour = \"white\"\n");
    assert_eq!(wake.coats[0].pieces[0].fade_m, 7.5);
    let whole =
        patch(&site, "centre = [1, 2]\nradius_m = 8\nfrom_deg = 0\nsweep_deg = 360\ncolour = \"red\"\n");
    assert_eq!(whole.coats[0].pieces[0].sector, None);

    let bombs = patch(
        &site,
        "kind = \"bomb_circle\"\ncentre = [400, 200]\nradius_m = 90\nrings = 3\ncolours = [\"white\", \"red\"]\n",
    );
    let seen: Vec<_> = bombs.coats.iter().map(|coat| (coat.pieces[0].radii.y, coat.colour)).collect();
    let [white, red] = [Some([255; 3]), Some([255, 0, 0])];
    assert_eq!(seen, [(90.0, white), (60.0, red), (30.0, white)]);

    let marks = "kind = \"tyre_marks\"\ncentre = [400, 200]\nlength_m = 300\nwidth_m = 12\n";
    let tyres = patch(&site, &format!("{marks}azimuth_deg = 90\ncount = 25\nseed = 4\n"));
    assert_eq!((tyres.coats.len(), tyres.coats[0].pieces.len()), (1, 25));
    assert!(tyres.strength < 1.0 && patch(&site, marks).coats[0].pieces.len() == 60);

    let lake = patch(&site, "kind = \"lake\"\ncentre = [400, 200]\nradius_m = 60\nragged = 0.4\nseed = 9\n");
    assert_eq!((lake.material, lake.coats[0].pieces.len()), (Some(Material::Water), 10));
}

/// Tables, the line of what is wrong with each, counted in the table, and words of the sentence.
const WRONG: [(&str, usize, &str); 27] = [
    ("centre = [1, 2]\nradius_m = 9\nfade_m = 9\ncolour = \"red\"\n", 3, "fade_m must be 0 to less than 9 m"),
    ("centre = [1, 2]\nradius_m = 9\nfade_m = -inf\ncolour = \"red\"\n", 3, "fade_m must be 0"),
    ("kind = \"square\"\n", 1, "kind is one of ellipse, bomb_circle, tyre_marks, lake, not \"square\""),
    ("kind = 3\n", 1, "kind is text in quotation marks"),
    ("radius_m = 9\ncolour = \"red\"\n", 0, "needs `centre`"),
    ("centre = [1, 2]\ncolour = \"red\"\n", 0, "a patch needs radius_m, or radii_m = [right, forward]"),
    ("centre = [1]\nradius_m = 9\ncolour = \"red\"\n", 1, "centre is a place"),
    ("centre = [1, nan]\nradius_m = 9\ncolour = \"red\"\n", 1, "centre must be a place in metres"),
    ("centre = [1, 2]\nradius_m = 0\ncolour = \"red\"\n", 2, "radius_m must be more than 0"),
    ("centre = [1, 2]\nradius_m = -inf\ncolour = \"red\"\n", 2, "radius_m must be more than 0"),
    (
        "centre = [1, 2]\nradius_m = 9\nradii_m = [1, 2]\ncolour = \"red\"\n",
        3,
        "give radius_m or radii_m, not both",
    ),
    ("centre = [1, 2]\nradii_m = [1]\ncolour = \"red\"\n", 2, "radii_m are two half axes"),
    ("centre = [1, 2]\nradii_m = [1, 1e30]\ncolour = \"red\"\n", 2, "radii_m must be more than 0"),
    ("centre = [1, 2]\nradius_m = 9\n", 0, "a patch needs colour or material"),
    ("centre = [1, 2]\nradius_m = 9\ncolour = \"reddish\"\n", 3, "a colour is #rrggbb (sRGB) or a name"),
    (
        "centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\ninner_radius_m = 9\n",
        4,
        "must be smaller than the patch",
    ),
    (
        "centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\ninner_radii_m = [8, 10]\n",
        4,
        "must be smaller than the patch",
    ),
    ("centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\nfrom_deg = 4\n", 0, "needs `sweep_deg`"),
    (
        "centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\nfrom_deg = 4\nsweep_deg = 0\n",
        5,
        "sweep_deg must be more than 0",
    ),
    (
        "centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\npriority = 1001\n",
        4,
        "priority must be −1000 to 1000, not 1001",
    ),
    ("centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\nstrength = 2\n", 4, "strength must be 0 to 1"),
    ("centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\nmaterial = \"cheese\"\n", 4, "cheese"),
    ("centre = [1, 2]\nradius_m = 9\ncolour = \"red\"\nazimut_deg = 4\n", 4, "did you mean `azimuth_deg`?"),
    ("kind = \"bomb_circle\"\ncentre = [1, 2]\nradius_m = 9\ncolours = []\n", 4, "colours are one at least"),
    (
        "kind = \"bomb_circle\"\ncentre = [1, 2]\nradius_m = 9\ncolours = [\"red\"]\nrings = 0\n",
        5,
        "rings must be 1 to 100, not 0",
    ),
    ("kind = \"tyre_marks\"\ncentre = [1, 2]\nwidth_m = 9\n", 0, "needs `length_m`"),
    ("kind = \"lake\"\ncentre = [1, 2]\nradius_m = 9\nragged = 0.7\n", 4, "ragged must be 0 to 0.5"),
];

#[test]
fn each_mistake_is_one_sentence_with_its_line() {
    let site = Site::new();
    let first = MADE.lines().count() + 1;
    for (text, line, words) in WRONG {
        let mistakes = site.mistakes(&format!("{MADE}[[patch]]\n{text}"));
        assert!(
            mistakes.len() == 1 && mistakes[0].line == first + line && mistakes[0].what.contains(words),
            "{text}: {mistakes:?}"
        );
    }
}

/// Any value of any key is read or told, and never ends the program.
#[test]
fn any_value_is_read_or_told() {
    let site = Site::new();
    let keys = [
        "kind",
        "centre",
        "radius_m",
        "radii_m",
        "inner_radius_m",
        "inner_radii_m",
        "azimuth_deg",
        "from_deg",
        "fade_m",
    ];
    let more = [
        "sweep_deg",
        "colour",
        "material",
        "priority",
        "strength",
        "rings",
        "colours",
        "count",
        "seed",
        "ragged",
    ];
    let values = [
        "\"lake\"",
        "\"tyre_marks\"",
        "\"bomb_circle\"",
        "\"\"",
        "0",
        "-1",
        "1e308",
        "-9223372036854775808",
        "nan",
        "inf",
        "true",
        "[]",
        "[1, 2]",
        "[[1, 2]]",
        "[\"red\"]",
        "{ a = 1 }",
        "1979-05-27",
        "4294967296",
    ];

    let base =
        [("centre", "[400, 200]"), ("radius_m", "30"), ("colour", "\"red\""), ("colours", "[\"red\"]")];

    // Each value for each key of a patch that is sound without it.
    let mut read = 0;
    for key in keys.into_iter().chain(more) {
        for value in values {
            let others = base.iter().filter(|(other, _)| *other != key && *other != "colours");
            let mut text: String = others.map(|(key, value)| format!("{key} = {value}\n")).collect();
            text += &format!("{key} = {value}\n");
            match Recipe::check(&site.put(&format!("{MADE}[[patch]]\n{text}"))).unwrap() {
                Ok(recipe) => read += recipe.options.synthetic.patches.len(),
                Err(mistakes) => assert!(!mistakes.is_empty() && mistakes.len() <= 4, "{text}: {mistakes:?}"),
            }
        }
    }
    assert!(read > 6, "{read}");
}

#[test]
fn patches_outside_the_area_are_told() {
    let site = Site::new();
    let text = format!("{MADE}[[patch]]\ncentre = [9000, 200]\nradius_m = 30\ncolour = \"red\"\n");
    let notes = site.read(&text).outline().unwrap().notes;
    assert!(
        notes.iter().any(|note| note.starts_with("line 8: [[patch]] number 1 lies outside the area")),
        "{notes:?}"
    );
}
