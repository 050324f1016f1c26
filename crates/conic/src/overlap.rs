//! Exact shares of rectangular cells that lie in an ellipse or a polygon.

use glam::{DMat2, DVec2};

use crate::{ImageConic, ImagePoint};

/// An ellipse of a plane that knows its exact area in any rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellOverlap {
    centre: DVec2,
    /// Makes the ellipse the unit circle.
    circle_from_plane: DMat2,
    /// Half the extent of the box around it.
    half: DVec2,
}

impl CellOverlap {
    /// The ellipse about `centre` with two conjugate half axes; `None`: they are parallel, or not finite.
    pub fn new(centre: DVec2, axes: [DVec2; 2]) -> Option<Self> {
        let plane_from_circle = DMat2::from_cols(axes[0], axes[1]);
        let circle_from_plane = plane_from_circle.inverse();
        let half = (axes[0] * axes[0] + axes[1] * axes[1]).map(f64::sqrt);
        let is_area = plane_from_circle.determinant() != 0.0 && circle_from_plane.is_finite();
        (is_area && centre.is_finite() && half.is_finite()).then_some(Self {
            centre,
            circle_from_plane,
            half,
        })
    }

    /// The ellipse of an image, whose plane has lines as x and elements as y; `None`: the conic is none.
    pub fn of(conic: &ImageConic) -> Option<Self> {
        let (centre, axes) = conic.ellipse()?;
        Self::new(centre, axes)
    }

    /// Least and greatest corner of the box around it.
    pub fn bounds(&self) -> [DVec2; 2] {
        [self.centre - self.half, self.centre + self.half]
    }

    /// Returns the area of a polygon that lies in the ellipse.
    pub fn area(&self, polygon: &[DVec2]) -> f64 {
        let corners: Vec<_> =
            polygon.iter().map(|corner| self.circle_from_plane * (*corner - self.centre)).collect();
        disc_overlap(&corners) / self.circle_from_plane.determinant().abs()
    }

    /// Returns the share of the rectangle between two corners that lies in the ellipse, 0…1.
    pub fn share(&self, low: DVec2, high: DVec2) -> f64 {
        let size = high - low;
        (self.area(&rectangle(low, high)) / (size.x * size.y)).clamp(0.0, 1.0)
    }

    /// Returns the share of the pixel right of and below an element and a line.
    pub fn pixel(&self, at: ImagePoint) -> f64 {
        let low = DVec2::new(at.line, at.element);
        self.share(low, low + 1.0)
    }
}

/// Finds the area that a polygon has in common with the unit circle.
pub fn disc_overlap(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(from, to)| edge_overlap(*from, *to)).sum::<f64>().abs()
}

/// The signed area of the triangle of the origin and an edge, as far as it lies in the unit circle.
fn edge_overlap(from: DVec2, to: DVec2) -> f64 {
    let way = to - from;
    let square = way.length_squared();
    if square == 0.0 {
        return 0.0;
    }
    let sector = |a: DVec2, b: DVec2| 0.5 * a.perp_dot(b).atan2(a.dot(b));

    // Where its line enters and leaves the circle, parts of the way.
    let nearest = -from.dot(way) / square;
    let aside = from.perp_dot(way).powi(2) / square;
    if aside >= 1.0 {
        return sector(from, to);
    }
    let half = ((1.0 - aside) / square).sqrt();
    let [enter, leave] = [(nearest - half).clamp(0.0, 1.0), (nearest + half).clamp(0.0, 1.0)];
    if enter >= leave {
        return sector(from, to);
    }

    let [first, last] = [from + way * enter, from + way * leave];
    let outside = |a: DVec2, b: DVec2, is_part: bool| if is_part { sector(a, b) } else { 0.0 };
    outside(from, first, enter > 0.0) + 0.5 * first.perp_dot(last) + outside(last, to, leave < 1.0)
}

/// Corners of the rectangle between two of them, counterclockwise where x goes right and y up.
pub fn rectangle(low: DVec2, high: DVec2) -> [DVec2; 4] {
    [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
}

/// Finds the part of a convex polygon on that side of the line through `on` to which `inward` points.
pub fn half_plane(polygon: &[DVec2], on: DVec2, inward: DVec2) -> Vec<DVec2> {
    let inside = |point: DVec2| inward.dot(point - on);
    let next = polygon.iter().cycle().skip(1);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (from, to) in polygon.iter().zip(next) {
        let (own, other) = (inside(*from), inside(*to));
        if own >= 0.0 {
            kept.push(*from);
        }
        if own * other < 0.0 {
            kept.push(from.lerp(*to, own / (own - other)));
        }
    }
    kept
}

/// Finds the area of a convex polygon within the rectangle between two corners.
pub fn clipped_area(polygon: &[DVec2], low: DVec2, high: DVec2) -> f64 {
    let sides = [(low, DVec2::X), (high, DVec2::NEG_X), (low, DVec2::Y), (high, DVec2::NEG_Y)];
    let points =
        sides.into_iter().fold(polygon.to_vec(), |points, (on, inward)| half_plane(&points, on, inward));
    area_of(&points)
}

/// Returns the area of a polygon that does not cross itself.
pub fn area_of(polygon: &[DVec2]) -> f64 {
    // From a corner, so that far ones lose no digits.
    let Some(first) = polygon.first() else { return 0.0 };
    let pairs = polygon.windows(2).map(|pair| (pair[0] - *first).perp_dot(pair[1] - *first));
    0.5 * pairs.sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn overlaps_of_the_circle_have_their_closed_forms() {
        let square =
            |half: f64| [[-half, -half], [half, -half], [half, half], [-half, half]].map(DVec2::from_array);
        assert!((disc_overlap(&square(2.0)) - PI).abs() < 1e-14);
        assert!((disc_overlap(&square(0.5)) - 1.0).abs() < 1e-14);
        // Four segments less than the circle.
        let segment = (0.8_f64).acos() - 0.8 * 0.6;
        assert!((disc_overlap(&square(0.8)) - (PI - 4.0 * segment)).abs() < 1e-14);
        let beside = square(0.5).map(|point| point + DVec2::new(3.0, 0.2));
        assert!(disc_overlap(&beside) < 1e-15);
        assert!((disc_overlap(&square(2.0).map(|point| point + 2.0)) - 0.25 * PI).abs() < 1e-14);
    }

    #[test]
    fn shares_of_cells_sum_to_the_area() {
        for (size, axes) in [
            (1.0, [DVec2::new(7.3, 1.0), DVec2::new(-0.4, 2.9)]),
            (16.0, [DVec2::new(300.0, 90.0), DVec2::new(-20.0, 70.0)]),
            (64.0, [DVec2::new(3.0, 0.0), DVec2::new(0.0, 5.0)]),
        ] {
            let overlap = CellOverlap::new(DVec2::new(0.3, -0.7), axes).unwrap();
            let [low, high] = overlap.bounds().map(|corner| (corner / size).floor());
            let mut sum = 0.0;
            for x in low.x as i32..=high.x as i32 {
                for y in low.y as i32..=high.y as i32 {
                    let corner = DVec2::new(f64::from(x), f64::from(y)) * size;
                    sum += overlap.share(corner, corner + size) * size * size;
                }
            }
            let area = PI * axes[0].perp_dot(axes[1]).abs();
            assert!((sum / area - 1.0).abs() < 1e-10, "{sum} {area}");
        }
    }

    #[test]
    fn what_is_no_ellipse_has_no_overlap() {
        assert_eq!(CellOverlap::new(DVec2::ZERO, [DVec2::X, DVec2::X * 2.0]), None);
        assert_eq!(CellOverlap::new(DVec2::ZERO, [DVec2::X, DVec2::Y * f64::NAN]), None);
        assert_eq!(CellOverlap::new(DVec2::NAN, [DVec2::X, DVec2::Y]), None);
    }
}
