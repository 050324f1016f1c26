//! Files and folders that import each other in a loop.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::imports::Arrows;
use crate::sources::Target;

/// Rooms, files or folders, each of which reaches all others.
#[derive(Debug)]
pub struct Circle {
    /// Paths from the workspace's root.
    pub rooms: Vec<PathBuf>,
    /// Imports inside of it: the room that takes, the room that gives, and the names.
    pub ties: Vec<(PathBuf, PathBuf, BTreeSet<String>)>,
}

/// Finds circles of files.
pub fn of_files(target: &Target, arrows: &Arrows) -> Vec<Circle> {
    let room = |file: usize| target.files[file].path.clone();
    find(arrows.iter().map(|((from, to), names)| (room(*from), room(*to), names.clone())))
}

/// Finds circles among the files and folders that lie in one folder, for each folder.
pub fn of_folders(target: &Target, arrows: &Arrows) -> Vec<Circle> {
    let folders: BTreeSet<&Path> = target.files.iter().filter_map(|file| file.path.parent()).collect();
    let mut circles = Vec::new();
    for folder in folders {
        let room = |file: usize| {
            let below = target.files[file].path.strip_prefix(folder).ok()?;
            Some(folder.join(below.components().next()?))
        };
        let within = arrows.iter().filter_map(|((from, to), names)| {
            let (from, to) = (room(*from)?, room(*to)?);
            (from != to).then(|| (from, to, names.clone()))
        });
        let is_of_folders = |circle: &Circle| circle.rooms.iter().any(|room| room.extension().is_none());
        circles.extend(find(within).into_iter().filter(is_of_folders));
    }
    circles
}

/// Finds strongly connected rooms of more than one (Tarjan 1972).
fn find(ties: impl Iterator<Item = (PathBuf, PathBuf, BTreeSet<String>)>) -> Vec<Circle> {
    let mut all: BTreeMap<(PathBuf, PathBuf), BTreeSet<String>> = BTreeMap::new();
    for (from, to, names) in ties {
        all.entry((from, to)).or_default().extend(names);
    }

    let mut reached: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> = BTreeMap::new();
    for (from, to) in all.keys() {
        reached.entry(from).or_default().insert(to);
        reached.entry(to).or_default();
    }

    let mut search = Search { reached: Some(&reached), ..Search::default() };
    for room in reached.keys() {
        if !search.index.contains_key(*room) {
            search.visit(room);
        }
    }

    let circle = |rooms: Vec<PathBuf>| {
        let inside = |(from, to): &(PathBuf, PathBuf)| rooms.contains(from) && rooms.contains(to);
        let ties = all.iter().filter(|(pair, _)| inside(pair));
        let ties = ties.map(|((from, to), names)| (from.clone(), to.clone(), names.clone())).collect();
        Circle { rooms, ties }
    };

    search.circles.into_iter().map(circle).collect()
}

/// State of Tarjan's search.
#[derive(Default)]
struct Search<'a> {
    reached: Option<&'a BTreeMap<&'a PathBuf, BTreeSet<&'a PathBuf>>>,
    index: BTreeMap<&'a PathBuf, usize>,
    low: BTreeMap<&'a PathBuf, usize>,
    stack: Vec<&'a PathBuf>,
    circles: Vec<Vec<PathBuf>>,
}

impl<'a> Search<'a> {
    fn visit(&mut self, room: &'a PathBuf) {
        let number = self.index.len();
        self.index.insert(room, number);
        self.low.insert(room, number);
        self.stack.push(room);

        for next in self.reached.map(|reached| &reached[room]).into_iter().flatten() {
            if !self.index.contains_key(next) {
                self.visit(next);
                self.low.insert(room, self.low[room].min(self.low[next]));
            } else if self.stack.contains(next) {
                self.low.insert(room, self.low[room].min(self.index[next]));
            }
        }

        if self.low[room] != self.index[room] {
            return;
        }

        let start = self.stack.iter().position(|other| *other == room).unwrap_or_default();
        let circle: Vec<PathBuf> = self.stack.drain(start..).cloned().collect();
        if circle.len() > 1 {
            self.circles.push(circle);
        }
    }
}
