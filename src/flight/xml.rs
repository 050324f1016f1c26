//! A thin walk over XML: elements open and close, leaves carry text, everything knows its line.
//!
//! GPX and KML are read with it instead of with the `gpx` and `kml` crates: those tell no lines, `gpx` 0.10 refuses a
//! file for one element that it does not know, and `kml` 0.15 panics on an empty `<Point>` and recurses without limit.
//! This walk keeps no tree and no recursion, so that neither depth nor size of a file can hurt.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::raw::PathSource;
use hedgehop_base::error::Result;

/// An element opens or closes.
#[derive(Debug)]
pub(super) enum XmlStep<'a> {
    /// Attributes are looked up with [`attribute`].
    Open(&'a BytesStart<'a>),
    /// Text since the last tag, trimmed: the content, if the element is a leaf.
    Close(&'a str),
}

/// Position of a walk through a document.
#[derive(Debug, Clone, Copy)]
pub(super) struct XmlPlace<'a> {
    /// Name of the element, without prefix.
    pub name: &'a str,
    /// Line where its tag begins, from 1.
    pub line: u64,
    /// Elements around it: 0 for the root.
    pub depth: usize,
}

/// Calls `visit` for every element of `text`, in order.
pub(super) fn walk(
    source: &PathSource<'_>,
    text: &str,
    mut visit: impl FnMut(XmlPlace<'_>, XmlStep<'_>) -> Result<()>,
) -> Result<()> {
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    let mut lines = LineCounter { text: text.as_bytes(), position: 0, line: 1 };
    let mut depth = 0_usize;
    let mut content = String::new();

    loop {
        let line = lines.at(reader.buffer_position());
        let event = reader.read_event().map_err(|error| {
            let line = lines.at(reader.error_position());
            // Names of damaged elements may hold line ends.
            let error = error.to_string().replace(char::is_control, " ");
            source.at_line(line, format!("the XML is damaged ({error}); export the file again"))
        })?;

        match event {
            Event::Start(start) => {
                content.clear();
                let local = start.local_name();
                let name = String::from_utf8_lossy(local.as_ref());
                visit(XmlPlace { name: &name, line, depth }, XmlStep::Open(&start))?;
                depth += 1;
            }
            Event::End(end) => {
                depth = depth.saturating_sub(1);
                let local = end.local_name();
                let name = String::from_utf8_lossy(local.as_ref());
                visit(XmlPlace { name: &name, line, depth }, XmlStep::Close(content.trim()))?;
                content.clear();
            }
            Event::Text(piece) => content.push_str(&String::from_utf8_lossy(&piece)),
            Event::CData(piece) => content.push_str(&String::from_utf8_lossy(&piece)),
            Event::Eof if depth > 0 => {
                return Err(
                    source.at_line(line, "the file ends within an element; it was cut off, copy it again")
                );
            }
            Event::Eof => return Ok(()),
            _ => {}
        }
    }
}

/// The value of an attribute, if it is there and sound.
pub(super) fn attribute(start: &BytesStart<'_>, name: &str) -> Option<String> {
    let attribute = start.try_get_attribute(name).ok()??;
    Some(String::from_utf8_lossy(&attribute.value).into_owned())
}

/// Lines of growing byte positions, each byte looked at once.
struct LineCounter<'a> {
    text: &'a [u8],
    position: usize,
    line: u64,
}

impl LineCounter<'_> {
    fn at(&mut self, position: u64) -> u64 {
        let position = usize::try_from(position).unwrap_or(usize::MAX).min(self.text.len());
        if let Some(passed) = self.text.get(self.position..position) {
            self.line += passed.iter().filter(|&&byte| byte == b'\n').count() as u64;
            self.position = position;
        }
        self.line
    }
}
