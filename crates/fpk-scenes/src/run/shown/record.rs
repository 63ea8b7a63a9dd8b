//! Result file of a run: quantities over time, each value with its error.

use std::fmt;

use scene_runs::answers::Unknown;
use serde::{Serialize, Serializer};

use super::super::resolutions::Resolutions;
use super::observed::{Observed, by_scale};
use crate::density::{Exceedances, Row, is_beside, thresholds_beside};
use crate::scene::FpkScene;
use crate::system::System;

/// Keys that this kind adds to the schema `run-result/1`.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Content {
    pub(crate) seed: Option<u64>,
    pub(crate) work: WorkRecord,
    /// Why the run ended before its last time.
    pub(crate) stopped: Option<String>,
    /// Unknown errors, and why; nothing else is missing.
    pub(crate) unknown: Vec<Unknown>,
    pub(crate) quantities: Vec<Series>,
}

/// Work counters.
#[derive(Debug, Default, Serialize)]
pub(crate) struct WorkRecord {
    pub(crate) particles: Option<usize>,
    pub(crate) steps: Option<u64>,
    pub(crate) evaluations: Option<u64>,
    pub(crate) neighbour_visits: Option<u64>,
    pub(crate) path_steps: Option<u64>,
    pub(crate) cpu_seconds: f64,
}

/// A quantity over time.
#[derive(Debug, Serialize)]
pub(crate) struct Series {
    #[serde(rename = "id", serialize_with = "as_text")]
    pub(crate) of: Quantity,
    pub(crate) quantity: String,
    pub(crate) unit: String,
    pub(crate) values: Vec<Observed>,
}

/// Relative error of an integral over cells that a threshold cuts, seen at spacings of 0.2 to 0.5: its sign changes with the place of
/// the threshold, so that a difference of lattices can miss it.
const OF_CUT_CELLS: f64 = 1e-6;
/// Relative error of standard deviations by the moment equations above which what the lattice left outside bounds no probability.
const VIOLATION_OF_BOUND: f64 = 0.01;
/// The same above which what is missing of a second moment may lie beyond a threshold. Below it what the lattice left outside was a
/// bound in all scenes of the hunts.
const VIOLATION_IN_TAIL: f64 = 1e-3;
const NO_CELL_BEYOND: &str =
    "no cell of the lattice lies beyond the threshold: take a finer lattice, or guided paths";

impl Series {
    /// A series without unit.
    pub(crate) fn new(of: Quantity, quantity: String, values: Vec<Observed>) -> Self {
        Self { of, quantity, unit: String::new(), values }
    }

    /// A probability that a demand is above a threshold.
    pub(crate) fn probability(
        (by, threshold): (Probability, f64),
        demand: &str,
        values: Vec<Observed>,
    ) -> Self {
        let of = Quantity::Probability { by, threshold };
        Self::new(of, format!("P({demand} > {threshold})"), values)
    }
}

/// What a series is of. Its text is the id in `result.json`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Quantity {
    /// The mean of a product of powers of the states.
    Moment(Vec<u32>),
    /// The probability that a demand is above a threshold.
    Probability {
        by: Probability,
        threshold: f64,
    },
    TotalMass,
    CellMass,
    Entropy,
}

/// Estimators of a probability, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Probability {
    /// First passages up to a time.
    FirstPassage,
    /// Exceedance at a time, integrated over cells.
    Cell,
    /// Exceedance, interpolated between particles.
    LogInterpolated,
    /// Exceedance by the only estimator of a method.
    Exceedance,
    /// Exceedance by counted masses.
    Indicator,
}

impl Probability {
    pub(crate) const ALL: [Self; 5] =
        [Self::FirstPassage, Self::Cell, Self::LogInterpolated, Self::Exceedance, Self::Indicator];

    const fn id(self) -> &'static str {
        match self {
            Self::FirstPassage => "first-passage",
            Self::Cell => "exceedance-cell",
            Self::LogInterpolated => "exceedance-log-interpolated",
            Self::Exceedance => "exceedance",
            Self::Indicator => "exceedance-indicator",
        }
    }
}

impl Quantity {
    /// The id by which a probability is compared, whatever its estimator.
    pub(crate) fn shared_id(&self) -> String {
        match *self {
            Self::Probability { by, threshold } if by != Probability::FirstPassage => {
                Self::Probability { by: Probability::Exceedance, threshold }.to_string()
            }
            _ => self.to_string(),
        }
    }

    /// Whether a scene asks for it.
    const fn is_asked(&self) -> bool {
        matches!(self, Self::Moment(_) | Self::Probability { .. })
    }

    /// The estimator of a probability; none for another quantity.
    pub(crate) const fn estimator(&self) -> Option<Probability> {
        if let Self::Probability { by, .. } = self { Some(*by) } else { None }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Moment(powers) => {
                let powers: Vec<String> = powers.iter().map(ToString::to_string).collect();
                write!(formatter, "moment/{}", powers.join("-"))
            }
            Self::Probability { by, threshold } => write!(formatter, "{}/{threshold}", by.id()),
            Self::TotalMass => formatter.write_str("total-mass"),
            Self::CellMass => formatter.write_str("cell-mass"),
            Self::Entropy => formatter.write_str("entropy"),
        }
    }
}

fn as_text<S: Serializer>(of: &Quantity, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(of)
}

/// Probabilities by the best estimator that the method has.
pub(crate) fn best_probabilities(quantities: &[Series]) -> impl Iterator<Item = &Series> {
    let best = quantities.iter().filter_map(|series| series.of.estimator()).min();
    quantities.iter().filter(move |series| best.is_some() && series.of.estimator() == best)
}

/// Values of an exceedance by its estimator.
type Estimator = (Probability, fn(&Exceedances) -> Option<f64>);

const ESTIMATORS: [Estimator; 3] = [
    (Probability::Cell, |e| e.cell_integrated),
    (Probability::LogInterpolated, |e| Some(e.log_interpolated)),
    (Probability::Indicator, |e| Some(e.indicator)),
];

/// Quantities of a run that no scene asks for.
type OfRun = (Quantity, &'static str, fn(&Row) -> Option<f64>);

const OF_RUN: [OfRun; 3] = [
    (Quantity::TotalMass, "sum of the masses", |row| Some(row.total_mass)),
    (Quantity::CellMass, "mass over the cells", |row| row.cell_mass),
    (Quantity::Entropy, "entropy (nats)", |row| Some(row.entropy)),
];

/// The error by coarser runs that the quantities of one time share, as a relative error of the scale of the states.
///
/// A difference of runs is far too small where it changes its sign, which seldom happens in all quantities at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedError(f64);

/// Part of the shared error that each quantity has at least.
const PART_SHARED: f64 = 0.25;

/// Smallest ratio of the probability at a neighbouring threshold to this one: relative errors grow towards the tail.
const PART_BESIDE: f64 = 0.3;

impl SharedError {
    /// The largest of some moments, of each its error at a time and its order times its scale: the relative error of a moment of order
    /// `n` is `n` times that of a scale.
    pub(crate) fn of(moments: impl Iterator<Item = (Option<f64>, f64)>) -> Self {
        let relative =
            moments.filter_map(|(error, order_and_scale)| Some(error? / order_and_scale));
        Self(relative.filter(|relative| relative.is_finite()).fold(0.0, f64::max))
    }

    pub(crate) fn of_moment(self, order_and_scale: f64) -> f64 {
        PART_SHARED * self.0 * order_and_scale
    }

    pub(crate) fn of_probability(self, value: f64) -> f64 {
        PART_SHARED * self.0 * by_scale(value)
    }

    /// Least error of a probability by that at a neighbouring threshold; none if the other probability is far smaller, as in a tail.
    fn of_beside(beside: &Observed, value: f64) -> Option<f64> {
        let scale = by_scale(beside.value);
        let is_near = scale > 0.0 && beside.value >= PART_BESIDE * value;
        is_near.then_some(Self(beside.error? / scale).of_probability(value))
    }
}

/// Values at a time.
pub(crate) fn at(values: &[Observed], t: f64) -> Option<&Observed> {
    values.iter().find(|observed| observed.t.to_bits() == t.to_bits())
}

pub(crate) fn order(powers: &[u32]) -> u32 {
    powers.iter().sum::<u32>().max(1)
}

/// All quantities of the scene, without those that the method does not compute.
///
/// `beyond_reach` is what each moment has beyond the lattice over what it has within.
pub(in crate::run) fn series(
    both: &Resolutions,
    scene: &FpkScene,
    system: &System,
    beyond_reach: &[f64],
) -> Vec<Series> {
    let orders: Vec<f64> = scene.moments.iter().map(|powers| f64::from(order(powers))).collect();
    let by_runs: Vec<Vec<Observed>> =
        (0..orders.len()).map(|k| both.values(|row| Some(row.moments[k]))).collect();
    let shared = |row: &Row| {
        let of = |(k, values): (usize, &Vec<Observed>)| {
            (at(values, row.t).and_then(|it| it.error), orders[k] * row.scales[k])
        };
        SharedError::of(by_runs.iter().enumerate().map(of))
    };
    let moment = |((k, powers), values): ((usize, &Vec<u32>), &Vec<Observed>)| {
        let mut values = values.clone();
        for observed in &mut values {
            let Some(row) = both.fine.at(observed.t) else { continue };
            observed.raise_error(shared(row).of_moment(orders[k] * row.scales[k]));
            observed.add_error(Some(row.offsets[k].hypot(beyond_reach[k] * row.scales[k])));
        }
        moment_series(powers, system, values)
    };
    let mut all: Vec<Series> = scene.moments.iter().enumerate().zip(&by_runs).map(moment).collect();
    let demand = magnitude_name(scene, system);
    let over_cells = cells_at_thresholds(both, scene);
    for (by, pick) in ESTIMATORS {
        for (k, &threshold) in scene.thresholds.iter().enumerate() {
            let mut values = both.values(|row| pick(&row.exceedances[k]));
            for observed in &mut values {
                let Some(row) = both.fine.at(observed.t) else { continue };
                let missing = row.exceedances[k].missing;
                let is_suspect = row.violation > VIOLATION_IN_TAIL;
                let unseen = row.mass_outside.max(if is_suspect { missing } else { 0.0 });
                let by_runs = observed.error.unwrap_or_default();
                observed.raise_error(shared(row).of_probability(observed.value));
                observed.add_error(Some(row.exceedances[k].offset));
                if by == Probability::Cell {
                    observed.raise_error(OF_CUT_CELLS * observed.value);
                    let beside =
                        over_cells.iter().filter(|(other, _)| is_beside(*other, threshold));
                    let beside = beside.filter_map(|(_, values)| at(values, observed.t));
                    let least = beside.filter_map(|it| SharedError::of_beside(it, observed.value));
                    observed.raise_error(least.fold(0.0, f64::max));
                    // What the cells leave out, near their rim and in folded ones.
                    observed.add_error(row.cell_mass.map(|mass| 1.0 - mass));
                    observed.note.clone_from(&row.exceedances[k].note);
                    // `Probability::Below`: a small difference of runs says nothing of what no particle carries.
                    // A remeshed cloud ends where it has no mass to speak of, whatever the first lattice left outside.
                    // So does one whose particles violate the moment equations, and then no small probability is known, nor one that
                    // rests on less than particles.
                    let is_violated = row.violation > VIOLATION_OF_BOUND;
                    let is_below = observed.value <= row.mass_outside;
                    let is_unsure = is_below || observed.note.is_some();
                    if (observed.value == 0.0 && row.is_remeshed) || (is_unsure && is_violated) {
                        observed.lose_error(NO_CELL_BEYOND);
                    } else if is_below {
                        // A larger difference says that the particles are not where they should be.
                        let bound = unseen.max(by_runs);
                        observed.bounded_by(bound);
                        if bound > row.mass_outside {
                            observed.note = Some(format!("known only to be below {bound:.1e}"));
                        }
                    }
                } else {
                    // Counts of masses end with the cloud; the fits of the cells go on beyond it.
                    observed.may_lack(unseen);
                }
            }
            all.push(Series::probability((by, threshold), &demand, values));
        }
    }
    for (of, words, pick) in OF_RUN {
        all.push(Series::new(of, words.to_owned(), both.values(pick)));
    }
    all.retain(|series| !series.values.is_empty());
    if conditions_nonlinear(scene, system) {
        let answers = all.iter_mut().filter(|series| series.of.is_asked());
        answers.flat_map(|series| &mut series.values).for_each(Observed::of_one_covariance);
    }
    all
}

/// Whether the states of a filter are conditioned out of a nonlinear structure, whose error no lattice shows.
pub(in crate::run) fn conditions_nonlinear(scene: &FpkScene, system: &System) -> bool {
    scene.method.conditions_filter() && !system.is_linear()
}

/// Thresholds of the scene and those beside them, with their probabilities over the cells.
fn cells_at_thresholds(both: &Resolutions, scene: &FpkScene) -> Vec<(f64, Vec<Observed>)> {
    let asked = scene.thresholds.iter().enumerate();
    let asked = asked.map(|(k, &it)| (it, both.values(|row| row.exceedances[k].cell_integrated)));
    let beside = thresholds_beside(&scene.thresholds).into_iter().enumerate();
    let beside = beside.map(|(k, it)| (it, both.values(|row| row.beside.get(k).copied())));
    asked.chain(beside).collect()
}

/// Moments and exceedances of a scene by a method with one estimator.
///
/// `moment` and `exceedance` take indices in the lists of the scene. Quantities without a value are omitted.
pub(crate) fn asked_series(
    scene: &FpkScene,
    system: &System,
    moment: &dyn Fn(usize) -> Vec<Observed>,
    exceedance: &dyn Fn(usize) -> Vec<Observed>,
) -> Vec<Series> {
    let moments = scene.moments.iter().enumerate();
    let moments = moments.map(|(k, powers)| moment_series(powers, system, moment(k)));
    let demand = magnitude_name(scene, system);
    let exceedances = scene.thresholds.iter().enumerate().map(|(k, &threshold)| {
        Series::probability((Probability::Exceedance, threshold), &demand, exceedance(k))
    });
    moments.chain(exceedances).filter(|series| !series.values.is_empty()).collect()
}

fn moment_series(powers: &[u32], system: &System, values: Vec<Observed>) -> Series {
    let of = Quantity::Moment(powers.to_vec());
    let quantity = moment_words(powers, system.states());
    Series { of, quantity, unit: moment_unit(powers, system.states()), values }
}

/// Unit of a moment, e.g. `m^2/s` of `E[q v]`; none of a process whose states have the unit of the user.
pub(crate) fn moment_unit(powers: &[u32], states: &[&str]) -> String {
    let (mut length, mut time) = (0, 0);
    for (&power, state) in powers.iter().zip(states) {
        match *state {
            "xg" | "xf" => length += power,
            state if state.starts_with(['q', 'z']) => length += power,
            state if state.starts_with('v') => (length, time) = (length + power, time + power),
            _ => return String::new(),
        }
    }
    let power_of = |unit: &str, power: u32| match power {
        1 => unit.to_owned(),
        power => format!("{unit}^{power}"),
    };
    match (length, time) {
        (0, _) => String::new(),
        (length, 0) => power_of("m", length),
        (length, time) => format!("{}/{}", power_of("m", length), power_of("s", time)),
    }
}

/// Symbol of a moment, e.g. `E[q^2 v]`, without states to the power of zero.
pub(crate) fn moment_words(powers: &[u32], states: &[&str]) -> String {
    let factor = |(name, &power): (&&str, &u32)| match power {
        0 => None,
        1 => Some((*name).to_owned()),
        _ => Some(format!("{name}^{power}")),
    };
    let factors: Vec<String> = states.iter().zip(powers).filter_map(factor).collect();
    format!("E[{}]", factors.join(" "))
}

/// Name of the magnitude of the demand.
pub(crate) fn magnitude_name(scene: &FpkScene, system: &System) -> String {
    let name = scene.demand(system.states()).map(|demand| demand.name);
    format!("|{}|", name.unwrap_or_default())
}

/// The time of a run and its first moment, for progress reports.
pub(crate) fn progress_words(scene: &FpkScene, system: &System, t: f64, moments: &[f64]) -> String {
    let first = scene.moments.first().zip(moments.first());
    let words = first.map_or_else(String::new, |(powers, value)| {
        format!(", {} = {value:.5e}", moment_words(powers, system.states()))
    });
    format!("t = {t:.4}{words}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_beside_another_counts_unless_it_is_far_smaller() {
        let beside = |value: f64| Observed::by_two(1.0, value, Some(0.01));
        let of = |value: f64| SharedError::of_beside(&beside(value), 0.35);
        let expected = 0.25 * 0.01 * by_scale(0.35) / by_scale(0.3);
        assert!((of(0.3).unwrap() - expected).abs() < 1e-15);
        assert!(of(0.1).is_none() && of(0.0).is_none() && of(1.0).is_none());
    }
}
