//! Bitwise identical on any number of threads, in numbers and with derivatives.

use smpm::uncertainty::Study;
use work_precision::problems::smpm::problems::{Problem, experiment};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smpm/invariance",
    title: "The explosion on 1, 2 and 8 threads",
    source: "by construction: every entry is written once, sums have one order",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// Responses in numbers and slopes with derivatives, as bits.
fn bits(n_threads: usize) -> Result<[Vec<u64>; 2], CaseError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build()?;
    pool.install(|| {
        let scene = Problem::ContactExplosion.scene_with(0.05, &[8.0])?;
        let experiment = experiment::<2>(&scene)?;
        let study = Study::new(&experiment, scene.inputs()?, scene.plan::<2>()?)?;
        let moments = study.propagated()?.moments;
        let slopes = moments.iter().flat_map(|moments| *moments.slopes());
        Ok([
            study.centre().iter().map(|value| value.to_bits()).collect(),
            slopes.map(f64::to_bits).collect(),
        ])
    })
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let one = bits(1)?;
    let mut claims = Vec::new();
    for n_threads in [2, 8] {
        context.progress(&format!("{n_threads} threads"));
        let other = bits(n_threads)?;
        for (k, name) in ["numbers", "derivatives"].into_iter().enumerate() {
            let different = one[k].iter().zip(&other[k]).filter(|(a, b)| a != b).count();
            claims.push(Claim::same_bits(
                context.subject(
                    &format!("threads{n_threads}/{name}"),
                    "responses that differ in a bit",
                    "",
                    "against one thread",
                ),
                different,
                one[k].len().min(other[k].len()),
                "no atomics, and sums whose shape the number of particles alone decides",
            ));
        }
    }
    Ok(claims)
}
