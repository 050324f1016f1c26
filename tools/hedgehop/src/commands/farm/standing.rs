//! Standing of a job: which of its frames are finished, as records and files tell.

use std::path::Path;

use crate::commands::render::RenderArgs;
use crate::farm::job::{FarmChunk, FarmJob};
use crate::farm::parts::{ChunkState, holds};
use crate::side_by_side::side_by_side;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Reads how far the chunks of a job are. Records of frames that are not theirs, or of files of other names, are nobody's.
pub fn standing(job: &FarmJob, args: &RenderArgs, place: &Path) -> Result<Vec<ChunkState>> {
    let mut states = ChunkState::read_all(place, job.chunks.len())?;
    let name = |number: u64| {
        let path = args.output.as_ref()?.path(number);
        Some(path.file_name()?.to_string_lossy().into_owned())
    };
    for (chunk, state) in job.chunks.iter().zip(&mut states) {
        let frames = chunk.set()?;
        state.records.retain(|number, record| frames.contains(*number) && record.file == name(*number));
    }
    Ok(states)
}

/// Lists the frames of a chunk that are not finished: they have no record, or no file.
pub fn unfinished(job: &FarmJob, chunk: &FarmChunk, state: &ChunkState) -> Result<Vec<u64>> {
    let folder = job.frames();
    let is_there = |number: &u64| {
        let file = state.records.get(number).and_then(|record| record.file.as_ref());
        file.is_some_and(|file| folder.join(file).is_file())
    };
    Ok(chunk.set()?.iter().filter(|number| !is_there(number)).collect())
}

/// Lists the frames of each chunk that have no record, or whose file does not hold the bytes that it tells of; all files are read.
pub fn unsound(job: &FarmJob, states: &[ChunkState], observer: &dyn Observer) -> Result<Vec<Vec<u64>>> {
    let folder = job.frames();
    let is_sound = |state: &ChunkState, number: u64| {
        let record = state.records.get(&number);
        let file = record.and_then(|record| record.file.as_ref()).map(|file| folder.join(file));
        record.zip(file).is_some_and(|(record, file)| holds(record, &file))
    };
    let mut sets = Vec::new();
    for chunk in &job.chunks {
        sets.push(chunk.set()?);
    }

    let wrong = |index: usize| {
        let state = &states[index];
        sets[index].iter().filter(|number| !is_sound(state, *number)).collect()
    };
    observer.begin("look", sets.len() as u64, "chunks");
    let found = side_by_side(sets.len().min(states.len()), observer, &wrong);
    observer.end();
    found.ok_or_else(|| Error::Interrupted("not all frames were looked at".into()))
}
