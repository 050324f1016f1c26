//! Fewer shades about a centre: attenuation of a code's contrast.
//!
//! ```text
//! shade = centre − ½·count + (tone >> shift)          count = 256 >> shift
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), Table 2: centre 101, 32 shades: 85 +
//! (tone >> 3).

use hedgehop_base::error::{Error, Result};

/// Number of shades that tones of 0 to 255 become, about a centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shades {
    shift: u32,
    lowest: u8,
}

impl Shades {
    /// Takes 2, 4, 8, 16, 32, 64, 128 or 256 shades about a centre.
    ///
    /// # Errors
    ///
    /// The number is another, or shades about the centre leave 0 to 255.
    pub fn new(count: u32, centre: u8) -> Result<Self> {
        if !count.is_power_of_two() || !(2..=256).contains(&count) {
            return Err(Error::Configuration(format!(
                "{count} shades of a texture are no power of two from 2 to 256; want 32, say"
            )));
        }
        let half = (count / 2) as i64;
        let lowest = i64::from(centre) - half;
        match u8::try_from(lowest).ok().filter(|&lowest| u32::from(lowest) + count <= 256) {
            Some(lowest) => Ok(Self { shift: 8 - count.ilog2(), lowest }),
            None => Err(Error::Configuration(format!(
                "{count} shades about {centre} leave 0 to 255; want a centre of {half} to {}",
                256 - half
            ))),
        }
    }

    /// Shade of a tone.
    pub fn shade(self, tone: u8) -> u8 {
        self.lowest + (u32::from(tone) >> self.shift) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_are_those_of_table_2() {
        let shades = Shades::new(32, 101).unwrap();
        for (tone, shade) in [(152, 104), (144, 103), (143, 102), (136, 102), (135, 101), (129, 101)] {
            assert_eq!(shades.shade(tone), shade);
        }
    }

    #[test]
    fn shades_are_as_many_as_asked_for() {
        for count in [2, 4, 8, 16, 32, 64, 128, 256] {
            let shades = Shades::new(count, 128).unwrap();
            let mut seen: Vec<u8> = (0..=255).map(|tone| shades.shade(tone)).collect();
            assert!(seen.is_sorted());
            seen.dedup();
            assert_eq!(seen.len(), count as usize);
            assert_eq!(u32::from(shades.shade(128)), 128);
        }
    }

    #[test]
    fn shades_that_do_not_fit_are_refused() {
        assert!(Shades::new(33, 101).unwrap_err().to_string().contains("power of two"));
        assert!(Shades::new(1, 101).is_err() && Shades::new(512, 101).is_err());
        assert!(Shades::new(64, 20).unwrap_err().to_string().contains("32 to 224"));
        assert!(Shades::new(64, 224).is_ok() && Shades::new(64, 225).is_err());
    }
}
