//! Flags that do not go together, and frames that would destroy what they are made of: refused before the first one.

use std::path::{Path, PathBuf};

use super::flags::RenderArgs;
use crate::aov::AovKind;
use crate::args::check_no_input;
use crate::screen::Setup;
use crate::{scene, traffic};
use hedgehop::encode::atomic::check_writable;
use hedgehop::encode::labels::LabelTable;
use hedgehop::encode::poses::PoseFormat;
use hedgehop::encode::video::{VideoSettings, check_video};
use hedgehop::encode::{FramePattern, Target, sidecar};
use hedgehop::scene::{Finish, Scene, Titling};
use hedgehop::{Error, Result};

/// Refuses frames that would take the place of what they are made of.
pub fn check_frames(args: &RenderArgs, scene: Option<&Scene>, frames: &[PathBuf]) -> Result<()> {
    let mut inputs: Vec<&Path> = vec![&args.area];
    inputs.extend(args.flight.path.as_deref());
    inputs.extend(args.flight.screen.table());
    inputs.extend(args.titling.font.iter().map(PathBuf::as_path));
    inputs.extend(scene::inputs(scene));
    frames.iter().try_for_each(|frame| check_no_input("-o", frame, &inputs))
}

/// Refuses before the first frame what would fail, or destroy an input, after the last one.
pub fn check_combination(args: &RenderArgs, scene: Option<&Scene>, setup: &Setup) -> Result<()> {
    let is_stream = args.target() == Some(Target::Y4m);
    let mut inputs: Vec<&Path> = args.flight.path.as_deref().into_iter().collect();
    inputs.extend(scene::inputs(scene));
    let folder = args.output.as_ref().and_then(FramePattern::folder);
    if let (true, Some(folder), false) = (args.flight.is_sequence(), folder, is_stream) {
        for name in [sidecar::POSES, sidecar::MANIFEST] {
            check_no_input("-o", &folder.join(name), &inputs)?;
        }
        sidecar::Manifest::check_folder(folder)?;
    }
    check_poses(args, &inputs, setup)?;

    if let Some(map) = &args.traffic {
        inputs.push(&args.area);
        traffic::check(map, &inputs)?;
    }

    if is_stream && args.skip_existing {
        return Err(Error::Configuration(
            "--skip-existing needs frames in files; a y4m stream is always written whole".into(),
        ));
    }

    match &args.film.video {
        Some(_) if is_stream => Err(Error::Configuration(
            "--video is made without y4m: leave out -o, or write frames to make it of with -o frames/####.png"
                .into(),
        )),
        Some(_) if args.target() == Some(Target::Npy) => Err(Error::Configuration(
            "--video is made from pictures, and NPY holds depth; write frames with -o frames/####.png".into(),
        )),
        Some(_) if setup.size.width.min(setup.size.height) < 2 => Err(Error::Configuration(
            "--video has pictures of even sizes, 2x2 pixels at least; ask for a larger --size".into(),
        )),
        _ => Ok(()),
    }
}

/// Refuses, of views that no path joins, what tells of motion from one to the next.
pub fn check_views(args: &RenderArgs, finish: &Finish, titling: &Titling) -> Result<()> {
    let (moves, remedy) = if args.flight.views.views.is_none() {
        return Ok(());
    } else if args.aov.has(AovKind::Motion) {
        ("--aov motion tells how the picture moves to the next frame", "leave motion out")
    } else if finish.shutter > 0.0 {
        (
            "--shutter blurs what moves while it is open",
            "leave it out, or give --shutter 0 where the scene has it",
        )
    } else if !titling.is_empty() {
        (
            "text and figures tell of a flight",
            "leave --overlay, --hud, --title, --credits and --caption out, and what the scene has of them",
        )
    } else {
        return Ok(());
    };
    Err(Error::Configuration(format!("{moves}, and --views are stills without a path; {remedy}")))
}

/// Refuses labels in files that hold none, or of several rays a pixel, whose numbers have no mean.
pub fn check_labels(args: &RenderArgs, finish: &Finish) -> Result<()> {
    let refuse = |what: &str| Err(Error::Configuration(what.to_owned()));
    if args.labels.labels.is_none() {
        return Ok(());
    }
    let Some(output) = args.output.as_ref().filter(|output| output.target() == Target::Png) else {
        return refuse("--labels are PNG; write them with -o labels/####.png");
    };
    if args.film.video.is_some() {
        return refuse("--video is made from pictures, and --labels are none; leave one of the two out");
    }
    if finish.gathers() {
        return refuse(
            "--labels are of one ray a pixel, at one moment; leave --antialias and --shutter out, or give --antialias 1 and --shutter 0 \
             where the scene has them",
        );
    }
    output.folder().map_or(Ok(()), LabelTable::check_folder)
}

/// Refuses a film that cannot be made, or would destroy an input.
pub fn check_film(args: &RenderArgs, scene: Option<&Scene>, film: &VideoSettings) -> Result<()> {
    if args.output.is_none() && args.skip_existing {
        return Err(Error::Configuration(
            "--skip-existing needs frames in files, such as -o frames/####.png; a film alone is always made whole"
                .into(),
        ));
    }
    if args.output.is_none() && args.overwrite {
        return Err(Error::Configuration(
            "--overwrite is of frames in files, such as -o frames/####.png; a film alone replaces what was there"
                .into(),
        ));
    }

    let mut inputs: Vec<&Path> = vec![&args.area];
    inputs.extend(args.flight.path.as_deref());
    inputs.extend(args.flight.screen.table());
    inputs.extend(args.film.audio.as_deref());
    inputs.extend(args.film.chapters.as_deref());
    inputs.extend(args.titling.font.iter().map(PathBuf::as_path));
    inputs.extend(scene::inputs(scene));
    check_no_input("--video", &film.out, &inputs)?;
    check_video(film)?;
    check_writable(&film.out)
}

/// Refuses files of poses that would be of no flight, or tell what they have no words for.
fn check_poses(args: &RenderArgs, inputs: &[&Path], setup: &Setup) -> Result<()> {
    let formats = &args.poses.poses;
    let refuse = |what: &str| Err(Error::Configuration(what.to_owned()));
    if formats.is_empty() {
        return Ok(());
    }
    let Some(output) = args.output.as_ref().filter(|output| output.target() != Target::Y4m) else {
        return refuse("--poses writes files beside frames; write these with -o frames/####.png");
    };
    let (true, Some(folder)) = (args.flight.is_sequence(), output.folder()) else {
        return refuse(
            "--poses tells the poses of a flight; give it a --path or --views, or leave it out: a picture of --eye says its own pose",
        );
    };
    if !setup.is_planar() && formats.iter().any(|format| format.describes_cameras()) {
        return refuse(
            "--poses transforms and colmap describe planar screens, through a lens or not; leave --screen out, or take --poses tum",
        );
    }
    let name = output.path(1).file_name().unwrap_or_default().to_string_lossy().into_owned();
    if formats.contains(&PoseFormat::Colmap) && name.contains(char::is_whitespace) {
        return refuse(
            "COLMAP reads names without blanks; name frames otherwise (-o), or leave --poses colmap out",
        );
    }

    for format in formats {
        format.files().iter().try_for_each(|name| check_no_input("-o", &folder.join(name), inputs))?;
        format.check_folder(folder)?;
    }
    Ok(())
}
