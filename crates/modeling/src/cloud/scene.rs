//! Scene that solids are made from: the points and the ground about the voxels of a tile.

use super::super::features::{Paint, Solid, Wall};
use super::class::PointKind;
use super::fit::{FittedPlane, PlaneFit, tent};
use super::posts::Mix;
use super::window::{Mark, PointWindow, TileVoxel};

/// Steepest upper end, rise over run.
const STEEPEST: f64 = 3.0;
/// Darkness of sides against the upper end, as a factor.
const SHADE: f64 = 0.72;

/// Points and ground about the voxels of a tile.
pub(super) struct TileScene<'a> {
    pub window: &'a PointWindow,
    /// Heights of the ground of the window's voxels, metres; NaN where there is none.
    pub ground: Vec<f64>,
    /// Side of a voxel, metres.
    pub spacing: f64,
    /// Points in a voxel, in the mean of the cloud.
    pub density: f64,
}

impl TileScene<'_> {
    pub fn index(&self, voxel: TileVoxel) -> usize {
        voxel.row * self.window.side + voxel.column
    }

    /// All voxels of the window.
    pub fn voxels(&self) -> impl Iterator<Item = TileVoxel> + use<> {
        let side = self.window.side;
        (0..side).flat_map(move |row| (0..side).map(move |column| TileVoxel { column, row }))
    }

    /// The eight voxels around one, as far as they are of the window.
    pub fn neighbours(&self, voxel: TileVoxel) -> impl Iterator<Item = TileVoxel> + use<> {
        let side = self.window.side;
        let near = move |at: usize| at.saturating_sub(1)..(at + 2).min(side);
        let columns = near(voxel.column);
        let all =
            near(voxel.row).flat_map(move |row| columns.clone().map(move |column| TileVoxel { column, row }));
        all.filter(move |other| *other != voxel)
    }

    /// Heights of points of a voxel that stand for something at least so high above its ground, from the lowest on.
    pub fn heights(&self, voxel: TileVoxel, least: f64, is: impl Fn(PointKind) -> bool) -> Vec<f64> {
        let ground = self.ground[self.index(voxel)];
        let own = self.window.at(voxel).iter();
        let mut heights: Vec<f64> =
            own.filter(|mark| is(mark.kind()) && mark.z() >= ground + least).map(Mark::z).collect();
        heights.sort_by(f64::total_cmp);
        heights
    }

    /// The plane through points near `level` about a voxel, and how many of all that count lie on it: these, and all.
    pub fn plane(
        &self,
        voxel: TileVoxel,
        level: f64,
        counts: impl Fn(&Mark) -> bool,
    ) -> Option<(FittedPlane, usize, usize)> {
        // Widths of the band about the level, and of that about a first plane: metres, and sides of a voxel, the greater.
        const BAND: (f64, f64) = (0.8, 1.5);
        const CLOSE: (f64, f64) = (0.15, 0.2);
        const RADIUS: f64 = 1.5;

        let wide = BAND.0.max(BAND.1 * self.spacing);
        let close = CLOSE.0.max(CLOSE.1 * self.spacing);
        let about = || self.window.around(voxel, 1).filter(|(_, mark)| counts(mark));
        let mut rough = PlaneFit::new();
        for (place, mark) in about().filter(|(_, mark)| (mark.z() - level).abs() <= wide) {
            rough.add(place, mark.z(), tent(place, RADIUS));
        }

        let first = rough.plane()?;
        let (mut fine, mut on, mut all) = (PlaneFit::new(), 0, 0);
        for (place, mark) in about() {
            all += 1;
            if (mark.z() - first.at(place)).abs() <= close {
                on += 1;
                fine.add(place, mark.z(), tent(place, RADIUS));
            }
        }

        // Where two planes meet in a ridge neither holds most points.
        let is_one = fine.weight() >= 0.5 * rough.weight();
        Some((fine.plane().filter(|_| is_one).unwrap_or(first), on, all))
    }

    /// Mean colour of points about a voxel that count, its own before those around.
    pub fn colour(&self, voxel: TileVoxel, counts: impl Fn(&Mark) -> bool) -> Option<[u8; 3]> {
        let mut mix = Mix::default();
        for (step, marks) in self.window.voxels(voxel, 1) {
            let weight = if step == [0, 0] { 1.0 } else { 0.2 };
            marks.iter().filter(|mark| counts(mark)).for_each(|mark| mix.add(mark.srgb(), weight));
        }
        mix.srgb()
    }

    /// A dense solid whose upper end is a plane.
    pub fn solid(&self, low_m: Option<f64>, plane: &FittedPlane, paint: Paint) -> Solid {
        Solid {
            low_m,
            high_m: plane.height,
            slope: plane.rise.map(|rise| (rise / self.spacing).clamp(-STEEPEST, STEEPEST)),
            wall: Wall::Whole,
            top: paint.colour,
            side: shaded(paint.colour),
            opacity: 1.0,
            material: paint.material.code(),
            parallel: false,
            strip: false,
            joined: [false; 2],
            facade: None,
        }
    }
}

/// The colour of what is turned away from the sky.
pub(super) fn shaded(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|code| (f64::from(code) * SHADE).round() as u8)
}

/// The value below which a share of sorted values lies.
pub(super) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    sorted.get(((sorted.len().saturating_sub(1)) as f64 * share).round() as usize).copied()
}
