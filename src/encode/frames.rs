//! Selection of a flight's frames: `1-10,20,30-40:2`.
//!
//! A set is kept as its ranges, never as a list of numbers, so `1-18446744073709551615` costs nothing.
//! Iteration is the k-way merge of the ranges (Knuth, The Art of Computer Programming 3, 5.4.1) with
//! repeated numbers left out.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use hedgehop_base::error::{Error, Result};

const EXAMPLE: &str = "write for instance 1-10,20,30-40:2";

/// A set of frame numbers, each ≥ 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameSet {
    ranges: Vec<FrameRange>,
}

/// `first, first + step, …`, none above `last`; `last` is one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FrameRange {
    first: u64,
    last: u64,
    step: u64,
}

impl FrameRange {
    fn contains(&self, number: u64) -> bool {
        (self.first..=self.last).contains(&number) && (number - self.first).is_multiple_of(self.step)
    }
}

impl FrameSet {
    /// Understands what `--frames` was given: numbers and ranges, `A-B` or `A..B` with an optional
    /// step `:N`, separated by commas. They may overlap and stand in any order.
    pub fn parse(text: &str) -> Result<Self> {
        let ranges = text
            .split(',')
            .map(|item| {
                range(item.trim())
                    .map_err(|what| Error::Configuration(format!("--frames {text}: {what}; {EXAMPLE}")))
            })
            .collect::<Result<_>>()?;
        Ok(Self { ranges })
    }

    /// Frames 1 … `count`; nothing for 0.
    pub fn all(count: u64) -> Self {
        let ranges =
            if count == 0 { Vec::new() } else { vec![FrameRange { first: 1, last: count, step: 1 }] };
        Self { ranges }
    }

    /// Whether `number` is wanted.
    pub fn contains(&self, number: u64) -> bool {
        self.ranges.iter().any(|range| range.contains(number))
    }

    /// The highest frame; `None` when there is none.
    pub fn last(&self) -> Option<u64> {
        self.ranges.iter().map(|range| range.last).max()
    }

    /// Refuses a set that goes beyond the `count` frames of a flight.
    pub fn check_within(&self, count: u64) -> Result<()> {
        match self.last() {
            Some(last) if last > count => Err(Error::Configuration(format!(
                "--frames asks for frame {last}, but the flight has frames 1-{count} at this --fps"
            ))),
            _ => Ok(()),
        }
    }

    /// The frames in rising order, each once.
    pub fn iter(&self) -> impl Iterator<Item = u64> + use<> {
        let mut queue: BinaryHeap<_> =
            self.ranges.iter().map(|range| Reverse((range.first, range.last, range.step))).collect();
        let mut previous = 0;
        std::iter::from_fn(move || {
            while let Some(Reverse((number, last, step))) = queue.pop() {
                if let Some(next) = number.checked_add(step).filter(|&next| next <= last) {
                    queue.push(Reverse((next, last, step)));
                }
                if number != previous {
                    previous = number;
                    return Some(number);
                }
            }
            None
        })
    }
}

/// One item of the list, or what is wrong with it.
fn range(item: &str) -> Result<FrameRange, String> {
    let (span, step) = match item.split_once(':') {
        Some((span, step)) => (span, number(step, item)?),
        None => (item, 1),
    };
    let (first, last) = match span.split_once("..").or_else(|| span.split_once('-')) {
        Some((first, last)) => (number(first, item)?, number(last, item)?),
        None if span.len() == item.len() => (number(span, item)?, number(span, item)?),
        None => return Err(format!("`{item}` has a step but no range")),
    };
    if first == 0 {
        return Err(format!("`{item}` begins at 0, but frames are numbered from 1"));
    }
    if step == 0 {
        return Err(format!("`{item}` has a step of 0"));
    }
    if last < first {
        return Err(format!("`{item}` runs backwards ({first} is above {last})"));
    }

    Ok(FrameRange { first, last: last - (last - first) % step, step })
}

fn number(text: &str, item: &str) -> Result<u64, String> {
    let text = text.trim();
    if item.is_empty() {
        return Err("an item is empty".to_owned());
    }
    if text.is_empty() {
        return Err(format!("`{item}` lacks a number"));
    }
    if !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(format!("`{text}` is no frame number"));
    }
    text.parse().map_err(|_| format!("`{text}` is above {}, the highest frame number", u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Vec<u64> {
        FrameSet::parse(text).unwrap().iter().collect()
    }

    #[test]
    fn sets_are_sorted_and_unique() {
        for (text, expected) in [
            ("7", vec![7]),
            ("1-3,5,7..9", vec![1, 2, 3, 5, 7, 8, 9]),
            ("30-40:4,1-2", vec![1, 2, 30, 34, 38]),
            ("5-8,6-10:2,7", vec![5, 6, 7, 8, 10]),
            (" 3 , 1 - 2 ", vec![1, 2, 3]),
            ("1-1:9", vec![1]),
            ("1-4:2,1-4:3", vec![1, 3, 4]),
            ("2,2,2", vec![2]),
        ] {
            assert_eq!(list(text), expected, "{text}");
        }
    }

    #[test]
    fn huge_ranges_cost_nothing() {
        let set = FrameSet::parse("1-18446744073709551615,2-18446744073709551614:3").unwrap();
        assert_eq!(set.iter().take(3).collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(set.last(), Some(u64::MAX));
        assert!(set.contains(u64::MAX) && !set.contains(0));
        let top = FrameSet::parse("18446744073709551614-18446744073709551615").unwrap();
        assert_eq!(top.iter().collect::<Vec<_>>(), [u64::MAX - 1, u64::MAX]);
        assert!(set.check_within(300).unwrap_err().to_string().contains("1-300"));
        assert!(FrameSet::parse("1-300").unwrap().check_within(300).is_ok());
    }

    #[test]
    fn the_last_frame_is_one_that_is_in_the_set() {
        assert_eq!(FrameSet::parse("1-10:4").unwrap().last(), Some(9));
        assert_eq!(FrameSet::all(0).last(), None);
        assert_eq!(FrameSet::all(3).iter().collect::<Vec<_>>(), [1, 2, 3]);
    }

    #[test]
    fn refusals_say_what_and_how() {
        for (text, words) in [
            ("0", "begins at 0"),
            ("0-5", "begins at 0"),
            ("9-3", "runs backwards (9 is above 3)"),
            ("1-9:0", "step of 0"),
            ("5:2", "step but no range"),
            ("1,,2", "an item is empty"),
            ("", "an item is empty"),
            ("1-", "lacks a number"),
            ("-5", "lacks a number"),
            ("1-2-3", "`2-3` is no frame number"),
            ("a", "`a` is no frame number"),
            ("+1", "`+1` is no frame number"),
            ("1-99999999999999999999", "above 18446744073709551615"),
        ] {
            let message = FrameSet::parse(text).unwrap_err().to_string();
            assert!(message.starts_with("--frames") && message.contains(words), "{text}: {message}");
            assert!(message.ends_with(EXAMPLE), "{message}");
        }
    }
}
