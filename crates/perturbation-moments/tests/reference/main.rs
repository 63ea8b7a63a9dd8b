//! 51 cases against other programs: derivatives by JAX, moments by OpenTURNS 1.27, by Gauss-Hermite quadrature and in closed form.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed test panics")]

mod case;
#[path = "../responses/mod.rs"]
mod responses;

use perturbation_moments::{
    Expansion, ForwardDifferentiation, HighestOrder, Jet, Judgement, Moments, MonteCarlo,
    RandomVector, Response, SigmaPoints, Trust, Verdict,
};

use case::{Case, Visitor, flat, table};

/// What the crate makes of one case.
struct Assessed {
    /// The largest errors of value, gradient, Hessian and third derivatives, by dual numbers, by jets and in closed form.
    derivatives: f64,
    /// The largest error against OpenTURNS.
    openturns: f64,
    /// The largest error of a moment against its formula from the reference's derivatives.
    moments: f64,
    /// Of first order, and of fourth.
    variances: [f64; 2],
    mean_second_order: f64,
    trust: Trust,
    /// With the sigma points as a witness.
    witnessed: Trust,
}

struct Assess<'a>(&'a Case);

impl Visitor for Assess<'_> {
    type Output = Assessed;

    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        closed: Option<Expansion<N>>,
    ) -> Assessed {
        let case = self.0;
        let way = ForwardDifferentiation { response, order: HighestOrder::Third };
        let expansion = way.expansion(inputs.mean());
        // Mixed and third derivatives, which jets do not carry, are those of dual numbers.
        let mean = inputs.mean();
        let y = response.value(&std::array::from_fn(|k| Jet::variable(mean[k], k)));
        let mut by_jets = Expansion { value: y.value, ..expansion };
        for k in 0..N {
            by_jets.gradient[k] = y.first[k];
            by_jets.hessian.as_mut().unwrap()[k][k] = y.second[k];
        }
        let all = [Some(expansion), Some(by_jets), closed];
        let derivatives = all.iter().flatten().map(|ours| derivative_error(case, ours));
        let moments = Moments::new(inputs, &expansion).unwrap();
        let points = SigmaPoints::new(inputs, |x| response.value(x)).unwrap();
        Assessed {
            derivatives: derivatives.fold(0.0, largest),
            openturns: openturns_error(case, &expansion, &moments),
            moments: moment_error(case, &moments),
            variances: [moments.variance_first_order(), moments.variance_fourth_order().unwrap()],
            mean_second_order: moments.mean_second_order().unwrap(),
            trust: moments.trust().unwrap(),
            witnessed: points.judge(&moments).unwrap(),
        }
    }
}

/// The larger, and NaN if one is.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The largest distance of two lists of derivatives of an order, each times deviations of its inputs, over the largest entry.
fn apart(case: &Case, order: u32, ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len(), "{}", case.name);
    let n = case.sigma.len();
    let weight = |place: usize| (0..order).map(|k| case.sigma[place / n.pow(k) % n]).product();
    let weights: Vec<f64> = (0..ours.len()).map(weight).collect();
    let scale = weights.iter().zip(theirs).map(|(w, b)| (w * b).abs()).fold(0.0, f64::max);
    let scale = if scale > 0.0 { scale } else { 1.0 };
    let errors =
        weights.iter().zip(ours).zip(theirs).map(|((w, a), b)| (w * (a - b)).abs() / scale);
    errors.fold(0.0, largest)
}

fn derivative_error<const N: usize>(case: &Case, ours: &Expansion<N>) -> f64 {
    let (hessian, third) = (ours.hessian.unwrap(), ours.third.unwrap());
    let all: [(&str, &[f64]); 4] = [
        ("value", &[ours.value]),
        ("gradient", &ours.gradient),
        ("hessian", hessian.as_flattened()),
        ("third", third.as_flattened().as_flattened()),
    ];
    let errors =
        (0..).zip(all).map(|(order, (key, ours))| apart(case, order, ours, &flat(&case.data[key])));
    errors.fold(0.0, largest)
}

fn openturns_error<const N: usize>(case: &Case, ours: &Expansion<N>, moments: &Moments<N>) -> f64 {
    let hessian = ours.hessian.unwrap();
    let all: [(&str, u32, &[f64]); 6] = [
        ("mean1", 0, &[moments.mean_first_order()]),
        ("mean2", 0, &[moments.mean_second_order().unwrap()]),
        ("var1", 0, &[moments.variance_first_order()]),
        ("importance", 0, &moments.importance_factors().unwrap()),
        ("gradient", 1, &ours.gradient),
        ("hessian", 2, hessian.as_flattened()),
    ];
    let theirs = |key: &str| flat(&case.data["openturns"][key]);
    all.map(|(key, order, ours)| apart(case, order, ours, &theirs(key)))
        .into_iter()
        .fold(0.0, largest)
}

/// Odd and high moments may vanish: errors are over the power of the variance that has their unit.
fn moment_error<const N: usize>(case: &Case, moments: &Moments<N>) -> f64 {
    let formula = |key: &str| case.data["second_order"][key].as_f64().unwrap();
    let variance = formula("var2");
    [
        ("var2", 1.0, moments.variance_with_curvature()),
        ("var_o4_with_third_derivs", 1.0, moments.variance_fourth_order()),
        ("third_central", 1.5, moments.third_central_moment()),
        ("kappa4", 2.0, moments.fourth_cumulant()),
    ]
    .map(|(key, power, ours)| (ours.unwrap() - formula(key)).abs() / variance.powf(power))
    .into_iter()
    .fold(0.0, largest)
}

fn assessed() -> Vec<(Case, Assessed)> {
    let all = table().into_iter().map(|case| {
        let assessed = case.visit(&mut Assess(&case));
        (case, assessed)
    });
    all.collect()
}

/// Some hundred operations in both programs.
const ROUNDOFF: f64 = 1e-13;

/// Families by the beginning of their names: whether OpenTURNS prints six digits into their derivatives, and how far Taylor
/// variances of first and of fourth order are from the true ones.
const FAMILIES: [(&str, bool, [f64; 2]); 8] = [
    ("linear3", false, [ROUNDOFF, ROUNDOFF]),
    ("product2", false, [0.07, ROUNDOFF]),
    ("exp2", false, [0.25, 0.03]),
    ("cantilever", true, [0.05, 2.5e-3]),
    ("ishigami", false, [0.35, 0.09]),
    ("sdof", false, [0.7, 1.6]),
    ("johnson_cook", true, [0.06, 0.04]),
    ("mie_gruneisen", true, [0.045, 1.7e-3]),
];

#[test]
fn derivatives_and_moments_are_those_of_other_programs_and_a_series_is_off_by_its_truncation() {
    let all = assessed();
    let mut n_seen = 0;
    for (family, has_literals, truncation) in FAMILIES {
        let mut off = [0.0_f64; 2];
        for (case, found) in all.iter().filter(|(case, _)| case.name.starts_with(family)) {
            n_seen += 1;
            let openturns = if has_literals { 1e-5 } else { ROUNDOFF };
            assert!(found.derivatives <= ROUNDOFF, "{}: {:e}", case.name, found.derivatives);
            assert!(found.openturns <= openturns, "{}: {:e}", case.name, found.openturns);
            assert!(found.moments <= ROUNDOFF, "{}: {:e}", case.name, found.moments);
            if let Some(truth) = case.variance() {
                off = [0, 1].map(|k| largest(off[k], (found.variances[k] / truth - 1.0).abs()));
            }
        }
        for (off, bound) in off.into_iter().zip(truncation) {
            let is_tight = bound <= ROUNDOFF || off > 0.1 * bound;
            assert!(off <= bound && is_tight, "{family}: {off:e} of {bound:e}");
        }
    }
    assert_eq!((n_seen, all.len()), (51, 51));
}

/// Independent parameters of Johnson and Cook, coefficients of variation of 0.15 and 0.3: the mean is off by terms of fourth
/// order, and quadrature has the closed variance.
#[test]
fn the_second_order_mean_is_near_the_closed_one() {
    let (mut off, mut quadrature, mut count) = (0.0, 0.0, 0);
    for (case, found) in assessed() {
        let Some(mean) = case.data["exact"]["mean"].as_f64() else { continue };
        let variance = case.data["exact"]["var"].as_f64().unwrap();
        off = largest(off, (found.mean_second_order - mean).abs() / variance.sqrt());
        let by_nodes = case.data["quadrature"]["var"].as_f64().unwrap();
        quadrature = largest(quadrature, (by_nodes / variance - 1.0).abs());
        count += 1;
    }
    assert_eq!(count, 10);
    assert!(off <= 2.5e-2 && quadrature <= 3e-12, "{off} {quadrature:e}");
}

/// The counts of the README: warned and wrong, false alarms, misses, no warning and right. Wrong is a first-order variance that
/// is off by more than 10 %; the limit of 0.05 was chosen before.
#[test]
fn warnings_are_as_often_right_as_the_tables_say() {
    let all = assessed();
    let counts = |is_warned: &dyn Fn(&Assessed) -> bool| {
        let mut counts = [0; 4];
        for (case, found) in &all {
            let Some(truth) = case.variance() else { continue };
            let is_wrong = (found.variances[0] / truth - 1.0).abs() > 0.1;
            let place = match (is_warned(found), is_wrong) {
                (true, true) => 0,
                (true, false) => 1,
                (false, true) => 2,
                (false, false) => 3,
            };
            counts[place] += 1;
        }
        counts
    };
    let by_verdict = |trust: &Trust| trust.verdict() != Verdict::InPeace;
    assert_eq!(counts(&|found| by_verdict(&found.trust)), [4, 1, 0, 44]);
    let by_kappa =
        |found: &Assessed| found.trust.curvature_ratio.is_none_or(|ratio| ratio > Trust::LIMIT);
    assert_eq!(counts(&by_kappa), [3, 1, 1, 44]);
    assert_eq!(counts(&|found| by_verdict(&found.witnessed)), [4, 3, 0, 42]);

    let indicator = |trust: &Trust| {
        [trust.curvature_ratio, trust.third_ratio].into_iter().flatten().fold(0.0, f64::max)
    };
    let must_warn = |name: &str| {
        name.starts_with("sdof")
            || name == "ishigami_gauss_s0.3"
            || name.starts_with("mie_gruneisen_mu0.5_e2e+10_cv0.15")
    };
    let warned = all
        .iter()
        .filter(|(case, found)| must_warn(&case.name) && indicator(&found.trust) > Trust::LIMIT);
    assert_eq!(warned.count(), 5, "known failures, two of them near a pole");
    let in_peace = all
        .iter()
        .filter(|(case, found)| case.name.starts_with("johnson_cook") && !by_verdict(&found.trust));
    assert_eq!(in_peace.count(), 20, "right within 6 % in all cases");
}

/// `kappa = var_2/var_1 - 1` and `tau = abs(var_4 - var_2)/var_1`, by the variances of another program.
#[test]
fn indicators_are_ratios_of_variances() {
    for (case, found) in assessed() {
        let formula = |key: &str| case.data["second_order"][key].as_f64().unwrap();
        let first = found.variances[0];
        let curvature = formula("var2") / first - 1.0;
        let third = (formula("var_o4_with_third_derivs") - formula("var2")).abs() / first;
        for (found, expected) in
            [(found.trust.curvature_ratio, curvature), (found.trust.third_ratio, third)]
        {
            assert!(
                (found.unwrap() - expected).abs() <= 1e-13,
                "{}: {found:?} {expected}",
                case.name
            );
        }
    }
}

const JUDGE: MonteCarlo = MonteCarlo { seed: 51, n_samples: 200_000 };

struct Sample;

impl Visitor for Sample {
    type Output = Judgement;

    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        _closed: Option<Expansion<N>>,
    ) -> Judgement {
        let way = ForwardDifferentiation { response, order: HighestOrder::Second };
        let moments = Moments::new(inputs, &way.expansion(inputs.mean())).unwrap();
        JUDGE.judge(inputs, &moments, |x| response.value(x)).unwrap()
    }
}

/// Both estimates are unbiased, whatever the surrogate is worth: four standard errors. The factors by which the surrogate makes
/// standard errors of mean and variance smaller were measured; another seed moves them by a quarter.
#[test]
fn monte_carlo_agrees_with_quadrature_and_a_surrogate_sharpens_it() {
    let all = table();
    for (name, factors) in [
        ("exp2_s0.3", [10.15, 3.22]),
        ("ishigami_gauss_s0.1", [42.7, 11.8]),
        ("johnson_cook_ep0.1_rate1000_T0.2_cv0.15_rho0.0", [45.4, 27.6]),
        ("johnson_cook_ep0.5_rate10000_T0.4_cv0.1_rho0.4", [345.0, 111.5]),
        ("mie_gruneisen_mu0.2_e4e+09_cv0.05_rho0.0", [461.0, 130.6]),
    ] {
        let case = all.iter().find(|case| case.name == name).unwrap();
        let judged = case.visit(&mut Sample);
        let truth = |key: &str| case.data["quadrature"][key].as_f64().unwrap();
        for (estimate, truth) in [
            (judged.raw_mean, truth("mean")),
            (judged.controlled_mean, truth("mean")),
            (judged.raw_variance, truth("var")),
            (judged.controlled_variance, truth("var")),
        ] {
            let z = (estimate.value - truth) / estimate.standard_error().unwrap();
            assert!(z.abs() <= 4.0, "{name}: {estimate} for {truth}");
        }
        let miss = judged.surrogate_mean_miss.max(judged.surrogate_variance_miss);
        assert!(miss <= 4.0, "{name}: {miss}");
        for (found, seen) in
            [judged.mean_reduction(), judged.variance_reduction()].into_iter().zip(factors)
        {
            assert!((seen / 1.25..=seen * 1.25).contains(&found), "{name}: {found} for {seen}");
        }
    }
}

#[cfg(feature = "rayon")]
#[test]
fn samples_have_the_same_bits_on_any_number_of_threads() {
    let case = table().into_iter().find(|case| case.name == "exp2_s0.3").unwrap();
    let on = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| case.visit(&mut Sample))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(8));
}
