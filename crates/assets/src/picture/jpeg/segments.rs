//! Segments of a JPEG, and the tables that they define (T.81, annex B).

use super::bits::Codes;
use crate::picture::Fault;

/// Markers by their names.
pub mod marker {
    pub const DHT: u8 = 0xc4;
    pub const FIRST_RESTART: u8 = 0xd0;
    pub const LAST_RESTART: u8 = 0xd7;
    pub const SOI: u8 = 0xd8;
    pub const EOI: u8 = 0xd9;
    pub const SOS: u8 = 0xda;
    pub const DQT: u8 = 0xdb;
    pub const DRI: u8 = 0xdd;
    pub const APP0: u8 = 0xe0;
    pub const APP15: u8 = 0xef;
    pub const COM: u8 = 0xfe;
}

/// A marker with what belongs to it.
pub struct Segment<'b> {
    pub marker: u8,
    pub body: &'b [u8],
}

/// Coded data of a scan.
pub struct Coded<'b> {
    /// Cut at restarts.
    pub parts: Vec<&'b [u8]>,
    /// Whether the file goes on behind them.
    pub goes_on: bool,
}

impl Coded<'_> {
    /// Whether the last byte is zero, and not part of a coded 0xff.
    pub fn ends_in_zeros(&self) -> bool {
        matches!(self.parts.last(), Some([.., before, 0]) if *before != 0xff)
    }
}

/// Goes from segment to segment.
pub struct Segments<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b> Segments<'b> {
    pub fn new(bytes: &'b [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next one; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Segment<'b>>, Fault> {
        let from = self.at;
        let marker = loop {
            let Some(byte) = self.bytes.get(self.at) else { return Ok(None) };
            self.at += 1;
            match byte {
                // Bytes that fill space may stand before a marker.
                0 | 0xff => {}
                marker if self.at >= from + 2 && self.bytes[self.at - 2] == 0xff => break *marker,
                _ => return Err(damaged(format!("no marker stands at byte {from}"))),
            }
        };

        if matches!(marker, marker::SOI | marker::EOI) {
            return Ok(Some(Segment { marker, body: &[] }));
        }

        let cut = || damaged("it is cut short before its picture".to_owned());
        let rest = &self.bytes[self.at..];
        let (length, _) = rest.split_first_chunk().ok_or_else(cut)?;
        let length = usize::from(u16::from_be_bytes(*length));
        let body = rest.get(..length).ok_or_else(cut)?;
        let body =
            body.get(2..).ok_or_else(|| damaged(format!("its segment at byte {from} has no length")))?;
        self.at += length;

        Ok(Some(Segment { marker, body }))
    }

    /// Coded data from here to the next marker that is none of a restart.
    pub fn coded(&mut self) -> Result<Coded<'b>, Fault> {
        let (mut parts, mut from) = (Vec::new(), self.at);
        loop {
            let part = &self.bytes[from..];
            let mut after = 0;
            let end = loop {
                let Some(found) = part[after..].iter().position(|byte| *byte == 0xff) else { break None };
                match part.get(after + found + 1) {
                    Some(0) => after += found + 2,
                    Some(_) => break Some(after + found),
                    None => break None,
                }
            };

            let Some(end) = end else {
                parts.push(part);
                self.at = self.bytes.len();
                return Ok(Coded { parts, goes_on: false });
            };

            parts.push(&part[..end]);
            let fill = part[end..].iter().take_while(|byte| **byte == 0xff).count();
            let next = part.get(end + fill).copied().unwrap_or(marker::EOI);
            if !(marker::FIRST_RESTART..=marker::LAST_RESTART).contains(&next) {
                self.at = from + end;
                return Ok(Coded { parts, goes_on: true });
            }
            if usize::from(next - marker::FIRST_RESTART) != (parts.len() - 1) % 8 {
                return Err(damaged("its restart markers are out of order".to_owned()));
            }

            from += end + fill + 1;
        }
    }
}

/// Tables in force.
#[derive(Default)]
pub struct Tables {
    /// The first step of each quantisation table.
    pub steps: [Option<u16>; 4],
    pub dc: [Option<Codes>; 4],
    pub ac: [Option<Codes>; 4],
    /// Units between restarts; 0: there are none.
    pub restart: usize,
}

impl Tables {
    /// Takes tables of quantisation.
    pub fn quantisation(&mut self, mut body: &[u8]) -> Result<(), Fault> {
        let wrong = || damaged("a table of its quantisation is damaged".to_owned());
        while let Some((kind, rest)) = body.split_first() {
            let (wide, number) = (kind >> 4, usize::from(kind & 15));
            let size = if wide == 0 { 1 } else { 2 };
            let steps = rest.get(..64 * size).ok_or_else(wrong)?;
            let mut steps = steps
                .chunks_exact(size)
                .map(|step| step.iter().fold(0, |all, byte| all << 8 | u16::from(*byte)));
            let first = steps.next().filter(|first| *first > 0 && steps.all(|step| step > 0));
            if wide > 1 || number > 3 || first.is_none() {
                return Err(wrong());
            }
            self.steps[number] = first;
            body = &rest[64 * size..];
        }
        Ok(())
    }

    /// Takes tables of codes.
    pub fn codes(&mut self, mut body: &[u8]) -> Result<(), Fault> {
        let wrong = || damaged("a table of its codes is damaged".to_owned());
        while let Some((kind, rest)) = body.split_first() {
            let (counts, rest) = rest.split_first_chunk().ok_or_else(wrong)?;
            let count: usize = counts.iter().map(|count| usize::from(*count)).sum();
            let symbols = rest.get(..count).ok_or_else(wrong)?;
            let codes = Codes::new(counts, symbols).ok_or_else(wrong)?;
            let tables = match kind >> 4 {
                0 => &mut self.dc,
                1 => &mut self.ac,
                _ => return Err(wrong()),
            };
            *tables.get_mut(usize::from(kind & 15)).ok_or_else(wrong)? = Some(codes);
            body = &rest[count..];
        }
        Ok(())
    }

    /// Takes the number of units between restarts.
    pub fn restarts(&mut self, body: &[u8]) -> Result<(), Fault> {
        let number: [u8; 2] =
            body.try_into().map_err(|_| damaged("its interval of restarts is damaged".to_owned()))?;
        self.restart = usize::from(u16::from_be_bytes(number));
        Ok(())
    }
}

/// Damage, as a clause.
pub fn damaged(what: String) -> Fault {
    Fault::Damaged(what)
}
