//! Lines and letters over a picture.

use glam::DVec2;

use crate::dot_font::{ADVANCE, HEIGHT, WIDTH, rows};
use hedgehop::frame::Picture;

/// Colour that is drawn with, and the halo that sets it off from anything: 8-bit sRGB, and the share of it that counts.
#[derive(Debug, Clone, Copy)]
pub struct Ink {
    pub colour: [u8; 3],
    pub halo: f64,
}

/// A picture that is drawn on.
pub struct Canvas<'p> {
    picture: &'p mut Picture,
    /// Pixels of a letter's dot, and of a line's width.
    pub dot: usize,
}

impl<'p> Canvas<'p> {
    pub fn new(picture: &'p mut Picture, dot: usize) -> Self {
        Self { picture, dot }
    }

    /// Columns and rows.
    pub fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.picture.width), f64::from(self.picture.height))
    }

    /// Mixes a share of a colour into a pixel; nothing beside the picture.
    pub fn mix(&mut self, column: i64, row: i64, colour: [u8; 3], share: f64) {
        let (width, height) = (i64::from(self.picture.width), i64::from(self.picture.height));
        if column < 0 || row < 0 || column >= width || row >= height {
            return;
        }
        let first = 3 * (row * width + column) as usize;
        for (code, own) in self.picture.rgb[first..first + 3].iter_mut().zip(colour) {
            let mixed = f64::from(*code) + (f64::from(own) - f64::from(*code)) * share.clamp(0.0, 1.0);
            *code = mixed.round() as u8;
        }
    }

    /// A line between two places, pixels, with round ends.
    pub fn line(&mut self, ends: [DVec2; 2], ink: Ink) {
        self.lines(&[ends], ink);
    }

    /// Lines that no halo of another one covers, and whose halos do not add up where they meet.
    pub fn lines(&mut self, lines: &[[DVec2; 2]], ink: Ink) {
        let half = 0.5 * self.dot as f64;
        for (half, colour, share) in [(half + self.dot as f64, [0; 3], ink.halo), (half, ink.colour, 1.0)] {
            if share > 0.0 {
                let mut covered: Vec<_> = lines.iter().flat_map(|ends| self.stroke(*ends, half)).collect();
                covered.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
                covered.dedup_by_key(|(pixel, _)| *pixel);
                for ([row, column], covered) in covered {
                    self.mix(column, row, colour, share * covered);
                }
            }
        }
    }

    /// Row, column and share of the pixels that a line so wide covers.
    fn stroke(&self, ends: [DVec2; 2], half: f64) -> Vec<([i64; 2], f64)> {
        let Some([from, to]) = clipped(ends, self.size(), half + 1.0) else { return Vec::new() };
        let way = to - from;
        let least = from.min(to) - half - 1.0;
        let most = from.max(to) + half + 1.0;
        let [columns, rows] = [0, 1].map(|axis| {
            (least[axis].floor().max(0.0) as i64)..=(most[axis].ceil().min(self.size()[axis]) as i64)
        });
        let mut pixels = Vec::new();

        for row in rows {
            for column in columns.clone() {
                let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - from;
                let along = (at.dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
                let covered = (half + 0.5 - (at - way * along).length()).clamp(0.0, 1.0);
                if covered > 0.0 {
                    pixels.push(([row, column], covered));
                }
            }
        }

        pixels
    }

    /// Text of which the upper left corner, pixels, is given.
    pub fn text(&mut self, text: &str, [left, top]: [i64; 2], ink: Ink) {
        let dot = self.dot as i64;
        for (colour, share, grown) in [([0; 3], ink.halo, dot), (ink.colour, 1.0, 0)] {
            for (index, letter) in text.chars().enumerate() {
                let first = left + (index * ADVANCE) as i64 * dot;
                let dots = rows(letter);

                // Halos of neighbouring dots would add up: each pixel has one or none.
                for row in -grown..HEIGHT as i64 * dot + grown {
                    for column in -grown..WIDTH as i64 * dot + grown {
                        let is_near = |(down, across): (i64, i64)| {
                            let (row, column) =
                                ((row + down).div_euclid(dot), (column + across).div_euclid(dot));
                            (0..HEIGHT as i64).contains(&row)
                                && (0..WIDTH as i64).contains(&column)
                                && dots[row as usize] >> (WIDTH as i64 - 1 - column) & 1 == 1
                        };
                        let around = [(0, 0), (-grown, 0), (grown, 0), (0, -grown), (0, grown)];
                        if around.into_iter().any(is_near) {
                            self.mix(first + column, top + row, colour, share);
                        }
                    }
                }
            }
        }
    }

    /// Pixels that a text takes across.
    pub fn width_of(&self, text: &str) -> i64 {
        let letters = text.chars().count();
        (letters * ADVANCE * self.dot) as i64 - self.dot as i64
    }
}

/// The part of a line that lies in a picture of a size, or at most so far beside it.
fn clipped([from, to]: [DVec2; 2], size: DVec2, beside: f64) -> Option<[DVec2; 2]> {
    let (way, mut ends) = (to - from, [0.0_f64, 1.0]);
    if !(from.is_finite() && to.is_finite()) {
        return None;
    }
    for axis in 0..2 {
        let walls = [-beside, size[axis] + beside].map(|wall| (wall - from[axis]) / way[axis]);
        if way[axis] == 0.0 {
            if from[axis] < -beside || from[axis] > size[axis] + beside {
                return None;
            }
            continue;
        }
        ends[0] = ends[0].max(walls[0].min(walls[1]));
        ends[1] = ends[1].min(walls[0].max(walls[1]));
    }
    (ends[0] <= ends[1]).then(|| ends.map(|share| from + way * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: Ink = Ink { colour: [0, 255, 0], halo: 0.0 };

    fn black() -> Picture {
        Picture { width: 40, height: 20, rgb: vec![0; 2400] }
    }

    fn green(picture: &Picture) -> f64 {
        picture.rgb.iter().skip(1).step_by(3).map(|code| f64::from(*code) / 255.0).sum()
    }

    #[test]
    fn a_line_covers_as_much_as_it_is_long_and_wide() {
        for (ends, length) in [
            ([DVec2::new(5.0, 5.5), DVec2::new(25.0, 5.5)], 20.0),
            ([DVec2::new(5.0, 4.0), DVec2::new(17.0, 13.0)], 15.0),
            // Only its part in the picture counts.
            ([DVec2::new(-1.0e9, 10.5), DVec2::new(1.0e9, 10.5)], 40.0),
        ] {
            for dot in [1, 2] {
                let mut picture = black();
                Canvas::new(&mut picture, dot).line(ends, INK);
                let expected = length * dot as f64;
                assert!(
                    (green(&picture) - expected).abs() < 0.1 * expected + 3.0 * dot as f64,
                    "{ends:?} {dot}"
                );
            }
        }
    }

    #[test]
    fn nothing_is_drawn_beside_the_picture() {
        let mut picture = black();
        let mut canvas = Canvas::new(&mut picture, 1);
        canvas.line([DVec2::new(-50.0, -9.0), DVec2::new(90.0, -9.0)], INK);
        canvas.line([DVec2::new(f64::NAN, 0.0), DVec2::new(9.0, 9.0)], INK);
        canvas.text("88", [41, 0], INK);
        canvas.text("88", [0, -9], INK);
        assert_eq!(picture, black());
    }

    #[test]
    fn text_has_the_dots_of_its_letters() {
        let mut picture = black();
        Canvas::new(&mut picture, 2).text("1.", [3, 2], INK);
        let dots: u32 = "1.".chars().flat_map(rows).map(u8::count_ones).sum();
        assert_eq!(green(&picture), f64::from(4 * dots));
        // The upper left dot of `1` is its third.
        assert_eq!(picture.rgb[3 * (2 * 40 + 3 + 4) + 1], 255);
        assert_eq!(Canvas::new(&mut picture, 2).width_of("1."), 22);
    }

    #[test]
    fn halos_darken_once() {
        let mut picture = Picture { width: 40, height: 20, rgb: vec![200; 2400] };
        Canvas::new(&mut picture, 1).text("8", [5, 5], Ink { halo: 0.5, ..INK });
        assert!(picture.rgb.iter().all(|code| [0, 100, 200, 255].contains(code)));
        assert!(picture.rgb.contains(&100));
        // Where lines follow each other, too.
        let mut picture = Picture { width: 40, height: 20, rgb: vec![200; 2400] };
        let [left, middle, right] = [4.0, 20.5, 36.0].map(|column| DVec2::new(column, 10.5));
        Canvas::new(&mut picture, 1).lines(&[[left, middle], [middle, right]], Ink { halo: 0.5, ..INK });
        let darkest = picture.rgb[3 * 40 * 9..3 * 40 * 10].iter().min();
        assert_eq!(darkest, Some(&100));
    }
}
