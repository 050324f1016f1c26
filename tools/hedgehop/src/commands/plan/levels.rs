//! Needs of a flight, level by level.

use serde::Serialize;

use crate::area;
use hedgehop::memory::PageFile;
use hedgehop::render::NumberedCamera;
use hedgehop::voxel::{Grid, PageId, PageSource};

/// Needs of the flight on one level.
#[derive(Debug, Serialize)]
pub struct LevelNeeds {
    /// Units of a voxel's side.
    pub level: u32,
    /// Pages that some frame needs.
    pub pages: u64,
    /// Bytes of these.
    pub bytes: u64,
    /// Bytes of all pages of the level.
    pub bytes_stored: u64,
    /// Ground under these pages, km².
    pub area_km2: f64,
    /// Farthest of it from the path, metres.
    pub reach_m: f64,
}

/// Returns what the pages that are needed come to on each level.
pub fn levels(file: &PageFile, cameras: &[NumberedCamera], needed: &[PageId]) -> Vec<LevelNeeds> {
    let header = file.header();
    let grid = &header.grid;
    let stored = area::shares(header, file.directory());

    let level_needs = |level: u8| {
        let own: Vec<_> = needed.iter().filter(|id| id.level == level).collect();
        let squares = || own.iter().map(|id| grid.page_square(**id));
        let reach = squares().map(|[low, high]| {
            let eyes = cameras.iter().map(|frame| frame.camera.pose.eye.truncate());
            // To the corner that is farthest.
            let farthest = eyes.map(|eye| (eye - low).abs().max((high - eye).abs()).length());
            farthest.fold(f64::INFINITY, f64::min)
        });

        LevelNeeds {
            level: Grid::side_units(level),
            pages: own.len() as u64,
            bytes: own
                .iter()
                .filter_map(|id| file.directory().get(**id))
                .map(|entry| u64::from(entry.length))
                .sum(),
            bytes_stored: stored[usize::from(level)].bytes,
            // The sum of nothing is −0.
            area_km2: squares().map(|[low, high]| (high - low).element_product()).sum::<f64>() / 1e6 + 0.0,
            reach_m: reach.fold(0.0, f64::max),
        }
    };

    (0..header.level_count).map(level_needs).collect()
}
