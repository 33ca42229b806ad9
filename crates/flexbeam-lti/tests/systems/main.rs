//! Properties of systems, each checked by a formula that the code under test does not use.
#![allow(non_snake_case)]

mod connections;
mod plants;
mod sampling;
mod simulation;
