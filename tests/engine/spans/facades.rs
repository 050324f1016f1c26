//! Façades, by scan planes and by the reference.

use glam::{DVec2, DVec3, Vec3};

use super::scenes::{CODE, SPACING, pillar, standing, walls_of};
use hedgehop::earth::Curvature;
use hedgehop::frame::Frame;
use hedgehop::render::{RenderOptions, Renderer, render_reference};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Bays, Facade, FacadeStyle, MemPages, Span};

const MIDDLE: DVec2 = DVec2::new(160.0, 280.0);
/// Half of the house's sides, units, and its turn from the axes, radians.
const HALF: DVec2 = DVec2::new(8.0, 5.0);
const TURN: f64 = 0.3;
const STOREYS: u8 = 3;
const HEIGHT: f64 = 9.0;

/// A house with a flat roof, and with a façade or without.
fn house(has_facade: bool) -> MemPages {
    let turned = |angle: f64| (angle / std::f64::consts::TAU * 256.0).round().rem_euclid(256.0) as u8;
    let bays = [TURN, TURN + std::f64::consts::FRAC_PI_2].map(|angle| Bays::new(turned(angle), 3.0, 1.0));
    let facade = Facade {
        floor: CODE.encode(0.4),
        eaves: CODE.encode(HEIGHT - 0.2),
        storeys: STOREYS,
        look: Facade::look(FacadeStyle::Apartments, 2),
        bays,
    };
    standing(|x, y| {
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let cuts = walls_of(DVec2::from_angle(-TURN).rotate(at - MIDDLE), TURN, HALF);
        let facade = if has_facade { facade } else { Facade::NONE };
        cuts.map(|cuts| Span { cuts, facade, side: [190, 170, 150], ..pillar(HEIGHT) }).into_iter().collect()
    })
}

/// A camera that looks at the house's southern wall from a distance (metres), so many degrees from its normal.
fn camera(distance: f64, aside: f64, hfov: f64) -> Camera {
    let out = DVec2::from_angle(TURN + aside.to_radians()).rotate(DVec2::NEG_Y);
    let wall = MIDDLE + DVec2::from_angle(TURN).rotate(DVec2::NEG_Y) * HALF.y;
    let eye = DVec2::new(1000.0, 2000.0) + (wall * SPACING + out * distance);
    let yaw = (-out.x).atan2(-out.y).to_degrees();
    let attitude = Attitude { yaw, pitch: 0.0, roll: 0.0 };
    Camera::new(Pose { eye: DVec3::new(eye.x, eye.y, 5.0), attitude, hfov }, 320, 180)
}

fn options(pages: &MemPages) -> RenderOptions {
    RenderOptions {
        curvature: Curvature::FLAT,
        ..RenderOptions::of(hedgehop::voxel::PageSource::header(pages))
    }
}

fn light(frame: &Frame, index: usize) -> Vec3 {
    Vec3::from_array(frame.colour[index])
}

/// Pixels in the frame's middle, where nothing but the wall is seen.
fn inner() -> impl Iterator<Item = usize> {
    (70..110).flat_map(|y| (120..200).map(move |x| y * 320 + x))
}

#[test]
fn planes_see_facades_as_the_reference_does() {
    let (with, without) = (house(true), house(false));
    let farm = Farm::new(2).unwrap();
    for (distance, aside, hfov) in
        [(18.0, 0.0, 60.0), (40.0, 35.0, 24.0), (60.0, -55.0, 12.0), (120.0, 20.0, 8.0)]
    {
        let camera = camera(distance, aside, hfov);
        let fast = Renderer::new(&with, &options(&with)).frame(&camera, &farm).unwrap().frame;
        let exact = render_reference(&with, &camera, &options(&with), &farm).unwrap().frame;
        let plain = Renderer::new(&without, &options(&without)).frame(&camera, &farm).unwrap().frame;
        let mean = |one: &Frame, other: &Frame| {
            let off = |index| f64::from((light(one, index) - light(other, index)).abs().max_element());
            inner().map(off).sum::<f64>() / inner().count() as f64
        };
        let (off, shown) = (mean(&fast, &exact), mean(&fast, &plain));
        assert!(off < 0.02 && shown > 5.0 * off, "{distance} m, {aside}°: {off} of {shown}");
    }
}

#[test]
fn walls_are_as_without_facades_from_afar() {
    let farm = Farm::new(2).unwrap();
    let camera = camera(480.0, 10.0, 60.0);
    let frames = [true, false].map(|has_facade| {
        let pages = house(has_facade);
        Renderer::new(&pages, &options(&pages)).frame(&camera, &farm).unwrap().frame
    });
    assert_eq!(frames[0].colour, frames[1].colour);
}

#[test]
fn facades_are_the_same_by_any_number_of_workers() {
    let pages = house(true);
    let camera = camera(40.0, 35.0, 40.0);
    let [one, three] = [1, 3].map(|workers| {
        Renderer::new(&pages, &options(&pages)).frame(&camera, &Farm::new(workers).unwrap()).unwrap().frame
    });
    assert_eq!(one.colour, three.colour);
}
