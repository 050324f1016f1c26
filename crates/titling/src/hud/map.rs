//! The small map: shaded relief of the area, the path, the own position.

use glam::DVec2;

use super::canvas::{Canvas, Ink};
use crate::relief::{Relief, Window};
use hedgehop::voxel::PageSource;
use hedgehop_base::error::Result;

/// Places of the path at most.
const MOST_PLACES: usize = 2000;

/// Shaded relief of an area, and a path through it.
#[derive(Debug, Clone)]
pub struct MiniMap {
    pub(super) relief: Relief,
    path: Vec<DVec2>,
}

impl MiniMap {
    /// Draws the map of a database, with a path of places in its reference system, metres; of one that repeats without end the path may leave it.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn new(source: &dyn PageSource, path: &[DVec2], is_endless: bool) -> Result<Self> {
        let every = path.len().div_ceil(MOST_PLACES).max(1);
        let relief = Relief::new(source, Window { is_endless, ..Window::whole(source) })?;
        Ok(Self { relief, path: path.iter().copied().step_by(every).collect() })
    }

    /// Draws it so high, in pixels, with its lower right corner at a place; `own` is where the eye is, `heading` degrees clockwise from grid north.
    pub fn draw(
        &self,
        canvas: &mut Canvas<'_>,
        corner: DVec2,
        height: f64,
        own: DVec2,
        heading: f64,
        ink: Ink,
    ) {
        let extent = self.relief.window.extent;
        let size = extent * (height / extent.max_element());
        let first = corner - size;
        let [columns, rows] = [0, 1].map(|axis| (first[axis].floor() as i64, corner[axis].floor() as i64));

        for row in rows.0..rows.1 {
            for column in columns.0..columns.1 {
                let share = (DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - first) / size;
                canvas.mix(column, row, self.relief.nearest(share), 0.85);
            }
        }

        let place = |at: DVec2| first + self.relief.window.share(at) * size;
        let path = Ink { colour: [235, 60, 40], halo: 0.0 };
        for way in self.relief.window.parts(self.path.iter().copied()) {
            for pair in way.windows(2) {
                canvas.line([first + pair[0] * size, first + pair[1] * size], path);
            }
        }

        let (sine, cosine) = heading.to_radians().sin_cos();
        let (ahead, aside) = (DVec2::new(sine, -cosine), DVec2::new(cosine, sine));
        let (nose, long) = (place(own), 4.0 * canvas.dot as f64);
        let tail = nose - ahead * 2.0 * long;
        for wing in [-1.0, 1.0] {
            canvas.line([nose, tail + aside * wing * long], ink);
        }

        let corners = [first, DVec2::new(corner.x, first.y), corner, DVec2::new(first.x, corner.y)];
        for side in 0..4 {
            canvas.line([corners[side], corners[(side + 1) % 4]], Ink { halo: 0.0, ..ink });
        }
    }
}
