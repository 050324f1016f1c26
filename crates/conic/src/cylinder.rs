//! Upright cylinders: two discs, and between them one face with four edges that is found anew for each eye.
//!
//! ```text
//! the two generators along which the eye's upright planes touch bound the face
//! eye above the top: the upper disc has the colour of tops; below it, that of sides
//! ```
//!
//! Source: Bunker and Ferris (AFHRL-TR-77-66), §2.5, tanks.

use glam::{DVec2, DVec3};

use crate::FlatEllipse;

/// An upright cylinder, such as a tank or a tower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Middle of its lower disc, metres.
    pub foot: DVec3,
    /// Metres, > 0.
    pub radius: f64,
    /// Metres, > 0.
    pub height: f64,
}

/// Colour that a part of a cylinder has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CylinderColour {
    /// Colour of its top.
    Top,
    /// Colour of its side.
    Side,
}

impl Cylinder {
    /// Lower and upper disc.
    pub fn discs(&self) -> [FlatEllipse; 2] {
        [0.0, self.height].map(|up| FlatEllipse {
            centre: self.foot + DVec3::Z * up,
            axes: [DVec3::X * self.radius, DVec3::Y * self.radius],
        })
    }

    /// Colour of the upper disc as an eye sees it, metres.
    pub fn upper_colour(&self, eye: DVec3) -> CylinderColour {
        if eye.z > self.foot.z + self.height { CylinderColour::Top } else { CylinderColour::Side }
    }

    /// Finds the corners of the face between the discs, around it from the lower left one; `None`: the eye is over or in it, and sees no side.
    pub fn silhouette_face(&self, eye: DVec3) -> Option<[DVec3; 4]> {
        let away = (eye - self.foot).truncate();
        let distance = away.length();
        if distance <= self.radius {
            return None;
        }
        // Where tangents from the eye touch the circle.
        let towards = away / distance;
        let cos = self.radius / distance;
        let sin = (1.0 - cos * cos).sqrt();
        let touch = |side: f64, up: f64| {
            let offset: DVec2 = (towards * cos + towards.perp() * (side * sin)) * self.radius;
            self.foot + offset.extend(up)
        };
        Some([touch(-1.0, 0.0), touch(1.0, 0.0), touch(1.0, self.height), touch(-1.0, self.height)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CellOverlap, ImageConic, ImagePoint, Raster, ViewFrame, clipped_area};

    const TANK: Cylinder = Cylinder { foot: DVec3::new(60.0, 8.0, 0.0), radius: 9.0, height: 14.0 };
    const RASTER: Raster = Raster { lines: 96.0, elements: 128.0, vertical_fov: 0.8, horizontal_fov: 1.03 };

    #[test]
    fn the_upper_disc_changes_its_colour_where_the_eye_passes_its_plane() {
        let colour = |up: f64| TANK.upper_colour(DVec3::new(-20.0, 0.0, up));
        assert_eq!(colour(14.0 + 1e-9), CylinderColour::Top);
        assert_eq!([13.999, 14.0, 0.0, -5.0].map(colour), [CylinderColour::Side; 4]);

        // There its image is a line, so that nothing is seen to change.
        let frame = ViewFrame::looking(DVec3::new(-20.0, 0.0, 14.0), DVec3::X);
        let [_, upper] = TANK.discs();
        let rim = (0..60).map(|step| RASTER.project(upper.seen(&frame).point(f64::from(step))));
        assert!(rim.into_iter().all(|at| (at.x - 48.0).abs() < 1e-9));
    }

    #[test]
    fn edges_of_the_face_touch_both_discs() {
        for eye in [DVec3::new(-20.0, 0.0, 9.0), DVec3::new(75.0, -30.0, 40.0), DVec3::new(62.0, 20.0, -3.0)]
        {
            let face = TANK.silhouette_face(eye).unwrap();
            for corner in face {
                let out = (corner - TANK.foot).truncate();
                assert!((out.length() - TANK.radius).abs() < 1e-9);
                assert!(out.dot((corner - eye).truncate()).abs() < 1e-9, "a tangent is square to its radius");
            }
            assert_eq!([face[0].z, face[3].z], [0.0, 14.0]);
        }
        assert_eq!(TANK.silhouette_face(DVec3::new(62.0, 9.0, 90.0)), None);
    }

    /// Whether a ray meets the solid, in closed form.
    fn meets(eye: DVec3, ray: DVec3) -> bool {
        let (flat, from) = (ray.truncate(), (eye - TANK.foot).truncate());
        let (a, b, c) = (flat.dot(flat), from.dot(flat), from.dot(from) - TANK.radius.powi(2));
        let square = b * b - a * c;
        if square <= 0.0 {
            return false;
        }
        let root = square.sqrt();
        let mut part = [(-b - root) / a, (-b + root) / a];
        let ends = [0.0, TANK.height].map(|up| (up + TANK.foot.z - eye.z) / ray.z);
        part = [part[0].max(ends[0].min(ends[1])), part[1].min(ends[0].max(ends[1]))];
        part[0] < part[1] && part[1] > 0.0
    }

    #[test]
    fn discs_and_face_cover_what_rays_meet() {
        for eye in [DVec3::new(-20.0, 0.0, 9.0), DVec3::new(0.0, 30.0, 45.0), DVec3::new(10.0, -25.0, 0.7)] {
            let frame = ViewFrame::looking(eye, TANK.foot + DVec3::Z * 7.0 - eye);
            let discs = TANK.discs().map(|disc| {
                CellOverlap::of(&ImageConic::of(&disc.seen(&frame), &RASTER)).expect("an ellipse")
            });
            let face = TANK.silhouette_face(eye).unwrap().map(|corner| RASTER.project(frame.point(corner)));
            let mut covered = 0;
            for number in 0..96 * 128 {
                let (line, element) = (f64::from(number / 128), f64::from(number % 128));
                let low = DVec2::new(line, element);
                let shares = discs.map(|disc| disc.pixel(ImagePoint { line, element }));
                let parts = [shares[0], shares[1], clipped_area(&face, low, low + 1.0)];
                let most = parts.iter().copied().fold(0.0, f64::max);
                let sum: f64 = parts.iter().sum();
                // Pixels that are wholly in one part, or in none.
                if sum > 1e-9 && most < 1.0 - 1e-9 {
                    continue;
                }
                let at = (low + 0.5 - RASTER.centre()) / RASTER.scale();
                let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| frame.vector(axis));
                let own = DVec3::new(1.0, at.y, at.x);
                let ray = DVec3::from_array(axes.map(|axis| axis.dot(own)));
                assert_eq!(most > 0.5, meets(eye, ray), "{eye}: line {line}, element {element}");
                covered += u32::from(most > 0.5);
            }
            assert!(covered > 400, "{covered}");
        }
    }
}
