//! Signs that a recording is not what it seems: signals at their stops, coarse steps, feedback.
//!
//! Enters: channels, triangular factor. Leaves: doubts with their percentages; a refusal where nothing can be known.
//! Deliberately absent: repairs, which belong to the person.

use std::collections::HashSet;
use std::fmt;

use flexbeam_lti::Signals;

use crate::Error;
use crate::hankel::factor::Factor;
use crate::identify::Feedthrough;
use crate::singular::pivoted;

/// Samples in a row at the largest or smallest value that make a stop.
const STOP_RUN: usize = 3;
/// Stops at one value: a hub at rest before and after makes two.
const STOP_VISITS: usize = 3;
/// Part of an output's samples at its stops worth a word.
const STOPPED_OUTPUT: f64 = 0.005;
/// The same of an input: limited excitation is what the rig got, and harmless.
const STOPPED_INPUT: f64 = 0.1;
/// Fewer levels than this are chosen ones: binary and staircase inputs.
const CHOSEN_LEVELS: usize = 10;
/// More levels than this are no coarse steps.
const COARSE_LEVELS: usize = 64;
/// A step above this part of the rms is coarse: as noise it leaves 3 %.
const COARSE_STEP: f64 = 0.1;
/// Outputs that move by less than this part of their rms within the block rows stand still for them.
const HARDLY_MOVES: f64 = 0.05;
/// Part of the input, beyond what its own past says, that the outputs' past says: open loop leaves sampling error.
const FEEDBACK: f64 = 0.05;
/// The input follows from the outputs but for this part: nothing came from outside.
const NOTHING_FROM_OUTSIDE: f64 = 1e-8;
/// The outputs are not themselves known but for rounding: without noise D alone makes the input follow from them.
const NOISE: f64 = 1e-12;

/// A row that others leave less than this part of follows from them, but for rounding.
const DEPENDENT: f64 = 1e-12;

/// A sign, with its numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// The channel stands at its largest or smallest value again and again.
    Saturated {
        /// Name of the channel.
        channel: String,
        /// Samples there [percent].
        percent: f64,
        /// Smallest and largest value.
        stops: [f64; 2],
    },
    /// The channel has few levels, far apart.
    Coarse {
        /// Name of the channel.
        channel: String,
        /// Levels found.
        levels: usize,
        /// Smallest distance of two, over the rms about the mean [percent].
        step_percent: f64,
        /// Samples that repeat the one before [percent].
        still_percent: f64,
    },
    /// Nothing moves within the horizon: sampled too fast for these block rows.
    Slow {
        /// Movement of the liveliest output within it, over its rms [percent].
        percent: f64,
        /// Block rows i.
        block_rows: usize,
    },
    /// Inputs and outputs follow from each other at the same sample.
    Inverse,
    /// The input follows in part from the outputs: feedback, under which noise and input go together.
    Feedback {
        /// Variance of the input, beyond its own past, that the outputs explain [percent].
        percent: f64,
    },
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::Saturated { channel, percent, stops: [low, high] } => write!(
                f,
                "{channel} stands at {low:.4} or {high:.4} for {percent:.1} % of the samples: it looks cut off, and a linear \
                 model takes that for dynamics"
            ),
            Doubt::Coarse { channel, levels, step_percent, still_percent } => write!(
                f,
                "{channel} has {levels} levels, {step_percent:.0} % of its rms apart, and {still_percent:.0} % of its samples repeat \
                 the one before: much of what it did is lost"
            ),
            Doubt::Slow { percent, block_rows } => write!(
                f,
                "within {block_rows} samples, the block rows, the outputs move by {percent:.1} % of their rms: sampled too fast for \
                 them; noise is all that they see clearly"
            ),
            Doubt::Inverse => write!(
                f,
                "inputs and outputs follow from each other at the same sample without remainder: either nothing is noisy and the \
                 system answers at once, or this is a closed loop without external excitation and the model its controller's \
                 inverse; D = 0, if known, tells the two apart"
            ),
            Doubt::Feedback { percent } => write!(
                f,
                "{percent:.0} % of what is new in the input follows from the outputs: the recording is of a closed loop, and noise \
                 biases the model by as much as the loop feeds back"
            ),
        }
    }
}

/// Doubts about the channels themselves.
pub(crate) fn of_channels(inputs: &Signals, outputs: &Signals) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    for (signals, driven) in [(inputs, false), (outputs, true)] {
        for (c, name) in signals.names.iter().enumerate() {
            let x: Vec<f64> = signals.data.row(c).iter().copied().collect();
            let levels = levels(&x);
            doubts.extend(saturated(name, &x, levels.as_ref().map(Vec::len), driven));
            doubts.extend(levels.filter(|_| driven).and_then(|levels| coarse(name, &x, &levels)));
        }
    }
    doubts
}

/// The distinct values in ascending order, when they are few.
fn levels(x: &[f64]) -> Option<Vec<f64>> {
    let mut seen = HashSet::new();
    for value in x {
        // -0 is 0.
        if seen.insert((value + 0.0).to_bits()) && seen.len() > COARSE_LEVELS {
            return None;
        }
    }
    let mut levels: Vec<f64> = seen.into_iter().map(f64::from_bits).collect();
    levels.sort_by(f64::total_cmp);
    Some(levels)
}

fn saturated(name: &str, x: &[f64], levels: Option<usize>, driven: bool) -> Option<Doubt> {
    if levels.is_some_and(|levels| levels < CHOSEN_LEVELS) {
        return None;
    }
    let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
    let mut stopped = 0;
    for stop in [low, high] {
        let runs = x.chunk_by(|a, b| a == b).filter(|run| run[0] == stop);
        let lengths: Vec<usize> = match driven {
            true => runs.map(<[f64]>::len).filter(|length| *length >= STOP_RUN).collect(),
            false => runs.map(<[f64]>::len).collect(),
        };
        stopped += if lengths.len() >= STOP_VISITS { lengths.iter().sum() } else { 0 };
    }
    let part = stopped as f64 / x.len() as f64;
    let worth_a_word = if driven { STOPPED_OUTPUT } else { STOPPED_INPUT };
    (part > worth_a_word).then(|| Doubt::Saturated { channel: name.into(), percent: 100.0 * part, stops: [low, high] })
}

fn coarse(name: &str, x: &[f64], levels: &[f64]) -> Option<Doubt> {
    let step = levels.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let rms = (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt();
    let still = x.windows(2).filter(|w| w[0] == w[1]).count() as f64 / (x.len() - 1).max(1) as f64;
    (step.is_finite() && step > COARSE_STEP * rms).then(|| Doubt::Coarse {
        channel: name.into(),
        levels: levels.len(),
        step_percent: 100.0 * step / rms,
        still_percent: 100.0 * still,
    })
}

/// Whether the outputs hardly move within i samples.
pub(crate) fn of_horizon(outputs: &Signals, i: usize) -> Option<Doubt> {
    let movement = |row: usize| {
        let y: Vec<f64> = outputs.data.row(row).iter().copied().collect();
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        let size: f64 = y.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / y.len() as f64;
        let moved = y.iter().zip(&y[i.min(y.len())..]).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
        (moved / (y.len() - i) as f64 / size).sqrt()
    };
    let most = (0..outputs.channels()).map(movement).filter(|part| part.is_finite()).fold(0.0, f64::max);
    (most < HARDLY_MOVES).then_some(Doubt::Slow { percent: 100.0 * most, block_rows: i })
}

/// Whether the input answers to the outputs: u(k) regressed on its own past, then on the outputs' past and present too.
///
/// Errors: [`Error::ClosedLoop`] when the outputs leave nothing of it, and they are noisy or known to have no feedthrough.
pub(crate) fn of_loop(factor: &Factor, feedthrough: Feedthrough) -> Result<Option<Doubt>, Error> {
    let i = factor.i;
    let rows = [
        factor.inputs(0..i),
        factor.outputs(0..i),
        factor.inputs(i..i + 1),
        factor.outputs(i..i + 1),
        factor.inputs(i..i + 1),
    ];
    // Squared norm of the last group of rows beside those before it. Without noise these depend on each other, and what rounding leaves
    // of such a row must not count as one.
    let left = |order: &[usize]| {
        let (last, before) = order.split_last().expect("something is asked for");
        let before: Vec<usize> = before.iter().flat_map(|&k| rows[k].clone()).collect();
        let mut before = factor.L.select_rows(&before).transpose();
        before.column_iter_mut().for_each(|mut row| _ = row.normalize_mut());
        let Q = pivoted(&before, DEPENDENT).0;
        let now = factor.L.select_rows(&rows[*last]).transpose();
        (&now - &Q * Q.tr_mul(&now)).norm_squared()
    };
    let (by_itself, by_past) = (left(&[0, 2]), left(&[0, 1, 2]));
    let (by_outputs, noise) = (left(&[0, 1, 3, 4]), left(&[0, 1, 2, 3]));
    let whole = |rows: &[usize]| factor.L.select_rows(rows).norm_squared();
    if by_outputs <= NOTHING_FROM_OUTSIDE * by_itself {
        // Without noise the inverse of D gives the input away, too.
        let noisy = noise > NOISE * whole(&rows[3]) || feedthrough == Feedthrough::Zero;
        return if noisy { Err(Error::ClosedLoop { left: by_outputs / by_itself }) } else { Ok(Some(Doubt::Inverse)) };
    }
    let part = 1.0 - by_past / by_itself;
    Ok((part > FEEDBACK).then_some(Doubt::Feedback { percent: 100.0 * part }))
}

#[cfg(test)]
mod tests {
    use flexbeam_lti::Mat;

    use super::*;
    use crate::excitation::white_gaussian;

    fn channel(name: &str, x: Vec<f64>) -> Signals {
        Signals::new(vec![name.into()], vec!["".into()], 0.1, Mat::from_row_slice(1, x.len(), &x)).unwrap()
    }

    fn swing(s: usize) -> Vec<f64> {
        (0..s).map(|k| (0.05 * k as f64).sin() + 0.3 * (0.0171 * k as f64).cos()).collect()
    }

    fn doubts(u: Vec<f64>, y: Vec<f64>) -> Vec<Doubt> {
        of_channels(&channel("u", u), &channel("y", y))
    }

    #[test]
    fn a_cut_output_is_told_with_its_share() {
        let u = white_gaussian(2000, 1.0, 9.0, 1);
        assert_eq!(doubts(u.clone(), swing(2000)), []);
        let cut: Vec<f64> = swing(2000).iter().map(|y| y.clamp(-0.9, 0.9)).collect();
        let share = cut.iter().filter(|y| y.abs() == 0.9).count() as f64 / 20.0;
        let found = doubts(u, cut);
        assert!(
            matches!(&found[..], [Doubt::Saturated { channel, percent, .. }] if channel == "y" && (percent - share).abs() < 0.5)
        );
        assert!(found[0].to_string().contains('%'));
    }

    /// Excitation limited at two standard deviations, and a binary one: nothing to say. Limited at a tenth: something.
    #[test]
    fn limited_excitation_is_harmless_until_little_else_is_left() {
        let binary = white_gaussian(2000, 1.0, 9.0, 2).iter().map(|u| u.signum()).collect();
        assert_eq!(doubts(binary, swing(2000)), []);
        assert_eq!(doubts(white_gaussian(2000, 1.0, 2.0, 2), swing(2000)), []);
        let hard = doubts(white_gaussian(2000, 1.0, 0.1, 2), swing(2000));
        assert!(matches!(&hard[..], [Doubt::Saturated { channel, .. }] if channel == "u"), "{hard:?}");
    }

    #[test]
    fn a_signal_quantised_to_nothing_is_told_with_its_share() {
        let u = white_gaussian(2000, 1.0, 9.0, 1);
        let step = |q: f64| swing(2000).iter().map(|y| (y / q).round() * q).collect::<Vec<f64>>();
        assert_eq!(doubts(u.clone(), step(0.01)), []);
        let found = doubts(u, step(0.5));
        assert!(
            matches!(&found[..], [Doubt::Coarse { levels: 5 | 6, step_percent, .. }] if *step_percent > 50.0),
            "{found:?}"
        );
    }

    /// u = r - 0.6 y, y(k+1) = 0.9 y + u + e.
    ///
    /// With two noises in two outputs the input cannot tell them: the outputs do not follow from the input.
    fn looped(outside: f64, noise: f64) -> Factor {
        let (r, e) = (white_gaussian(4000, 1.0, 9.0, 3), white_gaussian(4000, 1.0, 9.0, 4));
        let f = white_gaussian(4000, noise, f64::INFINITY, 5);
        let (mut U, mut Y, mut y) = (Mat::zeros(4000, 1), Mat::zeros(4000, 2), 1.0);
        for k in 0..4000 {
            let u = outside * r[k] - 0.6 * (y + f[k]);
            (U[k], Y[(k, 0)], Y[(k, 1)]) = (u, y + f[k], y);
            y = 0.9 * y + u + noise * e[k];
        }
        Factor::new(&U, &Y, 5, false)
    }

    #[test]
    fn feedback_is_told_and_a_loop_without_excitation_refused() {
        assert!(matches!(of_loop(&looped(1.0, 0.0), Feedthrough::Free), Ok(Some(Doubt::Feedback { .. }))));
        assert!(
            matches!(of_loop(&looped(1.0, 1.0), Feedthrough::Free), Ok(Some(Doubt::Feedback { percent })) if percent > 10.0)
        );
        let refused = of_loop(&looped(0.0, 1.0), Feedthrough::Free);
        assert!(matches!(refused, Err(Error::ClosedLoop { .. })), "{refused:?}");
    }

    #[test]
    fn an_open_loop_is_not_taken_for_a_closed_one() {
        for noise in [0.0, 0.5] {
            let (u, e) = (white_gaussian(4000, 1.0, 9.0, 3), white_gaussian(4000, 1.0, 9.0, 4));
            let (mut Y, mut y) = (Mat::zeros(4000, 1), 0.0);
            for k in 0..4000 {
                // With a feedthrough: without noise the input follows from the outputs exactly.
                Y[k] = y + 0.5 * u[k] + noise * e[k];
                y = 0.9 * y + u[k];
            }
            let factor = Factor::new(&Mat::from_column_slice(4000, 1, &u), &Y, 5, false);
            let found = of_loop(&factor, Feedthrough::Free);
            assert_eq!(found, Ok(if noise > 0.0 { None } else { Some(Doubt::Inverse) }), "noise {noise}");
        }
    }
}
