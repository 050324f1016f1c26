//! The farm that was scanned: its roofs, trees and fence, in a frame of its own.

use glam::{DVec2, dvec2};

use crate::grid::{PIXELS, around, centre, sample};
use crate::noise::{gradient, uniform};
use crate::palette::{Material, colour};
use crate::sites::FARM;

/// Cosine and sine of the angle, from east, of the frame's first axis: walls run along the sides of pixels.
const AXIS: DVec2 = dvec2(1.0, 0.0);

/// A rectangular part of a building, along the frame's axes.
pub struct FarmPart {
    /// Middle, and half the size, metres.
    pub middle: DVec2,
    pub half: DVec2,
    pub eaves: f64,
    /// Rise from the eaves to the ridge; of a shed, from the lower side to the upper.
    pub rise: f64,
    pub form: Form,
    pub roof: Material,
    /// Walls in sRGB; none if its sides are open.
    pub walls: Option<[u8; 3]>,
    /// Index of the part on whose level it stands.
    pub level_of: usize,
}

/// Course of a roof's ridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    RidgeAlong,
    RidgeAcross,
    /// One plane, which falls along the second axis.
    Shed,
}

const PLASTER: [u8; 3] = [214, 206, 188];

/// The house's two wings, the barn, the shed.
pub const PARTS: [FarmPart; 4] = [
    FarmPart {
        middle: dvec2(-13.75, 14.375),
        half: dvec2(8.75, 4.375),
        eaves: 5.2,
        rise: 3.4,
        form: Form::RidgeAlong,
        roof: Material::RoofTile,
        walls: Some(PLASTER),
        level_of: 0,
    },
    FarmPart {
        middle: dvec2(-8.75, 5.9375),
        half: dvec2(3.75, 8.4375),
        eaves: 5.2,
        rise: 2.8,
        form: Form::RidgeAcross,
        roof: Material::RoofTile,
        walls: Some(PLASTER),
        level_of: 0,
    },
    FarmPart {
        middle: dvec2(14.375, 6.25),
        half: dvec2(5.625, 11.25),
        eaves: 5.5,
        rise: 4.4,
        form: Form::RidgeAcross,
        roof: Material::RoofTileDark,
        walls: Some([124, 100, 76]),
        level_of: 2,
    },
    FarmPart {
        middle: dvec2(1.875, -18.125),
        half: dvec2(8.125, 3.125),
        eaves: 3.4,
        rise: 1.2,
        form: Form::Shed,
        roof: Material::RoofMetal,
        walls: None,
        level_of: 3,
    },
];

impl FarmPart {
    /// Height of the roof above the level that it stands on; `None` beside it.
    fn roof_at(&self, u: f64, v: f64) -> Option<f64> {
        let (du, dv) = ((u - self.middle.x) / self.half.x, (v - self.middle.y) / self.half.y);
        let up = match self.form {
            Form::RidgeAlong => 1.0 - dv.abs(),
            Form::RidgeAcross => 1.0 - du.abs(),
            Form::Shed => (1.0 + dv) / 2.0,
        };
        (du.abs() <= 1.0 && dv.abs() <= 1.0).then_some(self.eaves + self.rise * up)
    }
}

/// A tree of the farm.
pub struct FarmTree {
    /// Place of the stem in the farm's frame, metres.
    pub place: DVec2,
    /// Radius of the crown, metres.
    pub radius: f64,
    /// Height above the ground, metres.
    pub tall: f64,
}

const fn tree(u: f64, v: f64, radius: f64, tall: f64) -> FarmTree {
    FarmTree { place: dvec2(u, v), radius, tall }
}

/// Trees around the farm.
pub const TREES: [FarmTree; 12] = [
    tree(-31.0, -22.0, 2.9, 6.5),
    tree(-22.0, -24.0, 2.6, 6.0),
    tree(-32.0, -13.0, 2.7, 6.2),
    tree(-23.0, -15.0, 3.0, 6.8),
    tree(-32.0, 0.0, 3.8, 10.0),
    tree(-30.0, 22.0, 4.4, 12.5),
    tree(-18.0, 26.0, 3.6, 10.5),
    tree(-2.0, 26.0, 4.6, 13.5),
    tree(26.0, 25.0, 4.2, 12.0),
    tree(30.0, 10.0, 3.4, 9.0),
    tree(31.0, -3.0, 3.0, 8.0),
    tree(24.0, -21.0, 3.3, 8.5),
];

/// Corners of the fence around the paddock.
pub const FENCE: [DVec2; 5] =
    [dvec2(15.0, -11.0), dvec2(33.0, -11.0), dvec2(33.0, -28.0), dvec2(15.0, -28.0), dvec2(15.0, -11.0)];

/// The farm on its ground.
pub struct Farm {
    /// Heights on which the parts stand, metres above the sea.
    levels: [f64; 4],
}

impl Farm {
    /// On bare ground.
    pub fn new(bare: &[f64]) -> Self {
        let at = |index: usize| {
            let DVec2 { x: u, y: v } = PARTS[index].middle;
            let DVec2 { x, y } = area_from_farm(u, v);
            sample(bare, x, y)
        };
        Self { levels: PARTS.each_ref().map(|part| at(part.level_of)) }
    }

    /// The highest roof over a place of the frame, metres above the sea, and its part.
    pub fn roof(&self, u: f64, v: f64) -> Option<(f64, &'static FarmPart)> {
        let over = PARTS.iter().zip(self.levels).filter_map(|(part, level)| {
            let height = part.roof_at(u, v)?;
            Some((level + height, part))
        });
        over.reduce(|best, other| if other.0 > best.0 { other } else { best })
    }

    /// Draws it: heights, and colours of roofs, crowns, yard and drive.
    pub fn draw(&self, surface: &mut [f64], colours: &mut [[u8; 3]]) {
        let middle = middle();
        for pixel in around(middle.x, middle.y, 60.0).filter(|pixel| *pixel < PIXELS) {
            let (x, y) = centre(pixel);
            let (u, v) = farm_from_area(x, y);
            let grain = uniform(pixel as i64, 0, 760) - 0.5;
            if let Some((height, part)) = self.roof(u, v) {
                surface[pixel] = height;
                colours[pixel] = roof_colour(part, u, v);
            } else if let Some((rise, shade)) = crown(u, v) {
                surface[pixel] += rise;
                colours[pixel] = colour(Material::BroadMid, shade + 0.4 * grain);
            } else if in_yard(u, v) {
                colours[pixel] = colour(Material::Yard, 0.6 * grain);
            } else if on_drive(u, v) {
                colours[pixel] = colour(Material::Track, 0.8 * grain);
            }
        }
    }
}

/// Colour of a roof: its two sides differ in light.
pub fn roof_colour(part: &FarmPart, u: f64, v: f64) -> [u8; 3] {
    let lit = match part.form {
        Form::RidgeAlong => v < part.middle.y,
        Form::RidgeAcross => u < part.middle.x,
        Form::Shed => true,
    };
    colour(part.roof, if lit { 0.1 } else { -0.1 })
}

/// Height of the crown over a place above the ground, and its shade.
fn crown(u: f64, v: f64) -> Option<(f64, f64)> {
    let over = TREES.iter().filter_map(|&FarmTree { place, radius, tall }| {
        let inside = 1.0 - ((u - place.x).powi(2) + (v - place.y).powi(2)) / (radius * radius);
        (inside > 0.0).then(|| (tall * (0.6 + 0.4 * inside.sqrt()), 1.4 * inside.sqrt() - 0.9))
    });
    over.reduce(|best, other| if other.0 > best.0 { other } else { best })
}

/// Whether gravel lies at a place: between house, barn and shed.
pub fn in_yard(u: f64, v: f64) -> bool {
    let ragged = 1.5 * gradient(u / 7.0, v / 7.0, 761);
    (-6.0 - ragged..8.5 + ragged).contains(&u) && (-14.0..15.0 + ragged).contains(&v)
}

/// Whether the drive from the track to the yard lies at a place.
pub fn on_drive(u: f64, v: f64) -> bool {
    let (from, to) = (farm_from_area(1684.0, 1268.0), (-8.0, -8.0));
    let (du, dv) = (to.0 - from.0, to.1 - from.1);
    let t = (((u - from.0) * du + (v - from.1) * dv) / (du * du + dv * dv)).clamp(0.0, 1.0);
    (u - from.0 - t * du).hypot(v - from.1 - t * dv) < 1.9
}

fn middle() -> DVec2 {
    dvec2((FARM[0] + FARM[2]) / 2.0, (FARM[1] + FARM[3]) / 2.0)
}

/// Metres in the area of a place of the farm's frame.
pub fn area_from_farm(u: f64, v: f64) -> DVec2 {
    let DVec2 { x, y } = middle();
    dvec2(x + AXIS.x * u - AXIS.y * v, y + AXIS.y * u + AXIS.x * v)
}

/// Inverse of [`area_from_farm`].
pub fn farm_from_area(x: f64, y: f64) -> (f64, f64) {
    let (dx, dy) = (x - middle().x, y - middle().y);
    (AXIS.x * dx + AXIS.y * dy, AXIS.x * dy - AXIS.y * dx)
}
