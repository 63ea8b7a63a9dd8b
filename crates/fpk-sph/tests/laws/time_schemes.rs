//! Schemes in time: order, limit of stability, memory, and what is refused.

use fpk_sph::score::{Degree, Estimates, FlowMapFit, LatticePlaces, LocalMap};
use fpk_sph::{
    Cloud, Combination, Config, Error, InitialLattice, MOST_NEGLIGIBLE, Method, Remapping, Scheme,
    ScoreEstimator, Simulation, StepRule,
};
use neighbour_search::Criterion;
use sde_integrators::{Additive, GaussianMixture, Sde};
use vibrating_systems::{
    BoucWen, BoucWenParameters, LinearOscillator, OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters,
    TwoStorey, TwoStoreyParameters, ViscousDamper, Window,
};

use crate::fixtures::{self, changed, damper, law, oscillator, same_bits};

fn config(scheme: Scheme, step: StepRule, count: usize) -> Config<2> {
    let method = changed(|c| (c.scheme, c.step) = (scheme, step));
    Config { method, ..fixtures::config(InitialLattice::box_of(count), 2.0) }
}

fn run(config: &Config<2>, time: f64) -> Simulation<ViscousDamper, 2, 1> {
    let mut simulation = Simulation::new(damper(), &law(), config).unwrap();
    simulation.advance_to(time).unwrap();
    simulation
}

/// Evaluations of one step.
fn evaluations(simulation: &mut Simulation<ViscousDamper, 2, 1>) -> u64 {
    let before = simulation.work().evaluations;
    let _report = simulation.step().unwrap();
    simulation.work().evaluations - before
}

/// A damped linear oscillator whose covariance is known.
fn process() -> OrnsteinUhlenbeck<2> {
    let w = std::f64::consts::PI;
    OrnsteinUhlenbeck::new(OrnsteinUhlenbeckParameters {
        rates: [[0.0, -1.0], [w * w, 0.4]],
        mean: [0.0; 2],
        noise: [[0.0, 0.0], [0.0, 0.3]],
    })
    .unwrap()
}

/// The worse relative error of both variances of [`process`] at `t = 1.5` after so many steps.
fn error_of_variances(scheme: Scheme, n_steps: u32) -> f64 {
    let time = 1.5;
    let config = Config {
        lattice: InitialLattice::Box { reach: 8.0, count: [21, 21] },
        ..config(scheme, StepRule::Fixed { dt: time / f64::from(n_steps) }, 21)
    };
    let mut simulation = Simulation::new(process(), &law(), &config).unwrap();
    simulation.advance_to(time).unwrap();
    let exact = process().covariance_at(time, &law().covariance()).unwrap();
    let error = |powers, exact: f64| (simulation.raw_moment(powers) / exact - 1.0).abs();
    error([2, 0], exact[0][0]).max(error([0, 2], exact[1][1]))
}

#[test]
fn each_scheme_has_its_order_on_the_linear_process() {
    for (scheme, order) in [(Scheme::RungeKutta4, 4.0), (Scheme::LawsonAdamsBashforth2, 2.0)] {
        let errors = [24, 48, 96].map(|n_steps| error_of_variances(scheme, n_steps));
        for pair in errors.windows(2) {
            let found = (pair[0] / pair[1]).log2();
            // The next term of the error is half as large at half the step.
            assert!((found - order).abs() < 0.3, "{scheme:?}: {errors:?}");
        }
    }
}

#[test]
fn an_undamped_oscillator_gains_and_loses_energy_by_the_root_of_each_scheme() {
    let system = oscillator(std::f64::consts::PI, 0.0, 0.0);
    let (dt, n_steps) = (0.02_f64, 500.0);
    let theta = std::f64::consts::PI * dt;
    // |R(i theta)|^2 - 1 of a step; roundoff of the moments in 500 steps, 1e-13, over the growth of all.
    for (scheme, growth, within) in [
        (Scheme::ForwardEuler, theta.powi(2), 1e-12),
        (Scheme::RungeKutta4, -theta.powi(6) / 72.0 + theta.powi(8) / 576.0, 3e-7),
    ] {
        let step = StepRule::Fixed { dt };
        let combination = Combination { scheme, step, ..Method::CanorDenoel2013.combination() };
        let config = Config {
            method: Method::Custom(combination),
            lattice: InitialLattice::Box { reach: 4.0, count: [15, 15] },
            ..config(scheme, step, 15)
        };
        let mut simulation = Simulation::new(system.clone(), &law(), &config).unwrap();
        let energy = |simulation: &Simulation<LinearOscillator, 2, 1>| {
            let stiffness = std::f64::consts::PI.powi(2);
            simulation.raw_moment([0, 2]) + stiffness * simulation.raw_moment([2, 0])
        };
        let start = energy(&simulation);
        simulation.advance_to(dt * n_steps).unwrap();
        let found = energy(&simulation) / start - 1.0;
        let expected = (n_steps * growth.ln_1p()).exp_m1();
        assert!((found / expected - 1.0).abs() < within, "{scheme:?}: {found:e} {expected:e}");
    }
}

#[test]
fn without_noise_the_exact_flow_has_no_error_of_the_step() {
    let quiet = OrnsteinUhlenbeck::new(OrnsteinUhlenbeckParameters {
        noise: [[0.0; 2]; 2],
        ..*process().parameters()
    })
    .unwrap();
    let config = config(Scheme::LawsonAdamsBashforth2, StepRule::Fixed { dt: 0.5 }, 9);
    let mut simulation = Simulation::new(quiet, &law(), &config).unwrap();
    let start = simulation.positions().to_vec();
    simulation.advance_to(1.5).unwrap();
    for (x, start) in simulation.positions().iter().zip(&start) {
        let exact = quiet.mean_at(1.5, start).unwrap();
        // Roundoff of three steps.
        assert!((x[0] - exact[0]).abs() + (x[1] - exact[1]).abs() < 1e-13, "{x:?} {exact:?}");
    }
}

#[test]
fn schemes_agree_on_the_damper_within_their_errors() {
    let second_moments = |scheme, n_steps: u32| {
        let dt = 4.0 / f64::from(n_steps);
        let simulation = run(&config(scheme, StepRule::Fixed { dt }, 21), 4.0);
        [simulation.raw_moment([2, 0]), simulation.raw_moment([0, 2])]
    };
    let fine = second_moments(Scheme::RungeKutta4, 640);
    for (scheme, n_steps, most) in
        [(Scheme::LawsonAdamsBashforth2, 100, 2e-3), (Scheme::LawsonAdamsBashforth2, 400, 2e-4)]
    {
        let found = second_moments(scheme, n_steps);
        let error = |k: usize| (found[k] / fine[k] - 1.0).abs();
        assert!(
            error(0).max(error(1)) < most,
            "{scheme:?}, {n_steps} steps: {:e} {:e}",
            error(0),
            error(1)
        );
    }
}

/// The flow-map fit with a limit of the step that is `factor` times as long.
#[derive(Debug)]
struct Bold {
    fit: FlowMapFit<2>,
    factor: f64,
}

impl ScoreEstimator<2> for Bold {
    fn support(&self) -> f64 {
        self.fit.support()
    }

    fn criterion(&self) -> Option<Criterion> {
        None
    }

    fn start(&mut self, lattice: &LatticePlaces<'_, 2>) -> Result<(), Error> {
        self.fit.start(lattice)
    }

    fn estimate(&self, cloud: &Cloud<'_, 2>, out: &mut Estimates<2>) -> Result<(), Error> {
        self.fit.estimate(cloud, out)
    }

    fn spread(&self, diffusion: &[[f64; 2]; 2], radius: f64, deformation: &[[f64; 2]; 2]) -> f64 {
        self.fit.spread(diffusion, radius, deformation) / self.factor
    }

    fn settle(&self, x: &mut [[f64; 2]], before: &mut [[f64; 2]], part: f64) {
        self.fit.settle(x, before, part);
    }

    fn local_maps(&self, cloud: &Cloud<'_, 2>) -> Option<Vec<LocalMap<2>>> {
        self.fit.local_maps(cloud)
    }
}

#[test]
fn the_limit_of_each_scheme_holds_and_is_not_far_from_where_it_fails() {
    let reference =
        run(&config(Scheme::RungeKutta4, StepRule::DiffusionLimited { longest: 0.01 }, 57), 4.0);
    let error = |factor: f64, longest: f64| {
        let step = StepRule::DiffusionLimited { longest };
        let fit = FlowMapFit::new(Degree::Cubic, 0.2);
        let config = config(Scheme::LawsonAdamsBashforth2, step, 57);
        let bold = Box::new(Bold { fit, factor });
        let mut simulation = Simulation::with_estimator(damper(), &law(), &config, bold).unwrap();
        simulation.advance_to(4.0).map(|()| {
            let moment = |powers| simulation.raw_moment(powers) / reference.raw_moment(powers);
            (moment([2, 0]) - 1.0_f64).abs().max((moment([0, 2]) - 1.0_f64).abs())
        })
    };
    let inside = error(1.0, 0.1).unwrap();
    assert!(inside < 0.01, "{inside}");
    // Four and ten times the limit.
    let outside = error(1000.0, 0.2);
    assert!(outside.as_ref().map_or(true, |error| *error > 0.05), "{outside:?}");
}

/// A building that yields, in a ball of 5 sigma with a spacing of 0.8.
fn hysteresis(scheme: Scheme, negligible: f64) -> Result<Simulation<BoucWen, 3, 1>, Error> {
    let system = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013)?;
    let law = GaussianMixture::independent([0.0; 3], [0.05; 3]).unwrap();
    let method = changed(|c| (c.scheme, c.negligible) = (scheme, negligible));
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 0.8 };
    let config = Config { method, ..fixtures::config(lattice, 2.0) };
    Simulation::new(system, &law, &config)
}

#[test]
fn thin_cells_of_negligible_weight_do_not_shorten_the_steps() {
    let run = |negligible| {
        let mut simulation = hysteresis(Scheme::LawsonAdamsBashforth2, negligible).unwrap();
        simulation.advance_to(3.0).unwrap();
        let moments = [[2, 0, 0], [0, 2, 0], [0, 0, 2]].map(|p| simulation.raw_moment(p));
        (moments, simulation.work().evaluations as f64)
    };
    let (exact, all) = run(0.0);
    // Evaluations over those with all cells stable, and change of the worst moment: 8.4e-3 seen with 1e-2, of E[z^2].
    for (negligible, fewer, within) in [(1e-4, 0.9, 5e-4), (1e-2, 0.5, 1e-2)] {
        let (found, evaluations) = run(negligible);
        let error = (0..3).map(|k| (found[k] / exact[k] - 1.0).abs()).fold(0.0, f64::max);
        assert!(evaluations < fewer * all, "{negligible}: {evaluations} of {all}");
        assert!(error < within, "{negligible}: {error:e}");
    }
}

#[test]
fn a_part_that_is_not_negligible_is_refused() {
    for negligible in [-1e-3, 2.0 * MOST_NEGLIGIBLE, f64::NAN] {
        let error = hysteresis(Scheme::LawsonAdamsBashforth2, negligible).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { .. } | Error::NotFinite { .. }), "{error}");
        assert!(error.to_string().contains("negligible"), "{error}");
    }
}

#[test]
fn a_fixed_step_beyond_the_limit_of_its_scheme_is_refused_with_that_limit() {
    let config = config(Scheme::LawsonAdamsBashforth2, StepRule::Fixed { dt: 0.1 }, 57);
    let mut simulation = Simulation::new(damper(), &law(), &config).unwrap();
    match simulation.advance_to(4.0) {
        Err(Error::StepExceedsDiffusionLimit { dt, limit, .. }) => assert!(limit < dt),
        other => unreachable!("{other:?}"),
    }
}

#[test]
fn the_same_bits_come_from_any_number_of_threads_and_after_a_restart() {
    for negligible in [0.0, 1e-2] {
        let method = changed(|c| {
            c.scheme = Scheme::LawsonAdamsBashforth2;
            c.step = StepRule::PeriodFraction { steps_per_period: 40.0 };
            c.negligible = negligible;
        });
        let config = Config { method, ..fixtures::config(InitialLattice::box_of(41), 2.0) };
        same_bits(|| Simulation::new(damper(), &law(), &config).unwrap(), [0.3, 0.75]);
    }
}

#[test]
fn one_evaluation_a_step_but_for_the_first_after_a_start_and_after_a_remeshing() {
    let step = StepRule::Fixed { dt: 0.05 };
    let config = config(Scheme::LawsonAdamsBashforth2, step, 25);
    let mut simulation = Simulation::new(damper(), &law(), &config).unwrap();
    assert_eq!([(); 3].map(|()| evaluations(&mut simulation)), [2, 1, 1]);
    let _report = simulation.remap(&Remapping::MEASURED).unwrap();
    assert_eq!([(); 2].map(|()| evaluations(&mut simulation)), [2, 1]);
}

#[test]
fn a_step_much_longer_than_the_one_before_it_does_not_extrapolate() {
    let step = StepRule::Fixed { dt: 0.05 };
    let config = config(Scheme::LawsonAdamsBashforth2, step, 25);
    let mut simulation = Simulation::new(damper(), &law(), &config).unwrap();
    // Ends at 0.01: a fifth of the step after it.
    simulation.advance_to(0.5).unwrap();
    simulation.advance_to(0.51).unwrap();
    assert_eq!([(); 2].map(|()| evaluations(&mut simulation)), [2, 1]);
}

#[test]
fn a_snapshot_of_another_scheme_starts_the_memory_anew() {
    let step = StepRule::Fixed { dt: 0.05 };
    let new = |scheme| Simulation::new(damper(), &law(), &config(scheme, step, 15)).unwrap();
    let mut single = new(Scheme::RungeKutta4);
    single.advance_to(0.2).unwrap();
    let mut bytes = Vec::new();
    single.snapshot(&mut bytes).unwrap();
    let mut multiple = new(Scheme::LawsonAdamsBashforth2);
    multiple.advance_to(0.1).unwrap();
    multiple.restore(&bytes[..]).unwrap();
    assert_eq!(evaluations(&mut multiple), 2);
}

/// A system that declares no linear part, or one that is not finite.
#[derive(Debug, Clone, Copy)]
struct Pendulum(Option<f64>);

impl Sde<2, 1> for Pendulum {
    type Noise = Additive;

    fn drift(&self, _: f64, &[angle, rate]: &[f64; 2]) -> [f64; 2] {
        [rate, -angle.sin() - 0.5 * rate]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [0.3]]
    }

    fn linear_part(&self) -> Option<[[f64; 2]; 2]> {
        self.0.map(|stiffness| [[0.0, 1.0], [-stiffness, -0.5]])
    }
}

#[test]
fn a_system_without_a_linear_part_is_refused_where_the_scheme_needs_one() {
    let step = StepRule::Fixed { dt: 0.05 };
    let new = |system, scheme| Simulation::new(system, &law(), &config(scheme, step, 15));
    let scheme = Scheme::LawsonAdamsBashforth2;
    let error = new(Pendulum(None), scheme).unwrap_err();
    assert!(matches!(error, Error::NoLinearPart { scheme: found } if found == scheme));
    assert!(error.to_string().contains(&format!("{scheme:?}")), "{error}");
    let error = new(Pendulum(Some(f64::NAN)), scheme).unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
    let moment = |part, scheme| {
        let mut simulation = new(Pendulum(part), scheme).unwrap();
        simulation.advance_to(2.0).unwrap();
        simulation.raw_moment([0, 2])
    };
    let reference = moment(None, Scheme::RungeKutta4);
    for (part, scheme) in [
        (Some(1.0), Scheme::LawsonAdamsBashforth2),
        // Whatever the matrix, the equation is the same.
        (Some(0.5), Scheme::LawsonAdamsBashforth2),
    ] {
        let found = moment(part, scheme);
        // Order 2, for a noise that doubles the variance of the start within two steps; 1.3e-3 seen.
        assert!((found / reference - 1.0).abs() < 3e-3, "{scheme:?} {found} {reference}");
    }
}

/// What remains of the drift without its declared linear part.
fn rest<S: Sde<D, M>, const D: usize, const M: usize>(system: &S, x: &[f64; D]) -> [f64; D] {
    let (drift, part) = (system.drift(1.0, x), system.linear_part().unwrap());
    std::array::from_fn(|k| drift[k] - (0..D).map(|l| part[k][l] * x[l]).sum::<f64>())
}

#[test]
fn the_declared_linear_parts_leave_what_is_not_linear() {
    let is_zero = |rest: &[f64]| rest.iter().all(|value| value.abs() < 1e-13);
    assert!(is_zero(&rest(&process(), &[0.3, -0.7])));
    let [still, force] = rest(&damper(), &[0.3, -0.7]);
    assert!(is_zero(&[still, force - 0.25 * 0.7_f64.powf(0.35)]), "{still} {force}");
    let frame = TwoStorey::new(TwoStoreyParameters {
        mass: [1.0, 0.5],
        stiffness: [10.0, 7.0],
        damping: [0.3, 0.2],
        damper_coefficient: [0.0; 2],
        damper_exponent: 1.0,
        noise_intensity: 0.2,
        window: Window::Stationary,
    })
    .unwrap();
    assert!(is_zero(&rest(&frame, &[0.3, -0.7, 0.2, 0.5])));
    let hysteresis = BoucWen::new(BoucWenParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.05,
        hardening: 0.5,
        initial_slope: 1.0,
        beta: 0.6,
        gamma: 0.3,
        exponent: 1.0,
        noise_intensity: 1.0,
        window: Window::Stationary,
    })
    .unwrap();
    // z' = v (1 - 0.9 |z|) where v z > 0.
    let [q, v, z] = rest(&hysteresis, &[0.3, 0.7, 0.2]);
    assert!(is_zero(&[q, v, z + 0.7 * 0.9 * 0.2]), "{q} {v} {z}");
}
