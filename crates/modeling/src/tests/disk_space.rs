//! Room on the disk. What is free is what a test says, to builds of its own thread.

use std::fs;
use std::path::Path;
use std::sync::Mutex;

use glam::DVec2;

use super::support::{Area, options};
use crate::disk_space::{DiskSpace, FREE, least_page_bytes};
use crate::inputs::Inputs;
use crate::object::ObjectFile;
use crate::plan::{self, Plan};
use crate::reach::Reach;
use crate::synthetic::Terrain;
use crate::{BuildOptions, build};
use hedgehop::voxel::most_page_bytes;
use hedgehop_base::progress::{Observer, Silent};

/// Notes of a build.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Observer for Notes {
    fn note(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }
}

impl Notes {
    fn of_room(self) -> Vec<String> {
        let notes = self.0.into_inner().unwrap();
        notes.into_iter().filter(|note| note.contains("MB are free")).collect()
    }
}

/// Level ground at a height, 1280 x 1280 voxels: 25 pages of level 1, 4 + 1 + 1 above.
fn level(folder: &Path, height_m: f64) -> BuildOptions {
    let mut options = options(folder);
    options.local = true;
    options.bbox = Some([0.0, 0.0, 1280.0, 1280.0]);
    options.spacing = Some(1.0);
    let plane = Terrain::Plane { height_m, centre: DVec2::ZERO, slope: 0.0, upward_deg: 0.0 };
    options.synthetic.terrain = vec![plane];
    options
}

/// The same with a box on it, of a colour.
fn with_box(folder: &Path, height_m: f64, red: f64) -> BuildOptions {
    let faces = "mtllib box.mtl\nv -5 0 -3\nv 5 0 -3\nv 5 0 3\nv -5 0 3\nv -5 5 -3\nv 5 5 -3\nv 5 5 3\nv -5 5 3\n\
        usemtl wall\nf 1 2 3 4\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\nf 5 8 7 6\n";
    fs::write(folder.join("box.obj"), faces).unwrap();
    fs::write(folder.join("box.mtl"), format!("newmtl wall\nKd {red} 0.8 0.7\n")).unwrap();
    let paths = vec![folder.join("box.obj")];
    let mut options = level(folder, height_m);
    options.objects = vec![ObjectFile { paths, places: vec![[700.0, 700.0]], ..ObjectFile::default() }];
    options
}

fn plan_of(options: &BuildOptions) -> Plan {
    plan::plan(&Inputs::default(), options).unwrap()
}

pub fn with_free<T>(free: u64, run: impl FnOnce() -> T) -> T {
    FREE.set(Some(free));
    let result = run();
    FREE.set(None);
    result
}

#[test]
fn what_is_needed_lies_between_the_least_and_the_most() {
    let folder = tempfile::tempdir().unwrap();
    let areas = [(level(folder.path(), 100.0), false), (with_box(folder.path(), 100.0, 0.2), true)];
    for (options, builds) in areas {
        let plan = plan_of(&options);
        let reach = Reach::of(&Inputs::default(), &plan, &options).unwrap();
        let room = DiskSpace { plan: &plan, output: &options.output, builds, reach: &reach };
        let report = build(&options, &Silent).unwrap();
        let area = Area::open(&options.output).unwrap();

        // Of each level: bytes of its pages, and the same with gaps; bare ground is made with its surface.
        let mut levels = vec![(0, 0); usize::from(area.grid.level_count())];
        let mut bare = 0;
        for (id, entry) in area.pages.directory().present() {
            let length = u64::from(entry.length);
            let (aside, placed) = &mut levels[usize::from(id.surface().level)];
            (*aside, *placed) = (*aside + length, *placed + length.next_multiple_of(4096));
            if id.is_bare() {
                bare += 1;
                continue;
            }
            let least = least_page_bytes(&area.grid, id);
            assert!((least..=most_page_bytes(&area.grid, id.level)).contains(&length), "{id}: {length}");
            assert!(builds || id.level > 0 || length - least < 1024, "{id}: {length} of level ground");
        }

        assert_eq!(bare > 0, builds);
        let [least, most] = [room.least_needed(), room.most_needed()];
        let (mut file, mut peak) = (4096, 0);
        for (aside, placed) in levels {
            file += placed;
            peak = peak.max(file + aside);
        }

        assert!((least..=most).contains(&peak), "{peak} of {least} to {most}");
        assert!(report.bytes <= room.most_bytes() && room.most_bytes() < most);
    }
}

#[test]
fn a_disk_that_is_too_small_is_told_before_anything_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let options = level(folder.path(), 100.0);
    let plan = plan_of(&options);
    let reach = Reach::of(&Inputs::default(), &plan, &options).unwrap();
    let room = DiskSpace { plan: &plan, output: &options.output, builds: false, reach: &reach };
    let [least, most] = [room.least_needed(), room.most_needed()];
    let refused = with_free(least - 1, || build(&options, &Silent)).unwrap_err().to_string();
    let megabytes = |bytes: u64| format!("{} MB", bytes.div_ceil(1_000_000));
    assert!(refused.contains("area.hop") && refused.contains("--spacing"), "{refused}");
    assert!(refused.contains(&format!("at least {}", megabytes(least))), "{refused}");
    assert!(refused.contains(&format!("up to {}", megabytes(most))), "{refused}");
    assert!(refused.contains(&format!("only {} MB are free", (least - 1) / 1_000_000)), "{refused}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

    // It may do.
    let notes = Notes::default();
    with_free(least, || build(&options, &notes)).unwrap();
    let told = notes.of_room();
    assert!(told.len() == 1 && told[0].contains(&format!("up to {}", megabytes(most))), "{told:?}");

    // It does.
    let notes = Notes::default();
    with_free(most, || build(&options, &notes)).unwrap();
    assert!(notes.of_room().is_empty());
}

#[test]
fn a_change_in_place_takes_no_room_for_a_new_file() {
    let folder = tempfile::tempdir().unwrap();
    let stepped = |height_m: f64, red: f64| {
        let options = with_box(folder.path(), height_m, red);
        BuildOptions { steps: true, ..options }
    };
    let first = build(&stepped(100.0, 0.2), &Silent).unwrap();

    // A quarter of what is there.
    let free = first.bytes / 4;
    let notes = Notes::default();
    let options = stepped(100.0, 0.4);
    let changed = with_free(free, || build(&options, &notes)).unwrap();
    assert!(
        changed.reused > 0 && changed.reused < changed.pages && changed.content_hash != first.content_hash
    );
    assert!(notes.of_room().is_empty());
    let clean = BuildOptions { steps: false, output: folder.path().join("clean.hop"), ..options.clone() };
    build(&clean, &Silent).unwrap();
    assert!(fs::read(&options.output).unwrap() == fs::read(&clean.output).unwrap(), "the same bytes");

    // Nothing changed: no room at all is needed.
    with_free(0, || build(&options, &Silent)).unwrap();
    let parts = fs::read_dir(folder.path()).unwrap().flatten();
    assert!(parts.into_iter().all(|file| !file.file_name().to_string_lossy().contains(".part-")));
}
