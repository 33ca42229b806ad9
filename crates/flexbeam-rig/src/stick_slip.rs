//! A hub with dry friction and its link through one period of constant motor torque.
//!
//! Enters: the motor's stall torque. Leaves: the next state. Sliding either way and sticking are three linear
//! systems; each is propagated by its own matrix exponential, so nothing is approximated but the instant at which one
//! takes over from another.

use crate::friction::{Contact, Friction};
use crate::piece::{Piece, pieces};
use crate::{Error, Motion};
use flexbeam_lti::Mat;

/// The instant of a change of contact is bisected down to 2^-24 of a substep: 15 ps of 0.25 ms, in which the hub
/// gains less speed than rounding loses in a second.
pub(crate) const HALVINGS: u32 = 24;
const WHOLE: u32 = 1 << HALVINGS;

/// State [theta theta' eta eta'] and what carries it forward.
///
/// Numerics: exact for Coulomb friction but for events that begin and end within one substep; second order in the
/// substep with a Stribeck effect, whose torque is held over each piece at its value for the speed expected halfway.
#[derive(Clone, Debug)]
pub(crate) struct StickSlip {
    x: Vec<f64>,
    next: Vec<f64>,
    contact: Contact,
    friction: Friction,
    substeps: u32,
    /// Pieces of the whole state under hub torque.
    sliding: Vec<Piece>,
    /// Pieces of [eta eta'] with the hub held.
    held: Vec<Piece>,
    /// Torque of the link on the held hub: its product with [eta eta'].
    reaction: Vec<f64>,
}

const THETA: usize = 0;
const SPEED: usize = 1;
/// [eta eta'] begins here.
const LINK: usize = 2;

impl StickSlip {
    /// At rest at theta = 0.
    ///
    /// Errors: [`Error::Lti`] when the motion has an entry that is not finite.
    pub fn new(motion: &Motion, friction: Friction, period_s: f64, substeps: u32) -> Result<StickSlip, Error> {
        let system = motion.state_space_with_friction(&[])?;
        let n = system.order();
        let order: Vec<usize> = [0, n / 2].into_iter().chain(1..n / 2).chain(n / 2 + 1..n).collect();
        let A = system.A.select_rows(&order).select_columns(&order);
        let torque_in = -system.B.select_rows(&order).columns(1, 1).into_owned();
        let (A_held, reaction) = motion.clamped();
        let substep_s = period_s / f64::from(substeps);
        Ok(StickSlip {
            x: vec![0.0; n],
            next: vec![0.0; n],
            contact: friction.contact_at_rest(0.0),
            friction,
            substeps,
            sliding: pieces(&A, &torque_in, substep_s),
            held: pieces(&A_held, &Mat::zeros(n - LINK, 1), substep_s),
            reaction: reaction.as_slice().to_vec(),
        })
    }

    /// Back to rest at theta = 0.
    pub fn reset(&mut self) {
        self.x.fill(0.0);
        self.contact = self.friction.contact_at_rest(0.0);
    }

    /// One period under this stall torque.
    ///
    /// Numerics: no allocation; 4 n^2 flops a substep, some fifty times that where the contact changes.
    pub fn advance(&mut self, torque_nm: f64) {
        if self.x[SPEED] == 0.0 {
            self.contact = self.contact_at_rest(torque_nm);
        }
        for _ in 0..self.substeps {
            self.advance_substep(torque_nm);
        }
    }

    pub fn theta(&self) -> f64 {
        self.x[THETA]
    }

    pub fn speed(&self) -> f64 {
        self.x[SPEED]
    }

    /// [eta eta'].
    pub fn link(&self) -> &[f64] {
        &self.x[LINK..]
    }

    /// For a substep, half of it, a quarter, ..
    pub fn sliding(&self) -> &[Piece] {
        &self.sliding
    }

    /// Likewise, of [eta eta'] with the hub held.
    pub fn held(&self) -> &[Piece] {
        &self.held
    }

    pub fn reaction(&self) -> &[f64] {
        &self.reaction
    }

    pub fn is_stuck(&self) -> bool {
        self.contact == Contact::Stuck
    }

    /// Goes in the largest pieces that end in the contact in which they began; a piece that does not is halved.
    fn advance_substep(&mut self, torque_nm: f64) {
        let (mut left, mut size) = (WHOLE, WHOLE);
        let mut searching = false;
        while left > 0 {
            size = size.min(1 << left.ilog2());
            self.try_piece((HALVINGS - size.ilog2()) as usize, torque_nm);
            let ended = self.contact_has_ended(torque_nm);
            if ended && size > 1 {
                searching = true;
                size /= 2;
                continue;
            }
            std::mem::swap(&mut self.x, &mut self.next);
            left -= size;
            if ended {
                self.change_contact(torque_nm);
            }
            // The event lies in the second half of what was too long, unless the smallest piece has just been taken.
            searching = searching && size > 1;
            size = if searching { size / 2 } else { WHOLE };
        }
    }

    fn try_piece(&mut self, halvings: usize, torque_nm: f64) {
        match self.contact {
            Contact::Stuck => {
                self.next[..LINK].copy_from_slice(&self.x[..LINK]);
                self.held[halvings].propagate(&self.x[LINK..], 0.0, &mut self.next[LINK..]);
            }
            Contact::Free => self.sliding[halvings].propagate(&self.x, torque_nm, &mut self.next),
            Contact::Sliding { direction } => {
                let net_nm = torque_nm - direction * self.sliding_nm(halvings, torque_nm, direction);
                self.sliding[halvings].propagate(&self.x, net_nm, &mut self.next);
            }
        }
    }

    /// Friction torque at the speed that is expected halfway through a piece.
    fn sliding_nm(&self, halvings: usize, torque_nm: f64, direction: f64) -> f64 {
        let now = self.friction.sliding_nm(self.x[SPEED]);
        if self.friction.stribeck.is_none() || halvings == HALVINGS as usize {
            return now;
        }
        let half = &self.sliding[halvings + 1];
        self.friction.sliding_nm(half.row(SPEED, &self.x, torque_nm - direction * now))
    }

    fn contact_has_ended(&self, torque_nm: f64) -> bool {
        match self.contact {
            Contact::Free => false,
            Contact::Stuck => self.torque_on_held_hub(&self.next, torque_nm).abs() > self.friction.breakaway_nm(),
            Contact::Sliding { direction } => direction * self.next[SPEED] < 0.0,
        }
    }

    fn change_contact(&mut self, torque_nm: f64) {
        self.x[SPEED] = 0.0;
        self.contact = self.contact_at_rest(torque_nm);
    }

    fn contact_at_rest(&self, torque_nm: f64) -> Contact {
        self.friction.contact_at_rest(self.torque_on_held_hub(&self.x, torque_nm))
    }

    fn torque_on_held_hub(&self, x: &[f64], torque_nm: f64) -> f64 {
        torque_nm + self.reaction.iter().zip(&x[LINK..]).map(|(r, eta)| r * eta).sum::<f64>()
    }
}
