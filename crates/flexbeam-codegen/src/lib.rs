//! A controller as source text that stands alone: C99, `no_std` Rust, a functional mock-up unit. The simulated rig as a unit.
//!
//! Enters: a controller file, its live settings, what its certificate says. Leaves: files by name, with test vectors that the
//! kernel made. The order of every sum and product is the kernel's, so in f64 the bits are, too. The same input gives the same
//! bytes: no date, no machine, no function whose last bit depends on one.
//! Deliberately absent: writing the files, verifying (flexbeam-verify), compilers.
//!
//! The fixed part of the text lies in `templates/`, as the files that come out, with the name `NAME` (in macros `UPPER`) and
//! `@MARKS@` where numbers go.

mod bound;
pub mod c;
pub mod fmu;
mod heading;
mod name;
mod number;
mod numbers;
mod rig;
pub mod rust;
mod settings;
mod single;
mod stimulus;
mod template;
mod vectors;

pub use bound::{NoBound, SingleBound};
pub use name::Name;
pub use numbers::rounded;
pub use rig::{RigSubject, rig_sources};
pub use vectors::{SingleError, SingleFigures};

use flexbeam_files::{Controller, LoopFigures};
use flexbeam_kernel as kernel;

/// Why a controller or a rig cannot be written as source text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// No name for a file, a type and a function.
    #[error(
        "found the name {found:?}, which {why}; needed a letter, then letters, digits and underscores, {longest} at most\nhint: --name beam_controller, for example",
        longest = Name::LONGEST
    )]
    Name {
        /// Name found.
        found: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// Too large for f32.
    #[error(
        "found {key} = {found:e}, which overflows f32; needed a magnitude of at most {largest:e}\nhint: --precision f64",
        largest = f32::MAX
    )]
    Overflow {
        /// Where it stands in the controller file, counted from 1.
        key: String,
        /// Number found.
        found: f64,
    },
    /// Too small for f32.
    #[error(
        "found {key} = {found:e}, which f32 keeps with fewer digits or as zero; needed zero, or a magnitude of at least {smallest:e}\nhint: --precision f64",
        smallest = f32::MIN_POSITIVE
    )]
    Subnormal {
        /// Where it stands in the controller file, counted from 1.
        key: String,
        /// Number found.
        found: f64,
    },
    /// A voltage cannot be early.
    #[error(
        "found a rig without computing delay, needed one period at least\nhint: computing_delay_periods = 1 in the rig file: a controller as a unit is one period late by itself"
    )]
    Delay,
    /// More than an Integer of FMI 2.0 holds.
    #[error(
        "found encoder.counts_per_turn = {found}, needed at most {largest}\nhint: 0 stands for an exact encoder",
        largest = i32::MAX
    )]
    Counts {
        /// Counts found.
        found: u32,
    },
    /// No rig can have these parameters.
    #[error("{0}")]
    Rig(#[from] flexbeam_rig::Error),
    /// The kernel does not take the coefficients.
    #[error("{0}")]
    Kernel(#[from] kernel::Error),
}

/// Precision of all arithmetic in the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// The kernel's own: the same bits.
    F64,
    /// For processors without f64; how far it is off is measured and stated.
    F32,
}

/// How the text is to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Of files, types and functions.
    pub name: Name,
    /// Of all arithmetic.
    pub precision: Precision,
}

/// What is written as text.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The controller file as it was verified, not rounded.
    pub controller: &'a Controller,
    /// The live settings that it starts with, not rounded.
    pub settings: &'a kernel::Settings,
    /// SHA-256 of the controller file.
    pub sha256: &'a str,
    /// Figures of the sampled loop with the numbers that stand in the text: for f32, recomputed with [`rounded`] ones.
    pub figures: &'a LoopFigures,
    /// Why it is written although its certificate does not match, in words.
    pub unverified: Option<&'a str>,
}

/// One file.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Its path below the folder, with slashes.
    pub path: String,
    /// What it holds.
    pub text: String,
}

/// The files, and how far f32 is off.
#[derive(Clone, Debug, PartialEq)]
pub struct Sources {
    /// The files.
    pub files: Vec<Source>,
    /// How far f32 is off; none in f64.
    pub single: Option<SingleFigures>,
}
