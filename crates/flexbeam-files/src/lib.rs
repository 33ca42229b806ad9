//! flexbeam-files
