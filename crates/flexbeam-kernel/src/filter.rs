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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_leaves_a_geometric_rest() {
        let mut filter = LowPass::default();
        assert_eq!(filter.pass(0.3, 0.0), 0.0);
        for k in 1..40 {
            assert!((filter.pass(0.3, 1.0) - (1.0 - 0.7f64.powi(k))).abs() < 1e-15);
        }
    }

    #[test]
    fn one_passes_every_bit_and_a_constant_stays() {
        let mut filter = LowPass::default();
        for y in [0.1, 1e300, -3e-310, 1.0 / 3.0, 1e-20] {
            assert_eq!(filter.pass(1.0, y).to_bits(), y.to_bits());
        }
        (0..10).for_each(|_| assert_eq!(filter.pass(0.37, 1e-20).to_bits(), 1e-20f64.to_bits()));
    }

    #[test]
    fn the_first_measurement_passes_without_a_transient() {
        assert_eq!(LowPass::default().pass(0.01, 2.5), 2.5);
    }
}
