//! One column of the screen, bottom to top, with range coherence where it is exact.

use super::{Contact, Marcher};
use crate::space::Camera;
use hedgehop_base::error::Result;

/// Contacts of one screen column, `[height]`, row 0 at the top of the screen; `None` = sky, or no ray.
pub type Column = Vec<Option<Contact>>;

/// Marches screen column `column` through the pixel centres.
///
/// On planar, cylindrical and equirectangular screens with pitch and roll 0 a column lies in a vertical plane through the
/// eye (a vertical scan line). Over a
/// single-valued surface a ray with a higher elevation angle then cannot end at a lesser ground
/// distance, so each ray starts where the one below it ended, and above a ray that sees the sky there is
/// only sky (Hughes patent, "coherence"; claim 14). Curvature changes nothing in that: over ground distance `d`
/// it adds the same `d² / 2R′` to every ray, so the higher ray stays the higher one, and the surface has one
/// height. In any other attitude, and on other screens, each ray starts at the eye.
pub fn march_column(marcher: &mut Marcher<'_>, camera: &Camera, column: u32) -> Result<Column> {
    let coherent = camera.has_vertical_columns();
    let mut contacts = vec![None; camera.height as usize];
    let mut ground_distance = 0.0;
    for row in (0..camera.height).rev() {
        let Some(ray) = camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5) else { continue };
        let ray = marcher.ray(ray.origin, ray.direction);
        let contact = marcher.first_contact(&ray, ground_distance)?;
        contacts[row as usize] = contact;
        match contact {
            Some(contact) if coherent => ground_distance = contact.range * ray.ground_cosine,
            None if coherent => break,
            _ => {}
        }
    }
    Ok(contacts)
}
