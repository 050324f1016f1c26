//! Fonts: the program's own, and files that a user names.

use std::borrow::Cow;
use std::path::Path;

use rustybuzz::Face;
use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder};

use hedgehop::scene::MOST_FONT_BYTES;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::read_whole_file;

/// Fonts of the program: Noto Sans for Latin, Greek and Cyrillic letters, DejaVu Sans for Hebrew, Arabic, Armenian, Georgian and other ones, and for
/// symbols. Both may be passed on freely.
const OWN: [&[u8]; 2] = [
    include_bytes!("../../../data/fonts/NotoSans-Regular.ttf"),
    include_bytes!("../../../data/fonts/DejaVuSans.ttf"),
];

/// Files of fonts, the first of which has the letters' measures.
#[derive(Debug)]
pub struct Fonts {
    files: Vec<Cow<'static, [u8]>>,
}

/// Outline that tells whether a glyph has any.
#[derive(Default)]
struct Strokes(usize);

impl OutlineBuilder for Strokes {
    fn move_to(&mut self, _: f32, _: f32) {
        self.0 += 1;
    }

    fn line_to(&mut self, _: f32, _: f32) {}

    fn quad_to(&mut self, _: f32, _: f32, _: f32, _: f32) {}

    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, _: f32, _: f32) {}

    fn close(&mut self) {}
}

impl Fonts {
    /// Reads the fonts that a user names, which serve for letters that the program's own has not.
    ///
    /// # Errors
    /// [`Error::Io`], or [`Error::Invalid`] of a file that is no font.
    pub fn read<'p>(paths: impl IntoIterator<Item = &'p Path>) -> Result<Self> {
        let mut files: Vec<Cow<'static, [u8]>> = OWN.iter().map(|file| Cow::Borrowed(*file)).collect();
        for path in paths {
            let bytes = read_whole_file(path, MOST_FONT_BYTES)?;
            let is_font = Face::from_slice(&bytes, 0).is_some_and(|face| face.number_of_glyphs() > 1);
            if !is_font {
                return Err(Error::invalid(
                    path,
                    "is no font that can be read; name a TrueType or OpenType file, .ttf, .otf or .ttc",
                ));
            }
            check_tables(&bytes).map_err(|what| Error::invalid(path, what))?;
            files.push(Cow::Owned(bytes));
        }
        Ok(Self { files })
    }

    /// Returns the faces, ready to be shaped with.
    pub fn faces(&self) -> Vec<Face<'_>> {
        self.files.iter().filter_map(|bytes| Face::from_slice(bytes, 0)).collect()
    }

    /// Refuses letters that no font can draw.
    ///
    /// # Errors
    /// [`Error::Configuration`], which names the first such letter.
    pub fn check(&self, text: &str) -> Result<()> {
        let faces = self.faces();
        for letter in text.chars().filter(|letter| needs_glyph(*letter)) {
            let glyphs: Vec<(&Face<'_>, GlyphId)> =
                faces.iter().filter_map(|face| Some((face, face.glyph_index(letter)?))).collect();
            let code = u32::from(letter);
            let Some((face, glyph)) = glyphs.first() else {
                return Err(Error::Configuration(format!(
                    "no font has the letter '{letter}' (U+{code:04X}) of {}; name one that has it with --font FILE.ttf",
                    quoted(text)
                )));
            };
            if face.outline_glyph(*glyph, &mut Strokes::default()).is_none()
                && face.is_drawn_otherwise(*glyph)
            {
                return Err(Error::Configuration(format!(
                    "the font has '{letter}' (U+{code:04X}) of {} as a picture, and only outlines are drawn; leave it out, or name another --font",
                    quoted(text)
                )));
            }
        }
        Ok(())
    }
}

/// Returns the beginning of a text between quotation marks, on one line.
pub fn quoted(text: &str) -> String {
    const SHOWN: usize = 40;
    let line = text.replace('\n', " ");
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("\"{}…\"", &line[..end]),
        None => format!("\"{line}\""),
    }
}

/// Ways besides outlines that a glyph is drawn in.
trait DrawnOtherwise {
    /// Whether a glyph is a bitmap, a vector picture, or layers of colour.
    fn is_drawn_otherwise(&self, glyph: GlyphId) -> bool;
}

impl DrawnOtherwise for Face<'_> {
    fn is_drawn_otherwise(&self, glyph: GlyphId) -> bool {
        self.is_color_glyph(glyph)
            || self.glyph_raster_image(glyph, u16::MAX).is_some()
            || self.glyph_svg_image(glyph).is_some()
    }
}

/// Checks that a font's tables lie in its file and have the checksums that its directory tells (OpenType 1.9, Organization of an OpenType
/// Font).
///
/// # Errors
/// A clause that names the table.
fn check_tables(bytes: &[u8]) -> std::result::Result<(), String> {
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|word| u32::from_be_bytes([word[0], word[1], word[2], word[3]]))
    };
    let damaged = || "its directory of tables is damaged; take another copy of the font".to_owned();
    // A collection (.ttc) holds several fonts, of which the first is read.
    let start = if bytes.starts_with(b"ttcf") { word(12).ok_or_else(damaged)? as usize } else { 0 };
    let count = word(start + 4).ok_or_else(damaged)? >> 16;

    for record in (0..count as usize).map(|index| start + 12 + 16 * index) {
        let fields = [word(record + 4), word(record + 8), word(record + 12)];
        let [Some(told), Some(offset), Some(length)] = fields else { return Err(damaged()) };
        let tag = String::from_utf8_lossy(&bytes[record..record + 4]).into_owned();
        let (offset, length) = (offset as usize, length as usize);
        let Some(table) = bytes.get(offset..offset.saturating_add(length)) else {
            return Err(format!(
                "its table {tag:?} reaches beyond the end of the file; take another copy of the font"
            ));
        };

        let mut sum = 0_u32;
        for chunk in table.chunks(4) {
            let mut word = [0; 4];
            word[..chunk.len()].copy_from_slice(chunk);
            sum = sum.wrapping_add(u32::from_be_bytes(word));
        }
        // The table `head` holds a sum over the file, which its own leaves out.
        let adjustment = if tag == "head" { word(offset + 8).unwrap_or_default() } else { 0 };
        if sum.wrapping_sub(adjustment) != told {
            return Err(format!(
                "its table {tag:?} is damaged: the checksum differs; take another copy of the font"
            ));
        }
    }
    Ok(())
}

/// Whether a letter is to be seen: neither space nor what only steers how others are set.
fn needs_glyph(letter: char) -> bool {
    let steers = matches!(letter, '\u{200B}'..='\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2060}'..='\u{2069}' | '\u{FE00}'..='\u{FE0F}' | '\u{AD}' | '\u{FEFF}');
    !letter.is_whitespace() && !letter.is_control() && !steers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_without_a_glyph_are_named() {
        let fonts = Fonts::read([]).unwrap();
        for text in [
            "Über den Höhen",
            "Лес",
            "Ελλάδα",
            "הרים",
            "جبال",
            "მთები",
            "1 243 m · 47° N — “x”",
            "Soft\u{AD}hyphen\n",
        ] {
            assert!(fonts.check(text).is_ok(), "{text}");
        }
        for (text, code) in [("山", "U+5C71"), ("नमस्ते", "U+0928"), ("\u{10FFFF}", "U+10FFFF")]
        {
            let said = fonts.check(text).unwrap_err().to_string();
            assert!(said.contains(code) && said.contains("--font"), "{said}");
        }
    }

    #[test]
    fn files_that_are_no_fonts_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("not.ttf");
        for bytes in [&b""[..], b"\0\x01\0\0", b"wOF2 and more", &OWN[0][..200]] {
            std::fs::write(&path, bytes).unwrap();
            let said = Fonts::read([path.as_path()]).unwrap_err().to_string();
            assert!(said.contains("no font that can be read"), "{said}");
        }
        // A wrong byte anywhere, and a missing end.
        for at in [13_000, 200_000, 400_000] {
            let mut bytes = OWN[0].to_vec();
            bytes[at] ^= 0x55;
            std::fs::write(&path, &bytes).unwrap();
            let said = Fonts::read([path.as_path()]).unwrap_err().to_string();
            assert!(said.contains("is damaged"), "{said}");
        }
        std::fs::write(&path, &OWN[1][..700_000]).unwrap();
        assert!(Fonts::read([path.as_path()]).unwrap_err().to_string().contains("beyond the end"));
        std::fs::write(&path, OWN[1]).unwrap();
        assert!(Fonts::read([path.as_path()]).is_ok());
        assert!(Fonts::read([folder.path()]).unwrap_err().to_string().contains("is a folder"));
        assert!(Fonts::read([Path::new("/nowhere/x.ttf")]).unwrap_err().to_string().contains("cannot read"));
    }
}
