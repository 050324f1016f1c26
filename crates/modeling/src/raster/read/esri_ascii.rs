//! Esri ASCII grids: a header of `key value` lines, then `nrows` × `ncols` numbers from the north-west on, separated by
//! white space (lines mean nothing). A `.prj` beside it states the CRS.
//!
//! Opening reads the file once, to note where every group of rows begins and whether all numbers are integers; after that only
//! the groups that a window needs are parsed. Integers become int32, anything else float32, as in GDAL (which only looks
//! at the first 100 KiB to decide; here the whole file counts).

mod tokens;

use std::path::Path;

use crate::raster::blocks::{Block, BlockIndex, BlockRaster, BlockSource, TO_TILES};
use crate::raster::file::InputFile;
use crate::raster::{
    GeoTransform, OpenOptions, Raster, RasterInfo, SampleType, georeference, nodata, side_files,
};
use hedgehop_base::Size;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};
use tokens::{Token, Tokens};

/// Samples per block, about.
const BLOCK_SAMPLES: u32 = 1 << 16;

/// Whether a file begins like one, or would if it were in UTF-8.
pub(in crate::raster) fn recognises(head: &[u8]) -> bool {
    // Of wide characters that are ASCII, and of a mark of UTF-8.
    let narrow: Vec<u8> = head.iter().copied().filter(|byte| byte.is_ascii() && *byte != 0).collect();
    let head = if unmarked(Path::new(""), head).is_ok_and(|rest| rest == head) { head } else { &narrow };
    let first = head.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
    first.eq_ignore_ascii_case(b"ncols") || first.eq_ignore_ascii_case(b"nrows")
}

/// A grid whose groups of rows are parsed when they are needed.
struct AsciiGrid {
    file: InputFile,
    info: RasterInfo,
    /// Byte where each group of `info.block.height` rows begins.
    groups: Vec<u64>,
}

/// Opens a grid.
pub(in crate::raster) fn open(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let mut tokens = Tokens::new(&file, text_begin(&file)?)?;
    let mut header = AsciiHeader::default();
    let first_value = header.parse(&mut tokens)?;
    let size = header.size(file.path())?;
    let Size { width, height } = size;
    let block_rows = (BLOCK_SAMPLES / width).clamp(1, height);
    let (groups, integers) = index(tokens, first_value, size, block_rows)?;
    let stated = header.nodata.as_deref().unwrap_or("-9999");
    let whole = integers && stated.parse::<i32>().is_ok();
    let sample = if whole { SampleType::I32 } else { SampleType::F32 };

    let nodata = match &header.nodata {
        Some(text) => nodata::parse(text, sample).map_err(|text| {
            Error::invalid(file.path(), format!("states {text:?} as its NODATA_value; give a number"))
        })?,
        None => None,
    };

    let mut info = RasterInfo {
        width,
        height,
        sample,
        geo: Some(header.geo(file.path(), height)?),
        nodata,
        block: Size { width, height: block_rows },
        ..RasterInfo::blank(file.path(), "Esri ASCII grid")
    };

    side_files::complete(&mut info)?;
    let grid = AsciiGrid { file, info, groups };
    Ok(Box::new(BlockRaster::new(grid, options.cache_bytes, TO_TILES)?))
}

/// Finds where the text begins: behind a mark of its encoding.
fn text_begin(file: &InputFile) -> Result<u64> {
    let head = file.head(4)?;
    Ok((head.len() - unmarked(file.path(), &head)?.len()) as u64)
}

#[derive(Debug, Default)]
struct AsciiHeader {
    columns: Option<u32>,
    rows: Option<u32>,
    x: Option<(f64, bool)>,
    y: Option<(f64, bool)>,
    step_x: Option<f64>,
    step_y: Option<f64>,
    nodata: Option<String>,
}

impl AsciiHeader {
    /// Takes the header's keys and values and returns the first number after them.
    fn parse(&mut self, tokens: &mut Tokens<'_>) -> Result<Token> {
        loop {
            let key = tokens.expect()?;
            if !key.text.starts_with(|c: char| c.is_ascii_alphabetic())
                || key.text.eq_ignore_ascii_case("nan")
            {
                return Ok(key);
            }
            let value = tokens.expect()?;
            self.set(&key.text.to_ascii_lowercase(), &value.text).ok_or_else(|| {
                let what = format!(
                    "states {} {} at byte {}, which is no sound header",
                    key.text, value.text, key.at
                );
                Error::invalid(tokens.path, what)
            })?;
        }
    }

    fn set(&mut self, key: &str, value: &str) -> Option<()> {
        let number = || value.parse::<f64>().ok().filter(|number| number.is_finite());
        let step = || number().filter(|step| *step > 0.0);
        match key {
            "ncols" => self.columns = Some(value.parse().ok()?),
            "nrows" => self.rows = Some(value.parse().ok()?),
            "xllcorner" => self.x = Some((number()?, false)),
            "xllcenter" | "xllcentre" => self.x = Some((number()?, true)),
            "yllcorner" => self.y = Some((number()?, false)),
            "yllcenter" | "yllcentre" => self.y = Some((number()?, true)),
            "cellsize" => (self.step_x, self.step_y) = (Some(step()?), Some(step()?)),
            "dx" => self.step_x = Some(step()?),
            "dy" => self.step_y = Some(step()?),
            "nodata_value" | "nodata" => self.nodata = Some(value.to_owned()),
            _ => return None,
        }
        Some(())
    }

    fn size(&self, path: &Path) -> Result<Size> {
        match (self.columns, self.rows) {
            (Some(width), Some(height)) if width > 0 && height > 0 => Ok(Size { width, height }),
            _ => Err(Error::invalid(path, "states no ncols and nrows above zero in its header")),
        }
    }

    fn geo(&self, path: &Path, rows: u32) -> Result<GeoTransform> {
        let missing = || Error::invalid(path, "lacks xllcorner, yllcorner or cellsize in its header");
        let (step_x, step_y) = (self.step_x.ok_or_else(missing)?, self.step_y.ok_or_else(missing)?);
        let corner = |value: Option<(f64, bool)>, step: f64| {
            value.map(|(value, centre)| if centre { value - step / 2.0 } else { value }).ok_or_else(missing)
        };
        let (x, y) = (corner(self.x, step_x)?, corner(self.y, step_y)?);
        let geo = [x, step_x, 0.0, y + f64::from(rows) * step_y, 0.0, -step_y];
        if georeference::is_sound(&geo) { Ok(geo) } else { Err(missing()) }
    }
}

/// Notes where each group of rows begins; also whether all numbers are integers of 32 bits.
fn index(mut tokens: Tokens<'_>, first: Token, size: Size, block_rows: u32) -> Result<(Vec<u64>, bool)> {
    let total = u64::from(size.width) * u64::from(size.height);
    // Each number takes a digit and, but for the last, a space.
    if total.saturating_mul(2) > tokens.length.saturating_sub(first.at).saturating_add(1) {
        let what = format!(
            "is too short to hold {} × {} numbers; it is cut short or its header is wrong",
            size.width, size.height
        );
        return Err(Error::invalid(tokens.path, what));
    }

    let group = u64::from(size.width) * u64::from(block_rows);
    let mut groups = Vec::new();
    let mut integers = true;
    let mut token = first;

    for number in 0..total {
        if number > 0 && !tokens.next(&mut token)? {
            let what = format!(
                "ends after {number} of {} × {} numbers; it is cut short, fetch it again",
                size.width, size.height
            );
            return Err(Error::invalid(tokens.path, what));
        }

        if number % group == 0 {
            groups.push(token.at);
        }
        integers = integers && token.text.parse::<i32>().is_ok();
        if !integers {
            tokens.number(&token)?;
        }
    }

    if tokens.next(&mut token)? {
        let what = format!(
            "goes on after {} × {} numbers, at byte {}; its header is wrong",
            size.width, size.height, token.at
        );
        return Err(Error::invalid(tokens.path, what));
    }

    Ok((groups, integers))
}

impl BlockSource for AsciiGrid {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn decode(&self, index: BlockIndex) -> Result<Block> {
        let begin = self.groups.get(index.row as usize).copied().unwrap_or_default();
        let block_rows = self.info.block.height;
        let rows = block_rows.min(self.info.height - index.row * block_rows);
        let count = rows as usize * self.info.width as usize;
        let mut tokens = Tokens::new(&self.file, begin)?;
        let mut bytes = Vec::with_capacity(count * self.info.sample.bytes());
        for _ in 0..count {
            let token = tokens.expect()?;
            let number = tokens.number(&token)?;
            match self.info.sample {
                SampleType::I32 => bytes.extend((number as i32).to_ne_bytes()),
                _ => bytes.extend((number as f32).to_ne_bytes()),
            }
        }
        Ok(Block::Samples { bytes, stride: self.info.width })
    }
}

#[cfg(test)]
mod tests {
    use crate::raster::{OpenOptions, RasterInfo, SampleType, Window, open};
    use hedgehop_base::error::Result;

    fn read(text: &str, cache_bytes: u64) -> Result<(RasterInfo, Vec<f64>)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.asc");
        std::fs::write(&path, text).unwrap();
        let raster = open(&path, &OpenOptions { cache_bytes, raw: None, classes: false })?;
        let info = raster.info().clone();
        let mut samples = Vec::new();
        raster.read(Window { x: 0, y: 0, width: info.width, height: info.height }, &[0], &mut samples)?;
        Ok((info, samples))
    }

    #[test]
    fn integers_wrapped_over_lines() {
        let (info, samples) = read(
            "NCOLS 3\r\nNROWS 2\r\nXLLCENTER 10.5\r\nYLLCENTER 20.5\r\nCELLSIZE 1\r\nNODATA_value -1\r\n1 2\r\n3 4\r\n5 -1",
            1 << 20,
        )
        .unwrap();
        assert_eq!(samples, [1.0, 2.0, 3.0, 4.0, 5.0, -1.0]);
        assert_eq!(info.geo, Some([10.0, 1.0, 0.0, 22.0, 0.0, -1.0]));
        assert_eq!((info.sample, info.nodata), (SampleType::I32, Some(-1.0)));
    }

    #[test]
    fn words_across_the_read_buffer() {
        let columns = 100_000;
        let mut text = format!("ncols {columns}\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n");
        let value = |i: usize| format!("{:.3} ", i as f64 / 7.0);
        text.extend((0..2 * columns).map(value));
        let (info, samples) = read(&text, 1 << 20).unwrap();
        assert_eq!(info.sample, SampleType::F32);
        for (i, sample) in samples.iter().enumerate() {
            assert_eq!(*sample, f64::from(value(i).trim().parse::<f32>().unwrap()));
        }
    }

    #[test]
    fn wrong_files() {
        let header = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
        for (body, says) in [
            ("1 2 3", "too short"),
            ("1 2 3       ", "3 of 2 × 2"),
            ("1 2 3 4 5", "goes on"),
            ("1 2 x3 4", "no number"),
            ("1 2 3.3.3 4", "no number"),
            ("1 2 é 4", "no number"),
        ] {
            let error = read(&format!("{header}{body}"), 1 << 20).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
        assert!(read("ncols 4000000000\nnrows 4000000000\nxllcorner 0\n", 1 << 20).is_err());
        assert!(read(&format!("{header}1 2 3 4"), 4).unwrap_err().to_string().contains("--memory"));
    }
}
