//! Shadows of spheres on level ground: one flat ellipse each.
//!
//! ```text
//! of a parallel light from elevation e:    middle = centre − light·(height/light_z), half axes R across and R/sin e along
//! ```
//!
//! Bunker and Ferris (AFHRL-TR-77-66, §2.5) lay an ellipse for each shadow; its size is that of the geometry.

use glam::DVec3;

use crate::{Ball, FlatEllipse};

impl Ball {
    /// Finds its shadow on level ground of a height, for a light that travels along a vector of any length; `None`: light does not come from above.
    pub fn shadow(&self, light: DVec3, ground: f64) -> Option<FlatEllipse> {
        let light = light.try_normalize().filter(|light| light.z < 0.0)?;
        let along = light.truncate().try_normalize().unwrap_or(glam::DVec2::X);
        Some(FlatEllipse {
            centre: self.centre + light * ((self.centre.z - ground) / -light.z),
            axes: [(along * (self.radius / -light.z)).extend(0.0), (along.perp() * self.radius).extend(0.0)],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadows_are_those_of_rays_to_the_light() {
        let ball = Ball { centre: DVec3::new(3.0, -7.0, 25.0), radius: 4.0 };
        for light in [DVec3::new(0.3, -0.8, -0.5), DVec3::new(0.0, 0.0, -2.0), DVec3::new(-5.0, 1.0, -1.0)] {
            let shadow = ball.shadow(light, 2.0).unwrap();
            let [long, short] = shadow.axes;
            let (mut sum, mut count) = (DVec3::ZERO, 0);
            for number in 0..400 * 400 {
                let share = |place: i32| (f64::from(place) + 0.5) / 200.0 - 1.0;
                let (a, b) = (1.2 * share(number % 400), 1.2 * share(number / 400));
                let at = shadow.centre + long * a + short * b;
                let missed = light.normalize().cross(ball.centre - at).length();
                // Within a thousandth of the rim either may be right.
                if (a.hypot(b) - 1.0).abs() > 1e-3 {
                    assert_eq!(missed < ball.radius, a.hypot(b) < 1.0, "{light}: {a} {b}");
                }
                if missed < ball.radius {
                    (sum, count) = (sum + at, count + 1);
                }
            }
            assert!((sum / f64::from(count) - shadow.centre).length() < 1e-9 * 400.0);
            assert_eq!(shadow.centre.z, 2.0);
        }
        assert_eq!(ball.shadow(DVec3::Z, 0.0), None);
    }
}
