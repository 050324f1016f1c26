//! Files that are damaged, forged, or say things beside their pixels.

use std::fs;

use image::Rgb;

use super::replay::{Replay, assert_range};

pub fn masks_beside_files(inputs: &Replay) {
    let kept = inputs.built("--elevation dem.tif --nodata-fill none");
    // 30 x 20 of 120 x 90.
    assert_eq!(kept["metadata"]["void_share"], 600.0 / 10_800.0);
    inputs.done("build --elevation flat.tif --imagery rgb.tif -o bare.hop");
    assert!(inputs.done("info bare.hop").contains("31.25 % of the ground bare"));
}

pub fn associated_alpha(inputs: &Replay) {
    let pictures = ["straight.tif", "premultiplied.tif"].map(|file| {
        inputs.built(&format!("--elevation flat.tif --imagery {file}"));
        inputs.colours()
    });
    assert_eq!(pictures[0].get_pixel(50, 60), &Rgb([106, 127, 67]));
    // Premultiplied bytes keep less of dark colours.
    for (straight, premultiplied) in pictures[0].pixels().zip(pictures[1].pixels()) {
        let apart = (0..3).map(|band| straight[band].abs_diff(premultiplied[band])).max().unwrap_or(0);
        assert!(apart <= 3, "{straight:?} {premultiplied:?}");
    }
}

pub fn bands_in_another_order(inputs: &Replay) {
    inputs.built("--elevation flat.tif --imagery bgr.tif");
    assert_eq!(inputs.colours().get_pixel(100, 60), &Rgb([190, 126, 200]));
}

pub fn chunks_that_are_damaged(inputs: &Replay) {
    for file in ["trns-damaged.png", "a_png16.png"] {
        let build = format!("build --elevation {file} --local --spacing 10 -o built.hop");
        inputs.refused(&build, 3, &[file, "tRNS", "damaged"]);
    }
    assert_range(&inputs.built("--elevation trns-good.png --local --spacing 10"), [300.0, 426.0], 0.1);
}

pub fn half_a_photograph(inputs: &Replay) {
    let build = "build --elevation e.png --imagery t50.jpg --local --spacing 10 -o built.hop";
    inputs.refused(build, 3, &["t50.jpg", "62 %", "missing"]);
}

pub fn byte_order_marks(inputs: &Replay) {
    let place = "[place]\nlocal = true\nbbox = [0, 0, 32, 32]\nspacing_m = 1\n\
                 [[terrain]]\nkind = \"plane\"\nheight_m = 10\n[[object]]\nat = [16, 16]\nfile = ";
    let hashes = ["nobom.obj", "bom.obj", "bom_unused_last.obj"].map(|model| {
        fs::write(inputs.path("place.toml"), format!("{place}\"{model}\"\n")).expect("a recipe");
        inputs.done("build place.toml -o built.hop --overwrite");
        let places: Vec<String> =
            (0..20).map(|step| format!("{} {}", 10.3 + 0.6 * f64::from(step), 16.4)).collect();
        inputs.done(&format!("height built.hop --xy {}", places.join(" ")))
    });
    assert!(hashes[0].contains("14.0") || hashes[0].contains("13.9"), "{}", hashes[0]);
    assert!(hashes.iter().all(|told| *told == hashes[0]), "{hashes:?}");
    inputs.built("--elevation asc_bom.asc --local");
}

pub fn boxes_of_clouds(inputs: &Replay) {
    for file in ["bbox_small.las", "bbox_zero.las"] {
        let info = inputs.built(&format!("--cloud {file} --spacing 1"));
        assert_eq!(info["voxels"], serde_json::json!([100, 100]), "{file}");
        assert_range(&info, [200.0, 214.0], 0.1);
    }
    inputs.refused(
        "build --cloud negative_scale.las --spacing 1 -o n.hop",
        3,
        &["negative_scale.las", "scale of -0.001"],
    );
}

pub fn absurd_numbers(inputs: &Replay) {
    inputs.refused(
        "render a.hop --eye 593658,5184287,5443 -o h.png",
        3,
        &["a.hop", "the spacing is 1e300 m", "build it again"],
    );
}

pub fn pixels_without_bound(inputs: &Replay) {
    let picture = image::ImageBuffer::from_fn(64, 64, |x, y| image::Luma([(300 + x + y) as u16]));
    picture.save(inputs.path("e.png")).expect("a picture");
    for system in ["--local", "--elevation-crs EPSG:32632"] {
        let build = format!("build --elevation e.png {system} -o built.hop");
        inputs.refused(&build, 4, &["e.png", "4294967296 x 10 m", "world file"]);
    }
    assert!(!inputs.path("built.hop").exists());
}
