//! A system of one's own behind a soil: the second moment of its displacement and a probability, each with its error.

// docs: own-system
use fpk_sph::observables::Probability;
use fpk_sph::{
    Additive, ConditionedSimulation, Config, DEFAULT_MOST_STEPS, Error, InitialLattice, Method, Sde,
};
use vibrating_systems::{Filter, Filtered, KanaiTajimiParameters, Window};

/// A frame whose stiffness falls off as it yields: `q'' + 2 xi w q' + w^2 q_y tanh(q / q_y) = sqrt(2 S_0) u`.
#[derive(Debug, Clone, Copy)]
struct SofteningFrame {
    natural_frequency: f64,
    damping_ratio: f64,
    yield_displacement: f64,
    noise_intensity: f64,
}

impl Sde<2, 1> for SofteningFrame {
    type Noise = Additive;

    fn drift(&self, _: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
        let w = self.natural_frequency;
        let force = w * w * self.yield_displacement * (q / self.yield_displacement).tanh();
        [v, -2.0 * self.damping_ratio * w * v - force]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [(2.0 * self.noise_intensity).sqrt()]]
    }
}

/// `E[q^2]` and `P(|q| > 0.3)` after three seconds, on a lattice of this spacing.
fn solve(spacing: f64) -> Result<(f64, Probability), Error> {
    let frame = SofteningFrame {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.05,
        yield_displacement: 0.4,
        noise_intensity: 0.02,
    };
    let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
    let shaken = Filtered::new(frame, Filter::kanai_tajimi(soil)?, Window::Stationary)?;
    let at_rest = shaken.initial_distribution::<4>(&[0.0, 0.0], &[0.02, 0.06])?;
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::Ball { reach: 5.5, spacing },
        reference_period: 2.0,
        most_steps: DEFAULT_MOST_STEPS,
    };
    // The soil's two states are conditioned out: the lattice has those of the frame.
    let mut simulation = ConditionedSimulation::new(&shaken, &at_rest, &config)?;
    simulation.advance_to(3.0)?;
    let density = simulation.structure();
    let tail = density.cell_integral()?.exceedance(|x| x[0].abs(), 0.3)?;
    Ok((density.raw_moment([2, 0]), tail.probability()))
}

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Error> {
    // Two lattices: their difference is the error of the spacing.
    let ((moment, tail), (rough_moment, rough_tail)) = (solve(0.4)?, solve(0.55)?);
    println!("E[q^2] = {moment:.4e} +- {:.0e}", (moment - rough_moment).abs());
    match (tail, rough_tail) {
        (Probability::Resolved(fine), Probability::Resolved(rough)) => {
            println!("P(|q| > 0.3) = {fine:.4e} +- {:.0e}", (fine - rough).abs());
        }
        // Not enough particles carry it: a bound, or the number with what it rests on.
        _ => println!("P(|q| > 0.3): {tail}"),
    }
    Ok(())
}
// docs: end

#[test]
fn the_example_runs() {
    main().unwrap();
    let ((moment, tail), (rough_moment, rough_tail)) = (solve(0.4).unwrap(), solve(0.55).unwrap());
    // Differences of 0.02 and 0.25 % seen.
    assert!((moment / rough_moment - 1.0).abs() < 2e-3, "{moment} {rough_moment}");
    let (tail, rough_tail) = (tail.resolved().unwrap(), rough_tail.resolved().unwrap());
    assert!((tail / rough_tail - 1.0).abs() < 0.025, "{tail} {rough_tail}");
}
