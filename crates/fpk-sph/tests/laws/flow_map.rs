//! The flow-map fit: exact for what is Gaussian, bounded where the flow collapses, refused where it cannot work.

use fpk_sph::observables::{Exceedance, Probability};
use fpk_sph::score::{Degree, Estimates, FlowMapFit, LatticePlaces, Unresolved};
use fpk_sph::{
    Cloud, Combination, Config, Error, Estimator, InitialLattice, MOST_UNRESOLVED, Method, Scheme,
    ScoreEstimator, Settling, Simulation, StepRule,
};
use neighbour_search::{CellGrid, Criterion, NeighbourList, NeighbourSearch, Radii};
use sde_integrators::{Additive, GaussianMixture, Sde};
use vibrating_systems::{
    BoucWen, BoucWenParameters, LinearOscillator, OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters,
};

use crate::fixtures::{self, changed, oscillator, same_bits, two_gaussians};

fn system() -> LinearOscillator {
    oscillator(2.0, 0.1, 0.3)
}

fn config(method: Method) -> Config<2> {
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 0.7 };
    Config { method, ..fixtures::config(lattice, std::f64::consts::PI) }
}

/// In whitened coordinates the score of a Gaussian is `-y`, whatever the particles.
#[derive(Debug)]
struct Gaussian;

impl ScoreEstimator<2> for Gaussian {
    fn support(&self) -> f64 {
        1.0
    }

    fn criterion(&self) -> Option<Criterion> {
        None
    }

    fn estimate(&self, cloud: &Cloud<'_, 2>, out: &mut Estimates<2>) -> Result<(), Error> {
        out.volume.fill(1.0);
        out.density.fill(1.0);
        out.score.copy_from_slice(cloud.positions);
        for component in out.score.as_flattened_mut() {
            *component = -*component;
        }
        Ok(())
    }
}

#[test]
fn a_gaussian_is_carried_exactly_by_any_lattice() {
    let law = GaussianMixture::independent([0.4, 0.0], [0.2, 0.3]).unwrap();
    // Wide enough that the truncated cloud has the covariance of its distribution within roundoff.
    let lattice = InitialLattice::Ball { reach: 8.0, spacing: 0.7 };
    let method = changed(|c| c.step = StepRule::Fixed { dt: 0.02 });
    let config = Config { lattice, ..config(method) };
    let mut fitted = Simulation::new(system(), &law, &config).unwrap();
    let mut exact =
        Simulation::with_estimator(system(), &law, &config, Box::new(Gaussian)).unwrap();
    fitted.advance_to(4.0).unwrap();
    exact.advance_to(4.0).unwrap();
    for (a, b) in fitted.positions().iter().zip(exact.positions()) {
        // Roundoff of 200 steps; the departure from the Gaussian is roundoff itself.
        assert!((a[0] - b[0]).abs() < 1e-10 && (a[1] - b[1]).abs() < 1e-10, "{a:?} {b:?}");
    }
}

/// The estimate beyond the cloud too, which these tests are about; a bound is none.
fn number(exceedance: Exceedance) -> f64 {
    match exceedance.probability() {
        Probability::Resolved(p)
        | Probability::Truncated { estimate: p, .. }
        | Probability::Extrapolated { estimate: p, .. }
        | Probability::Below { estimate: p, .. } => p,
        unresolved @ Probability::Unresolved { .. } => unreachable!("{unresolved}"),
    }
}

#[test]
fn the_tail_of_a_gaussian_goes_on_beyond_the_last_particle() {
    let law = GaussianMixture::independent([0.0, 0.0], [0.2, 0.3]).unwrap();
    let mut simulation = Simulation::new(system(), &law, &config(Method::FlowMapFit)).unwrap();
    simulation.advance_to(2.0).unwrap();
    let second_moment = simulation.raw_moment([2, 0]) / simulation.total_mass();
    let cells = simulation.cell_integral().unwrap();
    for sigmas in [2.0, 4.0, 6.0] {
        let threshold = sigmas * second_moment.sqrt();
        let found = number(cells.exceedance(|x| x[0], threshold).unwrap());
        // Upper tail of the normal distribution, to seven digits (Abramowitz & Stegun 1964, table 26.1).
        let expected = match sigmas {
            2.0 => 2.2750132e-2,
            4.0 => 3.1671242e-5,
            _ => 9.8658765e-10,
        };
        // Parts of a twelfth of a cell, the limit linear within a part: 0.4 % of a density that falls by exp(-0.35) over one
        // part at 6 sigma; the ball of 5 sigma goes on by three spacings.
        let error = (found / expected).log10().abs();
        assert!(error < 0.01, "at {sigmas} sigma: {found:e}, {error}");
    }
}

#[test]
fn a_coarse_lattice_in_four_dimensions_holds_the_tail_of_a_gaussian() {
    // 1.2 standard deviations between particles: at 4 of them a cell holds three times its centre's density.
    let law = GaussianMixture::independent([0.0; 4], [1.0; 4]).unwrap();
    let parameters = OrnsteinUhlenbeckParameters {
        rates: [[0.5, 1.0, 0.0, 0.0], [-1.0, 0.5, 0.0, 0.0], [0.0, 0.3, 0.5, 0.0], [0.0; 4]],
        mean: [0.0; 4],
        noise: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4], [0.0; 4]],
    };
    let process = OrnsteinUhlenbeck::new(parameters).unwrap();
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 1.2 };
    let config = fixtures::config(lattice, 6.0);
    let mut simulation = Simulation::new(process, &law, &config).unwrap();
    simulation.advance_to(0.5).unwrap();
    let deviation = process.covariance_at(0.5, &law.covariance()).unwrap()[0][0].sqrt();
    let cells = simulation.cell_integral().unwrap();
    // Upper tail of the normal distribution (Abramowitz & Stegun 1964, table 26.1).
    for (sigmas, expected) in [(2.0, 2.2750132e-2), (3.0, 1.349898e-3), (4.0, 3.1671242e-5)] {
        let found = number(cells.exceedance(|x| x[0], sigmas * deviation).unwrap());
        let error = (found / expected).log10().abs();
        // Fourth order in parts of a third of a cell, 0.4 standard deviations, and what the ball leaves out of the variance,
        // 4e-4 times half the square of 4.
        assert!(error < 0.005, "at {sigmas} sigma: {found:e}, {error}");
    }
}

#[test]
fn a_gaussian_is_known_between_the_particles_and_beyond_them() {
    let law = GaussianMixture::independent([0.4, 0.0], [0.2, 0.3]).unwrap();
    let method = Method::FlowMapFit;
    let lattice = InitialLattice::Ball { reach: 8.0, spacing: 0.5 };
    let simulation =
        Simulation::new(system(), &law, &Config { lattice, ..config(method) }).unwrap();
    let field = simulation.density_field().unwrap();
    for x in [[0.4, 0.0], [0.437, 0.111], [1.3, -1.4], [0.4, 2.35], [0.4, 2.9]] {
        // Roundoff; the covariance of a cloud of 8 standard deviations is that of its law.
        let error = field.density_at(&x) / law.density(&x) - 1.0;
        assert!(error.abs() < 1e-9, "{method:?} {x:?}: {error:e}");
    }
    assert!(!field.is_beyond(&[0.437, 0.111]) && field.is_beyond(&[0.4, 2.9]));
}

#[test]
fn a_density_that_is_no_gaussian_is_interpolated_with_the_third_order() {
    let law = two_gaussians([0.6, 0.4], [[0.04, 0.0], [0.0, 0.09]]);
    let worst = |spacing: f64| {
        let lattice = InitialLattice::Ball { reach: 5.0, spacing };
        let simulation =
            Simulation::new(system(), &law, &Config { lattice, ..config(Method::FlowMapFit) })
                .unwrap();
        let field = simulation.density_field().unwrap();
        (0..40)
            .map(|i| [-0.31 + 0.023 * f64::from(i), 0.4 - 0.017 * f64::from(i)])
            .map(|x| (field.density_at(&x) / law.density(&x) - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst(0.5), worst(0.25));
    // The third order falls by 8; the places lie differently in the two lattices.
    assert!(fine < 2e-3 && coarse / fine > 5.0, "{coarse:e} {fine:e}");
}

#[test]
fn the_same_bits_come_from_any_number_of_threads_and_after_a_restart() {
    let law = two_gaussians([0.6, 0.4], [[0.04, 0.01], [0.01, 0.09]]);
    // 1,681 particles: more than one thread keeps to itself.
    let lattice = InitialLattice::Box { reach: 5.0, count: [41, 41] };
    let config = Config { lattice, ..config(Method::FlowMapFit) };
    same_bits(|| Simulation::new(system(), &law, &config).unwrap(), [0.3, 0.6]);
}

#[test]
fn in_one_dimension_steps_within_the_limit_are_stable() {
    let parameters = OrnsteinUhlenbeckParameters { rates: [[1.0]], mean: [0.2], noise: [[0.5]] };
    let process = OrnsteinUhlenbeck::new(parameters).unwrap();
    let law = GaussianMixture::independent([1.0], [0.05]).unwrap();
    let config = fixtures::config(InitialLattice::Box { reach: 8.0, count: [60] }, 3.0);
    let mut simulation = Simulation::new(process, &law, &config).unwrap();
    simulation.advance_to(0.5).unwrap();
    let variance = process.covariance_at(0.5, &law.covariance()).unwrap()[0][0];
    let mean = simulation.raw_moment([1]);
    let found = simulation.raw_moment([2]) - mean * mean;
    // Runge-Kutta 4 at a fortieth of the period, 1e-7 seen; with the reach as the limit waves grew to 1e-3.
    assert!((found / variance - 1.0).abs() < 1e-6, "{found} {variance}");
}

/// Positions, score, and cells that were not resolved.
type Estimated = (Vec<[f64; 2]>, Vec<[f64; 2]>, Unresolved);

/// What the estimator makes of positions on a 15 x 15 lattice of spacing 0.4.
fn estimate(
    fit: &mut FlowMapFit<2>,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Result<Estimated, Error> {
    let places: Vec<[f64; 2]> =
        (0..225).map(|i| [f64::from(i % 15) - 7.0, f64::from(i / 15) - 7.0]).collect();
    let mut neighbours = NeighbourList::new();
    CellGrid::new().full_list(&places, Radii::Uniform(2.8), &mut neighbours)?;
    neighbours.sort_rows();
    let (reach, spacing) = (2.8, 0.4);
    fit.start(&LatticePlaces { places: &places, neighbours: &neighbours, reach, spacing })?;
    let n = places.len();
    let masses: Vec<f64> =
        places.iter().map(|[a, b]| (-0.08 * (a * a + b * b)).exp() * 0.0255).collect();
    let positions: Vec<[f64; 2]> = places.iter().map(|&p| place(p.map(|k| 0.4 * k))).collect();
    let cloud = Cloud {
        positions: &positions,
        masses: &masses,
        smoothing_lengths: &vec![1.0; n],
        neighbours: &neighbours,
        lattice: &[],
        whitened: true,
        step: 3,
        time: 0.5,
    };
    let mut out = Estimates::new(n);
    fit.estimate(&cloud, &mut out)?;
    Ok((positions, out.score, out.unresolved))
}

#[test]
fn a_cloud_that_collapses_onto_a_sheet_keeps_a_bounded_score() {
    let mut fit = FlowMapFit::new(Degree::Cubic, 0.2);
    // The width in x falls from 1 to 1e-4 over the upper half.
    let squeezed = |[x, y]: [f64; 2]| [x * 10.0_f64.powf(-4.0 * (y / 2.8).max(0.0)), y];
    let (positions, score, _) = estimate(&mut fit, squeezed).unwrap();
    for (y, s) in positions.iter().zip(&score) {
        // The departure's gradient per spacing is at most 10, its derivative along x at most that over 0.2 spacings.
        assert!(s[0].is_finite() && (s[0] + y[0]).abs() < 10.0 / (0.2 * 0.4), "{y:?} {s:?}");
    }
}

#[test]
fn cells_that_are_turned_over_are_counted_with_their_mass() {
    let mut fit = FlowMapFit::new(Degree::Cubic, 0.2);
    let upright = estimate(&mut fit, |p| p).unwrap().2;
    assert_eq!(upright, Unresolved::default());
    // A fold, wider than a neighbourhood: x runs back between -0.8 and 0.8.
    let folded = |[x, y]: [f64; 2]| [x - 2.2 * x * (-0.5 * x * x).exp(), y];
    let (_, score, unresolved) = estimate(&mut fit, folded).unwrap();
    assert!(unresolved.particles >= 15 && unresolved.mass > 0.05, "{unresolved:?}");
    assert!(score.iter().flatten().all(|value| value.is_finite()));
    // So wide that inner cells have no upright neighbour: they are repaired from repaired cells.
    let wide = |[x, y]: [f64; 2]| [x - 2.2 * x * (-0.08 * x * x).exp(), y];
    let (_, score, more) = estimate(&mut fit, wide).unwrap();
    assert!(more.particles > 2 * unresolved.particles && more.mass < 1.0, "{more:?}");
    assert!(score.iter().flatten().all(|value| value.is_finite()));
    // All turned over: nobody is left to take from.
    let error = estimate(&mut fit, |[x, y]| [-x, y]).unwrap_err().to_string();
    assert!(error.starts_with("step 3, t = 0.5: cell volume of particle 0 is -0.1"), "{error}");
}

/// A flow that gathers the particles at whole multiples of 3, without noise.
#[derive(Debug)]
struct Gathering;

impl Sde<2, 1> for Gathering {
    type Noise = Additive;

    fn drift(&self, _: f64, &[x, _]: &[f64; 2]) -> [f64; 2] {
        [-(std::f64::consts::TAU / 3.0 * x).sin(), 0.0]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0]; 2]
    }
}

#[test]
fn a_run_whose_unresolved_cells_hold_too_much_ends_with_the_heaviest_of_them() {
    let law = GaussianMixture::independent([0.0; 2], [1.0; 2]).unwrap();
    let lattice = InitialLattice::Box { reach: 5.0, count: [21, 21] };
    let config = Config { lattice, reference_period: 1.0, ..config(Method::FlowMapFit) };
    let mut simulation = Simulation::new(Gathering, &law, &config).unwrap();
    let error = simulation.advance_to(10.0).unwrap_err();
    let Error::TooMuchUnresolved { time, particle, particles, mass, limit, .. } = error else {
        unreachable!("{error}")
    };
    assert!(particles > 0 && mass > limit && (limit - MOST_UNRESOLVED).abs() < f64::MIN_POSITIVE);
    // The cell at the origin shrinks like exp(-2 pi t / 3), to 0.135 at t = 0.96; the middle of 441 is the heaviest.
    assert!((0.3..3.0).contains(&time) && particle == 220, "{time} {particle}");
    // Its mass is in every exceedance that rests on it.
    let cells = simulation.cell_integral().unwrap();
    let exceedance = cells.exceedance(|x| x[0].abs(), 1e-9).unwrap();
    let Probability::Unresolved { estimate, share } = exceedance.probability() else {
        unreachable!("{exceedance:?}")
    };
    assert!(share < 1.0 && (exceedance.unresolved() / estimate - share).abs() < 1e-15);
}

/// Largest unresolved mass up to t = 4 of the hysteretic oscillator of Canor & Denoël 2013, section 4.2, and the errors of
/// its second moments there.
fn hysteresis(settling: Settling) -> (f64, [f64; 3]) {
    let system = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013).unwrap();
    let law = GaussianMixture::independent([0.0; 3], [0.05; 3]).unwrap();
    let combination = Combination {
        estimator: Estimator::FlowMapFit { degree: Degree::Cubic, thinnest: 0.2, settling },
        scheme: Scheme::LawsonAdamsBashforth2,
        step: StepRule::PeriodFraction { steps_per_period: 80.0 },
        negligible: 1e-4,
        ..Method::FlowMapFit.combination()
    };
    let ball = InitialLattice::Ball { reach: 5.0, spacing: 0.72 };
    let method = Method::Custom(combination);
    let config = Config { method, ..fixtures::config(ball, system.period()) };
    let mut simulation = Simulation::new(system, &law, &config).unwrap();
    let mut unresolved = 0.0_f64;
    while simulation.time() < 4.0 {
        let report = simulation.step_towards(4.0).unwrap();
        unresolved = unresolved.max(report.unresolved.mass);
    }
    // 6e7 paths, error 2e-4: tests/reference/derived/fpk/bouc_wen.json.
    let references = [0.143_838, 1.252_42, 0.098_410_6];
    let powers = [[2, 0, 0], [0, 2, 0], [0, 0, 2]];
    let error = |k: usize| simulation.raw_moment(powers[k]) / references[k] - 1.0;
    (unresolved, [0, 1, 2].map(error))
}

#[test]
fn graded_settling_leaves_less_unresolved_and_moments_of_hysteresis_nearer_to_the_reference() {
    let (uniform, uniform_errors) = hysteresis(Settling::UNIFORM);
    let (graded, graded_errors) = hysteresis(Settling::GRADED);
    assert!(graded > 0.0 && graded < 0.9 * uniform, "{graded:e} against {uniform:e}");
    for (graded, uniform) in graded_errors.iter().zip(uniform_errors) {
        // Seen -0.47, -0.84, -0.36 %, for -1.25, -1.27, -0.98 %.
        assert!(graded.abs() < 0.012 && graded.abs() < uniform.abs(), "{graded} {uniform}");
    }
}

#[test]
fn what_cannot_work_is_refused_with_its_limit() {
    let law = GaussianMixture::independent([0.0, 0.0], [0.2, 0.3]).unwrap();
    let refused =
        |method: Method| Simulation::new(system(), &law, &config(method)).unwrap_err().to_string();
    assert_eq!(
        refused(changed(|c| c.support_over_spacing = 1.5)),
        "support_radius/spacing is 1.5: a support holds 9 neighbours of the undisturbed lattice; the fit needs 15 in 2-D"
    );
    for thinnest in [0.0, -0.1, f64::NAN] {
        let settling = Settling::UNIFORM;
        let estimator = Estimator::FlowMapFit { degree: Degree::Cubic, thinnest, settling };
        assert!(refused(changed(|c| c.estimator = estimator)).starts_with("thinnest is"));
    }
    let (degree, settling) = (Degree::Cubic, Settling { inside: 0.6, outside: 0.0 });
    let estimator = Estimator::FlowMapFit { degree, thinnest: 0.2, settling };
    assert_eq!(
        refused(changed(|c| c.estimator = estimator)),
        "settling outside is 0; it must be greater than 0"
    );
    let quartic = FlowMapFit::<4>::new(Degree::Quartic, 0.2);
    let error = quartic.check_resolution(3.0).unwrap_err().to_string();
    assert!(error.starts_with("a local polynomial of degree 4 in 4-D"), "{error}");
}
