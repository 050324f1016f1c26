//! Letters on pictures: numbers, units and a few marks, from dots.

use image::{Rgb, RgbImage};

/// Dots of a letter, across and down.
const SIZE: [u32; 2] = [5, 7];

/// Rows of the letters that there are, from the top; the highest of five bits is the left dot.
const LETTERS: [(char, [u8; 7]); 21] = [
    ('0', [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110]),
    ('1', [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('2', [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111]),
    ('3', [0b11110, 0b00001, 0b00001, 0b01110, 0b00001, 0b00001, 0b11110]),
    ('4', [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010]),
    ('5', [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110]),
    ('6', [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110]),
    ('7', [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000]),
    ('8', [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110]),
    ('9', [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100]),
    ('A', [0b00100, 0b01010, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001]),
    ('B', [0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110]),
    ('N', [0b10001, 0b11001, 0b11101, 0b10111, 0b10011, 0b10001, 0b10001]),
    ('d', [0b00001, 0b00001, 0b01101, 0b10011, 0b10001, 0b10011, 0b01101]),
    ('k', [0b10000, 0b10000, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010]),
    ('m', [0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101]),
    ('x', [0b00000, 0b00000, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001]),
    ('.', [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100]),
    ('-', [0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000]),
    ('|', [0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100]),
    (' ', [0; 7]),
];

/// Width of a text whose dots are `scale` pixels wide, pixels.
pub fn width(text: &str, scale: u32) -> u32 {
    (text.chars().count() as u32 * (SIZE[0] + 1)).saturating_sub(1) * scale
}

/// Height of a line, pixels.
pub fn height(scale: u32) -> u32 {
    SIZE[1] * scale
}

/// Writes a text with its upper left corner at a pixel, as far as it is on the picture. Of letters that there are not, the place stays empty.
pub fn write(picture: &mut RgbImage, text: &str, [left, top]: [i64; 2], scale: u32, colour: Rgb<u8>) {
    for (place, letter) in (0..).zip(text.chars()) {
        let Some((_, rows)) = LETTERS.iter().find(|(known, _)| *known == letter) else { continue };
        let dots = (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).map(move |column| (column, row)));
        for (column, row) in
            dots.filter(|(column, row)| rows[*row as usize] >> (SIZE[0] - 1 - column) & 1 == 1)
        {
            for (right, down) in (0..scale).flat_map(|down| (0..scale).map(move |right| (right, down))) {
                let x = left + i64::from((place * (SIZE[0] + 1) + column) * scale + right);
                let y = top + i64::from(row * scale + down);
                if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                    && let Some(pixel) = picture.get_pixel_mut_checked(x, y)
                {
                    *pixel = colour;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
