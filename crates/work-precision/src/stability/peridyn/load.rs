//! Loading rate limit of a plate, with and without the affine predictor.

use peridyn_sde::{
    BondConfig, Bonds, Breaking, Cause, Condition, Dynamics, Horizon, LatticeBody, Loading,
    Mobility, Nodes, Program, Scheme, Simulation, SimulationConfig, Strain,
};
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};
use sde_integrators::Noise;

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-load",
    title: "a notched plate under tension in a number of overdamped steps: where its bonds break",
    draw,
};

const STRENGTH: f64 = 0.01;
/// Mean strain at the end, over the strength.
const STRAIN: f64 = 0.5;
const NOTCH: f64 = 0.3;
const Z: f64 = 0.9;
const SHELLS: u32 = 3;
const PREDICTORS: [(&str, Pull); 2] =
    [("affine predictor", Pull::Predicted), ("edges alone", Pull::Grips)];

/// Nodes that follow the prescribed displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pull {
    /// All nodes, by the affine field.
    Predicted,
    /// Only the edge regions.
    Grips,
}

/// A square plate of unit width, with a notch at half height on the left.
struct Plate {
    nodes: Nodes<2>,
    bonds: Bonds,
    per_edge: usize,
    cut: Vec<usize>,
    /// Step for `z` with Euler's method.
    dt: f64,
}

/// Broken bonds.
struct Broken {
    /// Fraction of all bonds near the centre line, and near the loaded edges; the remainder is between.
    middle: f64,
    grips: f64,
    all: f64,
    /// Fraction of the columns ahead of the notch that separated.
    crack: f64,
}

impl Plate {
    fn new(per_edge: usize) -> Result<Self, CaseError> {
        let dx = 1.0 / per_edge as f64;
        let condition = Condition::PlaneStress { thickness: 1.0 };
        let nodes = Nodes::lattice(dx, ([0.0; 2], [1.0; 2]), condition, |_| true)?;
        let config = BondConfig::uncorrected(Horizon::of_shells(SHELLS, dx)?, 1.0);
        let bonds = Bonds::new(&nodes, &config)?;
        let cut = bonds.across_segment(&nodes, ([-dx, 0.5], [NOTCH, 0.5]))?;
        let mut plate = Self { nodes, bonds, per_edge, cut, dt: 1e-6 };
        plate.dt *= Z / plate.run(Pull::Grips, 1.0)?.relative_step();
        Ok(plate)
    }

    /// Rows of the edge regions, as many as in a horizon.
    fn grips(&self) -> [Vec<usize>; 2] {
        let (n, rows) = (self.per_edge, SHELLS as usize);
        [(0..rows * n).collect(), ((n - rows) * n..n * n).collect()]
    }

    /// Loads the plate in tension until a time.
    fn run(&self, pull: Pull, until: f64) -> Result<Simulation<f64, 2, 1>, CaseError> {
        let [low, high] = self.grips();
        let (n, rate) = (self.per_edge * self.per_edge, STRAIN * STRENGTH / until);
        let ramp = Program::Ramp { rate, until };
        let loading = match pull {
            Pull::Predicted => {
                let gripped = [low, high].concat();
                let gradient = [[0.0, 0.0], [0.0, 1.0]];
                Loading::new(n).stretch(&self.nodes, &gripped, [true; 2], gradient, ramp)?
            }
            Pull::Grips => {
                Loading::new(n).hold(&low)?.displace(&high, [true; 2], [0.0, 1.0], ramp)?
            }
        };
        let free: Vec<bool> = loading.prescribed().iter().map(|of| of == &[false; 2]).collect();
        let (mobility, scheme) = (Mobility::identity(&free, 1.0)?, Scheme::EulerMaruyama);
        let config = SimulationConfig {
            dynamics: Dynamics::Overdamped { mobility, temperature: 0.0, scheme },
            dt: self.dt,
            breaking: Breaking::AtEnds,
            confinement: 0.0,
            noise: Noise::new(1),
        };
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        let body = LatticeBody::<f64, 2>::new(nodes, bonds, Strain::Linear, STRENGTH)?;
        let mut run = Simulation::new(body, loading, config, [0])?;
        run.cut(&self.cut)?;
        Ok(run)
    }

    fn pulled(&self, pull: Pull, steps: u64) -> Result<Broken, CaseError> {
        let mut run = self.run(pull, steps as f64 * self.dt)?;
        let mut broken = vec![false; self.bonds.len()];
        for _ in 0..steps {
            for event in run.step()?.broken {
                broken[event.bond] |= event.cause != Cause::Cut;
            }
        }
        Ok(self.judge(&broken))
    }

    fn judge(&self, broken: &[bool]) -> Broken {
        let (n, dx) = (self.per_edge, self.nodes.spacing());
        let reach = (f64::from(SHELLS) + 0.5) * dx;
        let total = self.bonds.len() as f64;
        let [mut middle, mut grips, mut all] = [0.0; 3];
        let mut parted = vec![false; n];
        for ((i, j), _) in self.bonds.pairs().zip(broken).filter(|(_, broken)| **broken) {
            let [a, b] = [i, j].map(|node| self.nodes.positions()[node]);
            let height = 0.5 * (a[1] + b[1]);
            all += 1.0 / total;
            if (height - 0.5).abs() < reach {
                middle += 1.0 / total;
            } else if height.min(1.0 - height) < 2.0 * reach {
                grips += 1.0 / total;
            }
            let is_upright = j == i + n;
            if is_upright && (height - 0.5).abs() < reach {
                parted[i % n] = true;
            }
        }
        let row = &self.nodes.positions()[..n];
        let first = row.partition_point(|x| x[0] < NOTCH);
        let ahead = parted[first..].iter().take_while(|&&parted| parted).count();
        Broken { middle, grips, all, crack: ahead as f64 / (n - first) as f64 }
    }
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let plate = Plate::new(if is_quick { 24 } else { 48 })?;
    let steps: &[u64] =
        if is_quick { &[100, 1000] } else { &[300, 600, 1250, 2500, 5000, 10_000, 20_000] };
    let (mut crack, mut places, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for (look, (name, pull)) in PREDICTORS.into_iter().enumerate() {
        let [mut ahead, mut middle, mut grips] = [const { Vec::<CurvePoint>::new() }; 3];
        for &count in steps {
            context.progress(&format!("{name}, {count} steps"));
            let found = plate.pulled(pull, count)?;
            let x = count as f64;
            rows.push(format!(
                "  {name:16} {count:6} steps: {:5.1} % of the columns parted; broken {:.2} %, of them {:.2} near the notch's line, {:.2} near the edges",
                100.0 * found.crack, 100.0 * found.all, 100.0 * found.middle, 100.0 * found.grips
            ));
            ahead.push(CurvePoint::at(x, 100.0 * found.crack));
            middle.push(CurvePoint::at(x, 100.0 * found.middle));
            grips.push(CurvePoint::at(x, 100.0 * found.grips));
        }
        crack.push(Curve::marked(name, look, ahead));
        places.push(Curve::marked(format!("{name}: near the line of the notch"), look, middle));
        places.push(Curve::marked(format!("{name}: near the edges"), look + 2, grips));
    }
    let table = rows.join("\n");
    let crack = Drawing::curves("peridyn-load-crack", &picture(&plate, Of::Crack, crack))?;
    let places = Drawing::curves("peridyn-load-places", &picture(&plate, Of::Places, places))?;
    Ok(vec![Drawing { table, ..crack }, places])
}

/// Charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Crack,
    Places,
}

fn picture(plate: &Plate, of: Of, series: Vec<Curve>) -> Curves {
    let n = plate.per_edge;
    let (title, y_label) = match of {
        Of::Crack => (
            "In n² steps a crack comes half way; in four times as many it is through",
            "columns in front of the notch that parted (%)",
        ),
        Of::Places => (
            "Loaded fast at its edges alone, a plate breaks there and not at its notch",
            "broken bonds, of all (%)",
        ),
    };
    Curves {
        words: Words {
            title: title.into(),
            subtitle: format!(
                "{n} x {n} nodes, notch of {NOTCH} of the width, overdamped without noise, z = {Z}; mean strain to {STRAIN} of the strength"
            ),
            x_label: "steps of the ramp".into(),
            y_label: y_label.into(),
            caption: vec![format!(
                "The prescribed displacement travels inwards over n² steps, {} here; with the predictor every node moves at once, and relaxation only follows the crack.",
                n * n
            )],
        },
        across: Scale::Log,
        upwards: Scale::Linear,
        series,
        thresholds: vec![Threshold::across("n² steps", (n * n) as f64)],
    }
}
