//! flexbeam-design
