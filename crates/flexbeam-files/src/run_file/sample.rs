//! One tick of a run, and its message: plain CDR, little-endian, as ROS 2 writes it.

/// First bytes of every message: plain CDR, little-endian, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// The fields once, for the struct, its columns, the message and the definition that other readers are given.
///
/// Sorted by size, so that CDR's alignment puts no bytes between them.
macro_rules! fields {
    ($($name:ident: $type:ident $ros:literal [$unit:literal] $doc:literal;)*) => {
        /// What the loop records once a tick.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct RunSample {
            $(#[doc = $doc] pub $name: $type,)*
        }

        /// The samples of a run, a column a field. Columns are equally long.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct RunColumns {
            $(#[doc = $doc] pub $name: Vec<$type>,)*
        }

        impl RunSample {
            /// Names of the fields, in the message's order.
            pub const NAMES: &[&str] = &[$(stringify!($name)),*];

            /// What a scope can draw: all but the tick, which is its time.
            pub const SIGNALS: &[&str] = Self::NAMES.split_at(1).1;

            /// The units of [`RunSample::NAMES`], as in the names; empty for a count or a code.
            pub const UNITS: &[&str] = &[$($unit),*];

            /// Length of a message [bytes].
            pub const BYTES: usize = ENCAPSULATION.len() $(+ size_of::<$type>())*;

            /// The definition of `flexbeam_msgs/msg/Signals`.
            pub const DEFINITION: &str = concat!($($ros, " ", stringify!($name), "  # ", $doc, "\n"),*);

            /// The message on the topic `/signals`.
            pub fn to_cdr(self) -> [u8; Self::BYTES] {
                let mut bytes = [0; Self::BYTES];
                let mut at = 0;
                let mut put = |field: &[u8]| {
                    bytes[at..at + field.len()].copy_from_slice(field);
                    at += field.len();
                };
                put(&ENCAPSULATION);
                $(put(&self.$name.to_le_bytes());)*
                bytes
            }

            /// The sample in a message; nothing when it is no such message.
            pub fn from_cdr(bytes: &[u8]) -> Option<RunSample> {
                let rest = &mut bytes.strip_prefix(&ENCAPSULATION)?;
                let sample = RunSample { $($name: <$type>::from_le_bytes(taken(rest)?),)* };
                rest.is_empty().then_some(sample)
            }

            /// All fields as numbers, in the message's order.
            pub fn values(&self) -> [f64; Self::NAMES.len()] {
                [$(self.$name as f64),*]
            }
        }

        impl RunColumns {
            /// Appends a sample.
            pub fn push(&mut self, sample: RunSample) {
                $(self.$name.push(sample.$name);)*
            }

            /// Sample k; nothing beyond the last one.
            pub fn get(&self, k: usize) -> Option<RunSample> {
                Some(RunSample { $($name: *self.$name.get(k)?,)* })
            }
        }
    };
}

fields! {
    tick: u64 "uint64" [""] "Periods since the run began; a gap is a tick that was missed.";
    voltage_v: f64 "float64" ["v"] "Voltage that acts from this instant on: what was sent [V].";
    commanded_v: f64 "float64" ["v"] "Voltage that this tick computed; it acts one period later [V].";
    u_v: f64 "float64" ["v"] "The controller's u, before the variable-structure law [V].";
    reference_rad: f64 "float64" ["rad"] "Reference as asked for [rad].";
    smoothed_rad: f64 "float64" ["rad"] "Reference after the smooth step [rad].";
    theta_rad: f64 "float64" ["rad"] "Hub angle as measured, from its zero, unfiltered [rad].";
    alpha_rad: f64 "float64" ["rad"] "Deflection angle as measured, from its zero, unfiltered [rad].";
    psi_rad: f64 "float64" ["rad"] "Tip angle, filtered [rad].";
    y_model_rad: f64 "float64" ["rad"] "Output of the reference model [rad].";
    error_rad: f64 "float64" ["rad"] "The reference model's output less the tip angle [rad].";
    lateness_ns: u32 "uint32" [""] "How late the tick began [ns].";
    execution_ns: u32 "uint32" [""] "How long it took [ns].";
    settings: u32 "uint32" [""] "Revision of the settings in force.";
    phase: u8 "uint8" [""] "0 armed, 1 running, 2 stopped.";
    fault: u8 "uint8" [""] "The loop's code of a fault; 0 for none.";
    stale: u8 "uint8" [""] "1 where no fresh measurement came: the last one stands.";
}

/// The next bytes, taken off the front.
fn taken<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (field, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(*field)
}

impl RunColumns {
    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.tick.len()
    }
}

/// Where a run stands, as [`RunSample::phase`] counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum RunPhase {
    /// Ready; the rig gets 0 V.
    Armed = 0,
    /// The controller decides the voltage.
    Running = 1,
    /// Over; the rig gets 0 V.
    Stopped = 2,
}

impl RunPhase {
    /// The phase of that number.
    pub fn of(code: u8) -> Option<RunPhase> {
        [RunPhase::Armed, RunPhase::Running, RunPhase::Stopped].into_iter().find(|phase| *phase as u8 == code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> RunSample {
        RunSample {
            tick: 0x0102_0304_0506_0708,
            voltage_v: -0.0,
            commanded_v: f64::from_bits(0x7ff8_dead_beef_0001),
            theta_rad: 5e-324,
            lateness_ns: 0xa1b2_c3d4,
            phase: 1,
            stale: 0xff,
            ..RunSample::default()
        }
    }

    #[test]
    fn a_message_is_laid_out_as_cdr_demands() {
        let bytes = sample().to_cdr();
        assert_eq!(bytes.len(), 4 + 11 * 8 + 3 * 4 + 3);
        assert_eq!(bytes[..12], [0, 1, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1], "header, then tick, little-endian");
        assert_eq!(bytes[4 + 88..4 + 92], [0xd4, 0xc3, 0xb2, 0xa1], "the first 4-byte field, aligned to 4");
        assert_eq!(bytes[4 + 100..], [1, 0, 0xff]);
    }

    #[test]
    fn every_bit_comes_back() {
        let bytes = sample().to_cdr();
        assert_eq!(RunSample::from_cdr(&bytes).unwrap().to_cdr(), bytes);
        assert_eq!(RunSample::from_cdr(&bytes[..bytes.len() - 1]), None);
        assert_eq!(RunSample::from_cdr(&[&bytes[..], &[0]].concat()), None);
        let big_endian = [&[0, 0, 0, 0], &bytes[4..]].concat();
        assert_eq!(RunSample::from_cdr(&big_endian), None);
    }

    #[test]
    fn columns_hold_the_samples() {
        let mut columns = RunColumns::default();
        columns.push(RunSample::default());
        columns.push(RunSample { alpha_rad: 2.0, ..RunSample::default() });
        assert_eq!((columns.samples(), columns.get(1).unwrap().alpha_rad, columns.get(2)), (2, 2.0, None));
        let at = RunSample::NAMES.iter().position(|name| *name == "alpha_rad").unwrap();
        assert_eq!((columns.get(1).unwrap().values()[at], RunSample::UNITS[at]), (2.0, "rad"));
        assert_eq!(RunSample::UNITS.len(), RunSample::NAMES.len());
        assert_eq!((RunSample::NAMES[0], RunSample::SIGNALS), ("tick", &RunSample::NAMES[1..]));
    }

    #[test]
    fn phases_are_known_by_their_numbers() {
        assert_eq!(
            [0, 1, 2, 3].map(RunPhase::of),
            [Some(RunPhase::Armed), Some(RunPhase::Running), Some(RunPhase::Stopped), None]
        );
    }
}
