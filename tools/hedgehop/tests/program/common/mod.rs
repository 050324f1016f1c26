//! The program, run from outside.

pub mod range_server;

use std::ffi::OsStr;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// Runs it in a folder, with arguments between blanks.
pub fn run(folder: &TempDir, args: &str) -> Output {
    run_args(folder, args.split_whitespace())
}

/// Runs it in a folder.
pub fn run_args<A: AsRef<OsStr>>(folder: &TempDir, args: impl IntoIterator<Item = A>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hedgehop"))
        .current_dir(folder.path())
        .args(args)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// All that it said, once it has ended with that exit code.
#[track_caller]
pub fn ends(output: &Output, code: i32) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{out}{err}");
    out + &err
}
