//! Error estimates of a density run from coarser runs.

use fpk_sph::{Combination, Config, Error, InitialLattice, Method, Remapping};
use scene_runs::answers::Unknown;

use super::observed::Observed;
use super::resolution_error::{self, Orders, error_of_finest};
use super::step_runs::{Interval, StepRuns, step_runs, with_steps_of_interval};
use crate::density::{DensityRun, Row};

/// Resolutions of the coarser runs, as particles along a length relative to the fine run.
///
/// The first shows the order best. The others serve systems of many states, where a lattice that much coarser no
/// longer resolves the density.
const COARSER: [f64; 3] = [std::f64::consts::FRAC_1_SQRT_2, 0.8, 0.9];

/// Orders of the error in the spacing: the one that the verification measures, and that of the cubic fit.
const ORDERS: Orders = Orders { of_method: 2.0, largest: 4.0 };
/// With a third run an observed order counts up to this one: smooth densities converge faster than the verification asks for.
const OBSERVED: Orders = Orders { of_method: 4.0, largest: 6.0 };

/// A fine run, and the coarser runs for its error.
pub(super) struct Resolutions {
    pub(super) fine: DensityRun,
    coarser: Vec<Coarser>,
    /// Why coarser runs are missing.
    failed: Vec<String>,
    /// What the error by these runs leaves out.
    shared: Shared,
}

/// An error that runs at all resolutions share.
#[derive(Debug, Clone, PartialEq)]
enum Shared {
    /// No part is known to be shared.
    None,
    /// In four states and more, the part of the reach of the lattice.
    Reach { states: usize },
    /// That of settling too: the run that would show it is missing from a time on, for a reason.
    Settling { states: usize, from: f64, reason: String },
}

/// A coarser run.
struct Coarser {
    run: DensityRun,
    /// Its spacing over that of the fine run.
    ratio: f64,
    /// The same run with settling half as fast, in four states and more.
    slower: Option<DensityRun>,
    /// A third, coarser run and the ratio of its spacing to that of this run; none if its lattice is too coarse for the problem.
    coarsest: Option<(DensityRun, f64)>,
    /// The same run with other steps; none by a rule whose steps follow the spacing.
    steps: Option<StepRuns>,
}

impl Resolutions {
    /// Runs coarser configurations by `solve` until their results cover every time of the fine run, and for each of them one that is
    /// coarser by the same ratio. In four states and more, where lattices are coarse, the flow-map fit also runs with settling half
    /// as fast ([`Config::with_slower_settling`]).
    ///
    /// The first argument is the configuration for a fraction of the particles along a length; that of `solve` has the name of the run.
    /// The error of the steps is measured on the coarser lattice, by runs
    /// with longer ones ([`step_runs`]). A failure of a coarser run does not count against the fine one.
    ///
    /// # Errors
    /// Errors of `solve` that are not errors of the solver.
    pub(super) fn new<E, const D: usize>(
        fine: DensityRun,
        (config, interval): (impl Fn(f64) -> Option<Config<D>>, Interval),
        solve: impl Fn(&str, &Config<D>) -> Result<Result<DensityRun, Error>, E>,
    ) -> Result<Self, E> {
        let (mut coarser, mut failed) = (Vec::new(), Vec::new());
        let resolution = config(1.0).map_or(f64::NAN, |config| per_length(&config.lattice));
        let mut slow_failure = "no coarser run came so far".to_owned();
        // Configuration at a part of the resolution, and the ratio of its spacing to that of the fine run.
        let at = |part: f64| {
            let config = config(part)?;
            let ratio = resolution / per_length(&config.lattice);
            let config = with_steps_of_interval(config, interval);
            Some((within_the_work_of(&fine, config), ratio))
        };
        let name_of = |part: f64| format!("density at {part:.3} of the resolution");
        for part in COARSER {
            let Some((config, ratio)) = at(part) else { continue };
            if ratio.is_nan() || ratio <= 1.0 {
                failed.push(format!("at {part:.2} of the resolution the lattice is the same"));
                continue;
            }
            let name = name_of(part);
            match solve(&name, &config)? {
                Ok(run) => {
                    let complete = run.rows.len() >= fine.rows.len();
                    if let Some(error) = &run.stopped {
                        failed.push(format!("at {part:.2} of the resolution: {error}"));
                    }
                    let mut slower = None;
                    if let Some(config) = slower_of(&config) {
                        match solve(&format!("{name}, settling half as fast"), &config)? {
                            Ok(run) => {
                                slow_failure = run
                                    .stopped
                                    .as_ref()
                                    .map_or_else(String::new, ToString::to_string);
                                slower = Some(run);
                            }
                            Err(error) => slow_failure = error.to_string(),
                        }
                    }
                    // If this lattice is too coarse for the problem, the estimate uses two resolutions.
                    let coarsest = match at(part * part) {
                        Some((config, of_fine)) if of_fine > ratio => {
                            let run = solve(&name_of(part * part), &config)?;
                            run.ok().map(|run| (run, of_fine / ratio))
                        }
                        _ => None,
                    };
                    let other = |words: &str, config: &Config<D>| {
                        solve(&format!("{name}, with {words}"), config)
                    };
                    let steps = step_runs((&config, &run), interval, other)?;
                    if matches!(steps, Some(StepRuns::Failed)) {
                        failed.push(format!(
                            "at {part:.2} of the resolution no run with other steps came so far"
                        ));
                    }
                    coarser.push(Coarser { run, ratio, slower, coarsest, steps });
                    if complete {
                        break;
                    }
                }
                Err(error) => failed.push(format!("at {part:.2} of the resolution: {error}")),
            }
        }
        let mut both = Self { fine, coarser, failed, shared: Shared::None };
        if config(1.0).is_some_and(|config| slower_of(&config).is_some()) {
            both.shared = match both.first_without_settling() {
                None => Shared::Reach { states: D },
                Some(from) => Shared::Settling { states: D, from, reason: slow_failure },
            };
        }
        Ok(both)
    }

    /// The first time at which no run shows the error of settling.
    fn first_without_settling(&self) -> Option<f64> {
        let shows = |t: f64| {
            let seen =
                |coarser: &Coarser| coarser.slower.as_ref().is_some_and(|it| it.at(t).is_some());
            self.coarser.iter().find(|coarser| coarser.run.at(t).is_some()).is_some_and(seen)
        };
        self.fine.rows.iter().map(|row| row.t).find(|&t| !shows(t))
    }

    /// Errors that no coarser run estimates.
    pub(super) fn unknown(&self) -> Option<Unknown> {
        let has_error = |coarser: &Coarser, t: f64| {
            coarser.run.at(t).is_some() && !matches!(coarser.steps, Some(StepRuns::Failed))
        };
        let seen = |row: &&Row| !self.coarser.iter().any(|coarser| has_error(coarser, row.t));
        let first = self.fine.rows.iter().find(seen)?;
        Some(Unknown {
            what: format!("errors of all quantities from t = {} on", first.t),
            reason: format!(
                "they are estimated from a coarser run, and none came so far: {}",
                self.failed.join("; ")
            ),
        })
    }

    /// The part of all errors that these runs do not show: that of the reach, and where a run is missing that of settling.
    pub(super) fn not_shown(&self) -> Option<Unknown> {
        let see = "See \"The error of a run\" in docs/methods/fpk-sph.md";
        let (what, reason) = match &self.shared {
            Shared::None => return None,
            Shared::Reach { states } => (
                "the part of the errors that these runs share".to_owned(),
                format!(
                    "that of the reach of the lattice does not show in their difference in {states} states. {see}"
                ),
            ),
            Shared::Settling { states, from, reason } => (
                format!("the part of the errors that these runs share from t = {from} on"),
                format!(
                    "that of settling and of the reach of the lattice does not show in their difference; with {states} states and \
                     a nonlinear spring it was up to ten times the error stated for second moments. The run that shows \
                     settling is missing: {reason}. {see}"
                ),
            ),
        };
        Some(Unknown { what, reason })
    }

    /// The fine value with the error by coarser runs ([`error_of_finest`]) and that of settling where a run shows it, as independent
    /// parts. The second is `2 |coarse - slow| / r^2`, of the coarse run and the same with settling half as fast; a third is the error of
    /// the steps on the coarser lattice.
    pub(super) fn values(&self, pick: impl Fn(&Row) -> Option<f64>) -> Vec<Observed> {
        let observed = |row: &Row| {
            let value = pick(row)?;
            let estimate = |coarser: &Coarser| {
                let coarse = pick(coarser.run.at(row.t)?)?;
                let square = coarser.ratio * coarser.ratio;
                let slow = coarser.slower.as_ref().and_then(|slow| pick(slow.at(row.t)?));
                let settling = slow.map_or(0.0, |slow| 2.0 * (coarse - slow).abs() / square);
                let coarsest = coarser.coarsest.as_ref().and_then(|(run, ratio)| {
                    Some(resolution_error::Coarser { value: pick(run.at(row.t)?)?, ratio: *ratio })
                });
                let coarse = resolution_error::Coarser { value: coarse, ratio: coarser.ratio };
                let orders = if coarsest.is_some() { OBSERVED } else { ORDERS };
                let error = error_of_finest(value, coarse, coarsest, orders).hypot(settling);
                let of_steps =
                    |runs: &StepRuns| runs.error(coarse.value, |run| pick(run.at(row.t)?));
                let steps = coarser.steps.as_ref().map_or(Some(0.0), of_steps)?;
                let error = error.hypot(steps);
                error.is_finite().then_some(error)
            };
            Some(Observed::by_two(row.t, value, self.coarser.iter().find_map(estimate)))
        };
        Observed::without_sign_changes(self.fine.rows.iter().filter_map(observed).collect())
    }
}

/// States from which two lattices share much of an error: those of four states are coarse.
const SHARED_FROM: usize = 4;

/// The configuration with settling half as fast, where two lattices share its error.
fn slower_of<const D: usize>(config: &Config<D>) -> Option<Config<D>> {
    if D >= SHARED_FROM { config.with_slower_settling() } else { None }
}

/// The configuration of a coarser run, which ends once it takes more work than the fine one: where a density is extrapolated too far, a
/// coarser lattice can have more cells and shorter steps.
fn within_the_work_of<const D: usize>(fine: &DensityRun, config: Config<D>) -> Config<D> {
    let combination = config.method.combination_in(D);
    let most = MOST_GROWTH * fine.n_particles;
    let remapping = combination.remapping.map(|remapping| Remapping {
        most_particles: remapping.most_particles.min(most),
        ..remapping
    });
    let most_steps = config.most_steps.min(2 * fine.work.steps + FEWEST_STEPS);
    let method = Method::Custom(Combination { remapping, ..combination });
    Config { method, most_steps, ..config }
}

/// Most particles of a coarser run over those at the start of the fine one, and steps that it may take in any case.
const MOST_GROWTH: usize = 16;
const FEWEST_STEPS: u64 = 1_000;

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
    use fpk_sph::{DEFAULT_MOST_STEPS, StepRule};

    use super::*;

    /// A run that recorded one moment at these times.
    fn run(moment: f64, times: &[f64]) -> DensityRun {
        let row = |&t: &f64| Row {
            t,
            moments: vec![moment],
            scales: vec![moment.abs()],
            offsets: vec![0.0],
            violation: 0.0,
            exceedances: Vec::new(),
            beside: Vec::new(),
            total_mass: 1.0,
            mass_outside: 0.0,
            is_remeshed: false,
            entropy: 0.0,
            cell_mass: None,
            cpu_seconds: 0.0,
        };
        DensityRun {
            rows: times.iter().map(row).collect(),
            n_particles: 1,
            work: fpk_sph::Work::default(),
            stopped: None,
        }
    }

    /// The resolutions of runs that take the steps of their configurations, at most as long as a limit.
    fn resolutions<const D: usize>(
        fine: DensityRun,
        config: impl Fn(f64) -> Option<Config<D>>,
        longest: f64,
        solve: impl Fn(&str, &Config<D>) -> Result<DensityRun, Error>,
    ) -> Resolutions {
        let counted = |mut run: DensityRun, config: &Config<D>| {
            // A whole number of steps in each interval, counted by its rows.
            let each = 1.0 / step(config).min(longest);
            run.work.steps =
                (1..=100_u32).find(|n| f64::from(*n) > each - 0.5).map_or(0, u64::from)
                    * run.rows.len() as u64;
            run
        };
        let fine = counted(fine, &config(1.0).unwrap());
        let solve = |name: &str, config: &Config<D>| {
            Ok::<_, std::convert::Infallible>(solve(name, config).map(|run| counted(run, config)))
        };
        let interval = Interval { periods: 1.0, has_kinks: false };
        Resolutions::new(fine, (config, interval), solve).unwrap()
    }

    /// Its step in periods.
    fn step<const D: usize>(config: &Config<D>) -> f64 {
        match config.method.combination_in(D).step {
            StepRule::PeriodFraction { steps_per_period } => 1.0 / steps_per_period,
            _ => 1.0,
        }
    }

    #[test]
    fn steps_that_a_limit_of_stability_sets_are_halved_for_their_error() {
        // A step h leaves h^2, and none is longer than 0.01.
        let both = resolutions(run(1.0001, &[1.0, 2.0]), config, 0.01, |_, config| {
            Ok(run(1.0 + step(config).min(0.01).powi(2), &[1.0, 2.0]))
        });
        let error = both.values(|row| Some(row.moments[0]))[0].error.unwrap();
        assert!((error - 0.75e-4).abs() < 1e-9, "{error}");
    }

    #[test]
    fn an_error_that_crosses_zero_between_two_lattices_is_seen_on_the_third() {
        let both = of(|config| {
            let value = if spacing(config) > 1.9 { 1.5 } else { 1.1 };
            Ok(run(value, &[1.0, 2.0]))
        });
        let error = both.values(|row| Some(row.moments[0]))[0].error.unwrap();
        // The error of the coarser run is 0.4 / (2^2 - 1); that of the fine one falls with the order 6 at most, by 2^3.
        assert!((error - 0.4 / 3.0 / 8.0).abs() < 1e-12, "{error}");
    }

    /// A ball whose spacing is 1 at the whole resolution.
    fn ball<const D: usize>(method: Method) -> impl Fn(f64) -> Option<Config<D>> {
        move |part| {
            Some(Config {
                method,
                lattice: InitialLattice::Ball { reach: 5.0, spacing: 1.0 / part },
                reference_period: 1.0,
                most_steps: DEFAULT_MOST_STEPS,
            })
        }
    }

    fn config(part: f64) -> Option<Config<2>> {
        ball(Method::FlowMapFit)(part)
    }

    fn spacing(config: &Config<2>) -> f64 {
        1.0 / per_length(&config.lattice)
    }

    fn of(solve: impl Fn(&Config<2>) -> Result<DensityRun, Error>) -> Resolutions {
        resolutions(run(1.1, &[1.0, 2.0]), config, 1.0, |_, config| solve(config))
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
    fn an_error_of_the_steps_shows_whatever_its_order_is() {
        for order in [1, 2, 3, 4] {
            // The value at the step s is 1 + s^order; the spacing has no error.
            let value = |config: &Config<2>| 1.0 + step(config).powi(order);
            let fine = run(value(&config(1.0).unwrap()), &[1.0]);
            let both = resolutions(fine, config, 1.0, |_, config| Ok(run(value(config), &[1.0])));
            let error = both.values(|row| Some(row.moments[0]))[0].error.unwrap();
            let exact = step(&config(1.0).unwrap()).powi(order);
            assert!((error / exact - 1.0).abs() < 1e-6, "{order}: {error}");
        }
    }

    fn in_four_states(method: Method, slow: f64) -> Resolutions {
        resolutions(run(1.0, &[1.0]), ball::<4>(method), 1.0, |name, config| {
            let h = 1.0 / per_length(&config.lattice);
            let value =
                if name.contains("half as fast") { slow } else { 1.0 + 0.1 * (h * h - 1.0) };
            Ok(run(value, &[1.0]))
        })
    }

    #[test]
    fn four_states_by_the_flow_map_fit_add_the_error_of_settling() {
        let slow = in_four_states(Method::FlowMapFit, 1.4);
        // 0.1 by two lattices whose spacings are apart by the root of two; 2 (1.4 - 1.1)/2 by settling, independent of it.
        let error = slow.values(|row| Some(row.moments[0]))[0].error.unwrap();
        assert!((error - 0.1_f64.hypot(0.3)).abs() < 1e-12, "{error}");
        assert!(slow.not_shown().unwrap().reason.starts_with("that of the reach"));
        let none = in_four_states(Method::CanorDenoel2013, 1.4);
        let error = none.values(|row| Some(row.moments[0]))[0].error.unwrap();
        assert!((error - 0.1).abs() < 1e-12, "{error}");
        assert_eq!(none.not_shown(), None);
        assert_eq!(of(|_| Ok(run(1.0, &[1.0, 2.0]))).not_shown(), None);
    }

    #[test]
    fn a_run_that_would_show_settling_and_stopped_is_said_to_be_missing() {
        let four = ball::<4>(Method::FlowMapFit);
        let both = resolutions(run(1.0, &[1.0, 2.0]), four, 1.0, |name, _| {
            if name.contains("half as fast") {
                Err(Error::NotPositive { name: "a name", value: 0.0 })
            } else {
                Ok(run(1.1, &[1.0, 2.0]))
            }
        });
        let said = both.not_shown().unwrap();
        assert_eq!(said.what, "the part of the errors that these runs share from t = 1 on");
        assert!(said.reason.contains("settling is missing: a name"), "{}", said.reason);
        assert!(said.reason.contains("with 4 states"), "{}", said.reason);
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
