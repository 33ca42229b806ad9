//! Maximal-length binary sequences: a shift register with feedback, period 2^n - 1.
//!
//! The spectrum is flat but for the hold of one clock, (sin x / x)^2 with x = pi f clock.

use super::plan::{Excitation, Plan, setting};
use crate::Error;

/// Taps of registers of 3 to 24 stages whose feedback polynomial is primitive.
///
/// Source: Alfke 1996, Xilinx application note 52, table 3. A test runs each register through its period.
const TAPS: [&[u32]; 22] = [
    &[3, 2],
    &[4, 3],
    &[5, 3],
    &[6, 5],
    &[7, 6],
    &[8, 6, 5, 4],
    &[9, 5],
    &[10, 7],
    &[11, 9],
    &[12, 6, 4, 1],
    &[13, 4, 3, 1],
    &[14, 5, 3, 1],
    &[15, 14],
    &[16, 15, 13, 4],
    &[17, 14],
    &[18, 11],
    &[19, 6, 2, 1],
    &[20, 17],
    &[21, 19],
    &[22, 21],
    &[23, 18],
    &[24, 23, 22, 17],
];
/// Stages of the shortest register.
const FEWEST_STAGES: u32 = 3;

/// The power has fallen to a half at this part of the clock's frequency.
const HALF_POWER: f64 = 0.443;

/// One period of +1 and -1 of a register of `stages` stages, one value a clock; the seed turns the sequence round.
///
/// Returns: 2^stages - 1 values whose sum is 1 or -1; nothing for registers of fewer than 3 or more than 24 stages.
pub fn binary_sequence(stages: u32, seed: u64) -> Option<Vec<f64>> {
    let taps = TAPS.get(stages.checked_sub(FEWEST_STAGES)? as usize)?;
    let period = (1u64 << stages) - 1;
    let mut register = seed % period + 1;
    Some(
        (0..period)
            .map(|_| {
                let out = register >> (stages - 1) & 1;
                let fed_back = taps.iter().fold(0, |bit, tap| bit ^ (register >> (tap - 1) & 1));
                register = (register << 1 | fed_back) & period;
                2.0 * out as f64 - 1.0
            })
            .collect(),
    )
}

/// The clock from the band's upper end, the register from the length.
pub(super) fn excitation(plan: &Plan) -> Result<Excitation, Error> {
    let clock_samples = match plan.band_hz {
        Some([_, high_hz]) => (HALF_POWER / (high_hz * plan.period_s)).floor().max(1.0) as usize,
        None => 1,
    };
    let asked = plan.samples as f64 / (plan.periods * clock_samples) as f64;
    let length = |stages: u32| ((1u64 << stages) - 1) as f64;
    let registers = FEWEST_STAGES..FEWEST_STAGES + TAPS.len() as u32;
    let off = |stages: &u32| (length(*stages) / asked).ln().abs();
    let stages = registers.min_by(|a, b| off(a).total_cmp(&off(b))).expect("there are registers");
    let period_s = length(stages) * clock_samples as f64 * plan.period_s;
    let lowest_hz = plan.band_hz.map_or(0.0, |band| band[0]);
    if lowest_hz > 0.0 && period_s * lowest_hz < 1.0 {
        let needed = "at most one period of the excitation: a longer record or fewer periods";
        return setting("the time of one swing at the band's lower end [s]", 1.0 / lowest_hz, needed);
    }
    let clocks = binary_sequence(stages, plan.seed).expect("the register is one of the table");
    let one: Vec<f64> = clocks.iter().flat_map(|v| std::iter::repeat_n(*v, clock_samples)).collect();
    let period_samples = one.len();
    Ok(Excitation {
        voltage_v: plan.repeated(plan.sized(one)),
        period_samples: Some(period_samples),
        band_hz: Some([1.0 / period_s, HALF_POWER / (clock_samples as f64 * plan.period_s)]),
        clock_samples: Some(clock_samples),
    })
}
