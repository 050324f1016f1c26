//! Fonts: the program's own, and files that a user names.

use std::borrow::Cow;
use std::path::Path;

use rustybuzz::Face;
use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder};

use hedgehop_base::error::{Error, Result};

/// Fonts of the program: Noto Sans for Latin, Greek and Cyrillic letters, DejaVu Sans for Hebrew, Arabic, Armenian, Georgian and other ones, and for
/// symbols. Both may be passed on freely.
const OWN: [&[u8]; 2] = [
    include_bytes!("../../../data/fonts/NotoSans-Regular.ttf"),
    include_bytes!("../../../data/fonts/DejaVuSans.ttf"),
];

/// Largest file of a font, bytes; fonts of all Chinese characters have some 20 million.
const MOST_BYTES: u64 = 200_000_000;

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
            let io = |source| Error::io(path, "read", source);
            if std::fs::metadata(path).map_err(io)?.len() > MOST_BYTES {
                return Err(Error::invalid(
                    path,
                    "is larger than any font; name a TrueType or OpenType file, .ttf or .otf",
                ));
            }
            let bytes = std::fs::read(path).map_err(io)?;
            let is_font = Face::from_slice(&bytes, 0).is_some_and(|face| face.number_of_glyphs() > 1);
            if !is_font {
                return Err(Error::invalid(
                    path,
                    "is no font that can be read; name a TrueType or OpenType file, .ttf, .otf or .ttc",
                ));
            }
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
                    "no font has the letter '{letter}' (U+{code:04X}) of {text:?}; name one that has it with --font FILE.ttf"
                )));
            };
            if face.outline_glyph(*glyph, &mut Strokes::default()).is_none()
                && face.is_drawn_otherwise(*glyph)
            {
                return Err(Error::Configuration(format!(
                    "the font has '{letter}' (U+{code:04X}) of {text:?} as a picture, and only outlines are drawn; leave it out, or name another --font"
                )));
            }
        }
        Ok(())
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
        assert!(Fonts::read([Path::new("/nowhere/x.ttf")]).unwrap_err().to_string().contains("cannot read"));
    }
}
