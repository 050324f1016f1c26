//! Sixty-four places of a voxel, one bit each, and the half-plane, or the two, that say best which of them are covered.
//!
//! The places are a rank-1 lattice (Korobov 1959): no two share their column or row, so that walls along the grid are told to a 64th of a
//! voxel, as are most others.

use glam::{DVec2, dvec2};

use crate::features::HalfPlane;

/// Places of a voxel.
pub(super) const RAYS: usize = 64;

/// Generator of the lattice.
const STEP: usize = 19;

/// Directions that are tried where no face tells one.
const DIRECTIONS: usize = 64;

/// A place, in voxels from the voxel's centre.
pub(super) fn place(ray: usize) -> DVec2 {
    let part = |index: usize| (index as f64 + 0.5) / RAYS as f64 - 0.5;
    dvec2(part(ray), part(ray * STEP % RAYS))
}

/// Form of a mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MaskForm {
    /// All of the voxel.
    Whole,
    /// A half-plane, in voxels from the voxel's centre.
    Half(HalfPlane),
    /// Two half-planes, of which it has what both share.
    Corner([HalfPlane; 2]),
    /// A strip from side to side of the voxel, as a half-plane.
    Strip(HalfPlane),
    /// Something within.
    Island,
}

/// Half-plane that stands for a mask.
#[derive(Debug, Clone, Copy)]
struct HalfFit {
    half: HalfPlane,
    /// Places of the voxel that are others.
    wrong: u32,
}

/// Two half-planes that stand for a mask.
struct CornerFit {
    halves: [HalfPlane; 2],
    /// Places of the voxel that are others.
    wrong: u32,
}

/// Places that are covered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Mask(pub u64);

impl Mask {
    pub fn add(&mut self, ray: usize) {
        self.0 |= 1 << ray;
    }

    pub fn holds(self, ray: usize) -> bool {
        self.0 >> ray & 1 == 1
    }

    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Share of the voxel.
    pub fn share(self) -> f64 {
        self.count() as f64 / RAYS as f64
    }

    pub fn rays(self) -> impl Iterator<Item = usize> {
        (0..RAYS).filter(move |ray| self.holds(*ray))
    }

    /// Middle of the places, voxels.
    pub fn middle(self) -> DVec2 {
        self.rays().map(place).sum::<DVec2>() / self.count().max(1) as f64
    }

    /// The half-plane towards `normal` that covers as many places.
    fn half(self, normal: DVec2) -> HalfFit {
        let mut along: Vec<(f64, usize)> = (0..RAYS).map(|ray| (place(ray).dot(normal), ray)).collect();
        along.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = self.count();
        let mut covered = Self::default();
        along[..count].iter().for_each(|(_, ray)| covered.add(*ray));
        let reach = normal.abs().dot(DVec2::splat(0.5));
        let before = if count == 0 { -reach } else { along[count - 1].0 };
        let after = along.get(count).map_or(reach, |(at, _)| *at);
        let half = HalfPlane { normal, distance: 0.5 * (before + after) };
        HalfFit { half, wrong: (covered.0 ^ self.0).count_ones() }
    }

    /// Counts the places that differ from those within half-planes.
    fn differs(self, halves: &[HalfPlane]) -> u32 {
        let is_within = |ray: usize| halves.iter().all(|half| place(ray).dot(half.normal) <= half.distance);
        (0..RAYS).filter(|ray| is_within(*ray) != self.holds(*ray)).count() as u32
    }

    /// The two of some half-planes that have in common what is nearest to what is covered.
    fn corner(self, facings: &[HalfPlane]) -> Option<CornerFit> {
        let pairs = facings
            .iter()
            .enumerate()
            .flat_map(|(at, one)| facings[at + 1..].iter().map(|other| [*one, *other]));
        let fits = pairs.map(|halves| CornerFit { halves, wrong: self.differs(&halves) });
        fits.min_by_key(|fit| fit.wrong)
    }

    /// Finds the form, if `facings` are the half-planes within faces, in voxels from the voxel's centre.
    pub fn form(self, facings: &[HalfPlane]) -> MaskForm {
        let count = self.count();
        if let [own] = facings
            && count + 1 >= RAYS
            && self.differs(&[*own]) <= 1
        {
            // A corner of the voxel that no ray meets.
            return MaskForm::Half(*own);
        }
        if count + 1 >= RAYS {
            return MaskForm::Whole;
        }

        let told = |own: &HalfPlane| {
            let tried = self.half(own.normal);
            // Faces tell it exactly, where they are one wall.
            let wrong = self.differs(&[*own]);
            if wrong <= tried.wrong.max(1) { HalfFit { half: *own, wrong } } else { tried }
        };
        let told = facings.iter().map(told).min_by_key(|fit| fit.wrong);

        // Faces tell the direction exactly; another one must be far better.
        const BETTER: u32 = 5;

        let least = told.map_or(u32::MAX, |fit| fit.wrong);
        let best = if least <= BETTER {
            told
        } else {
            let turns = (0..DIRECTIONS).map(|turn| {
                self.half(DVec2::from_angle(std::f64::consts::TAU * turn as f64 / DIRECTIONS as f64))
            });
            let free = turns.min_by_key(|fit| fit.wrong);
            free.filter(|fit| fit.wrong + BETTER < least).or(told)
        };

        let Some(HalfFit { half, wrong }) = best else { return MaskForm::Island };
        let most = (count.min(RAYS - count) as u32).div_ceil(2);
        if let Some(corner) = self.corner(facings)
            && corner.wrong + 1 < wrong
            && corner.wrong <= most
        {
            return MaskForm::Corner(corner.halves);
        }
        if wrong <= most {
            return MaskForm::Half(half);
        }

        self.strip().unwrap_or(MaskForm::Island)
    }

    /// A strip, if it is one: its side that is farther from the centre is its outside.
    fn strip(self) -> Option<MaskForm> {
        let middle = self.middle();
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for from in self.rays().map(|ray| place(ray) - middle) {
            xx += from.x * from.x;
            xy += from.x * from.y;
            yy += from.y * from.y;
        }

        let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        let spread = |direction: DVec2| {
            self.rays()
                .map(|ray| place(ray).dot(direction))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
        };
        let [from, to] = spread(along);
        if to - from < 0.7 || self.count() < 3 {
            return None;
        }

        let across = along.perp();
        let normal = if middle.dot(across) >= 0.0 { across } else { -across };
        let [low, high] = spread(normal);
        let half = HalfPlane { normal, distance: high + 0.5 / RAYS as f64 };

        (high - low < 0.75 * (to - from)).then_some(MaskForm::Strip(half))
    }
}
