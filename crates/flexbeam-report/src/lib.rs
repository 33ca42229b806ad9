//! flexbeam-report
