//! Surface-tone contours: tones of a shape painted on level ground for one eye (§3.1).

use glam::{DVec2, DVec3};

/// Faces of a shape as one eye sees them, painted on level ground at height 0.
///
/// From that eye they cannot be told from the shape; from any other they are paint, and never rise above the horizon.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceTone {
    /// Corners on the ground, in order around each face.
    faces: Vec<PaintedFace>,
    ground: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct PaintedFace {
    corners: Vec<DVec2>,
    tone: f64,
}

impl SurfaceTone {
    /// Ground of one tone.
    pub fn new(ground: f64) -> Self {
        Self { faces: Vec::new(), ground }
    }

    /// Paints a convex face (corners in metres, in order around it) where `eye` sees it; later ones lie over earlier ones. False: a corner is not below the eye, so that none
    /// of the ground can show it, and nothing was painted.
    pub fn paint(&mut self, eye: DVec3, corners: &[DVec3], tone: f64) -> bool {
        let on_ground = |corner: &DVec3| {
            let fall = eye.z - corner.z;
            (fall > 0.0).then(|| (eye + (*corner - eye) * (eye.z / fall)).truncate())
        };
        let Some(corners) = corners.iter().map(on_ground).collect() else { return false };
        self.faces.push(PaintedFace { corners, tone });
        true
    }

    /// Returns the tone at a place of the ground, metres.
    pub fn tone(&self, at: DVec2) -> f64 {
        self.faces.iter().rev().find(|face| face.holds(at)).map_or(self.ground, |face| face.tone)
    }
}

impl PaintedFace {
    fn holds(&self, at: DVec2) -> bool {
        let next = self.corners.iter().cycle().skip(1);
        let mut sides = self.corners.iter().zip(next).map(|(from, to)| (*to - *from).perp_dot(at - *from));
        let first = sides.next().unwrap_or(0.0);
        sides.all(|side| side * first >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ToneLaw;

    const LAW: ToneLaw = ToneLaw { dark: 0.0, bright: 150.0, light: DVec3::new(-0.4364, 0.2182, -0.8729) };

    /// A ridge 200 ft wide and 100 ft high, 600 ft long.
    fn faces() -> Vec<Vec<DVec3>> {
        let [sw, se, ne, nw] = [[-100.0, -300.0], [100.0, -300.0], [100.0, 300.0], [-100.0, 300.0]]
            .map(|[x, y]| DVec3::new(x, y, 0.0));
        let [south, north] = [DVec3::new(0.0, -200.0, 100.0), DVec3::new(0.0, 200.0, 100.0)];
        vec![vec![sw, se, south], vec![se, ne, north, south], vec![ne, nw, north], vec![nw, sw, south, north]]
    }

    fn normal(face: &[DVec3]) -> DVec3 {
        (face[1] - face[0]).cross(face[2] - face[0]).normalize()
    }

    /// The tone of the modelled ridge on a ray from above.
    fn modelled(eye: DVec3, direction: DVec3) -> f64 {
        let mut nearest = (-eye.z / direction.z, LAW.tone(DVec3::Z));
        for face in faces() {
            let normal = normal(&face);
            let at = normal.dot(face[0] - eye) / normal.dot(direction);
            let point = eye + direction * at;
            let next = face.iter().cycle().skip(1);
            let is_inside =
                face.iter().zip(next).all(|(from, to)| (*to - *from).cross(point - *from).dot(normal) >= 0.0);
            if is_inside && at > 0.0 && at < nearest.0 {
                nearest = (at, LAW.tone(normal));
            }
        }
        nearest.1
    }

    #[test]
    fn paint_matches_the_ridge_for_its_eye_and_not_a_hundred_feet_beside() {
        let eye = DVec3::new(-320.0, -520.0, 350.0);
        let mut paint = SurfaceTone::new(LAW.tone(DVec3::Z));
        for face in faces().iter().filter(|face| normal(face).dot(eye - face[0]) > 0.0) {
            assert!(paint.paint(eye, face, LAW.tone(normal(face))));
        }

        let differing = |eye: DVec3| {
            let rays = (0..4000).map(|index| {
                let part = |step: f64| (f64::from(index) * step).fract();
                let target =
                    DVec3::new(400.0 * part(0.618_034) - 200.0, 700.0 * part(0.414_214) - 350.0, 30.0);
                (target - eye).normalize()
            });
            rays.filter(|direction| {
                let ground = eye - *direction * (eye.z / direction.z);
                (modelled(eye, *direction) - paint.tone(ground.truncate())).abs() > 2.0
            })
            .count()
        };
        // Rays that pass within rounding of an edge may fall to either side.
        assert!(differing(eye) <= 2, "{}", differing(eye));
        let beside = differing(eye - DVec3::X * 100.0);
        assert!(beside > 200, "{beside}");
    }

    #[test]
    fn nothing_is_painted_above_the_horizon() {
        let mut paint = SurfaceTone::new(1.0);
        assert!(!paint.paint(DVec3::Z * 90.0, &faces()[0], 2.0));
        assert_eq!(paint, SurfaceTone::new(1.0));
    }
}
