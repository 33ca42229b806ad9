//! Frequency responses straight from the data, without a model.
//!
//! Enters: recorded inputs and outputs. Leaves: G at many frequencies, its standard deviation, coherence; of a periodic
//! excitation noise and nonlinear distortion apart. Deliberately absent: models, plots.

mod averaging;
mod period;
mod welch;

pub use averaging::{Averaged, Detection, averaged};
pub use period::repeats_after;
pub use welch::{Segments, h1};

use flexbeam_lti::{CMat, Mat};

/// G between recorded inputs and outputs, at frequencies that rise.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Frequencies [rad/s], between zero and pi/Ts.
    pub omega_rad_s: Vec<f64>,
    /// G of the sampled system, behind its hold: l x m at each frequency.
    pub G: Vec<CMat>,
    /// Root of the expected |error|^2 of each entry: l x m at each frequency.
    pub std: Vec<Mat>,
    /// Part of each output's power that all inputs together explain, 0 to 1: l at each frequency. Nothing where periods
    /// were averaged, whose noise is known by itself.
    pub coherence: Option<Vec<Vec<f64>>>,
}

/// |error| of a circular complex Gaussian estimate stays below this many standard deviations with probability `level`.
///
/// |error|^2/std^2 is exponentially distributed: sqrt(-ln(1 - level)), 1.73 for 95 %.
pub fn circular_quantile(level: f64) -> f64 {
    (-(-level).ln_1p()).sqrt()
}
