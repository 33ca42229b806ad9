//! Numbers that may be infinite: margins and radii.

use serde::{Deserialize, Serialize};

/// A number, or infinity: `inf` in TOML, `null` in JSON (which has no infinity).
///
/// Everywhere else in the files an infinite number is a fault.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Extended(pub f64);

impl Extended {
    /// The name by which the reader knows where infinity is allowed.
    pub(crate) const NAME: &'static str = "Extended";

    /// No bound at all.
    pub const INFINITE: Extended = Extended(f64::INFINITY);
}

impl From<f64> for Extended {
    fn from(x: f64) -> Extended {
        Extended(x)
    }
}

impl From<Extended> for f64 {
    fn from(x: Extended) -> f64 {
        x.0
    }
}

/// Nothing that bounds it is infinity.
impl From<Option<f64>> for Extended {
    fn from(x: Option<f64>) -> Extended {
        x.map_or(Extended::INFINITE, Extended)
    }
}
