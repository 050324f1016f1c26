//! Files that are cut short or changed: a sentence, or what they say, and never more memory than they are worth.

use std::fs;

use glam::dvec3;

use super::scene::{Chance, Mark, options, write};
use hedgehop_modeling::{BuildOptions, faults, outline};

/// What is wrong with a file, if something is.
fn fault(path: &std::path::Path) -> Option<String> {
    let mut options = BuildOptions::new(Vec::new(), Vec::new(), "area.hop".into());
    options.clouds = vec![path.to_owned().into()];
    faults(&options).into_iter().next().map(|(_, error)| error.to_string())
}

#[test]
fn damaged_files_are_told_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let mut chance = Chance(3);
    let marks: Vec<Mark> = (0..1500)
        .map(|_| (dvec3(40.0 * chance.next(), 40.0 * chance.next(), 90.0 + chance.next()), 2, [9, 99, 199]))
        .collect();

    for (name, format) in [("a.las", 3), ("b.laz", 3), ("c.laz", 7), ("d.las", 6), ("e.laz", 1)] {
        let path = folder.path().join(name);
        write(&path, format, &marks);
        assert_eq!(fault(&path), None);
        let sound = fs::read(&path).unwrap();
        let mut told = 0;
        let count = 900;

        for round in 0..count {
            let mut bytes = sound.clone();
            let mut at = |below: usize| (chance.next() * below as f64) as usize;
            if round % 6 == 0 {
                bytes.truncate(at(sound.len()));
            } else {
                for _ in 0..=round % 3 {
                    let place = at(if round % 2 == 0 { sound.len().min(800) } else { sound.len() });
                    bytes[place] = at(256) as u8;
                }
            }

            fs::write(&path, &bytes).unwrap();
            let Some(what) = fault(&path) else { continue };
            told += 1;
            assert!(what.contains(name) && !what.contains('\n'), "{what}");
        }

        assert!(told > count / 6 - 20, "{name}: {told} of {count}");
    }
}

#[test]
fn what_is_no_cloud_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.las");
    for (bytes, word) in [
        (&b"II*\0"[..], "does not begin with LASF"),
        (&b"LASF"[..], "ends within its header"),
        (&[][..], "LASF"),
    ] {
        fs::write(&path, bytes).unwrap();
        let what = fault(&path).unwrap();
        assert!(what.contains(word), "{what}");
    }
    write(&path, 3, &[(dvec3(1.0, 1.0, 1.0), 7, [0; 3])]);
    assert!(fault(&path).unwrap().contains("noise"));
}

/// Writes doubles into a header.
fn forged(sound: &[u8], doubles: &[(usize, f64)]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for (at, value) in doubles {
        bytes[*at..at + 8].copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// Places of the header's box: greatest and least x, then y, then z.
const BOX: usize = 179;

#[test]
fn the_extent_is_that_of_the_points_whatever_the_header_says() {
    let folder = tempfile::tempdir().unwrap();
    let marks: Vec<Mark> = (0..1600)
        .map(|index| (dvec3(f64::from(index % 40) + 0.5, f64::from(index / 40) + 0.5, 90.0), 2, [9; 3]))
        .collect();

    let boxes: [(&str, [f64; 6]); 6] = [
        ("small", [500_010.0, 500_000.0, 5_000_010.0, 5_000_000.0, 90.0, 90.0]),
        ("large", [900_000.0, 100_000.0, 9_000_000.0, 0.0, 90.0, 90.0]),
        ("zero", [0.0; 6]),
        ("no number", [f64::NAN; 6]),
        ("turned", [500_000.0, 500_040.0, 5_000_000.0, 5_000_040.0, 90.0, 90.0]),
        ("endless", [f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 90.0, 90.0]),
    ];

    for name in ["a.las", "b.laz"] {
        let path = folder.path().join(name);
        write(&path, 3, &marks);
        let sound = fs::read(&path).unwrap();
        let plain = outline(&options(&path, folder.path().join("area.hop"))).unwrap();
        assert_eq!([plain.grid.nx, plain.grid.ny], [40, 40]);
        assert!(!plain.notes.iter().any(|note| note.contains("the points count")), "{:?}", plain.notes);

        for (what, sides) in boxes {
            let doubles: Vec<_> = (0..).step_by(8).zip(sides).map(|(at, side)| (BOX + at, side)).collect();
            fs::write(&path, forged(&sound, &doubles)).unwrap();
            let outline = outline(&options(&path, folder.path().join("area.hop"))).unwrap();
            assert_eq!(outline.grid, plain.grid, "{name}, {what}");
            assert!(outline.notes.iter().any(|note| note.contains("the points count")), "{what}");
        }
    }
}

#[test]
fn scales_and_counts_that_cannot_be_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.las");
    let marks: Vec<Mark> = (0..500).map(|index| (dvec3(f64::from(index), 1.0, 90.0), 2, [9; 3])).collect();
    write(&path, 3, &marks);
    let sound = fs::read(&path).unwrap();

    for (at, axis) in [(131, "x"), (139, "y"), (147, "z")] {
        for scale in [0.0, -0.001, f64::NAN, f64::INFINITY, 1e-310] {
            fs::write(&path, forged(&sound, &[(at, scale)])).unwrap();
            let what = fault(&path).unwrap();
            assert!(what.contains("a scale of") && what.contains(&format!("its {axis} ")), "{what}");
        }
        fs::write(&path, forged(&sound, &[(at, 1e300)])).unwrap();
        assert!(fault(&path).unwrap().contains("scales of"));
        fs::write(&path, forged(&sound, &[(at + 24, f64::NAN)])).unwrap();
        assert!(fault(&path).unwrap().contains("an offset of NaN"));
    }

    for (count, word) in [(499_u32, "has room for 500"), (501, "holds 500"), (0, "no points")] {
        let mut bytes = sound.clone();
        bytes[107..111].copy_from_slice(&count.to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        let what = fault(&path).unwrap();
        assert!(what.contains(word), "{count}: {what}");
    }
}
