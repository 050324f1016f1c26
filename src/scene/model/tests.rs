use std::fs;
use std::io::Cursor;
use std::path::PathBuf;

use glam::{DMat3, DVec3, Vec3};

use super::*;
use crate::scene::model::{Origin, Size};
use crate::space::Attitude;
use hedgehop_testing::realdata;

const PLAIN: Fit = Fit {
    size: Size::Scale(1.0),
    is_z_up: false,
    turn: Attitude { yaw: 0.0, pitch: 0.0, roll: 0.0 },
    origin: Origin::Model,
};

/// A red and a blue texel, as PNG.
fn png() -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::RgbImage::from_raw(2, 1, vec![255, 0, 0, 0, 0, 255]).unwrap();
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A square of two triangles, 2 by 4 units, in a node that lifts it by 3, with a texture.
fn gltf_json(buffer: &str, image: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"translation":[0,3,0],"children":[1]}},{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
"textures":[{{"source":0}}],"images":[{{{image}}}],
"buffers":[{{{buffer}"byteLength":92}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},{{"buffer":0,"byteOffset":80,"byteLength":12}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,0,0],"max":[1,4,0]}},
{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},{{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}]}}"#
    )
}

fn buffer() -> Vec<u8> {
    let floats: [f32; 20] = [
        -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 4.0, 0.0, -1.0, 4.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0,
    ];
    let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
    floats
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .chain(indices.iter().flat_map(|index| index.to_le_bytes()))
        .collect()
}

fn glb() -> Vec<u8> {
    let chunk = |name: &[u8; 4], mut bytes: Vec<u8>, fill: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), fill);
        [&(bytes.len() as u32).to_le_bytes()[..], name, &bytes].concat()
    };
    let json = gltf_json("", r#""uri":"picture.png""#);
    let rest = [chunk(b"JSON", json.into_bytes(), b' '), chunk(b"BIN\0", buffer(), 0)].concat();
    [&b"glTF"[..], &2_u32.to_le_bytes(), &(12 + rest.len() as u32).to_le_bytes(), &rest].concat()
}

const OBJ: &str = "# a square\nmtllib square.mtl\nv -1 0 0\nv 1 0 0 \\\n\nv 1 4 0\nv -1 4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\no s\nusemtl red\nf 1/1/1 2/2/1 3/3/1 -1/-1/-1\n";
const MTL: &str = "newmtl red\nKd 1 0.5 0\nmap_Kd -clamp on -s 1 1 1 picture.png\n";

/// Three voxels in a row and one beside, within a scene that turns and shifts them.
fn vox() -> Vec<u8> {
    fn chunk(name: &[u8; 4], own: &[u8]) -> Vec<u8> {
        [&name[..], &(own.len() as u32).to_le_bytes(), &0_u32.to_le_bytes(), own].concat()
    }

    fn words(values: &[u32]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    fn text(text: &str) -> Vec<u8> {
        [&words(&[text.len() as u32]), text.as_bytes()].concat()
    }

    let voxels = [[0, 0, 0, 1], [1, 0, 0, 1], [2, 0, 0, 2], [1, 1, 0, 3]];
    // Rows: −Y, X, Z.
    let turn =
        [words(&[0, 0, 1, u32::MAX, 0, 1, 2]), text("_r"), text("17"), text("_t"), text("10 20 30")].concat();

    let chunks = [
        chunk(b"SIZE", &words(&[3, 2, 1])),
        chunk(b"XYZI", &[words(&[4]), voxels.concat()].concat()),
        chunk(b"nTRN", &turn),
        chunk(b"nSHP", &words(&[1, 0, 1, 0, 0])),
    ]
    .concat();

    [&b"VOX "[..], &words(&[150]), b"MAIN", &words(&[0, chunks.len() as u32]), &chunks].concat()
}

/// A folder with models of all formats, and what they need.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.put("picture.png", &png());
        folder.put("square.mtl", MTL.as_bytes());
        folder.put("square.obj", OBJ.as_bytes());
        folder.put("square.glb", &glb());
        folder.put("square.bin", &buffer());
        let json = gltf_json(r#""uri":"square.bin","#, r#""uri":"picture.png""#);
        folder.put("square.gltf", json.as_bytes());
        folder.put("four.vox", &vox());
        folder
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read(&self, name: &str, fit: &Fit) -> Result<Fitted> {
        Models::default().get(&self.path(name), fit, &[], &[], &mut blake3::Hasher::new())
    }

    /// The sentence that tells what is wrong with bytes under a name.
    fn refused(&self, name: &str, bytes: &[u8]) -> String {
        self.put(name, bytes);
        let message = self.read(name, &PLAIN).unwrap_err().to_string();
        assert!(message.contains(name) && !message.contains('\n'), "{message:?}");
        message
    }
}

#[test]
fn all_formats_tell_the_same_square() {
    let folder = Folder::new();
    for (name, low, high) in [
        ("square.glb", Vec3::new(-1.0, 0.0, 3.0), Vec3::new(1.0, 0.0, 7.0)),
        ("square.gltf", Vec3::new(-1.0, 0.0, 3.0), Vec3::new(1.0, 0.0, 7.0)),
        ("square.obj", Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 4.0)),
    ] {
        let read = folder.read(name, &PLAIN).unwrap();
        let corners = read.cut.rest.corners();
        assert!(
            (corners[0] - low).abs().max_element() < 1e-3 && (corners[1] - high).abs().max_element() < 1e-3,
            "{name}: {corners:?}"
        );
        assert_eq!(read.cut.rest.triangle_count(), 2);
        assert!(read.files.contains(&folder.path("picture.png")), "{name}: {:?}", read.files);
    }

    let fit = Fit { size: Size::Length(8.0), origin: Origin::Base, ..PLAIN };
    let [low, high] = folder.read("square.glb", &fit).unwrap().cut.rest.corners();
    assert!(
        (low - Vec3::new(-2.0, 0.0, 0.0)).length() < 1e-3
            && (high - Vec3::new(2.0, 0.0, 8.0)).length() < 1e-3
    );

    let fit = Fit {
        is_z_up: true,
        turn: Attitude { yaw: 90.0, ..Attitude::default() },
        origin: Origin::Middle,
        ..PLAIN
    };
    // Rightward it was 2, forward 4: turned to the right it is 4 and 2.
    let [low, high] = folder.read("square.obj", &fit).unwrap().cut.rest.corners();
    assert!(
        (low - Vec3::new(-2.0, -1.0, 0.0)).length() < 1e-3
            && (high - Vec3::new(2.0, 1.0, 0.0)).length() < 1e-3
    );
}

#[test]
fn fronts_look_forward() {
    let folder = Folder::new();
    let raw = |name: &str| {
        let mut hasher = blake3::Hasher::new();
        super::read(&folder.path(name), &mut hasher).unwrap().model.body_from_model
    };
    for (name, front) in [("square.glb", DVec3::Z), ("square.obj", DVec3::NEG_Z)] {
        let axes: DMat3 = raw(name);
        assert_eq!((axes * front, axes * DVec3::Y), (DVec3::Y, DVec3::Z), "{name}");
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn voxels_are_their_outer_faces() {
    let folder = Folder::new();
    let read = folder.read("four.vox", &PLAIN).unwrap();
    // 18 faces of the 24 are outside.
    assert_eq!(read.cut.rest.triangle_count(), 36);
    let [low, high] = read.cut.rest.corners();
    assert!((high - low - Vec3::new(2.0, 3.0, 1.0)).abs().max_element() < 1e-3, "{low} {high}");
    assert!((0.5 * (low + high) - Vec3::new(10.0, 20.0, 30.0)).abs().max_element() < 1.01, "{low} {high}");
}

#[test]
fn models_are_read_once_and_change_the_digest() {
    let folder = Folder::new();
    let digest = || {
        let (mut models, mut hasher) = (Models::default(), blake3::Hasher::new());
        let first = models.get(&folder.path("square.glb"), &PLAIN, &[], &[], &mut hasher).unwrap();
        let again = models.get(&folder.path("square.glb"), &PLAIN, &[], &[], &mut hasher).unwrap();
        assert!(Arc::ptr_eq(&first.cut, &again.cut));
        hasher.finalize()
    };
    let first = digest();
    assert_eq!(first, digest());
    let mut picture = Cursor::new(Vec::new());
    image::RgbImage::new(2, 1).write_to(&mut picture, image::ImageFormat::Png).unwrap();
    folder.put("picture.png", &picture.into_inner());
    assert_ne!(first, digest());
}

#[test]
fn mistakes_are_named() {
    let folder = Folder::new();
    let json = |from: &str, to: &str| {
        let json = gltf_json(r#""uri":"square.bin","#, r#""uri":"picture.png""#);
        assert!(json.contains(from), "{from}");
        json.replace(from, to)
    };

    let cases = [
        ("square.bin", "none.bin", "none.bin"),
        ("square.bin", "https://example.org/a.bin", "https"),
        ("picture.png", "square.bin", "PNG"),
        ("picture.png", "data:image/png;base64,AA", "PNG"),
        (r#""children":[1]"#, r#""children":[0]"#, "twice"),
        (r#""children":[1]"#, r#""children":[1,1]"#, "twice"),
        (r#""children":[1]"#, r#""children":[7]"#, "children"),
        (r#""count":6"#, r#""count":99999999999"#, "more than"),
        (r#""count":6"#, r#""count":3000"#, "cut short"),
        (r#""count":4,"type":"VEC3""#, r#""count":5999999,"type":"VEC3""#, "POSITION"),
        (r#""byteOffset":0"#, r#""byteOffset":18446744073709551615"#, "cut short"),
        (r#""byteLength":92"#, r#""byteLength":93"#, "cut short"),
        (r#""scenes":[{"nodes":[0]}]"#, r#""scenes":[]"#, "scene"),
        (r#""translation":[0,3,0]"#, r#""translation":[0,3e38,0],"scale":[1,1e38,1]"#, "km"),
        (
            r#""version":"2.0"}"#,
            r#""version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]"#,
            "extensionsRequired",
        ),
        (r#""mesh":0"#, r#""mesh":9223372036854775808"#, "9223372036854775808"),
        (r#""POSITION":0"#, r#""POSITION":4294967296"#, "4294967296"),
        (r#""nodes":[0]"#, r#""nodes":[4294967296]"#, "4294967296"),
        (r#""componentType":5126"#, r#""componentType":4294972422"#, "4294972422"),
    ];

    for (from, to, told) in cases {
        let message = folder.refused("wrong.gltf", json(from, to).as_bytes());
        assert!(message.contains(told), "{to}: {message}");
    }

    let obj = [
        ("v 1 0 0", "v 1 nan 0", "line 4: nan"),
        ("v 1 0 0", "v 1 0", "line 4"),
        ("v 1 4 0", "v 1 4 x", "line 6"),
        ("f 1/1/1", "f 9/1/1", "line 15: \"9/1/1\" names number 9 of 4"),
        ("-1/-1/-1", "-5/-1/-1", "line 15"),
        ("-1/-1/-1", "9223372036854775807", "line 15"),
        ("-1/-1/-1", "0", "line 15"),
        ("f ", "g ", "no faces"),
        ("square.mtl", "none.mtl", "none.mtl"),
        ("square.mtl", "file:///etc/passwd", "file beside"),
    ];

    for (from, to, told) in obj {
        let message = folder.refused("wrong.obj", OBJ.replace(from, to).as_bytes());
        assert!(message.contains(told), "{to}: {message}");
    }

    folder.put("square.mtl", b"newmtl red\nKd 1\n");
    assert!(folder.refused("wrong.obj", OBJ.as_bytes()).contains("square.mtl, line 2"));
    assert!(folder.refused("wrong.ply", b"ply").contains(".glb"));
    for name in ["wrong.ply", "wrong.gltf"] {
        let draco = r#""version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]"#;
        folder.put("wrong.gltf", json(r#""version":"2.0"}"#, draco).as_bytes());
        let error = folder.read(name, &PLAIN).unwrap_err();
        assert!(matches!(error, Error::Unsupported { .. }), "{name}: {error}");
    }

    // Numbers that are no indices may be as large as they like.
    let large = json(r#""version":"2.0"}"#, r#""version":"2.0"},"extras":{"mesh":9223372036854775808}"#);
    folder.put("large.gltf", large.as_bytes());
    assert!(folder.read("large.gltf", &PLAIN).is_ok());

    let nested = [
        &b"VOX "[..],
        &[150, 0, 0, 0],
        b"MAIN",
        &[0; 4],
        &24_u32.to_le_bytes(),
        b"MAIN",
        &[0; 4],
        &12_u32.to_le_bytes(),
        b"MAIN",
        &[0; 8],
    ]
    .concat();

    assert!(folder.refused("wrong.vox", &nested).contains("chunk"));
    // A turn that is none: the reader of the format would panic.
    let mut turned = vox();
    let at = turned.windows(2).position(|pair| pair == b"17").unwrap();
    turned[at + 1] = b'5';
    assert!(folder.refused("wrong.vox", &turned).contains("turn"));

    for odd in ["10 20 3x", "10 20+30", "10 20 \t ", "1 20 3 4"] {
        let mut moved = vox();
        let at = moved.windows(8).position(|bytes| bytes == b"10 20 30").unwrap();
        moved[at..at + 8].copy_from_slice(format!("{odd:8}").as_bytes());
        assert!(folder.refused("wrong.vox", &moved).contains("no place"), "{odd:?}");
    }
}

#[test]
fn files_that_models_need_and_that_are_not_there_are_missing_and_not_wrong() {
    let folder = Folder::new();
    fs::remove_file(folder.path("picture.png")).unwrap();
    folder.put("no-list.obj", OBJ.replace("square.mtl", "none.mtl").as_bytes());
    for (model, needs) in
        [("square.obj", "picture.png"), ("square.gltf", "picture.png"), ("no-list.obj", "none.mtl")]
    {
        let error = folder.read(model, &PLAIN).unwrap_err();
        assert!(matches!(error, Error::Io { .. }), "{error:?}");
        let message = error.to_string();
        assert!(message.contains(needs) && message.contains(model), "{message}");
    }
}

/// A generator of numbers that look like chance (Marsaglia, "Xorshift RNGs", 2003).
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}

/// Damages a file in many ways; how many of them were refused, and how many read.
fn damage(folder: &Folder, name: &str, bytes: &[u8], times: usize) -> [usize; 2] {
    let mut chance = Chance(0x9e37_79b9_7f4a_7c15);
    let mut count = [0; 2];
    for time in 0..times {
        let mut changed = bytes.to_vec();
        match time % 4 {
            0 => changed.truncate(time * bytes.len() / times),
            1 => changed[chance.below(bytes.len())] = chance.below(256) as u8,
            2 => {
                for _ in 0..4 {
                    changed[chance.below(bytes.len())] ^= 1 << chance.below(8);
                }
            }
            _ => {
                let (from, to) = (chance.below(bytes.len()), chance.below(bytes.len()));
                let count = (1 + chance.below(64)).min(bytes.len() - from.max(to));
                changed.copy_within(from..from + count, to);
            }
        }

        folder.put(name, &changed);
        match folder.read(name, &PLAIN) {
            Ok(read) => {
                count[1] += 1;
                // What was read can be looked at.
                assert!(read.cut.rest.corners().iter().all(|corner| corner.is_finite()));
            }
            Err(error) => {
                count[0] += 1;
                let message = error.to_string();
                assert!(
                    message.contains(&*folder.0.path().to_string_lossy()) && !message.contains('\n'),
                    "{message:?}"
                );
            }
        }
    }

    count
}

#[test]
fn damaged_models_are_read_or_refused_by_a_sentence() {
    let folder = Folder::new();
    let json = gltf_json(r#""uri":"square.bin","#, r#""uri":"picture.png""#);
    let models = [
        ("a.glb", glb()),
        ("b.gltf", json.into_bytes()),
        ("c.obj", OBJ.as_bytes().to_vec()),
        ("d.vox", vox()),
        ("picture.png", png()),
        ("square.mtl", MTL.as_bytes().to_vec()),
    ];

    for (name, bytes) in models {
        if name == "picture.png" || name == "square.mtl" {
            // Through the model that needs it.
            let mut chance = Chance(77);
            for _ in 0..200 {
                let mut changed = bytes.clone();
                changed[chance.below(bytes.len())] = chance.below(256) as u8;
                changed.truncate(1 + chance.below(2 * bytes.len()));
                folder.put(name, &changed);
                if let Err(error) = folder.read("square.obj", &PLAIN) {
                    assert!(error.to_string().contains("square.obj"), "{error}");
                }
            }

            folder.put(name, &bytes);
            continue;
        }

        let [refused, read] = damage(&folder, name, &bytes, 600);
        assert!(refused > 100 && read > 0, "{name}: {refused} {read}");
    }
}

#[test]
fn real_models_are_read_whole_and_refused_damaged() {
    let Some(models) = realdata().map(|folder| folder.join("models")).filter(|folder| folder.is_dir()) else {
        return;
    };

    let folder = Folder::new();
    fs::create_dir(folder.path("Textures")).unwrap();
    fs::copy(models.join("kenney/racing/Textures/colormap.png"), folder.path("Textures/colormap.png"))
        .unwrap();

    for (name, triangles) in [
        ("airplane/airplane.glb", 2452),
        ("airplane/airplane.obj", 2452),
        ("kenney/racing/vehicle-truck-red.glb", 938),
        ("kenney/city/building-small-a.glb", 440),
    ] {
        let bytes = fs::read(models.join(name)).unwrap();
        let short = name.rsplit('/').next().unwrap();
        folder.put(short, &bytes);
        let read = folder.read(short, &PLAIN).unwrap();
        assert_eq!(read.cut.rest.triangle_count(), triangles, "{name}");
        let [refused, _] = damage(&folder, short, &bytes, 60);
        assert!(refused > 10, "{name}: {refused}");
    }
}

#[test]
fn too_many_triangles_are_refused_before_they_are_read() {
    let folder = Folder::new();
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    text.push_str(&"f 1 2 3 1 2 3 1 2 3 1 2 3\n".repeat(MOST_TRIANGLES / 10 + 1));
    let message = folder.refused("many.obj", text.as_bytes());
    assert!(message.contains("more than the 2000000"), "{message}");
    // A texture of 16384 × 16384 texels in a few bytes.
    let mut bomb = png();
    bomb[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.finalize().to_be_bytes());
    folder.put("picture.png", &bomb);
    let message = folder.read("square.glb", &PLAIN).unwrap_err().to_string();
    assert!(message.contains("square.glb") && message.contains("texels"), "{message}");
}
