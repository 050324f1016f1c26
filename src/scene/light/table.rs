//! The table `[[light]]`.

use std::ops::Range;

use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

use super::lamp::{Colour, around, beam};
use super::{Flash, Lamp, LampLayout, Light, MOST_LAMPS, Rhythm, kinds};
use crate::objects::Fixture;
use crate::scene::Anchor;
use crate::scene::place::{Above, PLACE_KEYS, Place, finite};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Brightest lamp, candela: searchlights have 10⁹.
const MOST_CANDELA: f64 = 1.0e10;

/// Longest line and largest area of lights, metres.
const LONGEST: f64 = 100_000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[light]]")]
pub(in crate::scene) struct LightTable {
    name: Option<String>,
    kind: Option<Spanned<LightKind>>,
    at: Option<Spanned<Vec<f64>>>,
    at_lonlat: Option<Spanned<Vec<f64>>>,
    altitude: Option<Spanned<Above>>,
    object: Option<Spanned<String>>,
    offset_m: Option<Spanned<Vec<f64>>>,
    yaw_deg: Option<Spanned<f64>>,
    pitch_deg: Option<Spanned<f64>>,
    candela: Option<Spanned<f64>>,
    colour: Option<Spanned<String>>,
    size_m: Option<Spanned<f64>>,
    beam_deg: Option<Spanned<Vec<f64>>>,
    two_sided: Option<Spanned<bool>>,
    flash_s: Option<Spanned<Vec<f64>>>,
    phase_s: Option<Spanned<f64>>,
    turn_rpm: Option<Spanned<f64>>,
    to: Option<Spanned<Vec<f64>>>,
    spacing_m: Option<Spanned<f64>>,
    running_s: Option<Spanned<f64>>,
    length_m: Option<Spanned<f64>>,
    width_m: Option<Spanned<f64>>,
    centre_line: Option<Spanned<bool>>,
    flashers: Option<Spanned<bool>>,
    slope_deg: Option<Spanned<f64>>,
    side: Option<Spanned<Side>>,
    extent_m: Option<Spanned<Vec<f64>>>,
    count: Option<Spanned<u32>>,
    seed: Option<Spanned<u32>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LightKind {
    Lamp,
    String,
    Runway,
    Approach,
    Papi,
    Vasi,
    Beacon,
    Town,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Side {
    Left,
    Right,
}

/// Keys that each kind takes besides its name, its place and `candela`.
const KEYS: [(LightKind, &str, &[&str]); 8] = [
    (
        LightKind::Lamp,
        "lamp",
        &[
            "object",
            "offset_m",
            "pitch_deg",
            "colour",
            "size_m",
            "beam_deg",
            "two_sided",
            "flash_s",
            "phase_s",
            "turn_rpm",
        ],
    ),
    (
        LightKind::String,
        "string",
        &["colour", "size_m", "flash_s", "phase_s", "to", "spacing_m", "running_s"],
    ),
    (LightKind::Runway, "runway", &["length_m", "width_m", "centre_line"]),
    (LightKind::Approach, "approach", &["length_m", "flashers"]),
    (LightKind::Papi, "papi", &["slope_deg", "side"]),
    (LightKind::Vasi, "vasi", &["slope_deg"]),
    (LightKind::Beacon, "beacon", &["turn_rpm"]),
    (LightKind::Town, "town", &["colour", "extent_m", "count", "seed"]),
];

/// A light while it is read.
struct LightEntry<'t, 'f> {
    reading: &'t Reading<'f>,
    table: &'t LightTable,
    span: Range<usize>,
    kind: &'static str,
}

/// Reads the light that is the `number`th of its scene, from 1 on.
pub(in crate::scene) fn light(
    reading: &Reading<'_>,
    table: &Spanned<LightTable>,
    number: usize,
) -> Result<Light> {
    let (span, table) = (table.span(), table.get_ref());
    let kind = table.kind.as_ref().map_or(LightKind::Lamp, |kind| *kind.get_ref());
    let (_, word, keys) = KEYS.into_iter().find(|(of, ..)| *of == kind).unwrap_or(KEYS[0]);
    let name = table.name.clone().unwrap_or_else(|| format!("{word} {number}"));
    if name.trim().is_empty() || name.chars().any(char::is_control) || name.chars().count() > 200 {
        return Err(reading.wrong(span, "a light's name must be 1 to 200 printable characters"));
    }
    let entry = LightEntry { reading, table, span: span.clone(), kind: word };
    entry.takes(keys)?;
    let line = reading.line(&span);
    let anchor = entry.anchor(&name)?;
    Ok(Light { line, layout: entry.layout(kind, &name)?, anchor, name })
}

impl LightEntry<'_, '_> {
    /// Refuses keys of other kinds.
    fn takes(&self, keys: &[&str]) -> Result<()> {
        let Self { table, kind, .. } = self;
        fn at<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
            value.as_ref().map(Spanned::span)
        }

        let given = [
            ("object", at(&table.object)),
            ("offset_m", at(&table.offset_m)),
            ("pitch_deg", at(&table.pitch_deg)),
            ("colour", at(&table.colour)),
            ("size_m", at(&table.size_m)),
            ("beam_deg", at(&table.beam_deg)),
            ("two_sided", at(&table.two_sided)),
            ("flash_s", at(&table.flash_s)),
            ("phase_s", at(&table.phase_s)),
            ("turn_rpm", at(&table.turn_rpm)),
            ("to", at(&table.to)),
            ("spacing_m", at(&table.spacing_m)),
            ("running_s", at(&table.running_s)),
            ("length_m", at(&table.length_m)),
            ("width_m", at(&table.width_m)),
            ("centre_line", at(&table.centre_line)),
            ("flashers", at(&table.flashers)),
            ("slope_deg", at(&table.slope_deg)),
            ("side", at(&table.side)),
            ("extent_m", at(&table.extent_m)),
            ("count", at(&table.count)),
            ("seed", at(&table.seed)),
        ];

        let other =
            given.into_iter().find_map(|(key, span)| Some(key).zip(span).filter(|_| !keys.contains(&key)));
        other.map_or(Ok(()), |(key, span)| {
            Err(self.reading.wrong(span, format!("a {kind} has no {key}; it takes {}", keys.join(", "))))
        })
    }

    fn wrong(&self, what: &str) -> hedgehop_base::error::Error {
        self.reading.wrong(self.span.clone(), what)
    }

    /// Reads the anchor.
    fn anchor(&self, name: &str) -> Result<Anchor> {
        let table = self.table;
        if let (Some(offset), None) = (&table.offset_m, &table.object) {
            return Err(self
                .reading
                .wrong(offset.span(), "offset_m is for lights of an object; give object, too"));
        }
        self.place(&format!("light `{name}`"), table.at.as_ref(), table.at_lonlat.as_ref())
            .anchor(self.reading, table.object.as_ref())
    }

    fn place<'p>(
        &'p self,
        whose: &'p str,
        at: Option<&'p Spanned<Vec<f64>>>,
        at_lonlat: Option<&'p Spanned<Vec<f64>>>,
    ) -> Place<'p> {
        Place {
            whose,
            keys: PLACE_KEYS,
            at,
            at_lonlat,
            altitude: self.table.altitude.as_ref().map(|above| *above.get_ref()),
            yaw: self.table.yaw_deg.as_ref(),
            pitch: None,
            roll: None,
            span: self.span.clone(),
        }
    }

    fn layout(&self, kind: LightKind, name: &str) -> Result<LampLayout> {
        let table = self.table;
        let metres = |key: &str, value: &Option<Spanned<f64>>, default: Option<f64>, least: f64| {
            let want = format!("must be {least} m to 100 km");
            self.number(key, value.as_ref(), default, least..=LONGEST, &want)
        };

        let slope = || {
            self.number(
                "slope_deg",
                table.slope_deg.as_ref(),
                Some(3.0),
                1.0..=15.0,
                "must be 1 to 15 degrees",
            )
        };

        Ok(LampLayout::Lamps(match kind {
            LightKind::Lamp => {
                let offset = match &table.offset_m {
                    Some(offset) => finite(self.reading, "offset_m", offset)?.into(),
                    None => DVec3::ZERO,
                };
                vec![Lamp {
                    offset,
                    yaw: self.own_yaw()?,
                    fixture: self.fixture()?.into(),
                    rhythm: self.rhythm()?,
                }]
            }
            LightKind::String => {
                let to = table.to.as_ref().ok_or_else(|| self.wrong("a string needs to"))?;
                let whose = format!("the end of light `{name}`");
                let to = match &table.at_lonlat {
                    Some(_) => self.place(&whose, None, Some(to)),
                    None => self.place(&whose, Some(to), None),
                };
                let to = Place { keys: ["to"; 2], ..to }.track(self.reading)?;
                let spacing = metres("spacing_m", &table.spacing_m, None, 0.1)?;
                let running = table.running_s.as_ref();
                if let (Some(running), None) = (running, &table.flash_s) {
                    return Err(self
                        .reading
                        .wrong(running.span(), "running_s is for lights that flash; give flash_s, too"));
                }

                let seconds = |value| {
                    self.number("running_s", Some(value), None, -3600.0..=3600.0, "must be -3600 to 3600 s")
                };
                let running = running.map(seconds).transpose()?;

                let lamp = Lamp {
                    offset: DVec3::ZERO,
                    yaw: 0.0,
                    fixture: self.fixture()?.into(),
                    rhythm: self.rhythm()?,
                };
                return Ok(LampLayout::String(lamp, Box::new(to), spacing, running));
            }
            LightKind::Runway => kinds::runway(
                metres("length_m", &table.length_m, None, 100.0)?,
                metres("width_m", &table.width_m, Some(45.0), 3.0)?,
                self.candela(150.0)?,
                table.centre_line.as_ref().is_some_and(|has| *has.get_ref()),
            ),
            LightKind::Approach => kinds::approach(
                metres("length_m", &table.length_m, Some(900.0), 30.0)?,
                self.candela(250.0)?,
                table.flashers.as_ref().is_none_or(|has| *has.get_ref()),
            ),
            LightKind::Papi => {
                let side = table.side.as_ref().map_or(Side::Left, |side| *side.get_ref());
                kinds::papi(slope()?, self.candela(1500.0)?, if side == Side::Left { 1.0 } else { -1.0 })
            }
            LightKind::Vasi => kinds::vasi(slope()?, self.candela(1500.0)?),
            LightKind::Beacon => {
                let turns = self.number(
                    "turn_rpm",
                    table.turn_rpm.as_ref(),
                    Some(12.0),
                    0.0..=600.0,
                    "must be 0 to 600 turns a minute",
                )?;
                kinds::beacon(self.candela(20_000.0)?, turns / 60.0)
            }
            LightKind::Town => {
                let extent = table.extent_m.as_ref().ok_or_else(|| self.wrong("a town needs extent_m"))?;
                let metres: [f64; 2] = self.reading.numbers("extent_m", extent)?;
                if !metres.into_iter().all(|metres| metres > 0.0 && metres <= LONGEST) {
                    let what = format!(
                        "extent_m must be two lengths of more than 0 m and at most 100 km, not {metres:?}"
                    );
                    return Err(self.reading.wrong(extent.span(), what));
                }

                let given = table.count.as_ref().ok_or_else(|| self.wrong("a town needs count"))?;
                let count = *given.get_ref() as usize;
                if count > MOST_LAMPS {
                    return Err(self
                        .reading
                        .wrong(given.span(), format!("count must be {MOST_LAMPS} at most, not {count}")));
                }

                let seed = table.seed.as_ref().map_or(0, |seed| u64::from(*seed.get_ref()));
                kinds::town(metres, count, self.candela(60.0)?, self.colour(Colour::WARM)?, seed)
            }
        }))
    }

    fn number(
        &self,
        key: &str,
        value: Option<&Spanned<f64>>,
        default: Option<f64>,
        range: std::ops::RangeInclusive<f64>,
        want: &str,
    ) -> Result<f64> {
        match (value, default) {
            (Some(value), _) => self.reading.number(key, value, |number| range.contains(&number), want),
            (None, Some(default)) => Ok(default),
            (None, None) => Err(self.wrong(&format!("a {} needs {key}", self.kind))),
        }
    }

    fn candela(&self, default: f64) -> Result<f64> {
        self.number(
            "candela",
            self.table.candela.as_ref(),
            Some(default),
            0.0..=MOST_CANDELA,
            "must be 0 to 10¹⁰ cd",
        )
    }

    fn colour(&self, default: Colour) -> Result<Colour> {
        let Some(colour) = &self.table.colour else { return Ok(default) };
        Colour::parse(colour.get_ref()).ok_or_else(|| {
            let what = format!(
                "colour must be white, red, green, yellow, blue, warm or #rrggbb (sRGB, not black), not {:?}",
                colour.get_ref()
            );
            self.reading.wrong(colour.span(), what)
        })
    }

    /// Turn of a lamp against its anchor: that of a light that stands is in its place's yaw.
    fn own_yaw(&self) -> Result<f64> {
        let yaw = self.table.yaw_deg.as_ref().filter(|_| self.table.object.is_some());
        self.number("yaw_deg", yaw, Some(0.0), -360.0..=360.0, "must lie between -360 and 360 degrees")
    }

    /// The fixture of a lamp or a string.
    fn fixture(&self) -> Result<Fixture> {
        let table = self.table;
        let (colour, candela) = (self.colour(Colour::WHITE)?, self.candela(100.0)?);
        let size =
            self.number("size_m", table.size_m.as_ref(), Some(0.2), 0.0..=1000.0, "must be 0 to 1000 m")?;

        let pitch = self.number(
            "pitch_deg",
            table.pitch_deg.as_ref(),
            Some(0.0),
            -90.0..=90.0,
            "must be -90 to 90 degrees",
        )?;

        let beams = match &table.beam_deg {
            None => match table
                .pitch_deg
                .as_ref()
                .map(Spanned::span)
                .or(table.two_sided.as_ref().map(Spanned::span))
            {
                Some(span) => {
                    return Err(self.reading.wrong(
                        span,
                        "pitch_deg and two_sided are for lamps with a beam; give beam_deg, too",
                    ));
                }
                None => vec![around(colour, candela)],
            },
            Some(given) => {
                let widths: [f64; 2] = self.reading.numbers("beam_deg", given)?;
                if !widths.into_iter().all(|width| width > 0.0 && width <= 360.0) {
                    let what = format!(
                        "beam_deg must be [wide, high] of more than 0 and at most 360 degrees, not {widths:?}"
                    );
                    return Err(self.reading.wrong(given.span(), what));
                }

                let half = widths.map(|width| 0.5 * width);
                let front = beam(colour, candela, [0.0, pitch], half);
                if table.two_sided.as_ref().is_some_and(|both| *both.get_ref()) {
                    vec![front, beam(colour, candela, [180.0, pitch], half)]
                } else {
                    vec![front]
                }
            }
        };

        Ok(Fixture { radius: 0.5 * size, beams })
    }

    fn rhythm(&self) -> Result<Rhythm> {
        let table = self.table;
        let flash = match &table.flash_s {
            None => match &table.phase_s {
                Some(phase) => {
                    return Err(self
                        .reading
                        .wrong(phase.span(), "phase_s is for lights that flash; give flash_s, too"));
                }
                None => None,
            },
            Some(given) => {
                let [period, on]: [f64; 2] = self.reading.numbers("flash_s", given)?;
                if !(on > 0.0 && on <= period && period <= 3600.0) {
                    let what = format!(
                        "flash_s must be [from flash to flash, length of each] in seconds, the second no longer than the first, 3600 at most, not {:?}",
                        given.get_ref()
                    );
                    return Err(self.reading.wrong(given.span(), what));
                }

                let phase = self.number(
                    "phase_s",
                    table.phase_s.as_ref(),
                    Some(0.0),
                    -3600.0..=3600.0,
                    "must be -3600 to 3600 s",
                )?;

                Some(Flash { period, on, phase })
            }
        };

        let turns = self.number(
            "turn_rpm",
            table.turn_rpm.as_ref(),
            Some(0.0),
            -600.0..=600.0,
            "must be -600 to 600 turns a minute",
        )?;

        Ok(Rhythm { flash, turns: turns / 60.0 })
    }
}
