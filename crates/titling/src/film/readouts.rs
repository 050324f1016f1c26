//! Readouts: clock, altitudes, speeds and place, at the lower left.

use glam::DVec2;

use super::measure;
use super::page::{Area, PANEL, Page, WHITE};
use crate::layer::{Layer, rectangle};
use crate::readings::Readings;
use crate::text::{TextBlock, TextStyle, Typesetter};
use hedgehop::scene::{Figures, Units};

/// Sizes of figures and of their names, units.
const FIGURE: f64 = 38.0;
const NAME: f64 = 20.0;

/// Space between two figures, and from them to the panel's border, units.
const GAP: f64 = 44.0;
const BORDER: f64 = 14.0;

/// Readouts of a picture.
pub struct Readouts {
    pub figures: Figures,
    pub units: Units,
    /// Offset of the clock from UTC, hours.
    pub utc_offset: f64,
    /// Width that they may take, pixels.
    pub width: f64,
}

/// A figure with its name above it.
struct Cell {
    name: String,
    figure: String,
    /// Size of the figure, units.
    size: f64,
    /// Widest text that such a figure usually is, so that those behind it stand still.
    widest: &'static str,
}

impl Readouts {
    /// Draws them on a panel; `None`: there are none.
    pub fn layer(
        &self,
        readings: &Readings,
        page: &Page,
        typesetter: &Typesetter<'_>,
    ) -> Option<(Area, Layer)> {
        let set = |text: &str, units: f64| typesetter.set(text, &TextStyle::line(page.letters(units)));
        let border = DVec2::splat(page.px(BORDER));
        let most = self.width - 2.0 * border.x;
        let mut placed: Vec<(TextBlock, DVec2)> = Vec::new();
        let (mut at, mut far, mut row_height) = (DVec2::ZERO, DVec2::ZERO, 0.0_f64);
        for cell in self.cells(readings) {
            let (name, figure) = (set(&cell.name, NAME), set(&cell.figure, cell.size));
            let usual = typesetter.width(cell.widest, page.letters(cell.size));
            let width = f64::from(name.extent[0].max(figure.extent[0]).max(usual));
            let below = if cell.size > NAME { 0.8 } else { 1.0 } * f64::from(name.extent[1]);
            let height = below + f64::from(figure.extent[1]);
            if at.x > 0.0 && at.x + width > most {
                at = DVec2::new(0.0, at.y + row_height);
                row_height = 0.0;
            }

            placed.push((name, at));
            placed.push((figure, at + DVec2::new(0.0, below)));
            far = far.max(at + DVec2::new(width, height));
            row_height = row_height.max(height);
            at.x += width + page.px(GAP);
        }

        if placed.is_empty() {
            return None;
        }

        let size = far + 2.0 * border;
        let area = Area { corner: DVec2::new(page.safe().corner.x, page.safe().far().y - size.y), size };
        let mut layer = Layer::new(area.corner, area.size)?;
        layer.fill(&rectangle(area.corner, area.size)?, PANEL);
        for (block, corner) in &placed {
            layer.text(block, area.corner + border + *corner, WHITE);
        }
        Some((area, layer))
    }

    fn cells(&self, readings: &Readings) -> Vec<Cell> {
        let mut cells = Vec::new();
        let mut add = |name: &str, figure: String, widest: &'static str| {
            cells.push(Cell { name: name.to_owned(), figure, size: FIGURE, widest });
        };
        if self.figures.clock {
            match readings.clock {
                Some(seconds) => {
                    add(
                        &measure::clock_name(self.utc_offset),
                        measure::clock(seconds, self.utc_offset),
                        "00:00:00",
                    );
                }
                None => add("Time", measure::elapsed(readings.seconds), "0:00:00"),
            }
        }

        let (high, fast, steep) = match self.units {
            Units::Metric => ("0000 m", "000 km/h", "+0.0 m/s"),
            Units::Aviation => ("00000 ft", "000 kt", "+0000 ft/min"),
            Units::Imperial => ("00000 ft", "000 mph", "+0000 ft/min"),
        };
        if self.figures.altitude {
            add("Altitude", measure::height(readings.altitude, self.units), high);
            let above = readings.above_ground.map(|metres| measure::height(metres, self.units));
            add("Above ground", above.unwrap_or_else(|| "–".to_owned()), high);
        }
        if let Some([level, up]) = readings.speed.filter(|_| self.figures.speed) {
            add("Speed", measure::speed(level, self.units), fast);
            add("Climb", measure::climb(up, self.units), steep);
        }
        if self.figures.place {
            let ([name, figure], widest) = match readings.lonlat {
                Some(lonlat) => (measure::geographic(lonlat), "000.0000° W"),
                None => {
                    let DVec2 { x, y } = readings.place;
                    ([format!("x {x:.0} m"), format!("y {y:.0} m")], "y 0000000 m")
                }
            };
            cells.push(Cell { name, figure, size: NAME, widest });
        }
        cells
    }
}
