//! Colours of sides by height: a door in a wall, a plinth, windows.
//!
//! ```text
//! heights at which steep faces begin or end → bands
//! of each band and direction: the outermost faces first, until all of the wall's width is covered; the mean of these
//! a band that is low, or looks like the one below, goes to that
//! ```
//! A solid of several bands is several solids, one on the other.

use glam::Vec3;

use super::rays::Steep;
use crate::features::Solid;
use hedgehop_base::colour::srgb8_from_linear;

/// Least height of a band, in voxels.
const LOWEST: f64 = 0.2;
/// Least difference of the colours of two bands, codes.
const APART: u8 = 12;

/// A solid with the colours that `faces` beside it have.
pub(super) fn banded(solid: Solid, faces: &[Steep], spacing: f64) -> Vec<Solid> {
    if solid.parallel || solid.strip || faces.is_empty() {
        return vec![solid];
    }

    let [east, north] = solid.slope;
    let low = solid.low_m.unwrap_or(f64::NEG_INFINITY);

    // Above that the upper end would cut a band off.
    let high = solid.high_m - 0.5 * spacing * (east.abs() + north.abs());
    let mut ends: Vec<f64> = faces.iter().flat_map(|face| [face.low, face.high]).collect();
    ends.retain(|end| *end > low && *end < high - LOWEST * spacing);
    ends.sort_by(f64::total_cmp);
    ends.push(solid.high_m);
    let mut bands: Vec<(f64, [u8; 3])> = Vec::new();
    let mut from = faces.iter().map(|face| face.low).fold(f64::INFINITY, f64::min).max(low);

    for end in ends {
        if end - from < LOWEST * spacing {
            continue;
        }
        let colour = colour_between(faces, [from, end]);
        match (bands.last_mut(), colour) {
            (Some((top, known)), Some(colour)) if !is_apart(*known, colour) => *top = end,
            (Some((top, _)), None) => *top = end,
            (_, Some(colour)) => bands.push((end, colour)),
            (None, None) => {}
        }
        from = end;
    }

    let Some((_, upper)) = bands.pop() else { return vec![solid] };
    let mut parts = Vec::with_capacity(bands.len() + 1);
    let mut low_m = solid.low_m;
    for (top, side) in bands {
        parts.push(Solid { low_m, high_m: top, slope: [0.0; 2], top: side, side, ..solid });
        low_m = Some(top);
    }

    parts.push(Solid { low_m, side: upper, ..solid });
    parts
}

fn is_apart(one: [u8; 3], other: [u8; 3]) -> bool {
    one.iter().zip(other).any(|(one, other)| one.abs_diff(other) >= APART)
}

/// Returns the colour seen from beside between two heights, sRGB; `None` where there is no face.
fn colour_between(faces: &[Steep], [low, high]: [f64; 2]) -> Option<[u8; 3]> {
    let middle = low.midpoint(high);
    let mut seen: Vec<&Steep> =
        faces.iter().filter(|face| face.low <= middle && face.high >= middle).collect();
    let outward = |face: &Steep| face.distance / face.area;
    seen.sort_by(|a, b| a.bin.cmp(&b.bin).then(outward(b).total_cmp(&outward(a))));
    let (mut sum, mut widths) = (Vec3::ZERO, 0.0);
    for wall in seen.chunk_by(|a, b| a.bin == b.bin) {
        let mut hidden = wall.iter().map(|face| face.length()).fold(0.0, f64::max);
        for face in wall {
            let width = face.length().min(hidden);
            hidden -= width;
            widths += width;
            sum += face.colour * (width / face.area) as f32;
        }
    }
    (widths > 0.0).then(|| (sum / widths as f32).to_array().map(srgb8_from_linear))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::features::Wall;

    fn solid() -> Solid {
        Solid {
            low_m: None,
            high_m: 6.0,
            slope: [0.5, 0.0],
            wall: Wall::Whole,
            top: [9; 3],
            side: [9; 3],
            opacity: 1.0,
            material: 3,
            parallel: false,
            strip: false,
            joined: [false; 2],
            facade: None,
        }
    }

    /// A face that looks east, `width` metres wide.
    fn face(colour: Vec3, width: f64, [low, high]: [f64; 2], out: f64) -> Steep {
        let area = width * (high - low);
        Steep {
            normal: DVec2::X * area,
            area,
            distance: out * area,
            low,
            high,
            colour: colour * area as f32,
            is_sheet: false,
            bin: 0,
            material: 0,
        }
    }

    #[test]
    fn doors_end_where_they_end() {
        let (red, grey) = (Vec3::new(0.3, 0.05, 0.05), Vec3::splat(0.4));
        let [wall, door] = [red, grey].map(|colour| colour.to_array().map(srgb8_from_linear));
        // The door lies before the wall, and is as wide as that.
        let parts =
            banded(solid(), &[face(red, 1.0, [0.0, 6.0], 0.3), face(grey, 1.0, [0.0, 2.5], 0.35)], 1.0);
        let found: Vec<_> =
            parts.iter().map(|part| (part.low_m, part.high_m, part.side, part.slope)).collect();
        assert_eq!(found, [(None, 2.5, door, [0.0; 2]), (Some(2.5), 6.0, wall, [0.5, 0.0])]);
        assert_eq!((parts[0].top, parts[1].top), (door, [9; 3]));
        // Half as wide, it is half of what is seen; behind the wall it is nothing.
        let half =
            banded(solid(), &[face(red, 1.0, [0.0, 6.0], 0.3), face(grey, 0.5, [0.0, 2.5], 0.35)], 1.0);
        let mean = (0.5 * (red + grey)).to_array().map(srgb8_from_linear);
        assert_eq!((half.len(), half[0].side, half[1].side), (2, mean, wall));
        let behind =
            banded(solid(), &[face(red, 1.0, [0.0, 6.0], 0.3), face(grey, 1.0, [0.0, 2.5], 0.2)], 1.0);
        assert_eq!((behind.len(), behind[0].side), (1, wall));
    }

    #[test]
    fn what_is_low_or_alike_makes_no_bands() {
        let red = Vec3::new(0.3, 0.05, 0.05);
        let wall = face(red, 1.0, [0.0, 6.0], 0.3);
        for other in [
            face(red * 1.02, 1.0, [0.0, 2.5], 0.35),
            face(Vec3::ONE, 1.0, [0.0, 0.1], 0.35),
            // Next to the upper end, which rises by a quarter of a metre to either side.
            face(Vec3::ONE, 1.0, [5.7, 6.0], 0.35),
        ] {
            assert_eq!(banded(solid(), &[wall, other], 1.0).len(), 1, "{other:?}");
        }
        assert_eq!(banded(solid(), &[], 1.0), [solid()]);
        let sheet = Solid { parallel: true, low_m: Some(1.0), ..solid() };
        assert_eq!(banded(sheet, &[wall, face(Vec3::ONE, 1.0, [0.0, 2.5], 0.35)], 1.0), [sheet]);
    }
}
