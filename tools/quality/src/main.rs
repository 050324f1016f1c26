//! Measures how true hedgehop's pictures are: ranges (`truth`), colours (`picture`), what flickers
//! (`flicker`), and tones of texture (`texture`).

mod args;
mod engine;
mod exact;
mod flicker;
mod measure;
mod picture;
mod posts;
mod random;
mod report;
mod texture;
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
    Texture(texture::TextureArgs),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().mode {
        Mode::Truth(args) => truth::run(&args),
        Mode::Picture(args) => picture::run(&args),
        Mode::Flicker(args) => flicker::run(&args),
        Mode::Texture(args) => texture::run(&args),
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
