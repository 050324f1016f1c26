//! Voxels whose source has no data.

use super::support::{Area, built, north_up, terrain};
use crate::NodataFill;
use hedgehop::voxel::{Attributes, PageSource};
use hedgehop_geo::Crs;

fn plane(x: f64, y: f64) -> f64 {
    500.0 + 0.2 * x - 0.1 * y
}

/// A plane of 400 × 400 pixels with a round hole.
fn holed(radius: f64, fill: NodataFill) -> Area {
    let hole = move |x: f64, y: f64| (x - 200.5).hypot(y - 200.5) < radius;
    let sample = move |x: f64, y: f64| if hole(x, y) { f64::NAN } else { plane(x, y) };
    let raster = terrain(&Crs::local(), north_up(0.0, 400.0, 1.0), (400, 400), sample);
    built(vec![raster], vec![], |options| options.nodata_fill = fill)
}

fn holes(area: &Area) -> usize {
    area.voxels().filter(|&(x, y)| area.attributes(x, y).flags & Attributes::VOID != 0).count()
}

#[test]
fn voids_stay_empty() {
    let area = holed(30.0, NodataFill::None);
    assert_eq!(area.height(200, 199), None);
    let count = area.voxels().filter(|&(x, y)| area.height(x, y).is_none()).count();
    assert_eq!(holes(&area), count);
    let metadata = &area.pages.header().metadata;
    assert_eq!(metadata.void_share, count as f64 / 160_000.0);
    assert_eq!(metadata.empty_share, metadata.void_share);
}

#[test]
fn voids_take_a_value() {
    let area = holed(30.0, NodataFill::Value(-7.5));
    assert!((area.height(200, 199).unwrap() + 7.5).abs() <= area.step());
    assert_eq!(holes(&area), holes(&holed(30.0, NodataFill::None)));
    let metadata = &area.pages.header().metadata;
    assert!(metadata.void_share > 0.0 && metadata.empty_share == 0.0);
}

#[test]
fn narrow_voids_follow_the_plane() {
    let area = holed(30.0, NodataFill::Interpolate);
    // Opposite directions balance, so that on a plane the middle of a round hole is right, and its rim nearly.
    let (x, y) = area.centre(200, 200);
    assert!((area.height(200, 200).unwrap() - plane(x, y)).abs() < 0.1);
    assert!(area.worst(plane) < 2.0, "{}", area.worst(plane));
    assert!(holes(&area) > 2000);
}

#[test]
fn wide_voids_follow_the_broad_shape() {
    // The middle is out of reach of every valid voxel.
    let area = holed(110.0, NodataFill::Interpolate);
    assert!(area.worst(plane) < 12.0, "{}", area.worst(plane));
    let row: Vec<f64> = (0..400).map(|x| area.height(x, 200).unwrap()).collect();
    let step = row.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(step < 2.0, "a step of {step} m within the fill");
}

#[test]
fn nothing_but_voids_is_refused_unless_a_value_fills_them() {
    let nothing = || vec![terrain(&Crs::local(), north_up(0.0, 9.0, 1.0), (9, 9), |_, _| f64::NAN)];
    for fill in [NodataFill::None, NodataFill::Interpolate] {
        let error =
            super::support::try_build(nothing(), vec![], |options| options.nodata_fill = fill).err().unwrap();
        assert!(error.to_string().contains("--nodata"), "{error}");
    }
    let area = built(nothing(), vec![], |options| options.nodata_fill = NodataFill::Value(3.0));
    assert!((area.height(4, 4).unwrap() - 3.0).abs() <= area.step());
}

/// A plane with voids about points, each of a half side; where they are, and whether they are small and enclosed.
#[test]
fn small_voids_are_filled_and_others_stay() {
    /// Middle, half side, whether it is filled.
    const VOIDS: [((f64, f64), f64, bool); 6] = [
        // Across the corner of four pages; as large as may be, and larger by two.
        ((256.0, 256.0), 9.0, true),
        ((100.0, 100.0), 32.0, true),
        ((400.0, 100.0), 33.0, false),
        ((100.5, 400.5), 0.6, true),
        // At the edge, and beside what no raster reaches.
        ((1.0, 300.0), 5.0, false),
        ((500.0, 400.0), 5.0, false),
    ];

    let hole =
        |x: f64, y: f64| VOIDS.iter().any(|((u, v), half, _)| (x - u).abs() < *half && (y - v).abs() < *half);
    let sample = move |x: f64, y: f64| if hole(x, y) { f64::NAN } else { plane(x, y) };

    let build = |fill: NodataFill| {
        let holed = terrain(&Crs::local(), north_up(0.0, 600.0, 1.0), (500, 600), sample);
        // It makes the area wider, and leaves a strip between.
        let apart = terrain(&Crs::local(), north_up(520.0, 600.0, 1.0), (80, 600), plane);
        built(vec![holed, apart], vec![], |options| options.nodata_fill = fill)
    };
    let (area, kept) = (build(NodataFill::Small), build(NodataFill::None));

    for ((x, y), half, is_filled) in VOIDS {
        let voxel = ((x - half.min(0.5)) as u32, (y - half.min(0.5)) as u32);
        assert_eq!(kept.height(voxel.0, voxel.1), None, "{x}, {y}");
        assert_ne!(area.attributes(voxel.0, voxel.1).flags & Attributes::VOID, 0);
        match is_filled {
            true => assert!((area.height(voxel.0, voxel.1).unwrap() - plane(x, y)).abs() < 2.0),
            false => assert_eq!(area.height(voxel.0, voxel.1), None, "{x}, {y}"),
        }
    }

    assert_eq!(holes(&area), holes(&kept));
    let metadata = &area.pages.header().metadata;
    let filled = metadata.filled_share.unwrap() * 360_000.0;
    assert!((filled - (18.0 * 18.0 + 64.0 * 64.0 + 1.0)).abs() < 0.5, "{filled}");
    assert!(
        metadata.notes.iter().any(|note| note.contains("--nodata-fill none keeps")),
        "{:?}",
        metadata.notes
    );
    assert!(
        metadata.notes.iter().any(|note| note.contains("--nodata-fill interp fills")),
        "{:?}",
        metadata.notes
    );
}
