//! Frames of scenes.

use super::replay::Replay;

/// A turn by which a wall is no longer parallel to the screen, and moves by a sixth of a pixel, degrees.
const TURN: f64 = 0.02;

/// Differences of a channel's byte that are no change of light.
const DISTINCT: u8 = 60;

/// Pixels along outlines of the model's parts.
const ALONG_OUTLINES: usize = 60;

pub fn walls_parallel_to_the_screen(inputs: &Replay) {
    inputs.done("build flat.toml");
    for eye in ["50,20,20", "50,10,12", "30,20,20", "20,0,15"] {
        let [flat, turned] = [0.0, TURN].map(|turn| {
            let view = format!("--eye {eye} --ypr {turn},{turn},0 --hfov 80 --size 640x360");
            inputs.done(&format!("render flat.hop {view} --scene sc.toml -o view.png --overwrite"));
            inputs.picture("view.png")
        });
        let is_distinct = |pair: &(&image::Rgb<u8>, &image::Rgb<u8>)| {
            (0..3).any(|band| pair.0[band].abs_diff(pair.1[band]) > DISTINCT)
        };
        let apart = flat.pixels().zip(turned.pixels()).filter(is_distinct).count();
        assert!(apart <= ALONG_OUTLINES, "{eye}: {apart} pixels");
    }
}
