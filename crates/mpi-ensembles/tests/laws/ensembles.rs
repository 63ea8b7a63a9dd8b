//! An ensemble of sde-integrators on ranks: bitwise identical to one process, including quantiles.

use std::thread;

use mpi_ensembles::{InMemory, Job, Ranks, ThreadRank};
use sde_integrators::{
    Additive, EnsembleConfig, EulerMaruyama, Observable, Sde, ShardRecord, SimdLevel, Study, merge,
};

/// `dx = -x dt + dW`.
struct OrnsteinUhlenbeck;

impl Sde<1, 1> for OrnsteinUhlenbeck {
    type Noise = Additive;

    fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] {
        [-x[0]]
    }

    fn noise(&self, _t: f64, _x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

#[test]
fn paths_on_any_number_of_ranks_are_the_bits_of_one_process() {
    let config = EnsembleConfig { seed: 4, n_paths: 40_000, dt: 0.05, times: vec![0.5, 1.0] };
    let exceeds = |_: f64, x: &[f64; 1]| x[0] > 1.0;
    let observables =
        [Observable::Mean(&|_, x: &[f64; 1]| x[0] * x[0]), Observable::Probability(&exceeds)];
    let study = Study {
        name: "decay",
        system: &OrnsteinUhlenbeck,
        integrator: &EulerMaruyama,
        law: &[0.0],
        config: &config,
        observables: &observables,
        level: SimdLevel::best(),
    };
    let whole = study.run::<1>().unwrap();
    let job = Job { n_blocks: 7, identity: Vec::new() };
    for n_ranks in 1..=4 {
        let ranks = ThreadRank::all(n_ranks);
        let (study, job) = (&study, &job);
        let found: Vec<Option<Vec<ShardRecord>>> = thread::scope(|scope| {
            let run = |rank: ThreadRank| {
                scope.spawn(move || {
                    let block = |block| study.shard::<1>(block, job.n_blocks);
                    let finished = job.run(&rank, block, &mut InMemory, &mut |_| ()).unwrap();
                    assert_eq!(finished.is_some(), rank.rank() == 0);
                    finished.map(|finished| finished.parts)
                })
            };
            let threads: Vec<_> = ranks.into_iter().map(run).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert_eq!(merge(found[0].as_ref().unwrap()).unwrap(), whole, "{n_ranks} ranks");
    }
}
