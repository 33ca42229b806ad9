//! Samples of a converter and the volts that they stand for.
//!
//! Computed here and not by the library, so that the loop calls nothing that it need not; a test holds the two together.

/// A range of a converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Volts of sample 0 [V].
    pub min_v: f64,
    /// Volts of the greatest sample [V].
    pub max_v: f64,
    /// The greatest sample.
    pub greatest: u32,
}

impl Scale {
    /// Real-time: yes. Volts of a sample.
    ///
    /// Differs from `comedi_to_phys` at the two ends, for which that answers NaN, since the input may be out of range: here they
    /// are the ends, numbers that are large enough for the loop's limit on the deflection.
    pub(crate) fn volts(&self, sample: u32) -> f64 {
        f64::from(sample) / f64::from(self.greatest) * (self.max_v - self.min_v) + self.min_v
    }

    /// Real-time: yes. The sample nearest to `board_v`; beyond the range its end.
    ///
    /// Assumes: a finite voltage.
    pub(crate) fn sample(&self, board_v: f64) -> u32 {
        let position = (board_v - self.min_v) / (self.max_v - self.min_v) * f64::from(self.greatest);
        // The cast cuts off, and takes what is out of range to the ends of u32.
        ((position + 0.5) as u32).min(self.greatest)
    }

    /// Largest magnitude that it holds with either sign [V]; not positive where 0 V is not inside.
    pub(crate) fn reach_v(&self) -> f64 {
        self.max_v.min(-self.min_v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn step_v(scale: &Scale) -> f64 {
        (scale.max_v - scale.min_v) / f64::from(scale.greatest)
    }

    const TWELVE_BITS: Scale = Scale { min_v: -10.0, max_v: 10.0, greatest: 4095 };

    #[test]
    fn the_ends_are_the_ends() {
        assert_eq!((TWELVE_BITS.sample(-10.0), TWELVE_BITS.sample(10.0)), (0, 4095));
        assert_eq!((TWELVE_BITS.sample(-99.0), TWELVE_BITS.sample(99.0)), (0, 4095));
        assert_eq!((TWELVE_BITS.volts(0), TWELVE_BITS.volts(4095)), (-10.0, 10.0));
    }

    #[test]
    fn a_range_without_0_v_inside_reaches_nowhere() {
        assert_eq!(TWELVE_BITS.reach_v(), 10.0);
        assert_eq!(Scale { min_v: -5.0, ..TWELVE_BITS }.reach_v(), 5.0);
        assert!(!(Scale { min_v: 0.0, ..TWELVE_BITS }.reach_v() > 0.0));
    }

    #[test]
    fn zero_is_at_most_half_a_step_from_zero() {
        assert!(TWELVE_BITS.volts(TWELVE_BITS.sample(0.0)).abs() <= 0.5 * step_v(&TWELVE_BITS));
    }

    /// `comedi_range`.
    #[repr(C)]
    struct Range(f64, f64, u32);

    type ToVolts = unsafe extern "C" fn(u32, *const Range, u32) -> f64;
    type FromVolts = unsafe extern "C" fn(f64, *const Range, u32) -> u32;

    /// comedilib's own conversions, where it is installed; says so where it is not.
    fn comedilib() -> Option<(ToVolts, FromVolts)> {
        let missing = crate::board::Missing { library: "comedilib", hint: "" };
        let library = crate::board::Library::open(&["libcomedi.so.0"], &missing);
        let library = library.map_err(|error| eprintln!("nothing compared with comedilib: {error}")).ok()?;
        // SAFETY: the types are those of comedilib.h.
        unsafe {
            Some((library.function("comedi_to_phys", "").unwrap(), library.function("comedi_from_phys", "").unwrap()))
        }
    }

    #[test]
    fn the_library_converts_alike() {
        let Some((to_volts, from_volts)) = comedilib() else { return };
        for (min_v, max_v, greatest) in [(-10.0, 10.0, 4095), (-5.0, 5.0, 65535), (-1.25, 10.0, 0xff_ffff)] {
            let scale = Scale { min_v, max_v, greatest };
            let range = Range(min_v, max_v, 0);
            for k in -5..=105 {
                let board_v = min_v + f64::from(k) / 100.0 * (max_v - min_v);
                // SAFETY: the range outlives the calls.
                let (sample, volts) = unsafe {
                    let sample = from_volts(board_v, &range, greatest);
                    (sample, to_volts(sample, &range, greatest))
                };
                assert_eq!(scale.sample(board_v), sample, "{board_v} V");
                let end = sample == 0 || sample == greatest;
                assert_eq!(volts.is_nan(), end, "{board_v} V");
                assert!(end || scale.volts(sample) == volts, "{board_v} V");
            }
        }
    }

    proptest! {
        #[test]
        fn there_and_back_is_at_most_half_a_step(board_v in -10.0..10.0, greatest in 255_u32..=u32::MAX) {
            let scale = Scale { greatest, ..TWELVE_BITS };
            let error_v = (scale.volts(scale.sample(board_v)) - board_v).abs();
            prop_assert!(error_v <= 0.5 * step_v(&scale) + 1e-14, "{error_v} V");
        }
    }
}
