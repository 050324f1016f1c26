//! Limits of the numbers in a database: a build is held to them, and so is a file when it is opened.
//!
//! A right checksum says that a file is as somebody wrote it, not that it was written by a build. All arithmetic behind the reader is
//! safe within these limits, which leave room for worlds much larger than the Earth and for voxels of a millimetre.

use std::ops::RangeInclusive;

use super::{DetailRecord, Grid, HeightCode, HeightRange, Metadata};

/// Voxels of level 1 along a side of the area, at most.
pub const MOST_VOXELS: u32 = 1 << 30;

/// Sides of a level-1 voxel, metres.
pub const SPACINGS: RangeInclusive<f64> = 1.0e-3..=1.0e7;

/// Farthest from the origin of its reference system that an area may reach, metres.
pub const FARTHEST: f64 = 1.0e10;

/// Farthest from the vertical datum that anything may be, metres.
pub const HIGHEST: f64 = 1.0e6;

/// Least step of a height code, metres.
const LEAST_STEP: f64 = 1.0e-9;

/// Refuses a spacing that no database may have, with a sentence.
pub fn check_spacing(spacing: f64) -> Result<(), String> {
    if SPACINGS.contains(&spacing) {
        return Ok(());
    }
    Err(format!(
        "the spacing is {spacing:?} m, but must be within {} and {} m",
        SPACINGS.start(),
        SPACINGS.end()
    ))
}

impl Grid {
    /// Whether every number is in range; otherwise a sentence that says which one is not.
    pub fn check(&self) -> Result<(), String> {
        let Self { nx, ny, spacing, origin } = *self;
        let sides = 1..=MOST_VOXELS;
        if !(sides.contains(&nx) && sides.contains(&ny)) {
            return Err(format!(
                "the grid has {nx} x {ny} voxels, but needs at least one and at most {MOST_VOXELS} each way"
            ));
        }
        check_spacing(spacing)?;
        let far = self.far_corner();
        let reach = [origin, far].map(|corner| corner.abs().max_element());
        if !(origin.is_finite() && far.is_finite() && reach.iter().all(|reach| *reach <= FARTHEST)) {
            return Err(format!(
                "the area reaches from ({:?}, {:?}) to ({:?}, {:?}), but may lie within {FARTHEST} m of its system's origin",
                origin.x, origin.y, far.x, far.y
            ));
        }
        Ok(())
    }
}

impl HeightCode {
    /// Whether every code has a height that can be; otherwise a sentence that says what is wrong.
    pub fn check(&self) -> Result<(), String> {
        let highest = self.offset + self.scale * f64::from(u16::MAX);
        if self.scale >= LEAST_STEP && self.offset.abs() <= HIGHEST && highest <= HIGHEST {
            return Ok(());
        }
        Err(format!(
            "heights of {:?} m + {:?} m per step cannot be: they must lie within {HIGHEST} m of the datum",
            self.offset, self.scale
        ))
    }

    /// The same of the lowest and the highest surface, which codes must have.
    pub(super) fn check_range(&self, range: HeightRange) -> Result<(), String> {
        let HeightRange { low, high } = range;
        // There is no surface at all.
        if (low, high) == (0.0, 0.0) {
            return Ok(());
        }
        let lowest = self.offset - self.scale;
        let highest = self.offset + self.scale * (f64::from(u16::MAX) + 1.0);
        if low <= high && low >= lowest && high <= highest {
            return Ok(());
        }
        Err(format!(
            "heights from {low:?} m to {high:?} m cannot be: codes reach from {lowest} m to {highest} m"
        ))
    }
}

impl Metadata {
    /// Whether every number is in range; otherwise a sentence that says which one is not.
    pub(super) fn check(&self) -> Result<(), String> {
        let bounded = |name: &str, value: f64, range: RangeInclusive<f64>| match range.contains(&value) {
            true => Ok(()),
            false => {
                let (least, most) = range.into_inner();
                Err(format!("metadata: {name} is {value:?}, but must be within {least} and {most}"))
            }
        };

        bounded("void_share", self.void_share, 0.0..=1.0)?;
        bounded("empty_share", self.empty_share, 0.0..=1.0)?;
        bounded("filled_share", self.filled_share.unwrap_or(0.0), 0.0..=1.0)?;
        if let Some([azimuth, elevation]) = self.baked_sun {
            bounded("the azimuth of baked_sun", azimuth, -360.0..=360.0)?;
            bounded("the elevation of baked_sun", elevation, -90.0..=90.0)?;
        }

        if let Some(side) = self.imagery_pixel {
            bounded("imagery_pixel", side, SPACINGS)?;
        }
        for corridor in &self.corridors {
            bounded("the width of a corridor", corridor.width, f64::MIN_POSITIVE..=f64::MAX)?;
            bounded("the spacing of a corridor", corridor.spacing, SPACINGS)?;
        }

        if self.sources.len() > usize::from(u16::MAX) + 1 {
            return Err(format!(
                "metadata: {} sources, but voxels tell {} apart",
                self.sources.len(),
                u16::MAX
            ));
        }
        self.detail.as_ref().map_or(Ok(()), DetailRecord::check)?;
        if self.materials.iter().any(|material| material.number == 0) {
            return Err("metadata: a material has number 0, which means that none is known".into());
        }

        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    /// Numbers that are no size of anything.
    const WRONG: [f64; 7] = [0.0, -1.0, 1.0e300, -1.0e300, 1.0e-300, f64::NAN, f64::INFINITY];

    #[test]
    fn sizes_that_cannot_be_are_told() {
        let grid = Grid { nx: 9, ny: 9, spacing: 1.0, origin: DVec2::ZERO };
        assert_eq!(grid.check(), Ok(()));
        for wrong in WRONG {
            let sentence = Grid { spacing: wrong, ..grid }.check().unwrap_err();
            assert!(sentence.contains("spacing") && sentence.len() < 100, "{sentence}");
            assert!(HeightCode { scale: wrong, offset: 0.0 }.check().is_err(), "{wrong}");
        }
        for wrong in [1.0e300, -1.0e300, f64::NAN, f64::INFINITY] {
            assert!(Grid { origin: DVec2::new(0.0, wrong), ..grid }.check().is_err(), "{wrong}");
            assert!(HeightCode { scale: 0.1, offset: wrong }.check().is_err(), "{wrong}");
        }
        assert!(Grid { nx: 0, ..grid }.check().is_err() && Grid { ny: u32::MAX, ..grid }.check().is_err());
    }

    #[test]
    fn the_range_is_one_that_codes_have() {
        let code = HeightCode { scale: 0.01, offset: 100.0 };
        for (low, high) in [(100.01, 700.0), (0.0, 0.0), (300.0, 300.0)] {
            assert_eq!(code.check_range(HeightRange { low, high }), Ok(()));
        }
        for (low, high) in
            [(99.0, 700.0), (100.0, 800.0), (300.0, 200.0), (f64::NAN, 200.0), (200.0, f64::INFINITY)]
        {
            let wrong = HeightRange { low, high };
            assert!(code.check_range(wrong).is_err(), "{wrong:?}");
        }
    }
}
