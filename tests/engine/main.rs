//! Tests of the engine through its public interface, in one program.

// The scenes of `analytic` are seen by both engines.
#![expect(clippy::duplicate_mod)]

#[path = "../fuzzing/mod.rs"]
mod fuzzing;
mod hills;
mod scene;

mod analytic;
mod attitudes;
mod cues;
mod damaged_pages;
mod detail;
mod determinism;
mod displacement;
mod finish;
mod frames;
mod fuzz_corpus;
mod golden;
mod lights;
mod live;
mod lost_files;
mod objects;
mod page_planner;
mod page_sources;
mod planes;
mod positions;
mod refusals;
mod residency;
mod scan;
mod scenes;
mod spans;
mod trails;
mod walls;
mod weather;
