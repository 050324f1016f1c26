//! Screens as tables of directions.

use super::screen::{Mapping, Screen};
use super::table::RayTable;
use hedgehop_base::error::{Error, Result};

impl RayTable {
    /// The directions of a screen's pixels; none for [`Screen::Orthographic`], whose rays have one direction and many
    /// origins.
    ///
    /// # Errors
    /// [`Error::Configuration`] for that one, for [`Screen::check`]'s reasons, and where no pixel has a ray.
    pub fn of_screen(screen: &Screen, width: u32, height: u32) -> Result<Self> {
        screen.check()?;
        if let Screen::Orthographic { .. } = screen {
            return Err(Error::Configuration(
                "parallel rays make no table of directions; take another screen".into(),
            ));
        }
        let mapping = Mapping::new(screen.clone(), width, height, 0.0);
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        let directions = pixels.map(|(column, row)| {
            let ray = mapping.ray(f64::from(column) + 0.5, f64::from(row) + 0.5);
            ray.map_or([0.0; 3], |(_, direction)| direction.normalize().as_vec3().to_array())
        });
        Self::new(width, height, directions.collect())
    }
}
