//! The numbers that stand in the text, in its precision.

use crate::{Error, Precision, Subject, settings};
use flexbeam_files::{Controller, Rows};
use flexbeam_kernel as kernel;

/// Coefficients and settings, every one a number of the precision.
#[derive(Clone, Debug)]
pub(crate) struct Numbers {
    pub(crate) order: usize,
    /// A, B, C, D column by column.
    pub(crate) coefficients: Vec<f64>,
    pub(crate) settings: kernel::Settings,
}

impl Numbers {
    /// Errors: [`Error::Overflow`], [`Error::Subnormal`].
    pub(crate) fn new(subject: &Subject<'_>, precision: Precision) -> Result<Numbers, Error> {
        let Subject { controller, settings, .. } = subject;
        let order = controller.order;
        match precision {
            Precision::F64 => Ok(Numbers { order, coefficients: controller.coefficients(), settings: **settings }),
            Precision::F32 => {
                let (controller, settings) = rounded(controller, settings)?;
                Ok(Numbers { order, coefficients: controller.coefficients(), settings })
            }
        }
    }

    /// Errors: [`Error::Kernel`]; none for a controller that was read.
    pub(crate) fn controller(&self) -> Result<kernel::Controller<'_>, Error> {
        Ok(kernel::Controller::new(self.order, &self.coefficients)?)
    }

    /// [A B], column by column.
    pub(crate) fn ab(&self) -> &[f64] {
        &self.coefficients[..self.order * (self.order + kernel::Controller::INPUTS)]
    }

    /// [C D], column by column.
    pub(crate) fn cd(&self) -> &[f64] {
        &self.coefficients[self.order * (self.order + kernel::Controller::INPUTS)..]
    }
}

/// The controller and its settings with every number of the loop rounded to f32; the design's filter likewise, so that a
/// certificate can be recomputed for what will run.
///
/// Errors: [`Error::Overflow`], [`Error::Subnormal`].
pub fn rounded(controller: &Controller, settings: &kernel::Settings) -> Result<(Controller, kernel::Settings), Error> {
    let mut file = controller.clone();
    for (name, rows) in [("A", &mut file.A), ("B", &mut file.B), ("C", &mut file.C), ("D", &mut file.D)] {
        round_rows(name, rows)?;
    }
    file.design.low_pass = single("design.low_pass", controller.design.low_pass)?;
    Ok((file, settings::mapped(settings, single)?))
}

fn round_rows(name: &str, rows: &mut Rows) -> Result<(), Error> {
    for (i, row) in rows.0.iter_mut().enumerate() {
        for (j, x) in row.iter_mut().enumerate() {
            *x = single(&format!("{name}[{}][{}]", i + 1, j + 1), *x)?;
        }
    }
    Ok(())
}

/// x in f32. No limit stays none.
fn single(key: &str, x: f64) -> Result<f64, Error> {
    let rounded = x as f32;
    if rounded.is_infinite() && x.is_finite() {
        Err(Error::Overflow { key: key.to_owned(), found: x })
    } else if x != 0.0 && !rounded.is_normal() && !x.is_infinite() {
        Err(Error::Subnormal { key: key.to_owned(), found: x })
    } else {
        Ok(f64::from(rounded))
    }
}
