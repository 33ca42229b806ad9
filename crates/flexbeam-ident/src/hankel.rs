//! Block Hankel matrices, equation (8), never formed: only their triangular factor is.

mod cholesky;
pub(crate) mod factor;
#[cfg(test)]
mod hard_cases;
