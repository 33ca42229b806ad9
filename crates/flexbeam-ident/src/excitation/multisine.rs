//! Sums of harmonics of one period, all of one amplitude.
//!
//! Enters: which harmonics. Leaves: one period, of any scale.
//! Source: Schroeder 1970 (first phases); Van der Ouderaa, Schoukens and Renneboog 1988 (clipping); Pintelon and Schoukens
//! 2012, sections 4.3 and 5.2 (odd random-phase multisines with a random harmonic grid).

use std::f64::consts::{PI, TAU};

use flexbeam_lti::C64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::plan::peak;
use crate::fourier::{Transform, record_of};

/// Rounds of clipping at most; the crest factor of a flat multisine settles within one percent.
const MOST_ROUNDS: usize = 300;
/// Samples transformed at most over all rounds: a second of work.
const MOST_WORK: usize = 30_000_000;
/// Where a round clips, as a part of the peak: deep at first, gently at last.
const CLIP: (f64, f64) = (0.80, 0.98);

/// Of each group of this many odd harmonics one is not excited.
const GROUP: usize = 4;

/// Phases of Schroeder, then clipping of the signal and restoring of the amplitudes in turn; the best period that was met.
pub(super) fn of_low_crest(harmonics: &[usize], samples: usize) -> Vec<f64> {
    let count = harmonics.len() as f64;
    let schroeder = |k: usize| -PI * (k * k) as f64 / count;
    let mut lines = vec![C64::ZERO; samples / 2 + 1];
    for (k, h) in harmonics.iter().enumerate() {
        lines[*h] = C64::cis(schroeder(k));
    }
    let mut transform = Transform::new(samples);
    let rounds = (MOST_WORK / samples).clamp(1, MOST_ROUNDS);
    let mut best = record_of(&lines, samples);
    for round in 0..rounds {
        let mut one = record_of(&lines, samples);
        let highest = peak(&one);
        if highest < peak(&best) {
            best.copy_from_slice(&one);
        }
        let clip = highest * (CLIP.0 + (CLIP.1 - CLIP.0) * round as f64 / rounds as f64);
        one.iter_mut().for_each(|v| *v = v.clamp(-clip, clip));
        let mut clipped = Vec::new();
        transform.lines(&one, &mut clipped);
        for h in harmonics {
            lines[*h] = C64::cis(clipped[*h].arg());
        }
    }
    best
}

/// Phases uniform on the circle.
pub(super) fn of_random_phase(harmonics: &[usize], samples: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut lines = vec![C64::ZERO; samples / 2 + 1];
    for h in harmonics {
        lines[*h] = C64::cis(TAU * random.random::<f64>());
    }
    record_of(&lines, samples)
}

/// The odd ones of these harmonics, less one of each whole group of four, drawn at random.
pub(super) fn odd_grid(harmonics: &[usize], seed: u64) -> Vec<usize> {
    // Not the stream of the phases.
    let mut random = ChaCha8Rng::seed_from_u64(!seed);
    let odd: Vec<usize> = harmonics.iter().copied().filter(|h| h % 2 == 1).collect();
    let mut excited = Vec::with_capacity(odd.len());
    for group in odd.chunks(GROUP) {
        let left_out = random.random_range(0..GROUP);
        excited
            .extend(group.iter().enumerate().filter(|(k, _)| group.len() < GROUP || *k != left_out).map(|(_, h)| *h));
    }
    excited
}
