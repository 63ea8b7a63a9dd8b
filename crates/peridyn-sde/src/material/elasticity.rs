//! From constants of the material to constants of its bonds.

use std::f64::consts::PI;

use crate::error::{Error, positive};

/// The weight `omega(q)` of a bond by its length over the horizon, `q = r/delta`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Influence {
    /// 1.
    Constant,
    /// `1 - q`.
    Conical,
    /// `(1 - q^2)^2`.
    Quartic,
}

impl Influence {
    /// Every one, for tests and tables.
    pub const ALL: [Self; 3] = [Self::Constant, Self::Conical, Self::Quartic];

    /// `omega(q)`, zero beyond the horizon.
    #[must_use]
    pub fn weight(self, q: f64) -> f64 {
        if q > 1.0 {
            return 0.0;
        }
        match self {
            Self::Constant => 1.0,
            Self::Conical => 1.0 - q,
            Self::Quartic => (1.0 - q * q).powi(2),
        }
    }

    /// `int_0^1 omega(q) q^k dq`.
    #[must_use]
    pub fn moment(self, k: u32) -> f64 {
        let power = |p: u32| 1.0 / f64::from(k + p + 1);
        match self {
            Self::Constant => power(0),
            Self::Conical => power(0) - power(1),
            Self::Quartic => power(0) - 2.0 * power(2) + power(4),
        }
    }
}

/// Elastic condition of a body in one, two or three dimensions. Bonds of a pair potential fix Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Condition {
    /// A bar of the cross-section `area` (length squared).
    Bar {
        /// The cross-section.
        area: f64,
    },
    /// A plate, free to contract across; Poisson's ratio 1/3.
    PlaneStress {
        /// Its thickness (length).
        thickness: f64,
    },
    /// A slice of a long body; Poisson's ratio 1/4.
    PlaneStrain {
        /// Its thickness (length).
        thickness: f64,
    },
    /// Three dimensions; Poisson's ratio 1/4.
    Solid,
}

impl Condition {
    /// How many dimensions it has.
    #[must_use]
    pub fn dimension(self) -> usize {
        match self {
            Self::Bar { .. } => 1,
            Self::PlaneStress { .. } | Self::PlaneStrain { .. } => 2,
            Self::Solid => 3,
        }
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Bar { .. } => "a bar",
            Self::PlaneStress { .. } => "plane stress",
            Self::PlaneStrain { .. } => "plane strain",
            Self::Solid => "a solid",
        }
    }

    /// What a length, an area or a volume is to be multiplied by to be a volume: cross-section, thickness, one.
    #[must_use]
    pub fn across(self) -> f64 {
        match self {
            Self::Bar { area } => area,
            Self::PlaneStress { thickness } | Self::PlaneStrain { thickness } => thickness,
            Self::Solid => 1.0,
        }
    }

    /// Poisson's ratio that bonds give; zero for a bar, which knows none.
    #[must_use]
    pub fn poisson_ratio(self) -> f64 {
        match self {
            Self::Bar { .. } => 0.0,
            Self::PlaneStress { .. } => 1.0 / 3.0,
            Self::PlaneStrain { .. } | Self::Solid => 0.25,
        }
    }

    /// The strain energy density of a uniform extension `s` along all axes, over `E s^2`:
    /// `1/2`, `1/(1 - nu)`, `1/((1 + nu)(1 - 2 nu))`, `3/(2 (1 - 2 nu))`.
    #[must_use]
    pub fn energy_of_extension(self) -> f64 {
        match self {
            Self::Bar { .. } => 0.5,
            Self::PlaneStress { .. } => 1.5,
            Self::PlaneStrain { .. } => 1.6,
            Self::Solid => 3.0,
        }
    }

    /// The strain energy density of a strain `s` along one axis with none across, over `E s^2`:
    /// `(1 - nu)/(2 (1 + nu)(1 - 2 nu))`, in plane stress `1/(2 (1 - nu^2))`, for a bar `1/2`.
    #[must_use]
    pub fn energy_of_uniaxial_strain(self) -> f64 {
        match self {
            Self::Bar { .. } => 0.5,
            Self::PlaneStress { .. } => 0.5625,
            Self::PlaneStrain { .. } | Self::Solid => 0.6,
        }
    }

    pub(crate) fn check(self) -> Result<(), Error> {
        match self {
            Self::Bar { area } => positive("cross-section", area),
            Self::PlaneStress { thickness } | Self::PlaneStrain { thickness } => {
                positive("thickness", thickness)
            }
            Self::Solid => Ok(()),
        }
    }
}

/// The constant of micro-elastic bonds: the force of a bond of length `r` stretched by `s` is `c omega(r/delta) s` for each
/// unit of volume at both ends, its energy `c omega r s^2/2`.
///
/// The energy of all bonds of a point inside the body under a uniform extension is that of the elastic body,
///
/// $$ \frac{1}{2} \int_{|\xi| < \delta} \frac{1}{2} c  \omega  |\xi| s^2   dV = w E s^2 , $$
///
/// with `w` of [`Condition::energy_of_extension`]. For a constant weight that is `2 E/(A delta^2)` for a bar,
/// `9 E/(pi t delta^3)` in plane stress, `48 E/(5 pi t delta^3)` in plane strain and `18 K/(pi delta^4)` in three dimensions
/// (Silling & Askari 2005, eq 25; the others as in Bobaru et al. 2016), with the cross-section `A` and the thickness `t`.
///
/// `young_modulus` (stress), `horizon` (length); the result is a force over length to the sixth.
///
/// # Errors
/// [`Error::Parameter`].
pub fn micromodulus(
    young_modulus: f64,
    horizon: f64,
    influence: Influence,
    condition: Condition,
) -> Result<f64, Error> {
    positive("Young's modulus", young_modulus)?;
    positive("horizon", horizon)?;
    condition.check()?;
    let (surface, power) = sphere(condition);
    let moment = influence.moment(power) * horizon.powi(signed(power) + 1);
    let energy = condition.energy_of_extension() * young_modulus;
    Ok(4.0 * energy / (surface * condition.across() * moment))
}

/// The stretch at which bonds break, so that a crack takes the energy `G0` for each unit of its area:
///
/// $$ G_0 = s_0^2 c \kappa \int_0^\delta \omega \xi^{D+1} d\xi , $$
///
/// all bonds across a plane, with `kappa = A/2`, `t`, `pi/2` in one, two and three dimensions (Silling & Askari 2005, eq 26-27,
/// with the weight kept). For a constant weight: `sqrt(5 G0/(6 E delta))` in three dimensions, `sqrt(4 pi G0/(9 E delta))` in
/// plane stress, `sqrt(5 pi G0/(12 E delta))` in plane strain.
///
/// `energy_release_rate` `G0` (energy over area), `young_modulus` (stress), `horizon` (length).
///
/// # Errors
/// [`Error::Parameter`].
pub fn critical_stretch(
    energy_release_rate: f64,
    young_modulus: f64,
    horizon: f64,
    influence: Influence,
    condition: Condition,
) -> Result<f64, Error> {
    positive("energy release rate", energy_release_rate)?;
    let c = micromodulus(young_modulus, horizon, influence, condition)?;
    let (_, power) = sphere(condition);
    let moment = influence.moment(power + 1) * horizon.powi(signed(power) + 2);
    Ok((energy_release_rate / (c * across_plane(condition) * moment)).sqrt())
}

/// `kappa`: a number `f(xi)` of every pair of volumes on both sides of a plane sums to `2 kappa int f xi^D dxi` for each unit of
/// its area.
pub(crate) fn across_plane(condition: Condition) -> f64 {
    match condition {
        Condition::Bar { area } => 0.5 * area,
        Condition::PlaneStress { thickness } | Condition::PlaneStrain { thickness } => thickness,
        Condition::Solid => 0.5 * PI,
    }
}

/// The surface of the unit ball, and the dimension.
pub(crate) fn sphere(condition: Condition) -> (f64, u32) {
    match condition {
        Condition::Bar { .. } => (2.0, 1),
        Condition::PlaneStress { .. } | Condition::PlaneStrain { .. } => (2.0 * PI, 2),
        Condition::Solid => (4.0 * PI, 3),
    }
}

pub(crate) fn signed(power: u32) -> i32 {
    i32::try_from(power).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const E: f64 = 72e9;
    const G0: f64 = 3.8;
    const DELTA: f64 = 3e-3;

    fn near(a: f64, b: f64) {
        assert!((a / b - 1.0).abs() < 1e-14, "{a} {b}");
    }

    #[test]
    fn constants_of_bonds_are_those_of_the_literature() {
        let t = 0.01;
        let of = |condition| micromodulus(E, DELTA, Influence::Constant, condition).unwrap();
        near(of(Condition::Bar { area: t }), 2.0 * E / (t * DELTA.powi(2)));
        near(of(Condition::PlaneStress { thickness: t }), 9.0 * E / (PI * t * DELTA.powi(3)));
        near(of(Condition::PlaneStrain { thickness: t }), 9.6 * E / (PI * t * DELTA.powi(3)));
        // K = E/(3 (1 - 2 nu)) = 2 E/3.
        near(of(Condition::Solid), 18.0 * (2.0 * E / 3.0) / (PI * DELTA.powi(4)));
    }

    #[test]
    fn so_are_critical_stretches() {
        let of =
            |condition| critical_stretch(G0, E, DELTA, Influence::Constant, condition).unwrap();
        let ratio = G0 / (E * DELTA);
        near(of(Condition::Solid), (5.0 * ratio / 6.0).sqrt());
        near(of(Condition::PlaneStress { thickness: 0.01 }), (4.0 * PI * ratio / 9.0).sqrt());
        near(of(Condition::PlaneStrain { thickness: 0.01 }), (5.0 * PI * ratio / 12.0).sqrt());
    }

    #[test]
    fn moments_are_the_integrals_of_the_weight() {
        for influence in Influence::ALL {
            for k in 0..6_u32 {
                // Simpson's rule; the weights are polynomials of degree ten at most.
                let n = 4000;
                let sum: f64 = (0..=n)
                    .map(|i| {
                        let q = f64::from(i) / f64::from(n);
                        let weight = if i == 0 || i == n {
                            1.0
                        } else if i % 2 == 1 {
                            4.0
                        } else {
                            2.0
                        };
                        weight * influence.weight(q) * q.powi(signed(k))
                    })
                    .sum();
                let integral = sum / (3.0 * f64::from(n));
                assert!((integral - influence.moment(k)).abs() < 1e-13, "{influence:?} {k}");
            }
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let plate = Condition::PlaneStress { thickness: -1.0 };
        let error = micromodulus(E, DELTA, Influence::Constant, plate).unwrap_err();
        assert_eq!(error.to_string(), "thickness is -1; it must be greater than 0 and finite");
        assert!(
            critical_stretch(f64::NAN, E, DELTA, Influence::Conical, Condition::Solid).is_err()
        );
        assert!(micromodulus(0.0, DELTA, Influence::Conical, Condition::Solid).is_err());
    }
}
