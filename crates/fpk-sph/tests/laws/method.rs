//! Laws of the method: exactness, limits, invariance, and what is refused.

use fpk_sph::score::{Estimates, Fits, SummationDensity};
use fpk_sph::{
    Cloud, Combination, Config, Error, InitialLattice, Method, ScoreEstimator, Simulation, StepRule,
};
use neighbour_search::{BruteForce, NeighbourList, NeighbourSearch, Radii};
use sde_integrators::GaussianMixture;
use smoothing_kernels::{Kernel, Lucy};
use vibrating_systems::{LinearOscillator, LinearOscillatorParameters, Window};

use crate::fixtures::{self, BUILDING, changed, damper, law, same_bits};

fn config(method: Method, lattice: InitialLattice<2>) -> Config<2> {
    Config { method, ..fixtures::config(lattice, 2.0) }
}

/// Score, density and volume of points by the paper's estimator.
fn estimate(
    positions: &[[f64; 2]],
    masses: &[f64],
    smoothing_lengths: &[f64],
) -> (Vec<[f64; 2]>, Vec<f64>, Vec<f64>) {
    let estimator = SummationDensity::<Lucy>::default();
    let support = ScoreEstimator::<2>::support(&estimator);
    let radii: Vec<f64> = smoothing_lengths.iter().map(|h| h * support).collect();
    let mut neighbours = NeighbourList::new();
    let criterion = ScoreEstimator::<2>::criterion(&estimator).unwrap();
    let radii = Radii::PerPoint { radii: &radii, criterion };
    BruteForce::new().full_list(positions, radii, &mut neighbours).unwrap();
    let cloud = Cloud {
        positions,
        masses,
        smoothing_lengths,
        neighbours: &neighbours,
        lattice: &[],
        whitened: false,
        step: 0,
        time: 0.0,
    };
    let mut out = Estimates::new(positions.len());
    estimator.estimate(&cloud, &mut out).unwrap();
    (out.score, out.density, out.volume)
}

#[test]
fn an_isolated_particle_sees_its_own_kernel_and_no_gradient() {
    let (mu, h) = (0.3, 0.5);
    let (score, density, volume) = estimate(&[[1.0, 2.0]], &[mu], &[h]);
    // Lucy in 2-D: W(0, h) = 5 / (pi h^2).
    let own = mu * 5.0 / (std::f64::consts::PI * h * h);
    assert!((density[0] - own).abs() < 1e-14 * own && (volume[0] - mu / own).abs() < 1e-14);
    assert!(score[0].iter().all(|s| s.abs() < f64::MIN_POSITIVE));
}

#[test]
fn the_report_of_a_step_counts_fits_of_a_lower_degree() {
    let lattice = InitialLattice::box_of(21);
    let fits = |method: Method| {
        let mut simulation = Simulation::new(damper(), &law(), &config(method, lattice)).unwrap();
        simulation.step().unwrap().fits
    };
    assert_eq!(fits(Method::CanorDenoel2013), Fits::default(), "no fit");
    // A cubic in two variables has ten unknowns and takes 15 points; counted within 2.8 spacings.
    let place = |i: i32| [i % 21, i / 21];
    let members = |i: i32| {
        let near = |j: &i32| {
            let ([a, b], [c, d]) = (place(i), place(*j));
            f64::from((a - c).pow(2) + (b - d).pow(2)) <= 2.8_f64.powi(2)
        };
        (0..441).filter(near).count()
    };
    let few = (0..441).filter(|&i| members(i) < 15).count();
    let Fits { lowered, smallest_pivot, .. } = fits(Method::FlowMapFit);
    // The outermost layer: 21 x 21 less 19 x 19.
    assert!(few == 80 && lowered == few, "{lowered} against {few}");
    assert!((1e-6..1.0).contains(&smallest_pivot), "{smallest_pivot}");
}

#[test]
fn the_gradient_of_the_summation_density_is_that_of_its_averaged_kernels() {
    let positions = [[0.0, 0.0], [0.3, 0.1], [-0.2, 0.25]];
    let (masses, h) = ([0.2, 0.5, 0.3], [0.6, 0.45, 0.8]);
    let (score, density, _) = estimate(&positions, &masses, &h);
    // Eq 15 with eq 23, as a function of the position of the first particle.
    let sum = |x: [f64; 2]| -> f64 {
        let averaged = |j: usize| {
            let r = (x[0] - positions[j][0]).hypot(x[1] - positions[j][1]);
            0.5 * (Kernel::<2>::value(&Lucy, r, h[0]) + Kernel::<2>::value(&Lucy, r, h[j]))
        };
        masses[0] * Kernel::<2>::value(&Lucy, 0.0, h[0])
            + masses[1] * averaged(1)
            + masses[2] * averaged(2)
    };
    let eps = 1e-6;
    let slope = (sum([eps, 0.0]) - sum([-eps, 0.0])) / (2.0 * eps);
    assert!((density[0] - sum([0.0, 0.0])).abs() < 1e-13);
    // Central difference: error eps^2 times a third derivative of order 100.
    assert!((score[0][0] * density[0] - slope).abs() < 1e-8);
}

#[test]
fn the_lattice_of_the_paper_misses_the_mass_beyond_its_outer_cells() {
    let lattice = InitialLattice::CANOR_DENOEL_2013;
    let simulation =
        Simulation::new(damper(), &law(), &config(Method::CanorDenoel2013, lattice)).unwrap();
    // The trapezoidal sum over the cells, each half a spacing beyond the edge: erfc(4.082/sqrt 2) + erfc(4.125/sqrt 2).
    let missing = 1.0 - simulation.total_mass();
    assert_eq!(simulation.n_particles(), 1650);
    assert!((missing / 7.92e-5 - 1.0).abs() < 0.01, "{missing:e}");
}

#[test]
fn without_noise_particles_follow_the_equation_of_motion() {
    let free = LinearOscillatorParameters {
        noise_intensity: 0.0,
        damping_ratio: 0.0,
        window: Window::Stationary,
        ..BUILDING
    };
    let mut simulation = Simulation::new(
        LinearOscillator::new(free).unwrap(),
        &law(),
        &config(Method::FlowMapFit, InitialLattice::box_of(11)),
    )
    .unwrap();
    let start = simulation.positions().to_vec();
    simulation.advance_to(2.0).unwrap();
    for (x_0, x) in start.iter().zip(simulation.positions()) {
        // One period: back at the start. Runge-Kutta 4 in 40 steps: phase error (w dt)^5 / 120 a step, 3.2e-5 in all,
        // times a velocity of up to w q_max = 2.8.
        assert!((x[0] - x_0[0]).abs() < 1e-4 && (x[1] - x_0[1]).abs() < 3.2e-4, "{x_0:?} {x:?}");
    }
}

#[test]
fn the_same_bits_come_from_any_number_of_threads_and_after_a_restart() {
    // More particles than one thread keeps to itself.
    let (fit, square) = (Method::FlowMapFit, InitialLattice::box_of(41));
    let rectangle = InitialLattice::Rectangle { half_width: [0.6, 0.4], count: [25, 17] };
    for (method, lattice) in [(fit, square), (Method::CanorDenoel2013, rectangle)] {
        same_bits(
            || Simulation::new(damper(), &law(), &config(method, lattice)).unwrap(),
            [0.5, 1.0],
        );
    }
}

#[test]
fn a_snapshot_of_another_simulation_is_refused_and_changes_nothing() {
    let lattice = |n| config(Method::FlowMapFit, InitialLattice::box_of(n));
    let other = Simulation::new(damper(), &law(), &lattice(13)).unwrap();
    let mut bytes = Vec::new();
    other.snapshot(&mut bytes).unwrap();
    let mut simulation = Simulation::new(damper(), &law(), &lattice(11)).unwrap();
    let before = simulation.positions().to_vec();
    let error = simulation.restore(bytes.as_slice()).unwrap_err();
    assert!(matches!(error, Error::ForeignSnapshot { found: 169, expected: 121 }), "{error}");
    assert_eq!(before, simulation.positions());
}

#[test]
fn the_papers_method_with_a_small_support_ends_in_a_collapsed_step() {
    let method = Method::Custom(Combination {
        support_over_spacing: 1.5,
        ..Method::CanorDenoel2013.combination()
    });
    let lattice = InitialLattice::CANOR_DENOEL_2013;
    let mut simulation = Simulation::new(damper(), &law(), &config(method, lattice)).unwrap();
    let error = simulation.advance_to(10.0).unwrap_err();
    let Error::StepCollapsed { dt, limit, time, .. } = error else { unreachable!("{error}") };
    assert!(dt < limit && time < 10.0);
}

#[test]
fn what_cannot_work_is_refused_before_the_first_step() {
    let new =
        |method, lattice| Simulation::new(damper(), &law(), &config(method, lattice)).unwrap_err();
    let fit = Method::FlowMapFit;
    let none = InitialLattice::Box { reach: 6.0, count: [0, 0] };
    assert!(matches!(new(fit, none), Error::Store(_)));
    let few = new(fit, InitialLattice::box_of(2)).to_string();
    assert_eq!(few, "the lattice holds 4 particles; at least 9 are needed in 2-D");
    let reach = InitialLattice::Box { reach: -6.0, count: [41, 41] };
    assert_eq!(new(fit, reach).to_string(), "reach is -6; it must be greater than 0");
    let narrow = changed(|c| c.support_over_spacing = 2.0);
    let refused = new(narrow, InitialLattice::box_of(41)).to_string();
    let expected = "support_radius/spacing is 2: a support holds 13 neighbours of the undisturbed lattice; \
                    the fit needs 15 in 2-D";
    assert_eq!(refused, expected);
    let step = changed(|c| c.step = StepRule::Fixed { dt: f64::NAN });
    assert!(matches!(new(step, InitialLattice::box_of(41)), Error::NotFinite { name: "dt", .. }));
    let negative = LinearOscillatorParameters { noise_intensity: -0.2, ..BUILDING };
    let error = LinearOscillator::new(negative).unwrap_err();
    assert_eq!(error.to_string(), "noise_intensity is -0.2; it must be 0 or greater");
    assert!(GaussianMixture::independent([f64::NAN, 0.0], [0.15, 0.1]).is_err());
}

#[test]
fn a_run_that_cannot_go_on_says_why() {
    let lattice = InitialLattice::box_of(41);
    let fixed = changed(|c| c.step = StepRule::Fixed { dt: 0.5 });
    let mut simulation = Simulation::new(damper(), &law(), &config(fixed, lattice)).unwrap();
    assert!(matches!(
        simulation.advance_to(2.0),
        Err(Error::StepExceedsDiffusionLimit { dt: 0.5, .. })
    ));

    let mut simulation = Simulation::new(
        damper(),
        &law(),
        &Config { most_steps: 3, ..config(Method::FlowMapFit, InitialLattice::box_of(11)) },
    )
    .unwrap();
    let stopped = simulation.advance_to(1.0).unwrap_err();
    let Error::WorkLimit { time, target, limit: 3 } = stopped else { unreachable!("{stopped}") };
    assert!(time < target && simulation.work().steps == 3);
    assert!(matches!(simulation.advance_to(0.01), Err(Error::TimeInThePast { .. })));
    assert!(matches!(simulation.advance_to(f64::NAN), Err(Error::TimeInThePast { .. })));
}
