//! What can go wrong, with the value and its limit.

use crate::scheme::Scheme;

/// Errors of constructing, running and observing a simulation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is NaN or infinite.
    #[error("{name} is {value}; it must be finite")]
    NotFinite {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter must be greater than zero.
    #[error("{name} is {value}; it must be greater than 0")]
    NotPositive {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter must not be negative.
    #[error("{name} is {value}; it must be 0 or greater")]
    Negative {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter lies outside an interval.
    #[error("{name} is {value}; it must be from {from} to {to}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The least that is allowed.
        from: f64,
        /// The most that is allowed.
        to: f64,
    },
    /// A table has too few rows.
    #[error("{name} has {count} rows; at least {limit} are needed")]
    TooFewRows {
        /// The table.
        name: &'static str,
        /// How many were given.
        count: usize,
        /// How many are needed.
        limit: usize,
    },
    /// The lattice holds too few particles to carry a density.
    #[error("the lattice holds {count} particles; at least {limit} are needed in {dimension}-D")]
    TooFewParticles {
        /// How many there are.
        count: usize,
        /// How many are needed.
        limit: usize,
        /// The dimension.
        dimension: usize,
    },
    /// A polynomial of this degree has more unknowns than there is room for.
    #[error(
        "a local polynomial of degree {degree} in {dimension}-D has too many unknowns; 2 holds up to 6-D, 3 up to 4-D, 4 up to 3-D"
    )]
    DegreeTooHigh {
        /// The degree asked for.
        degree: usize,
        /// The dimension.
        dimension: usize,
    },
    /// More particles than an id can count.
    #[error("{count} particles requested; ids count at most {limit}: use fewer particles")]
    TooManyParticles {
        /// The number requested.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// The support holds too few lattice neighbours for the estimator, whatever the flow does later.
    #[error(
        "support_radius/spacing is {ratio}: a support holds {count} neighbours of the undisturbed lattice; \
         the fit needs {limit} in {dimension}-D"
    )]
    SupportTooSmall {
        /// `support_radius / spacing`.
        ratio: f64,
        /// Neighbours of an interior particle on the undisturbed lattice, itself excluded.
        count: usize,
        /// How many are needed.
        limit: usize,
        /// The dimension.
        dimension: usize,
    },
    /// A particle has fewer neighbours than the local fit has unknowns.
    #[error(
        "step {step}, t = {time}: particle {particle} has {count} neighbours with itself; the fit has {limit} unknowns"
    )]
    TooFewNeighbours {
        /// Steps taken.
        step: u64,
        /// Time.
        time: f64,
        /// The particle.
        particle: usize,
        /// Its neighbours, itself included.
        count: usize,
        /// Unknowns of the fit.
        limit: usize,
    },
    /// The particles violate the moment equations, so that their density is not that of the system.
    #[error(
        "t = {time}: by the moment equations the standard deviations of the particles are off by {value:.2}, relatively; at most {limit} \
         is allowed: remesh the cloud (`fresh_lattices` in a scene), or take more particles or a larger reach"
    )]
    MomentsViolated {
        /// Time of the observation.
        time: f64,
        /// Relative error of the standard deviations.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// Cells that the estimator cannot resolve hold too much of the probability: what it takes for them from their
    /// neighbours is no longer a density.
    #[error(
        "step {step}, t = {time}: {particles} cells that are not resolved hold a probability of {mass:e}, above {limit:e}; \
         particle {particle} has most of it"
    )]
    TooMuchUnresolved {
        /// Steps taken.
        step: u64,
        /// Time.
        time: f64,
        /// The particle with the largest mass among them.
        particle: usize,
        /// How many there are.
        particles: usize,
        /// The probability that they carry.
        mass: f64,
        /// The most that is allowed.
        limit: f64,
    },
    /// The covariance of the cloud does not span the state space.
    #[error(
        "step {step}, t = {time}: the covariance of the cloud is singular along axis {axis}: \
         relative pivot {pivot:e} is below {limit:e}"
    )]
    SingularCovariance {
        /// Steps taken.
        step: u64,
        /// Time.
        time: f64,
        /// The axis of the failing pivot.
        axis: usize,
        /// The pivot over the variance of that axis.
        pivot: f64,
        /// The limit of that.
        limit: f64,
    },
    /// The Courant rule gives a step that is too small: particles have clumped.
    #[error(
        "step {step}, t = {time}: the step collapsed to {dt:e} at particle {particle}, below {limit:e} (1e-6 of a period)"
    )]
    StepCollapsed {
        /// Steps taken.
        step: u64,
        /// Time.
        time: f64,
        /// The step that the rule asks for.
        dt: f64,
        /// The particle that asks for it.
        particle: usize,
        /// The floor.
        limit: f64,
    },
    /// A fixed step exceeds the diffusion limit.
    #[error(
        "step {step}, t = {time}: the fixed step {dt:e} exceeds the diffusion limit {limit:e} at particle {particle}: \
         lower the step or the particle count, or leave out cells by `negligible`"
    )]
    StepExceedsDiffusionLimit {
        /// Steps taken.
        step: u64,
        /// Time.
        time: f64,
        /// The step.
        dt: f64,
        /// The particle that sets the limit.
        particle: usize,
        /// The largest stable step.
        limit: f64,
    },
    /// An integral over deformed cells needs an estimator that follows the flow map.
    #[error(
        "the estimator follows no flow map, which integrals over cells need: use FlowMapFit, or the indicator or log-interpolated estimate"
    )]
    NoFlowMap,
    /// A scheme needs the linear part of the drift, and the system declares none.
    #[error(
        "the scheme {scheme:?} needs the linear part of the drift, and the system declares none: \
         implement `Sde::linear_part`, or use RungeKutta4"
    )]
    NoLinearPart {
        /// The scheme.
        scheme: Scheme,
    },
    /// A position, velocity or density is no longer finite, or a density is no longer positive.
    #[error("step {step}, t = {time}: {quantity} of particle {particle} is {value}")]
    LeftStableRange {
        /// Steps taken.
        step: u64,
        /// Time.
        time: f64,
        /// The particle.
        particle: usize,
        /// What it is of the particle.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The run took as many steps as it was allowed.
    #[error("t = {time}: {limit} steps taken without reaching t = {target}")]
    WorkLimit {
        /// Time reached.
        time: f64,
        /// The time asked for.
        target: f64,
        /// The limit of steps.
        limit: u64,
    },
    /// A requested time is earlier than that of the simulation, or is not a number.
    #[error(
        "time {value} is requested, but the simulation is at {now}: request this time or a later one"
    )]
    TimeInThePast {
        /// What was asked for.
        value: f64,
        /// The time of the simulation.
        now: f64,
    },
    /// The deformed lattice cell of a particle is undefined: the particle has no lattice neighbour.
    #[error(
        "particle {particle} has no lattice neighbour along some axis, and none of its neighbours has; \
         use the kernel sum for the volumes"
    )]
    NoLatticeCell {
        /// The particle.
        particle: usize,
    },
    /// An index names no component of the state.
    #[error("component {value} was asked for, but the state has {limit}")]
    NoSuchComponent {
        /// What was asked for.
        value: usize,
        /// Components of the state.
        limit: usize,
    },
    /// Edges of bins must increase, and there must be two at least.
    #[error("{count} bin edges, not strictly increasing at {position}")]
    BinEdges {
        /// How many edges were given.
        count: usize,
        /// The first edge that does not exceed the one before it.
        position: usize,
    },
    /// An observer did not record every step of the simulation.
    #[error(
        "the simulation has taken {found} steps, the last one recorded is {recorded}; every step must be recorded"
    )]
    UnwatchedSteps {
        /// Steps at the last record.
        recorded: u64,
        /// Steps now.
        found: u64,
    },
    /// An observer was constructed for another simulation.
    #[error("the simulation holds {found} particles, the watched one {expected}")]
    OtherSimulation {
        /// Particles of the simulation given.
        found: usize,
        /// Particles of the simulation that the observer was constructed for.
        expected: usize,
    },
    /// Remeshing removed the particles that an observer follows.
    #[error(
        "t = {time}: remeshing replaced the observed particles; switch remeshing off for this observer"
    )]
    RemappedUnderWatch {
        /// Time.
        time: f64,
    },
    /// Remeshing needs whitened coordinates.
    #[error("remeshing needs whitened coordinates; the method's metric is isotropic")]
    NotWhitened,
    /// Remeshing needs more particles than allowed.
    #[error("t = {time}: remeshing needs {count} particles or more; {limit} are allowed")]
    RemappingTooLarge {
        /// Time.
        time: f64,
        /// Particles so far.
        count: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// The new lattice does not resolve the density: remeshing changes mass or moments too much.
    #[error(
        "t = {time}: remeshing changes the {quantity} by {value:e}; at most {limit:e} is allowed: take a finer lattice"
    )]
    RemappingChangesMass {
        /// Time.
        time: f64,
        /// Mass, mean, covariance, or explained variance of a filter's output.
        quantity: &'static str,
        /// The change: relative, in standard deviations, of a whitened entry, over the variance of the output, in this order.
        value: f64,
        /// The most that is allowed.
        limit: f64,
    },
    /// Filter states are conditioned out by some methods only.
    #[error("filter states are conditioned out with {must}; the method has {found}")]
    NotConditioned {
        /// What it has in place of it.
        found: String,
        /// What it must have, in words.
        must: &'static str,
    },
    /// Filter states are conditioned out of one normal distribution.
    #[error(
        "filter states are conditioned out of a single normal distribution at the start; this one has {count} components"
    )]
    ConditionedMixture {
        /// Components of the distribution.
        count: usize,
    },
    /// The filter's output has no variance left, given the structure's states.
    #[error(
        "t = {time}: given the structure's states, the filter's output has the variance {value:e} of {whole:e} in all; it must \
         not be negative: use more particles, or the density of all states"
    )]
    NoConditionalVariance {
        /// Time.
        time: f64,
        /// The variance given the structure's states.
        value: f64,
        /// The variance in all.
        whole: f64,
    },
    /// A snapshot is of another simulation.
    #[error("the snapshot holds {found} particles, the simulation {expected}")]
    ForeignSnapshot {
        /// Particles of the snapshot.
        found: usize,
        /// Particles of the simulation.
        expected: usize,
    },
    /// A number of a snapshot is invalid.
    #[error("{quantity} of particle {particle} in the snapshot is {value}; it must be {must}")]
    SnapshotNumber {
        /// What it is.
        quantity: &'static str,
        /// The particle; 0 for what all have in common.
        particle: usize,
        /// Its value.
        value: f64,
        /// What it must be, in words.
        must: &'static str,
    },
    /// A snapshot lacks time and step counts.
    #[error(
        "the snapshot holds no `time`, `n_steps` and `n_remaps`; it is not of a density simulation"
    )]
    SnapshotWithoutTime,
    /// The initial distribution or the system was refused.
    #[error(transparent)]
    Sde(#[from] sde_integrators::Error),
    /// A structure, filter or window was refused.
    #[error(transparent)]
    System(#[from] vibrating_systems::Error),
    /// The neighbour search refused its input.
    #[error(transparent)]
    Neighbours(#[from] neighbour_search::Error),
    /// The store or the lattice refused its input.
    #[error(transparent)]
    Store(#[from] particle_store::Error),
    /// A kernel refused its input.
    #[error(transparent)]
    Kernel(#[from] smoothing_kernels::Error),
}

/// Refuses NaN and infinity.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { name, value }) }
}

/// Refuses what is not finite and greater than zero.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    finite(name, value)?;
    if value > 0.0 { Ok(()) } else { Err(Error::NotPositive { name, value }) }
}

/// Refuses what is not finite and at least zero.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), Error> {
    finite(name, value)?;
    if value >= 0.0 { Ok(()) } else { Err(Error::Negative { name, value }) }
}

/// Refuses what is not from `from` to `to`.
pub(crate) fn within(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    finite(name, value)?;
    if (from..=to).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange { name, value, from, to })
    }
}
