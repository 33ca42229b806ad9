//! What other threads say to the loop, and what the loop lets them see: plain atomic numbers, no lock.

use crate::lifecycle::Phase;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};

/// Shared by the loop, its watchdog, signal handlers and every view.
#[derive(Clone, Debug, Default)]
pub struct Controls(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    start: AtomicBool,
    stop: AtomicBool,
    /// Somebody else's wish to stop, for this run and for others: a signal handler's.
    asked: Arc<AtomicBool>,
    emergency: AtomicBool,
    watchdog: AtomicBool,
    phase: AtomicU8,
    /// How often the loop has woken.
    beats: AtomicU64,
}

impl Controls {
    /// Real-time: yes. From armed to running, at the next tick.
    pub fn start(&self) {
        self.0.start.store(true, Ordering::Release);
    }

    /// Real-time: yes. To 0 V and to the end, at the next tick.
    pub fn stop(&self) {
        self.0.stop.store(true, Ordering::Release);
    }

    /// Real-time: yes. The emergency stop: a fault, at the next tick.
    pub fn emergency(&self) {
        self.0.emergency.store(true, Ordering::Release);
    }

    /// Real-time: no. Controls that also stop when `asked` is set, by a signal handler for example.
    pub(crate) fn with(asked: Arc<AtomicBool>) -> Controls {
        Controls(Arc::new(Shared { asked, ..Shared::default() }))
    }

    /// Real-time: yes. Where the run stands.
    pub fn phase(&self) -> Phase {
        Phase::of(self.0.phase.load(Ordering::Acquire)).unwrap_or_default()
    }

    pub(crate) fn set_phase(&self, phase: Phase) {
        self.0.phase.store(phase as u8, Ordering::Release);
    }

    pub(crate) fn start_asked(&self) -> bool {
        self.0.start.load(Ordering::Acquire)
    }

    pub(crate) fn stop_asked(&self) -> bool {
        self.0.stop.load(Ordering::Acquire) || self.0.asked.load(Ordering::Acquire)
    }

    pub(crate) fn emergency_asked(&self) -> bool {
        self.0.emergency.load(Ordering::Acquire)
    }

    pub(crate) fn bite(&self) {
        self.0.watchdog.store(true, Ordering::Release);
    }

    pub(crate) fn bitten(&self) -> bool {
        self.0.watchdog.load(Ordering::Acquire)
    }

    pub(crate) fn beat(&self) {
        self.0.beats.fetch_add(1, Ordering::AcqRel);
    }

    pub(crate) fn beats(&self) -> u64 {
        self.0.beats.load(Ordering::Acquire)
    }
}
