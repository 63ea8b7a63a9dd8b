//! Moments and tail of the normals that drive all integrators.

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{Noise, Purpose};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/normals",
    title: "Mean, variance, fourth moment, correlation of a pair and P(|z| > 3) of eight million normals",
    source: "the standard normal distribution",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: |context| Ok::<_, CaseError>(run(context)),
};

const PAIRS: u32 = 1 << 22;

/// `2 (1 - Phi(3))`.
const BEYOND: f64 = 0.002_699_796_063_260_19;

fn run(context: &Context<'_>) -> Vec<Claim> {
    let mut stream = Noise::new(91).stream(Purpose::InitialDistribution, 0);
    let (mut sums, mut beyond, mut product) = ([0.0; 4], 0_u32, 0.0);
    for _ in 0..PAIRS {
        let pair = stream.next_normal_pair();
        for z in pair {
            let mut power = 1.0;
            for sum in &mut sums {
                power *= z;
                *sum += power;
            }
            beyond += u32::from(z.abs() > 3.0);
        }
        product += pair[0] * pair[1];
    }
    let n = 2.0 * f64::from(PAIRS);
    // Standard errors of the exact distribution: Var z = 1, Var z^2 = 2, Var z^3 = 15, Var z^4 = 96, Var(z_0 z_1) = 1.
    let rows = [
        ("mean", "E[z]", sums[0] / n, 0.0, 1.0 / n),
        ("variance", "E[z^2]", sums[1] / n, 1.0, 2.0 / n),
        ("third-moment", "E[z^3]", sums[2] / n, 0.0, 15.0 / n),
        ("fourth-moment", "E[z^4]", sums[3] / n, 3.0, 96.0 / n),
        ("pair", "E[z_0 z_1] of a pair", product / f64::from(PAIRS), 0.0, 2.0 / n),
        ("beyond-3", "P(|z| > 3)", f64::from(beyond) / n, BEYOND, BEYOND * (1.0 - BEYOND) / n),
    ];
    rows.map(|(name, quantity, value, exact, variance)| {
        let method = "Box and Muller's transform, 2^23 normals";
        Claim::judge(
            context.subject(name, quantity, "", method),
            ErrorKind::Absolute,
            Measured::sampled(value, variance.sqrt()),
            Reference::exact(exact),
            Criterion::MonteCarlo {
                bias_bound: 1e-7,
                reason: "statistics: four standard errors of the sample; angles and radii have 52 bits",
            },
        )
    })
    .to_vec()
}
