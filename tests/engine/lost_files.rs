//! Databases that change under their readers: an error that names the place, and never a picture.
#![cfg(unix)]

use std::fs::{self, OpenOptions};
use std::path::Path;

use glam::{DVec2, DVec3};

use hedgehop::memory::{PageFile, ResidentPages, guard_mapped_files};
use hedgehop::progress::Silent;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Arrays, Grid, Metadata, PageId, PageSource, write_arrays};

const SIDE: u32 = 600;

fn write_area(path: &Path) {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 2.0, origin: DVec2::ZERO };
    let posts = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<f64> = posts.map(|(x, y)| 50.0 * (x / 90.0).sin() + 30.0 * (y / 70.0).cos()).collect();
    let colours: Vec<_> = (0..heights.len()).map(|post| [(post / 7 % 200) as u8, 110, 80]).collect();
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    write_arrays(path, &arrays, &Metadata::default(), false).unwrap();
}

fn camera() -> Camera {
    let attitude = Attitude { yaw: 40.0, pitch: -5.0, roll: 0.0 };
    Camera::new(Pose { eye: DVec3::new(150.0, 130.0, 140.0), attitude, hfov: 60.0 }, 160, 90)
}

/// What a renderer says that has rendered a frame already when its file is changed.
fn complaints(engine: Engine, change: impl Fn(&Path)) -> [String; 3] {
    guard_mapped_files().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    write_area(&path);
    let pages = ResidentPages::new(PageFile::open(&path).unwrap(), None);
    let renderer = Renderer::new(&pages, &RenderOptions { engine, ..RenderOptions::default() });
    let farm = Farm::new(2).unwrap();
    let before = renderer.picture(&camera(), &farm).unwrap().0;
    assert!(before.rgb.iter().any(|value| *value != before.rgb[0]));
    change(&path);
    let complaint = |outcome: hedgehop::Result<()>| {
        let complaint = outcome.expect_err("a picture of a file that changed").to_string();
        assert!(complaint.starts_with(&path.display().to_string()), "{complaint}");
        complaint
    };

    [
        complaint(renderer.picture(&camera(), &farm).map(drop)),
        complaint(renderer.frame(&camera(), &farm).map(drop)),
        complaint(pages.file().verify(&Silent).map(drop)),
    ]
}

fn resize(path: &Path, length: u64) {
    OpenOptions::new().write(true).open(path).unwrap().set_len(length).unwrap();
}

#[test]
fn a_file_that_is_cut_short_is_an_error_that_stays() {
    for engine in [Engine::Planes, Engine::Reference] {
        for complaint in complaints(engine, |path| resize(path, 5000)) {
            assert!(
                complaint.contains("cannot read byte ") && complaint.contains(" to 5000 bytes"),
                "{complaint}"
            );
            assert!(complaint.contains("leave a database alone"), "{complaint}");
        }
    }
}

/// What `cp other.hop area.hop` does: no byte is missing afterwards, but they are others.
#[test]
fn a_file_that_is_written_anew_is_an_error() {
    for complaint in complaints(Engine::Planes, |path| {
        let bytes = fs::read(path).unwrap();
        resize(path, 0);
        fs::write(path, bytes).unwrap();
    }) {
        assert!(complaint.contains("was changed while it was open"), "{complaint}");
    }
}

#[test]
fn pages_of_a_file_that_failed_are_refused_though_they_were_good() {
    guard_mapped_files().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    write_area(&path);
    let file = PageFile::open(&path).unwrap();
    let (good, other) = (PageId { level: 0, px: 0, py: 0 }, PageId { level: 0, px: 1, py: 1 });
    let codes = |id| file.page(id).map(|view| view.unwrap().heights.to_vec());
    assert!(codes(good).is_ok() && file.intact().is_ok());
    resize(&path, 4096);
    for id in [other, good] {
        let complaint = codes(id).unwrap_err().to_string();
        assert!(complaint.contains("cannot read byte"), "{complaint}");
    }
}
