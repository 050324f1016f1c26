//! Database modelling from outside: rasters, clouds, features and recipes become databases that are looked into.

mod clouds;
mod conformance;
mod corridors;
mod features;
mod land_cover;
mod matched;
mod real_places;
mod registration;
mod shadows;
mod steps;
