//! Limits of Taylor series: coefficient of variation, first yield, arrival of a shock.

use perturbation_moments::MonteCarlo;
use result_figures::{Drawing, Method, Reading, Run, RunOutcome, Words, WorkPrecision};
use scenes::smpm::scene::{GaugeScene, LawScene, SmpmScene};
use smpm::Error;
use smpm::uncertainty::{FrozenForm, Series, Study, Switch};

use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::smpm::problems::{Problem, experiment};

/// Ratio of curvature to slope above which the variance of a Taylor series is not reliable.
const TRUSTED: f64 = 0.03;
/// Coefficient of variation above which a normal distribution would leave the range of its parameter.
const MOST_NORMAL: f64 = 0.2;
/// Step of central differences, in standard deviations.
const DIFFERENCE: f64 = 0.02;
/// Number of raw samples whose standard error is drawn.
const RAW: f64 = 100.0;

/// The gauge at a point of the plate that impacts a wall.
const POINT: &str = "P";

/// Observed responses, by gauge, quantity and time.
struct Look {
    problem: Problem,
    words: &'static str,
    quantities: &'static [&'static str],
    /// First time, interval (us), and number of times.
    times: (f64, f64, u32),
    /// Maps over the coefficient of variation: file name, label, gauge, quantity, time (us).
    at: &'static [(&'static str, &'static str, &'static str, usize, f64)],
}

const LOOKS: [Look; 3] = [
    Look {
        problem: Problem::ContactExplosion,
        words: "contact explosion, thin plate, cells of 5 mm",
        times: (5.0, 0.5, 19),
        quantities: &["flow_stress", "deviator_11"],
        at: &[
            ("hardened", "flow stress at H, 10 us: hardened", "H", 0, 10.0),
            ("first-yield", "flow stress at G, 7 us: just yielded", "G", 0, 7.0),
            ("unloading", "S11 at H, 12 us: unloading", "H", 1, 12.0),
        ],
    },
    Look {
        problem: Problem::ThickPlate,
        words: "contact explosion, thick plate, cells of 5 mm",
        times: (5.0, 0.5, 19),
        quantities: &["pressure"],
        at: &[
            ("arrival", "pressure at F, 8.5 us: the shock arrives", "F", 0, 8.5),
            ("behind", "pressure at F, 12 us: behind the shock", "F", 0, 12.0),
        ],
    },
    // The front passes the gauge at 4.95 us.
    Look {
        problem: Problem::PlateImpact,
        words: "plate impact, cells of 0.5 mm",
        times: (4.5, 0.05, 25),
        quantities: &["pressure"],
        at: &[("front", "pressure 3 cm deep, 4.8 us: a sharp front arrives", POINT, 0, 4.8)],
    },
];

impl Look {
    fn times(&self) -> Vec<f64> {
        let (first, step, n) = self.times;
        (0..n).map(|k| first + step * f64::from(k)).collect()
    }

    /// The scene with one coefficient of variation for all parameters.
    fn scene(&self, strength: f64) -> Result<SmpmScene, CaseError> {
        let mut scene = self.problem.scene_with(strength, &self.times())?;
        scene.quantities = self.quantities.iter().map(|name| (*name).to_owned()).collect();
        for random in &mut scene.random {
            random.law =
                if strength > MOST_NORMAL { LawScene::Lognormal } else { LawScene::Normal };
        }
        if scene.dimension == 1 {
            let (name, body) = (POINT.to_owned(), scene.bodies[0].name.clone());
            scene.gauges = vec![GaugeScene { name, body, at: Some(vec![3.0]), within: None }];
        }
        Ok(scene)
    }
}

/// Methods, in the order of [`Judged::errors`].
const METHODS: [&str; 4] =
    ["frozen, corrected", "propagated, by jets", "finite differences", "sigma points"];

/// A distribution, solved by all methods and by the reference samples; all by response.
struct Judged {
    coefficient_of_variation: f64,
    /// Gauge, quantity and time of each response.
    responses: Vec<(String, usize, f64)>,
    /// Error of each method's variance relative to the sampled one, or why it is missing.
    errors: Vec<Result<Vec<f64>, String>>,
    /// Standard errors of the controlled variance and of the raw variance, relative to that variance.
    ///
    /// The raw variance is that of [`RAW`] samples.
    standard_error: Vec<f64>,
    raw_error: Vec<f64>,
    /// Curvature ratio and distance to a switch (deviations), or why they are missing.
    indicators: Vec<(f64, f64)>,
    n_failed: usize,
}

impl Judged {
    /// Errors of a response as a row of the table below the picture.
    fn row(&self, response: usize) -> String {
        let of = |errors: &Result<Vec<f64>, String>| match errors {
            Ok(errors) => format!("{:+9.2} %", 100.0 * errors[response]),
            Err(_) => "    ended  ".to_owned(),
        };
        let errors: Vec<String> = self.errors.iter().map(of).collect();
        format!(
            "  cv {:4}  {}  (judge +- {:.2} %)  r {:.3}  {}",
            self.coefficient_of_variation,
            errors.join(" "),
            100.0 * self.standard_error[response],
            self.indicators[response].0,
            self.warning(response).map_or("", |_| "warned")
        )
    }

    /// Solves for one coefficient of variation of all parameters.
    fn of<const D: usize>(
        scene: &SmpmScene,
        strength: f64,
        n_samples: u64,
    ) -> Result<Self, CaseError> {
        let experiment = experiment::<D>(scene)?;
        let study = Study::new(&experiment, scene.inputs()?, scene.plan::<D>()?)?;
        let propagated = study.propagated()?;
        let sampled = study.monte_carlo(MonteCarlo { seed: 2020, n_samples })?;
        let plan = study.plan();
        let name = |response| {
            let (gauge, quantity, window) = plan.parts(response);
            (plan.gauges[gauge].name.clone(), quantity, plan.windows[window].to)
        };
        let responses = (0..plan.n_responses()).map(name).collect();
        let (mut variance, mut standard_error, mut raw_error) = (vec![], vec![], vec![]);
        for (response, surrogate) in propagated.moments.iter().enumerate() {
            let found = sampled.controlled(response, surrogate)?.variance;
            let raw = sampled.raw(response)?.variance.standard_error().unwrap_or(f64::NAN);
            variance.push(found.value);
            standard_error.push(found.standard_error().unwrap_or(f64::NAN) / found.value);
            raw_error.push(raw * (sampled.n_samples() as f64 / RAW).sqrt() / found.value);
        }
        let against = |variances: Vec<f64>| -> Vec<f64> {
            variances.iter().zip(&variance).map(|(found, truth)| found / truth - 1.0).collect()
        };
        let taylor = |moments: &[Series]| moments.iter().map(Series::variance).collect();
        let judged = |variances: Result<Vec<f64>, Error>| {
            variances.map(against).map_err(|error| error.to_string())
        };
        let frozen = study.frozen(FrozenForm::Corrected).map(|all| {
            let of = |series: &Option<Series>| series.as_ref().map_or(f64::NAN, Series::variance);
            all.iter().map(of).collect()
        });
        let errors = vec![
            judged(frozen),
            judged(Ok(taylor(&propagated.moments))),
            judged(study.finite_difference(DIFFERENCE).map(|moments| taylor(&moments))),
            judged(
                study
                    .sigma_points()
                    .map(|all| all.iter().map(Series::surrogate_variance).collect()),
            ),
        ];
        let indicator = |(series, switch): (&Series, &Switch)| {
            (series.curvature_ratio().map_or(f64::NAN, f64::sqrt), switch.at_end)
        };
        let indicators = propagated.moments.iter().zip(&propagated.switches).map(indicator);
        Ok(Self {
            coefficient_of_variation: strength,
            indicators: indicators.collect(),
            responses,
            errors,
            standard_error,
            raw_error,
            n_failed: sampled.failures.len(),
        })
    }

    fn response(&self, gauge: &str, quantity: usize, time: f64) -> Result<usize, CaseError> {
        let is_it = |known: &(String, usize, f64)| {
            known.0 == gauge && known.1 == quantity && (known.2 - time).abs() < 1e-9
        };
        let found = self.responses.iter().position(is_it);
        found.ok_or_else(|| "no response at this gauge and time".into())
    }

    /// `r` for curvature, `s` for a switch within two deviations.
    fn warning(&self, response: usize) -> Option<&'static str> {
        let (ratio, switch) = self.indicators[response];
        match (ratio.is_nan() || ratio >= TRUSTED, switch <= Switch::LIMIT) {
            (true, true) => Some("r s"),
            (true, false) => Some("r"),
            (false, true) => Some("s"),
            (false, false) => None,
        }
    }
}

pub(super) fn charts(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let strengths: &[f64] =
        if is_quick { &[0.05, 0.3] } else { &[0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5] };
    let n_samples = if is_quick { 24 } else { 200 };
    let mut drawings = Vec::new();
    for look in &LOOKS {
        let mut judged = Vec::new();
        for &strength in strengths {
            context.progress(&format!("Taylor series, {:?} at {strength}", look.problem));
            let scene = look.scene(strength)?;
            judged.push(match scene.dimension {
                1 => Judged::of::<1>(&scene, strength, n_samples)?,
                _ => Judged::of::<2>(&scene, strength, n_samples)?,
            });
        }
        for &(name, words, gauge, quantity, time) in look.at {
            let response = judged[0].response(gauge, quantity, time)?;
            drawings.push(over_variation((name, words, look.words), &judged, response, n_samples)?);
        }
    }
    Ok(drawings)
}

/// A line on the chart of errors: its name, and its value at a response.
type Level = (&'static str, fn(&Judged, usize) -> f64);

/// Error of every method over the coefficient of variation, with warnings of the indicators.
fn over_variation(
    (name, what, problem): (&str, &str, &str),
    judged: &[Judged],
    response: usize,
    n_samples: u64,
) -> Result<Drawing, CaseError> {
    let point = |one: &Judged, value: Result<f64, String>, bar, label: Option<&str>| Run {
        cost: one.coefficient_of_variation,
        cost_error: None,
        outcome: match value {
            Ok(value) if value > 0.0 && value.is_finite() => {
                RunOutcome::Error { value, standard_error: bar }
            }
            Ok(value) => RunOutcome::Failed { reason: format!("the error is {value}") },
            Err(reason) => RunOutcome::Failed { reason },
        },
        label: label.map(str::to_owned),
    };
    let mut series = Vec::new();
    for (m, method) in METHODS.into_iter().enumerate() {
        let run = |one: &Judged| {
            let value = one.errors[m].as_ref().map(|errors| errors[response].abs());
            let label = if m == 1 { one.warning(response) } else { None };
            point(one, value.map_err(Clone::clone), Some(one.standard_error[response]), label)
        };
        series.push(Method { name: method.into(), runs: judged.iter().map(run).collect() });
    }
    let others: [Level; 2] = [
        ("standard error of 100 raw samples", |one, response| one.raw_error[response]),
        ("curvature ratio r of the jets", |one, response| one.indicators[response].0),
    ];
    for (method, of) in others {
        let run = |one: &Judged| point(one, Ok(of(one, response)), None, None);
        series.push(Method { name: method.into(), runs: judged.iter().map(run).collect() });
    }
    let n_failed: usize = judged.iter().map(|one| one.n_failed).sum();
    let words = Words {
        title: format!("Error of the variance: {what}"),
        subtitle: format!(
            "{problem}; all parameters alike, normal up to {MOST_NORMAL}, lognormal beyond"
        ),
        x_label: "coefficient of variation of every parameter".into(),
        y_label: "relative error of the variance".into(),
        caption: vec![
            format!(
                "Against {n_samples} samples with control variate; bars: their standard error. {n_failed} samples of all failed."
            ),
            format!(
                "Jets and differences lie on each other. Letters at the jets: warned, r by a curvature ratio of {TRUSTED} or more, s by a switch between elastic and plastic within two deviations."
            ),
        ],
    };
    let mut rows = vec![format!("  {what}: {}", METHODS.join(" | "))];
    rows.extend(judged.iter().map(|one| one.row(response)));
    let name = format!("smpm-breakdown-{name}");
    // Every method runs at the same coefficients.
    let chart = WorkPrecision { words, reading: Reading::Parameter, series };
    Ok(Drawing::work_precision(&name, &chart)?.with_rows(&rows.join("\n")))
}
