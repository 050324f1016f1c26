//! Sample of the valley's ground.

use crate::{land, roads, water};

/// All that the files show.
pub(super) struct Sample {
    pub(super) water: water::Water,
    pub(super) roads: Vec<roads::Road>,
    pub(super) valley: land::Valley,
}
