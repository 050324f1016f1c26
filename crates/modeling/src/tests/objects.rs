//! Models in databases: built, built again, and from damaged files.

mod stance;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec2;

use super::support::{Area, options};
use crate::object::{BuiltIn, ObjectFile, ScatterFile, ScatterForm, Stance};
use crate::synthetic::Terrain;
use crate::{BuildOptions, BuildReport, Finish, Materials, build};
use hedgehop::voxel::{Material, PageSource};
use hedgehop_base::progress::Silent;

/// A box of 10 by 6 m, 5 m high, its roof red.
const BOX: &str = "mtllib box.mtl\nv -5 0 -3\nv 5 0 -3\nv 5 0 3\nv -5 0 3\nv -5 5 -3\nv 5 5 -3\nv 5 5 3\nv -5 5 3\n\
    usemtl wall\nf 1 2 3 4\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\nusemtl roof\nf 5 8 7 6\n";
const MATERIALS: &str = "newmtl wall\nKd 0.8 0.8 0.7\nnewmtl roof\nKd 0.6 0.05 0.02\n";

fn files(folder: &Path) -> PathBuf {
    fs::write(folder.join("box.obj"), BOX).unwrap();
    fs::write(folder.join("box.mtl"), MATERIALS).unwrap();
    folder.join("box.obj")
}

/// 1280 m of level ground at 100 m, at voxels of 1 m: 5 × 5 pages of level 1, 4 + 1 + 1 above.
fn plain(folder: &Path, output: &str) -> BuildOptions {
    let mut options = options(folder);
    options.output = folder.join(output);
    options.local = true;
    options.bbox = Some([0.0, 0.0, 1280.0, 1280.0]);
    options.spacing = Some(1.0);
    let plane = Terrain::Plane { height_m: 100.0, centre: DVec2::ZERO, slope: 0.0, upward_deg: 0.0 };
    options.synthetic.terrain = vec![plane];
    options
}

const PAGES: u64 = 25 + 4 + 1 + 1;

fn object(path: &Path, places: &[[f64; 2]], heading_deg: f64) -> ObjectFile {
    let stance = Stance { heading_deg, ..Stance::default() };
    ObjectFile { paths: vec![path.to_owned()], places: places.to_vec(), stance, ..ObjectFile::default() }
}

/// Builds again, and holds the result against a build of everything beside it.
fn updated(options: &BuildOptions) -> BuildReport {
    let report = build(options, &Silent).unwrap();
    let clean =
        BuildOptions { output: options.output.with_extension("clean"), steps: false, ..options.clone() };
    build(&clean, &Silent).unwrap();
    assert!(fs::read(&options.output).unwrap() == fs::read(&clean.output).unwrap(), "the same bytes");
    report
}

#[test]
fn an_object_stands_where_it_says_and_moves_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = files(folder.path());
    let mut options = plain(folder.path(), "a.hop");
    options.steps = true;
    options.objects = vec![object(&path, &[[100.0, 140.0]], 90.0), object(&path, &[[700.0, 700.0]], 33.0)];
    assert_eq!(updated(&options).reused, 0);
    let area = Area::open(&options.output).unwrap();

    // Its length runs from north to south.
    for (x, y, height) in [(100, 144, 105.0), (102, 140, 105.0), (103, 140, 100.0), (100, 145, 100.0)] {
        assert!((area.height(x, y).unwrap() - height).abs() <= 2.0 * area.step(), "{x} {y}");
    }
    let [red, green, _] = area.colour(100, 140);
    assert!(red > 150 && green < 90, "{red} {green}");
    assert_eq!(updated(&options).reused, PAGES);

    // Its page, and one of each coarser level; the code of heights stays.
    options.objects[0].places[0][0] += 7.25;
    assert_eq!(updated(&options).reused, PAGES - 4);
    options.objects[1].stance.heading_deg = 60.0;
    assert_eq!(updated(&options).reused, PAGES - 4);

    // What its file holds counts, and not when it was written.
    fs::write(folder.path().join("box.mtl"), MATERIALS).unwrap();
    assert_eq!(updated(&options).reused, PAGES);
    fs::write(folder.path().join("box.mtl"), MATERIALS.replace("0.6", "0.5")).unwrap();
    assert!(updated(&options).reused < PAGES - 4);
    options.objects[0].places[0] = [-50.0, 20.0];
    let error = build(&BuildOptions { steps: false, ..options.clone() }, &Silent);
    assert!(error.is_ok(), "outside of the area it is left out");
}

#[test]
fn an_object_is_made_of_what_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = files(folder.path());
    let mut options = plain(folder.path(), "m.hop");
    options.steps = true;
    options.objects = vec![object(&path, &[[100.0, 140.0]], 90.0), object(&path, &[[700.0, 700.0]], 0.0)];
    updated(&options);
    let plain = Area::open(&options.output).unwrap();
    assert_eq!(plain.attributes(100, 140).material, 0);
    options.objects[0].material = Material::Wood;

    // Its page and those of two coarser levels: further up wood is nowhere most of a voxel, so that the next page has nothing new to see.
    assert_eq!(updated(&options).reused, PAGES - 3);
    let area = Area::open(&options.output).unwrap();
    let material = |x, y| Material::of_code(area.attributes(x, y).material);
    assert_eq!((material(100, 140), material(102, 144)), (Material::Wood, Material::Wood));
    assert_eq!((material(700, 700), material(110, 140)), (Material::Unknown, Material::Unknown));

    // Its colours are its own, and go along where the material's is another one than usual.
    assert_eq!(area.colour(100, 140), plain.colour(100, 140));
    let [red, green, blue] = Material::Wood.colour();
    let paler =
        Finish { material: Material::Wood, colour: Some([red, green + 40, blue + 30]), ..Finish::default() };
    options.materials = Materials::new(vec![paler]);
    updated(&options);
    let area = Area::open(&options.output).unwrap();
    let [red, green, blue] = plain.colour(100, 140);
    assert_eq!(area.colour(100, 140), [red, green + 40, blue + 30]);
    assert_eq!(area.colour(700, 700), plain.colour(700, 700));
}

#[test]
fn files_of_a_scatter_are_made_of_what_is_said_and_plants_of_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let forms = vec![ScatterForm::File(files(folder.path())), ScatterForm::BuiltIn(BuiltIn::Conifer)];
    let hay = Finish {
        material: Material::Own(201),
        name: "hay".into(),
        like: Some(Material::Crops),
        ..Finish::default()
    };
    let mut options = plain(folder.path(), "h.hop");
    options.bbox = Some([0.0, 0.0, 256.0, 256.0]);
    options.materials = Materials::new(vec![hay]);
    let material = Material::Own(201);
    options.scatters = vec![ScatterFile { forms, material, spacing_m: 25.0, ..ScatterFile::default() }];
    build(&options, &Silent).unwrap();
    let area = Area::open(&options.output).unwrap();
    let high = area.voxels().filter(|(x, y)| area.height(*x, *y).unwrap() > 104.5);
    let made: BTreeSet<u8> = high.map(|(x, y)| area.attributes(x, y).material).collect();
    assert_eq!(made, BTreeSet::from([Material::Needleleaf.code(), 201]));
    assert_eq!(area.pages.header().metadata.material_name(201), "hay");
}

#[test]
fn forms_of_scatters_have_a_greatest_width() {
    let folder = tempfile::tempdir().unwrap();
    let forms = vec![ScatterForm::File(files(folder.path()))];
    let mut options = plain(folder.path(), "a.hop");
    options.scatters =
        vec![ScatterFile { forms, spacing_m: 300.0, scale: [26.0; 2], ..ScatterFile::default() }];
    let told = build(&options, &Silent).unwrap_err().to_string();
    assert!(told.contains("262 voxels wide") && told.contains("[[object]]"), "{told}");
    options.scatters[0].scale = [24.0; 2];
    assert!(build(&options, &Silent).is_ok());
}

#[test]
fn scatters_are_the_same_for_any_machine() {
    let folder = tempfile::tempdir().unwrap();
    let path = files(folder.path());
    let forms = vec![
        ScatterForm::BuiltIn(BuiltIn::Broadleaf),
        ScatterForm::BuiltIn(BuiltIn::Conifer),
        ScatterForm::File(path.clone()),
    ];
    let scatter =
        ScatterFile { forms, spacing_m: 20.0, scale: [0.7, 1.2], seed: 3, ..ScatterFile::default() };
    let mut bytes = Vec::new();

    for (threads, memory) in [(1, 512), (3, 512), (2, 96)] {
        let mut options = plain(folder.path(), "b.hop");
        (options.threads, options.memory) = (threads, memory << 20);
        options.scatters = vec![scatter.clone()];
        options.objects = vec![object(&path, &[[255.5, 256.0], [640.0, 640.0]], 20.0)];
        build(&options, &Silent).unwrap();
        bytes.push(fs::read(&options.output).unwrap());
    }

    assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2]);
    let area = Area::open(&folder.path().join("b.hop")).unwrap();

    // Something stands on the whole of it, and not on most of it.
    let over = |x: u32, y: u32| area.height(x, y).unwrap() > 100.5;
    let share = |x0: u32, y0: u32| {
        let all = (0..128).flat_map(|y| (0..128).map(move |x| (x0 + x, y0 + y)));
        all.filter(|(x, y)| over(*x, *y)).count() as f64 / (128.0 * 128.0)
    };
    for (x, y) in [(0, 0), (600, 600), (1100, 300)] {
        assert!((0.03..0.3).contains(&share(x, y)), "{x} {y}: {}", share(x, y));
    }
}

/// Numbers by chance (Marsaglia 2003).
fn next(state: &mut u64) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 16) as usize
}

#[test]
fn damaged_files_are_errors_or_models() {
    let folder = tempfile::tempdir().unwrap();
    let path = files(folder.path());
    let mut options = plain(folder.path(), "c.hop");
    (options.bbox, options.spacing) = (Some([0.0, 0.0, 64.0, 64.0]), Some(2.0));
    options.objects = vec![object(&path, &[[32.0, 32.0]], 10.0)];
    let mut state = 0x9e37_79b9_7f4a_7c15;
    let (mut good, mut bad) = (0, 0);

    for round in 0..2000 {
        let mut bytes = BOX.as_bytes().to_vec();
        for _ in 0..1 + next(&mut state) % 4 {
            let at = next(&mut state) % bytes.len();
            match next(&mut state) % 3 {
                0 => bytes[at] = b"0123456789.-e/ \nvf"[next(&mut state) % 18],
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"0123456789.-e/ \nvf"[next(&mut state) % 18]),
            }
        }

        fs::write(&path, &bytes).unwrap();
        let opened = crate::object::open_object(&options.objects[0]);

        // Whole builds take longer.
        let done = if round % 20 == 0 { build(&options, &Silent).is_ok() } else { opened.is_ok() };
        if done { good += 1 } else { bad += 1 }
    }

    assert!(good > 100 && bad > 100, "{good} {bad}");
}
