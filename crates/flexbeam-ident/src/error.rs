/// Why a recording cannot be turned into a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting outside its range.
    #[error("{setting} is {found}, needed {needed}")]
    Setting {
        /// Which setting.
        setting: &'static str,
        /// What was asked for.
        found: f64,
        /// The range, in words.
        needed: &'static str,
    },
    /// No input or no output channel.
    #[error("found {inputs} input and {outputs} output channels, needed at least one of each")]
    NoChannel {
        /// Inputs found.
        inputs: usize,
        /// Outputs found.
        outputs: usize,
    },
    /// Inputs and outputs of different length.
    #[error("the inputs have {inputs} samples and the outputs {outputs}; they must be recorded together")]
    Length {
        /// Samples of the inputs.
        inputs: usize,
        /// Samples of the outputs.
        outputs: usize,
    },
    /// Inputs and outputs on different time axes.
    #[error("the inputs have a period of {input_s} s and the outputs of {output_s} s; resample one of the two")]
    Period {
        /// Period of the inputs [s].
        input_s: f64,
        /// Period of the outputs [s].
        output_s: f64,
    },
    /// A sample that is infinite or not a number.
    #[error("channel {channel} is {value} at sample {sample}; hint: cut the recording there or repair the sample")]
    NotFinite {
        /// Name of the channel.
        channel: String,
        /// Sample, from 0.
        sample: usize,
        /// The value found.
        value: f64,
    },
    /// Fewer samples than the block Hankel matrices need.
    #[error(
        "found {found} samples for {what}, needed {needed} with {block_rows} block rows; \
         hint: record longer or take fewer block rows"
    )]
    TooFewSamples {
        /// Which part of the recording.
        what: &'static str,
        /// Samples found.
        found: usize,
        /// Samples needed.
        needed: usize,
        /// Block rows i.
        block_rows: usize,
    },
    /// The input does not move enough: its block Hankel matrix lacks rank.
    #[error(
        "the input is not exciting: its block Hankel matrix has rank {rank}, needed {needed} with {block_rows} block \
         rows; hint: excite every input independently and with many frequencies (white noise is best), or take fewer \
         block rows"
    )]
    NotExciting {
        /// Rank found.
        rank: usize,
        /// Rank needed, 2 i m.
        needed: usize,
        /// Block rows i.
        block_rows: usize,
    },
    /// An order that the block rows or the data cannot carry.
    #[error("order {order} was asked for; {reason}: at most {largest}")]
    Order {
        /// Order asked for.
        order: usize,
        /// Largest order possible.
        largest: usize,
        /// What bounds it.
        reason: &'static str,
    },
    /// An input that no output answers to.
    #[error(
        "no output answers to input {input} (from 0) within {lags} samples by more than four standard errors; hint: \
         --delay N where you know it, more block rows for a longer delay, or leave the input out"
    )]
    NoAnswer {
        /// Which input, from 0.
        input: usize,
        /// Lags that were looked at.
        lags: usize,
    },
    /// Feedback and nothing else moved the input.
    #[error(
        "the input follows from the outputs but for a part of {left:.0e}: a closed loop without external excitation; a model of \
         it would be the controller's inverse; hint: add a test signal to the loop's reference or voltage and record again"
    )]
    ClosedLoop {
        /// Variance of the input that the outputs leave, relative to what its own past leaves.
        left: f64,
    },
    /// Known structure that the paper's equations have no place for.
    #[error("the paper's equations (13)-(17) have no place for {structure}; hint: --method auto has")]
    Structure {
        /// What was asked for.
        structure: &'static str,
    },
    /// What needs the samples a second time, asked of a recording that is read once.
    #[error("a recording that is read once has no place for {structure}; hint: a shorter part of it, read whole, has")]
    Streamed {
        /// What was asked for.
        structure: &'static str,
    },
    /// A refinement of a model whose states are in part a known delay.
    #[error(
        "the model carries an input delay of {delay} samples as states, which a refinement would take for poles to move; hint: leave --delay or --refine out"
    )]
    DelayRefined {
        /// Longest delay of an input [samples].
        delay: usize,
    },
    /// The outputs do not answer to the inputs or to any state at all.
    #[error("the outputs are constant or do not depend on the past: no state to identify")]
    NoState,
    /// Physical coordinates need theta and alpha and four states.
    #[error(
        "physical coordinates need one input, the outputs theta and alpha and order 4; found {inputs} inputs, {outputs} outputs, order {order}"
    )]
    NotTheFlexibleLink {
        /// Inputs found.
        inputs: usize,
        /// Outputs found.
        outputs: usize,
        /// Order found.
        order: usize,
    },
    /// [C; CA] is singular: theta and alpha do not determine the state.
    #[error(
        "the outputs and their velocities do not determine the state: [C; CA] has reciprocal condition {reciprocal:.1e}"
    )]
    Unobservable {
        /// Smallest over largest singular value.
        reciprocal: f64,
    },
    /// A model whose simulated output overflows has no residuals to make smaller.
    #[error(
        "the model's simulated output overflows within {samples} samples: nothing to refine; hint: another --order, \
         more --block-rows, or a shorter part of the recording"
    )]
    Overflow {
        /// Samples of the recording.
        samples: usize,
    },
    /// The least squares of the physical parameters left the range where the model means something.
    #[error("the physical parameters did not settle after {iterations} iterations: last relative step {step:.1e}")]
    NotSettled {
        /// Iterations done.
        iterations: usize,
        /// Last relative step.
        step: f64,
    },
    /// The deflection's response has one number fewer than there are unknowns.
    #[error(
        "the deflection alone does not tell the beam's damping from the hub's; needed theta or psi among the outputs"
    )]
    BeamDampingUnseen,
    /// Parameters that settled where no link can be.
    #[error(
        "the physical parameters came out as k1 = {k1:.4}, k2 = {k2:.4}, c = {c:.4}, b = {b:.4}; a link has 0 < k1 < k2, c > 0 and b > 0"
    )]
    NoLink {
        /// K_stiff/J_base [1/s^2].
        k1: f64,
        /// K_stiff (1/J_link + 1/J_base) [1/s^2].
        k2: f64,
        /// Damping of the hub [1/s].
        c: f64,
        /// Acceleration per volt [rad/s^2/V].
        b: f64,
    },
    /// The hub never moved in one direction of a breakaway test.
    #[error("the hub never moved {direction}: the ramp reached {reached_v} V; hint: a larger ramp, or a free hub")]
    NeverMoved {
        /// `forward` or `backward`.
        direction: &'static str,
        /// Largest voltage of that sign [V].
        reached_v: f64,
    },
    /// The hub moved although the ramp was at zero.
    #[error("the hub moves at {voltage_v} V already, at sample {sample}; hint: let it come to rest before the ramp")]
    NotAtRest {
        /// Voltage where the movement starts [V].
        voltage_v: f64,
        /// Sample, from 0.
        sample: usize,
    },
    /// Two models with different numbers of poles right of the line Re s = -beta: (19) does not make them one plant.
    #[error(
        "beta = {beta} cannot hold: the recording shows a pole at {re:.4} {im:+.1}j that the nominal plant lacks on that side of the line Re s = -beta; hint: a beta well below the damping of every neglected mode"
    )]
    PoleBeyond {
        /// Stability degree [1/s].
        beta: f64,
        /// Real part of the pole [1/s].
        re: f64,
        /// Imaginary part [rad/s].
        im: f64,
    },
    /// A pole that is not known well enough to say on which side of the line it lies.
    #[error(
        "beta = {beta} is too near to the damping of a mode: in {beyond} of {replicates} recordings that might as well have been made, a pole changes sides of the line Re s = -beta; hint: a smaller beta, a longer recording, or more voltage where there is friction"
    )]
    PoleUncertain {
        /// Stability degree [1/s].
        beta: f64,
        /// Re-estimates with another number of poles there.
        beyond: usize,
        /// Re-estimates made.
        replicates: usize,
    },
    /// Too few slow ramps that moved the hub.
    #[error("found {found} slow ramps that moved the hub {direction}, needed {needed} for a standard error")]
    TooFewRamps {
        /// `forward` or `backward`.
        direction: &'static str,
        /// Ramps found.
        found: usize,
        /// Ramps needed.
        needed: usize,
    },
    /// Too few runs at constant speed one way.
    #[error("found {found} runs at constant voltage and speed {direction}, needed {needed}")]
    TooFewRuns {
        /// `forward` or `backward`.
        direction: &'static str,
        /// Runs found.
        found: usize,
        /// Runs needed.
        needed: usize,
    },
    /// All runs at about the same speed.
    #[error("the runs turn at {slowest:.3} to {fastest:.3} rad/s, needed a fastest at least twice the slowest")]
    OneSpeed {
        /// Slowest run [rad/s].
        slowest: f64,
        /// Fastest run [rad/s].
        fastest: f64,
    },
    /// The speeds of the runs do not part the numbers of the line.
    #[error("the speeds of the runs do not part slope and dry friction: reciprocal condition {reciprocal:.1e}")]
    SpeedsAlike {
        /// Smallest over largest singular value.
        reciprocal: f64,
    },
    /// The hub never slid at 0 V: dead zone and Coulomb torque act as one.
    #[error("found {forward} runs cut to 0 V that coast forward and {backward} backward, needed {needed} each way")]
    NoCoast {
        /// Runs whose windows see the hub slide forward without voltage.
        forward: usize,
        /// The same backward.
        backward: usize,
        /// Runs needed.
        needed: usize,
    },
    /// A question about the linear system had no answer.
    #[error(transparent)]
    Linear(#[from] flexbeam_lti::Error),
}
