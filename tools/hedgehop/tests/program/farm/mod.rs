//! `hedgehop farm`: chunks of a flight, handed out by this machine or by schedulers, give what one process gives.
#![cfg(target_os = "linux")]

mod believed;
mod engines;
mod identity;
mod killed;
mod local;
mod refusals;
mod site;
mod texts;
mod workers;
