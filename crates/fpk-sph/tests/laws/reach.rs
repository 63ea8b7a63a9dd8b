//! How far a lattice goes, and what is known of a probability that it does not hold.

use fpk_sph::observables::{FirstPassage, Probability};
use fpk_sph::{Error, InitialLattice, MOST_OUTSIDE, Simulation};
use sde_integrators::GaussianMixture;
use vibrating_systems::LinearOscillator;

use crate::fixtures::{config, oscillator};

const DEVIATIONS: [f64; 2] = [0.05, 0.3];

fn simulation(lattice: InitialLattice<2>) -> Simulation<LinearOscillator, 2, 1> {
    let law = GaussianMixture::independent([0.0; 2], DEVIATIONS).unwrap();
    let system = oscillator(std::f64::consts::TAU, 0.05, 1.0);
    Simulation::new(system, &law, &config(lattice, 1.0)).unwrap()
}

#[test]
fn a_lattice_for_a_probability_leaves_at_most_a_tenth_of_it_outside() {
    for smallest in [1e-3, 1e-6, 1e-9] {
        let lattices = [
            InitialLattice::box_down_to(smallest, [61; 2]).unwrap(),
            InitialLattice::ball_down_to(smallest, 0.2).unwrap(),
        ];
        for lattice in lattices {
            let outside = simulation(lattice).mass_outside();
            // Cells at the rim of a box reach half a spacing beyond it; the rim of a ball is ragged.
            let most = MOST_OUTSIDE * smallest;
            assert!((0.2 * most..1.3 * most).contains(&outside), "{lattice:?}: {outside:e}");
        }
    }
    for smallest in [0.0, 2.0, f64::NAN] {
        let error = InitialLattice::<2>::ball_down_to(smallest, 0.2).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { name: "smallest probability", .. }), "{error}");
    }
}

#[test]
fn a_probability_that_no_particle_carries_is_a_bound() {
    let mut simulation = simulation(InitialLattice::Ball { reach: 4.0, spacing: 0.25 });
    let outside = simulation.mass_outside();
    assert!((1e-5..4e-4).contains(&outside), "{outside:e}");
    let mut passage = FirstPassage::new(&simulation, |x| x[0].abs(), &[0.1, 0.24, 9.0]).unwrap();
    let of = |passage: &FirstPassage<_, 2>, k| passage.probability(k);
    let nothing = Probability::Below { estimate: 0.0, bound: outside };
    assert_eq!(of(&passage, 0), Some(Probability::Resolved(passage.probabilities()[0])));
    assert_eq!(of(&passage, 2), Some(nothing));
    assert_eq!(of(&passage, 3), None);
    passage.advance_to(&mut simulation, 0.5).unwrap();
    assert_eq!(of(&passage, 2), Some(nothing));

    let cells = simulation.cell_integral().unwrap();
    let far = cells.exceedance(|x| x[0].abs(), 9.0).unwrap();
    assert_eq!((far.probability(), far.outside()), (nothing, outside));
    assert_eq!(far.probability().to_string(), format!("< {outside:.1e}"));
    let near = cells.exceedance(|x| x[0].abs(), 0.2).unwrap();
    assert!(near.probability().resolved().is_some_and(|p| p > 100.0 * outside), "{near:?}");
    assert!(near.probability().basis().contains("particles"));
}

#[test]
fn a_tail_beyond_the_outermost_particles_says_so() {
    let simulation = simulation(InitialLattice::Ball { reach: 3.0, spacing: 0.25 });
    let cells = simulation.cell_integral().unwrap();
    let probabilities: Vec<Probability> = [1.0, 2.0, 2.7, 3.2]
        .into_iter()
        .map(|deviations| {
            let threshold = deviations * DEVIATIONS[0];
            cells.exceedance(|x| x[0].abs(), threshold).unwrap().probability()
        })
        .collect();
    // 1.1 % lie outside: of P = 0.32 next to nothing, of 0.046 a sixth, of 0.0069 all.
    assert!(probabilities[0].resolved().is_some(), "{}", probabilities[0]);
    let (Probability::Extrapolated { share, .. } | Probability::Truncated { share, .. }) =
        probabilities[1]
    else {
        panic!("{}", probabilities[1]);
    };
    assert!((0.1..0.3).contains(&share), "{share}");
    for probability in &probabilities[2..] {
        let is_bound = matches!(probability, Probability::Below { bound, .. } if *bound > 0.009);
        assert!(is_bound, "{probability}");
    }
}
