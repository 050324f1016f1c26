//! Coverage of each pixel by bodies and ground, for mattes.
//!
//! ```text
//! pixels beside which ground becomes sky: 16 rays each → the ground's share
//! pixels with bodies: their shares; what is left, times the ground's share, is ground
//! ```

use super::reference;
use super::renderer::Renderer;
use super::shown_ground::ShownGround;
use crate::frame::{Frame, Matte, MatteCoverage};
use crate::objects::{SQUARE, Square};
use crate::simd::Isa;
use crate::subimage::{Farm, Stage};
use hedgehop_base::error::Result;

/// Least share of the ground behind bodies: less is rounding of theirs.
const LEAST: f32 = 1.0e-4;

/// Rays of a pixel of the skyline, a lattice: in 16 columns and 16 rows, with so many columns from one row to the next.
const RAYS: u32 = 16;
const STEP: u32 = 7;

/// The matte of a frame without bodies: how much of the pixels along the skyline is ground.
pub(super) fn of_ground(renderer: &Renderer<'_>, frame: &Frame, farm: &Farm) -> Result<Matte> {
    let (width, height) = (frame.camera.width as usize, frame.camera.height as usize);
    let is_sky = |column: usize, row: usize| frame.range[row * width + column].is_infinite();
    let is_edge = |column: usize, row: usize| {
        let own = is_sky(column, row);
        column > 0 && is_sky(column - 1, row) != own
            || column + 1 < width && is_sky(column + 1, row) != own
            || row > 0 && is_sky(column, row - 1) != own
            || row + 1 < height && is_sky(column, row + 1) != own
    };

    let displacement = renderer.displacement(&frame.camera)?;
    let mut bands: Vec<Vec<MatteCoverage>> = vec![Vec::new(); height.div_ceil(SQUARE)];
    farm.each(Stage::Image, bands.iter_mut().collect(), |band, covers| {
        let rows = band * SQUARE..((band + 1) * SQUARE).min(height);
        let places = rows.flat_map(|row| (0..width).map(move |column| (column, row)));
        let mut marcher = None;
        for (column, row) in places.filter(|(column, row)| is_edge(*column, *row)) {
            let marcher = marcher.get_or_insert_with(|| {
                reference::marcher(renderer.source, &frame.camera, &renderer.options)
                    .displaced(displacement.as_ref())
            });
            let mut hits = 0;
            for ray in 0..RAYS {
                let [right, down] =
                    [ray, ray * STEP % RAYS].map(|place| (f64::from(place) + 0.5) / f64::from(RAYS));
                if let Some(ray) = frame.camera.ray(column as f64 + right, row as f64 + down) {
                    let ray = marcher.ray(ray.origin, ray.direction);
                    hits += u32::from(marcher.first_contact(&ray, 0.0)?.is_some());
                }
            }

            // What the frame shows there has some share, if all rays pass it by.
            let least = if is_sky(column, row) { 0.0 } else { 0.5 };
            let share = (hits as f32).max(least) / RAYS as f32;
            if share > 0.0 {
                covers.push(MatteCoverage {
                    pixel: (row * width + column) as u32,
                    id: MatteCoverage::GROUND,
                    share,
                });
            }
        }

        Ok(())
    })?;

    renderer.source.intact()?;
    Ok(Matte { covers: bands.concat(), ..Matte::default() })
}

/// Adds what `bodies`, by [`SQUARE`] rows, cover of a frame in which they are not yet to the matte of its ground.
pub(super) fn add_bodies(
    bodies: &[Vec<Square<'_>>],
    isa: Isa,
    frame: &Frame,
    matte: &mut Matte,
    farm: &Farm,
) -> Result<()> {
    let shown = ShownGround { range: &frame.range, width: frame.camera.width as usize };
    let skyline = std::mem::take(&mut matte.covers);
    let at_skyline = |pixel: u32| skyline.binary_search_by_key(&pixel, |cover| cover.pixel);
    let of_ground = |pixel: u32| match at_skyline(pixel) {
        Ok(index) => skyline[index].share,
        Err(_) if shown.range[pixel as usize].is_finite() => 1.0,
        Err(_) => 0.0,
    };
    let mut rows: Vec<Vec<MatteCoverage>> = bodies.iter().map(|_| Vec::new()).collect();
    let tasks = bodies.iter().zip(&mut rows).collect();

    farm.each(Stage::Image, tasks, |_, (squares, covers)| {
        for square in squares {
            let ground = |column, row| shown.ground(column, row);
            square.shares(isa, ground, |row, column, shares| {
                let pixel = (row * shown.width + column) as u32;
                let rest = 1.0 - shares.iter().map(|share| share.share).sum::<f32>();
                let share = rest * of_ground(pixel);
                let first = covers.len();
                covers.extend(shares.iter().map(|share| MatteCoverage {
                    pixel,
                    id: share.id,
                    share: share.share,
                }));
                if share > LEAST {
                    let larger = shares.iter().take_while(|other| other.share >= share).count();
                    covers.insert(first + larger, MatteCoverage { pixel, id: MatteCoverage::GROUND, share });
                }
            });
        }

        // Squares stand side by side; what a pixel has stays in order.
        covers.sort_by_key(|cover| cover.pixel);
        Ok(())
    })?;

    let mut covers = rows.concat();
    let has_body = |pixel: u32| covers.binary_search_by_key(&pixel, |cover| cover.pixel).is_ok();
    let alone: Vec<MatteCoverage> = skyline.iter().copied().filter(|cover| !has_body(cover.pixel)).collect();
    covers.extend(alone);
    covers.sort_by_key(|cover| cover.pixel);
    matte.covers = covers;

    Ok(())
}
