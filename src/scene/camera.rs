//! The table `[[camera]]`: shots of a film.

use std::collections::BTreeSet;
use std::mem::discriminant;
use std::ops::{Range, RangeInclusive};

use serde::Deserialize;
use toml::Spanned;

use super::place::{Above, Place};
use crate::flight::{Chase, Ease, Fix, Keys, Look, Mount, Orbit, Shot, Track, Zoom};
use hedgehop_base::document::Reading;
use hedgehop_base::error::{Error, Result};

/// Longest time of a shot, seconds.
const LONGEST: f64 = 1.0e7;

/// Narrowest and widest field of view, degrees, as of `--hfov`.
const FIELDS: RangeInclusive<f64> = 0.01..=175.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[camera]]")]
pub(super) struct CameraTable {
    from_s: Option<Spanned<f64>>,
    chase_m: Option<Spanned<Vec<f64>>>,
    orbit_m: Option<Spanned<Vec<f64>>>,
    turn_s: Option<Spanned<f64>>,
    at: Option<Spanned<Vec<f64>>>,
    at_lonlat: Option<Spanned<Vec<f64>>>,
    altitude: Option<Spanned<Above>>,
    yaw_deg: Option<Spanned<f64>>,
    pitch_deg: Option<Spanned<f64>>,
    roll_deg: Option<Spanned<f64>>,
    look: Option<Spanned<LookName>>,
    look_ahead_s: Option<Spanned<f64>>,
    look_at: Option<Spanned<Vec<f64>>>,
    look_at_lonlat: Option<Spanned<Vec<f64>>>,
    look_at_altitude: Option<Spanned<Above>>,
    look_at_object: Option<Spanned<String>>,
    hfov_deg: Option<Spanned<FieldOfView>>,
    ease: Option<Spanned<EaseName>>,
    key: Option<Spanned<Vec<Spanned<KeyTable>>>>,
}

/// Pose at a time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[camera.key]]")]
struct KeyTable {
    t_s: Spanned<f64>,
    at: Option<Spanned<Vec<f64>>>,
    at_lonlat: Option<Spanned<Vec<f64>>>,
    altitude: Option<Spanned<Above>>,
    yaw_deg: Option<Spanned<f64>>,
    pitch_deg: Option<Spanned<f64>>,
    roll_deg: Option<Spanned<f64>>,
    hfov_deg: Option<Spanned<f64>>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LookName {
    Ahead,
    Down,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum EaseName {
    Linear,
    InOut,
}

/// One field of view, or one at either end of the shot.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "degrees, or two of them: [60, 30]")]
enum FieldOfView {
    Fixed(f64),
    Zoomed([f64; 2]),
}

/// Reads all cameras; `objects` are the names that they may look at.
pub(super) fn read_cameras(
    reading: &Reading<'_>,
    tables: &[Spanned<CameraTable>],
    objects: &BTreeSet<String>,
) -> Result<Vec<Shot>> {
    let mut shots: Vec<Shot> = Vec::with_capacity(tables.len());
    for (index, table) in tables.iter().enumerate() {
        let shot = Table { reading, whose: format!("camera {}", index + 1), table }.shot(objects)?;
        if shots.last().is_some_and(|before| shot.from <= before.from) {
            let what = format!(
                "camera {} must begin after the one before it: from_s says when, seconds after the flight's first fix",
                index + 1
            );
            return Err(reading.wrong(table.span(), what));
        }
        shots.push(shot);
    }
    Ok(shots)
}

/// Whether a view from a place needs angles to have a direction.
fn needs_angles(look: Option<&Look>) -> bool {
    matches!(look, None | Some(Look::Nose))
}

/// Whether angles of a pose say nothing of a view.
fn is_at_something(look: Option<&Look>) -> bool {
    matches!(look, Some(Look::Ahead(_) | Look::Place(_) | Look::Object(_)))
}

/// A camera while it is read.
struct Table<'t> {
    reading: &'t Reading<'t>,
    whose: String,
    table: &'t Spanned<CameraTable>,
}

impl Table<'_> {
    fn shot(&self, objects: &BTreeSet<String>) -> Result<Shot> {
        let table = self.table.get_ref();
        let look = self.look(objects)?;
        let mount = self.mount(look.as_ref())?;
        self.refuse_idle(&mount, look.as_ref())?;

        // A pitch of its own is the view's where no pose has it.
        let pitch = match (&mount, &table.pitch_deg) {
            (Mount::Keys(_), _) | (_, None) => None,
            (_, Some(pitch)) => Some(Look::Pitch(self.degrees("pitch_deg", pitch, 90.0)?)),
        };
        if let (Some(_), Some(_), Some(span)) = (&look, &pitch, table.pitch_deg.as_ref().map(Spanned::span)) {
            return Err(self
                .reading
                .wrong(span, "pitch_deg is of a view that looks at nothing; leave one of them out"));
        }

        let first_key = match &mount {
            Mount::Keys(keys) => keys.start,
            _ => 0.0,
        };
        let from = match &table.from_s {
            Some(from) => self.time("from_s", from)?,
            None => first_key,
        };
        Ok(Shot { from, mount, look: look.or(pitch), zoom: self.zoom()? })
    }

    fn mount(&self, look: Option<&Look>) -> Result<Mount> {
        let table = self.table.get_ref();
        let spans = [&table.chase_m, &table.orbit_m, &table.at, &table.at_lonlat];
        let key = table.key.as_ref().map(Spanned::span);
        let said: Vec<_> = spans.into_iter().flatten().map(Spanned::span).chain(key).collect();
        if let [_, second, ..] = said.as_slice() {
            let what =
                format!("{} has one of chase_m, orbit_m, at, at_lonlat and [[camera.key]]", self.whose);
            return Err(self.reading.wrong(second.clone(), what));
        }

        if let Some(offsets) = &table.chase_m {
            let want =
                "chase_m must be [back, up] or [back, up, right], metres, not all 0 and a million at most";
            let chase = Chase::of(offsets.get_ref()).map(Mount::Chase);
            return chase.ok_or_else(|| self.reading.wrong(offsets.span(), want));
        }
        if let Some(lengths) = &table.orbit_m {
            let want = "orbit_m must be [radius, up], metres, with a radius above 0 and a million at most, and turn_s 1 or \
                        more seconds of the film, or -1 or less: anticlockwise";
            let lengths_m: [f64; 2] = self.reading.numbers("orbit_m", lengths)?;
            let orbit = Orbit::of(lengths_m, table.turn_s.as_ref().map(|turn| *turn.get_ref()));
            return orbit.map(Mount::Orbit).ok_or_else(|| self.reading.wrong(lengths.span(), want));
        }

        if let Some(keys) = &table.key {
            return self.keys(keys, look).map(Mount::Keys);
        }
        if table.at.is_some() || table.at_lonlat.is_some() {
            if needs_angles(look) && table.yaw_deg.is_none() {
                return Err(self.blind(self.table.span()));
            }
            let track = self.place().track(self.reading)?;
            return Ok(Mount::Keys(Keys { start: 0.0, track, ease: Ease::None }));
        }
        Ok(Mount::Aboard)
    }

    /// Reads poses over time as one track.
    fn keys(&self, keys: &Spanned<Vec<Spanned<KeyTable>>>, look: Option<&Look>) -> Result<Keys> {
        let mut start = 0.0;
        let mut whole: Option<Track> = None;
        for key in keys.get_ref() {
            let (span, key) = (key.span(), key.get_ref());
            self.refuse_idle_key(key, look)?;
            let time = self.time("t_s", &key.t_s)?;
            if needs_angles(look) && key.yaw_deg.is_none() {
                return Err(self.blind(span));
            }
            let place = Place {
                whose: &self.whose,
                keys: ["at", "at_lonlat"],
                at: key.at.as_ref(),
                at_lonlat: key.at_lonlat.as_ref(),
                altitude: key.altitude.as_ref().map(|above| *above.get_ref()),
                yaw: key.yaw_deg.as_ref(),
                pitch: key.pitch_deg.as_ref(),
                roll: key.roll_deg.as_ref(),
                span: span.clone(),
            };

            let track = place.track(self.reading)?;
            let hfov = key.hfov_deg.as_ref().map(|hfov| self.field_of_view(hfov)).transpose()?;
            let Some(whole) = &mut whole else {
                start = time;
                let fixes = track.fixes.iter().map(|fix| Fix { hfov, ..*fix }).collect();
                whole = Some(Track { fixes, ..track });
                continue;
            };

            let time = time - start;
            if whole.fixes.last().is_some_and(|before| time - before.time < 1.0e-3) {
                return Err(self.reading.wrong(
                    key.t_s.span(),
                    "keys are in the order of their times, at least a millisecond apart",
                ));
            }
            if discriminant(&whole.fixes[0].horizontal) != discriminant(&track.fixes[0].horizontal) {
                return Err(self.reading.wrong(span, "keys of one camera have at, or all of them at_lonlat"));
            }
            whole.fixes.extend(track.fixes.iter().map(|fix| Fix { time, hfov, ..*fix }));
        }

        let ease = self.ease();
        let track = whole.ok_or_else(|| self.reading.wrong(keys.span(), "key must hold one pose or more"))?;
        Ok(Keys { start, track, ease })
    }

    fn look(&self, objects: &BTreeSet<String>) -> Result<Option<Look>> {
        let table = self.table.get_ref();
        let places = [&table.look_at, &table.look_at_lonlat].into_iter().flatten().map(Spanned::span);
        let others = [
            table.look.as_ref().map(Spanned::span),
            table.look_ahead_s.as_ref().map(Spanned::span),
            table.look_at_object.as_ref().map(Spanned::span),
        ];
        let said: Vec<_> = places.chain(others.into_iter().flatten()).collect();
        if let [_, second, ..] = said.as_slice() {
            let what = format!(
                "{} looks one way: give one of look, look_ahead_s, look_at, look_at_lonlat and look_at_object",
                self.whose
            );
            return Err(self.reading.wrong(second.clone(), what));
        }

        if let Some(look) = &table.look {
            return Ok(Some(match look.get_ref() {
                LookName::Ahead => Look::Nose,
                LookName::Down => Look::Down,
            }));
        }
        if let Some(lead) = &table.look_ahead_s {
            let lead = self.reading.number(
                "look_ahead_s",
                lead,
                |lead| (0.0..=3600.0).contains(&lead),
                "must lie between 0 and 3600 seconds",
            )?;
            return Ok(Some(Look::Ahead(lead)));
        }
        if let Some(name) = &table.look_at_object {
            if objects.contains(name.get_ref()) {
                return Ok(Some(Look::Object(name.get_ref().clone())));
            }
            let what = format!("the scene has no object `{}` for {} to look at", name.get_ref(), self.whose);
            return Err(self.reading.wrong(name.span(), what));
        }
        if table.look_at.is_none() && table.look_at_lonlat.is_none() {
            return Ok(None);
        }

        let place = Place {
            whose: &self.whose,
            keys: ["look_at", "look_at_lonlat"],
            at: table.look_at.as_ref(),
            at_lonlat: table.look_at_lonlat.as_ref(),
            altitude: table.look_at_altitude.as_ref().map(|above| *above.get_ref()),
            yaw: None,
            pitch: None,
            roll: None,
            span: self.table.span(),
        };
        place.track(self.reading).map(|track| Some(Look::Place(track)))
    }

    /// Refuses keys that say nothing of such a camera.
    fn refuse_idle(&self, mount: &Mount, look: Option<&Look>) -> Result<()> {
        let table = self.table.get_ref();
        let is_place = table.at.is_some() || table.at_lonlat.is_some();
        let is_zoomed = matches!(table.hfov_deg.as_ref().map(Spanned::get_ref), Some(FieldOfView::Zoomed(_)));
        let is_looking = table.look_at.is_some() || table.look_at_lonlat.is_some();
        let idle = [
            ("turn_s", table.turn_s.as_ref().map(Spanned::span), matches!(mount, Mount::Orbit(_))),
            ("altitude", table.altitude.as_ref().map(Spanned::span), is_place),
            ("yaw_deg", table.yaw_deg.as_ref().map(Spanned::span), is_place && !is_at_something(look)),
            ("roll_deg", table.roll_deg.as_ref().map(Spanned::span), is_place && !is_at_something(look)),
            (
                "pitch_deg",
                table.pitch_deg.as_ref().map(Spanned::span),
                table.key.is_none() && !(is_place && is_at_something(look)),
            ),
            ("look_at_altitude", table.look_at_altitude.as_ref().map(Spanned::span), is_looking),
            ("ease", table.ease.as_ref().map(Spanned::span), is_zoomed || table.key.is_some()),
        ];
        match idle.into_iter().find_map(|(key, span, is_used)| Some((key, span.filter(|_| !is_used)?))) {
            Some((key, span)) => {
                Err(self.reading.wrong(span, format!("{key} says nothing of {}; leave it out", self.whose)))
            }
            None => Ok(()),
        }
    }

    /// Refuses keys of a pose that say nothing, since the camera looks elsewhere or has a field of view.
    fn refuse_idle_key(&self, key: &KeyTable, look: Option<&Look>) -> Result<()> {
        let angles = [("yaw_deg", &key.yaw_deg), ("pitch_deg", &key.pitch_deg), ("roll_deg", &key.roll_deg)];
        let angles = angles.into_iter().filter(|_| is_at_something(look));
        let field = [("hfov_deg", &key.hfov_deg)];
        let field = field.into_iter().filter(|_| self.table.get_ref().hfov_deg.is_some());
        match angles.chain(field).find_map(|(name, value)| Some((name, value.as_ref()?.span()))) {
            Some((name, span)) => {
                let what = format!(
                    "{name} says nothing here, since {} has one or looks at something; leave it out",
                    self.whose
                );
                Err(self.reading.wrong(span, what))
            }
            None => Ok(()),
        }
    }

    fn zoom(&self) -> Result<Option<Zoom>> {
        let Some(hfov) = &self.table.get_ref().hfov_deg else { return Ok(None) };
        let (from, to) = match *hfov.get_ref() {
            FieldOfView::Fixed(hfov) => (hfov, hfov),
            FieldOfView::Zoomed([from, to]) => (from, to),
        };
        if [from, to].iter().all(|hfov| FIELDS.contains(hfov)) {
            return Ok(Some(Zoom { from, to, ease: self.ease() }));
        }
        Err(self.reading.wrong(hfov.span(), "hfov_deg must lie between 0.01 and 175 degrees"))
    }

    fn ease(&self) -> Ease {
        match self.table.get_ref().ease.as_ref().map(Spanned::get_ref) {
            Some(EaseName::InOut) => Ease::InOut,
            Some(EaseName::Linear) | None => Ease::None,
        }
    }

    /// Place of a camera that stands.
    fn place(&self) -> Place<'_> {
        let table = self.table.get_ref();
        Place {
            whose: &self.whose,
            keys: ["at", "at_lonlat"],
            at: table.at.as_ref(),
            at_lonlat: table.at_lonlat.as_ref(),
            altitude: table.altitude.as_ref().map(|above| *above.get_ref()),
            yaw: table.yaw_deg.as_ref(),
            pitch: table.pitch_deg.as_ref(),
            roll: table.roll_deg.as_ref(),
            span: self.table.span(),
        }
    }

    fn time(&self, key: &str, time: &Spanned<f64>) -> Result<f64> {
        let want = "must be seconds after the flight's first fix, 0 or more";
        self.reading.number(key, time, |time| (0.0..=LONGEST).contains(&time), want)
    }

    fn degrees(&self, key: &str, angle: &Spanned<f64>, most: f64) -> Result<f64> {
        let want = format!("must lie between -{most} and {most} degrees");
        self.reading.number(key, angle, |degrees| degrees.abs() <= most, &want)
    }

    fn field_of_view(&self, hfov: &Spanned<f64>) -> Result<f64> {
        let want = "must lie between 0.01 and 175 degrees";
        self.reading.number("hfov_deg", hfov, |hfov| FIELDS.contains(&hfov), want)
    }

    fn blind(&self, span: Range<usize>) -> Error {
        let what =
            format!("{} looks nowhere; give yaw_deg, look_at, look_at_lonlat or look_at_object", self.whose);
        self.reading.wrong(span, what)
    }
}
