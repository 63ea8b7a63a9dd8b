//! Properties of every job: each block once, results in order, named failures, no finished block lost.

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use mpi_ensembles::{
    Alone, Finished, InMemory, Job, JobError, Ranks, Store, ThreadRank, TransportError,
};
use proptest::prelude::*;

/// Blocks in memory that outlive a job.
#[derive(Debug, Default, Clone)]
struct Kept(BTreeMap<u64, u64>);

impl Store<u64> for Kept {
    fn load(&mut self, block: u64) -> Result<Option<u64>, Box<dyn Error + Send + Sync>> {
        Ok(self.0.get(&block).copied())
    }

    fn keep(&mut self, block: u64, part: &u64) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.0.insert(block, *part);
        Ok(())
    }
}

fn job(n_blocks: u64) -> Job {
    Job { n_blocks, identity: vec![("seed".to_owned(), "7".to_owned())] }
}

/// Return value of each rank.
type Returned = Vec<Result<Option<Finished<u64>>, JobError>>;

/// Runs a job on a number of threads; `job_of` gives each rank its own job description.
fn on_threads(
    n_ranks: usize,
    job_of: impl Fn(usize) -> Job + Sync,
    compute: impl Fn(usize, u64) -> Result<u64, String> + Sync,
    store: &mut Kept,
) -> Returned {
    let store = Mutex::new(store);
    let (job_of, compute, store) = (&job_of, &compute, &store);
    thread::scope(|scope| {
        let start = |rank: ThreadRank| {
            scope.spawn(move || {
                let number = rank.rank();
                let compute = |block| compute(number, block);
                let run = |store: &mut dyn Store<u64>| {
                    job_of(number).run(&rank, compute, store, &mut |_| ())
                };
                if number == 0 { run(*store.lock().unwrap()) } else { run(&mut InMemory) }
            })
        };
        let threads: Vec<_> = ThreadRank::all(n_ranks).into_iter().map(start).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Every block can be computed.
type Computed = Result<u64, Infallible>;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_block_that_is_not_known_is_computed_once(
        n_ranks in 1_usize..6,
        n_blocks in 1_u64..40,
        known in prop::collection::btree_set(0_u64..40, 0..40),
    ) {
        let known: BTreeSet<u64> = known.into_iter().filter(|block| *block < n_blocks).collect();
        let mut store = Kept(known.iter().map(|block| (*block, block * block)).collect());
        let computed = Mutex::new(Vec::new());
        let compute = |_, block| {
            computed.lock().unwrap().push(block);
            Ok(block * block)
        };
        let mut returned = on_threads(n_ranks, |_| job(n_blocks), compute, &mut store);
        let finished = returned.remove(0).unwrap().unwrap();
        prop_assert!(returned.into_iter().all(|worker| worker.unwrap().is_none()));
        let expected: Vec<u64> = (0..n_blocks).map(|block| block * block).collect();
        prop_assert_eq!(&finished.parts, &expected);
        let mut computed = computed.into_inner().unwrap();
        computed.sort_unstable();
        let missing: Vec<u64> = (0..n_blocks).filter(|block| !known.contains(block)).collect();
        prop_assert_eq!(&computed, &missing);
        prop_assert_eq!(store.0.len() as u64, n_blocks);
        let report = finished.report;
        prop_assert_eq!((report.n_ranks, report.n_known), (n_ranks, known.len() as u64));
        prop_assert_eq!(report.blocks.len(), missing.len());
    }

    /// Whatever rank 1 sends, rank 0 ends with a result or a typed error.
    #[test]
    fn any_message_is_taken_or_refused(
        messages in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..12), 0..4),
    ) {
        let ranks = Garbled(Mutex::new(messages));
        let ended = job(3).run(&ranks, |block| Computed::Ok(block * block), &mut Kept::default(), &mut |_| ());
        prop_assert!(ended.is_err());
    }
}

/// Two ranks; rank 1 has sent these bytes and exited.
#[derive(Debug)]
struct Garbled(Mutex<Vec<Vec<u8>>>);

impl Ranks for Garbled {
    fn rank(&self) -> usize {
        0
    }

    fn n_ranks(&self) -> usize {
        2
    }

    fn send(&self, _: usize, _: &[u8]) -> Result<(), TransportError> {
        Ok(())
    }

    fn receive(&self, _: Duration) -> Result<Option<(usize, Vec<u8>)>, TransportError> {
        let next = self.0.lock().unwrap().pop();
        next.map(|bytes| Some((1, bytes))).ok_or(TransportError::Gone { rank: 0 })
    }
}

#[test]
fn one_process_alone_is_a_job_of_one_rank() {
    let mut seen = Vec::new();
    let look = &mut |parts: &BTreeMap<u64, u64>| seen.push(parts.len());
    let finished = job(3).run(&Alone, |block| Computed::Ok(block * block), &mut InMemory, look);
    assert_eq!(finished.unwrap().unwrap().parts, [0, 1, 4]);
    assert_eq!(seen, [1, 2, 3]);
}

/// The first block ends after all others, so its rank receives no other block.
#[test]
fn blocks_go_to_whoever_is_free() {
    for n_ranks in [2, 3] {
        let done = AtomicU64::new(0);
        let compute = |_: usize, block: u64| {
            while block == 0 && done.load(Ordering::SeqCst) < 19 {
                thread::sleep(Duration::from_millis(1));
            }
            done.fetch_add(1, Ordering::SeqCst);
            Ok(block)
        };
        let returned = on_threads(n_ranks, |_| job(20), compute, &mut Kept::default());
        let report = returned.into_iter().next().unwrap().unwrap().unwrap().report;
        let of_first = report.blocks.iter().find(|b| b.block == 0).unwrap().rank;
        assert_eq!(report.blocks.iter().filter(|b| b.rank == of_first).count(), 1);
    }
}

#[test]
fn a_block_that_fails_or_panics_ends_the_job_by_its_name_and_what_was_done_is_kept() {
    for panics in [false, true] {
        for n_ranks in [1, 2, 3] {
            let compute = move |_: usize, block: u64| match block {
                5 if panics => panic!("no bond is left"),
                5 => Err("no bond is left".to_owned()),
                _ => Ok(block),
            };
            let mut store = Kept::default();
            let returned = on_threads(n_ranks, |_| job(9), compute, &mut store);
            let error = returned.into_iter().next().unwrap().unwrap_err();
            let JobError::Block { rank, block: 5, message } = &error else { panic!("{error}") };
            assert!(*rank < n_ranks, "{error}");
            let expected = if panics { "panicked: no bond is left" } else { "no bond is left" };
            assert_eq!(message, expected);
            // With one rank all earlier blocks; with more, at least all but those in progress.
            assert!(store.0.len() >= 6 - n_ranks, "{store:?}");
            // Resumes where it stopped.
            let returned = on_threads(2, |_| job(9), |_, block| Ok(block), &mut store);
            let finished = returned.into_iter().next().unwrap().unwrap().unwrap();
            assert_eq!(finished.parts, (0..9).collect::<Vec<_>>());
        }
    }
}

#[test]
fn a_rank_of_another_job_is_refused_by_what_differs_on_both_ends() {
    let other = |rank: usize| {
        let seed = if rank == 1 { "8" } else { "7" };
        Job { n_blocks: 4, identity: vec![("seed".to_owned(), seed.to_owned())] }
    };
    let returned = on_threads(2, other, |_, block| Ok(block), &mut Kept::default());
    for end in returned {
        let text = end.unwrap_err().to_string();
        assert_eq!(text, "rank 1 belongs to another job: its seed is 8, that of rank 0 is 7");
    }
    let longer = |rank: usize| job(if rank == 1 { 5 } else { 4 });
    let returned = on_threads(2, longer, |_, block| Ok(block), &mut Kept::default());
    let text = returned.into_iter().next().unwrap().unwrap_err().to_string();
    assert_eq!(
        text,
        "rank 1 belongs to another job: its number of blocks is 5, that of rank 0 is 4"
    );
}

#[test]
fn what_cannot_be_kept_or_read_ends_the_job() {
    struct Full;
    impl Store<u64> for Full {
        fn load(&mut self, block: u64) -> Result<Option<u64>, Box<dyn Error + Send + Sync>> {
            if block == 2 { Err("of another seed".into()) } else { Ok(None) }
        }
        fn keep(&mut self, _: u64, _: &u64) -> Result<(), Box<dyn Error + Send + Sync>> {
            Err("the disk is full".into())
        }
    }
    let run = |n| job(n).run(&Alone, |block| Computed::Ok(block * block), &mut Full, &mut |_| ());
    let error = run(2).unwrap_err();
    assert_eq!(error.to_string(), "block 0 could not be kept");
    assert_eq!(error.source().unwrap().to_string(), "the disk is full");
    assert_eq!(run(3).unwrap_err().to_string(), "block 2 could not be read");
    let none = job(0).run(&Alone, |block| Computed::Ok(block * block), &mut InMemory, &mut |_| ());
    assert!(matches!(none, Err(JobError::NoBlocks)));
}
