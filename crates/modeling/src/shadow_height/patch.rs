//! Parts of rasters around a building, by places turned to the sun.

use glam::{DMat2, DVec2, UVec2, dvec2, uvec2};

use super::super::kernel::Samples;
use super::super::warp::RasterPlacement;
use super::bounds::PlaceBounds;
use super::sunward::Sunward;
use crate::opened::Opened;
use crate::raster::Window;
use hedgehop::Size;
use hedgehop_base::colour::linear_of_codes;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, Transform};

/// Most samples of one part, and rows that are read at once.
const MOST_SAMPLES: usize = 16 << 20;
const ROWS: u32 = 64;

/// Samples beyond the rectangle on all sides, for interpolation.
const APRON: f64 = 2.0;

/// A raster where it lies.
pub(super) struct PlacedRaster<T> {
    pub samples: Box<dyn Samples<T>>,
    pub placement: RasterPlacement,
}

/// A part of a raster.
pub(super) struct RasterPatch<T> {
    /// First row, of each row the first column and where that lies in `samples`, and the end of the last.
    first: u32,
    rows: Vec<(u32, usize)>,
    samples: Vec<T>,
    /// The place of column 0, row 0 of the raster, and those of a step by a column and by a row.
    origin: DVec2,
    place_from_pixel: DMat2,
    pixel_from_place: DMat2,
}

/// Cut of a raster to a rectangle.
pub(super) enum Cut<T> {
    Part(RasterPatch<T>),
    Nothing,
    /// More samples than are taken.
    TooMany,
}

impl<T: Copy> PlacedRaster<T> {
    /// An opened raster under places of `crs`.
    ///
    /// # Errors
    /// One that is local where the other is not, and a geotransform that is none.
    pub fn new(raster: Opened<T>, crs: &Crs) -> Result<Self> {
        let transform = Transform::new(crs, &raster.crs)?;
        let placement = RasterPlacement::new(transform, &raster.geo, raster.samples.size())
            .ok_or_else(|| Error::invalid(&raster.path, "its geotransform maps the raster onto a line"))?;
        Ok(Self { samples: raster.samples, placement })
    }

    /// The part that lies under a rectangle of places turned to the sun.
    ///
    /// # Errors
    /// A raster that cannot be read.
    pub fn cut(&self, sun: &Sunward, bounds: PlaceBounds) -> Result<Cut<T>> {
        let PlaceBounds { low, high } = bounds;
        let Some((origin, place_from_pixel)) = self.local(sun, 0.5 * (low + high), high - low) else {
            return Ok(Cut::Nothing);
        };

        let pixel_from_place = place_from_pixel.inverse();
        let corners = [low, dvec2(high.x, low.y), high, dvec2(low.x, high.y)]
            .map(|corner| pixel_from_place * (corner - origin));
        let rows: Vec<f64> = corners.iter().map(|corner| corner.y).collect();
        let Size { width, height } = self.samples.size();
        let Some((first, last)) = range(&rows, height) else { return Ok(Cut::Nothing) };
        let spans: Vec<Option<(u32, u32)>> = (first..=last).map(|row| span(&corners, row, width)).collect();
        let count: usize = spans.iter().flatten().map(|(from, to)| (to - from + 1) as usize).sum();
        if count == 0 {
            return Ok(Cut::Nothing);
        }
        if count > MOST_SAMPLES {
            return Ok(Cut::TooMany);
        }

        let mut patch = RasterPatch {
            first,
            rows: Vec::with_capacity(spans.len() + 1),
            samples: Vec::with_capacity(count),
            origin,
            place_from_pixel,
            pixel_from_place,
        };

        let mut strip = Vec::new();
        for (y, spans) in (first..=last).step_by(ROWS as usize).zip(spans.chunks(ROWS as usize)) {
            let seen = || spans.iter().flatten();
            let (Some(from), Some(to)) = (seen().map(|span| span.0).min(), seen().map(|span| span.1).max())
            else {
                patch.rows.extend(spans.iter().map(|_| (0, patch.samples.len())));
                continue;
            };
            let window = Window { x: from, y, width: to - from + 1, height: spans.len() as u32 };
            self.samples.read(window, &mut strip)?;

            for (span, line) in spans.iter().zip(strip.chunks_exact(window.width as usize)) {
                let (column, line) = match span {
                    Some((column, end)) => (*column, &line[(column - from) as usize..=(end - from) as usize]),
                    None => (0, &[][..]),
                };
                patch.rows.push((column, patch.samples.len()));
                patch.samples.extend_from_slice(line);
            }
        }

        patch.rows.push((0, patch.samples.len()));
        Ok(Cut::Part(patch))
    }

    /// Columns and rows around a place as straight steps: the turned place of column 0, row 0, and the steps by a column and by a row.
    fn local(&self, sun: &Sunward, middle: DVec2, size: DVec2) -> Option<(DVec2, DMat2)> {
        let pixel = |place: DVec2| {
            let place = sun.place(place);
            self.placement.pixel_from_world(place.x, place.y).map(DVec2::from)
        };
        let step = 0.25 * size.max_element().max(1.0);
        let here = pixel(middle)?;
        let along =
            |axis: DVec2| Some((pixel(middle + axis * step)? - pixel(middle - axis * step)?) / (2.0 * step));
        let pixel_from_place = DMat2::from_cols(along(DVec2::X)?, along(DVec2::Y)?);
        let place_from_pixel = pixel_from_place.inverse();
        place_from_pixel.is_finite().then(|| (middle - place_from_pixel * here, place_from_pixel))
    }
}

/// Whole numbers from 0 to below `size` around some positions.
fn range(positions: &[f64], size: u32) -> Option<(u32, u32)> {
    let (low, high) = positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), position| {
        (low.min(*position), high.max(*position))
    });
    let (low, high) = ((low - APRON).floor().max(0.0), (high + APRON).ceil().min(f64::from(size) - 1.0));
    (low <= high).then_some((low as u32, high as u32))
}

/// Columns of a row that lie in or near a convex outline.
fn span(corners: &[DVec2; 4], row: u32, width: u32) -> Option<(u32, u32)> {
    let (bottom, top) = (f64::from(row) - APRON, f64::from(row) + APRON);
    let mut columns = Vec::with_capacity(8);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        if a.y.max(b.y) < bottom || a.y.min(b.y) > top {
            continue;
        }
        let at = |y: f64| {
            let share = if a.y == b.y { 0.0 } else { ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0) };
            a.x + share * (b.x - a.x)
        };
        let whole = a.y == b.y;
        columns.extend(if whole { [a.x, b.x] } else { [at(bottom), at(top)] });
    }
    range(&columns, width)
}

impl<T: Copy> RasterPatch<T> {
    /// Side of a pixel, metres: the root of its area.
    pub fn side(&self) -> f64 {
        self.place_from_pixel.determinant().abs().sqrt()
    }

    /// Metres of a step by columns and rows, turned.
    pub fn step(&self, columns: f64, rows: f64) -> DVec2 {
        self.place_from_pixel * dvec2(columns, rows)
    }

    /// Column and row of a place, whole numbers at pixel centres.
    fn pixel(&self, place: DVec2) -> DVec2 {
        self.pixel_from_place * (place - self.origin)
    }

    /// The sample of a column and row, which are whole numbers.
    fn sample(&self, pixel: DVec2) -> Option<T> {
        let row = pixel.y - f64::from(self.first);
        if !(row >= 0.0 && row + 1.0 < self.rows.len() as f64) {
            return None;
        }
        let ((first, from), (_, to)) = (self.rows[row as usize], self.rows[row as usize + 1]);
        let column = pixel.x - f64::from(first);
        (column >= 0.0 && column < (to - from) as f64).then(|| self.samples[from + column as usize])
    }
}

impl RasterPatch<[u8; 4]> {
    /// Whether a place is in the picture.
    pub fn shows(&self, place: DVec2) -> bool {
        self.sample(self.pixel(place).round()).is_some_and(|pixel| pixel[3] > 0)
    }

    /// Every pixel within a rectangle of places, of every `stride`-th column and row: column and row, place, logarithm of its brightness.
    pub fn each(&self, stride: u32, bounds: PlaceBounds, mut take: impl FnMut(UVec2, DVec2, f64)) {
        let PlaceBounds { low, high } = bounds;
        for (row, ends) in (self.first..).zip(self.rows.windows(2)) {
            if row % stride != 0 {
                continue;
            }
            let (first, line) = (ends[0].0, &self.samples[ends[0].1..ends[1].1]);
            for (column, pixel) in (first..).zip(line).filter(|(column, _)| column % stride == 0) {
                let place = self.origin + self.step(f64::from(column), f64::from(row));
                if pixel[3] > 0 && place.cmpge(low).all() && place.cmple(high).all() {
                    take(uvec2(column, row), place, log(*pixel));
                }
            }
        }
    }
}

impl RasterPatch<f64> {
    /// The height of a place between four samples, metres.
    pub fn height(&self, place: DVec2) -> Option<f64> {
        let pixel = self.pixel(place);
        let first = pixel.floor();
        let share = pixel - first;
        let row = |down: f64| {
            let at = |right: f64| self.sample(first + dvec2(right, down));
            // On the raster's last column or row there is nothing beyond to interpolate with.
            let (near, far) = (at(0.0), at(1.0));
            let (near, far) = (near.or(far)?, far.or(near)?);
            Some(near + share.x * (far - near))
        };
        let (above, below) = (row(0.0), row(1.0));
        let (above, below) = (above.or(below)?, below.or(above)?);
        Some(above + share.y * (below - above)).filter(|height| height.is_finite())
    }
}

/// Logarithm of a pixel's luminance (Rec. 709), with what lenses and air add to the darkest.
fn log([red, green, blue, _]: [u8; 4]) -> f64 {
    const LEAST: f64 = 0.004;
    let linear = |code: u8| f64::from(linear_of_codes()[usize::from(code)]);
    (0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue) + LEAST).ln()
}
