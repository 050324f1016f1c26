//! Eye with six degrees of freedom, over flat ground.
//!
//! ```text
//! (u, v, w)ᵀ = A·(x − x₀, y − y₀, fall)ᵀ        A: direction cosines of heading, then pitch, then roll
//! u out through the middle of the screen, v along its lines, w down
//! place of a frame n = place + n·step·velocity
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), image pipeline; it does not give the
//! order of the angles.

/// Angles of an eye, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EyeAttitude {
    /// Clockwise from x toward y, seen from above.
    pub heading_deg: f64,
    /// Upward.
    pub pitch_deg: f64,
    /// Right side down.
    pub roll_deg: f64,
}

/// Place and attitude of an eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// Place over the ground, x and y, feet.
    pub place: [f64; 2],
    /// Height over the ground, feet.
    pub altitude: f64,
    /// Angles.
    pub attitude: EyeAttitude,
}

impl EyeAttitude {
    /// Unit vectors u, v and w, each along x, y and down: rows of A.
    pub fn axes(self) -> [[f64; 3]; 3] {
        let [(sin_h, cos_h), (sin_p, cos_p), (sin_r, cos_r)] =
            [self.heading_deg, self.pitch_deg, self.roll_deg].map(|angle| angle.to_radians().sin_cos());
        [
            [cos_p * cos_h, cos_p * sin_h, -sin_p],
            [sin_r * sin_p * cos_h - cos_r * sin_h, sin_r * sin_p * sin_h + cos_r * cos_h, sin_r * cos_p],
            [cos_r * sin_p * cos_h + sin_r * sin_h, cos_r * sin_p * sin_h - sin_r * cos_h, cos_r * cos_p],
        ]
    }
}

impl Eye {
    /// The eye after a time in seconds at a velocity along x, y and up, feet a second.
    #[must_use]
    pub fn moved(self, velocity: [f64; 3], time: f64) -> Self {
        Self {
            place: [0, 1].map(|axis| self.place[axis] + velocity[axis] * time),
            altitude: self.altitude + velocity[2] * time,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_square_to_each_other_and_turn_as_an_aircraft() {
        let attitude = EyeAttitude { heading_deg: 37.0, pitch_deg: -12.0, roll_deg: 55.0 };
        let axes = attitude.axes();
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (number, axis) in axes.into_iter().enumerate() {
            for (other, second) in axes.into_iter().enumerate() {
                assert!((dot(axis, second) - f64::from(u8::from(number == other))).abs() < 1e-12);
            }
        }

        // Level: ahead, right, down. Pitched up: the boresight rises. Banked to the right: the right wing falls.
        assert_eq!(EyeAttitude::default().axes(), [[1.0, 0.0, -0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert!(EyeAttitude { pitch_deg: 10.0, ..EyeAttitude::default() }.axes()[0][2] < 0.0);
        assert!(EyeAttitude { roll_deg: 10.0, ..EyeAttitude::default() }.axes()[1][2] > 0.0);
        assert!(EyeAttitude { heading_deg: 10.0, ..EyeAttitude::default() }.axes()[0][1] > 0.0);
    }
}
