//! What stands on the ground: against closed forms, and by scan planes against the reference.

mod closed_forms;
mod engines;
mod facades;
mod scenes;
mod shortcuts;
