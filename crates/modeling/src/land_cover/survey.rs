//! Numbers that a scheme does not have, counted before pages are made, so that what is told does not depend on which are.

use std::collections::BTreeMap;

use super::raster::SampleClass;
use super::sample::CoverInput;
use crate::raster::Window;
use crate::warp;
use hedgehop::voxel::Grid;
use hedgehop_base::error::Result;

/// Numbers that are told one by one; of more, the number of pixels is told.
const TOLD_APART: usize = 6;
/// Numbers that are counted apart: a file full of noise has 65536.
const MOST: usize = 4096;
/// Places along each side of the area whose pixels bound what is looked at.
const LATTICE: u32 = 32;
/// Pixels that are looked at together.
const TOGETHER: u32 = 1 << 20;

/// Says what is unknown around the area: a sentence for numbers that the scheme does not have, and one if nothing there is known.
pub(crate) fn unknown(source: &CoverInput, grid: &Grid, file: &str, scheme: &str) -> Result<Vec<String>> {
    let Some(window) = window(source, grid) else {
        return Ok(vec![format!(
            "{file} lies outside the area and tells nothing; check its reference system"
        )]);
    };

    let mut unknown: BTreeMap<i32, u64> = BTreeMap::new();
    let (mut others, mut known) = (0_u64, 0_u64);
    let mut classes = Vec::new();
    let rows = (TOGETHER / window.width).max(1);

    for y in (window.y..window.y + window.height).step_by(rows as usize) {
        let height = rows.min(window.y + window.height - y);
        source.samples.read(Window { y, height, ..window }, &mut classes)?;
        for class in &classes {
            match class {
                SampleClass::Known(_) => known += 1,
                SampleClass::Void => {}
                SampleClass::Unknown(number) if unknown.len() < MOST || unknown.contains_key(number) => {
                    *unknown.entry(*number).or_default() += 1;
                }
                SampleClass::Unknown(_) => others += 1,
            }
        }
    }

    let mut notes = Vec::new();
    let mut counts: Vec<(i32, u64)> = unknown.into_iter().collect();
    counts.sort_by_key(|(number, count)| (std::cmp::Reverse(*count), *number));
    others += counts.iter().skip(TOLD_APART).map(|(_, count)| count).sum::<u64>();
    counts.truncate(TOLD_APART);

    if !counts.is_empty() {
        let told: Vec<String> =
            counts.iter().map(|(number, count)| format!("{number} ({count} pixels)")).collect();
        let more = if others > 0 { format!(" and others ({others} pixels)") } else { String::new() };
        notes.push(format!(
            "{file}: around the area it has numbers that are no classes of {scheme}: {}{more}; their ground has no material",
            told.join(", ")
        ));
    }

    if known == 0 {
        notes.push(format!(
            "{file}: no pixel around the area has a class of {scheme}; is it of another scheme?"
        ));
    }

    Ok(notes)
}

/// The part of a raster that lies around the area; `None`: none does.
fn window(source: &CoverInput, grid: &Grid) -> Option<Window> {
    let part = |step: u32, size: u32| f64::from(size) * f64::from(step) / f64::from(LATTICE);
    let places = (0..=LATTICE).flat_map(|j| (0..=LATTICE).map(move |i| (part(i, grid.nx), part(j, grid.ny))));
    let pixels = places.filter_map(|(i, j)| {
        let (x, y) = warp::world(grid, i, j);
        source.placement.pixel_from_world(x, y)
    });
    let joined = |a: [f64; 4], (x, y): (f64, f64)| [a[0].min(x), a[1].min(y), a[2].max(x), a[3].max(y)];
    let all = pixels
        .fold(None, |all: Option<[f64; 4]>, (x, y)| Some(joined(all.unwrap_or([x, y, x, y]), (x, y))))?;
    let size = source.samples.size();
    let range = |low: f64, high: f64, size: u32| {
        let (first, last) = ((low + 0.5).floor().max(0.0), (high + 0.5).floor().min(f64::from(size) - 1.0));
        (first <= last).then_some((first as u32, (last - first) as u32 + 1))
    };
    let ((x, width), (y, height)) = (range(all[0], all[2], size.width)?, range(all[1], all[3], size.height)?);
    Some(Window { x, y, width, height })
}
