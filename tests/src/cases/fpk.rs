//! What is claimed of `fpk-sph`.

pub(crate) mod bouc_wen;
pub(crate) mod bouc_wen_paper;
pub(crate) mod canor_denoel;
pub(crate) mod conditioned;
pub(crate) mod effectivity;
pub(crate) mod filtered;
pub(crate) mod first_passage;
pub(crate) mod four_states;
pub(crate) mod gaussian_mixture;
pub(crate) mod guided_paths;
pub(crate) mod known_densities;
pub(crate) mod linear_oscillator;
pub(crate) mod linear_systems;
pub(crate) mod monte_carlo;
pub(crate) mod passage_benchmarks;
pub(crate) mod reliability_benchmarks;
pub(crate) mod rivals;
pub(crate) mod shear_building;
pub(crate) mod spatial_order;
pub(crate) mod stated_errors;
pub(crate) mod stationary_oscillators;
pub(crate) mod viscous_damper;

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method};
use reference_problems::fpk::problem::Problem;
use scenes::fpk::density::{Demand, DensityRun, Exceedances, Requested, Row};
use scenes::fpk::scene::FpkScene;

use crate::cases::prelude::*;

/// One claim for a family that shares its criterion: a member that fails, else the one with the largest error; for
/// regression bounds always that one. Its method says over what the family goes and which member it is.
fn worst(
    context: &Context<'_>,
    (name, over): (&str, &str),
    family: Vec<Claim>,
) -> CaseResult<Claim> {
    let n = family.len();
    let size = |claim: &Claim| match claim.error {
        Some(error) if claim.passed || claim.is_regression_bound() => error.abs(),
        _ => f64::INFINITY,
    };
    let largest = family.into_iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    let worst = largest.ok_or_else(|| format!("{name}: there is nothing to claim"))?;
    let id = context.subject(name, "", "").id;
    let front = |end: Option<usize>| id.get(..end.map_or(0, |end| end + 1)).unwrap_or("");
    let of_case = front(id.find(name).map(|start| start - 1));
    let family_name = front(id.rfind('/'));
    let member = worst.id.strip_prefix(family_name).or_else(|| worst.id.strip_prefix(of_case));
    let member = member.unwrap_or(&worst.id);
    let method = format!("{}; worst of {n} over {over}: {member}", worst.method);
    Ok(Claim { id, method, ..worst })
}

/// Two and eight threads give the bits of one.
fn over_threads(
    context: &Context<'_>,
    name: &str,
    reason: &str,
    whole: impl Fn() -> CaseResult<Vec<u64>> + Sync,
) -> CaseResult {
    let on = |threads: usize| -> CaseResult<Vec<u64>> {
        context.progress(&format!("{name}, {threads} threads"));
        rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(&whole)
    };
    let one = on(1)?;
    let mut claims = Vec::new();
    for threads in [2, 8] {
        let other = on(threads)?;
        let method = format!("{threads} threads against 1");
        let quantity = "values whose bits differ";
        let subject = context.subject(format!("{name}/threads-{threads}"), quantity, &method);
        claims.push(subject.same_bits(different(&one, &other), one.len()).because(reason));
    }
    Ok(claims)
}

/// How many entries differ; all of them where the lengths do.
fn different(one: &[u64], other: &[u64]) -> usize {
    if one.len() == other.len() {
        one.iter().zip(other).filter(|(a, b)| a != b).count()
    } else {
        one.len().max(1)
    }
}

/// The moments that the references hold.
const POWERS: [[u32; 2]; 6] = [[2, 0], [1, 1], [0, 2], [4, 0], [2, 2], [0, 4]];

/// The flow-map fit on a lattice.
const fn flow_map_fit<const D: usize>(
    lattice: InitialLattice<D>,
    reference_period: f64,
) -> Config<D> {
    let (method, most_steps) = (Method::FlowMapFit, DEFAULT_MOST_STEPS);
    Config { method, lattice, reference_period, most_steps }
}

/// A scene by its file.
fn scene(name: &str, text: &str) -> CaseResult<FpkScene> {
    Ok(FpkScene::read(name, text)?.0)
}

/// The row of a time, or why there is none.
fn row(run: &DensityRun, t: f64) -> CaseResult<&Row> {
    run.at(t).ok_or_else(|| format!("no row at t = {t}: {:?}", run.stopped).into())
}

/// A run with what the cases look at.
fn asked(times: &[f64], problem: &Problem, cells: bool) -> Requested {
    Requested {
        times: times.to_vec(),
        powers: POWERS.to_vec(),
        demand: Demand::displacement(),
        thresholds: problem.scene.thresholds.clone(),
        kinks: Vec::new(),
        cells,
    }
}

/// The words of a moment in ids and tables.
fn moment_words(powers: [u32; 2]) -> (&'static str, &'static str, &'static str) {
    match powers {
        [2, 0] => ("second-moment-q", "E[q^2]", "m^2"),
        [1, 1] => ("cross-moment-qv", "E[q v]", "m^2/s"),
        [0, 2] => ("second-moment-v", "E[v^2]", "m^2/s^2"),
        [4, 0] => ("fourth-moment-q", "E[q^4]", "m^4"),
        [2, 2] => ("fourth-moment-qv", "E[q^2 v^2]", "m^4/s^2"),
        _ => ("fourth-moment-v", "E[v^4]", "m^4/s^4"),
    }
}

/// `P(|q| > T)` at a time by an estimator.
fn exceedance_at(lines: &Lines<'_>, estimator: &str, threshold: f64, t: f64) -> Subject {
    let name = format!("exceedance-{estimator}/threshold-{threshold}/t{t}");
    lines.of(name, format!("P(|q| > {threshold})"))
}

/// The run of a method against the references of its problem.
struct Judge<'a> {
    problem: &'a Problem,
    run: &'a DensityRun,
    lines: Lines<'a>,
}

impl Judge<'_> {
    /// A moment at a time.
    fn moment(&self, powers: [u32; 2], t: f64, criterion: Criterion<'_>) -> CaseResult<Claim> {
        let (name, quantity, unit) = moment_words(powers);
        let measured = self.row(t)?.moments[index_of(powers)];
        let subject = self.lines.of(format!("{name}/t{t}"), quantity).unit(unit);
        Ok(subject.relative(measured, self.reference(powers, t)?).judged(criterion))
    }

    fn reference(&self, powers: [u32; 2], t: f64) -> CaseResult<Reference> {
        let reference = self.problem.reference.moment(powers, t);
        Ok(reference.ok_or("no reference for this moment and time")?)
    }

    /// `E[q v] / sqrt(E[q^2] E[v^2])`, both with the reference's second moments below the line: the cross moment passes
    /// through zero, where a relative error says nothing.
    fn correlation(&self, t: f64, criterion: Criterion<'_>) -> CaseResult<Claim> {
        let [qq, qv, vv] = [[2, 0], [1, 1], [0, 2]].map(|powers| self.reference(powers, t));
        let (qv, scale) = (qv?, (qq?.value * vv?.value).sqrt());
        let value = self.row(t)?.moments[index_of([1, 1])] / scale;
        let error = qv.error.map(|error| error / scale);
        let reference = Reference { value: qv.value / scale, error };
        let subject = self.lines.of(format!("correlation/t{t}"), "corr(q, v)");
        Ok(subject.absolute(value, reference).judged(criterion))
    }

    /// The worst of a moment over times.
    fn worst_moment(
        &self,
        powers: [u32; 2],
        times: &[f64],
        criterion: Criterion<'_>,
    ) -> CaseResult<Claim> {
        let (name, ..) = moment_words(powers);
        let family = times.iter().map(|&t| self.moment(powers, t, criterion));
        self.worst(name, times, family.collect::<Result<_, _>>()?)
    }

    /// The worst of the correlation over times.
    fn worst_correlation(&self, times: &[f64], criterion: Criterion<'_>) -> CaseResult<Claim> {
        let family = times.iter().map(|&t| self.correlation(t, criterion));
        self.worst("correlation", times, family.collect::<Result<_, _>>()?)
    }

    /// The worst of a family over times.
    fn worst(&self, name: &str, times: &[f64], family: Vec<Claim>) -> CaseResult<Claim> {
        let name = format!("{}/{name}/worst", self.lines.id);
        worst(self.lines.context, (&name, &format!("t = {times:?}")), family)
    }

    /// `P(|q| > T)` by one of the three estimators.
    fn exceedance(
        &self,
        estimator: ExceedanceEstimator,
        threshold: f64,
        t: f64,
        criterion: Criterion<'_>,
    ) -> CaseResult<Claim> {
        let scene = &self.problem.scene;
        let k = scene.thresholds.iter().position(|&other| (other - threshold).abs() < 1e-12);
        let exceedances = &self.row(t)?.exceedances[k.ok_or("no such threshold in the scene")?];
        let value = estimator.of(exceedances).ok_or("cells were not asked for")?;
        let reference = self.problem.reference.exceedance(threshold, t);
        let reference = reference.ok_or("no reference for this exceedance")?;
        let method = format!("{}; {} estimator", self.lines.method, estimator.name());
        let lines = Lines { method, ..self.lines.clone() };
        let subject = exceedance_at(&lines, estimator.name(), threshold, t);
        Ok(subject.log10(value, reference).judged(criterion))
    }

    /// The worst of the exceedance probabilities over all times and thresholds with a reference of at least `floor`.
    fn worst_exceedance(
        &self,
        estimator: ExceedanceEstimator,
        times: &[f64],
        floor: f64,
        criterion: Criterion<'_>,
    ) -> CaseResult<Claim> {
        let family = self
            .exceedances_from(times, floor)
            .into_iter()
            .map(|(threshold, t, _)| self.exceedance(estimator, threshold, t, criterion));
        let name = format!("{}/exceedance-{}/worst", self.lines.id, estimator.name());
        let over = format!("t = {times:?} and thresholds with P >= {floor:e}");
        worst(self.lines.context, (&name, &over), family.collect::<Result<_, _>>()?)
    }

    /// Thresholds and times whose reference is at least `floor`.
    fn exceedances_from(&self, times: &[f64], floor: f64) -> Vec<(f64, f64, Reference)> {
        let mut found = Vec::new();
        for &t in times {
            for &threshold in &self.problem.scene.thresholds {
                let reference = self.problem.reference.exceedance(threshold, t);
                found.extend(reference.filter(|r| r.value >= floor).map(|r| (threshold, t, r)));
            }
        }
        found
    }

    fn row(&self, t: f64) -> CaseResult<&Row> {
        match (self.run.at(t), &self.run.stopped) {
            (Some(row), _) => Ok(row),
            (None, Some(error)) => Err(format!("the run ended before t = {t}: {error}").into()),
            (None, None) => Err(format!("t = {t} was not asked of the run").into()),
        }
    }
}

/// Which estimator of `P(|q| > T)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ExceedanceEstimator {
    Indicator,
    LogInterpolated,
    Cell,
}

impl ExceedanceEstimator {
    const fn name(self) -> &'static str {
        match self {
            Self::Indicator => "indicator",
            Self::LogInterpolated => "log-interpolated",
            Self::Cell => "cell",
        }
    }

    const fn of(self, exceedances: &Exceedances) -> Option<f64> {
        match self {
            Self::Indicator => Some(exceedances.indicator),
            Self::LogInterpolated => Some(exceedances.log_interpolated),
            Self::Cell => exceedances.cell_integrated,
        }
    }
}

fn index_of(powers: [u32; 2]) -> usize {
    POWERS.iter().position(|&other| other == powers).unwrap_or(0)
}
