//! Bitwise identical for any number of threads, any division into shards, every level of instructions, and after a file.

use sde_integrators::{
    Ensemble, EnsembleConfig, Error, GaussianMixture, Observable, Outcome, ShardRecord, SimdLevel,
    StrangOscillator, Study, Uncertainty, merge,
};

use super::Oscillator;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/ensembles/reproducibility",
    title: "Ensembles: bitwise identical on 1, 2 and 8 threads, in shards, at every level of instructions",
    source: "by construction: sums over fixed blocks of paths in a tree of fixed shape",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const OSCILLATOR: Oscillator = Oscillator { omega: 2.0, xi: 0.05, intensity: 1.0 };

/// Calls `look` with the study; its functions live only here.
fn with_study<T>(
    name: &str,
    seed: u64,
    level: SimdLevel,
    look: impl FnOnce(
        &Study<'_, Oscillator, StrangOscillator, GaussianMixture<2>, 2>,
    ) -> Result<T, CaseError>,
) -> Result<T, CaseError> {
    let law = GaussianMixture::independent([0.1, 0.0], [0.3, 0.5])?;
    let config =
        EnsembleConfig { seed, n_paths: 5 * 4096 + 77, dt: 0.1, times: vec![1.0, 2.3, 5.0] };
    let exceeds = |_: f64, x: &[f64; 2]| x[0] > 0.8;
    let observables = [
        Observable::Mean(&|_, x| x[0] * x[0]),
        Observable::Probability(&exceeds),
        Observable::Mean(&|_, x| x[0].powi(3)),
    ];
    look(&Study {
        name,
        system: &OSCILLATOR,
        integrator: &StrangOscillator,
        law: &law,
        config: &config,
        observables: &observables,
        level,
    })
}

fn bits(ensemble: &Ensemble) -> Vec<u64> {
    let error = |uncertainty| match uncertainty {
        Uncertainty::StandardError(value) | Uncertainty::Bound(value) => value,
        Uncertainty::Unknown => 0.0,
    };
    let estimates = ensemble.estimates.iter().flatten();
    estimates.flat_map(|e| [e.value.to_bits(), error(e.uncertainty).to_bits()]).collect()
}

fn outcome_bits(outcome: &Outcome) -> Result<Vec<u64>, CaseError> {
    Ok(bits(&outcome.ensemble()?))
}

fn on_threads(n_threads: usize, level: SimdLevel) -> Result<Vec<u64>, CaseError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build()?;
    with_study("study", 9, level, |study| {
        let outcome = pool.install(|| study.run::<1>())?;
        outcome_bits(&outcome)
    })
}

fn shards(name: &str, seed: u64, n_shards: u64) -> Result<Vec<ShardRecord>, CaseError> {
    with_study(name, seed, SimdLevel::best(), |study| {
        Ok((0..n_shards).map(|k| study.shard::<1>(k, n_shards)).collect::<Result<_, _>>()?)
    })
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let alone = on_threads(1, SimdLevel::best())?;
    let mut claims = Vec::new();
    let mut compare = |name: &str, what: &str, other: &[u64], reason: &str| {
        let n_different = alone.iter().zip(other).filter(|(a, b)| a != b).count()
            + alone.len().abs_diff(other.len());
        let subject = context.subject(name, what, "", "Strang, 20,557 paths, 3 times");
        claims.push(Claim::same_bits(subject, n_different, alone.len(), reason));
    };
    for n_threads in [2, 8] {
        let name = format!("threads-{n_threads}");
        let other = on_threads(n_threads, SimdLevel::best())?;
        compare(
            &name,
            "values unlike those on one thread",
            &other,
            "sums in a fixed tree of blocks",
        );
    }
    for level in SimdLevel::available() {
        let name = format!("level-{level}");
        let reason = "the same operations in the same order, none fused";
        compare(&name, "values unlike those of the widest level", &on_threads(1, level)?, reason);
    }
    for n_shards in [1, 2, 3, 6, 11] {
        let mut records = shards("study", 9, n_shards)?;
        records.reverse();
        let middle = records.len() / 3;
        records.rotate_left(middle);
        // As between machines: written, and read again.
        let text = serde_json::to_string(&records)?;
        let records: Vec<ShardRecord> = serde_json::from_str(&text)?;
        let other = outcome_bits(&merge(&records)?)?;
        let name = format!("shards-{n_shards}");
        compare(
            &name,
            "values unlike those of one run",
            &other,
            "a shard holds whole blocks, through JSON",
        );
    }
    claims.push(refusals(context)?);
    Ok(claims)
}

/// A shard that is missing, doubled or of another study is refused by the name of what is wrong.
fn refusals(context: &Context<'_>) -> Result<Claim, CaseError> {
    let records = shards("study", 9, 3)?;
    let missing = merge(&records[..2]);
    let doubled = merge(&[records[0].clone(), records[1].clone(), records[1].clone()]);
    let with = |foreign: ShardRecord| merge(&[records[0].clone(), records[1].clone(), foreign]);
    let seed = with(shards("study", 10, 3)?.remove(2));
    let name = with(shards("another", 9, 3)?.remove(2));
    let count = with(shards("study", 9, 4)?.remove(2));
    let is_right = [
        matches!(missing, Err(Error::MissingShard { shard: 2, n_shards: 3 })),
        matches!(doubled, Err(Error::DoubledShard { shard: 1 })),
        matches!(seed, Err(Error::ForeignShard { shard: 2, field: "seed", .. })),
        matches!(name, Err(Error::ForeignShard { shard: 2, field: "name", .. })),
        matches!(count, Err(Error::ForeignShard { shard: 2, field: "n_shards", .. })),
    ];
    let subject =
        context.subject("refusals", "wrong sets of shards not refused by name", "", "merge");
    let n_wrong = is_right.iter().filter(|right| !**right).count();
    Ok(Claim::same_bits(
        subject,
        n_wrong,
        is_right.len(),
        "missing, doubled, of another seed, name, number",
    ))
}
