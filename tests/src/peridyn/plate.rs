//! Plates of one brittle material that move and crack.

use peridyn_sde::{
    BondConfig, Bonds, Breaking, Cause, Condition, CrackPath, Dynamics, Fractured, Horizon,
    Influence, LatticeBody, Loading, Nodes, Notch, PathConfig, Simulation, SimulationConfig,
    Strain, crack_path, critical_stretch,
};
use sde_integrators::Noise;

use crate::case::CaseError;

/// A material on a lattice, in plane stress, its bonds of one stiffness, without corrections of volume or surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plate {
    /// `E` (stress).
    pub(crate) young_modulus: f64,
    /// `rho` (mass over volume).
    pub(crate) density: f64,
    /// `G0` (energy over area).
    pub(crate) energy_release_rate: f64,
    /// `t` (length).
    pub(crate) thickness: f64,
    /// Whole spacings in a horizon.
    pub(crate) shells: u32,
    /// `dx` (length).
    pub(crate) spacing: f64,
}

impl Plate {
    /// Plane stress.
    #[must_use]
    pub(crate) fn condition(&self) -> Condition {
        Condition::PlaneStress { thickness: self.thickness }
    }

    /// The nodes of a rectangle.
    pub(crate) fn rectangle(&self, low: [f64; 2], high: [f64; 2]) -> Result<Nodes<2>, CaseError> {
        Ok(Nodes::lattice(self.spacing, (low, high), self.condition(), |_| true)?)
    }

    /// How far a node sees (length).
    pub(crate) fn horizon(&self) -> Result<Horizon, CaseError> {
        Ok(Horizon::of_shells(self.shells, self.spacing)?)
    }

    /// Bonds of nodes.
    pub(crate) fn bonds(&self, nodes: &Nodes<2>) -> Result<Bonds, CaseError> {
        let config = BondConfig::uncorrected(self.horizon()?, self.young_modulus);
        Ok(Bonds::new(nodes, &config)?)
    }

    /// The critical stretch.
    pub(crate) fn strength(&self) -> Result<f64, CaseError> {
        Ok(critical_stretch(
            self.energy_release_rate,
            self.young_modulus,
            self.horizon()?.radius(),
            Influence::Constant,
            self.condition(),
        )?)
    }

    /// A share of the critical step of velocity Verlet, `2/omega` of the stiffest mode (time), by a patch of 40 by 40 nodes.
    pub(crate) fn step(&self, share: f64) -> Result<f64, CaseError> {
        let nodes = self.rectangle([0.0; 2], [40.0 * self.spacing; 2])?;
        let loading = Loading::new(nodes.positions().len());
        let small = 0.05 * self.spacing / (self.young_modulus / self.density).sqrt();
        let patch = Simulation::new(self.body(nodes)?, loading, self.in_time(small), [0])?;
        Ok(share * 2.0 * small / patch.relative_step().sqrt())
    }

    fn body(&self, nodes: Nodes<2>) -> Result<LatticeBody<f64, 2>, CaseError> {
        let bonds = self.bonds(&nodes)?;
        Ok(LatticeBody::new(nodes, bonds, Strain::Finite, self.strength()?)?)
    }

    /// Velocity Verlet.
    fn in_time(&self, dt: f64) -> SimulationConfig {
        SimulationConfig {
            dynamics: Dynamics::Inertial { density: self.density, friction: 0.0, temperature: 0.0 },
            dt,
            breaking: Breaking::AtEnds,
            confinement: 0.0,
            noise: Noise::new(1),
        }
    }

    /// The speed of Rayleigh waves along an edge (length over time), in plane stress with `nu = 1/3`: with `x = (c/c_s)^2`,
    /// `c_s^2 = G/rho` and `k = (c_s/c_p)^2 = (1 - nu)/2`, the root of `x^3 - 8 x^2 + (24 - 16 k) x - 16 (1 - k)` below one.
    #[must_use]
    pub(crate) fn rayleigh_speed(&self) -> f64 {
        let poisson_ratio = 1.0 / 3.0;
        let k = 0.5 * (1.0 - poisson_ratio);
        let (mut low, mut high) = (0.5, 1.0);
        for _ in 0..60 {
            let x: f64 = 0.5 * (low + high);
            if x.powi(3) - 8.0 * x * x + (24.0 - 16.0 * k) * x - 16.0 * (1.0 - k) < 0.0 {
                low = x;
            } else {
                high = x;
            }
        }
        let shear_modulus = 0.5 * self.young_modulus / (1.0 + poisson_ratio);
        (low * shear_modulus / self.density).sqrt()
    }

    /// Moves a plate with notches until a time, by 0.8 of the critical step.
    pub(crate) fn crack(
        &self,
        nodes: Nodes<2>,
        notches: &[Notch],
        loading: Loading<2>,
        until: f64,
    ) -> Result<Cracked, CaseError> {
        let (dt, bonds) = (self.step(0.8)?, self.bonds(&nodes)?);
        let mut cut = Vec::new();
        for notch in notches {
            cut.extend(bonds.across_segment(&nodes, (notch.mouth, notch.tip))?);
        }
        let mut run = Simulation::new(self.body(nodes.clone())?, loading, self.in_time(dt), [0])?;
        run.cut(&cut)?;
        let mut breaks = Vec::new();
        while run.time() < until {
            let report = run.step()?;
            let grown = report.broken.iter().filter(|broken| broken.cause != Cause::Cut);
            breaks.extend(grown.map(|broken| (broken.bond, report.time)));
        }
        let horizon = self.horizon()?.radius();
        Ok(Cracked { nodes, bonds, cut, breaks, horizon, n_steps: run.steps() })
    }
}

/// A plate that has cracked.
#[derive(Debug)]
pub(crate) struct Cracked {
    /// Its nodes.
    pub(crate) nodes: Nodes<2>,
    /// Its bonds.
    pub(crate) bonds: Bonds,
    /// Those that the notches cut.
    pub(crate) cut: Vec<usize>,
    /// Those that broke, and when.
    pub(crate) breaks: Vec<(usize, f64)>,
    /// Length.
    pub(crate) horizon: f64,
    /// How many steps it took.
    pub(crate) n_steps: u64,
}

impl Cracked {
    /// The crack from a notch, as it was at a time.
    pub(crate) fn path(&self, notch: &Notch, until: f64) -> Result<Option<CrackPath>, CaseError> {
        let mut broken = vec![false; self.bonds.len()];
        let grown = self.breaks.iter().filter(|(_, time)| *time <= until);
        for bond in grown.map(|(bond, _)| bond).chain(&self.cut) {
            broken[*bond] = true;
        }
        let Self { nodes, bonds, cut, .. } = self;
        let body = Fractured { nodes, bonds, broken: &broken, cut };
        Ok(crack_path(&body, notch, &PathConfig::of_horizon(self.horizon))?)
    }

    /// The fastest that a crack becomes longer (length over time), its length every `interval`, over four of them.
    pub(crate) fn tip_speed(
        &self,
        notch: &Notch,
        interval: f64,
        count: u32,
    ) -> Result<f64, CaseError> {
        let mut lengths = Vec::new();
        for index in 0..=count {
            if let Some(path) = self.path(notch, interval * f64::from(index))? {
                lengths.push(path.length());
            }
        }
        let speeds = lengths.windows(5).map(|five| (five[4] - five[0]) / (4.0 * interval));
        speeds.reduce(f64::max).ok_or_else(|| "no crack was seen to grow".into())
    }

    /// The share of broken bonds whose images in the middle line across the rows did not break in the same step.
    #[must_use]
    pub(crate) fn asymmetry(&self) -> f64 {
        let columns = self.columns();
        let last = self.nodes.positions().len() / columns - 1;
        let image = |node: usize| (last - node / columns) * columns + node % columns;
        let pairs: Vec<(usize, usize)> = self.bonds.pairs().collect();
        let mut times = vec![f64::NAN; pairs.len()];
        for &(bond, time) in &self.breaks {
            times[bond] = time;
        }
        let alone = self.breaks.iter().filter(|&&(bond, time)| {
            let (i, j) = (image(pairs[bond].0), image(pairs[bond].1));
            let other = pairs.binary_search(&(i.min(j), i.max(j)));
            !other.is_ok_and(|other| times[other].total_cmp(&time).is_eq())
        });
        alone.count() as f64 / self.breaks.len() as f64
    }

    /// Nodes in a row.
    fn columns(&self) -> usize {
        let (x, half) = (self.nodes.positions(), 0.5 * self.nodes.spacing());
        x.partition_point(|place| place[1] < x[0][1] + half)
    }
}
