//! A layer of fog in closed form.
//!
//! Fog is equally dense up to its upper edge, over which it thins to nothing along a smooth step 3u² − 2u³. The fog above a
//! height then is a polynomial of fourth degree of that height, and what lies along a ray the difference of two of them over the
//! ray's rise: transmittance follows the law of Bouguer, Lambert and Beer exactly, from inside, from above and from below.

/// Share of the upper edge's depth by which a ray must rise for the difference to keep its digits; else its mean density is that of two places
/// (Gauss's, exact for a cubic, which the step is).
pub(crate) const SMALL_FOG_RISE: f32 = 0.1;

/// Shares of a ray's way at which these places are.
pub(crate) const GAUSS: [f32; 2] = [0.211_324_87, 0.788_675_1];

/// Fog below a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FogLayer {
    /// Extinction inside, 1/metres.
    pub extinction: f32,
    /// Height above which there is none, metres above the datum.
    pub ceiling: f64,
    /// Depth of the upper edge, metres.
    pub soft: f32,
}

impl FogLayer {
    /// Fog of which, where haze already has `haze` (1/metres), a contrast of 5 % is left at its visibility.
    pub fn new(fog: &super::Fog, haze: f32) -> Self {
        let extinction =
            (-crate::weather::fog::VANISHING_CONTRAST.ln() / fog.visibility as f32 - haze).max(0.0);
        Self { extinction, ceiling: fog.top + 0.5 * fog.soft, soft: fog.soft as f32 }
    }

    /// Returns how far a height (metres above the datum) lies below all that is clear, metres.
    pub fn below(&self, height: f64) -> f32 {
        (self.ceiling - height) as f32
    }

    /// Fog above what lies `below` the clear air, as metres of full density.
    pub fn column(&self, below: f32) -> f32 {
        let share = (below / self.soft).clamp(0.0, 1.0);
        let cube = share * share * share;
        (self.soft * cube).mul_add(1.0 - 0.5 * share, (below - self.soft).max(0.0))
    }

    /// Density there, 0…1.
    fn density(&self, below: f32) -> f32 {
        let share = (below / self.soft).clamp(0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    }

    /// Optical depth from what lies `below` the clear air along `range` metres on which a ray rises by `rise` metres.
    pub fn depth(&self, below: f32, rise: f32, range: f32) -> f32 {
        let mean = if rise.abs() < SMALL_FOG_RISE * self.soft {
            0.5 * GAUSS.map(|share| self.density(below - share * rise)).iter().sum::<f32>()
        } else {
            (self.column(below) - self.column(below - rise)) / rise
        };
        self.extinction * range * mean
    }

    /// Optical depth to the sky in a direction of which `up` is the sine of the elevation angle; infinite where fog never ends.
    pub fn depth_to_sky(&self, below: f32, up: f32) -> f32 {
        if up > 0.0 { self.extinction * self.column(below) / up } else { f32::INFINITY }
    }

    /// Range of clear air before the fog, metres: none from inside, and none before a ray that does not reach it ends, which is `range`
    /// metres away.
    pub fn before(&self, below: f32, up: f32, range: f32) -> f32 {
        if below >= 0.0 {
            0.0
        } else if up < 0.0 {
            (below / up).min(range)
        } else {
            range
        }
    }
}

/// Contrast at which an object is taken to vanish: meteorological optical range is defined by 5 %.
pub(crate) const VANISHING_CONTRAST: f32 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weather::Fog;

    fn layer(soft: f64) -> FogLayer {
        FogLayer::new(&Fog { top: 500.0, visibility: 300.0, soft }, 0.0)
    }

    #[test]
    fn depth_agrees_with_numerical_integration() {
        for soft in [1.0, 20.0, 300.0] {
            let fog = layer(soft);
            for (eye, rise, range) in [
                (450.0, 0.0, 800.0),
                (450.0, 90.0, 700.0),
                (900.0, -600.0, 5000.0),
                (505.0, -0.5, 4000.0),
                (505.0, 1.5, 4000.0),
                (499.0, -20.0, 300.0),
                (2000.0, -10.0, 900.0),
                (100.0, 1.0, 60.0),
            ] {
                let steps = 200_000;
                let sum: f64 = (0..steps)
                    .map(|step| {
                        let height = eye + rise * (f64::from(step) + 0.5) / f64::from(steps);
                        f64::from(fog.density(fog.below(height)))
                    })
                    .sum();
                let expected = f64::from(fog.extinction) * range * sum / f64::from(steps);
                let depth = f64::from(fog.depth(fog.below(eye), rise as f32, range as f32));
                let through = [depth, expected].map(|depth| (-depth).exp());
                assert!((through[0] - through[1]).abs() < 1e-3, "{soft} {eye} {rise}: {through:?}");
                assert!(
                    (depth - expected).abs() < 2e-3 * expected.max(0.1),
                    "{soft} {eye} {rise}: {depth} {expected}"
                );
            }
        }
    }

    #[test]
    fn haze_counts_towards_the_visibility_inside() {
        let haze = 0.002;
        let fog = FogLayer::new(&Fog { top: 500.0, visibility: 300.0, soft: 10.0 }, haze);
        let depth = fog.depth(fog.below(100.0), 0.0, 300.0) + 300.0 * haze;
        assert!(((-depth).exp() - 0.05).abs() < 1e-5);
        assert_eq!(FogLayer::new(&Fog { top: 5.0, visibility: 5000.0, soft: 10.0 }, haze).extinction, 0.0);
    }

    #[test]
    fn the_way_to_the_sky_is_that_to_a_far_end() {
        let fog = layer(40.0);
        for (eye, up) in [(450.0, 0.01), (500.0, 0.2), (519.0, 0.001), (530.0, 0.5)] {
            let below = fog.below(eye);
            let far = fog.depth(below, up * 1.0e5, 1.0e5);
            let sky = fog.depth_to_sky(below, up);
            assert!((far - sky).abs() < 1e-3 * sky.max(0.1), "{eye}: {far} {sky}");
        }
    }
}
