//! Lights of a scene file: single lamps, and what airfields and towns have many of.

mod cast;
mod kinds;
mod lamp;
mod table;

use std::sync::Arc;

use glam::DVec3;

use crate::scene::Anchor;

pub(super) use cast::LampCast;
pub(super) use table::{LightTable, light};

use crate::flight::Track;
use crate::objects::Fixture;

/// Lamps of all lights of a scene.
pub const MOST_LAMPS: usize = 1_000_000;

/// One `[[light]]`: a lamp, or many that belong together.
#[derive(Debug, Clone)]
pub struct Light {
    /// Name in messages.
    pub name: String,
    /// Line of the scene file, from 1 on.
    pub line: usize,
    /// Anchor of its lamps.
    pub anchor: Anchor,
    /// Arrangement of its lamps about that.
    pub layout: LampLayout,
}

impl Light {
    /// Returns the number of its lamps, as far as they are known before it has a place: those of a string depend on how long it is.
    pub(in crate::scene) fn lamp_count(&self) -> usize {
        match &self.layout {
            LampLayout::Lamps(lamps) => lamps.len(),
            LampLayout::String(..) => 1,
        }
    }
}

/// Arrangement of lamps about their anchor.
#[derive(Debug, Clone)]
pub enum LampLayout {
    /// One by one.
    Lamps(Vec<Lamp>),
    /// The same one again and again, from the anchor to another place, so many metres apart; a flash, if it has one, runs along in so many seconds.
    String(Lamp, Box<Track>, f64, Option<f64>),
}

/// A lamp of a light.
#[derive(Debug, Clone, PartialEq)]
pub struct Lamp {
    /// Offset from the anchor: right, forward and up, metres.
    pub offset: DVec3,
    /// Direction of its front against the anchor's, degrees clockwise; of a lamp that turns, at the flight's first fix.
    pub yaw: f64,
    /// Kind of lamp.
    pub fixture: Arc<Fixture>,
    /// Behaviour in time.
    pub rhythm: Rhythm,
}

/// Behaviour of a lamp in time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rhythm {
    /// Part of each period in which it shines; `None`: it shines always.
    pub flash: Option<Flash>,
    /// Turns clockwise, per second.
    pub turns: f64,
}

/// A lamp that flashes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flash {
    /// Time from flash to flash, seconds, > 0.
    pub period: f64,
    /// Duration of each flash, seconds, > 0.
    pub on: f64,
    /// Seconds after the flight's first fix at which one begins.
    pub phase: f64,
}

impl Rhythm {
    /// Share of its intensity that the lamp has, so many seconds after the flight's first fix.
    fn level(&self, seconds: f64) -> f32 {
        let is_on = |flash: Flash| (seconds - flash.phase).rem_euclid(flash.period) < flash.on;
        if self.flash.is_none_or(is_on) { 1.0 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flashes_begin_at_their_phase_and_last_their_time() {
        let flash = |phase| Rhythm { flash: Some(Flash { period: 2.0, on: 0.5, phase }), turns: 0.0 };
        let at = |phase, seconds| flash(phase).level(seconds) > 0.0;
        assert!(at(0.0, 0.0) && at(0.0, 0.49) && !at(0.0, 0.51) && !at(0.0, 1.99) && at(0.0, 2.0));
        assert!(!at(0.25, 0.0) && at(0.25, 0.3) && at(-1.0, 1.2) && !at(0.25, -0.1));
        assert!(Rhythm::default().level(77.0) > 0.0);
    }
}
