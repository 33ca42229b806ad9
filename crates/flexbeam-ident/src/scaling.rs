//! Data preparation: offsets and scales, undone in the model.
//!
//! Enters: recorded channels. Leaves: channels of unit rms. Deliberately absent: filters and resampling, which change
//! the model and therefore belong to the person.

use flexbeam_lti::Mat;

/// Movement below this part of the largest value is rounding of the mean: a sum of 10^6 samples is off by 1e-13 of them.
const STILL: f64 = 1e-12;

/// Offset and scale of each channel.
#[derive(Clone, Debug)]
pub(crate) struct Scaling {
    pub mean: Vec<f64>,
    /// Root mean square about the mean, so that a model does not depend on the units of its channels.
    pub scale: Vec<f64>,
}

impl Scaling {
    /// Scales of `part` (samples x channels) about its means, or about zero when these are kept.
    pub fn of(part: &Mat, remove_mean: bool) -> Scaling {
        let (mut mean, mut scale) = (Vec::new(), Vec::new());
        for channel in part.column_iter() {
            let largest = channel.amax();
            let unit = if largest > 0.0 { power_of_two(largest) } else { 1.0 };
            let offset =
                if remove_mean { channel.iter().map(|x| x / unit).sum::<f64>() / channel.len() as f64 } else { 0.0 };
            let square = channel.iter().map(|x| (x / unit - offset).powi(2)).sum::<f64>() / channel.len() as f64;
            let moves = square.sqrt() > STILL;
            // A channel without any movement keeps its unit and loses its value to the last bit; its rank tells the rest.
            mean.push(if moves || !remove_mean { offset * unit } else { channel[0] });
            scale.push(if moves { square.sqrt() * unit } else { unit });
        }
        Scaling { mean, scale }
    }

    /// (data - mean) / scale, samples x channels.
    pub fn apply(&self, data: &Mat) -> Mat {
        Mat::from_fn(data.nrows(), data.ncols(), |k, c| (data[(k, c)] - self.mean[c]) / self.scale[c])
    }
}

/// The power of two next below x > 0.
fn power_of_two(x: f64) -> f64 {
    x.log2().floor().clamp(-1000.0, 1000.0).exp2()
}
