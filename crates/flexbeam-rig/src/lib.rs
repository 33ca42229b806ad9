//! flexbeam-rig
