//! A notched plate with a hole that is pulled slowly: its crack is drawn to the hole.

use peridyn_sde::{
    Body, BondConfig, Bonds, Breaking, Condition, CrackPath, Dynamics, EquilibriumConfig, Error,
    Fractured, Horizon, Influence, LatticeBody, Loading, Mobility, NextBreakage, Nodes, Notch,
    PathConfig, Program, QuasiStatic, Scheme, Simulation, SimulationConfig, Strain,
    SurfaceCorrection, VolumeCorrection, crack_path,
};
use sde_integrators::Noise;

/// Where bonds break (a stretch).
pub const STRENGTH: f64 = 0.01;
/// Mean strain at the end, over the strength.
pub const STRAIN: f64 = 0.8;
/// `z` of the explicit run.
pub const RELATIVE_STEP: f64 = 0.9;
/// Whole spacings in a horizon.
const SHELLS: u32 = 3;
/// Rows with prescribed displacements at each edge.
const ROWS: usize = 3;
/// Centre and radius of the hole.
const HOLE: ([f64; 2], f64) = ([0.6, 0.62], 0.1);

/// A square plate of unit width and thickness, in plane stress with `E = 1`; a notch at half height, a hole above its line.
#[derive(Debug)]
pub struct SlowPlate {
    /// Its nodes.
    pub nodes: Nodes<2>,
    /// Its bonds.
    pub bonds: Bonds,
    /// The notch.
    pub notch: Notch,
    cut: Vec<usize>,
    edges: [Vec<usize>; 2],
    horizon: f64,
}

/// How a plate broke.
#[derive(Debug)]
pub struct Pulled {
    /// Bonds that broke, in order.
    pub order: Vec<usize>,
    /// The largest load (force).
    pub peak: f64,
    /// The crack, if one grew.
    pub path: Option<CrackPath>,
    /// Evaluations of all forces.
    pub evaluations: u64,
    /// Work of the reactions less what is stored and what was released, over the work, at its largest; of a run event by event.
    pub imbalance: Option<f64>,
}

impl SlowPlate {
    /// With so many nodes along an edge.
    pub fn new(per_edge: usize) -> Result<Self, Error> {
        let dx = 1.0 / per_edge as f64;
        let condition = Condition::PlaneStress { thickness: 1.0 };
        let ([x, y], radius) = HOLE;
        let outside = |place: &[f64; 2]| (place[0] - x).hypot(place[1] - y) > radius;
        let nodes = Nodes::lattice(dx, ([0.0; 2], [1.0; 2]), condition, outside)?;
        let horizon = Horizon::of_shells(SHELLS, dx)?;
        let config = BondConfig {
            horizon,
            young_modulus: 1.0,
            influence: Influence::Constant,
            volume_correction: VolumeCorrection::None,
            surface_correction: SurfaceCorrection::None,
        };
        let bonds = Bonds::new(&nodes, &config)?;
        let notch = Notch { mouth: [-dx, 0.5], tip: [0.3, 0.5] };
        let cut = bonds.across_segment(&nodes, (notch.mouth, notch.tip))?;
        let height = ROWS as f64 * dx;
        let edge = |within: &dyn Fn(f64) -> bool| -> Vec<usize> {
            let heights = nodes.positions().iter().map(|x| x[1]).enumerate();
            heights.filter(|&(_, y)| within(y)).map(|(node, _)| node).collect()
        };
        let edges = [edge(&|y| y < height), edge(&|y| y > 1.0 - height)];
        Ok(Self { nodes, bonds, notch, cut, edges, horizon: horizon.radius() })
    }

    fn body(&self) -> Result<LatticeBody<f64, 2>, Error> {
        LatticeBody::new(self.nodes.clone(), self.bonds.clone(), Strain::Linear, STRENGTH)
    }

    /// The mean strain grows at a rate.
    fn loading(&self, rate: f64) -> Result<Loading<2>, Error> {
        let gradient = [[0.0, 0.0], [0.0, 1.0]];
        let loading = Loading::new(self.nodes.positions().len());
        let program = Program::Linear { rate };
        loading.stretch(&self.nodes, &self.edges.concat(), [true; 2], gradient, program)
    }

    /// In equilibrium at a load that is the mean strain.
    pub fn quasi_static(&self, config: EquilibriumConfig) -> Result<QuasiStatic<2>, Error> {
        let mut body = self.body()?;
        for &bond in &self.cut {
            body.set_intact(bond, 0);
        }
        QuasiStatic::new(body, self.loading(1.0)?, config)
    }

    /// The force that goes with the mean strain, by the pull of the bonds on each node of the edges.
    fn load(&self, pull_on: impl Fn(&[usize]) -> [f64; 2]) -> f64 {
        let x = self.nodes.positions();
        let gripped = self.edges.iter().flatten();
        gripped.map(|&node| -pull_on(&[node])[1] * x[node][1]).sum()
    }

    /// Event by event, to the mean strain of the other runs or until it is separated.
    pub fn by_events(&self, config: EquilibriumConfig) -> Result<Pulled, Error> {
        let mut run = self.quasi_static(config)?;
        let mut found = Pulled::none();
        let (mut work, mut released, mut before, mut slope) = (0.0, 0.0, 0.0, None);
        while let NextBreakage::At(event) = run.next_breakage()? {
            let stiffness = 2.0 * event.energy[0] / event.factor.powi(2);
            let line = slope.unwrap_or(stiffness);
            work += 0.5 * line * (event.factor.powi(2) - before * before);
            released += event.released;
            before = event.factor;
            slope = Some(self.load(|nodes| run.pull_on(nodes)) / before);
            found.peak = found.peak.max(stiffness * event.factor);
            found.order.extend(event.bonds);
            found.evaluations += event.solved.iterations as u64;
            let imbalance = (work - released - run.energy()).abs() / work.abs();
            found.imbalance = Some(found.imbalance.unwrap_or(0.0).max(imbalance));
            if before > STRAIN * STRENGTH {
                break;
            }
        }
        found.path = self.path(&found.order)?;
        Ok(found)
    }

    /// Overdamped and explicit, in so many steps.
    pub fn explicit(&self, n_steps: u64) -> Result<Pulled, Error> {
        let probe = self.simulation(1e-9, 0.0)?;
        let dt = 1e-9 * RELATIVE_STEP / probe.relative_step();
        let mut run = self.simulation(dt, STRAIN * STRENGTH / (dt * n_steps as f64))?;
        let mut found = Pulled::none();
        for step in 1..=n_steps {
            let report = run.step()?;
            found.order.extend(report.broken.iter().map(|broken| broken.bond));
            if step % 16 == 0 {
                found.peak = found.peak.max(self.load(|nodes| run.pull_on(nodes, 0)));
            }
        }
        found.evaluations = n_steps;
        found.path = self.path(&found.order)?;
        Ok(found)
    }

    fn simulation(&self, dt: f64, rate: f64) -> Result<Simulation<f64, 2, 1>, Error> {
        let mut free = vec![true; self.nodes.positions().len()];
        for &node in self.edges.iter().flatten() {
            free[node] = false;
        }
        let mobility = Mobility::identity(&free, 1.0)?;
        let scheme = Scheme::EulerMaruyama;
        let config = SimulationConfig {
            dynamics: Dynamics::Overdamped { mobility, temperature: 0.0, scheme },
            dt,
            breaking: Breaking::AtEnds,
            confinement: 0.0,
            noise: Noise::new(1),
        };
        let mut body = self.body()?;
        for &bond in &self.cut {
            body.set_intact(bond, 0);
        }
        Simulation::new(body, self.loading(rate)?, config, [0])
    }

    fn path(&self, order: &[usize]) -> Result<Option<CrackPath>, Error> {
        let mut broken = vec![false; self.bonds.len()];
        for &bond in order.iter().chain(&self.cut) {
            broken[bond] = true;
        }
        let Self { nodes, bonds, cut, .. } = self;
        let body = Fractured { nodes, bonds, broken: &broken, cut };
        crack_path(&body, &self.notch, &PathConfig::of_horizon(self.horizon))
    }

    /// The largest distance in height of two cracks, in spacings, from the notch to one horizon before the tip of the shorter one:
    /// the last points of a crack are the fit of a zone of damage that is still open. Also how many columns are compared.
    #[must_use]
    pub fn apart(&self, one: &CrackPath, two: &CrackPath) -> (f64, usize) {
        let dx = self.nodes.spacing();
        let mut distances = Vec::new();
        let mut x = self.notch.tip[0] + dx;
        while let (Some(a), Some(b)) = (one.height_at(x), two.height_at(x)) {
            distances.push((a - b).abs() / dx);
            x += dx;
        }
        distances.truncate(distances.len().saturating_sub(SHELLS as usize));
        (distances.iter().copied().fold(0.0, f64::max), distances.len())
    }
}

impl Pulled {
    fn none() -> Self {
        Self { order: Vec::new(), peak: 0.0, path: None, evaluations: 0, imbalance: None }
    }
}
