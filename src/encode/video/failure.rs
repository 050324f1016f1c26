//! Sentences for what ffmpeg cannot do.

use std::io;
use std::path::Path;

use hedgehop_base::error::Error;

/// The sentence for an ffmpeg that cannot be started.
pub(super) fn missing(file: &Path, error: &io::Error) -> Error {
    Error::unsupported(
        file,
        format!("it needs the program ffmpeg, which cannot be started ({error})"),
        "install it (Debian, Ubuntu: apt-get install ffmpeg), write a film without sound to an .avi file, which needs none, \
         or y4m with `-o -` and encode that elsewhere",
    )
}

/// The last line of ffmpeg's messages, which mostly says why it gave up.
pub(super) fn last_words(said: &str) -> Option<String> {
    said.lines().rev().map(str::trim).find(|line| !line.is_empty()).map(str::to_owned)
}
