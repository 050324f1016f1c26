//! Paint on the ground of databases: areas at every level, what lies over what, what the ground is made of.

use std::f64::consts::PI;

use glam::DVec2;

use super::support::{Area, built};
use crate::synthetic::{Circle, TouchdownZone};
use crate::synthetic::{
    EllipsePiece, GroundPatch, PaintCoat, Palette, Sector, Stop, Synthetic, Terrain, bomb_circle, lake,
};
use hedgehop::voxel::{Material, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::colour::linear_from_srgb8;

const SIDE: f64 = 640.0;
const WHITE: [u8; 3] = [255; 3];

fn one(piece: EllipsePiece) -> GroundPatch {
    painted(vec![PaintCoat { pieces: vec![piece], colour: Some(WHITE) }])
}

fn painted(coats: Vec<PaintCoat>) -> GroundPatch {
    GroundPatch { coats, material: None, strength: 1.0, priority: 0 }
}

/// Black level ground of one-metre voxels with patches.
fn made(patches: &[GroundPatch]) -> Area {
    built(vec![], vec![], |options| {
        options.local = true;
        options.bbox = Some([0.0, 0.0, SIDE, SIDE]);
        options.spacing = Some(1.0);
        options.synthetic = Synthetic {
            terrain: vec![Terrain::Plane {
                height_m: 10.0,
                centre: DVec2::ZERO,
                slope: 0.0,
                upward_deg: 0.0,
            }],
            palette: Some(Palette::new(&[Stop { at: 0.0, colour: [0; 3] }], &[])),
            patches: patches.to_vec(),
            ..Synthetic::default()
        };
    })
}

/// Linear light of all voxels of a level, by their places.
fn light(area: &Area, level: u8) -> (usize, Vec<f32>) {
    let side = (SIDE as u32).div_ceil(4_u32.pow(u32::from(level)));
    let at = |x: u32, y: u32| {
        let id = PageId { level, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
        let page = area.pages.page(id).unwrap().unwrap();
        linear_from_srgb8(page.colours[page.sample(x % PAGE_SIDE, y % PAGE_SIDE)])[1]
    };
    (side as usize, (0..side * side).map(|index| at(index % side, index / side)).collect())
}

#[test]
fn areas_are_within_half_a_percent_at_levels_one_to_sixteen() {
    let centre = DVec2::new(311.7, 322.4);
    let ellipse = EllipsePiece {
        radii: DVec2::new(140.0, 55.0),
        azimuth_deg: 28.0,
        ..EllipsePiece::circle(centre, 1.0)
    };
    let circle = EllipsePiece::circle(centre, 90.0);
    let road = EllipsePiece { inner: Some(DVec2::splat(82.0)), ..circle };
    let sector = Some(Sector { from_deg: 40.0, width_deg: 250.0 });
    let road_area = PI * (8100.0 - 82.0 * 82.0);
    for (piece, area) in [
        (ellipse, PI * 140.0 * 55.0),
        (circle, PI * 8100.0),
        (road, road_area),
        (EllipsePiece { sector, ..road }, road_area * 250.0 / 360.0),
    ] {
        let made = made(&[one(piece)]);
        let mut before: Option<Vec<f32>> = None;
        for (level, metres) in [(0, 1.0), (1, 4.0), (2, 16.0)] {
            let (side, light) = light(&made, level);
            let found = light.iter().map(|light| f64::from(*light)).sum::<f64>() * metres * metres;
            assert!((found / area - 1.0).abs() < 0.005, "{piece:?}, level {level}: {found}, not {area}");

            // A voxel has the mean of its sixteen children, but for the steps of codes.
            if let Some(fine) = before.filter(|_| metres > 1.0) {
                let wide = 4 * side;
                for (index, light) in light.iter().enumerate() {
                    let (x, y) = (4 * (index % side), 4 * (index / side));
                    let child = |part: usize| fine[(y + part / 4) * wide + x + part % 4];
                    let mean = (0..16).map(child).sum::<f32>() / 16.0;
                    assert!((light - mean).abs() < 1.5 / 255.0, "level {level}: {light}, not {mean}");
                }
            }
            before = Some(light);
        }
    }
}

#[test]
fn priorities_say_what_lies_over_what_in_any_order() {
    let patch = |x: f64, colour: [u8; 3], priority: i32| GroundPatch {
        coats: vec![PaintCoat {
            pieces: vec![EllipsePiece::circle(DVec2::new(300.0 + x, 300.0), 60.0)],
            colour: Some(colour),
        }],
        material: None,
        strength: 1.0,
        priority,
    };
    let patches = [patch(0.0, [200, 0, 0], 2), patch(40.0, [0, 200, 0], 1), patch(-30.0, [0, 0, 200], 3)];
    let first = made(&patches);
    assert_eq!(first.colour(300, 300), [0, 0, 200]);
    assert_eq!(first.colour(345, 300), [200, 0, 0]);
    assert_eq!(first.colour(370, 300), [0, 200, 0]);
    for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let area = made(&order.map(|index: usize| patches[index].clone()));
        let (_, light) = light(&first, 0);
        assert!(light == self::light(&area, 0).1, "{order:?}");
        assert!(first.voxels().all(|(x, y)| first.colour(x, y) == area.colour(x, y)), "{order:?}");
    }
    // At equal priority the later patch lies above.
    let equal = [patches[0].clone(), GroundPatch { priority: 2, ..patches[1].clone() }];
    assert_eq!(made(&equal).colour(320, 300), [0, 200, 0]);
}

#[test]
fn rings_of_bomb_circles_have_their_widths() {
    let circle = Circle { centre: DVec2::new(320.5, 300.5), radius_m: 200.0 };
    let area = made(&[painted(bomb_circle(circle, 4, &[WHITE, [0; 3]]))]);
    // Along a row through the middle light changes at 200, 150, 100 and 50 m to both sides.
    let row: Vec<f32> = (0..640).map(|x| linear_from_srgb8(area.colour(x, 300))[1]).collect();
    let sum = |from: usize, to: usize| row[from..to].iter().sum::<f32>();
    for (from, to, wanted) in [(100, 200, 50.0), (200, 320, 50.0), (321, 440, 50.0), (440, 640, 50.0)] {
        let width = sum(from, to);
        assert!((width - wanted).abs() < 0.5, "{from} to {to}: {width}");
    }
    let total: f32 = light(&area, 0).1.iter().sum();
    let wanted = PI as f32 * (200.0_f32.powi(2) - 150.0_f32.powi(2) + 100.0_f32.powi(2) - 50.0_f32.powi(2));
    assert!((total / wanted - 1.0).abs() < 0.005, "{total}, not {wanted}");
}

#[test]
fn lakes_are_water_and_tyre_marks_lie_on_what_is_below() {
    let circle = Circle { centre: DVec2::new(300.0, 300.0), radius_m: 120.0 };
    let water = GroundPatch {
        material: Some(Material::Water),
        ..painted(vec![PaintCoat { pieces: lake(circle, 0.3, 5), colour: Some([30, 60, 70]) }])
    };
    let bed = GroundPatch {
        material: Some(Material::Concrete),
        ..painted(vec![PaintCoat { pieces: vec![EllipsePiece::circle(circle.centre, 290.0)], colour: None }])
    };
    let zone = TouchdownZone {
        centre: DVec2::new(300.0, 480.0),
        azimuth_deg: 90.0,
        length_m: 300.0,
        width_m: 20.0,
        count: 50,
        seed: 1,
    };
    let marks = GroundPatch {
        strength: 0.6,
        ..painted(vec![PaintCoat { pieces: zone.marks(), colour: Some([38; 3]) }])
    };
    let area = made(&[bed, water, marks]);
    assert_eq!(area.attributes(300, 300).material, Material::Water.code());
    assert_eq!(area.colour(300, 300), [30, 60, 70]);
    let concrete = area.colour(300, 80);
    assert!(area.attributes(300, 80).material == Material::Concrete.code() && concrete[0] > 100);
    let darker = (160..440).filter(|x| (470..490).any(|y| area.colour(*x, y)[0] < concrete[0] - 20)).count();
    assert!(darker > 200, "{darker}");
    assert_eq!(area.attributes(300, 480).material, Material::Concrete.code());
    assert_eq!(area.attributes(5, 5).material, 0);
}
