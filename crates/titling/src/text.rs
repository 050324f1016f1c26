//! Text as outlines: direction, script, font, line breaks, shaping.
//!
//! ```text
//! text ──lines──▶ breaks that fit ──bidirectional runs──▶ runs of one script and font ──shaped──▶ glyphs ──▶ one outline
//! ```
//!
//! Directions are those of Unicode's bidirectional algorithm (UAX 9), breaks those of its line breaking (UAX 14).

use std::ops::Range;

use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder};
use rustybuzz::{Direction, Face, UnicodeBuffer};
use tiny_skia::{Path, PathBuilder, Transform};
use unicode_bidi::{BidiInfo, ParagraphInfo};
use unicode_script::{Script, UnicodeScript};

/// Height of a line, in sizes of the letters.
pub const LEADING: f32 = 1.3;

/// Place of lines that are shorter than the longest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Left ends below each other.
    Left,
    /// Middles below each other.
    Middle,
}

/// Size and place of letters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextStyle {
    /// Size of the letters, pixels an em.
    pub size: f32,
    /// Place of shorter lines.
    pub align: Align,
    /// Greatest width of a line, pixels.
    pub width: f32,
    /// Most lines; behind them the text is cut off with an ellipsis.
    pub most_lines: usize,
}

impl TextStyle {
    /// One line at the left, however long.
    pub fn line(size: f32) -> Self {
        Self { size, align: Align::Left, width: f32::INFINITY, most_lines: usize::MAX }
    }
}

/// Text that is set, its upper left corner at 0,0.
#[derive(Debug, Clone)]
pub struct TextBlock {
    /// Width and height, pixels.
    pub extent: [f32; 2],
    /// Size of its letters, pixels an em.
    pub size: f32,
    /// Outline of all letters; `None`: it has none.
    pub outline: Option<Path>,
    /// Whether it ends before the text does.
    pub is_cut: bool,
}

/// Sets text in the faces of some fonts.
pub struct Typesetter<'f> {
    faces: Vec<Face<'f>>,
}

/// A line that is set, its upper left corner at 0,0.
struct SetLine {
    outline: Option<Path>,
    /// Width, pixels.
    width: f32,
}

/// Part of a line of one font, script and direction.
struct Run {
    range: Range<usize>,
    face: usize,
    script: Script,
}

/// Outline of a glyph, moved to its place while it is read.
struct Glyph<'b> {
    builder: &'b mut PathBuilder,
    scale: f32,
    left: f32,
    base: f32,
}

impl Glyph<'_> {
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        [self.left + x * self.scale, self.base - y * self.scale]
    }
}

impl OutlineBuilder for Glyph<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.place(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.place(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ([x1, y1], [x, y]) = (self.place(x1, y1), self.place(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ([x1, y1], [x2, y2], [x, y]) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}

impl<'f> Typesetter<'f> {
    /// Takes faces, the first of which has the letters' measures.
    pub fn new(faces: Vec<Face<'f>>) -> Self {
        Self { faces }
    }

    /// Sets a text; line ends in it begin new lines.
    pub fn set(&self, text: &str, style: &TextStyle) -> TextBlock {
        let mut builder = PathBuilder::new();
        let mut lines: Vec<SetLine> = Vec::new();
        let bidi = BidiInfo::new(text, None);
        let mut is_cut = false;
        'text: for paragraph in &bidi.paragraphs {
            for line in self.lines(&bidi, paragraph, style) {
                if lines.len() == style.most_lines {
                    self.cut(&mut lines, style.size);
                    is_cut = true;
                    break 'text;
                }
                let width = self.line(&bidi, paragraph, line, style.size, &mut builder);
                lines.push(SetLine { outline: std::mem::take(&mut builder).finish(), width });
            }
        }

        let widest = lines.iter().map(|line| line.width).fold(0.0, f32::max);
        let tall = LEADING * style.size;
        for (index, SetLine { outline, width }) in lines.iter().enumerate() {
            let across = match style.align {
                Align::Left => 0.0,
                Align::Middle => 0.5 * (widest - width),
            };
            let down = tall * index as f32;
            if let Some(outline) =
                outline.clone().and_then(|path| path.transform(Transform::from_translate(across, down)))
            {
                builder.push_path(&outline);
            }
        }
        let extent = [widest, tall * lines.len() as f32];
        TextBlock { extent, size: style.size, outline: builder.finish(), is_cut }
    }

    /// Ends the last line with an ellipsis.
    fn cut(&self, lines: &mut [SetLine], size: f32) {
        let Some(SetLine { outline, width }) = lines.last_mut() else { return };
        let ellipsis = self.set("…", &TextStyle::line(size));
        let mut builder = PathBuilder::new();
        let moved = ellipsis.outline.and_then(|path| path.transform(Transform::from_translate(*width, 0.0)));
        for path in [outline.take(), moved].into_iter().flatten() {
            builder.push_path(&path);
        }
        *outline = builder.finish();
        *width += ellipsis.extent[0];
    }

    /// Returns the width of a line, pixels.
    pub fn width(&self, text: &str, size: f32) -> f32 {
        self.set(text, &TextStyle::line(size)).extent[0]
    }

    /// Breaks a paragraph into lines that are no wider than they may be, where a break is allowed.
    fn lines(&self, bidi: &BidiInfo<'_>, paragraph: &ParagraphInfo, style: &TextStyle) -> Vec<Range<usize>> {
        let text = &bidi.text[paragraph.range.clone()];
        let first = paragraph.range.start;
        let width_of = |range: Range<usize>| {
            let end = first + text[..range.end - first].trim_end().len();
            self.line(bidi, paragraph, range.start..end.max(range.start), style.size, &mut PathBuilder::new())
        };
        let (mut lines, mut start, mut fits) = (Vec::new(), first, first);

        for (at, _) in unicode_linebreak::linebreaks(text) {
            let at = first + at;
            if fits > start && width_of(start..at) > style.width {
                lines.push(start..fits);
                start = fits;
            }

            // A word that is wider than a line is broken between any two letters.
            while width_of(start..at) > style.width {
                let ends = text[start - first..at - first].char_indices().skip(1).map(|(end, _)| start + end);
                let ends: Vec<usize> = ends.collect();
                let room = ends.partition_point(|end| width_of(start..*end) <= style.width);
                let Some(end) = ends.get(room.max(1) - 1) else { break };
                lines.push(start..*end);
                start = *end;
            }
            fits = at;
        }
        lines.push(start..paragraph.range.end);

        // Neither a line end nor a space at the end of a line has a width.
        let trimmed = |line: Range<usize>| line.start..line.start + bidi.text[line].trim_end().len();
        lines.into_iter().map(trimmed).collect()
    }

    /// Adds a line's glyphs to an outline, the upper left corner of the line at 0,0, and returns its width.
    fn line(
        &self,
        bidi: &BidiInfo<'_>,
        paragraph: &ParagraphInfo,
        line: Range<usize>,
        size: f32,
        builder: &mut PathBuilder,
    ) -> f32 {
        if line.is_empty() {
            return 0.0;
        }
        let (levels, visual) = bidi.visual_runs(paragraph, line);
        let base = self.ascent(size);
        let mut left = 0.0;
        for range in visual {
            let is_backward = levels[range.start].is_rtl();
            let mut runs = self.runs(bidi.text, range);
            if is_backward {
                runs.reverse();
            }
            for run in runs {
                left = self.shape(bidi.text, &run, is_backward, [left, base, size], builder);
            }
        }
        left
    }

    /// Splits a part of a text by scripts and fonts.
    fn runs(&self, text: &str, range: Range<usize>) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (at, letter) in text[range.clone()].char_indices() {
            let start = range.start + at;
            let end = start + letter.len_utf8();
            let script = letter.script();
            let is_shared = matches!(script, Script::Common | Script::Inherited);
            let face = self.faces.iter().position(|face| face.glyph_index(letter).is_some());

            if let Some(run) = runs.last_mut() {
                let has_letter = self.faces[run.face].glyph_index(letter).is_some() || face.is_none();
                let is_same = is_shared
                    || run.script == script
                    || matches!(run.script, Script::Common | Script::Inherited);
                if has_letter && is_same {
                    run.script = if is_shared { run.script } else { script };
                    run.range.end = end;
                    continue;
                }
            }
            runs.push(Run { range: start..end, face: face.unwrap_or(0), script });
        }
        runs
    }

    /// Adds a run's glyphs from a place on, left and base, at a size, and returns where the next run begins.
    fn shape(
        &self,
        text: &str,
        run: &Run,
        is_backward: bool,
        [mut left, base, size]: [f32; 3],
        builder: &mut PathBuilder,
    ) -> f32 {
        let face = &self.faces[run.face];
        let scale = size / face.units_per_em() as f32;
        let mut buffer = UnicodeBuffer::new();
        buffer.push_str(&text[run.range.clone()]);
        buffer.guess_segment_properties();
        buffer.set_direction(if is_backward { Direction::RightToLeft } else { Direction::LeftToRight });
        let shaped = rustybuzz::shape(face, &[], buffer);

        for (glyph, place) in shaped.glyph_infos().iter().zip(shaped.glyph_positions()) {
            let id = GlyphId(u16::try_from(glyph.glyph_id).unwrap_or_default());
            let mut outline = Glyph {
                builder,
                scale,
                left: left + place.x_offset as f32 * scale,
                base: base - place.y_offset as f32 * scale,
            };
            face.outline_glyph(id, &mut outline);
            left += place.x_advance as f32 * scale;
        }
        left
    }

    /// Returns how far below a line's upper edge letters stand, pixels, so that they are in its middle.
    fn ascent(&self, size: f32) -> f32 {
        let Some(face) = self.faces.first() else { return size };
        let scale = size / face.units_per_em() as f32;
        let (up, down) = (f32::from(face.ascender()) * scale, -f32::from(face.descender()) * scale);
        0.5 * (LEADING * size - up - down) + up
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fonts::Fonts;

    /// Sets a text 40 pixels an em.
    fn set(text: &str, width: f32) -> TextBlock {
        let fonts = Fonts::read([]).unwrap();
        Typesetter::new(fonts.faces()).set(text, &TextStyle { width, ..TextStyle::line(40.0) })
    }

    #[test]
    fn digits_are_all_as_wide() {
        let widths: Vec<f32> =
            (0..10).map(|digit| set(&digit.to_string().repeat(5), 1e6).extent[0]).collect();
        assert!(widths.iter().all(|width| *width == widths[0] && *width > 100.0), "{widths:?}");
    }

    #[test]
    fn lines_break_where_they_may_and_are_no_wider_than_said() {
        let text = "a caption that goes on and on until it has no room any more";
        let whole = set(text, 1e6);
        assert_eq!(whole.extent[1], LEADING * 40.0);
        for width in [200.0, 333.0, 600.0] {
            let broken = set(text, width);
            assert!(broken.extent[0] <= width && broken.extent[1] > whole.extent[1], "{width}");
        }
        // A word that is longer than a line is broken, and each letter has a line where there is room for none.
        let word = set("Donaudampfschifffahrt", 150.0);
        assert!(word.extent[0] <= 150.0 && word.extent[1] > 2.0 * LEADING * 40.0, "{:?}", word.extent);
        assert_eq!(set("abc", 1.0).extent[1], 3.0 * LEADING * 40.0);
        assert_eq!(set("a\n\nb", 1e6).extent[1], 3.0 * LEADING * 40.0);
    }

    #[test]
    fn letters_join_as_their_script_asks() {
        // Lam and alef make one glyph, unless something keeps them from joining.
        let [joined, apart] = ["لا", "ل\u{200C}ا"].map(|text| set(text, 1e6).extent[0]);
        assert!(joined < 0.9 * apart, "{joined} {apart}");
        // A mark stands on its letter.
        let [marked, plain] = ["e\u{301}", "e"].map(|text| set(text, 1e6).extent[0]);
        assert!((marked - plain).abs() < 0.01 * plain, "{marked} {plain}");
    }

    #[test]
    fn scripts_run_in_their_direction() {
        // A full stop behind Hebrew letters lies at their left, and digits among them run to the right.
        let left_of = |text: &str| set(text, 1e6).outline.unwrap().bounds();
        let (plain, stopped) = (left_of("אבג"), set("\u{200F}אבג.", 1e6));
        let first_column = stopped.outline.unwrap();
        let low = first_column.points().iter().filter(|point| point.x < 8.0);
        assert!(
            low.clone().count() > 0
                && low.clone().all(|point| point.y > 0.5 * (plain.top() + plain.bottom())),
            "no stop at the left"
        );
        let [mixed, parts] =
            [set("א 12", 1e6).extent[0], set("א ", 1e6).extent[0] + set("12", 1e6).extent[0]];
        assert!((mixed - parts).abs() < 15.0, "{mixed} {parts}");
    }

    #[test]
    fn outlines_stay_within_their_blocks() {
        for text in ["Ägj", "fly", "1 243 m"] {
            let block = set(text, 1e6);
            let bounds = block.outline.unwrap().bounds();
            assert!(bounds.top() >= 0.0 && bounds.bottom() <= block.extent[1], "{text} {bounds:?}");
            assert!(bounds.left() >= -3.0 && bounds.right() <= block.extent[0] + 3.0, "{text} {bounds:?}");
        }
        assert!(set("", 1e6).outline.is_none() && set("  ", 1e6).outline.is_none());
    }
}
