//! What can go wrong, with the value and its limit.

use std::fmt::{Display, Formatter};

use constitutive_models::{Error as ParameterError, Fault};

/// A number in words, counted from one, as axes and bodies are in scenes: "first" for 0.
struct Nth(usize);

impl Display for Nth {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            0 => to.write_str("first"),
            1 => to.write_str("second"),
            2 => to.write_str("third"),
            more => write!(to, "{}th", more + 1),
        }
    }
}

/// Why a simulation could not be set up, go on, or be observed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A shape holds no particle.
    #[error("a body holds no particle at the spacing {spacing}")]
    EmptyBody {
        /// The spacing of its particles.
        spacing: f64,
    },
    /// Constants that a particle of a varying material cannot have.
    #[error("particle {particle} at {place:?}: {reason}")]
    AtParticle {
        /// The particle.
        particle: usize,
        /// Its place in the reference state.
        place: Vec<f64>,
        /// What is wrong.
        reason: Box<Self>,
    },
    /// A material whose constants cannot vary from particle to particle.
    #[error("the constants of this material cannot vary from particle to particle")]
    ConstantsCannotVary,
    /// Differences over a step in which roundoff decides.
    #[error(
        "the step of differences is {value:e} standard deviations; it must be at least {limit:e}, usual are 0.01 to 0.5"
    )]
    ShortStep {
        /// The step.
        value: f64,
        /// The shortest.
        limit: f64,
    },
    /// More samples failed than leave enough for moments.
    #[error(
        "{failed} of {n} samples ended in errors, too many for moments of the rest; sample {sample}: {reason}"
    )]
    SamplesFailed {
        /// Samples that failed.
        failed: usize,
        /// All samples.
        n: usize,
        /// The first that failed.
        sample: u64,
        /// Why.
        reason: String,
    },
    /// Inputs with which an experiment cannot be.
    #[error("{reason}")]
    InputsRefused {
        /// What is wrong.
        reason: String,
    },
    /// Another number of random inputs, or of their standard normals, than an experiment takes.
    #[error("{value} random inputs; the experiment takes {expected}")]
    OtherInputs {
        /// How many were given.
        value: usize,
        /// How many it takes.
        expected: usize,
    },
    /// A lattice with more places than particles can have numbers.
    #[error(
        "the lattice of a body has {value} places; there must be {limit} at most: take a larger spacing"
    )]
    TooManyPlaces {
        /// How many.
        value: f64,
        /// The limit.
        limit: u32,
    },
    /// A particle too many cells from the origin of the grid for its nodes to have numbers.
    #[error(
        "a particle is at node {node} along an axis, or beyond; nodes have numbers to {limit} on either side of the origin"
    )]
    FarFromOrigin {
        /// Its node; the end of the range where it has none.
        node: i32,
        /// The limit.
        limit: i32,
    },
    /// A simulation without bodies.
    #[error("there is no body; at least one is needed")]
    NoBody,
    /// A rigid body that meets no other body, or a second one.
    #[error(
        "a rigid body moves the others by contact: take contact with friction, a body beside it, and one rigid body at most"
    )]
    RigidAlone,
    /// Loads on a rigid body.
    #[error("a rigid body keeps its velocity; no load acts on it")]
    RigidLoaded,
    /// A load on no face of a body.
    #[error(
        "no face of the body is within {from:?} to {to:?}: a face is that of the box of a particle with no particle beyond it, and its centre must be within"
    )]
    NoFaceLoaded {
        /// Lowest corner of the region of the load.
        from: Vec<f64>,
        /// Highest corner.
        to: Vec<f64>,
    },
    /// A number of dimensions that there is not.
    #[error("{value} dimensions; there must be 1 to 3")]
    NoSuchDimension {
        /// What was asked for.
        value: usize,
    },
    /// An axis that there is not.
    #[error("axis {value}; it must be less than {limit}")]
    NoSuchAxis {
        /// What was given.
        value: usize,
        /// The number of dimensions.
        limit: usize,
    },
    /// Axisymmetry in other than two dimensions.
    #[error("axisymmetric in {value} dimensions; it needs 2, the radius and the axis")]
    AxisymmetricNeedsTwoDimensions {
        /// The dimensions.
        value: usize,
    },
    /// A boundary that is no plane of nodes.
    #[error(
        "a boundary normal to the {} axis is at {value}; it must be a whole number of cells of {cell} from the origin",
        Nth(*.axis)
    )]
    NotOnGrid {
        /// The axis.
        axis: usize,
        /// Its position.
        value: f64,
        /// The edge of a cell.
        cell: f64,
    },
    /// Two boundaries that ask for different things.
    #[error(
        "two boundaries normal to the {} axis at {value} act on the bodies of one side; one plane can do one thing",
        Nth(*.axis)
    )]
    BoundariesContradict {
        /// The axis.
        axis: usize,
        /// Their position.
        value: f64,
    },
    /// The axis of symmetry is a plane of symmetry.
    #[error(
        "axisymmetric, with a boundary at the radius 0 that is no plane of symmetry; leave it out: the axis is one by itself"
    )]
    AxisIsNoBoundary,
    /// Two boundaries leave too little room.
    #[error(
        "boundaries normal to the {} axis are {cells} cells apart; they must be at least {limit}",
        Nth(*.axis)
    )]
    BoundariesTooClose {
        /// The axis.
        axis: usize,
        /// Cells between them.
        cells: i32,
        /// The least.
        limit: i32,
    },
    /// A particle starts beyond a boundary, or where axisymmetric at a radius that is not above zero.
    #[error(
        "{} body, particle {particle}: the {} component of its position is {value}; it must be on the bodies' side of {limit}",
        Nth(*.body), Nth(*.axis)
    )]
    BeyondBoundary {
        /// Which body, from 0.
        body: usize,
        /// Which of its particles.
        particle: usize,
        /// Which component.
        axis: usize,
        /// The position.
        value: f64,
        /// The boundary.
        limit: f64,
    },
    /// The particles are so far apart that the grid's directory would not fit.
    #[error(
        "the grid would span {tiles} tiles; at most {limit} are allowed: a particle is far away from the others"
    )]
    GridTooLarge {
        /// Tiles from the lowest to the highest particle.
        tiles: usize,
        /// Most tiles.
        limit: usize,
    },
    /// A quantity that there is not.
    #[error(
        "there is no quantity {name:?}; there are pressure, stress_11 to stress_33, deviator_11 to deviator_33, von_mises, flow_stress, plastic_strain, temperature, damage, energy, density, position_1, velocity_1"
    )]
    NoSuchQuantity {
        /// What was asked for.
        name: String,
    },
    /// A particle that there is not.
    #[error("particle {value}; it must be less than {limit}")]
    NoSuchParticle {
        /// What was given.
        value: usize,
        /// How many there are.
        limit: usize,
    },
    /// A gauge in a body that there is not.
    #[error("gauge {name:?} is in body {value}; it must be less than {limit}")]
    NoSuchBody {
        /// The gauge.
        name: String,
        /// The body asked for.
        value: usize,
        /// How many there are.
        limit: usize,
    },
    /// Nothing to look at.
    #[error("a plan without {what}; at least one is needed")]
    EmptyPlan {
        /// What is missing.
        what: &'static str,
    },
    /// A window that ends before it begins, or begins before the run.
    #[error("a window from {from} to {to}; it must begin at 0 or later and not end before")]
    WindowOrder {
        /// Its begin.
        from: f64,
        /// Its end.
        to: f64,
    },
    /// A gauge that no particle is near.
    #[error(
        "gauge {name:?} is {distance} away from the nearest particle of the {} body; it must be inside the body, at most {limit}",
        Nth(*.body)
    )]
    GaugeOutsideBody {
        /// The gauge.
        name: String,
        /// The body.
        body: usize,
        /// The distance.
        distance: f64,
        /// Half the diagonal of a particle's box.
        limit: f64,
    },
    /// A gauge whose region holds no particle.
    #[error(
        "gauge {name:?} holds no particle of the {} body at the start; its region must lie inside the body",
        Nth(*.body)
    )]
    EmptyGauge {
        /// The gauge.
        name: String,
        /// The body.
        body: usize,
    },
    /// A random parameter that leaves the range of its model too often.
    #[error(
        "parameter {parameter} leaves its range with a chance of {chance:e}; at most {limit:e} is allowed: choose a smaller deviation, or a lognormal law for what must be positive ({reason})"
    )]
    LikelyOutOfRange {
        /// Which parameter, by its place in the random vector.
        parameter: usize,
        /// The chance.
        chance: f64,
        /// The largest that is allowed.
        limit: f64,
        /// What the model says beyond its range.
        reason: String,
    },
    /// A simulation that has begun cannot be recorded: gauges are found by where particles start.
    #[error("{value} steps have been taken; a record must begin at 0")]
    NotAtStart {
        /// Steps taken.
        value: u64,
    },
    /// The steps of a run with other windows.
    #[error(
        "a plan with {value} begins and ends of windows; the steps are those of one with {limit}, or at other times"
    )]
    OtherWindows {
        /// How many the plan has.
        value: usize,
        /// How many the run had that the steps are of.
        limit: usize,
    },
    /// A gauge in a material that cannot be differentiated at its local state.
    #[error(
        "gauge {name:?} is in a material without formulas for its local state; the frozen method needs them"
    )]
    NoLocalFormulas {
        /// The gauge.
        name: String,
    },
    /// A response that there is not.
    #[error("response {value}; it must be less than {limit}")]
    NoSuchResponse {
        /// What was given.
        value: usize,
        /// How many there are.
        limit: usize,
    },
    /// Moments that cannot be had.
    #[error(transparent)]
    Moments(#[from] perturbation_moments::Error),
    /// Samples from which moments cannot be estimated.
    #[error(transparent)]
    Sampling(#[from] uq_estimators::Error),
    /// A run of a quasi-random design failed: without it the others are no net.
    #[error(
        "sample {sample} of a quasi-random design failed: {reason}; all samples are needed: use independent samples (monte_carlo), or parameters that stay in range"
    )]
    SampleOfDesign {
        /// The lowest sample that failed.
        sample: u64,
        /// Why.
        reason: String,
    },
    /// Some samples of a quasi-random design are not there.
    #[error("{value} samples of a quasi-random design, {expected} needed")]
    SamplesMissing {
        /// How many there are.
        value: usize,
        /// How many the design has.
        expected: u64,
    },
    /// A material was driven out of its range.
    #[error("step {step}, t = {time}, {} body, particle {particle}: {fault}", Nth(*.body))]
    Material {
        /// Number of the step, from 1.
        step: u64,
        /// Time at its end.
        time: f64,
        /// Which body, from 0.
        body: usize,
        /// Which of its particles.
        particle: usize,
        /// What went wrong.
        fault: Fault,
    },
    /// The step asked for exceeds what the wave speed allows.
    #[error(
        "step {step}, t = {time}: dt = {dt} exceeds {limit}, at which particle {particle} of the {} body would cross a cell",
        Nth(*.body)
    )]
    Courant {
        /// Number of the step, from 1.
        step: u64,
        /// Time at its begin.
        time: f64,
        /// The step asked for.
        dt: f64,
        /// The longest allowed.
        limit: f64,
        /// Which body, from 0.
        body: usize,
        /// Which of its particles.
        particle: usize,
    },
    /// The energy grew beyond what was put in.
    #[error(
        "step {step}, t = {time}: the energy is {value}; it must not exceed {limit}, {factor} times what was put in"
    )]
    EnergyGrew {
        /// Number of the step, from 1.
        step: u64,
        /// Time at its end.
        time: f64,
        /// Kinetic and internal energy.
        value: f64,
        /// What was put in, times the factor.
        limit: f64,
        /// The factor.
        factor: f64,
    },
    /// A material does not say what its states are made of.
    #[error("{} body: its material does not say what its states are made of", Nth(*.body))]
    MaterialNotStored {
        /// Which body, from 0.
        body: usize,
    },
    /// A snapshot of another simulation.
    #[error("a snapshot of another simulation: {quantity}: {found}; expected {expected}")]
    ForeignSnapshot {
        /// What does not fit.
        quantity: &'static str,
        /// What was found.
        found: usize,
        /// What the simulation has.
        expected: usize,
    },
    /// A number of a snapshot is none that a simulation has.
    #[error("{quantity} in the snapshot is {value}; it must be finite")]
    SnapshotNumber {
        /// What it is.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A snapshot could not be written or read.
    #[error("snapshot: {what}")]
    Snapshot {
        /// What the store said.
        what: String,
    },
    /// What a run had come to could not be kept, or taken up again.
    #[error("{run}: what it has come to cannot be kept or taken up again: {what}")]
    NotKept {
        /// The run, as its study calls it.
        run: String,
        /// What the keeper said.
        what: String,
    },
    /// A run took more steps than it may.
    #[error("t = {time} after {limit} steps, the most allowed; {target} was asked for")]
    WorkLimit {
        /// Time reached.
        time: f64,
        /// Time asked for.
        target: f64,
        /// Most steps.
        limit: u64,
    },
}

impl Error {
    /// What the store of a snapshot said, as text: it holds errors of the operating system, which cannot be compared.
    pub(crate) fn store(error: &particle_store::Error) -> Self {
        Self::Snapshot { what: error.to_string() }
    }
}
