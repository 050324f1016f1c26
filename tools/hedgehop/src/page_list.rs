//! List of the bytes of a database that a flight needs.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use crate::args::check_no_input;
use hedgehop::Result;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::memory::{PageFile, PagePlan};
use hedgehop::render::NumberedCamera;
use hedgehop::voxel::{BARE, Grid, PagePart};

/// Columns of the table. What holds no pages, and is needed to open the database, has the first three alone; what was read to plan the flight, and is read again to
/// fly it, no frame.
const COLUMNS: &str = "first_byte,length,part,level,px,py,first_frame";

/// Refuses before any work a list that could not be written, or that would replace an input.
pub fn check(list: &Path, inputs: &[&Path]) -> Result<()> {
    check_no_input("--page-list", list, inputs)?;
    check_writable(list)
}

/// Writes the table: a line for each part of a page, in the order of need, with the number of the first frame that needs it. Nothing else of the database was
/// read than to plan the flight.
///
/// # Errors
/// The database cannot be read; the list cannot be written.
pub fn write(list: &Path, file: &PageFile, plan: &PagePlan, cameras: &[NumberedCamera]) -> Result<()> {
    let mut text = format!("{COLUMNS}\n");
    // Writing to a string does not fail.
    for Range { start, end } in file.ends()? {
        let _ = writeln!(text, "{start},{},file,,,,", end - start);
    }
    let planned: HashSet<_> = plan.first_use.iter().map(|(part, _)| *part).collect();
    let read = file.touched_parts().into_iter().filter(|part| !planned.contains(part));
    let read = read.map(|part| (part, String::new()));
    let number =
        |index: u32| cameras.get(index as usize).map_or_else(String::new, |frame| frame.number.to_string());
    let needed = plan.first_use.iter().map(|(part, index)| (*part, number(*index)));
    for (part, frame) in read.chain(needed) {
        let (Range { start, end }, page) = (file.stretch(part), part.page());
        let level = if page.level == BARE { "bare".into() } else { Grid::side_units(page.level).to_string() };
        let (length, name) = (end - start, name(part));
        let _ = writeln!(text, "{start},{length},{name},{level},{},{},{frame}", page.px, page.py);
    }
    write_bytes(list, text.as_bytes())
}

fn name(part: PagePart) -> &'static str {
    match part {
        PagePart::Heights(_) => "heights",
        PagePart::Paint(_) => "paint",
        PagePart::Bounds(_) => "bounds",
        PagePart::Spans(_) => "spans",
    }
}
