//! The answers of `rig test` as tables.

use flexbeam_files::{FrictionResult, Law, Quantity, RigTestResult};
use flexbeam_report::{Cell, Table};

/// Breakaway voltages, and the settings that follow.
pub(super) fn settings(result: &RigTestResult) -> Table {
    let name = match result.law {
        Law::Switched => "switched law",
        Law::Inverse => "inverse law",
        Law::None => "inverse law (the controller uses none)",
    };
    let mut rows = vec![
        ("breakaway forward", result.breakaway_plus_v, "V", "measured".to_string()),
        ("breakaway backward", result.breakaway_minus_v, "V", "measured".into()),
    ];
    if let Some(repeated) = &result.repeated {
        let from = |q: &Quantity| format!("all ramps, ± {:.4} with 95 %", q.half_width_95);
        rows.push(("forward, free of the detection's delay", repeated.plus_v.value, "V", from(&repeated.plus_v)));
        rows.push(("backward, likewise", repeated.minus_v.value, "V", from(&repeated.minus_v)));
    }
    rows.extend([
        ("u_p forward", result.u_p_plus_v, "V", name.into()),
        ("u_p backward (magnitude)", result.u_p_minus_v, "V", name.into()),
        ("eps_u", result.eps_u_v, "V", name.into()),
        ("eps_e", result.eps_e_rad.to_degrees(), "degree", name.into()),
    ]);
    rows.extend(result.residual_voltage_v.map(|v| ("residual voltage v_res", v, "V", name.to_string())));
    rows.into_iter().fold(
        Table::new(&[("", ""), ("value", ""), ("unit", ""), ("from", "")]),
        |table, (what, x, unit, from)| {
            table.row([what.into(), Cell::Number(format!("{x:+.4}")), unit.into(), from.as_str().into()])
        },
    )
}

/// Friction, each number with its standard error and 95 % interval.
pub(super) fn friction(found: &FrictionResult) -> Table {
    let rows = [
        ("dead zone + Coulomb forward", Some(found.dry_plus_v), "V"),
        ("dead zone + Coulomb backward", Some(found.dry_minus_v), "V"),
        ("slope of voltage over speed", Some(found.slope_v_s), "V s/rad"),
        ("dead zone forward", found.dead_zone_plus_v, "V"),
        ("dead zone backward", found.dead_zone_minus_v, "V"),
        ("Coulomb forward", found.coulomb_plus_v, "V"),
        ("Coulomb backward", found.coulomb_minus_v, "V"),
        ("Coulomb torque", found.coulomb_nm, "N m"),
        ("viscous friction B_eq", Some(found.viscous_nm_s), "N m s/rad"),
        ("Stribeck rise", found.stribeck_extra_nm, "N m"),
        ("torque per volt", Some(found.torque_per_volt_nm), "N m/V"),
    ];
    let known = rows.into_iter().filter_map(|(what, quantity, unit)| Some((what, quantity?, unit)));
    known.fold(
        Table::new(&[("friction", ""), ("value", ""), ("standard error", ""), ("95 %", ""), ("unit", "")]),
        |table, (what, q, unit)| {
            let cell = |x: f64| Cell::Number(format!("{x:.5}"));
            // What was stated has no scatter but that of rounding.
            let stated = q.std < 1e-9 * q.value.abs();
            let std = if stated { Cell::Number("as stated".into()) } else { cell(q.std) };
            let wide = if stated { String::new() } else { format!("± {:.5}", q.half_width_95) };
            table.row([what.into(), cell(q.value), std, Cell::Number(wide), unit.into()])
        },
    )
}
