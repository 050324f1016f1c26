//! Tests of the program `hedgehop`, run as users run it, in one program.

mod classes;
mod cli;
mod clouds;
mod common;
mod corridors;
mod faults;
mod features;
mod films;
mod first_steps;
mod known_faults;
mod labels;
mod maps;
mod paging;
mod queries;
mod recipes;
mod running_sun;
mod scenes;
mod screens;
mod shadow_heights;
mod sheets;
mod titles;
mod trails;
mod verify_frames;
mod videos;
mod views;
mod vision;
