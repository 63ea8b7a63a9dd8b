//! What is looked at: quantities at gauges, at instants or averaged over windows of time.

use std::fmt;
use std::str::FromStr;

use perturbation_moments::Scalar;

use constitutive_models::finite;

use crate::error::Error;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::record::interpolation::linear;
use crate::simulation::Simulation;
use constitutive_models::tensor::von_mises;

/// Names of the axes in those of quantities.
const AXES: [&str; 3] = ["1", "2", "3"];

/// A number that a particle shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// `-tr(sigma)/3`, without the bulk viscosity (stress).
    Pressure,
    /// `sigma_ij`, without the bulk viscosity; axes from 0 (stress).
    Stress(usize, usize),
    /// `S_ij`, its deviator (stress).
    Deviator(usize, usize),
    /// The von Mises stress (stress). At no stress it has no derivative and is a constant zero.
    VonMises,
    /// The present flow stress (stress).
    FlowStress,
    /// The equivalent plastic strain.
    PlasticStrain,
    /// Temperature above that of the reference state (K).
    Temperature,
    /// Damage, from 0 to 1.
    Damage,
    /// Internal energy per reference volume (stress).
    Energy,
    /// Mass per volume.
    Density,
    /// A component of the place; axis from 0 (length).
    Position(usize),
    /// A component of the velocity; axis from 0 (length per time).
    Velocity(usize),
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = |k: usize| AXES.get(k).copied().unwrap_or("?");
        match *self {
            Self::Pressure => f.write_str("pressure"),
            Self::Stress(i, j) => write!(f, "stress_{}{}", axis(i), axis(j)),
            Self::Deviator(i, j) => write!(f, "deviator_{}{}", axis(i), axis(j)),
            Self::VonMises => f.write_str("von_mises"),
            Self::FlowStress => f.write_str("flow_stress"),
            Self::PlasticStrain => f.write_str("plastic_strain"),
            Self::Temperature => f.write_str("temperature"),
            Self::Damage => f.write_str("damage"),
            Self::Energy => f.write_str("energy"),
            Self::Density => f.write_str("density"),
            Self::Position(k) => write!(f, "position_{}", axis(k)),
            Self::Velocity(k) => write!(f, "velocity_{}", axis(k)),
        }
    }
}

impl FromStr for Quantity {
    type Err = Error;

    /// The inverse of [`Display`](fmt::Display): `pressure`, `deviator_11`, `velocity_2`.
    fn from_str(name: &str) -> Result<Self, Error> {
        Self::all()
            .find(|quantity| quantity.to_string() == name)
            .ok_or_else(|| Error::NoSuchQuantity { name: name.to_owned() })
    }
}

impl Quantity {
    /// All quantities.
    pub fn all() -> impl Iterator<Item = Self> {
        const SCALARS: [Quantity; 8] = [
            Quantity::Pressure,
            Quantity::VonMises,
            Quantity::FlowStress,
            Quantity::PlasticStrain,
            Quantity::Temperature,
            Quantity::Damage,
            Quantity::Energy,
            Quantity::Density,
        ];
        let pairs = (0..3).flat_map(|i| (i..3).map(move |j| (i, j)));
        let tensors = pairs.flat_map(|(i, j)| [Self::Stress(i, j), Self::Deviator(i, j)]);
        let vectors = (0..3).flat_map(|k| [Self::Position(k), Self::Velocity(k)]);
        SCALARS.into_iter().chain(tensors).chain(vectors)
    }

    fn check(self, dimension: usize) -> Result<(), Error> {
        let (value, limit) = match self {
            Self::Stress(i, j) | Self::Deviator(i, j) => (i.max(j), 3),
            Self::Position(k) | Self::Velocity(k) => (k, dimension),
            _ => (0, 1),
        };
        if value < limit { Ok(()) } else { Err(Error::NoSuchAxis { value, limit }) }
    }

    /// The quantity of one particle.
    ///
    /// # Errors
    /// [`Error::NoSuchAxis`], [`Error::NoSuchParticle`].
    pub fn of<S: CarriedNumber, const D: usize>(
        self,
        body: &Body<S, D>,
        particle: usize,
    ) -> Result<S, Error> {
        self.check(D)?;
        let limit = body.n_particles();
        if particle >= limit {
            return Err(Error::NoSuchParticle { value: particle, limit });
        }
        Ok(self.read(body, particle))
    }

    pub(crate) fn read<S: CarriedNumber, const D: usize>(
        self,
        body: &Body<S, D>,
        particle: usize,
    ) -> S {
        let stress = || body.stress(particle);
        match self {
            Self::Pressure => body.pressure(particle),
            Self::Stress(i, j) => stress().matrix()[i][j],
            Self::Deviator(i, j) => stress().deviator().matrix()[i][j],
            Self::VonMises => {
                let deviator = stress().deviator();
                if deviator.values().iter().all(|&entry| entry == 0.0) {
                    S::constant(0.0)
                } else {
                    von_mises(&deviator)
                }
            }
            Self::FlowStress => body.observe(particle).flow_stress,
            Self::PlasticStrain => body.observe(particle).plastic_strain,
            Self::Temperature => body.observe(particle).temperature,
            Self::Damage => body.observe(particle).damage,
            Self::Energy => body.observe(particle).energy,
            Self::Density => body.density(particle),
            Self::Position(k) => body.position(particle)[k],
            Self::Velocity(k) => body.velocity(particle)[k],
        }
    }
}

/// Which particles of a body a gauge averages, by where they start: it goes with the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place<const D: usize> {
    /// Those nearest to a point: one, or all that are equally near. On a face between the boxes of particles there are two in
    /// two dimensions, on a corner four. On an interface or a plane of symmetry only the particles of the gauge's own body on
    /// their side count: the gauge then reads half a spacing inside the body.
    Nearest([f64; D]),
    /// All that start inside a box, weighted by their volume: for what is ill-posed at a point, such as the pressure behind
    /// a shock, whose ringing moves with every parameter.
    Region {
        /// The lowest corner.
        from: [f64; D],
        /// The highest corner.
        to: [f64; D],
    },
    /// A point of the lattice between particles, linear between those around it; at a face, by extrapolation over half a spacing.
    /// The same point on every grid: [`Plan::interpolated`].
    Interpolated([f64; D]),
}

/// A place in a body at which quantities are read.
#[derive(Debug, Clone, PartialEq)]
pub struct Gauge<const D: usize> {
    /// How results call it.
    pub name: String,
    /// The number of its body, from 0.
    pub body: usize,
    /// The place of the particles that it reads.
    pub place: Place<D>,
}

/// An instant, where `from` and `to` are equal, or a span of time over which a quantity is averaged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its begin, from 0 (time).
    pub from: f64,
    /// Its end (time).
    pub to: f64,
}

impl Window {
    /// An instant.
    #[must_use]
    pub const fn at(time: f64) -> Self {
        Self { from: time, to: time }
    }
}

/// The plan of outputs: every quantity at every gauge over every window.
///
/// Responses are numbered gauge by gauge, within it quantity by quantity, within it window by window.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan<const D: usize> {
    /// Where quantities are read.
    pub gauges: Vec<Gauge<D>>,
    /// The quantities that are read.
    pub quantities: Vec<Quantity>,
    /// The times of observation.
    pub windows: Vec<Window>,
}

impl<const D: usize> Plan<D> {
    /// How many responses it has.
    #[must_use]
    pub fn n_responses(&self) -> usize {
        self.gauges.len() * self.quantities.len() * self.windows.len()
    }

    /// The number of a response.
    #[must_use]
    pub fn index(&self, gauge: usize, quantity: usize, window: usize) -> usize {
        (gauge * self.quantities.len() + quantity) * self.windows.len() + window
    }

    /// Gauge, quantity and window of a response.
    #[must_use]
    pub fn parts(&self, response: usize) -> (usize, usize, usize) {
        let (windows, quantities) = (self.windows.len().max(1), self.quantities.len().max(1));
        (response / (windows * quantities), response / windows % quantities, response % windows)
    }

    /// The instants at which a run stops to look: begins and ends of windows but zero, ascending, each once.
    #[must_use]
    pub fn stops(&self) -> Vec<f64> {
        stops(self.windows.iter().flat_map(|window| [window.from, window.to]))
    }

    /// The plan for the same bodies on another grid: each gauge at a point reads the mean place of those particles that it reads
    /// in `simulation`, at its start, by interpolation. Gauges of regions keep them.
    ///
    /// # Errors
    /// Those of the plan, as a run of it.
    pub fn interpolated<S: CarriedNumber>(
        &self,
        simulation: &Simulation<S, D>,
    ) -> Result<Self, Error> {
        let located = self.resolve(simulation)?;
        let moved = |(gauge, located): (&Gauge<D>, &Located)| {
            let place = match gauge.place {
                Place::Nearest(_) => {
                    let body = &simulation.bodies()[located.body];
                    let coordinate =
                        |k: usize| located.mean_over(|particle| body.position(particle)[k]);
                    Place::Interpolated(std::array::from_fn(|k| Scalar::value(coordinate(k))))
                }
                place => place,
            };
            Gauge { place, ..gauge.clone() }
        };
        let gauges = self.gauges.iter().zip(&located).map(moved).collect();
        Ok(Self { gauges, ..self.clone() })
    }

    /// Finds the particles of every gauge in a simulation at its start.
    ///
    /// # Errors
    /// [`Error::EmptyPlan`]; [`Error::NoSuchBody`], [`Error::NoSuchAxis`]; [`Error::Parameter`] for a place or a time,
    /// [`Error::WindowOrder`]; [`Error::GaugeOutsideBody`] for a point farther from the nearest particle than half the
    /// diagonal of its box, [`Error::EmptyGauge`] for a region without particles.
    pub(crate) fn resolve<S: CarriedNumber>(
        &self,
        simulation: &Simulation<S, D>,
    ) -> Result<Vec<Located>, Error> {
        let empty = [
            ("gauges", self.gauges.is_empty()),
            ("quantities", self.quantities.is_empty()),
            ("windows", self.windows.is_empty()),
        ];
        if let Some((what, _)) = empty.into_iter().find(|&(_, empty)| empty) {
            return Err(Error::EmptyPlan { what });
        }
        self.quantities.iter().try_for_each(|quantity| quantity.check(D))?;
        for window in &self.windows {
            finite("begin of a window", window.from)?;
            finite("end of a window", window.to)?;
            if !(window.from >= 0.0 && window.to >= window.from) {
                return Err(Error::WindowOrder { from: window.from, to: window.to });
            }
        }
        self.gauges.iter().map(|gauge| gauge.locate(simulation)).collect()
    }
}

/// All instants but zero, ascending, each once.
pub(crate) fn stops(edges: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut stops: Vec<f64> = edges.filter(|&time| time > 0.0).collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    stops
}

/// The particles of a gauge with their weights, which sum to one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Located {
    pub(crate) body: usize,
    pub(crate) particles: Vec<(usize, f64)>,
}

impl Located {
    /// The weighted mean over its particles.
    pub(crate) fn mean_over<T: CarriedNumber>(&self, of: impl Fn(usize) -> T) -> T {
        let zero = T::constant(0.0);
        self.particles.iter().fold(zero, |sum, &(particle, weight)| sum + of(particle) * weight)
    }
}

impl<const D: usize> Gauge<D> {
    fn locate<S: CarriedNumber>(&self, simulation: &Simulation<S, D>) -> Result<Located, Error> {
        let limit = simulation.bodies().len();
        let Some(body) = simulation.bodies().get(self.body) else {
            return Err(Error::NoSuchBody { name: self.name.clone(), value: self.body, limit });
        };
        let starts: Vec<[f64; D]> = body.positions().iter().map(|x| x.map(Scalar::value)).collect();
        let outside = |distance, limit| Error::GaugeOutsideBody {
            name: self.name.clone(),
            body: self.body,
            distance,
            limit,
        };
        let limit = body.half_diagonal();
        // Roundoff of the places of a lattice.
        let slack = 1e-9 * limit;
        let chosen: Vec<usize> = match self.place {
            Place::Nearest(point) | Place::Interpolated(point) => {
                point.iter().try_for_each(|&value| finite("place of a gauge", value))?;
                let distances: Vec<f64> = starts
                    .iter()
                    .map(|x| (0..D).map(|k| (x[k] - point[k]).powi(2)).sum::<f64>().sqrt())
                    .collect();
                let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
                if least > limit + slack {
                    return Err(outside(least, limit));
                }
                if matches!(self.place, Place::Interpolated(_)) {
                    let particles = linear(&starts, body.spacing(), &point);
                    return Ok(Located { body: self.body, particles });
                }
                (0..starts.len()).filter(|&p| distances[p] <= least + slack).collect()
            }
            Place::Region { from, to } => {
                for value in from.iter().chain(&to) {
                    finite("corner of a gauge's region", *value)?;
                }
                let inside = |x: &[f64; D]| (0..D).all(|k| (from[k]..=to[k]).contains(&x[k]));
                (0..starts.len()).filter(|&p| inside(&starts[p])).collect()
            }
        };
        if chosen.is_empty() {
            return Err(Error::EmptyGauge { name: self.name.clone(), body: self.body });
        }
        let volumes: Vec<f64> = chosen.iter().map(|&p| body.reference_volume(p)).collect();
        let total: f64 = volumes.iter().sum();
        let particles = chosen.into_iter().zip(volumes).map(|(p, v)| (p, v / total)).collect();
        Ok(Located { body: self.body, particles })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_is_found_by_its_name_and_no_other() {
        for quantity in Quantity::all() {
            assert_eq!(quantity.to_string().parse::<Quantity>(), Ok(quantity));
        }
        let error = "presure".parse::<Quantity>().unwrap_err().to_string();
        assert!(error.contains("presure") && error.contains("pressure"), "{error}");
    }

    #[test]
    fn responses_are_numbered_one_by_one() {
        let gauge =
            |name: &str| Gauge { name: name.to_owned(), body: 0, place: Place::Nearest([0.0]) };
        let plan = Plan {
            gauges: vec![gauge("a"), gauge("b")],
            quantities: vec![Quantity::Pressure, Quantity::Density, Quantity::Energy],
            windows: vec![Window::at(1.0), Window::at(2.0)],
        };
        for response in 0..plan.n_responses() {
            let (gauge, quantity, window) = plan.parts(response);
            assert_eq!(plan.index(gauge, quantity, window), response);
        }
    }
}
