//! Options of rendering that are refused.

use glam::{DVec2, DVec3};

use hedgehop::Error;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{Grid, Metadata, build_in_memory};

#[test]
fn values_that_make_no_picture_are_refused() {
    let grid = Grid { nx: 2, ny: 2, spacing: 1.0, origin: DVec2::ZERO };
    let source = build_in_memory(grid, &[0.0; 4], &[[0; 3]; 4], None, &Metadata::default()).unwrap();
    let farm = Farm::new(1).unwrap();
    let sound = (DVec3::ONE, 60.0, RenderOptions::default());
    let frame = |(eye, hfov, options): (DVec3, f64, RenderOptions)| {
        let camera = Camera::new(Pose { eye, attitude: Attitude::default(), hfov }, 2, 2);
        render_frame(&source, &camera, &options, &farm)
    };
    assert!(frame(sound).is_ok());
    let beyond = Sun { azimuth: 0.0, elevation: 91.0 };

    for broken in [
        (DVec3::NAN, 60.0, sound.2),
        (DVec3::ONE, 180.0, sound.2),
        (DVec3::ONE, 60.0, RenderOptions { sun: beyond, ..sound.2 }),
        (DVec3::ONE, 60.0, RenderOptions { visibility: f64::NAN, ..sound.2 }),
        (DVec3::ONE, 60.0, RenderOptions { detail: 0.0, ..sound.2 }),
        (DVec3::ONE, 60.0, RenderOptions { far_spans: 0.1, ..sound.2 }),
    ] {
        assert!(matches!(frame(broken), Err(Error::Configuration(_))), "{broken:?}");
    }
}
