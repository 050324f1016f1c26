//! A scan of a JPEG, block by block, without making samples of it (T.81, F.2.2 and G.1.2).
//!
//! ```text
//! for each interval between restarts, each unit, each component, each block:
//!     sequential  difference of the mean, then runs of zeros and sizes of coefficients
//!     mean        of a progressive frame: the difference, or its next bit
//!     others      runs and sizes, or the next bit of each coefficient that is not zero; ends of bands for many blocks at once
//! an interval must be used up when its last block is read
//! ```

use super::bits::{Bits, Codes, Stop};
use super::segments::{Coded, Tables};
use crate::picture::jpeg::layout::Frame;

/// Bits of the largest difference of means and of the largest coefficient, of samples of 8 bits (T.81, F.1.2).
const MOST_DIFFERENCE: u8 = 11;
const MOST_COEFFICIENT: u8 = 10;
/// Largest mean of a block that samples of 8 bits have, times eight, doubled: encoders may go a little beyond.
const MOST_MEAN: i64 = 2048;
/// Bytes of zeros behind coded data that are no damage.
const FILLING: usize = 8;

/// Scan as its header states it.
pub struct Scan {
    pub parts: Vec<Part>,
    /// First and last coefficient, in the order of T.81.
    pub from: u8,
    pub to: u8,
    /// The bit that came last, and the one that comes now; 0 and 0 if all come at once.
    pub high: u8,
    pub low: u8,
}

/// A component in a scan, and the tables of its codes.
pub struct Part {
    pub component: usize,
    pub dc: usize,
    pub ac: usize,
}

/// Place where coded data break.
pub struct Broken {
    stop: Stop,
    /// Units that are whole, and how many there are.
    pub done: usize,
    pub of: usize,
}

impl Broken {
    /// A clause.
    pub fn what(&self) -> &'static str {
        match self.stop {
            Stop::Ended => "they end too early",
            Stop::Wrong(what) => what,
        }
    }
}

/// State carried from block to block.
struct Walk<'w> {
    scan: &'w Scan,
    bits: Bits<'w>,
    has_eight_bits: bool,
    /// Means of the blocks before, by component of the scan.
    means: [i32; 4],
    /// Blocks that hold nothing further.
    ended: u32,
}

/// A component's tables.
struct Coding<'t> {
    dc: Option<&'t Codes>,
    ac: Option<&'t Codes>,
    step: i64,
}

/// Follows the scan's coded data, cut at its restarts.
pub fn walk(frame: &mut Frame, scan: &Scan, tables: &Tables, coded: &Coded<'_>) -> Result<(), Broken> {
    let is_interleaved = scan.parts.len() > 1;
    let first = &frame.components[scan.parts[0].component];
    let (across, down) = if is_interleaved { frame.units } else { first.blocks };
    let of = across * down;
    let interval = if tables.restart == 0 { of } else { tables.restart };
    let broken = |done: usize, stop: Stop| Broken { stop, done, of };

    let coding = |part: &Part| {
        let step = frame.components[part.component].steps;
        let table = |tables: &'_ [Option<Codes>; 4], number: usize| {
            tables.get(number).and_then(Option::as_ref).is_some()
        };
        let has_dc = scan.from > 0 || scan.high > 0 || table(&tables.dc, part.dc);
        let has_ac = scan.to == 0 || table(&tables.ac, part.ac);
        let step = tables.steps[step].filter(|_| has_dc && has_ac)?;
        let dc = tables.dc.get(part.dc).and_then(Option::as_ref);
        let ac = tables.ac.get(part.ac).and_then(Option::as_ref);
        Some(Coding { dc, ac, step: i64::from(step) })
    };

    let codings: Option<Vec<Coding<'_>>> = scan.parts.iter().map(coding).collect();
    let Some(codings) = codings else { return Err(broken(0, Stop::Wrong("a table of it is missing"))) };

    for (number, part) in coded.parts.iter().enumerate() {
        let from = number * interval;
        let mut walk =
            Walk { scan, bits: Bits::new(part), has_eight_bits: frame.bits == 8, means: [0; 4], ended: 0 };
        if from >= of {
            return Err(broken(of, Stop::Wrong("they go on behind its last block")));
        }

        for unit in from..of.min(from + interval) {
            let (column, row) = (unit % across, unit / across);
            walk.unit(frame, &codings, column, row).map_err(|stop| broken(unit, stop))?;
        }

        // Zeros at the end of a file are what was never written of it.
        let filling = if coded.goes_on { FILLING } else { 0 };
        if walk.ended > 0 || !walk.bits.is_used_up(filling) {
            return Err(broken(of.min(from + interval), Stop::Wrong("they go on behind its last block")));
        }
    }

    let done = coded.parts.len() * interval;
    if done < of { Err(broken(done, Stop::Ended)) } else { Ok(()) }
}

impl Walk<'_> {
    /// All blocks of a unit.
    fn unit(
        &mut self,
        frame: &mut Frame,
        codings: &[Coding<'_>],
        column: usize,
        row: usize,
    ) -> Result<(), Stop> {
        let is_interleaved = codings.len() > 1;
        for (index, (part, coding)) in self.scan.parts.iter().zip(codings).enumerate() {
            let component = &mut frame.components[part.component];
            let (across, down) = if is_interleaved { component.sampling } else { (1, 1) };
            for (right, below) in (0..down).flat_map(|below| (0..across).map(move |right| (right, below))) {
                let place = (row * down + below) * component.stride + column * across + right;
                if frame.is_progressive {
                    let nonzero = component.nonzero.get_mut(place).ok_or(Stop::Ended)?;
                    self.progressive(coding, index, nonzero)?;
                } else {
                    self.mean(coding, index)?;
                    self.sequential(coding.ac.ok_or(Stop::Ended)?)?;
                }
            }
        }
        Ok(())
    }

    fn progressive(&mut self, coding: &Coding<'_>, index: usize, nonzero: &mut u64) -> Result<(), Stop> {
        match (self.scan.from, self.scan.high) {
            (0, 0) => self.mean(coding, index),
            (0, _) => self.bits.take(1).map(|_| ()),
            (_, 0) => self.first(coding.ac.ok_or(Stop::Ended)?, nonzero),
            _ => self.refine(coding.ac.ok_or(Stop::Ended)?, nonzero),
        }
    }

    /// The difference to the mean of the block before.
    fn mean(&mut self, coding: &Coding<'_>, index: usize) -> Result<(), Stop> {
        let size = coding.dc.ok_or(Stop::Ended)?.next(&mut self.bits)?;
        if size > if self.has_eight_bits { MOST_DIFFERENCE } else { 15 } {
            return Err(Stop::Wrong("a difference is too large"));
        }
        let mean = self.means[index] + self.bits.number(u32::from(size))?;
        let brightness = (i64::from(mean) << self.scan.low) * coding.step;
        if self.has_eight_bits && brightness.abs() > MOST_MEAN + coding.step {
            return Err(Stop::Wrong("a block is brighter or darker than can be"));
        }
        self.means[index] = mean;
        Ok(())
    }

    /// All other coefficients of a block.
    fn sequential(&mut self, codes: &Codes) -> Result<(), Stop> {
        let mut at = 1;
        while at < 64 {
            let (zeros, size) = self.run(codes)?;
            match (zeros, size) {
                (0, 0) => break,
                (15, 0) => at += 16,
                (_, 0) => return Err(Stop::Wrong("a code that does not exist")),
                _ => {
                    at += u32::from(zeros);
                    self.bits.take(u32::from(size))?;
                    at += 1;
                }
            }

            // Behind sixteen zeros comes a coefficient.
            if at > if size == 0 { 63 } else { 64 } {
                return Err(Stop::Wrong("a block has too many coefficients"));
            }
        }

        Ok(())
    }

    /// Zeros before a coefficient, and its size in bits.
    fn run(&mut self, codes: &Codes) -> Result<(u8, u8), Stop> {
        let symbol = codes.next(&mut self.bits)?;
        let (zeros, size) = (symbol >> 4, symbol & 15);
        if self.has_eight_bits && size > MOST_COEFFICIENT {
            return Err(Stop::Wrong("a coefficient is too large"));
        }
        Ok((zeros, size))
    }

    /// Returns the number of blocks, with this one, that hold nothing further.
    fn ends(&mut self, power: u8) -> Result<u32, Stop> {
        Ok((1 << power) + self.bits.take(u32::from(power))?)
    }

    /// The highest bits of a band.
    fn first(&mut self, codes: &Codes, nonzero: &mut u64) -> Result<(), Stop> {
        if self.ended > 0 {
            self.ended -= 1;
            return Ok(());
        }

        let mut at = self.scan.from;
        while at <= self.scan.to {
            let (zeros, size) = self.run(codes)?;
            if size == 0 && zeros < 15 {
                self.ended = self.ends(zeros)? - 1;
                break;
            }

            at += zeros;
            if size > 0 {
                self.bits.take(u32::from(size))?;
            }
            if at > self.scan.to || size == 0 && at == self.scan.to {
                return Err(Stop::Wrong("a block has too many coefficients"));
            }

            if size > 0 {
                *nonzero |= 1 << at;
            }
            at += 1;
        }

        Ok(())
    }

    /// The next bit of a band.
    fn refine(&mut self, codes: &Codes, nonzero: &mut u64) -> Result<(), Stop> {
        let mut at = self.scan.from;
        while self.ended == 0 && at <= self.scan.to {
            let (zeros, size) = self.run(codes)?;
            if size > 1 {
                return Err(Stop::Wrong("a code that does not exist"));
            }
            if size == 0 && zeros < 15 {
                self.ended = self.ends(zeros)?;
                break;
            }

            // The new coefficient's sign.
            self.bits.take(u32::from(size))?;
            at = self.pass(at, zeros, *nonzero)?;
            if size > 0 {
                if at > self.scan.to {
                    return Err(Stop::Wrong("a block has too many coefficients"));
                }
                *nonzero |= 1 << at;
            }

            at += 1;
        }

        if self.ended > 0 {
            self.pass(at, u8::MAX, *nonzero)?;
            self.ended -= 1;
        }

        Ok(())
    }

    /// Goes over so many zeros, and reads the next bit of all that is not zero on the way.
    fn pass(&mut self, mut at: u8, mut zeros: u8, nonzero: u64) -> Result<u8, Stop> {
        while at <= self.scan.to {
            if nonzero >> at & 1 == 1 {
                self.bits.take(1)?;
            } else if zeros == 0 {
                break;
            } else {
                zeros -= 1;
            }
            at += 1;
        }
        Ok(at)
    }
}
