//! Flags that do not go together, and frames that would destroy what they are made of: refused before the first one.

use std::path::{Path, PathBuf};

use super::flags::RenderArgs;
use crate::args::check_no_input;
use crate::{scene, traffic};
use hedgehop::encode::video::check_video;
use hedgehop::encode::{Target, sidecar};
use hedgehop::scene::Scene;
use hedgehop::{Error, Result, Size};

/// Refuses frames that would take the place of what they are made of.
pub fn check_frames(args: &RenderArgs, scene: Option<&Scene>, frames: &[PathBuf]) -> Result<()> {
    let mut inputs: Vec<&Path> = vec![&args.area];
    inputs.extend(args.flight.path.as_deref());
    inputs.extend(args.flight.screen.table());
    inputs.extend(scene::inputs(scene));
    frames.iter().try_for_each(|frame| check_no_input("-o", frame, &inputs))
}

/// Refuses before the first frame what would fail, or destroy an input, after the last one.
pub fn check_combination(args: &RenderArgs, scene: Option<&Scene>, size: Size) -> Result<()> {
    let is_stream = args.output.target() == Target::Y4m;
    let mut inputs: Vec<&Path> = args.flight.path.as_deref().into_iter().collect();
    inputs.extend(scene::inputs(scene));
    if let (Some(_), Some(folder), false) = (&args.flight.path, args.output.folder(), is_stream) {
        for name in [sidecar::POSES, sidecar::MANIFEST] {
            check_no_input("-o", &folder.join(name), &inputs)?;
        }
        sidecar::Manifest::check_folder(folder)?;
    }

    if let Some(map) = &args.traffic {
        inputs.push(&args.area);
        traffic::check(map, &inputs)?;
    }

    if is_stream && args.skip_existing {
        return Err(Error::Configuration(
            "--skip-existing needs frames in files; a y4m stream is always written whole".into(),
        ));
    }

    match &args.video {
        Some(_) if is_stream => Err(Error::Configuration(
            "--video is made from frames in files; write them with -o frames/####.png".into(),
        )),
        Some(_) if size.width.min(size.height) < 2 => Err(Error::Configuration(
            "--video has pictures of even sizes, 2x2 pixels at least; ask for a larger --size".into(),
        )),
        Some(film) => check_video(film),
        None => Ok(()),
    }
}
