//! Data preparation: offsets and scales, undone in the model.
//!
//! Enters: recorded channels. Leaves: channels of about unit rms. Deliberately absent: filters and resampling, which change
//! the model and therefore belong to the person.

use flexbeam_lti::Mat;

/// Offset and scale of each channel.
#[derive(Clone, Debug)]
pub(crate) struct Scaling {
    pub mean: Vec<f64>,
    /// Powers of two, so that scaling and its undoing are exact.
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
            mean.push(offset * unit);
            // A channel without any movement keeps its unit; the rank of the input finds it.
            scale.push(if square > 0.0 { power_of_two(square.sqrt()) * unit } else { unit });
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
