//! Priorities, edges, blocks nearby, and the time of a picture.

use std::time::{Duration, Instant};

use super::super::eye::{Eye, EyeAttitude};
use super::super::view::Screen;
use super::*;
use crate::code::CyclicCode;
use crate::projection::Projection;
use crate::subterrain::Subterrain;

const SKY: u8 = 240;
const GROUND: u8 = 60;
const RUNWAY: u8 = 10;

/// Terrain whose shades lie from 112 to 143, about a runway, before an eye so high.
fn scene() -> StudyScene {
    let subterrain = Subterrain { first_line: 0, start: 1 };
    StudyScene {
        sky: SKY,
        ground: GROUND,
        terrain: TexturedTerrain {
            outline: GroundQuad::rectangle([2000.0, 9000.0], [-1500.0, 1500.0]),
            code: SubterrainCode::new(CyclicCode::default(), vec![subterrain]).unwrap(),
            cell: 6.0,
            shades: Shades::new(32, 128).unwrap(),
            subdivision: 12,
            slices: 4,
            is_smooth_nearby: false,
        },
        runway: Some(Runway {
            outline: GroundQuad::rectangle([1000.0, 6000.0], [200.0, 500.0]),
            tone: RUNWAY,
        }),
        has_smooth_edges: true,
    }
}

fn view(altitude: f64, attitude: EyeAttitude, screen: Screen) -> GroundView {
    GroundView::new(Eye { place: [0.0, 0.0], altitude, attitude }, screen)
}

const SMALL: Screen = Screen { projection: Projection { pixels: 160, fov_deg: 45.0 }, lines: 120 };
const DOWN: EyeAttitude = EyeAttitude { heading_deg: 0.0, pitch_deg: -5.0, roll_deg: 0.0 };

#[test]
fn runway_hides_terrain_terrain_hides_ground_and_sky_is_above() {
    let scene = scene();
    for roll_deg in [0.0, 20.0, -75.0] {
        let view = view(700.0, EyeAttitude { roll_deg, ..DOWN }, SMALL);
        let picture = scene.picture(&view);
        let mut counts = [0; 4];
        for (number, &grey) in (0..).zip(&picture.greys) {
            let at = SMALL.pixel(number);
            let holds = |quad: GroundQuad, [x, y]: [f64; 2]| {
                let [low, _, high, _] = quad.corners;
                (low[0]..high[0]).contains(&x) && (low[1]..high[1]).contains(&y)
            };
            // Surfaces in which all four corners and the middle of a pixel lie.
            let parts =
                [[0.0, 0.0], [-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]].map(|[line, column]| {
                    let part = ScreenPoint { line: at.line + line, column: at.column + column };
                    match view.ground(part) {
                        None => 0,
                        Some(ground) if holds(scene.runway.unwrap().outline, ground) => 3,
                        Some(ground) if holds(scene.terrain.outline, ground) => 2,
                        Some(_) => 1,
                    }
                });
            if parts.iter().any(|&part| part != parts[0]) {
                continue;
            }
            counts[parts[0]] += 1;
            let tones = [SKY..=SKY, GROUND..=GROUND, 112..=143, RUNWAY..=RUNWAY];
            assert!(tones[parts[0]].contains(&grey), "pixel {number} of kind {} shows {grey}", parts[0]);
        }
        assert!(counts.iter().all(|&count| count > 150), "{counts:?}");
    }

    // Without a runway, terrain is there.
    let bare = StudyScene { runway: None, ..scene.clone() };
    assert!(!bare.picture(&view(700.0, DOWN, SMALL)).greys.contains(&RUNWAY));
}

#[test]
fn pixels_at_edges_mix_tones_by_area() {
    // One shade of terrain, so that the mixture is known.
    let mut scene = StudyScene { runway: None, ..scene() };
    scene.terrain.code =
        SubterrainCode::new(CyclicCode::default(), vec![Subterrain { first_line: 0, start: 1 }]).unwrap();
    scene.terrain.shades = Shades::new(2, 130).unwrap();
    let attitude = EyeAttitude { heading_deg: 3.0, roll_deg: 17.0, ..DOWN };
    let view = view(700.0, attitude, SMALL);
    let smooth = scene.picture(&view);
    let sharp = StudyScene { has_smooth_edges: false, ..scene.clone() }.picture(&view);

    let sides = scene.terrain.outline.sides(&view).unwrap();
    let mut mixed = 0;
    for (number, (&smooth, &sharp)) in (0..).zip(smooth.greys.iter().zip(&sharp.greys)) {
        let share = pixel_share(SMALL.pixel(number), &sides);
        let expected = share * 129.5 + (1.0 - share) * f64::from(GROUND);
        assert!(matches!(sharp, SKY | GROUND | 129 | 130), "{sharp}");
        if share > 0.05 && share < 0.95 {
            assert!((f64::from(smooth) - expected).abs() <= 1.0, "{smooth}, not {expected}");
            mixed += 1;
        }
    }
    assert!(mixed > 60, "{mixed}");
}

/// Greatest steps from a pixel to the next along a line, and whole lines of them.
fn steps(picture: &GreyPicture) -> (u8, Vec<u8>) {
    let line = &picture.greys[..picture.width as usize];
    let steps: Vec<u8> = line.windows(2).map(|pair| pair[0].abs_diff(pair[1])).collect();
    (steps.iter().copied().max().unwrap(), steps)
}

#[test]
fn cells_larger_than_pixels_are_blocks_or_blend() {
    let mut scene = StudyScene { runway: None, ..scene() };
    scene.terrain.outline = GroundQuad::rectangle([-500.0, 500.0], [-500.0, 500.0]);
    scene.terrain.shades = Shades::new(256, 128).unwrap();
    // Straight down on cells of 12 pixels.
    let above = EyeAttitude { heading_deg: 0.0, pitch_deg: -90.0, roll_deg: 0.0 };
    let screen = Screen { projection: Projection { pixels: 160, fov_deg: 45.0 }, lines: 96 };
    let view = view(0.5 * screen.projection.distance(), above, screen);

    let blocks = scene.picture(&view);
    assert_eq!(blocks, scene.picture(&view));
    let (most, along) = steps(&blocks);
    // Flat within cells, with jumps of half the range between them.
    let flat = along.iter().filter(|&&step| step == 0).count();
    assert!(most > 100 && flat > 130, "{most} {flat}");

    scene.terrain.is_smooth_nearby = true;
    let smooth = scene.picture(&view);
    assert_eq!(smooth, scene.picture(&view));
    // A pixel is a twelfth of a cell: so much of a jump at most.
    let (most, along) = steps(&smooth);
    assert!(most <= 13, "{most}");
    assert!(along.iter().filter(|&&step| step == 0).count() < 40);
    assert_ne!(smooth, blocks);
}

#[test]
fn a_picture_takes_less_than_the_30_seconds_of_the_study() {
    let screen = Screen { projection: Projection::OF_THE_STUDY, lines: 480 };
    let begun = Instant::now();
    let picture = scene().picture(&view(1000.0, EyeAttitude { pitch_deg: -6.0, ..DOWN }, screen));
    let taken = begun.elapsed();
    assert_eq!(picture.greys.len(), 640 * 480);
    assert!(picture.greys.iter().filter(|&&grey| (112..=143).contains(&grey)).count() > 50_000);
    assert!(taken < Duration::from_secs(30), "{taken:?}");
}
