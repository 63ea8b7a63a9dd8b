//! Our times compared with those of rivals, as ratios that are robust on a busy machine.
//!
//! The contenders of a work alternate, and each round gives one ratio for each rival: a disturbance in a round slows
//! all contenders. The result is the median over the rounds, with quartiles as its uncertainty. Nothing is omitted: a
//! ratio below one is a loss and is printed.

use std::io::Write;
use std::time::{Duration, Instant};

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, Table};
use cpu_time::ProcessTime;
use criterion::{Criterion, Throughput};

use crate::CpuTime;
use crate::record::{self, Listed, Tables};

/// Range of the number of rounds, limited by time.
const ROUNDS: std::ops::RangeInclusive<usize> = 7..=25;
/// Wall time after which no further round begins.
const PATIENCE: Duration = Duration::from_secs(4);
/// Minimum CPU time of a contender in a round, by repetition: far above the cost of reading the clock.
const SAMPLE: Duration = Duration::from_millis(2);

/// Title of the table of every target with rivals.
const RATIOS: &str = "Ratios, rival / ours: above 1 we are faster";

const HEADER: [&str; 10] =
    ["work", "ours", "M/s", "rival", "", "ratio", "quartiles", "target", "reached", "rounds"];

struct Contender<'a> {
    name: &'static str,
    target: Option<f64>,
    run: Box<dyn FnMut() + 'a>,
}

/// The same work by several contenders: ours first, then the rivals.
#[expect(missing_debug_implementations, reason = "closures have none")]
pub struct Work<'a> {
    name: String,
    n_elements: usize,
    contenders: Vec<Contender<'a>>,
}

impl<'a> Work<'a> {
    /// A work with its number of elements and our implementation.
    pub fn new(
        name: impl Into<String>,
        n_elements: usize,
        ours: &'static str,
        run: impl FnMut() + 'a,
    ) -> Self {
        let ours = Contender { name: ours, target: None, run: Box::new(run) };
        Self { name: name.into(), n_elements, contenders: vec![ours] }
    }

    /// Adds a rival.
    #[must_use]
    pub fn rival(mut self, name: &'static str, run: impl FnMut() + 'a) -> Self {
        self.contenders.push(Contender { name, target: None, run: Box::new(run) });
        self
    }

    /// Adds a rival that is expected to take at least `target` times as long.
    #[must_use]
    pub fn rival_to_beat(
        mut self,
        name: &'static str,
        target: f64,
        run: impl FnMut() + 'a,
    ) -> Self {
        self.contenders.push(Contender { name, target: Some(target), run: Box::new(run) });
        self
    }

    /// Also measures the contenders by criterion, one after the other: for distributions and changes between runs.
    #[must_use]
    pub fn in_criterion(mut self, criterion: &mut Criterion<CpuTime>) -> Self {
        let mut group = criterion.benchmark_group(&self.name);
        group.throughput(Throughput::Elements(self.n_elements as u64));
        for Contender { name, run, .. } in &mut self.contenders {
            group.bench_function(*name, |b| b.iter(&mut *run));
        }
        group.finish();
        self
    }
}

/// Table of ratios of a benchmark target.
#[derive(Debug)]
pub struct Ratios {
    title: &'static str,
    filter: Option<String>,
    is_measured: bool,
    load_at_start: String,
    rows: Vec<Vec<String>>,
    further: Vec<Listed>,
    notes: Vec<String>,
}

impl Ratios {
    /// An empty table.
    ///
    /// With `--test` or `--list` on the command line nothing is measured. A first argument that is no option filters
    /// the names of works.
    #[must_use]
    pub fn from_args(title: &'static str) -> Self {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        let is_given = |option: &str| arguments.iter().any(|argument| argument == option);
        Self {
            title,
            filter: arguments.first().filter(|first| !first.starts_with('-')).cloned(),
            // As in criterion: cargo passes `--bench` for a measurement.
            is_measured: is_given("--bench") && !is_given("--test") && !is_given("--list"),
            load_at_start: load_average(),
            rows: Vec::new(),
            further: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Whether anything is measured; otherwise work of many seconds is skipped.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        self.is_measured
    }

    /// Whether the filter selects this work.
    #[must_use]
    pub fn wants(&self, work: &str) -> bool {
        self.filter.as_ref().is_none_or(|part| work.contains(part))
    }

    /// Measures all contenders by CPU time; without measurement each runs once.
    pub fn measure(&mut self, work: Work<'_>) {
        let Work { name, n_elements, mut contenders } = work;
        if !self.wants(&name) {
            return;
        }
        if !self.is_measured {
            for contender in &mut contenders {
                (contender.run)();
            }
            return;
        }
        let rounds = rounds(&mut contenders);
        // In the table of one target its name need not precede each work, as it does in criterion's.
        let work = name.trim_start_matches(self.title).trim_start_matches('/');
        for (k, rival) in contenders.iter().enumerate().skip(1) {
            let seconds: Vec<[f64; 2]> = rounds.iter().map(|of| [of[0], of[k]]).collect();
            self.compare((work, Some(n_elements)), (rival.name, rival.target), &seconds);
        }
    }

    /// Adds a rival, by the seconds of ours and of the rival in every round.
    fn compare(
        &mut self,
        (work, n_elements): (&str, Option<usize>),
        (rival, target): (&str, Option<f64>),
        seconds: &[[f64; 2]],
    ) {
        let ours = Quartiles::of(seconds.iter().map(|of| of[0]));
        let its = Quartiles::of(seconds.iter().map(|of| of[1]));
        let ratio = Quartiles::of(seconds.iter().map(|of| of[1] / of[0]));
        let speed = |n: usize| format!("{:.1}", 1e-6 * n as f64 / ours.median);
        let none = || "-".to_owned();
        self.rows.push(vec![
            work.to_owned(),
            duration(ours.median),
            n_elements.map_or_else(none, speed),
            rival.to_owned(),
            duration(its.median),
            format!("{:.2}", ratio.median),
            format!("{:.2} to {:.2}", ratio.lower, ratio.upper),
            target.map_or_else(none, |target| target.to_string()),
            target.map_or("-", |target| ratio.reaches(target)).to_owned(),
            seconds.len().to_string(),
        ]);
    }

    /// Adds counted bytes, ours and a rival's.
    pub fn bytes(&mut self, work: &str, ours: usize, rival: &str, its: usize, target: f64) {
        let megabytes = |bytes: usize| format!("{:.0} MB", 1e-6 * bytes as f64);
        let ratio = its as f64 / ours as f64;
        self.rows.push(vec![
            work.to_owned(),
            megabytes(ours),
            "-".to_owned(),
            rival.to_owned(),
            megabytes(its),
            format!("{ratio:.2}"),
            "counted".to_owned(),
            target.to_string(),
            if ratio >= target { "yes" } else { "no" }.to_owned(),
            "1".to_owned(),
        ]);
    }

    /// Measures two of our variants by wall time, which alone shows the gain from threads.
    pub fn wall(
        &mut self,
        work: &str,
        [name, other_name]: [&str; 2],
        target: f64,
        mut run: impl FnMut(),
        mut other: impl FnMut(),
    ) {
        if !self.wants(work) {
            return;
        }
        let wall = |run: &mut dyn FnMut()| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        };
        // The first runs grow buffers.
        wall(&mut run);
        wall(&mut other);
        let rounds: Vec<[f64; 2]> =
            (0..*ROUNDS.start()).map(|_| [wall(&mut run), wall(&mut other)]).collect();
        let work = format!("{work}, {name}");
        self.compare((&work, None), (other_name, Some(target)), &rounds);
    }

    /// Adds a line below the table.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Adds a table below that of the ratios.
    pub fn list(&mut self, listed: Listed) {
        self.further.push(listed);
    }

    /// Prints the tables if anything was measured, and writes them where `record` requests it.
    pub fn print(self) {
        if !self.is_measured {
            return;
        }
        let Self { title, rows, further, load_at_start, notes, .. } = self;
        let ratios = Listed { title: RATIOS.into(), head: HEADER.map(String::from).to_vec(), rows };
        let mut table = markdown(&ratios);
        for column in table.column_iter_mut().filter(|column| ![0, 3, 8].contains(&column.index)) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        let cores = std::thread::available_parallelism().map_or(0, usize::from);
        let mut text = format!(
            "\n{title}. {RATIOS}\n\n{table}\n\n\
             CPU time of the process on one thread of {cores}; contenders alternate; medians over the rounds.\n\
             M/s: millions of pairs, points or particles a second, ours.\n\
             reached: no if even the upper quartile is below the target, about if the target lies between the quartiles.\n\
             load average {load_at_start} at the start, {} at the end.\n",
            load_average()
        );
        for note in &notes {
            text.push_str(note);
            text.push('\n');
        }
        for listed in &further {
            text.extend(["\n", &listed.title, "\n\n", &markdown(listed).to_string(), "\n"]);
        }
        let tables = [vec![ratios], further].concat();
        if let Err(error) = record::leave(&Tables { tables, notes }) {
            let error = error.to_string();
            text.extend(["the tables could not be left for the record: ", &error, "\n"]);
        }
        // A closed output needs no table.
        let _ = std::io::stdout().write_all(text.as_bytes());
    }
}

/// Seconds of every contender in every round.
fn rounds(contenders: &mut [Contender<'_>]) -> Vec<Vec<f64>> {
    let repetitions: Vec<u32> = contenders
        .iter_mut()
        .map(|contender| {
            let mut repetitions = 1;
            // The first runs also warm caches and grow buffers.
            while seconds(contender, repetitions) * f64::from(repetitions) < SAMPLE.as_secs_f64() {
                repetitions *= 2;
            }
            repetitions
        })
        .collect();
    let (start, mut rounds) = (Instant::now(), Vec::new());
    while rounds.len() < *ROUNDS.start()
        || (rounds.len() < *ROUNDS.end() && start.elapsed() < PATIENCE)
    {
        let mut round = vec![0.0; contenders.len()];
        for turn in 0..contenders.len() {
            // Every other round is reversed, so that no contender always follows the same one.
            let k = if rounds.len() % 2 == 0 { turn } else { contenders.len() - 1 - turn };
            round[k] = seconds(&mut contenders[k], repetitions[k]);
        }
        rounds.push(round);
    }
    rounds
}

/// CPU seconds of one run.
fn seconds(contender: &mut Contender<'_>, repetitions: u32) -> f64 {
    let start = ProcessTime::now();
    for _ in 0..repetitions {
        (contender.run)();
    }
    start.elapsed().as_secs_f64() / f64::from(repetitions)
}

fn markdown(listed: &Listed) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(&listed.head);
    table.add_rows(&listed.rows);
    table
}

struct Quartiles {
    lower: f64,
    median: f64,
    upper: f64,
}

impl Quartiles {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let [lower, median, upper] =
            [1, 2, 3].map(|quarter| sorted[(sorted.len() - 1) * quarter / 4]);
        Self { lower, median, upper }
    }

    fn reaches(&self, target: f64) -> &'static str {
        if self.lower >= target {
            "yes"
        } else if self.upper < target {
            "no"
        } else {
            "about"
        }
    }
}

fn duration(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.2} µs", 1e6 * seconds)
    } else {
        format!("{:.2} ms", 1e3 * seconds)
    }
}

/// Load average over the last minute, if the system reports it.
fn load_average() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().filter(|load| !load.is_empty()).unwrap_or("unknown").to_owned()
}
