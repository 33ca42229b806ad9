//! Levenberg-Marquardt down to where the data cannot tell any more.
//!
//! Enters: a point, the record, the measure. Leaves: a point that is never worse, and why it went no further.

use std::ops::ControlFlow;

use flexbeam_lti::schur::spectrum;
use flexbeam_lti::{Mat, Vector};

use super::balance::balanced;
use super::criterion::{Judged, Measure};
use super::local::{Basis, Point, Structure};
use super::reseat::reseated;
use super::sensitivity::{Record, jacobian, second_moment};
use super::{Progress, Reason, Settings};
use crate::Poles;
use crate::triangle::Triangle;

/// Damping: first value, largest and smallest factor of a good step.
const DAMPING: (f64, f64, f64) = (1e-3, 1.0 / 3.0, 2.0);
/// Beyond this damping the step is shorter than rounding.
const MOST_DAMPING: f64 = 1e14;
/// What is missed below this part of the outputs is rounding.
const ROUNDING: f64 = 1e-13;
/// A direction that moves the output less than this part of the strongest is damped as if it moved it so much: the starts of the
/// tip angle, whose idle poles run away otherwise, ask for it.
const LEAST_COLUMN: f64 = 1e-2;
/// So many linearisations that lower the cost by less than this part of it, all together, are a valley without an end.
const PATIENCE: usize = 10;
const COARSE: f64 = 1e-2;
const FINE: f64 = 1e-5;

/// Less than this part of the cost is no reason to move a mode.
const WORTH_IT: f64 = 1e-4;

/// Where the descent stands.
#[derive(Clone)]
pub(crate) struct Standing {
    pub point: Point,
    pub judged: Judged,
    radius: f64,
}

/// The problem that does not change on the way down.
pub(crate) struct Descent<'a> {
    pub record: &'a Record,
    pub measure: &'a Measure,
    pub structure: Structure,
    pub settings: &'a Settings,
}

/// The end of a descent.
pub(crate) struct Descended {
    pub standing: Standing,
    pub iterations: usize,
    pub reason: Reason,
    pub dimension: usize,
}

impl Descent<'_> {
    /// None where the simulation overflows; Break where whoever watches has had enough.
    pub fn standing(&self, point: Point, watch: Watch, progress: Progress) -> ControlFlow<(), Option<Standing>> {
        let predictor = point.predictor();
        let moment = second_moment(&predictor, self.record, &mut || watch(&progress))?;
        let judged = moment.map(|S| self.measure.judge(&S)).filter(|judged| judged.cost.is_finite());
        ControlFlow::Continue(judged.map(|judged| {
            let radius = self.radius(&point);
            Standing { point, judged, radius }
        }))
    }

    /// Down until it becomes slow, and down again from where an idle mode found a better place, as long as that helps; then to
    /// the end.
    pub fn down(&self, start: Standing, watch: Watch) -> Descended {
        let most = self.settings.most_iterations;
        let mut end = self.descend(start, most, COARSE, watch);
        while !matches!(end.reason, Reason::Asked | Reason::Rounding) && end.iterations < most {
            let Some(tried) = self.elsewhere(&end, most - end.iterations, watch) else { break };
            let helped = tried.standing.judged.missed < (1.0 - WORTH_IT) * end.standing.judged.missed;
            let kept = if helped { tried.standing } else { end.standing };
            let reason = if helped || tried.reason == Reason::Asked { tried.reason } else { end.reason };
            end = Descended { standing: kept, iterations: end.iterations + tried.iterations, reason, ..end };
            if !helped {
                break;
            }
        }
        if end.reason != Reason::Slow {
            return end;
        }
        let rest = self.descend(end.standing, most - end.iterations, FINE, watch);
        Descended { iterations: end.iterations + rest.iterations, ..rest }
    }

    fn elsewhere(&self, end: &Descended, most_iterations: usize, watch: Watch) -> Option<Descended> {
        let Standing { point, judged, .. } = &end.standing;
        let settled = end.reason == Reason::Settled;
        let point = reseated(point, self.record, self.structure, &judged.weight, settled)?;
        let progress = Progress { iterations: end.iterations, missed: judged.missed };
        match self.standing(point, watch, progress) {
            ControlFlow::Continue(Some(start)) => Some(self.descend(start, most_iterations, COARSE, watch)),
            _ => None,
        }
    }

    /// Steps until one of the reasons to stop.
    fn descend(&self, start: Standing, most_iterations: usize, slow: f64, watch: Watch) -> Descended {
        let mut at = start;
        let mut damping = Damping::new();
        let mut dimension = 0;
        // Missed before each linearisation.
        let mut history: Vec<f64> = Vec::new();
        let reason = loop {
            let iterations = history.len();
            let progress = Progress { iterations, missed: at.judged.missed };
            if at.judged.missed <= ROUNDING {
                break Reason::Rounding;
            }
            if iterations == most_iterations {
                break Reason::Iterations;
            }
            if iterations >= PATIENCE && history[iterations - PATIENCE] - at.judged.missed < slow * at.judged.missed {
                break Reason::Slow;
            }
            if watch(&progress).is_break() {
                break Reason::Asked;
            }
            at.point = balanced(&at.point, self.structure.integrators, self.record.Y.ncols());
            let basis = at.point.basis(self.structure);
            let predictor = at.point.predictor();
            let directions = at.point.predictor_directions(&basis, &predictor);
            dimension = directions.nrows();
            let weight = &at.judged.weight;
            let ControlFlow::Continue(R) =
                jacobian(&predictor, self.record, weight, &directions, &mut || watch(&progress))
            else {
                break Reason::Asked;
            };
            history.push(at.judged.missed);
            let linearised = Linearised { R, samples: self.record.Y.ncols(), rows: self.record.Y.len() };
            if linearised.offset() <= self.settings.tolerance {
                break Reason::Settled;
            }
            match self.step(&mut at, &basis, &linearised, &mut damping, watch) {
                Outcome::Lower => {}
                Outcome::NoDescent => break Reason::NoDescent,
                Outcome::Asked => break Reason::Asked,
            }
        };
        Descended { standing: at, iterations: history.len(), reason, dimension }
    }

    /// The first of ever shorter steps that lowers the cost and keeps what must be kept.
    fn step(
        &self,
        at: &mut Standing,
        basis: &Basis,
        linearised: &Linearised,
        damping: &mut Damping,
        watch: Watch,
    ) -> Outcome {
        let progress = Progress { iterations: 0, missed: at.judged.missed };
        while damping.lambda <= MOST_DAMPING {
            let (step, promised) = linearised.step(damping.lambda);
            let point = at.point.moved(basis, &step);
            if self.permitted(&point, at) {
                let ControlFlow::Continue(tried) = self.standing(point, watch, progress) else {
                    return Outcome::Asked;
                };
                if let Some(tried) = tried.filter(|tried| tried.judged.cost < at.judged.cost) {
                    damping.relax((at.judged.cost - tried.judged.cost) / promised);
                    *at = tried;
                    return Outcome::Lower;
                }
            }
            damping.tighten();
        }
        Outcome::NoDescent
    }

    /// Poles that must stay inside the circle stay inside, those outside go no farther; so do those of the one-step predictor.
    fn permitted(&self, point: &Point, from: &Standing) -> bool {
        let poles = self.settings.poles == Poles::Free || self.radius(point) < from.radius.max(1.0);
        poles && (point.K.is_none() || modulus(&point.predictor().A) <= modulus(&from.point.predictor().A).max(1.0))
    }

    /// Largest modulus of the poles that are not known.
    fn radius(&self, point: &Point) -> f64 {
        let (n, q) = (point.A.nrows(), self.structure.integrators);
        modulus(&point.A.view((q, q), (n - q, n - q)).into_owned())
    }
}

/// Largest modulus of an eigenvalue.
fn modulus(A: &Mat) -> f64 {
    spectrum(A).map_or(f64::INFINITY, |poles| poles.iter().map(|z| z.norm()).fold(0.0, f64::max))
}

/// Who watches a descent.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

enum Outcome {
    Lower,
    NoDescent,
    Asked,
}

/// Levenberg's factor and how it answers to good and bad steps.
///
/// Source: Nielsen 1999, algorithm 3.16 of Madsen, Nielsen and Tingleff 2004.
struct Damping {
    lambda: f64,
    growth: f64,
}

impl Damping {
    fn new() -> Damping {
        Damping { lambda: DAMPING.0, growth: DAMPING.2 }
    }

    fn relax(&mut self, gain: f64) {
        self.lambda *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(DAMPING.1, DAMPING.2);
        self.growth = DAMPING.2;
    }

    fn tighten(&mut self) {
        self.lambda *= self.growth;
        self.growth *= 2.0;
    }
}

/// Triangular factor of the weighted Jacobian, the weighted residuals as its last column.
struct Linearised {
    R: Mat,
    samples: usize,
    rows: usize,
}

impl Linearised {
    /// Relative offset: length of the residuals' part that the parameters can still take away, over what they must leave, each by
    /// its degrees of freedom. 1e-3: the step left is a thousandth of the confidence region.
    ///
    /// Source: Bates and Watts 1981.
    fn offset(&self) -> f64 {
        let d = self.R.ncols() - 1;
        let removable = self.R.column(d).rows(0, d).norm_squared() / d as f64;
        let left = self.R[(d, d)].powi(2) / (self.rows.saturating_sub(d)).max(1) as f64;
        (removable / left).sqrt()
    }

    /// Damped step, and how much it lowers the squares by the linear model.
    fn step(&self, lambda: f64) -> (Vector, f64) {
        let d = self.R.ncols() - 1;
        let mut damped = Triangle { R: self.R.clone() };
        let mut rows = Mat::zeros(d, d + 1);
        let lengths: Vec<f64> = (0..d).map(|k| self.R.column(k).norm()).collect();
        let floor = LEAST_COLUMN * lengths.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        lengths.iter().enumerate().for_each(|(k, length)| rows[(k, k)] = lambda.sqrt() * length.max(floor));
        damped.absorb(&mut rows);
        let square = |R: &Mat| R.view((0, 0), (d, d)).into_owned();
        let right = |R: &Mat| Vector::from_column_slice(&R.column(d).as_slice()[..d]);
        let step = square(&damped.R).solve_upper_triangular(&right(&damped.R)).unwrap_or_else(|| Vector::zeros(d));
        let left = right(&self.R) - square(&self.R) * &step;
        let promised = (right(&self.R).norm_squared() - left.norm_squared()) / self.samples as f64;
        (step, promised.max(f64::MIN_POSITIVE))
    }
}
