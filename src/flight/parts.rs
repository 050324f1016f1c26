//! Recordings that one path file holds: one of them alone, or all of them in the order of their times.
//!
//! ```text
//! fixes of all parts ──--track N──▶ those of one ──--sort──▶ by time
//! ```

use std::ops::Range;

use time::OffsetDateTime;

use super::raw::{CLOCK, PathSource, RawFix, Reading};
use crate::flight::raw::Recording;
use hedgehop_base::error::{Error, Result};

/// Parts that a sentence lists before it only counts them.
const MOST_LISTED: usize = 20;

/// Letters of a part's name that a sentence shows.
const MOST_LETTERS: usize = 40;

/// Leaves of a file's fixes what the user asked for, in the order that was asked for.
pub(super) fn choose(source: &PathSource<'_>, reading: &mut Reading) -> Result<()> {
    let parts = spans(reading);
    let count = parts.len().max(1);

    match source.options.track {
        Some(number) if (1..=count).contains(&number) => {
            if let Some(span) = parts.get(number - 1) {
                reading.fixes = reading.fixes[span.clone()].to_vec();
                reading.parts.clear();
            }
        }
        Some(number) => {
            let holds = match count {
                1 => "holds one track".to_owned(),
                _ => format!("holds {count} tracks ({})", listed(reading)),
            };
            return Err(Error::invalid(source.path, format!("{holds}, and --track {number} is none")));
        }
        None if count > 1 => {
            let list = listed(reading);
            let note = format!(
                "{count} {} were joined into one flight ({list}); --track N flies one of them.",
                reading.noun
            );
            reading.notes.push(note);
        }
        None => {}
    }

    if source.options.sort {
        sort(source, reading)?;
    }

    Ok(())
}

/// Orders fixes by time. Recordings of the same hours are refused: sorted, they would be flown by turns.
fn sort(source: &PathSource<'_>, reading: &mut Reading) -> Result<()> {
    let mut hours: Vec<(usize, [f64; 2])> =
        spans(reading).into_iter().map(|span| ends(&reading.fixes[span])).enumerate().collect();
    hours.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    if let Some(pair) = hours.windows(2).find(|pair| pair[1].1[0] < pair[0].1[1] - CLOCK) {
        let (first, second) = (pair[0].0 + 1, pair[1].0 + 1);
        let what = format!(
            "tracks {first} and {second} are of the same time, and sorted together they would be flown by turns; take one \
             with --track N ({})",
            listed(reading)
        );
        return Err(Error::invalid(source.path, what));
    }

    let steps_back = reading.fixes.windows(2).filter(|pair| pair[1].fix.time < pair[0].fix.time).count();
    if steps_back > 0 {
        reading.fixes.sort_by(|a, b| a.fix.time.total_cmp(&b.fix.time));
        let times = if steps_back == 1 { "once" } else { "times" };
        let count = if steps_back == 1 { String::new() } else { format!("{steps_back} ") };
        reading.notes.push(format!("Fixes were sorted by time, which went back {count}{times}."));
    }

    Ok(())
}

/// Names what helps against times that go back, in this file.
pub(super) fn remedy(reading: &Reading) -> String {
    match spans(reading).len() {
        0 | 1 => "--sort puts the fixes in the order of their times".to_owned(),
        count => format!(
            "--track N flies one of its {count} tracks ({}), --sort puts all fixes in the order of their times",
            listed(reading)
        ),
    }
}

/// Fixes of each part that has any.
fn spans(reading: &Reading) -> Vec<Range<usize>> {
    named(reading).map(|(_, span)| span).collect()
}

fn named(reading: &Reading) -> impl Iterator<Item = (&Recording, Range<usize>)> {
    let ends = reading.parts.iter().skip(1).map(|part| part.start).chain([reading.fixes.len()]);
    reading
        .parts
        .iter()
        .zip(ends)
        .map(|(part, end)| (part, part.start..end))
        .filter(|(_, span)| !span.is_empty())
}

/// Parts by number, name, time and size.
fn listed(reading: &Reading) -> String {
    let mut words: Vec<String> = named(reading)
        .take(MOST_LISTED)
        .enumerate()
        .map(|(index, (part, span))| {
            let fixes = span.len();
            let name = part.name.as_deref().map(|name| format!(" \"{}\"", short(name))).unwrap_or_default();
            let [first, last] = ends(&reading.fixes[span]).map(clock);
            // The date of the end is said only where it is another one.
            let same_day = last.get(..10).is_some() && last.get(..10) == first.get(..10);
            let last = if same_day { &last[11..] } else { &last };
            format!("{}{name}: {first} to {last}, {fixes} fixes", index + 1)
        })
        .collect();
    let more = spans(reading).len().saturating_sub(MOST_LISTED);
    if more > 0 {
        words.push(format!("{more} more"));
    }
    words.join("; ")
}

/// Times of the earliest and the latest fix.
fn ends(fixes: &[RawFix]) -> [f64; 2] {
    let times = fixes.iter().map(|raw| raw.fix.time);
    times.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], time| [low.min(time), high.max(time)])
}

/// `2026-05-01 12:00`, UTC.
fn clock(unix_seconds: f64) -> String {
    match OffsetDateTime::from_unix_timestamp(unix_seconds as i64) {
        Ok(moment) => format!("{} {:02}:{:02}", moment.date(), moment.hour(), moment.minute()),
        Err(_) => format!("{unix_seconds} s"),
    }
}

fn short(name: &str) -> String {
    let name = name.trim().replace(char::is_control, " ");
    match name.char_indices().nth(MOST_LETTERS) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{ReadOptions, Track, read_track};

    /// A GPX of tracks, each by its name and the minutes of its fixes.
    fn gpx(tracks: &[(&str, &[u32])]) -> String {
        let point = |minute: &u32| {
            format!(
                "<trkpt lat=\"47.{minute:02}\" lon=\"8\"><ele>500</ele><time>2026-05-01T12:{minute:02}:00Z</time></trkpt>"
            )
        };
        let track = |(name, minutes): &(&str, &[u32])| {
            let points: String = minutes.iter().map(point).collect();
            format!("<trk><name>{name}</name><trkseg></trkseg><trkseg>{points}</trkseg></trk>")
        };
        format!("<gpx>{}</gpx>", tracks.iter().map(track).collect::<String>())
    }

    fn read(text: &str, track: Option<usize>, sort: bool) -> std::result::Result<Track, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hike.gpx");
        std::fs::write(&path, text).unwrap();
        let options = ReadOptions { track, sort, ..ReadOptions::default() };
        read_track(Path::new(&path), &options).map_err(|error| error.to_string())
    }

    fn minutes(track: &Track) -> Vec<u32> {
        track.fixes.iter().map(|fix| (fix.time / 60.0).round() as u32).collect()
    }

    #[test]
    fn one_track_of_several_is_flown_alone() {
        let text = gpx(&[("Evening", &[30, 31, 35]), ("Morning", &[10, 11])]);
        let error = read(&text, None, false).unwrap_err();
        for words in
            ["out of order", "1 \"Evening\": 2026-05-01 12:30 to 12:35, 3 fixes; 2 \"Morning\"", "--sort"]
        {
            assert!(error.contains(words), "{words}: {error}");
        }
        assert_eq!(minutes(&read(&text, Some(1), false).unwrap()), [0, 1, 5]);
        let morning = read(&text, Some(2), false).unwrap();
        assert_eq!(minutes(&morning), [0, 1]);
        assert!(!morning.notes.iter().any(|note| note.contains("joined")), "{:?}", morning.notes);
        for number in [0, 3] {
            let error = read(&text, Some(number), false).unwrap_err();
            assert!(error.contains("holds 2 tracks (1 \"Evening\""), "{error}");
        }
        assert!(read(&gpx(&[("A", &[1])]), Some(2), false).unwrap_err().contains("holds one track"));
    }

    #[test]
    fn sorted_fixes_are_in_the_order_of_their_times() {
        let text = gpx(&[("Evening", &[30, 31, 35]), ("Morning", &[10, 12, 11])]);
        let sorted = read(&text, None, true).unwrap();
        assert_eq!(minutes(&sorted), [0, 1, 2, 20, 21, 25]);
        assert!(sorted.notes.iter().any(|note| note.contains("back 2 times")), "{:?}", sorted.notes);
        assert_eq!(minutes(&read(&text, Some(2), true).unwrap()), [0, 1, 2]);
    }

    #[test]
    fn tracks_of_the_same_time_are_not_mixed() {
        let text = gpx(&[("Anna", &[10, 20]), ("Ben", &[15, 25])]);
        let error = read(&text, None, true).unwrap_err();
        assert!(
            error.contains("tracks 1 and 2 are of the same time") && error.contains("\"Ben\""),
            "{error}"
        );
        assert_eq!(minutes(&read(&text, Some(2), true).unwrap()), [0, 10]);
        // One begins when the other ends.
        assert!(read(&gpx(&[("Anna", &[10, 20]), ("Ben", &[20, 25])]), None, true).is_ok());
    }
}
