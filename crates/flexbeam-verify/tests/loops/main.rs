//! Loops made by hand, checked by other formulas than the crate's own.

mod by_hand;
mod certificate;
mod distributed_beam;
mod loop_figures;
mod many_rigs;
