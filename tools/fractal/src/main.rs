//! Writes a square of fractal terrain as a float32 BigTIFF of 1 m posts, strip by strip, so that its size is bounded by the
//! disk alone.
//!
//! `cargo run --release -p hedgehop-fractal -- 53504 7 big.tif`, then `hedgehop build --elevation big.tif --local -o big.hop`:
//! 16 GiB of database. The same side and seed give the same bytes on every machine.

mod octave;

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use octave::Octave;
use tiff::encoder::{TiffEncoder, colortype::Gray32Float};
use tiff::tags::Tag;

/// Rows of a strip.
const STRIP: u32 = 256;
/// Wavelengths of the coarsest and the finest octave, metres.
const WAVELENGTHS: [u32; 2] = [4096, 2];
/// Height of the coarsest octave, metres. Each finer one is half as high: power falls with the fourth power of frequency.
const AMPLITUDE: f32 = 260.0;
/// Height about which the terrain lies, metres.
const MEAN: f32 = 400.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [side, seed, path] = arguments.as_slice() else {
        return Err("usage: hedgehop-fractal SIDE SEED OUT.tif".into());
    };
    write(side.parse()?, seed.parse()?, Path::new(path))
}

fn write(side: u32, seed: u64, path: &Path) -> Result<(), Box<dyn Error>> {
    let octaves = octaves(seed);
    let mut encoder = TiffEncoder::new_big(BufWriter::new(File::create(path)?))?;
    let mut image = encoder.new_image::<Gray32Float>(side, side)?;
    image.rows_per_strip(STRIP)?;
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, [1.0, 1.0, 0.0].as_slice())?;
    tags.write_tag(Tag::ModelTiepointTag, [0.0, 0.0, 0.0, 0.0, f64::from(side), 0.0].as_slice())?;
    let mut strip = Vec::new();
    for top in (0..side).step_by(STRIP as usize) {
        strip.resize(side as usize * STRIP.min(side - top) as usize, 0.0);
        fill(&octaves, top, side as usize, &mut strip);
        image.write_strip(&strip)?;
    }
    Ok(image.finish()?)
}

fn octaves(seed: u64) -> Vec<Octave> {
    let [coarsest, finest] = WAVELENGTHS.map(u32::ilog2);
    let octave = |log: u32| {
        let share = 0.5_f32.powi((coarsest - log) as i32);
        Octave::new(log, AMPLITUDE * share, seed ^ u64::from(log) << 32)
    };
    (finest..=coarsest).rev().map(octave).collect()
}

/// Heights of rows from `top` on, on all cores.
fn fill(octaves: &[Octave], top: u32, width: usize, strip: &mut [f32]) {
    let rows = strip.len() / width;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = rows.div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        for (part, block) in strip.chunks_mut(share * width).enumerate() {
            scope.spawn(move || {
                for (row, heights) in block.chunks_mut(width).enumerate() {
                    heights.fill(MEAN);
                    octaves.iter().for_each(|octave| octave.add(top + (part * share + row) as u32, heights));
                }
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heights(seed: u64, top: u32, width: usize, rows: usize) -> Vec<f32> {
        let mut strip = vec![0.0; width * rows];
        fill(&octaves(seed), top, width, &mut strip);
        strip
    }

    #[test]
    fn terrain_is_the_same_however_it_is_cut_and_goes_on_smoothly() {
        let (all, below) = (heights(3, 0, 600, 20), heights(3, 12, 600, 8));
        assert_eq!(all[12 * 600..], below);
        assert_ne!(all, heights(4, 0, 600, 20));
        let steps = all.chunks(600).flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
        let steepest = steps.fold(0.0, f32::max);
        assert!((0.1..4.0).contains(&steepest), "{steepest}");
    }

    #[test]
    fn a_file_holds_the_heights() {
        let path = std::env::temp_dir().join(format!("hedgehop-fractal-{}.tif", std::process::id()));
        write(300, 5, &path).unwrap();
        let mut decoder = tiff::decoder::Decoder::new(File::open(&path).unwrap()).unwrap();
        let read = decoder.read_image().unwrap();
        std::fs::remove_file(&path).unwrap();
        let tiff::decoder::DecodingResult::F32(read) = read else { panic!("no float32") };
        assert_eq!(read, heights(5, 0, 300, 300));
    }
}
