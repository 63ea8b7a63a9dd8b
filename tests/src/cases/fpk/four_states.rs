//! The error that a density of four states states against the error that it makes: two lattices, and one with slower settling.

use fpk_sph::systems::Filtered;
use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};
use scenes::fpk::system::System;
use sde_integrators::{Additive, GaussianMixture, Sde};

use super::conditioned::{CubicSpring, Derived, Paths};
use super::scene;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/errors-of-four-states",
    title: "Estimated over true error of second moments in four states, by two lattices alone and with a run of slower settling",
    source: "2e6 to 4e6 paths of Heun's method by an independent program",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

/// Of the coarser lattice over the finer one.
const RATIO: f64 = std::f64::consts::SQRT_2;
/// A true error below this many errors of its reference is not known.
const KNOWN: f64 = 4.0;
const MOMENTS: [[u32; 4]; 2] = [[2, 0, 0, 0], [0, 2, 0, 0]];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let derived = Derived::read()?;
    context.progress("cubic spring");
    let (system, law) = CubicSpring::behind_soil()?;
    let cubic = Indices::of(&system, &law, &derived.cubic_spring)?;
    let mut claims = cubic.claims(context, "cubic-spring", [BOUNDS, BOUNDS]);
    context.progress("damper");
    let text = include_str!("../../../scenes/fpk/damper_kanai_tajimi.json");
    let scene = scene("tests/scenes/fpk/damper_kanai_tajimi.json", text)?;
    let built = scene.system.build()?;
    let System::KanaiTajimiDamper(system) = &built else {
        return Err("the scene holds another system".into());
    };
    let law = scene.initial.build(built.filter_covariance().as_deref())?;
    let damper = Indices::of(system, &law, &derived.viscous_damper)?;
    claims.extend(damper.claims(context, "viscous-damper", [BOUNDS, BOUNDS]));
    Ok(claims)
}

const BOUNDS: (f64, f64) = (0.0, 1.0);

/// Estimated over true errors, by two lattices and with slower settling.
struct Indices {
    names: Vec<String>,
    two: Vec<f64>,
    three: Vec<f64>,
}

impl Indices {
    fn of<S>(
        system: &Filtered<S, 2, 2>,
        law: &GaussianMixture<4>,
        paths: &Paths,
    ) -> Result<Self, CaseError>
    where
        S: Sde<2, 1, Noise = Additive> + Clone,
    {
        let config = |spacing: f64| Config {
            method: Method::FlowMapFit,
            lattice: InitialLattice::Ball { reach: 5.0, spacing },
            reference_period: 2.0,
            most_steps: DEFAULT_MOST_STEPS,
        };
        let slow = config(RATIO).with_slower_settling().ok_or("the method does not settle")?;
        let mut runs = Vec::new();
        for config in [config(1.0), config(RATIO), slow] {
            let mut simulation = Simulation::new(system.clone(), law, &config)?;
            let mut values = Vec::new();
            for row in &paths.rows {
                simulation.advance_to(row.t)?;
                values.extend(MOMENTS.map(|powers| simulation.raw_moment(powers)));
            }
            runs.push(values);
        }
        let mut found = Self { names: Vec::new(), two: Vec::new(), three: Vec::new() };
        let square = RATIO * RATIO;
        let references = paths.rows.iter().flat_map(|row| {
            [("E[q^2]", 0), ("E[v^2]", 1)].map(|(name, k)| (name, row.t, row.second_moments[k]))
        });
        for (k, (name, t, [value, error])) in references.enumerate() {
            let [fine, coarse, slow] = [0, 1, 2].map(|run: usize| runs[run][k]);
            let made = (fine - value).abs();
            if made <= KNOWN * error {
                continue;
            }
            let by_two = (fine - coarse).abs() / (square - 1.0);
            let by_settling = 2.0 * (coarse - slow).abs() / square;
            found.names.push(format!("{name} t{t}"));
            found.two.push(by_two / made);
            found.three.push(by_two.hypot(by_settling) / made);
        }
        Ok(found)
    }

    /// The share of errors that are told less than half as large as they are.
    fn claims(
        &self,
        context: &Context<'_>,
        name: &str,
        [two, three]: [(f64, f64); 2],
    ) -> Vec<Claim> {
        let of = |id: &str, values: &[f64], band: (f64, f64), reason: &str| {
            let each = self.names.iter().zip(values);
            let words: Vec<String> =
                each.map(|(name, value)| format!("{name} {value:.2}")).collect();
            let method = format!("estimated over true error: {}", words.join(", "));
            let id = format!("{name}/{id}");
            let lines = Lines { context, id: &id, method };
            let share = |is: &dyn Fn(f64) -> bool| {
                values.iter().filter(|value| is(**value)).count() as f64 / values.len() as f64
            };
            vec![lines.measured(
                ("too-small", "share of estimates below half of the true error", ""),
                share(&|index| index < 0.5),
                band,
                reason,
            )]
        };
        [
            of("two-lattices", &self.two, two, "two coarse lattices share the error of settling"),
            of("with-slower-settling", &self.three, three, "what scenes of four states state"),
        ]
        .concat()
    }
}
