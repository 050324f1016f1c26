//! A direction for every pixel: screens that no formula describes.

use glam::{DVec3, UVec2, Vec3};

use hedgehop_base::error::{Error, Result};

/// Share of the neighbours whose angle is not wider than [`RayTable::pixel_angle`]; the rest may jump (seams between
/// projectors, the rim of a mirror).
const USUAL: f64 = 0.95;

/// Most neighbours that are looked at for [`RayTable::pixel_angle`].
const MOST_NEIGHBOURS: usize = 1 << 20;

/// Directions in the axes of the view (x right, y up, z forward), one per pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct RayTable {
    size: UVec2,
    /// `[row][column]`, unit length; zero where there is no ray.
    directions: Vec<Vec3>,
    pixel_angle: f64,
    digest: String,
}

impl RayTable {
    /// A table of `width` × `height` directions, `[row][column]`, row 0 at the top, of any length; a direction that
    /// is zero or not finite is no ray.
    ///
    /// # Errors
    /// [`Error::Configuration`] if the count is another, or no direction is a ray.
    pub fn new(width: u32, height: u32, mut directions: Vec<[f32; 3]>) -> Result<Self> {
        let count = (width as usize).checked_mul(height as usize);
        if count != Some(directions.len()) {
            return Err(Error::Configuration(format!(
                "a table of rays of {width}×{height} pixels needs as many directions, not {}",
                directions.len()
            )));
        }

        directions.iter_mut().for_each(|direction| *direction = unit(*direction));
        if directions.iter().all(|direction| *direction == [0.0; 3]) {
            return Err(Error::Configuration(
                "no pixel of the table has a direction: all are zero or not finite".into(),
            ));
        }

        let mut hasher = blake3::Hasher::new();
        hasher.update(&width.to_le_bytes());
        for direction in &directions {
            hasher.update(&direction.map(f32::to_le_bytes).concat());
        }

        let directions: Vec<Vec3> = directions.into_iter().map(Vec3::from_array).collect();
        let size = UVec2::new(width, height);
        let pixel_angle = usual_angle(size, &directions);

        Ok(Self { size, directions, pixel_angle, digest: hasher.finalize().to_hex().to_string() })
    }

    /// Columns and rows.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// The directions, `[row][column]`: of unit length, zero where there is no ray.
    pub fn directions(&self) -> &[Vec3] {
        &self.directions
    }

    /// BLAKE3 of the directions, hexadecimal.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Angle, radians, that 95 of 100 neighbouring directions do not exceed.
    pub fn pixel_angle(&self) -> f64 {
        self.pixel_angle
    }

    /// The direction at a position of the table, entries being at half-integers; between them bilinear, at the border
    /// continued. `None` if one that counts is no ray.
    pub(super) fn direction(&self, column: f64, row: f64) -> Option<DVec3> {
        let axis = |position: f64, count: u32| {
            let from_first = position - 0.5;
            let before = from_first.floor().clamp(0.0, f64::from(count.saturating_sub(2)));
            (before as usize, if count > 1 { from_first - before } else { 0.0 })
        };
        let ((left, u), (top, v)) = (axis(column, self.size.x), axis(row, self.size.y));
        let mut sum = DVec3::ZERO;

        for (dy, weight_y) in [(0, 1.0 - v), (1, v)] {
            for (dx, weight_x) in [(0, 1.0 - u), (1, u)] {
                let weight = weight_x * weight_y;
                if weight != 0.0 {
                    let direction = self.directions[(top + dy) * self.size.x as usize + left + dx];
                    if direction == Vec3::ZERO {
                        return None;
                    }
                    sum += weight * direction.as_dvec3();
                }
            }
        }

        (sum.is_finite() && sum != DVec3::ZERO).then_some(sum)
    }
}

/// The direction at unit length; zero for what is no direction.
fn unit(direction: [f32; 3]) -> [f32; 3] {
    let direction = DVec3::from_array(direction.map(f64::from));
    if direction.is_finite() { direction.normalize_or_zero().as_vec3().to_array() } else { [0.0; 3] }
}

fn usual_angle(size: UVec2, directions: &[Vec3]) -> f64 {
    let width = size.x as usize;
    let stride = directions.len().div_ceil(MOST_NEIGHBOURS / 2);
    let mut angles = Vec::new();
    for index in (0..directions.len()).step_by(stride) {
        let has_right = (index + 1) % width != 0;
        let neighbours = [has_right.then_some(index + 1), Some(index + width)];
        for neighbour in neighbours.into_iter().flatten() {
            let Some(&other) = directions.get(neighbour) else { continue };
            if directions[index] != Vec3::ZERO && other != Vec3::ZERO {
                let (one, other) = (directions[index].as_dvec3(), other.as_dvec3());
                angles.push(one.cross(other).length().atan2(one.dot(other)));
            }
        }
    }

    if angles.is_empty() {
        // Lone pixels say nothing of how wide they are; this makes the picture a radian wide.
        return 1.0 / f64::from(size.max_element());
    }

    let rank = ((angles.len() - 1) as f64 * USUAL) as usize;
    let (_, usual, _) = angles.select_nth_unstable_by(rank, f64::total_cmp);
    *usual
}
