//! Tones of faces: flat, by gradients of tones at corners, and by curvature (§3.2).

use glam::{DVec2, DVec3};

/// Tone by the angle between light and surface: halfway between dark and bright where light grazes (half-Lambert).
///
/// The report prints tones, not the law; this one gives all that it prints of faces and ridges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToneLaw {
    /// Tone of what faces away from the light.
    pub dark: f64,
    /// Tone of what faces the light.
    pub bright: f64,
    /// Direction in which light travels, of unit length.
    pub light: DVec3,
}

/// A triangle of the screen with a tone at each corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadedTriangle {
    /// Corners, pixels.
    pub corners: [DVec2; 3],
    /// Tone at each.
    pub tones: [f64; 3],
}

/// Normal of a corner that several faces share: the mean of their normals, of unit length; zero if they cancel.
pub fn vertex_normal(faces: &[DVec3]) -> DVec3 {
    faces.iter().map(|normal| normal.normalize_or_zero()).sum::<DVec3>().normalize_or_zero()
}

impl ToneLaw {
    /// Returns the tone of a surface with that normal, of any length: dark + (bright − dark)·(1 − L·n)/2.
    pub fn tone(&self, normal: DVec3) -> f64 {
        let against = 1.0 - self.light.dot(normal.normalize_or_zero());
        self.dark + (self.bright - self.dark) * 0.5 * against
    }

    /// Shades a triangle by its face alone.
    pub fn flat(&self, corners: [DVec2; 3], normal: DVec3) -> ShadedTriangle {
        ShadedTriangle { corners, tones: [self.tone(normal); 3] }
    }

    /// Shades a triangle by the normals of its corners, each the mean of the faces that share it.
    pub fn curved(&self, corners: [DVec2; 3], normals: [DVec3; 3]) -> ShadedTriangle {
        ShadedTriangle { corners, tones: normals.map(|normal| self.tone(normal)) }
    }
}

impl ShadedTriangle {
    /// Returns the tone at a place, linear over the screen; `None`: it lies outside, or the triangle has no area.
    pub fn tone(&self, at: DVec2) -> Option<f64> {
        let [a, b, c] = self.corners;
        let area = (b - a).perp_dot(c - a);
        let weights = [(c - b).perp_dot(at - b), (a - c).perp_dot(at - c), (b - a).perp_dot(at - a)];
        let weights = weights.map(|weight| weight / area);
        let is_inside = area != 0.0 && weights.iter().all(|weight| *weight >= -1e-12);
        is_inside.then(|| weights.into_iter().zip(self.tones).map(|(weight, tone)| weight * tone).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: ToneLaw = ToneLaw { dark: 0.0, bright: 150.0, light: DVec3::new(-0.4364, 0.2182, -0.8729) };

    /// Faces of a ridge with flanks of 45°: west, north, east, south.
    const FACES: [DVec3; 4] = [
        DVec3::new(-1.0, 0.0, 1.0),
        DVec3::new(0.0, 1.0, 1.0),
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::new(0.0, -1.0, 1.0),
    ];

    #[test]
    fn seven_tones_of_the_report_come_out() {
        let [west, north, east, south] = FACES;
        let ends = [vertex_normal(&[west, north, south]), vertex_normal(&[east, north, south])];
        let normals = [DVec3::Z, west, north, east, south, ends[0], ends[1]];
        let wanted = [140.0, 98.0, 110.0, 144.0, 133.0, 127.0, 147.0];
        for (normal, wanted) in normals.into_iter().zip(wanted) {
            let tone = LAW.tone(normal);
            assert!((tone - wanted).abs() <= 1.0, "{normal}: {tone}, not {wanted}");
        }
    }

    #[test]
    fn of_nine_suns_the_vertical_one_washes_out() {
        let spread = |light: DVec3| {
            let tones = FACES.map(|face| ToneLaw { light, ..LAW }.tone(face));
            (tones, tones.into_iter().fold(0.0, f64::max) - tones.into_iter().fold(150.0, f64::min))
        };
        for step in 0..8 {
            let towards = DVec2::from_angle(f64::from(step) * std::f64::consts::FRAC_PI_4);
            let light = |towards: DVec2| (towards * 0.5_f64.sqrt()).extend(-0.5_f64.sqrt());
            let (tones, range) = spread(light(towards));
            assert!(range > 50.0, "{step}: {tones:?}");
            // From the other side, opposite faces change places.
            let (other, _) = spread(light(-towards));
            for face in 0..4 {
                assert!((tones[face] - other[(face + 2) % 4]).abs() < 1e-12, "{tones:?} {other:?}");
            }
        }
        let (tones, range) = spread(DVec3::NEG_Z);
        assert!(range < 1e-12, "{tones:?}");
        assert!((tones[0] - 75.0 * (1.0 + 0.5_f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn curvature_is_smooth_over_edges_and_flat_shading_is_not() {
        // Two faces of a roof, which share the edge from a to b.
        let [a, b, c, d] = [[10.0, 0.0], [12.0, 40.0], [-20.0, 20.0], [45.0, 25.0]].map(DVec2::from_array);
        let [west, _, east, _] = FACES;
        let shared = vertex_normal(&[west, east]);
        let curved =
            [LAW.curved([a, b, c], [shared, shared, west]), LAW.curved([a, b, d], [shared, shared, east])];
        let flat = [LAW.flat([a, b, c], west), LAW.flat([a, b, d], east)];
        for part in [0.0, 0.3, 1.0] {
            let at = a.lerp(b, part);
            let of = |two: &[ShadedTriangle; 2]| two.map(|triangle| triangle.tone(at).unwrap());
            let [left, right] = of(&curved);
            assert!((left - right).abs() < 1e-9, "{left} {right}");
            let [left, right] = of(&flat);
            assert!((left - LAW.tone(west)).abs() < 1e-9 && (left - right).abs() > 40.0);
        }
        assert!((curved[0].tone(c).unwrap() - LAW.tone(west)).abs() < 1e-9);
        assert_eq!(curved[0].tone(d), None);
        assert_eq!(ShadedTriangle { corners: [a, a, b], tones: [1.0; 3] }.tone(a), None);
    }

    /// The fault that the report found: a long flat face of a ridge gets a gradient from the normals of its ends.
    #[test]
    fn curvature_shows_a_false_gradient_along_a_long_face() {
        let [west, north, east, south] = FACES;
        let ends = [[west, north, south], [east, north, south]].map(|faces| vertex_normal(&faces));
        let [left, right] = [DVec2::ZERO, DVec2::X * 100.0];
        let face = LAW.curved([left, right, DVec2::new(50.0, 30.0)], [ends[0], ends[1], south]);
        let along: Vec<f64> =
            (0..=10).map(|step| face.tone(left.lerp(right, f64::from(step) / 10.0)).unwrap()).collect();
        assert!(along.is_sorted() && along[10] - along[0] > 19.0, "{along:?}");
        let flat = LAW.flat(face.corners, south);
        assert_eq!(flat.tone(left), flat.tone(right));
    }

    #[test]
    fn a_wake_goes_from_white_to_blue_in_steps_that_nobody_sees() {
        let corners = [DVec2::ZERO, DVec2::new(300.0, 10.0), DVec2::new(300.0, -10.0)];
        let wake = ShadedTriangle { corners, tones: [255.0, 40.0, 40.0] };
        let tones: Vec<f64> = (0..=300).map(|x| wake.tone(DVec2::X * f64::from(x)).unwrap()).collect();
        assert!(tones.windows(2).all(|pair| (0.0..=2.0).contains(&(pair[0] - pair[1]))));
        assert!((tones[0] - 255.0).abs() < 1e-9 && (tones[300] - 40.0).abs() < 1e-9);
    }
}
