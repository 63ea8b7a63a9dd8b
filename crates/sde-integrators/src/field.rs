//! Fields: states of many unknowns in slices, with additive noise correlated over the unknowns.

use crate::error::{Error, StepError};
use crate::noise::{Noise, Purpose, Stream, WORDS_PER_PAIR};
use crate::noise_factor::NoiseFactor;

/// A system of many unknowns with additive noise,
///
/// $$ dX = f(t, X) dt + a(t) L dB, $$
///
/// with a constant [`NoiseFactor`] `L`. Ito and Stratonovich agree. Its methods implement [`FieldIntegrator`];
/// state-dependent noise does not compile.
///
/// ```compile_fail
/// use sde_integrators::{DiagonalFactor, FieldPath, FieldSde, Milstein, Noise};
///
/// struct Heat(DiagonalFactor);
///
/// impl FieldSde for Heat {
///     type Factor = DiagonalFactor;
///     fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) {
///         drift.iter_mut().zip(x).for_each(|(f, x)| *f = -x);
///     }
///     fn factor(&self) -> &DiagonalFactor { &self.0 }
/// }
///
/// let heat = Heat(DiagonalFactor::new(vec![1.0; 4]).unwrap());
/// FieldPath::new(&heat, &Milstein, &Noise::new(1), 0, vec![0.0; 4]);
/// ```
pub trait FieldSde: Sync {
    /// Type of the noise factor.
    type Factor: NoiseFactor;

    /// Writes `f(t, x)` into `drift`; both have as many entries as the factor has rows. Every entry must be written.
    fn drift(&self, t: f64, x: &[f64], drift: &mut [f64]);

    /// `L`.
    fn factor(&self) -> &Self::Factor;

    /// `a(t)`; 1 by default.
    fn intensity(&self, t: f64) -> f64 {
        let _ = t;
        1.0
    }
}

/// Correlated increments of a field over one step: `L w` and `L H`, entry by entry of the state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldIncrement<'a> {
    /// `L w`.
    pub brownian: &'a [f64],
    /// `L H`.
    pub space_time_area: &'a [f64],
}

/// A method that takes one step of a field.
///
/// Like an [`Integrator`](crate::Integrator) it owns no clock, storage or random numbers. Its buffers come from the
/// [`Workspace`], so after the first step nothing is allocated.
pub trait FieldIntegrator: Sync {
    /// Data of a path kept between steps, other than its state.
    type Memory: Default + Clone + Send;

    /// Advances `x` from `t` to `t + dt` along the increment `dw` over that step.
    ///
    /// # Errors
    /// If the method cannot take the step. A non-finite result is no error here; [`FieldPath`] checks.
    #[allow(clippy::too_many_arguments, reason = "the seven parts of a step, as in Integrator")]
    fn step<S: FieldSde + ?Sized>(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: FieldIncrement<'_>,
        x: &mut [f64],
        workspace: &mut Workspace,
        memory: &mut Self::Memory,
    ) -> Result<(), StepError>;
}

/// Buffers for use during a step. Their contents between steps are undefined.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    values: Vec<f64>,
}

impl Workspace {
    /// One buffer of `length` values.
    pub fn flat(&mut self, length: usize) -> &mut [f64] {
        if self.values.len() < length {
            self.values.resize(length, 0.0);
        }
        &mut self.values[..length]
    }

    /// `K` buffers of `length` values each.
    pub fn buffers<const K: usize>(&mut self, length: usize) -> [&mut [f64]; K] {
        let mut rest = self.flat(K * length);
        std::array::from_fn(|_| {
            let (buffer, tail) = std::mem::take(&mut rest).split_at_mut(length);
            rest = tail;
            buffer
        })
    }
}

/// One path of a field: its state, its time, and its noise.
///
/// The increments are a function of seed, realisation and step, like those of [`PathNoise`](crate::PathNoise): a field
/// of `M` motions has the same noise as a small state of `M` motions.
///
/// ```
/// use sde_integrators::{DiagonalFactor, FieldPath, FieldSde, Noise, Shark};
///
/// /// A thousand springs that relax, each with its own noise.
/// struct Springs(DiagonalFactor);
///
/// impl FieldSde for Springs {
///     type Factor = DiagonalFactor;
///     fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) {
///         drift.iter_mut().zip(x).for_each(|(f, x)| *f = -x);
///     }
///     fn factor(&self) -> &DiagonalFactor { &self.0 }
/// }
///
/// let springs = Springs(DiagonalFactor::new(vec![2.0_f64.sqrt(); 1000])?);
/// let mut path = FieldPath::new(&springs, &Shark, &Noise::new(1), 0, vec![0.0; 1000])?;
/// for _ in 0..100 {
///     path.step(0.1)?;
/// }
/// // The stationary variance is 1; of 1000 springs it is known to sqrt(2/1000) = 0.045.
/// let variance = path.state().iter().map(|x| x * x).sum::<f64>() / 1000.0;
/// assert!((variance - 1.0).abs() < 4.0 * 0.045, "{variance}");
/// # Ok::<(), sde_integrators::Error>(())
/// ```
#[derive(Debug)]
pub struct FieldPath<'a, S: ?Sized, I: FieldIntegrator> {
    system: &'a S,
    integrator: &'a I,
    stream: Stream,
    area_stream: Stream,
    realisation: u64,
    t: f64,
    steps: u64,
    state: Vec<f64>,
    /// State before the step, restored after a failed step.
    before: Vec<f64>,
    normals: Vec<f64>,
    increments: Vec<f64>,
    workspace: Workspace,
    memory: I::Memory,
}

impl<'a, S, I> FieldPath<'a, S, I>
where
    S: FieldSde + ?Sized,
    I: FieldIntegrator,
{
    /// A path from `start` at time 0.
    ///
    /// # Errors
    /// [`Error::Length`] if `start` has not as many entries as the factor has rows, [`Error::NotFinite`].
    pub fn new(
        system: &'a S,
        integrator: &'a I,
        noise: &Noise,
        realisation: u64,
        start: Vec<f64>,
    ) -> Result<Self, Error> {
        let n = system.factor().n_unknowns();
        if start.len() != n {
            let (quantity, value) = ("unknowns of the start", start.len());
            return Err(Error::Length { quantity, value, expected: n });
        }
        if let Some(index) = start.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite { quantity: "unknown", index, value: start[index] });
        }
        Ok(Self {
            system,
            integrator,
            stream: noise.stream(Purpose::Path, realisation),
            area_stream: noise.stream(Purpose::PathArea, realisation),
            realisation,
            t: 0.0,
            steps: 0,
            before: start.clone(),
            state: start,
            normals: vec![0.0; 2 * (system.factor().n_motions() + 1)],
            increments: vec![0.0; 2 * n],
            workspace: Workspace::default(),
            memory: I::Memory::default(),
        })
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// The time.
    #[must_use]
    pub const fn time(&self) -> f64 {
        self.t
    }

    /// Number of steps taken.
    #[must_use]
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Memory of the method for the path.
    #[must_use]
    pub const fn memory(&self) -> &I::Memory {
        &self.memory
    }

    /// Advances by one step of length `dt`. A failed step leaves the state unchanged.
    ///
    /// # Errors
    /// [`Error::NotPositive`] (`dt`), [`Error::Step`], [`Error::NonFiniteState`] with step, time, path and unknown.
    pub fn step(&mut self, dt: f64) -> Result<(), Error> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(Error::NotPositive { quantity: "dt", value: dt });
        }
        self.draw(dt);
        let (brownian, space_time_area) = self.increments.split_at(self.state.len());
        let dw = FieldIncrement { brownian, space_time_area };
        self.before.copy_from_slice(&self.state);
        let (t, step, realisation) = (self.t, self.steps, self.realisation);
        let (state, memory) = (&mut self.state, &mut self.memory);
        self.integrator
            .step(self.system, t, dt, dw, state, &mut self.workspace, memory)
            .map_err(|source| Error::Step { realisation, step, t, source })
            .and_then(|()| match state.iter().position(|value| !value.is_finite()) {
                Some(component) => Err(Error::NonFiniteState {
                    realisation,
                    steps: step + 1,
                    t: t + dt,
                    component,
                    value: state[component],
                }),
                None => Ok(()),
            })
            .inspect_err(|_| state.copy_from_slice(&self.before))?;
        self.t += dt;
        self.steps += 1;
        Ok(())
    }

    /// Draws the increments of the next step.
    ///
    /// Normal number `k M + m` belongs to step `k` and motion `m`, as for a small state.
    fn draw(&mut self, dt: f64) {
        let n_motions = self.system.factor().n_motions();
        let first = u128::from(self.steps) * n_motions as u128;
        // Normals come in pairs, of which the first may belong to the previous step.
        let before = usize::from(!first.is_multiple_of(2));
        let (w, area) = self.normals.split_at_mut(n_motions + 1);
        for (stream, normals, deviation) in [
            (&mut self.stream, &mut *w, dt.sqrt()),
            (&mut self.area_stream, &mut *area, (dt / 12.0).sqrt()),
        ] {
            stream.seek(first / 2 * WORDS_PER_PAIR);
            let normals = &mut normals[..before + n_motions];
            stream.fill_normal(normals);
            for normal in normals.iter_mut() {
                *normal *= deviation;
            }
        }
        let (brownian, space_time_area) = self.increments.split_at_mut(self.state.len());
        let of_step = before..before + n_motions;
        self.system.factor().apply(&w[of_step.clone()], brownian);
        self.system.factor().apply(&area[of_step], space_time_area);
    }
}
