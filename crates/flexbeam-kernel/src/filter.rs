//! First-order low-pass filter of one measurement (anti-aliasing after the converter, DESIGN section 7).

/// y_f, or nothing before the first measurement.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct LowPass {
    y_f: Option<f64>,
}

impl LowPass {
    /// y_f = y - (1 - a) (y - y_f), which is y_f += a (y - y_f); the first measurement passes.
    ///
    /// Numerics: in this form a = 1 passes y to the last bit, and y_f = y stays there for any a.
    pub(crate) fn pass(&mut self, a: f64, y: f64) -> f64 {
        let y_f = match self.y_f {
            Some(y_f) => y - (1.0 - a) * (y - y_f),
            None => y,
        };
        self.y_f = Some(y_f);
        y_f
    }

    /// The last output; nothing before the first measurement.
    pub(crate) fn last(&self) -> Option<f64> {
        self.y_f
    }
}
