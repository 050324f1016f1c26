//! Difference of two pictures, in figures and as a picture.

use std::path::Path;

use image::{Rgb, RgbImage};
use serde_json::{Value, json};

use crate::lettering;
use hedgehop::{Error, Result};

/// Pixels around panels, and between them.
const MARGIN: u32 = 8;
const BACKGROUND: Rgb<u8> = Rgb([24, 24, 26]);
const INK: Rgb<u8> = Rgb([190, 190, 194]);

/// Sums over the pixels of one or several pairs of pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sums {
    pixels: u64,
    differing: u64,
    /// Sums of the 8-bit codes of all three colours.
    absolute: u64,
    squares: u64,
    most: u8,
}

impl Sums {
    /// Sums the differences of two pictures of one size.
    pub fn of(a: &RgbImage, b: &RgbImage) -> Self {
        let mut sums = Self::default();
        for (own, other) in a.pixels().zip(b.pixels()) {
            sums.pixels += 1;
            sums.differing += u64::from(own != other);
            for (own, other) in own.0.into_iter().zip(other.0) {
                let step = own.abs_diff(other);
                sums.absolute += u64::from(step);
                sums.squares += u64::from(step) * u64::from(step);
                sums.most = sums.most.max(step);
            }
        }
        sums
    }

    /// Adds those of another pair.
    pub fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.differing += other.differing;
        self.absolute += other.absolute;
        self.squares += other.squares;
        self.most = self.most.max(other.most);
    }

    /// Peak signal-to-noise ratio of the 8-bit codes, dB; `None`: the pictures are the same.
    pub fn psnr(&self) -> Option<f64> {
        let mean = self.squares as f64 / (3 * self.pixels.max(1)) as f64;
        (self.squares > 0).then(|| 10.0 * (255.0 * 255.0 / mean).log10())
    }

    /// Mean difference of a code.
    pub fn mean(&self) -> f64 {
        self.absolute as f64 / (3 * self.pixels.max(1)) as f64
    }

    /// Share of the pixels that differ, 0…1.
    pub fn differing(&self) -> f64 {
        self.differing as f64 / self.pixels.max(1) as f64
    }

    /// A line of the table, under [`HEAD`].
    pub fn row(&self, name: &str) -> String {
        let psnr = self.psnr().map_or("same".to_owned(), |psnr| format!("{psnr:.2}"));
        let (most, mean, share) = (self.most, self.mean(), 100.0 * self.differing());
        format!("{name:<24} {psnr:>8} {most:>5} {mean:>9.4} {share:>11.4}\n")
    }

    /// The same for programs.
    pub fn json(&self, name: &str) -> Value {
        json!({
            "name": name,
            "psnr_db": self.psnr(),
            "max": self.most,
            "mean": self.mean(),
            "differing_share": self.differing(),
        })
    }
}

/// First line of the table.
pub const HEAD: &str = "frame                     PSNR dB   max      mean   differing %\n";

/// A picture and its file.
#[derive(Debug, Clone, Copy)]
pub struct PictureFile<'a> {
    /// File that the picture was read from.
    pub path: &'a Path,
    /// Picture in the file.
    pub picture: &'a RgbImage,
}

/// Refuses pictures of two sizes.
pub fn check_sizes(a: PictureFile<'_>, b: PictureFile<'_>) -> Result<()> {
    let (own, other) = (a.picture.dimensions(), b.picture.dimensions());
    if own == other {
        return Ok(());
    }
    let what = format!(
        "has {}x{} pixels, and {} has {}x{}; render both with one --size",
        other.0,
        other.1,
        a.path.display(),
        own.0,
        own.1
    );
    Err(Error::invalid(b.path, what))
}

/// Both pictures and what differs, beside each other; differences are `factor` times as large.
pub fn panels(a: &RgbImage, b: &RgbImage, factor: u32) -> RgbImage {
    let (width, height) = a.dimensions();
    let scale = if width < 200 { 1 } else { 2 };
    let top = 2 * MARGIN + lettering::height(scale);
    let mut panels = RgbImage::from_pixel(MARGIN + 3 * (width + MARGIN), top + height + MARGIN, BACKGROUND);
    let difference = RgbImage::from_fn(width, height, |x, y| {
        let (own, other) = (a.get_pixel(x, y).0, b.get_pixel(x, y).0);
        Rgb([0, 1, 2].map(|part| (u32::from(own[part].abs_diff(other[part])) * factor).min(255) as u8))
    });
    let named = [("A".to_owned(), a), ("B".to_owned(), b), (format!("A-B x{factor}"), &difference)];
    for (place, (name, picture)) in (0..).zip(named) {
        let left = i64::from(MARGIN + place * (width + MARGIN));
        lettering::write(&mut panels, &name, [left, i64::from(MARGIN)], scale, INK);
        image::imageops::replace(&mut panels, picture, left, i64::from(top));
    }
    panels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_their_definitions() {
        let a = RgbImage::from_pixel(10, 10, Rgb([100, 100, 100]));
        let mut b = a.clone();
        assert_eq!((Sums::of(&a, &b).psnr(), Sums::of(&a, &b).differing()), (None, 0.0));
        b.put_pixel(3, 4, Rgb([110, 95, 100]));
        b.put_pixel(5, 5, Rgb([100, 100, 101]));
        let sums = Sums::of(&a, &b);
        assert_eq!((sums.most, sums.differing()), (10, 0.02));
        assert!((sums.mean() - 16.0 / 300.0).abs() < 1e-12);
        let exact = 20.0 * 255.0_f64.log10() - 10.0 * (126.0_f64 / 300.0).log10();
        assert!((sums.psnr().unwrap() - exact).abs() < 1e-9);
        let mut both = sums;
        both.add(&Sums::of(&a, &a));
        assert!((both.psnr().unwrap() - exact - 10.0 * 2.0_f64.log10()).abs() < 1e-9);
        assert!(both.row("all").starts_with("all ") && Sums::of(&a, &a).row("x").contains("same"));
    }

    #[test]
    fn panels_stand_beside_each_other() {
        let a = RgbImage::from_pixel(10, 6, Rgb([100, 100, 100]));
        let b = RgbImage::from_pixel(10, 6, Rgb([103, 100, 30]));
        let made = panels(&a, &b, 8);
        assert_eq!(made.dimensions(), (8 + 3 * 18, 23 + 6 + 8));
        let middle = |place: u32| made.get_pixel(8 + place * 18 + 5, 23 + 3).0;
        assert_eq!([middle(0), middle(1), middle(2)], [[100; 3], [103, 100, 30], [24, 0, 255]]);
        let [a, b] =
            [("a", &a), ("b", &made)].map(|(name, picture)| PictureFile { path: Path::new(name), picture });
        assert!(check_sizes(a, b).unwrap_err().to_string().contains("10x6"));
    }
}
