//! What stands at the head of the files: what it is, where it came from, what was proven of it.

use crate::bound::{NoBound, SingleBound};
use crate::vectors::{SingleError, SingleFigures};
use crate::{Precision, Subject};
use flexbeam_files::Extended;

/// Columns of a line of the heading.
const WIDTH: usize = 118;

/// One sentence.
pub(crate) fn title(subject: &Subject<'_>, precision: Precision) -> String {
    let (order, period_s) = (subject.controller.order, subject.controller.period_s);
    let precision = match precision {
        Precision::F64 => "64",
        Precision::F32 => "32",
    };
    format!("Controller of a flexible beam: order {order}, sample period {period_s} s, {precision}-bit arithmetic.")
}

/// Origin, certificate and precision, each line behind `prefix`.
pub(crate) fn banner(subject: &Subject<'_>, single: Option<&SingleFigures>, prefix: &str) -> String {
    let mut lines = vec![
        format!("Written by flexbeam {} from the controller file with SHA-256", env!("CARGO_PKG_VERSION")),
        subject.sha256.to_owned(),
        String::new(),
    ];
    lines.extend(certificate(subject, single.is_some()));
    if let Some(single) = single {
        lines.push(String::new());
        lines.extend(precision(&single.error));
        lines.push(String::new());
        lines.extend(bound(&single.bound));
    }
    if let Some(reason) = subject.unverified {
        lines.push(String::new());
        lines.extend(wrapped(&format!("NOT VERIFIED: {}", harmless(reason))));
    }
    let line = |line: &String| format!("{prefix}{}{line}", if line.is_empty() { "" } else { " " });
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The sampled loop's figures.
fn certificate(subject: &Subject<'_>, rounded: bool) -> Vec<String> {
    let figures = subject.figures;
    let of = if rounded { ", with the numbers as they stand here, rounded to f32" } else { "" };
    let figure = |name: &str, text: String, unit: &str| format!("  {name:<18}{text} {unit}").trim_end().to_owned();
    let extended = |x: Extended| if x.0.is_infinite() { "infinite".to_owned() } else { format!("{:.6}", x.0) };
    let mut lines = wrapped(&format!(
        "Certificate of the sampled loop with its delay of {} s and filters of share {}{of}:",
        subject.controller.design.delay_s, subject.controller.design.low_pass
    ));
    lines.extend([
        figure("stability_degree", format!("{:.6}", figures.stability_degree), "1/s"),
        figure("bound_norm", format!("{:.6}", figures.bound_norm), "(at most 1: survives the whole uncertainty)"),
        figure("robust_radius", extended(figures.robust_radius), "(of the plant, whatever the controller)"),
        figure("stiffness", extended(figures.stiffness), "V/rad"),
        figure("gain_margin", extended(figures.gain_margin), ""),
        figure("phase_margin", extended(figures.phase_margin_rad), "rad"),
        figure("delay_margin", extended(figures.delay_margin_s), "s"),
        figure("disk_margin", extended(figures.disk_margin), ""),
    ]);
    lines
}

fn precision(error: &SingleError) -> Vec<String> {
    let mut lines = wrapped(&format!(
        "Proven of f32: the figures above, of the loop with the rounded numbers; how the arithmetic itself rounds is not in them. \
         Measured: the largest differences from the controller in f64 over {} ticks of a closed loop, the inputs being the same; they hold to the last bit for these ticks \
         and are no bound for others:",
        error.ticks
    ));
    let [voltage, switched, u, angle] =
        [error.voltage_v, error.switched_voltage_v, error.u_v, error.angle_rad].map(not_below);
    lines.extend([
        format!("  voltage           {voltage} V, {switched} V under the switched law"),
        format!("  u                 {u} V"),
        format!("  angles            {angle} rad"),
    ]);
    lines
}

/// What holds for all references, or why nothing does.
fn bound(bound: &Result<SingleBound, NoBound>) -> Vec<String> {
    let bound = match bound {
        Ok(bound) => bound,
        Err(why) => return wrapped(&format!("No bound of the difference between the loops in f32 and f64: {why}.")),
    };
    let mut lines = wrapped(&format!(
        "Bound of the difference between the loop in f32 and the loop in f64, with the nominal plant, for all references within {} rad (each smooth step at rest before the \
         next) and for all times, while |alpha| is within {} rad, the voltage limit is not reached, and the law cancels the actuator's dead zone, or there is neither:",
        bound.reference_rad, bound.deflection_rad
    ));
    let [voltage, u, tip] = [bound.voltage_v, bound.u_v, bound.tip_rad].map(not_below);
    lines.extend([
        format!("  voltage           {voltage} V"),
        format!("  u                 {u} V"),
        format!("  tip angle         {tip} rad"),
    ]);
    lines
}

/// Three digits, rounded up.
fn not_below(x: f64) -> String {
    let nearest = format!("{x:.2e}");
    let is_below = nearest.parse::<f64>().is_ok_and(|rounded| rounded < x);
    if is_below { format!("{:.2e}", x * 1.005) } else { nearest }
}

/// A person's words, which must not end a comment, begin one, or hide behind a line's end.
fn harmless(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.replace("*/", "* /").replace("/*", "/ *").replace("??/", "?? /").trim_end_matches('\\').to_owned()
}

pub(crate) fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && line + 1 + word.chars().count() > WIDTH {
            lines.push(word.to_owned());
        } else if let Some(last) = lines.last_mut() {
            let space = if line > 0 { " " } else { "" };
            last.push_str(space);
            last.push_str(word);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_cannot_end_the_comment() {
        for evil in ["*/ int x; /*", "a *//* b", "a\n#error", "x ??/", "end \\", "**//**/"] {
            let text = harmless(evil);
            assert!(!text.contains("*/") && !text.contains("/*") && !text.contains('\n'), "{text}");
            assert!(!text.contains("??/") && !text.ends_with('\\'), "{text}");
        }
    }

    #[test]
    fn an_error_is_never_stated_below_what_it_is() {
        for k in 0..2000 {
            let x = 1e-7 * 1.0123_f64.powi(k);
            let stated: f64 = not_below(x).parse().unwrap();
            assert!(stated >= x && stated <= x * 1.0101, "{x} as {stated}");
        }
        assert_eq!(not_below(0.0), "0.00e0");
    }

    #[test]
    fn words_are_wrapped_and_none_is_lost() {
        let text = "word ".repeat(100);
        let lines = wrapped(&text);
        assert!(lines.len() > 3 && lines.iter().all(|line| line.len() <= WIDTH));
        assert_eq!(lines.join(" "), text.trim());
    }
}
