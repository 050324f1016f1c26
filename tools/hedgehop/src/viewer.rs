//! A page that shows two runs over each other: one file of HTML with all pictures in it, which needs nothing else.

use serde_json::{Value, json};

use hedgehop::{Error, Result};

/// Bytes of the pictures of the largest page.
const MOST_BYTES: usize = 256 << 20;

/// The page's beginning, up to its data.
const BEGIN: &str = include_str!("viewer.html");

/// Mark in the page that the data replace.
const DATA: &str = "/*PAIRS*/";

/// Pairs of pictures for a page.
#[derive(Debug)]
pub struct Viewer {
    /// Names of both runs.
    names: [String; 2],
    pairs: Vec<Value>,
    bytes: usize,
}

impl Viewer {
    /// Without pairs yet, of two runs.
    pub fn of(names: [String; 2]) -> Self {
        Self { names, pairs: Vec::new(), bytes: 0 }
    }

    /// Adds a pair, as PNG, with its figures.
    ///
    /// # Errors
    /// The page would be too large.
    pub fn add(&mut self, [a, b]: [&[u8]; 2], figures: Value) -> Result<()> {
        self.bytes += a.len() + b.len();
        if self.bytes > MOST_BYTES {
            return Err(Error::Configuration(format!(
                "--html would hold more than {} MiB of pictures; compare fewer frames, or leave it out",
                MOST_BYTES >> 20
            )));
        }
        self.pairs.push(json!({ "figures": figures, "a": base64(a), "b": base64(b) }));
        Ok(())
    }

    /// The page.
    pub fn page(&self) -> String {
        // Within a script `</` would end it.
        let data = json!({ "names": self.names, "pairs": self.pairs }).to_string().replace("</", "<\\/");
        BEGIN.replacen(DATA, &data, 1)
    }
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |index: usize| u32::from(group.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let is_there = digit <= group.len();
            text.push(if is_there {
                char::from(DIGITS[(bits >> (18 - 6 * digit) & 63) as usize])
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg==")];
        for (bytes, text) in cases {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn a_page_needs_nothing_else_and_names_cannot_leave_their_place() {
        let mut viewer = Viewer::of(["before/".to_owned(), "</script>".to_owned()]);
        viewer.add([b"foo", b"fo"], json!({ "name": "</script><b>" })).unwrap();
        let page = viewer.page();
        assert!(page.contains("\"names\":[\"before/\",\"<\\/script>\"]"));
        assert!(page.contains("\"a\":\"Zm9v\"") && page.contains("\"b\":\"Zm8=\""));
        assert_eq!(page.matches("</script>").count(), 1);
        assert!(!page.contains("http:") && !page.contains("https:") && !page.contains(DATA));
    }
}
