//! Plates in noise and without load: how many bonds break, by step and by temperature.

use peridyn_sde::Scheme;
use reference_problems::peridyn::background::{
    MOST_DEVIATIONS, broken, noise_of_bonds, rate_in_equilibrium, temperature,
};
use reference_problems::peridyn::first_passage::rate;
use reference_problems::peridyn::network::Network;
use reference_problems::peridyn::sample::mean;

use crate::cases::prelude::*;

pub(crate) const LATTICE: Case = Case {
    id: "peridyn-sde/breaking-by-step",
    title: "A plate of 48 x 48 nodes in noise: bonds broken after a fixed time, for steps of z = 0.1, 0.05, 0.025",
    source: "the same time at a quarter of the step; research of the prototype: 6.0 % against 2.95 % by two schemes at z = 0.11",
    cost: Profile::Default,
    run: Together(by_step),
};

pub(crate) const BACKGROUND: Case = Case {
    id: "peridyn-sde/background",
    title: "Bonds that break in equilibrium without load: their rate against that of killed Ornstein-Uhlenbeck paths",
    source: "K^-1 of the network for the variance of each bond; lowest eigenvalue of the killed process",
    cost: Profile::Default,
    run: Together(background),
};

/// `s0/sigma` of a plate of which some per cent of the bonds break: few enough of them to be rare, enough to be counted.
const RATIO: f64 = 4.0;

fn by_step(context: &Context<'_>) -> CaseResult {
    let network = Network::square(48, 3)?;
    let (strength, time) = (0.01, 50.0);
    let mut claims = Vec::new();
    for scheme in [Scheme::Theta(0.5), Scheme::Heun] {
        let steps = [0.025, 0.05, 0.1];
        let mut found = Vec::new();
        for z in steps {
            context.progress(&format!("{} z = {z}", scheme.name()));
            let (lost, _) = broken(&network, (strength, RATIO), (z, &[time]), scheme)?;
            found.push(mean(&lost[0].map(|lost| lost / network.bonds.len() as f64)));
        }
        let finest = found[0];
        for (z, coarse) in steps.into_iter().zip(&found).skip(1) {
            let name = scheme.name().to_lowercase().replace(' ', "-");
            let method = format!(
                "{} with the bridge, ratio {RATIO}, z = {z} against 0.025, 8 realisations",
                scheme.name()
            );
            let quantity = "share of bonds broken after 50/lambda_max";
            let reason = "a bond alone, from the transition of one step: 1.2 % at z = 0.1 and four deviations, by either scheme; other noise at each step";
            let reference =
                Reference::uncertain(finest.value, finest.standard_error.unwrap_or(0.0));
            let subject = context.subject(format!("{name}/z{z}"), quantity, method);
            claims.push(subject.relative(*coarse, reference).monte_carlo(0.015).because(reason));
        }
    }
    Ok(claims)
}

/// Logarithms of the rate at levels from 2 on.
struct Rates(Vec<f64>);

impl Rates {
    const STEP: f64 = 0.05;

    fn new() -> Self {
        let count = ((MOST_DEVIATIONS - 2.0) / Self::STEP).ceil();
        let levels = (0..=140_u32).map(f64::from).take_while(|&at| at <= count);
        Self(levels.map(|at| rate(2.0 + Self::STEP * at).ln()).collect())
    }

    /// By straight lines: within 3e-4, an eighth of the curvature, about one, times the square of the step.
    fn at(&self, level: f64) -> f64 {
        let place = (level - 2.0) / Self::STEP;
        let below = self.0.iter().zip(&self.0[1..]).enumerate();
        let mut found = below.filter(|&(at, _)| (at as f64..at as f64 + 1.0).contains(&place));
        found
            .next()
            .map_or(f64::NAN, |(at, (low, high))| (low + (high - low) * (place - at as f64)).exp())
    }
}

fn background(context: &Context<'_>) -> CaseResult {
    let network = Network::square(16, 3)?;
    let (strength, of_bonds, rates) = (0.01, noise_of_bonds(&network)?, Rates::new());
    let full = context.profile == Profile::Full;
    let mut claims = Vec::new();
    for (ratio, time, batches) in [(5.5, 50.0, 40), (6.0, 100.0, 40), (7.0, 400.0, 80)] {
        if ratio > 6.5 && !full {
            continue;
        }
        context.progress(&format!("ratio {ratio}"));
        let (found, duration) =
            rate_in_equilibrium::<f32, 16>(&network, (strength, ratio), (0.1, time), batches)?;
        let kt = temperature(&network, strength, ratio);
        let lost = |rate: f64| -(-rate * duration).exp_m1() / duration;
        let rates = of_bonds.iter().map(|of| of.rate(kt, strength, |level| rates.at(level)));
        let expected: f64 = rates.map(lost).sum();
        let method = format!(
            "Heun with the bridge, z = 0.1, 16 x 16 nodes from equilibrium, {} realisations until {time}/lambda_max",
            16 * batches
        );
        let reason = "a bond alone by Heun's steps of z = 0.1 is up to 1.5 % low. A bond of a network is a sum of paths, of which some last: by Slepian's inequality it breaks no more often than one path of its variance and diffusion, and some per cent less. A broken bond loads others, but few are broken";
        let subject = context.subject(format!("ratio{ratio}"), "bonds broken per time", method);
        let compared = subject.unit("1/time").relative(found, expected);
        claims.push(compared.monte_carlo(0.03).because(reason));
    }
    Ok(claims)
}
