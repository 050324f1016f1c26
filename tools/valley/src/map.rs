//! The map of the valley: what stands and lies on the ground, by OpenStreetMap's tags.

use glam::{DVec2, dvec2};

use crate::features::{Feature, Geometry, Tag, Value};
use crate::grid::{PIXELS, SIDE, around, centre};
use crate::land::Tree;
use crate::noise::uniform;
use crate::outline;
use crate::palette::colour;
use crate::roads::{self, Road};
use crate::sample::Sample;
use crate::sites;
use crate::terrain::{area_from_valley, centre_line};
use crate::village::{Building, Use};
use crate::water::Water;

/// Colours of houses' walls, sRGB.
const WALLS: [[u8; 3]; 6] =
    [[206, 198, 180], [196, 184, 160], [212, 206, 192], [188, 174, 148], [204, 188, 158], [190, 190, 184]];
/// Walls of barns, and of the church.
const PLANKS: [u8; 3] = [126, 102, 78];
const CHURCH: [u8; 3] = [204, 198, 184];

/// Height of the pylons, metres.
pub const PYLON: f64 = 30.0;
/// Height of the mast, metres.
pub const MAST: f64 = 40.0;

/// All features.
pub fn draw(sample: &Sample) -> Vec<Feature> {
    let valley = &sample.valley;
    let mut features: Vec<Feature> = valley.buildings.iter().map(building).collect();
    for (number, road) in sample.roads.iter().enumerate() {
        features.extend(ways(number, road, &sample.water, &valley.bare));
    }

    features.push(strip());
    features.extend(waters(&sample.water));
    let line = Geometry::Line(sites::LINE.to_vec());

    features.push(Feature::new(
        line,
        [
            Tag::new("power", "line"),
            Tag::new("voltage", "110000"),
            Tag::new("cables", "6"),
            Tag::new("height", PYLON),
        ],
    ));

    features.extend(works(&valley.bare, &valley.buildings, &sample.roads));
    features.extend(barriers(&valley.buildings, &sample.roads));
    features.extend(valley.trees.iter().map(tree));

    features
}

fn hex([red, green, blue]: [u8; 3]) -> Value {
    format!("#{red:02x}{green:02x}{blue:02x}").into()
}

/// A number 0 … 1 that a building keeps.
fn own(building: &Building, salt: u64) -> f64 {
    uniform((8.0 * building.x) as i64, (8.0 * building.y) as i64, 770 + salt)
}

fn building(building: &Building) -> Feature {
    let pick = own(building, 0);
    let (word, shape, walls) = match building.kind {
        Use::Church => ("church", "gabled", CHURCH),
        Use::Tower => ("church", "pyramidal", CHURCH),
        Use::Barn => ("barn", "gabled", PLANKS),
        Use::House => {
            let shape = if pick < 0.78 {
                "gabled"
            } else if pick < 0.94 {
                "hipped"
            } else {
                "flat"
            };
            ("house", shape, WALLS[(own(building, 1) * WALLS.len() as f64) as usize])
        }
    };

    let geometry = Geometry::Polygon(building.corners(0.0).to_vec());
    let shade = 0.25 * (uniform(building.x as i64, building.y as i64, 730) - 0.5);
    let mut tags = vec![Tag::new("building", word)];
    if shape == "flat" {
        let levels = (building.eaves / 3.0).round().max(2.0);
        tags.extend([Tag::new("building:levels", levels), Tag::new("height", 3.0 * levels)]);
    } else {
        tags.extend([Tag::new("height", building.eaves + building.roof)]);
    }

    tags.push(Tag::new("roof:shape", shape));
    if shape != "flat" {
        tags.push(Tag::new("roof:height", building.roof));
    }

    tags.extend([
        Tag::new("building:colour", hex(walls)),
        Tag::new("roof:colour", hex(colour(building.material, shade))),
    ]);
    Feature { geometry, tags }
}

/// A road within the area, cut where bridges begin and end.
fn ways(number: usize, road: &Road, water: &Water, bare: &[f64]) -> Vec<Feature> {
    let (class, name) = match number {
        0 => ("secondary", "V 1"),
        _ if road.paved => ("residential", ""),
        4 => ("track", "V 2"),
        _ => ("track", ""),
    };
    let inside = |&DVec2 { x, y }: &DVec2| (0.0..=SIDE).contains(&x) && (0.0..=SIDE).contains(&y);
    let first = road.line.iter().position(inside).unwrap_or(0);
    let last = road.line.iter().rposition(inside).unwrap_or(road.line.len() - 1);

    // The track is drawn straight over steep slopes, where no vehicle goes.
    let last = if road.paved { last } else { last.min(roads::gentle(road, bare, 0.2) - 1) };
    let bridges: Vec<(usize, usize)> = roads::bridges(road, water);
    let mut cuts = vec![(first, false)];
    for (from, to) in bridges {
        cuts.extend([(from, true), (to, false)]);
    }

    cuts.push((last, false));
    let part = |pair: &[(usize, bool)]| {
        let line = outline::simplified(&road.line[pair[0].0..=pair[1].0], 0.15);
        let mut tags = vec![Tag::new("highway", class), Tag::new("width", 2.0 * road.half)];
        if !name.is_empty() {
            tags.push(Tag::new("ref", name));
        }
        if !road.paved {
            tags.push(Tag::new("surface", "gravel"));
        }
        if pair[0].1 {
            tags.extend([Tag::new("bridge", "yes"), Tag::new("layer", 1.0)]);
        }

        Feature { geometry: Geometry::Line(line), tags }
    };

    cuts.windows(2).filter(|pair| pair[1].0 > pair[0].0).map(part).collect()
}

fn strip() -> Feature {
    let line = Geometry::Line(sites::strip_ends().to_vec());
    Feature::new(
        line,
        [
            Tag::new("aeroway", "runway"),
            Tag::new("ref", "02/20"),
            Tag::new("surface", "grass"),
            Tag::new("colour", "#6b8244"),
            Tag::new("width", sites::STRIP_SIZE.y),
        ],
    )
}

/// The lake, and the river above and below it.
fn waters(water: &Water) -> Vec<Feature> {
    let lake = outline::rings(|pixel| water.beside_lake[pixel], 0.7);
    let river = outline::rings(|pixel| water.outside[pixel].max(-water.beside_lake[pixel]), 0.7);
    let large = |ring: &Vec<DVec2>| outline::area(ring) > 300.0;
    let lake = lake.into_iter().filter(large).map(|ring| {
        Feature::new(Geometry::Polygon(ring), [Tag::new("natural", "water"), Tag::new("water", "lake")])
    });
    let river = river.into_iter().filter(large).map(|ring| {
        Feature::new(Geometry::Polygon(ring), [Tag::new("natural", "water"), Tag::new("water", "river")])
    });
    lake.chain(river).collect()
}

fn tree(tree: &Tree) -> Feature {
    let leaf = if tree.conifer { "needleleaved" } else { "broadleaved" };
    Feature::new(
        Geometry::Point(dvec2(tree.x, tree.y)),
        [
            Tag::new("natural", "tree"),
            Tag::new("height", tree.tall),
            Tag::new("diameter_crown", 2.0 * tree.radius),
            Tag::new("leaf_type", leaf),
        ],
    )
}

/// Tanks and a silo on their yard, a mast on its hill, a chimney beside a barn.
fn works(bare: &[f64], buildings: &[Building], roads: &[Road]) -> Vec<Feature> {
    let [west, south, east, north] = sites::TANKS;
    let upright = |place: DVec2, kind: &str, height: f64, diameter: f64| {
        let tags = [Tag::new("man_made", kind), Tag::new("height", height), Tag::new("diameter", diameter)];
        Feature::new(Geometry::Point(place), tags)
    };

    let mut works = vec![
        upright(dvec2(west + 15.0, south + 17.0), "storage_tank", 9.0, 16.0),
        upright(dvec2(east - 15.0, south + 17.0), "storage_tank", 9.0, 16.0),
        upright(dvec2(west + 13.0, north - 11.0), "silo", 17.0, 6.0),
        upright(hilltop(bare), "mast", MAST, 1.2),
    ];
    let beside = |barn: &Building, side: f64| {
        let away = side * (barn.half.x + 2.5);
        dvec2(barn.x + away * barn.axis.x, barn.y + away * barn.axis.y)
    };
    let barns = buildings.iter().filter(|building| building.kind == Use::Barn);
    let mut places = barns.flat_map(|barn| [beside(barn, 1.0), beside(barn, -1.0)]);
    if let Some(place) = places.find(|place| free(buildings, roads, 1.2, place.x, place.y)) {
        works.push(upright(place, "chimney", 14.0, 1.6));
    }

    works
}

/// The highest ground near the place of the mast.
pub fn hilltop(bare: &[f64]) -> DVec2 {
    let pixels = around(sites::MAST.x, sites::MAST.y, 40.0).filter(|&pixel| pixel < PIXELS);
    let highest = pixels.max_by(|&a, &b| bare[a].total_cmp(&bare[b]));
    highest.map_or(sites::MAST, |pixel| centre(pixel).into())
}

/// Whether a place is `margin` metres off all buildings and roads, and off what sites keep.
fn free(buildings: &[Building], roads: &[Road], margin: f64, x: f64, y: f64) -> bool {
    let on_road = around(x, y, 0.0).any(|pixel| roads::outside(roads, pixel) < margin + 1.0);
    let on_building = buildings.iter().any(|building| building.covers(x, y, margin));
    !on_road && !on_building && sites::kept(x, y).is_none()
}

/// The wall of the churchyard, hedges along the village's rim, the fence around the tanks.
fn barriers(buildings: &[Building], roads: &[Road]) -> Vec<Feature> {
    let barrier = |line: Vec<DVec2>, kind: &str, height: f64| {
        Feature::new(Geometry::Line(line), [Tag::new("barrier", kind), Tag::new("height", height)])
    };
    let free = |x: f64, y: f64| free(buildings, roads, 1.5, x, y);
    let church = buildings.iter().find(|building| building.kind == Use::Church);
    let yard = church.map_or_else(Vec::new, |church| {
        let corners = church.corners(10.0);
        corners.iter().chain(corners.first()).copied().collect()
    });
    let walls = outline::free_parts(&yard, 8.0, free).into_iter().map(|line| barrier(line, "wall", 1.2));

    let rim = |from: i32, to: i32| -> Vec<DVec2> {
        let round = (from..=to).step_by(6).map(|degrees| {
            let (s, c) = f64::from(degrees).to_radians().sin_cos();
            let along = -310.0 + 250.0 * c;
            area_from_valley(along, centre_line(along) - 155.0 + 125.0 * s)
        });
        round.collect()
    };

    let hedges = [rim(36, 72), rim(120, 156)];
    let hedges = hedges.iter().flat_map(|line| outline::free_parts(line, 20.0, free));
    let [west, south, east, north] = sites::TANKS;

    let fence = vec![
        dvec2(west, south + 20.0),
        dvec2(west, south),
        dvec2(east, south),
        dvec2(east, north),
        dvec2(west, north),
        dvec2(west, south + 30.0),
    ];

    walls
        .chain(hedges.map(|line| barrier(line, "hedge", 2.0)))
        .chain([barrier(fence, "fence", 1.8)])
        .collect()
}
