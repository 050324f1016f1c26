//! The map of a flight's pages by the frame that needed them first, as SVG.

use std::path::Path;

use glam::DVec2;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::args::check_no_input;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::render::NumberedCamera;
use hedgehop::voxel::{Grid, Header, PageId};
use hedgehop::{Error, Result};

/// Pixels of a level's map, and of the band with the title.
const SIDE: u32 = 520;
const TITLE: u32 = 40;

const PATH: RGBColor = RGBColor(20, 20, 20);

/// Colours from the first frame to the last one; rising in lightness, so that they read in grey too.
const RAMP: [RGBColor; 5] = [
    RGBColor(68, 1, 84),
    RGBColor(59, 82, 139),
    RGBColor(33, 145, 140),
    RGBColor(94, 201, 98),
    RGBColor(253, 231, 37),
];

/// Objects to be drawn.
#[derive(Debug, Clone, Copy)]
pub struct Traffic<'a> {
    /// The database.
    pub header: &'a Header,
    /// The frames, in order.
    pub cameras: &'a [NumberedCamera],
    /// Pages with the index of the first frame that needed them.
    pub first_use: &'a [(PageId, u32)],
}

type Drawn<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Refuses before any work a map that could not be written, or that a file named otherwise would hold.
pub fn check(map: &Path, inputs: &[&Path]) -> Result<()> {
    check_no_input("--traffic", map, inputs)?;
    if !map.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg")) {
        return Err(Error::Configuration(format!(
            "--traffic draws SVG; name its file {}",
            map.with_extension("svg").display()
        )));
    }
    check_writable(map)
}

impl Traffic<'_> {
    /// Writes the map.
    ///
    /// # Errors
    /// It cannot be drawn or written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let svg = self
            .svg()
            .map_err(|error| Error::Configuration(format!("{} cannot be drawn: {error}", path.display())))?;
        write_bytes(path, svg.as_bytes())
    }

    /// One map a level, finest first, of the ground that its pages cover.
    ///
    /// # Errors
    /// Those of the drawing library.
    fn svg(&self) -> Drawn<String> {
        let levels: Vec<u8> =
            (0..self.header.level_count).filter(|level| self.pages(*level).next().is_some()).collect();
        let columns = (levels.len() as f64).sqrt().ceil().max(1.0) as u32;
        let rows = (levels.len() as u32).div_ceil(columns).max(1);

        let mut svg = String::new();
        {
            let size = (columns * SIDE, rows * SIDE + TITLE);
            let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
            root.fill(&WHITE)?;
            let title = format!(
                "{} pages of {} frames, by the first frame that needs them: dark first, bright last",
                self.first_use.len(),
                self.cameras.len(),
            );
            let root = root.titled(&title, ("sans-serif", 20))?;
            for (level, panel) in levels.iter().zip(root.split_evenly((rows as usize, columns as usize))) {
                self.level(*level, &panel)?;
            }

            root.present()?;
        }

        Ok(svg)
    }

    fn pages(&self, level: u8) -> impl Iterator<Item = (PageId, u32)> {
        self.first_use.iter().copied().filter(move |(id, _)| id.level == level)
    }

    fn level(&self, level: u8, panel: &DrawingArea<SVGBackend<'_>, Shift>) -> Drawn<()> {
        let grid = &self.header.grid;
        let mut extent = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let mut include = |[low, high]: [DVec2; 2]| extent = [extent[0].min(low), extent[1].max(high)];
        self.pages(level).for_each(|(id, _)| include(grid.page_square(id)));
        for NumberedCamera { camera, .. } in self.cameras {
            include([camera.pose.eye.truncate(); 2]);
        }

        // North is up, and a metre as long in both directions.
        let half = 0.52 * (extent[1] - extent[0]).max_element();
        let middle = (extent[0] + extent[1]) / 2.0;
        let caption = format!("level {}: {} pages", Grid::side_units(level), self.pages(level).count());

        let mut chart = ChartBuilder::on(panel)
            .margin(12)
            .caption(caption, ("sans-serif", 16))
            .x_label_area_size(34)
            .y_label_area_size(70)
            .build_cartesian_2d(middle.x - half..middle.x + half, middle.y - half..middle.y + half)?;

        chart
            .configure_mesh()
            .x_desc("east, m")
            .y_desc("north, m")
            .x_labels(4)
            .y_labels(5)
            .x_label_formatter(&|metres| format!("{metres:.0}"))
            .y_label_formatter(&|metres| format!("{metres:.0}"))
            .label_style(("sans-serif", 12))
            .light_line_style(WHITE)
            .draw()?;

        let last = f64::from(self.first_use.iter().map(|(_, frame)| *frame).max().unwrap_or(0).max(1));
        chart.draw_series(self.pages(level).map(|(id, frame)| {
            let [low, high] = grid.page_square(id);
            Rectangle::new([(low.x, low.y), (high.x, high.y)], colour(f64::from(frame) / last).filled())
        }))?;
        let eyes = self.cameras.iter().map(|frame| (frame.camera.pose.eye.x, frame.camera.pose.eye.y));
        chart.draw_series(LineSeries::new(eyes, PATH.stroke_width(2)))?;

        Ok(())
    }
}

/// The ramp's colour at a share of the flight, 0 to 1.
fn colour(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let from = (place as usize).min(RAMP.len() - 2);
    let (low, high, share) = (RAMP[from], RAMP[from + 1], place - from as f64);
    let mix = |low: u8, high: u8| (f64::from(low) + (f64::from(high) - f64::from(low)) * share).round() as u8;
    RGBColor(mix(low.0, high.0), mix(low.1, high.1), mix(low.2, high.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_svg() {
        let refusal = check(Path::new("a/map.png"), &[]).unwrap_err().to_string();
        assert!(refusal.contains("a/map.svg"), "{refusal}");
        assert!(!Path::new("a").exists(), "nothing is made for a map that is refused");
    }

    #[test]
    fn the_ramp_goes_through_its_colours() {
        assert_eq!(colour(-1.0), RAMP[0]);
        assert_eq!(colour(0.25), RAMP[1]);
        assert_eq!(colour(1.0), RAMP[4]);
        assert_eq!(colour(0.125), RGBColor(64, 42, 112));
    }
}
