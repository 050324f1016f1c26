//! One file per subcommand: its flags, and what it does with the library.

pub mod bake;
pub mod bench;
pub mod build;
pub mod compare;
pub mod contact_sheet;
pub mod continuity;
pub mod contours;
pub mod demo;
pub mod extract;
pub mod farm;
pub mod height;
pub mod hillshade;
pub mod info;
pub mod manual;
pub mod merge;
pub mod overview;
pub mod plan;
pub mod profile;
pub mod recipe;
pub mod render;
pub mod scene;
pub mod shadow_heights;
pub mod sight;
pub mod verify;
pub mod verify_frames;
