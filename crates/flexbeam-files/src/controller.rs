//! Controllers: what the kernel runs, what it was asked for, and what was proven of it.

use crate::certificate::Certificate;
use crate::document::Document;
use crate::fault::Fault;
use crate::matrices::{Matrices, Rows};
use crate::misfit::Misfit;
use crate::model::{Uncertainty, positive};
use crate::provenance::Provenance;
use crate::settings::Settings;
use crate::stiffness::Stiffness;
use flexbeam_lti::{StateSpace, Time};
use serde::{Deserialize, Serialize};

/// `flexbeam.controller/1`: x+ = A x + B (v, y, u_applied), (u, y_model) = C x + D (v, y).
///
/// Shapes: A n*n, B n*3, C 2*n, D 2*2, n = `order`; n may be 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Sample period [s].
    pub period_s: f64,
    /// Number of states n.
    pub order: usize,
    /// State matrix.
    pub A: Rows,
    /// Input matrix; inputs are the reference v [rad], the tip angle y [rad], the voltage applied [V].
    pub B: Rows,
    /// Output matrix; outputs are the voltage u [V] and the reference model's tip angle [rad].
    pub C: Rows,
    /// Feedthrough from v and y.
    pub D: Rows,
    /// Law, thresholds, limits, filters: what may change while the loop runs.
    pub settings: Settings,
    /// What was asked for.
    pub design: Design,
    /// The nominal plant of the design: continuous, from the voltage [V] to the tip angle [rad].
    pub plant: Matrices,
    /// What was proven.
    pub certificate: Certificate,
    /// Where it came from.
    pub provenance: Option<Provenance>,
}

/// The table `design`: the question to which the controller is the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Method: `sampled` for a design in the w-plane.
    pub method: String,
    /// Output that is controlled: `psi`.
    pub output: String,
    /// beta [1/s]: every closed-loop pole was to have a real part below -beta.
    pub stability_degree: f64,
    /// Numerator of alpha(s) in the shifted plane [rad/V], highest power first.
    pub uncertainty_num: Vec<f64>,
    /// Denominator of alpha(s), highest power first.
    pub uncertainty_den: Vec<f64>,
    /// Numerator of the bound in the w-plane, w = (2/Ts)(z - 1)/(z + 1), highest power first: at least |alpha(jw)| on
    /// |w| <= pi/Ts, and the weight of the sampled `bound_norm` [rad/V].
    pub sampled_uncertainty_num: Vec<f64>,
    /// Denominator of that bound, highest power first.
    pub sampled_uncertainty_den: Vec<f64>,
    /// What was asked against constant disturbances.
    pub stiffness: Stiffness,
    /// Numerator of the reference model M(s), highest power first.
    pub reference_num: Vec<f64>,
    /// Denominator of the reference model M(s), highest power first.
    pub reference_den: Vec<f64>,
    /// Rise time of the reference model [s].
    pub rise_time_s: Option<f64>,
    /// Overshoot that was asked of the reference model [percent].
    pub overshoot_percent: Option<f64>,
    /// Voltage that the largest step may take [V].
    pub max_voltage_v: Option<f64>,
    /// The largest step [rad].
    pub max_step_rad: Option<f64>,
    /// Time from a measurement to the voltage that answers it, as the design took it [s].
    pub delay_s: f64,
    /// Share of the new measurement in the filter that the design took into account; 1 is no filter.
    pub low_pass: f64,
}

impl Controller {
    /// Inputs of the state equation: v, y, u_applied.
    pub const INPUT_NAMES: [&str; 3] = ["v_rad", "y_rad", "u_applied_v"];
    /// Outputs u and y_model.
    pub const OUTPUT_NAMES: [&str; 2] = ["u_v", "y_model_rad"];

    const INPUTS: usize = Self::INPUT_NAMES.len();
    /// Also the number of inputs, v and y, that reach the outputs directly.
    const OUTPUTS: usize = Self::OUTPUT_NAMES.len();

    /// A, B, C and D column by column, one after the other, as the kernel reads them.
    pub fn coefficients(&self) -> Vec<f64> {
        let matrices =
            [(&self.A, self.order), (&self.B, Self::INPUTS), (&self.C, self.order), (&self.D, Self::OUTPUTS)];
        matrices.iter().flat_map(|(M, columns)| M.to_mat(*columns).as_slice().to_vec()).collect()
    }

    /// The nominal plant.
    ///
    /// Errors: those of [`StateSpace::new`]; none for a controller that was read.
    pub fn plant_state_space(&self) -> Result<StateSpace, flexbeam_lti::Error> {
        self.plant.state_space(Time::Continuous)
    }

    fn check_shapes(&self) -> Result<(), Misfit> {
        let n = self.order;
        self.A.check(n, n).map_err(|misfit| misfit.under("A"))?;
        self.B.check(n, Self::INPUTS).map_err(|misfit| misfit.under("B"))?;
        self.C.check(Self::OUTPUTS, n).map_err(|misfit| misfit.under("C"))?;
        self.D.check(Self::OUTPUTS, Self::OUTPUTS).map_err(|misfit| misfit.under("D"))?;
        self.plant.check(1, 1).map_err(|misfit| misfit.under("plant"))
    }
}

impl Document for Controller {
    const SCHEMA: &'static str = "flexbeam.controller/1";
    const HEAD: &'static str =
        "flexbeam controller: x+ = A x + B (v, y, u_applied), (u, y_model) = C x + D (v, y). SI units.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    fn check(&self) -> Result<(), Misfit> {
        positive("period_s", self.period_s)?;
        self.check_shapes()?;
        self.settings.check().map_err(|misfit| misfit.under("settings"))?;
        self.design.check().map_err(|misfit| misfit.under("design"))?;
        let found = self.certificate.controller_order;
        if found != self.order {
            let fault = Fault::Range { key: String::new(), found: found as f64, needed: "the controller's order" };
            return Err(Misfit::new(fault).under("controller_order").under("certificate"));
        }
        self.certificate.check_figures().map_err(|misfit| misfit.under("certificate"))
    }
}

impl Design {
    /// The uncertainty as a model's file holds it.
    pub fn uncertainty(&self) -> Uncertainty {
        Uncertainty {
            num: self.uncertainty_num.clone(),
            den: self.uncertainty_den.clone(),
            beta: self.stability_degree,
            origin: None,
        }
    }

    fn check(&self) -> Result<(), Misfit> {
        let lists = [
            ("uncertainty_num", &self.uncertainty_num),
            ("uncertainty_den", &self.uncertainty_den),
            ("sampled_uncertainty_num", &self.sampled_uncertainty_num),
            ("sampled_uncertainty_den", &self.sampled_uncertainty_den),
            ("reference_num", &self.reference_num),
            ("reference_den", &self.reference_den),
        ];
        match lists.iter().find(|(_, coefficients)| coefficients.is_empty()) {
            Some((key, _)) => Err(Misfit::empty(key)),
            None => positive("low_pass", self.low_pass),
        }
    }
}
