//! Axes of an eye, and the scan lines before it.

use glam::{DVec2, DVec3};

/// Eye with axes u along the boresight, v to the right and w up (§2.4.3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewFrame {
    /// Metres in the world.
    pub eye: DVec3,
    /// Unit vectors u, v and w in the world.
    axes: [DVec3; 3],
}

/// Scan lines and their elements; line 0 is the uppermost, element 0 the leftmost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster {
    /// Scan lines, > 0.
    pub lines: f64,
    /// Elements of a scan line, > 0.
    pub elements: f64,
    /// Angle from the upper to the lower side of the screen, radians, 0…π.
    pub vertical_fov: f64,
    /// Angle from the left to the right side, radians, 0…π.
    pub horizontal_fov: f64,
}

impl ViewFrame {
    /// An eye that looks along `boresight` (of any length but 0), with the z axis as far up as that allows.
    pub fn looking(eye: DVec3, boresight: DVec3) -> Self {
        let u = boresight.normalize();
        let v = u.cross(DVec3::Z).try_normalize().unwrap_or(DVec3::X);
        Self { eye, axes: [u, v, v.cross(u)] }
    }

    /// Turns a vector of the world into the eye's axes: x is along u, y along v, z along w.
    pub fn vector(&self, vector: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(vector)))
    }

    /// Returns the place of a point of the world in the eye's axes, metres.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.vector(point - self.eye)
    }
}

impl Raster {
    /// Lines and elements per unit of the tangents w/u and v/u; lines count downward, so that the first is negative.
    pub fn scale(&self) -> DVec2 {
        let of = |count: f64, angle: f64| 0.5 * count / (0.5 * angle).tan();
        DVec2::new(-of(self.lines, self.vertical_fov), of(self.elements, self.horizontal_fov))
    }

    /// Line and element of the boresight.
    pub fn centre(&self) -> DVec2 {
        0.5 * DVec2::new(self.lines, self.elements)
    }

    /// Returns line and element of a point in an eye's axes; what lies behind the eye is mirrored through it.
    pub fn project(&self, point: DVec3) -> DVec2 {
        self.centre() + self.scale() * DVec2::new(point.z, point.y) / point.x
    }
}
