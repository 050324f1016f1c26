//! Whether two points see each other.
//!
//! ```text
//! the ray between them, over bare ground as far as there is some ──▶ where it meets the ground
//! the spans before that ──▶ where half of the light is gone
//!     neither counts if it only touches the ray: what a point stands on does not hide it
//! ground and spans on the way ──▶ how near it comes to what lies below it, and how much higher the far point would have to be
//! ```

use glam::{DVec2, DVec3};

use super::clearance::{TOUCH, clearance, floor};
use super::slabs::Slabs;
use super::{Ground, Sample};
use hedgehop::earth::Curvature;
use hedgehop::raymarch::{Contact, GridRay, LevelBands, Marcher, Surface};
use hedgehop::voxel::PageSource;
use hedgehop_base::error::{Error, Result};

/// Pixels so small that what stands is seen by itself at any distance, radians.
const SMALLEST_PIXEL: f64 = f64::MIN_POSITIVE;

/// Share of the light that comes through what is still seen through, as in the ranges of frames.
const HALF: f64 = 0.5;

/// Least opacity of what one stands on: crowns of trees and more, as in the highest surface of a database.
const DENSE: f64 = 0.4;

/// Matter that a point may lie within.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Matter {
    /// Below the ground.
    Ground,
    /// Something opaque that stands on the ground or hangs over it: the number of its material.
    Standing(u8),
}

/// Line of sight between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Horizontal distance between them, metres.
    pub distance: f64,
    /// Place where the far one is first hidden, by ground or by what stands on it; `None`: they see each other. Its height is that of the ray.
    pub blocked: Option<Sample>,
    /// Number of the material of what stands there and hides it; `None`: it is ground, or they see each other.
    pub material: Option<u8>,
    /// Place where the straight line between them comes nearest to what lies below it (ground, roofs, decks, crowns), or lies deepest in it, half a voxel at its ends aside, and how
    /// far it is above it there, metres: 0 in leaves that let light through. `None`: there is no ground between them, or one is straight above the other. Its height is that of
    /// what it is nearest to.
    pub nearest: Option<(Sample, f64)>,
    /// Height that the far point lacks to be seen, metres ≥ 0; ∞: no height would do, since something hides it that is above the eye or all around it.
    pub missing: f64,
    /// Matter that the near and the far point lie within; `None`: in the air, in leaves, or on the surface of something.
    pub within: [Option<Matter>; 2],
}

/// Whether `from` sees `to` (metres of the database's system, heights above its datum) over an Earth of that curvature, which light bends after.
///
/// Below bridges and crowns there is air wherever the database has bare ground. What is semitransparent hides the far point once half of the light is gone.
/// Points on the ground, on a roof or below a deck are not hidden by it unless it rises, or hangs, before them.
///
/// # Errors
/// [`Error::Configuration`]: points that are the same, or not finite; a page that is damaged.
pub fn sight(source: &dyn PageSource, from: DVec3, to: DVec3, curvature: Curvature) -> Result<Sight> {
    let (near, far) = (from.truncate(), to.truncate());
    let distance = near.distance(far);
    if !(from.is_finite() && to.is_finite()) || from == to {
        return Err(Error::Configuration("a line of sight needs two points that are not the same".into()));
    }

    // Where the far point appears over a plane.
    let seen = to.with_z(to.z - curvature.drop_at(distance));
    let (way, length) = (seen - from, (seen - from).length());
    let ray = GridRay::new(&source.header().grid, from, way / length).over(curvature);
    let sample = |part: f64, height: f64| Sample {
        distance: part * distance,
        place: near.lerp(far, part),
        ground: Some(height),
    };
    let found = obstacle(source, &ray, length)?;
    let blocked = found.map(|(range, _)| sample(range / length, ray.height_at(range)));

    let (nearest, missing) = if distance > 0.0 {
        let found = clearance(source, &ray, length)?;
        (found.nearest.map(|(part, height, above)| (sample(part, height), above)), found.missing)
    } else if to.z < from.z {
        (None, (floor(source, near, from.z)? - to.z).max(0.0))
    } else {
        (None, f64::INFINITY)
    };

    let missing = if blocked.is_some() { missing } else { 0.0 };
    let within = [surroundings(source, from)?, surroundings(source, to)?];
    Ok(Sight {
        distance,
        blocked,
        material: found.and_then(|(_, material)| material),
        nearest,
        missing,
        within,
    })
}

/// Height of what one stands on at a place (metres of the database's system), metres above the datum: the highest of bare ground and what stands or hangs there, as lines of
/// sight meet it. `None`: there is no ground.
///
/// # Errors
/// A page that is damaged.
pub fn footing(source: &dyn PageSource, place: DVec2) -> Result<Option<f64>> {
    let Some(ground) = Ground::Bare.height_at(source, place)? else { return Ok(None) };
    let grid = source.header().grid;
    let mut slabs = Slabs::new(source);
    let standing = slabs.along([(place - grid.origin) / grid.spacing; 2])?;
    let dense = standing.iter().filter(|slab| slab.opacity >= DENSE);
    Ok(Some(dense.map(|slab| slab.high[0]).fold(ground, f64::max)))
}

/// Finds the matter that a point lies within.
fn surroundings(source: &dyn PageSource, point: DVec3) -> Result<Option<Matter>> {
    let grid = source.header().grid;
    let place = point.truncate();
    let Some(ground) = Ground::Bare.height_at(source, place)? else { return Ok(None) };
    if point.z < ground - TOUCH {
        return Ok(Some(Matter::Ground));
    }
    let mut slabs = Slabs::new(source);
    let standing = slabs.along([(place - grid.origin) / grid.spacing; 2])?;
    let holds = standing.iter().find(|slab| slab.hides_in(point.z));
    Ok(holds.map(|slab| Matter::Standing(slab.material)))
}

/// Range at which the ray is stopped before `length` metres, and the material of the span that does so.
///
/// Heights of the ray and of what it meets are rounded, so that which of them is higher where they touch is chance, and they touch wherever a point stands on something. So ground
/// counts if it stops a ray that is higher by [`TOUCH`], and a span, which has two ends, if it stops both a higher and a lower one.
fn obstacle(source: &dyn PageSource, ray: &GridRay, length: f64) -> Result<Option<(f64, Option<u8>)>> {
    let grid = source.header().grid;
    let [higher, lower] = [TOUCH, -TOUCH].map(|up| GridRay { eye: ray.eye + DVec3::Z * up, ..*ray });
    let bands = LevelBands::finest_only().with_bare_ground(&grid, SMALLEST_PIXEL, 0.0, 1.0);
    let mut marcher = Marcher::new(source, bands, Surface::Smooth);
    let contact = marcher.first_contact(&higher, 0.0)?.filter(|contact| contact.range < length);

    // What stands beyond the far point hides nothing.
    let end = Contact { range: length, level: 0, wanted: 0, face: None, bare: true };
    let mut hits = Vec::new();

    let mut solid = |ray: &GridRay| -> Result<Option<(f64, Option<u8>)>> {
        marcher.solids(ray, Some(&contact.unwrap_or(end)), &mut hits)?;
        let mut left = 1.0;
        let found = hits.iter().find(|hit| {
            left *= 1.0 - hit.opacity;
            left <= HALF
        });
        Ok(found.map(|hit| (hit.range, Some(hit.span.material))))
    };

    // What one of them only touches lies nearer than what stops both.
    let solid = match solid(&higher)? {
        Some(one) => solid(&lower)?.map(|other| if one.0 < other.0 { other } else { one }),
        None => None,
    };

    Ok(solid.or(contact.map(|contact| (contact.range, None))))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::testing::{CODE, pillar, standing};
    use hedgehop::voxel::{Cut, Grid, MemPages, Metadata, Span, build_in_memory};

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

    #[test]
    fn a_wall_right_before_the_eye_counts_in_full() {
        // Half a metre thick along the western side of its voxel, 0.2 m before the eye: no half of a voxel's side has a middle in it.
        let wall = Span { cuts: [Cut::wall(0, -32), Cut::NONE, Cut::NONE], ..pillar(6.0) };
        let pages = standing(|x, _| if x == 145 { vec![wall] } else { Vec::new() });
        let see = |to: f64| sight(&pages, point(289.8, 5.0), point(489.8, to), Curvature::FLAT).unwrap();
        let hidden = see(5.0);
        // Its near edge has to be cleared by a metre after 0.2 m of 200 m.
        assert!(hidden.blocked.is_some() && (hidden.missing - 1000.0).abs() < 1.0, "{hidden:?}");
        let needed = 5.0 + hidden.missing;
        assert!(see(needed + 1.0).blocked.is_none() && see(needed - 1.0).blocked.is_some());
        assert_eq!(hidden.within, [None; 2]);
        // The same before the far point.
        let back = sight(&pages, point(489.8, 5.0), point(289.8, 5.0), Curvature::FLAT).unwrap();
        assert!((back.missing - 200.0 / 199.3).abs() < 0.01, "{back:?}");
    }

    #[test]
    fn a_slope_right_before_the_eye_asks_for_its_steepest_place() {
        let area = area(20.0);
        // On a slope of a fifth, a tenth of a metre up: the line has to be as steep as it, less the tenth up to its crest.
        let (from, to) = (point(450.5, 110.2), point(900.5, 110.2));
        let hidden = sight(&area, from, to, Curvature::FLAT).unwrap();
        let crest = 9.6 * 450.0 / 48.5;
        assert!((hidden.missing - crest).abs() < 0.1, "{hidden:?}");
        let see = |more: f64| sight(&area, from, to.with_z(to.z + more), Curvature::FLAT).unwrap().blocked;
        assert!(see(hidden.missing + 0.01).is_none() && see(hidden.missing - 0.01).is_some());
        // On the ground itself it asks for the slope's own steepness.
        let ground = Ground::Bare.height_at(&area, from.truncate()).unwrap().unwrap();
        let hidden = sight(&area, from.with_z(ground), to.with_z(ground), Curvature::FLAT).unwrap();
        assert!((hidden.missing - 0.2 * 450.0).abs() < 0.5, "{hidden:?}");
    }

    /// A point on what stands at x.
    fn foot(pages: &MemPages, x: f64) -> DVec3 {
        let place = point(x, 0.0).truncate();
        place.extend(footing(pages, place).unwrap().unwrap())
    }

    fn on_foot(pages: &MemPages, from: f64, to: f64) -> Sight {
        sight(pages, foot(pages, from), foot(pages, to), Curvature::FLAT).unwrap()
    }

    #[track_caller]
    fn sees(found: &Sight) {
        assert_eq!((found.blocked, found.missing, found.within), (None, 0.0, [None; 2]), "{found:?}");
    }

    #[test]
    fn points_on_level_ground_see_each_other_until_the_earth_bends() {
        let area = area(0.0);
        for (from, to) in [(100.0, 900.0), (900.0, 101.3), (333.3, 334.1), (100.7, 100.9)] {
            let found = on_foot(&area, from, to);
            sees(&found);
            assert!(found.nearest.unwrap().1.abs() < TOUCH, "{found:?}");
        }
        let [from, to] = [100.0, 900.0].map(|x| foot(&area, x));
        let curved = |up: f64| sight(&area, from, to + DVec3::Z * up, Curvature::standard()).unwrap();
        let drop = Curvature::standard().drop_at(800.0);
        assert!(curved(0.0).blocked.is_some() && (curved(0.0).missing - drop).abs() < 1e-3);
        sees(&curved(drop + 1e-3));
    }

    #[test]
    fn points_on_one_slope_see_each_other() {
        // It rises by a quarter, by 151 of the 65534 steps of its heights from post to post: rounding leaves it even.
        let grid = Grid { nx: 435, ny: 50, spacing: 2.0, origin: DVec2::new(1000.0, 2000.0) };
        let heights: Vec<f64> = (0..50).flat_map(|_| (0..435).map(|x| 100.0 + 0.5 * f64::from(x))).collect();
        let colours = vec![[90; 3]; heights.len()];
        let slope = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();

        for (one, other) in [(10.3, 855.7), (300.1, 301.7), (444.4, 444.5), (21.0, 23.0)] {
            for found in [on_foot(&slope, one, other), on_foot(&slope, other, one)] {
                sees(&found);
                assert!(found.nearest.unwrap().1.abs() < TOUCH, "{found:?}");
            }
        }

        let beside = foot(&slope, 700.3) + DVec3::new(0.0, 31.7, 0.0);
        sees(&sight(&slope, foot(&slope, 100.9), beside, Curvature::FLAT).unwrap());
        let above = foot(&slope, 450.3) + DVec3::Z * 50.0;
        sees(&sight(&slope, foot(&slope, 450.3), above, Curvature::FLAT).unwrap());
        sees(&sight(&slope, above, foot(&slope, 450.3), Curvature::FLAT).unwrap());

        // A hair below the ground is below it.
        let below = foot(&slope, 100.9) - DVec3::Z * 1e-4;
        assert!(sight(&slope, below, above, Curvature::FLAT).unwrap().blocked.is_some());
    }

    #[test]
    fn points_on_a_ridge_and_at_its_feet_see_each_other_but_not_across() {
        let area = area(20.0);
        // Its highest posts stand at 499 and 501 m.
        for (one, other) in [(100.0, 499.0), (501.0, 900.0)] {
            sees(&on_foot(&area, one, other));
            sees(&on_foot(&area, other, one));
        }
        let hidden = on_foot(&area, 100.0, 900.0);
        assert!(
            (hidden.blocked.unwrap().distance - 299.0).abs() < 0.1,
            "its foot, not the eye's: {hidden:?}"
        );
        assert!((hidden.missing - 19.8 * 800.0 / 399.0).abs() < 0.1, "{hidden:?}");
    }

    #[test]
    fn points_on_roofs_and_right_below_decks_are_not_hidden_by_them() {
        let deck = Span { low: CODE.encode(12.0), ..pillar(13.0) };
        let pitched = Span { slope: [16, 0], ..pillar(9.0) };
        let pages = standing(|x, _| match x {
            100..110 | 145..155 => vec![pillar(8.0)],
            165..175 => vec![deck],
            180 => vec![pitched],
            _ => Vec::new(),
        });

        // Beside a wall one stands on the ground, not half way up.
        let heights = [289.9, 290.1, 340.5, 360.7].map(|x| foot(&pages, x).z);
        for (height, wanted) in heights.into_iter().zip([0.0, 8.0, 13.0, 8.85]) {
            assert!((height - wanted).abs() < 1e-6, "{heights:?}");
        }

        assert_eq!(footing(&pages, DVec2::ZERO).unwrap(), None, "there is no ground beside the area");
        for (one, other) in [(201.3, 218.9), (201.3, 300.5), (360.2, 361.8)] {
            sees(&on_foot(&pages, one, other));
            sees(&on_foot(&pages, other, one));
        }

        let see = |from: DVec3, to: DVec3| sight(&pages, from, to, Curvature::FLAT).unwrap();
        sees(&see(foot(&pages, 360.7), point(380.0, 20.0)));
        sees(&see(point(320.0, 30.0), foot(&pages, 360.7)));
        let below = point(340.5, CODE.decode(CODE.encode(12.0)).unwrap());
        sees(&see(below, point(400.5, below.z)));
        sees(&see(point(400.5, 10.0), below));
        assert_eq!(see(below, point(400.5, 20.0)).material, Some(2), "the deck is above it");
    }

    #[test]
    fn straight_up_and_down_is_a_line_of_sight() {
        let deck = Span { low: CODE.encode(12.0), ..pillar(13.0) };
        let leaf = Span { low: CODE.encode(14.0), state: 5, ..pillar(30.0) };
        let pages = standing(|x, _| match x {
            145..155 => vec![deck],
            165..175 => vec![leaf],
            _ => Vec::new(),
        });
        let see = |x: f64, from: f64, to: f64| {
            sight(&pages, point(x, from), point(x, to), Curvature::standard()).unwrap()
        };
        let down = see(300.5, 50.0, 2.0);
        assert_eq!((down.distance, down.material), (0.0, Some(2)));
        assert!((down.missing - 11.0).abs() < 0.01, "up to the deck's upper end: {down:?}");
        assert!(see(300.5, 50.0, 13.01).blocked.is_none());
        let up = see(300.5, 2.0, 50.0);
        assert!(up.blocked.is_some() && up.missing == f64::INFINITY, "{up:?}");
        let under = see(300.5, 11.0, 2.0);
        assert_eq!((under.blocked, under.missing), (None, 0.0));
        for inside in [see(300.5, 12.5, 2.0), see(100.5, -1.0, -3.0)] {
            assert!(inside.blocked.is_some() && inside.missing == f64::INFINITY, "{inside:?}");
        }

        let ground = see(100.5, 50.0, -3.0);
        assert!((ground.missing - 3.0).abs() < 1e-6, "{ground:?}");

        // Two voxels' sides of 2 m let the share (10/15)² through, 0.44: half is gone after 1.71 of them.
        let leaves = see(340.5, 50.0, 2.0);
        let half = 2.0 * 0.5_f64.ln() / (10.0_f64 / 15.0).ln();
        assert!((leaves.missing - (30.0 - half - 2.0)).abs() < 0.01, "{leaves:?}");
        assert!(see(340.5, 50.0, 30.0 - half + 0.01).blocked.is_none());
    }

    #[test]
    fn points_within_something_are_told() {
        let deck = Span { low: CODE.encode(12.0), ..pillar(13.0) };
        let leaf = Span { state: 5, ..pillar(9.0) };
        let pages = standing(|x, _| match x {
            145..155 => vec![deck],
            165..175 => vec![leaf],
            185..195 => vec![pillar(8.0)],
            _ => Vec::new(),
        });
        let within = |from: DVec3, to: DVec3| {
            let found = sight(&pages, from, to, Curvature::FLAT).unwrap();
            (found.within, found.missing)
        };
        let standing = Some(Matter::Standing(2));
        let (around, missing) = within(point(380.5, 5.0), point(300.5, 12.5));
        assert_eq!((around, missing), ([standing; 2], f64::INFINITY));
        let (around, _) = within(point(340.5, 5.0), point(100.5, -1.0));
        assert_eq!(around, [None, Some(Matter::Ground)], "leaves are no solid");

        // On roofs and below decks there is air; so there is beside the area.
        assert_eq!(within(point(380.5, 8.0), point(300.5, 11.99)).0, [None; 2]);
        assert_eq!(within(point(-50.0, -5.0), point(100.5, 3.0)).0, [None; 2]);

        // Up from within the deck to above it.
        let (around, missing) = within(point(100.5, 12.5), point(300.5, 12.5));
        assert_eq!(around, [None, standing]);
        assert!((missing - 0.5 * 200.0 / 189.5).abs() < 0.01, "{missing}");
    }
}
