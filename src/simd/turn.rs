//! Rows as columns.

use std::array;
use std::ops::Range;

/// Rows that are turned together: as many values as a word takes lie side by side both before and after.
const TOGETHER: usize = 4;

/// Some columns of `[rows][width]` as `[columns][rows]`; what is left over behind the last whole row is left out.
pub fn turned<T: Copy + Default>(rows: &[T], width: usize, columns: Range<usize>) -> Vec<T> {
    let height = rows.len().checked_div(width).unwrap_or(0);
    let mut turned = vec![T::default(); columns.len() * height];
    let row = |y: usize| &rows[y * width..][columns.clone()];
    let whole = height - height % TOGETHER;

    for top in (0..whole).step_by(TOGETHER) {
        let together: [_; TOGETHER] = array::from_fn(|y| row(top + y).as_chunks::<TOGETHER>());
        let squares = together[0].0.len();
        for square in 0..squares {
            let values = together.map(|(chunks, _)| chunks[square]);
            for x in 0..TOGETHER {
                let column = (square * TOGETHER + x) * height + top;
                turned[column..][..TOGETHER].copy_from_slice(&values.map(|row| row[x]));
            }
        }

        for (y, (_, rest)) in together.into_iter().enumerate() {
            for (x, value) in rest.iter().enumerate() {
                turned[(squares * TOGETHER + x) * height + top + y] = *value;
            }
        }
    }

    for y in whole..height {
        for (x, value) in row(y).iter().enumerate() {
            turned[x * height + y] = *value;
        }
    }

    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns() {
        for (width, height) in [(1, 1), (5, 3), (32, 64), (70, 33)] {
            let rows: Vec<usize> = (0..width * height).collect();
            let columns = turned(&rows, width, 0..width);
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                assert_eq!(columns[x * height + y], y * width + x);
            }
            assert_eq!(turned(&columns, height, 0..height), rows);
            let some = width / 3..width - width / 4;
            assert_eq!(turned(&rows, width, some.clone()), columns[some.start * height..some.end * height]);
        }
        assert!(turned::<u8>(&[], 0, 0..0).is_empty());
    }
}
