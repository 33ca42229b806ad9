//! flexbeam-verify
