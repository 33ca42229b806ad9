//! The simulated rig in the process, as a back end.

use crate::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use flexbeam_rig::{Measurement, SimulatedRig};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A rig in the process. Its time is the loop's count of periods, so a run gives the bits of [`flexbeam_rig::closed_loop`].
pub struct SimulatedBackEnd {
    rig: SimulatedRig,
    /// Voltages on their way where the rig has more than the loop's own period of delay.
    on_its_way: VecDeque<f64>,
    /// The instant after the last one that was exchanged, and the voltage that acts.
    next: u64,
    held_v: f64,
    cut: Arc<AtomicBool>,
}

struct SimulatedCutoff(Arc<AtomicBool>);

impl Cutoff for SimulatedCutoff {
    fn cut(&self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

impl SimulatedBackEnd {
    /// Real-time: no.
    ///
    /// Errors: a rig whose computing delay is less than the loop's own, which is one period.
    pub fn new(rig: SimulatedRig) -> Result<SimulatedBackEnd, OpenError> {
        let delay = rig.parameters().computing_delay_periods;
        let Some(further) = delay.checked_sub(1) else {
            return Err(OpenError {
                found: "a simulated rig without computing delay".into(),
                needed: "at least one period: the loop sends at an instant what the one before computed".into(),
                hint: "computing_delay_periods = 1 in the rig file".into(),
            });
        };
        let mut on_its_way = VecDeque::with_capacity(further + 1);
        on_its_way.resize(further, 0.0);
        Ok(SimulatedBackEnd { rig, on_its_way, next: 0, held_v: 0.0, cut: Arc::default() })
    }

    /// Real-time: no. The rig behind it, to look at what no sensor shows.
    pub fn rig(&self) -> &SimulatedRig {
        &self.rig
    }

    fn hold(&mut self, voltage_v: f64) {
        self.on_its_way.push_back(voltage_v);
        self.held_v = self.on_its_way.pop_front().unwrap_or(0.0);
        self.rig.apply(self.held_v);
    }
}

impl BackEnd for SimulatedBackEnd {
    fn exchange(&mut self, instant: u64, voltage_v: f64) -> Result<Answer, LinkFault> {
        if self.cut.load(Ordering::Relaxed) {
            return Err(LinkFault::CutOff);
        }
        // The periods that the loop missed passed with the voltage that stood.
        (self.next..instant).for_each(|_| self.rig.apply(self.held_v));
        let measured: Measurement = self.rig.measure();
        self.hold(voltage_v);
        self.next = instant + 1;
        Ok(Answer::Fresh(measured))
    }

    fn zero(&mut self) -> Result<(), LinkFault> {
        self.on_its_way.iter_mut().for_each(|v| *v = 0.0);
        self.held_v = 0.0;
        Ok(())
    }

    fn prepare(&mut self, _timing: Timing) -> Result<(), OpenError> {
        self.cut.store(false, Ordering::SeqCst);
        self.next = 0;
        self.zero().expect("a simulated rig can always be set to 0 V");
        Ok(())
    }

    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        Some(Box::new(SimulatedCutoff(self.cut.clone())))
    }

    fn counters(&self) -> Counters {
        Counters::default()
    }

    fn name(&self) -> String {
        "simulated".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flexbeam_rig::RigParameters;

    fn rig() -> SimulatedRig {
        SimulatedRig::new(&RigParameters::default(), 7).unwrap()
    }

    #[test]
    fn missed_periods_pass_with_the_voltage_that_stood() {
        let mut back_end = SimulatedBackEnd::new(rig()).unwrap();
        let mut by_hand = rig();
        for (instant, voltage_v) in [(0, 1.0), (1, 2.0), (5, 3.0), (6, -1.0)] {
            let answer = back_end.exchange(instant, voltage_v).unwrap();
            if instant == 5 {
                (0..3).for_each(|_| by_hand.apply(2.0));
            }
            assert_eq!(answer, Answer::Fresh(by_hand.measure()));
            by_hand.apply(voltage_v);
        }
        assert_eq!(back_end.rig().truth(), by_hand.truth());
    }

    #[test]
    fn further_periods_of_delay_are_kept_and_none_is_refused() {
        let with_delay = |computing_delay_periods| {
            let parameters = RigParameters { computing_delay_periods, ..RigParameters::default() };
            SimulatedBackEnd::new(SimulatedRig::new(&parameters, 1).unwrap())
        };
        let mut back_end = with_delay(3).unwrap();
        let mut by_hand = rig();
        for (instant, voltage_v) in [9.0, 8.0, 7.0].into_iter().enumerate() {
            back_end.exchange(instant as u64, voltage_v).unwrap();
        }
        [0.0, 0.0, 9.0].into_iter().for_each(|v| by_hand.apply(v));
        assert_eq!(back_end.rig().truth(), by_hand.truth());
        assert!(with_delay(0).is_err());
    }

    #[test]
    fn once_cut_off_it_takes_no_voltage_until_it_is_prepared_again() {
        let mut back_end = SimulatedBackEnd::new(rig()).unwrap();
        back_end.cutoff().unwrap().cut();
        assert_eq!(back_end.exchange(0, 1.0), Err(LinkFault::CutOff));
        back_end.prepare(Timing { period_s: 1e-3, wait_s: 1e-3, hold_s: 0.02 }).unwrap();
        assert!(back_end.exchange(0, 1.0).is_ok());
    }
}
