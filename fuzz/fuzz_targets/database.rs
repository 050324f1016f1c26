//! Any bytes as a database: `cargo +nightly fuzz run database`. The test `fuzz_corpus` replays the corpus without libFuzzer.
#![no_main]

#[path = "../../tests/fuzzing/mod.rs"]
mod fuzzing;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzzing::exercise(bytes));
