//! What the system grants to the loop's thread: a real-time priority, locked memory, a core of its own.
//!
//! None of it is demanded. What is refused becomes a plain warning that says what to do.

use nix::errno::Errno;
use nix::sched::{CpuSet, sched_setaffinity};
use nix::sys::mman::{MlockAllFlags, mlockall};
use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
use nix::unistd::{Pid, geteuid};
use std::fmt;

/// SCHED_FIFO priority of the loop; below the kernel's own threads for timers (99) and above what desktops use.
pub const LOOP_PRIORITY: i32 = 80;
/// Priority of the watchdog: it must run when the loop does not stop running.
pub const WATCHDOG_PRIORITY: i32 = 81;

/// Stack that is touched before the first tick [bytes]; the loop and a back end need less than a tenth.
const STACK: usize = 128 * 1024;

/// What was granted to a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// SCHED_FIFO with this priority, or why not.
    pub priority: Result<i32, Errno>,
    /// All memory of the process locked, or why not.
    pub memory: Result<(), Errno>,
    /// Bound to this core, or why not; nothing when it was not asked for.
    pub core: Option<Result<usize, Errno>>,
}

/// A right that was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// No real-time priority.
    Priority(Errno),
    /// Memory may be paged.
    Memory(Errno),
    /// No core of its own.
    Core(Errno),
}

impl Standing {
    /// Real-time: no. Claims everything for the calling thread, and touches its stack.
    pub fn claim(priority: i32, core: Option<usize>) -> Standing {
        let standing = Standing {
            memory: mlockall(pages()),
            priority: fifo(priority).map(|()| priority),
            core: core.map(|core| pin(core).map(|()| core)),
        };
        touch_stack();
        standing
    }

    /// What was refused.
    pub fn warnings(&self) -> Vec<Warning> {
        let priority = self.priority.err().map(Warning::Priority);
        let core = self.core.and_then(Result::err).map(Warning::Core);
        [priority, self.memory.err().map(Warning::Memory), core].into_iter().flatten().collect()
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::Priority(error) => write!(
                f,
                "no real-time priority ({}): other programs may delay the loop by milliseconds\n\
                 hint: run as root, or give your user the right once: echo \"$USER - rtprio 90\" | sudo tee /etc/security/limits.d/flexbeam.conf, and log in again",
                error.desc()
            ),
            Warning::Memory(error) => write!(
                f,
                "memory is not locked ({}): a page that comes back from disk delays the loop\n\
                 hint: echo \"$USER - memlock unlimited\" | sudo tee -a /etc/security/limits.d/flexbeam.conf, and log in again",
                error.desc()
            ),
            Warning::Core(error) => write!(
                f,
                "the loop has no core of its own ({}): the system may move it between cores\n\
                 hint: name a core that exists, counted from 0, with --core",
                error.desc()
            ),
        }
    }
}

/// Pages to come are locked only where there is no limit: one that is met on the way would end the program.
fn pages() -> MlockAllFlags {
    let limit = getrlimit(Resource::RLIMIT_MEMLOCK).map_or(0, |(soft, _)| soft);
    let unlimited = limit == RLIM_INFINITY || geteuid().is_root();
    let future = if unlimited { MlockAllFlags::MCL_FUTURE } else { MlockAllFlags::empty() };
    MlockAllFlags::MCL_CURRENT | future
}

fn fifo(priority: i32) -> Result<(), Errno> {
    let parameter = libc::sched_param { sched_priority: priority };
    // SAFETY: `parameter` lives through the call, which only reads it; pid 0 is the calling thread.
    Errno::result(unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameter) }).map(drop)
}

fn pin(core: usize) -> Result<(), Errno> {
    let mut set = CpuSet::new();
    set.set(core)?;
    sched_setaffinity(Pid::from_raw(0), &set)
}

/// Brings the stack's pages in.
#[inline(never)]
fn touch_stack() {
    let mut pages = [0u8; STACK];
    pages.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
    std::hint::black_box(&pages);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_is_said_with_what_to_do() {
        let all = Standing { priority: Err(Errno::EPERM), memory: Err(Errno::ENOMEM), core: Some(Err(Errno::EINVAL)) };
        let said: Vec<String> = all.warnings().iter().map(Warning::to_string).collect();
        assert_eq!(said.len(), 3);
        assert!(said.iter().all(|warning| warning.contains("\nhint: ")));
        let none = Standing { priority: Ok(80), memory: Ok(()), core: None };
        assert_eq!(none.warnings(), []);
    }

    #[test]
    fn a_core_that_does_not_exist_is_refused() {
        std::thread::spawn(|| assert_eq!(pin(1023), Err(Errno::EINVAL))).join().unwrap();
    }
}
