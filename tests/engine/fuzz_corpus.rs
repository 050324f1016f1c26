//! The corpus of the fuzz target (`fuzz/`), replayed, and some random damage with right checksums beside: `HEDGEHOP_COPIES` damaged copies of each file, from `HEDGEHOP_SEED`.

use std::fs;
use std::path::{Path, PathBuf};

use hedgehop::voxel::MemPages;
use hedgehop_testing::Random;

/// Damaged copies of each file of the corpus, unless told otherwise.
const COPIES: u64 = 40;

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |value| value.parse().unwrap())
}

fn corpus() -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/database");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

#[test]
fn the_corpus_is_small_and_does_no_harm() {
    let files = corpus();
    assert!(files.len() >= 3);
    assert!(files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() <= 200_000);
    let mut open = 0;
    for (_, bytes) in files {
        crate::fuzzing::exercise(&bytes);
        let mut sealed = bytes;
        crate::fuzzing::seal(&mut sealed);
        open += usize::from(MemPages::from_bytes("sealed.hop", &sealed).is_ok());
    }
    assert!(open >= 3, "sealed files are met by what lies behind their checksums: {open} open");
}

#[test]
fn damaged_copies_with_right_checksums_do_no_harm() {
    let mut random = Random(number("HEDGEHOP_SEED", 11));
    for (_, bytes) in corpus() {
        for _ in 0..number("HEDGEHOP_COPIES", COPIES) {
            let mut copy = bytes.clone();
            for _ in 0..4 {
                let mut at = |limit: usize| random.between([0.0, limit as f64]) as usize % limit;
                // The head of the file steers most.
                let place = if at(2) == 0 { at(copy.len()) } else { at(256.min(copy.len())) };
                copy[place] = [0, 1, 0x7f, 0x80, 0xff, at(256) as u8][at(6)];
            }
            crate::fuzzing::exercise(&copy);
        }
    }
}
