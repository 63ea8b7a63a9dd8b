//! What a simulation needs to know besides its bodies.

use constitutive_models::{finite, not_negative, positive, within};

use crate::error::Error;
use crate::grid::boundary::{Boundary, BoundaryKind, Side};
use crate::transfer::shape::Shape;

/// How velocities go from nodes to particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transfer {
    /// Particles interpolate the change of the nodal velocity (FLIP, Brackbill & Ruppel 1986): energy is conserved.
    Flip,
    /// Particles interpolate the nodal velocity and its gradient (APIC, Jiang et al. 2015): angular momentum is conserved.
    Apic,
}

/// What two dimensions stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Geometry {
    /// Cartesian: uniaxial strain in one dimension, plane strain in two.
    Cartesian,
    /// Two dimensions only: the first axis is the radius, the second the axis of symmetry. Masses are per radian. The axis is a plane
    /// of symmetry by itself, and so a row of nodes: the origin lies a whole number of cells from it.
    Axisymmetric,
}

/// Interaction of bodies in contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// Bonded: bodies share one velocity on the grid and stick together while they share nodes.
    Bonded,
    /// Frictional contact with separation: each body has its own velocity on the grid (Bardenhagen et al. 2001).
    ///
    /// Two bodies are in contact at a node where all bodies fill the volume around it,
    ///
    /// $$ \sum_b \phi_b \ge 1 - \tfrac{1}{64}, \qquad \phi_b = \sum_{p \in b} V_p N_i(x_p) / h^D, $$
    ///
    /// which is when the gap between flat surfaces has closed; without a gap test bodies meet one to three cells early (Huang,
    /// Zhang, Ma and Huang 2011 test the gap by particles instead). There an impulse stops the approach that forces add, and
    /// another across the normal, at most `coefficient` times as large, acts against their slip. The approach that particles
    /// bring is no impulse: the stress that builds up stops it. Bodies that separate are free. Momentum is conserved within
    /// roundoff. The normal is the difference of the gradients of $\phi$, each weighted by its square.
    Friction {
        /// Coulomb's coefficient, zero or above.
        coefficient: f64,
    },
}

/// Coefficients of the bulk viscosity,
///
/// $$ q = \rho h (q_0 h (\mathrm{tr} L)^2 - q_1 c \mathrm{tr} L), \quad \mathrm{tr} L < 0, $$
///
/// with the cell `h` and the wave speed `c` (von Neumann & Richtmyer 1950; Landshoff 1955). It is zero under expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BulkViscosity {
    /// `q_0 >= 0`, quadratic: spreads strong shocks over a few cells.
    pub quadratic: f64,
    /// `q_1 >= 0`, linear: damps the ripple behind them.
    pub linear: f64,
}

/// Most local damping: with more the force that stops a node lasts, and rest is reached later, not sooner (no unit).
const MOST_DAMPING: f64 = 0.95;

/// What a simulation needs to know besides its bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Config<const D: usize> {
    /// The edge `h` of a grid cell (length).
    pub cell: f64,
    /// A node of the grid (length).
    pub origin: [f64; D],
    /// The shape function.
    pub shape: Shape,
    /// How velocities come back.
    pub transfer: Transfer,
    /// Cartesian or axisymmetric.
    pub geometry: Geometry,
    /// The bulk viscosity.
    pub viscosity: BulkViscosity,
    /// `C` of `dt = C h / (abs v + sqrt(Q^2 + c^2) + Q)`, with the wave speed `c` and `Q` that of the bulk viscosity.
    pub courant_number: f64,
    /// Local damping `a`, from 0 to below 1 (no unit), for loads under which a body comes to rest: at each node the force `f` along
    /// an axis becomes `f - a abs(f) sign(v)` (Cundall 1987). Nothing is damped where forces balance, so that the state at rest is
    /// that without damping; free fall and impact are not.
    pub damping: f64,
    /// Acceleration of all particles (length per time squared).
    pub gravity: [f64; D],
    /// The multiple of `gravity` that acts, as points of time (time) and multiple in ascending order, linear between them and constant
    /// before the first and after the last. Without points it is one.
    pub gravity_history: Vec<[f64; 2]>,
    /// Interaction of bodies in contact.
    pub contact: Contact,
    /// Planes at which the motion is prescribed.
    pub boundaries: Vec<Boundary>,
    /// The energy may not exceed this many times the largest that the run has had reason for: that of the start.
    pub most_energy_growth: f64,
    /// Most steps that a run may take.
    pub most_steps: u64,
}

impl<const D: usize> Config<D> {
    /// The default: quadratic B-splines, FLIP, bulk viscosity 1.5 and 0.06, Courant number 0.4, bodies bonded, no boundaries.
    ///
    /// It conserves energy. For shocks use cubic B-splines with a linear viscosity of 0.3 or more: with the default the pressure
    /// behind a plate impact oscillates by 6 %, and its derivative at an instant is off by a third.
    #[must_use]
    pub fn with_cell(cell: f64) -> Self {
        Self {
            cell,
            origin: [0.0; D],
            shape: Shape::QuadraticBSpline,
            transfer: Transfer::Flip,
            geometry: Geometry::Cartesian,
            viscosity: BulkViscosity { quadratic: 1.5, linear: 0.06 },
            courant_number: 0.4,
            damping: 0.0,
            gravity: [0.0; D],
            gravity_history: vec![],
            contact: Contact::Bonded,
            boundaries: vec![],
            most_energy_growth: 1.2,
            most_steps: 1_000_000,
        }
    }

    /// The acceleration of all particles at a time.
    #[must_use]
    pub fn gravity_at(&self, time: f64) -> [f64; D] {
        let multiple = multiple_at(&self.gravity_history, time);
        self.gravity.map(|along| along * multiple)
    }

    /// The same with the boundary that the axis of symmetry is.
    pub(crate) fn with_axis(mut self) -> Result<Self, Error> {
        if self.geometry == Geometry::Axisymmetric {
            let (side, kind) = (Side::Above, BoundaryKind::Symmetry);
            let is_axis = |of: &&Boundary| of.axis == 0 && of.position == 0.0 && of.side == side;
            match self.boundaries.iter().find(is_axis).map(|of| of.kind) {
                None => self.boundaries.push(Boundary { axis: 0, position: 0.0, side, kind }),
                Some(BoundaryKind::Symmetry) => {}
                Some(_) => return Err(Error::AxisIsNoBoundary),
            }
        }
        Ok(self)
    }

    /// Refuses numbers outside their range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if !(1..=3).contains(&D) {
            return Err(Error::NoSuchDimension { value: D });
        }
        positive("cell", self.cell)?;
        for k in 0..D {
            finite("origin", self.origin[k])?;
            finite("gravity", self.gravity[k])?;
        }
        let names = ["time in gravity_history", "multiple in gravity_history"];
        check_history(names, &self.gravity_history)?;
        not_negative("quadratic bulk viscosity", self.viscosity.quadratic)?;
        not_negative("linear bulk viscosity", self.viscosity.linear)?;
        if let Contact::Friction { coefficient } = self.contact {
            not_negative("friction coefficient", coefficient)?;
        }
        positive("courant_number", self.courant_number)?;
        within("courant_number", self.courant_number, 0.0, 1.0)?;
        within("damping", self.damping, 0.0, MOST_DAMPING)?;
        within("most_energy_growth", self.most_energy_growth, 1.0, f64::MAX)?;
        if self.geometry == Geometry::Axisymmetric && D != 2 {
            return Err(Error::AxisymmetricNeedsTwoDimensions { value: D });
        }
        Ok(())
    }
}

/// The multiple at a time by points of time and multiple: linear between them, constant outside, and one without points.
pub(crate) fn multiple_at(history: &[[f64; 2]], time: f64) -> f64 {
    let after = history.partition_point(|point| point[0] <= time);
    match (after.checked_sub(1), history.get(after)) {
        (None, None) => 1.0,
        (None, Some(first)) => first[1],
        (Some(last), None) => history[last][1],
        (Some(before), Some(next)) => {
            let [from, multiple] = history[before];
            multiple + (next[1] - multiple) * (time - from) / (next[0] - from)
        }
    }
}

/// Refuses points of time and multiple that do not ascend or are not finite, by the names of both.
pub(crate) fn check_history(
    [of_time, of_multiple]: [&'static str; 2],
    history: &[[f64; 2]],
) -> Result<(), Error> {
    let mut from = 0.0;
    for &[time, multiple] in history {
        within(of_time, time, from, f64::MAX)?;
        finite(of_multiple, multiple)?;
        from = time;
    }
    Ok(())
}
