//! A body: particles of one material.

use std::sync::OnceLock;

use crate::error::Error;
use crate::grid::binning::Binning;
use crate::number::CarriedNumber;
use crate::points::compiled_points::Number;
use crate::points::fill::Fill;
use crate::points::material_points::{MaterialPoints, Points};
use crate::points::particles::{Chunk, ParticleNumbers, Particles};
use crate::points::points_in_lanes::PointsInLanes;
use crate::points::surface_load::{Loaded, SurfaceLoad};
use constitutive_models::tensor::Symmetric;
use constitutive_models::{
    LocalResponse, LocalState, Material, MaterialFamily, Model, Observed, Scalar, finite, positive,
};

/// A body: particles of one material, in `D` dimensions, with numbers `S`.
///
/// A particle has the number that its place has in [`Fill::positions`], for good: the output of the body, and errors, are by
/// this number. In memory particles move, so that those of a cell are adjacent.
#[derive(Debug)]
pub struct Body<S, const D: usize> {
    pub(crate) particles: Particles<S, D>,
    pub(crate) points: Box<dyn MaterialPoints<S>>,
    pub(crate) binning: Binning<D>,
    /// Whether it keeps its velocity.
    is_rigid: bool,
    loads: Vec<Loaded<D>>,
    /// The edges of the box of each particle at the start (length).
    spacing: [f64; D],
    /// Where each particle is in memory; empty while all are at their numbers.
    places: Vec<u32>,
    views: Views<S, D>,
}

/// An error in the constants of a particle.
fn at_particle<const D: usize>(particle: usize, place: &[f64; D], reason: Error) -> Error {
    Error::AtParticle { particle, place: place.to_vec(), reason: Box::new(reason) }
}

/// Columns by the numbers of particles, made when asked for.
#[derive(Debug)]
struct Views<S, const D: usize> {
    positions: OnceLock<Vec<[S; D]>>,
    velocities: OnceLock<Vec<[S; D]>>,
    masses: OnceLock<Vec<S>>,
}

impl<S, const D: usize> Views<S, D> {
    fn none() -> Self {
        let (positions, velocities) = (OnceLock::new(), OnceLock::new());
        Self { positions, velocities, masses: OnceLock::new() }
    }

    fn forget(&mut self) {
        *self = Self::none();
    }
}

impl<S: Number, const D: usize> Body<S, D> {
    /// Particles of a material of `constitutive-models`, all with one velocity.
    ///
    /// # Errors
    /// [`Error::EmptyBody`]; [`Error::Parameter`] for a spacing, the density, a place or a velocity.
    pub fn new(
        material: impl Into<Model<S>>,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Self, Error> {
        let (model, plane) = (material.into(), D < 3);
        let density = model.density();
        Self::of(&|_| density, fill, velocity, |places| S::points(&model, plane, places))
    }

    /// Particles of a material whose constants differ from particle to particle, all with one velocity: `material` makes that of
    /// a particle, by its number and place. Density, and so mass, may vary too.
    ///
    /// Bitwise [`new`](Self::new) where all particles have the same constants. Those of linear elasticity, and of Mie-Grüneisen with
    /// von Mises or Johnson-Cook, can vary ([`Model::can_vary`]).
    ///
    /// ```
    /// use smpm::material::{LinearElasticParameters, LinearElasticSolid};
    /// use smpm::{Body, Fill};
    ///
    /// let fill = Fill::of([0.1; 2], ([0.0; 2], [1.0, 1.0]), |_| true)?;
    /// let graded = |_: usize, x: &[f64; 2]| {
    ///     let young_modulus = 1.0 + 0.5 * x[0];
    ///     let parameters = LinearElasticParameters { density: 1.0, young_modulus, poisson_ratio: 0.3 };
    ///     Ok(LinearElasticSolid::linear_elastic(parameters)?)
    /// };
    /// let body = Body::varying(graded, &fill, [0.0; 2])?;
    /// assert_eq!(body.n_particles(), 100);
    /// # Ok::<(), smpm::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::AtParticle`] for constants that a particle cannot have, with the reason;
    /// [`Error::ConstantsCannotVary`] for another material.
    pub fn varying<M: Into<Model<S>>>(
        mut material: impl FnMut(usize, &[f64; D]) -> Result<M, Error>,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Self, Error> {
        let places = fill.checked()?;
        let make = |(particle, place): (usize, &[f64; D])| {
            let refused = |reason| at_particle(particle, place, reason);
            let made: Model<S> = material(particle, place).map_err(refused)?.into();
            positive("density", made.density().value()).map_err(|it| refused(it.into()))?;
            Ok(made)
        };
        let models =
            fill.positions.iter().enumerate().map(make).collect::<Result<Vec<_>, Error>>()?;
        let points =
            S::varying_points(&models, D < 3, &places).ok_or(Error::ConstantsCannotVary)?;
        Self::of(&|particle| models[particle].density(), fill, velocity, |_| points)
    }
}

impl<S: CarriedNumber, const D: usize> Body<S, D> {
    /// Particles of a material from outside, one by one, compiled for the caller.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn one_by_one<M: Material<S, State: 'static> + 'static>(
        material: M,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Self, Error> {
        let density = material.density();
        Self::of(&|_| density, fill, velocity, |places| {
            Box::new(Points::at_start(material, D < 3, places))
        })
    }

    fn of(
        density: &dyn Fn(usize) -> S,
        fill: &Fill<D>,
        velocity: [f64; D],
        points: impl FnOnce(&[[f64; 3]]) -> Box<dyn MaterialPoints<S>>,
    ) -> Result<Self, Error> {
        let places = fill.checked()?;
        for &component in &velocity {
            finite("velocity", component)?;
        }
        positive("density", density(0).value())?;
        Ok(Self {
            particles: Particles::of(fill, velocity, density),
            points: points(&places),
            binning: Binning::of(places.len()),
            is_rigid: false,
            loads: vec![],
            spacing: fill.spacing,
            places: vec![],
            views: Views::none(),
        })
    }

    /// The same as a rigid body: it keeps its velocity whatever it meets, as if its mass were infinite, and neither gravity nor planes
    /// act on it. It has no stress; the wave speed of its material still limits the step.
    ///
    /// A simulation has at most one, beside other bodies, and needs [`Contact::Friction`](crate::Contact::Friction).
    #[must_use]
    pub fn rigid(mut self) -> Self {
        self.is_rigid = true;
        self
    }

    /// The same under loads on its surface.
    ///
    /// # Errors
    /// [`Error::NoFaceLoaded`]; [`Error::Parameter`] for a number that is not finite and for times that do not ascend.
    pub fn loaded(mut self, loads: &[SurfaceLoad<D>]) -> Result<Self, Error> {
        let places = || self.particles.position.iter().map(|x| x.map(Scalar::value));
        let on = |load: &SurfaceLoad<D>| load.on(places(), &self.spacing);
        self.loads = loads.iter().map(on).collect::<Result<_, _>>()?;
        Ok(self)
    }

    /// Whether loads act on it.
    pub(crate) const fn is_loaded(&self) -> bool {
        !self.loads.is_empty()
    }

    /// Its loads per radian.
    pub(crate) fn make_loads_axisymmetric(&mut self) {
        self.loads.iter_mut().for_each(Loaded::make_axisymmetric);
    }

    /// Finds the forces of its loads at a time.
    pub(crate) fn set_forces(&mut self, time: f64) {
        if !self.is_loaded() {
            return;
        }
        let mut force = std::mem::take(&mut self.particles.force);
        force.clear();
        force.resize(self.n_particles(), [0.0; D]);
        for load in &self.loads {
            load.for_each(time, |particle, on_face| {
                let sum = &mut force[self.place(particle)];
                for k in 0..D {
                    sum[k] += on_face[k];
                }
            });
        }
        self.particles.force = force;
    }

    /// The force of its loads in the last step, and their work (energy).
    pub(crate) fn force_and_work(&self) -> ([f64; D], f64) {
        let (mut sum, mut work) = ([0.0; D], 0.0);
        for (force, by) in self.particles.force.iter().zip(&self.particles.displacement) {
            for k in 0..D {
                sum[k] += force[k];
                work += force[k] * by[k].value();
            }
        }
        (sum, work)
    }

    /// Its velocity if it is rigid.
    pub(crate) fn velocity_if_rigid(&self) -> Option<[f64; D]> {
        self.is_rigid.then(|| self.particles.velocity[0].map(Scalar::value))
    }

    /// All particles and their materials, to be written by a pass.
    pub(crate) fn for_pass(&mut self) -> (Chunk<'_, S, D>, &mut dyn MaterialPoints<S>) {
        self.views.forget();
        (self.particles.chunk(&self.binning), &mut *self.points)
    }

    /// Puts the particles into the order of their cells. They are to be binned anew.
    pub(crate) fn sort(&mut self, done: &mut Vec<bool>) {
        let order = self.binning.by_cell();
        self.particles.permute(order, done);
        self.points.permute(order, done);
        self.renumbered();
    }

    /// Calls with a copy of every number of a particle, by its place in memory; whether that is all of it.
    pub(crate) fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        ParticleNumbers::of(&self.particles, place).visit_numbers(visit);
        self.points.show_numbers(place, visit)
    }

    /// The same with the numbers themselves, to be written.
    pub(crate) fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        let mut row = ParticleNumbers::of(&self.particles, place);
        row.visit_numbers(visit);
        row.put(&mut self.particles, place);
        self.points.visit_numbers(place, visit)
    }

    /// To be called when the numbers of the particles have changed places.
    pub(crate) fn renumbered(&mut self) {
        self.find_places();
        self.views.forget();
    }

    /// Notes where each number is in memory.
    fn find_places(&mut self) {
        let number = &self.particles.number;
        self.places.resize(number.len(), 0);
        for (place, &number) in (0_u32..).zip(number) {
            self.places[number as usize] = place;
        }
    }

    /// Where a particle is in memory.
    fn place(&self, particle: usize) -> usize {
        self.places.get(particle).map_or(particle, |&place| place as usize)
    }

    /// A column by the numbers of particles.
    fn by_number<'a, T: Copy>(&self, column: &'a [T], view: &'a OnceLock<Vec<T>>) -> &'a [T] {
        if self.places.is_empty() {
            return column;
        }
        view.get_or_init(|| self.places.iter().map(|&place| column[place as usize]).collect())
    }

    /// Gives every particle the velocity at its place.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a velocity.
    pub fn set_velocities(
        &mut self,
        velocity: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Result<(), Error> {
        let Particles { position, velocity: kept, .. } = &mut self.particles;
        for (place, kept) in position.iter().zip(kept) {
            let value = velocity(&place.map(Scalar::value));
            value.iter().try_for_each(|&component| finite("velocity", component))?;
            *kept = value.map(S::constant);
        }
        Ok(())
    }

    /// How many particles it has.
    #[must_use]
    pub fn n_particles(&self) -> usize {
        self.particles.position.len()
    }

    /// Places (length), by the numbers of particles. The first call after a step gathers all; [`Self::position`] is for few.
    #[must_use]
    pub fn positions(&self) -> &[[S; D]] {
        self.by_number(&self.particles.position, &self.views.positions)
    }

    /// The place of a particle (length).
    #[must_use]
    pub fn position(&self, particle: usize) -> [S; D] {
        self.particles.position[self.place(particle)]
    }

    /// Velocities (length per time), by the numbers of particles; gathered as the positions are.
    #[must_use]
    pub fn velocities(&self) -> &[[S; D]] {
        self.by_number(&self.particles.velocity, &self.views.velocities)
    }

    /// The velocity of a particle (length per time).
    #[must_use]
    pub fn velocity(&self, particle: usize) -> [S; D] {
        self.particles.velocity[self.place(particle)]
    }

    /// Masses, by the numbers of particles; per radian where axisymmetric.
    #[must_use]
    pub fn masses(&self) -> &[S] {
        self.by_number(&self.particles.mass, &self.views.masses)
    }

    /// The stress of a particle, without the bulk viscosity.
    #[must_use]
    pub fn stress(&self, particle: usize) -> Symmetric<S> {
        self.points.conditions().get(self.place(particle)).stress
    }

    /// The pressure of a particle, `-tr(sigma)/3`, without the bulk viscosity.
    #[must_use]
    pub fn pressure(&self, particle: usize) -> S {
        self.stress(particle).trace() * (-1.0 / 3.0)
    }

    /// `V/V_0` of a particle.
    #[must_use]
    pub fn volume_ratio(&self, particle: usize) -> S {
        self.points.conditions().volume[self.place(particle)]
    }

    /// The density of a particle (mass per volume).
    #[must_use]
    pub fn density(&self, particle: usize) -> S {
        let (Particles { mass, .. }, place) = (&self.particles, self.place(particle));
        mass[place] / (self.volume_ratio(particle) * self.reference_volume(particle))
    }

    /// The volume of a particle in the reference state; per radian where axisymmetric.
    pub(crate) fn reference_volume(&self, particle: usize) -> f64 {
        self.particles.reference_volume[self.place(particle)]
    }

    /// The edges of the box of each particle at the start (length).
    pub(crate) const fn spacing(&self) -> [f64; D] {
        self.spacing
    }

    /// Half the diagonal of the box of a particle at the start (length).
    pub(crate) fn half_diagonal(&self) -> f64 {
        0.5 * self.spacing.iter().map(|edge| edge * edge).sum::<f64>().sqrt()
    }

    /// What the material shows of a particle besides its stress.
    #[must_use]
    pub fn observe(&self, particle: usize) -> Observed<S> {
        self.points.observe(self.place(particle))
    }

    /// Pressure and flow stress by the formulas of its material at a state that is taken for certain; `None` where the
    /// material has none.
    #[must_use]
    pub fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>> {
        self.points.at_local_state(state)
    }
}

impl<const D: usize> Body<f64, D> {
    /// As [`one_by_one`](Self::one_by_one), for a material whose text serves several particles at once: bitwise identical, and
    /// faster. Materials of `constitutive-models` are computed so by [`new`](Self::new).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn in_lanes<M: MaterialFamily<f64, State: 'static> + 'static>(
        material: M,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Self, Error> {
        let density = material.density();
        Self::of(&|_| density, fill, velocity, |places| {
            Box::new(PointsInLanes::at_start(material, D < 3, places))
        })
    }

    /// The state of a particle without its history.
    #[must_use]
    pub fn local_state(&self, particle: usize) -> LocalState {
        LocalState {
            volume: self.volume_ratio(particle),
            pressure: self.pressure(particle),
            observed: self.observe(particle),
        }
    }
}
