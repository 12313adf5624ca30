//! Runs against exact solutions. Effort (factorisations, steps) is asserted beside the answer.
#![allow(clippy::float_cmp, clippy::unwrap_used, clippy::expect_used)]

#[path = "../support/mod.rs"]
mod support;

mod backends;
mod bond_forces;
mod carter;
mod combinations;
mod cracks;
mod damage;
mod dynamics;
mod effects;
mod estimates;
mod fields;
mod five_spot;
mod fluid_lag;
mod fourier;
mod gravity;
mod held_wells;
mod incompressible;
mod initial;
mod laminate;
mod lefm;
mod mechanics;
mod meshes;
mod operators;
mod output;
mod patch;
mod path;
mod penny;
mod poroelastic;
mod restart;
mod shares;
mod shelf;
mod spe10;
mod split;
mod stages;
mod tensors;
mod theis;
mod toughness;
mod turned;
mod two_layer;
mod uneven_cracks;
mod uniform_flow;
mod voids;
mod wells;
