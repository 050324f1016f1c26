//! Plots as SVG: of `bench` speed, pixels, efficiency and where the time goes, over workers; of `profile` the ground along a line.

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::figures::{BenchReport, Figures};

const SIZE: (u32, u32) = (1100, 820);
const PROFILE_SIZE: (u32, u32) = (1200, 480);
const GROUND: RGBColor = RGBColor(96, 120, 60);
const LINE: RGBColor = RGBColor(31, 95, 160);
const IDEAL: RGBColor = RGBColor(150, 150, 150);
/// One colour per stage; distinct in lightness, too.
const STAGES: [RGBColor; 4] =
    [RGBColor(31, 95, 160), RGBColor(226, 135, 30), RGBColor(60, 150, 80), RGBColor(140, 70, 150)];

/// A named line of (workers, value) points.
struct Line<'a> {
    name: &'a str,
    colour: RGBColor,
    points: Vec<(f64, f64)>,
}

type PlotArea = Result<(), Box<dyn std::error::Error>>;

/// Draws the report.
pub fn bench(report: &BenchReport) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let [width, height] = report.size;

        let title = format!(
            "hedgehop bench: {} frames of {width}x{height}, {} cores, {}",
            report.frames.len(),
            report.cores,
            report.marcher()
        );
        let root = root.titled(&title, ("sans-serif", 22))?;
        let panels = root.split_evenly((2, 2));
        let results = &report.results;
        panel(&panels[0], "frames/s", &with_ideal(results, |f| f.frames_per_s))?;
        panel(&panels[1], "Mpixel/s", &with_ideal(results, |f| f.mpixel_per_s))?;
        let full = results.iter().map(|f| (f.workers as f64, 100.0)).collect();

        panel(
            &panels[2],
            "efficiency, %",
            &[
                Line { name: "ideal", colour: IDEAL, points: full },
                Line { name: "measured", colour: LINE, points: points(results, |f| f.efficiency * 100.0) },
            ],
        )?;

        panel(&panels[3], "ms per frame; march, shade: of all workers", &stages(results))?;
        root.present()?;
    }

    Ok(svg)
}

/// Elevations of a profile: (kilometres, metres above the datum).
pub struct Elevations {
    pub title: String,
    pub datum: String,
    pub ground: Vec<(f64, Option<f64>)>,
    /// Elevations of the flight over it, if there is one.
    pub flight: Vec<(f64, f64)>,
}

/// Draws the ground along a line, and a flight above it.
pub fn profile(shown: &Elevations) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, PROFILE_SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let root = root.titled(&shown.title, ("sans-serif", 20))?;
        let heights = || {
            let ground = shown.ground.iter().filter_map(|(_, height)| *height);
            ground.chain(shown.flight.iter().map(|(_, height)| *height))
        };
        let (low, high) = heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
            (low.min(height), high.max(height))
        });
        let margin = 0.08 * (high - low).max(10.0);
        let (low, high) = (low - margin, high + margin);
        let length = shown.ground.last().map_or(0.0, |(along, _)| *along).max(1.0e-3);
        let mut chart = ChartBuilder::on(&root)
            .margin(14)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..length, low..high)?;

        chart
            .configure_mesh()
            .x_desc("km along the line")
            .y_desc(format!("m above {}", shown.datum))
            .axis_desc_style(("sans-serif", 16))
            .label_style(("sans-serif", 14))
            .light_line_style(WHITE)
            .draw()?;

        // Where there is no ground the area ends.
        for run in shown.ground.chunk_by(|a, b| a.1.is_some() == b.1.is_some()) {
            let run: Vec<_> = run.iter().filter_map(|(along, height)| Some((*along, (*height)?))).collect();
            if !run.is_empty() {
                chart.draw_series(
                    AreaSeries::new(run, low, GROUND.mix(0.35)).border_style(GROUND.stroke_width(2)),
                )?;
            }
        }

        chart.draw_series(LineSeries::new(shown.flight.iter().copied(), LINE.stroke_width(2)))?;
        root.present()?;
    }

    Ok(svg)
}

fn points(results: &[Figures], value: impl Fn(&Figures) -> f64) -> Vec<(f64, f64)> {
    results.iter().map(|figures| (figures.workers as f64, value(figures))).collect()
}

/// The measured line, and the one that grows with the workers.
fn with_ideal(results: &[Figures], value: impl Fn(&Figures) -> f64) -> [Line<'static>; 2] {
    let measured = points(results, value);
    let per_worker = measured.first().map_or(0.0, |(workers, value)| value / workers);
    let ideal = measured.iter().map(|(workers, _)| (*workers, workers * per_worker)).collect();
    [
        Line { name: "ideal", colour: IDEAL, points: ideal },
        Line { name: "measured", colour: LINE, points: measured },
    ]
}

fn stages(results: &[Figures]) -> [Line<'static>; 4] {
    let [march, shade, image, encode] = STAGES;
    [
        Line { name: "march", colour: march, points: points(results, |f| f.march_ms) },
        Line { name: "shade", colour: shade, points: points(results, |f| f.shade_ms) },
        Line { name: "image stage", colour: image, points: points(results, |f| f.image_ms) },
        Line { name: "encode", colour: encode, points: points(results, |f| f.encode_ms) },
    ]
}

fn panel(area: &DrawingArea<SVGBackend<'_>, Shift>, label: &str, lines: &[Line<'_>]) -> PlotArea {
    let all = || lines.iter().flat_map(|line| &line.points);
    let most_workers = all().map(|(x, _)| *x).fold(1.0, f64::max);
    let highest = all().map(|(_, y)| *y).fold(0.0, f64::max);

    // A flat zero line still needs an axis with a length.
    let top = if highest > 0.0 { highest * 1.12 } else { 1.0 };
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..most_workers * 1.05, 0.0..top)?;

    chart
        .configure_mesh()
        .x_desc("workers")
        .y_desc(label)
        .x_labels((most_workers as usize + 1).min(9))
        .x_label_formatter(&|workers| format!("{workers:.0}"))
        .axis_desc_style(("sans-serif", 16))
        .label_style(("sans-serif", 14))
        .light_line_style(WHITE)
        .draw()?;

    for line in lines {
        let colour = line.colour;
        let stroke = colour.stroke_width(if line.name == "ideal" { 1 } else { 2 });
        chart
            .draw_series(LineSeries::new(line.points.iter().copied(), stroke))?
            .label(line.name)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(2)));
        if line.name != "ideal" {
            chart.draw_series(line.points.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
        }
    }

    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font(("sans-serif", 14))
        .background_style(WHITE.mix(0.8))
        .draw()?;

    Ok(())
}
