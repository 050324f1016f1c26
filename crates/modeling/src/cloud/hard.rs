//! Roofs and decks: hard things, one solid over each voxel.
//!
//! ```text
//! a voxel belongs to a roof if its points of buildings are as many as those of its ground,
//!     or if its points of no known kind, and those around, lie on one plane
//! voxels amid others are joined to them; those that stand alone are left out
//! height, slope = plane through the points about the voxel
//! at its rim a wall cuts the voxel where it parts these points from those below    wall
//! ```

use super::super::features::{Paint, Solid, Wall};
use super::class::PointKind;
use super::scene::{TileScene, quantile};
use super::wall::{self, Side};
use super::window::{Mark, TileVoxel};

/// Least height of buildings above the ground, and of matter of no known kind, metres.
const LOWEST: f64 = 1.0;
pub(super) const UNKNOWN: f64 = 2.0;
/// Share of a voxel's points that lie below its roof: others are of walls.
const LEVEL: f64 = 0.7;
/// Thickness of a deck, metres.
const DECK: f64 = 1.0;
/// Points of no known kind that make a roof: so many of them, this share of them on one plane, no steeper than this.
const PLANAR: (usize, f64, f64) = (6, 0.85, 1.7);
/// Voxels of the same around one that is kept, around one that is kept although its points are of no known kind, and around one that has
/// no points.
const KEPT: usize = 2;
const KEPT_UNKNOWN: usize = 4;
const JOINED: usize = 5;
/// Around one whose own points say otherwise.
const JOINED_ALL: usize = 8;

/// Levels of the voxels of a window, metres; `None`: there is no such thing over it.
pub(super) struct Hard {
    levels: Vec<Option<(f64, bool)>>,
    kind: PointKind,
}

impl Hard {
    /// Roofs.
    pub fn roofs(scene: &TileScene<'_>) -> Self {
        let level = |voxel: TileVoxel| {
            let ground = scene.heights(voxel, f64::NEG_INFINITY, |kind| kind == PointKind::Ground).len();
            let own = scene.heights(voxel, LOWEST, |kind| kind == PointKind::Building);
            if !own.is_empty() && own.len() >= ground {
                return quantile(&own, LEVEL).map(|level| (level, false));
            }
            let unknown = scene.heights(voxel, UNKNOWN, |kind| kind == PointKind::Unknown);
            let level = quantile(&unknown, LEVEL).filter(|_| unknown.len() >= ground.max(1))?;
            let lowest = scene.ground[scene.index(voxel)] + UNKNOWN;
            let counts = |mark: &Mark| mark.kind() == PointKind::Unknown && mark.z() >= lowest;
            let (plane, on, all) = scene.plane(voxel, level, counts)?;
            let is_plane = all >= PLANAR.0
                && on as f64 >= PLANAR.1 * all as f64
                && plane.rise[0].hypot(plane.rise[1]) <= PLANAR.2 * scene.spacing;
            is_plane.then_some((level, true))
        };
        Self { levels: scene.voxels().map(level).collect(), kind: PointKind::Building }
    }

    /// Decks of bridges.
    pub fn decks(scene: &TileScene<'_>) -> Self {
        let level = |voxel: TileVoxel| {
            let own = scene.heights(voxel, f64::NEG_INFINITY, |kind| kind == PointKind::Deck);
            quantile(&own, 0.5).map(|level| (level, false))
        };
        Self { levels: scene.voxels().map(level).collect(), kind: PointKind::Deck }
    }

    /// The solid over a voxel that is not at the window's rim.
    pub fn solid(&self, scene: &TileScene<'_>, voxel: TileVoxel) -> Option<Solid> {
        let ground = Some(scene.ground[scene.index(voxel)]).filter(|ground| !ground.is_nan())?;
        let (level, is_sure, is_rim) = self.level(scene, voxel)?;
        let is_same = |mark: &Mark| match mark.kind() {
            PointKind::Unknown => self.kind == PointKind::Building && mark.z() >= ground + UNKNOWN,
            kind => kind == self.kind,
        };
        let (plane, ..) = scene.plane(voxel, level, is_same)?;
        let wall = match wall::between(scene, voxel, level, is_same).filter(|_| is_rim) {
            Some(Side::Cut(wall)) => wall,
            Some(Side::Inside) | None if is_sure => Wall::Whole,
            _ => return None,
        };
        let own = self.kind.paint();
        let paint = Paint { colour: scene.colour(voxel, is_same).unwrap_or(own.colour), ..own };
        if self.kind == PointKind::Deck {
            let deck = scene.solid(Some(plane.height - DECK), &plane, paint);
            return Some(Solid { parallel: true, wall, ..deck });
        }

        (plane.height >= ground + LOWEST).then(|| Solid { wall, ..scene.solid(None, &plane, paint) })
    }

    /// Level over a voxel, whether it surely belongs to it, and whether it is at its rim.
    fn level(&self, scene: &TileScene<'_>, voxel: TileVoxel) -> Option<(f64, bool, bool)> {
        let mut around: Vec<f64> = scene
            .neighbours(voxel)
            .filter_map(|other| self.levels[scene.index(other)])
            .map(|(level, _)| level)
            .collect();
        let count = around.len();
        let is_rim = count < 8;
        if let Some((level, is_unknown)) = self.levels[scene.index(voxel)] {
            let least = if is_unknown { KEPT_UNKNOWN } else { KEPT };
            return (count >= least).then_some((level, true, is_rim));
        }
        if count < KEPT {
            return None;
        }

        around.sort_by(f64::total_cmp);
        let level = quantile(&around, 0.5)?;
        let has_ground = scene.window.at(voxel).iter().any(|mark| mark.kind() == PointKind::Ground);
        let is_sure = count >= if has_ground { JOINED_ALL } else { JOINED };

        Some((level, is_sure, is_rim))
    }
}
