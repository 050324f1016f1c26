//! A JPEG's frame: its components, the scans that bring them, and whether all of them came (T.81, annexes B, G).

use super::scan::{self, Scan};
use super::segments::{Segments, Tables, damaged, marker};
use crate::picture::Fault;
use crate::picture::jpeg::layout::{Component, Frame};

/// No scan brought a coefficient yet.
const UNSEEN: u8 = u8::MAX;

/// Follows all coded data.
///
/// # Errors
/// What of it is missing or cannot be.
pub fn check(bytes: &[u8]) -> Result<(), Fault> {
    let mut segments = Segments::new(bytes);
    let (mut tables, mut frame) = (Tables::default(), None);
    let (mut scans, mut ends_in_zeros) = (0, false);
    while let Some(segment) = segments.next()? {
        let body = segment.body;
        match segment.marker {
            marker::SOI | marker::COM | marker::APP0..=marker::APP15 => {}
            marker::EOI => break,
            marker::DQT => tables.quantisation(body)?,
            marker::DHT => tables.codes(body)?,
            marker::DRI => tables.restarts(body)?,
            marker::SOS => {
                let frame: &mut Frame =
                    frame.as_mut().ok_or_else(|| damaged("its picture has no size".to_owned()))?;
                scans += 1;
                let scan = frame.scan(body)?;
                let coded = segments.coded()?;
                ends_in_zeros = !coded.goes_on && coded.ends_in_zeros();
                let walked = scan::walk(frame, &scan, &tables, &coded);
                walked.map_err(|broken| frame.fault(&broken, &scan, scans, coded.goes_on))?;
            }
            kind @ 0xc0..=0xc2 => {
                let read = Frame::read(kind == 0xc2, body)?;
                if frame.replace(read).is_some() {
                    return Err(damaged("it holds the size of its picture twice".to_owned()));
                }
            }
            0xc3 | 0xc5..=0xcf => {
                return Err(Fault::Unsupported(
                    "it is a JPEG of a rare kind (lossless, arithmetic)".to_owned(),
                ));
            }
            other => return Err(damaged(format!("it holds a segment of no known kind (0xff{other:02x})"))),
        }
    }

    let frame = frame.ok_or_else(|| damaged("its picture has no size".to_owned()))?;
    // Zeros are codes too: of a file that nothing closes they may be room for what never came.
    if ends_in_zeros {
        return Err(damaged("it ends in zeros, and the marker of its end is missing".to_owned()));
    }

    if frame.components.iter().all(Component::is_whole) {
        Ok(())
    } else {
        Err(damaged("it is cut short: its last scans are missing".to_owned()))
    }
}

impl Frame {
    fn read(is_progressive: bool, body: &[u8]) -> Result<Self, Fault> {
        let wrong = || damaged("the size of its picture is damaged".to_owned());
        let [bits, y0, y1, x0, x1, count, rest @ ..] = body else { return Err(wrong()) };
        let size = |high: &u8, low: &u8| usize::from(u16::from_be_bytes([*high, *low]));
        let (width, height) = (size(x0, x1), size(y0, y1));
        if rest.len() != 3 * usize::from(*count) || rest.is_empty() || rest.len() > 12 || width * height == 0
        {
            return Err(wrong());
        }

        let sampling = |part: &[u8]| (usize::from(part[1] >> 4), usize::from(part[1] & 15));
        let parts = || rest.chunks_exact(3);
        let most = parts().map(sampling).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1))).unwrap_or_default();
        if parts().any(|part| !matches!(sampling(part), (1..=4, 1..=4)) || part[2] > 3) {
            return Err(wrong());
        }

        let units = (width.div_ceil(8 * most.0), height.div_ceil(8 * most.1));
        let component = |part: &[u8]| {
            let own = sampling(part);
            let side = |size: usize, own: usize, most: usize| (size * own).div_ceil(most).div_ceil(8);
            let stride = units.0 * own.0;
            let all = if is_progressive { stride * units.1 * own.1 } else { 0 };

            Component {
                id: part[0],
                sampling: own,
                steps: usize::from(part[2]),
                blocks: (side(width, own.0, most.0), side(height, own.1, most.1)),
                stride,
                nonzero: vec![0; all],
                low: [UNSEEN; 64],
            }
        };

        let components = parts().map(component).collect();
        Ok(Self { is_progressive, bits: *bits, units, components })
    }

    /// Reads a scan's header, and notes what the scan brings.
    fn scan(&mut self, body: &[u8]) -> Result<Scan, Fault> {
        let wrong = || damaged("the header of one of its scans is damaged".to_owned());
        let (count, rest) = body.split_first().ok_or_else(wrong)?;
        let (parts, rest) = rest.split_at_checked(2 * usize::from(*count)).ok_or_else(wrong)?;
        let [from, to, bits] = rest else { return Err(wrong()) };

        let mut scan = Scan { parts: Vec::new(), from: 0, to: 63, high: 0, low: 0 };
        if self.is_progressive {
            (scan.from, scan.to, scan.high, scan.low) = (*from, *to, bits >> 4, bits & 15);
        }

        let is_dc = scan.from == 0;
        let is_sound = if !self.is_progressive {
            true
        } else if is_dc {
            scan.to == 0
        } else {
            scan.from <= scan.to && scan.to < 64 && *count == 1
        };

        for part in parts.chunks_exact(2) {
            let number = self.components.iter().position(|component| component.id == part[0]);
            let number = number.ok_or_else(wrong)?;
            if scan.parts.iter().any(|known| known.component == number) {
                return Err(wrong());
            }
            let (dc, ac) = (usize::from(part[1] >> 4), usize::from(part[1] & 15));
            scan.parts.push(scan::Part { component: number, dc, ac });
        }

        if scan.parts.is_empty() || !is_sound {
            return Err(wrong());
        }

        for part in &scan.parts {
            let low = &mut self.components[part.component].low[usize::from(scan.from)..=usize::from(scan.to)];
            // Bits of a coefficient come from the highest one down, each once.
            let follows = |known: &u8| match scan.high {
                0 => *known == UNSEEN,
                high => *known == high && scan.low + 1 == high,
            };
            if !low.iter().all(follows) {
                return Err(damaged("its scans do not follow each other; one is missing".to_owned()));
            }
            low.fill(scan.low);
        }

        Ok(scan)
    }

    /// Says what is wrong with coded data, and how much of the picture that costs.
    fn fault(&self, broken: &scan::Broken, scan: &Scan, number: usize, goes_on: bool) -> Fault {
        let share = 100.0 * broken.done as f64 / broken.of.max(1) as f64;
        let is_all = !self.is_progressive && scan.parts.len() == self.components.len();
        let whole = if is_all { "its picture".to_owned() } else { format!("its scan {number}") };
        let what = broken.what();
        damaged(if goes_on {
            format!("its coded data break after {share:.0} % of {whole}: {what}")
        } else {
            format!("it is cut short: {:.0} % of {whole} is missing", (100.0 - share).max(1.0))
        })
    }
}

impl Component {
    /// Whether all bits of all coefficients that any scan brought are there.
    fn is_whole(&self) -> bool {
        self.low[0] == 0 && self.low.iter().all(|low| matches!(*low, 0 | UNSEEN))
    }
}
