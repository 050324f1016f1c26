//! Poses and depth for computer vision: `--poses`, `.npy`, and the Python in `docs/vision.md`.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::common::{ends, run, run_args};
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

/// All files of poses besides `poses.csv`.
const FILES: [&str; 5] =
    ["transforms.json", "sparse/0/cameras.txt", "sparse/0/images.txt", "sparse/0/points3D.txt", "poses.tum"];

/// A folder with a database of a plain at 100 m, far from the origin, and a path of three frames over it, banked.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let origin = glam::DVec2::new(500_123.0, 4_649_250.0);
    let grid = Grid { nx: 160, ny: 160, spacing: 10.0, origin };
    let (heights, colours) = (vec![100.0; 160 * 160], vec![[90, 140, 60]; 160 * 160]);
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
    write_arrays(&folder.path().join("area.hop"), &arrays, &metadata, false).expect("a database");
    let path = "t_s,x_m,y_m,alt_m,yaw_deg,pitch_deg,roll_deg\n\
                0,500700,4649700,160.5,10,-20,5\n1,500720.25,4649740,171,40,-35,-15\n";
    fs::write(folder.path().join("path.csv"), path).expect("a path");
    folder
}

const FLY: &str = "render area.hop --path path.csv --fps 2 --size 64x36";

fn texts(site: &TempDir, folder: &str) -> [String; 5] {
    FILES.map(|name| fs::read_to_string(site.path().join(folder).join(name)).unwrap_or_default())
}

#[test]
fn poses_are_the_same_whichever_parts_are_rendered() {
    let site = site();
    let fly = |args: &str| ends(&run(&site, &format!("{FLY} {args}")), 0);
    fly("-o whole/####.png --poses transforms,colmap,tum");
    let whole = texts(&site, "whole");
    assert!(whole.iter().all(|text| !text.is_empty()));
    assert!(
        whole[0].contains("\"file_path\": \"0003.png\"") && whole[0].contains("500000.0"),
        "{}",
        whole[0]
    );

    fly("-o parts/####.png --frames 2-3 --poses colmap,colmap");
    assert!(texts(&site, "parts")[0].is_empty());
    let said = fly("-o parts/####.png --skip-existing --poses tum,transforms");
    assert!(said.contains("kept 2"), "poses decide no picture: {said}");
    assert!(texts(&site, "parts") == whole);

    fly("-o plain/####.png");
    let manifest = |folder: &str| fs::read_to_string(site.path().join(folder).join("manifest.json"));
    assert!(!manifest("plain").expect("a manifest").contains("\"poses\""));
    assert!(manifest("parts").expect("a manifest").contains("\"transforms\""));
    assert!(fly("-o curved/####.png --poses tum --curvature on").contains("--curvature off"));
    let lens = fly("-o lens/####.png --poses transforms,colmap --distortion=-0.1,0.01");
    assert!(texts(&site, "lens")[1].contains(" RADIAL 64 36 "), "{lens}");
}

#[test]
fn poses_that_would_be_of_nothing_are_refused() {
    let site = site();
    fs::create_dir(site.path().join("taken")).expect("a folder");
    fs::write(site.path().join("taken/transforms.json"), "{\"frames\": []}").expect("a file");
    for (args, part) in [
        ("--poses colmap --screen fisheye -o no/####.png", "--poses tum"),
        ("--poses tum -o no.y4m", "-o frames/####.png"),
        ("--poses transforms -o taken/####.png", "taken/transforms.json: it is not of a render"),
        ("--poses kitti -o no/####.png", "[possible values: transforms, colmap, tum]"),
    ] {
        let said = ends(&run(&site, &format!("{FLY} {args}")), 2);
        assert!(said.contains(part), "{args}: {said}");
    }
    let eye = "render area.hop --eye 500700,4649700,200 --poses tum -o no.png";
    assert!(ends(&run(&site, eye), 2).contains("--path"));
    let blank = FLY.split(' ').chain(["--poses", "colmap", "-o", "no/my ####.png"]);
    assert!(ends(&run_args(&site, blank), 2).contains("without blanks"));
    ends(&run(&site, &format!("{FLY} --poses tum --screen fisheye -o dome/####.png")), 0);
    assert!(!site.path().join("no").exists());
}

#[test]
fn depth_is_kept_checked_and_no_picture() {
    let site = site();
    let fly = |args: &str| run(&site, &format!("{FLY} {args}"));
    ends(&fly("-o depth/####.npy"), 0);
    let whole = fs::read(site.path().join("depth/0002.npy")).expect("depth");
    assert!(ends(&fly("-o depth/####.npy --skip-existing"), 0).contains("kept 3"));
    fs::write(site.path().join("depth/0002.npy"), &whole[..whole.len() - 1]).expect("depth");
    assert!(ends(&run(&site, "verify depth"), 6).contains("0002.npy"));
    assert!(ends(&fly("-o depth/####.npy --skip-existing"), 0).contains("rendered 1 frame"));
    assert!(fs::read(site.path().join("depth/0002.npy")).expect("depth") == whole);
    assert!(ends(&fly("-o depth/####.npy --video depth.mp4 --overwrite"), 2).contains("holds depth"));
    assert!(ends(&fly("-o depth/####.npy --exposure 1 --overwrite"), 0).contains("NPY holds depth"));
}

/// Whether there is a Python with NumPy; says so if not.
fn has_numpy() -> bool {
    let found = Command::new("python3").args(["-c", "import numpy"]).output();
    let is_there = found.is_ok_and(|output| output.status.success());
    if !is_there {
        // Written past the test harness, which swallows what passing tests print.
        let _ = writeln!(std::io::stderr(), "skipped: no python3 with numpy, which docs/vision.md asks for");
    }
    is_there
}

/// The Python that a page shows, without what needs more than NumPy.
fn python(page: &str) -> String {
    let blocks = page.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next());
    let needs_more = |block: &&str| ["OpenEXR", "PIL"].iter().any(|module| block.contains(module));
    blocks.filter(|block| !needs_more(block)).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_python_of_the_page_finds_the_plain() {
    if !has_numpy() {
        return;
    }
    let site = site();
    ends(&run(&site, &format!("{FLY} --poses transforms,colmap,tum -o frames/####.png")), 0);
    ends(&run(&site, &format!("{FLY} -o depth/####.npy")), 0);
    let checks = "
assert abs(world[numpy.isfinite(Z), 2] - 100).max() < 1e-2, world[..., 2]
assert numpy.isfinite(Z).mean() > 0.5 and entries['hedgehop.frame'] == '1'
assert abs(eye - [500700, 4649700, 160.5]).max() < 1e-8, eye
assert abs(colmap_eye - eye).max() < 1e-8 and abs(R - (pose[:3, :3] * [1, -1, -1]).T).max() < 1e-12
assert abs(trajectory[0, 1:4] + offset - eye).max() < 1e-8 and trajectory[2, 0] == 1
";
    let script = python(include_str!("../../../../docs/vision.md")) + checks;
    let run_python =
        |folder: &Path| Command::new("python3").current_dir(folder).args(["-c", &script]).output();
    let output = run_python(site.path()).expect("python3 starts");
    ends(&output, 0);
}
