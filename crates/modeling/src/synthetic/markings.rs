//! Things made of circles on the ground: bomb circles, tyre marks, lakes.

use glam::DVec2;

use super::noise::{share, turned};
use super::patch::{EllipsePiece, PaintCoat};
use super::shapes::Circle;

/// Width of a tyre's mark, metres, and lengths of marks as parts of their zone.
const TYRE_M: f64 = 0.45;
const TYRE_LENGTHS: [f64; 2] = [0.1, 0.4];

/// Circles around the middle one of a lake, and their radii as parts of that of all.
const LOBES: u32 = 9;
const LOBE_RADII: [f64; 2] = [0.3, 0.5];

/// Concentric rings of equal width about a disc, the outermost first; colours in turn from there, at least one.
pub fn bomb_circle(circle: Circle, rings: u32, colours: &[[u8; 3]]) -> Vec<PaintCoat> {
    let disc = |ring: u32| {
        let radius = circle.radius_m * f64::from(rings - ring) / f64::from(rings);
        PaintCoat {
            pieces: vec![EllipsePiece::circle(circle.centre, radius)],
            colour: colours.get(ring as usize % colours.len().max(1)).copied(),
        }
    };
    (0..rings).map(disc).collect()
}

/// Zone in which tyres touch a runway.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchdownZone {
    /// Middle, metres.
    pub centre: DVec2,
    /// Direction of the runway, degrees clockwise from grid north.
    pub azimuth_deg: f64,
    /// Extent along the runway, metres, > 0.
    pub length_m: f64,
    /// Extent across it, metres, > 0.
    pub width_m: f64,
    /// Number of marks.
    pub count: u32,
    /// Seed that picks one zone among all alike.
    pub seed: u64,
}

impl TouchdownZone {
    /// Marks of tyres: thin ellipses along the runway, most of them near its middle line.
    pub fn marks(&self) -> Vec<EllipsePiece> {
        let forward = turned(self.azimuth_deg);
        let right = -forward.perp();
        let mark = |index: u32| {
            let part = |which: i64| share(i64::from(index), which, self.seed);
            let length = self.length_m * (TYRE_LENGTHS[0] + (TYRE_LENGTHS[1] - TYRE_LENGTHS[0]) * part(0));
            let along = (part(1) - 0.5) * (self.length_m - length);
            // Two of them make a triangle of chances.
            let aside = 0.5 * (part(2) - part(3)) * (self.width_m - TYRE_M).max(0.0);
            EllipsePiece {
                radii: 0.5 * DVec2::new(TYRE_M.min(self.width_m), length),
                azimuth_deg: self.azimuth_deg,
                ..EllipsePiece::circle(self.centre + forward * along + right * aside, 1.0)
            }
        };
        (0..self.count).map(mark).collect()
    }
}

/// Overlapping circles within one: a shore with bays, which leave the circle by up to so many radii, 0…½.
pub fn lake(circle: Circle, ragged: f64, seed: u64) -> Vec<EllipsePiece> {
    let Circle { centre, radius_m } = circle;
    let middle = EllipsePiece::circle(centre, radius_m * (1.0 - ragged));
    let lobe = |index: u32| {
        let part = |which: i64| share(i64::from(index), which, seed);
        let radius = radius_m * (LOBE_RADII[0] + (LOBE_RADII[1] - LOBE_RADII[0]) * part(0));
        let away = radius_m * (1.0 - ragged * part(1)) - radius;
        let azimuth_deg = 360.0 * (f64::from(index) + part(2)) / f64::from(LOBES);
        EllipsePiece::circle(centre + turned(azimuth_deg) * away, radius)
    };
    std::iter::once(middle).chain((0..LOBES).map(lobe)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CIRCLE: Circle = Circle { centre: DVec2::new(500.0, 700.0), radius_m: 100.0 };

    #[test]
    fn bomb_circles_are_discs_from_outside_in() {
        let coats = bomb_circle(CIRCLE, 4, &[[255; 3], [9, 9, 200]]);
        let seen: Vec<_> = coats.iter().map(|coat| (coat.pieces[0].radii.x, coat.colour)).collect();
        let [white, blue] = [Some([255; 3]), Some([9, 9, 200])];
        assert_eq!(seen, [(100.0, white), (75.0, blue), (50.0, white), (25.0, blue)]);
        assert!(coats.iter().all(|coat| coat.pieces.len() == 1 && coat.pieces[0].centre == CIRCLE.centre));
    }

    #[test]
    fn tyre_marks_keep_to_their_zone() {
        let zone = TouchdownZone {
            centre: CIRCLE.centre,
            azimuth_deg: 25.0,
            length_m: 600.0,
            width_m: 30.0,
            count: 200,
            seed: 3,
        };
        let marks = zone.marks();
        let (forward, mut middle) = (turned(25.0), 0);
        for mark in &marks {
            let offset = mark.centre - zone.centre;
            let (along, aside) = (offset.dot(forward).abs(), offset.perp_dot(forward).abs());
            assert!(along + mark.radii.y <= 300.0 + 1e-9 && aside + mark.radii.x <= 15.0 + 1e-9);
            middle += u32::from(aside < 7.5);
        }
        assert!((130..170).contains(&middle), "{middle}");
        assert_eq!(marks, zone.marks());
        assert_ne!(marks, TouchdownZone { seed: 4, ..zone }.marks());
    }

    #[test]
    fn lakes_fill_their_circle_without_leaving_it() {
        for ragged in [0.0, 0.2, 0.5] {
            let circles = lake(CIRCLE, ragged, 8);
            assert!(circles.len() == 10);
            for circle in &circles {
                let reach = (circle.centre - CIRCLE.centre).length() + circle.radii.x;
                assert!(reach <= 100.0 + 1e-9, "{reach}");
                // Each overlaps the middle one: the lake hangs together.
                let apart = (circle.centre - CIRCLE.centre).length();
                assert!(apart < circle.radii.x + circles[0].radii.x);
            }
        }
    }
}
