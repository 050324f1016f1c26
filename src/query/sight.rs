//! Whether two points see each other.
//!
//! ```text
//! the ray between them, over bare ground as far as there is some ──▶ where it meets the ground
//! the spans before that ──▶ where half of the light is gone
//! samples along the line ──▶ how near it comes to what lies below it, and how much higher the far point would have to be
//! ```

use std::f64::consts::LN_2;

use glam::DVec3;

use super::slabs::{Slab, Slabs};
use super::{Ground, Sample, profile};
use crate::earth::Curvature;
use crate::error::{Error, Result};
use crate::raymarch::{Contact, GridRay, LevelBands, Marcher, Surface};
use crate::voxel::PageSource;

/// Samples a voxel along a line of sight.
const PER_VOXEL: f64 = 2.0;

/// Pixels so small that what stands is seen by itself at any distance, radians.
const SMALLEST_PIXEL: f64 = f64::MIN_POSITIVE;

/// Share of the light that comes through what is still seen through, as in the ranges of frames.
const HALF: f64 = 0.5;

/// What two points see of each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Horizontal distance between them, metres.
    pub distance: f64,
    /// Where the far one is first hidden, by ground or by what stands on it; `None`: they see each other. Its height is that of the ray.
    pub blocked: Option<Sample>,
    /// Number of the material of what stands there and hides it; `None`: it is ground, or they see each other.
    pub material: Option<u8>,
    /// Where the straight line between them comes nearest to what lies below it (ground, roofs, decks, crowns), or lies deepest in it, ends aside, and how far it is above it
    /// there, metres: 0 in leaves that let light through. `None`: there is no ground between them. Its height is that of what it is nearest to.
    pub nearest: Option<(Sample, f64)>,
    /// How much higher the far point would have to be to be seen, metres ≥ 0, as far as samples twice a voxel tell.
    pub missing: f64,
}

/// Whether `from` sees `to` (metres of the database's system, heights above its datum) over an Earth of that curvature, which light bends after.
///
/// Below bridges and crowns there is air wherever the database has bare ground. What is semitransparent hides the far point once half of the light is gone.
///
/// # Errors
/// [`Error::Configuration`]: points that are the same, or not finite; a page that is damaged.
pub fn sight<S: PageSource>(source: &S, from: DVec3, to: DVec3, curvature: Curvature) -> Result<Sight> {
    let (near, far) = (from.truncate(), to.truncate());
    let distance = near.distance(far);
    if !(from.is_finite() && to.is_finite()) || from == to {
        return Err(Error::Configuration("a line of sight needs two points that are not the same".into()));
    }
    // Where the far point appears over a plane.
    let seen = to.with_z(to.z - curvature.drop_at(distance));
    let (way, length) = (seen - from, (seen - from).length());
    let ray = GridRay::new(&source.header().grid, from, way / length).over(curvature);
    let found = obstacle(source, &ray, length)?;
    let blocked = found.map(|(range, _)| {
        let part = range / length;
        Sample { distance: part * distance, place: near.lerp(far, part), ground: Some(ray.height_at(range)) }
    });
    let (nearest, missing) = clearance(source, &Line { from, to, way, curvature })?;
    let missing = if blocked.is_some() { missing } else { 0.0 };
    Ok(Sight { distance, blocked, material: found.and_then(|(_, material)| material), nearest, missing })
}

/// Range at which the ray is stopped before `length` metres, and the material of the span that does so.
fn obstacle<S: PageSource>(source: &S, ray: &GridRay, length: f64) -> Result<Option<(f64, Option<u8>)>> {
    let grid = source.header().grid;
    let bands = LevelBands::finest_only().with_bare_ground(&grid, SMALLEST_PIXEL, 0.0, 1.0);
    let mut marcher = Marcher::new(source, bands, Surface::Smooth);
    let contact = marcher.first_contact(ray, 0.0)?.filter(|contact| contact.range < length);
    // What stands beyond the far point hides nothing.
    let end = Contact { range: length, level: 0, wanted: 0, face: None, bare: true };
    let mut hits = Vec::new();
    marcher.solids(ray, Some(&contact.unwrap_or(end)), &mut hits)?;
    let mut left = 1.0;
    let solid = hits.iter().find(|hit| {
        left *= 1.0 - hit.opacity;
        left <= HALF
    });
    let solid = solid.map(|hit| (hit.range, Some(hit.span.material)));
    Ok(solid.or(contact.map(|contact| (contact.range, None))))
}

/// A line of sight.
struct Line {
    from: DVec3,
    to: DVec3,
    /// To where the far point appears over a plane.
    way: DVec3,
    curvature: Curvature,
}

/// Where the line comes nearest to what lies below it, and how much its far end lacks.
fn clearance<S: PageSource>(source: &S, line: &Line) -> Result<(Option<(Sample, f64)>, f64)> {
    let spacing = source.header().grid.spacing;
    let ends = [line.from, line.to].map(DVec3::truncate);
    let distance = ends[0].distance(ends[1]);
    let samples = profile(source, Ground::Bare, &ends, spacing / PER_VOXEL)?;
    // Of the ray between two samples, in sides of a voxel.
    let stretch = line.way.length() / spacing / (samples.len() - 1) as f64;
    let mut slabs = Slabs::new(source);
    let mut nearest: Option<(Sample, f64)> = None;
    let mut bars = Vec::new();
    for sample in samples.iter().filter(|sample| sample.distance > 0.0 && sample.distance < distance) {
        let Some(ground) = sample.ground else { continue };
        let part = sample.distance / distance;
        let height = line.from.z + part * line.way.z + line.curvature.drop_at(sample.distance);
        let standing = slabs.over(sample.place)?;
        let below = standing.iter().filter(|slab| slab.low <= height).map(|slab| slab.beneath(height));
        let top = below.fold(ground, f64::max);
        if nearest.is_none_or(|(_, least)| height - top < least) {
            nearest = Some((Sample { ground: Some(top), ..*sample }, height - top));
        }
        let earth = Slab { low: f64::NEG_INFINITY, high: ground, opacity: 1.0 };
        let ahead = std::iter::once(&earth).chain(standing).filter(|slab| slab.high > height);
        bars.extend(ahead.flat_map(|slab| slab.bar(height, part, stretch)));
    }
    Ok((nearest, first_gap(bars)))
}

impl Slab {
    /// What of it counts as lying below a line at `height`, which is not below its lower end: leaves do only as far as the line.
    fn beneath(&self, height: f64) -> f64 {
        if self.opacity < 1.0 { self.high.min(height) } else { self.high }
    }

    /// Rises of the far end between which the line meets it, at `part` of the way, where it is at `height` now, and the optical depth that is there, added and taken away.
    fn bar(&self, height: f64, part: f64, stretch: f64) -> [(f64, f64); 2] {
        // Depth 1 hides, whatever else there is; a greater one would cost the sum its precision.
        let depth = (-(1.0 - self.opacity).ln() * stretch).min(1.0);
        [((self.low - height) / part, depth), ((self.high - height) / part, -depth)]
    }
}

/// The least rise ≥ 0 with an optical depth of less than half of the light; `bars` are changes of depth by rise.
fn first_gap(mut bars: Vec<(f64, f64)>) -> f64 {
    bars.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (mut rise, mut depth): (f64, f64) = (0.0, 0.0);
    for (at, change) in bars {
        if at > rise && depth < LN_2 {
            break;
        }
        rise = rise.max(at);
        depth += change;
    }
    rise
}

#[cfg(test)]
pub(super) mod tests {
    use glam::DVec2;

    use super::*;
    use crate::raymarch::solid_tests::{CODE, pillar, standing};
    use crate::voxel::{Grid, MemPages, Metadata, Span, build_in_memory};

    /// Level ground of 100 m with a ridge of `ridge` m more across x = 500 m, and a slope up to it from 400 m on.
    pub fn area(ridge: f64) -> MemPages {
        let grid = Grid { nx: 500, ny: 50, spacing: 2.0, origin: DVec2::new(1000.0, 2000.0) };
        let rise = |x: f64| ridge * (1.0 - (x - 500.0).abs() / 100.0).max(0.0);
        let heights: Vec<f64> =
            (0..50).flat_map(|_| (0..500).map(move |x| 100.0 + rise(2.0 * f64::from(x) + 1.0))).collect();
        let colours = vec![[90; 3]; heights.len()];
        build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
    }

    pub fn point(x: f64, z: f64) -> DVec3 {
        DVec3::new(1000.0 + x, 2050.0, z)
    }

    #[test]
    fn a_ridge_hides_what_stands_behind_it_until_that_is_high_enough() {
        let area = area(20.0);
        let see =
            |from: f64, to: f64| sight(&area, point(100.0, from), point(900.0, to), Curvature::FLAT).unwrap();
        let clear = see(130.0, 130.0);
        assert_eq!((clear.blocked, clear.missing, clear.distance), (None, 0.0, 800.0));
        let (nearest, above) = clear.nearest.unwrap();
        assert!((above - 10.2).abs() < 0.1 && (nearest.distance - 400.0).abs() < 2.0, "{above} {nearest:?}");
        // From 110 m both ways the ray meets the ridge half way up.
        let hidden = see(110.0, 110.0);
        let contact = hidden.blocked.unwrap();
        assert!(
            (contact.distance - 350.0).abs() < 1.0 && (contact.ground.unwrap() - 110.0).abs() < 1e-6,
            "{contact:?}"
        );
        assert_eq!(hidden.material, None, "ground hides it");
        // The line has to rise by 10 m in the middle.
        assert!((hidden.missing - 20.0).abs() < 0.4, "{hidden:?}");
        assert!(see(110.0, 110.0 + hidden.missing + 0.5).blocked.is_none());
        assert!(see(110.0, 110.0 + hidden.missing - 1.0).blocked.is_some());
    }

    #[test]
    fn the_earth_bends_between_far_points() {
        let grid = Grid { nx: 400, ny: 4, spacing: 100.0, origin: DVec2::ZERO };
        let (heights, colours) = (vec![0.0; 1600], vec![[90; 3]; 1600]);
        let area = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
        let see = |height: f64, curvature| {
            let [from, to] = [1000.0, 39_000.0].map(|x| DVec3::new(x, 200.0, height));
            sight(&area, from, to, curvature).unwrap()
        };
        // Over 38 km two eyes need 24 m each to see each other over the sea: (19 km)² / 2R′.
        let wanted = 19_000.0_f64.powi(2) * Curvature::standard().inverse_diameter;
        assert!((wanted - 24.3).abs() < 0.1, "{wanted}");
        assert!(see(wanted + 0.5, Curvature::standard()).blocked.is_none());
        assert!(see(wanted - 0.5, Curvature::standard()).blocked.is_some());
        assert!(see(0.5, Curvature::FLAT).blocked.is_none());
    }

    /// From x = 100 m to x = 500 m, both ends at a height, over level ground at 0 m with a strip 10 voxels of 2 m wide across x = 300 m.
    fn across(strip: &[Span], height: f64) -> Sight {
        let pages = standing(|x, _| if (145..155).contains(&x) { strip.to_vec() } else { Vec::new() });
        sight(&pages, point(100.0, height), point(500.0, height), Curvature::FLAT).unwrap()
    }

    #[test]
    fn one_sees_under_a_deck_and_over_it_but_not_through_it() {
        let deck = [Span { low: CODE.encode(12.0), ..pillar(13.0) }];
        let under = across(&deck, 5.0);
        assert_eq!((under.blocked, under.missing), (None, 0.0));
        assert!((under.nearest.unwrap().1 - 5.0).abs() < 0.01, "the ground is what lies below: {under:?}");
        let over = across(&deck, 15.0);
        let (place, above) = over.nearest.unwrap();
        assert!(over.blocked.is_none() && (above - 2.0).abs() < 0.01, "{over:?}");
        assert!(
            (place.ground.unwrap() - 13.0).abs() < 0.01 && (290.0..310.0).contains(&(place.place.x - 1000.0))
        );
        let through = across(&deck, 12.5);
        assert_eq!(through.material, Some(pillar(0.0).material));
        assert!((through.blocked.unwrap().distance - 190.0).abs() < 1e-6, "{through:?}");
        assert!((through.nearest.unwrap().1 + 0.5).abs() < 0.01, "{through:?}");
        // The near edge, 190 m on the way, has to be cleared by half a metre; at the far one the line is higher then.
        assert!((through.missing - 0.5 * 400.0 / 190.0).abs() < 0.02, "{through:?}");
        assert!(across(&[pillar(13.0)], 5.0).blocked.is_some(), "a wall is no deck");
    }

    #[test]
    fn a_deck_below_a_higher_one_leaves_a_gap_to_rise_into() {
        let [low, high] = [4.0, 20.0].map(|low| Span { low: CODE.encode(low), ..pillar(low + 2.0) });
        let hidden = across(&[low, high], 5.0);
        // Over the lower deck, 1 m at its near edge, and still under the upper one.
        assert!((hidden.missing - 400.0 / 190.0).abs() < 0.03, "{hidden:?}");
    }

    #[test]
    fn leaves_hide_once_half_of_the_light_is_gone() {
        // A voxel of 2 m lets through the share 14/15 of what comes: ten of them half of it, 0.5016.
        let leaf = |state| [Span { low: CODE.encode(4.0), state, ..pillar(20.0) }];
        let thin = across(&leaf(1), 10.0);
        assert_eq!((thin.blocked, thin.missing), (None, 0.0));
        assert_eq!(thin.nearest.unwrap().1, 0.0, "the line goes through leaves");
        // The share 11/15 is half after two and a quarter voxels: within the third.
        let thick = across(&leaf(4), 10.0);
        assert!((thick.blocked.unwrap().distance - 194.0).abs() < 1e-6, "{thick:?}");
        assert_eq!(thick.material, Some(2));
        assert!(across(&leaf(4), 2.0).blocked.is_none(), "below the crown there is air");
        assert!((20.0..24.0).contains(&(10.0 + 0.5 * thick.missing)), "{thick:?}");
    }
}
