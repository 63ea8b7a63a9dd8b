//! Remeshing: keeps mass and moments, continues where the flow folds, and is saved with the state.

use fpk_sph::{Combination, Config, Error, InitialLattice, Method, Remapping, Simulation};
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::{Duffing, DuffingParameters, LinearOscillator};

use crate::fixtures::{self, bits, oscillator};

fn linear() -> LinearOscillator {
    oscillator(1.0, 0.05, 0.1)
}

fn duffing() -> Duffing {
    let structure = linear().parameters().clone();
    Duffing::new(DuffingParameters { structure, cubic_stiffness: 0.5 }).unwrap()
}

fn config(method: Method, remapping: Option<Remapping>) -> Config<2> {
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 0.5 };
    let method = Method::Custom(Combination { remapping, ..method.combination() });
    Config { method, ..fixtures::config(lattice, std::f64::consts::TAU) }
}

fn start<S: Sde<2, 1>>(system: S, config: &Config<2>) -> Simulation<S, 2, 1> {
    let law = GaussianMixture::independent([0.1, 0.0], [0.7, 0.9]).unwrap();
    Simulation::new(system, &law, config).unwrap()
}

/// Mass, mean and second moments.
fn moments<S: Sde<2, 1>>(simulation: &Simulation<S, 2, 1>) -> [f64; 6] {
    [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].map(|powers| simulation.raw_moment(powers))
}

#[test]
fn a_gaussian_is_kept_by_either_fit_and_reaches_as_far_as_asked() {
    let method = Method::FlowMapFit;
    let lattice = InitialLattice::Ball { reach: 7.0, spacing: 0.5 };
    let mut simulation = start(linear(), &Config { lattice, ..config(method, None) });
    simulation.advance_to(1.0).unwrap();
    let before = moments(&simulation);
    let report = simulation.remap(&Remapping::MEASURED).unwrap();
    assert_eq!(report.particles_after, simulation.n_particles());
    // The lattice ends near 6 standard deviations, beyond which 1.5e-8 lie; they weigh 6^2 times that in the covariance.
    assert!(report.outermost_mass < 1e-8 && report.mass_change.abs() < 2e-8, "{report:?}");
    assert!(report.mean_change < 1e-7 && report.covariance_change < 6e-7, "{report:?}");
    let [mass, m_q, m_v, qq, qv, vv] = moments(&simulation);
    for (after, before) in [mass, m_q, m_v, qq, qv, vv].into_iter().zip(before) {
        assert!((after - before).abs() < 1e-13, "roundoff of sums: {after} against {before}");
    }
    // The density of the cloud's Gaussian, with the cell at the mean for its constant.
    let (mean_q, mean_v) = (m_q / mass, m_v / mass);
    let (a, b, c) =
        (qq / mass - mean_q.powi(2), qv / mass - mean_q * mean_v, vv / mass - mean_v.powi(2));
    let determinant = a * c - b * b;
    let exponent = |&[q, v]: &[f64; 2]| {
        let (q, v) = (q - mean_q, v - mean_v);
        -0.5 * (c * q * q - 2.0 * b * q * v + a * v * v) / determinant
    };
    let constants: Vec<f64> = simulation
        .positions()
        .iter()
        .zip(simulation.masses())
        .map(|(x, mass)| mass.ln() - exponent(x))
        .collect();
    let (low, high) = constants
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &c| (c.min(l), c.max(h)));
    // That error of the covariance, which is restored, times 6^2/2.
    assert!(high - low < 1e-5, "{method:?}: {}", high - low);
}

#[test]
fn mass_mean_and_covariance_are_kept_where_the_density_is_no_gaussian() {
    let mut simulation = start(duffing(), &config(Method::FlowMapFit, None));
    simulation.advance_to(2.0).unwrap();
    let before = moments(&simulation);
    let report = simulation.remap(&Remapping::MEASURED).unwrap();
    // Truncation at half a standard deviation, far above what is left of it below.
    assert!(report.mass_change.abs() < 5e-3 && report.mass_change.abs() > 1e-10, "{report:?}");
    for (after, before) in moments(&simulation).into_iter().zip(before) {
        assert!((after - before).abs() < 1e-13, "{after} against {before}");
    }
    assert_eq!(simulation.n_remaps(), 1);
}

#[test]
fn a_linear_flow_asks_for_no_fresh_lattice_and_a_folding_one_goes_on_with_it() {
    let remapping = Remapping { most_uneven: 0.5, ..Remapping::MEASURED };
    let mut affine = start(linear(), &config(Method::FlowMapFit, Some(remapping)));
    affine.advance_to(10.0).unwrap();
    assert_eq!(affine.n_remaps(), 0);
    let without = config(Method::FlowMapFit, None);
    let ended = start(duffing(), &without).advance_to(20.0);
    assert!(matches!(ended, Err(Error::TooMuchUnresolved { .. })), "{ended:?}");
    let with = config(Method::FlowMapFit, Some(Remapping::MEASURED));
    let mut folding = start(duffing(), &with);
    folding.advance_to(20.0).unwrap();
    assert!(folding.n_remaps() > 5, "{}", folding.n_remaps());
}

#[test]
fn a_snapshot_holds_the_lattice() {
    let config = config(Method::FlowMapFit, Some(Remapping::MEASURED));
    let mut whole = start(duffing(), &config);
    let (mut early, mut late) = (Vec::new(), Vec::new());
    whole.advance_to(0.5).unwrap();
    whole.snapshot(&mut early).unwrap();
    whole.advance_to(6.0).unwrap();
    whole.snapshot(&mut late).unwrap();
    assert!(whole.n_remaps() > 0);
    whole.advance_to(9.0).unwrap();
    // From the start, and from a lattice that is another one: both ways.
    let mut resumed = start(duffing(), &config);
    resumed.restore(late.as_slice()).unwrap();
    resumed.advance_to(9.0).unwrap();
    assert_eq!(bits(&resumed), bits(&whole));
    resumed.restore(early.as_slice()).unwrap();
    resumed.advance_to(6.0).unwrap();
    resumed.advance_to(9.0).unwrap();
    assert_eq!(bits(&resumed), bits(&whole));
    let finer = Config { lattice: InitialLattice::Ball { reach: 5.0, spacing: 0.4 }, ..config };
    let mut foreign = start(duffing(), &finer);
    assert!(matches!(foreign.restore(late.as_slice()), Err(Error::ForeignSnapshot { .. })));
}

#[test]
fn a_fresh_lattice_that_cannot_be_laid_leaves_all_as_it_was() {
    let mut tried = start(duffing(), &config(Method::FlowMapFit, None));
    let mut spared = start(duffing(), &config(Method::FlowMapFit, None));
    tried.advance_to(2.0).unwrap();
    spared.advance_to(2.0).unwrap();
    let refused = |tried: &mut Simulation<Duffing, 2, 1>, remapping: Remapping| {
        tried.remap(&remapping).unwrap_err().to_string()
    };
    let few = refused(&mut tried, Remapping { most_particles: 20, ..Remapping::MEASURED });
    assert!(
        few.starts_with("t = 2: remeshing needs ") && few.ends_with("; 20 are allowed"),
        "{few}"
    );
    let strict = refused(&mut tried, Remapping { most_change: 1e-12, ..Remapping::MEASURED });
    assert!(strict.starts_with("t = 2: remeshing changes the mass by "), "{strict}");
    let nothing = refused(&mut tried, Remapping { outermost_mass: 0.0, ..Remapping::MEASURED });
    assert_eq!(nothing, "outermost_mass is 0; it must be greater than 0");
    tried.advance_to(3.0).unwrap();
    spared.advance_to(3.0).unwrap();
    assert_eq!(bits(&tried), bits(&spared));
}

#[test]
fn the_papers_coordinates_are_refused() {
    let law = GaussianMixture::independent([0.0, 0.0], [0.7, 0.9]).unwrap();
    let config = config(Method::CanorDenoel2013, Some(Remapping::MEASURED));
    assert!(matches!(Simulation::new(duffing(), &law, &config), Err(Error::NotWhitened)));
}

#[test]
fn a_step_reports_the_lattice_laid_before_it_and_goes_forward_only() {
    let config = config(Method::FlowMapFit, Some(Remapping::MEASURED));
    let mut simulation = start(duffing(), &config);
    let mut reported = 0;
    while simulation.time() < 6.0 {
        let report = simulation.step_towards(6.0).unwrap();
        reported += u64::from(report.remapped.is_some());
    }
    assert!(reported > 0 && reported == simulation.n_remaps());
    for end in [5.0, 6.0, f64::NAN] {
        assert!(matches!(simulation.step_towards(end), Err(Error::TimeInThePast { .. })));
    }
}
