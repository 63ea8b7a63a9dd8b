//! A body of a user's own: the five required methods of `Body` are enough for every scheme.

use peridyn_sde::{
    AtStrength, Body, BondList, Bonds, Breaking, BrokenBond, Cause, Condition, Error, Loading,
    Nodes, Scheme, Simulation, SimulationConfig, Strain,
};

use crate::fixtures::{bonded, in_time, overdamped};

const STRENGTH: f64 = 0.02;

/// Springs along a line that break at a stretch.
struct Springs {
    nodes: Nodes<1>,
    bonds: Bonds,
    intact: Vec<u16>,
}

impl Body<f64, 1, 1> for Springs {
    fn nodes(&self) -> &Nodes<1> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    fn forces(&mut self, u: &[f64], forces: &mut [f64], at: AtStrength<'_>) -> Result<(), Error> {
        let mut none = Vec::new();
        let (reached, limit) = match at {
            AtStrength::Break(list) => (list, STRENGTH),
            AtStrength::Hold => (&mut none, f64::INFINITY),
        };
        forces.fill(0.0);
        for (bond, ((i, j), of)) in self.bonds.pairs().zip(self.bonds.all()).enumerate() {
            let stretch = (u[j] - u[i]) / of.length;
            if stretch >= limit && self.intact[bond] != 0 {
                reached.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
            } else if self.intact[bond] != 0 {
                forces[i] += of.stiffness * stretch;
                forces[j] -= of.stiffness * stretch;
            }
        }
        Ok(())
    }

    fn intact(&self, bond: usize) -> u16 {
        self.intact[bond]
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        self.intact[bond] = lanes;
    }
}

/// Twenty nodes in a row, each bonded to two others on either side.
fn row() -> (Nodes<1>, Bonds) {
    bonded(20.0, Condition::Bar { area: 1.0 }, 2)
}

fn springs() -> Springs {
    let (nodes, bonds) = row();
    let intact = vec![1; bonds.len()];
    Springs { nodes, bonds, intact }
}

/// What a run in noise ends with: displacements, and when bonds broke. The first bond is cut.
struct End {
    relative_step: f64,
    u: Vec<[f64; 1]>,
    broken: Vec<(u64, usize, Cause)>,
    damage: Vec<f64>,
    energy: f64,
}

fn end(body: impl Body<f64, 1, 1> + 'static, scheme: Scheme) -> End {
    let config = in_time(overdamped(&[true; 20], scheme, 5e-5), 0.2, 3);
    let mut run = Simulation::new(body, Loading::new(20), config, [0]).unwrap();
    run.cut(&[0]).unwrap();
    let mut broken = Vec::new();
    for _ in 0..200 {
        let report = run.step().unwrap();
        broken.extend(report.broken.iter().map(|of| (report.step, of.bond, of.cause)));
    }
    // Continues bitwise identically.
    let saved = run.save().unwrap();
    let _ = run.step().unwrap();
    let after = run.displacements(0);
    run.restore(&saved).unwrap();
    let _ = run.step().unwrap();
    assert_eq!(run.displacements(0), after);
    let relative_step = run.relative_step();
    End { relative_step, u: after, broken, damage: run.damage(0), energy: run.energy(0) }
}

#[test]
fn a_body_of_five_methods_runs_as_the_built_in_one_of_the_same_bonds() {
    let schemes = [Scheme::EulerMaruyama, Scheme::LeimkuhlerMatthews, Scheme::Heun];
    for scheme in schemes.into_iter().chain([Scheme::Theta(0.5)]) {
        let (nodes, bonds) = row();
        let strengths = vec![STRENGTH; bonds.len()];
        let list = BondList::<f64, 1, 1>::new(nodes, bonds, Strain::Linear, &strengths).unwrap();
        let (own, built_in) = (end(springs(), scheme), end(list, scheme));
        // Neither none nor all of the 37 bonds, and the cut one first.
        assert!((5..37).contains(&own.broken.len()), "{scheme:?}: {}", own.broken.len());
        assert_eq!(own.broken[0], (1, 0, Cause::Cut));
        assert_eq!(own.broken, built_in.broken, "{scheme:?}");
        assert_eq!(own.damage, built_in.damage, "{scheme:?}");
        assert!((own.relative_step - built_in.relative_step).abs() < 1e-9, "{scheme:?}");
        let largest = own.u.iter().zip(&built_in.u).map(|(a, b)| (a[0] - b[0]).abs());
        // 200 steps add rounded sums; conjugate gradients stop at a residual of 1e-11.
        assert!(largest.fold(0.0, f64::max) < 1e-10, "{scheme:?}");
        // Finite strains, unless a body says otherwise, differ by about the stretch.
        assert!((own.energy / built_in.energy - 1.0).abs() < STRENGTH, "{scheme:?}");
    }
}

#[test]
fn bonds_of_such_a_body_break_in_forces_alone() {
    let dynamics = overdamped(&[true; 20], Scheme::EulerMaruyama, 3e-4);
    let breaking = Breaking::Bridge;
    let config = SimulationConfig { breaking, ..in_time(dynamics, 0.2, 3) };
    let mut run = Simulation::new(springs(), Loading::new(20), config, [0]).unwrap();
    for _ in 0..50 {
        assert!(run.step().unwrap().broken.is_empty());
    }
}
