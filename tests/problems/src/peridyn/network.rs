//! Small networks whose bonds are linear: their matrices, and the maps that steps of schemes are.

use nalgebra::DMatrix;
use peridyn_sde::{
    BondConfig, BondList, Bonds, Breaking, Condition, Dynamics, Error, Horizon, Influence, Loading,
    Mobility, Nodes, Real, Simulation, SimulationConfig, Strain, SurfaceCorrection,
    VolumeCorrection,
};
use sde_integrators::{LaneNormals, Noise, Purpose};

/// A network some of whose nodes are held.
#[derive(Debug, Clone)]
pub struct Network<const D: usize> {
    /// Its nodes.
    pub nodes: Nodes<D>,
    /// Its bonds.
    pub bonds: Bonds,
    /// Which nodes are free.
    pub free: Vec<bool>,
    /// `epsilon` of its runs (force over length).
    pub confinement: f64,
    /// Bonds that are cut before its runs begin.
    pub cut: Vec<usize>,
}

impl Network<1> {
    /// A chain of `n` free nodes and one held, with springs of stiffness one.
    pub fn chain(n: usize) -> Result<Self, Error> {
        let held = |x: &[f64; 1]| x[0] < 1.0;
        Self::lattice(([0.0], [n as f64 + 1.0]), Condition::Bar { area: 1.0 }, 1, held)
    }
}

impl Network<2> {
    /// A square of `side` nodes, whose first column is held.
    pub fn square(side: usize, shells: u32) -> Result<Self, Error> {
        let corner = [side as f64; 2];
        let condition = Condition::PlaneStress { thickness: 1.0 };
        Self::lattice(([0.0; 2], corner), condition, shells, |x| x[0] < 1.0)
    }
}

impl<const D: usize> Network<D> {
    /// Nodes one apart, the shortest bonds of stiffness one.
    fn lattice(
        corners: ([f64; D], [f64; D]),
        condition: Condition,
        shells: u32,
        held: impl Fn(&[f64; D]) -> bool,
    ) -> Result<Self, Error> {
        let nodes = Nodes::lattice(1.0, corners, condition, |_| true)?;
        let config = |young_modulus| {
            Ok::<_, Error>(BondConfig {
                horizon: Horizon::of_shells(shells, 1.0)?,
                young_modulus,
                influence: Influence::Constant,
                volume_correction: VolumeCorrection::None,
                surface_correction: SurfaceCorrection::None,
            })
        };
        let of_one = Bonds::new(&nodes, &config(1.0)?)?.all()[0].stiffness;
        let bonds = Bonds::new(&nodes, &config(1.0 / of_one)?)?;
        let free = nodes.positions().iter().map(|x| !held(x)).collect();
        Ok(Self { nodes, bonds, free, confinement: 0.0, cut: Vec::new() })
    }

    /// How many components of free nodes there are.
    #[must_use]
    pub fn n_unknowns(&self) -> usize {
        D * self.free.iter().filter(|&&free| free).count()
    }

    /// Node and component of each unknown.
    #[must_use]
    pub fn unknowns(&self) -> Vec<(usize, usize)> {
        let free = (0..self.free.len()).filter(|&node| self.free[node]);
        free.flat_map(|node| (0..D).map(move |k| (node, k))).collect()
    }

    /// Nodes that are held.
    #[must_use]
    pub fn held(&self) -> Vec<usize> {
        (0..self.free.len()).filter(|&node| !self.free[node]).collect()
    }

    /// `K` of the free components, of the bonds that are not cut and without confinement.
    #[must_use]
    pub fn stiffness(&self) -> DMatrix<f64> {
        let unknowns = self.unknowns();
        let n = unknowns.len();
        let mut number = vec![None; self.free.len() * D];
        for (at, &(node, k)) in unknowns.iter().enumerate() {
            number[node * D + k] = Some(at);
        }
        let mut matrix = DMatrix::zeros(n, n);
        for (bond, ((i, j), of)) in self.bonds.pairs().zip(self.bonds.all()).enumerate() {
            if self.cut.contains(&bond) {
                continue;
            }
            let (a, b) = (self.nodes.positions()[i], self.nodes.positions()[j]);
            for k in 0..D {
                for l in 0..D {
                    let direction = (b[k] - a[k]) * (b[l] - a[l]) / (of.length * of.length);
                    let entry = of.stiffness / of.length * direction;
                    for (one, other, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)]
                    {
                        if let (Some(row), Some(column)) =
                            (number[one * D + k], number[other * D + l])
                        {
                            matrix[(row, column)] += sign * entry;
                        }
                    }
                }
            }
        }
        matrix
    }

    /// `L` of a mobility, over the free components: a row per unknown, a column per motion.
    pub fn factor(&self, mobility: &Mobility) -> Result<DMatrix<f64>, Error> {
        let (unknowns, m) = (self.unknowns(), mobility.n_motions() * D);
        let mut factor = DMatrix::zeros(unknowns.len(), m);
        let (mut z, mut out) = (vec![0.0; m], vec![0.0; self.free.len() * D]);
        for motion in 0..m {
            z[motion] = 1.0;
            mobility.apply_factor(D, &z, &mut out)?;
            z[motion] = 0.0;
            for (row, &(node, k)) in unknowns.iter().enumerate() {
                factor[(row, motion)] = out[node * D + k];
            }
        }
        Ok(factor)
    }

    /// A run of one realisation with linear bonds that never break.
    pub fn run(
        &self,
        dynamics: Dynamics,
        dt: f64,
        noise: Noise,
    ) -> Result<Simulation<f64, D, 1>, Error> {
        let strengths = vec![1e6; self.bonds.len()];
        let body = BondList::<f64, D, 1>::new(
            self.nodes.clone(),
            self.bonds.clone(),
            Strain::Linear,
            &strengths,
        )?;
        let (breaking, confinement) = (Breaking::AtEnds, self.confinement);
        let config = SimulationConfig { dynamics, dt, breaking, confinement, noise };
        let mut run = Simulation::new(body, self.loading()?, config, [0])?;
        run.cut(&self.cut)?;
        Ok(run)
    }

    /// The held nodes held.
    pub fn loading(&self) -> Result<Loading<D>, Error> {
        Loading::new(self.free.len()).hold(&self.held())
    }

    /// The matrix of one step without noise, column by column from a unit displacement of each unknown; where `of` is of inertial
    /// dynamics, of displacements and velocities one after the other.
    pub fn map_of_step(&self, of: &Dynamics, dt: f64) -> Result<DMatrix<f64>, Error> {
        let unknowns = self.unknowns();
        let n = unknowns.len();
        let inertial = matches!(of, Dynamics::Inertial { .. });
        let size = if inertial { 2 * n } else { n };
        let mut map = DMatrix::zeros(size, size);
        for column in 0..size {
            let mut run = self.run(of.clone(), dt, Noise::new(0))?;
            let mut unit = vec![[0.0; D]; self.free.len()];
            let (node, k) = unknowns[column % n];
            unit[node][k] = 1.0;
            if column < n {
                run.set_displacements(0, &unit)?;
            } else {
                run.set_velocities(0, &unit)?;
            }
            let _ = run.step()?;
            let (u, v) = (run.displacements(0), run.velocities(0));
            for (row, &(node, k)) in unknowns.iter().enumerate() {
                map[(row, column)] = u[node][k];
                if inertial {
                    map[(n + row, column)] = v[node][k];
                }
            }
        }
        Ok(map)
    }

    /// The displacements after the first step from rest, and the normals that drove it: of the step, and of the areas.
    pub fn first_kick(
        &self,
        dynamics: Dynamics,
        dt: f64,
        n_motions: usize,
    ) -> Result<[Vec<f64>; 3], Error> {
        let noise = Noise::new(77);
        let mut run = self.run(dynamics, dt, noise)?;
        let _ = run.step()?;
        let u = run.displacements(0);
        let u = self.unknowns().into_iter().map(|(node, k)| u[node][k]).collect();
        let normals = |purpose| {
            let mut z = vec![0.0; n_motions];
            LaneNormals::new(&noise, purpose, [0]).fill(0, n_motions, 0..n_motions, &mut z);
            z
        };
        Ok([u, normals(Purpose::Path), normals(Purpose::PathArea)])
    }
}

/// The covariance `S = A S A^T + Q` of a linear map driven by noise of the covariance `Q`, by doubling.
#[must_use]
pub fn stationary(map: &DMatrix<f64>, noise: &DMatrix<f64>) -> DMatrix<f64> {
    let (mut power, mut sum) = (map.clone(), noise.clone());
    for _ in 0..60 {
        sum = &sum + &power * &sum * power.transpose();
        power = &power * &power;
        if power.amax() < 1e-30 {
            break;
        }
    }
    sum
}

/// The largest entry of a difference over the largest of the second matrix.
#[must_use]
pub fn distance(found: &DMatrix<f64>, exact: &DMatrix<f64>) -> f64 {
    (found - exact).amax() / exact.amax()
}

/// The stiffest mode of a body per unit of time, by a step so small that any scheme takes it.
pub fn rate<const D: usize>(network: &Network<D>, dynamics: &Dynamics) -> Result<f64, Error> {
    let dt = 1e-6;
    let z = network.run(dynamics.clone(), dt, Noise::new(0))?.relative_step();
    let inertial = matches!(dynamics, Dynamics::Inertial { .. });
    Ok(if inertial { z.sqrt() / dt } else { z / dt })
}

/// Half of the bonds' energy is that of the body: `sum k n^T cov n` over bonds, Foster's identity.
#[must_use]
pub fn foster<const D: usize>(network: &Network<D>, covariance: &DMatrix<f64>) -> f64 {
    (network.stiffness() * covariance).trace()
}

/// The bonds of a network as a body in lanes, linear, of one strength.
pub fn lanes<const D: usize, const L: usize>(
    network: &Network<D>,
    strength: f64,
) -> Result<BondList<f64, D, L>, Error> {
    lanes_of(network, strength)
}

/// The same in numbers of any precision.
pub fn lanes_of<T: Real, const D: usize, const L: usize>(
    network: &Network<D>,
    strength: f64,
) -> Result<BondList<T, D, L>, Error> {
    let strengths = vec![strength; network.bonds.len()];
    BondList::new(network.nodes.clone(), network.bonds.clone(), Strain::Linear, &strengths)
}
