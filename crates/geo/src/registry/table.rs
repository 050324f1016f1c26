//! A table of tab-separated lines in the order of their codes.

use std::sync::OnceLock;

/// A table; lines that begin with `#` say where it comes from.
pub(super) struct Table {
    text: &'static str,
    /// Codes and lines, in rising order; made when the first code is looked for.
    index: OnceLock<Vec<Row>>,
}

/// A line of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    code: u32,
    is_esri: bool,
    line: &'static str,
}

impl Table {
    pub(super) const fn new(text: &'static str) -> Self {
        Self { text, index: OnceLock::new() }
    }

    /// Finds the line of a code.
    pub(super) fn find(&self, code: u32) -> Option<Row> {
        let rows = self.index();
        rows.binary_search_by_key(&code, |row| row.code).ok().map(|index| rows[index])
    }

    /// All lines.
    pub(super) fn rows(&self) -> impl Iterator<Item = Row> {
        self.index().iter().copied()
    }

    fn index(&self) -> &[Row] {
        self.index.get_or_init(|| {
            let mut rows: Vec<Row> = self.text.lines().filter_map(Row::read).collect();
            rows.sort_by_key(|row| row.code);
            rows
        })
    }
}

impl Row {
    fn read(line: &'static str) -> Option<Self> {
        let text = line.split('\t').next()?;
        let code = text.strip_suffix('e');
        Some(Self { code: code.unwrap_or(text).parse().ok()?, is_esri: code.is_some(), line })
    }

    pub(super) fn code(self) -> u32 {
        self.code
    }

    pub(super) fn is_esri(self) -> bool {
        self.is_esri
    }

    /// A field, counted from 0; empty beyond the last one.
    pub(super) fn field(self, index: usize) -> &'static str {
        self.line.split('\t').nth(index).unwrap_or_default()
    }

    pub(super) fn number(self, index: usize) -> Option<f64> {
        self.field(index).parse().ok()
    }
}
