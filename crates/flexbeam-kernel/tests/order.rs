//! The order of summation, bit for bit: `tick` against the plain loops that generated code will contain.

use flexbeam_kernel::{Controller, Fault, Law, Measured, Settings, State, tick};

/// SplitMix64 as numbers in -1..1.
struct Numbers(u64);

impl Iterator for Numbers {
    type Item = f64;
    fn next(&mut self) -> Option<f64> {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Some((z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0)
    }
}

/// A, B, C, D column-major, subscripts as on paper.
struct Plain<'a> {
    n: usize,
    A: &'a [f64],
    B: &'a [f64],
    C: &'a [f64],
    D: &'a [f64],
    x: Vec<f64>,
}

impl<'a> Plain<'a> {
    fn new(n: usize, coefficients: &'a [f64]) -> Self {
        let (A, rest) = coefficients.split_at(n * n);
        let (B, rest) = rest.split_at(3 * n);
        let (C, D) = rest.split_at(2 * n);
        Self { n, A, B, C, D, x: vec![0.0; n] }
    }

    fn outputs(&self, v: f64, y: f64) -> [f64; 2] {
        [0, 1].map(|i| {
            let mut sum = None;
            for j in 0..self.n {
                add(&mut sum, self.C[i + 2 * j] * self.x[j]);
            }
            add(&mut sum, self.D[i] * v);
            add(&mut sum, self.D[i + 2] * y);
            sum.unwrap()
        })
    }

    fn advance(&mut self, inputs: [f64; 3]) {
        let row = |i: usize| {
            let mut sum = None;
            for j in 0..self.n {
                add(&mut sum, self.A[i + self.n * j] * self.x[j]);
            }
            for (j, input) in inputs.iter().enumerate() {
                add(&mut sum, self.B[i + self.n * j] * input);
            }
            sum.unwrap()
        };
        self.x = (0..self.n).map(row).collect();
    }
}

fn add(sum: &mut Option<f64>, product: f64) {
    *sum = Some(sum.map_or(product, |s| s + product));
}

#[test]
fn tick_sums_as_the_plain_loops_do_to_the_last_bit() {
    let settings = Settings { law: Law::None, voltage_limit_v: 0.5, deflection_limit_rad: 10.0, ..Settings::default() };
    for n in [0, 1, 2, 3, 4, 7, 8, 16, 33] {
        let mut numbers = Numbers(n as u64);
        let len = Controller::coefficients_len(n).unwrap();
        // Divided by n, the random A is a contraction.
        let coefficients: Vec<f64> = numbers.by_ref().take(len).map(|c| c / n.max(1) as f64).collect();
        let controller = Controller::new(n, &coefficients).unwrap();
        let mut memory = vec![0.0; controller.state_len()];
        let mut state = State::new(&controller, &mut memory).unwrap();
        let mut plain = Plain::new(n, &coefficients);
        for k in 0..200 {
            let [v, theta, alpha] = [(); 3].map(|()| numbers.next().unwrap());
            let measured = Measured { reference_rad: v, theta_rad: theta, alpha_rad: alpha };
            let commanded = tick(&settings, &controller, &mut state, measured);
            let y = theta + alpha;
            let [u, y_model] = plain.outputs(v, y);
            plain.advance([v, y, u.clamp(-0.5, 0.5)]);
            assert_eq!(commanded.fault, Fault::None);
            let found = [commanded.u_v, commanded.y_model_rad, commanded.error_rad, commanded.voltage_v];
            let expected = [u, y_model, y_model - y, u.clamp(-0.5, 0.5)];
            assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "order {n}, tick {k}");
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(state.x()), bits(&plain.x), "order {n}, tick {k}");
        }
    }
}
