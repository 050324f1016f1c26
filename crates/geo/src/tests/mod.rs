//! Tests of the reference systems against PROJ 9.5.1 and published values.

mod geokeys;
mod heights;
mod registry;
mod systems;
mod transforms;
mod wkt;
