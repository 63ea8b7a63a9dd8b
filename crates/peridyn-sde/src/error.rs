//! What can go wrong, with the value and its limit.

use std::fmt;

use crate::real::Real;

/// Why a body could not be made, bonded, or loaded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter does not meet its requirement.
    #[error("{name} is {value}; it must {must}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        must: Requirement,
    },
    /// A horizon so short that nodes of a lattice have no bonds.
    #[error("the horizon is {value}; it must be greater than the spacing {spacing} of the nodes")]
    HorizonTooShort {
        /// What was given.
        value: f64,
        /// The spacing.
        spacing: f64,
    },
    /// A horizon that ends where nodes are: which of them it holds is decided by roundoff.
    #[error(
        "the horizon is {value}, which is sqrt({square}) spacings of {spacing}: nodes are at exactly that distance, and \
         roundoff would decide which of them are bonded; {suggestion} has them inside"
    )]
    HorizonOnNodes {
        /// What was given.
        value: f64,
        /// The square of it in spacings.
        square: u64,
        /// The spacing.
        spacing: f64,
        /// A horizon a little longer.
        suggestion: f64,
    },
    /// No node.
    #[error("the body holds no node at the spacing {spacing}")]
    EmptyBody {
        /// The spacing.
        spacing: f64,
    },
    /// A coordinate or a volume of a node cannot be.
    #[error("{name} of node {node} is {value}; it must be {must}")]
    Node {
        /// Which number.
        name: &'static str,
        /// Which node.
        node: usize,
        /// What was given.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Two nodes coincide.
    #[error("nodes {first} and {second} are at the same position; remove one of them")]
    Coincident {
        /// One.
        first: usize,
        /// The other.
        second: usize,
    },
    /// A node without a bond would feel no force.
    #[error("node {node} has no bond within the horizon {horizon}")]
    LooseNode {
        /// Which.
        node: usize,
        /// The horizon.
        horizon: f64,
    },
    /// A column that does not belong to this body.
    #[error("{name} has {value} entries; the body has {expected}")]
    Length {
        /// Which column.
        name: &'static str,
        /// How many it has.
        value: usize,
        /// How many it must have.
        expected: usize,
    },
    /// Fewer of something than are needed.
    #[error("{value} {name}; at least {limit} are needed")]
    TooFew {
        /// Name of the counted things.
        name: &'static str,
        /// How many.
        value: usize,
        /// How many are needed.
        limit: usize,
    },
    /// More of something than are possible.
    #[error("{value} {name}; at most {limit} are possible")]
    TooMany {
        /// Name of the counted things.
        name: &'static str,
        /// How many.
        value: usize,
        /// The limit.
        limit: usize,
    },
    /// A realisation that is there twice.
    #[error("realisation {realisation} is there twice")]
    Doubled {
        /// Which.
        realisation: u64,
    },
    /// A realisation that is not there.
    #[error("realisation {realisation} of {n_realisations} is missing")]
    Missing {
        /// Which.
        realisation: u64,
        /// How many there must be.
        n_realisations: u64,
    },
    /// A realisation of another ensemble.
    #[error("there is no realisation {realisation}: numbers go from 0 to below {limit}")]
    NoSuchRealisation {
        /// Which.
        realisation: u64,
        /// How many there are.
        limit: u64,
    },
    /// Results of another study.
    #[error("{name} is {value}; that of the study is {expected}")]
    Foreign {
        /// Which parameter.
        name: &'static str,
        /// What it is.
        value: f64,
        /// That of the study.
        expected: f64,
    },
    /// A notch that cuts no bond.
    #[error("the notch cuts no bond: it lies outside the body, or does not reach into it")]
    NotchOutsideBody,
    /// Nodes or bonds that are no lattice.
    #[error("{what} of node {node} is not that of a lattice of the spacing {spacing}")]
    NotLattice {
        /// What is not.
        what: &'static str,
        /// Where.
        node: usize,
        /// The spacing.
        spacing: f64,
    },
    /// A body whose state is more than which of its bonds are whole.
    #[error("the bonds of this body remember more than whether they are whole: it cannot be saved")]
    NotSaved,
    /// A saved state after more steps than are counted.
    #[error("a saved state is after {value} steps; at most {limit} are counted")]
    SavedStep {
        /// What was given.
        value: u64,
        /// The most.
        limit: u64,
    },
    /// A saved bond that is whole in a lane that there is not.
    #[error("saved bond {bond} is whole in the lanes {value:#b}; the body has {lanes}")]
    SavedBond {
        /// Which bond.
        bond: usize,
        /// A bit for each lane.
        value: u16,
        /// How many lanes there are.
        lanes: usize,
    },
    /// A displacement that two conditions prescribe.
    #[error("component {component} of node {node} is prescribed twice")]
    PrescribedTwice {
        /// Which node.
        node: usize,
        /// Which component.
        component: usize,
    },
    /// A mobility that couples nodes moves one with a prescribed component, or holds one without.
    #[error(
        "node {node} has a prescribed displacement in some direction and is free in the mobility, or the other way round; a \
         mobility that couples nodes must move the nodes without a prescribed component, and no other"
    )]
    MobilityOfPrescribed {
        /// Which node.
        node: usize,
    },
    /// A step beyond the stable range of its scheme.
    #[error(
        "the step {dt} is {value} in units of the stiffest mode of the body; it must be less than {limit} for the scheme to be stable"
    )]
    Unstable {
        /// The step.
        dt: f64,
        /// `z = h M lambda`, or `(h omega)^2`.
        value: f64,
        /// Below what it must be.
        limit: f64,
    },
    /// A drawn strength that no number holds.
    #[error(
        "realisation {realisation}: the strength of element {element} is {value}; it must be greater than 0 and finite: raise the \
         Weibull modulus"
    )]
    StrengthOfElement {
        /// Which bond, node or block.
        element: usize,
        /// Which realisation.
        realisation: u64,
        /// What was drawn.
        value: f64,
    },
    /// A path that left what numbers can hold.
    #[error(
        "step {step}, time {time}, realisation {realisation}: a displacement of node {node} is {value}"
    )]
    Lost {
        /// Which step, from 1 on.
        step: u64,
        /// The time at its end.
        time: f64,
        /// Which node.
        node: usize,
        /// Which realisation.
        realisation: u64,
        /// What it is.
        value: f64,
    },
    /// A step that has become too long for a body as it is stretched, whose nodes swing about it.
    #[error(
        "step {step}, time {time}, realisation {realisation}: the body swings, most at node {node}: in units of the stiffest mode \
         of the body as it is stretched now the step is {value}, stable is less than {limit}; tension makes bonds stiff across \
         themselves: take a step of less than {dt} times {limit}/{value}, or stretch the body less"
    )]
    Swings {
        /// Which step, from 1 on.
        step: u64,
        /// The time at its end.
        time: f64,
        /// The node that moved farthest in it.
        node: usize,
        /// Which realisation.
        realisation: u64,
        /// `z` of the change over the step, in inertial dynamics `(omega h)^2`.
        value: f64,
        /// The limit of the scheme.
        limit: f64,
        /// The step.
        dt: f64,
    },
    /// A bridge between steps that are not those of a diffusive path.
    #[error(
        "bond failure between steps is undefined for Leimkuhler and Matthews' method, whose steps are averages of the path, and \
         for inertial dynamics; use Theta(0.5), Heun or Euler-Maruyama, or check at the ends of steps only"
    )]
    NoPathBetween,
    /// Conjugate gradients that did not come to an end.
    #[error(
        "step {step}: the linear system of an implicit step was solved to {residual} after {iterations} iterations; {limit} is asked"
    )]
    NotSolved {
        /// Which step, from 1 on.
        step: u64,
        /// The residual over the right-hand side.
        residual: f64,
        /// How many.
        iterations: usize,
        /// What is asked.
        limit: f64,
    },
    /// Equilibrium that was not reached.
    #[error(
        "load {load}: the residual of the equilibrium is {residual:e} of the reaction after {iterations} iterations; {limit:e} is \
         asked: allow more iterations or a larger tolerance, or hold parts that hang by few bonds"
    )]
    NotInEquilibrium {
        /// The load.
        load: f64,
        /// The residual over the reaction.
        residual: f64,
        /// How many.
        iterations: usize,
        /// What is asked.
        limit: f64,
    },
    /// A body that its prescribed displacements do not hold.
    #[error(
        "the stiffness is singular: a part of the body carries load and can move without stretching a bond; prescribe \
         displacements that hold it"
    )]
    SingularStiffness,
    /// Equilibrium event by event under a load of another course.
    #[error(
        "event by event all loads must be proportional to time: Program::Linear, or Program::Constant(0)"
    )]
    NotProportional,
    /// Bonds whose tension is no secant times their stretch.
    #[error(
        "the bonds of this body have no quasi-static equilibrium: their tension must be a secant times the stretch, with a \
         damage by the largest stretch alone, as CriticalStretch and Bilinear have"
    )]
    NotPiecewiseLinear,
    /// Bonds that soften, in steps of the equations of motion.
    #[error(
        "bonds that soften are followed in equilibrium alone: use a quasi-static procedure, or bonds that break at their strength"
    )]
    SofteningInTime,
    /// A law of a uniform stiffness, and one that varies.
    #[error(
        "the stiffness of {law} is uniform; leave its variation out, or use bonds that break at their strength"
    )]
    UniformStiffness {
        /// The law.
        law: &'static str,
    },
    /// A dimension that the conditions of the body do not have.
    #[error("{condition} has {expected} dimensions; the body has {value}")]
    Dimension {
        /// The conditions.
        condition: &'static str,
        /// Those of the body.
        value: usize,
        /// Those of the conditions.
        expected: usize,
    },
    /// A matrix that must be positive definite and is not.
    #[error("the matrix is not positive definite: the pivot of row {row} is not above {limit:e}")]
    NotPositiveDefinite {
        /// The row where the factorisation failed.
        row: usize,
        /// What the pivot must exceed: roundoff.
        limit: f64,
    },
    /// Every node of the body is fixed.
    #[error("none of {n_nodes} nodes is free to move")]
    NoFreeNode {
        /// How many nodes there are.
        n_nodes: usize,
    },
    /// Nodes whose neighbours cannot be found.
    #[error(transparent)]
    Neighbours(#[from] neighbour_search::Error),
    /// A factor of a covariance could not be made.
    #[error(transparent)]
    Factor(#[from] sde_integrators::Error),
    /// A random field, or its correlation.
    #[error(transparent)]
    Field(#[from] random_fields::Error),
}

/// What a parameter must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Requirement {
    /// Finite.
    Finite,
    /// Greater than zero and finite.
    Positive,
    /// Zero or greater, and finite.
    NotNegative,
    /// Between two limits.
    Between {
        /// The lower one.
        from: f64,
        /// The upper one.
        to: f64,
    },
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => f.write_str("be finite"),
            Self::Positive => f.write_str("be greater than 0 and finite"),
            Self::NotNegative => f.write_str("be finite and not below 0"),
            Self::Between { from, to } => write!(f, "lie between {from} and {to}"),
        }
    }
}

impl Requirement {
    /// Refuses a parameter that is not as required.
    pub(crate) fn check(self, name: &'static str, value: f64, is_met: bool) -> Result<(), Error> {
        if is_met { Ok(()) } else { Err(Error::Parameter { name, value, must: self }) }
    }
}

pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    Requirement::Finite.check(name, value, value.is_finite())
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    Requirement::Positive.check(name, value, value.is_finite() && value > 0.0)
}

pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), Error> {
    Requirement::NotNegative.check(name, value, value.is_finite() && value >= 0.0)
}

/// Between the limits, which are excluded.
pub(crate) fn between(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    Requirement::Between { from, to }.check(name, value, value > from && value < to)
}

/// Between the limits, which are included.
pub(crate) fn from_to(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    Requirement::Between { from, to }.check(name, value, (from..=to).contains(&value))
}

pub(crate) fn at_least(name: &'static str, value: usize, limit: usize) -> Result<(), Error> {
    if value < limit { Err(Error::TooFew { name, value, limit }) } else { Ok(()) }
}

pub(crate) fn at_most(name: &'static str, value: usize, limit: usize) -> Result<(), Error> {
    if value > limit { Err(Error::TooMany { name, value, limit }) } else { Ok(()) }
}

pub(crate) fn same_length(name: &'static str, value: usize, expected: usize) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(Error::Length { name, value, expected }) }
}

/// Refuses the number of a node or bond that is not one of so many.
pub(crate) fn exists(name: &'static str, number: usize, count: usize) -> Result<(), Error> {
    if number < count {
        Ok(())
    } else {
        Err(Error::Length { name, value: number, expected: count })
    }
}

/// A number of a node in the precision of the body.
pub(crate) fn node_number<T: Real>(
    name: &'static str,
    node: usize,
    value: f64,
) -> Result<T, Error> {
    let number = T::of(value);
    if number.to_f64().is_finite() {
        Ok(number)
    } else {
        Err(Error::Node { name, node, value, must: "finite in the precision of the body" })
    }
}
