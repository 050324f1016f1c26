//! The table `[[plume]]`: smoke and dust.

use glam::{DVec2, DVec3, Vec3};
use serde::Deserialize;
use toml::Spanned;

use super::place::{Above, PLACE_KEYS, Place, finite};
use crate::flight::{BindOptions, Trajectory};
use crate::scene::Anchor;
use crate::space::Pose;
use crate::weather::Puff;
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_hex};
use hedgehop_base::document::Reading;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Puffs of one plume at a time, and of a scene's plumes together.
const MOST_PUFFS: f64 = 5000.0;
const MOST_OF_ALL: f64 = 50_000.0;

/// Speed at which dust is as thick as it gets, metres per second, and time over which speed is measured, seconds.
const DUSTY: f64 = 8.0;
const STEP: f64 = 0.1;

/// Parts of a puff's life in which it comes and in which it goes.
const COMES: f64 = 0.05;
const GOES: f64 = 0.5;

/// Distance by which puffs stray from the middle of a plume, and by which they differ in size, in radii.
const STRAYS: f64 = 0.6;
const DIFFERS: f64 = 0.35;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[plume]]")]
pub(super) struct PlumeTable {
    name: Option<String>,
    kind: Option<Spanned<PlumeKind>>,
    at: Option<Spanned<Vec<f64>>>,
    at_lonlat: Option<Spanned<Vec<f64>>>,
    altitude: Option<Spanned<Above>>,
    object: Option<Spanned<String>>,
    offset_m: Option<Spanned<Vec<f64>>>,
    colour: Option<Spanned<String>>,
    opacity: Option<Spanned<f64>>,
    size_m: Option<Spanned<f64>>,
    growth_mps: Option<Spanned<f64>>,
    rise_mps: Option<Spanned<f64>>,
    life_s: Option<Spanned<f64>>,
    per_s: Option<Spanned<f64>>,
    wind_mps: Option<Spanned<Vec<f64>>>,
    start_s: Option<Spanned<f64>>,
}

/// Matter of a plume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlumeKind {
    /// Dark, and rises.
    Smoke,
    /// White, and soon gone.
    Steam,
    /// Whirled up by what moves: none while that stands.
    Dust,
}

/// Something that puffs come from, one after the other.
#[derive(Debug, Clone)]
pub struct Plume {
    /// Name in messages.
    pub name: String,
    /// Line of the scene file, from 1 on.
    pub line: usize,
    /// Place that they come from.
    pub anchor: Anchor,
    /// Offset from there, right, forward and up, metres.
    pub offset: DVec3,
    /// Matter of the plume.
    pub kind: PlumeKind,
    /// Linear Rec. 709 reflectance, 0…1.
    pub albedo: Vec3,
    /// Share of what is behind it that a fresh puff hides in its middle, 0 ≤ … < 1.
    pub opacity: f64,
    /// Width of a fresh puff, metres: four standard deviations of its density.
    pub size: f64,
    /// Growth of the radius, metres per second.
    pub growth: f64,
    /// Speed of its rise, metres per second.
    pub rise: f64,
    /// Seconds after which it is gone.
    pub life: f64,
    /// Puffs per second.
    pub rate: f64,
    /// Eastward and northward, metres per second.
    pub wind: [f64; 2],
    /// Time of the first, seconds after the flight's first fix; `None`: long before.
    pub start: Option<f64>,
}

/// Numbers of a kind: colour, opacity, size, growth, rise, life, rate.
fn presets(kind: PlumeKind) -> ([u8; 3], [f64; 6]) {
    match kind {
        PlumeKind::Smoke => ([70, 68, 66], [0.6, 3.0, 1.2, 2.5, 20.0, 8.0]),
        PlumeKind::Steam => ([250; 3], [0.5, 2.0, 1.5, 2.0, 6.0, 10.0]),
        PlumeKind::Dust => ([176, 156, 126], [0.35, 3.0, 1.5, 0.3, 8.0, 10.0]),
    }
}

/// Reads the plume that is the `number`th of its scene, from 1 on.
pub(super) fn plume(reading: &Reading<'_>, table: Spanned<PlumeTable>, number: usize) -> Result<Plume> {
    let (span, table) = (table.span(), table.into_inner());
    let given = table
        .kind
        .as_ref()
        .ok_or_else(|| reading.wrong(span.clone(), "a plume needs kind: smoke, steam or dust"))?;
    let kind = *given.get_ref();
    let name = table.name.unwrap_or_else(|| format!("plume {number}"));
    if name.trim().is_empty() || name.chars().any(char::is_control) || name.chars().count() > 200 {
        return Err(reading.wrong(span, "a plume's name must be 1 to 200 printable characters"));
    }

    let place = Place {
        whose: &format!("plume `{name}`"),
        keys: PLACE_KEYS,
        at: table.at.as_ref(),
        at_lonlat: table.at_lonlat.as_ref(),
        altitude: table.altitude.as_ref().map(|above| *above.get_ref()),
        yaw: None,
        pitch: None,
        roll: None,
        span: span.clone(),
    };

    let anchor = place.anchor(reading, table.object.as_ref())?;
    if let (PlumeKind::Dust, Anchor::At(_)) = (kind, &anchor) {
        return Err(reading.wrong(given.span(), "dust is whirled up by what moves; give object"));
    }

    let (grey, presets) = presets(kind);
    let number = |key: &str,
                  value: &Option<Spanned<f64>>,
                  default: f64,
                  range: std::ops::RangeInclusive<f64>| {
        let want = format!("must be {} to {}", range.start(), range.end());
        let value = value.as_ref();
        value.map_or(Ok(default), |value| reading.number(key, value, |number| range.contains(&number), &want))
    };

    let [opacity, size, growth, rise, life, rate] = presets;
    let life = number("life_s", &table.life_s, life, 0.1..=600.0)?;
    let rate = number("per_s", &table.per_s, rate, 0.1..=100.0)?;
    if life * rate > MOST_PUFFS {
        let what = format!("life_s times per_s must be {MOST_PUFFS} puffs at most, not {}", life * rate);
        return Err(reading.wrong(span, what));
    }

    let colour = match &table.colour {
        Some(colour) => srgb8_from_hex(colour.get_ref()).ok_or_else(|| {
            reading.wrong(colour.span(), format!("colour must be #rrggbb (sRGB), not {:?}", colour.get_ref()))
        })?,
        None => grey,
    };

    Ok(Plume {
        line: reading.line(&span),
        offset: table
            .offset_m
            .as_ref()
            .map_or(Ok([0.0; 3]), |offset| finite(reading, "offset_m", offset))?
            .into(),
        albedo: linear_from_srgb8(colour).into(),
        opacity: number("opacity", &table.opacity, opacity, 0.0..=0.99)?,
        size: number("size_m", &table.size_m, size, 0.1..=1000.0)?,
        growth: number("growth_mps", &table.growth_mps, growth, 0.0..=100.0)?,
        rise: number("rise_mps", &table.rise_mps, rise, -50.0..=50.0)?,
        wind: match &table.wind_mps {
            Some(wind) => {
                let metres: [f64; 2] = reading.numbers("wind_mps", wind)?;
                if !metres.into_iter().all(|speed| speed.abs() <= 100.0) {
                    return Err(reading.wrong(
                        wind.span(),
                        format!("wind_mps must be two speeds of 100 m/s at most, not {metres:?}"),
                    ));
                }
                metres
            }
            None => [0.0; 2],
        },
        start: table
            .start_s
            .as_ref()
            .map(|start| reading.number("start_s", start, |_| true, "must be finite"))
            .transpose()?,
        name,
        anchor,
        kind,
        life,
        rate,
    })
}

/// Plumes over a database.
#[derive(Debug, Clone, Default)]
pub(super) struct PlumeCast(Vec<(Plume, PuffSource)>);

/// Source of puffs.
#[derive(Debug, Clone, Copy)]
enum PuffSource {
    Actor(usize),
    Place(DVec3),
}

impl PlumeCast {
    /// `plumes` over a database; `actor` tells the number of an object by its name.
    pub fn bind(
        plumes: &[Plume],
        crs: &Crs,
        ground: &dyn Fn(DVec2) -> Option<f64>,
        wrong: impl Fn(usize, &str) -> Error,
        actor: impl Fn(&str) -> Option<usize>,
    ) -> Result<Self> {
        let mut bound = Vec::new();
        let mut count = 0.0;
        for plume in plumes {
            let wrong = |what: &str| wrong(plume.line, &format!("plume `{}`: {what}", plume.name));
            count += plume.life * plume.rate;
            if count > MOST_OF_ALL {
                return Err(wrong(&format!(
                    "all plumes together have at most {MOST_OF_ALL} puffs at a time"
                )));
            }

            let source = match &plume.anchor {
                Anchor::On(object) => PuffSource::Actor(
                    actor(object).ok_or_else(|| wrong(&format!("there is no object `{object}`")))?,
                ),
                Anchor::At(track) => {
                    let options = BindOptions::default();
                    let bound = Trajectory::bind(track, crs, ground, &options);
                    PuffSource::Place(bound.map_err(|error| wrong(&error.to_string()))?.pose_at(0.0).eye)
                }
            };

            bound.push((plume.clone(), source));
        }

        Ok(Self(bound))
    }

    /// All puffs so many seconds after the flight's first fix; `pose` tells where an actor is at a time; one that is not there sends none.
    pub fn at(&self, seconds: f64, pose: impl Fn(usize, f64) -> Option<Pose>) -> Vec<Puff> {
        let mut puffs = Vec::new();
        for (plume, source) in &self.0 {
            // Puffs are numbered from the flight's first fix on, so that each is itself in every frame.
            let first = ((seconds - plume.life) * plume.rate).floor() as i64 + 1;
            let last = (seconds * plume.rate).floor() as i64;
            for number in first..=last {
                let born = number as f64 / plume.rate;
                if plume.start.is_some_and(|start| born < start) {
                    continue;
                }

                let (from, speed) = match source {
                    PuffSource::Place(place) => (*place + plume.offset, 0.0),
                    PuffSource::Actor(actor) => {
                        let (Some(now), Some(before)) = (pose(*actor, born), pose(*actor, born - STEP))
                        else {
                            continue;
                        };
                        let speed = (now.eye - before.eye).length() / STEP;
                        let DVec3 { x: right, y: forward, z: up } = plume.offset;
                        (now.eye + now.attitude.world_from_view() * DVec3::new(right, up, forward), speed)
                    }
                };

                puffs.extend(plume.puff(number, seconds - born, from, speed));
            }
        }

        puffs
    }
}

impl Plume {
    /// The puff of a number, `age` seconds after it came from a place that moved at a speed, metres per second.
    fn puff(&self, number: i64, age: f64, from: DVec3, speed: f64) -> Option<Puff> {
        let strength = if self.kind == PlumeKind::Dust { (speed / DUSTY).min(1.0) } else { 1.0 };
        let part = age / self.life;
        let fades = (part / COMES).min(1.0) * ((1.0 - part) / GOES).clamp(0.0, 1.0);
        let fresh = 0.25 * self.size * (1.0 + DIFFERS * scatter(number, 3));
        let radius = fresh + 0.25 * self.growth * age;
        // What a puff is made of spreads over its growing cross section.
        let depth = -(1.0 - self.opacity).ln() * (fresh / radius).powi(2) * fades * strength;
        let strays = DVec3::from_array([0, 1, 2].map(|axis| scatter(number, axis))) * (STRAYS * radius);
        let wind = DVec3::new(self.wind[0], self.wind[1], self.rise) * age;
        let puff = Puff { centre: from + wind + strays, radius, depth: depth as f32, albedo: self.albedo };
        (depth > 0.0).then_some(puff)
    }
}

/// A number of -1…1 without pattern, for each of many, and of each for several uses.
pub(super) fn scatter(number: i64, part: u64) -> f64 {
    hedgehop_base::chance::unit(number as u64 ^ part.rotate_right(8)) * 2.0 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Attitude;

    fn smoke() -> Plume {
        Plume {
            name: "smoke".into(),
            line: 1,
            anchor: Anchor::On("x".into()),
            offset: DVec3::ZERO,
            kind: PlumeKind::Smoke,
            albedo: Vec3::splat(0.1),
            opacity: 0.5,
            size: 4.0,
            growth: 2.0,
            rise: 3.0,
            life: 10.0,
            rate: 5.0,
            wind: [2.0, 0.0],
            start: None,
        }
    }

    fn pose(seconds: f64) -> Pose {
        Pose { eye: DVec3::new(0.0, 10.0 * seconds, 100.0), attitude: Attitude::default(), hfov: 60.0 }
    }

    fn at(plume: &Plume, seconds: f64) -> Vec<Puff> {
        PlumeCast(vec![(plume.clone(), PuffSource::Actor(0))]).at(seconds, |_, seconds| Some(pose(seconds)))
    }

    #[test]
    fn puffs_come_where_the_object_was_and_go_with_the_wind() {
        let puffs = at(&smoke(), 33.0);
        assert!((45..=50).contains(&puffs.len()), "{}", puffs.len());
        for puff in &puffs {
            let age = (330.0 - puff.centre.y) / 10.0;
            let off = puff.centre - DVec3::new(2.0 * age, puff.centre.y, 100.0 + 3.0 * age);
            assert!(off.length() < 2.5 * puff.radius && puff.radius < 1.4 + 0.5 * 11.0, "{puff:?}");
        }
        let mean = puffs.iter().map(|puff| puff.centre).sum::<DVec3>() / puffs.len() as f64;
        assert!((mean.y - 280.0).abs() < 6.0, "{mean}");
    }

    #[test]
    fn a_puff_moves_steadily_from_frame_to_frame() {
        let (now, then) = (at(&smoke(), 20.0), at(&smoke(), 20.04));
        let moved = now.iter().filter(|puff| {
            then.iter().any(|later| {
                (later.centre - puff.centre).length() < 0.3 && (later.depth - puff.depth).abs() < 0.12
            })
        });
        assert!(moved.count() >= now.len() - 1);
    }

    #[test]
    fn dust_needs_speed_and_smoke_a_start() {
        let dust = Plume { kind: PlumeKind::Dust, ..smoke() };
        let still = PlumeCast(vec![(dust.clone(), PuffSource::Actor(0))]).at(20.0, |_, _| Some(pose(1.0)));
        assert!(still.is_empty() && !at(&dust, 20.0).is_empty());
        assert!(at(&Plume { start: Some(19.0), ..smoke() }, 20.0).len() <= 6);
        assert!(at(&Plume { start: Some(21.0), ..smoke() }, 20.0).is_empty());
    }
}
