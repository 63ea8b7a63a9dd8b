//! Pictures of an ensemble of cracks: crack paths and loads.

use peridyn_sde::CrackRun;
use peridyn_sde::statistics::{self, Bootstrap, CrackEnsemble, QUANTILES};
use result_figures::{Band, Drawing, Line, PathMap, PathQuantile, Scale, TimeSeries, Words};
use scene_runs::kind::RunError;
use scene_runs::machine::Machine;

use super::record::{LoadAt, Record, from_tip_to_exit};
use crate::scene::CrackScene;
use crate::scene_problem::CrackProblem;

/// Millimetres per metre.
const MM: f64 = 1e3;

pub(super) fn drawings(
    scene: &CrackScene,
    problem: &CrackProblem,
    run: &CrackRun,
    ensemble: &CrackEnsemble,
    record: &Record,
    bootstrap: &Bootstrap,
) -> Result<Vec<Drawing>, RunError> {
    let mut drawings = Vec::new();
    if !run.damage.realisations().is_empty() {
        let map = path_map(scene, problem, run, ensemble, bootstrap)?;
        drawings.push(Drawing::path_map("paths", &map).map_err(RunError::solver)?);
    }
    if !record.load.is_empty() {
        let chart = load(scene, run, record);
        drawings.push(Drawing::time_series("load", &chart).map_err(RunError::solver)?);
    }
    Ok(drawings)
}

/// Damage probability with the quantiles of the path.
fn path_map(
    scene: &CrackScene,
    problem: &CrackProblem,
    run: &CrackRun,
    ensemble: &CrackEnsemble,
    bootstrap: &Bootstrap,
) -> Result<PathMap, RunError> {
    let spacing = MM * scene.body.spacing;
    let [columns, rows] = scene.body.size.map(|length| boxes(MM * length / spacing));
    let probability = run.damage.probability().map_err(RunError::solver)?;
    let probability: Vec<f64> = probability.iter().map(|estimate| estimate.value).collect();
    let places = problem.nodes().positions();
    let edges = |n: usize| (0..=n).map(|k| spacing * k as f64).collect();
    let threshold = scene.output.damage_threshold;
    Ok(PathMap {
        words: words(scene, run, ensemble, problem.resolved.nodes),
        probability: vec!["probability that".into(), format!("damage reaches {threshold}")],
        x: edges(columns),
        y: edges(rows),
        values: by_boxes(places, &probability, scene.body.spacing, [columns, rows]),
        given: ("notch".into(), vec![mm(scene.notch.mouth), mm(scene.notch.tip)]),
        quantiles: quantiles(scene, problem, ensemble, bootstrap)?,
    })
}

/// Mean of a value over the nodes in each box of a lattice; none for a box without nodes.
fn by_boxes(
    places: &[[f64; 2]],
    values: &[f64],
    spacing: f64,
    [columns, rows]: [usize; 2],
) -> Vec<Vec<Option<f64>>> {
    let mut sums = vec![vec![(0.0, 0_usize); columns]; rows];
    for (place, value) in places.iter().zip(values) {
        let [column, row] = place.map(|x| boxes((x / spacing).floor()));
        // A point on the far edge belongs to the last box.
        let (sum, count) = &mut sums[row.min(rows - 1)][column.min(columns - 1)];
        *sum += value;
        *count += 1;
    }
    let mean = |&(sum, count): &(f64, usize)| (count > 0).then(|| sum / count as f64);
    sums.iter().map(|row| row.iter().map(mean).collect()).collect()
}

fn mm(point: [f64; 2]) -> [f64; 2] {
    point.map(|x| MM * x)
}

/// Quantiles of the path, as far as half of the cracks reach.
fn quantiles(
    scene: &CrackScene,
    problem: &CrackProblem,
    ensemble: &CrackEnsemble,
    bootstrap: &Bootstrap,
) -> Result<Vec<PathQuantile>, RunError> {
    if ensemble.counted().next().is_none() {
        return Ok(Vec::new());
    }
    let abscissae = from_tip_to_exit(scene, problem);
    let bands = ensemble.bands(&abscissae, bootstrap).map_err(RunError::solver)?;
    let come = |band: &&statistics::Band| band.reach.value >= 0.5;
    let laws: Vec<_> = bands
        .iter()
        .take_while(come)
        .map_while(|band| Some((band.x, band.heights.as_ref()?)))
        .collect();
    if laws.is_empty() {
        return Ok(Vec::new());
    }
    let quantile = |(k, p): (usize, &f64)| {
        let heights = laws.iter().map(|(x, law)| mm([*x, law.quantiles[k].value]));
        let name = if k == 2 { "median".to_owned() } else { format!("{:.0} %", 100.0 * p) };
        let points = std::iter::once(mm(scene.notch.tip)).chain(heights).collect();
        PathQuantile { name, points }
    };
    Ok(QUANTILES.iter().enumerate().map(quantile).collect())
}

fn words(scene: &CrackScene, run: &CrackRun, ensemble: &CrackEnsemble, nodes: usize) -> Words {
    let n = run.damage.realisations().len();
    let through = ensemble.counted().filter(|record| record.exit.is_some()).count();
    let (failed, threshold) = (ensemble.failures().count(), scene.output.damage_threshold);
    let spacing = MM * scene.body.spacing;
    let subtitle = format!(
        "{} realisations, {nodes} nodes at {spacing} mm; {through} cracks run through, {failed} do not count",
        scene.ensemble.realisations,
    );
    let of_path = "Quantiles of the height at which cracks first pass an abscissa, of those that come there, as far as half of \
                   them come.";
    let of_map = format!(
        "Probability over {n} realisations that a node has lost {threshold} of the stiffness of its bonds, the notch included; \
         standard error at most {:.2}.",
        0.5 / (n as f64).sqrt()
    );
    Words {
        title: scene.title.clone(),
        subtitle,
        x_label: "x (mm)".into(),
        y_label: "y (mm)".into(),
        caption: vec![of_path.to_owned(), of_map, Machine::read().caption()],
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of boxes")]
fn boxes(count: f64) -> usize {
    count.round().max(0.0) as usize
}

/// Mean load over mean strain, with the range of most realisations.
fn load(scene: &CrackScene, run: &CrackRun, record: &Record) -> TimeSeries {
    let is_displaced = record.load.iter().any(|at| at.displacement.is_some());
    let abscissa = |at: &LoadAt| match at.displacement {
        Some(displacement) => MM * displacement,
        None => 1e6 * at.strain.unwrap_or(0.0),
    };
    let (x_label, place) = if is_displaced {
        ("displacement (mm)", "Load on the displaced region")
    } else {
        ("mean strain (10⁻⁶)", "Reaction at the upper edge")
    };
    let mean = |at: &LoadAt| (abscissa(at), Some(at.load.value));
    let band = |(window, at): (usize, &LoadAt)| {
        let of_window = run.loads.iter().filter_map(|loads| loads.get(window).copied());
        let mut loads: Vec<f64> = of_window.collect();
        loads.sort_unstable_by(f64::total_cmp);
        Some((abscissa(at), rank(&loads, QUANTILES[0])?, rank(&loads, QUANTILES[4])?))
    };
    TimeSeries {
        words: Words {
            title: scene.title.clone(),
            subtitle: format!(
                "{place}, mean over {} realisations; shaded: from 5 % to 95 % of them",
                scene.ensemble.realisations
            ),
            x_label: x_label.into(),
            y_label: "load (N)".into(),
            caption: vec![Machine::read().caption()],
        },
        scale: Scale::Linear,
        lines: vec![Line {
            name: "mean load".into(),
            points: record.load.iter().map(mean).collect(),
        }],
        bands: vec![Band { points: record.load.iter().enumerate().filter_map(band).collect() }],
        references: Vec::new(),
    }
}

/// The value of rank `ceil(n p)`; none without values.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to n")]
pub(crate) fn rank(ascending: &[f64], p: f64) -> Option<f64> {
    let rank = (ascending.len() as f64 * p).ceil().max(1.0) as usize;
    ascending.get(rank - 1).copied()
}
