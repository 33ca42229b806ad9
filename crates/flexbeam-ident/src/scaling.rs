//! Data preparation: offsets and scales, undone in the model.
//!
//! Enters: recorded channels. Leaves: channels of unit rms. Deliberately absent: filters and resampling, which change
//! the model and therefore belong to the person.

use flexbeam_lti::{Mat, StateSpace};

use crate::Error;
use crate::correlation::{Channels, Gram, Record};
use crate::double::Double;

/// Offset and scale of each channel.
#[derive(Clone, Debug)]
pub(crate) struct Scaling {
    pub mean: Vec<f64>,
    /// Root mean square about the mean, so that a model does not depend on the units of its channels.
    pub scale: Vec<f64>,
}

impl Scaling {
    /// Scales of a record's channels about its means, or about zero for channels that keep them; and the record's Gram matrix about the same.
    pub fn of(gram: Gram, removes_mean: impl Fn(usize) -> bool) -> (Scaling, Gram) {
        let means = gram.means();
        let mean: Vec<f64> = means.iter().enumerate().map(|(c, &x)| if removes_mean(c) { x } else { 0.0 }).collect();
        let gram = gram.about(&mean);
        let rms = gram.rms();
        let scale: Vec<f64> = rms
            .iter()
            .zip(gram.exponents())
            .map(|(rms, e)| {
                // A channel that does not move keeps its unit; its rank tells the rest.
                Double::new(if *rms > 0.0 { *rms } else { 1.0 }).shifted(*e).hi
            })
            .collect();
        (Scaling { mean, scale }, gram)
    }

    /// Scales of these channels x samples about zero.
    ///
    /// Assumes: finite samples.
    pub fn of_rows(data: &Mat) -> Scaling {
        let mut record = Record::new(data.nrows(), 1);
        record.absorb(&Channels::of_rows(data), 1).expect("finite samples");
        Scaling::of(record.finish(), |_| false).0
    }

    /// Moves the means of the channels from `first` on by these scaled offsets.
    pub fn shift(&mut self, first: usize, offset: &[f64]) {
        let channels = self.mean[first..].iter_mut().zip(&self.scale[first..]);
        channels.zip(offset).for_each(|((mean, scale), d)| *mean += scale * d);
    }

    /// (data - mean) / scale, channels x samples.
    pub fn apply_rows(&self, data: &Mat) -> Mat {
        Mat::from_fn(data.nrows(), data.ncols(), |c, k| (data[(c, k)] - self.mean[c]) / self.scale[c])
    }
}

/// The model between unscaled channels, from the one between scaled channels: B / u, y C, y D / u.
///
/// Errors: shapes that do not fit, which is a bug of the caller.
pub(crate) fn rescaled(model: &StateSpace, u: &[f64], y: &[f64]) -> Result<StateSpace, Error> {
    let StateSpace { A, mut B, mut C, mut D, time } = model.clone();
    for (c, u) in u.iter().enumerate() {
        B.column_mut(c).unscale_mut(*u);
        D.column_mut(c).unscale_mut(*u);
    }
    for (p, y) in y.iter().enumerate() {
        C.row_mut(p).scale_mut(*y);
        D.row_mut(p).scale_mut(*y);
    }
    Ok(StateSpace::new(A, B, C, D, time)?)
}
