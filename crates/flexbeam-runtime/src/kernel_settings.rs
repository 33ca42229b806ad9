//! The kernel's settings and the table `settings` of a file, both ways.

use flexbeam_files as files;
use flexbeam_kernel as kernel;

/// The settings, with the table's keys in the place of their own. A key that the table leaves out stays.
pub fn with_table(settings: &kernel::Settings, table: &files::Settings) -> kernel::Settings {
    let or = |value: Option<f64>, present: f64| value.unwrap_or(present);
    let channel = |table: &Option<files::Channel>, present: kernel::Channel| {
        table.as_ref().map_or(present, |c| kernel::Channel {
            scale: or(c.scale, present.scale),
            offset_rad: or(c.offset_rad, present.offset_rad),
            low_pass: or(c.low_pass, present.low_pass),
        })
    };
    kernel::Settings {
        theta: channel(&table.theta, settings.theta),
        alpha: channel(&table.alpha, settings.alpha),
        smooth_ticks: or(table.smooth_ticks, settings.smooth_ticks),
        smooth_step_rad: or(table.smooth_step_rad, settings.smooth_step_rad),
        law: table.law.map_or(settings.law, law_of_file),
        u_p_plus_v: or(table.u_p_plus_v, settings.u_p_plus_v),
        u_p_minus_v: or(table.u_p_minus_v, settings.u_p_minus_v),
        eps_u_v: or(table.eps_u_v, settings.eps_u_v),
        eps_e_rad: or(table.eps_e_rad, settings.eps_e_rad),
        hysteresis_u: or(table.hysteresis_u, settings.hysteresis_u),
        hysteresis_e: or(table.hysteresis_e, settings.hysteresis_e),
        breakaway_plus_v: or(table.breakaway_plus_v, settings.breakaway_plus_v),
        breakaway_minus_v: or(table.breakaway_minus_v, settings.breakaway_minus_v),
        voltage_limit_v: or(table.voltage_limit_v, settings.voltage_limit_v),
        deflection_limit_rad: or(table.deflection_limit_rad, settings.deflection_limit_rad),
        theta_limit_rad: or(table.theta_limit_rad, settings.theta_limit_rad),
        theta_step_limit_rad: or(table.theta_step_limit_rad, settings.theta_step_limit_rad),
    }
}

/// Every key of the settings as a table; a limit that is infinite is left out, which is what the table means by that.
pub fn table_of(settings: &kernel::Settings) -> files::Settings {
    let channel = |c: &kernel::Channel| {
        Some(files::Channel { scale: Some(c.scale), offset_rad: Some(c.offset_rad), low_pass: Some(c.low_pass) })
    };
    let finite = |x: f64| Some(x).filter(|x| x.is_finite());
    files::Settings {
        law: Some(law_of_kernel(settings.law)),
        u_p_plus_v: Some(settings.u_p_plus_v),
        u_p_minus_v: Some(settings.u_p_minus_v),
        eps_u_v: Some(settings.eps_u_v),
        eps_e_rad: Some(settings.eps_e_rad),
        hysteresis_u: Some(settings.hysteresis_u),
        hysteresis_e: Some(settings.hysteresis_e),
        breakaway_plus_v: Some(settings.breakaway_plus_v),
        breakaway_minus_v: Some(settings.breakaway_minus_v),
        voltage_limit_v: Some(settings.voltage_limit_v),
        deflection_limit_rad: finite(settings.deflection_limit_rad),
        theta_limit_rad: finite(settings.theta_limit_rad),
        theta_step_limit_rad: finite(settings.theta_step_limit_rad),
        smooth_ticks: Some(settings.smooth_ticks),
        smooth_step_rad: finite(settings.smooth_step_rad),
        theta: channel(&settings.theta),
        alpha: channel(&settings.alpha),
    }
}

/// The kernel's law.
pub fn law_of_file(law: files::Law) -> kernel::Law {
    match law {
        files::Law::None => kernel::Law::None,
        files::Law::Switched => kernel::Law::Switched,
        files::Law::Inverse => kernel::Law::Inverse,
    }
}

/// The law as a file names it.
pub fn law_of_kernel(law: kernel::Law) -> files::Law {
    match law {
        kernel::Law::None => files::Law::None,
        kernel::Law::Switched => files::Law::Switched,
        kernel::Law::Inverse => files::Law::Inverse,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_same_and_an_empty_table_changes_nothing() {
        let channel = |k: f64| kernel::Channel { scale: 1.0 + k, offset_rad: k, low_pass: 0.5 };
        let settings = kernel::Settings {
            theta: channel(0.1),
            alpha: channel(0.2),
            law: kernel::Law::Switched,
            smooth_ticks: 200.0,
            u_p_plus_v: 0.26,
            u_p_minus_v: 0.09,
            eps_u_v: 0.011,
            eps_e_rad: 0.003,
            hysteresis_u: 0.3,
            hysteresis_e: 0.4,
            breakaway_plus_v: 0.28,
            breakaway_minus_v: 0.1,
            voltage_limit_v: 9.0,
            deflection_limit_rad: 0.4,
            theta_limit_rad: 2.0,
            ..kernel::Settings::default()
        };
        assert_eq!(with_table(&kernel::Settings::default(), &table_of(&settings)), settings);
        assert_eq!(with_table(&settings, &files::Settings::default()), settings);
    }
}
