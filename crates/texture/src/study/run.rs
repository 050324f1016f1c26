//! Flight by settings: frames, and a report of them.

use std::fmt::Write as _;
use std::path::Path;

use hedgehop_base::error::{Error, Result};

use super::eye::{Eye, EyeAttitude};
use super::ground_quad::GroundQuad;
use super::scene::{GreyPicture, Runway, StudyScene, TexturedTerrain};
use super::settings::{DatabaseSettings, Settings};
use super::view::{GroundView, Screen};
use crate::code::CyclicCode;
use crate::projection::Projection;
use crate::shades::Shades;
use crate::subterrain::{Subterrain, SubterrainCode};

/// Slices of each footprint.
const SLICES: u32 = 4;

/// Most subterrains that are kept as a list.
const MAX_SUBTERRAINS: f64 = 65_536.0;

/// Scene and flight of settings.
#[derive(Debug, Clone)]
pub struct Run {
    scene: StudyScene,
    screen: Screen,
    first: Eye,
    settings: Settings,
    frames: u32,
}

impl Run {
    /// Prepares a flight.
    ///
    /// # Errors
    ///
    /// A value is out of its range.
    pub fn new(settings: Settings) -> Result<Self> {
        let frames = settings.frames()?;
        let display = &settings.display;
        let sizes = 1..=8192;
        let has_sizes = sizes.contains(&display.pixels) && sizes.contains(&display.lines);
        if !(has_sizes && display.fov_deg > 0.0 && display.fov_deg < 180.0) {
            return Err(Error::Configuration(format!(
                "a display of {} × {} pixels over {}° cannot be drawn on; want 1 to 8192 each way, and more than \
                 0 and less than 180 degrees",
                display.pixels, display.lines, display.fov_deg
            )));
        }
        let projection = Projection { pixels: display.pixels, fov_deg: display.fov_deg };
        let aircraft = &settings.aircraft;
        let [x, y, altitude] = aircraft.place_ft;
        Ok(Self {
            scene: scene(&settings)?,
            screen: Screen { projection, lines: display.lines },
            first: Eye {
                place: [x, y],
                altitude,
                attitude: EyeAttitude {
                    heading_deg: aircraft.heading_deg,
                    pitch_deg: aircraft.pitch_deg,
                    roll_deg: aircraft.roll_deg,
                },
            },
            settings,
            frames,
        })
    }

    /// Frames of the flight.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Eye of a frame.
    pub fn eye(&self, frame: u32) -> Eye {
        let time = f64::from(frame) * self.settings.simulator.step_s;
        self.first.moved(self.settings.aircraft.velocity_ft_s, time)
    }

    /// Ground as a frame sees it.
    pub fn view(&self, frame: u32) -> GroundView {
        GroundView::new(self.eye(frame), self.screen)
    }

    /// Scene of the flight.
    pub fn scene(&self) -> &StudyScene {
        &self.scene
    }

    /// Picture of a frame.
    pub fn picture(&self, frame: u32) -> GreyPicture {
        self.scene.picture(&self.view(frame))
    }

    /// Report of the flight, a line for each frame that it tells of.
    pub fn report(&self) -> String {
        let every = self.settings.simulator.report_every.max(1);
        let mut text = String::from("frame        x ft        y ft   height ft    mean  deviation\n");
        for frame in (0..self.frames).step_by(every as usize) {
            let Eye { place: [x, y], altitude, .. } = self.eye(frame);
            let greys = self.picture(frame).greys;
            let count = greys.len() as f64;
            let mean = greys.iter().copied().map(f64::from).sum::<f64>() / count;
            let squares: f64 = greys.iter().map(|&grey| (f64::from(grey) - mean).powi(2)).sum();
            // Writing to a text cannot fail.
            let _ = writeln!(
                text,
                "{frame:>5} {x:>11.1} {y:>11.1} {altitude:>11.1} {mean:>7.2} {:>10.2}",
                (squares / count).sqrt()
            );
        }
        text
    }

    /// Writes the report to a file, over what is there.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn write_report(&self, path: &Path) -> Result<()> {
        std::fs::write(path, self.report()).map_err(|source| Error::io(path, "write the report", source))
    }
}

fn scene(settings: &Settings) -> Result<StudyScene> {
    let (database, simulator) = (&settings.database, &settings.simulator);
    let code = CyclicCode::new(database.polynomial)?;
    let terrain = TexturedTerrain {
        outline: GroundQuad::rectangle(database.terrain_x_ft, database.terrain_y_ft),
        code: SubterrainCode::new(code, subterrains(database)?)?,
        cell: database.cell_ft,
        shades: Shades::new(database.shades, database.centre)?,
        subdivision: simulator.subdivision,
        slices: SLICES,
        is_smooth_nearby: simulator.smooth_nearby,
    };
    // As far from its side as the study's runway is, and half as long.
    let runway = |tone: u8| {
        let ([x0, x1], [y0, y1]) = (database.terrain_x_ft, database.terrain_y_ft);
        let at = |from: f64, to: f64, share: f64| from + share * (to - from);
        Runway {
            outline: GroundQuad::rectangle(
                [at(x0, x1, 0.1), at(x0, x1, 0.6)],
                [at(y0, y1, 0.5), at(y0, y1, 0.55)],
            ),
            tone,
        }
    };
    Ok(StudyScene {
        sky: database.sky,
        ground: database.ground,
        terrain,
        runway: database.runway.map(runway),
        has_smooth_edges: simulator.smooth_edges,
    })
}

/// Subterrains over the terrain, one after the other along y.
fn subterrains(database: &DatabaseSettings) -> Result<Vec<Subterrain>> {
    let lines = f64::from(database.subterrain_lines.max(1)) * database.cell_ft;
    let [from, to] = database.terrain_y_ft;
    let count = ((to - from) / lines).ceil();
    if !(database.cell_ft > 0.0 && (1.0..=MAX_SUBTERRAINS).contains(&count)) {
        return Err(Error::Configuration(format!(
            "terrain from {from} to {to} ft along y cannot be laid out in subterrains of {} lines of cells of {} ft; \
             want cells above 0 and 1 to {MAX_SUBTERRAINS} subterrains",
            database.subterrain_lines, database.cell_ft
        )));
    }
    let first = (from / database.cell_ft).floor() as i64;
    let subterrain = |number: i64| Subterrain {
        first_line: first + number * i64::from(database.subterrain_lines.max(1)),
        start: database.subterrain_start.wrapping_add(number.wrapping_mul(database.subterrain_slip)),
    };
    Ok((0..count as i64).map(subterrain).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight of two frames on a small screen.
    fn small() -> Settings {
        Settings::from_text(
            "display = { pixels = 48, lines = 36 }\nsimulator = { flight_s = 0.2, step_s = 0.1, report_every = 1 }\n\
             database = { terrain_y_ft = [-900.0, 900.0] }\naircraft = { pitch_deg = -5.0, place_ft = [-300.0, 0.0, 100.0] }",
        )
        .unwrap()
    }

    /// All pictures and the report.
    fn shown(settings: Settings) -> (Vec<GreyPicture>, String) {
        let run = Run::new(settings).unwrap();
        ((0..run.frames()).map(|frame| run.picture(frame)).collect(), run.report())
    }

    #[test]
    fn every_setting_changes_the_output() {
        let settings = small();
        let usual = shown(settings.clone());
        assert!(usual == shown(settings.clone()));

        // One of each field, and of each part of a place.
        for change in [
            "database.polynomial = 0x11D",
            "database.sky = 221",
            "database.ground = 91",
            "database.shades = 16",
            "database.centre = 129",
            "database.terrain_x_ft = [0.0, 6000.0]",
            "database.terrain_y_ft = [-900.0, 400.0]",
            "database.cell_ft = 7.0",
            "database.subterrain_lines = 9",
            "database.subterrain_start = 2",
            "database.subterrain_slip = 11",
            "database.runway = 20",
            "display.pixels = 47",
            "display.lines = 35",
            "display.fov_deg = 21.0",
            "simulator.step_s = 0.11",
            "simulator.flight_s = 0.3",
            "simulator.subdivision = 0",
            "simulator.smooth_edges = false",
            "simulator.smooth_nearby = true",
            "simulator.report_every = 2",
            "aircraft.place_ft = [-300.0, 10.0, 100.0]",
            "aircraft.place_ft = [-300.0, 0.0, 95.0]",
            "aircraft.velocity_ft_s = [300.0, 0.0, 0.0]",
            "aircraft.velocity_ft_s = [337.6, 0.0, 20.0]",
            "aircraft.heading_deg = 1.0",
            "aircraft.pitch_deg = -7.0",
            "aircraft.roll_deg = 3.0",
        ] {
            let changed = settings.changed(change).unwrap();
            assert!(shown(changed) != usual, "{change}");
        }
    }

    #[test]
    fn reports_go_to_files() {
        let run = Run::new(small()).unwrap();
        let folder = std::env::temp_dir().join(format!("hedgehop-study-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("report.txt");
        std::fs::write(&path, "a longer report of an earlier flight".repeat(100)).unwrap();
        run.write_report(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        // A head, and a line for each of two frames.
        assert_eq!((text.lines().count(), &text), (3, &run.report()));
        let error = run.write_report(&folder.join("missing/report.txt")).unwrap_err().to_string();
        assert!(error.contains("report.txt: cannot write the report"), "{error}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn settings_come_back_from_their_text() {
        let settings = small().changed("database.runway = 7\naircraft.roll_deg = 12.5").unwrap();
        let text = settings.to_text().unwrap();
        assert_eq!(Settings::from_text(&text).unwrap(), settings);
        assert_eq!(Settings::from_text("").unwrap(), Settings::default());

        let error = |text: &str| Settings::from_text(text).unwrap_err().to_string();
        assert!(error("[aircraft]\nyaw_deg = 3").contains("yaw_deg"));
        assert!(small().changed("database.sky = 300").unwrap_err().to_string().contains("300"));
    }

    #[test]
    fn settings_out_of_range_are_refused() {
        for (change, words) in [
            ("simulator.step_s = 0.0", "has no frames"),
            ("display.fov_deg = 180.0", "cannot be drawn on"),
            ("display.pixels = 0", "cannot be drawn on"),
            ("database.polynomial = 0x11B", "not primitive"),
            ("database.cell_ft = 0.0", "cannot be laid out"),
            ("database.shades = 33", "power of two"),
        ] {
            let error = Run::new(small().changed(change).unwrap()).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn flights_of_180_frames_move_evenly_over_ground_that_stays() {
        let flown =
            "database.shades = 256\naircraft.velocity_ft_s = [337.6, 40.0, -10.0]\naircraft.roll_deg = 12.0";
        let settings =
            small().changed("simulator = { step_s = 0.033333333333333333, flight_s = 6.0 }").unwrap();
        let run = Run::new(settings.changed(flown).unwrap()).unwrap();
        assert_eq!(run.frames(), 180);
        let [first, last] = [0, 179].map(|frame| run.eye(frame));
        let seconds = 179.0 / 30.0;
        assert!((last.place[0] - first.place[0] - 337.6 * seconds).abs() < 1e-6);
        assert!((last.altitude - first.altitude + 10.0 * seconds).abs() < 1e-6);

        // One place on the ground, looked for on every frame's screen, has one tone.
        let code = &run.scene().terrain.code;
        let tone = |ground: [f64; 2]| {
            let [column, row] = ground.map(|feet| (feet / 6.0).floor() as i64);
            code.tone(column, row)
        };
        let mut found = 0;
        for frame in 0..180 {
            let view = run.view(frame);
            for ground in [[3001.0, 7.0], [2500.5, -400.0], [5003.0, 303.0]] {
                let at = view.projected(view.seen(ground));
                let back = view.ground(at).unwrap();
                assert_eq!(tone(back), tone(ground), "frame {frame}");
                found += 1;
            }
        }
        assert_eq!(found, 540);
    }
}
