//! Spans as they lie in files.

use std::ops::Range;

use super::{Facade, Span};

/// A span without its façade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(super) struct StoredSpan([u16; 10]);

/// Words of a span and of its façade.
type Words = [u16; size_of::<Span>() / 2];
const OWN: usize = size_of::<StoredSpan>() / 2;
const _: () = assert!(size_of::<Span>() == size_of::<StoredSpan>() + size_of::<Facade>());

impl StoredSpan {
    pub fn of(span: &Span) -> Self {
        let words: Words = bytemuck::cast(*span);
        Self(std::array::from_fn(|index| words[index]))
    }

    /// The span with its façade.
    #[inline]
    pub fn with(self, facade: Facade) -> Span {
        let facade: [u16; size_of::<Facade>() / 2] = bytemuck::cast(facade);
        let mut words: Words = [0; size_of::<Span>() / 2];
        words[..OWN].copy_from_slice(&self.0);
        words[OWN..].copy_from_slice(&facade);
        bytemuck::cast(words)
    }
}

/// A run of spans where they lie.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StoredSpans<'a> {
    spans: &'a [StoredSpan],
    /// Façades of these; empty: they have none.
    facades: &'a [Facade],
}

impl<'a> StoredSpans<'a> {
    pub(super) fn new(spans: &'a [StoredSpan], facades: &'a [Facade]) -> Self {
        Self { spans, facades }
    }

    /// No spans.
    pub const NONE: Self = Self { spans: &[], facades: &[] };

    /// Copies the spans without façades.
    pub(super) fn own(self) -> Vec<StoredSpan> {
        self.spans.to_vec()
    }

    /// Copies the façades: none, or one for each span.
    pub(super) fn facades(self) -> Vec<Facade> {
        self.facades.to_vec()
    }

    /// Counts the spans.
    #[inline]
    pub fn len(self) -> usize {
        self.spans.len()
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.spans.is_empty()
    }

    /// Iterates over the spans.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = Span> + Clone + 'a {
        let facades = self.facades.iter().copied().chain(std::iter::repeat(Facade::NONE));
        self.spans.iter().zip(facades).map(|(span, facade)| span.with(facade))
    }

    /// Returns the spans with numbers in a range; `None` if there are fewer.
    #[inline]
    pub(super) fn get(self, range: Range<usize>) -> Option<Self> {
        let spans = self.spans.get(range.clone())?;
        Some(Self { spans, facades: self.facades.get(range).unwrap_or_default() })
    }
}
