//! Chapters of a film, as people write them and as ffmpeg reads them.
//!
//! ```text
//! 0:00 Over the lake         a line each: time in the film, title     (as under films on the web)
//! 1:02:30.5 Back home
//!
//! ;FFMETADATA1               or what ffmpeg itself reads and writes
//! [CHAPTER]
//! TIMEBASE=1/1000
//! START=0
//! END=62000
//! title=Over the lake
//! ```
//!
//! A chapter ends where the next one begins, the last one with the film. Blank lines and lines that begin with `#` are
//! left out.

use std::path::Path;

use hedgehop_base::error::{Error, Result};

/// First line of ffmpeg's own form.
const FFMETADATA: &str = ";FFMETADATA";
/// Most bytes that a file of chapters may have.
const MOST_BYTES: u64 = 1 << 20;

/// Part of a film that players can go to.
#[derive(Debug, Clone, PartialEq)]
pub struct Chapter {
    /// Time in the film that it begins at, seconds.
    pub begin: f64,
    /// Title that players show.
    pub title: String,
}

/// Line of a file, and where it stands.
#[derive(Clone, Copy)]
struct TextLine<'t> {
    /// Number from 1 on.
    number: usize,
    /// Text without blanks around it.
    text: &'t str,
}

/// Reads a file of chapters.
///
/// # Errors
/// A file that is not there, or a line that says no chapter, or one before the chapter above it.
pub fn read_chapters(path: &Path) -> Result<Vec<Chapter>> {
    let length = std::fs::metadata(path).map_err(|error| Error::io(path, "read it", error))?.len();
    if length > MOST_BYTES {
        return Err(Error::invalid(
            path,
            "it is too long for a list of chapters, a line each: 1:30 Over the lake",
        ));
    }

    let bytes = std::fs::read(path).map_err(|error| Error::io(path, "read it", error))?;
    let text = String::from_utf8(bytes).map_err(|_| Error::invalid(path, "it is no text in UTF-8"))?;
    let chapters = parse(&text).map_err(|what| Error::invalid(path, what))?;
    if chapters.is_empty() {
        return Err(Error::invalid(path, "it names no chapter; write a line for each: 1:30 Over the lake"));
    }
    Ok(chapters)
}

fn parse(text: &str) -> Result<Vec<Chapter>, String> {
    let text = text.trim_start_matches('\u{feff}');
    let lines = (1..).zip(text.lines()).map(|(number, text)| TextLine { number, text: text.trim() });
    let lines = lines.filter(|line| !line.text.is_empty() && !line.text.starts_with('#'));
    let chapters =
        if text.starts_with(FFMETADATA) { ffmpeg_chapters(lines)? } else { plain_chapters(lines)? };

    let mut before = -1.0;
    for (number, chapter) in &chapters {
        if chapter.begin <= before {
            return Err(format!(
                "line {number}: chapter `{}` begins no later than the one above it; put them in the order of their times",
                chapter.title
            ));
        }
        before = chapter.begin;
    }
    Ok(chapters.into_iter().map(|(_, chapter)| chapter).collect())
}

/// Lines of a time and a title, each with its number.
fn plain_chapters<'t>(lines: impl Iterator<Item = TextLine<'t>>) -> Result<Vec<(usize, Chapter)>, String> {
    let chapter = |TextLine { number, text }: TextLine<'t>| {
        let (time, title) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let title = title.trim();
        match clock(time) {
            Some(begin) if !title.is_empty() => Ok((number, Chapter { begin, title: title.to_owned() })),
            _ => Err(format!(
                "line {number}: `{text}` is no time in the film and a title, as in 1:30 Over the lake"
            )),
        }
    };
    lines.map(chapter).collect()
}

/// `1:02:30.5`, `1:30` or `90`, in seconds.
fn clock(text: &str) -> Option<f64> {
    let parts: Vec<&str> = text.split(':').collect();
    let (seconds, above) = parts.split_last()?;
    let is_plain = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let is_time = above.iter().all(|part| is_plain(part)) && is_plain(&seconds.replacen('.', "", 1));
    if above.len() > 2 || !is_time {
        return None;
    }

    let seconds: f64 = seconds.parse().ok()?;
    if !above.is_empty() && seconds >= 60.0 {
        return None;
    }
    let mut whole = 0.0;
    for part in above {
        whole = whole * 60.0 + part.parse::<f64>().ok()?;
    }
    Some(whole * 60.0 + seconds)
}

/// `[CHAPTER]` sections of ffmpeg's metadata, each with the number of its first line.
fn ffmpeg_chapters<'t>(lines: impl Iterator<Item = TextLine<'t>>) -> Result<Vec<(usize, Chapter)>, String> {
    /// Keys of a section, so far.
    struct ChapterSection {
        number: usize,
        base: f64,
        start: Option<f64>,
        title: String,
    }

    let mut sections: Vec<ChapterSection> = Vec::new();
    let mut is_chapter = false;
    for TextLine { number, text } in lines {
        if text.starts_with('[') {
            is_chapter = text.eq_ignore_ascii_case("[CHAPTER]");
            if is_chapter {
                // Without TIMEBASE ffmpeg counts nanoseconds.
                sections.push(ChapterSection { number, base: 1.0e-9, start: None, title: String::new() });
            }
            continue;
        }

        let (Some(section), Some((key, value))) = (sections.last_mut(), text.split_once('=')) else {
            continue;
        };
        let wrong = || format!("line {number}: `{text}` is no number that ffmpeg's metadata has there");
        match key.trim().to_ascii_uppercase().as_str() {
            _ if !is_chapter => {}
            "TIMEBASE" => section.base = ratio(value).ok_or_else(wrong)?,
            "START" => section.start = Some(value.trim().parse::<u64>().map_err(|_| wrong())? as f64),
            "TITLE" => section.title = plain(value.trim()),
            _ => {}
        }
    }

    let chapter = |ChapterSection { number, base, start, title }: ChapterSection| {
        let start = start.ok_or_else(|| format!("line {number}: the chapter has no START"))?;
        Ok((number, Chapter { begin: start * base, title }))
    };
    sections.into_iter().map(chapter).collect()
}

/// `1/1000`.
fn ratio(text: &str) -> Option<f64> {
    let (above, below) = text.trim().split_once('/')?;
    let (above, below): (u32, u32) = (above.parse().ok()?, below.parse().ok()?);
    (above > 0 && below > 0).then(|| f64::from(above) / f64::from(below))
}

/// Text without ffmpeg's escapes.
fn plain(text: &str) -> String {
    let mut characters = text.chars();
    let mut plain = String::new();
    while let Some(character) = characters.next() {
        plain.extend(if character == '\\' { characters.next() } else { Some(character) });
    }
    plain
}

/// Writes chapters of a film that lasts so many seconds as ffmpeg reads them.
pub(super) fn ffmetadata(chapters: &[Chapter], seconds: f64) -> String {
    let ends = chapters.iter().skip(1).map(|next| next.begin).chain([seconds]);
    let mut text = format!("{FFMETADATA}1\n");
    for (Chapter { begin, title }, end) in chapters.iter().zip(ends) {
        let [begin, end] = [*begin, end].map(|seconds| (seconds * 1.0e6).round() as u64);
        text += &format!("[CHAPTER]\nTIMEBASE=1/1000000\nSTART={begin}\nEND={end}\ntitle=");
        for character in title.chars() {
            if matches!(character, '=' | ';' | '#' | '\\' | '\n') {
                text.push('\\');
            }
            text.push(character);
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chapter(begin: f64, title: &str) -> Chapter {
        Chapter { begin, title: title.to_owned() }
    }

    #[test]
    fn chapters_are_lines_of_time_and_title_or_what_ffmpeg_writes() {
        let expected =
            [chapter(0.0, "Start; as #1"), chapter(90.0, "Lake = blue \\"), chapter(3750.5, "Home")];
        let lines = "\u{feff}# my film\r\n0:00 Start; as #1\r\n\r\n90  Lake = blue \\\n1:02:30.5\tHome\n";
        assert_eq!(parse(lines).unwrap(), expected);
        assert_eq!(parse(&ffmetadata(&expected, 4000.0)).unwrap(), expected);
        let short =
            ";FFMETADATA1\ntitle=Film\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=5500\nEND=9000\n[STREAM]\ntitle=x\n";
        assert_eq!(parse(short).unwrap(), [chapter(5.5, "")]);
        assert!(ffmetadata(&expected, 4000.0).contains("START=90000000\nEND=3750500000\n"));
    }

    #[test]
    fn lines_that_say_no_chapter_are_named() {
        for (text, words) in [
            ("0:00 A\nlake", "line 2: `lake`"),
            ("0:00", "line 1"),
            ("1:60 A", "line 1"),
            ("-5 A", "line 1"),
            ("1:2:3:4 A", "line 1"),
            ("nan A", "line 1"),
            ("1e3 A", "line 1"),
            ("0:10 A\n\n0:05 B", "line 3: chapter `B` begins no later"),
            (";FFMETADATA1\n[CHAPTER]\ntitle=A", "line 2: the chapter has no START"),
            (";FFMETADATA1\n[CHAPTER]\nTIMEBASE=1/0", "line 3"),
            (";FFMETADATA1\n[CHAPTER]\nSTART=x", "line 3"),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}
