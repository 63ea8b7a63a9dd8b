//! A block with a flat notch, in tension: by two paths, on any number of threads.

use peridyn_sde::{
    Body, BondConfig, BondList, Bonds, Breaking, Cause, Condition, Dynamics, Horizon, LatticeBody,
    Loading, Nodes, Simulation, SimulationConfig, Strain,
};
use sde_integrators::Noise;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/precracked-block",
    title: "A block with a notch through half of it: lattice against bond list, threads, restart",
    source: "symmetry of the block; two implementations of one law",
    cost: Profile::Default,
    run: Together(run),
};

/// In spacings.
const SIZE: [f64; 3] = [28.0, 12.0, 16.0];
const NOTCH: f64 = 9.0;
/// Critical stretch.
const STRENGTH: f64 = 0.01;
/// Of the three outermost layers to each side, over the speed of waves `sqrt(E/rho)`.
const SPEED: f64 = 2.5e-4;
const N_STEPS: u32 = 390;

struct Block {
    nodes: Nodes<3>,
    bonds: Bonds,
    cut: Vec<usize>,
}

/// What became of it.
struct Pulled {
    /// Bond and step, in ascending order.
    breaks: Vec<(usize, u64)>,
    u: Vec<[f64; 3]>,
}

impl Block {
    fn new() -> CaseResult<Self> {
        let nodes = Nodes::lattice(1.0, ([0.0; 3], SIZE), Condition::Solid, |_| true)?;
        let config = BondConfig::uncorrected(Horizon::of_shells(3, 1.0)?, 1.0);
        let bonds = Bonds::new(&nodes, &config)?;
        let middle = 0.5 * SIZE[2];
        // Beyond the surfaces of the block, so that it is open to three sides.
        let edges = [[NOTCH + 1.0, 0.0, 0.0], [0.0, SIZE[1] + 2.0, 0.0]];
        let cut = bonds.across_plane(&nodes, [-1.0, -1.0, middle], edges)?;
        Ok(Self { nodes, bonds, cut })
    }

    fn lattice(&self) -> CaseResult<LatticeBody<f64, 3>> {
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        Ok(LatticeBody::new(nodes, bonds, Strain::Finite, STRENGTH)?)
    }

    fn list(&self) -> CaseResult<BondList<f64, 3, 1>> {
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        let strengths = vec![STRENGTH; bonds.len()];
        Ok(BondList::new(nodes, bonds, Strain::Finite, &strengths)?)
    }

    fn simulation(
        &self,
        body: impl Body<f64, 3, 1> + 'static,
    ) -> CaseResult<Simulation<f64, 3, 1>> {
        let x = self.nodes.positions();
        let layers = |inside: &dyn Fn(f64) -> bool| {
            (0..x.len()).filter(|&node| inside(x[node][2])).collect::<Vec<usize>>()
        };
        let (top, bottom) = (layers(&|z| z > SIZE[2] - 3.0), layers(&|z| z < 3.0));
        let along = [false, false, true];
        let loading = Loading::new(x.len()).velocity(&top, along, [0.0, 0.0, SPEED])?.velocity(
            &bottom,
            along,
            [0.0, 0.0, -SPEED],
        )?;
        let config = SimulationConfig {
            dynamics: Dynamics::Inertial { density: 1.0, friction: 0.0, temperature: 0.0 },
            dt: 0.6,
            breaking: Breaking::AtEnds,
            confinement: 0.0,
            noise: Noise::new(1),
        };
        let mut run = Simulation::new(body, loading, config, [0])?;
        run.cut(&self.cut)?;
        Ok(run)
    }

    fn pulled(&self, body: impl Body<f64, 3, 1> + 'static) -> CaseResult<Pulled> {
        Self::finished(self.simulation(body)?, 0)
    }

    /// The same, put away in the middle and taken up by another simulation.
    fn restarted(&self) -> CaseResult<Pulled> {
        let mut first = self.simulation(self.lattice()?)?;
        let mut breaks = Vec::new();
        for _ in 0..N_STEPS / 2 {
            let report = first.step()?;
            let grown = report.broken.iter().filter(|broken| broken.cause != Cause::Cut);
            breaks.extend(grown.map(|broken| (broken.bond, report.step)));
        }
        let text = serde_json::to_string(&first.save()?)?;
        let mut second = self.simulation(self.lattice()?)?;
        second.restore(&serde_json::from_str(&text)?)?;
        let mut pulled = Self::finished(second, N_STEPS / 2)?;
        pulled.breaks.extend(breaks);
        pulled.breaks.sort_unstable();
        Ok(pulled)
    }

    fn finished(mut run: Simulation<f64, 3, 1>, done: u32) -> CaseResult<Pulled> {
        let mut breaks = Vec::new();
        for _ in done..N_STEPS {
            let report = run.step()?;
            let grown = report.broken.iter().filter(|broken| broken.cause != Cause::Cut);
            breaks.extend(grown.map(|broken| (broken.bond, report.step)));
        }
        breaks.sort_unstable();
        Ok(Pulled { breaks, u: run.displacements(0) })
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let block = Block::new()?;
    let method = format!(
        "28 x 12 x 16 nodes, horizon 3.015 dx, f64, velocity Verlet, {N_STEPS} steps, nu = 1/4"
    );
    let lines = context.lines("", method);
    let (lattice, list) = (block.pulled(block.lattice()?)?, block.pulled(block.list()?)?);
    let mut claims = against_list(&lines, &lattice, &list);
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let again = pool.install(|| block.pulled(block.lattice()?))?;
        let reason = "every node sums over its own bonds in one order";
        claims.push(same(&lines, &format!("threads-{threads}"), (&lattice, &again), reason));
    }
    let reason = "displacements, velocities, step and whole bonds are all that a run needs to resume; written as JSON and read again half way";
    claims.push(same(&lines, "restart", (&lattice, &block.restarted()?), reason));
    Ok(claims)
}

fn same(lines: &Lines<'_>, id: &str, (one, other): (&Pulled, &Pulled), reason: &str) -> Claim {
    let quantity = "displacements and breaks that differ from those of the run above";
    let differ = |(a, b): &(&f64, &f64)| a.to_bits() != b.to_bits();
    let (ours, theirs) = (one.u.as_flattened(), other.u.as_flattened());
    let n_different =
        ours.iter().zip(theirs).filter(differ).count() + usize::from(one.breaks != other.breaks);
    lines
        .context
        .subject(id, quantity, &lines.method)
        .same_bits(n_different, ours.len() + 1)
        .because(reason)
}

fn against_list(lines: &Lines<'_>, lattice: &Pulled, list: &Pulled) -> Vec<Claim> {
    let alone = |one: &Pulled, other: &Pulled| {
        one.breaks.iter().filter(|&at| other.breaks.binary_search(at).is_err()).count()
    };
    let differ = (alone(lattice, list) + alone(list, lattice)) as f64;
    let both = lattice.u.as_flattened().iter().zip(list.u.as_flattened());
    let largest = lattice.u.as_flattened().iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    let apart = both.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    vec![
        lines
            .of("broken", "bonds that broke")
            .measured(lattice.breaks.len() as f64, (8900.0, 9400.0))
            .because("enough of them that the claims below can fail"),
        lines
            .of("breaks-of-list", "breaks, bond and step, of the lattice or the bond list alone")
            .bounded(differ, 0.0)
            .because("both add the same forces in another order, 1e-15 of the largest"),
        lines
            .of("displacements-of-list", "largest difference of displacements, over the largest")
            .bounded(apart / largest, 1e-13)
            .because("roundoff: 1e-16 of each step over 390 of them, in which the crack does not make it grow much"),
    ]
}
