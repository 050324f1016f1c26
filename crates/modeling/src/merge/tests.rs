//! Databases that lie beside and over each other, and those that do not fit.

use super::*;
use hedgehop::voxel::{MemPages, SourceRecord, build_in_memory, verify};
use hedgehop_base::progress::Silent;

fn area(first: [u32; 2], size: [u32; 2], height: impl Fn(f64, f64) -> f64) -> MemPages {
    let at = |axis: usize| first[axis]..first[axis] + size[axis];
    let origin = DVec2::new(f64::from(first[0]), f64::from(first[1])) * 2.0;
    let grid = Grid { nx: size[0], ny: size[1], spacing: 2.0, origin };
    let places = at(1).flat_map(|y| at(0).map(move |x| (x, y)));
    let heights: Vec<f64> = places.map(|(x, y)| height(f64::from(x), f64::from(y))).collect();
    let colours = vec![[first[0] as u8, 60, 90]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

fn slope(x: f64, y: f64) -> f64 {
    100.0 + 0.1 * x + 0.05 * y
}

fn merged(databases: &[&MemPages], feather: f64) -> (MemPages, Merged) {
    let named: Vec<MergeInput<'_>> =
        databases.iter().map(|pages| MergeInput { source: *pages, name: "a.hop" }).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.hop");
    let report = Merger::new(&named, feather)
        .unwrap()
        .write(OutputFile { path: &path, overwrite: false }, 2, &Silent)
        .unwrap();
    let whole = MemPages::from_bytes("whole", &std::fs::read(&path).unwrap()).unwrap();
    let verdict = verify(&whole, &Silent).unwrap();
    assert!(verdict.is_sound(), "{:?}", verdict.problems);
    (whole, report)
}

fn height(whole: &MemPages, x: u32, y: u32) -> f64 {
    let id = PageId { level: 0, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
    let view = whole.page(id).unwrap().unwrap();
    let sample = view.sample(x % PAGE_SIDE, y % PAGE_SIDE);
    whole.header().heights.decode(view.heights[sample]).unwrap_or(f64::NAN)
}

#[test]
fn the_first_is_in_front_and_the_join_is_measured() {
    // They overlap by 30 voxels, and the second is 4 m higher.
    let west = area([0, 0], [300, 280], slope);
    let east = area([270, 17], [300, 280], |x, y| slope(x, y) + 4.0);
    let (whole, report) = merged(&[&west, &east], 0.0);
    assert_eq!((whole.header().grid.nx, whole.header().grid.ny), (570, 297));

    for (x, y, raised) in [(10, 10, 0.0), (299, 100, 0.0), (300, 100, 4.0), (569, 296, 4.0), (280, 290, 4.0)]
    {
        let wanted = slope(f64::from(x), f64::from(y)) + raised;
        assert!((height(&whole, x, y) - wanted).abs() < 0.01, "{x} {y}");
    }

    assert!(height(&whole, 5, 290).is_nan() && height(&whole, 560, 3).is_nan());
    assert!((report.join.largest - 4.1).abs() < 0.02, "{report:?}");

    // Along the column and along the row where the first ends.
    assert_eq!(report.join.pairs, 263 + 30);
    let (other, _) = merged(&[&east, &west], 0.0);
    assert!((height(&other, 280, 100) - slope(280.0, 100.0) - 4.0).abs() < 0.01);

    // Blended over 20 m nothing steps by more than a metre.
    let (soft, report) = merged(&[&west, &east], 20.0);
    assert!(report.join.largest < 0.6, "{report:?}");
    assert!((height(&soft, 280, 100) - slope(280.0, 100.0)).abs() < 0.01);
    let middle = height(&soft, 295, 100) - slope(295.0, 100.0);
    assert!((1.5..2.5).contains(&middle), "{middle}");
}

#[test]
fn what_is_told_of_several_is_told_once() {
    let grid = Grid { nx: 100, ny: 100, spacing: 2.0, origin: DVec2::ZERO };
    let pages = |first: f64, notes: &[&str], file: &str| {
        let source = SourceRecord { file: file.into(), ..SourceRecord::default() };
        let metadata = Metadata {
            notes: notes.iter().map(|note| (*note).to_owned()).collect(),
            sources: vec![source],
            ..Metadata::default()
        };
        let grid = Grid { origin: DVec2::new(first, 0.0), ..grid };
        build_in_memory(grid, &[5.0; 10_000], &[[9; 3]; 10_000], None, &metadata).unwrap()
    };

    let west = pages(0.0, &["no imagery", "datum assumed"], "a.tif");
    let east = pages(200.0, &["no imagery", "west of all", "datum assumed"], "b.tif");
    let (whole, _) = merged(&[&west, &east], 0.0);
    let metadata = &whole.header().metadata;
    let files: Vec<&str> = metadata.sources.iter().map(|source| source.file.as_str()).collect();
    assert_eq!(files, ["a.tif", "b.tif"]);
    assert_eq!(metadata.notes, ["no imagery", "datum assumed", "west of all", "merged from 2 databases"]);

    // Again with a third.
    let far = pages(400.0, &["no imagery"], "c.tif");
    let (whole, _) = merged(&[&whole, &far], 0.0);
    let notes = &whole.header().metadata.notes;
    assert_eq!(*notes, ["no imagery", "datum assumed", "west of all", "merged from 2 databases"]);
}

#[test]
fn what_does_not_fit_is_refused() {
    let one = area([0, 0], [100, 100], slope);
    let far = area([60_000, 60_000], [100, 100], slope);
    let header = one.header();
    let other = |grid: Grid, metadata: Metadata| {
        let count = grid.nx as usize * grid.ny as usize;
        build_in_memory(grid, &vec![1.0; count], &vec![[9; 3]; count], None, &metadata).unwrap()
    };
    let coarse = other(Grid { spacing: 4.0, ..header.grid }, Metadata::default());
    let aside = other(Grid { origin: DVec2::new(0.7, 0.0), ..header.grid }, Metadata::default());
    let datum = other(header.grid, Metadata { vertical_datum: "ellipsoid".into(), ..Metadata::default() });
    for (second, words) in
        [(&coarse, "voxels of 4 m"), (&aside, "aside"), (&datum, "heights are measured"), (&far, "far apart")]
    {
        let pair = [MergeInput { source: &one, name: "a.hop" }, MergeInput { source: second, name: "b.hop" }];
        let told = Merger::new(&pair, 0.0).err().unwrap().to_string();
        assert!(told.contains(words), "{told}");
    }
}
