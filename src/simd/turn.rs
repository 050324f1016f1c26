//! Rows as columns.

use std::ops::Range;

/// Side of the squares that are turned one after the other, so that neither side leaves the cache.
const SQUARE: usize = 32;

/// Some columns of `[rows][width]` as `[columns][rows]`; what is left over behind the last whole row is left out.
pub fn turned<T: Copy + Default>(rows: &[T], width: usize, columns: Range<usize>) -> Vec<T> {
    let height = rows.len().checked_div(width).unwrap_or(0);
    let mut turned = vec![T::default(); columns.len() * height];
    for top in (0..height).step_by(SQUARE) {
        for left in columns.clone().step_by(SQUARE) {
            for y in top..height.min(top + SQUARE) {
                for x in left..columns.end.min(left + SQUARE) {
                    turned[(x - columns.start) * height + y] = rows[y * width + x];
                }
            }
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
