//! Prediction of how long a flight's frames take, from a few that are rendered.

use std::path::Path;

use super::PlanArgs;
use crate::args::Workers;
use crate::commands::render::{RenderArgs, cost_samples, survey};
use crate::farm::cost::CostPrediction;
use crate::progress::Reporter;
use hedgehop::Result;
use hedgehop::encode::FramePattern;
use hedgehop::memory::PageFile;

/// Predicts the time of each frame, as a PNG and with so many workers as the flags ask for.
///
/// # Errors
/// Whatever keeps the sample frames from being rendered.
pub fn predict(args: &PlanArgs, file: &PageFile, reporter: &Reporter) -> Result<CostPrediction> {
    let render = || render_args(args);
    let survey = survey(&render()?, file, reporter)?;
    let places = cost_samples::usual_places(survey.numbers.len());
    let samples = cost_samples::take(&render, &survey, places, reporter)?.samples;
    Ok(CostPrediction::fit(&survey.numbers, &survey.loads, &samples))
}

/// The flight as `render` would fly it.
fn render_args(args: &PlanArgs) -> Result<RenderArgs> {
    let pattern = Path::new("frames").join("####.png");
    let output = FramePattern::parse(&pattern.to_string_lossy())?;
    Ok(RenderArgs {
        frames: args.frames.clone(),
        workers: Workers { jobs: args.workers.jobs },
        overlap: args.overlap,
        look: args.look.clone(),
        scene: args.scene.clone(),
        ..RenderArgs::of_flight(args.area.clone(), output, args.fps, args.flight.clone())
    })
}
