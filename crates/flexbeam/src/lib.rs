//! flexbeam
