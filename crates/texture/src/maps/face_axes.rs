//! Coordinates on faces that are not ground, so that maps lie on them without stretching.
//!
//! ```text
//! along = level direction of the face, up = direction of steepest rise, both of unit length
//! place on the face = ((p − origin)·along, (p − origin)·up)            flat faces: x and y
//! ```
//!
//! Bunker and Ferris 1977 (AFHRL-TR-77-66) recommend texture on faces of any orientation, by functions that
//! are linear over a face; which is ours.

/// Axes on a face that is fixed to an object or the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceAxes {
    origin: [f64; 3],
    along: [f64; 3],
    up: [f64; 3],
}

impl FaceAxes {
    /// Axes of a face through an origin with a normal of any length but 0.
    pub fn new(origin: [f64; 3], normal: [f64; 3]) -> Self {
        let [x, y, z] = normal;
        let level = x.hypot(y);
        if level <= 1e-9 * z.abs() {
            return Self { origin, along: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] };
        }
        let (along, length) = ([-y / level, x / level, 0.0], level.hypot(z));
        // Normal × along.
        let up = [-z * along[1], z * along[0], level].map(|part| part / length);
        Self { origin, along, up }
    }

    /// Place on the face of a point of space.
    pub fn place(&self, point: [f64; 3]) -> [f64; 2] {
        let along = |axis: [f64; 3]| (0..3).map(|part| (point[part] - self.origin[part]) * axis[part]).sum();
        [along(self.along), along(self.up)]
    }

    /// Point of space at a place on the face.
    pub fn point(&self, [along, up]: [f64; 2]) -> [f64; 3] {
        std::array::from_fn(|part| self.origin[part] + along * self.along[part] + up * self.up[part])
    }
}

#[cfg(test)]
mod tests {
    use super::super::six::SixMaps;
    use super::*;

    /// Sides of a ridge, a wall and flat ground.
    const NORMALS: [[f64; 3]; 5] =
        [[0.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [1.0, 0.3, 2.0], [0.0, 1.0, 0.0], [3.0, -4.0, 1e-3]];

    const ORIGIN: [f64; 3] = [300.0, -70.0, 15.0];

    /// Where a ray from an eye through a point of the face meets it again.
    fn seen(axes: &FaceAxes, normal: [f64; 3], eye: [f64; 3], place: [f64; 2]) -> [f64; 3] {
        let point = axes.point(place);
        let ray: [f64; 3] = std::array::from_fn(|part| (point[part] - eye[part]) * 0.37);
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|part| a[part] * b[part]).sum::<f64>();
        let offset: [f64; 3] = std::array::from_fn(|part| ORIGIN[part] - eye[part]);
        let at = dot(normal, offset) / dot(normal, ray);
        std::array::from_fn(|part| eye[part] + at * ray[part])
    }

    #[test]
    fn texture_stays_on_a_face_from_any_eye() {
        let maps = SixMaps::new(2.0, 8, 26);
        for normal in NORMALS {
            let axes = FaceAxes::new(ORIGIN, normal);
            for number in 0..200 {
                // In the middles of zones of no map: places where rounding moves nothing over a border.
                let place = [f64::from(number) * 1.71 - 150.0, f64::from(number % 37) * 2.03];
                let tone = |eye| {
                    let [along, up] = axes.place(seen(&axes, normal, eye, place));
                    assert!((along - place[0]).abs() < 1e-6 && (up - place[1]).abs() < 1e-6);
                    maps.tone((along * 1e4).round() / 1e4, (up * 1e4).round() / 1e4, 1)
                };
                let eyes = [[-800.0, 900.0, 700.0], [-790.0, 905.0, 698.0], [250.0, 1200.0, 90.0]];
                let tones = eyes.map(tone);
                assert!(tones[1..].iter().all(|&other| other == tones[0]), "{normal:?}: {tones:?}");
            }
        }
    }

    #[test]
    fn faces_vary_as_much_as_ground_per_metre_in_every_direction() {
        let maps = SixMaps::new(2.0, 8, 27);
        // Mean square change over a metre of the face, along a direction.
        let change = |normal: [f64; 3], direction: [f64; 2]| {
            let axes = FaceAxes::new(ORIGIN, normal);
            let sum: f64 = (0..6000)
                .map(|number| {
                    let place = [f64::from(number) * 1.37, f64::from(number * 31 % 6000) * 0.77];
                    let moved = [place[0] + direction[0], place[1] + direction[1]];
                    let [a, b] = [place, moved].map(|place| axes.place(axes.point(place)));
                    (maps.tone(a[0], a[1], 1) - maps.tone(b[0], b[1], 1)).powi(2)
                })
                .sum();
            sum / 6000.0
        };
        for direction in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]] {
            let ground = change(NORMALS[0], direction);
            for normal in NORMALS {
                let share = change(normal, direction) / ground;
                assert!((share - 1.0).abs() < 0.02, "{share} on {normal:?}");
            }
            // Seen from above, a wall is a line: its texture would be curtains.
            let wall = FaceAxes::new(ORIGIN, NORMALS[3]);
            let [low, high] = [[5.0, 0.0], [5.0, 40.0]].map(|place| wall.point(place));
            assert_eq!(maps.tone(low[0], low[1], 1), maps.tone(high[0], high[1], 1));
        }
    }
}
