//! Distance of a picture from the truth, and a picture of it.

use std::path::Path;

use glam::Vec3;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip};
use serde::Serialize;

use hedgehop::colour::srgb8_picture;
use hedgehop::encode::atomic::write_bytes;
use hedgehop::{Error, Result};

/// Nearness of a picture to the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Nearness {
    /// Peak signal to noise ratio of 8-bit sRGB codes over the three channels, decibels.
    pub psnr_db: f64,
    /// Mean FLIP error at 67 pixels per degree (a 0.7 m wide 4K monitor at 0.7 m), 0…1, lower is better.
    pub flip: f64,
}

impl Nearness {
    /// Measures `picture` against `truth`, both 8-bit sRGB and of a size in pixels.
    pub fn between(truth: &[u8], picture: &[u8], [width, height]: [u32; 2]) -> Self {
        let image = |rgb| FlipImageRgb8::with_data(width, height, rgb);
        let errors = flip(image(truth), image(picture), DEFAULT_PIXELS_PER_DEGREE);
        let flip = f64::from(FlipPool::from_image(&errors).mean());
        Self { psnr_db: psnr(truth, picture), flip }
    }
}

/// Peak signal to noise ratio of 8-bit codes, decibels; infinite for equal pictures.
pub fn psnr(truth: &[u8], picture: &[u8]) -> f64 {
    let squares: f64 = truth.iter().zip(picture).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
    10.0 * (255.0 * 255.0 * truth.len() as f64 / squares).log10()
}

/// The 8-bit sRGB codes of a picture in linear light.
pub fn codes(colour: &[[f32; 3]]) -> Vec<u8> {
    srgb8_picture(colour)
}

/// The same before they are rounded.
pub fn exact_codes(colour: &[[f32; 3]]) -> Vec<Vec3> {
    // The sRGB curve, IEC 61966-2-1.
    let encoded =
        |light: f32| if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    let code = |light: f32| 255.0 * encoded(light.clamp(0.0, 1.0));
    colour.iter().map(|light| Vec3::from(light.map(code))).collect()
}

/// Differences of codes, `gain` times, around middle grey.
pub fn difference(truth: &[u8], picture: &[u8], gain: i32) -> Vec<u8> {
    let around = |(&a, &b): (&u8, &u8)| (128 + gain * (i32::from(b) - i32::from(a))).clamp(0, 255) as u8;
    truth.iter().zip(picture).map(around).collect()
}

/// Writes 8-bit sRGB codes of a picture of a size in pixels as PNG.
pub fn write_png(path: &Path, rgb: &[u8], [width, height]: [u32; 2]) -> Result<()> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|source| Error::invalid(path, format!("the PNG encoder refuses the picture: {source}")))?;
    write_bytes(path, &bytes)
}
