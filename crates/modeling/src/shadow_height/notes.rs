//! Notes on rows without a height.

use std::collections::BTreeMap;

use super::super::features::Layer;
use super::answer::Answer;
use super::site::Reason;

/// Rows that are named for one reason.
const MOST_NAMED: usize = 12;
/// Reasons that are told apart.
const MOST_REASONS: usize = 30;

impl Reason {
    /// Returns the reason in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::OutOfPicture => "the ground behind it is not in the picture",
            Self::LeavesPicture => {
                "no end of a shadow is seen, and a part of the ground behind it is not in the picture"
            }
            Self::Hidden => "other buildings hide or shade the ground behind it",
            Self::NoShadow => "no shadow is seen",
            Self::Ragged => "the end of its shadow is not seen along all of it",
            Self::Short => "too few pixels are seen of its shadow, or of the ground behind that",
            Self::TooLarge => "the rasters have too many pixels under it and its longest shadow",
            Self::Pale => "what is seen is much paler than the other shadows",
        }
    }
}

/// One sentence for each reason, with the rows.
pub(super) fn notes(file: &str, layer: &Layer, answers: &[Answer]) -> Vec<String> {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (row, answer) in layer.rows.iter().zip(answers) {
        if let Answer::Nothing(reason) = answer {
            let known = reasons.len() < MOST_REASONS || reasons.contains_key(reason.as_str());
            reasons.entry(if known { reason } else { "other reasons" }).or_default().push(&row.place);
        }
    }
    let sentence = |(reason, places): (&str, Vec<&str>)| {
        let named = places.iter().take(MOST_NAMED).copied().collect::<Vec<_>>().join(", ");
        match places.len() {
            1 => format!("{file}: {named} is left without a height: {reason}"),
            count if count <= MOST_NAMED => {
                format!("{file}: {count} rows are left without a height: {reason} ({named})")
            }
            count => format!("{file}: {count} rows are left without a height: {reason} ({named} and others)"),
        }
    };
    reasons.into_iter().map(sentence).collect()
}
