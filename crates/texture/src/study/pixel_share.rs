//! Shares of pixels that lie on one side of lines: smoothing of edges by area.
//!
//! ```text
//! edge from (I₁, J₁) to (I₂, J₂)         half of the screen at its inner side
//! share γ = area of the unit square of a pixel that is left when each edge has cut it
//! tone = γ·tone within + (1 − γ)·tone beyond
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), which cuts a square by one edge, as
//! slope and intercept; a square cut by all edges of a convex outline is exact at corners, too.

/// Place on the screen from its middle, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenPoint {
    /// Lines downward, I.
    pub line: f64,
    /// Pixels to the right, J.
    pub column: f64,
}

/// Part of the screen where a linear function of the place is positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    /// Change for each line.
    pub by_line: f64,
    /// Change for each column.
    pub by_column: f64,
    /// Value in the middle of the screen.
    pub middle: f64,
}

impl HalfPlane {
    /// The side of an edge that is to the right of who goes from a point to another, on the screen.
    pub fn right_of(from: ScreenPoint, to: ScreenPoint) -> Self {
        let (down, right) = (to.line - from.line, to.column - from.column);
        Self { by_line: right, by_column: -down, middle: down * from.column - right * from.line }
    }

    /// The other side of the same line.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self { by_line: -self.by_line, by_column: -self.by_column, middle: -self.middle }
    }

    /// The function at a place: positive within.
    pub fn at(self, point: ScreenPoint) -> f64 {
        self.by_line * point.line + self.by_column * point.column + self.middle
    }

    /// Part of a convex polygon within.
    fn cut(self, polygon: &[ScreenPoint]) -> Vec<ScreenPoint> {
        let mut part = Vec::with_capacity(polygon.len() + 1);
        for (number, &from) in polygon.iter().enumerate() {
            let to = polygon[(number + 1) % polygon.len()];
            let (a, b) = (self.at(from), self.at(to));
            if a >= 0.0 {
                part.push(from);
            }
            if a * b < 0.0 {
                let share = a / (a - b);
                part.push(ScreenPoint {
                    line: from.line + share * (to.line - from.line),
                    column: from.column + share * (to.column - from.column),
                });
            }
        }
        part
    }
}

/// Share of the pixel about a place that lies within all of some half planes, 0 to 1.
pub fn pixel_share<'a>(middle: ScreenPoint, within: impl IntoIterator<Item = &'a HalfPlane>) -> f64 {
    let square = [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]];
    let corner =
        |[line, column]: [f64; 2]| ScreenPoint { line: middle.line + line, column: middle.column + column };
    let mut part = square.map(corner).to_vec();
    for half in within {
        // Most pixels lie wholly on one side.
        let reach = 0.5 * (half.by_line.abs() + half.by_column.abs());
        let inside = half.at(middle);
        if inside <= -reach {
            return 0.0;
        }
        if inside < reach {
            part = half.cut(&part);
        }
    }
    area(&part).clamp(0.0, 1.0)
}

/// Area of a convex polygon.
fn area(polygon: &[ScreenPoint]) -> f64 {
    let Some(origin) = polygon.first() else { return 0.0 };
    let cross = |pair: &[ScreenPoint]| {
        (pair[0].line - origin.line) * (pair[1].column - origin.column)
            - (pair[0].column - origin.column) * (pair[1].line - origin.line)
    };
    0.5 * polygon[1..].windows(2).map(cross).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::chance::Random;

    const MIDDLE: ScreenPoint = ScreenPoint { line: 17.5, column: -200.5 };

    #[test]
    fn a_half_covered_pixel_is_the_mean_of_both_tones() {
        for degrees in 0..360 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let to = ScreenPoint { line: MIDDLE.line + 3.0 * sin, column: MIDDLE.column + 3.0 * cos };
            let share = pixel_share(MIDDLE, &[HalfPlane::right_of(MIDDLE, to)]);
            let tone = share * 200.0 + (1.0 - share) * 31.0;
            assert!((tone - 115.5).abs() < 1e-9, "{degrees}°: {tone}");
        }
    }

    #[test]
    fn shares_are_those_of_many_samples() {
        let mut random = Random(20);
        for _ in 0..300 {
            let mut half = || HalfPlane {
                by_line: random.unit() - 0.5,
                by_column: random.unit() - 0.5,
                middle: 0.6 * (random.unit() - 0.4),
            };
            let sides = [half(), half(), half()];
            let origin = ScreenPoint { line: 0.0, column: 0.0 };
            let side = |number: i32| (f64::from(number) + 0.5) / 200.0 - 0.5;
            let samples = (0..200 * 200).filter(|&number| {
                let at = ScreenPoint { line: side(number / 200), column: side(number % 200) };
                sides.iter().all(|half| half.at(at) > 0.0)
            });
            let sampled = samples.count() as f64 / 40_000.0;
            let share = pixel_share(origin, &sides);
            assert!((share - sampled).abs() < 0.006, "{share}, sampled {sampled}");
        }
    }

    #[test]
    fn both_sides_of_an_edge_add_up_to_the_pixel() {
        let from = ScreenPoint { line: 16.9, column: -203.0 };
        for line in 0..40 {
            let half =
                HalfPlane::right_of(from, ScreenPoint { line: 15.0 + f64::from(line) * 0.1, column: 9.0 });
            let both = [half, half.opposite()].map(|half| pixel_share(MIDDLE, &[half]));
            assert!((both[0] + both[1] - 1.0).abs() < 1e-12, "{both:?}");
        }
    }
}
