//! Heights from shadows that somebody measured: Z = L·tan A (Hughes 1994, shadows), on ground that is not level, too.
//!
//! ```text
//! the corner p that lies farthest from the sun throws the tip of the shadow, L metres behind it
//! z = ground(p − L·sun) + L·tan A − base         base: the lowest ground along the outline
//! ```
//! From the tip's place itself L and p follow: its ray towards the sun enters the outline there.

use glam::{DVec2, dvec2};

use super::site::Site;

/// Metres that a tip may lie beside the outline's shadow, and the share of the shadow's length.
const BESIDE: f64 = 3.0;
const BESIDE_SHARE: f64 = 0.1;

impl Site<'_> {
    /// The corner that lies farthest from the sun, turned.
    fn corner(&self) -> Option<DVec2> {
        self.rings.iter().flatten().copied().min_by(|a, b| a.x.total_cmp(&b.x))
    }

    /// Height of the roof above the ground, metres, by the length of its shadow, metres; `None` where the tip has no ground.
    pub fn height_of_length(&self, length: f64) -> Option<f64> {
        let ground = self.ground.height_at(self.corner()? - dvec2(length, 0.0))?;
        Some(ground - self.base + length * self.sun.rise)
    }

    /// Length of the shadow of a roof, metres: where the ray past the corner first meets the ground, or would on level ground if that is not known.
    pub fn length_of_height(&self, height: f64) -> f64 {
        let level = height / self.sun.rise;
        /// Steps of the level length.
        const STEPS: f64 = 256.0;
        let mut before = 0.0;
        for step in 1..=2 * STEPS as u32 {
            let length = level * f64::from(step) / STEPS;
            let Some(reached) = self.height_of_length(length) else { return level };
            if reached >= height {
                return self.halved(height, before, length);
            }
            before = length;
        }
        level
    }

    /// Halves two lengths until the height is reached between them.
    fn halved(&self, height: f64, mut low: f64, mut high: f64) -> f64 {
        /// Halvings from a 256th of a length to millimetres and below.
        const HALVINGS: u32 = 32;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.height_of_length(middle).is_some_and(|reached| reached >= height) {
                high = middle;
            } else {
                low = middle;
            }
        }
        0.5 * (low + high)
    }

    /// Height of the roof above the ground and length of its shadow, metres, by the place of the shadow's tip, turned; else why there is none.
    pub fn height_of_tip(&self, tip: DVec2) -> Result<(f64, f64), &'static str> {
        let edges = || self.rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let crossing = |(a, b): (&DVec2, &DVec2)| {
            let ahead = a.x + (tip.y - a.y) / (b.y - a.y) * (b.x - a.x) - tip.x;
            ((a.y > tip.y) != (b.y > tip.y) && ahead > 0.0).then_some(ahead)
        };
        if edges().filter_map(crossing).count() % 2 == 1 {
            return Err("its shadow_tip lies on it");
        }

        let entered = edges().filter_map(crossing).reduce(f64::min);
        // A tip that is a little beside is that of the corner nearest to its ray.
        let beside = || {
            let corners = self.rings.iter().flatten().filter(|corner| corner.x > tip.x);
            let nearest = corners.min_by(|a, b| (a.y - tip.y).abs().total_cmp(&(b.y - tip.y).abs()))?;
            let length = nearest.x - tip.x;
            ((nearest.y - tip.y).abs() <= BESIDE.max(BESIDE_SHARE * length)).then_some(length)
        };
        let length =
            entered.or_else(beside).ok_or("its shadow_tip does not lie behind it as seen from the sun")?;
        let ground = self.ground.height_at(tip).ok_or("there is no elevation at its shadow_tip")?;

        Ok((ground - self.base + length * self.sun.rise, length))
    }
}
