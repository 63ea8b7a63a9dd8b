//! What a simulation needs to know besides its bodies.

use crate::body::BulkViscosity;
use crate::boundary::Boundary;
use crate::error::{Error, finite, not_negative, positive, within};
use crate::shape::Shape;

/// When the stress is brought up to date (Bardenhagen 2002; Sulsky, Zhou & Schreyer 1995).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpdateOrder {
    /// Update stress first: from the velocities at the begin of the step.
    StressFirst,
    /// Update stress last: from the velocities that the nodes have at the end.
    StressLast,
    /// Modified update stress last: from what the particles, already accelerated, give to the nodes once more.
    ModifiedStressLast,
}

/// How velocities go from nodes to particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transfer {
    /// Particles take the change of the nodes' velocity (FLIP, Brackbill & Ruppel 1986), and go over to the velocity itself
    /// (PIC) at a rate: the share of FLIP in a step is `exp(-dt/damping_time)`, so that halving the step changes nothing. An
    /// infinite time is FLIP alone.
    Flip {
        /// The time (time); above zero, infinite for none.
        damping_time: f64,
    },
    /// Particles take the velocity and its gradient (APIC, Jiang et al. 2015): angular momentum is kept.
    Apic,
}

/// What two dimensions stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Geometry {
    /// Cartesian: uniaxial strain in one dimension, plane strain in two.
    Cartesian,
    /// Two dimensions only: the first axis is the radius, the second the axis of symmetry. Masses are per radian.
    Axisymmetric,
}

/// What a simulation needs to know besides its bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Config<const D: usize> {
    /// The edge `h` of a grid cell (length).
    pub cell: f64,
    /// A node of the grid (length).
    pub origin: [f64; D],
    /// The shape function.
    pub shape: Shape,
    /// When the stress is updated.
    pub update_order: UpdateOrder,
    /// How velocities come back.
    pub transfer: Transfer,
    /// Cartesian or axisymmetric.
    pub geometry: Geometry,
    /// The bulk viscosity.
    pub viscosity: BulkViscosity,
    /// `C` of `dt = C h / (abs v + sqrt(Q^2 + c^2) + Q)`, with the wave speed `c` and `Q` that of the bulk viscosity.
    pub courant_number: f64,
    /// Acceleration of all particles (length per time squared).
    pub gravity: [f64; D],
    /// Planes at which the motion is prescribed.
    pub boundaries: Vec<Boundary>,
    /// The energy may not exceed this many times the largest that the run has had reason for: that of the start.
    pub most_energy_growth: f64,
    /// Most steps that a run may take.
    pub most_steps: u64,
}

impl<const D: usize> Config<D> {
    /// The usual choice: modified update stress last with quadratic B-splines, FLIP alone, bulk viscosity 1.5 and 0.06,
    /// Courant number 0.4, no boundaries. It keeps energy. For shocks it is a poor one: behind that of a plate impact the
    /// pressure ripples by 10 %, and its carried derivative is off by up to 70 %; APIC with a linear viscosity of 1, or FLIP
    /// that damps, is right within a few per cent (see the crate's page).
    #[must_use]
    pub fn with_cell(cell: f64) -> Self {
        Self {
            cell,
            origin: [0.0; D],
            shape: Shape::QuadraticBSpline,
            update_order: UpdateOrder::ModifiedStressLast,
            transfer: Transfer::Flip { damping_time: f64::INFINITY },
            geometry: Geometry::Cartesian,
            viscosity: BulkViscosity { quadratic: 1.5, linear: 0.06 },
            courant_number: 0.4,
            gravity: [0.0; D],
            boundaries: vec![],
            most_energy_growth: 1.2,
            most_steps: 1_000_000,
        }
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
        not_negative("quadratic bulk viscosity", self.viscosity.quadratic)?;
        not_negative("linear bulk viscosity", self.viscosity.linear)?;
        within("courant_number", self.courant_number, f64::MIN_POSITIVE, 1.0)?;
        within("most_energy_growth", self.most_energy_growth, 1.0, f64::MAX)?;
        if let Transfer::Flip { damping_time } = self.transfer
            && (damping_time.is_nan() || damping_time <= 0.0)
        {
            return Err(Error::NotPositive { name: "damping_time", value: damping_time });
        }
        if self.geometry == Geometry::Axisymmetric && D != 2 {
            return Err(Error::AxisymmetricNeedsTwoDimensions { value: D });
        }
        Ok(())
    }
}
