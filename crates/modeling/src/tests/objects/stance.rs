//! How models stand: a block with a tower on its north-eastern corner, of every format and in every stance.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec3, IVec3};

use super::plain;
use crate::build;
use crate::object::{ObjectFile, Stance};
use crate::tests::support::Area;
use hedgehop::voxel::{BlockSpans, Cut, PAGE_SIDE, PageId, PageSource, Span, SpanTable};
use hedgehop_base::progress::Silent;

/// Least and greatest corner: eastward, northward, upward.
type Cuboid = [[i32; 3]; 2];

/// 10 by 6, 2 high.
const BLOCK: Cuboid = [[-5, -3, 0], [5, 3, 2]];
/// 4 by 2, on the block's north-eastern corner, 7 high.
const TOWER: Cuboid = [[1, 1, 2], [5, 3, 7]];
/// A post, and a hat on it: 8 high.
const POST: Cuboid = [[-1, -1, 0], [1, 1, 6]];
const HAT: Cuboid = [[-2, -2, 6], [2, 2, 8]];

/// Where walls cut voxels.
const PLACE: [f64; 2] = [100.3, 140.2];
/// Where they lie between voxels.
const EVEN: [f64; 2] = [100.0, 140.0];

/// Sides of cuboids, counterclockwise as seen from outside; those of one direction after the other.
fn sides(cuboids: &[Cuboid]) -> Vec<[DVec3; 4]> {
    let mut all = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1), (axis, -1)]) {
        for [low, high] in cuboids.iter().map(|corners| corners.map(IVec3::from_array)) {
            let [out, along, across] = [0, 1, 2].map(|step| IVec3::AXES[(axis + step) % 3] * (high - low));
            let base = if sign > 0 { low + out } else { low };
            let mut side = [base, base + along, base + along + across, base + across];
            if sign < 0 {
                side.reverse();
            }
            all.push(side.map(|corner| corner.as_dvec3()));
        }
    }
    all
}

/// Wavefront, whose axes are what `axes` makes of east, north and up.
fn obj(path: PathBuf, cuboids: &[Cuboid], axes: fn(DVec3) -> DVec3) -> PathBuf {
    let mut text = String::new();
    for side in sides(cuboids) {
        side.map(axes).iter().for_each(|at| text += &format!("v {} {} {}\n", at.x, at.y, at.z));
        text += "f -4 -3 -2 -1\n";
    }
    fs::write(&path, text).unwrap();
    path
}

/// As the format has it: up is Y, and the front looks along −Z.
fn y_up(at: DVec3) -> DVec3 {
    DVec3::new(at.x, at.z, -at.y)
}

/// glTF, whose front looks along Z, so that east is −X.
fn glb(path: PathBuf, cuboids: &[Cuboid]) -> PathBuf {
    let corners = sides(cuboids).into_iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]);
    let places: Vec<[f32; 3]> = corners.map(|at| [-at.x as f32, at.z as f32, at.y as f32]).collect();
    let least = |axis: usize| places.iter().map(|place| place[axis]).fold(f32::INFINITY, f32::min);
    let most = |axis: usize| places.iter().map(|place| place[axis]).fold(f32::NEG_INFINITY, f32::max);
    let (low, high) = ([0, 1, 2].map(least), [0, 1, 2].map(most));
    let buffer: Vec<u8> = places.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let (count, length) = (places.len(), buffer.len());

    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"buffers":[{{"byteLength":{length}}}],
"bufferViews":[{{"buffer":0,"byteLength":{length}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3","min":{low:?},"max":{high:?}}}]}}"#
    );
    let chunk = |name: &[u8; 4], mut bytes: Vec<u8>| {
        bytes.resize(bytes.len().next_multiple_of(4), b' ');
        [&(bytes.len() as u32).to_le_bytes()[..], name, &bytes].concat()
    };
    let rest = [chunk(b"JSON", json.into_bytes()), chunk(b"BIN\0", buffer)].concat();
    let size = 12 + rest.len() as u32;
    fs::write(&path, [&b"glTF"[..], &2_u32.to_le_bytes(), &size.to_le_bytes(), &rest].concat()).unwrap();

    path
}

/// MagicaVoxel: a voxel for each unit.
fn vox(path: PathBuf, cuboids: &[Cuboid]) -> PathBuf {
    let words = |values: &[u32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let chunk = |name: &[u8; 4], own: Vec<u8>| [&name[..], &words(&[own.len() as u32, 0]), &own].concat();
    let corners = |index: usize| cuboids.iter().map(move |cuboid| IVec3::from_array(cuboid[index]));
    let low = corners(0).reduce(IVec3::min).unwrap();
    let size = corners(1).reduce(IVec3::max).unwrap() - low;
    let mut cells = Vec::new();

    for [from, to] in cuboids {
        for (x, y) in (from[0]..to[0]).flat_map(|x| (from[1]..to[1]).map(move |y| (x, y))) {
            cells.extend((from[2]..to[2]).map(|z| {
                let cell = IVec3::new(x, y, z) - low;
                [cell.x as u8, cell.y as u8, cell.z as u8, 1]
            }));
        }
    }

    let chunks = [
        chunk(b"SIZE", words(&size.to_array().map(|side| side as u32))),
        chunk(b"XYZI", [words(&[cells.len() as u32]), cells.concat()].concat()),
    ]
    .concat();
    let head = [&b"VOX "[..], &words(&[150]), b"MAIN", &words(&[0, chunks.len() as u32])].concat();
    fs::write(&path, [head, chunks].concat()).unwrap();

    path
}

fn standing(paths: &[PathBuf], place: [f64; 2], stance: Stance) -> ObjectFile {
    ObjectFile { paths: paths.to_vec(), places: vec![place], stance, ..ObjectFile::default() }
}

fn built(folder: &Path, object: ObjectFile) -> Area {
    let mut options = plain(folder, "stance.hop");
    options.bbox = Some([0.0, 0.0, 256.0, 256.0]);
    options.objects = vec![object];
    build(&options, &Silent).unwrap();
    Area::open(&options.output).unwrap()
}

/// What stands on a voxel, placed objects included.
fn spans(area: &Area, x: u32, y: u32) -> Vec<Span> {
    let id = PageId { level: 0, px: x / PAGE_SIDE, py: y / PAGE_SIDE }.bare();
    let Some(view) = area.pages.spans(id).unwrap() else { return Vec::new() };
    let header = area.pages.header();
    let mut block = BlockSpans::default();
    let rise = SpanTable::rise(header.heights, area.grid.spacing);
    block.gather(&view, &header.objects, [x % PAGE_SIDE, y % PAGE_SIDE], rise);
    block.of(x % PAGE_SIDE, y % PAGE_SIDE).to_vec()
}

/// Fails unless the same stands around two voxels, but for a step of height and one of where walls lie; `shift` leads from the one to the other.
fn alike(what: &str, [one, other]: [&Area; 2], [x, y]: [u32; 2], shift: [u32; 2]) {
    let mut there = 0;
    for (x, y) in (y - 10..y + 10).flat_map(|y| (x - 10..x + 10).map(move |x| (x, y))) {
        let [found, wanted] = [spans(other, x + shift[0], y + shift[1]), spans(one, x, y)];
        assert_eq!(found.len(), wanted.len(), "{what}: {x} {y}: {found:?} {wanted:?}");
        for (found, wanted) in found.iter().zip(&wanted) {
            let Span { high, cuts, top, side, .. } = *wanted;
            let nearly = Span { high, cuts, top, side, ..*found };
            let is_cut_near = found.cuts.iter().zip(&cuts).all(|(found, wanted)| {
                let apart = (found.distance() - wanted.distance()).abs() * Cut::STEPS;
                found.facing == wanted.facing && apart <= 1.0
            });
            let is_near = found.high.abs_diff(high) <= 1 && is_cut_near;
            assert!(is_near && nearly == *wanted, "{what}: {x} {y}: {found:?} {wanted:?}");
        }
        there += wanted.len();
    }
    assert!(there > 30, "{what}: {there}");
}

/// Fails unless voxels have these heights.
fn heights(what: &str, area: &Area, expected: &[(u32, u32, f64)]) {
    for (x, y, height) in expected {
        let found = area.height(*x, *y).unwrap();
        assert!((found - height).abs() <= 2.0 * area.step(), "{what}: {x} {y}: {found}, not {height}");
    }
}

/// Lower ends of what stands on a voxel, metres; of what stands on the ground there is none.
fn lows(area: &Area, x: u32, y: u32) -> Vec<Option<f64>> {
    let code = area.pages.header().heights;
    let of = |span: &Span| (span.low != Span::GROUND).then(|| code.decode(span.low).unwrap());
    spans(area, x, y).iter().map(of).collect()
}

#[test]
fn a_model_is_the_same_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let all = [BLOCK, TOWER];
    let stance = |scale: f64| Stance { scale, ..Stance::default() };
    let wavefront = built(folder, standing(&[obj(folder.join("a.obj"), &all, y_up)], PLACE, stance(1.0)));
    let gltf = built(folder, standing(&[glb(folder.join("a.glb"), &all)], PLACE, stance(1.0)));
    // Its voxels are of 10 cm.
    let voxels = built(folder, standing(&[vox(folder.join("a.vox"), &all)], PLACE, stance(10.0)));
    for (what, area) in [("obj", &wavefront), ("glb", &gltf), ("vox", &voxels)] {
        let tower = [(102, 142, 107.0), (104, 142, 107.0)];
        let block = [(97, 142, 102.0), (97, 138, 102.0), (104, 138, 102.0)];
        let beside = [(106, 142, 100.0), (94, 138, 100.0), (104, 144, 100.0), (104, 136, 100.0)];
        heights(what, area, &[&tower[..], &block, &beside].concat());
        alike(what, [&wavefront, area], [100, 140], [0, 0]);
    }
}

#[test]
fn a_scale_is_that_of_all_sides() {
    let folder = tempfile::tempdir().unwrap();
    let path = obj(folder.path().join("a.obj"), &[BLOCK, TOWER], y_up);
    let stance = Stance { scale: 2.0, ..Stance::default() };
    let area = built(folder.path(), standing(&[path], PLACE, stance));
    let tower = [(103, 143, 114.0), (109, 145, 114.0)];
    let block = [(91, 135, 104.0), (91, 145, 104.0), (109, 135, 104.0)];
    let beside = [(111, 143, 100.0), (89, 140, 100.0), (100, 147, 100.0), (100, 133, 100.0)];
    heights("scale", &area, &[&tower[..], &block, &beside].concat());
}

#[test]
fn a_post_with_a_hat_is_laid_down() {
    let folder = tempfile::tempdir().unwrap();
    let path = obj(folder.path().join("post.obj"), &[POST, HAT], y_up);
    let laid = |pitch_deg: f64, roll_deg: f64| {
        let stance = Stance { pitch_deg, roll_deg, ..Stance::default() };
        built(folder.path(), standing(std::slice::from_ref(&path), EVEN, stance))
    };
    heights("upright", &laid(0.0, 0.0), &[(99, 139, 108.0), (101, 141, 108.0), (100, 143, 100.0)]);

    // Its front goes up, and its top to the south. The hat lies on the ground, and the post a metre above it.
    let pitched = laid(90.0, 0.0);
    let hat = [(98, 136, 104.0), (101, 137, 104.0), (97, 136, 100.0), (99, 135, 100.0)];
    let post = [(99, 138, 103.0), (100, 143, 103.0), (98, 140, 100.0), (101, 140, 100.0), (99, 144, 100.0)];
    heights("pitch", &pitched, &[&hat[..], &post].concat());

    // Its right side goes down, and its top to the east.
    let rolled = laid(0.0, 90.0);
    let hat = [(102, 138, 104.0), (103, 141, 104.0), (102, 137, 100.0), (104, 140, 100.0)];
    let post = [(96, 139, 103.0), (101, 140, 103.0), (99, 138, 100.0), (99, 141, 100.0), (95, 140, 100.0)];
    heights("roll", &rolled, &[&hat[..], &post].concat());

    for (what, area, [x, y], hat) in
        [("pitch", &pitched, [99, 141], [99, 136]), ("roll", &rolled, [98, 140], [102, 140])]
    {
        let [Some(low)] = lows(area, x, y)[..] else { panic!("{what}: {:?}", lows(area, x, y)) };
        assert!((low - 101.0).abs() <= 2.0 * area.step(), "{what}: {low}");
        assert_eq!(lows(area, hat[0], hat[1]), [None], "{what}");
    }
}

#[test]
fn up_is_the_axis_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let all = [BLOCK, TOWER];
    let up = |is_z_up: Option<bool>, scale: f64| Stance { is_z_up, scale, ..Stance::default() };
    let plain = built(folder, standing(&[obj(folder.join("a.obj"), &all, y_up)], PLACE, up(None, 1.0)));
    let path = obj(folder.join("b.obj"), &all, |at| at);
    alike("z", [&plain, &built(folder, standing(&[path], PLACE, up(Some(true), 1.0)))], [100, 140], [0, 0]);
    // Voxels are piled along Z: now the block stands on its long side in the north, and the tower reaches out southward from its upper part.
    let path = vox(folder.join("a.vox"), &all);
    let area = built(folder, standing(&[path], [100.0, 140.5], up(Some(false), 10.0)));
    let block = [(95, 142, 106.0), (104, 143, 106.0), (100, 144, 100.0), (94, 142, 100.0), (97, 141, 100.0)];
    let tower =
        [(101, 137, 106.0), (104, 141, 106.0), (100, 139, 100.0), (105, 139, 100.0), (103, 136, 100.0)];
    heights("y", &area, &[&block[..], &tower].concat());
    let [Some(low)] = lows(&area, 103, 139)[..] else { panic!("{:?}", lows(&area, 103, 139)) };
    assert!((low - 104.0).abs() <= 2.0 * area.step(), "{low}");
}

#[test]
fn what_is_lifted_leaves_the_ground_and_what_is_sunk_stays_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = obj(folder.path().join("a.obj"), &[BLOCK, TOWER], y_up);
    let at = |up_m: f64| {
        let object = standing(std::slice::from_ref(&path), PLACE, Stance::default());
        built(folder.path(), ObjectFile { up_m, ..object })
    };
    let (lifted, sunk) = (at(3.0), at(-0.5));
    heights("lifted", &lifted, &[(104, 142, 110.0), (97, 138, 105.0), (106, 142, 100.0)]);
    heights("sunk", &sunk, &[(104, 142, 106.5), (97, 138, 101.5), (106, 142, 100.0)]);
    let [Some(low)] = lows(&lifted, 97, 138)[..] else { panic!("{:?}", lows(&lifted, 97, 138)) };
    assert!((low - 103.0).abs() <= 2.0 * lifted.step(), "{low}");
    assert_eq!(lows(&sunk, 97, 138), [None]);
}

#[test]
fn files_of_one_object_share_their_origin() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let whole = obj(folder.join("a.obj"), &[BLOCK, TOWER], y_up);
    let parts = [obj(folder.join("b.obj"), &[BLOCK], y_up), glb(folder.join("c.glb"), &[TOWER])];
    let whole = built(folder, standing(&[whole], PLACE, Stance::default()));
    let parts = built(folder, standing(&parts, PLACE, Stance::default()));
    heights("parts", &parts, &[(104, 142, 107.0), (97, 142, 102.0), (104, 138, 102.0)]);
    alike("parts", [&whole, &parts], [100, 140], [0, 0]);
}

#[test]
fn what_one_sees_through_is_whole_or_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text =
        |name: &str, cuboid: Cuboid| fs::read_to_string(obj(folder.join(name), &[cuboid], y_up)).unwrap();
    let path = folder.join("c.obj");
    let tower = format!("mtllib clear.mtl\nusemtl clear\n{}", text("b.obj", TOWER));
    fs::write(&path, text("a.obj", BLOCK) + &tower).unwrap();
    for (says, height) in [("d 0.4", 102.0), ("d 0.6", 107.0), ("Tr 0.6", 102.0), ("Tr 0.4", 107.0)] {
        fs::write(folder.join("clear.mtl"), format!("newmtl clear\nKd 0.2 0.3 0.3\n{says}\n")).unwrap();
        let area = built(folder, standing(std::slice::from_ref(&path), PLACE, Stance::default()));
        heights(says, &area, &[(104, 142, height), (97, 138, 102.0)]);
        assert!(spans(&area, 104, 142).iter().all(|span| span.opacity() == 1.0), "{says}");
    }
}

#[test]
fn many_places_of_an_object_share_its_form() {
    let folder = tempfile::tempdir().unwrap();
    let path = obj(folder.path().join("a.obj"), &[BLOCK, TOWER], y_up);
    let place = |index: u32| [f64::from(20 + index % 13 * 18) + 0.3, f64::from(40 + index / 13 * 40) + 0.8];
    let of = |places: Vec<[f64; 2]>| {
        let object = standing(std::slice::from_ref(&path), PLACE, Stance::default());
        built(folder.path(), ObjectFile { places, ..object })
    };

    // One alone, in the middle of a voxel.
    let middle = of(vec![[20.5, 40.5]]);
    let (shared, exact) = (of((0..65).map(place).collect()), of((0..64).map(place).collect()));
    assert_eq!((shared.pages.header().objects.len(), exact.pages.header().objects.len()), (1, 0));

    for index in 0..65 {
        let shift = [index % 13 * 18, index / 13 * 40];
        // Neighbours stand 18 m apart.
        let [x, y] = [20 + shift[0], 40 + shift[1]];
        let tower = [(x + 3, y + 2, 107.0), (x - 3, y + 2, 102.0), (x + 3, y - 2, 102.0)];
        heights("shared", &shared, &[&tower[..], &[(x + 7, y, 100.0), (x, y + 5, 100.0)]].concat());

        for (x, y) in (y - 5..y + 6).flat_map(|y| (x - 7..x + 8).map(move |x| (x, y))) {
            let wanted = spans(&middle, x - shift[0], y - shift[1]);
            let found = spans(&shared, x, y);
            assert_eq!(found.len(), wanted.len(), "{index}: {x} {y}");
            let near =
                |(a, b): (&Span, &Span)| a.high.abs_diff(b.high) <= 1 && Span { high: b.high, ..*a } == *b;
            assert!(found.iter().zip(&wanted).all(near), "{index}: {x} {y}: {found:?} {wanted:?}");
        }
    }

    // Exactly where they are said to be, walls lie elsewhere in their voxels.
    assert_ne!(spans(&exact, 25, 40), spans(&middle, 25, 40));
}
