use super::Schur;

/// The plane rotation [c s; -s c].
#[derive(Clone, Copy)]
pub(super) struct Rotation {
    c: f64,
    s: f64,
}

impl Rotation {
    /// The rotation that turns (x, y) onto the first axis.
    pub(super) fn onto_first_axis(x: f64, y: f64) -> Rotation {
        let r = x.hypot(y);
        if r == 0.0 { Rotation { c: 1.0, s: 0.0 } } else { Rotation { c: x / r, s: y / r } }
    }

    fn by_angle(theta: f64) -> Rotation {
        let (s, c) = theta.sin_cos();
        Rotation { c, s }
    }

    /// T <- G T G', Q <- Q G' in rows and columns k, k+1; `T` stays quasi-triangular outside the block.
    pub(super) fn turn(self, form: &mut Schur, k: usize) {
        let Rotation { c, s } = self;
        let n = form.T.nrows();
        for j in k..n {
            let (x, y) = (form.T[(k, j)], form.T[(k + 1, j)]);
            (form.T[(k, j)], form.T[(k + 1, j)]) = (c * x + s * y, c * y - s * x);
        }
        for i in 0..k + 2 {
            let (x, y) = (form.T[(i, k)], form.T[(i, k + 1)]);
            (form.T[(i, k)], form.T[(i, k + 1)]) = (c * x + s * y, c * y - s * x);
        }
        for i in 0..form.Q.nrows() {
            let (x, y) = (form.Q[(i, k)], form.Q[(i, k + 1)]);
            (form.Q[(i, k)], form.Q[(i, k + 1)]) = (c * x + s * y, c * y - s * x);
        }
    }
}

/// Brings the block in rows k, k+1 to standard form: triangular when its eigenvalues are real, otherwise
/// [a b; c a] with b c < 0, whose eigenvalues are a +- sqrt(b c).
pub(super) fn standardise(form: &mut Schur, k: usize) {
    if equalise_diagonal(form, k) {
        return;
    }
    let (a, b, c, d) = form.block(k);
    if c == 0.0 {
        return;
    }
    // Eigenvector (z, c) of the eigenvalue d + z farther from d.
    let p = 0.5 * (a - d);
    let z = p + real_root(p, b, c).max(0.0).sqrt().copysign(p);
    Rotation::onto_first_axis(z, c).turn(form, k);
    form.T[(k + 1, k)] = 0.0;
}

/// For a block with complex eigenvalues: makes its diagonal constant. False when the eigenvalues are real,
/// be it only after the rotation's rounding.
fn equalise_diagonal(form: &mut Schur, k: usize) -> bool {
    let (a, b, c, d) = form.block(k);
    if !(real_root(0.5 * (a - d), b, c) < 0.0) {
        return false;
    }
    let sum = b + c;
    let theta = 0.5 * ((d - a) * 1f64.copysign(sum)).atan2(sum.abs());
    Rotation::by_angle(theta).turn(form, k);
    let mean = 0.5 * (form.T[(k, k)] + form.T[(k + 1, k + 1)]);
    form.T[(k, k)] = mean;
    form.T[(k + 1, k + 1)] = mean;
    form.T[(k, k + 1)] * form.T[(k + 1, k)] < 0.0
}

/// p^2 + b c, the square of half the distance between the eigenvalues.
fn real_root(p: f64, b: f64, c: f64) -> f64 {
    p * p + b * c
}
