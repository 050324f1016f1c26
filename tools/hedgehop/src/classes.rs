//! Composition of a database, in words and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};

use hedgehop::voxel::{Grid, Group, Header};
use hedgehop_query::{ClassTally, ObjectTally, Tally};

/// Square metres as square kilometres.
const KM2: f64 = 1.0e-6;
/// Objects that are told one by one, the most placed first.
const MOST_OBJECTS: usize = 10;

/// A part of a whole, 0…1.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Areas and spans by what materials have in common, without those that there are none of.
fn groups(header: &Header, tally: &Tally) -> Vec<(Group, ClassTally)> {
    let of = |group: Group| {
        let classes =
            tally.materials.iter().filter(|(number, _)| header.metadata.material(**number).group() == group);
        let sum = |sum: ClassTally, (_, class): (&u8, &ClassTally)| ClassTally {
            area: sum.area + class.area,
            spans: sum.spans + class.spans,
        };
        (group, classes.fold(ClassTally::default(), sum))
    };
    Group::ALL.into_iter().map(of).filter(|(_, sum)| *sum != ClassTally::default()).collect()
}

/// Materials by falling area.
fn sorted(tally: &Tally) -> Vec<(u8, ClassTally)> {
    let mut classes: Vec<_> = tally.materials.iter().map(|(number, class)| (*number, *class)).collect();
    classes.sort_by(|a, b| b.1.area.total_cmp(&a.1.area).then(b.1.spans.cmp(&a.1.spans)).then(a.0.cmp(&b.0)));
    classes
}

/// Objects that stand somewhere, by their numbers, the most placed first.
fn placed(tally: &Tally) -> Vec<(usize, ObjectTally)> {
    let all = tally.objects.iter().copied().enumerate();
    let mut placed: Vec<_> = all.filter(|(_, object)| object.placed > 0).collect();
    placed.sort_by_key(|(number, object)| (std::cmp::Reverse(object.placed), *number));
    placed
}

/// Rows of objects: the most placed ones, and the sum of all others.
fn objects(tally: &Tally) -> String {
    let mut text = String::new();
    let mut row = |name: &str, placed: u64, bytes: u64| {
        let title = if text.is_empty() { "by object" } else { "" };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {title:<9} {name:<22} {placed:>12} times {:>9.1} kB", bytes as f64 / 1e3);
    };
    let all = placed(tally);
    let (told, others) = all.split_at(all.len().min(MOST_OBJECTS));
    for (number, ObjectTally { voxels: [width, depth], placed, bytes }) in told {
        row(&format!("{number}: {width} x {depth} voxels"), *placed, *bytes);
    }
    if !others.is_empty() {
        let sum = |of: fn(&ObjectTally) -> u64| others.iter().map(|(_, object)| of(object)).sum();
        let name = format!("{} others", others.len());
        row(&name, sum(|object| object.placed), sum(|object| object.bytes));
    }
    text
}

/// Further rows of the table that `info` prints.
pub fn description(header: &Header, tally: &Tally) -> String {
    let mut text = String::new();
    let spans = tally.spans;
    let mut row = |first: bool, title: &str, name: &str, class: &ClassTally| {
        let title = if first { title } else { "" };
        let percent = 100.0 * share(class.area, tally.area);
        // Writing to a String cannot fail.
        let _ = write!(text, "  {title:<9} {name:<22} {:>12.4} km² {percent:>8.3} %", class.area * KM2);
        let percent = 100.0 * share(class.spans as f64, spans as f64);
        let _ = match class.spans {
            0 => writeln!(text),
            count => writeln!(text, " {count:>12} spans {percent:>8.3} %"),
        };
    };

    for (index, (number, class)) in sorted(tally).iter().enumerate() {
        row(index == 0, "materials", &header.metadata.material_name(*number), class);
    }
    for (index, (group, class)) in groups(header, tally).iter().enumerate() {
        row(index == 0, "together", group.name(), class);
    }

    for (index, (source, area)) in tally.sources.iter().enumerate() {
        let name =
            header.metadata.sources.get(usize::from(*source)).map_or("", |source| source.file.as_str());
        row(index == 0, "by source", &format!("{source}: {name}"), &ClassTally { area: *area, spans: 0 });
    }

    for (index, level) in tally.levels.iter().enumerate().filter(|(_, level)| level.area > 0.0) {
        let name = format!("level {}, {} pages", Grid::side_units(index as u8), level.pages);
        row(index == 0, "by level", &name, &ClassTally { area: level.area, spans: 0 });
    }

    if tally.empty > 0.0 {
        let _ = writeln!(text, "            without a surface      {:>12.4} km²", tally.empty * KM2);
    }

    text + &objects(tally)
}

/// The same for programs.
pub fn json(header: &Header, tally: &Tally, bbox: Option<[f64; 4]>) -> Value {
    let parts = |class: &ClassTally| {
        json!({
            "area_km2": class.area * KM2,
            "share": share(class.area, tally.area),
            "spans": class.spans,
            "share_of_spans": share(class.spans as f64, tally.spans as f64),
        })
    };

    let named = |name: String, class: &ClassTally| {
        let mut value = parts(class);
        value["name"] = json!(name);
        value
    };
    let materials = sorted(tally).into_iter().map(|(number, class)| {
        let mut value = named(header.metadata.material_name(number), &class);
        value["number"] = json!(number);
        value
    });
    let groups = groups(header, tally);
    let groups = groups.iter().map(|(group, class)| named(group.name().to_owned(), class));

    let sources = tally.sources.iter().map(|(source, area)| {
        let record = header.metadata.sources.get(usize::from(*source));
        json!({
            "source": source,
            "file": record.map(|record| &record.file),
            "area_km2": area * KM2,
            "share": share(*area, tally.area),
        })
    });

    let levels = tally.levels.iter().enumerate().map(|(level, found)| {
        json!({ "level": Grid::side_units(level as u8), "pages": found.pages, "area_km2": found.area * KM2 })
    });
    let objects = tally.objects.iter().enumerate().map(|(number, object)| {
        json!({ "number": number, "voxels": object.voxels, "placed": object.placed, "bytes": object.bytes })
    });

    json!({
        "bbox": bbox,
        "area_km2": tally.area * KM2,
        "without_surface_km2": tally.empty * KM2,
        "spans": tally.spans,
        "materials": materials.collect::<Vec<_>>(),
        "groups": groups.collect::<Vec<_>>(),
        "sources": sources.collect::<Vec<_>>(),
        "levels": levels.collect::<Vec<_>>(),
        "objects": objects.collect::<Vec<_>>(),
    })
}
