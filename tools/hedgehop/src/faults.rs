//! Faults of terrain, for people and for programs: words, a table, and marks on a map.

use std::fmt::Write;

use clap::ValueEnum;
use glam::DVec2;
use image::{Rgb, RgbImage};

use crate::drawing::Mask;
use crate::lettering;
use crate::places::Places;
use hedgehop_query::{ContinuityReport, Fault, Finding, MapExtent};

const WHITE: Rgb<u8> = Rgb([255; 3]);
const DARK: Rgb<u8> = Rgb([20, 20, 24]);

/// Kinds of faults as users name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FaultKind {
    /// Voxels far above all of their neighbours
    Spikes,
    /// Voxels far below all of their neighbours
    Pits,
    /// Steps along a column or row
    Seams,
    /// Level tops of something steep
    FlatTops,
    /// Slopes of few heights
    Terraces,
    /// Voxels without a surface, inside of the area
    Voids,
    /// Pages that say of their neighbours what these do not
    Cracks,
}

impl FaultKind {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Spikes, Self::Pits, Self::Seams, Self::FlatTops, Self::Terraces, Self::Voids, Self::Cracks];

    /// Converts to the library's kind.
    pub fn fault(self) -> Fault {
        match self {
            Self::Spikes => Fault::Spike,
            Self::Pits => Fault::Pit,
            Self::Seams => Fault::Seam,
            Self::FlatTops => Fault::FlatTop,
            Self::Terraces => Fault::Terrace,
            Self::Voids => Fault::Void,
            Self::Cracks => Fault::Crack,
        }
    }

    /// Returns the name as it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spikes => "spikes",
            Self::Pits => "pits",
            Self::Seams => "seams",
            Self::FlatTops => "flat-tops",
            Self::Terraces => "terraces",
            Self::Voids => "voids",
            Self::Cracks => "cracks",
        }
    }

    fn of(fault: Fault) -> Self {
        Self::ALL.into_iter().find(|kind| kind.fault() == fault).unwrap_or(Self::Cracks)
    }

    fn colour(self) -> Rgb<u8> {
        match self {
            Self::Spikes => Rgb([214, 30, 30]),
            Self::Pits => Rgb([30, 80, 220]),
            Self::Seams => Rgb([200, 0, 190]),
            Self::FlatTops => Rgb([255, 130, 0]),
            Self::Terraces => Rgb([235, 200, 0]),
            Self::Voids => Rgb([0, 170, 170]),
            Self::Cracks => Rgb([20, 20, 20]),
        }
    }

    /// Describes a size of this kind.
    fn measure(self, size: f64) -> String {
        match self {
            Self::Spikes => format!("{size:.2} m above its neighbours"),
            Self::Pits => format!("{size:.2} m below its neighbours"),
            Self::Seams => format!("steps of {size:.2} m"),
            Self::FlatTops => format!("{size:.2} m down to the next voxel"),
            Self::Terraces => format!("{size:.2} m from height to height"),
            Self::Voids => format!("{size:.0} m across"),
            Self::Cracks => format!("{size:.2} m apart"),
        }
    }
}

/// A line for each kind: how many, and the worst.
pub fn summary(report: &ContinuityReport, places: &Places<'_>) -> String {
    let mut text = String::new();
    for kind in FaultKind::ALL {
        let count = report.count(kind.fault());
        // Writing to a String cannot fail.
        let _ = write!(text, "{:<10} {count:>7}", kind.name());
        if let Some(worst) = report.findings.iter().find(|finding| finding.fault == kind.fault()) {
            let Finding { place, size, .. } = worst;
            let _ = write!(text, "  worst: {}, x {:.1} y {:.1}", kind.measure(*size), place.x, place.y);
            if let Some([longitude, latitude]) = places.lonlat(*place) {
                let _ = write!(text, " ({longitude:.6} {latitude:.6})");
            }
        }
        text.push('\n');
    }

    if report.ends > 0 {
        let _ =
            writeln!(text, "{} voids at the edge of the area, where the data end, do not count", report.ends);
    }

    text
}

/// All findings as CSV.
pub fn table(report: &ContinuityReport, places: &Places<'_>) -> String {
    let mut text =
        "class,x_m,y_m,lon_deg,lat_deg,height_m,size_m,voxels,west_m,south_m,east_m,north_m\n".to_owned();
    for finding in &report.findings {
        let Finding { fault, place, extent: [low, high], height, size, voxels, .. } = finding;
        let [longitude, latitude] = places
            .lonlat(*place)
            .map_or([String::new(), String::new()], |place| place.map(|degrees| format!("{degrees:.8}")));
        let height = if height.is_nan() { String::new() } else { format!("{height:.3}") };

        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{},{:.3},{:.3},{longitude},{latitude},{height},{size:.3},{voxels},{:.3},{:.3},{:.3},{:.3}",
            FaultKind::of(*fault).name(),
            place.x,
            place.y,
            low.x,
            low.y,
            high.x,
            high.y
        );
    }

    text
}

/// Puts all findings on a map, with a legend.
pub fn mark(picture: &mut RgbImage, extent: &MapExtent, report: &ContinuityReport, unit: f64) {
    // What covers much lies below what is small.
    for kind in [
        FaultKind::Terraces,
        FaultKind::Voids,
        FaultKind::FlatTops,
        FaultKind::Cracks,
        FaultKind::Seams,
        FaultKind::Pits,
        FaultKind::Spikes,
    ] {
        let [mut inside, mut rim, mut halo] = [Mask::new(picture), Mask::new(picture), Mask::new(picture)];
        for finding in report.findings.iter().filter(|finding| finding.fault == kind.fault()) {
            let at = |place: DVec2| extent.pixel_of(place);
            let (low, high) = (at(finding.extent[0]), at(finding.extent[1]));
            match kind {
                FaultKind::Spikes | FaultKind::Pits | FaultKind::Cracks => {
                    halo.disc(at(finding.place), 5.2 * unit);
                    rim.disc(at(finding.place), 3.8 * unit);
                }
                FaultKind::Seams => {
                    halo.lines(&[low, high], 4.6 * unit);
                    rim.lines(&[low, high], 2.6 * unit);
                }
                FaultKind::Terraces | FaultKind::Voids | FaultKind::FlatTops => {
                    // What is smaller than a mark is shown as one.
                    let (middle, least) = (0.5 * (low + high), 5.0 * unit);
                    let half = (0.5 * (high - low).abs()).max(DVec2::splat(if kind == FaultKind::Terraces {
                        0.0
                    } else {
                        least
                    }));
                    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
                        .map(|(x, y)| middle + half * DVec2::new(x, y));

                    if kind == FaultKind::Terraces {
                        inside.rectangle(low.min(high), low.max(high));
                    } else {
                        halo.lines(&corners, 4.2 * unit);
                        rim.lines(&corners, 2.4 * unit);
                    }
                }
            }
        }

        inside.paint(picture, kind.colour(), 0.38);
        halo.paint(picture, WHITE, 0.85);
        rim.paint(picture, kind.colour(), 1.0);
    }

    legend(picture, report, unit);
}

/// Writes the counts of each kind into the upper left corner.
fn legend(picture: &mut RgbImage, report: &ContinuityReport, unit: f64) {
    let letters = (2.0 * unit).round().max(1.0) as u32;
    let tall = f64::from(lettering::height(letters));
    let margin = 14.0 * unit;

    let rows: Vec<(FaultKind, String)> = FaultKind::ALL
        .into_iter()
        .filter(|kind| report.count(kind.fault()) > 0)
        .map(|kind| {
            (
                kind,
                format!(
                    "{} {}",
                    kind.name().to_ascii_uppercase().replace('-', " "),
                    report.count(kind.fault())
                ),
            )
        })
        .collect();

    let nothing = ["NOTHING FOUND".to_owned()];
    let texts: Vec<&String> =
        if rows.is_empty() { nothing.iter().collect() } else { rows.iter().map(|(_, text)| text).collect() };
    let widest = texts.iter().map(|text| lettering::width(text, letters)).max().unwrap_or(0);
    let sample = if rows.is_empty() { 0.0 } else { 2.2 * margin };
    let size =
        DVec2::new(f64::from(widest) + sample + 2.0 * margin, texts.len() as f64 * (tall + margin) + margin);
    let low = DVec2::splat(margin);
    let mut behind = Mask::new(picture);
    behind.polygon(&[low, low + DVec2::X * size.x, low + size, low + DVec2::Y * size.y]);
    behind.paint(picture, DARK, 0.72);

    for (index, text) in texts.iter().enumerate() {
        let top = low.y + margin + index as f64 * (tall + margin);
        if let Some((kind, _)) = rows.get(index) {
            let mut mark = Mask::new(picture);
            let middle = DVec2::new(low.x + 1.7 * margin, top + 0.5 * tall);
            match kind {
                FaultKind::Seams => mark
                    .lines(&[middle - DVec2::X * margin * 0.7, middle + DVec2::X * margin * 0.7], 4.0 * unit),
                FaultKind::Terraces => mark.square(middle, 0.5 * margin),
                FaultKind::Voids | FaultKind::FlatTops => {
                    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
                    mark.lines(&corners.map(|(x, y)| middle + 0.45 * margin * DVec2::new(x, y)), 2.4 * unit);
                }
                FaultKind::Spikes | FaultKind::Pits | FaultKind::Cracks => mark.disc(middle, 4.5 * unit),
            }

            // Black on dark would not be seen.
            let colour = if *kind == FaultKind::Cracks { WHITE } else { kind.colour() };
            mark.paint(picture, colour, 1.0);
        }

        let place = [low.x + margin + sample, top].map(|place| place.round() as i64);
        lettering::write(picture, text, place, letters, WHITE);
    }
}
