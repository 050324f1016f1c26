//! Lines painted on roads, by their class.
//!
//! Lengths and widths are those of Germany's *Richtlinien für die Markierung von Straßen* (RMS-1, FGSV 1993): narrow
//! lines are 0.15 m wide on motorways and 0.12 m elsewhere, broad ones twice as wide; dashes of lines between lanes are 6 m long on
//! motorways and 4 m on other roads outside of towns, with gaps twice as long.

use super::super::kinds::{Dashes, LaneLines, Paint};
use super::tags::Tags;
use hedgehop::voxel::Material;

const MOTORWAY: Dashes = Dashes { dash_m: 6.0, gap_m: 12.0 };
const RURAL: Dashes = Dashes { dash_m: 4.0, gap_m: 8.0 };
/// Narrow lines on motorways and elsewhere, and the broad line beside a hard shoulder, metres.
const NARROW_MOTORWAY: f64 = 0.15;
const NARROW: f64 = 0.12;
const BROAD_MOTORWAY: f64 = 0.3;
/// Narrowest road that is divided into two lanes, metres.
const DIVIDED: f64 = 5.5;

/// Lines of a class of roads with a surface and width (metres); `None`: it has none.
pub(super) fn road_lines(tags: &Tags<'_>, class: &str, paint: Paint, width_m: f64) -> Option<LaneLines> {
    let is_paved = matches!(paint.material, Material::Asphalt | Material::Concrete);
    let is_bare = tags.is("lane_markings", &["no"]);
    if tags.options.plain_ground || !is_paved || is_bare || width_m < DIVIDED {
        return None;
    }

    let said =
        tags.word("lanes").and_then(|lanes| lanes.parse().ok()).filter(|lanes| (1..=20).contains(lanes));
    let is_fast = matches!(class, "motorway" | "trunk" | "motorway_link" | "trunk_link");
    let has_edges = is_fast || matches!(class, "primary" | "primary_link" | "secondary" | "secondary_link");
    // Minor roads are divided where somebody saw lanes.
    let has_middle = match class {
        "tertiary" | "tertiary_link" => true,
        "unclassified" => said.is_some(),
        _ => has_edges,
    };
    if !has_middle {
        return None;
    }

    let is_link = class.ends_with("_link");
    let is_motorway = matches!(class, "motorway" | "motorway_link");
    let is_one_way = match tags.word("oneway").as_deref() {
        Some("no" | "0" | "false" | "f" | "b") => false,
        Some(_) => true,
        None => is_motorway,
    };
    let lanes = said.unwrap_or(if is_link && is_one_way { 1 } else { 2 });

    Some(LaneLines {
        lanes,
        is_one_way,
        lane_m: if is_fast { 3.75 } else { 3.5 },
        dashes: if is_motorway { MOTORWAY } else { RURAL },
        width_m: if is_motorway { NARROW_MOTORWAY } else { NARROW },
        edge_m: has_edges.then_some(match class {
            "motorway" => BROAD_MOTORWAY,
            "motorway_link" => NARROW_MOTORWAY,
            _ => NARROW,
        }),
        inset_m: if is_motorway { 0.5 } else { 0.25 },
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::kinds::{FieldRows, Meaning};
    use super::super::super::layer::{Area, Attributes, Geometry, LayerOptions, Row, Value};
    use super::super::interpret;
    use super::*;

    fn meaning(tags: &[(&str, &str)], is_area: bool, plain_ground: bool) -> Meaning {
        let mut attributes = Attributes::default();
        tags.iter().for_each(|(name, value)| attributes.push(*name, Value::Text((*value).into())));
        let areas = if is_area { vec![Area::default()] } else { Vec::new() };
        let row = Row { geometry: Geometry { areas, ..Geometry::default() }, attributes, ..Row::default() };
        interpret(&row, &LayerOptions { plain_ground, ..LayerOptions::default() }).meaning
    }

    fn lines(tags: &[(&str, &str)]) -> Option<LaneLines> {
        let Meaning::Way(way) = meaning(tags, false, false) else { panic!("{tags:?}") };
        way.lines
    }

    #[test]
    fn roads_have_the_lines_of_their_class() {
        let motorway = lines(&[("highway", "motorway")]).unwrap();
        assert_eq!((motorway.lanes, motorway.is_one_way, motorway.dashes), (2, true, MOTORWAY));
        assert_eq!((motorway.width_m, motorway.edge_m), (0.15, Some(0.3)));
        let link = lines(&[("highway", "trunk_link"), ("oneway", "yes")]).unwrap();
        assert_eq!((link.lanes, link.is_one_way, link.dashes), (1, true, RURAL));
        let primary = lines(&[("highway", "primary"), ("lanes", "4")]).unwrap();
        assert_eq!((primary.lanes, primary.is_one_way, primary.edge_m), (4, false, Some(0.12)));
        assert_eq!(lines(&[("highway", "tertiary")]).map(|lines| lines.edge_m), Some(None));
        assert!(lines(&[("highway", "unclassified"), ("lanes", "2")]).is_some());

        for without in [
            &[("highway", "residential")][..],
            &[("highway", "track")],
            &[("highway", "service"), ("width", "7")],
            &[("highway", "unclassified")],
            &[("highway", "primary"), ("surface", "gravel")],
            &[("highway", "primary"), ("width", "5")],
            &[("highway", "primary"), ("lane_markings", "no")],
        ] {
            assert_eq!(lines(without), None, "{without:?}");
        }
    }

    #[test]
    fn plain_layers_have_neither_lines_nor_rows() {
        let Meaning::Way(way) = meaning(&[("highway", "motorway")], false, true) else { panic!() };
        assert_eq!(way.lines, None);
        for (word, rows) in
            [("vineyard", FieldRows::Vines), ("orchard", FieldRows::Fruit), ("forest", FieldRows::Fruit)]
        {
            let rows = Some(rows).filter(|_| word != "forest");
            for plain_ground in [false, true] {
                let Meaning::Wood(wood) = meaning(&[("landuse", word)], true, plain_ground) else {
                    panic!("{word}")
                };
                assert_eq!(wood.rows, rows.filter(|_| !plain_ground), "{word}");
            }
        }
        let farmland = [("landuse", "farmland")];
        assert!(matches!(meaning(&farmland, true, false), Meaning::Field(_, FieldRows::Tramlines)));
        assert!(matches!(meaning(&farmland, true, true), Meaning::Ground(_)));
        assert!(matches!(meaning(&[("landuse", "meadow")], true, false), Meaning::Ground(_)));
    }
}
