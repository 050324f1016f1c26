//! Voxels that are pixels.

use super::support::{Area, built, north_up, sheet};
use hedgehop::voxel::PageSource;
use hedgehop_geo::Crs;

const SIZE: (u32, u32) = (700, 530);

/// Numbers that look random.
fn hash(column: u32, row: u32) -> u32 {
    let mixed = (column.wrapping_mul(0x9e37_79b1) ^ row.wrapping_mul(0x85eb_ca77)).wrapping_mul(0xc2b2_ae3d);
    mixed ^ mixed >> 15
}

/// One pixel of each page, the page's apron included, that all of its rasters lack.
fn is_hole(column: u32, row: u32) -> bool {
    column % 256 == 130 && (SIZE.1 - 1 - row) % 256 == 9
}

/// Rasters whose pixels are the voxels; far from the origin, where rounding shows.
fn area(with_holes: bool) -> Area {
    let (local, side) = (Crs::local(), 0.3);
    let geo = north_up(612_345.6, 5_241_000.9, side);
    let heights = sheet(&local, geo, SIZE, |column, row| match (column, row) {
        // The range of heights is that of any.
        (0, 0) => 0.0,
        (1, 0) => 900.0,
        _ if with_holes && is_hole(column, row) => f64::NAN,
        _ => f64::from(hash(column, row) % 8000) * 0.1 + 50.0,
    });
    let colours = sheet(&local, geo, SIZE, |column, row| {
        let [red, green, blue, _] = hash(row, column).to_le_bytes();
        [red, green, blue, if with_holes && is_hole(column, row) { 0 } else { 255 }]
    });
    built(vec![heights], vec![colours], |_| {})
}

#[test]
fn pixels_become_voxels_as_they_stand() {
    let area = area(false);
    assert_eq!([area.grid.nx, area.grid.ny], [SIZE.0, SIZE.1]);
    for (x, y) in area.voxels().filter(|(x, y)| *y != SIZE.1 - 1 || *x > 1) {
        let (column, row) = (x, SIZE.1 - 1 - y);
        let height = f64::from(hash(column, row) % 8000) * 0.1 + 50.0;
        assert!((area.height(x, y).unwrap() - height).abs() <= area.step(), "({x}, {y})");
        assert_eq!(area.colour(x, y)[..], hash(row, column).to_le_bytes()[..3], "({x}, {y})");
        assert_eq!(area.attributes(x, y), Default::default(), "({x}, {y})");
    }
}

#[test]
fn what_is_copied_is_what_merging_and_draping_come_to() {
    let copied = area(false);
    // A hole in each page makes it take the long way.
    let merged = area(true);
    assert_eq!(copied.pages.header().heights, merged.pages.header().heights);
    let mut holes = 0;
    for (x, y) in copied.voxels() {
        if is_hole(x, SIZE.1 - 1 - y) {
            assert_eq!(merged.height(x, y), None, "({x}, {y})");
            holes += 1;
            continue;
        }
        assert_eq!(copied.height(x, y), merged.height(x, y), "({x}, {y})");
        assert_eq!(copied.colour(x, y), merged.colour(x, y), "({x}, {y})");
        assert_eq!(copied.attributes(x, y), merged.attributes(x, y), "({x}, {y})");
    }
    assert_eq!(holes, 9);
}
