//! Words of a command as a POSIX shell reads them.

use std::path::Path;

/// Joins words into a line that a shell takes apart into the same words.
pub fn quoted(words: &[String]) -> String {
    words.iter().map(|word| quote(word)).collect::<Vec<_>>().join(" ")
}

/// Returns the name of a file as a shell reads it, for commands that messages propose.
pub fn named(path: &Path) -> String {
    quote(&path.display().to_string())
}

fn quote(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%^#".contains(c);
    // A # begins a comment where a word does.
    if !word.is_empty() && word.chars().all(is_plain) && !word.starts_with('#') {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_shell_reads_what_was_written() {
        let words: Vec<String> = [
            "a b",
            "it's",
            "$HOME",
            "%04d",
            "",
            "#x",
            "frames/####.png",
            "line\nbreak",
            "`id`",
            "\\",
            "ü*?",
            "{}",
        ]
        .map(String::from)
        .to_vec();
        let script = format!("printf '%s\\0' {}", quoted(&words));
        let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
        let read: Vec<_> = output.stdout.split(|byte| *byte == 0).collect();
        let expected: Vec<_> = words.iter().map(String::as_bytes).chain([&b""[..]]).collect();
        assert_eq!(read, expected);
    }
}
