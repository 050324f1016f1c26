//! Files that are cut short or changed: a sentence, or what they say, and never more memory than they are worth.

use std::fs;

use glam::dvec3;
use hedgehop::modeling::{BuildOptions, faults};

use crate::scene::{Chance, Mark, write};

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
