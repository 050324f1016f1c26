//! Ellipses, rings and arcs painted on the ground, by the exact area of each voxel that they cover.
//!
//! ```text
//! share of a piece = area of (voxel ∩ outer ellipse ∩ sector) − that of the inner one, over the voxel's;
//!                    with a transition its mean over ellipses from the outer rim inward
//! share of a coat  = 1 − Π (1 − share of each of its pieces)
//! patches by priority, then as they come; of each its coats in their order
//! ```
//!
//! Coarse voxels have the means of fine ones, since areas add up. Circles after Bunker and Ferris, AFHRL-TR-77-66 (1977), §2.

use glam::DVec2;

use super::noise::turned;
use crate::warp::{self, LevelGrid, Rect};
use hedgehop::voxel::Material;
use hedgehop_conic::{CellOverlap, area_of, half_plane, rectangle};

/// Paint on the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundPatch {
    /// Coats of paint, each over those before it.
    pub coats: Vec<PaintCoat>,
    /// Material of the ground under it, if it states that.
    pub material: Option<Material>,
    /// Share of it in the colour of the ground, 0…1.
    pub strength: f32,
    /// Rank among patches: higher ones lie over lower ones, of equal ones later ones.
    pub priority: i32,
}

/// Pieces of one colour, which overlap unseen.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintCoat {
    /// At least one.
    pub pieces: Vec<EllipsePiece>,
    /// Colour, sRGB; `None`: that of the patch's material.
    pub colour: Option<[u8; 3]>,
}

/// An ellipse on the ground, or a ring of it, or an arc of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipsePiece {
    /// Middle, metres.
    pub centre: DVec2,
    /// Half axes to the right and forward, metres, > 0.
    pub radii: DVec2,
    /// Direction of the forward axis, degrees clockwise from grid north.
    pub azimuth_deg: f64,
    /// Half axes of what is left out in the middle, metres, > 0 and less than `radii`.
    pub inner: Option<DVec2>,
    /// Sector that it keeps to.
    pub sector: Option<Sector>,
    /// Width over which it fades into the ground, inward from its outer rim, metres, 0 to the least of `radii`.
    pub fade_m: f64,
}

/// Part of the way around a centre, clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sector {
    /// Azimuth of its beginning, degrees clockwise from grid north.
    pub from_deg: f64,
    /// Angle that it goes over, degrees, more than 0 and less than 360.
    pub width_deg: f64,
}

/// Paint on a voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PaintedVoxel {
    /// Index in its block.
    pub index: usize,
    /// Share of the voxel that a coat covers, more than 0, at most 1.
    pub share: f32,
    /// Numbers of the patch, and of the coat in it.
    pub patch: usize,
    pub coat: usize,
}

/// Places before which a piece's area is found: ellipses and a sector, ready to be asked.
struct PieceOverlap {
    centre: DVec2,
    /// Ellipses from the outermost inward; each has the same part in the piece.
    outer: Vec<CellOverlap>,
    inner: Option<CellOverlap>,
    sector: Option<Sector>,
}

/// Most ellipses of a transition.
const MOST_STEPS: f64 = 256.0;

impl EllipsePiece {
    /// A whole circle.
    pub fn circle(centre: DVec2, radius_m: f64) -> Self {
        Self {
            centre,
            radii: DVec2::splat(radius_m),
            azimuth_deg: 0.0,
            inner: None,
            sector: None,
            fade_m: 0.0,
        }
    }

    fn ellipse(&self, radii: DVec2) -> Option<CellOverlap> {
        let forward = turned(self.azimuth_deg);
        CellOverlap::new(self.centre, [-forward.perp() * radii.x, forward * radii.y])
    }

    /// Makes it ready for voxels of a side, metres: steps of a transition are narrower than these.
    fn overlap(&self, side: f64) -> Option<PieceOverlap> {
        let steps = (2.0 * self.fade_m / side).ceil().clamp(1.0, MOST_STEPS);
        let radii = |step: u32| self.radii - self.fade_m * (f64::from(step) + 0.5) / steps;
        let outer: Option<Vec<_>> = if self.fade_m > 0.0 {
            (0..steps as u32).map(|step| self.ellipse(radii(step))).collect()
        } else {
            self.ellipse(self.radii).map(|ellipse| vec![ellipse])
        };
        let inner = self.inner.and_then(|inner| self.ellipse(inner));
        Some(PieceOverlap { centre: self.centre, outer: outer?, inner, sector: self.sector })
    }
}

impl PieceOverlap {
    /// Mean area of a convex polygon in the ellipses of the transition.
    fn faded(&self, polygon: &[DVec2]) -> f64 {
        let [outer] = self.outer.as_slice() else {
            // They lie in each other: the outer ones hold all of it, the inner ones nothing.
            let whole = area_of(polygon);
            let full = self.outer.partition_point(|ellipse| ellipse.area(polygon) >= whole * (1.0 - LEAST));
            let areas = self.outer[full..].iter().map(|ellipse| ellipse.area(polygon));
            let partial: f64 = areas.take_while(|area| *area > whole * LEAST).sum();
            return (full as f64 * whole + partial) / self.outer.len() as f64;
        };
        outer.area(polygon)
    }

    /// Area of a convex polygon in it.
    fn area(&self, polygon: &[DVec2]) -> f64 {
        let ring =
            |polygon: &[DVec2]| self.faded(polygon) - self.inner.map_or(0.0, |inner| inner.area(polygon));
        let Some(Sector { from_deg, width_deg }) = self.sector else { return ring(polygon) };

        // A sector of more than half a turn is no convex region, but what it leaves is one.
        let wedge = |from: f64, width: f64| {
            let part = half_plane(polygon, self.centre, -turned(from).perp());
            ring(&half_plane(&part, self.centre, turned(from + width).perp()))
        };
        if width_deg <= 180.0 {
            wedge(from_deg, width_deg)
        } else {
            ring(polygon) - wedge(from_deg + width_deg, 360.0 - width_deg)
        }
    }
}

impl GroundPatch {
    fn pieces(&self) -> impl Iterator<Item = &EllipsePiece> {
        self.coats.iter().flat_map(|coat| &coat.pieces)
    }

    /// West, south, east, north of it; `None`: it has no piece.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        let boxes = self.pieces().filter_map(|piece| Some(piece.ellipse(piece.radii)?.bounds()));
        let [low, high] = boxes.reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])?;
        Some([low.x, low.y, high.x, high.y])
    }
}

/// Finds what patches paint on a block, in the order in which coats lie on each other.
pub(super) fn painted(patches: &[GroundPatch], level: &LevelGrid, rect: Rect) -> Vec<PaintedVoxel> {
    let mut order: Vec<usize> = (0..patches.len()).collect();
    order.sort_by_key(|patch| patches[*patch].priority);

    let mut found = Vec::new();
    for patch in order {
        let reaches = patches[patch].bounds().is_some_and(|bounds| rect.meets(&bounds, &level.grid));
        for (coat, PaintCoat { pieces, .. }) in patches[patch].coats.iter().enumerate().filter(|_| reaches) {
            let mut bare = vec![1.0; if pieces.len() > 1 { rect.len() } else { 0 }];
            for piece in pieces.iter().filter_map(|piece| piece.overlap(level.grid.spacing)) {
                each_share(&piece, level, rect, |index, share| match bare.get_mut(index) {
                    Some(bare) => *bare *= 1.0 - share,
                    None => found.push(PaintedVoxel { index, share: share as f32, patch, coat }),
                });
            }
            let covered = bare.iter().enumerate().filter(|(_, bare)| **bare < 1.0);
            found.extend(covered.map(|(index, bare)| PaintedVoxel {
                index,
                share: (1.0 - bare) as f32,
                patch,
                coat,
            }));
        }
    }
    found
}

/// Tells the share of each voxel of a block that a piece covers, where that is more than 0.
fn each_share(piece: &PieceOverlap, level: &LevelGrid, rect: Rect, mut tell: impl FnMut(usize, f64)) {
    let (grid, side) = (&level.grid, level.grid.spacing);
    let Some(outermost) = piece.outer.first() else { return };
    let [low, high] = outermost.bounds().map(|corner| (corner - grid.origin) / side);
    // A float converts saturating.
    let columns = (low.x.floor() as u32).max(rect.x0)..(high.x.ceil() as u32).min(rect.x1);
    for y in (low.y.floor() as u32).max(rect.y0)..(high.y.ceil() as u32).min(rect.y1) {
        for x in columns.clone() {
            let corner = |x: u32, y: u32| DVec2::from(warp::world(grid, f64::from(x), f64::from(y)));
            let area = piece.area(&rectangle(corner(x, y), corner(x + 1, y + 1)));
            let share = (area / (side * side)).min(1.0);
            if share > LEAST {
                tell(rect.index(x, y), share);
            }
        }
    }
}

/// Share of a voxel that is none: rounding of what lies beside a piece.
const LEAST: f64 = 1.0e-9;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use hedgehop::voxel::Grid;

    const CENTRE: DVec2 = DVec2::new(200.3, 190.7);

    fn level(level: u8) -> LevelGrid {
        let grid = Grid { origin: DVec2::ZERO, spacing: 1.0, nx: 512, ny: 512 };
        LevelGrid::of(&grid, level)
    }

    fn patch(pieces: Vec<EllipsePiece>, priority: i32) -> GroundPatch {
        let coats = vec![PaintCoat { pieces, colour: Some([255; 3]) }];
        GroundPatch { coats, material: None, strength: 1.0, priority }
    }

    /// Shares of a whole level.
    fn shares(patches: &[GroundPatch], number: u8) -> Vec<f64> {
        let level = level(number);
        let rect = Rect { x0: 0, y0: 0, x1: level.grid.nx, y1: level.grid.ny };
        let mut shares = vec![0.0; rect.len()];
        painted(patches, &level, rect).iter().for_each(|voxel| shares[voxel.index] = f64::from(voxel.share));
        shares
    }

    fn pieces() -> Vec<(EllipsePiece, f64)> {
        let whole = EllipsePiece {
            radii: DVec2::new(120.0, 47.0),
            azimuth_deg: 33.0,
            ..EllipsePiece::circle(CENTRE, 1.0)
        };
        let inner = Some(DVec2::new(90.0, 30.0));
        let (all, hole) = (PI * 120.0 * 47.0, PI * 90.0 * 30.0);
        let sector = |from_deg: f64, width_deg: f64| Some(Sector { from_deg, width_deg });
        let circle = EllipsePiece::circle(CENTRE, 80.0);
        let ring = EllipsePiece { inner: Some(DVec2::splat(72.0)), ..circle };
        let road = PI * (80.0 * 80.0 - 72.0 * 72.0);
        vec![
            (whole, all),
            (EllipsePiece { inner, ..whole }, all - hole),
            (circle, PI * 6400.0),
            (ring, road),
            (EllipsePiece { sector: sector(350.0, 65.0), ..ring }, road * 65.0 / 360.0),
            (EllipsePiece { sector: sector(-30.0, 290.0), ..ring }, road * 290.0 / 360.0),
            (EllipsePiece { sector: sector(20.0, 180.0), ..circle }, PI * 3200.0),
            (EllipsePiece::circle(CENTRE, 0.31), PI * 0.31 * 0.31),
        ]
    }

    #[test]
    fn areas_are_exact_at_every_level() {
        for (piece, area) in pieces() {
            for (number, side) in [(0, 1.0), (1, 4.0), (2, 16.0), (3, 64.0)] {
                let sum: f64 = shares(&[patch(vec![piece], 0)], number).iter().sum();
                let found = sum * side * side;
                assert!((found / area - 1.0).abs() < 1e-5, "{piece:?}, level {number}: {found}, not {area}");
            }
        }
    }

    #[test]
    fn coarse_voxels_have_the_means_of_their_children() {
        for (piece, _) in pieces() {
            let [fine, coarse] = [0, 1].map(|number| shares(&[patch(vec![piece], 0)], number));
            let (wide, narrow) = (512, 128);
            for (index, share) in coarse.iter().enumerate() {
                let (x, y) = (4 * (index % narrow), 4 * (index / narrow));
                let children = (0..16).map(|child| fine[(y + child / 4) * wide + x + child % 4]);
                let mean = children.sum::<f64>() / 16.0;
                assert!((share - mean).abs() < 1e-6, "{piece:?}: {share}, not {mean}");
            }
        }
    }

    /// Azimuths turn from north to east, and sectors go that way.
    #[test]
    fn pieces_lie_as_their_azimuths_say() {
        let at = |piece: EllipsePiece, azimuth: f64, away: f64| {
            let place = (CENTRE + turned(azimuth) * away).floor();
            shares(&[patch(vec![piece], 0)], 0)[place.y as usize * 512 + place.x as usize]
        };
        let long = EllipsePiece {
            radii: DVec2::new(5.0, 60.0),
            azimuth_deg: 70.0,
            ..EllipsePiece::circle(CENTRE, 1.0)
        };
        assert_eq!([70.0, 250.0, 110.0, 160.0].map(|azimuth| at(long, azimuth, 50.0)), [1.0, 1.0, 0.0, 0.0]);
        let sector = Some(Sector { from_deg: 80.0, width_deg: 40.0 });
        let arc = EllipsePiece { sector, ..EllipsePiece::circle(CENTRE, 60.0) };
        assert_eq!([100.0, 70.0, 130.0, 280.0].map(|azimuth| at(arc, azimuth, 50.0)), [1.0, 0.0, 0.0, 0.0]);
    }

    /// White to blue as of a carrier's wake: light falls from the middle outward in steps that nobody sees.
    #[test]
    fn transitions_fall_evenly_to_the_rim() {
        let circle = EllipsePiece { fade_m: 150.0, ..EllipsePiece::circle(CENTRE, 190.0) };
        let shares = shares(&[patch(vec![circle], 0)], 0);
        let row: Vec<f64> = (200..395).map(|x| shares[190 * 512 + x]).collect();
        assert!(row.windows(2).all(|pair| (0.0..=2.0 / 255.0).contains(&(pair[0] - pair[1]))), "{row:?}");
        assert!(row[..39].iter().all(|share| *share == 1.0) && row[191..].iter().all(|share| *share == 0.0));
        for (x, wanted) in [(70, 0.8), (115, 0.5), (160, 0.2)] {
            assert!((row[x] - wanted).abs() < 0.006, "{x}: {}", row[x]);
        }
        // A ramp over so narrow a band is an edge.
        let narrow = EllipsePiece { fade_m: 0.1, ..circle };
        let area: f64 = self::shares(&[patch(vec![narrow], 0)], 0).iter().sum();
        assert!((area / (PI * 189.95_f64.powi(2)) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn pages_do_not_matter() {
        let all = shares(&[patch(vec![pieces()[4].0], 0)], 0);
        for (x0, y0) in [(130, 100), (200, 190), (255, 255)] {
            let rect = Rect { x0, y0, x1: x0 + 70, y1: y0 + 90 };
            let part = painted(&[patch(vec![pieces()[4].0], 0)], &level(0), rect);
            for PaintedVoxel { index, share, .. } in part {
                let (x, y) = rect.voxel(index);
                assert_eq!(f64::from(share), all[y as usize * 512 + x as usize]);
            }
        }
    }

    #[test]
    fn patches_lie_by_priority_and_pieces_of_a_coat_as_one() {
        let circle = |radius: f64| EllipsePiece::circle(CENTRE, radius);
        let patches = [9, -2, 9, 0].map(|priority| patch(vec![circle(20.0)], priority));
        let rect = Rect { x0: 195, y0: 185, x1: 205, y1: 195 };
        let order: Vec<usize> = painted(&patches, &level(0), rect).iter().map(|voxel| voxel.patch).collect();
        let mut layers = order.clone();
        layers.dedup();
        assert_eq!((layers, order.len()), (vec![1, 3, 0, 2], 400));

        let twice = patch(vec![circle(20.0), circle(12.0)], 0);
        let voxels = painted(std::slice::from_ref(&twice), &level(0), rect);
        assert_eq!(voxels.len(), 100);
        assert!(voxels.iter().all(|voxel| voxel.share == 1.0));
    }

    #[test]
    fn pieces_far_away_reach_nothing() {
        let far = EllipsePiece::circle(DVec2::new(-900.0, 3e8), 30.0);
        assert!(shares(&[patch(vec![far], 0)], 0).iter().all(|share| *share == 0.0));
    }
}
