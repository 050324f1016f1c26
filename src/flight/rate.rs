//! Frames per second as an exact fraction: 24000/1001 is not 23.976.

use std::fmt;
use std::str::FromStr;

use hedgehop_base::error::{Error, Result};

/// Frames per second, a fraction in lowest terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRate {
    numerator: u32,
    denominator: u32,
}

impl FrameRate {
    /// `numerator / denominator` frames per second; both ≥ 1.
    pub fn new(numerator: u32, denominator: u32) -> Option<Self> {
        if numerator == 0 || denominator == 0 {
            return None;
        }
        let divisor = greatest_common_divisor(numerator, denominator);
        Some(Self { numerator: numerator / divisor, denominator: denominator / divisor })
    }

    /// Frames in [`Self::denominator`] seconds.
    pub fn numerator(self) -> u32 {
        self.numerator
    }

    /// Seconds in which [`Self::numerator`] frames pass.
    pub fn denominator(self) -> u32 {
        self.denominator
    }

    /// Frames per second, rounded to f64.
    pub fn per_second(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    /// Time of frame `number` (1 is the first, at 0), seconds.
    pub fn seconds_at(self, number: u64) -> f64 {
        number.saturating_sub(1) as f64 * f64::from(self.denominator) / f64::from(self.numerator)
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => write!(f, "{}", self.numerator),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

/// Reads `25`, `12.5` and `24000/1001`; the usual roundings 23.976, 29.97, 59.94 and 119.88 mean the
/// broadcast rates that they stand for.
impl FromStr for FrameRate {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        parse(text.trim()).ok_or_else(|| {
            Error::Configuration(format!(
                "--fps {text}: not a frame rate above 0; write for instance 25, 12.5 or 24000/1001"
            ))
        })
    }
}

fn parse(text: &str) -> Option<FrameRate> {
    if let Some((numerator, denominator)) = text.split_once('/') {
        return FrameRate::new(digits(numerator)?, digits(denominator)?);
    }
    match text {
        "23.976" | "23.98" => return FrameRate::new(24_000, 1001),
        "29.97" => return FrameRate::new(30_000, 1001),
        "59.94" => return FrameRate::new(60_000, 1001),
        "119.88" => return FrameRate::new(120_000, 1001),
        _ => {}
    }
    let Some((whole, decimals)) = text.split_once('.') else {
        return FrameRate::new(digits(text)?, 1);
    };
    let scale = 10_u32.checked_pow(u32::try_from(decimals.len()).ok()?)?;
    let numerator = digits(whole)?.checked_mul(scale)?.checked_add(digits(decimals)?)?;
    FrameRate::new(numerator, scale)
}

/// A number of decimal digits alone: no sign, no spaces.
fn digits(text: &str) -> Option<u32> {
    let plain = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    plain.then(|| text.parse().ok()).flatten()
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_exact_fractions() {
        for (text, numerator, denominator) in [
            ("25", 25, 1),
            ("12.5", 25, 2),
            ("24000/1001", 24_000, 1001),
            ("50/2", 25, 1),
            ("29.97", 30_000, 1001),
            ("23.976", 24_000, 1001),
            ("0.25", 1, 4),
        ] {
            let rate: FrameRate = text.parse().unwrap();
            assert_eq!((rate.numerator(), rate.denominator()), (numerator, denominator), "{text}");
        }
        assert_eq!("60000/1001".parse::<FrameRate>().unwrap().to_string(), "60000/1001");
    }

    #[test]
    fn nonsense_names_the_flag() {
        for text in
            ["", "0", "0/1", "25/0", "-3", "+3", "1e3", "NaN", ".5", "5.", "1/2/3", "99999999999", "0.0"]
        {
            let message = text.parse::<FrameRate>().unwrap_err().to_string();
            assert!(message.starts_with("--fps"), "{text}: {message}");
        }
    }

    #[test]
    fn the_first_frame_is_at_zero() {
        let rate = FrameRate::new(25, 1).unwrap();
        assert_eq!(rate.seconds_at(1), 0.0);
        assert_eq!(rate.seconds_at(26), 1.0);
    }
}
