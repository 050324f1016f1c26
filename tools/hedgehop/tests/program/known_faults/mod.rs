//! Faults that were found once, replayed with their inputs: each is right now, or refused with a sentence.
//!
//! The inputs lie in a folder beside the project, or where `HEDGEHOP_FAULTS` says; without it the test says that it skips.
//! Each kind of fault has small tests in the tree, too, beside the code that it was in.

mod files;
mod pictures;
mod places;
mod replay;
mod standing;
mod systems;

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use replay::Replay;

/// Name of a folder of inputs, and the commands that went wrong with them.
type Fault = (&'static str, fn(&Replay));

const FAULTS: [Fault; 21] = [
    ("antimeridian_tiles", places::tiles_across_the_180th_meridian),
    ("bgr_colorinterp", files::bands_in_another_order),
    ("byte_order_mark", files::byte_order_marks),
    ("epsg_null_shift", systems::codes_with_shifts),
    ("esri_prj_datum", systems::datums_by_name),
    ("forged_header", files::absurd_numbers),
    ("grads", systems::grads),
    ("jpeg_truncated", files::half_a_photograph),
    ("las_header_bbox", files::boxes_of_clouds),
    ("man_made_area", standing::squares_of_man_made),
    ("mesh_holes", pictures::walls_parallel_to_the_screen),
    ("misleading_sentences", systems::sentences_that_are_true),
    ("model_slabs_filled", standing::air_between_parts),
    ("msk_sidecar", files::masks_beside_files),
    ("osm_small", standing::small_faults_of_features),
    ("other_bodies", systems::moon_and_mars),
    ("png_trns_damaged", files::chunks_that_are_damaged),
    ("premultiplied_alpha", files::associated_alpha),
    ("resume_keeps_nothing", places::pages_of_interrupted_builds),
    ("vertical_system", systems::heights_and_depths),
    ("worldfile_without_bound", files::pixels_without_bound),
];

/// Folders whose fault is one of design, which no single command tells right from wrong.
const NOT_REPLAYED: [&str; 1] = ["roofs_become_blobs"];

fn folder() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/faults");
    let folder = std::env::var_os("HEDGEHOP_FAULTS").map_or_else(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    // Written past the test harness, which swallows what passing tests print.
    let told = format!("skipped: no known faults at {} (set HEDGEHOP_FAULTS)\n", folder.display());
    std::io::stderr().write_all(told.as_bytes()).expect("a line");
    None
}

#[test]
fn known_faults_are_right_or_refused() {
    let Some(folder) = folder() else { return };
    let mut failed = Vec::new();
    for (name, replay) in FAULTS {
        let inputs = Replay::of(&folder.join(name));
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| replay(&inputs)));
        if outcome.is_err() {
            failed.push(name);
        }
    }
    assert!(failed.is_empty(), "{} of {} fail: {failed:?}", failed.len(), FAULTS.len());
}

#[test]
fn all_folders_of_faults_are_replayed() {
    let Some(folder) = folder() else { return };
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    let found: BTreeSet<String> = entries
        .filter(|entry| entry.path().join("README.md").is_file())
        .map(|entry| entry.file_name().into_string().expect("a name in Unicode"))
        .collect();
    let known = FAULTS.iter().map(|(name, _)| *name).chain(NOT_REPLAYED);
    assert_eq!(found, known.map(str::to_owned).collect());
}
