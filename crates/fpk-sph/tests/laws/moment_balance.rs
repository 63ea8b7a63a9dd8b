//! Errors by the moment equations.

use fpk_sph::{Error, InitialLattice, MeanAndCovariance, Simulation};
use particle_store::{Attribute, ParticleStore};
use sde_integrators::GaussianMixture;
use vibrating_systems::{Bistable, BistableParameters};

use crate::fixtures::{config, exact_moments, oscillator};

/// A lattice that ends within the distribution leaves out a part of the second moments, which coarser lattices leave out too.
#[test]
fn what_lies_beyond_the_reach_is_found_in_a_linear_system() {
    let (system, law) =
        (oscillator(2.0, 0.1, 0.3), GaussianMixture::independent([0.2, 0.0], [0.2, 0.3]));
    let law = law.unwrap();
    for reach in [2.0, 3.0] {
        let lattice = InitialLattice::Ball { reach, spacing: 0.2 };
        let mut simulation =
            Simulation::new(system.clone(), &law, &config(lattice, system.period())).unwrap();
        simulation.advance_to(3.0).unwrap();
        let exact = exact_moments(&system, &law, 3.0);
        let corrected = simulation.moment_correction().unwrap();
        for (k, powers) in [[2, 0], [0, 2]].into_iter().enumerate() {
            let found = simulation.raw_moment(powers);
            let off = found - exact[k][k];
            let stated = found - simulation.expectation(|x| corrected.of(x)[k].powi(2));
            // The correction is of first order in an error of up to a half.
            assert!((stated / off - 1.0).abs() < 0.5, "{reach}, {powers:?}: {stated} for {off}");
            assert!(off.abs() > 0.02 * found, "the case is too easy: {off}");
        }
    }
}

/// Two wells that the flow map of one lattice does not resolve: coarser lattices agree on a moment that is a quarter low.
#[test]
fn a_density_that_one_lattice_does_not_resolve_is_seen() {
    let parameters = BistableParameters { growth: 1.0, cubic: 1.0, diffusion: 0.15 };
    let system = Bistable::new(parameters).unwrap();
    let law = GaussianMixture::independent([0.0], [0.3]).unwrap();
    let period = std::f64::consts::TAU * system.relaxation_time();
    let relative = |reach: f64, count: usize, t: f64| {
        let lattice = InitialLattice::Box { reach, count: [count] };
        let mut simulation = Simulation::new(system, &law, &config(lattice, period)).unwrap();
        simulation.advance_to(t).unwrap();
        simulation.moment_correction().unwrap().relative_change()
    };
    assert!(relative(6.0, 41, 0.1) < 1e-3, "{}", relative(6.0, 41, 0.1));
    assert!(relative(6.0, 41, 3.0) > 0.1, "{}", relative(6.0, 41, 3.0));
}

#[test]
fn a_snapshot_keeps_the_errors() {
    let (system, law) =
        (oscillator(2.0, 0.1, 0.3), GaussianMixture::independent([0.2, 0.0], [0.2, 0.3]));
    let law = law.unwrap();
    let config = config(InitialLattice::Ball { reach: 3.0, spacing: 0.4 }, 3.0);
    let start = || Simulation::new(system.clone(), &law, &config).unwrap();
    let (mut whole, mut second) = (start(), start());
    whole.advance_to(0.5).unwrap();
    let mut bytes = Vec::new();
    whole.snapshot(&mut bytes).unwrap();
    second.restore(&bytes[..]).unwrap();
    for simulation in [&mut whole, &mut second] {
        simulation.advance_to(1.0).unwrap();
    }
    let bits = |errors: MeanAndCovariance<2>| {
        let all = errors.mean.iter().chain(errors.covariance.as_flattened());
        all.map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(whole.moment_errors()), bits(second.moment_errors()));
    assert!(whole.moment_errors().covariance[0][0] < 0.0);
    // Errors that are not there are not zero.
    let mut store = ParticleStore::<2>::restore(&bytes[..]).unwrap();
    store.set_attribute("moment_error_3", Attribute::Real(f64::NAN));
    let mut other = Vec::new();
    store.snapshot(&mut other).unwrap();
    let error = second.restore(&other[..]).unwrap_err();
    assert!(matches!(error, Error::SnapshotNumber { must: "finite", .. }), "{error}");
}
