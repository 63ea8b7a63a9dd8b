//! Stability maps: sweeps of runs over two parameters, with the boundary that theory predicts.
//!
//! Each run is accurate, degraded, or ended by a typed error. A map is one file here with a `const MAP: ChartKind`,
//! and one line in [`crate::charts::STABILITY`]. Its `draw` creates [`Panel`]s and calls [`Panel::sweep`], which runs,
//! classifies, draws and tabulates. A run returns its error and spends [`Work`]; the typed errors are those of the
//! crate that it calls.

mod axes;
pub(crate) mod fpk;
pub(crate) mod peridyn;
pub(crate) mod smpm;

use rayon::prelude::*;
use result_figures::{
    Drawing, Face, Line, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words, finite,
    time_series,
};
use scenes::causes::with_causes;
use serde::{Deserialize, Serialize};

use crate::problems::work::Work;
use reference_problems::context::CaseError;

/// Number of points on the line of a boundary.
const BOUNDARY_POINTS: u32 = 120;

/// Relative distance of additional runs inside and outside the boundary, for every abscissa.
const NEAR: f64 = 0.03;

/// Outcome of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Outcome {
    /// Its error is within the tolerance of the map.
    Accurate { error: f64 },
    /// The result is wrong, without an error; none if it is unbounded.
    Degraded { error: Option<f64> },
    /// It ended in a typed error, of which this is the text with its causes.
    Ended { error: String },
}

impl Outcome {
    fn judge(result: Result<f64, CaseError>, tolerance: f64) -> Self {
        match result {
            // A silent failure.
            Ok(error) if error.is_nan() => {
                Self::Ended { error: "the run gave a result whose error is not a number".into() }
            }
            Ok(error) if error <= tolerance => Self::Accurate { error },
            Ok(error) => Self::Degraded { error: Some(error).filter(|error| error.is_finite()) },
            Err(error) => Self::Ended { error: with_causes(error.as_ref()) },
        }
    }
}

/// A run, from the two parameters to the magnitude of its error.
pub(crate) type Run<'a> = dyn Fn(f64, f64, &mut Work) -> Result<f64, CaseError> + Sync + 'a;

/// Predicted boundary: stable below it. `None` without a limit.
pub(crate) type Boundary<'a> = dyn Fn(f64) -> Option<f64> + Sync + 'a;

/// One method over two parameters, the vertical one on a logarithmic axis.
pub(crate) struct Panel<'a> {
    /// Name of the files, without extensions.
    pub(crate) name: String,
    /// Title and labels of the picture. The caption is completed with tolerance and work limit.
    pub(crate) words: Words,
    /// Grid along the horizontal axis.
    pub(crate) across: Vec<f64>,
    /// Grid along the vertical axis.
    pub(crate) upwards: Vec<f64>,
    /// Predicted boundary, with its name in the legend.
    pub(crate) boundary: Option<(&'a str, &'a Boundary<'a>)>,
    /// What an accurate run may take.
    pub(crate) limits: Limits,
    /// The run.
    pub(crate) run: &'a Run<'a>,
}

/// What an accurate run may take.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Its largest error.
    pub(crate) tolerance: f64,
    /// Its largest work.
    pub(crate) work: u64,
}

/// A run of a map, as recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Point {
    /// Horizontal and vertical parameter.
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Work spent.
    pub(crate) work: u64,
    pub(crate) outcome: Outcome,
}

/// Data of a map, recorded next to its picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Map {
    pub(crate) words: Words,
    /// Largest error of an accurate run.
    pub(crate) tolerance: f64,
    pub(crate) work_limit: u64,
    /// Predicted boundary; no value without a limit within the picture.
    pub(crate) boundary: Vec<(f64, Option<f64>)>,
    pub(crate) points: Vec<Point>,
    /// Number of runs that contradict the prediction: accurate outside it, or ended inside it.
    pub(crate) against_prediction: usize,
}

impl Panel<'_> {
    /// Runs every point independently and draws the map.
    ///
    /// A failed run is a point of the map; an error are only numbers that cannot be drawn.
    pub(crate) fn sweep(&self) -> Result<Drawing, CaseError> {
        let map = self.map();
        let picture = TimeSeries {
            words: map.words.clone(),
            scale: Scale::Log,
            lines: self
                .boundary
                .iter()
                .map(|&(name, _)| Line { name: name.into(), points: map.boundary.clone() })
                .collect(),
            bands: Vec::new(),
            references: sets(&map.points),
        };
        let svg = time_series(&picture)?;
        let data = finite::to_json(&map)?;
        Ok(Drawing { name: self.name.clone(), face: Face::Picture(svg), data, table: row(&map) })
    }

    fn map(&self) -> Map {
        let points: Vec<Point> = self
            .places()
            .into_par_iter()
            .map(|(x, y)| {
                let mut work = Work::new(self.limits.work);
                let outcome = Outcome::judge((self.run)(x, y, &mut work), self.limits.tolerance);
                Point { x, y, work: work.spent(), outcome }
            })
            .collect();
        let is_against = |point: &&Point| {
            let Some((_, boundary)) = self.boundary else { return false };
            let is_inside = boundary(point.x).is_none_or(|limit| point.y < limit);
            match point.outcome {
                Outcome::Accurate { .. } => !is_inside,
                Outcome::Ended { .. } => is_inside,
                Outcome::Degraded { .. } => false,
            }
        };
        let Limits { tolerance, work: work_limit } = self.limits;
        let mut words = self.words.clone();
        words.caption.push(format!(
            "Accurate: error up to {tolerance}. Degraded: a result with a larger error, and no warning. Work limit: {work_limit} steps a run."
        ));
        let against_prediction = points.iter().filter(is_against).count();
        let boundary = self.boundary_line();
        Map { words, tolerance, work_limit, boundary, points, against_prediction }
    }

    /// The grid, and a run on either side of the boundary.
    fn places(&self) -> Vec<(f64, f64)> {
        let mut places = Vec::new();
        for &x in &self.across {
            places.extend(self.upwards.iter().map(|&y| (x, y)));
            let near = |limit: f64| [(x, limit * (1.0 - NEAR)), (x, limit * (1.0 + NEAR))];
            let limit = self.boundary.and_then(|(_, boundary)| boundary(x));
            places.extend(limit.filter(|&y| self.shows(y)).into_iter().flat_map(near));
        }
        places
    }

    /// Whether a value lies between the ends of the grid.
    fn shows(&self, y: f64) -> bool {
        let least = self.upwards.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = self.upwards.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (least..=largest).contains(&y)
    }

    fn boundary_line(&self) -> Vec<(f64, Option<f64>)> {
        let (Some((_, boundary)), Some(&first), Some(&last)) =
            (self.boundary, self.across.first(), self.across.last())
        else {
            return Vec::new();
        };
        (0..=BOUNDARY_POINTS)
            .map(|k| {
                let x = first + (last - first) * f64::from(k) / f64::from(BOUNDARY_POINTS);
                (x, boundary(x).filter(|&y| self.shows(y)))
            })
            .collect()
    }
}

/// The points by their outcome.
fn sets(points: &[Point]) -> Vec<ReferencePoints> {
    type Is = fn(&Outcome) -> bool;
    let kinds: [(&str, Is); 3] = [
        ("accurate", |outcome| matches!(outcome, Outcome::Accurate { .. })),
        ("degraded", |outcome| matches!(outcome, Outcome::Degraded { .. })),
        ("ended by a typed error, given in the JSON", |outcome| {
            matches!(outcome, Outcome::Ended { .. })
        }),
    ];
    kinds
        .into_iter()
        .map(|(name, is)| ReferencePoints {
            name: name.into(),
            points: points
                .iter()
                .filter(|point| is(&point.outcome))
                .map(|point| ReferencePoint { x: point.x, y: point.y, error: None })
                .collect(),
        })
        .collect()
}

/// Number of runs by outcome, and the first error text.
fn row(map: &Map) -> String {
    let counts: Vec<usize> = sets(&map.points).iter().map(|set| set.points.len()).collect();
    let first = map.points.iter().find_map(|point| match &point.outcome {
        Outcome::Ended { error } => Some(error.as_str()),
        _ => None,
    });
    format!(
        "  {} runs: {} accurate, {} degraded, {} ended; {} against the prediction{}",
        map.points.len(),
        counts[0],
        counts[1],
        counts[2],
        map.against_prediction,
        first.map_or_else(String::new, |text| format!("\n  first end: {text}"))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel<'a>(run: &'a Run<'a>, boundary: &'a Boundary<'a>) -> Panel<'a> {
        let words = Words {
            title: "made up".into(),
            subtitle: String::new(),
            x_label: "x".into(),
            y_label: "y".into(),
            caption: Vec::new(),
        };
        Panel {
            name: "made-up".into(),
            words,
            across: vec![1.0, 2.0],
            upwards: vec![0.5, 1.0, 3.0],
            boundary: Some(("y = x", boundary)),
            limits: Limits { tolerance: 0.1, work: 10 },
            run,
        }
    }

    /// A grid of 2 x 3 and two runs at each abscissa: accurate inside, ended beyond twice the boundary.
    #[test]
    fn every_run_has_an_outcome_and_is_held_against_the_prediction() {
        let run = |x: f64, y: f64, work: &mut Work| -> Result<f64, CaseError> {
            work.spend(4)?;
            if y > 2.0 * x {
                work.spend(7)?;
            }
            Ok(if y < x { 0.01 } else { f64::INFINITY })
        };
        let map = panel(&run, &|x| Some(x)).map();
        assert_eq!(map.points.len(), 10);
        assert_eq!(map.against_prediction, 0);
        let text = "work limit reached: 11 steps asked for, the limit is 10";
        let ended: Vec<&Point> = map
            .points
            .iter()
            .filter(|point| matches!(&point.outcome, Outcome::Ended { error } if error == text))
            .collect();
        assert_eq!(ended.len(), 1);
        assert_eq!((ended[0].x, ended[0].y, ended[0].work), (1.0, 3.0, 4));
        assert!(map.points.iter().any(|point| point.outcome == Outcome::Degraded { error: None }));
        // The same runs with a wrong prediction.
        assert!(panel(&run, &|x| Some(0.4 * x)).map().against_prediction > 0);
        assert!(panel(&run, &|_| None).map().against_prediction > 0);
    }

    #[test]
    fn a_silent_nan_is_an_end_and_a_map_is_drawn_and_survives_json() {
        let drawing = panel(&|_, _, _| Ok(f64::NAN), &|x| Some(x)).sweep().unwrap();
        assert!(drawing.table.contains("10 ended") && drawing.table.contains("not a number"));
        assert!(drawing.clone().into_svg().is_some_and(|svg| svg.contains("made up")));
        let map: Map = serde_json::from_str(&drawing.data).unwrap();
        assert_eq!(map.points.len(), 10);
    }
}
