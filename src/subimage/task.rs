//! Tasks: their stages and sizes.

/// Half of a frame that a task belongs to. The second begins when the first has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Vertical planes: what each ray meets.
    March,
    /// The screen: resampling, shading, haze.
    Image,
}

impl Stage {
    /// All stages, in the order in which a frame goes through them.
    pub const ALL: [Self; 2] = [Self::March, Self::Image];

    /// One word, lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::March => "march",
            Self::Image => "image",
        }
    }
}

/// Part of a frame that one task works on. Frames have the same bits for any size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskSize {
    /// Adjacent scan lines, or vertical planes, of a march task (the patent's NV), ≥ 1.
    pub lines: u32,
    /// Screen rows of an image task, ≥ 1.
    pub rows: u32,
}

impl Default for TaskSize {
    fn default() -> Self {
        Self { lines: 8, rows: 8 }
    }
}

/// Adjacent vertical scan lines of one screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subimage {
    /// First column.
    pub first_column: u32,
    /// Columns, ≥ 1.
    pub columns: u32,
}

/// Cuts a screen of `width` columns into tasks of `lines` columns (at least one), from left to right.
pub fn split(width: u32, lines: u32) -> impl Iterator<Item = Subimage> {
    let lines = lines.max(1);
    (0..width)
        .step_by(lines as usize)
        .map(move |first_column| Subimage { first_column, columns: lines.min(width - first_column) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subimages_tile_the_screen() {
        for (width, lines) in [(1, 8), (7, 8), (8, 8), (9, 8), (640, 1), (1921, 16), (5, u32::MAX), (3, 0)] {
            let mut next = 0;
            for subimage in split(width, lines) {
                assert_eq!(subimage.first_column, next);
                assert!((1..=lines.max(1)).contains(&subimage.columns));
                next += subimage.columns;
            }
            assert_eq!(next, width);
        }
    }
}
