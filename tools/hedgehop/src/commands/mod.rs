//! One file per subcommand: its flags, and what it does with the library.

pub mod bake;
pub mod bench;
pub mod build;
pub mod demo;
pub mod info;
pub mod plan;
pub mod render;
pub mod scene;
pub mod verify;
