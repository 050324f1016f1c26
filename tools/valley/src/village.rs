//! Buildings: rectangles beside the lanes, with roofs that rise in steps to the ridge, and a church.

use glam::{DVec2, dvec2};

use crate::grid::{SIZE, SPACING, around, centre, sample};
use crate::noise::uniform;
use crate::palette::Material;
use crate::roads::Road;
use crate::terrain::{area_from_valley, centre_line};
use crate::water::Water;

/// Use of a building.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    House,
    Barn,
    Church,
    Tower,
}

/// One building.
pub struct Building {
    pub kind: Use,
    pub x: f64,
    pub y: f64,
    /// Unit vector along the ridge.
    pub axis: DVec2,
    /// Half the length and half the width, metres.
    pub half: DVec2,
    pub eaves: f64,
    /// Rise from the eaves to the ridge.
    pub roof: f64,
    /// Material of the roof.
    pub material: Material,
}

impl Building {
    /// Returns the coordinates of a place along and across the ridge, metres.
    fn local(&self, x: f64, y: f64) -> DVec2 {
        let (dx, dy) = (x - self.x, y - self.y);
        dvec2(dx * self.axis.x + dy * self.axis.y, dy * self.axis.x - dx * self.axis.y)
    }

    /// Corners, counterclockwise, of a building that is `margin` metres wider on all sides.
    pub fn corners(&self, margin: f64) -> [DVec2; 4] {
        let (length, width) = (self.half.x + margin, self.half.y + margin);
        [(-length, -width), (length, -width), (length, width), (-length, width)].map(|(u, v)| {
            dvec2(self.x + u * self.axis.x - v * self.axis.y, self.y + u * self.axis.y + v * self.axis.x)
        })
    }

    /// Whether a place lies in it or no more than `margin` metres beside it.
    pub fn covers(&self, x: f64, y: f64, margin: f64) -> bool {
        let place = self.local(x, y);
        place.x.abs() < self.half.x + margin && place.y.abs() < self.half.y + margin
    }

    /// Whether two lie on each other: no edge of either has the other wholly beyond it.
    pub fn overlaps(&self, other: &Self) -> bool {
        let apart = |a: &Self, b: &Self| {
            let corners = b.corners(0.0).map(|corner| a.local(corner.x, corner.y));
            let beyond = |far: &dyn Fn(DVec2) -> f64| corners.iter().all(|&corner| far(corner) > -0.01);
            beyond(&|corner| corner.x - a.half.x)
                || beyond(&|corner| -corner.x - a.half.x)
                || beyond(&|corner| corner.y - a.half.y)
                || beyond(&|corner| -corner.y - a.half.y)
        };
        !apart(self, other) && !apart(other, self)
    }
}

/// Places about sixty buildings where none overlaps another, a road or water.
pub fn place(roads: &[Road], water: &Water) -> Vec<Building> {
    let mut buildings = vec![church(), tower()];
    for (number, road) in roads.iter().enumerate().take(4) {
        let mut k = 3;
        while k + 3 < road.line.len() {
            for side in [1.0, -1.0] {
                let building = beside(road, k, side, (number * 1000 + k) as i64);
                if fits(&building, &buildings, roads, water) {
                    buildings.push(building);
                }
            }
            k += 2;
        }
    }
    buildings
}

fn beside(road: &Road, k: usize, side: f64, seed: i64) -> Building {
    let pick = |salt: u64| uniform(seed, side as i64, 700 + salt);
    let (a, b) = (road.line[k - 2], road.line[k + 2]);
    let length = (b.x - a.x).hypot(b.y - a.y);
    let turn = 0.16 * (pick(0) - 0.5);
    let (c, s) = ((b.x - a.x) / length, (b.y - a.y) / length);
    let longer = 1.0f64.hypot(turn);
    let along = dvec2((c - turn * s) / longer, (s + turn * c) / longer);
    let barn = pick(1) < 0.14;
    let half = if barn {
        dvec2(9.0 + 4.0 * pick(2), 5.8 + 1.5 * pick(3))
    } else {
        dvec2(6.2 + 3.0 * pick(2), 5.0 + 1.2 * pick(3))
    };
    let gable = pick(4) < 0.35;
    let axis = if gable { dvec2(-along.y, along.x) } else { along };
    let depth = if gable { half.x } else { half.y };
    let setback = side * (road.half + 4.0 + depth + 7.0 * pick(5));

    let material = match (barn, (pick(6) * 10.0) as u32) {
        (true, 0..=3) => Material::RoofMetal,
        (_, 0..=3) => Material::RoofTile,
        (_, 4..=6) => Material::RoofTileDark,
        (_, 7 | 8) => Material::RoofSlate,
        _ => Material::RoofWood,
    };

    Building {
        kind: if barn { Use::Barn } else { Use::House },
        x: road.line[k].x - setback * along.y,
        y: road.line[k].y + setback * along.x,
        axis,
        half,
        eaves: if barn { 5.0 } else { 4.5 + 2.5 * pick(7) },
        roof: 0.45 * half.y,
        material,
    }
}

fn church() -> Building {
    let DVec2 { x, y } = area_from_valley(-276.4, centre_line(-276.4) - 113.7);
    Building {
        kind: Use::Church,
        x,
        y,
        axis: dvec2(0.94, 0.342),
        half: dvec2(12.0, 5.5),
        eaves: 9.0,
        roof: 5.5,
        material: Material::RoofSlate,
    }
}

fn tower() -> Building {
    let church = church();
    let (x, y) = (church.x - 16.0 * church.axis.x, church.y - 16.0 * church.axis.y);
    Building { kind: Use::Tower, x, y, half: dvec2(4.0, 4.0), eaves: 17.0, roof: 9.0, ..church }
}

fn fits(building: &Building, others: &[Building], roads: &[Road], water: &Water) -> bool {
    let reach = building.half.x.hypot(building.half.y);
    let margin = 2.0 * SPACING + reach;
    if !(margin..SIZE as f64 * SPACING - margin).contains(&building.x)
        || !(margin..SIZE as f64 * SPACING - margin).contains(&building.y)
    {
        return false;
    }

    let Some(pixel) = around(building.x, building.y, 0.0).next() else { return false };
    let density = 1.36 - crate::roads::village_radius(pixel);
    let clear = others.iter().all(|other| {
        let away = (other.x - building.x).hypot(other.y - building.y);
        away > reach + other.half.x.hypot(other.half.y) - 3.0 && !other.overlaps(building)
    });

    let on_road = roads.iter().any(|road| {
        let mut middles = road.line.windows(2).map(|pair| {
            let [a, b] = [pair[0], pair[1]];
            (a + b) / 2.0
        });
        middles.any(|middle| building.covers(middle.x, middle.y, road.half + 1.0))
    });

    clear
        && !on_road
        && uniform((building.x * 8.0) as i64, (building.y * 8.0) as i64, 720) < density
        && water.outside[pixel] > reach + 8.0
        && crate::roads::outside(roads, pixel) > building.half.y + 1.5
}

/// Draws the buildings: heights onto `surface`, roofs into `paint` (material and shade by pixel).
pub fn draw(
    buildings: &[Building],
    ground: &[f64],
    surface: &mut [f64],
    mut paint: impl FnMut(usize, Material, f64),
) {
    for building in buildings {
        let base = sample(ground, building.x, building.y);
        for pixel in around(building.x, building.y, building.half.x.hypot(building.half.y) + SPACING) {
            let (x, y) = centre(pixel);
            let DVec2 { x: u, y: v } = building.local(x, y);
            if u.abs() > building.half.x + SPACING / 2.0 || v.abs() > building.half.y + SPACING / 2.0 {
                continue;
            }
            if u.abs() > building.half.x || v.abs() > building.half.y {
                paint(pixel, Material::Wall, 0.4 * (uniform(pixel as i64, 0, 740) - 0.5));
                continue;
            }

            let towards_ridge = 1.0 - v.abs() / building.half.y;
            let stepped = ((towards_ridge * 3.0).floor() + 0.5) / 3.0;
            surface[pixel] = base + building.eaves + building.roof * stepped;
            let (x, y) = (building.x as i64, building.y as i64);
            let lit = if v * building.axis.x > 0.0 { 0.12 } else { -0.08 };
            paint(pixel, building.material, lit + 0.25 * (uniform(x, y, 730) - 0.5));
        }
    }
}
