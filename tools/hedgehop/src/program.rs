//! The name under which this program was started, for commands that it proposes.

use std::path::PathBuf;

/// Returns the command that a shell in this folder understands: `hedgehop` where it was found through PATH, else where it
/// lies, from here if it lies below (`cargo run` leaves it in `target/release`, which is on nobody's PATH).
pub fn program() -> String {
    let Some(given) = std::env::args_os().next().map(PathBuf::from) else { return "hedgehop".into() };
    let near = std::env::current_dir().ok().and_then(|here| given.strip_prefix(here).ok().map(PathBuf::from));
    near.unwrap_or(given).display().to_string()
}
