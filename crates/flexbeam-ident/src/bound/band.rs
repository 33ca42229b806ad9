//! How far the true response may lie from a model's, on a line.

use flexbeam_lti::response::Hessenberg;
use flexbeam_lti::{C64, CMat, StateSpace};

use super::poles_beyond;
use crate::Error;

/// |G - model| on s = jw - beta stays below `radius` at all w at once, with probability `level`.
///
/// Whoever knows a model's covariance can fill one: it is all that a bound needs to know.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Frequencies on the line [rad/s], positive and rising.
    pub omega_rad_s: Vec<f64>,
    /// Radius at each, in units of G.
    pub radius: Vec<f64>,
    /// Probability that it holds everywhere.
    pub level: f64,
}

impl Band {
    /// Radius at any frequency: between two points a straight line over log w, beyond the ends the end's value.
    pub fn radius_at(&self, omega: f64) -> f64 {
        let k = self.omega_rad_s.partition_point(|w| *w < omega);
        if k == 0 || k == self.omega_rad_s.len() {
            return self.radius[k.min(self.radius.len() - 1)];
        }
        let (low, high) = (self.omega_rad_s[k - 1], self.omega_rad_s[k]);
        let part = (omega / low).ln() / (high / low).ln();
        self.radius[k - 1] + part * (self.radius[k] - self.radius[k - 1])
    }

    /// This band and something else that may be off besides, at each frequency.
    #[must_use]
    pub fn widened(mut self, by: impl Fn(f64) -> f64) -> Band {
        self.omega_rad_s.iter().zip(&mut self.radius).for_each(|(omega, radius)| *radius += by(*omega));
        self
    }

    /// The band around `model` from models that were estimated again, each from a recording that might as well have been made.
    ///
    /// At each w the scatter sigma(w) is the rms of |model_r - model|. Each re-estimate has one number, T_r = max over w of
    /// |model_r - model|/sigma; the true system has one, too, of the same distribution as far as the re-estimates are like the
    /// estimate itself. Of R + 1 such numbers the truth's is one of the k largest with probability k/(R + 1): the radius is
    /// the k-th largest T_r times sigma, k = (1 - level)(R + 1) rounded down.
    ///
    /// Shapes: continuous, one input and one output; nothing stands for an estimate that failed, which counts as the worst.
    /// Assumes: `omega_rad_s` dense enough for the resonances, as [`line`] makes it.
    /// Errors: [`Error::Setting`] for fewer than 1/(1 - level) - 1 re-estimates; [`Error::PoleUncertain`] where so many
    /// re-estimates have another number of poles right of the line that no radius holds.
    /// Source: Efron and Tibshirani 1993, section 12.5 (studentised); Vovk et al. 2005, section 2.2 (ranks).
    pub fn of_replicates(
        model: &StateSpace,
        replicates: &[Option<StateSpace>],
        omega_rad_s: Vec<f64>,
        beta: f64,
        level: f64,
    ) -> Result<Band, Error> {
        let rank = ((1.0 - level) * (replicates.len() + 1) as f64 + RANK_ROUNDING).floor() as usize;
        if rank == 0 {
            let (setting, needed) = ("the number of re-estimates", "at least 1/(1 - level) - 1, 19 for 95 %");
            return Err(Error::Setting { setting, found: replicates.len() as f64, needed });
        }
        let G = on_line(model, &omega_rad_s, beta);
        let beyond = poles_beyond(model, beta).len();
        let like: Vec<&StateSpace> =
            replicates.iter().flatten().filter(|again| poles_beyond(again, beta).len() == beyond).collect();
        let other = replicates.len() - like.len();
        if other >= rank {
            return Err(Error::PoleUncertain { beta, beyond: other, replicates: replicates.len() });
        }
        let off: Vec<Vec<f64>> = like
            .iter()
            .map(|replicate| {
                let each = on_line(replicate, &omega_rad_s, beta);
                each.iter().zip(&G).map(|(a, b)| (a - b).norm()).collect()
            })
            .collect();
        let sigma: Vec<f64> = (0..omega_rad_s.len())
            .map(|k| (off.iter().map(|e| e[k] * e[k]).sum::<f64>() / off.len() as f64).sqrt())
            .collect();
        let over =
            |e: &Vec<f64>| e.iter().zip(&sigma).filter(|(_, s)| **s > 0.0).map(|(e, s)| e / s).fold(0.0, f64::max);
        let mut largest: Vec<f64> = off.iter().map(over).collect();
        largest.sort_by(|a, b| b.total_cmp(a));
        // Those that changed sides stand above all others.
        let factor = largest[rank - 1 - other];
        let radius = sigma.iter().map(|s| factor * s).collect();
        Ok(Band { omega_rad_s, radius, level })
    }
}

/// 0.05 times 20 is one, whatever its last bit says.
const RANK_ROUNDING: f64 = 1e-9;

fn on_line(system: &StateSpace, omega_rad_s: &[f64], beta: f64) -> Vec<C64> {
    let reduced = Hessenberg::new(system);
    let value = |G: CMat| G[(0, 0)];
    omega_rad_s.iter().map(|omega| value(reduced.at(C64::new(-beta, *omega)))).collect()
}

/// Points a decade of the line between the resonances.
const A_DECADE: usize = 60;
/// Points around each resonance, in units of its distance from the line.
const AROUND: [f64; 13] = [-8.0, -4.0, -2.0, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// The line begins at this part of beta: below it s = jw - beta hardly moves.
const LOWEST: f64 = 0.1;

/// Frequencies of s = jw - beta [rad/s] up to `highest_rad_s`: evenly over its decades, and densely where these models have
/// resonances.
pub fn line(models: &[&StateSpace], beta: f64, highest_rad_s: f64) -> Vec<f64> {
    let lowest = LOWEST * beta;
    let decades = (highest_rad_s / lowest).log10().max(1.0);
    let count = (decades * A_DECADE as f64).ceil() as usize;
    let mut omega: Vec<f64> = (0..=count).map(|k| lowest * 10f64.powf(decades * k as f64 / count as f64)).collect();
    for pole in models.iter().flat_map(|model| model.poles()).filter(|p| p.im > 0.0) {
        let width = (pole.re + beta).abs();
        let near = AROUND.iter().map(|d| pole.im + d * width);
        omega.extend(near.filter(|w| *w > lowest && *w < highest_rad_s));
    }
    omega.sort_by(f64::total_cmp);
    omega.dedup();
    omega
}

#[cfg(test)]
mod tests {
    use flexbeam_lti::{Mat, Time};

    use super::*;

    fn lag(pole: f64, gain: f64) -> StateSpace {
        let one = |x: f64| Mat::from_element(1, 1, x);
        StateSpace::new(one(pole), one(1.0), one(gain), one(0.0), Time::Continuous).unwrap()
    }

    /// 19 gains around 1: the band is the farthest of them, at each frequency times |1/(s + 5)|.
    #[test]
    fn of_nineteen_replicates_the_band_is_the_farthest() {
        let gains: Vec<f64> = (0..19).map(|k| 1.0 + 0.01 * f64::from((k * 7) % 19 - 9)).collect();
        let replicates: Vec<Option<StateSpace>> = gains.iter().map(|g| Some(lag(-5.0, *g))).collect();
        let band = Band::of_replicates(&lag(-5.0, 1.0), &replicates, vec![1.0, 10.0], 2.0, 0.95).unwrap();
        for (omega, radius) in band.omega_rad_s.iter().zip(&band.radius) {
            assert!((radius - 0.09 / omega.hypot(3.0)).abs() < 1e-12, "{omega} {radius}");
        }
        assert!((band.radius_at(10f64.sqrt()) - 0.5 * (band.radius[0] + band.radius[1])).abs() < 1e-12);
        assert_eq!((band.radius_at(0.1), band.radius_at(99.0)), (band.radius[0], band.radius[1]));
        let few = Band::of_replicates(&lag(-5.0, 1.0), &replicates[1..], vec![1.0], 2.0, 0.95);
        assert!(matches!(few, Err(Error::Setting { found: 18.0, .. })));
    }

    #[test]
    fn replicates_that_change_sides_leave_no_band() {
        let mut replicates: Vec<Option<StateSpace>> =
            (0..39).map(|k| Some(lag(-5.0, 1.0 + 0.01 * f64::from(k)))).collect();
        replicates[3] = Some(lag(-1.9, 1.0));
        let of =
            |replicates: &[Option<StateSpace>]| Band::of_replicates(&lag(-5.0, 1.0), replicates, vec![1.0], 2.0, 0.95);
        // Of 39 the second largest counts: the one that changed sides is the largest, the farthest gain the next.
        assert!((of(&replicates).unwrap().radius[0] - 0.38 / 10f64.sqrt()).abs() < 1e-12);
        replicates[4] = None;
        assert_eq!(of(&replicates).unwrap_err(), Error::PoleUncertain { beta: 2.0, beyond: 2, replicates: 39 });
    }
}
