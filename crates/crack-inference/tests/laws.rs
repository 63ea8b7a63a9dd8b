//! Inference on models whose likelihoods and posteriors are known.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

use crack_inference::{
    Absent, Emulator, EmulatorMixture, Error, Observations, Parameter, ParameterSpace, Posterior,
    Prior, SamplerConfig, Scale, Summaries, Verdict,
};
use sde_integrators::{Accumulator, Estimate, Noise, Purpose};

fn summaries(rows: &[Vec<f64>]) -> Summaries {
    Summaries::new(rows, Absent::default()).unwrap()
}

fn parameter(name: &str, scale: Scale, low: f64, high: f64, prior: Prior) -> Parameter {
    Parameter { name: name.to_owned(), scale, low, high, prior }
}

/// Two summaries: `x_0` of mean `m_0` and deviation `s_0`, `x_1` of mean `m_1 + b (x_0 - m_0)` and deviation `s_1` given `x_0`.
#[derive(Clone, Copy)]
struct Pair {
    mean: [f64; 2],
    slope: f64,
    deviations: [f64; 2],
}

impl Pair {
    fn draw(&self, seed: u64, number: u64, n: usize) -> Summaries {
        let mut stream = Noise::new(seed).stream(Purpose::Field, number);
        let row = |_| {
            let [a, b] = stream.next_normal_pair();
            let away = self.deviations[0] * a;
            vec![self.mean[0] + away, self.mean[1] + self.slope * away + self.deviations[1] * b]
        };
        summaries(&(0..n).map(row).collect::<Vec<_>>())
    }

    /// The log-density of plates, by the two by two inverse written out.
    fn log_density(&self, plates: &Summaries, errors: [f64; 2]) -> f64 {
        let [v_0, v_1] = self.deviations.map(|s| s * s);
        let (a, b, c) = (v_0 + errors[0], self.slope * v_0, self.slope * self.slope * v_0 + v_1);
        let (c, determinant) = (c + errors[1], a * (c + errors[1]) - b * b);
        let of = |plate: &[f64]| {
            let (x, y) = (plate[0] - self.mean[0], plate[1] - self.mean[1]);
            let distance = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant;
            -0.5 * (distance + determinant.ln()) - (2.0 * std::f64::consts::PI).ln()
        };
        plates.rows().map(of).sum()
    }
}

fn within(estimate: &Estimate, expected: f64, bias: f64) -> bool {
    (estimate.value - expected).abs() < 4.0 * estimate.standard_error().unwrap() + bias
}

/// Strength and correlation length on logarithms, between 1/2 and 2: means, slope and logarithms of variances are quadratic in them.
fn law_at(point: &[f64]) -> Pair {
    let [s, l] = [point[0].ln(), point[1].ln()];
    Pair {
        mean: [1.0 + 2.0 * s + 0.3 * s * s, 0.4 * s - 0.2 * l],
        slope: 0.5 * l,
        deviations: [(0.1 + 0.3 * s).exp(), (0.5 * l - 0.4 * l * l + 0.2 * s * l).exp()],
    }
}

fn two_parameters() -> ParameterSpace {
    let log = |name| parameter(name, Scale::Logarithmic, 0.5, 2.0, Prior::Uniform);
    ParameterSpace::new(vec![log("strength"), log("length")]).unwrap()
}

fn emulator(space: &ParameterSpace, law: impl Fn(&[f64]) -> Pair, seed: u64, n: usize) -> Emulator {
    let points = space.design(24).unwrap();
    let draw = |(point, id): (&Vec<f64>, u64)| law(point).draw(seed, id, n);
    let ensembles: Vec<Summaries> = points.iter().zip(0..).map(draw).collect();
    Emulator::new(space, &points, &ensembles).unwrap()
}

#[test]
fn emulated_likelihood_is_the_density_within_its_stated_error() {
    let (space, errors) = (two_parameters(), [0.05, 0.0]);
    let plates = law_at(&[1.2, 0.9]).draw(3, 0, 6);
    let data = Observations::new(&plates, &errors).unwrap();
    for point in [[1.2, 0.9], [0.7, 1.6], [1.9, 0.55]] {
        let expected = law_at(&point).log_density(&plates, errors);
        let (mut error, mut stated) = (Accumulator::default(), Accumulator::default());
        for seed in 0..200 {
            let found = emulator(&space, law_at, 100 + seed, 60);
            let found = found.log_likelihood(&point, &data).unwrap();
            error.push((found.value - expected) / found.standard_error().unwrap());
            stated.push(found.standard_error().unwrap());
        }
        // Errors in units of the stated one: mean 0, less a bias of second order in it (the stated error is up to one half);
        // deviation 1, which 200 repetitions resolve to 5 %.
        let spread = error.variance().unwrap().sqrt();
        let mean = error.estimate().unwrap();
        assert!(within(&mean, 0.0, stated.mean()), "{point:?}: {mean} {}", stated.mean());
        assert!((spread - 1.0).abs() < 0.2 + 0.1, "{point:?}: {spread}");
    }
}

#[test]
fn moments_of_the_emulator_are_those_of_the_law() {
    let emulator = emulator(&two_parameters(), law_at, 5, 4000);
    let point = [1.3, 0.8];
    let (law, (mean, covariance)) = (law_at(&point), emulator.moments(&point).unwrap());
    let [v_0, v_1] = law.deviations.map(|s| s * s);
    let b = law.slope * v_0;
    // Some six of 24 ensembles of 4000 make up a point: 1/sqrt(20,000) of a deviation, 4 of them, and twice that on variances.
    for i in 0..2 {
        assert!((mean[i] - law.mean[i]).abs() < 0.03 * law.deviations[i].max(1.0), "{mean:?}");
    }
    for (found, expected) in covariance.iter().zip([v_0, b, b, law.slope * b + v_1]) {
        assert!((found - expected).abs() < 0.06 * v_0.max(1.0), "{covariance:?}");
    }
}

fn sampled(
    space: &ParameterSpace,
    log_likelihood: impl Fn(&[f64]) -> f64 + Sync,
    seed: u64,
) -> Posterior {
    let config = SamplerConfig::new(Noise::new(seed));
    Posterior::sample(space, &|point| Ok(log_likelihood(point)), &config).unwrap()
}

#[test]
fn draws_from_a_normal_posterior_have_its_moments_and_quantiles() {
    let wide = |name| parameter(name, Scale::Linear, -30.0, 30.0, Prior::Uniform);
    let space = ParameterSpace::new(vec![wide("a"), wide("b")]).unwrap();
    // Deviations 1 and 2, correlation 0.8; the bounds are 14 deviations away.
    let log_density = |x: &[f64]| {
        let (a, b) = (x[0] - 1.0, 0.5 * x[1] + 1.0);
        -0.5 * (a * a - 1.6 * a * b + b * b) / 0.36
    };
    let posterior = sampled(&space, log_density, 1);
    assert!(posterior.has_converged());
    assert!((0.2..0.5).contains(&posterior.acceptance()), "{}", posterior.acceptance());
    assert!(posterior.temperatures().len() > 2);
    for (of, (mean, deviation)) in posterior.parameters().iter().zip([(1.0, 1.0), (-2.0, 2.0)]) {
        assert!(within(&of.mean, mean, 0.0), "{of:?}");
        assert!(within(&of.standard_deviation, deviation, 0.0), "{of:?}");
        for (quantile, z) in of.quantiles.iter().zip([-1.6448536, 0.0, 1.6448536]) {
            assert!(within(quantile, mean + z * deviation, 0.0), "{of:?}");
        }
        // Of the prior: 60^2/12 = 300.
        assert!(within(&of.contraction, 1.0 - deviation * deviation / 300.0, 0.0), "{of:?}");
        assert_eq!(of.verdict, Verdict::Identified);
    }
    let chains = posterior.chains();
    let (mut product, middle) = (Accumulator::default(), posterior.parameters()[0].mean.value);
    chains.iter().flatten().for_each(|draw| product.push((draw[0] - middle) * (draw[1] + 2.0)));
    // The covariance is 1.6, the variance of a product 4 (1 + 0.64); draws are worth a tenth of their number or more.
    let error = (4.0 * 1.64 / (0.1 * product.count() as f64)).sqrt();
    assert!((product.mean() - 1.6).abs() < 4.0 * error, "{}", product.mean());
}

#[test]
fn a_posterior_that_a_bound_cuts_is_not_an_identification() {
    let bounds = (0.5, 8.0);
    for (scale, data, deviation, expected) in [
        // Far beyond a bound, on either side: an exponential against it.
        (Scale::Linear, 2000.0, 20.0, Verdict::AtBound),
        (Scale::Logarithmic, 0.01, 0.05, Verdict::AtBound),
        // At the bound, and a deviation inside.
        (Scale::Linear, 8.0, 0.1, Verdict::AtBound),
        (Scale::Linear, 0.7, 0.2, Verdict::AtBound),
        // Three deviations inside.
        (Scale::Linear, 7.4, 0.2, Verdict::Identified),
        (Scale::Logarithmic, 0.6, 0.04, Verdict::Identified),
        // Hardly any data.
        (Scale::Linear, 8.0, 30.0, Verdict::NotIdentified),
    ] {
        let toughness = parameter("toughness", scale, bounds.0, bounds.1, Prior::Uniform);
        let space = ParameterSpace::new(vec![toughness]).unwrap();
        let density = |x: &[f64]| -0.5 * ((x[0] - data) / deviation).powi(2);
        let of = &sampled(&space, density, 5).parameters()[0].clone();
        assert_eq!(of.verdict, expected, "{data} {of:?}");
    }
}

#[test]
fn normal_prior_and_normal_likelihood_make_the_posterior_in_closed_form() {
    // On the logarithm: prior N(0, 0.5^2), one datum 0.6 with the deviation 0.5: N(0.3, 0.125). Bounds at 6 deviations.
    let prior = Prior::Normal { mean: 0.0, standard_deviation: 0.5 };
    let (low, high) = ((-3.0_f64).exp(), 3.0_f64.exp());
    let strength = parameter("strength", Scale::Logarithmic, low, high, prior);
    let space = ParameterSpace::new(vec![strength]).unwrap();
    let posterior = sampled(&space, |x| -2.0 * (x[0].ln() - 0.6).powi(2), 2);
    let of = &posterior.parameters()[0];
    assert!(within(&of.mean, (0.3_f64 + 0.0625).exp(), 0.0), "{of:?}");
    assert!(within(&of.quantiles[1], 0.3_f64.exp(), 0.0), "{of:?}");
    assert!(within(&of.contraction, 0.5, 0.0), "{of:?}");
    // A likelihood that says nothing leaves the prior.
    let posterior = sampled(&space, |_| -7.0, 3);
    let of = &posterior.parameters()[0];
    assert!(within(&of.contraction, 0.0, 0.0), "{of:?}");
    assert!(within(&of.quantiles[2], (0.5 * 1.6448536_f64).exp(), 0.0), "{of:?}");
    assert_eq!((of.verdict, posterior.temperatures()), (Verdict::NotIdentified, &[1.0][..]));
}

#[test]
fn intervals_of_plates_cover_as_often_as_they_say_and_a_parameter_without_effect_is_named() {
    // Temperature in place of the length, without effect.
    let law = |point: &[f64]| law_at(&[point[0], 1.3]);
    let parameters = vec![
        parameter("strength", Scale::Logarithmic, 0.5, 2.0, Prior::Uniform),
        parameter("kT", Scale::Logarithmic, 1e-6, 1e-4, Prior::Uniform),
    ];
    let space = ParameterSpace::new(parameters).unwrap();
    let emulator = emulator(&space, law, 7, 200);
    let (mut covered, n) = (0, 60);
    for id in 0..n {
        let mut stream = Noise::new(9).stream(Purpose::InitialDistribution, id);
        let truth = 0.5 * 4_f64.powf(stream.next_uniform());
        let plates = law(&[truth, 1e-5]).draw(10, id, 8);
        let data = Observations::new(&plates, &[0.0; 2]).unwrap();
        let config = SamplerConfig {
            n_particles: 200,
            n_draws: 2000,
            ..SamplerConfig::new(Noise::new(1000 + id))
        };
        let of = |point: &[f64]| emulator.value(point, &data);
        let posterior = Posterior::sample(&space, &of, &config).unwrap();
        let [strength, temperature] = posterior.parameters() else { unreachable!() };
        let (low, high) = strength.interval_90();
        covered += u64::from((low..=high).contains(&truth));
        assert_eq!(temperature.verdict, Verdict::NotIdentified, "{id}: {temperature:?}");
    }
    // Binomial: 54 of 60, with the deviation sqrt(60 0.9 0.1) = 2.3, four of them.
    assert!((45..=60).contains(&covered), "{covered} of {n}");
}

#[test]
fn error_of_posterior_means_is_the_spread_over_ensembles() {
    let space = two_parameters();
    let plates = law_at(&[1.2, 0.9]).draw(3, 1, 6);
    let data = Observations::new(&plates, &[0.0; 2]).unwrap();
    let (mut means, mut stated) = ([Accumulator::default(); 2], [Accumulator::default(); 2]);
    for seed in 0..50 {
        let emulator = emulator(&space, law_at, 500 + seed, 60);
        let config = SamplerConfig { n_particles: 200, ..SamplerConfig::new(Noise::new(4)) };
        let of = |point: &[f64]| emulator.value(point, &data);
        let posterior = Posterior::sample(&space, &of, &config).unwrap();
        let draws = posterior.thinned(400).unwrap();
        let errors = emulator.error_of_means(&draws, &data).unwrap();
        for i in 0..2 {
            let chains = posterior.chains().iter().flatten();
            let mut mean = Accumulator::default();
            chains.for_each(|draw| mean.push(draw[i].ln()));
            means[i].push(mean.mean());
            stated[i].push(errors[i]);
        }
    }
    for i in 0..2 {
        // A deviation from 50 repetitions has an error of 10 %. It is of first order in errors of the log-likelihood of a half.
        let ratio = stated[i].mean() / means[i].variance().unwrap().sqrt();
        assert!((ratio - 1.0).abs() < 0.4 + 0.1, "{i}: {ratio}");
    }
}

#[test]
fn mixture_scatters_by_the_stated_error_and_widens_the_posterior() {
    let space = two_parameters();
    let plates = law_at(&[1.2, 0.9]).draw(3, 2, 6);
    let data = Observations::new(&plates, &[0.0; 2]).unwrap();
    let fine = emulator(&space, law_at, 20, 1000);
    let mixture = EmulatorMixture::new(&fine, 400, &Noise::new(21)).unwrap();
    for point in [[1.2, 0.9], [0.7, 1.6]] {
        let mut values = Accumulator::default();
        for of in mixture.emulators() {
            values.push(of.value(&point, &data).unwrap());
        }
        let stated = fine.log_likelihood(&point, &data).unwrap();
        let ratio = values.variance().unwrap().sqrt() / stated.standard_error().unwrap();
        // A deviation from 400 draws has an error of 3.5 %; errors of 0.1 to 0.2 are nearly of first order.
        assert!((ratio - 1.0).abs() < 4.0 * 0.035 + 0.05, "{point:?}: {ratio}");
        let mean = values.estimate().unwrap();
        assert!(within(&mean, stated.value, 0.05), "{point:?}: {mean} {stated}");
    }
    let coarse = emulator(&space, law_at, 22, 12);
    let mixture = EmulatorMixture::new(&coarse, 32, &Noise::new(23)).unwrap();
    let config =
        SamplerConfig { n_particles: 200, n_draws: 2000, ..SamplerConfig::new(Noise::new(4)) };
    let deviations = |of: &(dyn Fn(&[f64]) -> Result<f64, Error> + Sync)| -> Vec<f64> {
        let posterior = Posterior::sample(&space, &of, &config).unwrap();
        posterior.parameters().iter().map(|p| p.standard_deviation.value).collect()
    };
    let alone = deviations(&|x| coarse.value(x, &data));
    let averaged = deviations(&|x| mixture.value(x, &data));
    assert!((0..2).all(|i| averaged[i] > 1.02 * alone[i]), "{averaged:?} {alone:?}");
    let few = EmulatorMixture::new(&coarse, 7, &Noise::new(0));
    assert!(matches!(few, Err(Error::TooFew { value: 7, limit: 8, .. })));
}

#[test]
fn posterior_has_the_same_bits_on_any_number_of_threads() {
    let space = two_parameters();
    let on = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| {
            let config = SamplerConfig { n_draws: 200, ..SamplerConfig::new(Noise::new(6)) };
            let likelihood = |x: &[f64]| Ok(-5.0 * (x[0] - x[1]).powi(2));
            Posterior::sample(&space, &likelihood, &config).unwrap()
        })
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(8));
}

#[test]
fn two_far_modes_leave_few_effective_draws() {
    let wide = parameter("a", Scale::Linear, -1.0, 1.0, Prior::Uniform);
    let space = ParameterSpace::new(vec![wide]).unwrap();
    // Deviations of 0.02 at -0.5 and 0.5: of proposals of the deviation 2.38 times 0.5 some 3 % fall onto either.
    let log = |x: &[f64]| -0.5 * ((x[0].abs() - 0.5) / 0.02).powi(2);
    let config = SamplerConfig { n_draws: 500, ..SamplerConfig::new(Noise::new(12)) };
    let posterior = Posterior::sample(&space, &|x| Ok(log(x)), &config).unwrap();
    let of = &posterior.parameters()[0];
    assert!(!posterior.has_converged() && of.effective_sample_size < 100.0, "{of:?}");
}

#[test]
fn likelihoods_and_configurations_that_cannot_be_are_refused() {
    let space = two_parameters();
    let config = SamplerConfig::new(Noise::new(1));
    let nan = Posterior::sample(&space, &|_| Ok(f64::NAN), &config);
    assert!(matches!(nan, Err(Error::NotFinite { .. })));
    let infinite = Posterior::sample(&space, &|_| Ok(f64::INFINITY), &config);
    assert!(matches!(infinite, Err(Error::NotFinite { .. })));
    let never = Posterior::sample(&space, &|_| Ok(f64::NEG_INFINITY), &config).unwrap_err();
    assert_eq!(
        never.to_string(),
        "0 points of the prior at which the data are possible; at least 10 are needed"
    );
    let of_caller = || Error::NotPositive { name: "a strength", value: -1.0 };
    let failed = Posterior::sample(&space, &|_| Err(of_caller()), &config);
    assert_eq!(failed, Err(of_caller()));
    for (config, name) in [
        (SamplerConfig { n_chains: 3, ..config }, "chains"),
        (SamplerConfig { n_draws: 99, ..config }, "draws of a chain"),
        (SamplerConfig { n_particles: 99, ..config }, "points of a cloud"),
        (SamplerConfig { n_moves: 0, ..config }, "steps of a point"),
    ] {
        let refused = Posterior::sample(&space, &|_| Ok(0.0), &config);
        assert!(matches!(refused, Err(Error::TooFew { name: found, .. }) if found == name));
    }
}
