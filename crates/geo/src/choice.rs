//! Choice of a metric system for an area: the one that distorts its distances least.
//!
//! ```text
//! utm   = the zone of the centre      error (cos φ · Δλ)²/2 at the farthest longitude, least |latitude|
//! ups   = EPSG:32661 or 32761         error |k − 1| at the ends of the latitudes
//! polar = EPSG:3995 or 3031           likewise (true at 71°)
//! world = EPSG:4087                   error 1/cos φ − 1 at the greatest |latitude|, east–west only
//! utm where its error is ≤ 1.25 % and the centre lies in its latitudes, else the least
//! ```
//!
//! Scales after Snyder, *Map Projections – A Working Manual* (1987), eq. 8-4 (spherical), 12-4 and 21-4, on the sphere.
//! 1.25 % is what 9° of longitude from the central meridian cost at the equator, so that 18° centred on a zone stay UTM.
//! Height does not matter by itself: a transverse Mercator map is as good 60° along its meridian as at the equator.

/// Largest distance error that is taken without looking for better.
const GOOD: f64 = 0.0125;

/// Farthest that transverse Mercator is used from its meridian, degrees of longitude.
const UTM_REACH: f64 = 45.0;

/// UTM's latitudes, degrees.
const UTM_LATITUDES: std::ops::RangeInclusive<f64> = -80.0..=84.0;

/// World Equidistant Cylindrical, WGS 84.
const WORLD: u32 = 4087;

/// EPSG code for the area (west, south, east, north in degrees).
pub(super) fn metric_code([west, south, east, north]: [f64; 4]) -> u32 {
    if ![west, south, east, north].iter().all(|degrees| degrees.is_finite()) {
        return WORLD;
    }

    let (south, north) = (south.min(north).clamp(-90.0, 90.0), south.max(north).clamp(-90.0, 90.0));
    let east = if east < west { east + 360.0 } else { east };
    let (longitude, latitude) = (west.midpoint(east), south.midpoint(north));
    let utm = Utm::of(longitude, latitude);
    let utm_error = utm.error([west, south, east, north]);
    let mut best = (WORLD, world_error(south, north));
    if UTM_LATITUDES.contains(&latitude) {
        if utm_error <= GOOD {
            return utm.code();
        }
        if utm_error < best.1 {
            best = (utm.code(), utm_error);
        }
    }

    for (code, at_pole, true_latitude) in polar_systems(latitude) {
        let error = polar_error(at_pole, true_latitude, latitude.signum(), south, north);
        if error < best.1 {
            best = (code, error);
        }
    }

    best.0
}

struct Utm {
    zone: u32,
    north: bool,
}

impl Utm {
    fn of(longitude: f64, latitude: f64) -> Self {
        let wrapped = (longitude + 180.0).rem_euclid(360.0);
        // The cast saturates, and the zone is between 1 and 60 by the line above.
        Self { zone: ((wrapped / 6.0) as u32).min(59) + 1, north: latitude >= 0.0 }
    }

    fn code(&self) -> u32 {
        if self.north { 32_600 + self.zone } else { 32_700 + self.zone }
    }

    fn error(&self, [west, south, east, north]: [f64; 4]) -> f64 {
        let meridian = 6.0 * f64::from(self.zone) - 183.0;
        let turn = ((west.midpoint(east) - meridian) / 360.0).round() * 360.0;
        let reach = (west - turn - meridian).abs().max((east - turn - meridian).abs());
        let nearest = if south <= 0.0 && north >= 0.0 { 0.0 } else { south.abs().min(north.abs()) };
        if reach > UTM_REACH {
            return f64::INFINITY;
        }
        (nearest.to_radians().cos() * reach.to_radians()).powi(2) / 2.0
    }
}

fn world_error(south: f64, north: f64) -> f64 {
    let greatest = south.abs().max(north.abs());
    1.0 / greatest.to_radians().cos() - 1.0
}

/// Code, scale at the pole (or `None`), and latitude of true scale of the polar systems of one hemisphere.
fn polar_systems(latitude: f64) -> [(u32, Option<f64>, f64); 2] {
    if latitude >= 0.0 {
        [(32_661, Some(0.994), 90.0), (3995, None, 71.0)]
    } else {
        [(32_761, Some(0.994), 90.0), (3031, None, 71.0)]
    }
}

fn polar_error(at_pole: Option<f64>, true_latitude: f64, side: f64, south: f64, north: f64) -> f64 {
    let growth = |latitude: f64| 2.0 / (1.0 + (side * latitude).to_radians().sin());
    let at_pole = at_pole.unwrap_or(1.0 / (2.0 / (1.0 + true_latitude.to_radians().sin())));
    let error = |latitude: f64| (at_pole * growth(latitude) - 1.0).abs();
    error(south).max(error(north))
}
