//! Writes a square of fractal terrain as a float32 BigTIFF of 1 m posts, strip by strip, so that its size is bounded by the
//! disk alone; or a part of it, or every so many posts.
//!
//! `cargo run --release -p hedgehop-fractal -- 53504 7 big.tif`, then `hedgehop build --elevation big.tif --local -o big.hop`:
//! 16 GiB of database. The same side and seed give the same bytes on every machine.
//!
//! `hedgehop-fractal 200000 7 area.tif --spacing 16` and `hedgehop-fractal 200000 7 strip.tif --part 0,99000,200000,101000` are
//! of the same terrain, the first without what is finer than its posts tell.

mod octave;

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use tiff::encoder::{TiffEncoder, colortype::Gray32Float};
use tiff::tags::Tag;

use octave::Octave;

/// Rows of a strip.
const STRIP: u32 = 256;
/// Wavelengths of the coarsest and the finest octave, metres.
const WAVELENGTHS: [u32; 2] = [4096, 2];
/// Height of the coarsest octave, metres. Each finer one is half as high: power falls with the fourth power of frequency.
const AMPLITUDE: f32 = 260.0;
/// Height about which the terrain lies, metres.
const MEAN: f32 = 400.0;

/// Part of the square that is written, and its density.
#[derive(Debug, Clone, Copy)]
struct Part {
    /// Side of the whole square, metres.
    side: u32,
    /// West, south, east and north edge, metres.
    bounds: [u32; 4],
    /// Metres from post to post.
    spacing: u32,
}

impl Part {
    /// Posts (columns, rows).
    fn size(&self) -> (u32, u32) {
        let [west, south, east, north] = self.bounds;
        ((east - west) / self.spacing, (north - south) / self.spacing)
    }

    /// Column and row of a post of the part in the square's posts of 1 m: the one in the middle, or the next to the south-east.
    fn post(&self, [column, row]: [u32; 2]) -> [u32; 2] {
        let [west, _, _, north] = self.bounds;
        [(west, column), (self.side - north, row)]
            .map(|(first, index)| first + index * self.spacing + self.spacing / 2)
    }

    /// World position of the north-west corner of the first post's pixel.
    fn corner(&self) -> [f64; 2] {
        let [column, row] = self.post([0, 0]).map(|post| f64::from(post) + 0.5);
        let half = 0.5 * f64::from(self.spacing);
        [column - half, f64::from(self.side) - row + half]
    }
}

const USAGE: &str =
    "usage: hedgehop-fractal SIDE SEED OUT.tif [--part WEST,SOUTH,EAST,NORTH] [--spacing METRES]";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [side, seed, path, flags @ ..] = arguments.as_slice() else { return Err(USAGE.into()) };
    write(part(side.parse()?, flags)?, seed.parse()?, Path::new(path))
}

fn part(side: u32, flags: &[String]) -> Result<Part, Box<dyn Error>> {
    let mut part = Part { side, bounds: [0, 0, side, side], spacing: 1 };
    for flag in flags.chunks(2) {
        match flag {
            [name, value] if name == "--spacing" => part.spacing = value.parse()?,
            [name, value] if name == "--part" => {
                let edges: Result<Vec<u32>, _> = value.split(',').map(str::parse).collect();
                part.bounds = edges?.try_into().map_err(|_| USAGE)?;
            }
            _ => return Err(USAGE.into()),
        }
    }
    let [west, south, east, north] = part.bounds;
    let is_inside = west < east && south < north && east <= side && north <= side;
    if !is_inside || part.spacing == 0 || part.size().0.min(part.size().1) == 0 {
        return Err("the part is none of the square, or has no post".into());
    }
    Ok(part)
}

fn write(part: Part, seed: u64, path: &Path) -> Result<(), Box<dyn Error>> {
    let octaves = octaves(seed);
    let (width, height) = part.size();
    let mut encoder = TiffEncoder::new_big(BufWriter::new(File::create(path)?))?;
    let mut image = encoder.new_image::<Gray32Float>(width, height)?;
    image.rows_per_strip(STRIP)?;
    let tags = image.encoder();
    let (pixel, [west, north]) = (f64::from(part.spacing), part.corner());
    tags.write_tag(Tag::ModelPixelScaleTag, [pixel, pixel, 0.0].as_slice())?;
    tags.write_tag(Tag::ModelTiepointTag, [0.0, 0.0, 0.0, west, north, 0.0].as_slice())?;
    let mut strip = Vec::new();
    for top in (0..height).step_by(STRIP as usize) {
        strip.resize(width as usize * STRIP.min(height - top) as usize, 0.0);
        fill(&octaves, &part, top, &mut strip);
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

/// Heights of the part's rows from `top` on, on all cores.
fn fill(octaves: &[Octave], part: &Part, top: u32, strip: &mut [f32]) {
    let width = part.size().0 as usize;
    let rows = strip.len() / width;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = rows.div_ceil(threads).max(1);
    // Shorter waves than posts can tell would be noise.
    let told = |octave: &&Octave| octave.wavelength() >= 2 * part.spacing;
    std::thread::scope(|scope| {
        for (index, block) in strip.chunks_mut(share * width).enumerate() {
            scope.spawn(move || {
                for (row, heights) in block.chunks_mut(width).enumerate() {
                    heights.fill(MEAN);
                    let post = part.post([0, top + (index * share + row) as u32]);
                    octaves.iter().filter(told).for_each(|octave| octave.add(post, part.spacing, heights));
                }
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heights(seed: u64, part: Part) -> Vec<f32> {
        let (width, rows) = part.size();
        let mut strip = vec![0.0; width as usize * rows as usize];
        fill(&octaves(seed), &part, 0, &mut strip);
        strip
    }

    fn square(side: u32) -> Part {
        part(side, &[]).unwrap()
    }

    #[test]
    fn terrain_is_the_same_however_it_is_cut_and_goes_on_smoothly() {
        let all = heights(3, square(600));
        let cut = Part { bounds: [200, 0, 600, 588], ..square(600) };
        for (row, cut) in heights(3, cut).chunks(400).enumerate() {
            assert_eq!(all[(12 + row) * 600 + 200..][..400], *cut);
        }
        assert_ne!(all, heights(4, square(600)));
        let steps = all.chunks(600).flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
        let steepest = steps.fold(0.0, f32::max);
        assert!((0.1..4.0).contains(&steepest), "{steepest}");
    }

    #[test]
    fn wide_posts_tell_the_same_terrain_where_they_lie() {
        let (all, wide) = (square(640), Part { spacing: 16, ..square(640) });
        let [west, north] = wide.corner();
        assert_eq!([west, north], [0.5, 639.5]);
        let (fine, wide) = (heights(3, all), heights(3, wide));
        for (index, height) in wide.iter().enumerate() {
            let (column, row) = (index % 40 * 16 + 8, index / 40 * 16 + 8);
            // Waves of less than 32 m are left out: 260 m / 2^8 and less.
            let difference = (fine[row * 640 + column] - height).abs();
            assert!(difference < 3.0, "{index}: {difference}");
        }
    }

    #[test]
    fn parts_that_are_none_are_refused() {
        let refused =
            |flags: &[&str]| part(100, &flags.iter().map(ToString::to_string).collect::<Vec<_>>()).is_err();
        for flags in [
            &["--part", "0,0,101,50"][..],
            &["--part", "5,0,5,9"],
            &["--spacing", "0"],
            &["--spacing", "200"],
            &["--part"],
        ] {
            assert!(refused(flags), "{flags:?}");
        }
    }

    #[test]
    fn a_file_holds_the_heights() {
        let path = std::env::temp_dir().join(format!("hedgehop-fractal-{}.tif", std::process::id()));
        write(square(300), 5, &path).unwrap();
        let mut decoder = tiff::decoder::Decoder::new(File::open(&path).unwrap()).unwrap();
        let read = decoder.read_image().unwrap();
        std::fs::remove_file(&path).unwrap();
        let tiff::decoder::DecodingResult::F32(read) = read else { panic!("no float32") };
        assert_eq!(read, heights(5, square(300)));
    }
}
