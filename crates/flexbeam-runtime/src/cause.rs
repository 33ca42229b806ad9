//! Why a run ended.

use crate::back_end::LinkFault;
use flexbeam_kernel as kernel;

/// The end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Its time is over.
    Over,
    /// Somebody asked for it: a key, a signal, the control socket.
    Asked,
    /// A fault; the rig was stopped.
    Fault(RunFault),
}

/// What stops a rig at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RunFault {
    /// The emergency stop.
    #[error("the emergency stop was pressed")]
    Emergency,
    /// The kernel's limits.
    #[error("{}", kernel_words(*.0))]
    Kernel(kernel::Fault),
    /// The loop woke too late: one voltage stood for too long.
    #[error("the loop woke {:.1} ms late, more than one voltage may stand (--hold)", *.late_ns as f64 * 1e-6)]
    Overrun {
        /// How late [ns].
        late_ns: u64,
    },
    /// No measurement for too long.
    #[error("no measurement for {:.1} ms, longer than one voltage may stand (--hold)", *.for_ns as f64 * 1e-6)]
    Silent {
        /// How long [ns].
        for_ns: u64,
    },
    /// The loop misses more periods than it makes up for.
    #[error("the loop keeps missing periods: {missed} of them in excess, more than one voltage may stand (--hold)")]
    Behind {
        /// Missed periods, less one for every three ticks in between.
        missed: u64,
    },
    /// The encoder stands still under a voltage that moves the hub.
    #[error("the encoder is frozen: not a count in {:.0} ms under a voltage that moves the hub (a cable, a blocked hub, the amplifier)", *.for_ns as f64 * 1e-6)]
    Frozen {
        /// How long [ns].
        for_ns: u64,
    },
    /// The end came, and the rig did not take 0 V.
    #[error("the rig did not take 0 V at the end: {0}")]
    NotAtZero(LinkFault),
    /// The back end.
    #[error(transparent)]
    Link(#[from] LinkFault),
    /// The loop's thread hung; the watchdog cut the voltage off.
    #[error("the loop hung, and the watchdog cut the voltage off")]
    Watchdog,
    /// A bug of ours.
    #[error("the loop's thread panicked, which is a bug of flexbeam")]
    Panicked,
}

impl RunFault {
    /// Number in a recording's column `fault`; 0 is no fault.
    pub fn code(self) -> u8 {
        match self {
            RunFault::Kernel(kernel::Fault::None) => 0,
            RunFault::Kernel(kernel::Fault::Deflection) => 1,
            RunFault::Kernel(kernel::Fault::Angle) => 2,
            RunFault::Kernel(kernel::Fault::Speed) => 3,
            RunFault::Kernel(kernel::Fault::NonFinite) => 4,
            RunFault::Kernel(kernel::Fault::Order) => 5,
            RunFault::Emergency => 10,
            RunFault::Overrun { .. } => 11,
            RunFault::Silent { .. } => 12,
            RunFault::Frozen { .. } => 13,
            RunFault::Watchdog => 14,
            RunFault::Panicked => 15,
            RunFault::Behind { .. } => 16,
            RunFault::NotAtZero(_) => 21,
            RunFault::Link(_) => 20,
        }
    }
}

/// A fault of the kernel, in words.
pub fn kernel_words(fault: kernel::Fault) -> &'static str {
    match fault {
        kernel::Fault::Deflection => "the deflection passed its limit (settings.deflection_limit_rad)",
        kernel::Fault::Angle => "the hub passed its limit (settings.theta_limit_rad)",
        kernel::Fault::Speed => "the hub turned faster than its limit (settings.theta_step_limit_rad)",
        kernel::Fault::NonFinite => "a number of the loop was not finite",
        kernel::Fault::Order => "the controller's memory is of another order",
        kernel::Fault::None => "no fault",
    }
}
