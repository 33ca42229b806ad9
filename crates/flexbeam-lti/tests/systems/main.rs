//! Properties of systems, each checked by a formula that the code under test does not use.
#![allow(non_snake_case)]
// References from 60 digits keep the digits they came with.
#![allow(clippy::excessive_precision)]

mod connections;
mod generalised;
mod plants;
mod rational;
mod response;
mod sampling;
mod simulation;
mod zeros;
