//! Labels of pixels: `--labels`.

use std::fs;
use std::io::BufReader;
use std::path::Path;

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use tempfile::TempDir;

use crate::common::{ends, run};
use hedgehop::voxel::{Arrays, Attributes, Grid, MaterialRecord, Metadata, write_arrays};

const SCENE: &str = r##"
[[object]]
name = "mast"
shape = "cylinder"
radius_m = 8
height_m = 70
at = [800, 900, 0]

[[object]]
name = "car"
shape = "box"
size_m = [20, 40, 15]
at = [700, 700, 0]

[[object.part]]
name = "lid"
shape = "disc"
radius_m = 19
offset_m = [0, 0, 25]
"##;

/// A folder with a database of a plain, of grass, rock and a material of its own, a path of three frames, and a scene.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let grid = Grid { nx: 160, ny: 160, spacing: 10.0, origin: glam::DVec2::ZERO };
    let (heights, colours) = (vec![100.0; 160 * 160], vec![[90, 140, 60]; 160 * 160]);
    let attributes: Vec<_> = (0..160 * 160)
        .map(|post| Attributes { material: [14, 19, 200][post % 160 / 5 % 3], ..Attributes::default() })
        .collect();
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: Some(&attributes) };
    let own =
        MaterialRecord { number: 200, name: "lava".into(), like: Some("rock".into()), colour: [200, 40, 10] };
    let metadata = Metadata { crs_name: "local".into(), materials: vec![own], ..Metadata::default() };
    write_arrays(&folder.path().join("area.hop"), &arrays, &metadata, false).expect("a database");
    let path = "t_s,x_m,y_m,alt_agl_m,yaw_deg,pitch_deg\n0,700,400,80,0,-10\n1,740,440,60,5,-12\n";
    fs::write(folder.path().join("path.csv"), path).expect("a path");
    fs::write(folder.path().join("scene.toml"), SCENE).expect("a scene");
    folder
}

const FLY: &str = "render area.hop --path path.csv --fps 2 --size 160x90 --scene scene.toml";

/// The channel `id` of an EXR.
fn ids(path: &Path) -> Vec<u32> {
    let image = read_first_flat_layer_from_file(path).expect("an EXR");
    let channels = image.layer_data.channel_data.list;
    let id = channels.into_iter().find(|channel| channel.name.eq_case_insensitive("id")).expect("ids");
    match id.sample_data {
        FlatSamples::U32(ids) => ids,
        other => panic!("{other:?}"),
    }
}

/// Bytes of the pixels of a PNG as they are stored, and what it says of itself.
fn stored(path: &Path) -> (Vec<u8>, png::Info<'static>) {
    let mut decoder = png::Decoder::new(BufReader::new(fs::File::open(path).expect("a file")));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("pixels");
    (pixels, reader.info().clone())
}

#[test]
fn labels_are_the_ids_of_exr_frames() {
    let site = site();
    let fly = |args: &str| ends(&run(&site, &format!("{FLY} {args}")), 0);
    fly("-o exr/####.exr");
    fly("--labels semantic -o semantic/####.png");
    fly("--labels instance -j 1 -o instance/####.png");
    let palette = fs::read_to_string(site.path().join("semantic/palette.json")).expect("a palette");
    let palette: serde_json::Value = serde_json::from_str(&palette).expect("JSON");
    assert_eq!(
        palette["instance"],
        serde_json::json!([{ "index": 1, "name": "car" }, { "index": 2, "name": "mast" }])
    );

    let mut seen = std::collections::BTreeSet::new();
    for number in 1..=3 {
        let file = |folder: &str, kind: &str| site.path().join(format!("{folder}/{number:04}.{kind}"));
        let ids = ids(&file("exr", "exr"));
        let (semantic, info) = stored(&file("semantic", "png"));
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Indexed, png::BitDepth::Eight));
        let (instance, grey) = stored(&file("instance", "png"));
        assert_eq!((grey.color_type, grey.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Sixteen));
        assert_eq!((semantic.len(), instance.len()), (ids.len(), 2 * ids.len()));

        for ((id, label), instance) in ids.iter().zip(semantic).zip(instance.chunks_exact(2)) {
            // The car, the mast, and the lid of the car, which is part of it.
            let expected = match *id {
                u32::MAX => (255, 0),
                0x8000_0000 | 0x8000_0002 => (254, 1),
                0x8000_0001 => (254, 2),
                ground => ((ground >> 8) as u8, 0),
            };
            assert_eq!((label, u16::from_be_bytes([instance[0], instance[1]])), expected, "{id:x}");
            seen.insert(*id);
        }

        let plte = info.palette.expect("a palette");
        for entry in palette["semantic"].as_array().expect("entries") {
            let index = 3 * entry["index"].as_u64().expect("an index") as usize;
            assert_eq!(serde_json::json!(plte[index..index + 3]), entry["colour"], "{entry}");
        }
    }
    for id in [14 << 8, 19 << 8, 200 << 8, 0x8000_0000, 0x8000_0001, 0x8000_0002, u32::MAX] {
        assert!(seen.contains(&id), "{id:x} is not in sight");
    }
    let lava = serde_json::json!("lava");
    assert!(palette["semantic"].as_array().expect("entries").iter().any(|entry| entry["name"] == lava));
}

#[test]
fn labels_are_kept_checked_and_no_pictures() {
    let site = site();
    let fly = |args: &str| run(&site, &format!("{FLY} {args}"));
    ends(&fly("--labels semantic -o labels/####.png"), 0);
    let whole = fs::read(site.path().join("labels/0002.png")).expect("labels");
    assert!(ends(&fly("--labels semantic -o labels/####.png --skip-existing"), 0).contains("kept 3"));
    fs::write(site.path().join("labels/0002.png"), &whole[..whole.len() - 1]).expect("labels");
    assert!(ends(&run(&site, "verify labels"), 6).contains("0002.png"));
    let said = ends(&fly("--labels semantic -o labels/####.png --skip-existing"), 0);
    assert!(said.contains("rendered 1 frame"), "{said}");
    assert!(fs::read(site.path().join("labels/0002.png")).expect("labels") == whole);

    // A folder of pictures, or of other labels, is another render's.
    for other in ["", "--labels instance"] {
        let said = ends(&fly(&format!("{other} -o labels/####.png")), 2);
        assert!(said.contains("labels is"), "{said}");
    }
    ends(&run(&site, "contact-sheet labels -o sheet.png"), 0);
    let said = ends(&fly("--labels semantic --exposure 1 --hud=all -o light/####.png"), 0);
    assert!(said.contains("labels are no light"), "{said}");
    assert!(fs::read(site.path().join("light/0002.png")).expect("labels") == whole);
}

#[test]
fn labels_that_would_be_none_are_refused() {
    let site = site();
    fs::create_dir(site.path().join("taken")).expect("a folder");
    fs::write(site.path().join("taken/palette.json"), "[]").expect("a file");
    for (args, part) in [
        ("--labels semantic -o no/####.exr", "--labels are PNG"),
        ("--labels semantic -o no.y4m", "--labels are PNG"),
        ("--labels semantic --video no.mp4", "--labels are PNG"),
        ("--labels semantic --video no.mp4 -o no/####.png", "--video is made from pictures"),
        ("--labels semantic --antialias 2 -o no/####.png", "one ray a pixel"),
        ("--labels instance --shutter 180 -o no/####.png", "one ray a pixel"),
        ("--labels instance --aov motion -o no/####.png", "--aov adds channels to EXR"),
        ("--labels depth -o no/####.png", "[possible values: semantic, instance]"),
        ("--labels semantic -o taken/####.png", "palette.json: it is not of a render"),
    ] {
        let said = ends(&run(&site, &format!("{FLY} {args}")), 2);
        assert!(said.contains(part), "{args}: {said}");
    }
    assert!(!site.path().join("no").exists());
    ends(&run(&site, "render area.hop --eye 700,400,180 --labels semantic -o one/labels.png"), 0);
    assert!(site.path().join("one/labels.png").exists() && site.path().join("one/palette.json").exists());
}
