//! Files that lie far apart: what is between them costs an entry a page, and everything sees what it sees of a database in full.

use std::path::Path;

use super::disk_space::with_free;
use super::support::{Area, built, north_up, options, sheet, terrain, try_build};
use crate::disk_space::DiskSpace;
use crate::inputs::Inputs;
use crate::opened::Opened;
use crate::reach::Reach;
use crate::{Baking, ExtractPart, MergeInput, Merger, NodataFill, OutputFile, bake_shadows, extract, plan};
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{MemPages, PageId, PageSource, in_full, verify};
use hedgehop_base::progress::Silent;
use hedgehop_geo::Crs;

/// Pixels along the side of a tile, of 1 m, and from one tile to the next both ways.
const SIDE: u32 = 200;
const APART: f64 = 2200.0;

fn tile(x: f64, y: f64) -> Opened<f64> {
    terrain(&Crs::local(), north_up(x, y + f64::from(SIDE), 1.0), (SIDE, SIDE), |x, y| {
        90.0 + 12.0 * (x * 0.05).sin() + 9.0 * (y * 0.07).cos() + 0.002 * (x + y)
    })
}

fn tiles() -> Vec<Opened<f64>> {
    vec![tile(0.0, 0.0), tile(APART, APART)]
}

fn apart() -> Area {
    built(tiles(), Vec::new(), |_| {})
}

/// Bytes of what `write` makes at a path.
fn written<T>(write: impl FnOnce(&Path) -> T) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.hop");
    write(&path);
    std::fs::read(&path).unwrap()
}

#[test]
fn what_lies_between_files_has_no_bytes() {
    let area = apart();
    assert_eq!((area.grid.nx, area.grid.ny), (2400, 2400));
    let directory = area.pages.directory();
    let with_bytes = |level| {
        let own = directory.present().filter(|(id, _)| id.level == level);
        own.map(|(_, entry)| u32::from(entry.length > 0))
            .fold([0, 0], |[all, some], own| [all + 1, some + own])
    };

    // The far tile lies across two columns and two rows of pages of level 1, and in one of level 4.
    assert_eq!([0, 1, 2, 3].map(with_bytes), [[100, 5], [9, 2], [1, 1], [1, 1]]);
    assert!(area.bytes.len() < 4_500_000, "{}", area.bytes.len());
    let report = verify(&area.pages, &Silent).unwrap();
    assert_eq!((report.problems, report.pages, report.empty), (Vec::new(), 111, 102));

    // Heights, and what the metadata say.
    let (far, end) = (APART as u32, APART as u32 + SIDE);
    for (x, y) in area.voxels().step_by(37) {
        let (east, north) = area.centre(x, y);
        let has_surface = x < SIDE && y < SIDE || (far..end).contains(&x) && (far..end).contains(&y);
        let wanted = 90.0 + 12.0 * (east * 0.05).sin() + 9.0 * (north * 0.07).cos() + 0.002 * (east + north);
        match area.height(x, y) {
            Some(height) => assert!(has_surface && (height - wanted).abs() <= area.step(), "{x} {y}"),
            None => assert!(!has_surface, "{x} {y}"),
        }
    }

    let metadata = &area.pages.header().metadata;
    let covered = 2.0 * f64::from(SIDE).powi(2) / 2400.0_f64.powi(2);
    assert_eq!((metadata.void_share, metadata.filled_share), (0.0, None));
    assert!((metadata.empty_share - (1.0 - covered)).abs() < 1e-12);
    assert!(
        metadata.notes.iter().any(|note| note.contains("no surface, and takes 44 bytes")),
        "{metadata:?}"
    );
}

#[test]
fn pages_that_nothing_reaches_are_what_they_would_be_made() {
    // What shows nothing, but reaches all pages: none of them is passed over.
    let clear = || sheet(&Crs::local(), north_up(-10.0, 2410.0, 100.0), (25, 25), |_, _| [9, 9, 9, 0]);
    for fill in [NodataFill::Small, NodataFill::Interpolate, NodataFill::Value(70.0)] {
        let quick = built(tiles(), Vec::new(), |options| options.nodata_fill = fill);
        let made = built(tiles(), vec![clear()], |options| options.nodata_fill = fill);
        assert_eq!(quick.grid, made.grid);
        let entries = |area: &Area| {
            let directory = area.pages.directory();
            directory.present().map(|(id, entry)| (id, entry.length, entry.hash)).collect::<Vec<_>>()
        };
        assert!(entries(&quick) == entries(&made), "{fill:?}");
        let shares = |area: &Area| {
            let metadata = &area.pages.header().metadata;
            (metadata.void_share, metadata.empty_share, metadata.filled_share)
        };
        assert_eq!(shares(&quick), shares(&made));
    }

    // Voxels that differ need bytes: imagery over half of the gap.
    let image = sheet(&Crs::local(), north_up(700.0, 1500.0, 10.0), (70, 70), |_, _| [80, 90, 60, 255]);
    let seen = built(tiles(), vec![image], |_| {});
    let stored = seen.pages.directory().present().filter(|(_, entry)| entry.length > 0).count();
    assert!(stored > 9 && verify(&seen.pages, &Silent).unwrap().is_sound(), "{stored}");
}

#[test]
fn parts_wholes_and_shadows_are_those_of_a_database_in_full() {
    let area = apart();
    let full = in_full(&area.pages).unwrap();
    let both = [&area.pages, &full];

    // In the gap, across the edge of a tile, and beyond both.
    for bounds in [[600.0, 600.0, 1000.0, 1000.0], [100.0, 100.0, 900.0, 300.0], [1700.0, 1700.0, 9e9, 9e9]] {
        let [part, wanted] = both.map(|source: &MemPages| {
            let pages: Vec<PageId> = source.directory().present().map(|(id, _)| id).collect();
            let part = ExtractPart::around(&area.grid, &pages, bounds).unwrap();
            written(|path| {
                extract(source, &pages, &part, OutputFile { path, overwrite: true }, 2, &Silent).unwrap()
            })
        });
        assert!(part == wanted, "{bounds:?}");
        let part = MemPages::from_bytes("part.hop", &part).unwrap();
        assert!(verify(&part, &Silent).unwrap().is_sound());
        let is_bare = bounds[0] == 600.0;
        assert_eq!(part.header().metadata.empty_share == 1.0, is_bare, "{bounds:?}");
    }

    let other = built(vec![tile(900.0, 900.0)], Vec::new(), |_| {});
    for reversed in [false, true] {
        let [whole, wanted] = both.map(|source: &MemPages| {
            let mut databases =
                [MergeInput { source, name: "a.hop" }, MergeInput { source: &other.pages, name: "b.hop" }];
            if reversed {
                databases.reverse();
            }
            let merger = Merger::new(&databases, 0.0).unwrap();
            written(|path| merger.write(OutputFile { path, overwrite: true }, 2, &Silent).unwrap())
        });
        assert!(whole == wanted, "{reversed}");
        let whole = MemPages::from_bytes("whole.hop", &whole).unwrap();
        assert!(verify(&whole, &Silent).unwrap().empty > 70);
    }

    let sun = Sun { azimuth: 140.0, elevation: 12.0 };
    let [baked, wanted] = both.map(|source: &MemPages| {
        written(|output| {
            let baking = Baking {
                source,
                directory: source.directory(),
                sun,
                output,
                overwrite: true,
                steps: false,
                threads: 2,
            };
            bake_shadows(&baking, &Silent).unwrap()
        })
    });

    let [baked, wanted] = [baked, wanted].map(|bytes| MemPages::from_bytes("baked.hop", &bytes).unwrap());
    assert_eq!(baked.header().content_hash, wanted.header().content_hash);
    assert!(baked.bytes().len() == wanted.bytes().len() && verify(&baked, &Silent).unwrap().is_sound());
}

#[test]
fn a_small_disk_has_room_for_files_far_apart() {
    let folder = tempfile::tempdir().unwrap();
    let options = options(folder.path());
    let inputs = Inputs { elevation: tiles(), ..Inputs::default() };
    let plan = plan::plan(&inputs, &options).unwrap();
    let reach = Reach::of(&inputs, &plan, &options).unwrap();
    let room = DiskSpace { plan: &plan, output: &options.output, builds: false, reach: &reach };
    let area = apart();
    let bytes = area.bytes.len() as u64;
    let [least, most] = [room.least_needed(), room.most_needed()];
    assert!(least <= bytes && bytes <= room.most_bytes() && most < 4 * bytes, "{least} {bytes} {most}");
    // A third of the pages that have bytes lies on a tile for certain, at the least.
    assert!(least > bytes / 5, "{least} of {bytes}");
    with_free(most, || try_build(tiles(), Vec::new(), |_| {}).map(drop)).unwrap();
    let refused = with_free(least - 1, || try_build(tiles(), Vec::new(), |_| {}).map(drop)).unwrap_err();
    assert!(refused.to_string().contains("at least"), "{refused}");
}
