//! An event-driven reference for the simulated rig: Runge-Kutta of order four with small steps, every change between
//! sticking and sliding located by bisection. It shares the equations of motion with the rig and nothing else: a
//! stuck hub is held by the multiplier that makes theta'' zero.

use flexbeam_lti::{Mat, Vector};
use flexbeam_rig::{Friction, Output, RigParameters};

pub struct EventDriven {
    A: Mat,
    voltage_in: Vector,
    friction_in: Vector,
    psi: Vector,
    friction: Friction,
    step_s: f64,
    pub x: Vector,
    /// 0 while stuck, else the sign of theta'.
    direction: f64,
    pub changes: usize,
}

impl EventDriven {
    pub fn new(parameters: &RigParameters, step_s: f64) -> EventDriven {
        let system = parameters.motion().unwrap().state_space_with_friction(&[Output::Psi]).unwrap();
        EventDriven {
            voltage_in: system.B.column(0).into_owned(),
            friction_in: system.B.column(1).into_owned(),
            psi: system.C.row(0).transpose(),
            friction: parameters.friction,
            step_s,
            x: Vector::zeros(system.order()),
            direction: 0.0,
            changes: 0,
            A: system.A,
        }
    }

    pub fn psi(&self) -> f64 {
        self.psi.dot(&self.x)
    }

    /// Index of theta'.
    fn speed(&self) -> usize {
        self.x.len() / 2
    }

    /// Friction torque that would keep theta' as it is.
    fn holding_nm(&self, x: &Vector, voltage_v: f64) -> f64 {
        let free = (&self.A * x)[self.speed()] + self.voltage_in[self.speed()] * voltage_v;
        -free / self.friction_in[self.speed()]
    }

    fn derivative(&self, x: &Vector, voltage_v: f64) -> Vector {
        let friction_nm = match self.direction {
            0.0 => self.holding_nm(x, voltage_v),
            direction => direction * self.friction.sliding_nm(x[self.speed()]),
        };
        &self.A * x + &self.voltage_in * voltage_v + &self.friction_in * friction_nm
    }

    fn after(&self, step_s: f64, voltage_v: f64) -> Vector {
        let f = |x: &Vector| self.derivative(x, voltage_v);
        let k1 = f(&self.x);
        let k2 = f(&(&self.x + &k1 * (step_s / 2.0)));
        let k3 = f(&(&self.x + &k2 * (step_s / 2.0)));
        let k4 = f(&(&self.x + &k3 * step_s));
        &self.x + (k1 + (k2 + k3) * 2.0 + k4) * (step_s / 6.0)
    }

    fn has_ended(&self, x: &Vector, voltage_v: f64) -> bool {
        match self.direction {
            0.0 => self.holding_nm(x, voltage_v).abs() > self.friction.breakaway_nm(),
            direction => direction * x[self.speed()] < 0.0,
        }
    }

    fn settle_contact(&mut self, voltage_v: f64) {
        let (speed, before) = (self.speed(), self.direction);
        self.x[speed] = 0.0;
        let holding = self.holding_nm(&self.x, voltage_v);
        self.direction = if holding.abs() <= self.friction.breakaway_nm() { 0.0 } else { holding.signum() };
        self.changes += usize::from(self.direction != before);
    }

    pub fn advance(&mut self, period_s: f64, voltage_v: f64) {
        if self.direction == 0.0 {
            self.settle_contact(voltage_v);
        }
        let mut left = period_s;
        while left > 0.0 {
            let mut step = self.step_s.min(left);
            let mut next = self.after(step, voltage_v);
            let ended = self.has_ended(&next, voltage_v);
            if ended {
                let (mut still, mut gone) = (0.0, step);
                while gone - still > 1e-18 && (still + gone) / 2.0 != gone && (still + gone) / 2.0 != still {
                    let middle = (still + gone) / 2.0;
                    if self.has_ended(&self.after(middle, voltage_v), voltage_v) {
                        gone = middle
                    } else {
                        still = middle
                    }
                }
                step = gone;
                next = self.after(step, voltage_v);
            }
            self.x = next;
            left -= step;
            if ended {
                self.settle_contact(voltage_v);
            }
        }
    }
}
