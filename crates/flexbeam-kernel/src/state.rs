//! All that one tick hands to the next. Enters: memory that the caller lends. Leaves: itself, changed by
//! [`crate::tick`] alone. Deliberately absent: settings, which may change between ticks without touching it.

use crate::controller::{Controller, Error};
use crate::filter::LowPass;
use crate::law::Switches;
use crate::limits::Fault;
use crate::smooth::Path;

/// State of the loop: the controller's x, the filters, the reference's path, the law's switches, a latched fault.
#[derive(Debug, PartialEq)]
pub struct State<'a> {
    /// z = (x, v, y, u_applied), what [A B] multiplies.
    pub(crate) z: &'a mut [f64],
    /// Where the next x is put together.
    pub(crate) next: &'a mut [f64],
    pub(crate) theta: LowPass,
    pub(crate) alpha: LowPass,
    pub(crate) reference: Path,
    pub(crate) switches: Switches,
    pub(crate) fault: Fault,
}

impl<'a> State<'a> {
    /// Real-time: no. The state at rest at 0 rad, x = 0, no fault.
    ///
    /// Shapes: `memory` has [`Controller::state_len`] numbers; what they held is overwritten.
    /// Errors: [`Error::Memory`] when it has another length.
    pub fn new(controller: &Controller<'_>, memory: &'a mut [f64]) -> Result<Self, Error> {
        let (needed, found) = (controller.state_len(), memory.len());
        let halves = memory.split_at_mut_checked(controller.order() + Controller::INPUTS);
        let Some((z, next)) = halves.filter(|_| found == needed) else {
            return Err(Error::Memory { needed, found });
        };
        z.fill(0.0);
        next.fill(0.0);
        Ok(Self {
            z,
            next,
            theta: LowPass::default(),
            alpha: LowPass::default(),
            reference: Path::default(),
            switches: Switches::default(),
            fault: Fault::None,
        })
    }

    /// Real-time: yes. Back to what [`State::new`] made: the only way out of a fault.
    ///
    /// Assumes: x = 0 stands for a beam at rest at 0 rad; where it rests elsewhere, the channels' offsets take it there.
    pub fn reset(&mut self) {
        self.z.fill(0.0);
        self.next.fill(0.0);
        self.theta = LowPass::default();
        self.alpha = LowPass::default();
        self.reference = Path::default();
        self.switches = Switches::default();
        self.fault = Fault::None;
    }

    /// The controller's state x, n numbers.
    pub fn x(&self) -> &[f64] {
        self.z.get(..self.next.len()).unwrap_or_default()
    }

    /// The fault that holds the rig at 0 V.
    pub fn fault(&self) -> Fault {
        self.fault
    }

    /// Real-time: yes. Puts v and y behind x.
    pub(crate) fn set_inputs(&mut self, v_now: f64, y_now: f64) {
        if let [.., v, y, _] = self.z {
            (*v, *y) = (v_now, y_now);
        }
    }

    /// Real-time: yes. x+ = [A B] z.
    pub(crate) fn advance(&mut self, controller: &Controller<'_>, u_applied: f64) {
        if let [.., last] = self.z {
            *last = u_applied;
        }
        controller.advance(self.z, self.next);
        self.z.iter_mut().zip(self.next.iter()).for_each(|(x, next)| *x = *next);
    }
}
