use crate::Error;
use crate::error::{not_negative, positive};

/// What must be known besides (18) before its four numbers become physical parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Gear ratio K_g, motor turns per turn of the load shaft.
    pub K_g: f64,
    /// Armature resistance R [ohm].
    pub R_ohm: f64,
    /// Viscous friction B_eq at the load shaft [N m s/rad].
    pub B_eq: f64,
    /// Length of the link L [m]. It scales the deflection d = L alpha and the strain; no other figure depends on it.
    pub length_m: f64,
}

impl Drive {
    /// The SRV02 with its flexible link: K_g = 70, R = 2.6 ohm, no viscous friction besides the motor's own, L = 0.419 m.
    ///
    /// Source: DESIGN section 2 for K_g and R; L is the length that the maker states for the link (16.5 inches).
    pub const SRV02: Drive = Drive { K_g: 70.0, R_ohm: 2.6, B_eq: 0.0, length_m: 0.419 };
}

/// Physical parameters of motor, hub and link, referred to the load shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physical {
    /// Inertia of hub, gears and motor [kg m^2].
    pub J_base: f64,
    /// Inertia of the link about the hub's axis [kg m^2].
    pub J_link: f64,
    /// Torsion spring that gives the lumped link its clamped frequency [N m/rad].
    pub K_stiff: f64,
    /// Gear ratio.
    pub K_g: f64,
    /// Motor constant K_b = K_T [V s/rad = N m/A].
    pub K_b: f64,
    /// Armature resistance [ohm].
    pub R_ohm: f64,
    /// Viscous friction at the load shaft [N m s/rad].
    pub B_eq: f64,
    /// Length of the link L [m].
    pub length_m: f64,
}

impl Physical {
    /// The paper's plant (18) on [`Drive::SRV02`].
    ///
    /// Returns K_b = 0.00767563, J_base = 1.924309e-3, K_stiff = 2.041307, J_link = 5.047742e-3.
    /// Source: DESIGN section 2.
    pub fn paper() -> Physical {
        Physical::from_lumped(&Lumped::PAPER, &Drive::SRV02).expect("(18) is the model of a rig")
    }

    /// The parameters whose image under [`Physical::lumped`] is `lumped`.
    ///
    /// b J_base = K_g K/R and c J_base = K_g^2 K^2/R + B_eq determine K = K_b = K_T: the larger root of
    /// (K_g^2/R) K^2 - (c K_g/(b R)) K + B_eq = 0, the one that remains when B_eq = 0.
    ///
    /// Errors: [`Error::Parameter`] for a number that is not positive, [`Error::NoLinkInertia`] for k2 <= k1,
    /// [`Error::TooMuchFriction`] when B_eq is larger than c allows.
    pub fn from_lumped(lumped: &Lumped, drive: &Drive) -> Result<Physical, Error> {
        lumped.check()?;
        drive.check()?;
        let K_b = motor_constant(lumped, drive)?;
        let J_base = drive.K_g * K_b / (lumped.b * drive.R_ohm);
        let K_stiff = lumped.k1 * J_base;
        let J_link = K_stiff / (lumped.k2 - lumped.k1);
        let Drive { K_g, R_ohm, B_eq, length_m } = *drive;
        Ok(Physical { J_base, J_link, K_stiff, K_g, K_b, R_ohm, B_eq, length_m })
    }

    /// k1 = K_stiff/J_base, k2 = K_stiff (1/J_link + 1/J_base), b = K_T K_g/(J_base R),
    /// c = K_T K_b K_g^2/(J_base R) + B_eq/J_base.
    ///
    /// Source: DESIGN section 2.
    pub fn lumped(&self) -> Lumped {
        Lumped {
            k1: self.K_stiff / self.J_base,
            k2: self.K_stiff / self.J_base + self.K_stiff / self.J_link,
            c: self.hub_damping() / self.J_base,
            b: self.torque_per_volt() / self.J_base,
        }
    }

    /// What [`Physical::from_lumped`] needs besides the lumped numbers.
    pub fn drive(&self) -> Drive {
        Drive { K_g: self.K_g, R_ohm: self.R_ohm, B_eq: self.B_eq, length_m: self.length_m }
    }

    /// g = K_g K_T/R, the hub torque at stall per volt [N m/V].
    pub fn torque_per_volt(&self) -> f64 {
        self.K_g * self.K_b / self.R_ohm
    }

    /// c0 = g K_g K_b + B_eq, what opposes the hub's speed [N m s/rad].
    pub fn hub_damping(&self) -> f64 {
        self.torque_per_volt() * self.K_g * self.K_b + self.B_eq
    }

    /// omega_1 = sqrt(K_stiff/J_link), the link's first frequency with the hub held [rad/s].
    pub fn clamped_frequency_rad_s(&self) -> f64 {
        (self.K_stiff / self.J_link).sqrt()
    }

    /// m = 3 J_link/L^2 of a uniform link [kg].
    pub fn link_mass_kg(&self) -> f64 {
        3.0 * self.J_link / (self.length_m * self.length_m)
    }

    /// Errors: [`Error::Parameter`] for the first quantity that no rig can have.
    pub fn check(&self) -> Result<(), Error> {
        self.drive().check()?;
        positive("J_base", "kg m^2", self.J_base)?;
        positive("J_link", "kg m^2", self.J_link)?;
        positive("K_stiff", "N m/rad", self.K_stiff)?;
        positive("K_b", "V s/rad", self.K_b)?;
        Ok(())
    }
}

impl Drive {
    fn check(&self) -> Result<(), Error> {
        positive("gear ratio K_g", "turns per turn", self.K_g)?;
        positive("resistance R", "ohm", self.R_ohm)?;
        not_negative("viscous friction B_eq", "N m s/rad", self.B_eq)?;
        positive("link length L", "m", self.length_m)?;
        Ok(())
    }
}

fn motor_constant(lumped: &Lumped, drive: &Drive) -> Result<f64, Error> {
    let quadratic = drive.K_g * drive.K_g / drive.R_ohm;
    let linear = lumped.c * drive.K_g / (lumped.b * drive.R_ohm);
    let discriminant = linear * linear - 4.0 * quadratic * drive.B_eq;
    if discriminant < 0.0 {
        let largest = linear * linear / (4.0 * quadratic);
        return Err(Error::TooMuchFriction { c: lumped.c, b: lumped.b, B_eq: drive.B_eq, largest });
    }
    Ok((linear + discriminant.sqrt()) / (2.0 * quadratic))
}

/// The four numbers of the lumped model, the pattern of (18).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lumped {
    /// K_stiff/J_base [1/s^2].
    pub k1: f64,
    /// K_stiff (1/J_link + 1/J_base) [1/s^2].
    pub k2: f64,
    /// Damping of the hub [1/s].
    pub c: f64,
    /// Angular acceleration of the hub per volt [rad/s^2/V].
    pub b: f64,
}

impl Lumped {
    /// The numbers printed in (18).
    pub const PAPER: Lumped = Lumped { k1: 1060.8, k2: 1465.2, c: 57.7, b: 107.39 };

    fn check(&self) -> Result<(), Error> {
        positive("k1", "1/s^2", self.k1)?;
        positive("k2", "1/s^2", self.k2)?;
        positive("c", "1/s", self.c)?;
        positive("b", "rad/s^2/V", self.b)?;
        if self.k2 > self.k1 { Ok(()) } else { Err(Error::NoLinkInertia { k1: self.k1, k2: self.k2 }) }
    }
}
