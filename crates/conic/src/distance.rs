//! Distance algorithm: shares of pixels by how far their middles are from the outline along the way to the centre (§2.4.2).

use glam::DVec2;

use crate::{ImageConic, ImagePoint};

/// Share of a pixel whose middle lies so many pixels inside of the outline: one half on it, all or nothing half a pixel off.
pub fn distance_share(inside: f64) -> f64 {
    0.5 + inside.clamp(-0.5, 0.5)
}

/// Returns the share of the pixel right of and below an element and a line; `None`: the conic is no ellipse.
pub fn distance_coverage(conic: &ImageConic, at: ImagePoint) -> Option<f64> {
    let (centre, _) = conic.ellipse()?;
    let offset = DVec2::new(at.line, at.element) + 0.5 - centre;
    let distance = offset.length();
    let [r1, r2, r3, ..] = conic.terms;
    // The conic is q − limit about its centre: the outline is as many times as far as the root of their ratio.
    let square = r1 * offset.x * offset.x + r2 * offset.y * offset.y + r3 * offset.x * offset.y;
    let limit = -conic.value(ImagePoint { line: centre.x, element: centre.y });
    if square == 0.0 {
        return Some(1.0);
    }
    Some(distance_share(distance * (limit / square).sqrt() - distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_samples_of_the_report_are_exact() {
        for (inside, share) in [(0.6, 1.0), (-0.2, 0.3), (0.15, 0.65)] {
            assert!((distance_share(inside) - share).abs() < 1e-15, "{inside}");
        }
    }

    #[test]
    fn distances_are_those_from_a_circle() {
        let centre = DVec2::new(20.0, 30.0);
        let conic = ImageConic::of_image(centre, [DVec2::X * 8.0, DVec2::Y * 8.0]);
        for (line, element) in [(27.0, 30.0), (12.0, 30.0), (25.0, 36.0), (20.0, 30.0), (14.0, 24.0)] {
            let middle = DVec2::new(line, element) + 0.5;
            let wanted = distance_share(8.0 - (middle - centre).length());
            let share = distance_coverage(&conic, ImagePoint { line, element }).unwrap();
            assert!((share - wanted).abs() < 1e-9, "{line} {element}: {share} {wanted}");
        }
    }
}
