//! Whole frames of worlds whose pictures are known in closed form, as the reference marcher sees them; `planes` has the
//! same scenes seen by scan planes.

#[path = "../scene.rs"]
mod scene;

mod attitude;
mod earth;
mod horizon;
mod judge;
mod light;
mod projections;
mod screen;
mod seams;
mod slopes;

/// What renders.
const ENGINE: hedgehop::render::Engine = hedgehop::render::Engine::Reference;
