//! Lamps over a database: where each is, and what it does, at any time.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::{Flash, Lamp, LampLayout, Light, MOST_LAMPS};
use crate::flight::{AltitudeMode, BindOptions, Track, Trajectory};
use crate::objects::PointLight;
use crate::scene::Anchor;
use crate::space::{Attitude, Pose};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Lamps of a scene over a database.
#[derive(Debug, Clone, Default)]
pub(in crate::scene) struct LampCast(Vec<PlacedLight>);

#[derive(Debug, Clone)]
struct PlacedLight {
    lamp: Lamp,
    /// Number of the actor that it goes with; its position is in that one's axes then.
    actor: Option<usize>,
    position: DVec3,
    attitude: Attitude,
}

/// Ground that places are bound to.
struct Land<'g> {
    scene: &'g Path,
    crs: &'g Crs,
    ground: &'g dyn Fn(DVec2) -> Option<f64>,
}

impl LampCast {
    /// The lamps of `lights`; `actor` tells the number of an object by its name.
    pub fn bind(
        scene: &Path,
        lights: &[Light],
        crs: &Crs,
        ground: &dyn Fn(DVec2) -> Option<f64>,
        actor: impl Fn(&str) -> Option<usize>,
    ) -> Result<Self> {
        let land = Land { scene, crs, ground };
        let mut placed = Vec::new();
        for light in lights {
            match &light.anchor {
                Anchor::On(object) => {
                    let missing = || land.wrong(light, &format!("there is no object `{object}`"));
                    let actor = Some(actor(object).ok_or_else(missing)?);
                    let LampLayout::Lamps(lamps) = &light.layout else { continue };
                    placed.extend(lamps.iter().map(|lamp| PlacedLight {
                        lamp: lamp.clone(),
                        actor,
                        position: lamp.offset,
                        attitude: Attitude::default(),
                    }));
                }
                Anchor::At(track) => land.stand(light, track, &mut placed)?,
            }

            if placed.len() > MOST_LAMPS {
                return Err(land.wrong(light, &format!("a scene has at most {MOST_LAMPS} lamps")));
            }
        }

        Ok(Self(placed))
    }

    /// All that shine so many seconds after the flight's first fix; `pose` tells where an actor is then; on one that is not there, none shine.
    pub fn at(&self, seconds: f64, pose: impl Fn(usize) -> Option<Pose>) -> Vec<PointLight> {
        let shines = |placed: &PlacedLight| {
            let level = placed.lamp.rhythm.level(seconds);
            if level == 0.0 {
                return None;
            }

            let turn = placed.lamp.yaw + 360.0 * (placed.lamp.rhythm.turns * seconds).rem_euclid(1.0);
            let turned = Attitude { yaw: turn, ..Attitude::default() };
            let (position, attitude) = match placed.actor {
                None => (placed.position, Attitude { yaw: placed.attitude.yaw + turn, ..placed.attitude }),
                Some(actor) => {
                    let Pose { eye, attitude, .. } = pose(actor)?;
                    let view = attitude.world_from_view();
                    let DVec3 { x: right, y: forward, z: up } = placed.position;
                    (eye + view * DVec3::new(right, up, forward), attitude.turned(turned))
                }
            };

            Some(PointLight { position, attitude, fixture: placed.lamp.fixture.clone(), level })
        };

        self.0.iter().filter_map(shines).collect()
    }
}

impl Land<'_> {
    fn wrong(&self, light: &Light, what: &str) -> Error {
        Error::invalid(self.scene, format!("line {}: light `{}`: {what}", light.line, light.name))
    }

    fn pose(&self, light: &Light, track: &Track) -> Result<Pose> {
        let options = BindOptions::default();
        let bound = Trajectory::bind(track, self.crs, self.ground, &options);
        bound.map(|trajectory| trajectory.pose_at(0.0)).map_err(|error| match error {
            Error::Invalid { what, .. } => {
                self.wrong(light, &format!("{what}; of a light, altitude = \"msl\" in the scene"))
            }
            other => self.wrong(light, &other.to_string()),
        })
    }

    /// Places the lamps of a light that stands.
    fn stand(&self, light: &Light, track: &Track, placed: &mut Vec<PlacedLight>) -> Result<()> {
        let anchor = self.pose(light, track)?;
        let altitude = track.fixes[0].altitude;
        let place = |at: DVec3, above: f64, lamp: &Lamp| -> Result<PlacedLight> {
            // Above ground, each stands on its own.
            let height = match altitude.mode {
                AltitudeMode::Agl => {
                    let ground = (self.ground)(at.truncate()).ok_or_else(|| {
                        let what = format!(
                            "one of its lamps, at x {:.1}, y {:.1}, has no ground below; move it, or give altitude = \"msl\"",
                            at.x, at.y
                        );
                        self.wrong(light, &what)
                    })?;
                    ground + above
                }
                _ => at.z,
            };

            let position = at.with_z(height + lamp.offset.z);
            Ok(PlacedLight { lamp: lamp.clone(), actor: None, position, attitude: anchor.attitude })
        };

        match &light.layout {
            LampLayout::Lamps(lamps) => {
                let (sin, cos) = anchor.attitude.yaw.to_radians().sin_cos();
                for lamp in lamps {
                    let DVec3 { x: right, y: forward, .. } = lamp.offset;
                    let offset = DVec3::new(right * cos + forward * sin, forward * cos - right * sin, 0.0);
                    placed.push(place(anchor.eye + offset, altitude.metres, lamp)?);
                }
            }
            LampLayout::String(lamp, to, spacing, running) => {
                let end = self.pose(light, to)?;
                let length = (end.eye - anchor.eye).truncate().length();
                let count = (length / spacing).round().max(1.0);
                if count >= MOST_LAMPS as f64 {
                    return Err(self.wrong(light, &format!("a scene has at most {MOST_LAMPS} lamps")));
                }

                for index in 0..=count as usize {
                    let part = index as f64 / count;
                    let mut lamp = lamp.clone();
                    if let (Some(flash), Some(running)) = (&mut lamp.rhythm.flash, running) {
                        *flash = Flash { phase: flash.phase + part * running, ..*flash };
                    }
                    let above = altitude.metres + part * (to.fixes[0].altitude.metres - altitude.metres);
                    placed.push(place(anchor.eye.lerp(end.eye, part), above, &lamp)?);
                }
            }
        }

        Ok(())
    }
}
