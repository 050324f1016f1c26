//! Words of a text file and where they begin, read through a buffer, however long the file is.

use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use crate::raster::decimal::decimal;
use crate::raster::file::InputFile;
use hedgehop_base::error::{Error, Result};

/// No number is longer.
const LONGEST_TOKEN: usize = 64;
const BUFFER: usize = 1 << 18;

/// A word and where it begins.
#[derive(Debug, Default)]
pub(super) struct Token {
    pub text: String,
    /// Byte at which it begins.
    pub at: u64,
}

/// Words between white space.
pub(super) struct Tokens<'a> {
    /// The file, for messages.
    pub path: &'a Path,
    /// Length of the file, bytes.
    pub length: u64,
    reader: BufReader<std::fs::File>,
    /// Byte that the reader stands at.
    position: u64,
}

impl<'a> Tokens<'a> {
    /// Reads words from byte `begin` on.
    pub fn new(file: &'a InputFile, begin: u64) -> Result<Self> {
        let mut reader = BufReader::with_capacity(BUFFER, file.reopen()?);
        reader.seek(SeekFrom::Start(begin)).map_err(|e| Error::io(file.path(), "seek in", e))?;
        Ok(Self { path: file.path(), length: file.length(), reader, position: begin })
    }

    /// Replaces `token` by the next word; false at the end of the file.
    pub fn next(&mut self, token: &mut Token) -> Result<bool> {
        token.text.clear();
        loop {
            let buffer = self.reader.fill_buf().map_err(|e| Error::io(self.path, "read", e))?;
            if buffer.is_empty() {
                return Ok(!token.text.is_empty());
            }

            let mut used = 0;
            if token.text.is_empty() {
                used = buffer.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
                token.at = self.position + used as u64;
            }

            let word = buffer[used..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            let complete = used + word < buffer.len() && word + token.text.len() > 0;
            let text = std::str::from_utf8(&buffer[used..used + word.min(LONGEST_TOKEN + 1)]);
            match text {
                Ok(text) if text.len() + token.text.len() <= LONGEST_TOKEN => token.text.push_str(text),
                _ => {
                    let what =
                        format!("holds something that is no number at byte {}; it is damaged", token.at);
                    return Err(Error::invalid(self.path, what));
                }
            }

            self.reader.consume(used + word);
            self.position += (used + word) as u64;
            if complete {
                return Ok(true);
            }
        }
    }

    /// Returns the next word.
    ///
    /// # Errors
    /// The end of the file.
    pub fn expect(&mut self) -> Result<Token> {
        let mut token = Token::default();
        if self.next(&mut token)? {
            Ok(token)
        } else {
            Err(Error::invalid(self.path, "ends too early; it is cut short, fetch it again"))
        }
    }

    /// A number, with a point or a comma.
    pub fn number(&self, token: &Token) -> Result<f64> {
        decimal(&token.text).map_err(|_| {
            let what =
                format!("holds {:?} at byte {}, which is no number; it is damaged", token.text, token.at);
            Error::invalid(self.path, what)
        })
    }
}
