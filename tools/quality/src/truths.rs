//! Truths that are kept: a view of many samples per pixel takes up to a minute, and is the same in every run.
//!
//! A file is named by a hash of everything that decides it and holds `[height][width][3]` little-endian f32, linear
//! Rec. 709.

use std::ops::Range;
use std::path::Path;

use crate::exact::supersampled;
use crate::random::fold;
use hedgehop::encode::atomic::write_bytes;
use hedgehop::render::RenderOptions;
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};

/// Bytes of a pixel.
const PIXEL: usize = 12;

/// A folder of truths with `samples` × `samples` samples per pixel.
#[derive(Debug, Clone, Copy)]
pub struct Truths<'a> {
    /// Folder in which they are kept.
    pub folder: &'a Path,
    /// Side of the grid of samples in a pixel.
    pub samples: u32,
    /// Columns of the picture that are looked at; `None`: all.
    pub columns: Option<u32>,
}

impl Truths<'_> {
    /// Returns the columns of a view that are looked at: those in its middle.
    pub fn columns_of(&self, camera: &Camera) -> Range<u32> {
        let count = self.columns.unwrap_or(camera.width).min(camera.width);
        let first = (camera.width - count) / 2;
        first..first + count
    }

    /// The truth of a view, and whether it had to be computed.
    pub fn get(
        &self,
        source: &dyn PageSource,
        camera: &Camera,
        options: &RenderOptions,
        farm: &Farm,
    ) -> Result<(Vec<[f32; 3]>, bool)> {
        let file = self.folder.join(format!("truth-{:016x}.f32", self.key(source, camera, options)));
        let columns = self.columns_of(camera);
        let pixels = columns.len() * camera.height as usize;
        match std::fs::read(&file) {
            Ok(bytes) if bytes.len() == pixels * PIXEL => return Ok((decode(&bytes), false)),
            Ok(_) => return Err(Error::invalid(&file, "is cut short; remove it")),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(Error::io(&file, "read", error)),
        }
        let truth = supersampled(source, camera, options, columns, farm, self.samples)?.colour;
        let bytes: Vec<u8> = truth.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        write_bytes(&file, &bytes)?;
        Ok((truth, true))
    }

    /// A hash of the database, the view, the look and the samples.
    fn key(&self, source: &dyn PageSource, camera: &Camera, options: &RenderOptions) -> u64 {
        let said = format!(
            "light of posts, {} {:?} {}x{} {options:?} {}",
            source.header().content_hash,
            camera.pose,
            camera.width,
            camera.height,
            self.samples
        );
        // Whole pictures go by the name that they had before there were others.
        let said = self.columns.map_or(said.clone(), |columns| format!("{said} {columns} columns"));
        said.bytes().fold(0, |hash, byte| fold(hash, u64::from(byte)))
    }
}

fn decode(bytes: &[u8]) -> Vec<[f32; 3]> {
    let value = |at: &[u8]| f32::from_le_bytes([at[0], at[1], at[2], at[3]]);
    bytes
        .chunks_exact(PIXEL)
        .map(|pixel| [value(&pixel[..4]), value(&pixel[4..8]), value(&pixel[8..])])
        .collect()
}
