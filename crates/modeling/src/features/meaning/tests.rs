use glam::dvec2;
use proptest::prelude::*;

use super::super::kinds::{Building, Cap, FeatureClass, Leaf, Meaning, Rise, RoofShape, Top, WayKind};
use super::super::layer::{Area, Attributes, Columns, Geometry, Layer, LayerOptions, Path, Row, Value};
use super::{Interpreted, interpret, interpret_all};
use hedgehop::voxel::{FacadeStyle, Material};

/// A row of tags `key=value …`; `;` stands for a space. A square area, or a point.
fn row(tags: &str, area: bool) -> Row {
    let mut attributes = Attributes::default();
    for tag in tags.split(' ').filter(|tag| !tag.is_empty()) {
        let (key, value) = tag.split_once('=').unwrap();
        let value = value.replace('~', " ");
        let value = value.parse().map_or(Value::Text(value), Value::Number);
        attributes.push(key, value);
    }
    let square = Path::flat(vec![dvec2(0.0, 0.0), dvec2(9.0, 0.0), dvec2(9.0, 9.0), dvec2(0.0, 9.0)]);
    let geometry = if area {
        Geometry { areas: vec![Area { outer: square, holes: vec![] }], ..Geometry::default() }
    } else {
        Geometry { points: Path::flat(vec![dvec2(1.0, 1.0)]), ..Geometry::default() }
    };
    Row { place: "feature 3".into(), geometry, attributes }
}

fn meaning(tags: &str, area: bool) -> Meaning {
    let Interpreted { meaning, doubts } = interpret(&row(tags, area), &LayerOptions::default());
    assert_eq!(doubts, [""; 0], "{tags}");
    meaning
}

fn building(tags: &str) -> Building {
    match meaning(tags, true) {
        Meaning::Building(building) => building,
        other => panic!("{tags}: {other:?}"),
    }
}

#[test]
fn buildings_have_heights_by_what_they_say() {
    assert_eq!(building("building=yes height=12").top, Top::Ridge(12.0));
    assert_eq!(building("building=yes height=40~ft").top, Top::Ridge(40.0 * 0.3048));
    assert_eq!(building("building=yes height=12 building:levels=9").top, Top::Ridge(12.0));
    assert_eq!(building("building=yes building:levels=3").top, Top::Eaves(9.0));
    assert_eq!(building("building=roof height=0.2").min_height_m, 0.0);
    assert!((building("building=roof height=5").min_height_m - 4.6).abs() < 1e-9);
    let part = building("building:part=yes height=30 min_height=12~m");
    assert_eq!((part.min_height_m, part.is_part), (12.0, true));
    assert_eq!(building("building:part=yes building:levels=5 building:min_level=2").min_height_m, 6.0);
    let Top::Eaves(usual) = building("building=house").top else { panic!() };
    assert!((5.0..7.0).contains(&usual), "{usual}");
}

#[test]
fn facades_follow_kind_levels_and_material() {
    use FacadeStyle::{Apartments, Barn, Church, Garage, Hall, House, Office, Shop};

    let style = |tags: &str| building(tags).facade.map(|facade| facade.style);
    for (tags, wanted) in [
        ("building=house", Some(House)),
        ("building=yes", Some(House)),
        ("building=yes building:levels=6", Some(Apartments)),
        ("building=yes height=20", Some(Apartments)),
        ("building=yes building:material=glass", Some(Office)),
        ("building=yes building:material=wood", Some(Barn)),
        ("building=apartments", Some(Apartments)),
        ("building=office", Some(Office)),
        ("building=retail", Some(Shop)),
        ("building=warehouse", Some(Hall)),
        ("building=barn", Some(Barn)),
        ("building=chapel", Some(Church)),
        ("building=garages", Some(Garage)),
        ("building=roof", None),
        ("building=greenhouse", None),
    ] {
        assert_eq!(style(tags), wanted, "{tags}");
    }

    let levels = |tags: &str| building(tags).facade.unwrap().levels;
    assert_eq!(levels("building=house"), None);
    assert_eq!(levels("building:part=yes building:levels=5 building:min_level=2"), Some(3.0));

    let plain = LayerOptions { plain_walls: true, ..LayerOptions::default() };
    let Meaning::Building(plain) = interpret(&row("building=house", true), &plain).meaning else { panic!() };
    assert_eq!(plain, Building { facade: None, ..building("building=house") });
    let Meaning::Structure(tank) = meaning("man_made=storage_tank", true) else { panic!() };
    assert_eq!(tank.walled.facade, None);
}

#[test]
fn roofs_have_shapes_rises_and_directions() {
    let roof =
        building("building=yes roof:shape=hipped roof:height=4 roof:orientation=across roof:direction=SW")
            .roof;
    assert_eq!((roof.shape, roof.rise), (RoofShape::Hipped, Rise::Height(4.0)));
    assert_eq!((roof.direction, roof.across), (Some(225.0), true));
    assert_eq!(building("building=yes roof:shape=gabled roof:angle=40").roof.rise, Rise::Angle(40.0));
    assert_eq!(building("building=yes roof:shape=gabled roof:levels=2").roof.rise, Rise::Height(6.0));
    for (word, shape) in [
        ("flat", RoofShape::Flat),
        ("skillion", RoofShape::Skillion),
        ("pyramidal", RoofShape::Pyramidal),
        ("dome", RoofShape::Dome),
    ] {
        assert_eq!(building(&format!("building=yes roof:shape={word}")).roof.shape, shape);
    }
    assert_eq!(building("building=warehouse").roof.shape, RoofShape::Flat);
    assert_eq!(building("building=house").roof.shape, RoofShape::Gabled);
}

#[test]
fn paint_is_said_or_follows_material_and_kind() {
    let said = building("building=yes building:colour=#102030 roof:colour=navy roof:material=slate");
    assert_eq!((said.walls.colour, said.cover.colour), ([0x10, 0x20, 0x30], [0, 0, 128]));
    assert_eq!(said.cover.material, Material::RoofTiles);
    let brick = building("building=yes building:material=brick");
    assert_eq!(brick.walls.material, Material::Brick);
    assert!(brick.walls.colour[0] > brick.walls.colour[2] + 50);
    let mut other = row("building=yes building:material=brick", true);
    other.place = "feature 4".into();
    let Meaning::Building(other) = interpret(&other, &LayerOptions::default()).meaning else { panic!() };
    assert_ne!(other.walls.colour, brick.walls.colour);
}

#[test]
fn ways_have_widths_by_what_they_say() {
    let way = |tags: &str| match meaning(tags, false) {
        Meaning::Way(way) => way,
        other => panic!("{tags}: {other:?}"),
    };
    assert_eq!(way("highway=residential").width_m, 6.0);
    assert_eq!(way("highway=residential width=20'").width_m, 20.0 * 0.3048);
    assert_eq!(way("highway=primary lanes=4").width_m, 4.0 * 3.25 + 1.6);
    assert_eq!(way("highway=track").paint.material, Material::Gravel);
    assert_eq!(way("highway=track surface=concrete").paint.material, Material::Concrete);
    let bridge = way("highway=primary bridge=yes layer=1");
    assert!(bridge.is_bridge && bridge.layer == 1);
    assert!(!way("highway=primary bridge=no").is_bridge);
    assert_eq!(way("railway=rail tracks=2").width_m, 4.5 + 4.2);
    assert_eq!((way("aeroway=runway").kind, way("aeroway=runway width=60").width_m), (WayKind::Runway, 60.0));
    assert!(matches!(meaning("aeroway=apron", true), Meaning::Pavement(_)));
}

#[test]
fn water_flows_or_stands() {
    assert_eq!(meaning("waterway=river width=30", false), Meaning::River(30.0));
    assert_eq!(meaning("waterway=riverbank", true), Meaning::River(0.0));
    assert_eq!(meaning("natural=water", true), Meaning::Lake);
    assert_eq!(meaning("natural=water water=river", true), Meaning::River(0.0));
    assert_eq!(meaning("landuse=reservoir", true), Meaning::Lake);
}

#[test]
fn what_stands_upright() {
    let upright = |tags: &str, area: bool| match meaning(tags, area) {
        Meaning::Upright(upright) | Meaning::Pylon(upright, _) => upright,
        Meaning::Structure(structure) => structure.round,
        other => panic!("{tags}: {other:?}"),
    };
    assert_eq!(upright("man_made=chimney height=120", false).height_m, 120.0);
    let tank = upright("man_made=storage_tank height=14 roof:shape=dome", true);
    assert_eq!((tank.diameter_m, tank.cap), (None, Cap::Dome));
    assert_eq!(upright("man_made=silo diameter=6", false).diameter_m, Some(6.0));
    assert_eq!(upright("man_made=tower tower:type=cooling", true).cap, Cap::Waisted);
    assert!(upright("power=tower", false).opacity < 0.5);
    let Meaning::PowerLine(line) = meaning("power=line voltage=380000;110000 cables=6", false) else {
        panic!()
    };
    assert_eq!(line.wires.len(), 7);
    assert_eq!(line.pylon.height_m, 50.0);
    let Meaning::Barrier(wall) = meaning("barrier=wall height=3 width=0.5", false) else { panic!() };
    assert_eq!((wall.height_m, wall.thickness_m), (3.0, 0.5));
}

#[test]
fn outlines_of_what_is_man_made_have_walls() {
    for (tags, top, shape) in [
        (
            "man_made=tower building=yes height=40 roof:shape=pyramidal roof:height=6",
            40.0,
            RoofShape::Pyramidal,
        ),
        ("man_made=silo building=silo height=20 roof:shape=flat", 20.0, RoofShape::Flat),
        ("man_made=silo", 15.0, RoofShape::Pyramidal),
        ("man_made=gasometer", 30.0, RoofShape::Dome),
        ("man_made=storage_tank height=7", 7.0, RoofShape::Flat),
        ("man_made=chimney", 50.0, RoofShape::Flat),
        ("man_made=lighthouse", 25.0, RoofShape::Flat),
    ] {
        let Meaning::Structure(found) = meaning(tags, true) else { panic!("{tags}") };
        assert_eq!((found.walled.top, found.walled.roof.shape), (Top::Ridge(top), shape), "{tags}");
        assert_eq!((found.walled.walls, found.round.height_m), (found.round.paint, top), "{tags}");
        assert!(matches!(meaning(tags, false), Meaning::Upright(_)), "{tags}");
    }

    // A lattice has no walls.
    assert!(matches!(meaning("man_made=tower tower:construction=lattice", true), Meaning::Upright(_)));
    let twice = interpret(&row("man_made=tower height=tall", true), &LayerOptions::default());
    assert_eq!(twice.doubts.len(), 1, "{:?}", twice.doubts);
}

#[test]
fn what_is_stated_of_levels_areas_and_pylons_counts() {
    let roof = building("building=yes building:levels=0 roof:levels=1 roof:shape=gabled");
    assert_eq!((roof.top, roof.roof.rise), (Top::Eaves(0.0), Rise::Height(3.0)));
    let roof = building("building=yes building:levels=0 roof:height=5 roof:shape=gabled");
    assert_eq!((roof.top, roof.roof.rise), (Top::Eaves(0.0), Rise::Height(5.0)));
    assert_eq!(building("building=yes building:levels=0.5").top, Top::Eaves(1.5));
    let nothing =
        interpret(&row("building=yes building:levels=0 roof:shape=flat", true), &LayerOptions::default());
    assert!(nothing.doubts[0].contains("is not below its top, 0 m"), "{:?}", nothing.doubts);

    let is_filled = |tags: &str, area: bool| match meaning(tags, area) {
        Meaning::Barrier(barrier) => barrier.is_filled,
        other => panic!("{tags}: {other:?}"),
    };

    for (tags, area, expected) in [
        ("barrier=hedge area=yes", true, true),
        ("barrier=wall area=yes", true, true),
        ("barrier=hedge", true, false),
        ("barrier=hedge area=no", true, false),
        ("barrier=hedge area=yes", false, false),
        ("barrier=fence area=yes", true, false),
    ] {
        assert_eq!(is_filled(tags, area), expected, "{tags}");
    }

    for (tags, height_m, is_stated) in [("power=tower height=45", 45.0, true), ("power=tower", 28.0, false)] {
        let Meaning::Pylon(pylon, stated) = meaning(tags, false) else { panic!("{tags}") };
        assert_eq!((pylon.height_m, stated), (height_m, is_stated), "{tags}");
    }
}

#[test]
fn plants() {
    let Meaning::Trees(tree, _) =
        meaning("natural=tree height=22 diameter_crown=9 leaf_type=needleleaved", false)
    else {
        panic!()
    };
    assert_eq!((tree.height_m, tree.crown_m, tree.leaf), (22.0, 9.0, Leaf::Needle));
    assert!(matches!(meaning("natural=wood", true), Meaning::Wood(_)));
    assert!(
        matches!(meaning("landuse=forest leaf_type=broadleaved", true), Meaning::Wood(wood) if wood.leaf == Leaf::Broad)
    );
}

#[test]
fn values_out_of_sense_are_doubts_of_file_and_row() {
    let rows = [
        "building=yes height=-5",
        "building=yes height=tall building:colour=reddish",
        "shop=bakery",
        "highway=primary tunnel=yes",
    ];
    let rows = rows
        .iter()
        .enumerate()
        .map(|(index, tags)| Row { place: format!("row {}", index + 1), ..row(tags, true) });

    let layer = Layer {
        path: "/maps/town.shp".into(),
        crs: hedgehop_geo::Crs::local(),
        rows: rows.collect(),
        notes: vec![],
    };
    let (meanings, notes) = interpret_all(&layer, &LayerOptions::default());
    assert_eq!(meanings.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0, 1]);

    assert_eq!(
        notes,
        [
            "town.shp: row 1: height = \"-5\" is passed over: it is no number from 0.01 to 1000",
            "town.shp: row 2: height = \"tall\" is passed over: it is no number from 0.01 to 1000",
            "town.shp: row 2: building:colour = \"reddish\" is passed over: it is no colour",
            "town.shp: row 4 is left out: it is under ground or indoors",
            "town.shp: row 3 is left out: no tag says what it is that is known here",
        ]
    );
}

#[test]
fn sizes_that_nothing_on_earth_has_are_told_and_passed_over() {
    let said = |tags: &str| interpret(&row(tags, true), &LayerOptions::default());
    for (plain, absurd) in [
        ("building=yes", "height=1e9"),
        ("building=yes height=9", "roof:height=1e9"),
        ("building=yes height=9", "min_height=1e9"),
        ("building=yes", "building:levels=1e9"),
        ("building=yes", "building:min_level=1e9"),
        ("man_made=mast", "height=1001"),
        ("power=tower", "height=1e30"),
        ("barrier=wall", "height=1e9"),
        ("natural=tree", "height=131"),
        ("natural=tree", "diameter_crown=61"),
        ("natural=wood", "height=131"),
    ] {
        let (usual, found) = (said(plain), said(&format!("{plain} {absurd}")));
        assert!(usual.doubts.is_empty() && found.meaning == usual.meaning, "{absurd}: {:?}", found.meaning);
        let [doubt] = &found.doubts[..] else { panic!("{absurd}: {:?}", found.doubts) };
        assert!(doubt.contains("is passed over: it is no number from"), "{doubt}");
    }
}

#[test]
fn other_files_name_their_columns() {
    let columns = Columns {
        height: Some("HOEHE".into()),
        roof_shape: Some("DACH".into()),
        class: Some("ART".into()),
        ..Columns::default()
    };
    let options = LayerOptions { kind: Some(FeatureClass::Building), columns, ..LayerOptions::default() };
    let found = interpret(&row("hoehe=7.5 DACH=Gabled ART=barn height=99", true), &options);
    let Meaning::Building(building) = found.meaning else { panic!() };
    assert_eq!((building.top, building.roof.shape), (Top::Ridge(7.5), RoofShape::Gabled));
    assert_eq!(building.walls.material, Material::Wood);
    let roads = LayerOptions { kind: Some(FeatureClass::Road), ..LayerOptions::default() };
    let Meaning::Way(way) = interpret(&row("fclass=motorway", false), &roads).meaning else { panic!() };
    assert_eq!(way.width_m, 11.5);
    for name in ["building", "power-line"] {
        assert!(FeatureClass::of(name).is_ok());
    }
    assert!(FeatureClass::of("house").unwrap_err().contains("building, road"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever people write, there is an answer, and its sizes are those of things.
    #[test]
    fn any_tags_have_an_answer(tags in prop::collection::vec((0..26_usize, 0..31_usize), 0..6), junk in ".{0,12}", area: bool) {
        let mut row = row("", area);
        for (key, value) in tags {
            let (key, value) = (KEYS.split('|').nth(key).unwrap(), VALUES.split('|').nth(value).unwrap());
            let value = if value.is_empty() { &junk } else { value };
            row.attributes.push(key, Value::Text(value.to_owned()));
        }

        match interpret(&row, &LayerOptions::default()).meaning {
            Meaning::Building(building) => {
                let (Top::Ridge(top) | Top::Eaves(top)) = building.top;
                let is_above = top > building.min_height_m || top == building.min_height_m && building.roof.rises();
                prop_assert!(is_above && building.min_height_m >= 0.0 && top <= 1004.0, "{building:?}");
            }
            Meaning::Way(way) => prop_assert!(way.width_m > 0.0 && way.width_m < 1500.0),
            Meaning::Upright(upright) => prop_assert!(upright.height_m > 0.0 && upright.diameter_m.is_none_or(|d| d > 0.0)),
            Meaning::Barrier(barrier) => prop_assert!(barrier.height_m > 0.0 && barrier.thickness_m > 0.0),
            Meaning::Trees(tree, step) => prop_assert!(tree.height_m > 0.0 && tree.crown_m > 0.0 && step > 1.0),
            Meaning::PowerLine(line) => prop_assert!(!line.wires.is_empty() && line.wires.len() <= 37),
            _ => {}
        }
    }
}

const KEYS: &str = "building|building:part|height|min_height|building:levels|building:min_level|roof:shape|roof:height|roof:angle|\
roof:direction|building:colour|highway|width|lanes|bridge|layer|railway|tracks|natural|man_made|diameter|power|voltage|cables|barrier|waterway";

const VALUES: &str = "|yes|no|house|roof|carport|12|-5|0|0.05|1e9|nan|40'|5'11\"|0.5 km|gabled|dome|skillion|#12|navy|motorway|rail|\
tree|wood|tower|silo|storage_tank|line|hedge|river|NW";

#[test]
fn natural_ground_has_its_material() {
    let ground = |tags: &str| match meaning(tags, true) {
        Meaning::Ground(paint) | Meaning::Field(paint, _) => Some(paint.material),
        _ => None,
    };
    assert_eq!(ground("natural=sand"), Some(Material::Sand));
    assert_eq!(ground("natural=bare_rock"), Some(Material::Rock));
    assert_eq!(ground("natural=glacier"), Some(Material::Ice));
    assert_eq!(ground("landuse=meadow"), Some(Material::Grass));
    assert_eq!(ground("landuse=farmland"), Some(Material::Crops));
    assert_eq!(ground("natural=scree surface=sand"), Some(Material::Sand));
    // What is no area is no ground.
    assert_eq!(meaning("natural=sand", false), Meaning::Unknown);
    assert_eq!(ground("landuse=residential"), None);
}
