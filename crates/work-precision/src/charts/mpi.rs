//! Efficiency of an ensemble over the number of ranks, from a model of the job with measured block costs.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use result_figures::{Drawing, Method, Reading, Run, Words, WorkPrecision};
use scenes::kind::{BlockRecord, JobRecord};
use scenes::machine::Machine;
use sde_integrators::{Noise, Purpose, Stream};

use super::cost::outcome;
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::processes::{command_of_scenes, cracks, finish, piped, scenes};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "mpi",
    title: "efficiency of ensembles over the number of ranks, by a model from measured blocks",
    draw,
};

/// Number of blocks of the ensemble with fixed size.
const STRONG: u64 = 10_000;
/// Number of blocks of each rank for an ensemble that grows with the ranks.
const WEAK: u64 = 20;
/// Time from a request for a block to its arrival on an idle rank 0 (s).
///
/// It is the polling interval of a millisecond plus the network.
const ROUND_TRIP: f64 = 1.1e-3;
const MOST_RANKS: u64 = 10_000;

/// Measured costs of the blocks of a scene.
struct Measured {
    name: &'static str,
    /// Time of each block (s).
    seconds: Vec<f64>,
    /// Time of rank 0 for each block (s).
    taking: f64,
    /// File size of each block.
    bytes: f64,
}

impl Measured {
    fn mean(&self) -> f64 {
        self.seconds.iter().sum::<f64>() / self.seconds.len() as f64
    }

    /// Coefficient of variation.
    fn spread(&self) -> f64 {
        let mean = self.mean();
        let squares: f64 = self.seconds.iter().map(|s| (s - mean) * (s - mean)).sum();
        (squares / (self.seconds.len() as f64 - 1.0).max(1.0)).sqrt() / mean
    }
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let measured = measure(context)?;
    let mut rows = vec![
        "  ensemble             blocks  s a block  spread  ms to take in  kB a block  ranks for 90 %: 10,000 blocks, 20 a rank".to_owned(),
    ];
    let ranks = ranks();
    let [mut strong, mut weak] = [Vec::new(), Vec::new()];
    for of in &measured {
        let curve = |n_blocks: &dyn Fn(u64) -> u64| -> Vec<(f64, f64)> {
            ranks.iter().map(|&n| (n as f64, efficiency(of, n, n_blocks(n)))).collect()
        };
        let (fixed, growing) = (curve(&|_| STRONG), curve(&|n| WEAK * n));
        rows.push(format!(
            "  {:<20} {:>6}  {:>9.4}  {:>6.3}  {:>13.3}  {:>10.1}  {:>10} {:>10}",
            of.name,
            of.seconds.len(),
            of.mean(),
            of.spread(),
            1e3 * of.taking,
            1e-3 * of.bytes,
            most_at(&fixed, 0.9),
            most_at(&growing, 0.9),
        ));
        strong.push(method(of.name, &fixed));
        weak.push(method(of.name, &growing));
    }
    let table = rows.join("\n");
    let of_strong = format!("{STRONG} blocks, shared among all ranks");
    let of_weak = format!("{WEAK} blocks for each rank");
    let strong = Drawing::work_precision("mpi-strong-scaling", &picture(strong, &of_strong))?;
    let weak = Drawing::work_precision("mpi-weak-scaling", &picture(weak, &of_weak))?;
    Ok(vec![Drawing { table, ..strong }, weak])
}

/// Efficiencies over the number of ranks.
fn method(name: &str, efficiencies: &[(f64, f64)]) -> Method {
    let run = |&(cost, value): &(f64, f64)| Run {
        cost,
        cost_error: None,
        outcome: outcome(value),
        label: None,
    };
    Method { name: name.into(), runs: efficiencies.iter().map(run).collect() }
}

fn picture(series: Vec<Method>, ensemble: &str) -> WorkPrecision {
    WorkPrecision {
        words: Words {
            title: "Fraction of the time of all ranks spent on blocks, by the model".into(),
            subtitle: ensemble.to_owned(),
            x_label: "ranks".into(),
            y_label: "efficiency".into(),
            caption: vec![
                "Block costs drawn from those measured on one rank; rank 0 processes one result at a time.".into(),
                Machine::read().caption(),
            ],
        },
        reading: Reading::Parameter,
        series,
    }
}

/// Runs the ensembles block by block, each on one thread in a separate process.
fn measure(context: &Context<'_>) -> Result<Vec<Measured>, CaseError> {
    let folder = tempfile::tempdir()?;
    let mut measured = Vec::new();
    // Enough blocks for a standard deviation.
    let cracks = cracks(192)?;
    for scene in scenes()?.into_iter().filter(|scene| scene.shards) {
        let scene = if scene.name == cracks.name { &cracks } else { &scene };
        context.progress(scene.name);
        let (file, out) = (scene.write(folder.path())?, folder.path().join(scene.name));
        let mut command = command_of_scenes()?;
        command.arg("run").arg(file).arg("--out").arg(&out).args(["--threads", "1", "--blocks"]);
        finish(piped(command)?)?;
        let job: JobRecord = serde_json::from_str(&std::fs::read_to_string(out.join("job.json"))?)?;
        let n = job.blocks.len() as f64;
        let bytes: u64 = std::fs::read_dir(out.join("blocks"))?
            .map(|entry| Ok(entry?.metadata()?.len()))
            .sum::<std::io::Result<u64>>()?;
        let of = |value: fn(&BlockRecord) -> f64| job.blocks.iter().map(value);
        measured.push(Measured {
            name: scene.name,
            seconds: of(|block| block.seconds).collect(),
            taking: of(|block| block.taking).sum::<f64>() / n,
            bytes: bytes as f64 / n,
        });
        if context.profile == Profile::Quick {
            break;
        }
    }
    Ok(measured)
}

/// 1, 2, 5, 10, ... ranks.
fn ranks() -> Vec<u64> {
    let decades = (0..=4).flat_map(|k| [1, 2, 5].map(|n| n * 10_u64.pow(k)));
    decades.filter(|&n| n <= MOST_RANKS).collect()
}

/// Largest number of ranks up to which a curve exceeds a value.
fn most_at(efficiencies: &[(f64, f64)], least: f64) -> f64 {
    let above = efficiencies.iter().take_while(|(_, efficiency)| *efficiency >= least);
    above.last().map_or(0.0, |(ranks, _)| *ranks)
}

/// Time in blocks over `n_ranks` times the time of the job.
fn efficiency(of: &Measured, n_ranks: u64, n_blocks: u64) -> f64 {
    let mut draw = Draw { of, stream: Noise::new(1).stream(Purpose::Bootstrap, n_ranks), sum: 0.0 };
    let seconds = job_time(n_ranks, n_blocks, of.taking, || draw.next());
    draw.sum / (n_ranks as f64 * seconds)
}

/// Random block costs, drawn from the measured ones.
struct Draw<'a> {
    of: &'a Measured,
    stream: Stream,
    sum: f64,
}

impl Draw<'_> {
    fn next(&mut self) -> f64 {
        let n = self.of.seconds.len();
        // 2^64 is no multiple of n, but the bias is far below the precision of a double.
        let place = usize::try_from(self.stream.next_u64() % n as u64).unwrap_or_default();
        let cost = self.of.seconds[place];
        self.sum += cost;
        cost
    }
}

/// Time at which the last result is processed: idle ranks send requests in order, and rank 0 answers one at a time.
fn job_time(n_ranks: u64, n_blocks: u64, taking: f64, mut cost: impl FnMut() -> f64) -> f64 {
    // Times are positive, so their bit patterns are ordered.
    let mut asking: BinaryHeap<Reverse<u64>> = (0..n_ranks).map(|_| Reverse(0)).collect();
    let (mut answered, mut left) = (0.0_f64, n_blocks);
    let mut first_words = n_ranks;
    while let Some(Reverse(bits)) = asking.pop() {
        let asked = f64::from_bits(bits);
        let has_result = first_words == 0 || asked > 0.0;
        first_words = first_words.saturating_sub(1);
        answered = answered.max(asked) + if has_result { taking } else { 0.0 };
        if left > 0 {
            left -= 1;
            asking.push(Reverse((answered + ROUND_TRIP + cost()).to_bits()));
        }
    }
    answered
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 12 blocks of one second: on 1, 3, 5 ranks 12, 4, 3 rounds.
    #[test]
    fn equal_blocks_are_done_in_whole_rounds() {
        for (n_ranks, rounds) in [(1, 12.0), (3, 4.0), (5, 3.0), (20, 1.0)] {
            let time = job_time(n_ranks, 12, 0.0, || 1.0);
            assert!((time - rounds * (1.0 + ROUND_TRIP)).abs() < 1e-12, "{n_ranks}: {time}");
        }
    }

    /// For any number of ranks, rank 0 processes results one after the other.
    #[test]
    fn rank_zero_is_a_limit() {
        let time = job_time(1_000, 5_000, 0.01, || 0.1);
        assert!((time / (5_000.0 * 0.01) - 1.0).abs() < 0.01, "{time}");
    }

    /// One block of ten with ten times the length delays the others by at most its own length.
    #[test]
    fn uneven_blocks_balance() {
        let mut number = 0;
        let cost = || {
            number += 1;
            if number == 1 { 10.0 } else { 1.0 }
        };
        assert!(job_time(4, 31, 0.0, cost) < 10.2);
    }
}
