//! The `hedgehop` program: from elevation and imagery to flown pictures. Exit codes are in `exit.rs`.

mod aov;
mod area;
mod args;
mod bound_flight;
mod camera;
mod chart;
mod classes;
mod commands;
mod contact_sheet;
mod cpu_time;
mod database;
mod degrees;
mod difference;
mod drawing;
mod exit;
mod farm;
mod faults;
mod figures;
mod film;
mod finish;
mod frame_ranges;
mod interrupt;
mod labels;
mod lettering;
mod lines;
mod making;
mod maps;
mod memory;
mod output;
mod own_body;
mod page_list;
mod partner;
mod pictures;
mod places;
mod playback;
mod plot;
mod poses;
mod product;
mod program;
mod progress;
mod reference;
mod running_sun;
mod scene;
mod screen;
mod sequence;
mod sharpness;
mod side_by_side;
mod smoothing;
mod speedup;
mod titling;
mod tracks;
mod traffic;
mod trails;
mod trust;
mod view;
mod viewer;
mod views;
mod world;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::commands::{
    bake, bench, build, compare, contact_sheet as sheet, continuity, contours, demo, extract, farm as farms,
    height, hillshade, info, manual, merge, overview, plan, profile, recipe, render, scene as scenes,
    shadow_heights, sight, verify, verify_frames,
};
use crate::interrupt::Interrupt;
use hedgehop::memory::guard_mapped_files;

/// Renders low flight over real terrain from voxel databases, without a GPU.
///
/// Build a database from elevation rasters and imagery once, then fly paths through it.
#[derive(Debug, Parser)]
#[command(name = "hedgehop", version, after_help = START, after_long_help = START, max_term_width = 100, args_override_self = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const START: &str = "\
Start here:
  hedgehop demo
  hedgehop build --elevation dem.tif --imagery ortho.tif -o area.hop
  hedgehop render area.hop --path track.gpx -o frames/####.png

Exit codes are listed by `hedgehop COMMAND --help`.";

#[derive(Debug, Subcommand)]
enum Command {
    Build(build::BuildArgs),
    New(recipe::NewArgs),
    Recipe(recipe::RecipeArgs),
    Bake(bake::BakeArgs),
    Render(Box<render::RenderArgs>),
    Plan(plan::PlanArgs),
    Farm(farms::FarmArgs),
    Info(info::InfoArgs),
    Continuity(continuity::ContinuityArgs),
    Contours(contours::ContoursArgs),
    Extract(extract::ExtractArgs),
    Merge(merge::MergeArgs),
    Height(height::HeightArgs),
    Hillshade(hillshade::HillshadeArgs),
    ShadowHeights(shadow_heights::ShadowHeightsArgs),
    Sight(sight::SightArgs),
    Profile(profile::ProfileArgs),
    Verify(verify::VerifyArgs),
    VerifyFrames(verify_frames::VerifyFramesArgs),
    Scene(scenes::SceneCheckArgs),
    Bench(bench::BenchArgs),
    Overview(overview::OverviewArgs),
    ContactSheet(sheet::ContactSheetArgs),
    Compare(compare::CompareArgs),
    Demo(demo::DemoArgs),
    Completions(manual::CompletionArgs),
    Man(manual::ManArgs),
}

fn main() -> ExitCode {
    exit::install_panic_hook();
    let cli = Cli::parse_from(height::apart(std::env::args_os()));
    let ready = guard_mapped_files().and_then(|()| Interrupt::install());

    let outcome = ready.map_err(exit::Failure::from).and_then(|interrupt| match &cli.command {
        Command::Build(args) => build::run(args, &interrupt),
        Command::New(args) => recipe::create(args),
        Command::Recipe(args) => recipe::run(args),
        Command::Bake(args) => bake::run(args, &interrupt),
        Command::Render(args) => render::run(args, &interrupt),
        Command::Plan(args) => plan::run(args, &interrupt),
        Command::Farm(args) => farms::run(args, &interrupt),
        Command::Info(args) => info::run(args),
        Command::Continuity(args) => continuity::run(args, &interrupt),
        Command::Contours(args) => contours::run(args, &interrupt),
        Command::Extract(args) => extract::run(args, &interrupt),
        Command::Merge(args) => merge::run(args, &interrupt),
        Command::Height(args) => height::run(args),
        Command::Hillshade(args) => hillshade::run(args, &interrupt),
        Command::ShadowHeights(args) => shadow_heights::run(args, &interrupt),
        Command::Sight(args) => sight::run(args),
        Command::Profile(args) => profile::run(args, &interrupt),
        Command::Verify(args) => verify::run(args, &interrupt),
        Command::VerifyFrames(args) => verify_frames::run(args, &interrupt),
        Command::Scene(args) => scenes::run(args, &interrupt),
        Command::Bench(args) => bench::run(args, &interrupt),
        Command::Overview(args) => overview::run(args, &interrupt),
        Command::ContactSheet(args) => sheet::run(args, &interrupt),
        Command::Compare(args) => compare::run(args, &interrupt),
        Command::Demo(args) => demo::run(args, &interrupt),
        Command::Completions(args) => manual::completions(args, Cli::command()),
        Command::Man(args) => manual::pages(args, Cli::command()),
    });

    exit::report(outcome)
}
