//! The density of an oscillator on a conservative, non-negative grid.
//!
//! One step of length `tau` is `Q(tau/2) K D Q(tau/2)` on even and `Q(tau/2) D K Q(tau/2)` on odd steps, with
//!
//! - `Q`: `q' = v`, the rows of the grid shift relative to each other,
//! - `K`: `v' = a(t, q, v)`, the columns move with the acceleration,
//! - `D`: the noise, a discrete Gaussian along `v`.
//!
//! Two steps are a symmetric composition of order 2. The durations of `Q` and of the elastic part of `K` are those of
//! the three shears that compose a rotation, so an undamped linear oscillator at the reference frequency rotates
//! exactly.
//!
//! `Q` and `K` transport cell masses by conservative semi-Lagrangian remapping. The new mass is the mass between the
//! departure points of a cell's edges; it follows from the cumulative distribution along the line, interpolated with
//! degree 5. The grid is a square in `(q, v/omega)` that follows mean and covariance, so it neither clips a tail nor
//! wastes cells.
//!
//! Sources: Strang 1968, On the construction and comparison of difference schemes; conservative remapping Zerroukat, Wood
//! and Staniforth 2002, SLICE, a semi-Lagrangian inherently conserving and efficient scheme; limited fluxes Filbet,
//! Sonnendrücker and Bertrand 2001, Conservative numerical schemes for the Vlasov equation; rotation by three shears
//! Paeth 1986, A fast algorithm for general raster rotation.

use sde_integrators::{Additive, GaussianMixture, Sde};

use crate::density::discrete_gaussian::spread_gaussian;
use crate::density::grid_config::{GridConfig, GridError, Spread};
use crate::density::remap::{Axis, Line};

/// The density of an oscillator `(q, v)` on a grid.
///
/// Mass is conserved within roundoff, because mass beyond the grid is kept in its outermost cells. Cells are never
/// negative, because a remapped mass lies between zero and the available mass. No cell is lost in roundoff either:
/// only neighbouring masses are added, so the relative accuracy of a tail is that of the interpolation.
pub struct GridDensity<'a> {
    system: &'a dyn Sde<2, 1, Noise = Additive>,
    config: GridConfig,
    time: f64,
    steps: u64,
    q: Axis,
    v: Axis,
    /// Masses of the cells; the velocity is the fastest index.
    masses: Vec<f64>,
    scratch: Scratch,
}

/// Work arrays of a step.
#[derive(Debug)]
struct Scratch {
    line: Line,
    column: Vec<f64>,
    moved: Vec<f64>,
    departures: Vec<f64>,
}

impl<'a> GridDensity<'a> {
    /// Creates the grid for the initial distribution at `t = 0`; the masses are normalised to 1.
    ///
    /// # Errors
    /// [`GridError::OutOfRange`] with the name of the parameter.
    pub fn new(
        system: &'a dyn Sde<2, 1, Noise = Additive>,
        law: &GaussianMixture<2>,
        config: GridConfig,
    ) -> Result<Self, GridError> {
        config.check()?;
        let n = config.cells;
        let covariance = law.covariance();
        let spread = Spread {
            mean: law.mean(),
            qq: covariance[0][0],
            qv: covariance[0][1],
            vv: covariance[1][1],
        };
        let (q, v) = config.axes(&spread, 0.0)?;
        let mut masses = Vec::with_capacity(n * n);
        for i in 0..n {
            masses.extend((0..n).map(|j| cell_mass(law, &q, &v, (i, j))));
        }
        let total: f64 = masses.iter().sum();
        for mass in &mut masses {
            *mass /= total;
        }
        let scratch = Scratch {
            line: Line::new(n),
            column: vec![0.0; n],
            moved: vec![0.0; n],
            departures: vec![0.0; n + 1],
        };
        Ok(Self { system, config, time: 0.0, steps: 0, q, v, masses, scratch })
    }

    /// Advances to a time in an even number of equal steps.
    ///
    /// # Errors
    /// [`GridError`].
    pub fn advance_to(&mut self, end: f64) -> Result<(), GridError> {
        self.advance_while(end, &mut |_| true)
    }

    /// The same as long as `goes_on`, which is asked at the time after each pair of steps.
    ///
    /// # Errors
    /// [`GridError`].
    pub fn advance_while(
        &mut self,
        end: f64,
        goes_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<(), GridError> {
        let span = end - self.time;
        if span.is_nan() || span < 0.0 {
            return Err(GridError::Time { value: end, limit: self.time });
        }
        if span == 0.0 {
            return Ok(());
        }
        let pairs = 0.5 * span * self.config.steps_per_period / self.config.period;
        // The tolerance prevents roundoff from adding a pair.
        let pairs = (pairs - 1e-9).ceil().max(1.0);
        let (from, tau) = (self.time, 0.5 * span / pairs);
        let omega = self.config.frequency();
        // The shears of a rotation by `omega tau`.
        let half_drift = (0.5 * omega * tau).tan() / omega;
        self.drift(half_drift)?;
        let mut done = 0.0;
        while done < 2.0 * pairs {
            let t = from + done * tau;
            let is_even = done % 2.0 == 0.0;
            let noise = self.noise_variance(t, tau)?;
            if is_even {
                // The axis holds the noise of this step and of the next, which comes before its kick.
                let ahead = noise + self.noise_variance(t + tau, tau)?;
                self.kick(t, tau, ahead)?;
                self.diffuse(noise);
            } else {
                self.diffuse(noise);
                self.kick(t, tau, 0.0)?;
            }
            done += 1.0;
            self.time = from + done * tau;
            self.steps += 1;
            let is_last = done >= 2.0 * pairs;
            let is_ended = !is_last && !is_even && !goes_on(self.time);
            self.drift(if is_last || is_ended { half_drift } else { 2.0 * half_drift })?;
            if is_ended {
                return Ok(());
            }
        }
        self.time = end;
        Ok(())
    }

    /// Integrates `q' = v` over a time, onto an axis that fits the result.
    fn drift(&mut self, tau: f64) -> Result<(), GridError> {
        let Spread { mean, qq, qv, vv } = self.spread();
        let moved = Spread {
            mean: [mean[0] + tau * mean[1], mean[1]],
            qq: qq + tau * (2.0 * qv + tau * vv),
            qv: qv + tau * vv,
            vv,
        };
        let (to, _) = self.config.axes(&moved, self.time)?;
        let n = self.config.cells;
        let Scratch { line, column, moved, departures } = &mut self.scratch;
        for j in 0..n {
            let shift = tau * self.v.centre_of(j);
            for (i, mass) in column.iter_mut().enumerate() {
                *mass = self.masses[i * n + j];
            }
            for (edge, departure) in departures.iter_mut().enumerate() {
                *departure = self.q.in_cells(to.edge(edge) - shift);
            }
            line.remap(column, departures, moved);
            for (i, mass) in moved.iter().enumerate() {
                self.masses[i * n + j] = *mass;
            }
        }
        self.q = to;
        Ok(())
    }

    /// Integrates `v' = a(t, q, v)` over a step by Runge-Kutta 4.
    ///
    /// The integration is backward from the cell edges of an axis that fits the result, and the variance `ahead` that noise adds to it.
    fn kick(&mut self, t: f64, tau: f64, ahead: f64) -> Result<(), GridError> {
        let n = self.config.cells;
        let omega = self.config.frequency();
        // The elastic force acts only for `sin(omega tau)/omega`, as in the rotation.
        let spared = omega * omega * (1.0 - (omega * tau).sin() / (omega * tau));
        let to = self.kicked_axis(t, tau, (spared, ahead))?;
        let Scratch { line, column, departures, .. } = &mut self.scratch;
        for i in 0..n {
            let q = self.q.centre_of(i);
            let acceleration = |t: f64, v: f64| self.system.drift(t, &[q, v])[1] + spared * q;
            for (edge, departure) in departures.iter_mut().enumerate() {
                let v = to.edge(edge);
                let k_1 = acceleration(t + tau, v);
                let k_2 = acceleration(t + 0.5 * tau, v - 0.5 * tau * k_1);
                let k_3 = acceleration(t + 0.5 * tau, v - 0.5 * tau * k_2);
                let k_4 = acceleration(t, v - tau * k_3);
                *departure = self.v.in_cells(v - tau / 6.0 * (k_1 + 2.0 * (k_2 + k_3) + k_4));
            }
            if let Some(&value) = departures.iter().find(|place| !place.is_finite()) {
                return Err(GridError::Collapsed { time: t, what: "path back in time", value });
            }
            let row = &mut self.masses[i * n..(i + 1) * n];
            line.remap(row, departures, column);
            row.copy_from_slice(column);
        }
        self.v = to;
        Ok(())
    }

    /// The velocity axis after a step, from `v + tau a` at the cells and the variance that noise adds.
    fn kicked_axis(
        &self,
        t: f64,
        tau: f64,
        (spared, ahead): (f64, f64),
    ) -> Result<Axis, GridError> {
        let n = self.config.cells;
        let Spread { mean, qq, qv, .. } = self.spread();
        // Every fourth cell suffices to position a grid.
        let (mut weight, mut first, mut second) = (0.0, 0.0, 0.0);
        for i in (0..n).step_by(4) {
            let q = self.q.centre_of(i);
            for j in (0..n).step_by(4) {
                let (v, mass) = (self.v.centre_of(j), self.masses[i * n + j]);
                let [rate, a] = self.system.drift(t + 0.5 * tau, &[q, v]);
                if (rate - v).abs() > ROUNDOFF * (1.0 + v.abs()) {
                    return Err(GridError::NoOscillator { time: t, value: rate, limit: v });
                }
                let v = v + tau * (a + spared * q);
                weight += mass;
                first += mass * v;
                second += mass * v * v;
            }
        }
        let v = first / weight;
        let vv = second / weight - v * v + ahead;
        let moved = Spread { mean: [mean[0], v], qq, qv, vv };
        Ok(self.config.axes(&moved, t)?.1)
    }

    /// The variance that noise adds to the velocity in a step.
    fn noise_variance(&self, t: f64, tau: f64) -> Result<f64, GridError> {
        let mut mean_diffusion = 0.0;
        for (part, weight) in [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)] {
            let time = t + part * tau;
            let [[on_q], [on_v]] = self.system.noise(time, &[self.q.centre, self.v.centre]);
            if on_q != 0.0 {
                return Err(GridError::NoiseOnDisplacement { time, value: on_q });
            }
            mean_diffusion += weight * 0.5 * on_v * on_v;
        }
        // A kick between the shears changes the energy by 1/cos^2 of its change within the rotation.
        let spared = (0.5 * self.config.frequency() * tau).cos().powi(2);
        Ok(2.0 * mean_diffusion * tau * spared)
    }

    /// Adds an independent normal variable of this variance to the velocities.
    ///
    /// The kernel is a Gaussian sampled at the cells, whose variance is accurate to `1e-6` for a standard deviation of
    /// at least one cell. For smaller deviations it is a random walk between neighbours.
    fn diffuse(&mut self, variance: f64) {
        let variance = variance / (self.v.width * self.v.width);
        let n = self.config.cells;
        let Scratch { column, .. } = &mut self.scratch;
        for row in self.masses.chunks_exact_mut(n) {
            spread_gaussian(row, variance, column);
        }
    }
}

impl std::fmt::Debug for GridDensity<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { config, time, .. } = self;
        f.debug_struct("GridDensity")
            .field("config", config)
            .field("time", time)
            .finish_non_exhaustive()
    }
}

impl GridDensity<'_> {
    /// Current time.
    #[must_use]
    pub const fn time(&self) -> f64 {
        self.time
    }

    /// Number of steps so far.
    #[must_use]
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Sum of all masses.
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        self.masses.chunks_exact(self.config.cells).map(|row| row.iter().sum::<f64>()).sum()
    }

    /// Smallest mass of a cell.
    #[must_use]
    pub fn smallest_mass(&self) -> f64 {
        self.masses.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The raw moment `E[q^a v^b]`, with Sheppard's corrections for the width of the cells; powers up to 4.
    ///
    /// Source: Kendall and Stuart 1977, The advanced theory of statistics, volume 1, chapter 3.
    ///
    /// # Errors
    /// [`GridError::OutOfRange`] for a power above 4.
    pub fn raw_moment(&self, powers: [u32; 2]) -> Result<f64, GridError> {
        if let Some(&power) = powers.iter().find(|&&power| power > 4) {
            let (name, limit) = ("the power of a moment", "at most 4");
            return Err(GridError::OutOfRange { name, value: f64::from(power), limit });
        }
        let n = self.config.cells;
        let along_v: Vec<f64> = (0..n).map(|j| self.v.sheppard(j, powers[1])).collect();
        let mut moment = 0.0;
        for (i, row) in self.masses.chunks_exact(n).enumerate() {
            let sum: f64 = row.iter().zip(&along_v).map(|(mass, v)| mass * v).sum();
            moment += self.q.sheppard(i, powers[0]) * sum;
        }
        Ok(moment)
    }

    /// `P(|q| > T)`; the cell that `T` cuts is divided by the interpolated distribution.
    #[must_use]
    pub fn exceedance(&self, threshold: f64) -> f64 {
        let n = self.config.cells;
        let marginal: Vec<f64> =
            self.masses.chunks_exact(n).map(|row| row.iter().sum::<f64>()).collect();
        let mut line = Line::new(n);
        let cuts = [0.0, self.q.in_cells(-threshold), self.q.in_cells(threshold), n as f64];
        let mut parts = [0.0; 3];
        line.remap(&marginal, &cuts, &mut parts);
        parts[0] + parts[2]
    }

    fn spread(&self) -> Spread {
        let n = self.config.cells;
        let (mut mean, mut second) = ([0.0; 2], [0.0; 3]);
        for (i, row) in self.masses.chunks_exact(n).enumerate() {
            let (mut mass, mut first, mut square) = (0.0, 0.0, 0.0);
            for (j, m) in row.iter().enumerate() {
                let v = self.v.centre_of(j);
                mass += m;
                first += m * v;
                square += m * v * v;
            }
            let q = self.q.centre_of(i);
            mean[0] += q * mass;
            mean[1] += first;
            second[0] += q * q * mass;
            second[1] += q * first;
            second[2] += square;
        }
        Spread {
            mean,
            qq: second[0] - mean[0] * mean[0],
            qv: second[1] - mean[0] * mean[1],
            vv: second[2] - mean[1] * mean[1],
        }
    }
}

/// Bound on the roundoff of a sum of a few terms, with margin.
const ROUNDOFF: f64 = 1e-12;

/// Mass of a cell under a density, by the product of two Gauss-Legendre rules with three nodes.
fn cell_mass(law: &GaussianMixture<2>, q: &Axis, v: &Axis, (i, j): (usize, usize)) -> f64 {
    let rule = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
    let mut mass = 0.0;
    for (y, p) in rule {
        for (z, r) in rule {
            let x = [q.centre_of(i) + 0.5 * y * q.width, v.centre_of(j) + 0.5 * z * v.width];
            mass += p * r * law.density(&x);
        }
    }
    mass * q.width * v.width
}
