//! flexbeam-ident
