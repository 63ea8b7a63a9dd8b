//! A body: particles of one material.

use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Fault, finite, positive};
use crate::grid::Binning;
use crate::material::{LocalResponse, LocalState, Material, Now, Observed};
use crate::number::Number;
use crate::parallel::for_each_pair;
use crate::tensor::{Symmetric, volume_change};

/// A body: particles of one material, in `D` dimensions, with numbers `S`.
#[derive(Debug)]
pub struct Body<S, const D: usize> {
    pub(crate) particles: Particles<S, D>,
    pub(crate) constitution: Box<dyn Constitution<S>>,
    pub(crate) bases: Vec<[i32; D]>,
    pub(crate) binning: Binning,
}

/// Where the particles of a body start.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill<const D: usize> {
    /// Their places (length).
    pub positions: Vec<[f64; D]>,
    /// The distance between them along each axis (length); each stands for a box of that size.
    pub spacing: [f64; D],
}

impl<const D: usize> Fill<D> {
    /// Places at the centres of the boxes of a lattice from `low` to `high` that lie inside a shape.
    ///
    /// ```
    /// use smpm::Fill;
    ///
    /// let disk = Fill::of([0.5, 0.5], ([-1.0, -1.0], [1.0, 1.0]), |[x, y]| x * x + y * y < 1.0);
    /// assert_eq!(disk.positions.len(), 12); // of 16, the four corners lie outside
    /// ```
    #[must_use]
    pub fn of(
        spacing: [f64; D],
        (low, high): ([f64; D], [f64; D]),
        inside: impl Fn(&[f64; D]) -> bool,
    ) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of boxes; what is not finite gives none"
        )]
        let count: [usize; D] =
            std::array::from_fn(|k| ((high[k] - low[k]) / spacing[k]).round().max(0.0) as usize);
        let total: usize = count.iter().product();
        let positions = (0..total)
            .map(|index| {
                let mut rest = index;
                std::array::from_fn(|k| {
                    let along = rest % count[k];
                    rest /= count[k];
                    low[k] + (along as f64 + 0.5) * spacing[k]
                })
            })
            .filter(|place| inside(place))
            .collect();
        Self { positions, spacing }
    }
}

/// What every particle carries besides the state of its material.
#[derive(Debug)]
pub(crate) struct Particles<S, const D: usize> {
    pub(crate) position: Vec<[S; D]>,
    pub(crate) velocity: Vec<[S; D]>,
    /// By how much the step moves it.
    pub(crate) displacement: Vec<[S; D]>,
    /// APIC's matrix, or zero.
    pub(crate) affine: Vec<[[S; D]; D]>,
    pub(crate) velocity_gradient: Vec<[[S; 3]; 3]>,
    /// Half its length along each axis (length).
    pub(crate) half_length: Vec<[S; D]>,
    pub(crate) mass: Vec<S>,
    /// Its volume in the reference state; per radian where axisymmetric.
    pub(crate) reference_volume: Vec<f64>,
}

/// What the material made of a particle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Condition<S> {
    /// Cauchy stress with the bulk viscosity.
    pub(crate) stress: Symmetric<S>,
    /// Cauchy stress without it.
    pub(crate) material_stress: Symmetric<S>,
    /// `V/V_0`.
    pub(crate) volume: S,
    /// Speed of a longitudinal wave.
    pub(crate) wave_speed: S,
}

/// Coefficients of the bulk viscosity,
///
/// $$ q = \rho h (q_0 h (\mathrm{tr} L)^2 - q_1 c \mathrm{tr} L), \quad \mathrm{tr} L < 0, $$
///
/// with the cell `h` and the wave speed `c` (von Neumann & Richtmyer 1950; Landshoff 1955). Zero under expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BulkViscosity {
    /// `q_0 >= 0`, quadratic: spreads strong shocks over a few cells.
    pub quadratic: f64,
    /// `q_1 >= 0`, linear: damps the ripple behind them.
    pub linear: f64,
}

/// A material with the states of its particles, whatever their type: the loop over particles sees one material.
pub(crate) trait Constitution<S>: std::fmt::Debug + Send + Sync {
    /// Advances every particle over a step; of several faults, that of the lowest particle.
    fn advance(&mut self, motion: &Motion<'_, S>) -> Result<(), (usize, Fault)>;
    fn conditions(&self) -> &[Condition<S>];
    fn observe(&self, particle: usize) -> Observed<S>;
    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>>;
}

/// What a step does to all particles of a body.
#[derive(Debug)]
pub(crate) struct Motion<'a, S> {
    pub(crate) velocity_gradient: &'a [[[S; 3]; 3]],
    pub(crate) dt: f64,
    pub(crate) time: f64,
    pub(crate) cell: f64,
    pub(crate) viscosity: BulkViscosity,
}

#[derive(Debug)]
struct Particular<M: Material<S>, S: Number> {
    material: M,
    density: S,
    states: Vec<M::State>,
    conditions: Vec<Condition<S>>,
}

/// One particle over a step.
fn next<M: Material<S>, S: Number>(
    (material, density): (&M, S),
    motion: &Motion<'_, S>,
    i: usize,
    state: &mut M::State,
    condition: &mut Condition<S>,
) -> Result<(), Fault> {
    let Motion { dt, time, cell, viscosity, .. } = *motion;
    let l = motion.velocity_gradient[i];
    let volume = condition.volume * volume_change(&l, dt);
    if !(volume.value() > 0.0 && volume.value().is_finite()) {
        let must = "above 0 and finite";
        return Err(Fault { quantity: "V/V_0", value: volume.value(), must });
    }
    let trace = l[0][0] + l[1][1] + l[2][2];
    let q = if trace.value() < 0.0 {
        let slope = trace * (viscosity.quadratic * cell) - condition.wave_speed * viscosity.linear;
        density / volume * slope * trace * cell
    } else {
        S::constant(0.0)
    };
    let now = Now {
        velocity_gradient: l,
        dt,
        time,
        volume_before: condition.volume,
        volume,
        viscosity: q,
        cell,
    };
    let material_stress = material.update(&now, state)?;
    let stress = material_stress - Symmetric::isotropic(q);
    if let Some(value) = stress.values().into_iter().find(|value| !value.is_finite()) {
        return Err(Fault { quantity: "stress", value, must: "finite" });
    }
    let wave_speed = material.wave_speed(volume, state);
    let c = wave_speed.value();
    if !(c >= 0.0 && c.is_finite()) {
        return Err(Fault { quantity: "wave speed", value: c, must: "0 or above and finite" });
    }
    *condition = Condition { stress, material_stress, volume, wave_speed };
    Ok(())
}

impl<M: Material<S> + 'static, S: Number> Constitution<S> for Particular<M, S>
where
    M::State: 'static,
{
    fn advance(&mut self, motion: &Motion<'_, S>) -> Result<(), (usize, Fault)> {
        let first_fault = Mutex::new(None::<(usize, Fault)>);
        let Self { material, density, states, conditions } = self;
        let (material, density) = (&*material, *density);
        for_each_pair(states, conditions, |i, state, condition| {
            if let Err(fault) = next((material, density), motion, i, state, condition) {
                let mut first = first_fault.lock().unwrap_or_else(PoisonError::into_inner);
                if first.is_none_or(|(lowest, _)| i < lowest) {
                    *first = Some((i, fault));
                }
            }
        });
        first_fault.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    fn conditions(&self) -> &[Condition<S>] {
        &self.conditions
    }

    fn observe(&self, particle: usize) -> Observed<S> {
        self.material.observe(&self.states[particle])
    }

    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>> {
        self.material.at_local_state(state)
    }
}

impl<S: Number, const D: usize> Body<S, D> {
    /// Particles of a material, all with one velocity.
    ///
    /// # Errors
    /// [`Error::EmptyBody`]; [`Error::NotPositive`] for a spacing or the density, [`Error::NotFinite`] for a place or a
    /// velocity.
    pub fn new<M: Material<S> + 'static>(
        material: M,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Self, Error>
    where
        M::State: 'static,
    {
        for (k, &spacing) in fill.spacing.iter().enumerate() {
            positive("spacing of particles", spacing)?;
            finite("velocity", velocity[k])?;
        }
        let n = fill.positions.len();
        if n == 0 {
            return Err(Error::EmptyBody { spacing: fill.spacing[0] });
        }
        for place in &fill.positions {
            place.iter().try_for_each(|&value| finite("position of a particle", value))?;
        }
        let density = material.density();
        positive("density", density.value())?;
        let (zero, volume) = (S::constant(0.0), fill.spacing.iter().product());
        let start = |place: &[f64; D]| {
            material.start(std::array::from_fn(|k| if k < D { place[k] } else { 0.0 }))
        };
        let states: Vec<_> = fill.positions.iter().map(start).collect();
        let one = S::constant(1.0);
        let conditions = states
            .iter()
            .map(|state| Condition {
                stress: Symmetric::zero(),
                material_stress: Symmetric::zero(),
                volume: one,
                wave_speed: material.wave_speed(one, state),
            })
            .collect();
        let particles = Particles {
            position: fill.positions.iter().map(|place| place.map(S::constant)).collect(),
            velocity: vec![velocity.map(S::constant); n],
            displacement: vec![[zero; D]; n],
            affine: vec![[[zero; D]; D]; n],
            velocity_gradient: vec![[[zero; 3]; 3]; n],
            half_length: vec![fill.spacing.map(|length| S::constant(0.5 * length)); n],
            mass: vec![density * volume; n],
            reference_volume: vec![volume; n],
        };
        Ok(Self {
            particles,
            constitution: Box::new(Particular { material, density, states, conditions }),
            bases: vec![[0; D]; n],
            binning: Binning::default(),
        })
    }

    /// Gives every particle the velocity at its place.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a velocity.
    pub fn set_velocities(
        &mut self,
        velocity: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Result<(), Error> {
        let Particles { position, velocity: kept, .. } = &mut self.particles;
        for (place, kept) in position.iter().zip(kept) {
            let value = velocity(&place.map(perturbation_moments::Scalar::value));
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

    /// Places (length).
    #[must_use]
    pub fn positions(&self) -> &[[S; D]] {
        &self.particles.position
    }

    /// Velocities (length per time).
    #[must_use]
    pub fn velocities(&self) -> &[[S; D]] {
        &self.particles.velocity
    }

    /// Masses; per radian where axisymmetric.
    #[must_use]
    pub fn masses(&self) -> &[S] {
        &self.particles.mass
    }

    /// The stress of a particle, without the bulk viscosity.
    #[must_use]
    pub fn stress(&self, particle: usize) -> Symmetric<S> {
        self.constitution.conditions()[particle].material_stress
    }

    /// The pressure of a particle, `-tr(sigma)/3`, without the bulk viscosity.
    #[must_use]
    pub fn pressure(&self, particle: usize) -> S {
        self.stress(particle).trace() * (-1.0 / 3.0)
    }

    /// `V/V_0` of a particle.
    #[must_use]
    pub fn volume_ratio(&self, particle: usize) -> S {
        self.constitution.conditions()[particle].volume
    }

    /// The density of a particle (mass per volume).
    #[must_use]
    pub fn density(&self, particle: usize) -> S {
        let Particles { mass, reference_volume, .. } = &self.particles;
        mass[particle] / (self.volume_ratio(particle) * reference_volume[particle])
    }

    /// Half the diagonal of the box that a particle stands for at the start (length).
    pub(crate) fn half_diagonal(&self) -> f64 {
        let square = |length: &S| length.value() * length.value();
        self.particles.half_length[0].iter().map(square).sum::<f64>().sqrt()
    }

    /// What the material shows of a particle besides its stress.
    #[must_use]
    pub fn observe(&self, particle: usize) -> Observed<S> {
        self.constitution.observe(particle)
    }

    /// Pressure and flow stress by the formulas of its material at a state that is taken for certain; `None` where the
    /// material has none.
    #[must_use]
    pub fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>> {
        self.constitution.at_local_state(state)
    }
}

impl<const D: usize> Body<f64, D> {
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
