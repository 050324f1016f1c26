//! Tags that GDAL's reader of OpenStreetMap puts into one attribute: `"building"=>"yes","height"=>"12"`.

use super::super::layer::{Attributes, Value};

/// Adds the tags of a text, as far as it can be read.
pub(super) fn add(attributes: &mut Attributes, text: &str) {
    let mut rest = text;
    while let Some((name, after)) = quoted(rest) {
        let Some(after) = after.trim_start().strip_prefix("=>") else { return };
        let Some((value, after)) = quoted(after) else { return };
        attributes.push(name, Value::Text(value));
        rest = after.trim_start().strip_prefix(',').unwrap_or("");
    }
}

/// Splits off the text between the first two quotation marks.
fn quoted(text: &str) -> Option<(String, &str)> {
    let text = text.trim_start().strip_prefix('"')?;
    let (mut value, mut escaped) = (String::new(), false);
    for (at, character) in text.char_indices() {
        match character {
            '\\' if !escaped => {
                escaped = true;
                continue;
            }
            '"' if !escaped => return Some((value, &text[at + 1..])),
            other => value.push(other),
        }
        escaped = false;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_taken_apart() {
        let mut attributes = Attributes::default();
        add(&mut attributes, r#""building"=>"yes", "name"=>"the \"old\" mill","height"=>"12","#);
        let found: Vec<(&str, &Value)> = attributes.iter().collect();
        let text = |text: &str| Value::Text(text.to_owned());
        let expected =
            [("building", text("yes")), ("name", text("the \"old\" mill")), ("height", text("12"))];
        assert_eq!(found, expected.iter().map(|(name, value)| (*name, value)).collect::<Vec<_>>());
    }
}
