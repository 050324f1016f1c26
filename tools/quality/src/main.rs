//! Measures how true hedgehop's pictures are: ranges (`truth`), colours (`picture`), and what flickers (`flicker`).

mod args;
mod engine;
mod exact;
mod flicker;
mod measure;
mod picture;
mod posts;
mod random;
mod report;
mod truth;
mod truths;
mod views;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(name = "hedgehop-quality", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    mode: Mode,
}

#[derive(Debug, Subcommand)]
enum Mode {
    Truth(truth::TruthArgs),
    Picture(picture::PictureArgs),
    Flicker(flicker::FlickerArgs),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().mode {
        Mode::Truth(args) => truth::run(&args),
        Mode::Picture(args) => picture::run(&args),
        Mode::Flicker(args) => flicker::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            #[expect(clippy::print_stderr, reason = "a program's complaint")]
            {
                eprintln!("error: {error}");
            }
            ExitCode::FAILURE
        }
    }
}
