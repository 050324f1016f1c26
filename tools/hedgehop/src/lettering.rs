//! Letters on pictures: numbers, units and a few marks, from dots.

use glam::DVec2;
use image::{Rgb, RgbImage};

use crate::drawing::Mask;
use hedgehop_titling::dot_font::{ADVANCE, HEIGHT, WIDTH, rows};

/// Width of a text whose dots are `scale` pixels wide, pixels.
pub fn width(text: &str, scale: u32) -> u32 {
    ((text.chars().count() * ADVANCE).saturating_sub(ADVANCE - WIDTH)) as u32 * scale
}

/// Height of a line, pixels.
pub fn height(scale: u32) -> u32 {
    HEIGHT as u32 * scale
}

/// Writes a text with its upper left corner at a pixel, as far as it is on the picture. Of letters that there are not, the place stays empty.
pub fn write(picture: &mut RgbImage, text: &str, [left, top]: [i64; 2], scale: u32, colour: Rgb<u8>) {
    for (place, letter) in text.chars().enumerate() {
        let rows = rows(letter);
        let dots = (0..HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (column, row)));
        for (column, row) in dots.filter(|(column, row)| rows[*row] >> (WIDTH - 1 - column) & 1 == 1) {
            for (right, down) in (0..scale).flat_map(|down| (0..scale).map(move |right| (right, down))) {
                let x = left + i64::from((place * ADVANCE + column) as u32 * scale + right);
                let y = top + i64::from(row as u32 * scale + down);
                if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                    && let Some(pixel) = picture.get_pixel_mut_checked(x, y)
                {
                    *pixel = colour;
                }
            }
        }
    }
}

/// Adds a text as strokes around a middle (pixels), along a direction of length 1, of capitals so many pixels high; `width` is that of the strokes.
pub fn stroke(mask: &mut Mask, text: &str, middle: DVec2, along: DVec2, tall: f64, width: f64) {
    let dot = tall / (HEIGHT - 1) as f64;
    let columns = (text.chars().count() * ADVANCE).saturating_sub(ADVANCE - WIDTH + 1) as f64;
    let down = DVec2::new(-along.y, along.x);
    let at = |column: usize, row: usize| {
        let right = column as f64 - 0.5 * columns;
        middle + (along * right + down * (row as f64 - 0.5 * (HEIGHT - 1) as f64)) * dot
    };

    for (place, letter) in text.chars().enumerate() {
        let rows = rows(letter);
        let is_lit = |column: usize, row: usize| {
            column < WIDTH && row < HEIGHT && rows[row] >> (WIDTH - 1 - column) & 1 == 1
        };
        let dots = (0..HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (column, row)));

        for (column, row) in dots.filter(|(column, row)| is_lit(*column, *row)) {
            let here = at(place * ADVANCE + column, row);
            mask.disc(here, 0.5 * width);
            let mut line_to = |column: usize, row: usize| {
                mask.lines(&[here, at(place * ADVANCE + column, row)], width);
            };
            let (right, below) = (is_lit(column + 1, row), is_lit(column, row + 1));
            if right {
                line_to(column + 1, row);
            }
            if below {
                line_to(column, row + 1);
            }

            // Slanting, where no corner connects them.
            if is_lit(column + 1, row + 1) && !right && !below {
                line_to(column + 1, row + 1);
            }
            if column > 0 && is_lit(column - 1, row + 1) && !below && !is_lit(column - 1, row) {
                line_to(column - 1, row + 1);
            }
        }
    }
}

/// Width of a text as strokes, of capitals so many pixels high, pixels.
pub fn stroke_width(text: &str, tall: f64) -> f64 {
    f64::from(width(text, 1).saturating_sub(1)) * tall / (HEIGHT - 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_turn_about_their_middle() {
        let mut picture = RgbImage::new(100, 100);
        let mut mask = Mask::new(&picture);
        stroke(&mut mask, "H", DVec2::splat(50.0), DVec2::Y, 30.0, 2.0);
        mask.paint(&mut picture, Rgb([255; 3]), 1.0);
        let is_lit = |x: u32, y: u32| picture.get_pixel(x, y)[0] > 100;
        // Lying on its side: bars above and below, a beam between.
        assert!(is_lit(40, 40) && is_lit(60, 59) && is_lit(50, 50));
        assert!(!is_lit(40, 50) && !is_lit(60, 50));
        assert!((stroke_width("H", 30.0) - 20.0).abs() < 1e-9);
    }

    #[test]
    fn letters_are_as_large_as_they_say_and_stay_on_the_picture() {
        let (white, text) = (Rgb([255; 3]), "0123456789ABNdkmx.-| ");
        let mut picture = RgbImage::new(width(text, 2), height(2));
        write(&mut picture, text, [0, 0], 2, white);
        let has_ink = |x: u32| (0..height(2)).any(|y| *picture.get_pixel(x, y) == white);
        // Of the first letter both sides have dots, and the last is a space.
        assert!(has_ink(0) && has_ink(9) && !has_ink(10) && !has_ink(width(text, 2) - 3));
        for (index, letter) in text.chars().enumerate().filter(|(_, letter)| *letter != ' ') {
            let mut own = RgbImage::new(5, 7);
            write(&mut own, &letter.to_string(), [0, 0], 1, white);
            let first = index as u32 * 12;
            assert!((first..first + 10).any(has_ink), "{letter}");
            assert!(own.pixels().any(|pixel| *pixel == white), "{letter}");
        }
        for corner in [[-3, -5], [1000, 3], [3, 1000]] {
            write(&mut picture, "88", corner, 3, white);
        }
    }
}
