//! Subimages: how a frame is cut into independent tasks, and the farm that works on them.
//!
//! A task is a group of adjacent vertical scan lines (Hughes patent: NV lines a task). Tasks share
//! nothing that they write, so a frame has the same bits for any number of workers. This is the only
//! module that knows rayon.

use rayon::prelude::*;

use crate::error::{Error, Result};

/// Adjacent vertical scan lines of one screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subimage {
    /// First column.
    pub first_column: u32,
    /// Columns, ≥ 1.
    pub columns: u32,
}

/// Columns of a task: few enough that the last tasks of a frame finish close together.
const COLUMNS_PER_TASK: u32 = 8;

/// Cuts a screen of `width` columns into tasks, from left to right.
pub fn split(width: u32) -> impl Iterator<Item = Subimage> {
    (0..width).step_by(COLUMNS_PER_TASK as usize).map(move |first_column| Subimage {
        first_column,
        columns: COLUMNS_PER_TASK.min(width - first_column),
    })
}

/// A fixed number of workers.
#[derive(Debug)]
pub struct Farm {
    pool: rayon::ThreadPool,
}

impl Farm {
    /// A farm of `workers` threads, at least one.
    pub fn new(workers: usize) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(workers.max(1))
            .thread_name(|index| format!("subimage-{index}"))
            .build()
            .map_err(|error| {
                Error::Configuration(format!("cannot start {workers} workers: {error}; ask for fewer (-j)"))
            })?;
        Ok(Self { pool })
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Works on every subimage of a screen of `width` columns; results in order, or the first error.
    pub fn render<T: Send>(
        &self,
        width: u32,
        task: impl Fn(Subimage) -> Result<T> + Sync + Send,
    ) -> Result<Vec<T>> {
        let subimages: Vec<_> = split(width).collect();
        self.pool.install(|| subimages.into_par_iter().with_max_len(1).map(task).collect())
    }

    /// Works on every row of an image with `width` elements a row, in place: `task(row index, row)`.
    pub fn rows<T: Send>(&self, image: &mut [T], width: usize, task: impl Fn(usize, &mut [T]) + Sync + Send) {
        self.pool.install(|| image.par_chunks_mut(width).enumerate().for_each(|(row, line)| task(row, line)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subimages_tile_the_screen() {
        for width in [1, 7, 8, 9, 640, 1921] {
            let mut next = 0;
            for subimage in split(width) {
                assert_eq!(subimage.first_column, next);
                assert!(subimage.columns >= 1);
                next += subimage.columns;
            }
            assert_eq!(next, width);
        }
    }

    #[test]
    fn an_error_ends_the_frame() {
        let farm = Farm::new(2).unwrap();
        let result: Result<Vec<u32>> = farm.render(64, |subimage| match subimage.first_column {
            32 => Err(Error::Configuration("no".into())),
            column => Ok(column),
        });
        assert!(result.is_err());
    }
}
