//! Data preparation: offsets and scales, undone in the model.
//!
//! Enters: recorded channels. Leaves: channels of unit rms. Deliberately absent: filters and resampling, which change
//! the model and therefore belong to the person.

use crate::correlation::Gram;
use crate::double::Double;

/// Offset and scale of each channel.
#[derive(Clone, Debug)]
pub(crate) struct Scaling {
    pub mean: Vec<f64>,
    /// Root mean square about the mean, so that a model does not depend on the units of its channels.
    pub scale: Vec<f64>,
}

impl Scaling {
    /// Scales of a record's channels about its means, or about zero when these are kept; and the record's Gram matrix about the same.
    pub fn of(gram: Gram, remove_mean: bool) -> (Scaling, Gram) {
        let mean = if remove_mean { gram.means() } else { vec![0.0; gram.channels()] };
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

    /// The part for these channels.
    pub fn part(&self, channels: std::ops::Range<usize>) -> Scaling {
        Scaling { mean: self.mean[channels.clone()].to_vec(), scale: self.scale[channels].to_vec() }
    }

    /// The same for channels x samples.
    pub fn apply_rows(&self, data: &Mat) -> Mat {
        Mat::from_fn(data.nrows(), data.ncols(), |c, k| (data[(c, k)] - self.mean[c]) / self.scale[c])
    }
}
