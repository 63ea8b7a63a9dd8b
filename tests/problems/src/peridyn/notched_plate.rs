//! A square plate with a notch in its left edge in an ensemble of tension tests: scatter of crack paths.
//!
//! Units: the width of the plate, its modulus and density are one, and so is the speed of a wave along a bar. The energy release
//! rate `G0` is the same on every lattice, whatever the horizon.

use peridyn_sde::statistics::CrackEnsemble;
use peridyn_sde::{
    BondConfig, BondList, BondOrder, BondValue, Bonds, Breaking, Condition, CrackRun, CrackStudy,
    DisorderField, Dynamics, Error, Horizon, Influence, Loading, Mobility, Nodes, Notch,
    PathConfig, Precision, Procedure, Program, Scheme, Simulation, SimulationConfig, Stiffness,
    Strain, Strength, StrengthElement, StudyLaw, SurfaceCorrection, VolumeCorrection,
    WeibullByVolume, WeibullStrength, critical_stretch,
};
use random_fields::{Correlation, CorrelationFunction, GaussianField, Marginal};
use sde_integrators::Noise;

use crate::context::CaseError;

/// `G0`, for strains of 1e-3.
const ENERGY_RELEASE_RATE: f64 = 1e-6;
const PLANE: Condition = Condition::PlaneStress { thickness: 1.0 };
/// Weibull's modulus of independent strengths, and `Gamma(1 + 1/5)`, the mean over the scale.
const MODULUS: (f64, f64) = (5.0, 0.918_168_742_399_761);
/// Largest variance that a field on a rotated lattice may omit at a point before it is rescaled to one.
const LEFT_OUT: f64 = 1e-3;
/// Height of a prescribed edge, three rows of 32.
const GRIP: f64 = 3.0 / 32.0;
/// Within so much of both ends no bond breaks.
const PROTECTED: f64 = 6.0 / 32.0;
/// The length over which stiffness is correlated: three horizons of three shells of 32 rows.
pub const CORRELATION: f64 = 9.045 / 32.0;

/// What makes one crack differ from the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// White noise on every node, as in the note: `s0` is so many standard deviations of the stretch of a bond. Overdamped, while
    /// the plate is stretched to 0.8 of `s0`.
    WhiteNoise {
        /// `s0/sigma`.
        ratio: f64,
        /// By which steps.
        scheme: Scheme,
        /// `z` of the stiffest mode.
        z: f64,
    },
    /// The stiffness of bonds, a lognormal field with a length. Inertial with friction, without noise, the same ramp of strain over
    /// time on every lattice.
    Stiffness,
    /// The critical stretch, a lognormal field whose standard deviation is 0.4 of its mean, and noise. Inertial with friction, the
    /// same ramp up to twice the strain, so that strong samples break too.
    Sample {
        /// The mean of the critical stretch, over that of `G0`.
        strength: f64,
        /// Its correlation length (widths of the plate).
        length: f64,
        /// `kT`, over the one at which `s0/sigma` is ten.
        temperature: f64,
    },
    /// The critical stretch, of mean `s0` and coefficient of variation 0.229. Inertial with friction, without noise, the ramp of
    /// [`Cause::Sample`].
    Strength(StrengthLaw),
    /// One lognormal field, and the ramp of [`Cause::Sample`], without noise.
    Field {
        /// What varies.
        of: Varies,
        /// Standard deviation over mean.
        coefficient_of_variation: f64,
        /// Its correlation length (widths of the plate).
        length: f64,
    },
}

/// What a field is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Varies {
    /// The critical stretch.
    Strength,
    /// The stiffness of bonds.
    Stiffness,
}

/// Independent strengths, Weibull's with the modulus 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StrengthLaw {
    /// Of each bond, the same law on every lattice.
    Bonds,
    /// Of each node, scaled by its volume: mean `s0` on 32 rows, on finer lattices more.
    NodesByVolume,
    /// Of each box of the edge 3.015/32, scaled by its volume, the same on every lattice.
    BlocksByVolume,
}

/// A plate on a lattice.
#[derive(Debug, Clone, Copy)]
pub struct NotchedPlate {
    /// Nodes along an edge.
    pub rows: u32,
    /// `delta` (widths of the plate).
    pub horizon: f64,
    /// What is random.
    pub cause: Cause,
    /// By which angle the lattice is rotated against the edges (degrees).
    pub rotation: f64,
    /// Where the notch ends (widths of the plate); one that ends within a spacing leaves the plate whole.
    pub tip: f64,
}

/// Where the notch ends that the cases have (widths of the plate).
pub const NOTCH: f64 = 0.3;

/// Three shells of so many rows: a horizon (widths of the plate).
#[must_use]
pub fn three_shells(rows: u32) -> f64 {
    3.015 / f64::from(rows)
}

/// A plate ready to be pulled.
struct Ready {
    nodes: Nodes<2>,
    bonds: Bonds,
    strength: f64,
    grips: Vec<usize>,
    protected: Vec<usize>,
    loading: Loading<2>,
    config: SimulationConfig,
    n_steps: u64,
}

impl NotchedPlate {
    fn spacing(&self) -> f64 {
        f64::from(self.rows).recip()
    }

    /// The cracks of realisations from 0 on.
    pub fn cracks(
        &self,
        precision: Precision,
        realisations: u64,
        seed: u64,
    ) -> Result<CrackEnsemble, CaseError> {
        let run = self.run(precision, 0..realisations, seed)?;
        Ok(CrackEnsemble::new(realisations, run.records)?)
    }

    /// What becomes of some realisations.
    pub fn run(
        &self,
        precision: Precision,
        realisations: std::ops::Range<u64>,
        seed: u64,
    ) -> Result<CrackRun, CaseError> {
        self.study((precision, seed), |study| study.run(realisations, &[]))
    }

    fn study<R>(
        &self,
        (precision, seed): (Precision, u64),
        run: impl FnOnce(&CrackStudy<'_>) -> Result<R, Error>,
    ) -> Result<R, CaseError> {
        let ready = self.ready(Noise::new(seed))?;
        let weibull = match self.cause {
            Cause::Strength(law) => Some(Self::weibull(&ready, law)?),
            _ => None,
        };
        let (strengths, stiffness) = match self.cause {
            Cause::WhiteNoise { .. } | Cause::Strength(_) => (None, None),
            Cause::Field { of, coefficient_of_variation, length } => {
                let mean = if of == Varies::Strength { ready.strength } else { 1.0 };
                let field =
                    Some(self.field(&ready.nodes, length, (mean, coefficient_of_variation))?);
                if of == Varies::Strength { (field, None) } else { (None, field) }
            }
            Cause::Stiffness => (None, Some(self.field(&ready.nodes, CORRELATION, (1.0, 0.5))?)),
            Cause::Sample { strength, length, .. } => {
                (Some(self.field(&ready.nodes, length, (strength * ready.strength, 0.4))?), None)
            }
        };
        let study = CrackStudy {
            nodes: &ready.nodes,
            bonds: &ready.bonds,
            law: StudyLaw::BondBased,
            order: BondOrder::List,
            precision,
            strain: Strain::Finite,
            strength: match (&strengths, &weibull) {
                (Some(field), _) => Strength::Field { field, value: BondValue::Mean },
                (None, Some(weibull)) => Strength::Weibull(weibull),
                (None, None) => Strength::Uniform(ready.strength),
            },
            stiffness: stiffness.as_ref().map_or(Stiffness::Uniform, |field| Stiffness::Field {
                field,
                value: BondValue::Mean,
            }),
            no_fail: &ready.protected,
            notch: Notch { mouth: [-self.spacing(), 0.0], tip: [self.tip, 0.0] },
            loading: &ready.loading,
            procedure: Procedure::Dynamic { simulation: &ready.config, n_steps: ready.n_steps },
            load: (&ready.grips, 1),
            n_windows: 40,
            path: PathConfig::of_horizon(self.horizon),
            border: 0.95,
            damage_threshold: 0.3,
        };
        Ok(run(&study)?)
    }

    /// A lognormal field of a mean and a coefficient of variation.
    fn field(
        &self,
        nodes: &Nodes<2>,
        length: f64,
        (mean, coefficient_of_variation): (f64, f64),
    ) -> Result<DisorderField, CaseError> {
        let correlation = Correlation { function: CorrelationFunction::Gaussian, length };
        let x = nodes.positions();
        let gaussian = if self.rotation == 0.0 {
            GaussianField::by_circulant_embedding(x, self.spacing(), correlation)
        } else {
            GaussianField::by_pivoted_cholesky(x, correlation, LEFT_OUT)
        };
        let gaussian = gaussian.map_err(Error::from)?;
        let law = Marginal::Lognormal { mean, coefficient_of_variation };
        Ok(DisorderField::new(gaussian, law, 0)?)
    }

    fn weibull(ready: &Ready, law: StrengthLaw) -> Result<WeibullStrength, CaseError> {
        let (block, coarse) = (three_shells(32), f64::from(32_u32).recip());
        let volume: f64 = ready.nodes.volumes().iter().sum();
        let (element, reference_volume) = match law {
            StrengthLaw::Bonds => (StrengthElement::Bond, volume / ready.bonds.len() as f64),
            StrengthLaw::NodesByVolume => (StrengthElement::Node, coarse * coarse),
            StrengthLaw::BlocksByVolume => (StrengthElement::Block { size: block }, block * block),
        };
        let (modulus, mean) = MODULUS;
        let law =
            WeibullByVolume { scale: ready.strength / mean, modulus, reference_volume, element };
        Ok(WeibullStrength::new(&ready.nodes, &ready.bonds, law, 0)?)
    }

    /// Nodes of a square lattice in the plate, rotated about the tip of the notch.
    #[allow(clippy::cast_possible_wrap, reason = "some hundreds of rows")]
    fn nodes(&self) -> Result<Nodes<2>, CaseError> {
        let dx = self.spacing();
        if self.rotation == 0.0 {
            return Ok(Nodes::lattice(dx, ([0.0, -0.5], [1.0, 0.5]), PLANE, |_| true)?);
        }
        let (sine, cosine) = self.rotation.to_radians().sin_cos();
        let reach = 2 * self.rows as i32;
        let all = (-reach..reach).flat_map(|j| (-reach..reach).map(move |i| [i, j]));
        let place = |at: [i32; 2]| {
            let [a, b] = at.map(|k| (f64::from(k) + 0.5) * dx);
            [NOTCH + cosine * a - sine * b, sine * a + cosine * b]
        };
        let inside = |x: &[f64; 2]| x[0] > 0.0 && x[0] < 1.0 && x[1].abs() < 0.5;
        let x: Vec<[f64; 2]> = all.map(place).filter(inside).collect();
        let volumes = vec![dx * dx; x.len()];
        Ok(Nodes::new(x, volumes, dx, PLANE)?)
    }

    fn ready(&self, noise: Noise) -> Result<Ready, CaseError> {
        let nodes = self.nodes()?;
        let horizon = Horizon::new(self.horizon, self.spacing())?;
        let bonds = Bonds::new(
            &nodes,
            &BondConfig {
                horizon,
                young_modulus: 1.0,
                influence: Influence::Constant,
                volume_correction: VolumeCorrection::Ramp,
                surface_correction: SurfaceCorrection::None,
            },
        )?;
        let influence = Influence::Constant;
        let strength =
            critical_stretch(ENERGY_RELEASE_RATE, 1.0, horizon.radius(), influence, PLANE)?;
        let x = nodes.positions();
        let near_ends = |height: f64| -> Vec<usize> {
            (0..x.len()).filter(|&node| x[node][1].abs() > 0.5 - height).collect()
        };
        let (grips, protected) = (near_ends(GRIP), near_ends(PROTECTED));
        let free: Vec<bool> = x.iter().map(|x| x[1].abs() <= 0.5 - GRIP).collect();
        let is_upper: Vec<bool> = x.iter().map(|x| x[1] > 0.0).collect();
        let mut ready = Ready {
            loading: Loading::new(x.len()).hold(&grips)?,
            config: self.config(&bonds, strength, &free, noise)?,
            nodes,
            bonds,
            strength,
            grips: grips.iter().copied().filter(|&node| is_upper[node]).collect(),
            protected,
            n_steps: 0,
        };
        self.pull(&mut ready, &grips)?;
        Ok(ready)
    }

    /// With a step that is small on any lattice.
    fn config(
        &self,
        bonds: &Bonds,
        strength: f64,
        free: &[bool],
        noise: Noise,
    ) -> Result<SimulationConfig, CaseError> {
        // By equipartition, were all bonds like a shortest one.
        let temperature = |ratio: f64| {
            let unknowns = 2.0 * free.iter().filter(|&&free| free).count() as f64;
            let stiffness = bonds.all()[0].stiffness * self.spacing();
            (strength / ratio).powi(2) * stiffness * bonds.len() as f64 / unknowns
        };
        // Near the lowest frequency of the plate, pi.
        let inertial =
            |temperature| Dynamics::Inertial { density: 1.0, friction: 3.0, temperature };
        let dynamics = match self.cause {
            Cause::WhiteNoise { ratio, scheme, .. } => Dynamics::Overdamped {
                mobility: Mobility::identity(free, 1.0)?,
                temperature: temperature(ratio),
                scheme,
            },
            Cause::Stiffness | Cause::Strength(_) | Cause::Field { .. } => inertial(0.0),
            Cause::Sample { temperature: over, .. } => inertial(over * temperature(10.0)),
        };
        let (dt, breaking) = (1e-9, Breaking::AtEnds);
        Ok(SimulationConfig { dynamics, dt, breaking, confinement: 0.0, noise })
    }

    /// The step, how many of them, and the prescribed displacements.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts of steps")]
    fn pull(&self, ready: &mut Ready, grips: &[usize]) -> Result<(), CaseError> {
        let strengths = vec![ready.strength; ready.bonds.len()];
        let (nodes, bonds) = (ready.nodes.clone(), ready.bonds.clone());
        let body = BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Finite, &strengths)?;
        let probe = Simulation::new(body, ready.loading.clone(), ready.config.clone(), [0])?;
        let (small, relative) = (ready.config.dt, probe.relative_step());
        let slowly = |ready: &mut Ready, omega_dt: f64, until: f64| {
            ready.config.dt = omega_dt * small / relative.sqrt();
            ready.n_steps = ((until + 4.0) / ready.config.dt).ceil() as u64;
            ([false, true], Program::Ramp { rate: 2e-3 / 24.0, until })
        };
        let (directions, program) = match self.cause {
            Cause::WhiteNoise { z, .. } => {
                // Relaxation takes time in proportion to the square of the rows: 5000 steps of z = 0.9 for 64.
                ready.config.dt = z * small / relative;
                ready.n_steps = (f64::from(self.rows.pow(2)) * 5000.0 / 4096.0 * 0.9 / z) as u64;
                let end = ready.config.dt * ready.n_steps as f64;
                ([true; 2], Program::Linear { rate: 0.8 * ready.strength / end })
            }
            // 0.6 leaves room for places ten times as stiff as the mean; 2 is the limit.
            Cause::Stiffness => slowly(ready, 0.6, 24.0),
            Cause::Sample { .. }
            | Cause::Strength(_)
            | Cause::Field { of: Varies::Strength, .. } => slowly(ready, 1.6, 48.0),
            Cause::Field { of: Varies::Stiffness, .. } => slowly(ready, 0.6, 48.0),
        };
        let gradient = [[0.0; 2], [0.0, 1.0]];
        let still = Loading::new(ready.nodes.positions().len());
        ready.loading = still.stretch(&ready.nodes, grips, directions, gradient, program)?;
        Ok(())
    }
}
