//! Failed paths are counted and reported, never dropped.

use result_figures::{ErrorKind, Reference};
use sde_integrators::{
    Additive, EnsembleConfig, Error, EulerMaruyama, Observable, Sampling, Sde, SimdLevel, Study,
};

use super::sampled;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/ensembles/failures",
    title: "Euler's method on dX = -X^3 dt + s dB: the paths that explode are counted",
    source: "an independent program in C++, 10,000 paths: fraction of |X| > 1e10 by t = 20, from 0",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// `dX = -X^3 dt + s dB`.
struct Cubic {
    intensity: f64,
}

impl Sde<1, 1> for Cubic {
    type Noise = Additive;

    fn drift(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        [-x * x * x]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.intensity]]
    }
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    let mut n_accepted = 0;
    let cases = [(2.0, 0.2, 0.2382), (4.0, 0.1, 0.4288), (8.0, 0.05, 0.6783)];
    for (intensity, dt, fraction) in cases {
        let config = EnsembleConfig { seed: 12, n_paths: 20_000, dt, times: vec![20.0] };
        let observables = [Observable::Mean(&|_, x: &[f64; 1]| x[0] * x[0])];
        let study = Study {
            name: "cubic",
            system: &Cubic { intensity },
            integrator: &EulerMaruyama,
            law: &[0.0],
            config: &config,
            observables: &observables,
            sampling: Sampling::Independent,
            level: SimdLevel::best(),
        };
        let outcome = study.run::<1>()?;
        let reference_error = (fraction * (1.0 - fraction) / 1e4_f64).sqrt();
        claims.push(Claim::judge(
            context.subject(
                &format!("fraction/s{intensity}-h{dt}"),
                "fraction of paths that fail",
                "",
                "Euler, 20,000 paths",
            ),
            ErrorKind::Absolute,
            sampled(&outcome.failure_probability()?)?,
            Reference::uncertain(fraction, reference_error),
            Criterion::MonteCarlo { bias_bound: 0.0, reason: "the same method on both sides" },
        ));
        let is_refused = matches!(
            outcome.ensemble(),
            Err(Error::PathsFailed { n_failed, .. }) if n_failed == outcome.n_failed
        );
        n_accepted += usize::from(!is_refused);
    }
    claims.push(Claim::same_bits(
        context.subject(
            "refused",
            "estimates given although paths failed",
            "",
            "Outcome::ensemble",
        ),
        n_accepted,
        cases.len(),
        "those that are left are not a sample of the law",
    ));
    Ok(claims)
}
