//! The tick in f32: the very text that is written as Rust, compiled here over slices of any order.
//!
//! Enters: a controller, settings and inputs that f32 holds exactly, as f64. Leaves: answers, likewise.

#[path = "../templates/rust/src/law.rs"]
mod law;
#[path = "../templates/rust/src/settings.rs"]
mod settings;
#[path = "../templates/rust/src/tick.rs"]
mod tick;

use flexbeam_kernel as kernel;

type Real = f32;
type Memory = Vec<f32>;

/// The controller in f32.
#[derive(Debug)]
pub(crate) struct Single {
    order: usize,
    ab: Vec<f32>,
    cd: Vec<f32>,
    state: tick::State,
}

impl Single {
    /// At rest.
    pub(crate) fn new(controller: &kernel::Controller<'_>) -> Single {
        let order = controller.order();
        let numbers: Vec<f32> = controller.coefficients().iter().map(|&x| x as f32).collect();
        let (ab, cd) = numbers.split_at(order * (order + kernel::Controller::INPUTS));
        let memory = vec![0.0; order + kernel::Controller::INPUTS];
        Single { order, ab: ab.to_vec(), cd: cd.to_vec(), state: tick::State::at_rest(memory.clone(), memory) }
    }

    /// Back to rest.
    pub(crate) fn reset(&mut self) {
        self.state.reset();
    }

    /// One period.
    pub(crate) fn tick(&mut self, settings: &kernel::Settings, measured: kernel::Measured) -> kernel::Commanded {
        let gains = tick::Gains { order: self.order, ab: &self.ab, cd: &self.cd };
        let measured = tick::Measured {
            reference_rad: measured.reference_rad as f32,
            theta_rad: measured.theta_rad as f32,
            alpha_rad: measured.alpha_rad as f32,
        };
        let commanded = tick::tick(gains, &in_single(settings), &mut self.state, measured);
        kernel::Commanded {
            voltage_v: commanded.voltage_v.into(),
            u_v: commanded.u_v.into(),
            reference_rad: commanded.reference_rad.into(),
            y_rad: commanded.y_rad.into(),
            y_model_rad: commanded.y_model_rad.into(),
            error_rad: commanded.error_rad.into(),
            fault: match self.state.fault() {
                tick::Fault::None => kernel::Fault::None,
                tick::Fault::Deflection => kernel::Fault::Deflection,
                tick::Fault::Angle => kernel::Fault::Angle,
                tick::Fault::Speed => kernel::Fault::Speed,
                tick::Fault::NonFinite => kernel::Fault::NonFinite,
            },
        }
    }
}

fn in_single(s: &kernel::Settings) -> settings::Settings {
    let channel = |c: kernel::Channel| settings::Channel {
        scale: c.scale as f32,
        offset_rad: c.offset_rad as f32,
        low_pass: c.low_pass as f32,
    };
    settings::Settings {
        theta: channel(s.theta),
        alpha: channel(s.alpha),
        smooth_ticks: s.smooth_ticks as f32,
        smooth_step_rad: s.smooth_step_rad as f32,
        law: match s.law {
            kernel::Law::None => settings::Law::None,
            kernel::Law::Switched => settings::Law::Switched,
            kernel::Law::Inverse => settings::Law::Inverse,
        },
        u_p_plus_v: s.u_p_plus_v as f32,
        u_p_minus_v: s.u_p_minus_v as f32,
        eps_u_v: s.eps_u_v as f32,
        eps_e_rad: s.eps_e_rad as f32,
        hysteresis_u: s.hysteresis_u as f32,
        hysteresis_e: s.hysteresis_e as f32,
        breakaway_plus_v: s.breakaway_plus_v as f32,
        breakaway_minus_v: s.breakaway_minus_v as f32,
        voltage_limit_v: s.voltage_limit_v as f32,
        deflection_limit_rad: s.deflection_limit_rad as f32,
        theta_limit_rad: s.theta_limit_rad as f32,
        theta_step_limit_rad: s.theta_step_limit_rad as f32,
    }
}
