//! The scenes of `analytic` once more, as scan planes see them.

#[path = "../scene.rs"]
mod scene;

#[path = "../analytic/attitude.rs"]
mod attitude;
#[path = "../analytic/earth.rs"]
mod earth;
#[path = "../analytic/horizon.rs"]
mod horizon;
#[path = "../analytic/judge.rs"]
mod judge;
#[path = "../analytic/light.rs"]
mod light;
#[path = "../analytic/projections.rs"]
mod projections;
#[path = "../analytic/screen.rs"]
mod screen;
#[path = "../analytic/seams.rs"]
mod seams;
#[path = "../analytic/slopes.rs"]
mod slopes;

/// What renders.
const ENGINE: hedgehop::render::Engine = hedgehop::render::Engine::Planes;
