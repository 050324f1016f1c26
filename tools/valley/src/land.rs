//! Vegetation and ground: fields and hedges, woods and single trees, alp, scree, rock and snow.

use crate::farm::Farm;
use crate::grid::{PIXELS, SIZE, SPACING, around, centre, steepness};
use crate::land_cover::{self, Class};
use crate::noise::{Crown, crown, fractal, gradient, hash, mix, smooth, stems, uniform};
use crate::palette::{Material, colour};
use crate::roads::{self, Road};
use crate::sites::{self, Kept};
use crate::terrain::{Terrain, centre_line, valley_from_area};
use crate::village::{self, Building};
use crate::water::Water;

const SEED: u64 = 9000;
/// Distance of trees in gardens, of which only some stand there, metres; their greatest height.
const GARDEN_TREES: f64 = 11.0;
const GARDEN_TALL: f64 = 6.5;

/// The finished valley.
pub struct Valley {
    /// Height of what is seen from above (ground, roofs, crowns), metres above the sea.
    pub surface: Vec<f64>,
    /// Height of the bare ground, metres above the sea.
    pub bare: Vec<f64>,
    /// sRGB.
    pub colours: Vec<[u8; 3]>,
    /// Land cover.
    pub classes: Vec<Class>,
    pub trees: Vec<Tree>,
    pub buildings: Vec<Building>,
}

/// A tree that stands by itself.
pub struct Tree {
    pub x: f64,
    pub y: f64,
    /// Radius of the crown, metres.
    pub radius: f64,
    /// Height above the ground, metres.
    pub tall: f64,
    pub conifer: bool,
}

struct Scene<'a> {
    terrain: &'a Terrain,
    water: &'a Water,
    roads: &'a [Road],
    steep: Vec<f64>,
}

/// One pixel's cover.
struct Cover {
    material: Material,
    /// −1 … 1.
    shade: f64,
    /// Metres above the ground.
    height: f64,
    class: Class,
    /// Nobody farms it.
    wild: bool,
}

impl Cover {
    fn flat(material: Material, shade: f64) -> Self {
        Self { material, shade, height: 0.0, class: land_cover::class(material), wild: false }
    }

    fn of(self, class: Class) -> Self {
        Self { class, ..self }
    }
}

/// Covers the terrain; `bare` is its ground with bridges open.
pub fn cover(terrain: &Terrain, bare: &[f64], water: &Water, roads: &[Road]) -> Valley {
    let scene = Scene { terrain, water, roads, steep: steepness(&terrain.ground) };
    let (mut surface, mut colours, mut classes, mut wild) = (vec![], vec![], vec![], vec![]);
    for pixel in 0..PIXELS {
        let cover = scene.at(pixel);
        surface.push(rounded(terrain.ground[pixel] + cover.height, scene.quantum(pixel, cover.height)));
        colours.push(colour(cover.material, cover.shade));
        wild.push(cover.wild);
        classes.push(cover.class);
    }

    land_cover::settle(&mut classes, &wild);
    let mut trees = plant(&scene, &mut surface, &mut colours);
    skirt(&scene, &surface, &mut colours);
    let buildings = village::place(roads, water);
    trees.extend(garden_trees(&scene, &buildings));

    village::draw(&buildings, &terrain.ground, &mut surface, |pixel, material, shade| {
        colours[pixel] = colour(material, shade);
        if material != Material::Wall {
            classes[pixel] = Class::Buildings;
        }
    });
    for height in &mut surface {
        *height = rounded(*height, 1.0 / 16.0);
    }

    let bare: Vec<f64> = (0..PIXELS).map(|pixel| rounded(bare[pixel], scene.quantum(pixel, 0.0))).collect();
    Farm::new(&bare).draw(&mut surface, &mut colours);
    Valley { surface, bare, colours, classes, trees, buildings }
}

/// Multiples of a power of two leave the last bits of a float32 zero, for compression.
fn rounded(value: f64, quantum: f64) -> f64 {
    (value / quantum).round() * quantum
}

impl Scene<'_> {
    fn quantum(&self, pixel: usize, height: f64) -> f64 {
        match (height > 3.0, self.steep[pixel] > 0.35) {
            (true, _) => 0.5,
            (false, true) => 0.25,
            (false, false) => 1.0 / 16.0,
        }
    }

    fn at(&self, pixel: usize) -> Cover {
        let (x, y) = centre(pixel);
        let grain = uniform((pixel % SIZE) as i64, (pixel / SIZE) as i64, SEED) - 0.5;
        if self.water.outside[pixel] <= 0.0 && roads::outside(self.roads, pixel) > 1.0 {
            return self.water_at(pixel, grain);
        }
        if let Some(road) = self.road_at(pixel, grain) {
            return road;
        }

        let shore = self.water.outside[pixel];
        if shore < 2.0 + 9.0 * fractal(x / 45.0, y / 45.0, 2, SEED + 1).max(0.0) {
            return Cover::flat(Material::Gravel, grain * 0.9);
        }
        if let Some(kept) = sites::kept(x, y) {
            return Self::kept_at(&kept, grain + 0.5 * fractal(x / 24.0, y / 24.0, 3, SEED + 60));
        }
        if let Some(wood) = self.wood_at(pixel, grain) {
            return Cover { wild: true, ..wood };
        }

        let village = roads::village_radius(pixel);
        if village < 1.0 + 0.1 * grain && self.terrain.relief[pixel] < 40.0 {
            return self.garden_at(x, y, grain);
        }
        if self.terrain.relief[pixel] + 160.0 * (self.steep[pixel] - 0.12).max(0.0)
            < 62.0 + 14.0 * gradient(x / 60.0, y / 60.0, SEED + 2)
            && shore > 9.0
        {
            return self.field_at(x, y, grain);
        }

        Cover { wild: true, ..self.wild_at(pixel, grain) }
    }

    /// Ground that a use keeps free.
    fn kept_at(kept: &Kept, tone: f64) -> Cover {
        match kept {
            Kept::Strip { along } => {
                let mown = if (along / 22.0).rem_euclid(2.0) < 1.0 { 0.25 } else { -0.05 };
                Cover::flat(Material::PastureLush, mown + 0.4 * tone)
            }
            Kept::Verge => Cover::flat(Material::Meadow, 0.8 * tone),
            Kept::Farm => Cover::flat(Material::Pasture, 0.7 * tone),
            Kept::Tanks => Cover::flat(Material::Yard, 0.5 * tone).of(Class::Roads),
        }
    }

    fn water_at(&self, pixel: usize, grain: f64) -> Cover {
        let (x, y) = centre(pixel);
        let depth = -self.water.outside[pixel] + 5.0 * gradient(x / 14.0, y / 14.0, SEED + 3);
        let material = if depth > 6.0 + 6.0 * grain { Material::WaterDeep } else { Material::WaterShallow };
        Cover::flat(material, 0.35 * gradient(x / 11.0, y / 23.0, SEED + 4) + 0.2 * grain)
    }

    fn road_at(&self, pixel: usize, grain: f64) -> Option<Cover> {
        let outside = roads::outside(self.roads.iter().filter(|road| road.paved), pixel);
        if outside < 0.0 {
            return Some(Cover::flat(Material::Asphalt, 0.35 * grain));
        }
        if roads::outside(self.roads.iter().filter(|road| !road.paved), pixel) < 0.0 {
            return Some(Cover::flat(Material::Track, 0.8 * grain));
        }
        (outside < 4.0).then(|| Cover::flat(Material::Meadow, 0.9 * grain))
    }

    /// Tree crowns where a wood stands.
    fn wood_at(&self, pixel: usize, grain: f64) -> Option<Cover> {
        let (x, y) = centre(pixel);
        let (relief, steep) = (self.terrain.relief[pixel], self.steep[pixel]);
        let offset = self.terrain.offset[pixel];
        let line = 235.0 + 45.0 * fractal(x / 120.0, y / 120.0, 3, SEED + 10);
        let patch =
            fractal(x / 230.0, y / 230.0, 4, SEED + 11) + 0.18 * gradient(x / 22.0, y / 22.0, SEED + 12);
        let favour = mix(-0.50, 0.28, smooth(14.0, 75.0, relief)) - 1.3 * smooth(0.7, 1.15, steep)
            + if offset < 0.0 { 0.04 } else { 0.0 }
            - 1.2 * smooth(line - 40.0, line, relief);
        let stream = smooth(34.0, 10.0, self.water.outside[pixel])
            * 0.75
            * smooth(-0.25, 0.2, gradient(x / 90.0, y / 90.0, SEED + 13));
        if patch + favour + stream < 0.12
            || roads::outside(self.roads, pixel) < 7.0
            || roads::village_radius(pixel) < 1.25
            || self.water.outside[pixel] < 4.0
            || sites::beside_line(x, y) < 12.0
        {
            return None;
        }

        let conifers = smooth(30.0, 130.0, relief) * 0.85 + 0.35 * gradient(x / 130.0, y / 130.0, SEED + 14);
        let edge = smooth(0.12, 0.34, patch + favour + stream);
        Some(tree_cover(x, y, conifers, edge, grain).of(Class::wood(conifers)))
    }

    fn garden_at(&self, x: f64, y: f64, grain: f64) -> Cover {
        let plot = gradient(x / 17.0, y / 17.0, SEED + 20) + 0.5 * grain;
        let material = match plot {
            p if p > 0.42 => Material::Yard,
            p if p < -0.55 => Material::Soil,
            p if p < -0.2 => Material::PastureLush,
            _ => Material::Garden,
        };
        let crown = crown(x, y, GARDEN_TREES, SEED + 21);
        if crown.height > 0.45 && in_garden(&crown) {
            let tree = Cover::flat(Material::BroadMid, crown.height * 1.2 - 0.9 + 0.3 * grain);
            return Cover { height: GARDEN_TALL * crown.height, class: Class::Gardens, ..tree };
        }
        Cover::flat(material, 0.8 * grain).of(Class::Gardens)
    }

    /// Strips along the valley, cut across into fields, each under one crop, most with a hedge around.
    fn field_at(&self, x: f64, y: f64, grain: f64) -> Cover {
        let (along, across) = valley_from_area(x, y);
        let u = along + 0.22 * across + 26.0 * gradient(x / 190.0, y / 190.0, SEED + 30);
        let v = across - centre_line(along) + 18.0 * gradient(x / 150.0, y / 150.0, SEED + 31);
        let (strip, to_strip) = cell(v, 86.0, 0, SEED + 32);
        let (part, to_part) = cell(u + 57.0 * (strip % 3) as f64, 128.0, strip, SEED + 33);
        let field = hash(part, strip, SEED + 34);
        let border = to_strip.min(to_part);
        let hedged = if to_strip < to_part {
            !hash(strip, 0, SEED + 35).is_multiple_of(5)
        } else {
            !hash(part, strip, SEED + 36).is_multiple_of(4)
        };
        let ragged = 2.3 + 1.3 * gradient(x / 8.0, y / 8.0, SEED + 37);
        if hedged && border < ragged && gradient(x / 40.0, y / 40.0, SEED + 38) > -0.62 {
            let height = 2.2 + 1.1 * gradient(x / 9.0, y / 9.0, SEED + 39);
            let hedge = Cover::flat(Material::Hedge, 1.2 * grain - 0.1);
            return Cover { height: height.max(1.2), ..hedge };
        }
        if border < 4.2 {
            return Cover::flat(Material::Meadow, grain);
        }

        let turn = if field & 64 == 0 { u } else { v };
        crop(field, turn, x, y, grain).of(if field % 16 < 8 { Class::Pasture } else { Class::Crops })
    }

    /// Unfarmed ground by height and steepness.
    fn wild_at(&self, pixel: usize, grain: f64) -> Cover {
        let (x, y) = centre(pixel);
        let (relief, steep) = (self.terrain.relief[pixel], self.steep[pixel]);
        let mottle = fractal(x / 28.0, y / 28.0, 3, SEED + 50);
        let wander = 0.22 * fractal(x / 70.0, y / 70.0, 3, SEED + 51) + 0.22 * grain;
        let snow =
            smooth(250.0, 430.0, relief + 110.0 * fractal(x / 95.0, y / 95.0, 5, SEED + 52)) - 0.72 * steep;
        if snow + 0.10 * grain > 0.06 {
            let shaded = 2.0 * mottle + 0.4 * grain < -0.9;
            let material = if shaded { Material::SnowShade } else { Material::Snow };
            return Cover::flat(material, 0.25 * mottle).of(Class::Snow);
        }

        if steep + wander > 1.02 {
            let bedding = gradient(
                (self.terrain.ground[pixel] + 9.0 * mottle) / 15.0,
                (0.8 * x + 0.6 * y) / 160.0,
                SEED + 53,
            );
            let grain = grain * smooth(2.2, 0.9, steep).max(0.35);
            let tone = bedding + 0.7 * grain + 0.6 * mottle;

            let material = if tone > 0.35 {
                Material::RockPale
            } else if tone > -0.3 {
                Material::RockMid
            } else {
                Material::RockDark
            };

            return Cover::flat(material, 0.8 * grain + 0.5 * bedding + 0.3 * mottle).of(Class::Rock);
        }

        let stones =
            fractal(x / 60.0, y / 60.0, 4, SEED + 54) + smooth(150.0, 420.0, relief) + 0.7 * (steep - 0.5);
        if stones + 0.9 * grain > 0.72 {
            let material = if grain + mottle > 0.45 { Material::RockMid } else { Material::Scree };
            return Cover::flat(material, 1.1 * grain).of(Class::Rock);
        }

        let dry = mottle + 0.9 * grain + smooth(60.0, 240.0, relief) - 0.5;
        let material = match (relief > 190.0 + 60.0 * mottle, dry) {
            (true, d) if d > 0.65 => Material::Heath,
            (_, d) if d > 0.25 => Material::AlpBrown,
            (_, d) if d > -0.35 => Material::AlpGreen,
            _ => Material::Pasture,
        };
        let class = if material == Material::Heath { Class::Heath } else { Class::Alp };

        Cover::flat(material, 0.9 * grain + 0.4 * mottle).of(class)
    }
}

/// Returns the cell of a line with uneven borders that a coordinate lies in, and its distance to the nearer border.
fn cell(at: f64, width: f64, row: i64, seed: u64) -> (i64, f64) {
    let edge = |k: i64| (k as f64 + 0.55 * (uniform(k, row, seed) - 0.5)) * width;
    let mut k = (at / width).floor() as i64;
    if at < edge(k) {
        k -= 1;
    } else if at >= edge(k + 1) {
        k += 1;
    }
    (k, (at - edge(k)).min(edge(k + 1) - at))
}

fn crop(field: u64, turn: f64, x: f64, y: f64, grain: f64) -> Cover {
    let mottle = fractal(x / 24.0, y / 24.0, 3, SEED + 60);
    let brightness = 0.5 * ((field >> 20 & 255) as f64 / 255.0 - 0.5);
    let rows = |period: f64| (std::f64::consts::TAU * turn / period).sin();
    let tramline = (turn / 17.0).rem_euclid(1.0) < 0.16;
    let fine = 0.75 * grain + 0.45 * mottle + brightness;

    match field % 16 {
        0..4 => {
            Cover::flat(pick(mottle + grain, Material::Pasture, Material::PastureLush), fine + 0.15 * grain)
        }
        4 | 5 => Cover::flat(pick(mottle + grain, Material::PastureDry, Material::Pasture), fine),
        6 | 7 => Cover::flat(pick(rows(19.0) + grain, Material::Hay, Material::Meadow), fine),
        8 | 9 => Cover::flat(
            pick(mottle + 0.6 * grain, Material::Wheat, Material::Barley),
            fine - if tramline { 0.5 } else { 0.0 },
        ),
        10 => Cover::flat(
            pick(1.6 * grain + mottle, Material::Rape, Material::Meadow),
            fine - if tramline { 0.6 } else { 0.0 },
        ),
        11 | 12 => Cover { height: 1.7, ..Cover::flat(Material::Maize, fine + 0.4 * rows(8.5)) },
        13 => Cover::flat(pick(mottle + grain, Material::Soil, Material::Stubble), fine + 0.3 * rows(9.5)),
        14 => Cover::flat(Material::Beet, fine + 0.35 * rows(10.5)),
        _ => Cover::flat(pick(rows(12.5) + 0.8 * grain, Material::Stubble, Material::Hay), fine),
    }
}

fn pick(value: f64, high: Material, low: Material) -> Material {
    if value > -0.12 { high } else { low }
}

/// Crowns of a wood; `conifers` is their share, `edge` 0 at the wood's rim … 1 inside.
fn tree_cover(x: f64, y: f64, conifers: f64, edge: f64, grain: f64) -> Cover {
    let crown = crown(x, y, 7.4, SEED + 40);
    if crown.height < 0.22 {
        let material = if grain > 0.2 { Material::PastureLush } else { Material::ForestFloor };
        return Cover { height: 0.4 + 2.0 * edge, ..Cover::flat(material, -0.6 + 0.4 * grain) };
    }

    let conifer = (crown.tree >> 8 & 255) as f64 / 255.0 < conifers;
    let material = match (conifer, crown.tree % 4) {
        (true, 0) => Material::ConiferBlue,
        (true, _) => Material::Conifer,
        (false, 0) => Material::BroadLight,
        (false, 1 | 2) => Material::BroadMid,
        (false, _) => Material::BroadDark,
    };

    let own = ((crown.tree >> 16 & 255) as f64 / 255.0 - 0.5) * 0.5;
    let tall = mix(7.0, if conifer { 15.0 } else { 13.0 }, edge);
    let height = if conifer { tall * crown.height.powf(1.3) } else { tall * crown.height };
    let ragged = 1.6 * (uniform((x * 4.0) as i64, (y * 4.0) as i64, SEED + 41) - 0.5);
    let shade = 1.5 * crown.height - 1.05 + own + 0.5 * grain + 0.12 * ragged;

    Cover { height: (height + ragged).max(2.0), ..Cover::flat(material, shade) }
}

/// Single trees: along hedges and water, on pastures and at the upper edge of the woods.
fn plant(scene: &Scene<'_>, surface: &mut [f64], colours: &mut [[u8; 3]]) -> Vec<Tree> {
    let mut trees = Vec::new();
    for tree in 0..4200i64 {
        let pick = |salt: u64| uniform(tree, 0, SEED + 80 + salt);
        let side = SIZE as f64 * SPACING;
        let (x, y) = (side * pick(0), side * pick(1));
        let Some(middle) = around(x, y, 0.0).next() else { continue };
        let relief = scene.terrain.relief[middle];
        let sparse = if relief < 20.0 { 0.35 } else { 0.75 } * smooth(330.0, 230.0, relief);
        if scene.water.outside[middle] < 6.0
            || roads::outside(scene.roads, middle) < 6.0
            || scene.steep[middle] > 0.9
            || pick(2) > sparse
            || roads::village_radius(middle) < 1.1
            || !bears_trees(scene.at(middle).material)
        {
            continue;
        }

        let conifer = pick(3) < smooth(60.0, 170.0, relief);
        let radius = if conifer { 3.4 + 1.2 * pick(4) } else { 4.2 + 2.6 * pick(4) };
        let tall = if conifer { 9.0 + 5.0 * pick(5) } else { 7.0 + 6.0 * pick(5) };
        if !sites::bears_tree(x, y, radius) {
            continue;
        }

        trees.push(Tree { x, y, radius, tall, conifer });
        let material = if conifer {
            Material::Conifer
        } else if pick(6) < 0.5 {
            Material::BroadMid
        } else {
            Material::BroadDark
        };

        for pixel in around(x, y, radius) {
            let (px, py) = centre(pixel);
            let ragged = radius * (1.0 + 0.25 * gradient(px / 3.1, py / 3.1, SEED + 90));
            let inside = 1.0 - ((px - x).powi(2) + (py - y).powi(2)) / (ragged * ragged);
            if inside > 0.05 {
                let ragged = inside.sqrt() * (0.78 + 0.3 * uniform(pixel as i64, tree, SEED + 91));
                let top = rounded(scene.terrain.ground[pixel] + tall * ragged, 0.5);
                if top > surface[pixel] {
                    surface[pixel] = top;
                    colours[pixel] = colour(material, 1.9 * ragged - 1.25);
                }
            }
        }
    }

    trees
}

fn in_garden(crown: &Crown) -> bool {
    crown.tree % 7 < 2
}

/// The trees of gardens, where they have room between buildings and lanes.
fn garden_trees<'a>(scene: &'a Scene<'_>, buildings: &'a [Building]) -> impl Iterator<Item = Tree> + use<'a> {
    let stems = stems(GARDEN_TREES, SEED + 21, 2.0 * SIZE as f64 * SPACING);
    stems.filter(|(.., crown)| in_garden(crown)).filter_map(|(x, y, crown)| {
        let radius = 3.4 * crown.height;
        let pixel = around(x, y, 0.0).next().filter(|&pixel| roads::village_radius(pixel) < 1.1)?;
        let free = !buildings.iter().any(|building| building.covers(x, y, radius))
            && roads::outside(scene.roads, pixel) > radius
            && sites::bears_tree(x, y, radius);
        let is_garden = scene.at(pixel).class == Class::Gardens;
        (free && is_garden).then_some(Tree { x, y, radius, tall: GARDEN_TALL * crown.height, conifer: false })
    })
}

/// Darkens the ground at the foot of trees: it is what the steep side of a crown shows.
fn skirt(scene: &Scene<'_>, surface: &[f64], colours: &mut [[u8; 3]]) {
    let bare = |pixel: usize| surface[pixel] - scene.terrain.ground[pixel] < 1.0;
    for row in 1..SIZE - 1 {
        for column in 1..SIZE - 1 {
            let pixel = row * SIZE + column;
            let beside = [pixel - 1, pixel + 1, pixel - SIZE, pixel + SIZE];
            let crown = beside.iter().any(|&other| surface[other] - scene.terrain.ground[other] > 3.5);
            if bare(pixel)
                && crown
                && scene.water.outside[pixel] > 0.0
                && roads::outside(scene.roads, pixel) > 0.0
            {
                let shade = uniform(pixel as i64, 0, SEED + 95) - 0.9;
                colours[pixel] = colour(Material::ForestFloor, shade);
            }
        }
    }
}

/// Farmers leave trees in hedges and on grass, not in crops; nothing stands on rock.
fn bears_trees(material: Material) -> bool {
    use Material::{AlpBrown, AlpGreen, Hedge, Meadow, Pasture, PastureLush, Scree};
    matches!(material, Pasture | PastureLush | Hedge | Meadow | AlpGreen | AlpBrown | Scree)
}
