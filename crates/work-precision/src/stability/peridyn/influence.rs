//! Influence functions: critical step, energy deficit at a surface, energy of a lattice and of a crack.

use peridyn_sde::{
    BondList, Bonds, Breaking, Condition, Dynamics, Horizon, Influence, Loading, Mobility, Nodes,
    Scheme, Simulation, SimulationConfig, Strain, VolumeCorrection,
};
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};
use sde_integrators::Noise;

use crate::context::{CaseError, Context, Profile};
use crate::draw::ChartKind;
use crate::problems::peridyn::lattice::{
    MODULUS, config, energy_of_crack, energy_of_middle, energy_of_node,
};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-influence",
    title: "influence functions over the horizon: critical step, softness of a surface, energies",
    draw,
};

const INFLUENCES: [(&str, Influence); 3] = [
    ("constant", Influence::Constant),
    ("conical", Influence::Conical),
    ("quartic", Influence::Quartic),
];
const PLATE: Condition = Condition::PlaneStress { thickness: 1.0 };

/// Step at `z = 2` of a plate with independent nodes, times `M E t`.
fn critical_step(shells: u32, influence: Influence) -> Result<f64, CaseError> {
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [28.0; 2]), PLATE, |_| true)?;
    let n = nodes.positions().len();
    let horizon = Horizon::of_shells(shells, 1.0)?;
    let bonds = Bonds::new(&nodes, &config(horizon, influence, VolumeCorrection::Ramp))?;
    let strengths = vec![1.0; bonds.len()];
    let body = BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Linear, &strengths)?;
    let mobility = Mobility::identity(&vec![true; n], 1.0)?;
    let (temperature, scheme, dt) = (0.0, Scheme::EulerMaruyama, 1e-6);
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature, scheme },
        dt,
        breaking: Breaking::AtEnds,
        confinement: 0.0,
        noise: Noise::new(1),
    };
    let run = Simulation::new(body, Loading::new(n), config, [0])?;
    Ok(2.0 * dt / run.relative_step() * MODULUS)
}

/// Energy deficit of a strain near an edge, as the depth of a layer without stiffness (horizons).
fn lost_layer(shells: u32, influence: Influence) -> Result<f64, CaseError> {
    let horizon = Horizon::of_shells(shells, 1.0)?;
    let config = config(horizon, influence, VolumeCorrection::Ramp);
    let along = |x: &[f64; 2]| [x[0], 0.0];
    let inside = energy_of_middle::<2>(PLATE, &config, along)?;
    let mut lost = 0.0;
    for layers in 0..=shells {
        let below = -f64::from(layers) - 0.5;
        let here = energy_of_node::<2>(PLATE, &config, along, |x| x[1] > below)?;
        lost += 1.0 - here / inside;
    }
    Ok(lost / horizon.radius())
}

/// Relative errors of the energies of a uniform extension and of a crack.
fn energies(shells: u32, influence: Influence) -> Result<[f64; 2], CaseError> {
    let horizon = Horizon::of_shells(shells, 1.0)?;
    let config = config(horizon, influence, VolumeCorrection::Ramp);
    let uniform = 0.5 * energy_of_middle::<2>(PLATE, &config, |x| *x)?;
    let crack = energy_of_crack::<2>(PLATE, shells, influence)?;
    Ok([uniform / PLATE.energy_of_extension() - 1.0, crack - 1.0])
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let last = if context.profile == Profile::Quick { 3 } else { 8 };
    let [mut steps, mut layers, mut errors] = [const { Vec::<Curve>::new() }; 3];
    let mut rows = Vec::new();
    for (look, (name, influence)) in INFLUENCES.into_iter().enumerate() {
        context.progress(name);
        let [mut step, mut layer, mut uniform, mut crack] = [const { Vec::<CurvePoint>::new() }; 4];
        for shells in 2..=last {
            let m = f64::from(shells) + 0.015;
            let (h, depth) = (critical_step(shells, influence)?, lost_layer(shells, influence)?);
            let [of_extension, of_crack] = energies(shells, influence)?;
            rows.push(format!(
                "  {name:8} m = {m}: critical step {h:.3}/(M E t), lost layer {depth:.3} horizons, extension {:+.2} %, crack {:+.2} %",
                100.0 * of_extension, 100.0 * of_crack
            ));
            step.push(CurvePoint::at(m, h));
            layer.push(CurvePoint::at(m, depth));
            uniform.push(CurvePoint::at(m, 100.0 * of_extension));
            crack.push(CurvePoint::at(m, 100.0 * of_crack));
        }
        steps.push(Curve::marked(name, look, step));
        layers.push(Curve::marked(name, look, layer));
        errors.push(Curve::marked(format!("{name}: uniform extension"), look, uniform));
        errors.push(Curve::marked(format!("{name}: crack"), look + 3, crack));
    }
    let table = rows.join("\n");
    let step = Drawing::curves("peridyn-influence-step", &pictures(Of::Step, steps))?;
    let layer = Drawing::curves("peridyn-influence-surface", &pictures(Of::Surface, layers))?;
    let energy = Drawing::curves("peridyn-influence-energy", &pictures(Of::Energy, errors))?;
    Ok(vec![Drawing { table, ..step }, layer, energy])
}

/// Charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Step,
    Surface,
    Energy,
}

fn pictures(of: Of, series: Vec<Curve>) -> Curves {
    let (title, y_label, foot, thresholds) = match of {
        Of::Step => (
            "A weight that falls with the distance costs smaller steps",
            "critical step, times M E t",
            "z = 2 of the stiffest mode of 28 x 28 nodes, by the power method (0.1 %); M the mobility of a node, E Young's modulus, t the thickness.",
            Vec::new(),
        ),
        Of::Surface => (
            "A weight that falls with the distance loses less at a surface",
            "layer that is lost at an edge, in horizons",
            "Energy of a strain along a straight edge, summed over the nodes near it, against as many inside: the depth of a layer that does not carry.",
            Vec::new(),
        ),
        Of::Energy => (
            "At three shells a crack is 3 % off by constant weights, 9 % by conical ones",
            "energy over what is meant, less one (%)",
            "Of a uniform extension, against the elastic plate; of all bonds across a straight crack at the critical stretch, against G0.",
            vec![Threshold::upwards("as meant", 0.0)],
        ),
    };
    Curves {
        words: Words {
            title: title.into(),
            subtitle: "square lattice in plane stress, ramp of volumes; constant 1, conical 1 - q, quartic (1 - q²)², q = r/δ".into(),
            x_label: "horizon over spacing, m".into(),
            y_label: y_label.into(),
            caption: vec![foot.into()],
        },
        across: Scale::Linear,
        upwards: Scale::Linear,
        series,
        thresholds,
    }
}
