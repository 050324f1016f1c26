//! Things by tile, in a file without a name: what does not fit into memory.
//!
//! ```text
//! append(tile, things)    held until there are too many of them, then written, tile after tile
//! read(tile)              block after block, in the order in which they came
//! ```

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use bytemuck::Pod;

use super::super::raster::read_exact_at;
use hedgehop_base::error::{Error, Result};

/// Voxels along a tile of level 1.
pub(super) const TILE: i64 = 64;

/// A tile, counted eastward and northward from the grid's origin.
pub(super) type CloudTile = (i64, i64);

/// Things that are read at once.
const AT_ONCE: u64 = 1 << 15;

/// Things by tile.
#[derive(Debug)]
pub(super) struct Store<T> {
    file: File,
    /// Path that messages name.
    path: PathBuf,
    end: u64,
    /// Blocks of each tile: first byte, and how many.
    blocks: BTreeMap<CloudTile, Vec<(u64, u64)>>,
    held: BTreeMap<CloudTile, Vec<T>>,
    count: usize,
    /// Most records that are held.
    most: usize,
    things: PhantomData<T>,
}

impl<T: Pod> Store<T> {
    /// An empty one in a file beside `output`, that holds `bytes` in memory at most until [`Self::settle`].
    pub fn beside(output: &Path, bytes: u64) -> Result<Self> {
        let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
        let file = tempfile::tempfile_in(folder.unwrap_or(Path::new(".")))
            .map_err(|error| Error::io(output, "create a file beside it", error))?;
        Ok(Self {
            file,
            path: output.to_owned(),
            end: 0,
            blocks: BTreeMap::new(),
            held: BTreeMap::new(),
            count: 0,
            // Lists grow by doubling.
            most: (bytes as usize / size_of::<T>() / 2).max(1),
            things: PhantomData,
        })
    }

    /// Adds a thing to a tile.
    pub fn push(&mut self, tile: CloudTile, thing: T) -> Result<()> {
        self.held.entry(tile).or_default().push(thing);
        self.count += 1;
        if self.count < self.most { Ok(()) } else { self.settle() }
    }

    /// Adds things to a tile.
    pub fn append(&mut self, tile: CloudTile, things: &[T]) -> Result<()> {
        if things.is_empty() {
            return Ok(());
        }
        let bytes = bytemuck::cast_slice(things);
        self.file.write_all(bytes).map_err(|error| Error::io(&self.path, "write a file beside it", error))?;
        self.blocks.entry(tile).or_default().push((self.end, things.len() as u64));
        self.end += bytes.len() as u64;
        Ok(())
    }

    /// Writes all that is held.
    pub fn settle(&mut self) -> Result<()> {
        self.count = 0;
        std::mem::take(&mut self.held).iter().try_for_each(|(tile, things)| self.append(*tile, things))
    }

    /// Tiles that have something, in order.
    pub fn tiles(&self) -> impl Iterator<Item = CloudTile> {
        self.blocks.keys().copied()
    }

    /// Hands over what a tile has, part by part.
    pub fn read(&self, tile: CloudTile, mut take: impl FnMut(&[T])) -> Result<()> {
        let mut things = Vec::new();
        for (start, count) in self.blocks.get(&tile).into_iter().flatten() {
            for first in (0..*count).step_by(AT_ONCE as usize) {
                things.clear();
                things.resize(AT_ONCE.min(count - first) as usize, T::zeroed());
                let at = start + first * size_of::<T>() as u64;
                read_exact_at(&self.file, bytemuck::cast_slice_mut(&mut things), at)
                    .map_err(|error| Error::io(&self.path, "read a file beside it", error))?;
                take(&things);
            }
        }
        Ok(())
    }
}
