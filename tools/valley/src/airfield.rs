//! Buildings beside the airstrip, by OpenStreetMap's tags: hangars, a clubhouse, a tower, the apron before them, and ways to both.
//!
//! Places are drawn along the strip and across it, from its middle: the first northward, the second eastward, metres. Where the taxiway leaves the strip, the
//! ground beside it is as high as that.

use glam::{DVec2, dvec2};

use crate::features::{Feature, Geometry, Tag};
use crate::sites;

/// Along and across the strip: least and greatest.
type Area = [[f64; 2]; 2];

/// The apron, the hangars on its eastern side, and the clubhouse, whose roof has a ridge of half a metre.
const APRON: Area = [[82.0, 158.0], [30.0, 54.0]];
const HANGARS: [Area; 2] = [[[84.0, 112.0], [58.0, 80.0]], [[120.0, 138.0], [58.0, 74.0]]];
const CLUBHOUSE: Area = [[148.0, 160.5], [58.0, 70.0]];
/// Course of the fence: around all of it, open to the apron.
const FENCE: Area = [[76.0, 176.0], [54.0, 88.0]];

/// Buildings, masts and tanks: areas and places.
pub fn buildings() -> Vec<Feature> {
    let building = |area: Area, kind: &str, [height, roof]: [f64; 2], shape: &str, [wall, top]: [&str; 2]| {
        Feature::new(
            Geometry::Polygon(corners(area).to_vec()),
            [
                Tag::new("building", kind),
                Tag::new("height", height),
                Tag::new("roof:shape", shape),
                Tag::new("roof:height", roof),
                Tag::new("building:colour", wall),
                Tag::new("roof:colour", top),
            ],
        )
    };

    let mut features = vec![
        building(HANGARS[0], "hangar", [10.5, 3.0], "gabled", ["#8fa0ab", "#6d7c86"]),
        building(HANGARS[1], "hangar", [6.5, 1.2], "skillion", ["#c9c4b6", "#9aa3a6"]),
        building(CLUBHOUSE, "clubhouse", [6.8, 3.2], "hipped", ["#ded6c2", "#8e4f3a"]),
    ];
    let uprights = [
        (dvec2(168.0, 62.0), "tower", 12.0, 4.0),
        (dvec2(79.0, 60.0), "storage_tank", 3.2, 5.0),
        (dvec2(90.0, 33.0), "mast", 7.0, 0.3),
    ];
    features.extend(uprights.map(|(place, kind, height, diameter)| {
        let tags = [Tag::new("man_made", kind), Tag::new("height", height), Tag::new("diameter", diameter)];
        Feature::new(Geometry::Point(georeferenced(place)), tags)
    }));

    features
}

/// The apron.
pub fn grounds() -> Vec<Feature> {
    let tags = [Tag::new("aeroway", "apron"), Tag::new("surface", "concrete")];
    vec![Feature::new(Geometry::Polygon(corners(APRON).to_vec()), tags)]
}

/// The way from the strip to the apron, a lane between the buildings, and the fence.
pub fn ways() -> Vec<Feature> {
    let line = |places: &[DVec2]| Geometry::Line(places.iter().map(|&place| georeferenced(place)).collect());
    let [[south, north], [west, east]] = FENCE;
    vec![
        Feature::new(
            line(&[dvec2(150.0, sites::STRIP_SIZE.y / 2.0 - 3.0), dvec2(150.0, APRON[1][0] + 2.0)]),
            [Tag::new("aeroway", "taxiway"), Tag::new("surface", "asphalt"), Tag::new("width", 10.0)],
        ),
        Feature::new(
            line(&[dvec2(143.0, APRON[1][1] - 2.0), dvec2(143.0, east - 5.0)]),
            [Tag::new("highway", "service"), Tag::new("surface", "asphalt"), Tag::new("width", 4.0)],
        ),
        Feature::new(
            line(&[dvec2(south, west), dvec2(south, east), dvec2(north, east), dvec2(north, west)]),
            [Tag::new("barrier", "fence"), Tag::new("height", 1.6)],
        ),
    ]
}

/// Corners counterclockwise, metres in the area.
pub fn corners([[south, north], [west, east]]: Area) -> [DVec2; 4] {
    [dvec2(south, west), dvec2(south, east), dvec2(north, east), dvec2(north, west)].map(georeferenced)
}

/// Returns the place in the area, metres, of one that is drawn along and across the strip.
fn georeferenced(DVec2 { x: along, y: across }: DVec2) -> DVec2 {
    let (s, c) = sites::STRIP_DIRECTION.to_radians().sin_cos();
    dvec2(sites::STRIP.x + along * s + across * c, sites::STRIP.y + along * c - across * s)
}
