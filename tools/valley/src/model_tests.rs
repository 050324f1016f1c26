//! The models, and what lies on the eastern slope, against their files and the valley.

use std::collections::BTreeMap;

use glam::{DVec2, dvec2};

use crate::features::{Feature, Geometry, Tag};
use crate::geotiff::ORIGIN;
use crate::grid::around;
use crate::shapefile::{self, Shapefile};
use crate::tests::SAMPLE;
use crate::{chapel, gravel, mesh, path, roads, sites, vineyard, voxels};

fn little(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

fn big(bytes: &[u8], at: usize) -> usize {
    u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

fn real(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

#[test]
fn chapel_is_closed_and_its_faces_look_outward() {
    for part in chapel::build() {
        let mut sides = BTreeMap::new();
        let mut volume = 0.0;
        for [a, b, c] in part.faces() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (from.map(f32::to_bits), to.map(f32::to_bits));
                *sides.entry((from, to)).or_insert(0) += 1;
                *sides.entry((to, from)).or_insert(0) -= 1;
            }
            volume += a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
        }
        assert!(sides.values().all(|&open| open == 0), "{} has an open side", part.name);
        assert!(volume > 0.0, "{} is inside out: {volume}", part.name);
    }
}

#[test]
fn model_of_faces_has_the_lengths_that_it_states() {
    let bytes = mesh::encode("chapel", &chapel::build()).unwrap();
    assert!(bytes.len() < 20_000, "{} bytes", bytes.len());
    assert_eq!((&bytes[..4], little(&bytes, 4), little(&bytes, 8)), (b"glTF".as_slice(), 2, bytes.len()));
    let text = little(&bytes, 12);
    let buffer = 20 + text;
    assert_eq!(
        (text % 4, &bytes[16..20], &bytes[buffer + 4..buffer + 8]),
        (0, b"JSON".as_slice(), b"BIN\0".as_slice())
    );
    assert_eq!(buffer + 8 + little(&bytes, buffer), bytes.len());
    let text = std::str::from_utf8(&bytes[20..buffer]).unwrap();
    assert!(text.contains(&format!(r#""buffers":[{{"byteLength":{}}}]"#, little(&bytes, buffer))), "{text}");
    for pair in ["{}", "[]"].map(|pair| pair.split_at(1)) {
        assert_eq!(text.matches(pair.0).count(), text.matches(pair.1).count(), "{text}");
    }
}

#[test]
fn model_of_voxels_holds_its_shell() {
    let plant = gravel::build();
    let bytes = voxels::encode(&plant, &gravel::COLOURS).unwrap();
    assert!(bytes.len() < 20_000, "{} bytes", bytes.len());
    assert_eq!(
        (&bytes[..4], little(&bytes, 4), &bytes[8..12]),
        (b"VOX ".as_slice(), 150, b"MAIN".as_slice())
    );
    assert_eq!((little(&bytes, 12), 20 + little(&bytes, 16)), (0, bytes.len()));
    let (mut at, mut names) = (20, Vec::new());
    while at < bytes.len() {
        names.push(&bytes[at..at + 4]);
        at += 12 + little(&bytes, at + 4);
    }

    assert_eq!((at, names), (bytes.len(), vec![b"SIZE".as_slice(), b"XYZI", b"RGBA"]));
    // Behind the sizes' chunk and the head of the next.
    let cells = 20 + 12 + 12 + 12;
    let count = little(&bytes, cells);
    assert_eq!(count, plant.shell().count());
    let mut met = [false; gravel::COLOURS.len()];
    for cell in bytes[cells + 4..cells + 4 + 4 * count].chunks_exact(4) {
        assert!((0..3).all(|axis| usize::from(cell[axis]) < gravel::SIZE[axis]), "{cell:?}");
        met[usize::from(cell[3]) - 1] = true;
    }

    assert_eq!(met, [true; gravel::COLOURS.len()], "a colour that nothing has");
    assert!(voxels::encode(&voxels::Voxels::new([257, 1, 1]), &[]).is_err());
}

/// Lines of a `.shp`, found through its `.shx`: that they are read back.
fn lines(Shapefile { shp, shx, .. }: &Shapefile) -> Vec<Vec<DVec2>> {
    for bytes in [shp, shx] {
        assert_eq!((big(bytes, 0), 2 * big(bytes, 24), little(bytes, 28)), (9994, bytes.len(), 1000));
    }
    let records = shx[100..].chunks_exact(8).enumerate().map(|(row, entry)| {
        let (at, length) = (2 * big(entry, 0), 2 * big(entry, 4));
        assert_eq!((big(shp, at), 2 * big(shp, at + 4), little(shp, at + 8)), (row + 1, length, 3));
        let count = little(shp, at + 8 + 40);
        assert_eq!(length, 48 + 16 * count);
        let place = |k: usize| dvec2(real(shp, at + 56 + 16 * k), real(shp, at + 64 + 16 * k));
        (0..count).map(place).collect()
    });
    records.collect()
}

#[test]
fn shapefile_is_read_back() {
    let features = vineyard::draw();
    let file = shapefile::encode(&features).unwrap();
    let total = [&file.shp, &file.shx, &file.dbf, &file.prj, &file.cpg].map(Vec::len).iter().sum::<usize>();
    assert!(total < 60_000, "{total} bytes");
    let lines = lines(&file);
    assert_eq!((lines.len(), little(&file.dbf, 4)), (features.len(), features.len()));
    let width = |at: usize| usize::from(u16::from_le_bytes([file.dbf[at], file.dbf[at + 1]]));
    let (first, stride) = (width(8), width(10));
    assert_eq!(file.dbf.len(), first + stride * features.len() + 1);

    for (row, (feature, found)) in features.iter().zip(lines).enumerate() {
        let Geometry::Line(line) = &feature.geometry else { panic!("row {row} is no line") };
        assert_eq!(line.len(), found.len());
        for (place, found) in line.iter().zip(found) {
            let off = (ORIGIN.x + place.x - found.x).hypot(ORIGIN.y + place.y - found.y);
            assert!(off < 0.01, "row {row}: {off} m");
        }

        let mut from = first + stride * row + 1;
        let mut met = 0;
        for column in file.dbf[32..first - 1].chunks_exact(32) {
            let name = std::str::from_utf8(&column[..11]).unwrap().trim_end_matches('\0');
            let text = std::str::from_utf8(&file.dbf[from..from + usize::from(column[16])]).unwrap().trim();
            from += usize::from(column[16]);
            let number = feature.number(name).map(|number| format!("{number:.2}"));
            let wanted = feature.text(name).map(str::to_owned).or(number).unwrap_or_default();
            assert_eq!(text, wanted, "row {row}, {name}");
            met += usize::from(!wanted.is_empty());
        }

        assert_eq!(met, feature.tags.len(), "row {row}");
    }
}

#[test]
fn shapefile_refuses_what_it_cannot_hold() {
    let line = || Geometry::Line(vec![DVec2::ZERO, DVec2::ONE]);
    let refuses = |feature: Feature| shapefile::encode(&[feature]).is_err();
    assert!(!refuses(Feature::new(line(), [Tag::new("barrier", "fence")])));
    assert!(refuses(Feature::new(line(), [Tag::new("barrier", "a fence of wire")])));
    assert!(refuses(Feature::new(line(), [Tag::new("layer", 1.0)])));
    assert!(refuses(Feature::new(Geometry::Point(DVec2::ZERO), [Tag::new("barrier", "fence")])));
}

#[test]
fn vineyard_lies_on_free_ground() {
    let vines = vineyard::vines();
    let apart = |a: DVec2, b: DVec2| (a.x - b.x).hypot(a.y - b.y);
    for pair in vines.windows(2) {
        for end in [0, 1] {
            let step = apart(pair[0][end], pair[1][end]);
            assert!((0.8..1.2).contains(&(step / vineyard::ROWS)), "{step} m between {pair:?}");
        }
    }

    let flight = path::fly(&SAMPLE.valley.surface);
    let [gate, ..] = vineyard::TRACK;
    for feature in vineyard::draw() {
        let Geometry::Line(line) = &feature.geometry else { panic!("no line") };
        for &place in line {
            let DVec2 { x, y } = place;
            let pixel = around(x, y, 0.0).next().unwrap();
            assert!(SAMPLE.water.outside[pixel] > 20.0, "in water at {x}, {y}");
            assert!(sites::kept(x, y).is_none(), "on a site at {x}, {y}");
            assert!(
                apart(gate, place) < 10.0 || roads::outside(&SAMPLE.roads, pixel) > 5.0,
                "on a road at {x}, {y}"
            );
            assert!(
                flight.iter().all(|eye| apart(eye.truncate(), place) > 150.0),
                "under the flight at {x}, {y}"
            );
            let tree = SAMPLE
                .valley
                .trees
                .iter()
                .find(|tree| apart(dvec2(tree.x, tree.y), place) < tree.radius + 1.0);
            assert!(tree.is_none(), "in a crown at {x}, {y}");
        }
    }

    // The farm's track is met, not crossed.
    let pixel = around(gate.x, gate.y, 0.0).next().unwrap();
    assert!(roads::outside(&SAMPLE.roads, pixel) <= 2.5, "the track begins beside the farm's");
}
