//! Several rays of a pixel gathered: a filter for colour, the ray nearest to the middle for what has no mean.
//!
//! The filter is the cubic of Mitchell and Netravali (1988, *Reconstruction Filters in Computer Graphics*) with B = C = ⅓, two pixels either way: it blurs
//! less than the mean of the pixel's own rays does, and lets through less of what is too fine for pixels.

use crate::subimage::Farm;

/// Pixels that the filter reaches either way.
const REACH: usize = 2;

/// Adds `weight` times the filtered light of `rays` to `target`, `[row][column]` of `width` columns; each of its pixels has `side` × `side` rays, which lie as in a picture that many
/// times as wide and high. Beyond the border rays are as on it; what the filter makes negative is 0. The result does not depend on the number of workers.
pub fn gather(
    rays: &[[f32; 3]],
    side: usize,
    weight: f32,
    target: &mut [[f32; 3]],
    width: usize,
    farm: &Farm,
) {
    if side == 1 {
        farm.rows(target, width, |row, line| {
            for (sum, light) in line.iter_mut().zip(&rays[row * width..]) {
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum += weight * light;
                }
            }
        });
        return;
    }

    let taps = taps(side);
    let (columns, rows) = (width * side, rays.len() / (width * side).max(1));
    farm.rows(target, width, |row, line| {
        let place = |pixel: usize, tap: usize, count: usize| {
            (pixel * side + tap).saturating_sub(REACH * side - side / 2).min(count - 1)
        };
        let mut upright = vec![[0.0_f32; 3]; columns];

        for (tap, share) in taps.iter().enumerate() {
            let from = &rays[place(row, tap, rows) * columns..][..columns];
            for (sum, light) in upright.iter_mut().zip(from) {
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum += share * light;
                }
            }
        }

        for (pixel, target) in line.iter_mut().enumerate() {
            let mut sum = [0.0_f32; 3];
            for (tap, share) in taps.iter().enumerate() {
                let light = upright[place(pixel, tap, columns)];
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum += share * light;
                }
            }
            for (target, sum) in target.iter_mut().zip(sum) {
                *target += weight * sum.max(0.0);
            }
        }
    });
}

/// Keeps the ray below and right of each pixel's middle; for ranges, normals and numbers, whose means are of nothing.
pub fn thin<T: Copy>(rays: &[T], side: usize, width: usize) -> Vec<T> {
    let columns = width * side;
    let rows = rays.chunks_exact(columns.max(1)).skip(side / 2).step_by(side);
    rows.flat_map(|row| row.iter().skip(side / 2).step_by(side).copied()).collect()
}

/// Weights of the rays about a pixel, from the first that it reaches.
fn taps(side: usize) -> Vec<f32> {
    let count = 2 * REACH * side;
    let at = |tap: usize| cubic((tap as f64 + 0.5 - 0.5 * count as f64) / side as f64);
    let sum: f64 = (0..count).map(at).sum();
    (0..count).map(|tap| (at(tap) / sum) as f32).collect()
}

/// The filter, of an integral of 1.
fn cubic(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
    } else if x < 2.0 {
        (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filter_is_the_published_one() {
        // (1 − B/3), (B/6), 0 at whole pixels.
        for (x, value) in [(0.0, 8.0 / 9.0), (1.0, 1.0 / 18.0), (-1.0, 1.0 / 18.0), (2.0, 0.0), (3.0, 0.0)] {
            assert!((cubic(x) - value).abs() < 1e-12, "{x}");
        }
        for side in [2, 4] {
            let taps = taps(side);
            assert!((taps.iter().sum::<f32>() - 1.0).abs() < 1e-6 && taps.len() == 4 * side);
            assert!(taps.iter().eq(taps.iter().rev()) && taps[0] < 0.0);
        }
    }

    /// Light of a picture with an edge: white below a slanting line.
    fn edge(width: usize, height: usize, side: usize) -> Vec<[f32; 3]> {
        let per = 1.0 / side as f64;
        let at = |index: usize| {
            let (column, row) = (index % (width * side), index / (width * side));
            let (x, y) = ((column as f64 + 0.5) * per, (row as f64 + 0.5) * per);
            if y > 0.27 * x + 3.1 { [1.0, 0.5, 0.0] } else { [0.0, 0.0, 1.0] }
        };
        (0..width * height * side * side).map(at).collect()
    }

    #[test]
    fn an_edge_comes_nearer_to_the_share_that_it_covers_with_more_rays() {
        let (width, height) = (30, 20);
        let fine = edge(width, height, 32);
        let covered = |pixel: usize| {
            let first = pixel / width * 32 * width * 32 + pixel % width * 32;
            let rays = (0..32 * 32).map(|ray| first + ray / 32 * width * 32 + ray % 32);
            rays.map(|ray| f64::from(fine[ray][0])).sum::<f64>() / 1024.0
        };
        let truth: Vec<f64> = (0..width * height).map(covered).collect();
        let farm = Farm::new(2).unwrap();

        let wrong = |side: usize| {
            let mut seen = vec![[0.0; 3]; width * height];
            gather(&edge(width, height, side), side, 1.0, &mut seen, width, &farm);
            for pixel in &seen {
                assert!((pixel[0] - 2.0 * pixel[1]).abs() < 0.2 && pixel.iter().all(|light| *light >= 0.0));
            }
            let squares = seen.iter().zip(&truth).map(|(seen, truth)| (f64::from(seen[0]) - truth).powi(2));
            (squares.sum::<f64>() / (width * height) as f64).sqrt()
        };

        let [one, two, four] = [1, 2, 4].map(wrong);
        assert!(two < 0.6 * one && four < 0.5 * one, "{one} {two} {four}");
    }

    #[test]
    fn even_light_stays_even_to_the_border_whoever_works() {
        for side in [1, 2, 4] {
            let rays = vec![[0.3, 2.0, 0.0]; 5 * 3 * side * side];
            for workers in [1, 3] {
                let mut seen = vec![[1.0; 3]; 15];
                gather(&rays, side, 0.5, &mut seen, 5, &Farm::new(workers).unwrap());
                for light in seen {
                    let expected = [1.15, 2.0, 1.0];
                    assert!(
                        light.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-5),
                        "{light:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn filtered_rays_stay_where_they_are() {
        // A ramp is the same at the pixels' middles, away from the border.
        for side in [2, 4] {
            let rays: Vec<[f32; 3]> = (0..9 * 7 * side * side)
                .map(|ray| [(ray % (9 * side)) as f32 + 0.5, (ray / (9 * side)) as f32 + 0.5, 1.0])
                .map(|light| light.map(|light| light / side as f32))
                .collect();
            let mut seen = vec![[0.0; 3]; 63];
            gather(&rays, side, 1.0, &mut seen, 9, &Farm::new(1).unwrap());
            let [x, y, _] = seen[3 * 9 + 4];
            assert!((x - 4.5).abs() < 1e-5 && (y - 3.5).abs() < 1e-5, "{x} {y}");
            let numbers: Vec<usize> = (0..9 * 7 * side * side).collect();
            let middle = thin(&numbers, side, 9)[3 * 9 + 4];
            assert_eq!(middle, (3 * side + side / 2) * 9 * side + 4 * side + side / 2);
            assert_eq!(thin(&numbers, side, 9).len(), 63);
        }
    }
}
