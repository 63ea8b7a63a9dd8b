//! Error estimates of a density run from coarser runs.

use fpk_sph::{Combination, Config, Error, InitialLattice, Method, StepRule};

use super::observed::Observed;
use crate::fpk::density::{DensityRun, Row};
use crate::run_result::Unknown;

/// Resolutions of the coarser runs, as particles along a length relative to the fine run.
///
/// The first shows the order best. The others serve systems of many states, where a lattice that much coarser no
/// longer resolves the density.
const COARSER: [f64; 3] = [std::f64::consts::FRAC_1_SQRT_2, 0.8, 0.9];

/// A fine run, and the coarser runs for its error.
pub(super) struct TwoResolutions {
    pub(super) fine: DensityRun,
    coarser: Vec<Coarser>,
    /// Why coarser runs are missing.
    failed: Vec<String>,
}

/// A coarser run.
struct Coarser {
    run: DensityRun,
    /// Its spacing over that of the fine run.
    ratio: f64,
}

impl TwoResolutions {
    /// Runs coarser configurations by `solve` until their results cover every time of the fine run.
    ///
    /// The argument is the configuration for a fraction of the particles along a length. The steps of a coarser run are
    /// longer too ([`with_longer_steps`]). A failure of a coarser run does not count against the fine one.
    ///
    /// # Errors
    /// Errors of `solve` that are not errors of the solver.
    pub(super) fn new<E, const D: usize>(
        fine: DensityRun,
        config: impl Fn(f64) -> Option<Config<D>>,
        solve: impl Fn(f64, &Config<D>) -> Result<Result<DensityRun, Error>, E>,
    ) -> Result<Self, E> {
        let (mut coarser, mut failed) = (Vec::new(), Vec::new());
        let resolution = config(1.0).map_or(f64::NAN, |config| per_length(&config.lattice));
        for part in COARSER {
            let Some(config) = config(part) else { continue };
            let ratio = resolution / per_length(&config.lattice);
            if ratio.is_nan() || ratio <= 1.0 {
                failed.push(format!("at {part:.2} of the resolution the lattice is the same"));
                continue;
            }
            match solve(part, &with_longer_steps(config, part))? {
                Ok(run) => {
                    let complete = run.rows.len() >= fine.rows.len();
                    if let Some(error) = &run.stopped {
                        failed.push(format!("at {part:.2} of the resolution: {error}"));
                    }
                    coarser.push(Coarser { run, ratio });
                    if complete {
                        break;
                    }
                }
                Err(error) => failed.push(format!("at {part:.2} of the resolution: {error}")),
            }
        }
        Ok(Self { fine, coarser, failed })
    }

    /// Errors that no coarser run estimates.
    pub(super) fn unknown(&self) -> Option<Unknown> {
        let seen = |row: &&Row| self.coarser.iter().all(|coarser| coarser.run.at(row.t).is_none());
        let first = self.fine.rows.iter().find(seen)?;
        Some(Unknown {
            what: format!("errors of all quantities from t = {} on", first.t),
            reason: format!(
                "they are estimated from a coarser run, and none came so far: {}",
                self.failed.join("; ")
            ),
        })
    }

    /// The fine value with Richardson's error estimate.
    ///
    /// The estimate is `|fine - coarse| / (r^2 - 1)`, with `r` the ratio of the spacings, at the order 2 that the
    /// verification measures.
    pub(super) fn values(&self, pick: impl Fn(&Row) -> Option<f64>) -> Vec<Observed> {
        let observed = |row: &Row| {
            let value = pick(row)?;
            let estimate = |coarser: &Coarser| {
                let coarse = pick(coarser.run.at(row.t)?)?;
                let error = (value - coarse).abs() / (coarser.ratio * coarser.ratio - 1.0);
                error.is_finite().then_some(error)
            };
            Some(Observed::by_two(row.t, value, self.coarser.iter().find_map(estimate)))
        };
        self.fine.rows.iter().filter_map(observed).collect()
    }
}

/// States from which two lattices share most of an error: those of four states are coarse.
const SHARED_FROM: usize = 4;

/// The part of all errors that no coarser run shows: that of settling, which only the flow-map fit has, and of the reach.
pub(super) fn not_shown<const D: usize>(config: &Config<D>) -> Option<Unknown> {
    (D >= SHARED_FROM && config.with_slower_settling().is_some()).then(|| Unknown {
        what: "the part of the errors that runs at two resolutions share".to_owned(),
        reason: format!(
            "that of settling and of the reach of the lattice does not show in their difference; with {D} states and a \
             nonlinear spring it was up to ten times the error stated for second moments. See \"The error of a run\" in \
             docs/methods/fpk-sph.md"
        ),
    })
}

/// The configuration with steps longer by the square of the ratio of the spacings, where the rule is a fraction of the period.
///
/// An error of first order in the step then falls like one of second order in the spacing, which the estimate assumes; one
/// of a higher order is overestimated. The diffusion limit and the Courant rule follow the spacing by themselves.
fn with_longer_steps<const D: usize>(config: Config<D>, part: f64) -> Config<D> {
    let combination = config.method.combination_in(D);
    let StepRule::PeriodFraction { steps_per_period } = combination.step else {
        return config;
    };
    let step = StepRule::PeriodFraction { steps_per_period: part * part * steps_per_period };
    Config { method: Method::Custom(Combination { step, ..combination }), ..config }
}

/// Number of intervals of the lattice along a length: the geometric mean over the axes.
fn per_length<const D: usize>(lattice: &InitialLattice<D>) -> f64 {
    match lattice {
        InitialLattice::Ball { spacing, .. } => 1.0 / spacing,
        InitialLattice::Box { count, .. } | InitialLattice::Rectangle { count, .. } => {
            let intervals: f64 = count.iter().map(|&n| n as f64 - 1.0).product();
            intervals.powf(1.0 / D as f64)
        }
    }
}

#[cfg(test)]
mod tests {
    use fpk_sph::{DEFAULT_MOST_STEPS, Method};

    use super::*;

    /// A run that recorded one moment at these times.
    fn run(moment: f64, times: &[f64]) -> DensityRun {
        let row = |&t: &f64| Row {
            t,
            moments: vec![moment],
            exceedances: Vec::new(),
            total_mass: 1.0,
            mass_outside: 0.0,
            entropy: 0.0,
            cell_mass: None,
            distrusted_cells: None,
            cpu_seconds: 0.0,
        };
        DensityRun {
            rows: times.iter().map(row).collect(),
            n_particles: 1,
            work: fpk_sph::Work::default(),
            stopped: None,
        }
    }

    #[allow(clippy::unnecessary_wraps, reason = "the shape that is asked for")]
    fn config(part: f64) -> Option<Config<2>> {
        Some(Config {
            method: Method::FlowMapFit,
            lattice: InitialLattice::Ball { reach: 5.0, spacing: 1.0 / part },
            reference_period: 1.0,
            most_steps: DEFAULT_MOST_STEPS,
        })
    }

    fn spacing(config: &Config<2>) -> f64 {
        1.0 / per_length(&config.lattice)
    }

    fn of(solve: impl Fn(&Config<2>) -> Result<DensityRun, Error>) -> TwoResolutions {
        let solve = |_: f64, config: &Config<2>| Ok::<_, std::convert::Infallible>(solve(config));
        TwoResolutions::new(run(1.1, &[1.0, 2.0]), config, solve).unwrap()
    }

    #[test]
    fn an_error_of_second_order_is_found_as_it_is_by_whichever_coarser_run_has_come_so_far() {
        // The value at spacing h is 1 + 0.1 h^2; lattices coarser than 1.3 end at t = 1.
        let both = of(|config| {
            let h = spacing(config);
            let times = if h > 1.3 { &[1.0][..] } else { &[1.0, 2.0] };
            Ok(run(1.0 + 0.1 * h * h, times))
        });
        let values = both.values(|row| Some(row.moments[0]));
        assert_eq!(values.len(), 2);
        for observed in values {
            assert!((observed.error.unwrap() - 0.1).abs() < 1e-12, "{observed:?}");
        }
        assert_eq!(both.unknown(), None);
    }

    #[test]
    fn the_coarser_run_takes_longer_steps_so_that_their_error_shows() {
        let step = |config: &Config<2>| match config.method.combination().step {
            StepRule::PeriodFraction { steps_per_period } => 1.0 / steps_per_period,
            _ => f64::NAN,
        };
        let error_of = |order: i32| {
            // The value at the step s is 1 + s^order; the spacing has no error.
            let fine = step(&config(1.0).unwrap()).powi(order);
            let both = TwoResolutions::new(run(1.0 + fine, &[1.0]), config, |_, config| {
                let value = 1.0 + step(config).powi(order);
                Ok::<_, std::convert::Infallible>(Ok(run(value, &[1.0])))
            });
            let values = both.unwrap().values(|row| Some(row.moments[0]));
            values[0].error.unwrap() / fine
        };
        assert!((error_of(1) - 1.0).abs() < 1e-9, "{}", error_of(1));
        assert!((error_of(2) - 3.0).abs() < 1e-9, "{}", error_of(2));
    }

    #[test]
    fn four_states_by_the_flow_map_fit_say_what_their_errors_leave_out() {
        let of = |method| Config::<4> {
            method,
            lattice: InitialLattice::Ball { reach: 5.0, spacing: 1.0 },
            reference_period: 1.0,
            most_steps: DEFAULT_MOST_STEPS,
        };
        let said = not_shown(&of(Method::FlowMapFit)).unwrap();
        assert!(said.reason.contains("with 4 states"), "{}", said.reason);
        assert_eq!(not_shown(&of(Method::LogDensityFit)), None);
        assert_eq!(not_shown(&config(1.0).unwrap()), None);
    }

    #[test]
    fn what_no_coarser_run_shows_is_unknown_and_says_since_when_and_why() {
        let both = of(|config| {
            if spacing(config) > 1.3 {
                return Err(Error::NotPositive { name: "a name", value: 0.0 });
            }
            Ok(run(1.2, &[1.0]))
        });
        let values = both.values(|row| Some(row.moments[0]));
        assert!(values[0].error.is_some() && values[1].error.is_none());
        let unknown = both.unknown().unwrap();
        assert_eq!(unknown.what, "errors of all quantities from t = 2 on");
        assert!(unknown.reason.contains("at 0.71 of the resolution: a name"), "{}", unknown.reason);
    }
}
