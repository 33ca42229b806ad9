//! Responses of a system to its inputs in modal coordinates, where every state is a filter of one pole.
//!
//! Enters: A, recorded inputs and outputs. Leaves: B, D, the initial state and the output's offsets that fit the outputs best, and how well.
//! Deliberately absent: systems whose modes are no basis, or that grow out of the record; the QR of `output_map` answers those.

mod block;
mod least_squares;
mod modes;
mod responses;
mod shape;

pub(crate) use least_squares::{Free, ModalFit, Problem};
