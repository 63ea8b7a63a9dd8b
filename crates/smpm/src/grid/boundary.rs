//! Planes of the grid at which the motion is prescribed.

use constitutive_models::{not_negative, positive};

use crate::error::Error;
use crate::grid::contact::friction_share;
use crate::grid::tile_size::signed;
use crate::number::CarriedNumber;

/// On which side of a plane the bodies are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// At larger coordinates.
    Above,
    /// At smaller coordinates.
    Below,
}

/// What a plane does to the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BoundaryKind {
    /// A plane of symmetry: what is beyond it mirrors what is here.
    Symmetry,
    /// Held: no velocity at the plane, and the mirror image moves the other way.
    Clamped,
    /// A rigid wall: nothing moves into it, everything may leave it.
    ///
    /// With Coulomb friction a node that the wall stops by `dv` along the normal loses at most `friction dv` of its velocity along
    /// the wall (Bardenhagen, Brackbill & Sulsky 2000).
    Rigid {
        /// Coulomb's coefficient, zero or above; zero for a wall without friction.
        friction: f64,
    },
    /// Waves leave through it (Lysmer & Kuhlemeyer 1969): a traction `-rho c v`, with the speeds of longitudinal and of shear
    /// waves of the material there (length per time).
    Absorbing {
        /// Of longitudinal waves.
        longitudinal: f64,
        /// Of shear waves; zero for a fluid.
        shear: f64,
    },
}

/// A plane of the grid. Where none is given the grid has no end: it is allocated where particles are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boundary {
    /// The axis that it is normal to.
    pub axis: usize,
    /// Its coordinate (length): a plane of nodes.
    pub position: f64,
    /// Where the bodies are.
    pub side: Side,
    /// What it does.
    pub kind: BoundaryKind,
}

/// A plane by its node number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    pub(crate) axis: usize,
    pub(crate) node: i32,
    pub(crate) side: Side,
    pub(crate) kind: BoundaryKind,
}

impl Boundary {
    /// The plane of nodes, refused where it is none.
    pub(crate) fn plane(
        &self,
        dimension: usize,
        origin: &[f64],
        cell: f64,
    ) -> Result<Plane, Error> {
        let Self { axis, position, side, kind } = *self;
        if axis >= dimension {
            return Err(Error::NoSuchAxis { value: axis, limit: dimension });
        }
        if let BoundaryKind::Absorbing { longitudinal, shear } = kind {
            positive("longitudinal wave speed of an absorbing boundary", longitudinal)?;
            not_negative("shear wave speed of an absorbing boundary", shear)?;
        }
        if let BoundaryKind::Rigid { friction } = kind {
            not_negative("friction coefficient of a rigid boundary", friction)?;
        }
        let place = (position - origin[axis]) / cell;
        let node = place.round();
        // A coordinate that was computed may miss its node by roundoff.
        if !place.is_finite() || (place - node).abs() > 1e-6 || node.abs() > 1e9 {
            return Err(Error::NotOnGrid { axis, value: position, cell });
        }
        #[allow(clippy::cast_possible_truncation, reason = "checked above")]
        let node = node as i32;
        Ok(Plane { axis, node, side, kind })
    }
}

impl Plane {
    /// How far a node lies beyond the plane, in cells; negative on the bodies' side.
    pub(crate) fn beyond(&self, node: i32) -> i32 {
        match self.side {
            Side::Above => self.node - node,
            Side::Below => node - self.node,
        }
    }

    /// The least and the most that nodes of a box lie beyond the plane: `edge` nodes along each axis from `corner` on.
    pub(crate) fn range_beyond<const D: usize>(
        &self,
        corner: &[i32; D],
        edge: usize,
    ) -> (i32, i32) {
        let first = corner[self.axis];
        let ends = [self.beyond(first), self.beyond(first + signed(edge) - 1)];
        (ends[0].min(ends[1]), ends[0].max(ends[1]))
    }

    /// Whether what is beyond the plane is an image of what is here.
    pub(crate) fn mirrors(&self) -> bool {
        matches!(self.kind, BoundaryKind::Symmetry | BoundaryKind::Clamped)
    }

    /// Whether it changes velocities along itself.
    pub(crate) fn acts_along(&self) -> bool {
        match self.kind {
            BoundaryKind::Symmetry => false,
            BoundaryKind::Rigid { friction } => friction > 0.0,
            BoundaryKind::Clamped | BoundaryKind::Absorbing { .. } => true,
        }
    }

    /// The image of a node.
    pub(crate) fn image(&self, node: i32) -> i32 {
        2 * self.node - node
    }

    /// A vector as the mirror shows it.
    pub(crate) fn mirrored<S: CarriedNumber, const D: usize>(&self, vector: [S; D]) -> [S; D] {
        std::array::from_fn(|k| match self.kind {
            BoundaryKind::Symmetry if k != self.axis => vector[k],
            _ => -vector[k],
        })
    }

    /// Sets the velocity at a node on the plane or beyond it.
    pub(crate) fn constrain<S: CarriedNumber, const D: usize>(
        &self,
        node: i32,
        (dt, cell): (f64, f64),
        velocity: &mut [S; D],
    ) {
        if self.beyond(node) < 0 {
            return;
        }
        let zero = S::constant(0.0);
        match self.kind {
            BoundaryKind::Symmetry => velocity[self.axis] = zero,
            BoundaryKind::Clamped => *velocity = [zero; D],
            BoundaryKind::Rigid { friction } => {
                let inward = match self.side {
                    Side::Above => 1.0,
                    Side::Below => -1.0,
                };
                if velocity[self.axis].value() * inward < 0.0 {
                    let stopped = velocity[self.axis] * -inward;
                    velocity[self.axis] = zero;
                    if friction > 0.0 {
                        let share = friction_share(velocity, stopped, friction);
                        *velocity = velocity.map(|along| along - along * share);
                    }
                }
            }
            BoundaryKind::Absorbing { longitudinal, shear } => {
                // A node of the plane has half a cell behind it: m dv/dt = -2 m c v / h, implicitly.
                for (k, component) in velocity.iter_mut().enumerate() {
                    let speed = if k == self.axis { longitudinal } else { shear };
                    *component = *component / (1.0 + 2.0 * speed * dt / cell);
                }
            }
        }
    }
}
