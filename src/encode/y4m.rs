//! YUV4MPEG2: uncompressed video for a pipe, `hedgehop render … -o - | ffmpeg -i - out.mp4`.
//!
//! Y′CbCr by ITU-R BT.709-6, 3.2–3.4, limited range (Y′ 16–235, C 16–240), from the sRGB-coded values as
//! they are. With K = 2126 R + 7152 G + 722 B over the 8-bit codes:
//!
//! ```text
//! Y  =  16 + 219 K / (255 · 10000)
//! Cb = 128 + 224 (10000 B − K) / (255 · 2 · 9278)
//! Cr = 128 + 224 (10000 R − K) / (255 · 2 · 7874)
//! ```
//!
//! All of it in integers of 32 bits, rounded to nearest once, hence the same on every machine. At 4:2:0 a chroma
//! sample is the mean of its 2×2 pixels (`C420jpeg`, sited in the middle), of fewer at an odd edge.
//! The format cannot say which matrix was used; it is tagged `XCOLORRANGE=LIMITED`.

use std::io::{self, Write};
use std::path::Path;

use crate::flight::FrameRate;
use crate::frame::Picture;
use crate::simd::{Isa, Kernel, Simd};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Number of pixels that share a chroma sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Chroma {
    /// 4:2:0, what players decode.
    #[default]
    Shared,
    /// 4:4:4, one per pixel.
    Full,
}

/// Writes frames of one size to a stream.
pub struct Y4mWriter<W: Write> {
    encoder: y4m::Encoder<W>,
    width: usize,
    height: usize,
    chroma: Chroma,
    planes: Planes,
}

/// Codes of a frame, and memory for sums.
#[derive(Default)]
struct Planes {
    /// Y, Cb and Cr, each `[row][column]` of its samples.
    codes: [Vec<u8>; 3],
    /// Red, green and blue codes of one or two rows added up, `[column]`.
    column_sums: Vec<[u32; 3]>,
}

impl<W: Write> std::fmt::Debug for Y4mWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Y4mWriter({}×{}, {:?})", self.width, self.height, self.chroma)
    }
}

impl<W: Write> Y4mWriter<W> {
    /// Writes the stream's header; pictures of `size` pixels, at least 1 a side.
    pub fn new(writer: W, size: Size, rate: FrameRate, chroma: Chroma) -> io::Result<Self> {
        let (width, height) = (size.width as usize, size.height as usize);
        if width == 0 || height == 0 || width.checked_mul(height).is_none_or(|pixels| pixels > usize::MAX / 4)
        {
            let what = format!("a picture of {width}×{height} pixels");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        let colorspace = match chroma {
            Chroma::Shared => y4m::Colorspace::C420jpeg,
            Chroma::Full => y4m::Colorspace::C444,
        };
        let ratio = y4m::Ratio::new(rate.numerator() as usize, rate.denominator() as usize);
        let range = y4m::VendorExtensionString::new(b"COLORRANGE=LIMITED".to_vec()).map_err(plain)?;
        let encoder = y4m::encode(width, height, ratio)
            .with_colorspace(colorspace)
            .append_vendor_extension(range)
            .write_header(writer)
            .map_err(plain)?;
        Ok(Self { encoder, width, height, chroma, planes: Default::default() })
    }

    /// Writes one frame, `r g b r g b …` in sRGB, `[height][width]`.
    pub fn write(&mut self, rgb: &[u8]) -> io::Result<()> {
        if rgb.len() != self.width * self.height * 3 {
            let what = format!("{} bytes are no frame of {}×{} pixels", rgb.len(), self.width, self.height);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }

        let (pixels, _) = rgb.as_chunks::<3>();
        let (width, chroma) = (self.width, self.chroma);
        Isa::best().run(Conversion { pixels, width, chroma, planes: &mut self.planes });
        let [luma, blue, red] = &self.planes.codes;
        self.encoder.write_frame(&y4m::Frame::new([luma, blue, red], None)).map_err(plain)
    }

    /// Writes one picture; its size must be that of the stream.
    pub fn write_picture(&mut self, path: &Path, picture: &Picture) -> Result<()> {
        if (picture.width as usize, picture.height as usize) != (self.width, self.height) {
            let what = format!(
                "a picture of {}×{} in a stream of {}×{}; render all frames with one --size",
                picture.width, picture.height, self.width, self.height
            );
            return Err(Error::invalid(path, what));
        }
        self.write(&picture.rgb).map_err(|source| crate::encode::atomic::write_error(path, source))
    }
}

/// Conversion of a frame. Its loops are plain, and are compiled for each instruction set.
struct Conversion<'p> {
    pixels: &'p [[u8; 3]],
    width: usize,
    chroma: Chroma,
    planes: &'p mut Planes,
}

impl Kernel for Conversion<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, _: V) {
        let Self { pixels, width, chroma, planes: Planes { codes, column_sums } } = self;
        let samples = match chroma {
            Chroma::Full => pixels.len(),
            Chroma::Shared => width.div_ceil(2) * (pixels.len() / width).div_ceil(2),
        };
        let [luma, blue, red] = codes;
        luma.resize(pixels.len(), 0);
        blue.resize(samples, 0);
        red.resize(samples, 0);

        for (code, pixel) in luma.iter_mut().zip(pixels) {
            *code = luma_code(pixel);
        }

        match chroma {
            Chroma::Full => {
                for ((blue, red), pixel) in blue.iter_mut().zip(red).zip(pixels) {
                    [*blue, *red] = chroma_codes::<1>([pixel[0].into(), pixel[1].into(), pixel[2].into()]);
                }
            }
            Chroma::Shared => {
                column_sums.resize(width, [0; 3]);
                let samples = blue.chunks_mut(width.div_ceil(2)).zip(red.chunks_mut(width.div_ceil(2)));
                for (rows, (blue, red)) in pixels.chunks(2 * width).zip(samples) {
                    shared_chroma(rows, column_sums, [blue, red]);
                }
            }
        }
    }
}

/// Chroma of one or two rows of as many pixels as `sums` has columns.
#[inline(always)]
fn shared_chroma(rows: &[[u8; 3]], sums: &mut [[u32; 3]], [blue, red]: [&mut [u8]; 2]) {
    let (upper, lower) = rows.split_at(sums.len());
    if lower.is_empty() {
        for (sum, pixel) in sums.iter_mut().zip(upper) {
            *sum = [pixel[0].into(), pixel[1].into(), pixel[2].into()];
        }
        return mean_chroma::<2, 1>(sums, [blue, red]);
    }

    for ((sum, upper), lower) in sums.iter_mut().zip(upper).zip(lower) {
        *sum = [0, 0, 0];
        for channel in 0..3 {
            sum[channel] = u32::from(upper[channel]) + u32::from(lower[channel]);
        }
    }
    mean_chroma::<4, 2>(sums, [blue, red]);
}

/// Chroma of the means of two columns each, which are `PIXELS`, and of the last one of an odd number, which is of `LAST`.
#[inline(always)]
fn mean_chroma<const PIXELS: u32, const LAST: u32>(sums: &[[u32; 3]], [blue, red]: [&mut [u8]; 2]) {
    let (pairs, last) = sums.as_chunks::<2>();
    for ((blue, red), [one, other]) in blue.iter_mut().zip(red.iter_mut()).zip(pairs) {
        let sum = [one[0] + other[0], one[1] + other[1], one[2] + other[2]];
        [*blue, *red] = chroma_codes::<PIXELS>(sum);
    }
    if let ([sum], Some(blue), Some(red)) = (last, blue.last_mut(), red.last_mut()) {
        [*blue, *red] = chroma_codes::<LAST>(*sum);
    }
}

#[inline(always)]
fn luma_code(pixel: &[u8; 3]) -> u8 {
    // 219 and 255 · 10000 by their common factor, twice for rounding, and 16 more.
    const UNIT: u32 = 1_700_000;
    let weighted = weighted([pixel[0].into(), pixel[1].into(), pixel[2].into()]);
    ((146 * weighted + UNIT / 2 + 16 * UNIT) / UNIT) as u8
}

/// Cb and Cr of the mean of so many pixels, up to 4, whose codes add up to `sum`.
#[inline(always)]
fn chroma_codes<const PIXELS: u32>(sum: [u32; 3]) -> [u8; 2] {
    let luma = weighted(sum);
    [chroma_code(sum[2], luma, 4639 * PIXELS), chroma_code(sum[0], luma, 3937 * PIXELS)]
}

/// Code of a part of light against the luma of the same pixels; `rest` is half of what the weights of the other parts add up to, times the pixels.
#[inline(always)]
fn chroma_code(part: u32, luma: u32, rest: u32) -> u8 {
    // 224 and 255 · 2 · 2 `rest` by their common factor, twice for rounding; what 128 adds makes all of it positive.
    let unit = 2 * 255 * rest;
    let positive = 128 * unit + unit / 2 + 2 * 56 * 10_000 * part;
    ((positive - 2 * 56 * luma) / unit) as u8
}

#[inline(always)]
fn weighted([red, green, blue]: [u32; 3]) -> u32 {
    2126 * red + 7152 * green + 722 * blue
}

fn plain(error: y4m::Error) -> io::Error {
    match error {
        y4m::Error::IoError(source) => source,
        y4m::Error::EOF => io::Error::from(io::ErrorKind::UnexpectedEof),
        other => io::Error::other(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use crate::encode::y4m::*;

    fn stream(size: Size, rate: &str, chroma: Chroma, frames: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Y4mWriter::new(&mut bytes, size, rate.parse().unwrap(), chroma).unwrap();
        for frame in frames {
            writer.write(frame).unwrap();
        }
        bytes
    }

    fn planes(bytes: &[u8]) -> Vec<[Vec<u8>; 3]> {
        let mut decoder = y4m::decode(bytes).unwrap();
        let mut frames = Vec::new();
        while let Ok(frame) = decoder.read_frame() {
            frames.push([frame.get_y_plane(), frame.get_u_plane(), frame.get_v_plane()].map(<[u8]>::to_vec));
        }
        frames
    }

    #[test]
    fn the_header_says_size_exact_rate_range_and_sampling() {
        let bytes = stream(Size { width: 3, height: 2 }, "23.976", Chroma::Shared, &[]);
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "YUV4MPEG2 W3 H2 F24000:1001 XCOLORRANGE=LIMITED C420jpeg\n"
        );
    }

    /// The published codes of full and 75 % primaries, EBU/SMPTE colour bars in BT.709.
    #[test]
    fn known_colours() {
        for (pixel, expected) in [
            ([255, 255, 255], [235, 128, 128]),
            ([0, 0, 0], [16, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
            ([255, 255, 0], [219, 16, 138]),
            ([128, 128, 128], [126, 128, 128]),
        ] {
            let [frame] =
                &planes(&stream(Size { width: 1, height: 1 }, "25", Chroma::Full, &[pixel.to_vec()]))[..]
            else {
                panic!("one frame");
            };
            assert_eq!(frame.concat(), expected, "{pixel:?}");
        }
    }

    #[test]
    fn every_code_is_in_range_and_near_the_real_formula() {
        for step in 0..17 * 17 * 17 {
            let pixel = [step % 17, step / 17 % 17, step / 289].map(|part: u32| (part * 15) as u8);
            let codes = pixel.map(f64::from);
            let all = |pixels: u32| pixel.map(|code| pixels * u32::from(code));
            for [cb, cr] in [chroma_codes::<1>(all(1)), chroma_codes::<2>(all(2)), chroma_codes::<4>(all(4))]
            {
                for (code, exact) in [luma_code(&pixel), cb, cr].into_iter().zip(exact(codes)) {
                    assert!((f64::from(code) - exact).abs() <= 0.5 + 1e-9, "{pixel:?}: {code} {exact}");
                    assert!((16..=240).contains(&code));
                }
            }
        }
    }

    /// Codes by the module's formulas as they stand, in 64 bits, halves rounded up.
    fn as_written(sum: [i64; 3], count: i64) -> [u8; 3] {
        let rounded =
            |numerator: i64, denominator: i64| (2 * numerator + denominator).div_euclid(2 * denominator);
        let luma = 2126 * sum[0] + 7152 * sum[1] + 722 * sum[2];
        let chroma = |part: i64, weight: i64| {
            128 + rounded(224 * (10_000 * part - luma), 255 * 2 * (10_000 - weight) * count)
        };
        let luma = 16 + rounded(219 * luma, 255 * 10_000 * count);
        [luma, chroma(sum[2], 722), chroma(sum[0], 2126)].map(|code| code as u8)
    }

    proptest::proptest! {
        #[test]
        fn frames_are_as_the_formulas_say(
            size in (1_usize..40, 1_usize..6),
            bytes in proptest::collection::vec(proptest::num::u8::ANY, 40 * 6 * 3),
        ) {
            let (width, height) = size;
            let frame = &bytes[..3 * width * height];
            let size = Size { width: width as u32, height: height as u32 };
            let (pixels, _) = frame.as_chunks::<3>();
            let full = &planes(&stream(size, "25", Chroma::Full, &[frame.to_vec()]))[0];
            let shared = &planes(&stream(size, "25", Chroma::Shared, &[frame.to_vec()]))[0];
            assert_eq!(full[0], shared[0]);
            for (index, pixel) in pixels.iter().enumerate() {
                assert_eq!([0, 1, 2].map(|plane| full[plane][index]), as_written(pixel.map(i64::from), 1));
            }

            for (index, (&cb, &cr)) in shared[1].iter().zip(&shared[2]).enumerate() {
                let (column, row) = (2 * (index % width.div_ceil(2)), 2 * (index / width.div_ceil(2)));
                let (mut sum, mut count) = ([0; 3], 0);
                for y in row..(row + 2).min(height) {
                    for pixel in &pixels[y * width + column..y * width + (column + 2).min(width)] {
                        sum.iter_mut().zip(pixel).for_each(|(sum, &code)| *sum += i64::from(code));
                        count += 1;
                    }
                }
                assert_eq!([cb, cr], as_written(sum, count)[1..]);
            }
        }
    }

    /// Y, Cb and Cr by the formulas of BT.709, of codes that may be means.
    fn exact(codes: [f64; 3]) -> [f64; 3] {
        let [red, green, blue] = codes.map(|code| code / 255.0);
        let luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        [16.0 + 219.0 * luma, 128.0 + 224.0 * (blue - luma) / 1.8556, 128.0 + 224.0 * (red - luma) / 1.5748]
    }

    #[test]
    fn odd_sizes_share_what_is_there() {
        // Red and green, blue and green; below, grey and a red.
        let frame = vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 255, 0, 9, 9, 9, 200, 9, 9];
        let both = vec![frame.clone(), frame];
        let frames = planes(&stream(Size { width: 2, height: 3 }, "25", Chroma::Shared, &both));
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[0], frames[1]);
        let [luma, cb, cr] = &frames[0];
        assert_eq!((luma.len(), cb.len(), cr.len()), (6, 2, 2));
        for (block, mean) in [(0, [63.75, 127.5, 63.75]), (1, [104.5, 9.0, 9.0])] {
            let [_, exact_cb, exact_cr] = exact(mean);
            assert!((f64::from(cb[block]) - exact_cb).abs() <= 0.5, "{} {exact_cb}", cb[block]);
            assert!((f64::from(cr[block]) - exact_cr).abs() <= 0.5, "{} {exact_cr}", cr[block]);
        }
        let narrow = planes(&stream(Size { width: 1, height: 1 }, "25", Chroma::Shared, &[vec![255, 0, 0]]));
        assert_eq!(narrow[0].concat(), [63, 102, 240]);
    }

    #[test]
    fn frames_of_another_size_and_full_disks_are_errors() {
        let mut bytes = Vec::new();
        let rate = "25".parse().unwrap();
        let mut writer =
            Y4mWriter::new(&mut bytes, Size { width: 4, height: 4 }, rate, Chroma::Full).unwrap();
        assert!(writer.write(&[0; 47]).is_err());
        assert!(Y4mWriter::new(Vec::new(), Size { width: 0, height: 4 }, rate, Chroma::Full).is_err());
        let path = Path::new("0001.png");
        let other = Picture { width: 2, height: 8, rgb: vec![0; 48] };
        assert!(writer.write_picture(path, &other).unwrap_err().to_string().contains("--size"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_one_sentence() {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let error = Y4mWriter::new(full, Size { width: 4, height: 4 }, "25".parse().unwrap(), Chroma::Full)
            .unwrap_err();
        let message = crate::encode::atomic::write_error(Path::new("flight.y4m"), error).to_string();
        assert!(message.contains("flight.y4m") && message.contains("free some space"), "{message}");
    }
}
