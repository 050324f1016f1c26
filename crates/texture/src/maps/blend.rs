//! Levels of six maps that blend into each other, so that no line shows where one ends.
//!
//! ```text
//! ℓ = 1 + log₂(8 / (width·pixels per unit))              where zones of level ℓ cover eight pixels
//! tone = (1 − s)·tone(⌊ℓ⌋) + s·tone(⌊ℓ⌋ + 1)             s = ℓ − ⌊ℓ⌋; below 1, level 1
//! ```
//!
//! Bunker and Ferris 1977 (AFHRL-TR-77-66) change levels at once, and see no line in a still picture; blends
//! are ours.

use super::axis::MIN_ZONE_PIXELS;
use super::six::SixMaps;

impl SixMaps {
    /// Level with a fraction, from 1, for a view in which a unit of ground covers so many pixels.
    pub fn fractional_level(&self, pixels_per_unit: f64) -> f64 {
        let zones = self.zone_width(1) * pixels_per_unit;
        (1.0 + (MIN_ZONE_PIXELS / zones).log2()).clamp(1.0, f64::from(self.levels()))
    }

    /// Tone at a place, between two levels.
    pub fn blended(&self, x: f64, y: f64, level: f64) -> f64 {
        let level = level.clamp(1.0, f64::from(self.levels()));
        let (below, share) = (level.floor() as u32, level.fract());
        let fine = self.tone(x, y, below);
        if share > 0.0 { fine + share * (self.tone(x, y, below + 1) - fine) } else { fine }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance of a screen of 640 pixels over 40°, height of the eye in feet, and greys of one deviation.
    const DISTANCE: f64 = 879.2;
    const HEIGHT: f64 = 100.0;
    const CONTRAST: f64 = 10.0;

    fn maps() -> SixMaps {
        SixMaps::new(8.0, 10, 23)
    }

    /// Ground ahead that lines below the horizon show, and pixels that a foot covers there, foreshortened.
    fn ahead(line: f64) -> [f64; 2] {
        let away = HEIGHT * DISTANCE / line;
        [away, line * line / (HEIGHT * DISTANCE)]
    }

    /// Greys of a line of the picture, so many lines below the horizon.
    fn greys(line: f64, tone: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let away = HEIGHT * DISTANCE / line;
        (-300..300).map(|column| CONTRAST * tone(away, f64::from(column) * away / DISTANCE)).collect()
    }

    fn rms(a: &[f64], b: &[f64]) -> f64 {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    }

    /// Line at which levels change at once, and the ground there.
    fn level_lines(maps: &SixMaps) -> Vec<f64> {
        let level = |line: f64| maps.level_for(ahead(line)[1]);
        (40..900).map(|line| f64::from(line) * 0.5).filter(|&line| level(line) != level(line + 0.5)).collect()
    }

    #[test]
    fn level_lines_show_where_levels_change_at_once_and_not_where_they_blend() {
        let maps = maps();
        let lines = level_lines(&maps);
        assert!(lines.len() >= 4, "{lines:?}");
        let at_once = |line: f64| {
            let level = maps.level_for(ahead(line)[1]);
            greys(line, |x, y| maps.tone(x, y, level))
        };
        let blended = |line: f64| {
            let level = maps.fractional_level(ahead(line)[1]);
            greys(line, |x, y| maps.blended(x, y, level))
        };

        // Both are two lines a little apart on the ground, so that only the level can make a step.
        let step = |of: &dyn Fn(f64) -> Vec<f64>, line: f64| rms(&of(line), &of(line + 1e-5));
        for &line in &lines {
            let line = bisected(&maps, line);
            // At once, a line changes by as much as it varies; what is left of that far off is little.
            let varies = rms(&at_once(line), &[0.0; 600]);
            let steps = [step(&at_once, line), step(&blended, line)];
            assert!(steps[0] > 0.5 * varies && steps[1] < 0.05 * varies, "{steps:?} of {varies}");
        }
    }

    /// Place at which the level changes, within a hundred-thousandth of a line.
    fn bisected(maps: &SixMaps, from: f64) -> f64 {
        let level = |line: f64| maps.level_for(ahead(line)[1]);
        let (mut low, mut high) = (from, from + 0.5);
        while high - low > 5e-6 {
            let middle = 0.5 * (low + high);
            if level(middle) == level(low) { low = middle } else { high = middle }
        }
        low
    }

    #[test]
    fn flight_changes_the_tone_of_a_place_by_less_than_two_greys_a_frame() {
        // 200 knots at 30 frames a second over a place that comes nearer.
        let (maps, step) = (maps(), 11.25);
        let mut worst: [f64; 2] = [0.0; 2];
        for place in 0..40 {
            let (x, y) = (20_000.0 + f64::from(place) * 131.7, f64::from(place) * 77.7);
            let tones = |flown: f64| {
                let away = x - flown;
                let pixels = ahead(HEIGHT * DISTANCE / away)[1];
                let level = maps.fractional_level(pixels);
                [maps.blended(x, y, level), maps.tone(x, y, maps.level_for(pixels))]
                    .map(|tone| CONTRAST * tone)
            };
            let mut before = tones(x - 6000.0);
            let mut flown = x - 6000.0;
            while x - flown > 400.0 {
                flown += step;
                let now = tones(flown);
                for (worst, (now, before)) in worst.iter_mut().zip(now.iter().zip(before)) {
                    *worst = worst.max((now - before).abs());
                }
                before = now;
            }
        }
        assert!(worst[0] < 2.0 && worst[1] > 10.0, "blended {} greys, at once {}", worst[0], worst[1]);
    }

    #[test]
    fn contrast_falls_steadily_with_the_level() {
        let maps = maps();
        let contrast = |level: f64| {
            let tones = (0..20_000).map(|number| {
                let (x, y) = (f64::from(number) * 37.1, f64::from(number * 13 % 9001) * 3.7);
                maps.blended(x, y, level).powi(2)
            });
            (tones.sum::<f64>() / 20_000.0).sqrt()
        };
        let measured: Vec<f64> = (2..=14).map(|half| contrast(0.5 * f64::from(half))).collect();
        assert!(measured.windows(2).all(|pair| pair[1] < pair[0]), "{measured:?}");
    }
}
