//! Plants, and what else lets light through: runs of points in height.
//!
//! ```text
//! heights of the points of a voxel and the eight around it, sorted, cut wherever a gap is wide
//! for each run: upper end = plane through the highest point of each voxel, lower end = median of the lowest
//!     opacity from how many points it has
//! the lowest run stands on the ground if the gap below it is not wide; below a crown there is nothing otherwise
//! ```

use super::super::features::{Paint, Solid, Wall};
use super::class::PointKind;
use super::fit::PlaneFit;
use super::hard::UNKNOWN;
use super::posts::Mix;
use super::scene::{TileScene, quantile, shaded};
use super::window::{Mark, TileVoxel};

/// A wide gap: sides of a voxel, and metres, the greater.
const GAP: (f64, f64) = (2.0, 1.5);
/// Wide for towers, as a multiple.
const GAP_OF_TOWERS: f64 = 4.0;
/// Lowest plant, metres.
const LOWEST: f64 = 0.4;
/// Points of a run at least, and voxels around that hold some where a voxel has none itself.
const LEAST: usize = 3;
const JOINED: usize = 5;
/// Voxels of the nine that hold points of what hangs in the air, and of what hangs there below something else: less is a twig.
const AIRY: usize = 3;
const TWIG: usize = 6;
/// Least thickness of a run: sides of a voxel.
const THINNEST: f64 = 0.75;
/// Opacity of few points, and what many add.
const OPACITY: (f64, f64) = (0.5, 0.45);
/// Steepest upper end, rise over run.
const STEEPEST: f64 = 1.2;
/// Codes by which voxels without colours differ.
const ROUGH: i64 = 12;
/// Clearance between a roof and what hangs over it, metres.
const OVER_ROOF: f64 = 1.5;

/// Points of one run, by voxel of the nine: lowest and highest of each.
struct Run {
    ranges: [Option<(f64, f64)>; 9],
    count: usize,
    mix: Mix,
    /// Σ places.
    lean: [f64; 2],
    /// Height of the highest so far.
    high: f64,
}

impl Run {
    fn new(z: f64) -> Self {
        Self { ranges: [None; 9], count: 0, mix: Mix::default(), lean: [0.0; 2], high: z }
    }

    fn add(&mut self, slot: usize, place: [f64; 2], mark: &Mark) {
        let z = mark.z();
        let (low, high) = self.ranges[slot].unwrap_or((z, z));
        self.ranges[slot] = Some((low.min(z), high.max(z)));
        self.count += 1;
        self.mix.add(mark.srgb(), if slot == 4 { 1.0 } else { 0.2 });
        self.lean = [self.lean[0] + place[0], self.lean[1] + place[1]];
        self.high = z;
    }

    /// Whether the middle voxel is of it.
    fn is_here(&self) -> bool {
        let around = self.ranges.iter().flatten().count();
        self.count >= LEAST && (self.ranges[4].is_some() || around >= JOINED)
    }
}

/// Heights below a run, by which its lower end is found.
struct Footing {
    /// Height of the ground, metres.
    ground: f64,
    /// Height of the top of what is below the run, metres: the ground's, if nothing is.
    below: f64,
    /// Widest gap over the ground below a run that stands on it, metres.
    gap: f64,
}

/// Points of a voxel that are left over when its roof is known.
pub(super) struct Plants<'a, 's> {
    pub scene: &'a TileScene<'s>,
    /// Height of the roof or deck over each voxel of the window; NaN where there is none.
    pub roofs: &'a [f64],
}

impl Plants<'_, '_> {
    /// Solids of plants and of what is not known over a voxel.
    pub fn solids(&self, voxel: TileVoxel, out: &mut Vec<Solid>) {
        let scene = self.scene;
        let ground = scene.ground[scene.index(voxel)];
        let counts = |mark: &Mark, roof: f64| match mark.kind() {
            PointKind::Vegetation => mark.z() >= ground + LOWEST,
            PointKind::Unknown => {
                mark.z() >= ground + UNKNOWN && (roof.is_nan() || mark.z() > roof + OVER_ROOF)
            }
            _ => false,
        };
        let gap = GAP.1.max(GAP.0 * scene.spacing);
        self.raise(voxel, gap, counts, out);
    }

    /// Solids of towers over a voxel.
    pub fn towers(&self, voxel: TileVoxel, out: &mut Vec<Solid>) {
        let own = self.scene.window.at(voxel);
        if own.iter().any(|mark| mark.kind() == PointKind::Tower) {
            let gap = GAP_OF_TOWERS * GAP.1.max(GAP.0 * self.scene.spacing);
            self.raise(voxel, gap, |mark, _| mark.kind() == PointKind::Tower, out);
        }
    }

    fn raise(&self, voxel: TileVoxel, gap: f64, counts: impl Fn(&Mark, f64) -> bool, out: &mut Vec<Solid>) {
        let scene = self.scene;
        let ground = scene.ground[scene.index(voxel)];
        if ground.is_nan() {
            return;
        }

        let mut points: Vec<(usize, [f64; 2], &Mark)> = Vec::new();
        for ([east, north], marks) in scene.window.voxels(voxel, 1) {
            let other = TileVoxel {
                column: (voxel.column as i64 + east) as usize,
                row: (voxel.row as i64 + north) as usize,
            };
            let roof = self.roofs[scene.index(other)];
            let slot = ((north + 1) * 3 + east + 1) as usize;
            let place = |mark: &Mark| {
                [0, 1].map(|axis| [east, north][axis] as f64 + f64::from(mark.within[axis]) / 65536.0 - 0.5)
            };
            let those = marks.iter().filter(|mark| counts(mark, roof));
            points.extend(those.map(|mark| (slot, place(mark), mark)));
        }

        if points.len() < LEAST {
            return;
        }

        points.sort_by(|a, b| a.2.z.total_cmp(&b.2.z));
        let mut runs: Vec<Run> = Vec::new();
        for (slot, place, mark) in points {
            match runs.last_mut().filter(|run| mark.z() - run.high <= gap) {
                Some(run) => run.add(slot, place, mark),
                None => {
                    let mut run = Run::new(mark.z());
                    run.add(slot, place, mark);
                    runs.push(run);
                }
            }
        }

        let kind =
            if gap > GAP.1.max(GAP.0 * scene.spacing) { PointKind::Tower } else { PointKind::Vegetation };
        let roof = self.roofs[scene.index(voxel)];

        // The top of what is below.
        let mut below = if roof.is_nan() { ground } else { roof };
        for (index, run) in runs.iter().enumerate().filter(|(_, run)| run.is_here()) {
            let Some(solid) = self.solid(voxel, run, &Footing { ground, below, gap }, kind) else { continue };
            let least = if index + 1 < runs.len() { TWIG } else { AIRY };
            if solid.low_m.is_some() && run.ranges.iter().flatten().count() < least {
                continue;
            }
            below = solid.high_m;
            out.push(solid);
        }
    }

    /// The solid of a run, on the ground or above what lies below it.
    fn solid(&self, voxel: TileVoxel, run: &Run, footing: &Footing, kind: PointKind) -> Option<Solid> {
        let scene = self.scene;
        let &Footing { ground, below, gap } = footing;
        let (mut tops, mut bottoms) = (PlaneFit::new(), Vec::new());
        for (slot, (low, high)) in
            run.ranges.iter().enumerate().filter_map(|(slot, range)| Some((slot, (*range)?)))
        {
            let place = [(slot % 3) as f64 - 1.0, (slot / 3) as f64 - 1.0];
            let share = (2.0 - place[0].abs()) * (2.0 - place[1].abs());
            tops.add(place, high, share);
            bottoms.push(low);
        }

        let top = tops.plane()?;
        bottoms.sort_by(f64::total_cmp);
        let low = quantile(&bottoms, 0.5)?.min(top.height - THINNEST * scene.spacing);
        let is_on_ground = below == ground && low - ground <= gap;
        let low_m = (!is_on_ground).then_some(low.max(below));
        if top.height <= low_m.unwrap_or(ground) {
            return None;
        }

        let own = kind.paint();
        let colour = run.mix.srgb().unwrap_or_else(|| rough(own.colour, scene.window.first, voxel));
        let solid = scene.solid(low_m, &top, Paint { colour, ..own });
        let share = run.count as f64 / (9.0 * scene.density);

        // Sides look away from where the points are.
        let facing = (-run.lean[1]).atan2(-run.lean[0]);
        Some(Solid {
            slope: solid.slope.map(|slope| slope.clamp(-STEEPEST, STEEPEST)),
            wall: Wall::Round(facing),
            side: shaded(colour),
            opacity: OPACITY.0 + OPACITY.1 * share.min(1.0),
            ..solid
        })
    }
}

/// A colour that differs a little from voxel to voxel.
fn rough(colour: [u8; 3], first: [i64; 2], voxel: TileVoxel) -> [u8; 3] {
    let (x, y) = (first[0] + voxel.column as i64, first[1] + voxel.row as i64);
    let hash =
        (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    let hash = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40;
    let step = (hash % (2 * ROUGH as u64 + 1)) as i64 - ROUGH;
    colour.map(|code| (i64::from(code) + step).clamp(0, 255) as u8)
}
