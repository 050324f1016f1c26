//! Contour lines on a map: thin and thick ones, with their figures where these fit.

use glam::DVec2;
use image::{Rgb, RgbImage};

use crate::drawing::Mask;
use crate::lettering;
use hedgehop_query::{Contour, MapExtent};

/// Brown, as ground is on maps.
const LINE: Rgb<u8> = Rgb([128, 72, 24]);
const PAPER: Rgb<u8> = Rgb([250, 248, 240]);
/// Height of figures, at `unit` 1, pixels.
const FIGURES: f64 = 9.0;
/// Distance from figure to figure along a line, and between those of any lines, in widths of a figure.
const ALONG: f64 = 14.0;
const APART: f64 = 3.0;
/// Distance by which a line may leave the straight one under its figure, in heights of it.
const BENT: f64 = 0.35;

/// Heights of contour lines.
#[derive(Debug, Clone, Copy)]
pub struct ContourSpacing {
    /// Metres from line to line.
    pub interval: f64,
    /// Lines from index line to index line: lines whose number is a multiple of it are index lines.
    pub index: i64,
}

/// A figure on a line.
struct Figure {
    text: String,
    middle: DVec2,
    along: DVec2,
    wide: f64,
}

/// Draws lines; index lines are thick and have figures. Widths and heights on paper are multiples of `unit`, pixels.
pub fn draw(
    picture: &mut RgbImage,
    extent: &MapExtent,
    lines: &[Contour],
    spacing: ContourSpacing,
    unit: f64,
) {
    let ContourSpacing { interval, index } = spacing;
    let [mut thin, mut thick] = [Mask::new(picture), Mask::new(picture)];
    let mut figures: Vec<Figure> = Vec::new();
    let bounds = DVec2::new(f64::from(extent.width), f64::from(extent.height));
    for line in lines {
        let points: Vec<DVec2> = line.points.iter().map(|point| extent.pixel_of(*point)).collect();
        if line.number % index == 0 {
            thick.lines(&points, 2.0 * unit);
            label(&points, &text(line.number as f64 * interval, interval), bounds, unit, &mut figures);
        } else {
            thin.lines(&points, 1.0 * unit);
        }
    }

    let mut gaps = Mask::new(picture);
    let mut strokes = [Mask::new(picture), Mask::new(picture)];
    for Figure { text, middle, along, wide } in &figures {
        let half = *along * (0.5 * wide + 3.0 * unit);
        gaps.lines(&[*middle - half, *middle + half], FIGURES * unit + 3.0 * unit);
        for (mask, width) in strokes.iter_mut().zip([4.0, 1.3]) {
            lettering::stroke(mask, text, *middle, *along, FIGURES * unit, width * unit);
        }
    }

    // A figure breaks its own line and thin ones under it.
    thin.without(&gaps);
    thick.without(&gaps);
    thin.paint(picture, LINE, 0.7);
    thick.paint(picture, LINE, 0.9);
    strokes[0].paint(picture, PAPER, 0.8);
    strokes[1].paint(picture, LINE, 1.0);
}

/// An elevation with as many decimals as the interval has.
pub fn text(elevation: f64, interval: f64) -> String {
    let decimals = (0..4).find(|digits| {
        let scaled = interval * 10.0_f64.powi(*digits);
        (scaled - scaled.round()).abs() < 1e-6
    });
    format!("{elevation:.*}", decimals.unwrap_or(4) as usize)
}

/// Adds figures where a line is straight enough and has room.
fn label(points: &[DVec2], text: &str, bounds: DVec2, unit: f64, figures: &mut Vec<Figure>) {
    let tall = FIGURES * unit;
    let wide = lettering::stroke_width(text, tall);
    let ways: Vec<f64> = std::iter::once(0.0)
        .chain(points.windows(2).scan(0.0, |way, ends| {
            *way += ends[0].distance(ends[1]);
            Some(*way)
        }))
        .collect();
    let length = ways.last().copied().unwrap_or(0.0);

    // A ring that is all figure says nothing.
    if length < 4.0 * wide {
        return;
    }

    let at = |way: f64| {
        let next = ways.partition_point(|known| *known < way).clamp(1, points.len() - 1);
        let piece = ways[next] - ways[next - 1];
        let share = if piece > 0.0 { (way - ways[next - 1]) / piece } else { 0.0 };
        points[next - 1].lerp(points[next], share.clamp(0.0, 1.0))
    };
    let reach = 0.5 * wide + 4.0 * unit;
    let step = 0.25 * wide;
    let stretch = ALONG * wide;
    let stretches = (length / stretch).ceil().max(1.0);

    for part in 0..stretches as usize {
        let first = (part as f64 * length / stretches).max(reach);
        let last = ((part + 1) as f64 * length / stretches).min(length - reach);
        let count = ((last - first) / step).max(0.0) as usize + 1;
        let candidates = (0..count).map(|index| first + index as f64 * step).filter(|way| *way <= last);

        let fits = candidates.filter_map(|way| {
            let ends = [at(way - reach), at(way + reach)];
            let along = (ends[1] - ends[0]).try_normalize()?;
            let between = (0..=8).map(|index| at(way + reach * (f64::from(index) / 4.0 - 1.0)));
            let bent = between.map(|point| (point - ends[0]).perp_dot(along).abs()).fold(0.0, f64::max);
            let middle = 0.5 * (ends[0] + ends[1]);
            let is_inside = middle.min(bounds - middle).min_element() > 0.5 * wide + tall;
            let has_room =
                figures.iter().all(|other| other.middle.distance(middle) > APART * 0.5 * (wide + other.wide));
            // Nothing is read upside down.
            let along = if along.x < 0.0 { -along } else { along };
            (bent < BENT * tall && is_inside && has_room).then_some((bent, middle, along))
        });

        if let Some((_, middle, along)) = fits.min_by(|a, b| a.0.total_cmp(&b.0)) {
            figures.push(Figure { text: text.to_owned(), middle, along, wide });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_the_decimals_of_the_interval() {
        assert_eq!(
            [text(1250.0, 50.0), text(0.5, 0.5), text(-2.0, 1.0), text(0.75, 0.25)],
            ["1250", "0.5", "-2", "0.75"]
        );
    }

    #[test]
    fn figures_stand_on_straight_stretches_inside_of_the_map() {
        let mut figures = Vec::new();
        let bounds = DVec2::new(800.0, 400.0);
        let straight: Vec<DVec2> = (0..80).map(|x| DVec2::new(f64::from(x) * 10.0, 200.0)).collect();
        label(&straight, "1200", bounds, 1.0, &mut figures);
        assert!(figures.len() >= 2, "{}", figures.len());
        for Figure { middle, along, wide, .. } in &figures {
            let room = middle.x.min(bounds.x - middle.x) - 0.5 * wide;
            assert!(room > 0.0 && along.x > 0.99, "{middle} of {wide} along {along}");
        }
        let before = figures.len();
        // Neither on zigzags nor on rings that are hardly longer.
        let zigzag: Vec<DVec2> =
            (0..80).map(|x| DVec2::new(f64::from(x) * 10.0, 100.0 + 15.0 * f64::from(x % 2))).collect();
        label(&zigzag, "1200", bounds, 1.0, &mut figures);
        label(&[DVec2::new(400.0, 300.0), DVec2::new(430.0, 300.0)], "1200", bounds, 1.0, &mut figures);
        assert_eq!(figures.len(), before);
    }
}
