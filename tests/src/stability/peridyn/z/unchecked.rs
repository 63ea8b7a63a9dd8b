//! Bodies whose law gives no linear forces: their step is not checked.

use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    BondLaw, Breaking, Dynamics, Error, Mobility, Network as Body, Scheme, Simulation,
    SimulationConfig,
};
use sde_integrators::Noise;

use super::super::{modes, point};
use crate::case::CaseError;
use crate::chart::{Curve, CurvePoint, Curves, Scale, Threshold, Words};
use crate::charts::Drawing;
use crate::peridyn::network::Network;
use crate::stability::axes::linear;
use crate::stability::words_of;

/// The largest distance of a node from rest at the start, about (spacings).
const START: f64 = 1e-3;
/// The strength of bonds that break (a stretch).
const STRENGTH: f64 = 0.1;
const STEPS: u64 = 5000;

/// A spring that never breaks.
#[derive(Debug, Clone, Copy)]
struct Spring;

impl BondLaw for Spring {
    type State = ();

    fn start(&self) {}
    fn cut(&self) {}
    fn advance(&self, _strength: f64, _from: f64, _to: f64, _dt: f64, (): &mut ()) {}
    fn tension(&self, _strength: f64, s: f64, (): &()) -> f64 {
        s
    }
    fn energy(&self, _strength: f64, s: f64, (): &()) -> f64 {
        0.5 * s * s
    }
    fn damage(&self, _strength: f64, (): &()) -> f64 {
        0.0
    }
    fn threshold(&self, _strength: f64, (): &()) -> Option<f64> {
        None
    }
}

/// A run to its end: the largest distance of a node from rest over all steps (spacings), and the share of bonds that broke.
struct End {
    distance: f64,
    broken: f64,
}

/// A chain from the shape of its stiffest mode.
fn follow<L: BondLaw + Send>(
    chain: &Network<1>,
    law: L,
    dynamics: Dynamics,
    dt: f64,
) -> Result<End, CaseError> {
    let strengths = vec![STRENGTH; chain.bonds.len()];
    let body = Body::new(chain.nodes.clone(), chain.bonds.clone(), law, strengths)?;
    let (breaking, confinement, noise) = (Breaking::AtEnds, 0.0, Noise::new(1));
    let config = SimulationConfig { dynamics, dt, breaking, confinement, noise };
    let mut run = Simulation::new(body, chain.loading()?, config, [0])?;
    let (_, mode) = modes(chain.stiffness())?.pop().ok_or("a chain without a mode")?;
    let mut u = vec![[0.0]; chain.free.len()];
    for (at, (node, k)) in chain.unknowns().into_iter().enumerate() {
        u[node][k] = START * mode[at];
    }
    run.set_displacements(0, &u)?;
    let (mut broken, mut distance) = (0.0, 0.0);
    for _ in 0..STEPS {
        broken += run.step()?.broken.len() as f64 / chain.bonds.len() as f64;
        distance = run.displacements(0).iter().map(|[u]| u.abs()).fold(distance, f64::max);
    }
    Ok(End { distance, broken })
}

/// A scheme, or velocity Verlet.
#[derive(Clone, Copy)]
struct Stepped(&'static str, Option<Scheme>);

const STEPPED: [Stepped; 3] = [
    Stepped("Euler-Maruyama", Some(Scheme::EulerMaruyama)),
    Stepped("Heun", Some(Scheme::Heun)),
    Stepped("Verlet", None),
];

impl Stepped {
    fn dynamics(self, mobility: &Mobility) -> Dynamics {
        let (mobility, temperature) = (mobility.clone(), 0.0);
        match self.1 {
            Some(scheme) => Dynamics::Overdamped { mobility, temperature, scheme },
            None => Dynamics::Inertial { density: 1.0, friction: 0.0, temperature },
        }
    }

    fn step(self, z: f64, lambda: f64) -> f64 {
        if self.1.is_some() { z / lambda } else { z / lambda.sqrt() }
    }
}

pub(super) fn chart(is_quick: bool) -> Result<Drawing, CaseError> {
    let chain = Network::chain(10)?;
    let lambda = modes(chain.stiffness())?.pop().ok_or("a chain without a mode")?.0;
    let mobility = Mobility::identity(&chain.free, 1.0)?;
    let mut zs = linear(if is_quick { 4 } else { 11 }, 1.5, 3.0);
    zs.extend([1.98, 2.01, 2.02, 2.05]);
    zs.sort_by(f64::total_cmp);
    let (mut series, mut rows, mut first) = (Vec::new(), Vec::new(), None);
    for (look, of) in STEPPED.into_iter().enumerate() {
        let dynamics = of.dynamics(&mobility);
        let (mut distances, mut shares) = (Vec::new(), Vec::new());
        for &z in &zs {
            let dt = of.step(z, lambda);
            let springs = follow(&chain, Spring, dynamics.clone(), dt);
            if let Err(error) = &springs {
                first.get_or_insert(words_of(error.as_ref()));
            }
            distances.push(point(z, springs.map(|end| end.distance)));
            let breakable = follow(&chain, CriticalStretch, dynamics.clone(), dt);
            shares.push(point(z, breakable.map(|end| end.broken)));
        }
        let row = |points: &[CurvePoint]| -> String {
            let of = |point: &CurvePoint| match point.value() {
                Some(value) => format!(" {:.2}: {value:.1e}", point.x),
                None => format!(" {:.2}: ended", point.x),
            };
            points.iter().map(of).collect()
        };
        rows.push(format!("  {:14} springs, distance {}", of.0, row(&distances)));
        rows.push(format!("  {:14} breakable, share broken {}", of.0, row(&shares)));
        series.push(Curve::marked(format!("{}: springs, distance", of.0), look, distances));
        series.push(Curve::points(format!("{}: share of bonds broken", of.0), look + 3, shares));
    }
    let implicit = Stepped("theta", Some(Scheme::Theta(0.5)));
    rows.push(format!("  theta = 1/2: {}", refusal(&chain, implicit)?));
    rows.extend(first.map(|text| format!("  first end: {text}")));
    let drawing = Drawing::curves("peridyn-z-unchecked", &picture(series))?;
    Ok(Drawing { table: rows.join("\n"), ..drawing })
}

/// What an implicit step says of such a body.
fn refusal(chain: &Network<1>, of: Stepped) -> Result<String, CaseError> {
    let dynamics = of.dynamics(&Mobility::identity(&chain.free, 1.0)?);
    match follow(chain, Spring, dynamics, 0.1) {
        Ok(_) => Err("an implicit step without linear forces".into()),
        Err(error) if error.is::<Error>() => Ok(words_of(error.as_ref())),
        Err(error) => Err(error),
    }
}

fn picture(series: Vec<Curve>) -> Curves {
    Curves {
        words: Words {
            title: "Where no linear forces can be had, a step beyond z = 2 is not refused".into(),
            subtitle: "chain of ten nodes under a law of its own, without noise, 5,000 steps from the stiffest mode, 0.001 spacings".into(),
            x_label: "z = h M λ of the stiffest mode; of Verlet h ω".into(),
            y_label: "distance from rest (spacings); share of bonds".into(),
            caption: vec!["Springs never break: overdamped their nodes swing through each other and nothing is said; under Verlet they end in a typed error with step, time and node. Bonds that break at a stretch of 0.1 break, and nothing is said.".into()],
        },
        across: Scale::Linear,
        upwards: Scale::Log,
        series,
        thresholds: vec![Threshold::across("z = 2", 2.0)],
    }
}
