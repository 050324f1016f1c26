//! Lines and areas on pictures, smooth at their edges.
//!
//! Each figure is a mask of shares, so that what overlaps itself is no darker there; it is put on at once.

use glam::DVec2;
use image::{Rgb, RgbImage};

/// Shares of the pixels that a figure covers, 0…1.
#[derive(Debug, Clone)]
pub struct Mask {
    size: [u32; 2],
    shares: Vec<f32>,
}

impl Mask {
    /// Nothing, on a picture of this size.
    pub fn new(picture: &RgbImage) -> Self {
        let (width, height) = picture.dimensions();
        Self { size: [width, height], shares: vec![0.0; width as usize * height as usize] }
    }

    /// Adds lines between points (pixels from the upper left corner), as wide as this, with round ends.
    pub fn lines(&mut self, points: &[DVec2], width: f64) {
        for ends in points.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            let along = to - from;
            let length = along.length_squared();
            let nearest = move |place: DVec2| {
                let share =
                    if length > 0.0 { ((place - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
                (place - from - along * share).length()
            };
            self.near([from.min(to), from.max(to)], 0.5 * width, nearest);
        }
    }

    /// Adds a disc.
    pub fn disc(&mut self, middle: DVec2, radius: f64) {
        self.near([middle; 2], radius, |place| (place - middle).length());
    }

    /// Adds a square that stands on its side.
    pub fn square(&mut self, middle: DVec2, half: f64) {
        self.near([middle; 2], half, |place| (place - middle).abs().max_element());
    }

    /// Adds the pixels whose middles lie in an upright rectangle.
    pub fn rectangle(&mut self, low: DVec2, high: DVec2) {
        // A float converts saturating.
        let range = |low: f64, high: f64, size: u32| {
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).ceil().max(0.0) as usize).min(size as usize)
        };
        let columns = range(low.x, high.x, self.size[0]);
        for row in range(low.y, high.y, self.size[1]).filter(|_| !columns.is_empty()) {
            let line = row * self.size[0] as usize;
            self.shares[line + columns.start..line + columns.end].fill(1.0);
        }
    }

    /// Adds the inside of a polygon: what an odd number of its sides is to the left of.
    pub fn polygon(&mut self, corners: &[DVec2]) {
        let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
        for row in 0..self.size[1] {
            let y = f64::from(row) + 0.5;
            let crossing = |(a, b): (&DVec2, &DVec2)| {
                ((a.y <= y) != (b.y <= y)).then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
            };
            let mut crossings: Vec<f64> = sides().filter_map(crossing).collect();
            crossings.sort_unstable_by(f64::total_cmp);
            for span in crossings.chunks_exact(2) {
                // A float converts saturating.
                let [first, end] = [span[0], span[1]].map(|x| (x - 0.5).ceil().max(0.0) as usize);
                let line = row as usize * self.size[0] as usize;
                let end = end.min(self.size[0] as usize);
                self.shares[line + first.min(end)..line + end].fill(1.0);
            }
        }
    }

    /// Takes away what another covers.
    pub fn without(&mut self, other: &Self) {
        self.shares.iter_mut().zip(&other.shares).for_each(|(own, other)| *own *= 1.0 - other);
    }

    /// Adds what is nearer than `reach` to something within a box, by its `distance`.
    fn near(&mut self, [low, high]: [DVec2; 2], reach: f64, distance: impl Fn(DVec2) -> f64) {
        // Half a pixel beyond, edges end.
        let range = |low: f64, high: f64, size: u32| {
            (low - reach - 1.0).max(0.0) as u32..((high + reach + 2.0).max(0.0) as u32).min(size)
        };
        for y in range(low.y, high.y, self.size[1]) {
            for x in range(low.x, high.x, self.size[0]) {
                let share = reach + 0.5 - distance(DVec2::new(f64::from(x), f64::from(y)) + 0.5);
                let known = &mut self.shares[y as usize * self.size[0] as usize + x as usize];
                *known = known.max(share.clamp(0.0, 1.0) as f32);
            }
        }
    }

    /// Puts it on a picture in a colour, so opaque (0…1).
    pub fn paint(&self, picture: &mut RgbImage, colour: Rgb<u8>, opacity: f32) {
        for (pixel, share) in picture.pixels_mut().zip(&self.shares).filter(|(_, share)| **share > 0.0) {
            let share = share * opacity;
            for (own, other) in pixel.0.iter_mut().zip(colour.0) {
                *own = (f32::from(*own) * (1.0 - share) + f32::from(other) * share).round() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mask: &Mask) -> f64 {
        mask.shares.iter().map(|share| f64::from(*share)).sum()
    }

    #[test]
    fn figures_have_their_areas() {
        let mut picture = RgbImage::new(60, 40);
        let blank = Mask::new(&picture);
        let made = |draw: &dyn Fn(&mut Mask)| {
            let mut mask = blank.clone();
            draw(&mut mask);
            mask
        };
        let at = DVec2::new;
        let disc = made(&|mask| mask.disc(at(30.3, 20.1), 9.0));
        assert!((area(&disc) - std::f64::consts::PI * 81.0).abs() < 3.0, "{}", area(&disc));
        let line = made(&|mask| mask.lines(&[at(10.0, 20.0), at(50.0, 20.0), at(10.0, 20.0)], 4.0));

        // There and back it is the same line, with half a disc at either end.
        assert!((area(&line) - 160.0 - std::f64::consts::PI * 4.0).abs() < 2.0, "{}", area(&line));
        let polygon =
            made(&|mask| mask.polygon(&[at(10.0, 10.0), at(30.0, 10.0), at(30.0, 30.0), at(10.0, 30.0)]));
        assert_eq!(area(&polygon), 400.0);
        let outside = made(&|mask| {
            mask.lines(&[at(-1e12, -50.0), at(1e12, -50.0)], 2.0);
            mask.polygon(&[at(-1e12, -9.0), at(-5.0, 100.0), at(-1e9, 100.0)]);
            mask.disc(at(500.0, 500.0), 3.0);
        });
        assert_eq!(area(&outside), 0.0);
        let across =
            made(&|mask| mask.polygon(&[at(-1e12, -1e12), at(1e12, -1e12), at(1e12, 1e12), at(-1e12, 1e12)]));
        assert_eq!(area(&across), 2400.0);
        let rectangle = made(&|mask| mask.rectangle(at(50.0, 30.0), at(1e9, 1e9)));
        assert_eq!(area(&rectangle), 100.0);
        assert_eq!(area(&made(&|mask| mask.rectangle(at(70.0, 3.0), at(80.0, 9.0)))), 0.0);
        let mut cut = polygon.clone();
        cut.without(&made(&|mask| mask.square(at(20.0, 20.0), 5.0)));
        assert_eq!(area(&cut), 300.0);
        polygon.paint(&mut picture, Rgb([200, 100, 0]), 0.5);
        assert_eq!((picture.get_pixel(15, 15).0, picture.get_pixel(5, 5).0), ([100, 50, 0], [0; 3]));
    }
}
