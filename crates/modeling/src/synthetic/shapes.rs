//! Shapes of synthetic ground: planes, fractal hills, ridges and valleys, cones, domes, plateaus, ponds.
//!
//! ```text
//! height' = keep · height + add       of each shape in turn, keep and add being functions of the place
//! ```
//! What raises or carves has keep 1, what levels the ground fades keep to 0. For voxels of a coarse level both are means over places in the voxel
//! wherever the shape is not much wider than that. Waves shorter than two voxels, or than two such places, are left out.

use glam::DVec2;

use super::line;
use super::noise::{Waves, turned};

/// Shapes of which fewer voxels make up a flank are averaged over each voxel of a coarse level.
const FEW: f64 = 4.0;
/// Places of a voxel along a side over which they are.
const PLACES: i32 = 4;

/// A part of synthetic ground. Places are metres of the database's reference system, x east, y north.
#[derive(Debug, Clone, PartialEq)]
pub enum Terrain {
    /// Flat ground wherever there is none yet.
    Plane {
        /// Height at `centre`, metres.
        height_m: f64,
        /// Place at which it has that height.
        centre: DVec2,
        /// Rise over run.
        slope: f64,
        /// Direction in which it rises, degrees clockwise from grid north.
        upward_deg: f64,
    },
    /// Hills of all sizes.
    Fractal {
        /// Waves that they are the sum of.
        waves: Hills,
        /// Most that they go up and down, metres, > 0.
        amplitude_m: f64,
        /// Whether they have sharp edges.
        crests: bool,
        /// Circle in which they are, fading out towards the rim; `None`: everywhere.
        within: Option<Circle>,
    },
    /// Swept along a line, with rounded flanks.
    Ridge {
        /// At least two places, each different from the one before it.
        line: Vec<DVec2>,
        /// Width from foot to foot, metres, > 0.
        width_m: f64,
        /// Width that is level in the middle, metres, 0…`width_m`.
        crest_m: f64,
        /// Height of its middle above the ground as it is, metres; negative: a valley.
        height_m: f64,
    },
    /// Straight flanks up to a point.
    Cone {
        /// Circle of its foot.
        circle: Circle,
        /// Height of its point above the ground as it is, metres; negative: a pit.
        height_m: f64,
    },
    /// Round above, and rounded into the ground at its foot.
    Dome {
        /// Circle of its foot.
        circle: Circle,
        /// Height of its middle above the ground as it is, metres; negative: a bowl.
        height_m: f64,
    },
    /// Ground as high all over a circle.
    Plateau {
        /// Circle of its top.
        circle: Circle,
        /// Width of the flank around that, metres, > 0.
        flank_m: f64,
        /// Height of its top.
        top: PlateauTop,
    },
    /// Level water.
    Pond {
        /// Circle of its shore, but for bays.
        circle: Circle,
        /// Width of the bank around it, up or down to the ground, metres, > 0.
        bank_m: f64,
        /// Height of the water, metres.
        level_m: f64,
        /// Most that the shore leaves the circle, in radii, 0…½.
        ragged: f64,
        /// Seed that picks one shore among all.
        seed: u64,
        /// Colour of the water, sRGB.
        colour: [u8; 3],
    },
}

/// Waves of hills.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hills {
    /// Seed that picks some hills among all.
    pub seed: u64,
    /// Length of the longest, metres, > 0.
    pub wavelength_m: f64,
    /// Height of those half as long, as a share, 0…1 exclusively.
    pub roughness: f64,
}

/// A circle on the ground, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre of the circle.
    pub centre: DVec2,
    /// > 0.
    pub radius_m: f64,
}

/// Height of a plateau.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlateauTop {
    /// Height above the ground as it is, metres; with all its bumps.
    Above(f64),
    /// Level, at this height, metres.
    Level(f64),
}

/// Effect of a shape on a height: `keep · height + add`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Effect {
    pub keep: f64,
    pub add: f64,
}

impl Effect {
    fn raise(add: f64) -> Self {
        Self { keep: 1.0, add }
    }

    fn level(height: f64, share: f64) -> Self {
        Self { keep: 1.0 - share, add: share * height }
    }

    /// Applies it to a height, metres; NaN where there is no ground stays so, but where it is not asked for.
    pub fn on(self, height: f64) -> f64 {
        if self.keep == 0.0 { self.add } else { self.keep * height + self.add }
    }
}

impl Circle {
    /// Distance from the middle, in radii.
    fn radii(&self, at: DVec2) -> f64 {
        (at - self.centre).length() / self.radius_m
    }

    /// West, south, east, north of it, and of so many metres around it.
    pub(super) fn bounds(&self, more: f64) -> [f64; 4] {
        let reach = self.radius_m + more;
        let (low, high) = (self.centre - reach, self.centre + reach);
        [low.x, low.y, high.x, high.y]
    }
}

/// 1 at 0, 0 at 1 and beyond, level at both.
fn bell(t: f64) -> f64 {
    let rest = (1.0 - t * t).max(0.0);
    rest * rest
}

/// 1 at 0, 0 at 1 and beyond, level at both; half way down in the middle.
fn flank(t: f64) -> f64 {
    let rest = (1.0 - t).clamp(0.0, 1.0);
    rest * rest * (3.0 - 2.0 * rest)
}

/// Within −1…1, slowing down towards both.
fn limited(value: f64) -> f64 {
    let value = value.clamp(-1.0, 1.0);
    value * (1.5 - 0.5 * value * value)
}

impl Hills {
    fn waves(&self) -> Waves {
        Waves { seed: self.seed, longest: self.wavelength_m, gain: self.roughness }
    }

    /// The sum of its waves without bounds, those of the first having a mean square of 1.
    #[cfg(test)]
    pub(crate) fn plain(&self, at: DVec2, shortest: f64) -> f64 {
        self.waves().sum(at, self.waves().count(shortest), |value| value)
    }

    /// −1…1, without waves shorter than `shortest` metres.
    fn at(&self, at: DVec2, shortest: f64, crests: bool) -> f64 {
        let waves = self.waves();
        // The sum of all waves, whatever the level leaves out of them: 1 / (1 − gain); three deviations of it are rare.
        let whole = 1.0 / (1.0 - self.roughness * self.roughness).sqrt();
        let count = waves.count(shortest);
        if crests {
            // 1 where the noise is 0, falling off in straight lines that bend outward: mean 0.13 and deviation 0.53, and hardly ever less than −1.2.
            let edge = |value: f64| 1.0 - 1.4 * value.abs() / (1.0 + 0.3 * value.abs());
            limited(waves.sum(at, count, edge) / (2.0 * whole))
        } else {
            limited(waves.sum(at, count, |value| value) / (2.9 * whole))
        }
    }
}

impl Terrain {
    /// Effect on the voxel whose centre is `at` and whose side is `side` metres; at level 0 that of the place itself.
    pub(super) fn effect(&self, at: DVec2, side: f64, level: u8) -> Effect {
        if level == 0 || self.finest() >= FEW * side {
            return self.effect_at(at, 2.0 * side);
        }
        let places = (0..PLACES * PLACES).map(|place| {
            let part = |index: i32| (f64::from(index) + 0.5) / f64::from(PLACES) - 0.5;
            at + side * DVec2::new(part(place % PLACES), part(place / PLACES))
        });
        let sum = places.fold(Effect { keep: 0.0, add: 0.0 }, |sum, place| {
            let Effect { keep, add } = self.effect_at(place, 2.0 * side / f64::from(PLACES));
            Effect { keep: sum.keep + keep, add: sum.add + add }
        });
        let count = f64::from(PLACES * PLACES);
        Effect { keep: sum.keep / count, add: sum.add / count }
    }

    /// Whether a place lies on it: the ground there has its material.
    pub(super) fn holds(&self, at: DVec2) -> bool {
        match self {
            Self::Plane { .. } => true,
            Self::Fractal { within, .. } => within.is_none_or(|circle| circle.radii(at) < 1.0),
            Self::Ridge { line, width_m, .. } => line::distance(line, at) < 0.5 * width_m,
            Self::Cone { circle, .. } | Self::Dome { circle, .. } => circle.radii(at) < 1.0,
            Self::Plateau { circle, flank_m, .. } => {
                (at - circle.centre).length() < circle.radius_m + flank_m
            }
            Self::Pond { bank_m, .. } => self.ashore(at) < *bank_m,
        }
    }

    /// Effect on a place, without waves shorter than `shortest` metres.
    fn effect_at(&self, at: DVec2, shortest: f64) -> Effect {
        match self {
            Self::Plane { height_m, centre, slope, upward_deg } => {
                let rise = if *slope == 0.0 { 0.0 } else { slope * (at - *centre).dot(turned(*upward_deg)) };
                Effect { keep: 0.0, add: height_m + rise }
            }
            Self::Fractal { waves, amplitude_m, crests, within } => {
                let share = within.map_or(1.0, |circle| bell(circle.radii(at)));
                let height = if share > 0.0 { waves.at(at, shortest, *crests) } else { 0.0 };
                Effect::raise(share * amplitude_m * height)
            }
            Self::Ridge { line, width_m, crest_m, height_m } => {
                let away = line::distance(line, at) - 0.5 * crest_m;
                Effect::raise(height_m * bell((away / (0.5 * (width_m - crest_m))).max(0.0)))
            }
            Self::Cone { circle, height_m } => Effect::raise(height_m * (1.0 - circle.radii(at)).max(0.0)),
            Self::Dome { circle, height_m } => Effect::raise(height_m * bell(circle.radii(at))),
            Self::Plateau { circle, flank_m, top } => {
                let away = (at - circle.centre).length() - circle.radius_m;
                let share = flank(away / flank_m);
                match top {
                    PlateauTop::Above(height) => Effect::raise(height * share),
                    PlateauTop::Level(height) => Effect::level(*height, share),
                }
            }
            Self::Pond { bank_m, level_m, .. } => {
                let share = flank(self.ashore(at) / bank_m);
                Effect::level(*level_m, share)
            }
        }
    }

    /// Returns how far beyond a pond's shore a place is, metres; 0 and less on its water; infinite for other shapes.
    fn ashore(&self, at: DVec2) -> f64 {
        let Self::Pond { circle, ragged, seed, .. } = self else { return f64::INFINITY };
        let bays = Hills { seed: *seed, wavelength_m: 1.3 * circle.radius_m, roughness: 0.5 };
        let wander = if *ragged == 0.0 { 0.0 } else { ragged * bays.at(at, 0.3 * circle.radius_m, false) };
        (at - circle.centre).length() - (1.0 + wander) * circle.radius_m
    }

    /// Share of water in the voxel whose centre is `at` and whose side is `side` metres, and its colour.
    pub(super) fn water(&self, at: DVec2, side: f64) -> Option<(f64, [u8; 3])> {
        let Self::Pond { colour, .. } = self else { return None };
        let places = (0..PLACES * PLACES).map(|place| {
            let part = |index: i32| (f64::from(index) + 0.5) / f64::from(PLACES) - 0.5;
            at + side * DVec2::new(part(place % PLACES), part(place / PLACES))
        });
        let wet = places.filter(|place| self.ashore(*place) <= 0.0).count();
        (wet > 0).then(|| (wet as f64 / f64::from(PLACES * PLACES), *colour))
    }

    /// Least way over which it changes by all of its height, metres.
    fn finest(&self) -> f64 {
        match self {
            Self::Plane { .. } => f64::INFINITY,
            Self::Fractal { .. } => 0.0,
            Self::Ridge { width_m, crest_m, .. } => 0.5 * (width_m - crest_m),
            Self::Cone { circle, .. } | Self::Dome { circle, .. } => circle.radius_m,
            Self::Plateau { circle, flank_m, .. } => flank_m.min(circle.radius_m),
            Self::Pond { circle, bank_m, .. } => bank_m.min(circle.radius_m),
        }
    }

    /// West, south, east, north of what it changes; `None`: everything.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        match self {
            Self::Plane { .. } => None,
            Self::Fractal { within, .. } => within.map(|circle| circle.bounds(0.0)),
            Self::Ridge { line, width_m, .. } => {
                let reach = 0.5 * width_m * line::widening(line);
                let low = line.iter().copied().reduce(DVec2::min).unwrap_or_default() - reach;
                let high = line.iter().copied().reduce(DVec2::max).unwrap_or_default() + reach;
                Some([low.x, low.y, high.x, high.y])
            }
            Self::Cone { circle, .. } | Self::Dome { circle, .. } => Some(circle.bounds(0.0)),
            Self::Plateau { circle, flank_m, .. } => Some(circle.bounds(*flank_m)),
            Self::Pond { circle, bank_m, ragged, .. } => {
                Some(circle.bounds(bank_m + ragged * circle.radius_m))
            }
        }
    }

    /// Range of heights after it, metres, of those before it and within an area.
    pub(super) fn heights(
        &self,
        before: Option<(f64, f64)>,
        [west, south, east, north]: [f64; 4],
    ) -> Option<(f64, f64)> {
        let raised = |by: f64| before.map(|(low, high)| (low + by.min(0.0), high + by.max(0.0)));
        let with = |low: f64, high: f64| Some(before.map_or((low, high), |(a, b)| (a.min(low), b.max(high))));
        match self {
            Self::Plane { .. } => {
                let corners = [(west, south), (east, south), (west, north), (east, north)];
                let heights = corners.map(|(x, y)| self.effect_at(DVec2::new(x, y), 0.0).add);
                with(
                    heights.into_iter().fold(f64::INFINITY, f64::min),
                    heights.into_iter().fold(f64::NEG_INFINITY, f64::max),
                )
            }
            Self::Fractal { amplitude_m, .. } => {
                before.map(|(low, high)| (low - amplitude_m.abs(), high + amplitude_m.abs()))
            }
            Self::Ridge { height_m, .. } | Self::Cone { height_m, .. } | Self::Dome { height_m, .. } => {
                raised(*height_m)
            }
            Self::Plateau { top: PlateauTop::Above(height), .. } => raised(*height),
            Self::Plateau { top: PlateauTop::Level(height), .. } => with(*height, *height),
            Self::Pond { level_m, .. } => with(*level_m, *level_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CIRCLE: Circle = Circle { centre: DVec2::new(1000.0, 2000.0), radius_m: 300.0 };

    fn on(shape: &Terrain, away: f64, ground: f64) -> f64 {
        shape.effect(CIRCLE.centre + DVec2::new(away, 0.0), 1.0, 0).on(ground)
    }

    #[test]
    fn shapes_have_their_heights_in_the_middle_and_at_the_rim() {
        let cone = Terrain::Cone { circle: CIRCLE, height_m: 90.0 };
        assert_eq!([0.0, 150.0, 300.0, 500.0].map(|away| on(&cone, away, 10.0)), [100.0, 55.0, 10.0, 10.0]);
        let dome = Terrain::Dome { circle: CIRCLE, height_m: 90.0 };
        assert_eq!([0.0, 300.0, 400.0].map(|away| on(&dome, away, 10.0)), [100.0, 10.0, 10.0]);
        let plateau = |top| Terrain::Plateau { circle: CIRCLE, flank_m: 100.0, top };
        let heights = |top| [0.0, 300.0, 350.0, 400.0].map(|away| on(&plateau(top), away, 10.0));
        assert_eq!(heights(PlateauTop::Above(80.0)), [90.0, 90.0, 50.0, 10.0]);
        assert_eq!(heights(PlateauTop::Level(80.0)), [80.0, 80.0, 45.0, 10.0]);
    }

    #[test]
    fn water_is_level_to_the_shore_and_banks_meet_the_ground() {
        for ragged in [0.0, 0.4] {
            let pond =
                Terrain::Pond { circle: CIRCLE, bank_m: 50.0, level_m: 3.1, ragged, seed: 4, colour: [0; 3] };
            for step in 0..4000 {
                let place = CIRCLE.centre + 0.1 * f64::from(step) * turned(17.0 * f64::from(step));
                let height = pond.effect(place, 1.0, 0).on(7.7);
                match pond.ashore(place) {
                    ashore if ashore <= 0.0 => assert_eq!(height, 3.1),
                    ashore if ashore >= 50.0 => assert_eq!(height, 7.7),
                    _ => assert!((3.1..=7.7).contains(&height)),
                }
            }
            assert_eq!(pond.water(CIRCLE.centre, 1.0), Some((1.0, [0; 3])));
        }
    }

    #[test]
    fn a_ridge_has_its_cross_section() {
        let line = vec![DVec2::new(0.0, -4e4), DVec2::new(0.0, 100.0), DVec2::new(0.0, 4e4)];
        let ridge = Terrain::Ridge { line, width_m: 400.0, crest_m: 100.0, height_m: 60.0 };
        for across in [-250.0, -200.0, -120.0, -50.0, 0.0, 30.0, 90.0, 199.0] {
            let height = ridge.effect(DVec2::new(across, 30.0), 1.0, 0).on(0.0);
            let wanted = 60.0 * bell(((f64::abs(across) - 50.0) / 150.0).max(0.0));
            assert!((height - wanted).abs() < 1e-4, "{across}: {height}, not {wanted}");
        }
    }

    #[test]
    fn hills_keep_to_their_bounds_and_fill_them() {
        for crests in [false, true] {
            for roughness in [0.35, 0.5, 0.7] {
                let hills = Hills { seed: 3, wavelength_m: 500.0, roughness };
                let heights = (0..40_000).map(|step| {
                    let place = DVec2::new(f64::from(step % 200), f64::from(step / 200)) * 37.3;
                    hills.at(place, 2.0, crests)
                });
                let heights: Vec<f64> = heights.collect();
                let (least, most) =
                    heights.iter().fold((1.0_f64, -1.0_f64), |(a, b), h| (a.min(*h), b.max(*h)));
                let deviation = (heights.iter().map(|h| h * h).sum::<f64>() / 40_000.0).sqrt();
                assert!(
                    least >= -1.0 && most <= 1.0 && most > 0.85 && least < -0.6,
                    "{roughness} {least} {most}"
                );
                assert!((0.3..0.6).contains(&deviation), "{crests} {roughness}: {deviation}");
            }
        }
    }

    #[test]
    fn coarse_voxels_take_the_mean_of_narrow_shapes() {
        let dome = Terrain::Dome { circle: Circle { radius_m: 10.0, ..CIRCLE }, height_m: 60.0 };
        // Volume of a bell of revolution: π r² h / 3.
        let total: f64 = (-4..4)
            .flat_map(|row| (-4..4).map(move |column| (column, row)))
            .map(|(column, row)| {
                let at = CIRCLE.centre + 16.0 * (DVec2::new(f64::from(column), f64::from(row)) + 0.5);
                dome.effect(at, 16.0, 2).add * 256.0
            })
            .sum();
        let volume = std::f64::consts::PI * 100.0 * 60.0 / 3.0;
        assert!((total / volume - 1.0).abs() < 0.05, "{total}, not {volume}");
    }
}
