//! Photographs of made-up buildings on made-up hills, by casting a ray to the sun from each part of each pixel.
//!
//! Nothing of the solver is used here: rays meet walls and roofs in space. The hills shade no other hill: they are flatter than the rays of the lowest sun.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::super::super::kernel::Samples;
use crate::raster::Window;
use hedgehop::Size;
use hedgehop_base::error::Result;

/// Numbers that follow from a seed (Steele, Lea and Flood 2014, splitmix64).
pub(super) struct Random(pub u64);

impl Random {
    /// 0…1.
    pub fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.0)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }
}

fn mixed(seed: u64) -> f64 {
    let mut z = seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Value noise of a wavelength, 0…1.
fn noise(place: DVec2, wavelength: f64, seed: u64) -> f64 {
    let at = place / wavelength;
    let cell = at.floor();
    let f = at - cell;
    let f = f * f * (3.0 - 2.0 * f);
    let corner = |dx: f64, dy: f64| {
        let (x, y) = ((cell.x + dx) as i64 as u64, (cell.y + dy) as i64 as u64);
        mixed(x.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f) ^ seed)
    };
    let low = corner(0.0, 0.0) * (1.0 - f.x) + corner(1.0, 0.0) * f.x;
    let high = corner(0.0, 1.0) * (1.0 - f.x) + corner(1.0, 1.0) * f.x;
    low * (1.0 - f.y) + high * f.y
}

/// Height of the hills, metres.
pub(super) fn hills(place: DVec2) -> f64 {
    400.0
        + 12.0 * (place.x / 150.0).sin()
        + 9.0 * (place.y / 110.0 + 1.0).cos()
        + 1.5 * (place.x / 31.0 + place.y / 47.0).sin()
}

/// Rise of the hills per metre to the east and to the north.
fn slope(place: DVec2) -> DVec2 {
    let wave = 1.5 * (place.x / 31.0 + place.y / 47.0).cos();
    dvec2(
        12.0 / 150.0 * (place.x / 150.0).cos() + wave / 31.0,
        wave / 47.0 - 9.0 / 110.0 * (place.y / 110.0 + 1.0).sin(),
    )
}

/// A prism with a level roof.
#[derive(Debug, Clone)]
pub(super) struct Prism {
    pub ring: Vec<DVec2>,
    /// Height of the roof, metres.
    pub roof: f64,
}

impl Prism {
    fn holds(&self, place: DVec2) -> bool {
        let corners = || self.ring.iter().copied();
        let (low, high) =
            (corners().fold(DVec2::INFINITY, DVec2::min), corners().fold(DVec2::NEG_INFINITY, DVec2::max));
        if place.cmplt(low).any() || place.cmpgt(high).any() {
            return false;
        }
        // Angles around the place.
        let angle: f64 = self
            .ring
            .iter()
            .zip(self.ring.iter().cycle().skip(1))
            .map(|(a, b)| (*a - place).angle_to(*b - place))
            .sum();
        angle.abs() > std::f64::consts::PI
    }

    /// Whether a ray from a point meets a wall or the roof.
    fn stops(&self, from: DVec3, direction: DVec3) -> bool {
        let (at, along) = (from.truncate(), direction.truncate());
        let roof = (self.roof - from.z) / direction.z;
        if roof > 0.0 && self.holds(at + along * roof) {
            return true;
        }
        self.ring.iter().zip(self.ring.iter().cycle().skip(1)).any(|(&a, &b)| {
            let wall = b - a;
            let across = along.perp_dot(wall);
            let (t, s) = ((a - at).perp_dot(wall) / across, (a - at).perp_dot(along) / across);
            t > 0.0 && (0.0..=1.0).contains(&s) && from.z + t * direction.z < self.roof
        })
    }
}

/// What is photographed.
#[derive(Debug, Clone)]
pub(super) struct World {
    pub prisms: Vec<Prism>,
    /// Degrees.
    pub azimuth: f64,
    pub elevation: f64,
    /// Side of a pixel, metres.
    pub side: f64,
    pub size: Size,
    pub seed: u64,
    /// How much the ground's brightness varies, 0…1.
    pub texture: f64,
    /// The sun's share of the light on level ground, 0…1.
    pub direct: f64,
}

impl World {
    /// Directions to the middle of the sun, and to its right and above it.
    fn sun(&self) -> [DVec3; 3] {
        let [(east, north), (up, along)] =
            [self.azimuth, self.elevation].map(|angle| angle.to_radians().sin_cos());
        let middle = dvec3(east * along, north * along, up);
        let across = dvec3(north, -east, 0.0);
        [middle, across, across.cross(middle)]
    }

    fn brightness(&self, place: DVec2, sun: [DVec3; 3], jitter: &mut Random) -> [f64; 3] {
        if self.prisms.iter().any(|prism| prism.holds(place)) {
            return [0.42, 0.3, 0.26];
        }

        // Meadows, soil and ploughing.
        let patch = noise(place, 37.0, self.seed) - 0.5;
        let grain = noise(place, 3.0, self.seed ^ 1) - 0.5 + 0.7 * (noise(place, 0.9, self.seed ^ 2) - 0.5);
        let is_ploughed = noise(place, 90.0, self.seed ^ 3) > 0.5;
        let stripes = if is_ploughed { 0.35 * (place.dot(dvec2(0.8, 0.6)) * 1.3).sin() } else { 0.0 };
        let ground = 0.22 * (self.texture * (1.2 * patch + 1.3 * grain + stripes)).exp();
        let sky = 1.0 - self.direct;
        let from = place.extend(hills(place) + 1e-3);

        // A place on the sun's disc, which is so small that its axes are straight.
        let on_disc = loop {
            let place = dvec2(jitter.between(-1.0, 1.0), jitter.between(-1.0, 1.0));
            if place.length_squared() <= 1.0 {
                break place * 0.2666_f64.to_radians();
            }
        };
        let [middle, across, above] = sun;
        let direction = (middle + across * on_disc.x + above * on_disc.y).normalize();
        let normal = (-slope(place)).extend(1.0).normalize();
        let facing = normal.dot(direction).max(0.0) / direction.z;
        let is_shaded = self.prisms.iter().any(|prism| prism.stops(from, direction));
        let direct = if is_shaded { 0.0 } else { self.direct * facing };

        let (hues, blues) = ([0.95, 1.0, 0.8], [0.85, 1.0, 1.15]);
        std::array::from_fn(|band| ground * hues[band] * direct + ground * sky * blues[band])
    }

    fn pixel(&self, column: u32, row: u32) -> [u8; 4] {
        const PARTS: u32 = 3;

        let mut jitter = Random(
            self.seed ^ (u64::from(column) << 32 | u64::from(row)).wrapping_mul(0x2545_f491_4f6c_dd1d),
        );
        let (sun, mut sum) = (self.sun(), [0.0; 3]);

        for part in 0..PARTS * PARTS {
            let offset =
                |number: u32, jitter: &mut Random| (f64::from(number) + jitter.share()) / f64::from(PARTS);
            let (u, v) = (offset(part % PARTS, &mut jitter), offset(part / PARTS, &mut jitter));
            let place =
                dvec2(f64::from(column) + u, f64::from(self.size.height) - f64::from(row) - v) * self.side;
            let light = self.brightness(place, sun, &mut jitter);
            (0..3).for_each(|i| sum[i] += light[i]);
        }

        let gain = 1.0 + 0.06 * (jitter.share() + jitter.share() + jitter.share() - 1.5);
        let code = |light: f64| {
            let light = (light / f64::from(PARTS * PARTS) * 1.6 * gain).clamp(0.0, 1.0);
            let encoded =
                if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
            (encoded * 255.0).round() as u8
        };

        [code(sum[0]), code(sum[1]), code(sum[2]), 255]
    }
}

impl Samples<[u8; 4]> for World {
    fn size(&self) -> Size {
        self.size
    }
    fn read(&self, window: Window, samples: &mut Vec<[u8; 4]>) -> Result<()> {
        samples.clear();
        for row in window.y..window.y + window.height {
            samples.extend((window.x..window.x + window.width).map(|column| self.pixel(column, row)));
        }
        Ok(())
    }
}
