//! The far edge of a shadow in a photograph: the height at which the computed shadow agrees with it.
//!
//! Every pixel's ground has a height that the roof must have to shade it (its *critical height*), so that the shadow of a building of height
//! z is all ground below z, and the shadow's edge is one number.
//!
//! ```text
//! coarse   for each z: d(z) = (mean of the lit band − mean of all that is shaded) / deviation, of the logarithm of brightness
//!          the lit band is as high as half of z; start at the greatest d
//! fine     around it: pixel = (1 − c(z))·lit + c(z)·shade, c the share of the pixel that is shaded
//!          (parts of a pixel by themselves, each with the half-shadow of the sun's disc)
//!          for each z: lit and shade by least squares of logarithms (Gauss and Newton); the least sum of squares by parabola
//! error    from the sum's curvature, for as many pixels as are independent of their neighbours
//! ```
//! Logarithms, since what grows or lies on the ground is darkened by a factor.

/// Parts of a pixel along one side.
pub(super) const PARTS: usize = 3;

/// A part of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgePart {
    /// Height of the roof that shades its middle half, metres.
    pub critical: f32,
    /// Metres above and below that from first to last light, > 0.
    pub soft: f32,
}

/// A pixel near the edge.
#[derive(Debug, Clone)]
pub(super) struct Pixel {
    /// Logarithm of its brightness.
    pub log: f32,
    /// Raster, column and row.
    pub place: (u32, u32, u32),
    /// Metres across the sun's azimuth.
    pub across: f32,
    pub parts: [EdgePart; PARTS * PARTS],
}

/// A pixel's logarithm of brightness and its critical height.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoughPixel {
    pub critical: f64,
    pub log: f64,
}

/// Measurement in the photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FoundEdge {
    /// Height of the roof, metres.
    pub height: f64,
    /// Standard deviation, metres.
    pub error: f64,
    /// Logarithms of the brightness of lit and of shaded ground.
    pub lit: f64,
    pub shade: f64,
}

impl FoundEdge {
    /// Logarithm of the factor between lit and shaded ground.
    pub fn contrast(&self) -> f64 {
        self.lit - self.shade
    }
}

/// Why it says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unclear {
    /// Too few pixels on one side of an edge.
    Few,
    /// Nowhere does the brightness change as by a shadow.
    Flat,
    /// Edge that does not change along all of its length.
    Ragged,
}

/// Least factor between lit and shaded ground, as its logarithm.
const LEAST_CONTRAST: f64 = 0.22;
/// Least share of pixels that lie on the right side of the mean of both.
const LEAST_AGREEMENT: f64 = 0.75;
/// Pixels on either side of the edge, at least.
const LEAST_PIXELS: usize = 6;
/// Steps of the coarse search for the height of a pixel.
const STEPS: f64 = 2.0;

#[derive(Debug, Clone, Copy, Default)]
struct EdgeSums {
    count: f64,
    sum: f64,
    squares: f64,
}

impl EdgeSums {
    fn less(self, other: Self) -> Self {
        Self {
            count: self.count - other.count,
            sum: self.sum - other.sum,
            squares: self.squares - other.squares,
        }
    }

    fn mean(self) -> f64 {
        self.sum / self.count
    }

    fn variance(self) -> f64 {
        (self.squares / self.count - self.mean() * self.mean()).max(0.0)
    }
}

/// Height of the band of lit ground that is compared with the shadow of a height, metres; `rise` is the height of a pixel.
fn band(height: f64, rise: f64) -> f64 {
    (0.5 * height).max(5.0 * rise)
}

/// Finds the height from which the coarse search starts: pixels in any order, heights in metres, `rise` the height of a pixel.
pub(super) fn coarse(pixels: &[RoughPixel], rise: f64, lowest: f64, highest: f64) -> Result<f64, Unclear> {
    /// Variance that is there always, so that flat pictures have no infinite signal.
    const FLOOR: f64 = 1e-4;

    let step = rise / STEPS;
    let bins = (band(highest, rise) + highest) / step;
    let mut sums = vec![EdgeSums::default(); bins.ceil().max(1.0) as usize + 1];
    for pixel in pixels {
        let bin = (pixel.critical / step).floor().max(0.0) as usize;
        if let Some(bin) = sums.get_mut(bin + 1) {
            bin.count += 1.0;
            bin.sum += pixel.log;
            bin.squares += pixel.log * pixel.log;
        }
    }

    // From here on all that lies below.
    for index in 1..sums.len() {
        let before = sums[index - 1];
        let here = &mut sums[index];
        (here.count, here.sum, here.squares) =
            (here.count + before.count, here.sum + before.sum, here.squares + before.squares);
    }

    let below = |height: f64| sums[((height / step).round() as usize).min(sums.len() - 1)];
    let signal = |height: f64| {
        let (shaded, lit) = (below(height), below(height + band(height, rise)).less(below(height)));
        let least = LEAST_PIXELS as f64;
        (shaded.count >= least && lit.count >= least).then(|| {
            let deviation = (0.5 * (shaded.variance() + lit.variance()) + FLOOR).sqrt();
            (lit.mean() - shaded.mean()) / deviation
        })
    };

    let heights = (0..).map(|index| lowest + f64::from(index) * step).take_while(|height| *height <= highest);
    let best =
        heights.filter_map(|height| Some((height, signal(height)?))).max_by(|a, b| a.1.total_cmp(&b.1));
    match best {
        None => Err(Unclear::Few),
        Some((_, signal)) if signal <= 0.0 => Err(Unclear::Flat),
        Some((height, _)) => Ok(height),
    }
}

/// Height from which to which the fine search looks at pixels.
pub(super) fn window(start: f64, rise: f64, soft: f64) -> (f64, f64) {
    let half = (0.25 * start).max(6.0 * rise).max(3.0 * soft);
    (start - half, start + half)
}

/// A height tried, and what fits best then.
#[derive(Debug, Clone, Copy)]
struct EdgeFit {
    height: f64,
    squares: f64,
    lit: f64,
    shade: f64,
}

impl Pixel {
    /// Share of it that is shaded by a roof of a height.
    fn shaded(&self, height: f64) -> f64 {
        let part = |part: &EdgePart| {
            (0.5 + 0.5 * (height - f64::from(part.critical)) / f64::from(part.soft)).clamp(0.0, 1.0)
        };
        self.parts.iter().map(part).sum::<f64>() / self.parts.len() as f64
    }
}

/// Brightness on either side of an edge, as logarithms.
#[derive(Debug, Clone, Copy)]
struct EdgeLevels {
    /// Brightness of lit ground.
    lit: f64,
    /// Brightness of shaded ground.
    shade: f64,
}

/// The sum of squares at a height, and lit and shaded brightness there, beginning from some.
fn fit(pixels: &[Pixel], height: f64, levels: EdgeLevels) -> EdgeFit {
    const ROUNDS: usize = 3;

    let EdgeLevels { mut lit, mut shade } = levels;

    let shares: Vec<f64> = pixels.iter().map(|pixel| pixel.shaded(height)).collect();
    let mut squares = 0.0;
    for round in 0..=ROUNDS {
        let (of_lit, of_shade) = (lit.exp(), shade.exp());
        let (mut aa, mut ab, mut bb, mut ar, mut br) = (0.0, 0.0, 0.0, 0.0, 0.0);
        squares = 0.0;
        for (pixel, share) in pixels.iter().zip(&shares) {
            let light = (1.0 - share) * of_lit + share * of_shade;
            let residual = f64::from(pixel.log) - light.ln();
            let (by_lit, by_shade) = ((1.0 - share) * of_lit / light, share * of_shade / light);
            squares += residual * residual;
            aa += by_lit * by_lit;
            ab += by_lit * by_shade;
            bb += by_shade * by_shade;
            ar += by_lit * residual;
            br += by_shade * residual;
        }
        let determinant = aa * bb - ab * ab;
        // The last round only tells the squares.
        if round == ROUNDS || determinant <= 1e-9 * aa * bb {
            break;
        }
        lit += (ar * bb - br * ab) / determinant;
        shade += (br * aa - ar * ab) / determinant;
    }

    EdgeFit { height, squares, lit, shade }
}

/// The height at which computed shadow and photograph agree best near `start`; `rise` is the height of a pixel, `soft` half of that of the half-shadow.
pub(super) fn fine(pixels: &[Pixel], start: f64, rise: f64, soft: f64) -> Result<FoundEdge, Unclear> {
    enough(pixels, start)?;
    let step = 0.25 * rise.max(soft);
    let (best, curvature) = parabolas(pixels, scan(pixels, start, rise, step, soft), step);
    enough(pixels, best.height)?;
    if best.lit - best.shade < LEAST_CONTRAST || curvature <= 0.0 {
        return Err(Unclear::Flat);
    }
    check(pixels, &best)?;
    /// Height, lit and shaded brightness are taken from the pixels.
    const UNKNOWNS: f64 = 3.0;
    let variance = best.squares / (pixels.len() as f64 - UNKNOWNS);
    let error = (2.0 * variance / curvature * dependence(pixels, &best)).sqrt();
    Ok(FoundEdge { height: best.height, error, lit: best.lit, shade: best.shade })
}

/// Whether there are pixels on both sides of the edge of a height.
fn enough(pixels: &[Pixel], height: f64) -> Result<(), Unclear> {
    let shaded = pixels.iter().filter(|pixel| pixel.shaded(height) > 0.5).count();
    if shaded.min(pixels.len() - shaded) < LEAST_PIXELS { Err(Unclear::Few) } else { Ok(()) }
}

/// Mean brightness of the pixels on either side of the edge of a height.
fn levels(pixels: &[Pixel], height: f64) -> EdgeLevels {
    let mean = |is_shaded: bool| {
        let side = pixels.iter().filter(|pixel| (pixel.shaded(height) > 0.5) == is_shaded);
        let (sum, count) =
            side.fold((0.0, 0.0), |(sum, count), pixel| (sum + f64::from(pixel.log), count + 1.0));
        sum / count
    };
    EdgeLevels { lit: mean(false), shade: mean(true) }
}

/// The best of the heights around `start`, in steps: the squares have several valleys where the ground has stripes.
fn scan(pixels: &[Pixel], start: f64, rise: f64, step: f64, soft: f64) -> EdgeFit {
    /// Share of the window that is looked through; the rest is for what lies beyond the edge.
    const ROOM: f64 = 0.6;
    let levels = levels(pixels, start);
    let (_, high) = window(start, rise, soft);
    let count = (ROOM * (high - start) / step).ceil() as i32;
    let heights = (-count..=count).map(|index| (start + f64::from(index) * step).max(0.1 * rise));
    let first = fit(pixels, start, levels);
    heights
        .map(|height| fit(pixels, height, levels))
        .fold(first, |best, tried| if tried.squares < best.squares { tried } else { best })
}

/// The least squares by parabolas, each through closer heights; and their curvature there.
fn parabolas(pixels: &[Pixel], mut best: EdgeFit, mut step: f64) -> (EdgeFit, f64) {
    const ROUNDS: usize = 3;
    const CLOSER: f64 = 0.6;
    let mut curvature = 0.0;
    for _ in 0..ROUNDS {
        let levels = EdgeLevels { lit: best.lit, shade: best.shade };
        let from = |height: f64| fit(pixels, height, levels);
        let (before, after) = (from(best.height - step), from(best.height + step));
        curvature = (before.squares - 2.0 * best.squares + after.squares) / (step * step);
        if curvature <= 0.0 {
            break;
        }
        let shift = 0.5 * (before.squares - after.squares) / (curvature * step);
        best = from(best.height + shift.clamp(-step, step));
        step *= CLOSER;
    }
    (best, curvature)
}

/// Whether the pixels on either side of the edge are what they should be, and that at either end of it.
fn check(pixels: &[Pixel], fit: &EdgeFit) -> Result<(), Unclear> {
    let middle = 0.5 * (fit.lit + fit.shade);
    let agreement = |of: &dyn Fn(&Pixel) -> bool| {
        let (mut right, mut all) = (0_usize, 0_usize);
        for pixel in pixels.iter().filter(|pixel| of(pixel)) {
            all += 1;
            right += usize::from((f64::from(pixel.log) < middle) == (pixel.shaded(fit.height) > 0.5));
        }
        if all == 0 { 1.0 } else { right as f64 / all as f64 }
    };

    let (low, high) = pixels.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), pixel| {
        (low.min(pixel.across), high.max(pixel.across))
    });
    let centre = 0.5 * (low + high);
    let shaded = |pixel: &Pixel| pixel.shaded(fit.height) > 0.5;
    let (dark, bright) = (agreement(&shaded), agreement(&|pixel| !shaded(pixel)));
    let ends = [agreement(&|pixel| pixel.across < centre), agreement(&|pixel| pixel.across >= centre)];

    if 0.5 * (dark + bright) < LEAST_AGREEMENT {
        Err(Unclear::Flat)
    } else if ends.into_iter().any(|end| end < LEAST_AGREEMENT - 0.1) {
        Err(Unclear::Ragged)
    } else {
        Ok(())
    }
}

/// Returns how many neighbouring pixels tell what one independent pixel tells: by the correlation of what is left of neighbours in rows and in columns.
fn dependence(pixels: &[Pixel], fit: &EdgeFit) -> f64 {
    const MOST: f64 = 0.9;

    let (lit, shade) = (fit.lit.exp(), fit.shade.exp());
    let residual = |pixel: &Pixel| {
        let share = pixel.shaded(fit.height);
        f64::from(pixel.log) - ((1.0 - share) * lit + share * shade).ln()
    };
    let all: std::collections::BTreeMap<_, _> =
        pixels.iter().map(|pixel| (pixel.place, residual(pixel))).collect();
    let variance = all.values().map(|value| value * value).sum::<f64>() / all.len().max(1) as f64;

    let along = |column: u32, row: u32| {
        let pairs = all
            .iter()
            .filter_map(|(&(raster, x, y), value)| Some(value * all.get(&(raster, x + column, y + row))?));
        let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), product| (sum + product, count + 1.0));
        let correlation =
            if count > 0.0 && variance > 0.0 { (sum / count / variance).clamp(0.0, MOST) } else { 0.0 };
        (1.0 + correlation) / (1.0 - correlation)
    };

    along(1, 0) * along(0, 1)
}
