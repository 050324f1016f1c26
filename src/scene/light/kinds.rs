//! Lights of airfields and towns, lamp by lamp.
//!
//! Offsets are to the right and forward of somebody who lands; intensities are those of a night with good visibility, when airfields dim their lights. Patterns after
//! ICAO Annex 14, § 5.3 (approach lighting, PAPI, runway edge, threshold, end and centre line).

use std::sync::Arc;

use glam::DVec3;

use super::lamp::{Colour, around, beam, fixture, papi_beam, slope_beam};
use super::{Flash, Lamp, Rhythm};
use crate::objects::Fixture;
use hedgehop_base::chance::Random;

/// Azimuths against which, and in which, somebody lands.
const TOWARDS: f64 = 180.0;
const ALONG: f64 = 0.0;

/// Metres between edge lights, threshold lights, lights of the centre line and barrettes of the approach.
const EDGE_SPACING: f64 = 60.0;
const THRESHOLD_SPACING: f64 = 3.0;
const CENTRE_SPACING: f64 = 15.0;
const APPROACH_SPACING: f64 = 30.0;

/// Metres before its end from which on a runway's edge is yellow, its centre line red and white, and red.
const YELLOW: f64 = 600.0;
const MIXED: f64 = 900.0;
const RED: f64 = 300.0;

/// Distance of the crossbar before the threshold, and half its width, metres.
const CROSSBAR: f64 = 300.0;
const CROSSBAR_HALF: f64 = 15.0;

/// Seconds from flash to flash of an approach's flashers, how long each lasts, and how much brighter than other lamps they are.
const FLASH: f64 = 0.5;
const FLASH_ON: f64 = 0.045;
const FLASH_GAIN: f64 = 8.0;

/// Metres between units of a PAPI and of a VASI, and between the two bars of that.
const PAPI_SPACING: f64 = 9.0;
const VASI_SPACING: f64 = 4.9;
const VASI_BARS: f64 = 210.0;

/// Share of a beam that edge lights send all around.
const AROUND: f64 = 0.05;

fn lamp(right: f64, forward: f64, fixture: &Arc<Fixture>) -> Lamp {
    Lamp {
        offset: DVec3::new(right, forward, 0.0),
        yaw: 0.0,
        fixture: fixture.clone(),
        rhythm: Rhythm::default(),
    }
}

/// Places from one to another, both included, about so far apart.
fn places(from: f64, to: f64, spacing: f64) -> impl Iterator<Item = f64> {
    let steps = ((to - from) / spacing).round().max(1.0);
    (0..=steps as usize).map(move |step| from + (to - from) * step as f64 / steps)
}

/// A beam each way.
fn two_ways(towards: Colour, along: Colour, candela: f64) -> Arc<Fixture> {
    let half = [7.0, 4.5];
    fixture([
        beam(towards, candela, [TOWARDS, 3.5], half),
        beam(along, candela, [ALONG, 3.5], half),
        around(Colour::WHITE, AROUND * candela),
    ])
}

/// A runway of a length and a width, metres, of which the threshold is the anchor: edges, thresholds and ends for both directions, and the centre line.
pub fn runway(length: f64, width: f64, candela: f64, has_centre_line: bool) -> Vec<Lamp> {
    let half = 0.5 * width;
    let mut lamps = Vec::new();
    let yellow = YELLOW.min(0.5 * length);
    let edge = |left: f64| if left < yellow { Colour::YELLOW } else { Colour::WHITE };
    let kinds = [Colour::YELLOW, Colour::WHITE]
        .map(|towards| [Colour::YELLOW, Colour::WHITE].map(|along| two_ways(towards, along, candela)));
    let kind = |colour: Colour| usize::from(colour == Colour::WHITE);
    for at in places(0.0, length, EDGE_SPACING) {
        let fixture = &kinds[kind(edge(length - at))][kind(edge(at))];
        lamps.extend([-half - 2.0, half + 2.0].map(|right| lamp(right, at, fixture)));
    }

    let bar = |colours: [Colour; 2], at: f64| {
        let wing = [8.0, 5.0];
        let fixture = fixture([
            beam(colours[0], candela, [TOWARDS, 4.0], wing),
            beam(colours[1], candela, [ALONG, 4.0], wing),
        ]);
        places(-half, half, THRESHOLD_SPACING).map(|right| lamp(right, at, &fixture)).collect::<Vec<_>>()
    };

    lamps.extend(bar([Colour::GREEN, Colour::RED], -1.0));
    lamps.extend(bar([Colour::RED, Colour::GREEN], length + 1.0));
    if has_centre_line {
        let colour = |left: f64, is_even: bool| {
            if left < RED || (left < MIXED && is_even) { Colour::RED } else { Colour::WHITE }
        };

        let kinds = [Colour::RED, Colour::WHITE].map(|towards| {
            [Colour::RED, Colour::WHITE].map(|along| {
                let half = [5.0, 3.5];
                fixture([
                    beam(towards, candela, [TOWARDS, 3.5], half),
                    beam(along, candela, [ALONG, 3.5], half),
                ])
            })
        });

        for (index, at) in places(CENTRE_SPACING, length - CENTRE_SPACING, CENTRE_SPACING).enumerate() {
            let is_even = index % 2 == 0;
            let fixture = &kinds[kind(colour(length - at, is_even))][kind(colour(at, is_even))];
            lamps.push(lamp(0.0, at, fixture));
        }
    }

    lamps
}

/// Approach lights over a length before the threshold, metres: barrettes of the centre line, a crossbar, and flashers that run towards it.
pub fn approach(length: f64, candela: f64, has_flashers: bool) -> Vec<Lamp> {
    let wide = [10.0, 6.0];
    let steady = fixture([beam(Colour::WHITE, candela, [TOWARDS, 5.5], wide)]);
    let count = (length / APPROACH_SPACING).floor() as usize;
    let mut lamps = Vec::new();

    for bar in 1..=count {
        let before = bar as f64 * APPROACH_SPACING;
        lamps.extend((-2..=2).map(|right| lamp(f64::from(right), -before, &steady)));
        if before == CROSSBAR {
            let rest =
                places(-CROSSBAR_HALF, CROSSBAR_HALF, THRESHOLD_SPACING).filter(|right| right.abs() > 2.5);
            lamps.extend(rest.map(|right| lamp(right, -before, &steady)));
        }
    }

    if has_flashers {
        let flasher = fixture([beam(Colour::WHITE, FLASH_GAIN * candela, [TOWARDS, 5.5], wide)]);
        let first = (CROSSBAR / APPROACH_SPACING) as usize;
        for bar in first..=count {
            // The farthest one flashes first.
            let phase = FLASH * (count - bar) as f64 / (count + 1 - first) as f64;
            let flash = Some(Flash { period: FLASH, on: FLASH_ON, phase });
            let lamp = lamp(0.0, -(bar as f64) * APPROACH_SPACING, &flasher);
            lamps.push(Lamp { rhythm: Rhythm { flash, turns: 0.0 }, ..lamp });
        }
    }

    lamps
}

/// A precision approach path indicator for a slope, degrees, whose bar's middle is the anchor: four units, of which that next to the runway is the last to turn white. `side` is
/// 1 if it stands on the left of the runway, -1 on the right.
pub fn papi(slope: f64, candela: f64, side: f64) -> Vec<Lamp> {
    let settings = [(-1.5, -0.5), (-0.5, -1.0 / 6.0), (0.5, 1.0 / 6.0), (1.5, 0.5)];
    let unit = |(place, above): (f64, f64)| {
        lamp(side * place * PAPI_SPACING, 0.0, &fixture([papi_beam(candela, slope + above)]))
    };
    settings.map(unit).to_vec()
}

/// A visual approach slope indicator of two bars for a slope, degrees: the near one is the anchor. Red over white is right.
pub fn vasi(slope: f64, candela: f64) -> Vec<Lamp> {
    let bar = |forward: f64, elevation: f64| {
        let fixture = fixture([slope_beam(candela, [TOWARDS, slope], [10.0, 6.0], elevation, 0.25)]);
        [-1.0, 0.0, 1.0].map(|place| lamp(place * VASI_SPACING, forward, &fixture))
    };
    [bar(0.0, slope - 0.25), bar(VASI_BARS, slope + 0.25)].concat()
}

/// The beacon of an airfield, which shows white and green in turn.
pub fn beacon(candela: f64, turns: f64) -> Vec<Lamp> {
    let half = [4.0, 5.0];
    let beams = [
        beam(Colour::WHITE, candela, [ALONG, 4.0], half),
        beam(Colour::GREEN, 0.4 * candela, [TOWARDS, 4.0], half),
        around(Colour::WHITE, 2.0e-4 * candela),
    ];
    vec![Lamp { rhythm: Rhythm { flash: None, turns }, ..lamp(0.0, 0.0, &fixture(beams)) }]
}

/// Strews so many street lamps over an area about the anchor, metres to the right and forward.
pub fn town(extent: [f64; 2], count: usize, candela: f64, colour: Colour, seed: u64) -> Vec<Lamp> {
    let kinds = [0.4, 0.6, 0.8, 1.0].map(|share| fixture([around(colour, share * candela)]));
    let mut random = Random(seed);
    let strewn = |random: &mut Random, extent: f64| (random.unit() - 0.5) * extent;
    (0..count)
        .map(|_| {
            let kind = (random.unit() * kinds.len() as f64) as usize;
            lamp(strewn(&mut random, extent[0]), strewn(&mut random, extent[1]), &kinds[kind])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::objects::PointLight;
    use crate::space::Attitude;

    /// What somebody sees of a lamp from behind the threshold, at an elevation above it, degrees.
    fn seen(lamp: &Lamp, elevation: f64, side: f64) -> Vec3 {
        let (fixture, position) = (lamp.fixture.clone(), DVec3::ZERO);
        let light = PointLight { position, attitude: Attitude::default(), fixture, level: 1.0 };
        light.towards(5000.0 * DVec3::new(0.0, side, elevation.to_radians().tan()))
    }

    fn is_red(light: Vec3) -> bool {
        light.x > 5.0 * light.y
    }

    #[test]
    fn a_papi_tells_the_slope() {
        let units = papi(3.0, 2000.0, 1.0);
        for (elevation, reds) in [(2.3, 4), (2.7, 3), (3.0, 2), (3.3, 1), (3.8, 0)] {
            let red: Vec<_> = units.iter().map(|unit| is_red(seen(unit, elevation, -1.0))).collect();
            assert_eq!(red.iter().filter(|red| **red).count(), reds, "{elevation}");
            // Red ones are next to the runway, which lies to the right.
            assert!(red.is_sorted(), "{elevation}: {red:?}");
        }
        assert!(units.is_sorted_by(|a, b| a.offset.x < b.offset.x));
        assert!(papi(3.0, 2000.0, -1.0).is_sorted_by(|a, b| a.offset.x > b.offset.x));
    }

    #[test]
    fn a_vasi_is_red_over_white_on_the_slope() {
        let lamps = vasi(3.0, 2000.0);
        let red = |elevation| [0, 3].map(|lamp| is_red(seen(&lamps[lamp], elevation, -1.0)));
        assert_eq!([red(2.4), red(3.0), red(3.6)], [[true, true], [false, true], [false, false]]);
    }

    #[test]
    fn a_runway_shows_each_pilot_its_own_colours() {
        let lamps = runway(1800.0, 45.0, 150.0, true);
        let at = |right: f64, forward: f64| {
            let near = |lamp: &&Lamp| (lamp.offset - DVec3::new(right, forward, 0.0)).length() < 1e-6;
            lamps.iter().find(near).unwrap_or_else(|| panic!("a lamp at {right} {forward}"))
        };
        // Who lands sees green, then white, then yellow, then red.
        let threshold = seen(at(-22.5, -1.0), 3.0, -1.0);
        assert!(threshold.y > 5.0 * threshold.x);
        assert!(is_red(seen(at(-22.5, 1801.0), 3.0, -1.0)) && is_red(seen(at(-22.5, -1.0), 3.0, 1.0)));
        let is_yellow = |light: Vec3| light.x > 1.5 * light.y && light.y > 4.0 * light.z;
        assert!(!is_yellow(seen(at(24.5, 600.0), 3.0, -1.0)) && is_yellow(seen(at(24.5, 1260.0), 3.0, -1.0)));
        assert!(is_yellow(seen(at(24.5, 540.0), 3.0, 1.0)));
        assert!(is_red(seen(at(0.0, 1785.0), 3.0, -1.0)) && !is_red(seen(at(0.0, 15.0), 3.0, -1.0)));
        // Both edges, both bars of 16, the centre line.
        assert_eq!(lamps.len(), 2 * 31 + 2 * 16 + 119);
    }

    #[test]
    fn flashers_run_towards_the_threshold() {
        let lamps = approach(900.0, 300.0, true);
        let flashers: Vec<_> =
            lamps.iter().filter_map(|lamp| lamp.rhythm.flash.zip(Some(lamp.offset.y))).collect();
        assert_eq!(flashers.len(), 21);
        assert!(flashers.is_sorted_by(|a, b| a.1 > b.1 && a.0.phase > b.0.phase));
        assert_eq!(lamps.len(), 30 * 5 + 10 + 21);
    }

    #[test]
    fn towns_are_strewn_over_all_of_their_area() {
        let lamps = town([1000.0, 400.0], 4000, 100.0, Colour::WARM, 7);
        let quarter = lamps.iter().filter(|lamp| lamp.offset.x > 0.0 && lamp.offset.y > 0.0).count();
        assert!((900..1100).contains(&quarter), "{quarter}");
        assert!(lamps.iter().all(|lamp| lamp.offset.x.abs() <= 500.0 && lamp.offset.y.abs() <= 200.0));
        assert_ne!(lamps[0].offset, town([1000.0, 400.0], 1, 100.0, Colour::WARM, 8)[0].offset);
    }
}
