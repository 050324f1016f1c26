//! Positions on the map that pixels tell, against the database's own heights, and from view to view.

use glam::{DVec2, DVec3};

use crate::scene::{ORIGIN, Terrain, View, clear_air};
use hedgehop::earth::Curvature;
use hedgehop::frame::{Frame, MapPositions, PositionInputs, map_offset, map_positions};
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::{MemPages, PageSource};
use hedgehop_testing::Random;

const SIZE: [u32; 2] = [96, 64];

/// Slopes of a valley, so smooth that what is stored coarsely tells of the same ground.
fn valley() -> MemPages {
    ground(0.0)
}

/// The valley with ridges of some height, metres.
fn ground(ridges: f64) -> MemPages {
    let height = |at: DVec2| {
        let ridge = ridges * (at.x / 60.0 + (at.y / 110.0).sin()).sin();
        300.0 + 80.0 * (at.x / 700.0).sin() * (at.y / 900.0).cos() + ridge
    };
    Terrain::new([600, 600], 10.0, height, |_| [120, 130, 90]).in_memory()
}

/// A frame with the positions of its pixels.
struct Seen {
    frame: Frame,
    positions: MapPositions,
}

fn seen(area: &MemPages, camera: &Camera, options: &RenderOptions) -> Seen {
    let farm = Farm::new(2).unwrap();
    let frame = Renderer::new(area, options).frame(camera, &farm).unwrap().frame;
    let offset = map_offset(&area.header().grid);
    let inputs = PositionInputs { offset, curvature: options.curvature, bodies: &[], antialias: 1 };
    let positions = map_positions(&frame, &inputs, &farm);
    Seen { frame, positions }
}

impl Seen {
    /// Point of the map that a pixel shows, if it shows one.
    fn point(&self, pixel: usize) -> Option<DVec3> {
        let metres = self.positions.points[pixel].map(f64::from);
        metres[0].is_finite().then(|| DVec3::from_array(metres) + self.positions.offset)
    }
}

/// Options of both engines over a curved Earth, which look at the finest level, as a question about a height does.
fn both() -> [RenderOptions; 2] {
    let options = RenderOptions { curvature: Curvature::standard(), detail: 50.0, ..clear_air() };
    [Engine::Planes, Engine::Reference].map(|engine| RenderOptions { engine, ..options })
}

#[test]
fn pixels_of_any_view_meet_the_surface() {
    let (area, mut random) = (ground(12.0), Random(5));
    let mut within = |low: f64, high: f64| random.between([low, high]);
    let views: Vec<_> = (0..20)
        .map(|_| View {
            eye: DVec3::new(within(1500.0, 4500.0), within(1500.0, 4500.0), within(450.0, 900.0)),
            ypr: [within(0.0, 360.0), within(-80.0, 0.0), within(-60.0, 60.0)],
            hfov: within(30.0, 90.0),
            size: SIZE,
        })
        .collect();

    for options in both() {
        let (mut met, mut close) = (0, 0);
        for view in &views {
            let seen = seen(&area, &view.camera(), &options);
            for (pixel, range) in seen.frame.range.iter().enumerate() {
                let Some(point) = seen.point(pixel) else { continue };
                let Some(ground) = ground_height(&area, point.truncate()).unwrap() else { continue };
                met += 1;
                close += usize::from((point.z - ground).abs() < 1e-3 + 1e-4 * f64::from(*range));
            }
        }
        assert!(met > 20 * 96 * 64 / 2, "{met} pixels");
        assert!(close == met, "{:?}: {close} of {met} pixels", options.engine);
    }
}

/// Positions that one view tells are where another sees them: over a curved Earth both see them lowered, each otherwise.
#[test]
fn points_of_one_view_are_found_in_another() {
    let area = valley();
    let view =
        View { eye: DVec3::new(2200.0, 1500.0, 700.0), ypr: [10.0, -20.0, 5.0], hfov: 60.0, size: SIZE };
    let other = View { eye: DVec3::new(2900.0, 1300.0, 800.0), ypr: [-8.0, -18.0, -12.0], ..view };
    let cameras = [view.camera(), other.camera()];
    let place = |camera: &Camera, point: DVec3| {
        let away = (point - camera.pose.eye).truncate().length();
        camera.screen_from_world(point - DVec3::Z * Curvature::standard().drop_at(away))
    };

    for options in both() {
        let [one, two] = cameras.each_ref().map(|camera| seen(&area, camera, &options));
        let width = SIZE[0] as usize;
        let (mut found, mut close) = (0, 0);
        for pixel in 0..one.frame.range.len() {
            let Some(point) = one.point(pixel) else { continue };
            // The four pixels of the other view around it.
            let Some(at) = place(&cameras[1], point).map(|at| at - 0.5) else { continue };
            let inside = at.cmpge(DVec2::ZERO).all() && at.x < 94.0 && at.y < 62.0;
            if !inside {
                continue;
            }
            let (low, share) = (at.floor(), at - at.floor());
            let corner = |right: usize, down: usize| {
                two.point((low.y as usize + down) * width + low.x as usize + right)
            };
            let (Some(a), Some(b), Some(c), Some(d)) =
                (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1))
            else {
                continue;
            };
            let between = a.lerp(b, share.x).lerp(c.lerp(d, share.x), share.y);
            // Ground before it hides it from the other eye.
            if between.distance(point) > 0.01 * f64::from(one.frame.range[pixel]) {
                continue;
            }

            let own = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
            let back = place(&cameras[0], between).unwrap();
            found += 1;
            close += usize::from(back.distance(own) < 0.1);
        }
        assert!(found > 96 * 64 / 4, "{found} pixels");
        // Across an outline nothing lies between the pixels.
        assert!(close * 100 >= found * 99, "{:?}: {close} of {found} pixels", options.engine);
    }
    assert!(cameras[0].pose.eye.x > ORIGIN.x, "far from the origin, as georeferenced areas are");
}
