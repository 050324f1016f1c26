//! Whole frames of worlds whose pictures are known in closed form.

#[path = "../common/scene.rs"]
mod scene;

mod attitude;
mod earth;
mod horizon;
mod light;
mod screen;
mod seams;
mod slopes;

use std::sync::LazyLock;

use hedgehop::subimage::Farm;

/// Two workers for all tests; that their number does not matter is another test's concern.
static FARM: LazyLock<Farm> = LazyLock::new(|| Farm::new(2).unwrap());
