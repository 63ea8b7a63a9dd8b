//! The force that keeps nodes from passing through each other.

use crate::error::{Error, between, positive};
use crate::resistance::Resistance;
use crate::scheme::{Dynamics, Scheme};

/// Short-range repulsion of all pairs of nodes, bonded or not, so that crack faces that close do not pass through each other.
///
/// With the places `x` at rest, the places `y = x + u`, `r = |y_j - y_i|` and volumes `V`, the energy of a pair and the force on
/// `i` are
///
/// $$ W_{ij} = \frac{c_s}{2 \delta} (d_{ij} - r)^2 V_i V_j, \qquad
///    F_i = \frac{c_s}{\delta} (d_{ij} - r) V_i V_j \frac{y_i - y_j}{r} \qquad (r < d_{ij}), $$
///
/// and zero beyond `d_ij = min(a |x_j - x_i|, b dx)`. With `a < 1` nothing acts at rest; with `a = 0.9` nothing acts in a body
/// whose bonds are all shorter by less than 10 %. Beyond that it stiffens a whole body too.
///
/// Symbols: `c_s` = `stiffness`, `delta` = `horizon`, `a` = `rest_factor`, `b` = `spacing_factor`, `dx` the spacing of the nodes.
///
/// Source: Silling & Askari 2005; Parks, Lehoucq, Plimpton & Silling 2008, whose values [`Repulsion::new`] takes: `c_s = 15 c`,
/// `a = 0.9`, `b = 1.35`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repulsion {
    /// `c_s` (force over length to the sixth), of the kind of [`micromodulus`](crate::micromodulus).
    pub stiffness: f64,
    /// `delta` (length).
    pub horizon: f64,
    /// `a`, between 0 and 1: the part of their distance at rest within which nodes repel each other.
    pub rest_factor: f64,
    /// `b`, above 0: within how many spacings they do at most. Time and memory of a search grow with its power `D`.
    pub spacing_factor: f64,
}

impl Repulsion {
    /// That of the sources, for bonds of the constant `micromodulus` (force over length to the sixth) within a horizon (length).
    ///
    /// ```
    /// use peridyn_sde::{Condition, Influence, Repulsion, micromodulus};
    ///
    /// let plate = Condition::PlaneStress { thickness: 1.0 };
    /// let c = micromodulus(1.0, 3.015, Influence::Constant, plate)?;
    /// let repulsion = Repulsion::new(c, 3.015)?;
    /// // Neighbours along an axis, along a diagonal, and nodes that were far apart.
    /// assert_eq!(repulsion.distance(1.0, 1.0), 0.9);
    /// assert_eq!(repulsion.distance(2_f64.sqrt(), 1.0), 0.9 * 2_f64.sqrt());
    /// assert_eq!(repulsion.distance(20.0, 1.0), 1.35);
    /// # Ok::<(), peridyn_sde::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NotPositive`].
    pub fn new(micromodulus: f64, horizon: f64) -> Result<Self, Error> {
        positive("constant of the bonds", micromodulus)?;
        let stiffness = 15.0 * micromodulus;
        let made = Self { stiffness, horizon, rest_factor: 0.9, spacing_factor: 1.35 };
        made.check()?;
        Ok(made)
    }

    /// `d_ij`, within which two nodes repel each other, of their distance at rest and the spacing of the nodes (lengths).
    #[must_use]
    pub fn distance(&self, rest: f64, spacing: f64) -> f64 {
        (self.rest_factor * rest).min(self.spacing_factor * spacing)
    }

    /// `c_s/delta`: times the volumes of two nodes, their stiffness (force over length to the seventh).
    pub(crate) fn slope(&self) -> f64 {
        self.stiffness / self.horizon
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("stiffness of the repulsion", self.stiffness)?;
        positive("horizon of the repulsion", self.horizon)?;
        between("part of the distance at rest", self.rest_factor, 0.0, 1.0)?;
        positive("number of spacings of the repulsion", self.spacing_factor)
    }

    /// `h (M_i + M_j) k` of a pair of the stiffness `k` that nothing else holds, in inertial dynamics `h^2 (1/m_i + 1/m_j) k`,
    /// and below what it must be: at most this over all pairs, and just this where all nodes are alike. What couples two nodes
    /// in a mobility is left out.
    pub(crate) fn relative_step<T: crate::Real>(
        &self,
        volumes: &[f64],
        resistance: &Resistance<T>,
        dynamics: &Dynamics,
        dt: f64,
    ) -> Result<(f64, f64), Error> {
        let mut softest = 0.0_f64;
        for (node, volume) in volumes.iter().enumerate() {
            softest = softest.max(volume * resistance.largest_of(node, volumes.len())?);
        }
        let largest = volumes.iter().fold(0.0, |most: f64, &volume| most.max(volume));
        let rate = 2.0 * softest * largest * self.slope();
        Ok(match dynamics {
            // The repulsion is explicit in linearly implicit steps too.
            Dynamics::Overdamped { .. } => (dt * rate, Scheme::EulerMaruyama.stability_limit()),
            Dynamics::Inertial { .. } => (dt * dt * rate, 4.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_is_refused() {
        let good = Repulsion::new(2.0, 3.0).unwrap();
        assert!((good.stiffness - 30.0).abs() < 1e-15 && (good.slope() - 10.0).abs() < 1e-15);
        let of = |change: &dyn Fn(&mut Repulsion)| {
            let mut changed = good;
            change(&mut changed);
            changed.check().unwrap_err().to_string()
        };
        assert_eq!(
            of(&|repulsion| repulsion.rest_factor = 1.0),
            "part of the distance at rest is 1; it must lie between 0 and 1"
        );
        assert_eq!(
            of(&|repulsion| repulsion.spacing_factor = f64::INFINITY),
            "number of spacings of the repulsion is inf; it must be greater than 0 and finite"
        );
        assert!(of(&|repulsion| repulsion.stiffness = f64::NAN).contains("NaN"));
        assert!(matches!(Repulsion::new(0.0, 1.0), Err(Error::NotPositive { .. })));
        assert!(matches!(Repulsion::new(1.0, -1.0), Err(Error::NotPositive { .. })));
    }
}
