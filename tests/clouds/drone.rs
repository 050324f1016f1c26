//! A cloud of a real surface: what a drone's photographs make.

use glam::DVec3;
use hedgehop::modeling::BuildOptions;
use hedgehop::voxel::PageSource;

use crate::realdata::realdata;
use crate::scene::{CORNER, Mark, database, ground, options, write};

#[test]
fn a_surface_of_points_is_that_of_its_raster() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let raster = data.join("odm_drone_dsm/dsm.tif");
    let mut from_raster = BuildOptions::new(vec![raster], Vec::new(), folder.path().join("raster.hop"));
    from_raster.local = false;
    let surface = database(&from_raster);
    let grid = surface.header().grid;
    // A point in the middle of each voxel, in a system of which nothing but metres is needed.
    let mut marks: Vec<Mark> = Vec::new();
    let corner = grid.origin - CORNER;
    for (x, y) in (0..grid.ny).flat_map(|y| (0..grid.nx).map(move |x| (x, y))) {
        let place = corner + grid.spacing * glam::dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5);
        if let Some(height) = ground(&surface, place) {
            marks.push((
                DVec3::new(grid.spacing * (f64::from(x) + 0.5), grid.spacing * (f64::from(y) + 0.5), height),
                0,
                [0; 3],
            ));
        }
    }
    assert!(marks.len() > 100_000);
    let cloud = folder.path().join("dsm.laz");
    write(&cloud, 0, &marks);
    let mut from_cloud = options(&cloud, folder.path().join("cloud.hop"));
    from_cloud.spacing = Some(grid.spacing);
    let points = database(&from_cloud);
    let (mut off, mut count): (f64, f64) = (0.0, 0.0);
    for (place, ..) in marks.iter().step_by(7) {
        if let Some(height) = ground(&points, place.truncate()) {
            let far = (height - place.z).abs();
            assert!(far < 0.6, "{place}: {height}");
            off += far;
            count += 1.0;
        }
    }
    assert!(count > 0.99 * marks.len() as f64 / 7.0, "{count}");
    let mean = off / count;
    assert!(mean < 0.02, "heights are {mean} m off");
}
