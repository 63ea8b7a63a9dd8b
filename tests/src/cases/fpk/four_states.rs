//! The error that a density of four states states against the error that it makes: by two lattices, and with a run of slower
//! settling, where settling has the period of the structure and where it has that of the soil.

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};

use super::conditioned::{CubicSpring, Derived};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/errors-of-four-states",
    title: "Cubic spring, quadratic damper and soil in four states: estimated over true error of second moments",
    source: "2e6 paths of Heun's method by an independent program",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

/// Period of the structure, and of the soil (s).
const STRUCTURE: f64 = 2.0;
const SOIL: f64 = 0.4;
/// Of the coarser lattice over the finer one.
const RATIO: f64 = std::f64::consts::SQRT_2;
/// A true error below this many errors of its reference is not known.
const KNOWN: f64 = 4.0;
const MOMENTS: [(&str, [u32; 4]); 2] = [("E[q^2]", [2, 0, 0, 0]), ("E[v^2]", [0, 2, 0, 0])];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let derived = Derived::read()?;
    let mut claims = Vec::new();
    for (id, period, largest, too_small) in [
        ("settling-of-structure", STRUCTURE, (0.0, 0.02), [(0.0, 0.1), (0.0, 0.1)]),
        ("settling-of-soil", SOIL, (0.02, 0.12), [(0.3, 1.0), (0.0, 0.3)]),
    ] {
        context.progress(id);
        let runs = Runs::new(period, &derived)?;
        claims.extend(runs.claims(context, id, largest, too_small));
    }
    Ok(claims)
}

/// Second moments at some times, by the fine lattice, a coarser one, and that with slower settling.
struct Runs {
    /// Of each moment at each time.
    names: Vec<String>,
    values: [Vec<f64>; 3],
    /// With their standard errors.
    references: Vec<[f64; 2]>,
}

impl Runs {
    fn new(settling: f64, derived: &Derived) -> Result<Self, CaseError> {
        let (system, law) = CubicSpring::behind_soil()?;
        let config = |spacing: f64| {
            // Steps of 0.05 s resolve the soil too.
            let config = Config {
                method: Method::FlowMapFit,
                lattice: InitialLattice::Ball { reach: 5.0, spacing },
                reference_period: STRUCTURE,
                most_steps: DEFAULT_MOST_STEPS,
            };
            config.with_settling_in(settling).ok_or("the method does not settle")
        };
        let slow = config(RATIO)?.with_slower_settling().ok_or("the method does not settle")?;
        let run = |config: &Config<4>| -> Result<Vec<f64>, CaseError> {
            let mut simulation = Simulation::new(system.clone(), &law, config)?;
            let mut values = Vec::new();
            for row in &derived.cubic_spring.rows {
                simulation.advance_to(row.t)?;
                values.extend(MOMENTS.map(|(_, powers)| simulation.raw_moment(powers)));
            }
            Ok(values)
        };
        let rows = derived.cubic_spring.rows.iter();
        let names =
            rows.clone().flat_map(|row| MOMENTS.map(|(name, _)| format!("{name} t{}", row.t)));
        Ok(Self {
            names: names.collect(),
            values: [run(&config(1.0)?)?, run(&config(RATIO)?)?, run(&slow)?],
            references: rows.flat_map(|row| row.second_moments.clone()).collect(),
        })
    }

    fn claims(
        &self,
        context: &Context<'_>,
        id: &str,
        largest: (f64, f64),
        [two, three]: [(f64, f64); 2],
    ) -> Vec<Claim> {
        let [fine, coarse, slow] = &self.values;
        let square = RATIO * RATIO;
        let (mut most, mut by_two, mut by_three, mut words) =
            (0.0, Vec::new(), Vec::new(), String::new());
        for (k, &[value, error]) in self.references.iter().enumerate() {
            let made = (fine[k] - value).abs();
            most = f64::max(most, made / value);
            if made > KNOWN * error {
                let lattices = (fine[k] - coarse[k]).abs() / (square - 1.0);
                let settling = 2.0 * (coarse[k] - slow[k]).abs() / square;
                by_two.push(lattices / made);
                by_three.push(lattices.hypot(settling) / made);
                let [two, three] = [&by_two, &by_three].map(|all| all[all.len() - 1]);
                words += &format!(", {} {two:.2} and {three:.2}", self.names[k]);
            }
        }
        let method = format!("flow-map fit, 3121 particles; estimated over true error{words}");
        let lines = Lines { context, id, method };
        let share = |indices: &[f64]| {
            indices.iter().filter(|&&index| index < 0.5).count() as f64 / indices.len() as f64
        };
        let shared = "two coarse lattices share the error of settling";
        vec![
            lines.measured(
                ("moments", "largest error of a second moment, relative", ""),
                most,
                largest,
                shared,
            ),
            lines.measured(
                ("two-lattices/too-small", "share of estimates below half of the true error", ""),
                share(&by_two),
                two,
                shared,
            ),
            lines.measured(
                (
                    "slower-settling/too-small",
                    "the same with the part of settling, as scenes state it",
                    "",
                ),
                share(&by_three),
                three,
                "the part of settling is seen on the coarser lattice",
            ),
        ]
    }
}
