//! Sky by elevation angle, haze and fog by range and height, and how they glow about the sun.

use glam::Vec3;

use crate::sunlight::Sun;
use crate::weather::Weather;
use crate::weather::fog::{FogLayer, VANISHING_CONTRAST};
use crate::weather::glow::Glow;

/// Effect of the air before a surface on what is seen of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Veil {
    /// Light of the air itself, linear Rec. 709, 1 for white.
    pub light: Vec3,
    /// Share of the surface's light that comes through, 0…1.
    pub through: f32,
}

impl Veil {
    /// Radiance that reaches the eye from a surface of `radiance` behind it.
    pub fn over(&self, radiance: Vec3) -> Vec3 {
        self.light + radiance * self.through
    }

    /// Adds a layer of air between this veil and the eye: of `colour` where nothing comes through, and letting a share `through` of light
    /// through.
    fn with_nearer_layer(self, colour: Vec3, through: f32) -> Self {
        Self { light: colour.lerp(self.light, through), through: self.through * through }
    }
}

/// Share of a surface's radiance that makes no difference to the eye: less than half a step of 8 bits.
const UNSEEN: f64 = 1.0 / 1024.0;

/// Height over which haze thins by the factor e, metres: aerosol of the lower air.
pub(crate) const SCALE_HEIGHT: f32 = 2000.0;

/// Linear Rec. 709 colour of haze, but for its glow, at all heights.
pub(crate) const HAZE_COLOUR: Vec3 = Vec3::new(0.62, 0.71, 0.80);

/// Linear Rec. 709 colour of the clear sky straight above.
pub(crate) const ZENITH: Vec3 = Vec3::new(0.10, 0.22, 0.52);

/// Linear Rec. 709 colour of the clear sky at the horizon: that of haze, or a line would show where far ground meets it.
pub(crate) const HORIZON: Vec3 = HAZE_COLOUR;

/// Visibility of a clear day, metres, to which the colours of the sky belong: they hold that much haze already.
pub(crate) const CLEAR_VISIBILITY: f64 = 40_000.0;

/// Rate at which the sky turns from the horizon's haze to blue, per sine of elevation; it begins
/// gently, over sines up to `SKY_ONSET`, so that no line shows at the horizon.
pub(crate) const SKY_DEPTH: f32 = 5.0;
pub(crate) const SKY_ONSET: f32 = 0.12;

/// Linear Rec. 709 colours of fog from outside, where the sun lights it, and deep inside.
const FOG_LIT: Vec3 = Vec3::new(0.84, 0.87, 0.90);
const FOG_DEEP: Vec3 = Vec3::new(0.60, 0.65, 0.70);

/// Optical depths above the eye over which fog becomes as dark as it gets, by the factor e.
const FOG_DARKENS: f32 = 6.0;

/// Hazy air under a clear sky; the haze is thickest at a base height and thins exponentially above it. Fog may fill the air below a
/// height, and all may glow about the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Atmosphere {
    extinction: f32,
    base: f64,
    glow: Option<Glow>,
    fog: Option<FogLayer>,
}

impl Atmosphere {
    /// Air with a meteorological visibility (optical range) of `visibility` metres, > 0, at the
    /// height `base`, metres above the datum. Infinite visibility: no haze.
    pub fn new(visibility: f64, base: f64) -> Self {
        Self { extinction: -VANISHING_CONTRAST.ln() / visibility as f32, base, glow: None, fog: None }
    }

    /// The same with `weather` in it, under `sun`.
    #[must_use]
    pub fn with_weather(self, weather: &Weather, sun: Sun) -> Self {
        let fog = weather.fog.as_ref().map(|fog| FogLayer::new(fog, self.extinction));
        Self { glow: Glow::new(weather.glow, sun), fog, ..self }
    }

    /// Returns the glow of the air, if it glows.
    pub(crate) fn glow(&self) -> Option<&Glow> {
        self.glow.as_ref()
    }

    /// The layer of fog, if there is one.
    pub(crate) fn fog(&self) -> Option<&FogLayer> {
        self.fog.as_ref()
    }

    /// Whether the veil changes abruptly somewhere, as where fog ends: surfaces close to each other may then lie behind different ones.
    pub(crate) fn has_edge(&self) -> bool {
        self.fog.is_some()
    }

    /// Extinction at the base, 1/metres.
    pub(crate) fn extinction(&self) -> f32 {
        self.extinction
    }

    /// Extinction beyond that of a clear day, 1/metres: it hides the sky.
    pub(crate) fn excess(&self) -> f32 {
        (self.extinction - -VANISHING_CONTRAST.ln() / CLEAR_VISIBILITY as f32).max(0.0)
    }

    /// Height of an eye above the base, in scale heights, ≥ 0.
    pub(crate) fn scale_heights(&self, eye: f64) -> f32 {
        ((eye - self.base) as f32 / SCALE_HEIGHT).max(0.0)
    }

    /// Colour of fog from height `eye`, metres above the datum, but for its glow: darker the more of it lies above.
    pub(crate) fn fog_colour(&self, fog: &FogLayer, eye: f64) -> Vec3 {
        let above = fog.extinction * fog.column(fog.below(eye));
        FOG_DEEP.lerp(FOG_LIT, (-above / FOG_DARKENS).exp())
    }

    /// Each of some colours with the glow in unit `direction`.
    fn lit<const N: usize>(&self, colours: [Vec3; N], direction: Vec3) -> [Vec3; N] {
        let Some(glow) = &self.glow else { return colours };
        let share = glow.share(direction);
        colours.map(|colour| colour.lerp(glow.colour, share))
    }

    /// Radiance of the sky from height `eye` (metres above the datum) in unit `direction`, world axes. Below the
    /// horizon it is the haze that fills the distance, or the fog.
    pub fn sky(&self, eye: f64, direction: Vec3) -> Vec3 {
        let up = direction.z.max(0.0);
        let clear = 1.0 - (-SKY_DEPTH * up * up / (up + SKY_ONSET)).exp();

        // Air that is hazier than a clear day's hides the blue, or a white mountain would stand before it.
        let start = self.scale_heights(eye);
        let column = self.excess() * SCALE_HEIGHT * (-start).exp() / up.max(f32::MIN_POSITIVE);
        let fog_colour = self.fog.as_ref().map_or(HORIZON, |fog| self.fog_colour(fog, eye));
        let [horizon, light] = self.lit([HORIZON, fog_colour], direction);
        let sky = horizon.lerp(ZENITH, clear * (-column).exp());
        let Some(fog) = &self.fog else { return sky };
        let below = fog.below(eye);
        if below >= 0.0 {
            return light.lerp(sky, (-fog.depth_to_sky(below, direction.z)).exp());
        }

        // From above, fog is a floor without end, which haze hides towards the horizon.
        if direction.z >= 0.0 {
            return sky;
        }

        let before = fog.before(below, direction.z, f32::MAX);
        horizon.lerp(light, (-self.optical_depth(eye, direction.z, before)).exp())
    }

    /// Computes the veil before a surface at `range` metres in unit `direction`, world axes, for an eye at height `eye` (metres above the datum): what the air between lets
    /// through, and what it adds (Koschmieder 1924). Seen from above, haze lies before the fog, and from inside behind it.
    pub fn veil(&self, eye: f64, direction: Vec3, range: f32) -> Veil {
        let (up, clear) = (direction.z, Veil { light: Vec3::ZERO, through: 1.0 });
        let whole = self.optical_depth(eye, up, range);
        let Some(fog) = &self.fog else {
            let [haze] = self.lit([HAZE_COLOUR], direction);
            return clear.with_nearer_layer(haze, (-whole).exp());
        };
        let below = fog.below(eye);
        let before = match fog.before(below, up, range) {
            0.0 => 0.0,
            before => self.optical_depth(eye, up, before).min(whole),
        };
        let [haze, light] = self.lit([HAZE_COLOUR, self.fog_colour(fog, eye)], direction);
        clear
            .with_nearer_layer(haze, (before - whole).exp())
            .with_nearer_layer(light, (-fog.depth(below, up * range, range)).exp())
            .with_nearer_layer(haze, (-before).exp())
    }

    /// Radiance that reaches the eye from a surface of `radiance` behind the air of [`Self::veil`].
    pub fn haze(&self, radiance: Vec3, eye: f64, direction: Vec3, range: f32) -> Vec3 {
        self.veil(eye, direction, range).over(radiance)
    }

    /// Range beyond which nothing of the ground is seen from height `eye`, metres: haze lets through less than
    /// a thousandth of a surface at any height up to `highest`. Infinite where there is no haze.
    pub fn reach(&self, eye: f64, highest: f64) -> f64 {
        let air = Self { extinction: 1.0, ..*self };
        // Level with the highest ground, or between it and the eye: the clearest way that ends on ground. The
        // depth of a way of 1 m that rises or sinks as far is that of its mean.
        let mean = air.optical_depth(eye, (highest - eye) as f32, 1.0);
        -UNSEEN.ln() / f64::from(self.extinction * mean)
    }

    /// Extinction integrated along a ray: `∫ β·exp(−h/H) ds` in closed form, `h` above the base.
    fn optical_depth(&self, eye: f64, up: f32, range: f32) -> f32 {
        let start = self.scale_heights(eye);
        let end = (start + up * range / SCALE_HEIGHT).max(0.0);
        // From the lower end up, where nothing overflows: e^−low · (1 − e^−rise)/rise.
        let rise = (end - start).abs();
        let mean = if rise == 0.0 { 1.0 } else { -(-rise).exp_m1() / rise };
        self.extinction * range * (-start.min(end)).exp() * mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weather::Fog;

    /// A direction of which `up` is the sine of the elevation.
    fn rising(up: f32) -> Vec3 {
        Vec3::new(0.0, (1.0 - up * up).max(0.0).sqrt(), up)
    }

    #[test]
    fn contrast_at_the_visibility_range_is_five_percent() {
        let air = Atmosphere::new(12_000.0, 300.0);
        let contrast =
            (air.haze(Vec3::ZERO, 300.0, rising(0.0), 12_000.0).x - HAZE_COLOUR.x) / -HAZE_COLOUR.x;
        assert!((contrast - 0.05).abs() < 1e-6);
    }

    #[test]
    fn far_ground_meets_the_sky_without_an_edge() {
        let air = Atmosphere::new(1000.0, 0.0);
        assert!((air.haze(Vec3::ONE, 0.0, rising(0.0), 1.0e6) - air.sky(0.0, rising(0.0))).length() < 1e-6);
    }

    #[test]
    fn dense_haze_hides_the_sky_behind_mountains_but_not_from_above_it() {
        let (clear, dense) = (Atmosphere::new(40_000.0, 0.0), Atmosphere::new(1500.0, 0.0));
        let mountain = dense.haze(Vec3::ZERO, 10.0, rising(0.1), 5000.0);
        assert!((dense.sky(10.0, rising(0.1)) - mountain).abs().max_element() < 0.01);
        assert!((dense.sky(20_000.0, rising(0.5)) - clear.sky(20_000.0, rising(0.5))).length() < 1e-3);
        assert_eq!(clear.sky(10.0, rising(0.0)), HORIZON);
        assert_eq!(clear.sky(10.0, rising(1.0)), Atmosphere::new(f64::INFINITY, 0.0).sky(10.0, rising(1.0)));
    }

    #[test]
    fn beyond_reach_no_ground_differs_from_the_haze() {
        let air = Atmosphere::new(20_000.0, 100.0);
        for (eye, highest) in [(150.0, 100.0), (3000.0, 100.0), (500.0, 2500.0), (12_000.0, 4000.0)] {
            let reach = air.reach(eye, highest);
            for ground in [100.0, 0.5 * (100.0 + highest), highest] {
                let up = ((ground - eye) / reach) as f32;
                let left = air.haze(Vec3::ONE, eye, rising(up), reach as f32) - HAZE_COLOUR;
                assert!(
                    left.length() < 1.2e-3 * (Vec3::ONE - HAZE_COLOUR).length(),
                    "{eye} {ground}: {left}"
                );
            }
            assert!(reach > 40_000.0 && reach < 2.0e6, "{reach}");
        }
        assert_eq!(Atmosphere::new(f64::INFINITY, 0.0).reach(100.0, 50.0), f64::INFINITY);
    }

    #[test]
    fn unlimited_visibility_changes_nothing() {
        assert_eq!(
            Atmosphere::new(f64::INFINITY, 0.0).haze(Vec3::ONE, 500.0, rising(-0.1), 1.0e6),
            Vec3::ONE
        );
    }

    #[test]
    fn from_space_the_haze_is_a_thin_layer() {
        let air = Atmosphere::new(40_000.0, -10_000.0);
        let depth = air.optical_depth(2.5e6, -1.0, 2.51e6);
        assert!((depth / (air.extinction * SCALE_HEIGHT) - 1.0).abs() < 1e-3, "{depth}");
    }

    #[test]
    fn depth_agrees_with_numerical_integration() {
        let air = Atmosphere::new(20_000.0, 100.0);
        for (eye, up, range) in [(150.0, 0.0, 9_000.0), (3000.0, -0.4, 6_000.0), (200.0, 0.3, 40_000.0)] {
            let steps = 100_000;
            let sum: f64 = (0..steps)
                .map(|step| {
                    let distance = f64::from(range) * (f64::from(step) + 0.5) / f64::from(steps);
                    let height = eye + f64::from(up) * distance - 100.0;
                    (-height / f64::from(SCALE_HEIGHT)).exp()
                })
                .sum();
            let expected = f64::from(air.extinction) * sum * f64::from(range) / f64::from(steps);
            let depth = f64::from(air.optical_depth(eye, up, range));
            assert!((depth / expected - 1.0).abs() < 1e-4, "{depth} {expected}");
        }
    }

    /// Linear light as 8-bit sRGB codes, not rounded.
    fn codes(light: Vec3) -> Vec3 {
        light.map(|light| 255.0 * (1.055 * light.clamp(0.0, 1.0).powf(1.0 / 2.4) - 0.055))
    }

    fn weather(glow: f64, visibility: f64) -> Weather {
        Weather { glow, fog: Some(Fog { top: 400.0, visibility, soft: 20.0 }), ..Weather::default() }
    }

    const SUN: Sun = Sun { azimuth: 30.0, elevation: 8.0 };

    #[test]
    fn at_the_visibility_inside_fog_a_contrast_of_five_percent_is_left() {
        for (visibility, haze) in [(200.0, 40_000.0), (800.0, 3000.0)] {
            let air = Atmosphere::new(haze, 100.0).with_weather(&weather(1.0, visibility), SUN);
            let seen = |light| air.haze(light, 110.0, rising(0.0), visibility as f32);
            let contrast = (seen(Vec3::ONE) - seen(Vec3::ZERO)).x;
            assert!((contrast / 0.05 - 1.0).abs() < 0.02, "{visibility}: {contrast}");
        }
    }

    #[test]
    fn far_ground_meets_the_sky_from_inside_of_fog_from_above_it_and_in_haze() {
        let fogs = [None, Some(150.0), Some(2000.0)];
        for (fog, eye) in fogs.into_iter().flat_map(|fog| [120.0, 395.0, 420.0, 1500.0].map(|eye| (fog, eye)))
        {
            let weather = fog.map_or(Weather { glow: 1.0, ..Weather::default() }, |fog| weather(1.0, fog));
            let air = Atmosphere::new(15_000.0, 100.0).with_weather(&weather, SUN);
            for azimuth in [0.0_f32, 0.5, 2.0, 4.0] {
                let toward = |up: f32| {
                    let level = (1.0 - up * up).sqrt();
                    Vec3::new(azimuth.sin() * level, azimuth.cos() * level, up)
                };
                // A tenth of a pixel of a common view below the horizon and above it.
                let up = 5.0e-5;
                let ground = air.haze(Vec3::ZERO, eye, toward(-up), ((eye - 100.0) as f32 / up).max(2.0e5));
                let sky = [air.sky(eye, toward(up)), air.sky(eye, toward(-up))];
                for sky in sky {
                    let step = (codes(ground) - codes(sky)).abs().max_element();
                    assert!(step <= 2.0, "fog {fog:?}, eye {eye}, azimuth {azimuth}: {step}");
                }
            }
        }
    }

    #[test]
    fn fog_is_bright_from_above_and_hides_what_is_under_it() {
        let air = Atmosphere::new(40_000.0, 100.0).with_weather(&weather(0.0, 150.0), SUN);
        let [black, white] =
            [Vec3::ZERO, Vec3::ONE].map(|light| air.haze(light, 900.0, rising(-0.5), 1500.0));
        assert!((black - white).length() < 0.01 && black.min_element() > 0.75, "{black} {white}");
        // A summit above the fog is as it is in haze.
        let haze = Atmosphere::new(40_000.0, 100.0);
        let summit = |air: &Atmosphere| air.haze(Vec3::ONE, 900.0, rising(-0.1), 3000.0);
        assert!((summit(&air) - summit(&haze)).length() < 1e-5);
    }

    #[test]
    fn the_air_is_warmer_towards_the_sun_and_no_other_away_from_it() {
        let [plain, glowing] = [0.0, 1.0].map(|glow| {
            Atmosphere::new(20_000.0, 0.0).with_weather(&Weather { glow, ..Weather::default() }, SUN)
        });
        let toward = SUN.direction().with_z(0.0).normalize();
        let [before, after] = [plain, glowing].map(|air| air.sky(10.0, toward));
        assert!(after.x > before.x + 0.2 && after.z < before.z, "{before} {after}");
        let away = [plain, glowing].map(|air| codes(air.sky(10.0, -toward)));
        assert!((away[0] - away[1]).abs().max_element() < 1.0, "{away:?}");
        assert_eq!(plain, Atmosphere::new(20_000.0, 0.0));
    }
}
