//! The time axis of a table, judged while it is read: how far apart the samples are, and whether all are equally far.

use crate::fault::Fault;
use crate::table::{Mark, TableFault};

/// Each step of a time column is within this of the median step, relative to it.
///
/// A clock printed with three digits per period jitters by up to 1e-3; a missing sample makes a step of twice the
/// median.
pub const STEP_TOLERANCE: f64 = 1e-2;

/// Beyond this, relative to the median step, a sample is missing or one too many is there.
const GAP: f64 = 0.4;

/// Steps whose median is the one that all others are compared with. A few bad rows do not move it, so the first bad row is named.
const FIRST_STEPS: usize = 1000;

/// What a time axis may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Steps {
    /// Equal within [`STEP_TOLERANCE`].
    Equal,
    /// Jittered, but none missing: they are to be resampled.
    NoGaps,
}

/// A time axis so far.
pub(crate) struct Clock {
    allowed: Steps,
    /// The first instants [s], until their median step is known.
    first: Vec<(f64, Mark)>,
    median_s: Option<f64>,
    begin_s: f64,
    last_s: f64,
    steps: usize,
    /// Steps beyond the tolerance, the worst of them, and all steps' squared relative deviations.
    bad: usize,
    worst: Option<(f64, Mark)>,
    squares: f64,
}

/// A fault of the clock, and the row where it shows.
pub(crate) type Late = (Fault, Mark);

impl Clock {
    pub fn new(allowed: Steps) -> Clock {
        Clock {
            allowed,
            first: Vec::new(),
            median_s: None,
            begin_s: 0.0,
            last_s: 0.0,
            steps: 0,
            bad: 0,
            worst: None,
            squares: 0.0,
        }
    }

    /// Takes the next instant [s].
    ///
    /// Errors: [`Fault::UnequalPeriods`] for a gap, for an instant that comes twice, and for one that comes before the last.
    pub fn take(&mut self, time_s: f64, mark: Mark) -> Result<(), Late> {
        let Some(median_s) = self.median_s else {
            self.first.push((time_s, mark));
            return if self.first.len() > FIRST_STEPS { self.settle() } else { Ok(()) };
        };
        self.step(time_s, mark, median_s)
    }

    /// The mean step, when all instants were taken.
    ///
    /// Assumes: at least two instants.
    /// Errors: those of [`Clock::take`]; [`TableFault::Jitter`].
    pub fn period_s(&mut self) -> Result<f64, Late> {
        self.settle()?;
        self.check()?;
        Ok(shortest_near((self.last_s - self.begin_s) / self.steps as f64))
    }

    /// Whether the steps so far are what is allowed: sooner than at the end, for a long recording.
    ///
    /// Errors: [`TableFault::Jitter`].
    pub fn check(&self) -> Result<(), Late> {
        let (Some(needed_s), Some((found_s, mark)), Steps::Equal) = (self.median_s, self.worst, self.allowed) else {
            return Ok(());
        };
        let jitter = TableFault::Jitter {
            found_s,
            needed_s,
            tolerance: STEP_TOLERANCE,
            bad: self.bad,
            steps: self.steps,
            rms: (self.squares / self.steps as f64).sqrt(),
        };
        Err((jitter.into(), mark))
    }

    /// Compares the first instants with their own median step.
    fn settle(&mut self) -> Result<(), Late> {
        if self.median_s.is_some() || self.first.len() < 2 {
            return Ok(());
        }
        let first = std::mem::take(&mut self.first);
        let mut steps: Vec<f64> = first.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        let middle = steps.len() / 2;
        let median_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        self.median_s = Some(median_s);
        self.begin_s = first[0].0;
        self.last_s = first[0].0;
        first[1..].iter().try_for_each(|(time_s, mark)| self.step(*time_s, *mark, median_s))
    }

    fn step(&mut self, time_s: f64, mark: Mark, median_s: f64) -> Result<(), Late> {
        let step_s = time_s - self.last_s;
        let off = step_s / median_s - 1.0;
        if !(median_s > 0.0 && step_s > 0.0 && off.abs() <= GAP) {
            let fault = Fault::UnequalPeriods { found_s: step_s, needed_s: median_s, tolerance: STEP_TOLERANCE };
            return Err((fault, mark));
        }
        self.last_s = time_s;
        self.steps += 1;
        self.squares += off * off;
        if off.abs() > STEP_TOLERANCE {
            self.bad += 1;
            let worse = self.worst.is_none_or(|(worst, _)| (worst / median_s - 1.0).abs() < off.abs());
            self.worst = if worse { Some((step_s, mark)) } else { self.worst };
        }
        Ok(())
    }
}

/// The decimal number with fewest digits within 1e-12 of `x`, relative: 0.001 for 0.0010000000000000002.
///
/// 1e-12 is what `flexbeam_lti::Time` takes for equal.
fn shortest_near(x: f64) -> f64 {
    let rounded = (0..=16).map(|digits| format!("{x:.digits$e}").parse::<f64>().unwrap_or(x));
    rounded.into_iter().find(|r| (r - x).abs() <= 1e-12 * x.abs()).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(allowed: Steps, times_s: impl IntoIterator<Item = f64>) -> Result<f64, Late> {
        let mut clock = Clock::new(allowed);
        for (k, time_s) in times_s.into_iter().enumerate() {
            clock.take(time_s, Mark { line: k + 1, byte: 0 })?;
        }
        clock.period_s()
    }

    #[test]
    fn jitter_is_stated_and_gaps_are_told_apart() {
        // Every 100th sample is late by a fifth of a period; sample 1700 by 0.3.
        let late = |k: usize| match k {
            1700 => 0.3,
            k if k % 100 == 99 => 0.2,
            _ => 0.0,
        };
        let times = |count: usize| (0..count).map(|k| 0.01 * (k as f64 + late(k)));
        let (fault, mark) = judged(Steps::Equal, times(2001)).unwrap_err();
        let Fault::Table(TableFault::Jitter { found_s, needed_s, bad, steps, rms, .. }) = fault else {
            panic!("{fault:?}")
        };
        assert!((needed_s - 0.01).abs() < 1e-12 && (found_s - 0.007).abs() < 1e-12);
        // 1699 is late, too, so the step to 1700 is 1.1 periods and the one behind it 0.7.
        let wanted = ((19.0 * 2.0 * 0.04 + 0.04 + 0.01 + 0.09) / 2000.0f64).sqrt();
        assert_eq!((bad, steps), (41, 2000));
        assert!((rms - wanted).abs() < 1e-9, "{rms} {wanted}");
        assert_eq!(mark.line, 1702);
        assert!((judged(Steps::NoGaps, times(2001)).unwrap() - 0.01).abs() < 1e-9);
        for allowed in [Steps::Equal, Steps::NoGaps] {
            let gap = judged(allowed, times(2001).filter(|t| (t - 15.0).abs() > 1e-9)).unwrap_err();
            assert!(matches!(gap, (Fault::UnequalPeriods { .. }, Mark { line: 1501, .. })), "{gap:?}");
        }
    }
}
