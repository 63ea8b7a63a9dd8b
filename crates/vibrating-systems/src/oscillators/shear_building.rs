//! A shear building of any number of storeys under ground motion.

use sde_integrators::{LaneSde, PairTerm, PairwiseSde};

use crate::error::{Error, not_negative, positive};
use crate::excitation::filter::GroundMotion;
use crate::oscillators::hysteresis::Hysteresis;
use crate::oscillators::shear_chain::{self, Rayleigh};
use crate::{CloughPenzienParameters, Filter, KanaiTajimiParameters, Window};

/// A storey of a [`ShearBuilding`]: the columns below a floor, and the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Storey {
    /// `m > 0`, mass of the floor.
    pub mass: f64,
    /// `k > 0`, stiffness before yielding (force per displacement).
    pub stiffness: f64,
    /// `c >= 0`, damping of the storey (force per velocity).
    pub damping: f64,
    /// Hysteresis of the storey.
    pub hysteresis: Hysteresis,
}

/// Ground acceleration of a [`ShearBuilding`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ground {
    /// The modulated white noise itself.
    WhiteNoise,
    /// White noise behind the soil of Kanai and Tajimi.
    KanaiTajimi(KanaiTajimiParameters),
    /// White noise behind soil and high-pass filter of Clough and Penzien.
    CloughPenzien(CloughPenzienParameters),
}

/// Parameters of a [`ShearBuilding`].
#[derive(Debug, Clone, PartialEq)]
pub struct ShearBuildingParameters {
    /// The storeys from the ground upwards.
    pub storeys: Vec<Storey>,
    /// `a >= 0`, damping proportional to the masses (1 per unit of time).
    pub mass_damping: f64,
    /// Origin of the ground acceleration.
    pub ground: Ground,
    /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
    /// density per rad/s, a quarter of a one-sided one per Hz.
    pub noise_intensity: f64,
    /// `e(t)`, the window of the white noise, before a filter.
    pub window: Window,
}

impl ShearBuildingParameters {
    /// The same building with Rayleigh damping, which gives two of its modes these damping ratios.
    ///
    /// It replaces the damping of the storeys by `b k_i` and `mass_damping` by `a`, with `a/(2 omega) + b omega/2 = xi` in
    /// the two modes of the building before yielding (Chopra 2012, eq 11.4.9).
    ///
    /// # Errors
    /// Those of [`ShearBuilding::new`]; [`Error::OutOfRange`] for a mode, counted from 1, and [`Error::OutOfOrder`] for modes
    /// that do not increase; [`Error::Negative`] where one of the two parts would be negative.
    pub fn with_rayleigh_damping(self, modes: [usize; 2], ratios: [f64; 2]) -> Result<Self, Error> {
        let building = ShearBuilding::new(self)?;
        let frequencies = building.natural_frequencies();
        let Rayleigh { of_mass, of_stiffness } =
            shear_chain::rayleigh(&frequencies, modes, ratios)?;
        let mut parameters = building.parameters;
        parameters.mass_damping = of_mass;
        for storey in &mut parameters.storeys {
            storey.damping = of_stiffness * storey.stiffness;
        }
        Ok(parameters)
    }
}

/// A shear building with hysteretic storeys. With the drifts `u_i` of the storeys, the floors' accelerations `a_i` relative
/// to the ground, and the storey forces `F_i`:
///
/// $$ F_i = k_i (\alpha_i u_i + (1 - \alpha_i) z_i) + c_i \dot u_i, \qquad
///    a_i = \frac{F_{i+1} - F_i}{m_i} - a \sum_{j \le i} \dot u_j + u_g(t), \qquad
///    \ddot u_i = a_i - a_{i-1} . $$
///
/// State `(u_1 .. u_N, u_1' .. u_N', z_1 .. z_N)` and then the states of the filter of the ground acceleration `u_g`; without
/// hysteresis in any storey there are no `z`. A storey without hysteresis in a building that has some keeps its own `z = u`.
/// The ground acceleration enters with a plus sign, as for [`TwoStorey`](crate::TwoStorey). `F_(N+1) = 0`.
///
/// Source: Chopra 2012, Dynamics of structures, section 9.1; hysteresis: [`Hysteresis`].
///
/// ```
/// use vibrating_systems::{Ground, Hysteresis, ShearBuilding, ShearBuildingParameters, Storey, Window};
/// use sde_integrators::LaneSde;
///
/// let hysteresis = Hysteresis::BoucWen { post_yield_ratio: 0.1, yield_drift: 0.01, beta: 0.5, exponent: 1.0 };
/// let storey = Storey { mass: 1.0, stiffness: 100.0, damping: 0.0, hysteresis };
/// let building = ShearBuilding::new(ShearBuildingParameters {
///     storeys: vec![storey; 3],
///     mass_damping: 0.0,
///     ground: Ground::WhiteNoise,
///     noise_intensity: 0.1,
///     window: Window::Stationary,
/// })?;
/// assert_eq!(building.n_states(), 9);
/// // omega_1 = 2 sqrt(k/m) sin(pi/(2 (2 N + 1)))
/// let exact = 20.0 * (std::f64::consts::PI / 14.0).sin();
/// assert!((building.natural_frequencies()[0] / exact - 1.0).abs() < 1e-12);
/// # Ok::<(), vibrating_systems::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ShearBuilding {
    parameters: ShearBuildingParameters,
    is_hysteretic: bool,
    ground: GroundMotion,
}

impl ShearBuilding {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::TooFewRows`] without a storey; [`Error::NotFinite`], [`Error::NotPositive`], [`Error::Negative`],
    /// [`Error::OutOfRange`], [`Error::OutOfOrder`], naming the parameter.
    pub fn new(parameters: ShearBuildingParameters) -> Result<Self, Error> {
        let p = &parameters;
        if p.storeys.is_empty() {
            return Err(Error::TooFewRows { name: "storeys", count: 0, limit: 1 });
        }
        for storey in &p.storeys {
            positive("mass", storey.mass)?;
            positive("stiffness", storey.stiffness)?;
            not_negative("damping", storey.damping)?;
            storey.hysteresis.check()?;
        }
        not_negative("mass_damping", p.mass_damping)?;
        not_negative("noise_intensity", p.noise_intensity)?;
        p.window.check()?;
        let ground = match p.ground {
            Ground::WhiteNoise => GroundMotion::default(),
            Ground::KanaiTajimi(soil) => GroundMotion::of(&Filter::kanai_tajimi(soil)?),
            Ground::CloughPenzien(filter) => GroundMotion::of(&Filter::clough_penzien(filter)?),
        };
        let is_hysteretic = p.storeys.iter().any(|storey| storey.hysteresis != Hysteresis::None);
        Ok(Self { parameters, is_hysteretic, ground })
    }

    /// The parameters.
    pub fn parameters(&self) -> &ShearBuildingParameters {
        &self.parameters
    }

    /// Number of storeys.
    pub fn n_storeys(&self) -> usize {
        self.parameters.storeys.len()
    }

    /// Whether a storey has hysteresis.
    pub fn is_hysteretic(&self) -> bool {
        self.is_hysteretic
    }

    /// The circular frequencies before yielding, increasing (rad per unit of time).
    pub fn natural_frequencies(&self) -> Vec<f64> {
        let storeys = &self.parameters.storeys;
        let chain: Vec<_> = storeys.iter().map(|s| (s.mass, s.stiffness)).collect();
        shear_chain::natural_frequencies(&chain)
    }

    /// The shortest period of the building before yielding and of the filter (time), by which steps are measured.
    pub fn shortest_period(&self) -> f64 {
        let highest = self.natural_frequencies().last().copied().unwrap_or(f64::MIN_POSITIVE);
        (std::f64::consts::TAU / highest).min(self.ground.period)
    }

    /// First state of the hysteretic variables and of the filter.
    fn places(&self) -> [usize; 2] {
        let n = self.n_storeys();
        [2 * n, if self.is_hysteretic { 3 * n } else { 2 * n }]
    }

    /// Force of a storey of `L` paths, from its drift, the rate of that and its hysteretic variable.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    fn force<const L: usize>(
        &self,
        i: usize,
        (u, v, z): (Rows<'_, L>, Rows<'_, L>, Rows<'_, L>),
    ) -> [f64; L] {
        let Storey { stiffness, damping, hysteresis, .. } = self.parameters.storeys[i];
        let elastic = stiffness * hysteresis.post_yield_ratio();
        let (u, v, mut force) = (&u[i], &v[i], [0.0; L]);
        for lane in 0..L {
            force[lane] = elastic * u[lane] + damping * v[lane];
        }
        if self.is_hysteretic {
            let (z, of_z) = (&z[i], stiffness - elastic);
            for lane in 0..L {
                force[lane] += of_z * z[lane];
            }
        }
        force
    }
}

/// States of `L` paths, row by row.
type Rows<'x, const L: usize> = &'x [[f64; L]];

impl LaneSde for ShearBuilding {
    fn n_states(&self) -> usize {
        self.places()[1] + self.ground.n_states()
    }

    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    fn drift<const L: usize>(&self, _: f64, x: &[[f64; L]], drift: &mut [[f64; L]]) {
        let (n, [z, y]) = (self.n_storeys(), self.places());
        let (x, ground) = x.split_at(y);
        let (drift, rates) = drift.split_at_mut(y);
        self.ground.drift(ground, rates);
        let (x, z) = x.split_at(z);
        let (u, v) = x.split_at(n);
        let (of_u, rest) = drift.split_at_mut(n);
        let (of_v, of_z) = rest.split_at_mut(n);
        of_u.copy_from_slice(v);
        let shaken = self.ground.output(ground);
        let mut below = shaken.map(|acceleration| -acceleration);
        let mut force = self.force(0, (u, v, z));
        let mass_damping = self.parameters.mass_damping;
        for (i, storey) in self.parameters.storeys.iter().enumerate() {
            let above = if i + 1 < n { self.force(i + 1, (u, v, z)) } else { [0.0; L] };
            // Rows of fixed length alone, so that the loop over lanes has no check.
            let (v, of_v, inverse) = (&v[i], &mut of_v[i], 1.0 / storey.mass);
            for lane in 0..L {
                let floor = (above[lane] - force[lane]) * inverse;
                of_v[lane] = floor - below[lane] - mass_damping * v[lane];
                below[lane] = floor;
            }
            force = above;
            if self.is_hysteretic {
                storey.hysteresis.rate(v, &z[i], &mut of_z[i]);
            }
        }
    }

    fn noise(&self, t: f64, g: &mut [f64]) {
        let ShearBuildingParameters { window, noise_intensity, .. } = &self.parameters;
        let (amplitude, n) = (window.noise_amplitude(t, *noise_intensity), self.n_storeys());
        g.fill(0.0);
        if self.ground.n_states() == 0 {
            g[n] = amplitude;
        }
        for (g, b) in g[self.places()[1]..].iter_mut().zip(&self.ground.noise) {
            *g = amplitude * b;
        }
    }

    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    fn return_to_admissible<const L: usize>(&self, x: &mut [[f64; L]]) {
        if self.is_hysteretic {
            let z = self.places()[0];
            for (storey, row) in self.parameters.storeys.iter().zip(&mut x[z..]) {
                storey.hysteresis.return_to_yield_surface(row);
            }
        }
    }
}

impl PairwiseSde for ShearBuilding {
    fn linear_part(&self) -> Vec<(usize, usize, f64)> {
        let (n, [z, y], all) = (self.n_storeys(), self.places(), self.n_states());
        let mut matrix = vec![0.0; all * all];
        let mut add = |i: usize, j: usize, value: f64| matrix[i * all + j] += value;
        let storeys = &self.parameters.storeys;
        for (i, storey) in storeys.iter().enumerate() {
            let elastic = storey.stiffness * storey.hysteresis.post_yield_ratio();
            // The force of storey i pulls floor i and pushes the floor below.
            let mut acts = vec![(i, -1.0 / storey.mass)];
            if i > 0 {
                acts[0].1 -= 1.0 / storeys[i - 1].mass;
                acts.push((i - 1, 1.0 / storeys[i - 1].mass));
            }
            if i + 1 < n {
                acts.push((i + 1, 1.0 / storey.mass));
            }
            for (floor, factor) in acts {
                add(n + floor, i, factor * elastic);
                add(n + floor, n + i, factor * storey.damping);
                if self.is_hysteretic {
                    add(n + floor, z + i, factor * (storey.stiffness - elastic));
                }
            }
            add(i, n + i, 1.0);
            add(n + i, n + i, -self.parameters.mass_damping);
            if self.is_hysteretic && storey.hysteresis == Hysteresis::None {
                add(z + i, n + i, 1.0);
            }
        }
        for (k, output) in self.ground.output.iter().enumerate() {
            add(n, y + k, *output);
        }
        for (i, j, value) in self.ground.entries() {
            add(y + i, y + j, value);
        }
        let entry = |place: usize| (place / all, place % all, matrix[place]);
        (0..all * all).map(entry).filter(|(.., value)| value.abs() > 0.0).collect()
    }

    fn pair_terms(&self) -> Vec<PairTerm> {
        let (n, [z, _]) = (self.n_storeys(), self.places());
        let is_term = |i: &usize| self.parameters.storeys[*i].hysteresis != Hysteresis::None;
        let term = |i: usize| PairTerm { row: z + i, states: [n + i, z + i] };
        (0..n).filter(is_term).map(term).collect()
    }

    fn pair_term(&self, k: usize, v: f64, z: f64) -> f64 {
        let of_storeys = self.parameters.storeys.iter().map(|storey| storey.hysteresis);
        let mut terms = of_storeys.filter(|hysteresis| *hysteresis != Hysteresis::None);
        let mut rate = [[0.0]];
        if let Some(hysteresis) = terms.nth(k) {
            hysteresis.rate(&[v], &[z], &mut rate[0]);
        }
        rate[0][0]
    }
}
