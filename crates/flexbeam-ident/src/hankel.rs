//! Block Hankel matrices, equation (8), never formed: only their triangular factor is.

pub(crate) mod factor;
