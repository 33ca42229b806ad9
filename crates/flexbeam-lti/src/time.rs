use crate::Error;

/// The time axis of a system or a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Time {
    /// Continuous time, s-plane.
    Continuous,
    /// Sampled time, z-plane.
    Sampled {
        /// Sample period [s], positive.
        period_s: f64,
    },
}

impl Time {
    /// The common time axis of two systems that are to be connected.
    ///
    /// Errors: [`Error::TimeMismatch`] shows both axes. Periods count as equal within 1e-12 relative,
    /// the rounding of a period that went through a text file.
    pub fn common(self, other: Time) -> Result<Time, Error> {
        let same = match (self, other) {
            (Time::Continuous, Time::Continuous) => true,
            (Time::Sampled { period_s: a }, Time::Sampled { period_s: b }) => (a - b).abs() <= 1e-12 * a.abs(),
            _ => false,
        };
        if same { Ok(self) } else { Err(Error::TimeMismatch { left: self, right: other }) }
    }
}

impl std::fmt::Display for Time {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Time::Continuous => write!(f, "continuous time"),
            Time::Sampled { period_s } => write!(f, "period {period_s} s"),
        }
    }
}
